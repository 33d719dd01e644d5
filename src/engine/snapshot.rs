//! The whole state of a run, saved from one engine and restored into any other of the same netlist.
//!
//! Everything is kept in the netlist's own numbers (nets, cells, control pins in their order), not in those of an engine.

use std::fmt;

use crate::cell::Clock;
use crate::digest::Digest;
use crate::force::Held;
use crate::netlist::{CellId, NetId, Netlist};
use crate::value::Word;

/// A clock that an engine drives, as it stands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct RunningClock {
    pub net: NetId,
    pub clock: Clock,
    pub high: bool,
    /// The tick of its next edge.
    pub next: u64,
}

/// What a delay holds.
#[derive(Clone, Default, PartialEq, Eq, Debug)]
pub(crate) struct DelayLine {
    /// The input as last seen.
    pub seen: Vec<Word>,
    /// The state of an RC delay.
    pub rc: [u64; 8],
    /// Ticks of the changes on their way, and their values one after another.
    pub times: Vec<u64>,
    /// Ticks at which there may be something to do.
    pub due: Vec<u64>,
    pub values: Vec<Word>,
}

/// The whole state of a run: time, every net, what memories hold, clocks, delays and forces.
///
/// It is saved and restored by [`Engine::save`](crate::Engine::save) and [`Engine::restore`](crate::Engine::restore), and
/// written to and read from bytes. What is observed or traced is not part of it.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Snapshot {
    pub(crate) netlist: u64,
    pub(crate) now: u64,
    /// Whether there has been a phase.
    pub(crate) started: bool,
    /// Whether nothing has been driven, forced or deposited since the last phase.
    pub(crate) settled: bool,
    /// Clock pins that are another now than when edges were last looked for: the net, the bit, and what it was.
    pub(crate) edges: Vec<(NetId, u32, Word)>,
    /// The words of all nets, one net after another.
    pub(crate) nets: Vec<Word>,
    /// What memories hold, by cell.
    pub(crate) contents: Vec<(CellId, Vec<Word>)>,
    pub(crate) clocks: Vec<RunningClock>,
    pub(crate) delays: Vec<DelayLine>,
    /// For each control pin whether it has been known.
    pub(crate) control_seen: Vec<bool>,
    /// For each cell whether an unknown control of it has been reported.
    pub(crate) reported: Vec<bool>,
    /// Nets, the number of a word in each, and what it is held at.
    pub(crate) forces: Vec<(NetId, u32, Held)>,
}

impl Snapshot {
    /// The tick at which it was saved.
    #[must_use]
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Whether it is of this netlist, or one built alike.
    #[must_use]
    pub fn is_of(&self, netlist: &Netlist) -> bool {
        self.netlist == netlist.fingerprint()
    }

    /// As bytes, the same on every machine.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut w = Writer(MAGIC.to_vec());
        w.number(self.netlist);
        w.number(self.now);
        w.number(self.started.into());
        w.number(self.settled.into());
        w.list(&self.edges, |w, (net, bit, old)| {
            [net.index() as u64, (*bit).into()].into_iter().for_each(|n| w.number(n));
            w.word(*old);
        });
        w.words(&self.nets);
        w.list(&self.contents, |w, (cell, words)| {
            w.number(cell.index() as u64);
            w.words(words);
        });
        w.list(&self.clocks, |w, c| {
            let Clock { period, high, phase } = c.clock;
            [c.net.index() as u64, period, high, phase, c.high.into(), c.next].into_iter().for_each(|n| w.number(n));
        });
        w.list(&self.delays, |w, d| {
            w.words(&d.seen);
            d.rc.into_iter().for_each(|n| w.number(n));
            w.list(&d.times, |w, &t| w.number(t));
            w.list(&d.due, |w, &t| w.number(t));
            w.words(&d.values);
        });
        w.list(&self.control_seen, |w, &b| w.0.push(b.into()));
        w.list(&self.reported, |w, &b| w.0.push(b.into()));
        w.list(&self.forces, |w, (net, word, held)| {
            [net.index() as u64, (*word).into(), held.mask].into_iter().for_each(|n| w.number(n));
            [held.value, held.driver].into_iter().for_each(|word| w.word(word));
        });
        let sum = checksum(&w.0);
        w.number(sum);
        w.0
    }

    /// From bytes.
    ///
    /// # Errors
    /// If they are none that [`to_bytes`](Snapshot::to_bytes) gave, or not all of them, or changed ones.
    pub fn from_bytes(bytes: &[u8]) -> Result<Snapshot, SnapshotError> {
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            let other = bytes.starts_with(&MAGIC[..MAGIC.len() - 2]);
            return Err(if other { SnapshotError::Version } else { SnapshotError::NoSnapshot });
        };
        let (rest, sum) = rest.split_last_chunk::<8>().ok_or(SnapshotError::Damaged)?;
        if u64::from_le_bytes(*sum) != checksum(&bytes[..bytes.len() - 8]) {
            return Err(SnapshotError::Damaged);
        }
        Reader(rest).snapshot().ok_or(SnapshotError::Damaged)
    }

    /// Whether it fits a netlist: nothing in it is of a net or cell that is not there.
    pub(crate) fn check(&self, netlist: &Netlist) -> Result<(), SnapshotError> {
        let words = |width| crate::value::word::words(width);
        let fits = self.nets.len() == netlist.nets().iter().map(|n| words(n.width)).sum::<usize>()
            && self.contents.iter().all(|(cell, held)| {
                netlist
                    .cells()
                    .get(cell.index())
                    .is_some_and(|c| matches!(&c.kind, crate::cell::CellKind::Memory(m) if m.init.len() == held.len()))
            })
            && self.clocks.iter().all(|c| c.net.index() < netlist.nets().len() && c.clock.high < c.clock.period)
            && self.edges.iter().all(|(net, ..)| net.index() < netlist.nets().len())
            && self.reported.len() <= netlist.cells().len()
            && self.forces.iter().all(|(net, word, _)| {
                netlist.nets().get(net.index()).is_some_and(|n| (*word as usize) < words(n.width))
            });
        if self.is_of(netlist) && fits { Ok(()) } else { Err(SnapshotError::OtherNetlist) }
    }
}

/// Why a saved state cannot be restored.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum SnapshotError {
    /// It is no saved state.
    NoSnapshot,
    /// It was written by another version.
    Version,
    /// It is cut off, or changed.
    Damaged,
    /// It is of another circuit, or of this with other parameters.
    OtherNetlist,
}

impl fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SnapshotError::NoSnapshot => "it is no saved state",
            SnapshotError::Version => "it is a saved state of another version: save it again",
            SnapshotError::Damaged => "it is a saved state that is cut off or changed: save it again",
            SnapshotError::OtherNetlist => {
                "it is of another circuit, or of this one with other parameters: restore it into the one that was saved"
            }
        })
    }
}

impl std::error::Error for SnapshotError {}

/// How a saved state begins; the last but one byte is the version.
const MAGIC: &[u8] = b"discreta state 1\n";

fn checksum(bytes: &[u8]) -> u64 {
    let mut digest = Digest::default();
    digest.bytes(bytes);
    digest.number()
}

/// Little-endian numbers, lists with their lengths before them.
struct Writer(Vec<u8>);

impl Writer {
    fn number(&mut self, n: u64) {
        self.0.extend(n.to_le_bytes());
    }

    fn word(&mut self, word: Word) {
        self.number(word.v);
        self.number(word.u);
    }

    fn list<T>(&mut self, list: &[T], one: impl Fn(&mut Writer, &T)) {
        self.number(list.len() as u64);
        list.iter().for_each(|item| one(self, item));
    }

    fn words(&mut self, words: &[Word]) {
        self.list(words, |w, &word| w.word(word));
    }
}

struct Reader<'b>(&'b [u8]);

impl Reader<'_> {
    fn number(&mut self) -> Option<u64> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*first))
    }

    fn flag(&mut self) -> Option<bool> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first != 0)
    }

    fn word(&mut self) -> Option<Word> {
        Some(Word { v: self.number()?, u: self.number()? })
    }

    /// A list of items of at least `least` bytes: a length that cannot be is found before room is made for it.
    fn list<T>(&mut self, least: u64, one: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let n = self.number()?;
        if n.checked_mul(least)? > self.0.len() as u64 {
            return None;
        }
        (0..n).map(|_| one(self)).collect()
    }

    fn words(&mut self) -> Option<Vec<Word>> {
        self.list(16, Reader::word)
    }

    fn net(&mut self) -> Option<NetId> {
        Some(NetId(u32::try_from(self.number()?).ok()?))
    }

    fn snapshot(&mut self) -> Option<Snapshot> {
        let (netlist, now, started) = (self.number()?, self.number()?, self.number()? != 0);
        let settled = self.number()? != 0;
        let edges = self.list(32, |r| Some((r.net()?, u32::try_from(r.number()?).ok()?, r.word()?)))?;
        let nets = self.words()?;
        let contents = self.list(16, |r| Some((CellId(u32::try_from(r.number()?).ok()?), r.words()?)))?;
        let clocks = self.list(48, |r| {
            let net = r.net()?;
            let clock = Clock { period: r.number()?, high: r.number()?, phase: r.number()? };
            Some(RunningClock { net, clock, high: r.number()? != 0, next: r.number()? })
        })?;
        let delays = self.list(96, |r| {
            let seen = r.words()?;
            let mut rc = [0; 8];
            for n in &mut rc {
                *n = r.number()?;
            }
            Some(DelayLine {
                seen,
                rc,
                times: r.list(8, Reader::number)?,
                due: r.list(8, Reader::number)?,
                values: r.words()?,
            })
        })?;
        let control_seen = self.list(1, Reader::flag)?;
        let reported = self.list(1, Reader::flag)?;
        let forces = self.list(56, |r| {
            let (net, word, mask) = (r.net()?, u32::try_from(r.number()?).ok()?, r.number()?);
            Some((net, word, Held { mask, value: r.word()?, driver: r.word()? }))
        })?;
        self.0.is_empty().then_some(Snapshot {
            netlist,
            now,
            started,
            settled,
            edges,
            nets,
            contents,
            clocks,
            delays,
            control_seen,
            reported,
            forces,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Snapshot {
        let clock = RunningClock { net: NetId(3), clock: Clock { period: 4, high: 1, phase: 2 }, high: true, next: 9 };
        let held = Held { mask: 5, value: Word::x(1), driver: Word::known(4) };
        Snapshot {
            netlist: 7,
            now: 8,
            started: true,
            settled: true,
            edges: vec![(NetId(1), 3, Word::x(1))],
            nets: vec![Word::known(1), Word::z(3)],
            contents: vec![(CellId(2), vec![Word::x(9)])],
            clocks: vec![clock],
            delays: vec![DelayLine {
                seen: vec![Word::ZERO],
                rc: [1; 8],
                times: vec![4],
                due: vec![4, 6],
                values: vec![Word::x(2)],
            }],
            control_seen: vec![true, false],
            reported: vec![false],
            forces: vec![(NetId(1), 0, held)],
        }
    }

    #[test]
    fn bytes_give_back_what_was_written() {
        for snapshot in [sample(), Snapshot::default()] {
            assert_eq!(Snapshot::from_bytes(&snapshot.to_bytes()), Ok(snapshot));
        }
    }

    #[test]
    fn no_damage_goes_unseen() {
        let bytes = sample().to_bytes();
        for at in 0..bytes.len() {
            assert!(Snapshot::from_bytes(&bytes[..at]).is_err(), "cut off at {at}");
            let mut changed = bytes.clone();
            changed[at] ^= 0x41;
            assert!(Snapshot::from_bytes(&changed).is_err(), "changed at {at}");
        }
        assert_eq!(Snapshot::from_bytes(b"discreta state 2\n"), Err(SnapshotError::Version));
        assert_eq!(Snapshot::from_bytes(b"$date"), Err(SnapshotError::NoSnapshot));
    }
}
