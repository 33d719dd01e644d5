//! `discreta why` finds faults whose lines are known, for they were planted; and the origins of x, of which there is one each.

use needs::needs;

use crate::support::program::run_in as discreta;
use crate::support::tool::tool;
use crate::support::{folder, repository};

/// The commands of the README and of docs/why.md say what is printed there.
#[needs(yosys)]
#[test]
fn from_a_wrong_value_to_its_line_in_three_commands() {
    let page = std::fs::read_to_string(repository("docs/why.md")).unwrap();
    let readme = std::fs::read_to_string(repository("README.md")).unwrap();
    let folder = folder("why_three");
    for name in ["examples", "target"] {
        let link = folder.join(name);
        let _ = std::fs::remove_file(&link);
        let _ = std::fs::remove_dir_all(&link);
        match name {
            "target" => std::fs::create_dir_all(link).unwrap(),
            _ => std::os::unix::fs::symlink(repository(name), link).unwrap(),
        }
    }
    let example = page.split_once("```console\n").unwrap().1.split_once("```").unwrap().0;
    let mut commands = 0;
    for part in example.split("$ discreta ").skip(1) {
        let (line, expected) = part.split_once('\n').unwrap();
        let (status, text, told) = discreta(&folder, line);
        assert_eq!(status, i32::from(commands > 0), "{line}: {told}");
        assert!(text.contains(expected.trim()), "{line}: {text}");
        let in_readme = line.replace(" gearbox.vcd", " target/gearbox.vcd");
        assert!(readme.contains(&in_readme), "the README has not {in_readme}");
        if line.starts_with("why") {
            assert!(readme.contains(expected.trim()), "the README says something else than\n{expected}");
        }
        commands += 1;
    }
    assert_eq!(commands, 3);
}

/// Faults in different kinds of lines: each is planted in a line of the design, which `why` has to name, and it may name only few others.
#[needs(iverilog, yosys)]
#[test]
fn planted_faults_are_found_at_their_lines() {
    let design = std::fs::read_to_string(repository("examples/verilog/gearbox.v")).unwrap();
    let folder = folder("why_planted");
    let golden = repository("examples/verilog/golden.vcd");
    std::fs::copy(golden, folder.join("golden.vcd")).unwrap();
    let faults = [
        ("tick & run", "tick | run"),
        ("{tens, ones}", "{ones, tens}"),
        ("shown == 8'h99", "shown == 8'h12"),
        ("n == 3'd4", "n == 3'd5"),
        ("if (tick) n <= 0", "if (tick) n <= 1"),
        ("else n <= n + 1", "else n <= n + 2"),
        ("carry = ones == 4'd9", "carry = ones != 4'd9"),
        ("carry ? 4'd0 : ones + 4'd1", "carry ? 4'd0 : ones + 4'd3"),
        ("? 4'd0 : tens + 4'd1", "? 4'd0 : tens + 4'd2"),
        ("ones <= 0", "ones <= 1"),
    ];
    for (right, wrong) in faults {
        assert_eq!(design.matches(right).count(), 1, "{right}");
        let planted = design.replace(right, wrong);
        let mut line = planted.lines().position(|line| line.contains(wrong)).unwrap() + 1;
        if wrong == "ones <= 1" {
            // a constant has no place in a netlist, but the choice of it has
            line =
                planted.lines().collect::<Vec<_>>()[..line].iter().rposition(|l| l.contains("if (rst)")).unwrap() + 1;
        }
        std::fs::write(folder.join("t.v"), &planted).unwrap();
        let target = if wrong.contains("8'h12") { "full" } else { "shown" };
        let (status, text, told) = discreta(&folder, &format!("why t.v {target} --expect golden.vcd"));
        assert_eq!(status, 1, "{wrong}: {text}{told}");
        if wrong.contains("{ones, tens}") {
            // wires have no place in a netlist but that of their declaration
            assert!(text.contains("`shown` (t.v:2) is the first net that differs: it is wired to"), "{text}");
            continue;
        }
        let made = text.split_once("It is made here:").unwrap().1;
        let named: Vec<&str> = made.lines().filter(|l| l.contains("t.v:")).collect();
        assert!(named.iter().any(|l| l.contains(&format!("t.v:{line}:"))), "{wrong} in line {line}: {text}");
        assert!(named.len() <= 6, "{wrong}: {text}");
    }
    // and nothing is found where nothing is wrong, which Icarus says too
    std::fs::write(folder.join("t.v"), &design).unwrap();
    std::fs::copy(repository("examples/verilog/gearbox_tb.v"), folder.join("tb.v")).unwrap();
    tool(&folder, "iverilog", &["-o", "tb", "tb.v", "t.v"]);
    tool(&folder, "vvp", &["-n", "tb"]);
    let (status, text, told) = discreta(&folder, "why t.v shown --expect golden.vcd");
    assert_eq!((status, text.as_str()), (0, "shown does not differ at any time\n"), "{told}");
}

const ROOTS: &str = "module roots(input clk, input rst, input [3:0] a, input [3:0] b, input we, input idle,
    output reg [3:0] q, output [3:0] quotient, output floating, output [3:0] word, output reg [3:0] sum, output [3:0] late,
    output reg [64:0] wide, output unset);
  wire open;
  reg [3:0] never;
  reg [3:0] ram [0:15];
  reg [3:0] d1, d2;
  always @(posedge clk) if (rst) q <= 0; else q <= q + never;
  always @(posedge clk) if (we) never <= a;
  assign quotient = a / b;
  assign floating = open & a[0];
  assign word = ram[b];
  always @(posedge clk) if (we) ram[a] <= b;
  always @(posedge clk) sum <= sum + a;
  always @(posedge clk) begin d1 <= quotient; d2 <= d1; end
  assign late = d2;
  always @(posedge clk) if (rst) wide <= 0; else wide <= {wide[63:0], late[3]};
  assign unset = idle ^ a[1];
endmodule
";

#[needs(yosys)]
#[test]
fn every_x_has_its_origin() {
    let folder = folder("why_roots");
    std::fs::write(folder.join("roots.v"), ROOTS).unwrap();
    let options = "--clock clk=10 --reset rst=12 -s a=3 -s b=0 -s we=0 --cycles 6";
    for (net, origin) in [
        ("q", "it comes from the register `never` (roots.v:9), which nothing has set"),
        ("quotient", "it comes from a division by zero (roots.v:10)"),
        ("floating", "it comes from `open`, which nothing drives"),
        ("word", "it comes from a word of a memory (roots.v:6) that nothing has written"),
        ("sum", "it comes from the register `sum` (roots.v:14), which nothing has set"),
        ("late", "it comes from a division by zero (roots.v:10)"),
        ("wide", "it comes from a division by zero (roots.v:10)"),
        ("wide[2]", "it comes from a division by zero (roots.v:10)"),
        ("unset", "it comes from the input `idle`: set it"),
    ] {
        let (status, text, told) = discreta(&folder, &format!("why roots.v {net} {options}"));
        assert_eq!(status, 0, "{net}: {told}");
        assert!(text.trim_end().lines().last().unwrap().starts_with(origin), "{net}: {text}");
    }
    // a word that was written, by an address of long ago: 3 at the edge of 5 ns
    let (_, text, _) = discreta(&folder, "why roots.v word --clock clk=10 -s rst=0 -s a=3 -s b=3 -s we=1 --time 60");
    assert!(
        text.contains("word 3 was written at 55 ns")
            && text.contains("wr_data = 3")
            && text.contains("it comes from the input `b`"),
        "{text}"
    );
    let (_, text, _) =
        discreta(&folder, "why roots.v never --clock clk=10 -s rst=0 -s a=9 -s we=1 --at 44 --format json");
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["value"], "4'd9");
    assert_eq!(json["steps"][0]["source"], "roots.v:9");
    assert!(json["because"].as_str().unwrap().contains("input `a`"), "{text}");
}

#[needs(yosys)]
#[test]
fn what_is_not_there_is_said() {
    let folder = folder("why_bad");
    std::fs::write(folder.join("roots.v"), ROOTS).unwrap();
    let options = "--clock clk=10 -s rst=0 --time 40";
    for (line, part) in [
        ("roots.v quotien", "did you mean `quotient`?"),
        ("roots.v q[4]", "`q` has no bits [4]"),
        ("roots.v q --at 41", "the run ends at 40 ns"),
        ("roots.v q --at 4x", "is not a unit of time"),
        ("roots.v q --reset rst=5x", "is not a unit of time"),
        ("roots.v", "2 values required"),
    ] {
        let (status, _, told) = discreta(&folder, &format!("why {line} {options}"));
        assert_eq!(status, 2, "{line}: {told}");
        assert!(told.contains(part), "{line}: {told}");
    }
}
