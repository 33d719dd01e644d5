//! From the options of a method to a [`Request`], and what it is called.

use super::CliError;
use super::args::{Center, DrawingArgs, Point};
use crate::interpolate::{Drawing, InputError, Method, Offset, Options, Request, Shape};

/// Makes the interpolator.
///
/// # Errors
/// An option that the method does not have, one that it needs and was not given, or what it cannot draw.
pub fn draw(method: Method, args: &DrawingArgs) -> Result<(Request, Drawing), CliError> {
    let request = request(method, args)?;
    let drawing = request.draw().map_err(refused)?;
    Ok((request, drawing))
}

/// What a refusal means for the user.
fn refused(error: InputError) -> CliError {
    CliError::usage(error.to_string())
}

/// What the options say.
fn request(method: Method, args: &DrawingArgs) -> Result<Request, CliError> {
    let shape = method.shape();
    let missing = |option| refused(InputError::Missing { method, option });
    let curved = matches!(shape, Shape::Arc | Shape::Curve);
    let of_shapes = [
        ("--center", args.center.is_some(), shape == Shape::Arc),
        ("--f0", args.f0.is_some(), shape == Shape::Arc),
        ("--conic", args.conic.is_some(), shape == Shape::Curve),
        ("--ccw", args.ccw, curved),
        ("--cw", args.cw, curved),
    ];
    for (option, given, there_is) in of_shapes {
        if given && !there_is {
            return Err(refused(InputError::Option { method, option }));
        }
    }
    let to = at(method, "--to", args.to.ok_or_else(|| missing("--to"))?)?;
    let from = match args.from {
        Some(from) => at(method, "--from", from)?,
        None if curved => return Err(missing("--from")),
        None => [0; 3],
    };
    let center = args.center.unwrap_or(Center { whole: [0; 2], rest: [0.0; 2] });
    Ok(Request {
        from,
        center: center.whole,
        center_rest: center.rest,
        f0: args.f0,
        clockwise: args.cw,
        conic: args.conic,
        offset: args.offset.zip(args.side).map(|(radius, side)| Offset { radius, side }),
        bits: args.bits,
        options: Options {
            as_printed: args.as_printed,
            half_preload: args.half_preload,
            parallel: args.parallel,
            normalise: args.normalise,
            centred: args.centred,
        },
        ..Request::new(method, to)
    })
}

/// A point with as many coordinates as the method has axes.
fn at(method: Method, option: &str, point: Point) -> Result<[i64; 3], CliError> {
    match (method.shape() == Shape::Line3d, point.z) {
        (true, Some(z)) => Ok([point.x, point.y, z]),
        (false, None) => Ok([point.x, point.y, 0]),
        (true, None) => Err(CliError::usage(format!("{method} draws in space: write {option} X,Y,Z"))),
        (false, Some(_)) => Err(CliError::usage(format!("{method} draws in the plane: write {option} X,Y"))),
    }
}

/// What is drawn, by what: `ef-line, centred: (0, 0) → (5, 3)`.
pub fn title(request: &Request, axes: usize) -> String {
    let mut title = request.method.to_string();
    let options = request.options;
    for (set, word) in [
        (options.as_printed, "as printed"),
        (options.half_preload, "half preload"),
        (options.parallel, "parallel"),
        (options.normalise, "normalised"),
        (options.centred, "centred"),
        (request.clockwise, "clockwise"),
    ] {
        if set {
            title += ", ";
            title += word;
        }
    }
    if let Some(Offset { radius, side }) = request.offset {
        title += &format!(", {radius} BLU to the {side} of");
    }
    let center = Center { whole: request.center, rest: request.center_rest };
    let around = match center.exact() {
        [0.0, 0.0] => String::new(),
        [x, y] => format!(" around ({x}, {y})"),
    };
    format!("{title}: {} → {}{around}", point(request.from, axes), point(request.to, axes))
}

/// A point as it is printed.
pub fn point(at: [i64; 3], axes: usize) -> String {
    let all: Vec<String> = at[..axes].iter().map(i64::to_string).collect();
    format!("({})", all.join(", "))
}

impl DrawingArgs {
    /// The first option given that says how a method works, and so means nothing without one.
    pub fn of_methods_alone(&self) -> Option<&'static str> {
        let all = [
            ("--conic", self.conic.is_some()),
            ("--offset", self.offset.is_some()),
            ("--f0", self.f0.is_some()),
            ("--bits", self.bits.is_some()),
            ("--half-preload", self.half_preload),
            ("--parallel", self.parallel),
            ("--normalise", self.normalise),
            ("--centred", self.centred),
            ("--as-printed", self.as_printed),
        ];
        all.into_iter().find(|(_, given)| *given).map(|(option, _)| option)
    }
}
