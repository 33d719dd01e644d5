//! What an interpolator is given, and why it may not take it.

use std::{error, fmt};

use super::{MAX_BITS, Method};

/// A line of the first quadrant, and the width of the registers that draw it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LineInput {
    /// `XH`, the start point's x in BLU: `−2^(bits−1) ≤ xh < 2^bits`. A register keeps negative ones in two's
    /// complement.
    pub xh: i64,
    /// `YH`, its y; as `xh`.
    pub yh: i64,
    /// `ΔX = XK − XH` in BLU: `0 ≤ dx < 2^bits`.
    pub dx: i64,
    /// `ΔY = YK − YH`; as `dx`.
    pub dy: i64,
    /// Bits of a coordinate and of an increment, `1..=32`.
    pub bits: u32,
}

impl LineInput {
    /// The line from the origin with increments `dx`, `dy`, in registers of 8 bits.
    #[must_use]
    pub const fn new(dx: i64, dy: i64) -> Self {
        LineInput { xh: 0, yh: 0, dx, dy, bits: 8 }
    }

    /// The line between two points: `DX = XK − XH`, `DY = YK − YH`.
    ///
    /// # Errors
    /// If a difference overflows. What registers of `bits` bits cannot hold is refused by the interpolators.
    pub fn between((xh, yh): (i64, i64), (xk, yk): (i64, i64), bits: u32) -> Result<Self, InputError> {
        let dx = xk.checked_sub(xh).ok_or(InputError::Overflow)?;
        let dy = yk.checked_sub(yh).ok_or(InputError::Overflow)?;
        Ok(LineInput { xh, yh, dx, dy, bits })
    }

    /// Refuses what the registers cannot hold.
    ///
    /// # Errors
    /// A width that is not possible, a negative or wide increment, a wide coordinate.
    pub fn check(&self) -> Result<(), InputError> {
        check_bits(self.bits)?;
        check_coordinate("XH", self.xh, self.bits)?;
        check_coordinate("YH", self.yh, self.bits)?;
        check_increment("DX", self.dx, self.bits)?;
        check_increment("DY", self.dy, self.bits)
    }
}

/// A line in space, from a start point with increments of 0 or more along x, y and z.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Line3dInput {
    /// `XH`, `YH`, `ZH` in BLU; as [`LineInput::xh`].
    pub start: [i64; 3],
    /// `ΔX`, `ΔY`, `ΔZ` in BLU; as [`LineInput::dx`].
    pub increment: [i64; 3],
    /// Bits of a coordinate and of an increment, `1..=32`.
    pub bits: u32,
}

impl Line3dInput {
    /// Refuses what the registers cannot hold.
    ///
    /// # Errors
    /// As [`LineInput::check`].
    pub fn check(&self) -> Result<(), InputError> {
        check_bits(self.bits)?;
        for (name, value) in ["XH", "YH", "ZH"].into_iter().zip(self.start) {
            check_coordinate(name, value, self.bits)?;
        }
        for (name, value) in ["DX", "DY", "DZ"].into_iter().zip(self.increment) {
            check_increment(name, value, self.bits)?;
        }
        Ok(())
    }
}

/// An arc of the first quadrant around the origin, and the width of the registers that draw it.
///
/// Counter-clockwise x falls and y rises, clockwise the other way round.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ArcInput {
    /// `XH`, the start point's x in BLU: `0 ≤ xh < 2^bits`.
    pub xh: i64,
    /// `YH`, its y; as `xh`.
    pub yh: i64,
    /// `ΔX = |XH − XK|`, steps along x: `0 ≤ dx < 2^bits`, and no further than the axis where x falls.
    pub dx: i64,
    /// `ΔY = |YK − YH|`, steps along y; as `dx`.
    pub dy: i64,
    /// `F₀ = XH² + YH² − R²`: 0 for a start point on the circle.
    pub f0: i64,
    /// Clockwise: x rises, y falls.
    pub clockwise: bool,
    /// Bits of a coordinate, `1..=32`; `F` has two more.
    pub bits: u32,
}

impl ArcInput {
    /// The arc between two points of the first quadrant, whose circle goes through the first. A difference beyond 64
    /// bits becomes the nearest that is not; [`check`](ArcInput::check) refuses it in any width.
    #[must_use]
    pub const fn between((xh, yh): (i64, i64), (xk, yk): (i64, i64), clockwise: bool, bits: u32) -> Self {
        let (dx, dy) = if clockwise {
            (xk.saturating_sub(xh), yh.saturating_sub(yk))
        } else {
            (xh.saturating_sub(xk), yk.saturating_sub(yh))
        };
        ArcInput { xh, yh, dx, dy, f0: 0, clockwise, bits }
    }

    /// The end point.
    #[must_use]
    pub const fn end(&self) -> (i64, i64) {
        if self.clockwise { (self.xh + self.dx, self.yh - self.dy) } else { (self.xh - self.dx, self.yh + self.dy) }
    }

    /// Refuses what the registers cannot hold, and an arc that leaves the first quadrant or has no radius.
    ///
    /// # Errors
    /// A width that is not possible; a coordinate or increment that is negative or too wide; an end point that is not
    /// in the quadrant or does not fit; the centre as start point; an `f0` beyond `bits + 2` bits, signed.
    pub fn check(&self) -> Result<(), InputError> {
        let ArcInput { xh, yh, dx, dy, f0, bits, .. } = *self;
        check_bits(bits)?;
        for (name, value) in [("XH", xh), ("YH", yh)] {
            if value < 0 {
                return Err(InputError::NegativeCoordinate { name, value });
            }
            check_coordinate(name, value, bits)?;
        }
        check_increment("DX", dx, bits)?;
        check_increment("DY", dy, bits)?;
        let (xk, yk) = self.end();
        for (name, value) in [("XK", xk), ("YK", yk)] {
            if value < 0 {
                return Err(InputError::NegativeCoordinate { name, value });
            }
            check_coordinate(name, value, bits)?;
        }
        if (xh, yh) == (0, 0) {
            return Err(InputError::ZeroRadius);
        }
        if !(-(2 << bits)..2 << bits).contains(&f0) {
            return Err(InputError::WideF0 { value: f0, bits: bits + 2 });
        }
        Ok(())
    }
}

/// Why an interpolator does not take its input.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum InputError {
    /// The registers' width is not in `1..=MAX_BITS`.
    Bits {
        /// The width asked for.
        bits: u32,
    },
    /// An increment is below 0.
    NegativeIncrement {
        /// `DX`, `DY` or `DZ`.
        name: &'static str,
        /// Its value in BLU.
        value: i64,
    },
    /// An increment does not fit the counters.
    WideIncrement {
        /// `DX`, `DY` or `DZ`.
        name: &'static str,
        /// Its value in BLU.
        value: i64,
        /// The counters' width.
        bits: u32,
    },
    /// A coordinate fits the register neither unsigned nor in two's complement.
    WideCoordinate {
        /// `XH` …
        name: &'static str,
        /// Its value in BLU.
        value: i64,
        /// The register's width.
        bits: u32,
    },
    /// A point of an arc is not in the first quadrant.
    NegativeCoordinate {
        /// `XH` …
        name: &'static str,
        /// Its value in BLU.
        value: i64,
    },
    /// A point of an arc is too far from its centre along an axis.
    FarFromCenter {
        /// How far, in BLU.
        value: i64,
        /// Bits of the registers.
        bits: u32,
    },
    /// The circle is too great for the registers.
    WideRadius {
        /// The square of its radius.
        square: i128,
        /// Bits of the registers.
        bits: u32,
    },
    /// An arc within a quadrant on which no coordinate falls, or none rises.
    TooShort,
    /// The start point is the centre.
    ZeroRadius,
    /// The tool's radius is not below that of the arc inside which it is to go.
    TooGreatTool {
        /// The tool's radius in BLU.
        radius: u32,
        /// The square of the arc's.
        square: i128,
    },
    /// A line without a length has no side.
    NoSide,
    /// The start point is too far from the circle for the register of `F`.
    WideF0 {
        /// `F₀`.
        value: i64,
        /// The register's width.
        bits: u32,
    },
    /// The end point of an arc is not on its circle, not even rounded.
    OffCircle {
        /// The end point, BLU.
        end: (i64, i64),
        /// The start point, through which the circle goes, BLU.
        start: (i64, i64),
    },
    /// The registers are too narrow for the method.
    FewBits {
        /// The width asked for.
        bits: u32,
        /// The least.
        least: u32,
    },
    /// A value does not fit a register in two's complement.
    WideSigned {
        /// `A` … `E`, `XH` …
        name: &'static str,
        /// Its value.
        value: i64,
        /// The register's width.
        bits: u32,
    },
    /// `A` to `E` are all 0: no curve.
    NoCurve,
    /// A point is not near the curve.
    OffCurve {
        /// The point, BLU.
        point: [i64; 2],
        /// The polynomial's value there.
        value: i128,
        /// How great it may be.
        limit: i128,
    },
    /// Both derivatives are 0 at the start point: the curve has no direction there.
    NoDirection {
        /// The start point, BLU.
        point: [i64; 2],
    },
    /// The derivatives or the coordinates pass what the registers hold on the way from the start point to the end point.
    WideCurve {
        /// The greatest `|2Ax + By + D|` or `|Bx + 2Cy + E|`, rounded.
        derivative: u64,
        /// The greatest coordinate, without its sign, BLU, rounded.
        coordinate: u64,
        /// The registers' width.
        bits: u32,
    },
    /// The end point is behind the start point, or on another branch.
    NotAhead {
        /// The end point, BLU.
        point: [i64; 2],
    },
    /// The difference of two coordinates does not fit 64 bits.
    Overflow,
    /// An option that the method does not have.
    Option {
        /// The method.
        method: Method,
        /// The option, as on the command line.
        option: &'static str,
    },
    /// A value without which the method cannot begin.
    Missing {
        /// The method.
        method: Method,
        /// The option, as on the command line.
        option: &'static str,
    },
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            InputError::Bits { bits } => write!(f, "registers of {bits} bits: they may have 1 to {MAX_BITS}"),
            InputError::NegativeIncrement { name, value } => {
                write!(f, "{name} = {value} is negative: the line or arc has to lie in the first quadrant")
            }
            InputError::WideIncrement { name, value, bits } => {
                write!(f, "{name} = {value} is above {}, the greatest of {bits} bits", (1_i64 << bits) - 1)
            }
            InputError::WideCoordinate { name, value, bits } => {
                let (least, greatest) = (-(1_i64 << (bits - 1)), (1_i64 << bits) - 1);
                write!(f, "{name} = {value} is outside {least}..{greatest}, what {bits} bits hold")
            }
            InputError::NegativeCoordinate { name, value } => {
                write!(f, "{name} = {value} is negative: the arc has to lie in the first quadrant")
            }
            InputError::FarFromCenter { value, bits } => {
                write!(
                    f,
                    "a point is {value} from the centre, above {}, the greatest of {bits} bits",
                    (1_i64 << bits) - 1
                )
            }
            InputError::WideRadius { square, bits } => {
                let root = (square as f64).sqrt();
                write!(f, "the radius {root:.2} is above {}, the greatest of {bits} bits", (1_i64 << bits) - 1)
            }
            InputError::TooShort => {
                write!(f, "on no arc from the start point to the end point does one coordinate fall and the other rise")
            }
            InputError::TooGreatTool { radius, square } => {
                let arc = (square as f64).sqrt();
                write!(
                    f,
                    "a tool of radius {radius} does not fit into an arc of radius {arc:.2}: its path has to have a radius above 0"
                )
            }
            InputError::NoSide => write!(f, "a line without a length has no side to go on"),
            InputError::ZeroRadius => write!(f, "the start point is the centre: the radius is 0"),
            InputError::WideF0 { value, bits } => {
                let half = 1_i64 << (bits - 1);
                write!(
                    f,
                    "the start point is too far from the circle: F = {value} is outside {}..{}, what {bits} bits hold",
                    -half,
                    half - 1
                )
            }
            InputError::OffCircle { end: (xk, yk), start: (xh, yh) } => {
                let radius = |x: i64, y: i64| (x as f64 * x as f64 + y as f64 * y as f64).sqrt();
                write!(
                    f,
                    "the end point ({xk}, {yk}) is off the circle: it is {:.2} from the centre, the start point {:.2}, \
                     and they may differ by less than 2",
                    radius(xk, yk),
                    radius(xh, yh)
                )
            }
            InputError::FewBits { bits, least } => {
                write!(f, "registers of {bits} bits: this method's have {least} to {MAX_BITS}")
            }
            InputError::WideSigned { name, value, bits } => {
                let half = 1_i128 << (bits - 1);
                write!(
                    f,
                    "{name} = {value} is outside {}..{}, what {bits} bits hold in two's complement",
                    -half,
                    half - 1
                )
            }
            InputError::NoCurve => write!(f, "A, B, C, D and E are all 0: there is no curve"),
            InputError::OffCurve { point: [x, y], value, limit } => write!(
                f,
                "({x}, {y}) is not near the curve: Ax² + Bxy + Cy² + Dx + Ey + F is {value} there, and may be {} to {limit}",
                -limit
            ),
            InputError::NoDirection { point: [x, y] } => {
                write!(f, "the curve has no direction at ({x}, {y}): 2Ax + By + D and Bx + 2Cy + E are both 0")
            }
            InputError::WideCurve { derivative, coordinate, bits } => {
                let full = 1_i64 << bits;
                write!(
                    f,
                    "on the way 2Ax + By + D or Bx + 2Cy + E gets to ±{derivative} and a coordinate to \
                     ±{coordinate}: with {bits} bits they have to be below {full} and {}",
                    full / 2
                )
            }
            InputError::NotAhead { point: [x, y] } => write!(
                f,
                "the end point ({x}, {y}) does not lie ahead of the start point in the direction asked for: \
                 it is behind it or on another branch"
            ),
            InputError::Overflow => write!(f, "the end point is too far from the start point"),
            InputError::Option { method, option } => write!(f, "{method} has no option {option}"),
            InputError::Missing { method, option } => write!(f, "{method} needs {option}"),
        }
    }
}

impl error::Error for InputError {}

/// Refuses a width of registers that is not in `1..=MAX_BITS`.
pub(super) fn check_bits(bits: u32) -> Result<(), InputError> {
    if (1..=MAX_BITS).contains(&bits) { Ok(()) } else { Err(InputError::Bits { bits }) }
}

/// Refuses an increment that is negative or does not fit.
pub(super) fn check_increment(name: &'static str, value: i64, bits: u32) -> Result<(), InputError> {
    match value {
        v if v < 0 => Err(InputError::NegativeIncrement { name, value }),
        v if v >= 1 << bits => Err(InputError::WideIncrement { name, value, bits }),
        _ => Ok(()),
    }
}

/// Refuses a coordinate that fits neither unsigned nor in two's complement.
pub(super) fn check_coordinate(name: &'static str, value: i64, bits: u32) -> Result<(), InputError> {
    if value < -(1 << (bits - 1)) || value >= 1 << bits {
        return Err(InputError::WideCoordinate { name, value, bits });
    }
    Ok(())
}

/// Refuses what a register of `bits` bits does not hold in two's complement.
pub(super) fn check_signed(name: &'static str, value: i64, bits: u32) -> Result<(), InputError> {
    let half = 1 << (bits - 1);
    if (-half..half).contains(&value) { Ok(()) } else { Err(InputError::WideSigned { name, value, bits }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_register_takes_signed_and_unsigned_values() {
        let fits = |v| check_coordinate("XH", v, 8).is_ok();
        assert_eq!([-129, -128, -1, 0, 255, 256].map(fits), [false, true, true, true, true, false]);
        assert!(check_coordinate("XH", (1 << 32) - 1, 32).is_ok());
    }

    #[test]
    fn a_line_is_refused_with_its_limit() {
        let ok = LineInput::new(5, 3);
        let message = |input: LineInput| input.check().unwrap_err().to_string();
        assert_eq!(ok.check(), Ok(()));
        assert_eq!(
            message(LineInput { dx: -5, ..ok }),
            "DX = -5 is negative: the line or arc has to lie in the first quadrant"
        );
        assert_eq!(message(LineInput { dy: 256, ..ok }), "DY = 256 is above 255, the greatest of 8 bits");
        assert_eq!(message(LineInput { xh: 256, ..ok }), "XH = 256 is outside -128..255, what 8 bits hold");
        assert_eq!(
            message(LineInput { yh: i64::MIN, bits: 32, ..ok }).split(" is ").next(),
            Some("YH = -9223372036854775808")
        );
        assert_eq!(message(LineInput { bits: 0, ..ok }), "registers of 0 bits: they may have 1 to 32");
        assert_eq!(message(LineInput { bits: 33, ..ok }), "registers of 33 bits: they may have 1 to 32");
        assert_eq!(LineInput::between((i64::MIN, 0), (1, 0), 8), Err(InputError::Overflow));
        assert_eq!(LineInput::between((2, 1), (7, 4), 8).map(|i| (i.dx, i.dy)), Ok((5, 3)));
    }

    #[test]
    fn an_arc_is_refused_with_its_limit() {
        let quarter = ArcInput::between((5, 0), (0, 5), false, 8);
        assert_eq!(quarter, ArcInput { xh: 5, yh: 0, dx: 5, dy: 5, f0: 0, clockwise: false, bits: 8 });
        assert_eq!(quarter.check(), Ok(()));
        let message = |input: ArcInput| input.check().unwrap_err().to_string();
        assert_eq!(
            message(ArcInput { dx: 6, ..quarter }),
            "XK = -1 is negative: the arc has to lie in the first quadrant"
        );
        assert_eq!(message(ArcInput { xh: 0, dx: 0, ..quarter }), "the start point is the centre: the radius is 0");
        assert_eq!(
            message(ArcInput { f0: 512, ..quarter }),
            "the start point is too far from the circle: F = 512 is outside -512..511, what 10 bits hold"
        );
        assert_eq!(ArcInput { f0: -512, ..quarter }.check(), Ok(()));
        assert_eq!(message(ArcInput { yh: 254, ..quarter }), "YK = 259 is outside -128..255, what 8 bits hold");
    }
}
