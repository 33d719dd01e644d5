//! Verilog as the command line takes it: through Yosys, with its faults at their lines, and read once for the same text.

use std::path::Path;

use needs::needs;

use crate::support::program::run_in as discreta;
use crate::support::{folder, repository};

const SUB: &str = "module sub #(parameter W = 4) (input clk, input [W-1:0] d, output reg [W-1:0] q);
  always @(posedge clk) q <= d + `STEP;
endmodule
";
const TOP: &str = "`include \"step.vh\"
module top #(parameter W = 4) (input clk, input [W-1:0] d, output [W-1:0] q);
  sub #(.W(W)) u (.clk(clk), .d(d), .q(q));
endmodule
";

/// A new folder with files.
fn with(name: &str, files: &[(&str, &str)]) -> std::path::PathBuf {
    let folder = folder(name);
    std::fs::remove_dir_all(&folder).unwrap();
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

fn entries(folder: &Path) -> Vec<std::path::PathBuf> {
    std::fs::read_dir(folder.join("cache/discreta/yosys")).unwrap().map(|e| e.unwrap().path()).collect()
}

#[needs(yosys)]
#[test]
fn files_folders_macros_and_parameters_come_through() {
    let folder = with("verilog_run", &[("sub.v", SUB), ("top.v", TOP), ("inc/step.vh", "`define STEP `BY\n")]);
    for width in [1u32, 4, 63, 64, 65] {
        let d = (1u128 << (width - 1)) + u128::from(width > 1);
        let line =
            format!("run top.v sub.v -I inc -D BY=3 -G W={width} --clock clk=10ns -s d={width}'b{d:b} --cycles 2");
        let (status, text, told) = discreta(&folder, &line);
        let expected = (d + 3) & ((1u128 << width) - 1);
        let expected = if width > 64 { format!("{width}'b{expected:b}") } else { expected.to_string() };
        assert_eq!(status, 0, "{told}");
        assert!(text.contains(&format!("q = {expected}\n")), "{width}: {text}");
    }
    // wherever a circuit is taken
    for line in
        ["stats top.v sub.v -I inc -D BY=1", "check top.v sub.v -I inc -D BY=1", "draw top.v sub.v -I inc -D BY=1"]
    {
        let (status, _, told) = discreta(&folder, line);
        assert_eq!(status, 0, "{line}: {told}");
    }
}

#[needs(yosys)]
#[test]
fn what_was_read_is_read_again_only_if_it_changed() {
    let folder = with("verilog_cache", &[("sub.v", SUB), ("top.v", TOP), ("inc/step.vh", "`define STEP 1\n")]);
    let q = |expected: u32| {
        let (status, text, told) = discreta(&folder, "run top.v sub.v -I inc --clock clk=10ns -s d=3 --cycles 2");
        assert_eq!(status, 0, "{told}");
        assert!(text.contains(&format!("q = {expected}\n")), "{text}");
    };
    q(4);
    let first = entries(&folder);
    assert_eq!(first.len(), 1);
    let made = std::fs::metadata(&first[0]).unwrap().modified().unwrap();
    q(4);
    assert_eq!(std::fs::metadata(&first[0]).unwrap().modified().unwrap(), made, "made once");
    // an included file is no argument, but counts
    std::fs::write(folder.join("inc/step.vh"), "`define STEP 2\n").unwrap();
    q(5);
    std::fs::write(folder.join("sub.v"), SUB.replace("d +", "d -")).unwrap();
    q(1);
    // one that hides it
    std::fs::create_dir_all(folder.join("inc")).unwrap();
    std::fs::write(folder.join("step.vh"), "`define STEP 3\n").unwrap();
    let found = discreta(&folder, "run top.v sub.v -I . -I inc --clock clk=10ns -s d=3 --cycles 2").1;
    assert!(found.contains("q = 0\n"), "{found}");
    // what is damaged counts for nothing
    std::fs::write(folder.join("sub.v"), SUB).unwrap();
    std::fs::remove_file(folder.join("step.vh")).unwrap();
    for entry in entries(&folder) {
        let text = std::fs::read_to_string(&entry).unwrap();
        std::fs::write(&entry, text.split_once('\n').unwrap().1).unwrap();
    }
    q(5);
}

#[needs(yosys)]
#[test]
fn faults_are_shown_in_the_source() {
    let bad = "module t(input a,\n  output b);\n  assign b = a +;\nendmodule\n";
    let open = "module t(input clk, input d, output reg q);\n  always @(posedge clk) q <= d;\nendmodule\n";
    let missing = "module t(input a, output b);\n  nosuch u (a, b);\nendmodule\n";
    let folder = with("verilog_faults", &[("bad.v", bad), ("open.v", open), ("missing.v", missing)]);
    let cases = [
        ("check bad.v", 1, "--> bad.v:3:3"),
        ("check bad.v", 1, "syntax error"),
        ("run open.v", 2, "--> open.v:1:16"),
        ("check missing.v", 1, "--blackbox NAME"),
        ("check missing.v --top gone", 1, "`gone' not found"),
        ("run none.v", 2, "there is no such file"),
        ("run open.v -D A=1;2", 2, "Yosys cannot be given"),
        ("run open.v ../x.json", 2, "no such file"),
    ];
    for (line, expected, part) in cases {
        let (status, _, told) = discreta(&folder, line);
        assert_eq!(status, expected, "{line}: {told}");
        assert!(told.contains(part), "{line} does not say {part}: {told}");
    }
}

#[needs(yosys)]
#[test]
fn what_a_black_box_drives_is_x() {
    let design = "module ram(input [7:0] a, output [7:0] q);\n  assign q = a;\nendmodule
module t(input [7:0] a, input s, output [7:0] y);\n  wire [7:0] q;\n  ram u (.a(a), .q(q));\n  assign y = s ? a : q;\nendmodule\n";
    let folder = with("verilog_box", &[("t.v", design)]);
    let y = |line: &str| discreta(&folder, line).1;
    assert!(y("run t.v --time 4ns -s a=5 -s s=0").contains("y = 5\n"));
    assert!(y("run t.v --time 4ns -s a=5 -s s=0 --blackbox ram").contains("y = 8'bxxxxxxxx\n"));
    assert!(y("run t.v --time 4ns -s a=5 -s s=1 --blackbox ram").contains("y = 5\n"));
}

/// What an assertion is made of is told as it was sampled: n counts from 0 at the edge of 15 ns, so that it is 5 at that of 65 ns.
#[needs(yosys)]
#[test]
fn an_assertion_tells_its_values() {
    let design = "module t(input clk, input rst, output reg [7:0] n);
  reg [3:0] state;
  always @(posedge clk) if (rst) begin n <= 0; state <= 0; end else begin n <= n + 1; state <= state + 3; end
  always @(posedge clk) if (!rst) limit: assert (n + state < 20);
endmodule
";
    let scenario = r#"{ "circuit": "t.sv", "simulation": { "clocks": { "clk": { "period": 10 } }, "inputs": { "rst": 1 },
        "stimulus": [{ "at": 12, "set": { "rst": 0 } }], "limit": { "cycles": 8 } } }"#;
    let folder = with("verilog_assert", &[("t.sv", design), ("s.json", scenario)]);
    let (status, text, _) = discreta(&folder, "test s.json --format github");
    assert_eq!(status, 1);
    // 5 + 15 is the first sum of 20, at the sixth edge after the reset
    let line = text.lines().find(|l| l.starts_with("::error ")).unwrap();
    assert!(
        line.starts_with("::error file=t.sv,line=4,col=35,title=s.json::assertion `limit` fails at 65 ns"),
        "{line}"
    );
    assert!(line.contains("n = 8'd5") && line.contains("state = 4'd15"), "{line}");
    let (_, text, _) = discreta(&folder, "run s.json --format json");
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let first = &json["assertions"][0];
    assert_eq!(
        (&first["time"], &first["values"]["n"], &first["values"]["state"]),
        (&65.into(), &"8'd5".into(), &"4'd15".into())
    );
    assert_eq!(first["source"].as_str().unwrap().split('.').next(), Some("t"));
}

/// Words that were written are dumped as `$readmemh` reads them, and Icarus reads them back.
#[needs(iverilog, yosys)]
#[test]
fn a_memory_is_dumped_and_read_back() {
    for width in [1, 8, 63, 65] {
        let design = format!(
            "module mem(input clk, input [2:0] a, input [{0}:0] d, input we, output [{0}:0] q);
  reg [{0}:0] ram [0:7];
  always @(posedge clk) if (we) ram[a] <= d;
  assign q = ram[a];
endmodule
",
            width - 1
        );
        let bench = format!(
            "module tb; reg [{}:0] m [0:7]; initial begin $readmemh(\"out.hex\", m); $display(\"%b %b\", m[2], m[3]); end endmodule",
            width - 1
        );
        let folder = with(&format!("verilog_dump_{width}"), &[("mem.v", &design), ("tb.v", &bench)]);
        let d = format!("1{}", "01".repeat(40))[..width].to_owned();
        let line = format!("run mem.v --clock clk=10 -s a=2 -s d={width}'b{d} -s we=1 --cycles 2 --dump ram=out.hex");
        let (status, _, told) = discreta(&folder, &line);
        assert_eq!(status, 0, "{told}");
        crate::support::tool::tool(&folder, "iverilog", &["-o", "tb", "tb.v"]);
        let theirs = crate::support::tool::tool(&folder, "vvp", &["-n", "tb"]);
        assert!(theirs.contains(&format!("{d} {}", "x".repeat(width))), "{width}: {theirs}");
        let (_, text, _) = discreta(
            &folder,
            "run mem.v --clock clk=10 -s a=2 -s we=0 -s d=0 --cycles 2 --memory ram=out.hex --format json",
        );
        let q = serde_json::from_str::<serde_json::Value>(&text).unwrap()["outputs"]["q"].as_str().unwrap().to_owned();
        let as_number = u64::from_str_radix(&d, 2).map_or_else(|_| format!("{width}'b{d}"), |n| n.to_string());
        assert_eq!(q, as_number);
    }
    let folder = folder("verilog_dump_8");
    let (status, _, told) = discreta(&folder, "run mem.v --clock clk=10 --cycles 2 --dump rom=out.hex");
    assert!(status == 2 && told.contains("it has ram"), "{told}");
}

/// A golden trace in which outputs are x is no good one.
#[needs(yosys)]
#[test]
fn blessing_warns_of_x() {
    let design = "module t(input clk, input d, output reg q, output reg never);\n  always @(posedge clk) q <= d;\n  always @(posedge clk) never <= never ^ d;\nendmodule\n";
    let scenario = r#"{ "circuit": "t.v", "simulation": { "clocks": { "clk": { "period": 10 } }, "inputs": { "d": 1 }, "limit": { "cycles": 3 } } }"#;
    let folder = with("verilog_bless", &[("t.v", design), ("s.json", scenario)]);
    let (status, text, _) = discreta(&folder, "test s.json --bless");
    assert_eq!(status, 0);
    assert!(text.contains("warning: the golden trace ends with x on outputs: never\n"), "{text}");
}

/// A netlist of cells counts the clocks that its gate lets through.
#[needs(yosys)]
#[test]
fn a_library_of_cells_gives_its_netlist_a_meaning() {
    let cells = repository("tests/verilog/cells");
    let scenario = r#"{ "circuit": "counter.v", "verilog": { "sources": ["small.lib"] }, "simulation": {
        "clocks": { "clk": { "period": 10 } }, "inputs": { "rst_n": 0, "en": 1 },
        "stimulus": [{ "at": 8, "set": { "rst_n": 1 } }, { "at": 48, "set": { "en": 0 } }, { "at": 68, "set": { "en": 1 } }],
        "limit": { "time": 109 },
        "expect": [{ "net": "q", "value": 0, "at": 14 }, { "net": "q", "value": 0, "at": 47 }, { "net": "q", "value": 0, "at": 67 },
                   { "net": "q", "value": 3, "at": 99 }] } }"#;
    let read = |name: &str| std::fs::read_to_string(cells.join(name)).unwrap();
    let folder = with(
        "verilog_cells",
        &[("counter.v", &read("counter.v")), ("small.lib", &read("small.lib")), ("s.json", scenario)],
    );
    let (status, text, told) = discreta(&folder, "test s.json");
    assert_eq!(status, 0, "{text}{told}");
    let (status, _, told) = discreta(&folder, "run small.lib");
    assert_eq!(status, 2);
    assert!(told.contains("a library of cells, and no circuit"), "{told}");
}
