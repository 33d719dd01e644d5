//! `run --stimulus`: what other simulators recorded, replayed and compared.

use std::path::{Path, PathBuf};

use crate::support::replays::{icarus, netlist, refused, report, run};
use crate::support::tool::tool;
use crate::support::{folder, repository};
use needs::needs;
use serde_json::{Value as Json, json};

/// `replay.v` as netlist and waveform.
fn replay(name: &str) -> PathBuf {
    let folder = folder(name);
    let design = repository("tests/verilog/replay.v");
    icarus(&folder, &repository("tests/verilog/replay_tb.v"), &design);
    netlist(&folder, &design, "prep -top replay", "replay");
    folder
}

/// Two clocks that meet, resets, a bus, a gated clock, a strobe, x and z: no difference at any level, from VCD or FST,
/// with the scope given or found.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn icarus_is_replayed() {
    let folder = replay("stimulus_icarus");
    let design = repository("tests/verilog/replay.v");
    netlist(&folder, &design, "prep -flatten -top replay", "flat");
    let gates = "hierarchy -top replay; proc; tribuf; synth -top replay";
    netlist(&folder, &design, gates, "gates");
    // gates may know more where words are x
    for (name, dont_care) in [("replay", ""), ("flat", ""), ("gates", "--ignore-x a")] {
        for wave in ["icarus.vcd", "icarus.fst", "icarus.vcd --scope bench.dut", "icarus.fst --scope bench"] {
            let (status, ran) = report(&folder, &format!("run {name}.json --stimulus {wave} --expect {dont_care}"));
            assert_eq!((status, &ran["ok"]), (0, &json!(true)), "{name} {wave}: {ran:#}");
            let inner = !wave.ends_with("bench");
            assert_eq!(ran["stimulus"]["scope"], if inner { "bench.dut" } else { "bench" });
            let driven = json!(["clk_a", "clk_b", "rst_n", "en", "strobe", "d", "oe", "bus"]);
            assert_eq!(ran["stimulus"]["inputs"], driven);
            // six outputs, and of the two wires those that the passes keep
            let compared = ran["difference"]["compared"].as_u64().unwrap();
            assert!(if inner { (6..=8).contains(&compared) } else { compared == 6 }, "{name} {wave}: {compared}");
            let values = ran["difference"]["values"].as_u64().unwrap();
            println!("{name} {wave}: {compared} nets, {values} values");
            assert!(values > 300, "{name} {wave}: {values}");
            assert_eq!((&ran["time"], &ran["timescale"]), (&json!(10400), &json!("100ps")));
        }
    }
}

const NAMES_BENCH: &str = r#"
`timescale 1ns/1ns
module top_level;
  reg clk = 0, rst_n; reg [7:0] data = 8'h93; reg [1:0] sel = 0;
  wire [7:0] out, held; wire [3:0] bus;
  names \the.one (clk, rst_n, data, sel, out, held, bus);
  always #5 clk = ~clk;
  reg [3:0] n = 0;
  always @(negedge clk) begin n <= n + 1; data <= {data[6:0], data[7] ^ data[3]}; if (&n) sel <= sel + 1; end
  always @(posedge clk) if (n == 9) data <= 8'hx7;
  initial begin
    $dumpfile("icarus.vcd"); $dumpvars(0, top_level); rst_n = 0;
    #12 rst_n = 1; #400 rst_n = 0; #14 rst_n = 1; #600 $finish;
  end
endmodule
"#;

/// Names with dots, `=` and backslashes, and a hierarchy that is flattened or not.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn names_are_those_of_the_source() {
    let folder = folder("stimulus_names");
    let design = repository("tests/verilog/names.v");
    std::fs::write(folder.join("bench.v"), NAMES_BENCH).unwrap();
    icarus(&folder, &folder.join("bench.v"), &design);
    netlist(&folder, &design, "prep -top names", "names");
    netlist(&folder, &design, "prep -flatten -top names", "flat");
    for name in ["names", "flat"] {
        for wave in ["icarus.vcd", "icarus.fst --scope top_level.\\the.one"] {
            let (status, ran) = report(&folder, &format!("run {name}.json --stimulus {wave} --expect"));
            assert_eq!(status, 0, "{name} {wave}: {ran:#}");
            assert_eq!(ran["stimulus"]["scope"], "top_level.the.one");
            let compared = ran["difference"]["compared"].as_u64().unwrap();
            assert!(compared >= 20, "{name} {wave}: {compared} compared");
        }
    }
    let line = "run names.json --stimulus icarus.vcd --expect --ignore **.r.0 --ignore slow.one.**";
    let (status, fewer) = report(&folder, line);
    let (_, all) = report(&folder, "run names.json --stimulus icarus.vcd --expect");
    let compared = |ran: &Json| ran["difference"]["compared"].as_u64().unwrap();
    // r.0, and clk, rst_n, en, q of the one
    assert_eq!((status, compared(&all) - compared(&fewer)), (0, 5));
}

/// `icarus.vcd` with one value of `a`, at 555 ns, that is another.
fn with_another_value(folder: &Path) -> String {
    let waves = std::fs::read_to_string(folder.join("icarus.vcd")).unwrap();
    let dut = waves.split_once("module dut").unwrap().1;
    let of_a = dut.lines().find(|l| l.contains(" a [7:0]")).unwrap().split(' ').nth(3).unwrap();
    let at = waves.find("#5500\n").unwrap();
    let line = waves[at..].lines().find(|l| l.starts_with('b') && l.ends_with(&format!(" {of_a}"))).unwrap();
    let other = line.split_once(' ').map(|(bits, id)| format!("b{}1 {id}", &bits[2..].replace('1', "0"))).unwrap();
    format!("{}{}", &waves[..at], waves[at..].replacen(line, &other, 1))
}

/// What is wrong in the design or in the trace is found, and nothing else.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn a_difference_is_found() {
    let folder = replay("stimulus_difference");
    let design = std::fs::read_to_string(repository("tests/verilog/replay.v")).unwrap();
    let wrong = design.replace("strobes + d[3:0]", "strobes + d[4:1]");
    assert_ne!(wrong, design);
    std::fs::write(folder.join("wrong.v"), wrong).unwrap();
    netlist(&folder, &folder.join("wrong.v"), "prep -top replay", "wrong");
    let (status, ran) = report(&folder, "run wrong.json --stimulus icarus.vcd --expect");
    let names = |ran: &Json| -> Vec<String> {
        ran["difference"]["signals"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap().into()).collect()
    };
    assert_eq!((status, names(&ran)), (1, vec!["bench.dut.strobes".to_owned()]));
    let (status, out, _) = run(&folder, "run wrong.json --stimulus icarus.vcd --expect");
    assert_eq!(status, 1);
    for text in ["not the same as bench.dut in icarus.vcd", "a  expected (icarus.vcd)", "1 of 8 signals differ:"] {
        assert!(out.contains(text), "no `{text}` in\n{out}");
    }
    assert_eq!(run(&folder, "run wrong.json --stimulus icarus.vcd --expect --ignore strobes").0, 0);

    std::fs::write(folder.join("other.vcd"), with_another_value(&folder)).unwrap();
    let (status, ran) = report(&folder, "run replay.json --stimulus other.vcd --expect");
    assert_eq!((status, names(&ran)), (1, vec!["bench.dut.a".to_owned()]), "{ran:#}");
    assert_eq!(ran["difference"]["first"], 5550);
    // before it all is well
    assert_eq!(run(&folder, "run replay.json --stimulus other.vcd --expect --time 554ns").0, 0);
}

/// Every golden trace of this repository, with nothing but its circuit.
#[test]
fn golden_traces_are_replayed() {
    let mut open = vec![repository("traces")];
    let (mut traces, mut nets, mut values) = (0, 0, 0);
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(std::fs::read_dir(&path).unwrap().map(|e| e.unwrap().path()));
        }
        let wave = path.with_extension("vcd");
        if path.extension().is_none_or(|e| e != "json") || !wave.exists() {
            continue;
        }
        let line = format!("run {} --stimulus {} --expect --x-control ignore", path.display(), wave.display());
        let (status, ran) = report(&repository("."), &line);
        assert_eq!(status, 0, "{}: {:#}", path.display(), ran["difference"]);
        traces += 1;
        nets += ran["difference"]["compared"].as_u64().unwrap();
        values += ran["difference"]["values"].as_u64().unwrap();
    }
    println!("{traces} traces, {nets} nets, {values} values");
    assert!(traces >= 113 && nets > 113 && values > nets, "{traces} traces, {nets} nets, {values} values");
}

/// A waveform of the run is the same whether it is compared or not, and a run that is told nothing else ends where the
/// waveform does.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn the_end_and_the_output() {
    let folder = replay("stimulus_end");
    let ran = |line: &str| run(&folder, &format!("run replay.json --stimulus icarus.vcd {line}"));
    assert_eq!(ran("-o plain.vcd").0, 0);
    assert_eq!(ran("--expect -o compared.vcd --trace a --trace bus").0, 0);
    assert_eq!(ran("-o chosen.vcd --trace a --trace bus").0, 0);
    assert_eq!(ran("--expect -o both.vcd").0, 0);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert_eq!(read("plain.vcd"), read("both.vcd"));
    assert_eq!(read("chosen.vcd"), read("compared.vcd"));
    assert!(read("plain.vcd").contains("$timescale 100 ps $end") && read("plain.vcd").contains("\n#10400\n"));
    let (status, out, _) = run(&folder, "diff plain.vcd both.vcd");
    assert_eq!(status, 0, "{out}");

    let time = |line: &str| report(&folder, &format!("run replay.json --stimulus icarus.vcd {line}")).1["time"].clone();
    assert_eq!(time("--time 100ns"), 1000);
    // clk_a rises at 5 ns and falls at 10 ns
    assert_eq!(time("--cycles 5"), 500);
    assert_eq!(time("--cycles 0"), 49);
    assert_eq!(time("--until rst_n"), 150);
    for (line, text) in [
        ("--time 5us", "the waveform ends at 1040000 ps, before 5000000 ps"),
        ("--cycles 105", "the waveform ends before 105 cycles of `clk_a`, after 104 whole cycles of it"),
        ("-o icarus.vcd", "cannot write `icarus.vcd`: it is an input of this command"),
    ] {
        refused(&folder, &format!("run replay.json --stimulus icarus.vcd {line}"), &[text]);
    }
    let (status, out, _) = ran("--until gated=15 --time 50ns");
    assert!(status == 1 && out.contains("limit reached before gated = 15"), "{out}");
    for line in ["--expect", "--scope bench", "--stimulus icarus.vcd --ignore a", "--first d"] {
        refused(&folder, &format!("run replay.json {line}"), &["required"]);
    }
}

/// A register of eight bits, and a waveform of it with these declarations and changes.
fn register(folder: &Path, name: &str, vars: &str, changes: &str) {
    let circuit = json!({ "modules": { "r": {
        "ports": { "clk": { "direction": "input" }, "d": { "direction": "input", "width": 8 },
                   "q": { "direction": "output", "width": 8 } },
        "cells": { "r1": { "type": "register", "parameters": { "width": 8 },
                           "connections": { "clk": "clk", "d": "d", "q": "q" } } } } } });
    std::fs::write(folder.join("r.json"), circuit.to_string()).unwrap();
    let text = format!(
        "$timescale 1 ns $end $scope module r $end {vars} $upscope $end $enddefinitions $end\n{}",
        changes.replace("; ", "\n")
    );
    std::fs::write(folder.join(name), text).unwrap();
}

/// However a tool writes a vector, it is one.
#[test]
fn vectors_in_any_form() {
    let folder = folder("stimulus_vectors");
    let bits = |order: &[usize], name: &dyn Fn(usize) -> String| -> String {
        order.iter().map(|i| format!("$var wire 1 d{i} {} $end ", name(*i))).collect()
    };
    let by_bits = "#0; 0c; 1d0; 0d1; 0d2; 1d3; xd4; zd5; 0d6; 1d7; #5; 1c; #6; 0d0; #10; 0c; #15; 1c; #20; ";
    let whole = "#0; 0c; b10zx1001 v; #5; 1c; #6; b10zx1000 v; #10; 0c; #15; 1c; #20; ";
    let clk = "$var wire 1 c clk $end ";
    let parts = "$var wire 4 h d [7:4] $end $var wire 4 l d [3:0] $end";
    let forms = [
        ("spaced", format!("{clk}$var wire 8 v d [7:0] $end"), whole),
        ("attached", format!("{clk}$var wire 8 v d[7:0] $end"), whole),
        ("shifted", format!("{clk}$var wire 8 v d [11:4] $end"), whole),
        ("upwards", format!("{clk}$var wire 8 v d [0:7] $end"), whole),
        ("bare", format!("{clk}$var reg 8 v d $end"), whole),
        ("bits", clk.to_owned() + &bits(&[7, 6, 5, 4, 3, 2, 1, 0], &|i| format!("d[{i}]")), by_bits),
        ("spaced_bits", clk.to_owned() + &bits(&[3, 0, 7, 1, 2, 4, 6, 5], &|i| format!("d [{i}]")), by_bits),
        ("shifted_bits", clk.to_owned() + &bits(&[0, 1, 2, 3, 4, 5, 6, 7], &|i| format!("d [{}]", i + 4)), by_bits),
        ("parts", format!("{clk}{parts}"), "#0; 0c; b1001 l; b10zx h; #5; 1c; #6; b1000 l; #10; 0c; #15; 1c; #20; "),
    ];
    for (name, vars, changes) in forms {
        register(&folder, "w.vcd", &vars, changes);
        let line = "run r.json --stimulus w.vcd -o out.vcd --trace q";
        let (status, ran) = report(&folder, line);
        assert_eq!((status, &ran["outputs"]["q"]), (0, &json!("8'b10zx1000")), "{name}");
        let out = std::fs::read_to_string(folder.join("out.vcd")).unwrap();
        assert!(out.ends_with("#5\nb10zx1001 !\n#15\nb10zx1000 !\n#20\n"), "{name}: {out}");
    }
    let faults = [
        ("$var wire 7 v d [6:0] $end", "`d` has 7 bits in the waveform, 8 bits in the circuit"),
        ("$var wire 1 v d $end", "`d` has 1 bit in the waveform, 8 bits in the circuit"),
        ("$var real 64 v d $end", "`d` is a real number in the waveform, 8 bits in the circuit"),
        ("$var wire 4 v d [7:4] $end $var wire 3 u d [2:0] $end", "is recorded in parts of 7 bits in all"),
    ];
    for (vars, text) in faults {
        register(&folder, "w.vcd", &format!("{clk}{vars}"), "#0; 0c; #5; ");
        refused(&folder, "run r.json --stimulus w.vcd", &["error[width-mismatch]", text]);
    }
}

/// Times of other units fall on ticks, or are refused.
#[test]
fn timescales() {
    let folder = folder("stimulus_timescale");
    let vars = "$var wire 1 c clk $end $var wire 8 v d [7:0] $end $var wire 8 q q [7:0] $end";
    let changes = "#0; 0c; b1 v; bx q; #50; 1c; b1 q; b10 v; #100; 0c; #150; 1c; b10 q; #200; ";
    register(&folder, "w.vcd", vars, changes);
    let wave = std::fs::read_to_string(folder.join("w.vcd")).unwrap();
    for (timescale, end) in [("1 ns", 200), ("10 ns", 2000), ("1 us", 200_000), ("100 ps", 20)] {
        std::fs::write(folder.join("w.vcd"), wave.replace("1 ns", timescale)).unwrap();
        let (status, ran) = report(&folder, "run r.json --stimulus w.vcd --expect");
        assert_eq!((status, &ran["time"], &ran["timescale"]), (0, &json!(end), &json!("1ns")), "{timescale}: {ran:#}");
        assert_eq!((&ran["difference"]["compared"], &ran["difference"]["values"]), (&json!(1), &json!(3)));
    }
    std::fs::write(folder.join("w.vcd"), wave.replace("1 ns", "10 ps")).unwrap();
    let line = "run r.json --stimulus w.vcd";
    refused(
        &folder,
        line,
        &["error[bad-time]", "`clk` changes at 500 ps, which is not a whole number of ticks of 1ns"],
    );
    // 2^64 seconds are more than there is
    std::fs::write(folder.join("w.vcd"), wave.replace("1 ns", "1 s").replace("#200", "#20000000000")).unwrap();
    refused(&folder, line, &["is more than 2^64-1 ticks of 1ns"]);
    // a file that does not say counts the circuit's ticks
    std::fs::write(folder.join("w.vcd"), wave.replace("$timescale 1 ns $end", "")).unwrap();
    assert_eq!(report(&folder, line).1["time"], 200);
}

/// A waveform that begins late: before it inputs are x, and nothing is compared.
#[test]
fn a_late_beginning() {
    let folder = folder("stimulus_late");
    let vars = "$var wire 1 c clk $end $var wire 8 v d [7:0] $end $var wire 8 q q [7:0] $end";
    register(&folder, "w.vcd", vars, "#1000; 1c; b1 v; bx q; #1005; 0c; #1010; 1c; b1 q; #1020; ");
    let (status, ran) = report(&folder, "run r.json --stimulus w.vcd --expect");
    assert_eq!((status, &ran["time"], &ran["difference"]["values"]), (0, &json!(1020), &json!(2)), "{ran:#}");
}

/// What other simulators do not know is x, and agrees only if asked for.
#[test]
fn unknown_values() {
    let folder = folder("stimulus_unknown");
    let vars = "$var wire 1 c clk $end $var wire 8 v d [7:0] $end $var wire 8 q q [7:0] $end";
    let run_of = |changes: &str, line: &str| {
        register(&folder, "w.vcd", vars, changes);
        run(&folder, &format!("run r.json --stimulus w.vcd --expect {line}")).0
    };
    let two_valued = "#0; 0c; b1 v; b0 q; #5; 1c; b1 q; #10; ";
    assert_eq!(
        [run_of(two_valued, ""), run_of(two_valued, "--ignore-x a"), run_of(two_valued, "--ignore-x b")],
        [1, 1, 0]
    );
    let pessimistic = "#0; 0c; b1 v; bx q; #5; 1c; b0000000x q; #10; ";
    assert_eq!(
        [run_of(pessimistic, ""), run_of(pessimistic, "--ignore-x a"), run_of(pessimistic, "--ignore-x b")],
        [1, 0, 1]
    );
}

/// What cannot be meant is told with its place and a way out.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn kind_errors() {
    let folder = replay("stimulus_errors");
    let of = |wave: &str| format!("run replay.json --stimulus {wave}");
    refused(&folder, &of("icarus.vcd --scope bench.dat"), &["has no scope `bench.dat`", "`bench.dut`", "did you mean"]);
    refused(&folder, &of("missing.vcd"), &["missing.vcd", "check the spelling of the path"]);
    refused(&folder, &of("replay.json"), &["it is not a waveform", "VCD, FST and GHW"]);
    let waves = std::fs::read_to_string(folder.join("icarus.vcd")).unwrap();
    // a waveform that breaks off in its values is read; one that does in its names has no inputs
    std::fs::write(folder.join("cut.vcd"), &waves[..waves.find("$var").unwrap()]).unwrap();
    refused(&folder, &of("cut.vcd"), &["error"]);
    let fst = std::fs::read(folder.join("icarus.fst")).unwrap();
    std::fs::write(folder.join("cut.fst"), &fst[..fst.len() / 2]).unwrap();
    refused(&folder, &of("cut.fst"), &["error"]);

    // `en` and `d` are not in the file
    let without = waves.replace(" en $end", " en_ $end").replace(" d [7:0] $end", " d_ [7:0] $end");
    std::fs::write(folder.join("without.vcd"), without).unwrap();
    refused(&folder, &of("without.vcd"), &["has the inputs", "lacks `en`, `d`", "-s NET=VALUE"]);
    refused(
        &folder,
        &of("without.vcd --scope bench.dut -s d=1"),
        &["`bench.dut` of `without.vcd` lacks the input `en`"],
    );
    let (status, ran) = report(&folder, &of("without.vcd -s d=1 --clock en=40ns --expect"));
    assert_eq!((status, &ran["stimulus"]["scope"]), (1, &json!("bench.dut")));
    assert_eq!(ran["clocks"], json!({ "en": 26 }));

    // two of the same in one file
    let (head, rest) = waves.split_once("$scope module dut $end").unwrap();
    let (dut, tail) = rest.split_once("$upscope $end").unwrap();
    let twin =
        dut.replace(" en $end", " seen_ $end").replace(" seen $end", " en $end").replace(" seen_ $end", " seen $end");
    let two =
        format!("{head}$scope module dut $end{dut}$upscope $end\n$scope module twin $end{twin}$upscope $end{tail}");
    std::fs::write(folder.join("two.vcd"), two).unwrap();
    refused(
        &folder,
        &of("two.vcd"),
        &["several scopes of `two.vcd`", "`bench.dut`, `bench.twin`", "--scope bench.twin"],
    );
    assert_eq!(run(&folder, &of("two.vcd --scope bench.dut --expect")).0, 0);

    // a file with the inputs alone has nothing to compare
    let vars = "$var wire 1 c clk $end $var wire 8 v d [7:0] $end";
    register(&folder, "inputs.vcd", vars, "#0; 0c; b1 v; #5; 1c; #10; ");
    assert_eq!(run(&folder, "run r.json --stimulus inputs.vcd").0, 0);
    refused(&folder, "run r.json --stimulus inputs.vcd --expect", &["there is nothing to compare", "outputs"]);
    refused(&folder, "run r.json --stimulus inputs.vcd --first q", &["drives no input `q`"]);
}

/// A scenario names the waveform, and `test` compares.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn scenarios() {
    let folder = replay("stimulus_scenario");
    let _ = std::fs::remove_dir_all(folder.join("s"));
    std::fs::create_dir_all(folder.join("s")).unwrap();
    let write = |name: &str, stimulus: Json| {
        let scenario = json!({ "circuit": "../replay.json", "simulation": { "stimulus": stimulus } });
        std::fs::write(folder.join("s").join(name), serde_json::to_string_pretty(&scenario).unwrap()).unwrap();
    };
    let waves = std::fs::read_to_string(folder.join("icarus.vcd")).unwrap();
    // the waveform may stand beside it under its own name
    std::fs::write(folder.join("s/pinned.vcd"), &waves).unwrap();
    write("pinned.json", json!({ "wave": "pinned.vcd", "scope": "bench.dut", "expect": true }));
    write(
        "chosen.json",
        json!({ "wave": "../icarus.fst", "expect": true, "first": ["clk_a", "clk_b"],
                                 "ignore": ["bus"], "ignore_x": "wave" }),
    );
    let (status, out, err) = run(&folder, "test s --x-control ignore");
    assert_eq!((status, out.as_str()), (0, "s/chosen.json: ok\ns/pinned.json: ok\n\n2 passed, 0 failed\n"), "{err}");
    assert_eq!(run(&folder, "test s --bless --x-control ignore").0, 0);
    assert_eq!(
        std::fs::read_to_string(folder.join("s/pinned.vcd")).unwrap(),
        waves,
        "the waveform is not to be renewed"
    );
    assert!(!folder.join("s/chosen.vcd").exists());
    assert_eq!(run(&folder, "check s/pinned.json").0, 0);
    let (status, ran) = report(&folder, "run s/pinned.json");
    assert_eq!((status, &ran["difference"]["same"]), (0, &json!(true)));

    // another waveform than the netlist gives
    std::fs::write(folder.join("s/pinned.vcd"), with_another_value(&folder)).unwrap();
    let (status, out, _) = run(&folder, "test s/pinned.json --x-control ignore");
    assert!(status == 1 && out.contains("First difference at"), "{out}");

    let faults = [
        (json!({ "wave": "gone.vcd" }), "bad-wave", "gone.vcd"),
        (json!({ "wave": "pinned.vcd", "scope": "bench.dat" }), "bad-wave", "bench.dat"),
        (json!({ "wave": "pinned.vcd", "first": ["a"] }), "unknown-net", "\"a\""),
        (json!({ "wave": "pinned.vcd", "ignore": ["a"] }), "bad-scenario", "\"a\""),
        (json!({ "wave": "pinned.vcd", "expect": "yes" }), "wrong-type", "yes"),
        (json!({ "wave": "pinned.vcd", "ignore_x": "b", "expect": true }), "bad-value", "\"b\""),
        (json!({ "scope": "bench" }), "missing-field", "stimulus"),
        (json!(5), "wrong-type", "5"),
    ];
    for (stimulus, code, at) in faults {
        write("faulty.json", stimulus.clone());
        let (status, out, err) = run(&folder, "check s/faulty.json --format json");
        let told: Json = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}{err}"));
        assert_eq!(status, 1, "{stimulus}: {out}");
        let text = told.to_string();
        assert!(text.contains(&format!("\"{code}\"")), "{stimulus}: {text}");
        let source = std::fs::read_to_string(folder.join("s/faulty.json")).unwrap();
        let line = 1 + source[..source.find(at).unwrap()].matches('\n').count();
        assert!(text.contains(&format!("\"line\":{line}")), "{stimulus}: not in line {line}: {text}");
    }
}

/// Waveforms of Verilator, which knows no x. A bench in C++ changes data before the clock of the same time, or with it.
#[needs(verilator, yosys)]
#[test]
fn verilator_is_replayed() {
    let folder = folder("stimulus_verilator");
    let design = "module lfsr (input clk, input rst, input [3:0] k, output reg [7:0] q, output [7:0] mixed);
  wire tap = q[7] ^ q[5] ^ q[4] ^ q[3];
  always @(posedge clk) if (rst) q <= 8'h1; else q <= {q[6:0] ^ {3'b0, k}, tap};
  assign mixed = q ^ {k, k};
endmodule\n";
    std::fs::write(folder.join("lfsr.v"), design).unwrap();
    let main = r#"#include "Vlfsr.h"
#include "verilated_vcd_c.h"
static void bench(const char* file, int offset) {
  VerilatedContext context; context.traceEverOn(true);
  Vlfsr top{&context}; VerilatedVcdC waves;
  top.trace(&waves, 9); waves.open(file);
  for (int t = 0; t < 400; t++) {
    top.clk = t & 1;
    if ((t + offset) % 2 == 0) { top.rst = t < 7; top.k = t / 6 * 7 & 15; }
    top.eval(); waves.dump(uint64_t(t));
  }
  waves.close();
}
int main() { bench("before.vcd", 0); bench("with.vcd", 1); }
"#;
    std::fs::write(folder.join("main.cpp"), main).unwrap();
    let arguments = ["--cc", "--exe", "--build", "--trace", "-CFLAGS", "-O0", "-Mdir", "obj", "lfsr.v", "main.cpp"];
    tool(&folder, "verilator", &arguments);
    tool(&folder, "obj/Vlfsr", &[]);
    netlist(&folder, &folder.join("lfsr.v"), "prep -top lfsr", "lfsr");
    for (line, status) in [("before.vcd", 0), ("with.vcd", 1), ("with.vcd --first rst --first k", 0)] {
        let line = format!("run lfsr.json --scope TOP.lfsr --expect --ignore-x b --stimulus {line}");
        let (found, ran) = report(&folder, &line);
        assert_eq!((found, &ran["difference"]["compared"]), (status, &json!(3)), "{line}: {ran:#}");
        assert!(status == 1 || ran["difference"]["values"].as_u64().unwrap() > 400, "{line}: {ran:#}");
    }
}
