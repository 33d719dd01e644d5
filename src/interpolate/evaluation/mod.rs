//! Interpolation by evaluation function (documents B and C): the sign of `F` says on which side of the curve a point
//! lies, and so which step leads back.

pub mod circle;
pub mod fast_circle;
pub mod fast_line;
pub mod karibsky;
pub mod line;
pub mod line_3d;

#[cfg(test)]
mod circle_tests;

/// Ones in the low `bits` bits.
const fn mask(bits: u32) -> u64 {
    (1 << bits) - 1
}
