//! A planned move drawn by a method, clock by clock: lines and arcs by the interpolators of the documents, one after
//! another, routed to the axes of their plane, and a rise over them.

use std::fmt;
use std::str::FromStr;

use super::plan::{Plan, PlanArc, Shape};
use crate::interpolate::quadrant::ArcPath;
use crate::interpolate::request::{arc, line, line_3d};
use crate::interpolate::{
    EfLineFast, InputError, Interpolator, Line3dInput, LineInput, Method, Options, Quadrants, Shape as Shape2,
    UnknownMethod,
};

/// Which method draws what.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Choice {
    /// Lines in the plane of x and y.
    pub line: Method,
    /// Lines with z.
    pub space: Method,
    /// Arcs.
    pub arc: Method,
    /// Lines by evaluation function begin in the middle.
    pub centred: bool,
}

impl Choice {
    /// All that are compared where none is named.
    pub const ALL: [Choice; 4] = [
        Choice { line: Method::EfLine, space: Method::EfLine3d, arc: Method::EfCircle, centred: false },
        Choice { line: Method::EfLineFast, space: Method::EfLine3d, arc: Method::EfCircleFast, centred: false },
        Choice { line: Method::EfLine, space: Method::EfLine3d, arc: Method::Karibsky, centred: false },
        Choice { line: Method::DdaLine, space: Method::DdaLine3d, arc: Method::DdaCircle, centred: false },
    ];

    /// The method of lines, with z or without.
    #[must_use]
    pub const fn line_method(&self, z: bool) -> Method {
        if z { self.space } else { self.line }
    }

    /// Whether all of it is by differential increments, whose clocks have one rule only.
    #[must_use]
    pub const fn all_dda(&self) -> bool {
        Choice::dda(self.line) && Choice::dda(self.space) && Choice::dda(self.arc)
    }

    /// Whether these are differential increments, whose clocks are not all as long.
    pub(super) const fn dda(method: Method) -> bool {
        matches!(method, Method::DdaLine | Method::DdaLine3d | Method::DdaCircle)
    }

    const fn options(&self, method: Method) -> Options {
        let dda = Choice::dda(method);
        Options {
            as_printed: false,
            half_preload: dda,
            parallel: matches!(method, Method::DdaCircle),
            normalise: matches!(method, Method::DdaCircle),
            centred: self.centred && matches!(method, Method::EfLine | Method::EfLineFast | Method::EfLine3d),
        }
    }
}

/// Its methods; that of space only where it is not the one that goes with the line.
impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = format!("{},{}", self.line, self.arc);
        if self.space != space_of(self.line) {
            text += &format!(",{}", self.space);
        }
        f.pad(&text)
    }
}

/// The method in space of the same kind.
const fn space_of(line: Method) -> Method {
    if Choice::dda(line) { Method::DdaLine3d } else { Method::EfLine3d }
}

/// One method for lines, one for arcs, and one for lines in space if it is another; what is left out is of the same kind
/// as what is there.
impl FromStr for Choice {
    type Err = String;

    fn from_str(text: &str) -> Result<Choice, String> {
        let mut found = [None; 3];
        for name in text.split(',') {
            let method: Method = name.trim().parse().map_err(|e: UnknownMethod| e.to_string())?;
            let place = match method.shape() {
                Shape2::Line => 0,
                Shape2::Arc => 1,
                Shape2::Line3d => 2,
                Shape2::Curve => {
                    return Err(format!("{method} draws what no part program has: name methods of lines and arcs"));
                }
            };
            if let Some(other) = found[place].replace(method) {
                return Err(format!("{other} and {method} are both of one kind; to compare them write --method twice"));
            }
        }
        let [line, arc, space] = found;
        let line = line.unwrap_or(match (arc, space) {
            (Some(Method::DdaCircle), _) | (None, Some(Method::DdaLine3d)) => Method::DdaLine,
            (Some(Method::EfCircleFast), _) | (None, Some(_)) => Method::EfLineFast,
            _ => Method::EfLine,
        });
        let arc = arc.unwrap_or(match line {
            Method::DdaLine => Method::DdaCircle,
            Method::EfLineFast => Method::EfCircleFast,
            _ => Method::EfCircle,
        });
        Ok(Choice { line, arc, space: space.unwrap_or(space_of(line)), centred: false })
    }
}

/// One clock.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Tick {
    /// The step along each axis.
    pub step: [i8; 3],
    /// The clock is 2^shifts times as long as the shortest.
    pub shifts: u32,
}

/// A core, and how its steps are those of the machine.
struct Core {
    inner: Box<dyn Interpolator>,
    /// Where its x, y and z go.
    axes: [usize; 3],
    /// Which axes go down.
    negative: [bool; 3],
    /// Its clocks are of several lengths.
    shifted: bool,
}

impl Core {
    fn next(&mut self) -> Option<Tick> {
        let shifts = if self.shifted { self.inner.state().sum[2] as u32 } else { 0 };
        let clock = self.inner.next()?;
        let mut step = [0; 3];
        for i in 0..3 {
            step[self.axes[i]] = if self.negative[i] { -clock.step[i] } else { clock.step[i] };
        }
        Some(Tick { step, shifts })
    }
}

/// The clocks of one move.
pub struct Drawer {
    plan: Plan,
    choice: Choice,
    bits: u32,
    /// Pieces done.
    piece: u32,
    core: Option<Core>,
    /// For a rise: its steps over the clocks of the arc, and its direction.
    rise: Option<(EfLineFast, i8)>,
    /// What a core refused.
    refused: Option<InputError>,
}

impl Drawer {
    /// Begins; `bits` are those of the machine's registers.
    ///
    /// # Errors
    /// What the interpolators refuse.
    pub fn new(plan: &Plan, choice: Choice, bits: u32) -> Result<Drawer, InputError> {
        let mut drawer = Drawer { plan: *plan, choice, bits, piece: 0, core: None, rise: None, refused: None };
        drawer.core = drawer.next_piece()?;
        if let Shape::Arc(arc) = plan.shape {
            let w = arc.axes[2];
            let rise = plan.to[w] - plan.from[w];
            if rise != 0 {
                let mut around = 0_u64;
                while drawer.flat().is_some() {
                    around += 1;
                }
                if let Some(refused) = drawer.refused {
                    return Err(refused);
                }
                let input = LineInput { xh: 0, yh: 0, dx: around as i64, dy: rise.abs(), bits: 32 };
                (drawer.piece, drawer.rise) = (0, Some((EfLineFast::new(input)?, rise.signum() as i8)));
                drawer.core = drawer.next_piece()?;
            }
        }
        Ok(drawer)
    }

    /// How many pieces the move has.
    fn pieces(&self) -> u32 {
        match self.plan.shape {
            Shape::Nothing => 0,
            Shape::Line => 1,
            Shape::Arc(arc) => arc.circles + 1 + u32::from(self.closing(arc).is_some()),
        }
    }

    /// The increments of the line behind a spiral's arc.
    fn closing(&self, arc: PlanArc) -> Option<[i64; 2]> {
        let [u, v, _] = arc.axes;
        let d = [self.plan.to[u] - arc.to[0], self.plan.to[v] - arc.to[1]];
        (d != [0, 0]).then_some(d)
    }

    fn next_piece(&mut self) -> Result<Option<Core>, InputError> {
        if self.piece >= self.pieces() {
            return Ok(None);
        }
        self.piece += 1;
        match self.plan.shape {
            Shape::Arc(arc) if self.piece <= arc.circles + 1 => self.arc(arc, self.piece <= arc.circles).map(Some),
            Shape::Arc(arc) => {
                let [u, v, w] = arc.axes;
                let [du, dv] = self.closing(arc).unwrap_or_default();
                self.plane_line([du, dv], [u, v, w]).map(Some)
            }
            _ => {
                let d = [0, 1, 2].map(|a| self.plan.to[a] - self.plan.from[a]);
                if d[2] == 0 { self.plane_line([d[0], d[1]], [0, 1, 2]) } else { self.space_line(d) }.map(Some)
            }
        }
    }

    /// Registers of a normalised line by differential increments: as many bits as the longest increment has.
    fn line_bits(&self, method: Method, d: &[i64]) -> u32 {
        let most = d.iter().map(|v| v.unsigned_abs()).max().unwrap_or(0);
        if Choice::dda(method) { (u64::BITS - most.leading_zeros()).max(1) } else { self.bits }
    }

    fn plane_line(&self, d: [i64; 2], axes: [usize; 3]) -> Result<Core, InputError> {
        let method = self.choice.line;
        let [dx, dy] = d.map(i64::abs);
        let input = LineInput { xh: 0, yh: 0, dx, dy, bits: self.line_bits(method, &d) };
        let inner = line(method, input, &self.choice.options(method))?;
        Ok(Core { inner, axes, negative: [d[0] < 0, d[1] < 0, false], shifted: false })
    }

    fn space_line(&self, d: [i64; 3]) -> Result<Core, InputError> {
        let method = self.choice.space;
        let input = Line3dInput { start: [0; 3], increment: d.map(i64::abs), bits: self.line_bits(method, &d) };
        let inner = line_3d(method, input, &self.choice.options(method))?;
        Ok(Core { inner, axes: [0, 1, 2], negative: d.map(|v| v < 0), shifted: false })
    }

    fn arc(&self, plan: PlanArc, circle: bool) -> Result<Core, InputError> {
        let method = self.choice.arc;
        let options = self.choice.options(method);
        let PlanArc { center, from, to, f0, clockwise, full, long, axes, .. } = plan;
        let (to, full, long) = if circle { (from, true, true) } else { (to, full, long) };
        let dda = Choice::dda(method);
        // the steps are all that is wanted, so the centre may be the origin; that coordinates fit is the plan's to tell
        let away = |p: [i64; 2]| [p[0] - center[0], p[1] - center[1]];
        let (from, to) = (away(from), away(to));
        // registers as wide as the circle needs are what normalising them comes to
        let most =
            from.into_iter().chain(to).map(i64::unsigned_abs).max().unwrap_or(0) as f64 * std::f64::consts::SQRT_2;
        let bits = if dda { u64::BITS - (most as u64 + 2).leading_zeros() } else { self.bits };
        let path = ArcPath { center: [0; 2], from, to, full, long: Some(long), clockwise, f0, bits };
        let inner = Quadrants::new(path, !dda, move |input| arc(method, input, &options))?;
        Ok(Core { inner: Box::new(inner), axes, negative: [false; 3], shifted: dda })
    }

    /// The next clock without the rise.
    fn flat(&mut self) -> Option<Tick> {
        loop {
            let core = self.core.as_mut()?;
            if let Some(tick) = core.next() {
                return Some(tick);
            }
            match self.next_piece() {
                Ok(core) => self.core = core,
                Err(refused) => (self.core, self.refused) = (None, Some(refused)),
            }
        }
    }

    /// The next clock.
    pub fn tick(&mut self) -> Option<Tick> {
        let Some((rise, direction)) = &mut self.rise else { return self.flat() };
        let clock = rise.next()?;
        let (around, up) = (clock.step[0] != 0, clock.step[1] != 0);
        let up = if up { *direction } else { 0 };
        let Shape::Arc(arc) = self.plan.shape else { return None };
        let mut tick = if around { self.flat()? } else { Tick { step: [0; 3], shifts: 0 } };
        tick.step[arc.axes[2]] = up;
        Some(tick)
    }

    /// How long all clocks are together, in the shortest: as many as there are, where all are as long.
    pub fn weight(mut self) -> (u64, u64) {
        let (mut clocks, mut weight) = (0, 0);
        while let Some(tick) = self.tick() {
            clocks += 1;
            weight += 1_u64 << tick.shifts;
        }
        (clocks, weight)
    }

    /// What an interpolator refused on the way.
    pub const fn refused(&self) -> Option<InputError> {
        self.refused
    }
}
