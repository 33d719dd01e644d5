//! Algorithms over lanes: registers that all lanes of a block have, and what a clock makes of them.
//!
//! Each is the algorithm of the interpolator room once more, in bits; the tests here hold it to that, clock by clock.

use crate::engine::batch::{Bits, Lit, Logic, Registers, Rules};
use crate::interpolate::{InputError, LineInput, Method, Options};

/// What is compared of an algorithm.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum What {
    At(usize),
    Left(usize),
    Sum(usize),
    End,
    Step(usize),
}

/// An algorithm in the lanes of a block.
#[derive(Debug)]
pub(super) struct Model {
    pub registers: Registers,
    bits: u32,
    centred: bool,
}

/// Registers of the line: the coordinates, the steps left, `F`, the increments.
const XT: usize = 0;
const YT: usize = 1;
const KOX: usize = 2;
const KOY: usize = 3;
const F: usize = 4;
const DX: usize = 5;
const DY: usize = 6;

/// Whether the end is reached, and which steps the next clock makes.
fn line_steps(l: &mut Logic, now: &[Bits]) -> [Lit; 3] {
    let [x_left, y_left] = [KOX, KOY].map(|left| l.any(&now[left]));
    let negative = now[F].last().copied().unwrap_or(Lit::FALSE);
    let run = l.or(x_left, y_left);
    [!run, l.and(x_left, !negative), l.and(y_left, negative)]
}

/// The line by evaluation function, one clock.
fn line(l: &mut Logic, now: &[Bits]) -> Vec<Bits> {
    let [end, x, y] = line_steps(l, now);
    let negative = now[F].last().copied().unwrap_or(Lit::FALSE);
    let zeros = vec![Lit::FALSE; 64];
    let ones = |l: &mut Logic, bits: &Bits, minus: Lit| {
        let all = vec![minus; bits.len()];
        l.add(bits, &all, Lit::FALSE).0
    };
    let up = |l: &mut Logic, bits: &Bits, step: Lit| l.add(bits, &zeros[..bits.len()], step).0;
    // F < 0 adds ΔX, else -ΔY is added
    let back = l.and(!end, !negative);
    let on = l.and(!end, negative);
    let addend: Bits = (0..now[F].len())
        .map(|i| {
            let [dx, dy] = [DX, DY].map(|d| now[d].get(i).copied().unwrap_or(Lit::FALSE));
            let dx = l.and(on, dx);
            let dy = l.and(back, !dy);
            l.or(dx, dy)
        })
        .collect();
    let f = l.add(&now[F], &addend, back).0;
    vec![
        up(l, &now[XT], x),
        up(l, &now[YT], y),
        ones(l, &now[KOX], x),
        ones(l, &now[KOY], y),
        f,
        now[DX].clone(),
        now[DY].clone(),
    ]
}

impl Model {
    /// The algorithm, if it is there in this form; `width` tells how wide what is compared is.
    pub fn new(
        method: Method,
        options: Options,
        bits: u32,
        width: impl Fn(What) -> Option<u32>,
        lanes: usize,
    ) -> Option<Model> {
        if method != Method::EfLine || options.as_printed {
            return None;
        }
        let [xt, yt, kox, koy, f] = [What::At(0), What::At(1), What::Left(0), What::Left(1), What::Sum(0)].map(&width);
        if [kox, koy].into_iter().any(|left| left.is_none_or(|left| left > bits)) {
            return None;
        }
        let widths = [xt?, yt?, bits, bits, f?.max(bits + 1), bits, bits];
        let shown = |l: &mut Logic, now: &[Bits]| line_steps(l, now).to_vec();
        let rules = Rules { widths: &widths, next: &line, shown: &shown };
        Some(Model { registers: Registers::new(&rules, lanes), bits, centred: options.centred })
    }

    /// Loads a lane.
    pub fn load(&self, lane: usize, v: &[i64]) -> Result<(), InputError> {
        let input = LineInput { xh: v[0], yh: v[1], dx: v[2], dy: v[3], bits: self.bits };
        input.check()?;
        let f = if self.centred { (input.dx - input.dy) >> 1 } else { 0 };
        for (register, value) in [v[0], v[1], v[2], v[3], f, v[2], v[3]].into_iter().enumerate() {
            self.registers.put(register, lane, value as u64);
        }
        Ok(())
    }

    /// The plane of a bit of what is compared.
    pub fn plane(&self, what: What, bit: u32) -> u32 {
        match what {
            What::At(i) => self.registers.bit(XT + i, bit),
            What::Left(i) => self.registers.bit(KOX + i, bit),
            What::Sum(_) => self.registers.bit(F, bit),
            What::End => self.registers.shown(0),
            What::Step(i) => self.registers.shown(1 + i),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolate::{EfLine, Interpolator};

    /// All lines of 8 bits, so that a comparison with this is one with the algorithm; and samples of other widths.
    #[test]
    fn the_line_over_lanes_is_the_line() {
        const LANES: usize = 1 << 14;
        for (bits, centred) in [(4, false), (4, true), (8, false), (8, true), (12, true), (16, false)] {
            let options = Options { centred, ..Options::default() };
            let width = |what: What| {
                Some(match what {
                    What::Sum(_) => bits + 1,
                    What::End | What::Step(_) => 1,
                    _ => bits,
                })
            };
            let most = (1i64 << bits) - 1;
            let mut state = u64::from(bits);
            let mut random = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) as i64 & most
            };
            let mut compared = 0u64;
            for block in 0..if bits == 8 { 4 } else { 1 } {
                let lanes = if bits > 8 { 64 } else { LANES };
                let model = Model::new(Method::EfLine, options, bits, width, lanes).unwrap();
                let mut lines: Vec<EfLine> = (0..lanes)
                    .map(|lane| {
                        let number = (block * LANES + lane) as i64;
                        let (dx, dy) = match bits {
                            4 | 8 => (number & most, number >> bits & most),
                            _ => ([0, 1, most, random()][lane % 4], [random(), 0, most, 1][lane / 4 % 4]),
                        };
                        let (xh, yh) = (random(), random());
                        model.load(lane, &[xh, yh, dx, dy]).unwrap();
                        let input = LineInput { xh, yh, dx, dy, bits };
                        if centred { EfLine::centred(input) } else { EfLine::new(input) }.unwrap()
                    })
                    .collect();
                model.registers.show();
                // a plane of each bit of what an algorithm shows
                let m = most as u64;
                let shows = |line: &EfLine, step: [i8; 3]| {
                    let now = line.state();
                    let words = [now.at[0] as u64 & m, now.at[1] as u64 & m, now.left[0], now.left[1]];
                    let flags = u64::from(now.end) | (step[0] as u64) << 1 | (step[1] as u64) << 2;
                    (words, now.sum[0] as u64 & (m << 1 | 1), flags)
                };
                let look = |what: What, lane: usize| {
                    let bit = |i| u64::from(model.registers.lane(model.plane(what, i), lane)) << i;
                    (0..width(what).unwrap()).map(bit).sum::<u64>()
                };
                for clock in 0..2 * most + 3 {
                    for (lane, line) in lines.iter_mut().enumerate() {
                        // of lanes that have ended a few are looked at again
                        if line.state().end && clock % 61 != 0 {
                            continue;
                        }
                        let before = line.clone();
                        let step = line.next().map_or([0; 3], |n| n.step);
                        let (words, sum, flags) = shows(&before, step);
                        let seen =
                            [What::At(0), What::At(1), What::Left(0), What::Left(1)].map(|what| look(what, lane));
                        assert_eq!(seen, words, "{bits} bits, lane {lane}, clock {clock}");
                        assert_eq!(look(What::Sum(0), lane), sum, "{bits} bits, lane {lane}, clock {clock}");
                        let seen =
                            look(What::End, lane) | look(What::Step(0), lane) << 1 | look(What::Step(1), lane) << 2;
                        assert_eq!(seen, flags, "{bits} bits, lane {lane}, clock {clock}");
                        compared += 1;
                    }
                    model.registers.step();
                }
                assert!(lines.iter().all(|line| line.state().end));
            }
            // every clock of every line: the sum of all ends
            let least = if bits > 8 { 1 << 17 } else { (1 << (2 * bits)) * most as u64 };
            assert!(compared >= least, "{bits} bits: {compared} clocks");
        }
    }
}
