//! Nets held at a value whatever drives them, and what may be held or set so.
//!
//! The words are those of IEEE 1364-2005: `force` overrides the driver until `release` (9.3.2), a *deposit* (27.32,
//! `vpiNoDelay`) sets state once. After a release a net has what drives it; storage keeps what it was held at until it
//! samples again, as a variable does there.

use std::fmt;

use crate::cell::CellKind;
use crate::netlist::{Driver, NetId, Netlist, Slice};
use crate::value::Word;

/// Why some bits cannot be forced, or nothing can be deposited in them.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Refused {
    /// Constants decide them, and the engines have built on that.
    Constant(NetId),
    /// They are neither an input nor the state of storage, so there is nothing that would keep what is deposited.
    NoState(NetId),
}

impl Refused {
    /// The same in words.
    #[must_use]
    pub fn text(&self, netlist: &Netlist) -> String {
        match *self {
            Refused::Constant(net) => format!(
                "constants decide `{}`, and the circuit was simplified by that: force what reads it",
                netlist.net_name(net)
            ),
            Refused::NoState(net) => format!(
                "`{}` is neither an input nor storage: nothing would keep the value; force it",
                netlist.net_name(net)
            ),
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::Constant(net) => write!(f, "constants decide net {}", net.index()),
            Refused::NoState(net) => write!(f, "net {} is neither an input nor storage", net.index()),
        }
    }
}

impl std::error::Error for Refused {}

/// Whether a net is the state of a storage cell, or what a port of a memory holds.
pub(crate) fn is_state(netlist: &Netlist, net: NetId) -> bool {
    match netlist.net(net).driver {
        Driver::Cell(cell, 0) => match &netlist.cell(cell).kind {
            CellKind::Memory(memory) => memory.reads.iter().any(|r| r.clock.is_some()),
            kind => kind.init().is_some(),
        },
        _ => false,
    }
}

/// Whether some bits may be forced.
///
/// # Errors
/// If constants decide one of them.
pub(crate) fn may_force(netlist: &Netlist, bits: Slice) -> Result<(), Refused> {
    let constants = netlist.constants();
    let constant = |lo| constants.covers(&Slice { lo, width: 1, ..bits });
    match (bits.lo..bits.lo + bits.width).any(constant) {
        true => Err(Refused::Constant(bits.net)),
        false => Ok(()),
    }
}

/// Whether something may be deposited in some bits.
///
/// # Errors
/// If nothing would keep it.
pub(crate) fn may_deposit(netlist: &Netlist, bits: Slice) -> Result<(), Refused> {
    let kept = matches!(netlist.net(bits.net).driver, Driver::Input(_)) || is_state(netlist, bits.net);
    if kept { Ok(()) } else { Err(Refused::NoState(bits.net)) }
}

/// What one machine word of a net is held at.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Held {
    /// The bits that are.
    pub mask: u64,
    pub value: Word,
    /// What the word would be if it were not.
    pub driver: Word,
}

/// The machine words that some bits of a net lie in: the number of each, the bits in it, and what `value`, whose bit 0 is
/// the lowest of them, has there.
pub(crate) fn spread(bits: Slice, value: &[Word]) -> Vec<(usize, u64, Word)> {
    use crate::value::word::{copy, mask, words};
    let first = bits.lo / 64 * 64;
    let mut all = vec![Word::ZERO; words(bits.lo - first + bits.width)];
    copy(&mut all, bits.lo - first, value, 0, bits.width);
    let end = bits.lo + bits.width;
    let one = |(i, word): (usize, Word)| {
        let at = first + i as u32 * 64;
        let m = mask(end.min(at + 64) - at) & !mask(bits.lo.saturating_sub(at));
        ((at / 64) as usize, m, word)
    };
    all.into_iter().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_over_the_words_that_they_lie_in() {
        let bits = |lo, width| Slice { net: NetId::new(0), lo, width };
        assert_eq!(spread(bits(3, 4), &[Word::known(0b1010)]), [(0, 0b111_1000, Word::known(0b101_0000))]);
        assert_eq!(spread(bits(64, 1), &[Word::x(1)]), [(1, 1, Word::x(1))]);
        let across = spread(bits(60, 70), &[Word::known(0xff), Word::known(0b11_1111)]);
        let high = [(1, u64::MAX, Word::known(0xf | 0b1111 << 60)), (2, 0b11, Word::known(0b11))];
        assert_eq!(across, [vec![(0, 0xf << 60, Word::known(0xf << 60))], high.to_vec()].concat());
    }
}
