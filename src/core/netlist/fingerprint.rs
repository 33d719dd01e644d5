//! A number by which a netlist is known again in another run: saved states tell by it whose they are.

use std::fmt::Write as _;

use super::{Driver, Netlist};
use crate::cell::CellKind;
use crate::digest::Digest;

impl Netlist {
    /// A number that depends on cells, wiring and the names of signals, and not on what memories hold at first. Netlists
    /// loaded from the same file have the same.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        *self.content.fingerprint.get_or_init(|| self.hash())
    }

    fn hash(&self) -> u64 {
        let mut hash = Digest::default();
        // writing into a hash cannot fail
        let mut put = |text: std::fmt::Arguments<'_>| _ = hash.write_fmt(text);
        for net in self.nets() {
            match net.driver {
                Driver::Cell(..) => put(format_args!("n{};", net.width)),
                Driver::Input(signal) => put(format_args!("i{} {};", net.width, signal.index())),
            }
        }
        for id in self.cell_ids() {
            let kind = &self.cell(id).kind;
            match kind {
                CellKind::Memory(m) => {
                    put(format_args!("m{} {} {} {} {:?} {:?}", m.width, m.size, m.offset, m.abits, m.reads, m.writes))
                }
                kind => put(format_args!("{kind:?}")),
            }
            for pin in 0..kind.inputs().len() {
                put(format_args!(","));
                self.input(id, pin).iter().for_each(|s| put(format_args!("{}.{}.{} ", s.net.index(), s.lo, s.width)));
            }
            put(format_args!(";"));
        }
        for id in self.signal_ids() {
            put(format_args!("{}=", self.signal(id).name));
            self.bits(id).iter().for_each(|s| put(format_args!("{}.{}.{} ", s.net.index(), s.lo, s.width)));
        }
        hash.number()
    }
}

#[cfg(test)]
mod tests {
    use crate::netlist::{Builder, Netlist};

    fn netlist(name: &str, other: bool) -> Netlist {
        let mut b = Builder::new("top");
        let (a, clk, y) = (b.input(name, 4), b.input("clk", 1), b.output("y", 4));
        let once = b.not("n1", &a);
        let two = b.not("n2", if other { &a } else { &once });
        b.dff("ff", &clk, &two, &y);
        b.finish().unwrap()
    }

    #[test]
    fn built_twice_it_is_the_same_and_any_change_makes_it_another() {
        assert_eq!(netlist("a", false).fingerprint(), netlist("a", false).fingerprint());
        assert_ne!(netlist("a", false).fingerprint(), netlist("b", false).fingerprint());
        assert_ne!(netlist("a", false).fingerprint(), netlist("a", true).fingerprint());
    }
}
