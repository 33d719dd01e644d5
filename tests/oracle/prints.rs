//! `$print` as Yosys writes `$write` and `$display`: in the order of the source, whatever cells are called and wherever they
//! stand in the file, line by line as Icarus prints it.

use needs::needs;
use serde_json::{Map, json};

use crate::support::tool::tool;
use crate::support::{Rng, folder};

/// The lines that a run prints, without time and source.
fn printed(folder: &std::path::Path, engine: &str) -> String {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_discreta"));
    command.current_dir(folder).args(["run", "t.json", "-s", "d=5", "--clock", "clk=10ns", "--cycles", "3"]);
    let ran = command.args(["--engine", engine]).output().unwrap();
    let told = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success(), "{told}");
    let line = |line: &str| match line.strip_prefix("print: at ").and_then(|l| l.split_once(" ns: ")) {
        Some((_, text)) => text.rsplit_once(" (t.v").unwrap().0.to_owned() + "\n",
        None => panic!("{line}"),
    };
    told.lines().map(line).collect()
}

#[needs(iverilog)]
#[test]
fn prints_come_in_the_order_of_the_source() {
    let folder = folder("prints");
    let mut lines = 0;
    for seed in 0..24 {
        let mut rng = Rng::new(seed);
        let processes = 1 + rng.below(2);
        let (mut verilog, mut cells, mut number) =
            (String::from("module t(input clk, input [7:0] d);\n"), Vec::new(), 0);
        for process in 0..processes {
            verilog += "always @(posedge clk) begin\n";
            let statements = 2 + rng.below(5);
            for at in 0..statements {
                number += 1;
                // a process ends the line that it has begun
                let ends = at + 1 == statements || rng.one_in(2);
                let (least, shows) = (rng.below(8), rng.one_in(2));
                let least = if ends && at + 1 == statements { 0 } else { least };
                let task = if ends { "$display" } else { "$write" };
                let text = format!("p{process} s{at} ");
                let (format, arguments) = if shows { ("%0d ", ", d") } else { ("", "") };
                verilog += &format!("  if (d >= {least}) {task}(\"{text}{format}\"{arguments});\n");
                let shown = if shows { "{8:> du} " } else { "" };
                let bits: Vec<u32> = if shows { (3..11).collect() } else { vec![] };
                let end = if ends { "\n" } else { "" };
                let cell = json!({ "type": "$print", "attributes": { "src": format!("t.v:{number}.1-{number}.9") },
                    "parameters": { "FORMAT": format!("{text}{shown}{end}"), "ARGS_WIDTH": bits.len(),
                        "PRIORITY": format!("{:032b}", (-1 - at as i32) as u32),
                        "TRG_ENABLE": 1, "TRG_WIDTH": 1, "TRG_POLARITY": "1" },
                    "connections": { "EN": [u8::from(5 >= least).to_string()], "TRG": [2], "ARGS": bits } });
                cells.push((format!("{task}$t.v:{number}${number}"), cell));
            }
            verilog += "end\n";
        }
        verilog += "endmodule\n";
        rng.shuffle(&mut cells);
        let cells: Map<String, serde_json::Value> = cells.into_iter().collect();
        let file = json!({ "creator": "Yosys 0.70", "modules": { "t": {
            "attributes": { "top": "00000000000000000000000000000001" },
            "ports": { "clk": { "direction": "input", "bits": [2] },
                "d": { "direction": "input", "bits": [3, 4, 5, 6, 7, 8, 9, 10] } },
            "cells": cells, "netnames": {} } } });
        std::fs::write(folder.join("t.json"), file.to_string()).unwrap();
        std::fs::write(folder.join("t.v"), verilog).unwrap();
        let bench = "module tb; reg clk = 0; t t(clk, 8'd5); initial begin repeat (3) begin #5 clk = 1; #5 clk = 0; end $finish; end endmodule";
        std::fs::write(folder.join("tb.v"), bench).unwrap();
        tool(&folder, "iverilog", &["-o", "t.vvp", "t.v", "tb.v"]);
        let theirs = tool(&folder, "vvp", &["-n", "t.vvp"]);
        let sorted = |text: &str| {
            // which process comes first Verilog leaves open
            let mut lines: Vec<String> = text.lines().map(|l| l.trim_end().to_owned()).collect();
            if processes > 1 {
                lines.sort();
            }
            lines
        };
        for engine in ["event", "auto"] {
            assert_eq!(sorted(&printed(&folder, engine)), sorted(&theirs), "seed {seed}, {engine}");
        }
        lines += theirs.lines().count();
    }
    println!("{lines} lines equal");
    assert!(lines > 150);
}
