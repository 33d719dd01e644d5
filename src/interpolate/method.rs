//! The methods by name.

use std::{error, fmt, str::FromStr};

/// A method of interpolation, by the name it has on the command line.
///
/// ```
/// # mod discreta {
/// #     pub mod interpolate { pub use discreta_interpolate::*; }
/// # }
/// use discreta::interpolate::Method;
/// assert_eq!("ef-line".parse(), Ok(Method::EfLine));
/// assert_eq!(Method::EfLine.to_string(), "ef-line");
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum Method {
    /// `ef-line`: a line by evaluation function (documents B and C).
    EfLine,
    /// `ef-circle`: an arc by evaluation function (documents B and C).
    EfCircle,
    /// `ef-line-fast`: a line by the accelerated algorithm (document B).
    EfLineFast,
    /// `ef-circle-fast`: an arc by the accelerated algorithm (document B).
    EfCircleFast,
    /// `karibsky`: an arc by Karibsky's rule (document C).
    Karibsky,
    /// `grossman`: an arc by Grossman's rule (document C), which is `ef-circle`.
    Grossman,
    /// `dda-line`: a line by differential increments (document A).
    DdaLine,
    /// `dda-circle`: an arc by differential increments (document A).
    DdaCircle,
    /// `dda-curve`: a general curve of the second order by differential increments (document A).
    DdaCurve,
    /// `ef-line-3d`: a line in space by evaluation function.
    EfLine3d,
    /// `dda-line-3d`: a line in space by differential increments.
    DdaLine3d,
}

/// What a method draws.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash)]
pub enum Shape {
    /// A straight line in the plane.
    Line,
    /// A straight line in space.
    Line3d,
    /// An arc of a circle.
    Arc,
    /// A curve of the second order.
    Curve,
}

impl Method {
    /// Every method, in the order in which they are listed to the user.
    pub const ALL: &'static [Method] = &[
        Method::EfLine,
        Method::EfCircle,
        Method::EfLineFast,
        Method::EfCircleFast,
        Method::Karibsky,
        Method::Grossman,
        Method::DdaLine,
        Method::DdaCircle,
        Method::DdaCurve,
        Method::EfLine3d,
        Method::DdaLine3d,
    ];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Method::EfLine => "ef-line",
            Method::EfCircle => "ef-circle",
            Method::EfLineFast => "ef-line-fast",
            Method::EfCircleFast => "ef-circle-fast",
            Method::Karibsky => "karibsky",
            Method::Grossman => "grossman",
            Method::DdaLine => "dda-line",
            Method::DdaCircle => "dda-circle",
            Method::DdaCurve => "dda-curve",
            Method::EfLine3d => "ef-line-3d",
            Method::DdaLine3d => "dda-line-3d",
        }
    }

    /// One line about the method.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Method::EfLine => "line by evaluation function: the sign of F picks the axis",
            Method::EfCircle => "arc by evaluation function: the sign of F picks the axis",
            Method::EfLineFast => "line by evaluation function, accelerated: the leading axis steps on every clock",
            Method::EfCircleFast => {
                "arc by evaluation function, accelerated: the leading axis of the octant steps on every clock"
            }
            Method::Karibsky => "arc by evaluation function, Karibsky's rule: one axis steps only if F stays 0 or more",
            Method::Grossman => {
                "arc by evaluation function, Grossman's rule: the sign of F picks the axis, as ef-circle"
            }
            Method::DdaLine => "line by differential increments: the carries of two accumulators are the steps",
            Method::DdaCircle => "arc by differential increments: each accumulator sums the other axis' coordinate",
            Method::DdaCurve => {
                "second-order curve by differential increments: carries and borrows of signed accumulators"
            }
            Method::EfLine3d => "line in space by evaluation function",
            Method::DdaLine3d => "line in space by differential increments",
        }
    }

    /// What it draws.
    #[must_use]
    pub const fn shape(self) -> Shape {
        match self {
            Method::EfLine | Method::EfLineFast | Method::DdaLine => Shape::Line,
            Method::EfLine3d | Method::DdaLine3d => Shape::Line3d,
            Method::EfCircle | Method::EfCircleFast | Method::Karibsky | Method::Grossman | Method::DdaCircle => {
                Shape::Arc
            }
            Method::DdaCurve => Shape::Curve,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_found_by_its_name() {
        for &method in Method::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        let unknown = "ef-lime".parse::<Method>().unwrap_err();
        assert!(unknown.to_string().starts_with("no method is called 'ef-lime'; there is ef-line, ef-circle, "));
    }
}
