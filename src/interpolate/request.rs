//! The front door: a method, two points and the options, made into an interpolator and the curve that it is to follow.

use super::input::{check_bits, check_signed};
use super::{
    ArcInput, ArcPath, CurveInput, Ideal, InputError, Interpolator, Line3dInput, LineInput, MAX_BITS, Method, Mirrored,
    Offset, Quadrants, Shape, dda, evaluation,
};

/// How a method works; the default is each method's own default.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Options {
    /// The document's program taken at its word, misprints included.
    pub as_printed: bool,
    /// DDA: the accumulators begin at half of their volume.
    pub half_preload: bool,
    /// DDA circle and curve: both axes from the old coordinates, instead of y from the new x.
    pub parallel: bool,
    /// DDA line and circle: what is added is shifted left until a top bit is set.
    pub normalise: bool,
    /// Lines by evaluation function: `F` begins in the middle of its range.
    pub centred: bool,
}

impl Options {
    /// Refuses what a method does not have.
    fn check(&self, method: Method) -> Result<(), InputError> {
        use Method::{DdaCircle, DdaCurve, DdaLine, DdaLine3d, EfLine, EfLine3d, EfLineFast};
        let printed = !matches!(method, EfLine3d | DdaLine3d);
        let dda = matches!(method, DdaLine | DdaCircle | DdaCurve | DdaLine3d);
        let from_old = matches!(method, DdaCircle | DdaCurve);
        let normalised = matches!(method, DdaLine | DdaCircle);
        let line = matches!(method, EfLine | EfLineFast | EfLine3d);
        let all = [
            ("--as-printed", self.as_printed, printed),
            ("--half-preload", self.half_preload, dda),
            ("--parallel", self.parallel, from_old),
            ("--normalise", self.normalise, normalised),
            ("--centred", self.centred, line),
        ];
        match all.into_iter().find(|&(_, set, has)| set && !has) {
            Some((option, ..)) => Err(InputError::Option { method, option }),
            None => Ok(()),
        }
    }
}

/// What is to be drawn, and how.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Request {
    /// The method.
    pub method: Method,
    /// The start point in BLU; z is 0 in the plane.
    pub from: [i64; 3],
    /// The end point in BLU.
    pub to: [i64; 3],
    /// The centre of an arc in BLU, rounded.
    pub center: [i64; 2],
    /// What rounding took from the centre, BLU: the circle is that around both together through the start point.
    pub center_rest: [f64; 2],
    /// `F₀ = xs² + ys² − R²` of an arc's start point, from the rounded centre; without it, as the centre gives it.
    pub f0: Option<i64>,
    /// An arc or a curve goes clockwise.
    pub clockwise: bool,
    /// The coefficients `A` to `F` of a curve `A·x² + B·xy + C·y² + D·x + E·y + F = 0`.
    pub conic: Option<[i64; 6]>,
    /// The path of a tool's centre beside this line or arc, instead of the line or arc.
    pub offset: Option<Offset>,
    /// Bits of the registers; without them, the fewest that do from 8 up.
    pub bits: Option<u32>,
    /// How the method works.
    pub options: Options,
}

/// An interpolator at its start, and the curve that it is to follow.
pub struct Drawing {
    /// The interpolator.
    pub interpolator: Box<dyn Interpolator>,
    /// The curve.
    pub ideal: Ideal,
    /// Bits of its registers.
    pub bits: u32,
}

impl Request {
    /// From the origin to a point, counter-clockwise around the origin where it is an arc.
    #[must_use]
    pub const fn new(method: Method, to: [i64; 3]) -> Request {
        Request {
            method,
            from: [0; 3],
            to,
            center: [0; 2],
            center_rest: [0.0; 2],
            f0: None,
            clockwise: false,
            conic: None,
            offset: None,
            bits: None,
            options: Options {
                as_printed: false,
                half_preload: false,
                parallel: false,
                normalise: false,
                centred: false,
            },
        }
    }

    /// Makes the interpolator.
    ///
    /// # Errors
    /// If the method cannot draw this, or not in registers of that width, or has not an option that is set.
    pub fn draw(&self) -> Result<Drawing, InputError> {
        self.options.check(self.method)?;
        match self.bits {
            Some(bits) => self.draw_in(bits),
            // what is refused in every width is told for the widest
            None => (8..MAX_BITS).find_map(|bits| self.draw_in(bits).ok()).map_or_else(|| self.draw_in(MAX_BITS), Ok),
        }
    }

    fn draw_in(&self, bits: u32) -> Result<Drawing, InputError> {
        let (interpolator, ideal) = match self.method.shape() {
            Shape::Line => self.line(bits)?,
            Shape::Line3d => self.line_3d(bits)?,
            Shape::Arc => self.arc(bits)?,
            Shape::Curve => self.curve(bits)?,
        };
        Ok(Drawing { interpolator, ideal, bits })
    }

    fn line(&self, bits: u32) -> Result<(Box<dyn Interpolator>, Ideal), InputError> {
        let ([xh, yh, _], [xk, yk, _]) = (self.from, self.to);
        let (from, to, ideal) = match self.offset {
            Some(offset) => {
                let line = offset.line([xh, yh], [xk, yk])?;
                (line.from, line.to, line.ideal)
            }
            None => ([xh, yh], [xk, yk], Ideal::segment([xh, yh, 0], [xk, yk, 0])),
        };
        let from = [from[0], from[1], 0];
        let (negative, [dx, dy, _]) = octant(from, [to[0], to[1], 0], bits)?;
        let core = line(self.method, LineInput { xh: 0, yh: 0, dx, dy, bits }, &self.options)?;
        Ok((Box::new(Mirrored::new(core, false, negative, from)), ideal))
    }

    fn line_3d(&self, bits: u32) -> Result<(Box<dyn Interpolator>, Ideal), InputError> {
        self.refuse_offset()?;
        let (negative, increment) = octant(self.from, self.to, bits)?;
        let core = line_3d(self.method, Line3dInput { start: [0; 3], increment, bits }, &self.options)?;
        Ok((Box::new(Mirrored::new(core, false, negative, self.from)), Ideal::segment(self.from, self.to)))
    }

    fn arc(&self, bits: u32) -> Result<(Box<dyn Interpolator>, Ideal), InputError> {
        let Request { method, clockwise, center, center_rest, options, .. } = *self;
        let plane = |[x, y, _]: [i64; 3]| [x, y];
        let (from, to) = (plane(self.from), plane(self.to));
        let mut contour = ArcPath { center, from, to, full: true, long: None, clockwise, f0: 0, bits };
        // without a sum F nothing can make good what the rounding of an offset start point does
        let carries = method != Method::DdaCircle;
        let exact = [0, 1].map(|a| center[a] as f64 + center_rest[a]);
        let rounded = center_rest != [0.0; 2];
        if rounded {
            if !carries {
                return Err(InputError::Option { method, option: "--center off the grid" });
            }
            if self.offset.is_some() {
                return Err(InputError::Option { method, option: "--offset with --center off the grid" });
            }
            contour.f0 = self.rounded_f0(exact)?;
        }
        if let Some(f0) = self.f0 {
            if !carries {
                return Err(InputError::Option { method, option: "--f0" });
            }
            contour.f0 = f0;
        }
        let (path, ideal) = match self.offset {
            Some(_) if !carries => return Err(InputError::Option { method, option: "--offset" }),
            Some(offset) => {
                let arc = offset.arc(contour)?;
                (arc.path, arc.ideal)
            }
            None => {
                let float = |p: [i64; 2]| p.map(|v| v as f64);
                let mut ideal = Ideal::arc(exact, float(from), float(to), clockwise);
                if let (Some(f0), Ideal::Arc { radius, .. }) = (self.f0, &mut ideal) {
                    // of a start point that is off the circle
                    *radius = (self.square(center.map(|v| v as f64)) - f0 as f64).max(0.0).sqrt();
                }
                (contour, ideal)
            }
        };
        let arc = Quadrants::new(path, carries, move |input| arc(method, input, &options))?;
        Ok((Box::new(arc), ideal))
    }

    /// The square of the start point's distance from a centre.
    fn square(&self, center: [f64; 2]) -> f64 {
        let d = [0, 1].map(|a| self.from[a] as f64 - center[a]);
        d[0] * d[0] + d[1] * d[1]
    }

    /// `F₀` of the start point from the rounded centre, on a circle around the exact one.
    fn rounded_f0(&self, exact: [f64; 2]) -> Result<i64, InputError> {
        let mut square = 0_i128;
        for axis in 0..2 {
            let d = self.from[axis].checked_sub(self.center[axis]).ok_or(InputError::Overflow)?;
            square += i128::from(d) * i128::from(d);
        }
        i64::try_from(square - self.square(exact).round() as i128).map_err(|_| InputError::Overflow)
    }

    fn curve(&self, bits: u32) -> Result<(Box<dyn Interpolator>, Ideal), InputError> {
        self.refuse_offset()?;
        let coefficients = self.conic.ok_or(InputError::Missing { method: self.method, option: "--conic" })?;
        let (start, end) = ([self.from[0], self.from[1]], [self.to[0], self.to[1]]);
        let input = CurveInput { coefficients, start, end, clockwise: self.clockwise, bits };
        let ideal = Ideal::Conic { coefficients: coefficients.map(|v| v as f64) };
        Ok((dda::curve::build(input, &self.options)?, ideal))
    }

    fn refuse_offset(&self) -> Result<(), InputError> {
        match self.offset {
            Some(_) => Err(InputError::Option { method: self.method, option: "--offset" }),
            None => Ok(()),
        }
    }
}

/// Pre-processing of a line: which of its increments are negative, and the increments without signs.
fn octant(from: [i64; 3], to: [i64; 3], bits: u32) -> Result<([bool; 3], [i64; 3]), InputError> {
    check_bits(bits)?;
    let mut increment = [0; 3];
    for (axis, name) in ["XH", "YH", "ZH"].into_iter().enumerate() {
        check_signed(name, from[axis], bits + 1)?;
        let signed = to[axis].checked_sub(from[axis]).ok_or(InputError::Overflow)?;
        increment[axis] = signed.checked_abs().ok_or(InputError::Overflow)?;
    }
    Ok(([0, 1, 2].map(|axis| to[axis] < from[axis]), increment))
}

/// A line of the first quadrant.
pub fn line(method: Method, input: LineInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    match method {
        Method::EfLine => evaluation::line::build(input, options),
        Method::DdaLine => dda::line::build(input, options),
        Method::EfLineFast => evaluation::fast_line::build(input, options),
        _ => unreachable!("the shape of {method} is no line"),
    }
}

/// A line of the first octant of space.
pub fn line_3d(method: Method, input: Line3dInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    match method {
        Method::EfLine3d => evaluation::line_3d::build(input, options),
        Method::DdaLine3d => dda::line_3d::build(input, options),
        _ => unreachable!("the shape of {method} is no line in space"),
    }
}

/// An arc of the first quadrant around the origin.
pub fn arc(method: Method, input: ArcInput, options: &Options) -> Result<Box<dyn Interpolator>, InputError> {
    match method {
        Method::EfCircle | Method::Grossman => evaluation::circle::build(input, options),
        Method::Karibsky => evaluation::karibsky::build(input, options),
        Method::DdaCircle => dda::circle::build(input, options),
        Method::EfCircleFast => evaluation::fast_circle::build(input, options),
        _ => unreachable!("the shape of {method} is no arc"),
    }
}
