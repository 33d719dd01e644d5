//! Normalisation (document A): both numbers are doubled together until one of them has a 1 in its top bit, "and this
//! operation, which has the character of normalising, may be done before every summation" («може да се извършва преди
//! всяко сумиране»). It keeps their ratio, so the path stays and the clocks become fewer.

/// By how many bits `a` and `b`, both in `0..2^bits`, can be shifted left together until one has a 1 in bit `bits − 1`.
///
/// For a = b = 0 there is no such number: the answer is then the greatest that `clog2(bits)` bits hold, which is what
/// the shifting stages of the circuit show.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::dda::normalise::shifts;
/// // 0000_0101 and 0000_0100: five zeros above both
/// assert_eq!(shifts(5, 4, 8), 5);
/// assert_eq!((shifts(128, 1, 8), shifts(0, 1, 8), shifts(0, 0, 8), shifts(0, 0, 6)), (0, 7, 7, 7));
/// ```
#[must_use]
pub const fn shifts(a: i64, b: i64, bits: u32) -> u32 {
    match (a | b) as u64 {
        0 => (1 << (u32::BITS - (bits - 1).leading_zeros())) - 1,
        any => bits - (u64::BITS - any.leading_zeros()),
    }
}
