//! Flip-flops, registers and latches of words.

use discreta::Value;
use needs::needs;

use super::batch::{Cell, compare};
use crate::support::Rng;

/// What is compared here.
pub const CELLS: &[&str] = &[
    "$sr",
    "$ff",
    "$dff",
    "$dffe",
    "$dffsr",
    "$dffsre",
    "$adff",
    "$adffe",
    "$aldff",
    "$aldffe",
    "$sdff",
    "$sdffe",
    "$sdffce",
    "$dlatch",
    "$adlatch",
    "$dlatchsr",
];

pub fn cell(kind: &str, rng: &mut Rng) -> Cell {
    let most = if rng.one_in(3) { 70 } else { 9 };
    let w = 1 + rng.below(most) as u32;
    let mut cell = Cell::new(kind, &[], &[("Q", w)]).number("WIDTH", w.into());
    let mut control = |cell: &mut Cell, port: &'static str, polarity: &'static str, width: u32, turns: bool| {
        let positive = rng.one_in(2);
        cell.parameters.push((polarity, Value::from_u64(positive.into(), 1)));
        cell.inputs.push((port, width));
        if turns {
            cell.controls.push((port, Value::from_i64(if positive { 0 } else { -1 }, width)));
        }
    };
    let latch = kind.contains("latch");
    if kind != "$sr" {
        cell.inputs.push(("D", w));
    }
    if kind.contains("dff") {
        control(&mut cell, "CLK", "CLK_POLARITY", 1, true);
    }
    if latch || kind.ends_with('e') {
        control(&mut cell, "EN", "EN_POLARITY", 1, latch);
    }
    if kind.contains("sr") {
        control(&mut cell, "SET", "SET_POLARITY", w, true);
        control(&mut cell, "CLR", "CLR_POLARITY", w, true);
    }
    if kind.starts_with("$ad") {
        control(&mut cell, "ARST", "ARST_POLARITY", 1, true);
        let value = rng.known(w);
        cell.parameters.push(("ARST_VALUE", value));
    } else if kind.starts_with("$sdff") {
        control(&mut cell, "SRST", "SRST_POLARITY", 1, false);
        let value = rng.known(w);
        cell.parameters.push(("SRST_VALUE", value));
    } else if kind.starts_with("$aldff") {
        control(&mut cell, "ALOAD", "ALOAD_POLARITY", 1, true);
        cell.inputs.push(("AD", w));
    }
    if rng.one_in(2) {
        cell.init = Some(rng.known(w));
    }
    cell
}

#[needs(iverilog, yosys)]
#[test]
fn flip_flops_and_latches_of_words() {
    let mut rng = Rng::named("storage");
    let cells: Vec<Cell> =
        CELLS.iter().flat_map(|kind| (0..16).map(move |_| *kind)).map(|k| cell(k, &mut rng)).collect();
    compare("storage", &cells, 200);
}
