//! Interpolation by differential increments (document A): the carries of accumulators are the steps.
//!
//! An accumulator of `p` bits holds the part of a BLU that an axis has still to go, in units of 2^−p BLU. Each clock
//! adds to it; what passes 2^p is a carry, and a carry is a step. [`mod@line`] and [`circle`] differ in what is added.

pub mod circle;
pub mod conic;
pub mod curve;
pub mod line;
pub mod line_3d;
pub mod normalise;

use crate::{Clock, Columns, InputError, Method, Options};

/// The cells of the program's memory, which are the registers of the block diagram. Index 0 is x, 1 is y.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct State {
    /// Bits of every register, `p`.
    bits: u32,
    /// `XT`, `YT`, BLU.
    at: [i64; 2],
    /// `KOX`, `KOY`, steps.
    left: [u64; 2],
    /// `SX`, `SY`, units of 2^−p BLU.
    sum: [i64; 2],
}

impl State {
    /// Points 1 to 3 of the program: what START loads. The text clears the sums; half of their volume is ours.
    const fn load(at: [i64; 2], increment: [i64; 2], bits: u32, half: bool) -> State {
        let sum = if half { 1 << (bits - 1) } else { 0 };
        State { bits, at, left: [increment[0].unsigned_abs(), increment[1].unsigned_abs()], sum: [sum; 2] }
    }

    /// Point 7.
    const fn end(&self) -> bool {
        self.left[0] == 0 && self.left[1] == 0
    }

    /// Adds to the accumulator of an axis; whether there is a carry.
    const fn add(&mut self, axis: usize, addend: i64) -> bool {
        let sum = self.sum[axis] + addend;
        self.sum[axis] = sum & mask(self.bits);
        sum > mask(self.bits)
    }

    /// A step of an axis in its direction. A counter is a register of the same bits: below 0 comes the greatest number.
    const fn step(&mut self, axis: usize, direction: i64) {
        self.at[axis] += direction;
        self.left[axis] = self.left[axis].wrapping_sub(1) & mask(self.bits) as u64;
    }

    const fn clock(&self, step: [i64; 2], shifts: Option<u32>) -> Clock {
        Clock {
            step: [step[0] as i8, step[1] as i8, 0],
            at: [self.at[0], self.at[1], 0],
            left: [self.left[0], self.left[1], 0],
            sum: [self.sum[0], self.sum[1], if let Some(shifts) = shifts { shifts as i64 } else { 0 }],
            end: self.end(),
        }
    }
}

/// Ones in the low `bits` bits.
const fn mask(bits: u32) -> i64 {
    (1 << bits) - 1
}

/// The registers that there are.
const fn columns(normalised: bool) -> Columns {
    if normalised { Columns::DDA_NORMALISED } else { Columns::DDA }
}

/// Refuses options that mean nothing here.
fn check_options(method: Method, options: &Options) -> Result<(), InputError> {
    let refused = [
        (options.centred, "--centred"),
        (options.parallel && matches!(method, Method::DdaLine | Method::DdaLine3d), "--parallel"),
        (options.normalise && matches!(method, Method::DdaLine3d | Method::DdaCurve), "--normalise"),
        (options.as_printed && method == Method::DdaLine3d, "--as-printed"),
        (options.as_printed && options.normalise, "--normalise together with --as-printed"),
    ];
    match refused.into_iter().find(|r| r.0) {
        Some((_, option)) => Err(InputError::Option { method, option }),
        None => Ok(()),
    }
}
