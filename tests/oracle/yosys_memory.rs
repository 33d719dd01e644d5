//! Memories of real designs, taken through Yosys at several levels, against Icarus Verilog on the source; contents from
//! files; what is wrong with either.

use crate::support;

use std::path::Path;
use std::process::{Command, Output};

use crate::support::runs::run_everywhere;
use crate::support::tool::tool;
use crate::support::{Rng, folder, repository};
use discreta::Value;
use needs::needs;
use serde_json::{Value as Json, json};

fn discreta(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_discreta")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn write(folder: &Path, name: &str, file: &Json) {
    std::fs::write(folder.join(name), serde_json::to_string_pretty(file).unwrap()).unwrap();
}

const X: &str = "32'bxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx";
const END: u64 = 20_000;
const OUTPUTS: [&str; 6] = ["now", "old", "fresh", "other", "digit", "popped"];
const INPUTS: &[(&str, u32)] = &[("we", 4), ("a", 5), ("b", 5), ("d", 32), ("en", 1), ("rst", 1)];

/// Changes of inputs at ticks at which no clock has an edge; with unknown bits in some: in what is written and where is
/// read, or also in where and which bytes.
fn stimulus(name: &str, everywhere: bool) -> Vec<(u64, &'static str, String)> {
    let mut rng = Rng::named(name);
    let mut list: Vec<(u64, &str, String)> =
        INPUTS.iter().map(|&(input, width)| (0, input, Value::from_u64(4, width).bit_string())).collect();
    for time in (3..END).step_by(6).filter(|t| t % 5 != 0 && t % 7 != 0) {
        let &(input, width) = rng.pick(INPUTS);
        // what decides between two things is another thing in Verilog than a multiplexer, which Yosys makes of it
        let unknown = matches!(input, "b" | "d") || everywhere && matches!(input, "a" | "we");
        let mut value = if unknown && rng.one_in(8) { rng.four_valued(width, 4) } else { rng.known(width) };
        match input {
            "we" => value.set_bit(0, rng.known(1).bit(0)),
            // Yosys' transparent ports read what is written even where there is no word to write
            "a" if value.is_known() => value = Value::from_u64(3 + rng.below(20), 5),
            _ => {}
        }
        list.push((time, input, value.bit_string()));
    }
    list
}

/// The waveform that Icarus gives for the source.
fn icarus(folder: &Path, name: &str, stimulus: &[(u64, &str, String)]) {
    let mut changes = String::new();
    let mut now = 0;
    for (time, input, value) in stimulus {
        changes += &format!("    #{} {input} = {}'b{value};\n", time - now, value.len());
        now = *time;
    }
    let shown = OUTPUTS.map(|o| format!("memory.{o}")).join(", ");
    let bench = format!(
        "`timescale 1ns/1ns\nmodule bench;\n  reg clk = 0, clk2 = 0; reg [3:0] we; reg [4:0] a, b; reg [31:0] d; reg en, rst;\n  \
         wire [31:0] now, old, fresh, other; wire [6:0] digit; wire [7:0] popped;\n  \
         memory memory (clk, clk2, we, a, b, d, en, rst, now, old, fresh, other, digit, popped);\n  \
         always #5 clk = ~clk;\n  always #7 clk2 = ~clk2;\n  \
         initial begin\n    $dumpfile(\"{name}.vcd\"); $dumpvars(0, {shown});\n{changes}    #{} $finish;\n  end\nendmodule\n",
        END - now
    );
    std::fs::write(folder.join("bench.v"), bench).unwrap();
    let design = repository("tests/verilog/memory.v");
    tool(folder, "iverilog", &["-g2012", "-o", "bench.vvp", "bench.v", design.to_str().unwrap()]);
    tool(folder, "vvp", &["-n", "bench.vvp"]);
    let waves = std::fs::read_to_string(folder.join(format!("{name}.vcd"))).unwrap();
    // without the scope of the bench, which Icarus opens for each net
    let waves =
        waves.replace("$scope module bench $end\n", "").replace("$upscope $end\n$upscope $end", "$upscope $end");
    std::fs::write(folder.join(format!("{name}.vcd")), waves).unwrap();
}

/// The folder with the file that the design reads.
fn place(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    std::fs::copy(repository("tests/verilog/memory.hex"), folder.join("memory.hex")).unwrap();
    folder
}

fn synthesise(folder: &Path, passes: &str, name: &str) {
    let design = repository("tests/verilog/memory.v");
    let script = format!("read_verilog {}; hierarchy -top memory; {passes}; write_json {name}.json", design.display());
    tool(folder, "yosys", &["-q", "-p", &script]);
}

/// Every output has Icarus' value at every time: with ports as cells of their own, brought together, with read ports
/// that have a clock, and as flip-flops.
#[needs(iverilog, yosys)]
#[test]
fn a_design_with_memories_at_every_level_is_what_icarus_runs() {
    let folder = place("yosys_memory_levels");
    for everywhere in [true, false] {
        icarus(&folder, &format!("icarus_{everywhere}"), &stimulus("memory", everywhere));
    }
    let mut compared = 0;
    for (name, passes, kinds, everywhere) in [
        ("proc", "proc", &["$memrd", "$memwr_v2", "$meminit_v2"][..], true),
        ("parts", "proc; opt; memory_dff", &["$memrd_v2", "$memwr_v2", "$meminit_v2"], true),
        ("collected", "proc; memory_collect", &["$mem_v2"], true),
        ("prep", "prep", &["$mem_v2"], true),
        ("flat", "prep -flatten", &["$mem_v2"], true),
        ("ports", "proc; opt; memory -nomap", &["$mem_v2"], true),
        // an unknown address or enable is another thing in a multiplexer
        ("mapped", "prep; memory_map; opt", &[], false),
        ("gates", "synth", &[], false),
    ] {
        synthesise(&folder, passes, name);
        let netlist = std::fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
        for kind in kinds {
            assert!(netlist.contains(&format!("\"{kind}\"")), "{name}: {kind}");
        }
        assert_eq!(netlist.contains("\"type\": \"$mem"), !kinds.is_empty(), "{name}");
        let stimulus = stimulus("memory", everywhere);
        let events: Vec<Json> = stimulus
            .iter()
            .map(|(at, input, value)| json!({ "at": at, "set": { *input: format!("{}'b{value}", value.len()) } }))
            .collect();
        let scenario = json!({ "circuit": format!("{name}.json"), "simulation": {
            "clocks": { "clk": { "period": "10ns" }, "clk2": { "period": "14ns" } },
            "stimulus": events, "limit": { "time": END }, "trace": OUTPUTS } });
        write(&folder, &format!("{name}.scenario.json"), &scenario);
        let ran = run_everywhere(
            &folder,
            &["run", &format!("{name}.scenario.json"), "-o", &format!("{name}.vcd"), "--x-control", "ignore"],
        );
        assert!(ran.status.success(), "{name}: {}", text(&ran.stderr));
        let (ours, theirs) = (format!("{name}.vcd"), format!("icarus_{everywhere}.vcd"));
        let mut arguments = vec!["diff", &ours, &theirs];
        // Yosys knows more where a bit is the same in all words
        if !everywhere || name == "ports" {
            arguments.extend(["--ignore-x", "b"]);
        }
        let differs = discreta(&folder, &arguments);
        assert!(differs.status.success(), "{name}:\n{}", text(&differs.stdout));
        compared += stimulus.len();
    }
    // the memories are mapped to flip-flops in two of them
    support::engines::ran(1, 0);
    println!("8 levels, {compared} changes of inputs, {END} ns each");
}

/// A file takes the place of what the netlist says, word by word, for `run` and in a scenario; the paths are those of the
/// hierarchy, flattened or not.
#[needs(iverilog, yosys)]
#[test]
fn contents_from_files() {
    let folder = place("yosys_memory_contents");
    synthesise(&folder, "prep", "tree");
    synthesise(&folder, "prep -flatten", "flat");
    synthesise(&folder, "proc", "parts");
    std::fs::write(folder.join("ram.hex"), "@4 aaaa_5555 // the second\n@16 7").unwrap();
    std::fs::write(folder.join("stack.hex"), "c3").unwrap();
    for name in ["tree", "flat", "parts"] {
        let file = format!("{name}.json");
        let mut run = vec!["run", &file, "--time", "3", "-s", "clk=0", "-s", "clk2=0", "-s", "en=0", "-s", "rst=0"];
        run.extend(["-s", "we=0", "-s", "a=0", "-s", "d=0", "--format", "json"]);
        run.extend(["--memory", "ram=memory.hex", "--memory", "ram=ram.hex", "--memory", "stack.words=stack.hex"]);
        for (b, now) in [(4, "2863289685"), (22, "7"), (3, "1"), (7, X)] {
            let ran = discreta(&folder, &[&run[..], &["-s", &format!("b={b}")]].concat());
            assert!(ran.status.success(), "{}", text(&ran.stderr));
            let result: Json = serde_json::from_slice(&ran.stdout).unwrap();
            assert_eq!(
                (&result["outputs"]["now"], &result["outputs"]["popped"]),
                (&json!(now), &json!("195")),
                "{name} {b}"
            );
        }
    }
    let scenario = json!({ "circuit": "../yosys_memory_contents/tree.json", "memories": { "ram": "ram.hex" }, "simulation": {
        "inputs": { "clk": 0, "clk2": 0, "en": 0, "rst": 0, "we": 0, "a": 0, "d": 0, "b": 4 },
        "limit": { "time": 5 }, "expect": [{ "net": "now", "value": "0xaaaa5555" }] } });
    write(&folder, "filled.scenario.json", &scenario);
    let tested = discreta(&folder, &["run", "filled.scenario.json"]);
    assert!(tested.status.success(), "{}", text(&tested.stderr));
    // what the command line says goes before it
    let other = discreta(&folder, &["run", "filled.scenario.json", "--memory", "ram=memory.hex"]);
    assert_eq!(other.status.code(), Some(1), "{}", text(&other.stderr));
}

/// Everything that is wrong is told, with file, line and column.
#[needs(iverilog, yosys)]
#[test]
fn wrong_contents_are_told() {
    let folder = place("yosys_memory_faults");
    synthesise(&folder, "prep", "m");
    std::fs::write(folder.join("bad.hex"), "1 2\n  xyz 123456789\n@2 5\n@16 1 2\n/* to the end").unwrap();
    let told = |arguments: &[&str]| {
        let ran = discreta(&folder, &[&["check", "m.json"], arguments].concat());
        assert_eq!(ran.status.code(), Some(if arguments.is_empty() { 0 } else { 1 }), "{}", text(&ran.stderr));
        text(&ran.stderr)
    };
    assert_eq!(told(&[]), "");
    let faults = told(&["--memory", "ram=bad.hex"]);
    for part in [
        "error[bad-contents]: `y` is no hex digit\n --> bad.hex:2:3",
        "it does not fit into the 32 bits of a word\n --> bad.hex:2:7",
        "the memory has no address 0x2\n --> bad.hex:3:1",
        "its addresses are 0x3 to 0x16",
        "there are more words than the memory has\n --> bad.hex:4:7",
        "this comment has no end\n --> bad.hex:5:1",
    ] {
        assert!(faults.contains(part), "{part:?} is not in\n{faults}");
    }
    let faults = told(&["--memory", "rom=memory.hex", "--memory", "stack.word=memory.hex", "--memory", "ram=no.hex"]);
    for part in ["no memory `rom`", "did you mean `ram`?", "did you mean `stack.words`?", "cannot read `no.hex`"] {
        assert!(faults.contains(part), "{part:?} is not in\n{faults}");
    }
    let line = repository("circuits/evaluation/line.json");
    let ran = discreta(&folder, &["run", line.to_str().unwrap(), "--memory", "f=memory.hex"]);
    assert_eq!(ran.status.code(), Some(2));
    assert!(text(&ran.stderr).contains("error[unknown-memory]"), "{}", text(&ran.stderr));
}
