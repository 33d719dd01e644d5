//! Registers over lanes that go on by functions of themselves: what an algorithm keeps and does, beside a circuit.

use std::cell::Cell;

use pulp::Arch;

use super::logic::{Lit, Logic};
use super::machine::play;
use super::tape::{Part, Tape, emit};
use crate::batch::lanes::{Chunk, LANES};

/// A word of a function: its bits, the least significant first.
pub type Bits = Vec<Lit>;

/// What registers go on by, and what else is to be seen of them.
pub struct Rules<'r> {
    /// Their widths.
    pub widths: &'r [u32],
    /// What each is after a clock.
    pub next: &'r dyn Fn(&mut Logic, &[Bits]) -> Vec<Bits>,
    /// What is shown of them: functions of one bit.
    pub shown: &'r dyn Fn(&mut Logic, &[Bits]) -> Vec<Lit>,
}

/// Registers in all lanes of a block.
#[derive(Debug)]
pub struct Registers {
    planes: Vec<Cell<Chunk>>,
    chunks: usize,
    /// First plane and width of each.
    places: Vec<(u32, u32)>,
    /// The first plane of what is shown.
    shown: u32,
    step: Tape,
    show: Tape,
    all: Vec<Chunk>,
    arch: Arch,
}

/// The plane that is 0 in all lanes and that is 1 in all.
const FIXED: u32 = 2;

impl Registers {
    pub fn new(rules: &Rules<'_>, lanes: usize) -> Registers {
        let chunks = lanes.div_ceil(LANES);
        let mut places = Vec::new();
        let mut first = FIXED;
        for &width in rules.widths {
            places.push((first, width));
            first += width;
        }
        let mut shows = 0;
        let mut tape = |steps: bool| {
            let mut logic = Logic::default();
            let now = places.iter().map(|&(at, width)| (at..at + width).map(|plane| logic.source(plane)).collect());
            let mut now: Vec<Bits> = now.collect();
            let mut roots = Vec::new();
            if steps {
                now = (rules.next)(&mut logic, &now);
                for (bits, &(at, _)) in now.iter().zip(&places) {
                    roots.extend(bits.iter().copied().zip(at..));
                }
            }
            let shown = (rules.shown)(&mut logic, &now);
            shows = shown.len() as u32;
            roots.extend(shown.into_iter().zip(first..));
            let end = logic.nodes.len();
            emit(&logic, vec![Part { end, roots, pairs: None }], true, first + shows)
        };
        let (step, show) = (tape(true), tape(false));
        let planes = (first + shows + step.scratch.max(show.scratch)) as usize;
        let planes = vec![Cell::new(Chunk::ZERO); planes * chunks];
        planes[chunks..2 * chunks].iter().for_each(|c| c.set(Chunk::ONES));
        let all = vec![Chunk::ONES; chunks];
        Registers { planes, chunks, places, shown: first, step, show, all, arch: Arch::new() }
    }

    /// A clock in all lanes.
    pub fn step(&self) {
        play(self.arch, &self.step, &self.planes, self.chunks, &self.all);
    }

    /// Shows what has been put into the registers.
    pub fn show(&self) {
        play(self.arch, &self.show, &self.planes, self.chunks, &self.all);
    }

    /// Puts a number into a register of one lane.
    pub fn put(&self, register: usize, lane: usize, value: u64) {
        let (first, width) = self.places[register];
        for i in 0..width {
            let plane = &self.planes[(first + i) as usize * self.chunks + lane / LANES];
            let mut chunk = plane.get();
            let (word, bit) = (lane % LANES / 64, 1 << (lane % 64));
            chunk.0[word] = chunk.0[word] & !bit | (value >> i & 1) << (lane % 64);
            plane.set(chunk);
        }
    }

    /// The plane of a bit of a register.
    pub fn bit(&self, register: usize, bit: u32) -> u32 {
        self.places[register].0 + bit
    }

    /// The plane of what is shown as number `number`.
    pub fn shown(&self, number: usize) -> u32 {
        self.shown + number as u32
    }

    /// A bit of a lane.
    pub fn lane(&self, plane: u32, lane: usize) -> bool {
        self.planes[plane as usize * self.chunks + lane / LANES].get().0[lane % LANES / 64] >> (lane % 64) & 1 == 1
    }

    /// A plane.
    #[inline(always)]
    pub(in crate::batch) fn plane(&self, plane: u32) -> &[Cell<Chunk>] {
        &self.planes[plane as usize * self.chunks..][..self.chunks]
    }
}
