//! How long it takes to load a netlist that Yosys wrote, how much memory, and how both grow with its size.
//!
//!     cargo bench --bench yosys
//!
//! The netlists are random gates and flip-flops with the names, source places and layout that `write_json` gives. Each
//! is loaded in a process of its own, of which the largest memory is taken; the text itself is part of it.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Cells of each netlist.
const SIZES: [u32; 4] = [10_000, 100_000, 300_000, 1_000_000];

/// The ports and parameters of some cells.
const KINDS: [(&str, &[&str], &str); 8] = [
    ("$_AND_", &["A", "B"], "Y"),
    ("$_XOR_", &["A", "B"], "Y"),
    ("$_NAND_", &["A", "B"], "Y"),
    ("$_NOT_", &["A"], "Y"),
    ("$_ANDNOT_", &["A", "B"], "Y"),
    ("$_MUX_", &["A", "B", "S"], "Y"),
    ("$_DFF_P_", &["C", "D"], "Q"),
    ("$_SDFFE_PP0P_", &["C", "D", "E", "R"], "Q"),
];

/// A netlist of so many cells, each of which reads some before it.
fn netlist(cells: u32) -> String {
    let mut state = 1u64;
    let mut random = |n: u32| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) % u64::from(n)) as u32
    };
    let mut text = String::from(
        "{\n\"creator\": \"Yosys bench\",\n\"modules\": {\n\"big\": {\n\"attributes\": { \"top\": \"1\" },\n\"ports\": {\n\
         \"clk\": { \"direction\": \"input\", \"bits\": [ 2 ] },\n\"a\": { \"direction\": \"input\", \"bits\": [ 3, 4, 5, 6 ] },\n",
    );
    write!(text, "\"y\": {{ \"direction\": \"output\", \"bits\": [ {} ] }}\n}},\n\"cells\": {{\n", cells + 6).unwrap();
    for i in 0..cells {
        let own = i + 7;
        let (kind, inputs, output) = KINDS[random(KINDS.len() as u32) as usize];
        write!(
            text,
            "\"$abc$1$auto$blifparse.cc:397:parse_blif${i}\": {{ \"hide_name\": 1, \"type\": \"{kind}\", \"parameters\": {{ }}, \
             \"attributes\": {{ \"src\": \"big.v:{}.{}\" }}, \"connections\": {{ ",
            i / 7,
            i % 7
        )
        .unwrap();
        for port in inputs {
            let from = if *port == "C" { 2 } else { own - 1 - random((own - 3).min(2000)) };
            write!(text, "\"{port}\": [ {from} ], ").unwrap();
        }
        let end = if i + 1 < cells { "," } else { "" };
        writeln!(text, "\"{output}\": [ {own} ] }} }}{end}").unwrap();
    }
    text += "},\n\"netnames\": {\n";
    for i in 0..cells {
        let end = if i + 1 < cells { "," } else { "" };
        writeln!(text, "\"n{i}\": {{ \"hide_name\": 0, \"bits\": [ {} ], \"attributes\": {{ }} }}{end}", i + 7)
            .unwrap();
    }
    text + "}\n}\n}\n}\n"
}

/// The most memory that this process has had, in bytes.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()).unwrap_or(0) * 1024
}

/// Loads a file and prints seconds, cells and bytes, for the process that asked.
fn load(path: &Path) {
    let begin = Instant::now();
    let mut limits = discreta::circuit::Limits::default();
    limits.set("file-size=4000000000").expect("a limit");
    let mut loader = discreta::circuit::Loader::new(limits);
    let circuit = loader.open(path).and_then(|file| loader.elaborate(file, &[])).expect("a netlist");
    assert!(!loader.diagnostics.has_errors());
    println!("{} {} {}", begin.elapsed().as_secs_f64(), circuit.netlist.cells().len(), peak());
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let Some(at) = arguments.iter().position(|a| a == "--load") {
        return load(Path::new(&arguments[at + 1]));
    }
    let folder = tempfile::tempdir().expect("a folder");
    println!(
        "{:>9}  {:>9}  {:>8}  {:>10}  {:>10}  {:>12}",
        "cells", "text", "seconds", "s/M cells", "peak", "bytes/cell"
    );
    let mut last: Option<(f64, f64)> = None;
    for cells in SIZES {
        let path = folder.path().join(format!("{cells}.json"));
        let text = netlist(cells);
        std::fs::write(&path, &text).expect("room for the netlist");
        let mut best: Option<(f64, f64)> = None;
        for _ in 0..3 {
            let told = Command::new(&arguments[0]).arg("--load").arg(&path).output().expect("this program");
            let told = String::from_utf8_lossy(&told.stdout).into_owned();
            let numbers: Vec<f64> = told.split_whitespace().map(|n| n.parse().expect("numbers")).collect();
            assert!(numbers[1] >= f64::from(cells), "{} cells of {cells}", numbers[1]);
            best = Some(best.map_or((numbers[0], numbers[2]), |b| (b.0.min(numbers[0]), b.1.min(numbers[2]))));
        }
        let (seconds, bytes) = best.expect("three runs");
        let n = f64::from(cells);
        let mb = |bytes: f64| format!("{:.1} MB", bytes / 1e6);
        println!(
            "{cells:>9}  {:>9}  {seconds:>8.3}  {:>10.2}  {:>10}  {:>12.0}",
            mb(text.len() as f64),
            seconds / n * 1e6,
            mb(bytes),
            bytes / n
        );
        last = Some((n, seconds)).inspect(|&(n, s)| {
            if let Some((before, t)) = last {
                println!(
                    "{:>9}  grows with the number of cells to the power of {:.2}",
                    "",
                    (s / t).ln() / (n / before).ln()
                );
            }
        });
    }
}
