//! The clocks of a scenario as they go on, for lanes that run in step.

use crate::cell::Clock;
use crate::netlist::NetId;

/// A clock and its next edge.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Source {
    net: NetId,
    clock: Clock,
    high: bool,
    next: u64,
}

/// Clocks at one tick.
#[derive(Clone, Debug)]
pub(super) struct Clocks {
    sources: Vec<Source>,
}

impl Clocks {
    /// The clocks at tick 0.
    pub fn new(clocks: impl Iterator<Item = (NetId, Clock)>) -> Clocks {
        let start = |(net, clock): (NetId, Clock)| {
            let high = clock.phase == 0;
            Source { net, clock, high, next: if high { clock.high } else { clock.phase } }
        };
        Clocks { sources: clocks.map(start).collect() }
    }

    /// The levels.
    pub fn levels(&self) -> impl Iterator<Item = (NetId, bool)> {
        self.sources.iter().map(|s| (s.net, s.high))
    }

    /// The tick of the next edge, if there is a clock.
    pub fn next(&self) -> Option<u64> {
        self.sources.iter().map(|s| s.next).min().filter(|&t| t != u64::MAX)
    }

    /// Makes the edges of a tick; each net and its new level.
    pub fn fire(&mut self, now: u64, mut edge: impl FnMut(NetId, bool)) {
        for s in self.sources.iter_mut().filter(|s| s.next == now) {
            s.high = !s.high;
            s.next = now.saturating_add(if s.high { s.clock.high } else { s.clock.period - s.clock.high });
            edge(s.net, s.high);
        }
    }

    /// If these clocks, which have done their edges up to tick `now`, come by a tick before their next edge at which they
    /// stand to what follows as `other` does at its tick `then`: that tick.
    pub fn meets(&self, now: u64, other: &Clocks, then: u64) -> Option<u64> {
        let first = self.sources.first().zip(other.sources.first())?;
        let at = first.0.next.checked_sub(first.1.next.checked_sub(then)?)?;
        let same = |(a, b): (&Source, &Source)| {
            a.high == b.high && a.next.checked_sub(at).is_some_and(|left| Some(left) == b.next.checked_sub(then))
        };
        (at >= now && self.next().is_some_and(|next| at < next) && self.sources.iter().zip(&other.sources).all(same))
            .then_some(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_meet_where_they_are_in_step() {
        let clocks = || {
            let clock = |period, high, phase| Clock { period, high, phase };
            Clocks::new([(NetId(0), clock(20, 10, 20)), (NetId(1), clock(40, 5, 35))].into_iter())
        };
        // edges of the first at 20, 30, 40 …, of the second at 35, 40, 75, 80 …
        let run = |until: u64| {
            let mut clocks = clocks();
            let mut edges = Vec::new();
            while let Some(t) = clocks.next().filter(|&t| t <= until) {
                clocks.fire(t, |net, level| edges.push((t, net.0, level)));
            }
            (clocks, edges)
        };
        let (other, edges) = run(110);
        assert_eq!(edges[..4], [(20, 0, true), (30, 0, false), (35, 1, true), (40, 0, true)]);
        // at 110 the first is low until 120 and the second until 115: so it is at 30, and in steps of 40 from there
        assert_eq!(run(30).0.meets(30, &other, 110), Some(30));
        assert_eq!(run(20).0.meets(20, &other, 110), None);
        assert_eq!(run(0).0.meets(5, &other, 110), None);
        let (early, _) = run(15);
        assert_eq!(clocks().meets(0, &early, 15), Some(15));
        assert_eq!(run(50).0.meets(50, &other, 110), None);
    }
}
