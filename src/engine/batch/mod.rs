//! The batch engine: one netlist for thousands of stimuli side by side.
//!
//! A lane is one run. Each bit of the netlist is a plane of one bit a lane, and a second plane says in which lanes it is
//! unknown; while it is so in none, operations leave the second planes alone. Lanes stand in blocks that stay in cache.
//! An operation runs when anything that it reads has changed in any lane of the block, in the order that the event
//! engine runs it in. What a cell does to all lanes at once is its meaning in the algebra of lanes (`combine`), compiled
//! for each vector extension and chosen at run time; cells of very many steps are evaluated lane by lane in machine words. Values are those of [`EventEngine`](super::EventEngine) bit for bit.
//!
//! The engine knows no time: who drives it changes inputs, clocks included, and settles. Netlists with delays or
//! memories are not for it.
#![allow(clippy::needless_range_loop, reason = "several planes are gone through side by side")]

mod build;
mod combine;
mod compaction;
#[allow(missing_docs, reason = "shared with sweeps alone")]
mod known;
mod lanes;
mod program;
mod state;

use std::fmt;
use std::sync::Arc;

use lanes::{Chunk, Four, LANES, Plane};
use pulp::{Arch, NullaryFnOnce};
use state::State;

use crate::Value;
use crate::netlist::{NetId, Slice};
use crate::value::Word;
use crate::value::word::words;

pub use compaction::Compaction;
pub use known::{Bits, Lit, Logic, Registers, Rules};
pub use program::Program;

/// The vector extension that is used here.
#[must_use]
pub fn vectors() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    match Arch::new() {
        Arch::V4(_) => return "AVX-512",
        Arch::V3(_) => return "AVX2",
        _ => {}
    }
    "the target's own"
}

/// A set of lanes: bit `n % 64` of word `n / 64` is lane `n`.
pub type LaneSet = Vec<u64>;

/// A block of lanes that run side by side.
///
/// ```
/// # mod discreta {
/// #     pub use discreta_core::*;
/// #     pub mod engine { pub use discreta_engine::*; }
/// # }
/// use discreta::Value;
/// use discreta::engine::batch::{BatchEngine, Program};
/// use discreta::netlist::Builder;
/// use discreta::value::Word;
/// let mut b = Builder::new("top");
/// let (a, y) = (b.input("a", 8), b.output("y", 8));
/// let top = b.top();
/// let negate = discreta::cell::CellKind::Adder { op: discreta::cell::AddOp::Sub, width: 8 };
/// let zero = b.constant(&Value::from_u64(0, 8));
/// b.cell(top, "negate", negate, vec![zero, a], vec![y]);
/// let netlist = b.finish().unwrap();
/// let net = |name| netlist.bits(netlist.find(name).unwrap())[0];
/// let program = std::sync::Arc::new(Program::new(&netlist).unwrap());
/// let mut engine = BatchEngine::new(program, 100);
/// engine.drive_each(net("a").net, |lane| Some(Word::known(lane as u64 & 255)));
/// engine.settle();
/// assert_eq!(engine.value(&[net("y")], 3), Value::from_u64(253, 8));
/// ```
pub struct BatchEngine {
    program: Arc<Program>,
    state: State,
    arch: Arch,
}

impl fmt::Debug for BatchEngine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BatchEngine").field("lanes", &self.lanes()).finish_non_exhaustive()
    }
}

impl BatchEngine {
    /// At least so many lanes, at their start, with nothing settled yet.
    #[must_use]
    pub fn new(program: Arc<Program>, lanes: usize) -> BatchEngine {
        let state = State::new(&program, lanes.div_ceil(LANES).max(1));
        BatchEngine { program, state, arch: Arch::new() }
    }

    /// How many lanes there are.
    #[must_use]
    pub fn lanes(&self) -> usize {
        self.state.lanes()
    }

    /// The words of a [`LaneSet`] here.
    #[must_use]
    pub fn lane_words(&self) -> usize {
        self.lanes() / 64
    }

    /// Puts some lanes back to the start and lets them run. What they are driven by is unknown again.
    pub fn restart(&mut self, lanes: &[u64]) {
        self.state.restart(&self.program, &chunks(lanes));
    }

    /// Stops some lanes: their storage cells see no edges any more.
    pub fn stop(&mut self, lanes: &[u64]) {
        for (active, lanes) in self.state.active.iter_mut().zip(chunks(lanes)) {
            *active = *active & !lanes;
        }
    }

    /// Changes an input in some lanes; it takes effect at the next [`settle`](BatchEngine::settle).
    pub fn drive(&mut self, net: NetId, value: &Value, lanes: &[u64]) {
        let (first, width) = self.program.nets[net.index()];
        if self.state.known.on && !value.is_known() {
            self.state.leave(&self.program);
        }
        if self.state.known.on {
            let mut changed = false;
            let all: Vec<Word> = value.words().collect();
            for i in 0..width {
                let bit = Chunk::splat(combine::bit_of(&all, i).v == 1);
                changed |= self.state.planes.merge(first + i, bit, lanes);
            }
            self.state.known.change(&self.program, net, changed);
            return;
        }
        let lanes = chunks(lanes);
        let all: Vec<Word> = value.words().collect();
        for i in 0..width {
            let new = Four::splat(combine::bit_of(&all, i));
            let plane = self.state.planes.plane::<false>(first + i);
            let changed = self
                .state
                .planes
                .write::<false>(first + i, |c| plane.get(c).within(!lanes[c]).join(new.within(lanes[c])));
            self.state.tell(&self.program, first + i, changed);
        }
    }

    /// Changes an input of at most 64 bits in each lane for which there is a value.
    pub fn drive_each(&mut self, net: NetId, mut value: impl FnMut(usize) -> Option<Word>) {
        self.state.leave(&self.program);
        let (first, width) = self.program.nets[net.index()];
        let mut changed = 0u64;
        for lane in 0..self.lanes() {
            let Some(value) = value(lane) else { continue };
            for i in 0..width {
                let bit = Word { v: value.v >> i, u: value.u >> i };
                changed |= u64::from(self.state.planes.set_lane(first + i, lane, bit)) << i;
            }
        }
        for i in (0..width).filter(|i| changed >> i & 1 != 0) {
            self.state.wake(&self.program, first + i);
        }
    }

    /// Runs an evaluation phase in all lanes until nothing changes. A lane that does not settle is stopped
    /// and is from then on among the [`unsettled`](BatchEngine::unsettled).
    pub fn settle(&mut self) {
        let BatchEngine { program, state, arch } = self;
        if state.known.on && state.settle_known(program, *arch) {
            return;
        }
        arch.dispatch(Settle { program, state });
        state.enter(program);
    }

    /// The lanes that did not settle, or for which that takes too long to be waited for. Their values mean nothing; the
    /// event engine tells.
    #[must_use]
    pub fn unsettled(&self) -> LaneSet {
        self.state.unsettled.iter().flat_map(|c| c.0).collect()
    }

    /// Whether any lane that was not put back since has not settled.
    #[must_use]
    pub fn any_unsettled(&self) -> bool {
        self.state.unsettled.iter().any(|lanes| lanes.any())
    }

    /// Whether it runs in the form for what is all known.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.state.known.on
    }

    /// The value of some bits in a lane, the least significant slice first.
    #[must_use]
    pub fn value(&self, bits: &[Slice], lane: usize) -> Value {
        let width: u32 = bits.iter().map(|s| s.width).sum();
        let mut all = vec![Word::ZERO; words(width)];
        let bits = bits.iter().flat_map(|s| {
            let first = self.program.nets[s.net.index()].0 + s.lo;
            first..first + s.width
        });
        for (i, bit) in bits.enumerate() {
            let w = self.state.planes.lane(bit, lane);
            all[i / 64].v |= w.v << (i % 64);
            all[i / 64].u |= w.u << (i % 64);
        }
        Value::from_words(&all, width)
    }

    /// Keeps of a set the lanes in which some bits have a value.
    pub fn retain_equal(&self, bits: &[Slice], value: &Value, lanes: &mut [u64]) {
        let all: Vec<Word> = value.words().collect();
        let mut at = 0;
        for s in bits {
            let first = self.program.nets[s.net.index()].0 + s.lo;
            for bit in first..first + s.width {
                let wanted = combine::bit_of(&all, at);
                let plane = self.state.planes.plane::<false>(bit);
                for (c, lanes) in lanes.chunks_exact_mut(LANES / 64).enumerate() {
                    let now = plane.get(c);
                    for (i, lanes) in lanes.iter_mut().enumerate() {
                        *lanes &= !(now.v.0[i] ^ wanted.v.wrapping_neg()) & !(now.u.0[i] ^ wanted.u.wrapping_neg());
                    }
                }
                at += 1;
            }
        }
    }

    /// Some bits in a lane as a number, if there are at most 64 and all are known.
    #[must_use]
    pub fn number(&self, bits: &[Slice], lane: usize) -> Option<u64> {
        let (mut number, mut at) = (0, 0);
        for s in bits {
            let first = self.program.nets[s.net.index()].0 + s.lo;
            for bit in first..first + s.width {
                let w = self.state.planes.lane(bit, lane);
                if w.u != 0 || at == 64 {
                    return None;
                }
                number |= w.v << at;
                at += 1;
            }
        }
        Some(number)
    }

    /// Adds to a set the lanes in which a bit is not what is expected: 1 in the lanes of a set, 0 in the others.
    pub fn differ(&self, bit: Slice, expected: &[u64], lanes: &mut [u64]) {
        let bit = self.program.nets[bit.net.index()].0 + bit.lo;
        self.arch.dispatch(Differ { plane: self.state.planes.plane::<false>(bit), expected, lanes });
    }

    /// Takes lanes of another block of the same program, as they stand, if nothing in the lanes of either is x or z, and
    /// says whether it has. Those that run there run here; both have to be settled. The others here are left as they are.
    pub fn adopt(&mut self, from: &BatchEngine, compaction: &Compaction) -> bool {
        self.state.adopt(&self.program, self.arch, &from.state, compaction)
    }

    /// The number of a bit, for [`differ_from`](BatchEngine::differ_from).
    pub fn bit(&self, slice: Slice, at: u32) -> u32 {
        self.program.nets[slice.net.index()].0 + slice.lo + at
    }

    /// Adds to a set the lanes in which a bit is not as a plane of registers is.
    pub fn differ_from(&self, registers: &Registers, pairs: &[(u32, u32)], lanes: &mut [u64]) {
        self.arch.dispatch(DifferFrom { engine: self, registers, pairs, lanes });
    }

    /// How many times [`settle`](BatchEngine::settle) ran in the form for what is all known.
    #[must_use]
    pub fn known_instants(&self) -> u64 {
        self.state.known.instants
    }

    /// Bits evaluated so far, each in all lanes.
    #[must_use]
    pub fn evaluated(&self) -> u64 {
        self.state.evaluated
    }
}

/// An evaluation phase, compiled for each vector extension: what is not inlined into it would not be.
struct Settle<'a> {
    program: &'a Program,
    state: &'a mut State,
}

impl NullaryFnOnce for Settle<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.state.settle(self.program);
    }
}

/// A comparison of a bit with what is expected of it.
struct Differ<'a> {
    plane: Plane<'a, false>,
    expected: &'a [u64],
    lanes: &'a mut [u64],
}

impl NullaryFnOnce for Differ<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let sets = self.expected.chunks_exact(LANES / 64).zip(self.lanes.chunks_exact_mut(LANES / 64));
        for (c, (expected, lanes)) in sets.enumerate() {
            let now = self.plane.get(c);
            for i in 0..LANES / 64 {
                lanes[i] |= (now.v.0[i] ^ expected[i]) | now.u.0[i];
            }
        }
    }
}

/// A comparison of bits with registers beside them.
struct DifferFrom<'a> {
    engine: &'a BatchEngine,
    registers: &'a Registers,
    pairs: &'a [(u32, u32)],
    lanes: &'a mut [u64],
}

impl NullaryFnOnce for DifferFrom<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let planes = &self.engine.state.planes;
        for (c, lanes) in self.lanes.chunks_exact_mut(LANES / 64).enumerate() {
            let mut differ = Chunk::ZERO;
            for &(bit, plane) in self.pairs {
                differ |= planes.raw(bit, c).get() ^ self.registers.plane(plane)[c].get();
                if planes.may_be_unknown(bit) {
                    differ |= planes.plane::<false>(bit).get(c).u;
                }
            }
            lanes.iter_mut().zip(differ.0).for_each(|(lanes, differ)| *lanes |= differ);
        }
    }
}

fn chunks(lanes: &[u64]) -> Vec<Chunk> {
    let chunk = |words: &[u64]| {
        let mut chunk = Chunk::ZERO;
        chunk.0.copy_from_slice(words);
        chunk
    };
    lanes.chunks_exact(LANES / 64).map(chunk).collect()
}
