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

    #[test]
    fn the_line_over_lanes_is_the_line() {
        for (bits, centred) in [(4, false), (4, true), (8, false), (12, true)] {
            let options = Options { centred, ..Options::default() };
            let width = |what: What| {
                Some(match what {
                    What::Sum(_) => bits + 1,
                    What::End | What::Step(_) => 1,
                    _ => bits,
                })
            };
            let model = Model::new(Method::EfLine, options, bits, width, 512).unwrap();
            let most = (1i64 << bits) - 1;
            let mut state = u64::from(bits);
            let mut random = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) as i64
            };
            let mut lines: Vec<_> = (0..512usize)
                .map(|lane| {
                    let (dx, dy) = match bits {
                        4 => (lane as i64 & 15, lane as i64 >> 4 & 15),
                        _ => ([0, 1, most, random() & most][lane % 4], [random() & most, 0, most, 1][lane / 4 % 4]),
                    };
                    let (xh, yh) = (random() & most, random() & most);
                    model.load(lane, &[xh, yh, dx, dy]).unwrap();
                    let input = LineInput { xh, yh, dx, dy, bits };
                    let line = if centred { EfLine::centred(input) } else { EfLine::new(input) }.unwrap();
                    (line, 0u64)
                })
                .collect();
            model.registers.show();
            let look = |what: What, width: u32, lane: usize| {
                (0..width).fold(0, |n, i| n | u64::from(model.registers.lane(model.plane(what, i), lane)) << i)
            };
            let mut clocks = 0;
            for _ in 0..2 * most + 3 {
                for (lane, (line, clock)) in lines.iter_mut().enumerate() {
                    let now = line.state();
                    let m = (1u64 << bits) - 1;
                    let next = line.next();
                    *clock += u64::from(next.is_some());
                    clocks += u64::from(next.is_some());
                    let step = next.map_or([0; 3], |n| n.step);
                    for i in 0..2 {
                        assert_eq!(look(What::At(i), bits, lane), now.at[i] as u64 & m, "lane {lane}, clock {clock}");
                        assert_eq!(look(What::Left(i), bits, lane), now.left[i], "lane {lane}, clock {clock}");
                        assert_eq!(look(What::Step(i), 1, lane), step[i] as u64, "lane {lane}, clock {clock}");
                    }
                    let f = now.sum[0] as u64 & (m << 1 | 1);
                    assert_eq!(look(What::Sum(0), bits + 1, lane), f, "lane {lane}, clock {clock}");
                    assert_eq!(look(What::End, 1, lane), u64::from(now.end), "lane {lane}, clock {clock}");
                }
                model.registers.step();
            }
            assert!(clocks > 512 * 8, "{clocks} clocks");
            assert!(lines.iter().all(|(line, _)| line.state().end));
        }
    }
}
