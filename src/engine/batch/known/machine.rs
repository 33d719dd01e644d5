//! Runs tapes: a function of three inputs over the planes of a block, one loop for all that follow each other with the
//! same table.

use std::cell::Cell;
use std::ops::Range;

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};

use super::super::lanes::Chunk;
use super::tape::{Instruction, Step, Tape};

/// Times that a loop runs before it is given up.
const PATIENCE: usize = 256;

/// A function of two inputs by its table; bit `2b + c`.
#[inline(always)]
fn two(t: i32, b: Chunk, c: Chunk) -> Chunk {
    match t & 15 {
        0 => Chunk::ZERO,
        1 => !(b | c),
        2 => !b & c,
        3 => !b,
        4 => b & !c,
        5 => !c,
        6 => b ^ c,
        7 => !(b & c),
        8 => b & c,
        9 => !(b ^ c),
        10 => c,
        11 => !b | c,
        12 => b,
        13 => b | !c,
        14 => b | c,
        _ => Chunk::ONES,
    }
}

/// A function of three inputs by its table; bit `4a + 2b + c`. Compilers make one instruction of it where there is one.
#[inline(always)]
fn three<const T: i32>(a: Chunk, b: Chunk, c: Chunk) -> Chunk {
    let (low, high) = (T & 15, T >> 4 & 15);
    match () {
        () if low == high => two(low, b, c),
        () if low == high ^ 15 => a ^ two(low, b, c),
        () if low == 0 => a & two(high, b, c),
        () if high == 0 => !a & two(low, b, c),
        () if high == 15 => a | two(low, b, c),
        () if low == 15 => !a | two(high, b, c),
        () => two(low, b, c) ^ (a & two(low ^ high, b, c)),
    }
}

/// Whether a table depends on an input of this weight.
const fn reads(t: i32, weight: i32) -> bool {
    let mask = [0, 0x55, 0x33, 0, 0x0f][weight as usize];
    t & mask != t >> weight & mask
}

/// Chunks of lanes that a tape goes through at a time: few enough that all that it touches stays in the first cache.
const SPAN: usize = 4;

/// Some of the chunks of all planes.
#[derive(Clone)]
struct Window<'a> {
    planes: &'a [Cell<Chunk>],
    /// Chunks of a plane.
    chunks: usize,
    here: Range<usize>,
}

impl Window<'_> {
    #[inline(always)]
    fn of(&self, plane: u32) -> &[Cell<Chunk>] {
        &self.planes[plane as usize * self.chunks..][self.here.clone()]
    }
}

/// Functions of one table. Compiled for itself: all in one would be too much for a compiler.
struct Run<'a, const T: i32> {
    window: &'a Window<'a>,
    all: &'a [Instruction],
}

impl<const T: i32> NullaryFnOnce for Run<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for &[y, a, b, c] in self.all {
            let [y, a, b, c] = [self.window.of(y), self.window.of(a), self.window.of(b), self.window.of(c)];
            for (((y, a), b), c) in y.iter().zip(a).zip(b).zip(c) {
                let get = |weight: i32, cell: &Cell<Chunk>| if reads(T, weight) { cell.get() } else { Chunk::ZERO };
                y.set(three::<T>(get(4, a), get(2, b), get(1, c)));
            }
        }
    }
}

macro_rules! tables {
    ($($t:literal)*) => {
        /// The tables that tapes are made of: of each set that are alike but for the order of inputs, the least.
        #[cfg(test)]
        pub(super) const TABLES: &[u8] = &[$($t),*];

        fn dispatch<S: Simd>(simd: S, window: &Window<'_>, tape: &Tape, runs: Range<usize>, first: usize) {
            let mut rest = &tape.instructions[first..];
            for &(table, count) in &tape.runs[runs] {
                let (all, after) = rest.split_at(count as usize);
                rest = after;
                match table {
                    $($t => simd.vectorize(Run::<$t> { window, all }),)*
                    _ => {}
                }
            }
        }
    };
}

tables! {
    0x00 0x01 0x02 0x03 0x06 0x07 0x08 0x09 0x0b 0x0c 0x0e 0x0f 0x16 0x17 0x18 0x19 0x1a 0x1b 0x1e 0x1f
    0x28 0x29 0x2a 0x2b 0x2c 0x2d 0x2e 0x2f 0x3c 0x3d 0x3e 0x3f 0x68 0x69 0x6a 0x6b 0x6e 0x6f 0x7e 0x7f
    0x80 0x81 0x82 0x83 0x86 0x87 0x89 0x8a 0x8b 0x8e 0x8f 0x96 0x97 0x98 0x9a 0x9b 0x9e 0x9f 0xa8 0xa9
    0xab 0xac 0xad 0xae 0xbc 0xbd 0xbe 0xbf 0xc0 0xc3 0xcf 0xe8 0xe9 0xea 0xeb 0xef 0xf0 0xfc 0xfe 0xff
}

/// A tape that runs over a block.
struct Running<'a, S> {
    simd: S,
    planes: &'a [Cell<Chunk>],
    chunks: usize,
    tape: &'a Tape,
    active: &'a [Chunk],
}

impl<S: Simd> Running<'_, S> {
    fn part(&self, runs: Range<usize>, first: usize) {
        for from in (0..self.chunks).step_by(SPAN) {
            let here = from..self.chunks.min(from + SPAN);
            let window = Window { planes: self.planes, chunks: self.chunks, here };
            dispatch(self.simd, &window, self.tape, runs.clone(), first);
        }
    }

    /// Whether any copy differs from its plane in a lane that runs; they are the same then.
    fn commit(&self, pairs: &[(u32, u32)]) -> bool {
        let mut moved = Chunk::ZERO;
        for &(copy, plane) in pairs {
            for c in 0..self.chunks {
                let [copy, plane] = [copy, plane].map(|plane| &self.planes[plane as usize * self.chunks + c]);
                moved |= (copy.get() ^ plane.get()) & self.active[c];
                plane.set(copy.get());
            }
        }
        moved.any()
    }

    /// Whether its loops settle.
    fn play(&self) -> bool {
        let mut first = 0;
        for step in &self.tape.steps {
            let (Step::Straight(runs) | Step::Loop(runs, _)) = step;
            let count: usize = self.tape.runs[runs.clone()].iter().map(|r| r.1 as usize).sum();
            match step {
                Step::Straight(runs) => self.part(runs.clone(), first),
                Step::Loop(runs, pairs) => {
                    let mut left = PATIENCE;
                    loop {
                        self.part(runs.clone(), first);
                        if !self.commit(pairs) {
                            break;
                        }
                        left -= 1;
                        if left == 0 {
                            return false;
                        }
                    }
                }
            }
            first += count;
        }
        true
    }
}

/// A tape, before it is known what runs it.
struct Play<'a> {
    planes: &'a [Cell<Chunk>],
    chunks: usize,
    tape: &'a Tape,
    active: &'a [Chunk],
}

impl WithSimd for Play<'_> {
    type Output = bool;

    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Play { planes, chunks, tape, active } = self;
        Running { simd, planes, chunks, tape, active }.play()
    }
}

/// Runs a tape. Whether its loops settle in all lanes that run.
pub(super) fn play(arch: Arch, tape: &Tape, planes: &[Cell<Chunk>], chunks: usize, active: &[Chunk]) -> bool {
    arch.dispatch(Play { planes, chunks, tape, active })
}
