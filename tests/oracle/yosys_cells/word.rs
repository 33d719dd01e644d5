//! Combinational cells of words.

use discreta::Value;
use needs::needs;

use super::batch::{Cell, compare};
use crate::support::Rng;

/// What is compared here.
pub const CELLS: &[&str] = &[
    "$not",
    "$pos",
    "$neg",
    "$buf",
    "$reduce_and",
    "$reduce_or",
    "$reduce_xor",
    "$reduce_xnor",
    "$reduce_bool",
    "$logic_not",
    "$and",
    "$or",
    "$xor",
    "$xnor",
    "$shl",
    "$shr",
    "$sshl",
    "$sshr",
    "$shift",
    "$shiftx",
    "$lt",
    "$le",
    "$eq",
    "$ne",
    "$eqx",
    "$nex",
    "$ge",
    "$gt",
    "$add",
    "$sub",
    "$mul",
    "$div",
    "$mod",
    "$divfloor",
    "$modfloor",
    "$pow",
    "$logic_and",
    "$logic_or",
    "$slice",
    "$concat",
    "$lut",
    "$sop",
    "$bweqx",
    "$bwmux",
    "$mux",
    "$pmux",
    "$bmux",
    "$demux",
    "$fa",
    "$lcu",
    "$alu",
    "$tribuf",
    "$macc",
    "$macc_v2",
    "$barrier",
];

/// Cells of each type, and vectors for each cell.
const EACH: usize = 40;
const VECTORS: usize = 24;

/// 1 to 70, often small, often about 64.
fn width(rng: &mut Rng) -> u32 {
    match rng.below(4) {
        0 => 1 + rng.below(4) as u32,
        1 => 60 + rng.below(11) as u32,
        _ => 1 + rng.below(70) as u32,
    }
}

fn unary(kind: &str, rng: &mut Rng) -> Cell {
    let (a, y, signed) = (width(rng), width(rng), rng.one_in(2));
    let cell = Cell::new(kind, &[("A", a)], &[("Y", y)]);
    cell.flag("A_SIGNED", signed).number("A_WIDTH", a.into()).number("Y_WIDTH", y.into())
}

fn binary(kind: &str, rng: &mut Rng) -> Cell {
    let (a, mut b, y) = (width(rng), width(rng), width(rng));
    let (mut a_signed, mut b_signed) = (rng.one_in(2), rng.one_in(2));
    if rng.one_in(2) {
        (a_signed, b_signed) = (true, true);
    }
    let shifts = matches!(kind, "$shl" | "$shr" | "$sshl" | "$sshr" | "$shift" | "$shiftx");
    if shifts && !rng.one_in(6) || kind == "$pow" {
        b = 1 + rng.below(8) as u32;
    }
    if shifts && kind != "$shift" && kind != "$shiftx" {
        b_signed = false;
    }
    let mut cell = Cell::new(kind, &[("A", a), ("B", b)], &[("Y", y)]);
    if matches!(kind, "$eq" | "$ne" | "$eqx" | "$nex" | "$lt" | "$le" | "$gt" | "$ge") {
        // by chance alone they would never be equal
        let known = rng.known(a.min(b));
        let common = if rng.one_in(2) { known } else { rng.four_valued(a.min(b), 5) };
        for (port, width) in [("A", a), ("B", b)] {
            let mut value = Value::from_u64(0, width);
            (0..common.width()).for_each(|i| value.set_bit(i, common.bit(i)));
            cell.likely.push((port, value));
        }
    }
    if matches!(kind, "$div" | "$mod" | "$divfloor" | "$modfloor") {
        if a.max(b).max(y) >= 64 {
            cell.model = Some(match kind {
                "$div" => "long_division",
                "$mod" => "long_division REST",
                "$divfloor" => "long_division FLOOR",
                _ => "long_division FLOOR REST",
            });
        }
        let mut least = Value::from_u64(0, a);
        least.set_bit(a - 1, discreta::Logic::One);
        cell.likely.push(("A", least));
        cell.likely.push(("B", Value::from_i64(-1, b)));
        cell.likely.push(("B", Value::from_u64(rng.below(9), b)));
    }
    cell.flag("A_SIGNED", a_signed)
        .flag("B_SIGNED", b_signed)
        .number("A_WIDTH", a.into())
        .number("B_WIDTH", b.into())
        .number("Y_WIDTH", y.into())
}

/// The widths of some pieces, one after another in 16 bits each.
fn widths(pieces: &[u32]) -> Value {
    let mut value = Value::from_u64(0, 16 * pieces.len().max(1) as u32);
    for (i, &piece) in pieces.iter().enumerate() {
        let piece = Value::from_u64(piece.into(), 16);
        (0..16).for_each(|k| value.set_bit(16 * i as u32 + k, piece.bit(k)));
    }
    value
}

fn macc(rng: &mut Rng) -> Cell {
    let (ports, size, y, b) = (1 + rng.below(4), 4 + rng.below(3), width(rng), 1 + rng.below(4));
    let mut config: Vec<bool> = (0..4).map(|i| size >> i & 1 == 1).collect();
    let mut a = 0;
    for _ in 0..ports {
        config.extend([rng.one_in(2), rng.one_in(2)]);
        for n in [1 + rng.below(14), rng.below(2) * (1 + rng.below(14))] {
            config.extend((0..size).map(|i| n >> i & 1 == 1));
            a += n as u32;
        }
    }
    let mut bits = Value::from_u64(0, config.len() as u32);
    config.iter().enumerate().filter(|c| *c.1).for_each(|(i, _)| bits.set_bit(i as u32, discreta::Logic::One));
    let cell = Cell::new("$macc", &[("A", a), ("B", b as u32)], &[("Y", y)]);
    let cell = cell.number("A_WIDTH", a.into()).number("B_WIDTH", b).number("Y_WIDTH", y.into());
    cell.number("CONFIG_WIDTH", bits.width().into()).with("CONFIG", bits)
}

fn macc_v2(rng: &mut Rng) -> Cell {
    let mut pieces = |least| (0..least + rng.below(3)).map(|_| 1 + rng.below(20) as u32).collect::<Vec<u32>>();
    let (a, c) = (pieces(1), pieces(1));
    let b: Vec<u32> = a.iter().map(|_| 1 + rng.below(20) as u32).collect();
    let (products, addends, y) = (a.len() as u32, c.len() as u32, width(rng));
    let total = |list: &[u32]| list.iter().sum::<u32>();
    let cell = Cell::new("$macc_v2", &[("A", total(&a)), ("B", total(&b)), ("C", total(&c))], &[("Y", y)]);
    let cell = cell.number("NPRODUCTS", products.into()).number("NADDENDS", addends.into()).number("Y_WIDTH", y.into());
    let cell = cell.with("A_WIDTHS", widths(&a)).with("B_WIDTHS", widths(&b)).with("C_WIDTHS", widths(&c));
    let cell = cell.with("A_SIGNED", rng.known(products)).with("B_SIGNED", rng.known(products));
    let cell = cell.with("C_SIGNED", rng.known(addends));
    let cell = cell.with("PRODUCT_NEGATED", rng.known(products)).with("ADDEND_NEGATED", rng.known(addends));
    // for the model, which cannot add widths up in its header
    cell.number("A_TOTAL", total(&a).into()).number("B_TOTAL", total(&b).into()).number("C_TOTAL", total(&c).into())
}

pub fn cell(kind: &str, rng: &mut Rng) -> Cell {
    let w = width(rng);
    let n = u64::from(w);
    match kind {
        "$slice" => {
            let offset = rng.below(n);
            let y = 1 + rng.below(n - offset);
            let cell = Cell::new(kind, &[("A", w)], &[("Y", y as u32)]);
            cell.number("OFFSET", offset).number("A_WIDTH", n).number("Y_WIDTH", y)
        }
        "$concat" => {
            let b = width(rng);
            let cell = Cell::new(kind, &[("A", w), ("B", b)], &[("Y", w + b)]);
            cell.number("A_WIDTH", n).number("B_WIDTH", b.into())
        }
        "$lut" => {
            let a = 1 + rng.below(8) as u32;
            let table = if rng.one_in(2) { rng.known(1 << a) } else { Value::from_i64(-1, 1 << a) };
            Cell::new(kind, &[("A", a)], &[("Y", 1)]).number("WIDTH", a.into()).with("LUT", table)
        }
        "$sop" => {
            let depth = 1 + rng.below(4) as u32;
            let mut table = rng.known(2 * w * depth);
            if rng.one_in(2) {
                // few literals, so that some product holds
                (0..table.width()).filter(|_| !rng.one_in(8)).for_each(|i| table.set_bit(i, discreta::Logic::Zero));
            }
            let cell = Cell::new(kind, &[("A", w)], &[("Y", 1)]);
            cell.number("WIDTH", n).number("DEPTH", depth.into()).with("TABLE", table)
        }
        "$bweqx" => {
            let mut cell = Cell::new(kind, &[("A", w), ("B", w)], &[("Y", w)]).number("WIDTH", n);
            let common = rng.four_valued(w, 3);
            cell.likely = vec![("A", common.clone()), ("B", common)];
            cell
        }
        "$barrier" => Cell::new(kind, &[("A", w)], &[("Y", w)]).number("WIDTH", n),
        "$bwmux" => Cell::new(kind, &[("A", w), ("B", w), ("S", w)], &[("Y", w)]).number("WIDTH", n),
        "$mux" => Cell::new(kind, &[("A", w), ("B", w), ("S", 1)], &[("Y", w)]).number("WIDTH", n),
        "$tribuf" => Cell::new(kind, &[("A", w), ("EN", 1)], &[("Y", w)]).number("WIDTH", n),
        "$pmux" => {
            let most = if rng.one_in(8) { 70 } else { 6 };
            let s = 1 + rng.below(most) as u32;
            let mut cell = Cell::new(kind, &[("A", w), ("B", w * s), ("S", s)], &[("Y", w)]);
            let line = |k: u64| {
                let mut value = Value::from_u64(0, s);
                value.set_bit(k as u32, discreta::Logic::One);
                ("S", value)
            };
            cell.likely = vec![("S", Value::from_u64(0, s)), line(rng.below(s.into())), line(u64::from(s) - 1)];
            cell.number("WIDTH", n).number("S_WIDTH", s.into())
        }
        "$bmux" | "$demux" => {
            let s = 1 + rng.below(4) as u32;
            let (wide, ports) = (w << s, [("A", w), ("S", s)]);
            let cell = if kind == "$bmux" {
                let mut cell = Cell::new(kind, &[("A", wide), ("S", s)], &[("Y", w)]);
                cell.likely.push(("A", Value::from_i64(-1, wide)));
                cell
            } else {
                Cell::new(kind, &ports, &[("Y", wide)])
            };
            cell.number("WIDTH", n).number("S_WIDTH", s.into())
        }
        "$fa" => Cell::new(kind, &[("A", w), ("B", w), ("C", w)], &[("X", w), ("Y", w)]).number("WIDTH", n),
        "$lcu" => Cell::new(kind, &[("P", w), ("G", w), ("CI", 1)], &[("CO", w)]).number("WIDTH", n),
        "$alu" => {
            let (a, b) = (width(rng), width(rng));
            let (a_signed, b_signed) = (rng.one_in(2), rng.one_in(2));
            let cell = Cell::new(kind, &[("A", a), ("B", b), ("CI", 1), ("BI", 1)], &[("X", w), ("Y", w), ("CO", w)]);
            let cell = cell.flag("A_SIGNED", a_signed).flag("B_SIGNED", b_signed || a_signed && !rng.one_in(3));
            cell.number("A_WIDTH", a.into()).number("B_WIDTH", b.into()).number("Y_WIDTH", n)
        }
        "$macc" => macc(rng),
        "$macc_v2" => macc_v2(rng),
        "$not" | "$pos" | "$neg" | "$buf" | "$logic_not" => unary(kind, rng),
        reduce if reduce.starts_with("$reduce") => unary(kind, rng),
        _ => binary(kind, rng),
    }
}

fn compare_some(name: &str, kinds: &[&str]) {
    let mut rng = Rng::named(name);
    let cells: Vec<Cell> =
        kinds.iter().flat_map(|kind| (0..EACH).map(move |_| *kind)).map(|k| cell(k, &mut rng)).collect();
    compare(name, &cells, VECTORS);
}

#[needs(iverilog, yosys)]
#[test]
fn bitwise_and_logical_cells() {
    compare_some("bitwise", &CELLS[..14]);
}

#[needs(iverilog, yosys)]
#[test]
fn shifts_and_comparisons() {
    compare_some("shifts", &CELLS[14..28]);
}

#[needs(iverilog, yosys)]
#[test]
fn arithmetic() {
    compare_some("arithmetic", &CELLS[28..38]);
}

#[needs(iverilog, yosys)]
#[test]
fn choices_and_carries() {
    compare_some("choices", &CELLS[38..]);
}
