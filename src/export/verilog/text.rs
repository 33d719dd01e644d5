//! Pieces of wires as Verilog writes them.

use crate::Value;
use crate::netlist::hierarchy::Piece;

/// `width` bits of some pieces from bit `lo` up.
pub(super) fn part(pieces: &[Piece], lo: u32, width: u32) -> Vec<Piece> {
    let (mut skip, mut left) = (lo, width);
    let mut found = Vec::new();
    for piece in pieces {
        let own = piece.width();
        if left == 0 {
            break;
        }
        if skip >= own {
            skip -= own;
            continue;
        }
        let take = (own - skip).min(left);
        found.push(match piece {
            Piece::Wire { wire, lo, .. } => Piece::Wire { wire: *wire, lo: lo + skip, width: take },
            Piece::Constant(value) => Piece::Constant(bits(value, skip, take)),
            Piece::Open(_) => Piece::Open(take),
        });
        left -= take;
        skip = 0;
    }
    found
}

fn bits(value: &Value, lo: u32, width: u32) -> Value {
    let mut part = Value::unknown(width);
    (0..width).for_each(|i| part.set_bit(i, value.bit(lo + i)));
    part
}

pub(super) fn width(pieces: &[Piece]) -> u32 {
    pieces.iter().map(Piece::width).sum()
}

/// A constant: decimal where it is a number that people read, else bit by bit.
pub(super) fn literal(value: &Value) -> String {
    match value.to_u64() {
        Some(n) if value.width() > 1 && value.width() <= 32 => format!("{}'d{n}", value.width()),
        _ => format!("{}'b{}", value.width(), value.bit_string()),
    }
}

/// The range of a declaration, with a blank after it; nothing for one bit.
pub(super) fn range(width: u32) -> String {
    if width == 1 { String::new() } else { format!("[{}:0] ", width - 1) }
}

/// Zeros.
pub(super) fn zeros(width: u32) -> String {
    format!("{width}'d0")
}

/// An expression of one bit repeated.
pub(super) fn repeat(count: u32, bit: &str) -> String {
    if count == 1 { bit.to_owned() } else { format!("{{{count}{{{bit}}}}}") }
}
