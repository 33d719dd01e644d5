//! A rectangle of the picture with axes: its grid, its ticks, and where a number is in it.

use super::axis::{Range, Ticks};
use crate::svg::Svg;

/// Pixels between a frame and the numbers beside it.
const GAP: f64 = 6.0;

/// Where a frame is, in pixels.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Place {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// A rectangle with a range along each side.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Frame {
    pub(crate) place: Place,
    pub(crate) x: Range,
    pub(crate) y: Range,
}

/// How an axis is marked.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Marks<'a> {
    /// What is along it, with its unit.
    pub(crate) title: &'a str,
    /// Pixels between two ticks at least.
    pub(crate) gap: f64,
    /// Ticks are no closer than this power of ten.
    pub(crate) least: i32,
}

impl Frame {
    pub(crate) fn px(&self, x: f64) -> f64 {
        self.place.left + (x - self.x.least) / self.x.length() * self.place.width
    }

    pub(crate) fn py(&self, y: f64) -> f64 {
        self.place.top + (self.y.greatest - y) / self.y.length() * self.place.height
    }

    pub(crate) fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.px(x), self.py(y)]
    }

    pub(crate) fn right(&self) -> f64 {
        self.place.left + self.place.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.place.top + self.place.height
    }

    fn ticks(&self, range: Range, pixels: f64, marks: Marks<'_>) -> Ticks {
        Ticks::new(range, marks.gap * range.length() / pixels, marks.least)
    }

    /// A line for every BLU, where they are far enough apart to be counted.
    pub(crate) fn unit_grid(&self, svg: &mut Svg) {
        let unit = self.place.width / self.x.length();
        if unit < 8.0 {
            return;
        }
        svg.open("g", &[("class", "unit")]);
        for x in Ticks::new(self.x, 1.0, 0).values() {
            svg.line("", [self.px(x), self.place.top], [self.px(x), self.bottom()]);
        }
        for y in Ticks::new(self.y, 1.0, 0).values() {
            svg.line("", [self.place.left, self.py(y)], [self.right(), self.py(y)]);
        }
        svg.close();
    }

    /// The frame with ticks along the bottom and the left side.
    pub(crate) fn axes(&self, svg: &mut Svg, x: Marks<'_>, y: Marks<'_>) {
        let Place { left, top, width, height } = self.place;
        let (x_ticks, y_ticks) = (self.ticks(self.x, width, x), self.ticks(self.y, height, y));
        svg.open("g", &[("class", "grid")]);
        for v in x_ticks.values() {
            svg.line("", [self.px(v), top], [self.px(v), self.bottom()]);
        }
        for v in y_ticks.values() {
            svg.line("", [left, self.py(v)], [self.right(), self.py(v)]);
        }
        svg.close();
        for (zero, from, to) in [
            (self.x.holds(0.0), [self.px(0.0), top], [self.px(0.0), self.bottom()]),
            (self.y.holds(0.0), [left, self.py(0.0)], [self.right(), self.py(0.0)]),
        ] {
            if zero {
                svg.line("zero", from, to);
            }
        }
        svg.rectangle("frame", [left, top, width, height]);
        for v in x_ticks.values() {
            svg.label("soft", [self.px(v), self.bottom() + GAP + 9.0], "middle", &x_ticks.label(v));
        }
        for v in y_ticks.values() {
            svg.label("soft", [left - GAP, self.py(v) + 4.0], "end", &y_ticks.label(v));
        }
        svg.label("soft", [left + width / 2.0, self.bottom() + GAP + 26.0], "middle", x.title);
        let [cx, cy] = [left - 50.0, top + height / 2.0].map(crate::svg::number);
        let turn = format!("rotate(-90 {cx} {cy})");
        let place = [("class", "soft"), ("x", &cx), ("y", &cy), ("text-anchor", "middle"), ("transform", &turn)];
        svg.text("text", &place, y.title);
    }
}
