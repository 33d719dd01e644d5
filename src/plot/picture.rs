//! The picture as a whole: what stands where.

use std::fmt::Write as _;

use super::Recording;
use super::axis::{Range, signed};
use super::frame::{Frame, Marks, Place};
use crate::interpolate::Ideal;
use crate::svg::{Svg, number};

const WIDTH: f64 = 760.0;
const LEFT: f64 = 66.0;
const RIGHT: f64 = 18.0;
/// Where the first frame begins; the title is above it.
const TOP: f64 = 62.0;
/// What a frame needs beneath it for numbers and a title.
const BELOW: f64 = 46.0;
const TALLEST: f64 = 440.0;
const LOWEST: f64 = 110.0;
const DEVIATION: f64 = 130.0;
/// Around the path, so that the words at its ends have room.
const PAD: [f64; 2] = [46.0, 26.0];

/// Dots mark the points of a path only while there are so few, and so far apart in pixels.
const DOTS: (u64, f64) = (400, 7.0);

/// Corners and points of curves closer than this in pixels are one.
const FINE: f64 = 0.3;

/// One picture: the path over the ideal curve, in space in two views, and the deviation along the clocks.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// What was drawn, by what.
    pub title: &'a str,
    /// What else there is to say, in one line.
    pub note: &'a str,
    /// The curve that the path is to follow.
    pub ideal: &'a Ideal,
    /// The path.
    pub recording: &'a Recording,
}

/// Colours, as ordinary rules for renderers that know no more; the second set is for dark surroundings. The paper is
/// painted too, since a page may be dark where the system is not.
const STYLE: &str = "
    svg { color-scheme: light dark; }
    text { font-family: system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif; font-size: 12px; fill: #1f2328; }
    .title { font-size: 16px; font-weight: 600; }
    .soft { fill: #59636e; }
    .halo { stroke: #ffffff; stroke-width: 4px; stroke-linejoin: round; paint-order: stroke; font-weight: 600; }
    .paper { fill: #ffffff; }
    .frame { fill: none; stroke: #8c959f; }
    .unit line { stroke: #eef1f4; }
    .grid line { stroke: #d8dee4; }
    .zero { stroke: #8c959f; }
    .limit { stroke: #8c959f; stroke-dasharray: 2 3; }
    .ideal { fill: none; stroke: #d4700a; stroke-width: 2.5; stroke-linecap: round; stroke-linejoin: round; }
    .path { fill: none; stroke: #0860ca; stroke-width: 1.8; stroke-linejoin: round; }
    .band { fill: #0860ca; stroke: #0860ca; stroke-width: 0.8; fill-opacity: 0.55; }
    .dot { fill: #0860ca; }
    .end { fill: #0860ca; stroke: #ffffff; stroke-width: 1.5; }
    .start { fill: #ffffff; stroke: #0860ca; stroke-width: 2; }
    .worst { stroke: #cf222e; stroke-width: 2; fill: none; }
    .worst-text { fill: #cf222e; }
    @media (prefers-color-scheme: dark) {
      text { fill: #f0f6fc; }
      .soft { fill: #9198a1; }
      .halo { stroke: #0d1117; }
      .paper { fill: #0d1117; }
      .frame, .zero, .limit { stroke: #656c76; }
      .unit line { stroke: #191f27; }
      .grid line { stroke: #2b323b; }
      .ideal { stroke: #f0a33e; }
      .path { stroke: #58a6ff; }
      .band { fill: #58a6ff; stroke: #58a6ff; }
      .dot { fill: #58a6ff; }
      .end { fill: #58a6ff; stroke: #0d1117; }
      .start { fill: #0d1117; stroke: #58a6ff; }
      .worst { stroke: #ff7b72; }
      .worst-text { fill: #ff7b72; }
    }
  ";

impl Picture<'_> {
    /// The SVG file.
    #[must_use]
    pub fn svg(&self) -> String {
        let views: &[[usize; 2]] = if self.recording.axes() == 3 { &[[0, 1], [0, 2]] } else { &[[0, 1]] };
        let curve = self.curve();
        let frames = self.frames(views, &curve);
        let below = frames.iter().map(Frame::bottom).fold(TOP, f64::max) + BELOW;
        let deviation = Place { left: LEFT, top: below + 24.0, width: WIDTH - LEFT - RIGHT, height: DEVIATION };
        let height = deviation.top + DEVIATION + BELOW;

        let mut svg = Svg::new();
        let [w, h] = [WIDTH, height].map(number);
        let size = format!("0 0 {w} {h}");
        let head = [
            ("xmlns", "http://www.w3.org/2000/svg"),
            ("viewBox", &size),
            ("width", &w),
            ("height", &h),
            ("role", "img"),
            ("aria-labelledby", "title desc"),
        ];
        svg.open("svg", &head);
        svg.text("title", &[("id", "title")], self.title);
        svg.text("desc", &[("id", "desc")], &self.description());
        svg.style(STYLE);
        svg.rectangle("paper", [0.0, 0.0, WIDTH, height]);
        svg.label("title", [LEFT, 26.0], "start", &shortened(self.title, 78));
        svg.label("soft", [LEFT, 47.0], "start", &shortened(self.note, 60));
        legend(&mut svg);
        for (frame, &view) in frames.iter().zip(views) {
            self.view(&mut svg, frame, view, &curve);
        }
        self.deviation(&mut svg, deviation);
        svg.finish()
    }

    fn description(&self) -> String {
        let (worst, clock) = self.recording.worst();
        let point = |p: [i64; 3]| {
            let all: Vec<String> = p[..self.recording.axes()].iter().map(i64::to_string).collect();
            format!("({})", all.join(", "))
        };
        format!(
            "A path of steps from {} to {} in {}, drawn over the ideal curve, and its distance from the curve along the \
             clocks: at most {:.3} BLU, at clock {clock}. {}",
            point(self.recording.start()),
            point(self.recording.last()),
            counted(self.recording.clocks()),
            worst.abs(),
            self.note
        )
    }

    /// Points along the ideal curve; of a curve that has no beginning and end, those nearest to the path.
    fn curve(&self) -> Vec<[f64; 3]> {
        let points = self.ideal.points(256);
        if !points.is_empty() {
            return points;
        }
        let corners: Vec<[f64; 3]> = self.recording.corners().map(|c| c.map(|v| v as f64)).collect();
        let apart = |a: [f64; 3], b: [f64; 3]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
        let length: f64 = corners.windows(2).map(|pair| apart(pair[0], pair[1])).sum();
        let grain = (length / 512.0).max(0.5);
        let mut points = Vec::new();
        let mut since = grain;
        for pair in corners.windows(2) {
            // long straight runs have points within, short ones are passed over
            let parts = (apart(pair[0], pair[1]) / grain).ceil().max(1.0) as u32;
            for i in 0..parts {
                if since >= grain {
                    points.push(
                        [0, 1, 2].map(|a| pair[0][a] + (pair[1][a] - pair[0][a]) * f64::from(i) / f64::from(parts)),
                    );
                    since = 0.0;
                }
                since += apart(pair[0], pair[1]) / f64::from(parts) + 1e-9;
            }
        }
        points.extend(corners.last());
        points.into_iter().map(|p| self.ideal.nearest(p)).filter(|p| p.iter().all(|v| v.is_finite())).collect()
    }

    /// Frames for the views side by side, at one scale, the same along both axes.
    fn frames(&self, views: &[[usize; 2]], curve: &[[f64; 3]]) -> Vec<Frame> {
        let along = |axis: usize| {
            let bounds = self.recording.bounds(axis).map(|v| v as f64);
            Range::of(bounds.into_iter().chain(curve.iter().map(|p| p[axis])))
        };
        let number = views.len() as f64;
        let between = LEFT * (number - 1.0);
        let width = (WIDTH - LEFT - RIGHT - between) / number;
        let ranges: Vec<[Range; 2]> = views.iter().map(|view| view.map(along)).collect();
        let scale = |inner: f64, axis: usize| {
            ranges.iter().map(|r| inner / r[axis].length().max(1.0)).fold(f64::INFINITY, f64::min)
        };
        let scale = scale(width - 2.0 * PAD[0], 0).min(scale(TALLEST - 2.0 * PAD[1], 1)).min(96.0);
        let tallest = ranges.iter().map(|r| r[1].length() * scale + 2.0 * PAD[1]).fold(LOWEST, f64::max);
        let mut left = LEFT;
        let mut frames = Vec::new();
        for range in ranges {
            let place = Place { left, top: TOP, width, height: tallest };
            frames.push(Frame { place, x: range[0].resized(width / scale), y: range[1].resized(tallest / scale) });
            left += width + LEFT;
        }
        frames
    }

    /// The path over the curve.
    fn view(&self, svg: &mut Svg, frame: &Frame, [h, v]: [usize; 2], curve: &[[f64; 3]]) {
        let titles = ["x, BLU", "y, BLU", "z, BLU"];
        let at = |p: [f64; 3]| frame.point([p[h], p[v]]);
        let blu = |p: [i64; 3]| at(p.map(|v| v as f64));
        frame.unit_grid(svg);
        let marks = |title, gap| Marks { title, gap, least: 0 };
        frame.axes(svg, marks(titles[h], 52.0), marks(titles[v], 26.0));
        svg.leaf("path", &[("class", "ideal"), ("d", &polyline(curve.iter().map(|&p| at(p))))]);
        svg.leaf("path", &[("class", "path"), ("d", &polyline(self.recording.corners().map(blu)))]);
        if self.recording.clocks() <= DOTS.0 && frame.place.width / frame.x.length() >= DOTS.1 {
            for p in dots(self.recording) {
                svg.circle("dot", blu(p), 3.0);
            }
        }
        let worst = self.recording.furthest();
        if worst.deviation != 0.0 {
            let nearest = self.ideal.nearest(worst.at.map(|v| v as f64));
            svg.line("worst", blu(worst.at), at(nearest));
        }
        self.ends(svg, blu(self.recording.start()), blu(self.recording.last()));
    }

    /// Marks the ends, with a word on the side where the path is not.
    fn ends(&self, svg: &mut Svg, start: [f64; 2], end: [f64; 2]) {
        let d = [end[0] - start[0], end[1] - start[1]];
        let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
        svg.circle("start", start, 5.0);
        svg.circle("end", end, 5.5);
        if length < 24.0 {
            svg.label("halo", [start[0] + 11.0, start[1] - 9.0], "start", "start, end");
            return;
        }
        let u = [d[0] / length, d[1] / length];
        let mut word = |at: [f64; 2], u: [f64; 2], text: &str| {
            let anchor = match u[0] {
                x if x > 0.4 => "start",
                x if x < -0.4 => "end",
                _ => "middle",
            };
            svg.label("halo", [at[0] + 11.0 * u[0], at[1] + 15.0 * u[1] + 4.0], anchor, text);
        };
        word(start, [-u[0], -u[1]], "start");
        word(end, u, "end");
    }

    /// The deviation along the clocks: a line while every clock can be seen, else the band that it stays in.
    fn deviation(&self, svg: &mut Svg, place: Place) {
        let (spans, per_span) = self.recording.spans();
        let worst = self.recording.furthest();
        let range = Range::of(spans.iter().flat_map(|s| [s.least, s.greatest]).chain([0.0]));
        let y = range.resized((range.length() * 1.45).max(0.2));
        let clocks = self.recording.clocks() as f64;
        let frame = Frame { place, x: Range { least: 0.0, greatest: clocks.max(1.0) }, y };
        svg.label("soft", [LEFT, place.top - 8.0], "start", self.sides());
        frame.axes(
            svg,
            Marks { title: "clocks", gap: 52.0, least: 0 },
            Marks { title: "deviation, BLU", gap: 24.0, least: -6 },
        );
        for limit in [-1.0, 1.0].into_iter().filter(|&l| y.holds(l)) {
            svg.line("limit", [place.left, frame.py(limit)], [frame.right(), frame.py(limit)]);
        }
        if per_span == 1 && spans.len() as f64 <= place.width {
            let points = (0u32..).zip(spans).map(|(i, s)| frame.point([f64::from(i), s.least]));
            svg.leaf("path", &[("class", "path"), ("d", &polyline(points.clone()))]);
            if self.recording.clocks() <= DOTS.0 && place.width / clocks.max(1.0) >= DOTS.1 {
                points.for_each(|p| svg.circle("dot", p, 2.5));
            }
        } else {
            svg.leaf("path", &[("class", "band"), ("d", &self.band(&frame))]);
        }
        let at = frame.point([worst.clock as f64, worst.deviation]);
        svg.circle("worst", at, 5.0);
        let text = match worst.deviation {
            0.0 => "never off the curve".to_owned(),
            deviation => format!("{} BLU at clock {}", signed(deviation, 3), worst.clock),
        };
        let right = at[0] < f64::midpoint(place.left, frame.right());
        let (dx, anchor) = if right { (10.0, "start") } else { (-10.0, "end") };
        let dy = if worst.deviation < 0.0 { 11.0 } else { -4.0 };
        svg.label("halo worst-text", [at[0] + dx, at[1] + dy], anchor, &text);
    }

    /// The least and greatest of each pixel's clocks, there and back.
    fn band(&self, frame: &Frame) -> String {
        let (spans, per_span) = self.recording.spans();
        let together = (spans.len() as f64 / frame.place.width).ceil().max(1.0) as usize;
        let columns: Vec<(f64, f64, f64)> = spans
            .chunks(together)
            .enumerate()
            .map(|(i, spans)| {
                let middle =
                    ((i * together) as u64 * per_span) as f64 + (spans.len() as u64 * per_span - 1) as f64 / 2.0;
                let least = spans.iter().map(|s| s.least).fold(f64::INFINITY, f64::min);
                let greatest = spans.iter().map(|s| s.greatest).fold(f64::NEG_INFINITY, f64::max);
                (middle.min(self.recording.clocks() as f64), least, greatest)
            })
            .collect();
        let there = columns.iter().map(|&(x, _, greatest)| frame.point([x, greatest]));
        let back = columns.iter().rev().map(|&(x, least, _)| frame.point([x, least]));
        polyline(there.chain(back)) + "Z"
    }

    /// What the sign of a deviation means.
    fn sides(&self) -> &'static str {
        match self.ideal {
            Ideal::Segment { .. } if self.recording.axes() == 3 => "distance from the line",
            Ideal::Segment { .. } => "deviation: + to the left of the line, − to its right",
            Ideal::Arc { .. } => "deviation: + outside the circle, − inside",
            Ideal::Conic { .. } => "deviation: + where the curve's polynomial is positive, − where it is negative",
        }
    }
}

/// What the lines are, at the top right.
fn legend(svg: &mut Svg) {
    let mut left = WIDTH - RIGHT - 276.0;
    for (class, text, room) in [("ideal", "ideal", 76.0), ("path", "path", 72.0), ("worst", "greatest deviation", 0.0)]
    {
        svg.line(class, [left, 43.0], [left + 18.0, 43.0]);
        svg.label("soft", [left + 24.0, 47.0], "start", text);
        left += room;
    }
}

/// Every point of a path of few clocks.
fn dots(recording: &Recording) -> Vec<[i64; 3]> {
    let mut all = vec![recording.start()];
    let corners: Vec<[i64; 3]> = recording.corners().collect();
    for pair in corners.windows(2) {
        let mut at = pair[0];
        while at != pair[1] {
            for (v, to) in at.iter_mut().zip(pair[1]) {
                *v += (to - *v).signum();
            }
            all.push(at);
        }
    }
    all
}

/// The data of a path through these points, without those that no one could see.
fn polyline(points: impl IntoIterator<Item = [f64; 2]>) -> String {
    let mut data = String::new();
    let mut kept: Option<[f64; 2]> = None;
    let mut skipped = None;
    let mut add = |p: [f64; 2], first: bool| {
        let _ = write!(data, "{}{},{}", if first { 'M' } else { 'L' }, number(p[0]), number(p[1]));
    };
    for p in points {
        if kept.is_some_and(|k| (p[0] - k[0]).abs() < FINE && (p[1] - k[1]).abs() < FINE) {
            skipped = Some(p);
            continue;
        }
        add(p, kept.is_none());
        (kept, skipped) = (Some(p), None);
    }
    if let Some(last) = skipped {
        add(last, false);
    }
    data
}

/// A text that is not longer than it may be.
fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

/// So many clocks.
fn counted(clocks: u64) -> String {
    if clocks == 1 { "1 clock".to_owned() } else { format!("{clocks} clocks") }
}
