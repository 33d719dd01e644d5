//! The documents' interpolation algorithms, step by step, in plain integers.
//!
//! Each is written from the points of the program that its document lists and is an iterator over clocks. This room
//! knows nothing of circuits, engines or waveforms: what the circuits do is compared with what is computed here.
//!
//! The sources are lecture notes, cited as *document A* (differential increments), *B* and *C* (evaluation function).

pub mod ef_line;

use std::{error, fmt, str::FromStr};

pub use ef_line::{EfLine, EfLineInput, EfLinePrinted};

/// The widest coordinate register, bits.
pub const MAX_BITS: u32 = 32;

/// A method of interpolation, by the name it has on the command line.
///
/// ```
/// use discreta::interpolate::Method;
/// assert_eq!("ef-line".parse(), Ok(Method::EfLine));
/// assert_eq!(Method::EfLine.to_string(), "ef-line");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
#[non_exhaustive]
pub enum Method {
    /// `ef-line`: a line by evaluation function (documents B and C).
    EfLine,
}

impl Method {
    /// Every method, in the order in which they are listed to the user.
    pub const ALL: &'static [Method] = &[Method::EfLine];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Method::EfLine => "ef-line",
        }
    }

    /// One line about the method.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Method::EfLine => "line by evaluation function: the sign of F picks the axis",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        Method::ALL.iter().copied().find(|m| m.name() == name).ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}

/// A name that no [`Method`] has.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct UnknownMethod(String);

impl fmt::Display for UnknownMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no method is called '{}'; there is", self.0)?;
        for (i, method) in Method::ALL.iter().enumerate() {
            write!(f, "{} {method}", if i == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

impl error::Error for UnknownMethod {}

/// The letter of one clock's steps: `X`, `Y`, `D` for both, `-` for none.
///
/// ```
/// use discreta::interpolate::letter;
/// assert_eq!([letter(true, false), letter(false, true), letter(true, true), letter(false, false)], ['X', 'Y', 'D', '-']);
/// ```
#[must_use]
pub const fn letter(x: bool, y: bool) -> char {
    match (x, y) {
        (true, false) => 'X',
        (false, true) => 'Y',
        (true, true) => 'D',
        (false, false) => '-',
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
        /// `DX` or `DY`.
        name: &'static str,
        /// Its value in BLU.
        value: i64,
    },
    /// An increment does not fit the counters.
    WideIncrement {
        /// `DX` or `DY`.
        name: &'static str,
        /// Its value in BLU.
        value: i64,
        /// The counters' width.
        bits: u32,
    },
    /// A start coordinate fits the register neither unsigned nor in two's complement.
    WideCoordinate {
        /// `XH` or `YH`.
        name: &'static str,
        /// Its value in BLU.
        value: i64,
        /// The register's width.
        bits: u32,
    },
    /// The difference of two coordinates does not fit 64 bits.
    Overflow,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            InputError::Bits { bits } => write!(f, "registers of {bits} bits: they may have 1 to {MAX_BITS}"),
            InputError::NegativeIncrement { name, value } => {
                write!(f, "{name} = {value} is negative: the line has to lie in the first quadrant")
            }
            InputError::WideIncrement { name, value, bits } => {
                write!(f, "{name} = {value} is above {}, the greatest of {bits} bits", (1_i64 << bits) - 1)
            }
            InputError::WideCoordinate { name, value, bits } => {
                let (least, greatest) = (-(1_i64 << (bits - 1)), (1_i64 << bits) - 1);
                write!(f, "{name} = {value} is outside {least}..{greatest}, what {bits} bits hold")
            }
            InputError::Overflow => write!(f, "the end point is too far from the start point"),
        }
    }
}

impl error::Error for InputError {}

/// A watchdog's report: a program that did not end within the clocks that every one that ends needs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Overrun {
    /// The clocks that were let run.
    pub clocks: u64,
}

impl fmt::Display for Overrun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "stopped by the watchdog: no end within {} clocks", self.clocks)
    }
}

impl error::Error for Overrun {}

/// The contents of a register of `bits` bits that is given `value`: `None` if it holds it neither unsigned nor in
/// two's complement.
const fn register(value: i64, bits: u32) -> Option<u64> {
    if value < -(1 << (bits - 1)) || value >= 1 << bits { None } else { Some(value as u64 & mask(bits)) }
}

/// Ones in the low `bits` bits.
const fn mask(bits: u32) -> u64 {
    (1 << bits) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_found_by_its_name() {
        for &method in Method::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        let unknown = "ef-lime".parse::<Method>().unwrap_err();
        assert_eq!(unknown.to_string(), "no method is called 'ef-lime'; there is ef-line");
    }

    #[test]
    fn a_register_takes_signed_and_unsigned_values() {
        assert_eq!(
            [-129, -128, -1, 0, 255, 256].map(|v| register(v, 8)),
            [None, Some(128), Some(255), Some(0), Some(255), None]
        );
        assert_eq!(register((1 << 32) - 1, 32), Some(0xffff_ffff));
    }
}
