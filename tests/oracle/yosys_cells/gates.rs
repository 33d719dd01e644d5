//! The cells of one bit: all combinations of all values, and every flip-flop and latch in every polarity.

use discreta::{Logic, Value};
use needs::needs;

use super::batch::{Cell, compare};
use crate::support::Rng;

/// The combinational ones.
pub const COMBINATIONAL: &[&str] = &[
    "$_BUF_",
    "$_NOT_",
    "$_AND_",
    "$_NAND_",
    "$_OR_",
    "$_NOR_",
    "$_XOR_",
    "$_XNOR_",
    "$_ANDNOT_",
    "$_ORNOT_",
    "$_MUX_",
    "$_NMUX_",
    "$_MUX4_",
    "$_MUX8_",
    "$_MUX16_",
    "$_AOI3_",
    "$_OAI3_",
    "$_AOI4_",
    "$_OAI4_",
    "$_TBUF_",
];

const LETTERS: [&str; 16] = ["A", "B", "C", "D", "E", "F", "G", "H", "I", "J", "K", "L", "M", "N", "O", "P"];
const SELECTS: [&str; 4] = ["S", "T", "U", "V"];

pub fn combinational(kind: &str) -> Cell {
    let ports: Vec<&'static str> = match kind {
        "$_BUF_" | "$_NOT_" => vec!["A"],
        "$_MUX_" | "$_NMUX_" => vec!["A", "B", "S"],
        "$_MUX4_" => [&LETTERS[..4], &SELECTS[..2]].concat(),
        "$_MUX8_" => [&LETTERS[..8], &SELECTS[..3]].concat(),
        "$_MUX16_" => [&LETTERS[..], &SELECTS[..]].concat(),
        "$_AOI3_" | "$_OAI3_" => vec!["A", "B", "C"],
        "$_AOI4_" | "$_OAI4_" => vec!["A", "B", "C", "D"],
        "$_TBUF_" => vec!["A", "E"],
        _ => vec!["A", "B"],
    };
    let inputs: Vec<(&'static str, u32)> = ports.into_iter().map(|p| (p, 1)).collect();
    Cell::new(kind, &inputs, &[("Y", 1)])
}

/// The names of all flip-flops and latches, by what their letters can be.
pub fn storage_names() -> Vec<String> {
    let all = |family: &str, letters: &[&str]| -> Vec<String> {
        let mut names = vec![String::new()];
        for choice in letters {
            names = names.iter().flat_map(|n| choice.chars().map(move |c| format!("{n}{c}"))).collect();
        }
        names.iter().map(|n| format!("$_{family}_{n}_")).collect()
    };
    let (p, v) = ("NP", "01");
    let mut names = vec!["$_FF_".to_owned()];
    for (family, letters) in [
        ("SR", &[p, p][..]),
        ("DFF", &[p]),
        ("DFFE", &[p, p]),
        ("DFF", &[p, p, v]),
        ("DFFE", &[p, p, v, p]),
        ("ALDFF", &[p, p]),
        ("ALDFFE", &[p, p, p]),
        ("DFFSR", &[p, p, p]),
        ("DFFSRE", &[p, p, p, p]),
        ("SDFF", &[p, p, v]),
        ("SDFFE", &[p, p, v, p]),
        ("SDFFCE", &[p, p, v, p]),
        ("DLATCH", &[p]),
        ("DLATCH", &[p, p, v]),
        ("DLATCHSR", &[p, p, p]),
    ] {
        names.extend(all(family, letters));
    }
    names
}

pub fn storage(name: &str, init: Option<Value>) -> Cell {
    let parts: Vec<&str> = name.trim_matches(['$', '_']).split('_').collect();
    let letters = parts.get(1).copied().unwrap_or_default();
    // ports in the order of the letters; a digit is no port
    let ports: &[&'static str] = match (parts[0], letters.len()) {
        ("SR", _) => &["S", "R"],
        ("DFF", 1) => &["C"],
        ("DFFE", 2) => &["C", "E"],
        ("DFF" | "SDFF", _) => &["C", "R"],
        ("DFFE" | "SDFFE" | "SDFFCE", _) => &["C", "R", "E"],
        ("ALDFF", _) => &["C", "L"],
        ("ALDFFE", _) => &["C", "L", "E"],
        ("DFFSR", _) => &["C", "S", "R"],
        ("DFFSRE", _) => &["C", "S", "R", "E"],
        ("DLATCH", 1) => &["E"],
        ("DLATCH", _) => &["E", "R"],
        ("DLATCHSR", _) => &["E", "S", "R"],
        _ => &[],
    };
    let mut inputs: Vec<(&'static str, u32)> = ports.iter().map(|&p| (p, 1)).collect();
    match parts[0] {
        "SR" => {}
        "ALDFF" | "ALDFFE" => inputs.extend([("D", 1), ("AD", 1)]),
        _ => inputs.push(("D", 1)),
    }
    let mut cell = Cell::new(name, &inputs, &[("Q", 1)]);
    let polarities = letters.chars().filter(|c| "NP".contains(*c));
    cell.controls =
        ports.iter().copied().zip(polarities).map(|(port, p)| (port, Value::from_u64((p == 'N').into(), 1))).collect();
    cell.init = init;
    cell
}

#[needs(iverilog, yosys)]
#[test]
fn combinational_gates() {
    let cells: Vec<Cell> = COMBINATIONAL.iter().map(|k| combinational(k)).collect();
    compare("gates", &cells, 600);
}

#[needs(iverilog, yosys)]
#[test]
fn flip_flops_and_latches_of_one_bit() {
    let mut rng = Rng::named("fine");
    let mut cells = Vec::new();
    for name in storage_names() {
        for _ in 0..3 {
            let init = match rng.below(3) {
                0 => None,
                n => Some(Value::repeat(if n == 1 { Logic::Zero } else { Logic::One }, 1)),
            };
            cells.push(storage(&name, init));
        }
    }
    compare("fine", &cells, 200);
}
