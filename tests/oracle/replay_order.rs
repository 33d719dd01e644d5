//! `run --stimulus`: which bits are which, what changes together, and what is left of a width. Icarus on the Verilog is
//! the source of every value.

use std::path::Path;

use crate::support::folder;
use crate::support::replays::{icarus, netlist, refused, report, run};
use crate::support::rng::Rng;
use crate::support::tool::tool;
use needs::needs;
use serde_json::{Value as Json, json};

/// Levels of synthesis.
const LEVELS: [(&str, &str); 3] =
    [("prep", "prep -top dut"), ("gates", "synth -flatten -top dut"), ("nand", "synth -flatten -top dut; abc -g NAND")];

/// Icarus' waveform of `bench.v` with `dut.v`, and netlists of `dut.v` at every level.
fn make(name: &str, design: &str, bench: &str) -> std::path::PathBuf {
    let folder = folder(name);
    std::fs::write(folder.join("dut.v"), design).unwrap();
    std::fs::write(folder.join("bench.v"), bench).unwrap();
    icarus(&folder, &folder.join("bench.v"), &folder.join("dut.v"));
    for (level, passes) in LEVELS {
        netlist(&folder, &folder.join("dut.v"), passes, level);
    }
    folder
}

/// A replay in which all is equal; how many values were compared.
fn equal(folder: &Path, line: &str) -> u64 {
    let (status, ran) = report(folder, &format!("{line} --expect"));
    assert_eq!(status, 0, "{line}: {ran:#}");
    ran["difference"]["values"].as_u64().unwrap()
}

fn differing(folder: &Path, line: &str) -> Json {
    let (status, ran) = report(folder, &format!("{line} --expect"));
    assert_eq!(status, 1, "{line}: {ran:#}");
    ran["difference"].clone()
}

/// A waveform in which a vector stands in parts of these widths, from its left end on, the last part first if it is so
/// wanted. The values are those that were there.
fn in_parts(text: &str, name: &str, widths: &[u32], backwards: bool) -> String {
    let mut ids = Vec::new();
    let mut out = String::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["$var", kind, _, id, var, range, "$end"] = words[..]
            && var == name
        {
            let (left, right) = range.trim_matches(['[', ']']).split_once(':').unwrap();
            let (left, right): (i64, i64) = (left.parse().unwrap(), right.parse().unwrap());
            let step = if left >= right { -1 } else { 1 };
            let mut at = left;
            let mut lines = Vec::new();
            for (i, &width) in widths.iter().enumerate() {
                let end = at + step * (i64::from(width) - 1);
                let range = if width == 1 { format!("[{at}]") } else { format!("[{at}:{end}]") };
                lines.push(format!("$var {kind} {width} {id}~{i} {name} {range} $end\n"));
                at = end + step;
            }
            assert_eq!(at, right + step);
            if backwards {
                lines.reverse();
            }
            out.extend(lines);
            ids.push(id.to_owned());
            continue;
        }
        match words[..] {
            [value, id] if value.starts_with('b') && ids.iter().any(|known| known == id) => {
                let total: u32 = widths.iter().sum();
                let bits = &value[1..];
                let fill = if bits.starts_with('1') { "0" } else { &bits[..1] };
                let bits = format!("{}{bits}", fill.repeat(total as usize - bits.len()));
                let mut at = 0;
                for (i, &width) in widths.iter().enumerate() {
                    let part = &bits[at..at + width as usize];
                    out += &if width == 1 { format!("{part}{id}~{i}\n") } else { format!("b{part} {id}~{i}\n") };
                    at += width as usize;
                }
            }
            _ => {
                out += line;
                out.push('\n');
            }
        }
    }
    assert!(!ids.is_empty(), "no {name}");
    out
}

/// How a vector of so many bits may be cut.
fn cuts(width: u32) -> Vec<Vec<u32>> {
    let half = width / 2;
    let mut cuts = vec![vec![1; width as usize], vec![half, width - half], vec![1, width - 1]];
    if width > 3 {
        cuts.push(vec![1, 1, width - 2]);
        cuts.push(vec![width - 2, 1, 1]);
    }
    cuts
}

/// Vectors of clocks and data, of every direction and offset, whole, in parts and bit by bit, as VCD and FST, at every
/// level of synthesis.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn bits_of_one_vector_change_together() {
    let mut rng = Rng::new(16);
    // range, the bits that are clocks
    for (i, (left, right, clocks)) in [
        (1, 0, [0, 0]),
        (0, 1, [0, 1]),
        (5, 2, [3, 5]),
        (2, 5, [5, 3]),
        (-3, 4, [0, -2]),
        (4, -3, [-3, 4]),
        (69, 3, [67, 4]),
        (3, 69, [3, 68]),
    ]
    .into_iter()
    .enumerate()
    {
        let width = i64::abs(left - right) + 1;
        let [rise, fall] = clocks;
        let design = format!(
            "module dut(input [{left}:{right}] b, input clk, output reg [{left}:{right}] q, r, s, output [0:3] w);\n\
             initial begin q = 0; r = 0; s = 0; end\n\
             always @(posedge b[{rise}]) q <= b; always @(negedge b[{fall}]) r <= b ^ q;\n\
             always @(posedge clk) s <= b; assign w = {{b[{left}], b[{right}], q[{left}], r[{right}]}}; endmodule\n"
        );
        let mut bench = format!(
            "`timescale 1ns/1ns\nmodule tb; reg [{left}:{right}] b = 0; reg clk = 0; \
             wire [{left}:{right}] q, r, s; wire [0:3] w;\n\
             dut u(b, clk, q, r, s, w); always #10 clk = ~clk;\n\
             initial begin $dumpfile(\"icarus.vcd\"); $dumpvars(0, u);\n"
        );
        for step in 0..80 {
            let value: u128 = u128::from(rng.word()) << 64 | u128::from(rng.word());
            let value = value & ((1 << width) - 1);
            // by the clock, or between its edges
            let when = if step % 2 == 0 { "@(posedge clk)" } else { "#5" };
            bench += &format!("{when} b <= {width}'h{value:x};\n");
        }
        bench += "#20 $finish; end endmodule\n";
        let folder = make(&format!("replay_vectors_{i}"), &design, &bench);
        let vcd = std::fs::read_to_string(folder.join("icarus.vcd")).unwrap();
        let mut waves = vec!["icarus.vcd".to_owned(), "icarus.fst".to_owned()];
        for (k, cut) in cuts(width as u32).iter().enumerate().filter(|(k, _)| *k < 3 || width < 10) {
            for backwards in [false, true] {
                let mut text = in_parts(&vcd, "b", cut, backwards);
                if k == 0 {
                    text = in_parts(&text, "q", cut, backwards);
                    text = in_parts(&text, "w", &[1; 4], backwards);
                }
                let name = format!("cut_{k}_{backwards}");
                std::fs::write(folder.join(format!("{name}.vcd")), text).unwrap();
                tool(&folder, "vcd2fst", &[&format!("{name}.vcd"), &format!("{name}.fst")]);
                waves.extend([format!("{name}.vcd"), format!("{name}.fst")]);
            }
        }
        for wave in &waves {
            for (level, _) in LEVELS.iter().take(if wave == "icarus.vcd" { 3 } else { 1 }) {
                let values = equal(&folder, &format!("run {level}.json --stimulus {wave}"));
                assert!(values > 100, "{left}:{right} {level} {wave}: {values}");
            }
        }
        // it is the order that makes it so
        let named = format!("run prep.json --stimulus icarus.vcd --first b[{rise}] --first b[{fall}]");
        assert!(differing(&folder, &named)["differing"].as_u64() > Some(0));
        refused(&folder, "run prep.json --stimulus icarus.vcd --first b[77]", &["drives no input `b[77]`"]);
    }
}

/// `diff` takes bits that stand one by one as the other waveform declares them.
#[test]
fn diff_knows_which_way_indices_run() {
    let folder = folder("replay_diff_bits");
    let file = |name: &str, vars: &str, values: &str| {
        let text = format!(
            "$timescale 1 ns $end $scope module t $end\n{vars}$upscope $end $enddefinitions $end\n#0\n{values}\n#10\n"
        );
        std::fs::write(folder.join(name), text).unwrap();
    };
    let bits = |order: [i32; 4]| -> String {
        order.iter().map(|i| format!("$var wire 1 {} a [{i}] $end\n", ["p", "q", "r", "s"][*i as usize])).collect()
    };
    // a[0] is 1
    for (name, order) in [("up", [0, 1, 2, 3]), ("down", [3, 2, 1, 0])] {
        file(&format!("{name}.vcd"), &bits(order), "1p\n0q\n0r\n0s");
    }
    file("whole_up.vcd", "$var wire 4 ! a [0:3] $end\n", "b1000 !");
    file("whole_down.vcd", "$var wire 4 ! a [3:0] $end\n", "b0001 !");
    for bits in ["up.vcd", "down.vcd"] {
        for whole in ["whole_up.vcd", "whole_down.vcd"] {
            for line in [format!("diff {bits} {whole}"), format!("diff {whole} {bits}")] {
                let (status, out, err) = run(&folder, &line);
                assert_eq!(status, 0, "{line}: {out}{err}");
            }
        }
    }
    file("other.vcd", "$var wire 4 ! a [0:3] $end\n", "b0001 !");
    let (status, out, _) = run(&folder, "diff up.vcd other.vcd");
    assert!(status == 1 && out.contains("1000 (8)  0001 (1)"), "{out}");
}

const LATCH: &str = "module dut(input clk_ff, input [1:0] g, input en, input d, output reg d1, output reg q, output reg p, o);\n\
    initial begin d1 = 0; q = 0; p = 0; o = 0; end\n\
    always @(posedge clk_ff) begin d1 <= d; o <= q; end\n\
    always @* if (!g[0]) q = d1;\n    always @* if (g[1] & en) p = d1 ^ q;\nendmodule\n";

fn latch_bench(gates: &str) -> String {
    format!(
        "`timescale 1ns/1ns\nmodule tb; reg clk = 0, en = 1, d = 0, slow = 0; wire d1, q, p, o; wire [1:0] g;\n\
         assign g = {gates}; dut u(clk, g, en, d, d1, q, p, o);\n\
         always #5 clk = ~clk; always @(negedge clk) slow <= ~slow; reg [15:0] n = 16'hace1;\n\
         always @(negedge clk) begin n <= {{n[14:0], n[15] ^ n[13] ^ n[12] ^ n[10]}}; d <= n[0]; en <= n[3] | n[5]; end\n\
         initial begin $dumpfile(\"icarus.vcd\"); $dumpvars(0, tb); #1203 $finish; end endmodule\n"
    )
}

/// The enable of a latch that the bench ties to a clock, or to its inverse, closes with it, whatever the waveform calls it.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn gates_of_latches_that_are_the_clock() {
    for (i, gates) in ["{clk, clk}", "{~clk, clk}"].iter().enumerate() {
        let folder = make(&format!("replay_latch_{i}"), LATCH, &latch_bench(gates));
        for (level, _) in LEVELS {
            for wave in ["icarus.vcd", "icarus.fst"] {
                let (status, out, err) =
                    run(&folder, &format!("run {level}.json --stimulus {wave} --scope tb.u --expect"));
                assert_eq!((status, err.as_str()), (0, ""), "{gates} {level} {wave}: {out}");
            }
        }
    }
    // a gate that moves with the clock sometimes: taken as data, said, and settled by an option
    let folder = make("replay_latch_maybe", LATCH, &latch_bench("{1'b0, clk & ~slow}"));
    let line = "run prep.json --stimulus icarus.vcd --scope tb.u";
    let (_, _, err) = run(&folder, line);
    for text in
        ["warning[ambiguous-order]", "`g[0]` and another, the enable of a latch", "`--first clk_ff --first g[0]`"]
    {
        assert!(err.contains(text), "no `{text}` in {err}");
    }
    assert!(differing(&folder, line)["differing"].as_u64() > Some(0));
    equal(&folder, &format!("{line} --first clk_ff --first g[0]"));
}

/// Inputs that are one wire in the bench change as one.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn one_wire_is_one() {
    let design = "module dut(input clk, input a, input [3:0] v, output reg q, output reg [3:0] w);\n\
        initial begin q = 0; w = 0; end always @(posedge clk) begin q <= a; w <= v; end endmodule\n";
    let bench = "`timescale 1ns/1ns\nmodule tb; reg clk = 0; reg [3:0] v = 0; wire q; wire [3:0] w;\n\
        dut u(clk, clk, v, q, w); always #5 clk = ~clk; always @(posedge clk) v <= v + 3;\n\
        initial begin $dumpfile(\"icarus.vcd\"); $dumpvars(0, u); #200 $finish; end endmodule\n";
    let folder = make("replay_one_wire", design, bench);
    for (level, _) in LEVELS {
        equal(&folder, &format!("run {level}.json --stimulus icarus.vcd"));
    }
}

/// How many bits a net has in a netlist.
fn width(folder: &Path, file: &str, net: &str) -> usize {
    let file: Json = serde_json::from_str(&std::fs::read_to_string(folder.join(file)).unwrap()).unwrap();
    file["modules"]["dut"]["netnames"][net]["bits"].as_array().map_or(0, Vec::len)
}

/// What synthesis leaves of a width is compared, with signs and without, up and down, wherever 64 bits end.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn trimmed_widths() {
    for (i, (range, wide, kept)) in
        [("[3:0]", 4, 3), ("[0:7]", 8, 5), ("[68:4]", 65, 63), ("[2:67]", 66, 64), ("[99:0]", 100, 65)]
            .iter()
            .enumerate()
    {
        // `a` keeps its lower bits, of `c` the higher ones repeat the sign, of `l` they change and nobody reads them
        let design = format!(
            "module dut(input clk, input long, input [{top}:0] x, output reg [{top}:0] y, output reg [1:0] z, output reg o);\n\
             wire {range} a = long ? {{{pad}'d0, x}} : {wide}'d2;\n\
             wire signed {range} c = $signed(x) * 1;\n wire {range} l = {{x, {pad}'d0}} + x;\n\
             initial begin y = 0; z = 0; o = 0; end\n\
             always @(posedge clk) begin y <= a + c; z <= {lost}; o <= a == {wide}'d2; end endmodule\n",
            top = kept - 1,
            pad = wide - kept,
            lost = if i % 2 == 0 { format!("l[{}]", low(range)) } else { "0".to_owned() },
        );
        let bench = format!(
            "`timescale 1ns/1ns\nmodule tb; reg clk = 0, long = 0; reg [{top}:0] x = 1; wire [{top}:0] y; wire [1:0] z; wire o;\n\
             dut u(clk, long, x, y, z, o); always #5 clk = ~clk;\n\
             always @(negedge clk) begin x <= {{x[{next}:0], x[{top}] ^ x[0] ^ 1'b1}}; long <= x[1]; end\n\
             initial begin $dumpfile(\"icarus.vcd\"); $dumpvars(0, tb); #800 $finish; end endmodule\n",
            top = kept - 1,
            next = kept - 2,
        );
        let folder = make(&format!("replay_trimmed_{i}"), &design, &bench);
        assert!((1..*wide as usize).contains(&width(&folder, "prep.json", "a")), "{range}: nothing is trimmed");
        for wave in ["icarus.vcd", "icarus.fst"] {
            for (level, _) in LEVELS {
                let line = format!("run {level}.json --stimulus {wave} --scope tb.u --ignore l");
                equal(&folder, &line);
            }
        }
        if i % 2 == 0 {
            // what changes above is no mere trimming
            let told = differing(&folder, "run prep.json --stimulus icarus.vcd --scope tb.u");
            assert_eq!((&told["kinds"]["count"], &told["kinds"]["first"][0]["name"]), (&json!(1), &json!("l")));
        }
    }
}

/// The two lowest bits of a range.
fn low(range: &str) -> String {
    let (left, right) = range.trim_matches(['[', ']']).split_once(':').unwrap();
    let (left, right): (i64, i64) = (left.parse().unwrap(), right.parse().unwrap());
    if left > right { format!("{}:{right}", right + 1) } else { format!("{}:{right}", right - 1) }
}

/// The other way round: a waveform of what synthesis left, replayed on the design as it was written.
#[needs(iverilog, vcd2fst, yosys)]
#[test]
fn a_waveform_of_what_was_trimmed() {
    let design = "module dut(input clk, input long, output reg done, output reg [3:0] low);\n\
        wire [8:5] rounds = long ? 4'd6 : 4'd2; wire [7:0] sum = {4'd9, low} + {low, low}; reg [3:0] n;\n\
        initial begin n = 0; done = 0; low = 0; end\n\
        always @(posedge clk) begin n <= n == rounds ? 4'd0 : n + 4'd1; done <= n == rounds; low <= sum[3:0] + 1; end\n\
        endmodule\n";
    let bench = "`timescale 1ns/1ns\nmodule tb; reg clk = 0, long = 0; wire done; wire [3:0] low; dut u(clk, long, done, low);\n\
        always #5 clk = ~clk; initial begin $dumpfile(\"icarus.vcd\"); $dumpvars(0, tb); #72 long = 1; #120 $finish; end\n\
        endmodule\n";
    let folder = folder("replay_trimmed_waveform");
    std::fs::write(folder.join("dut.v"), design).unwrap();
    std::fs::write(folder.join("bench.v"), bench).unwrap();
    tool(&folder, "yosys", &["-q", "-p", "read_verilog dut.v; prep -top dut; write_verilog -noattr trimmed.v"]);
    let trimmed = std::fs::read_to_string(folder.join("trimmed.v")).unwrap();
    assert!(trimmed.contains("wire [2:0] rounds;") && trimmed.contains("wire [3:0] sum;"), "{trimmed}");
    icarus(&folder, &folder.join("bench.v"), &folder.join("trimmed.v"));
    netlist(&folder, &folder.join("dut.v"), "proc", "whole");
    assert_eq!((width(&folder, "whole.json", "rounds"), width(&folder, "whole.json", "sum")), (4, 8));
    equal(&folder, "run whole.json --stimulus icarus.vcd --scope tb.u --ignore sum");
    let told = differing(&folder, "run whole.json --stimulus icarus.vcd --scope tb.u");
    assert_eq!(told["kinds"]["first"], json!([{ "name": "sum", "a": "4 bits", "b": "8 bits" }]));
}

fn write(folder: &Path, name: &str, json: &Json) {
    std::fs::write(folder.join(name), json.to_string()).unwrap();
}

/// A netlist without ports is found among the scopes in time that grows as they do: 8 s were taken for 4,000 instances
/// once, and four times that for twice as many.
#[test]
fn scopes_are_found_in_linear_time() {
    let folder = folder("replay_scopes");
    let count = 40_000;
    let leaf = json!({ "netnames": { "r": { "hide_name": 0, "bits": ["1"], "attributes": {} } } });
    let cells: serde_json::Map<String, Json> = (0..count)
        .map(|i| (format!("i{i}"), json!({ "type": "leaf", "port_directions": {}, "connections": {} })))
        .collect();
    let top = json!({ "attributes": { "top": "1" }, "cells": cells, "netnames": {} });
    write(&folder, "top.json", &json!({ "creator": "Yosys", "modules": { "leaf": leaf, "top": top } }));
    let mut text = "$timescale 1 ns $end\n$scope module bench $end\n$scope module top $end\n".to_owned();
    for i in 0..count {
        text += &format!("$scope module i{i} $end\n$var reg 1 v{i} r $end\n$upscope $end\n");
    }
    text += "$upscope $end\n$upscope $end\n$enddefinitions $end\n#0\n";
    text.extend((0..count).map(|i| format!("1v{i}\n")));
    std::fs::write(folder.join("w.vcd"), text + "#10\n").unwrap();
    let started = std::time::Instant::now();
    assert_eq!(equal(&folder, "run top.json --stimulus w.vcd"), count);
    let took = started.elapsed();
    assert!(took.as_secs() < 100, "{took:?}");
}

/// What only prints is replayed like anything else, and its bench need not be named if it has the same values.
#[test]
fn a_design_that_only_prints() {
    let folder = folder("replay_print");
    let print = json!({ "type": "$print",
        "parameters": { "FORMAT": "d={4:> d-u}\n", "ARGS_WIDTH": 4, "PRIORITY": 0, "TRG_ENABLE": 1, "TRG_WIDTH": 1,
            "TRG_POLARITY": "1" },
        "connections": { "EN": ["1"], "TRG": [2], "ARGS": [3, 4, 5, 6] } });
    let module = json!({ "attributes": { "top": "1" },
        "ports": { "clk": { "direction": "input", "bits": [2] }, "d": { "direction": "input", "bits": [3, 4, 5, 6] } },
        "cells": { "p": print }, "netnames": {} });
    write(&folder, "p.json", &json!({ "creator": "Yosys", "modules": { "p": module } }));
    let wave = |name: &str, inner: &str| {
        let text = format!(
            "$timescale 1 ns $end $scope module tb $end $var reg 1 ! clk $end $var reg 4 a d [3:0] $end\n\
             $scope module u $end $var wire 1 ! clk $end $var wire 4 b d [3:0] $end $upscope $end $upscope $end\n\
             $enddefinitions $end\n#0\n0!\nb0 a\nb0 b\n#5\n1!\nb11 a\n{inner}#10\n0!\n#15\n1!\n#20\n"
        );
        std::fs::write(folder.join(name), text).unwrap();
    };
    wave("w.vcd", "b11 b\n");
    for scope in ["", "--scope tb.u"] {
        let (status, out, err) = run(&folder, &format!("run p.json --stimulus w.vcd --expect {scope}"));
        assert_eq!(status, 0, "{out}{err}");
        for value in ["d=0", "d=3"] {
            assert!(format!("{out}{err}").contains(value), "no `{value}` in {out}{err}");
        }
    }
    // other values: which is it?
    wave("w.vcd", "b111 b\n");
    refused(&folder, "run p.json --stimulus w.vcd --expect", &["several scopes", "`tb`, `tb.u`"]);
}
