//! Arcs: the centre and the radius from the words of a block, and how far round one goes.

use std::f64::consts::{PI, TAU};

use super::block::Block;
use super::canon::{Plane, Units};
use super::decimal::Decimal;
use super::fault::Fault;
use super::words::Word;
use crate::diag::Code;

/// An arc in its plane, in millimetres of the machine.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Arc {
    /// The plane.
    pub plane: Plane,
    /// The centre along the plane's first two axes.
    pub center: [Decimal; 2],
    /// The distances of start and end point from the centre.
    pub radii: [f64; 2],
    /// Clockwise, seen from where the third axis points.
    pub clockwise: bool,
    /// 1, and one more for each full turn.
    pub turns: u32,
}

impl Arc {
    /// Half of the two distances together.
    #[must_use]
    pub fn mean_radius(&self) -> f64 {
        self.radii[0].midpoint(self.radii[1])
    }

    /// The angle from start to end, radians, positive counter-clockwise. Where the two lie in exactly the same direction
    /// it is a full turn: nothing is rounded before that is decided.
    #[must_use]
    pub fn sweep(&self, from: [Decimal; 3], to: [Decimal; 3]) -> f64 {
        let [first, second, _] = self.plane.axes();
        let away = |p: [Decimal; 3]| [p[first] - self.center[0], p[second] - self.center[1]];
        let (a, b) = (away(from), away(to));
        let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(Decimal::to_f64);
        let (cross, dot) = (ax * by - ay * bx, ax * bx + ay * by);
        let angle = match Decimal::cross_sign(a, b) {
            0 if dot > 0.0 => 0.0,
            0 => PI,
            // of the sign that it has exactly, however small it is
            sign => libm::atan2(cross, dot).abs().max(f64::MIN_POSITIVE) * f64::from(sign),
        };
        let once = match self.clockwise {
            true if angle >= 0.0 => angle - TAU,
            false if angle <= 0.0 => angle + TAU,
            _ => angle,
        };
        let more = f64::from(self.turns - 1) * TAU;
        if self.clockwise { once - more } else { once + more }
    }
}

/// When the radii at the start and at the end of an arc are too different.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tolerance {
    /// Millimetres; beyond 0.1 % of the radius too.
    pub relative: f64,
    /// Millimetres, whatever the radius.
    pub absolute: f64,
}

impl Default for Tolerance {
    fn default() -> Tolerance {
        Tolerance::of(0.0283)
    }
}

impl Tolerance {
    /// LinuxCNC's rule, scaled: it has 0.0283 mm and, whatever the radius, a hundred times that.
    #[must_use]
    pub fn of(mm: f64) -> Tolerance {
        Tolerance { relative: mm, absolute: 100.0 * mm }
    }
}

/// Where grbl refuses, mm and beyond 0.1 % of the radius.
const GRBL: f64 = 0.005;

/// What an arc is made from.
pub struct Request<'a> {
    /// The words.
    pub block: &'a Block,
    /// The start point, mm.
    pub from: [Decimal; 3],
    /// The end point, mm.
    pub to: [Decimal; 3],
    /// The plane.
    pub plane: Plane,
    /// Centres are absolute (G90.1): counted from this origin.
    pub absolute: Option<[Decimal; 3]>,
    /// The unit of words.
    pub units: Units,
    /// G2.
    pub clockwise: bool,
    /// Which radii are too different.
    pub tolerance: Tolerance,
}

/// The words of a centre by axis.
const CENTERS: [u8; 3] = *b"IJK";

impl Request<'_> {
    /// Makes the arc; what other controls may refuse goes to `warnings`.
    ///
    /// # Errors
    /// Words that are missing or contradict each other; no such radius.
    pub fn arc(&self, warnings: &mut Vec<Fault>) -> Result<Arc, Fault> {
        let [first, second, third] = self.plane.axes();
        if let Some(word) = self.block.get(CENTERS[third]) {
            let (name, axes) = (char::from(word.letter), self.plane_name());
            return Err(Fault::new(Code::BadArc, word.at.clone(), format!("{name} in an arc of the plane {axes}"))
                .help("take the word out, or choose the plane with G17, G18 or G19"));
        }
        let centers = [self.block.get(CENTERS[first]), self.block.get(CENTERS[second])];
        let turns = self.turns()?;
        match (self.block.get(b'R'), centers) {
            (Some(r), [None, None]) => self.with_radius(r, turns),
            (None, [None, None]) => Err(Fault::new(Code::BadArc, self.place(), "an arc without centre or radius")
                .help(format!(
                    "give the centre with {} and {}, counted from the start point, or the radius with R",
                    char::from(CENTERS[first]),
                    char::from(CENTERS[second])
                ))),
            (Some(r), _) => Err(Fault::new(Code::BadArc, r.at.clone(), "an arc with both a centre and a radius")
                .help("take R out, or the words of the centre")),
            (None, centers) => self.around_center(centers, turns, warnings),
        }
    }

    fn plane_name(&self) -> &'static str {
        match self.plane {
            Plane::Xy => "XY (G17)",
            Plane::Xz => "XZ (G18)",
            Plane::Yz => "YZ (G19)",
        }
    }

    /// The first word that has to do with the arc.
    fn place(&self) -> std::ops::Range<usize> {
        self.block.place()
    }

    fn turns(&self) -> Result<u32, Fault> {
        let Some(p) = self.block.get(b'P') else { return Ok(1) };
        match p.value.to_whole() {
            Some(n @ 1..=1_000_000) => Ok(n as u32),
            _ => Err(Fault::new(Code::BadArc, p.at.clone(), format!("an arc of {} turns", p.value))
                .help("P is a whole number from 1 to 1000000")),
        }
    }

    fn around_center(&self, words: [Option<&Word>; 2], turns: u32, warnings: &mut Vec<Fault>) -> Result<Arc, Fault> {
        let axes = self.plane.axes();
        let mut center = [Decimal::ZERO; 2];
        for (i, word) in words.into_iter().enumerate() {
            let axis = axes[i];
            center[i] = match (word, self.absolute) {
                (Some(word), Some(origin)) => origin[axis] + self.units.to_mm(word.value),
                (Some(word), None) => self.from[axis] + self.units.to_mm(word.value),
                (None, None) => self.from[axis],
                (None, Some(_)) => {
                    let name = char::from(CENTERS[axis]);
                    let message = format!("an absolute centre (G90.1) without {name}");
                    return Err(Fault::new(Code::BadArc, self.place(), message).help("give both of its coordinates"));
                }
            };
        }
        let away = |p: [Decimal; 3]| [0, 1].map(|i| (p[axes[i]] - center[i]).to_f64());
        let (a, b) = (away(self.from), away(self.to));
        let radii = [a[0].hypot(a[1]), b[0].hypot(b[1])];
        if radii.contains(&0.0) {
            let which = if radii[0] == 0.0 { "start" } else { "end" };
            return Err(Fault::new(Code::BadArc, self.place(), format!("the centre of this arc is its {which} point"))
                .help("an arc has a radius above 0: look at the words of its centre"));
        }
        let off = (radii[0] - radii[1]).abs();
        let relative = off / radii[0].max(radii[1]);
        let Tolerance { relative: near, absolute } = self.tolerance;
        if off > absolute || off > near && relative > 0.001 {
            let [r, s] = radii;
            let message = format!("the radius is {r:.4} mm at the start of this arc and {s:.4} mm at its end");
            let help = if self.absolute.is_some() {
                "look at the centre, which is absolute (G90.1) here"
            } else {
                "look at the centre, which counts from the start point (G91.1); `--arc-tolerance` allows more"
            };
            return Err(Fault::new(Code::BadArc, self.place(), message).label(format!("{off:.4} mm apart")).help(help));
        }
        if off > GRBL && relative > 0.001 {
            let message = "the radii at the start and at the end of an arc differ by more than 0.005 mm and 0.1 %";
            warnings.push(
                Fault::new(Code::DoubtfulBlock, self.place(), message)
                    .label(format!("{off:.4} mm apart"))
                    .help("grbl refuses it: write more digits, or a centre that fits"),
            );
        }
        Ok(Arc { plane: self.plane, center, radii, clockwise: self.clockwise, turns })
    }

    /// The centre is on the perpendicular through the middle of the chord, on the side that makes the arc at most half a
    /// turn, or with a negative R at least that.
    fn with_radius(&self, word: &Word, turns: u32) -> Result<Arc, Fault> {
        let axes = self.plane.axes();
        let delta = [0, 1].map(|i| self.to[axes[i]] - self.from[axes[i]]);
        if delta == [Decimal::ZERO; 2] {
            return Err(Fault::new(Code::BadArc, word.at.clone(), "an arc with a radius that ends where it begins")
                .help("there are many such circles: give the centre in place of R"));
        }
        let radius = self.units.to_mm(word.value);
        if radius == Decimal::ZERO {
            return Err(Fault::new(Code::BadArc, word.at.clone(), "an arc of radius 0")
                .help("a radius is above 0, or below it for the longer way round"));
        }
        // in nanometres, so that the squares are whole numbers
        let nm = |v: Decimal| i128::from(v.in_units(Decimal::scaled(1, 6).unwrap_or_default()).unwrap_or(i64::MAX / 4));
        let [dx, dy] = delta.map(nm);
        // (2·height)² = (2R)² − chord²
        let chord = dx * dx + dy * dy;
        let rest = 4 * nm(radius) * nm(radius) - chord;
        if rest < 0 {
            // each coordinate may be off by half of its last place, seen at 3 digits at least
            let places = [Some(word), self.block.get(b"XYZ"[axes[0]]), self.block.get(b"XYZ"[axes[1]])];
            let digits = places.into_iter().flatten().map(|w| w.decimals).max().unwrap_or(0).clamp(3, 9);
            let last = self.units.to_mm(Decimal::scaled(1, digits).unwrap_or_default()).to_f64();
            let short = (chord as f64).sqrt() / 2e6 - radius.abs().to_f64();
            if short > 1.5 * last {
                let half = (chord as f64).sqrt() / 2e6;
                let message = format!("a radius of {} mm does not reach the end point", radius.abs());
                return Err(Fault::new(Code::BadArc, word.at.clone(), message)
                    .label(format!("half of the chord is {half:.4} mm"))
                    .help("give a greater R, or look at the end point"));
            }
        }
        let height = rest.max(0).isqrt() as f64 / 2.0;
        let left = (self.clockwise == (word.value.signum() < 0)) as i32 * 2 - 1;
        let [x, y] = [dx, dy].map(|v| v as f64);
        let length = x.hypot(y);
        let (mx, my) = (-y / length * height * f64::from(left) / 1e6, x / length * height * f64::from(left) / 1e6);
        let half = [0, 1].map(|i| delta[i].over(Decimal::whole(2)).unwrap_or_default());
        let center = [
            self.from[axes[0]] + half[0] + Decimal::nearest(mx).unwrap_or_default(),
            self.from[axes[1]] + half[1] + Decimal::nearest(my).unwrap_or_default(),
        ];
        let r = radius.abs().to_f64().max(length / 2e6);
        Ok(Arc { plane: self.plane, center, radii: [r, r], clockwise: self.clockwise, turns })
    }
}
