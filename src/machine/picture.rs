//! The picture of a program: the path coloured by its deviation, and along it the speed under each rule of feed.
//!
//! What is kept does not grow with the program: points of the path that are too close together to be seen apart become
//! one, and what lies along the path is kept in a fixed number of buckets.

use std::fmt::Write as _;

use super::Drawn;
use super::measure::Point;
use super::plan::Plan;
use super::program::Feed;
use super::report::Report;
use crate::plot::axis::Range;
use crate::plot::frame::{Frame, Marks, Place};
use crate::svg::{Svg, number};

/// More points than this are merged.
const POINTS: usize = 1 << 13;
/// Buckets along the path; then pairs are merged.
const BUCKETS: usize = 1 << 10;
/// The speed is taken over this way, BLU.
const WINDOW: f64 = 10.0;

/// Deviations from here on have the next colour, BLU.
const CLASSES: [f64; 5] = [0.25, 0.5, 0.75, 1.0, 1.25];
/// The class of G0.
const RAPID: usize = CLASSES.len() + 1;

const WIDTH: f64 = 860.0;
const LEFT: f64 = 72.0;
const RIGHT: f64 = 18.0;
const TOP: f64 = 84.0;
const TALLEST: f64 = 470.0;
const CHART: f64 = 132.0;
const BELOW: f64 = 56.0;

/// A point where the way so far has one colour.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: [i64; 3],
    class: u8,
}

/// The least and the greatest of something in one bucket.
type Band = Option<[f64; 2]>;

/// Something along the path.
#[derive(Clone, Debug)]
struct Along {
    width: f64,
    bands: Vec<Band>,
}

impl Along {
    const fn new() -> Along {
        Along { width: 0.01, bands: Vec::new() }
    }

    fn push(&mut self, mm: f64, value: f64) {
        let mut bucket = (mm.max(0.0) / self.width) as usize;
        while bucket >= BUCKETS {
            self.width *= 2.0;
            bucket /= 2;
            self.bands = self.bands.chunks(2).map(|pair| join(pair[0], pair.get(1).copied().flatten())).collect();
        }
        if self.bands.len() <= bucket {
            self.bands.resize(bucket + 1, None);
        }
        self.bands[bucket] = join(self.bands[bucket], Some([value, value]));
    }

    /// The middle of each bucket, mm, and its band.
    fn bands(&self) -> impl Iterator<Item = (f64, [f64; 2])> + '_ {
        self.bands.iter().enumerate().filter_map(|(i, b)| b.map(|b| ((i as f64 + 0.5) * self.width, b)))
    }
}

fn join(a: Band, b: Band) -> Band {
    match (a, b) {
        (Some(a), Some(b)) => Some([a[0].min(b[0]), a[1].max(b[1])]),
        (one, other) => one.or(other),
    }
}

/// What a picture keeps of a program as it is drawn.
#[derive(Clone, Debug)]
pub struct Picture {
    corners: Vec<Corner>,
    grain: u64,
    worst: f64,
    last: Corner,
    speeds: Vec<Along>,
    deviation: Along,
    /// Millimetres before the present move, and how many a BLU of it is.
    begun: f64,
    mm_per_blu: f64,
    /// The speed asked for, BLU a tick.
    commanded: f64,
    rapid: bool,
    seconds: f64,
    /// For each rule the begin of the window: BLU, ticks.
    window: [(f64, u64); 3],
    now: [u64; 3],
    rapid_speed: f64,
}

impl Picture {
    /// Nothing yet; `rules` of feed, ticks of so many `seconds`, G0 at `rapid` mm/min.
    #[must_use]
    pub fn new(rules: usize, seconds: f64, rapid: f64) -> Picture {
        let origin = Corner { at: [0; 3], class: RAPID as u8 };
        Picture {
            corners: vec![origin],
            grain: 1,
            worst: 0.0,
            last: origin,
            speeds: vec![Along::new(); rules.min(3)],
            deviation: Along::new(),
            begun: 0.0,
            mm_per_blu: 0.0,
            commanded: 1.0,
            rapid: false,
            seconds,
            window: [(0.0, 0); 3],
            now: [0; 3],
            rapid_speed: rapid,
        }
    }

    /// A move begins.
    pub fn begin(&mut self, plan: &Plan) {
        self.rapid = plan.feed == Feed::Rapid;
        self.mm_per_blu = if plan.length > 0.0 { plan.mm / plan.length } else { 0.0 };
        self.window = [0, 1, 2].map(|i| (0.0, self.now[i]));
        self.commanded = plan.speed(self.rapid_speed) * self.seconds;
    }

    /// Nothing moves for some seconds, which are no part of a speed.
    pub fn wait(&mut self, seconds: f64) {
        let ticks = (seconds / self.seconds).round().max(0.0) as u64;
        self.now = self.now.map(|now| now.saturating_add(ticks));
    }

    /// A clock of it.
    pub fn clock(&mut self, point: &Point) {
        let mm = self.begun + point.along * self.mm_per_blu;
        self.now = point.time;
        self.deviation.push(mm, point.off);
        for (i, along) in self.speeds.iter_mut().enumerate() {
            let (from, since) = self.window[i];
            let way = point.along - from;
            if way >= WINDOW && point.time[i] > since {
                let speed = way / (point.time[i] - since) as f64 / self.commanded;
                along.push(mm, speed);
                self.window[i] = (point.along, point.time[i]);
            }
        }
        self.worst = self.worst.max(point.off);
        let class = if self.rapid { RAPID } else { CLASSES.iter().filter(|&&c| self.worst >= c).count() };
        self.last = Corner { at: point.at, class: class as u8 };
        let Some(before) = self.corners.last() else { return };
        let apart = (0..3).map(|a| before.at[a].abs_diff(point.at[a])).max().unwrap_or(0);
        if apart >= self.grain {
            self.keep();
        }
    }

    fn keep(&mut self) {
        self.corners.push(self.last);
        self.worst = 0.0;
        if self.corners.len() > POINTS {
            self.grain *= 2;
            let mut kept = self.corners[0];
            let mut class = 0;
            let grain = self.grain;
            let mut all = vec![kept];
            for corner in &self.corners[1..] {
                class = if corner.class as usize == RAPID { corner.class } else { class.max(corner.class) };
                let apart = (0..3).map(|a| kept.at[a].abs_diff(corner.at[a])).max().unwrap_or(0);
                if apart >= grain {
                    kept = Corner { at: corner.at, class };
                    all.push(kept);
                    class = 0;
                }
            }
            self.corners = all;
        }
    }

    /// A move ends.
    pub fn end(&mut self, drawn: &Drawn<'_>) {
        // its end is a corner that can be seen, unless the whole move cannot
        let moved =
            self.corners.last().is_some_and(|c| (0..3).any(|a| c.at[a].abs_diff(self.last.at[a]) * 4 >= self.grain));
        if moved {
            self.keep();
        }
        self.begun += drawn.plan.mm;
    }

    /// The SVG file.
    #[must_use]
    pub fn svg(&self, report: &Report<'_>) -> String {
        let solid = self.corners.iter().any(|c| c.at[2] != self.corners[0].at[2]);
        let per_mm = [0, 1, 2].map(|a| report.settings.scale.per_mm(a));
        let points: Vec<[f64; 2]> = self
            .corners
            .iter()
            .chain([&self.last])
            .map(|c| project([0, 1, 2].map(|a| c.at[a] as f64 / per_mm[a]), solid))
            .collect();
        let (x, y) = (Range::of(points.iter().map(|p| p[0])), Range::of(points.iter().map(|p| p[1])));
        let room = WIDTH - LEFT - RIGHT;
        let scale = (room / x.length().max(1e-9)).min(TALLEST / y.length().max(1e-9));
        let (width, tall) = (x.length() * scale, (y.length() * scale).max(40.0));
        let left = LEFT + (room - width) / 2.0;
        let to = |p: [f64; 2]| [left + (p[0] - x.least) * scale, TOP + 12.0 + (y.greatest - p[1]) * scale];
        let speed = TOP + tall + BELOW;
        let deviation = speed + CHART + BELOW + 24.0;
        let height = deviation + CHART + BELOW;

        let mut svg = Svg::new();
        let [w, h] = [WIDTH, height].map(number);
        let size = format!("0 0 {w} {h}");
        let title = report.outcomes.first().map_or(String::new(), |o| format!("{}, by {}", report.name, o.run.choice));
        svg.open(
            "svg",
            &[
                ("xmlns", "http://www.w3.org/2000/svg"),
                ("viewBox", &size),
                ("width", &w),
                ("height", &h),
                ("role", "img"),
                ("aria-labelledby", "title desc"),
            ],
        );
        svg.text("title", &[("id", "title")], &title);
        svg.text("desc", &[("id", "desc")], &describe(report));
        svg.style(STYLE);
        svg.rectangle("paper", [0.0, 0.0, WIDTH, height]);
        svg.label("title", [LEFT, 28.0], "start", &title);
        svg.label("soft", [LEFT, 49.0], "start", &describe(report));
        legend(&mut svg);
        self.path(&mut svg, &points, to);
        scale_bar(&mut svg, scale, TOP + tall + 22.0);
        self.speed_chart(&mut svg, speed, report);
        self.deviation_chart(&mut svg, deviation);
        svg.finish()
    }

    /// One element for each run of one colour.
    fn path(&self, svg: &mut Svg, points: &[[f64; 2]], to: impl Fn([f64; 2]) -> [f64; 2]) {
        let classes: Vec<u8> = self.corners.iter().chain([&self.last]).map(|c| c.class).collect();
        // rapids first, the worst on top
        let order = std::iter::once(RAPID).chain(0..RAPID);
        for class in order {
            let mut d = String::new();
            let mut pen = usize::MAX;
            for i in 1..points.len() {
                if usize::from(classes[i]) != class {
                    continue;
                }
                let [a, b] = [to(points[i - 1]), to(points[i])].map(|p| p.map(number));
                if pen != i - 1 {
                    let _ = write!(d, "M{} {}", a[0], a[1]);
                }
                let _ = write!(d, "L{} {}", b[0], b[1]);
                pen = i;
            }
            if !d.is_empty() {
                svg.leaf("path", &[("class", &format!("path k{class}")), ("d", &d)]);
            }
        }
        if let (Some(&first), Some(&last)) = (points.first(), points.last()) {
            svg.circle("start", to(first), 3.5);
            svg.circle("end", to(last), 2.5);
        }
    }

    fn frame(&self, top: f64, y: Range) -> Frame {
        let place = Place { left: LEFT, top, width: WIDTH - LEFT - RIGHT, height: CHART };
        let x = Range { least: 0.0, greatest: self.begun.max(1e-6) };
        Frame { place, x, y }
    }

    fn speed_chart(&self, svg: &mut Svg, top: f64, report: &Report<'_>) {
        let all = || self.speeds.iter().flat_map(Along::bands);
        let most = all().map(|(_, b)| b[1]).fold(1.1, f64::max);
        let least = all().map(|(_, b)| b[0]).fold(0.9, f64::min);
        let pad = (most - least) * 0.05;
        let frame = self.frame(top, Range { least: least - pad, greatest: most + pad });
        frame.axes(
            svg,
            Marks { title: "along the path, mm", gap: 90.0, least: -3 },
            Marks { title: "1 = commanded", gap: 26.0, least: -3 },
        );
        svg.label("soft", [LEFT, top - 8.0], "start", "Speed over 10 BLU");
        let mut x = WIDTH - RIGHT;
        let names = report.settings.rules.iter().map(ToString::to_string);
        for (i, (along, name)) in self.speeds.iter().zip(names).enumerate() {
            band(svg, &frame, &format!("rule r{i}"), along);
            x -= 8.0 * name.len() as f64 + 30.0;
            svg.rectangle(&format!("rule r{i}"), [x, top - 17.0, 14.0, 9.0]);
            svg.label("soft", [x + 19.0, top - 8.0], "start", &name);
        }
        svg.line("asked", [LEFT, frame.py(1.0)], [WIDTH - RIGHT, frame.py(1.0)]);
    }

    fn deviation_chart(&self, svg: &mut Svg, top: f64) {
        let most = self.deviation.bands().map(|(_, b)| b[1]).fold(1.0, f64::max);
        let frame = self.frame(top, Range { least: 0.0, greatest: most * 1.05 });
        frame.axes(
            svg,
            Marks { title: "along the path, mm", gap: 90.0, least: -3 },
            Marks { title: "BLU", gap: 26.0, least: -3 },
        );
        svg.label("soft", [LEFT, top - 8.0], "start", "Distance from the program's own curve");
        band(svg, &frame, "off", &self.deviation);
    }
}

/// A filled band from the least to the greatest of each bucket, a hairline at least.
fn band(svg: &mut Svg, frame: &Frame, class: &str, along: &Along) {
    let half = along.width / 2.0;
    let mut d = String::new();
    let mut pen: Option<f64> = None;
    for (mm, [least, greatest]) in along.bands() {
        let [left, right] = [frame.px(mm - half), frame.px((mm + half).min(frame.x.greatest))].map(number);
        let (a, b) = (frame.py(least), frame.py(greatest));
        let joined = pen.is_some_and(|end| (end - (mm - half)).abs() < along.width / 4.0);
        let _ = write!(d, "{}{left} {}", if joined { "L" } else { "M" }, number(a));
        if (a - b).abs() > 0.3 {
            let _ = write!(d, "V{}V{}", number(b), number(a));
        }
        let _ = write!(d, "H{right}");
        pen = Some(mm + half);
    }
    if !d.is_empty() {
        svg.leaf("path", &[("class", class), ("d", &d)]);
    }
}

/// Seen from above, or with z from the front, 25° to the left and 50° from above.
fn project([x, y, z]: [f64; 3], solid: bool) -> [f64; 2] {
    if !solid {
        return [x, y];
    }
    let (turn, tilt) = (25_f64.to_radians(), 50_f64.to_radians());
    let (u, v) = (x * libm::cos(turn) - y * libm::sin(turn), x * libm::sin(turn) + y * libm::cos(turn));
    [u, v * libm::sin(tilt) + z * libm::cos(tilt)]
}

fn describe(report: &Report<'_>) -> String {
    let Some(outcome) = report.outcomes.first() else { return String::new() };
    let moves: u64 = report.survey.moves.iter().sum();
    format!(
        "{moves} moves, {} clocks, {:.0} mm; at most {:.3} BLU off, in line {}",
        outcome.run.clocks, report.survey.length, outcome.run.total.0, outcome.worst.line
    )
}

/// The colours of deviations.
fn legend(svg: &mut Svg) {
    let (mut x, y) = (LEFT, 68.0);
    let mut entry = |class: usize, text: &str| {
        svg.line(&format!("path k{class}"), [x, y - 4.0], [x + 18.0, y - 4.0]);
        svg.label("soft", [x + 23.0, y], "start", text);
        x += 41.0 + 6.5 * text.len() as f64;
    };
    for (class, limit) in CLASSES.iter().enumerate() {
        entry(class, &format!("< {limit} BLU"));
    }
    entry(CLASSES.len(), "more");
    entry(RAPID, "rapid");
}

/// A length of 1, 2 or 5 times a power of ten, mm.
fn scale_bar(svg: &mut Svg, scale: f64, y: f64) {
    let mut length = 1e-6;
    for k in 0.. {
        length = [1.0, 2.0, 5.0][k % 3] * 10_f64.powi(k as i32 / 3 - 6);
        if length * scale >= 60.0 || k > 60 {
            break;
        }
    }
    svg.line("bar", [LEFT, y], [LEFT + length * scale, y]);
    svg.label("soft", [LEFT, y - 5.0], "start", &format!("{length} mm"));
}

/// Colours for light and for dark surroundings.
const STYLE: &str = "
    svg { color-scheme: light dark; }
    text { font-family: system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif; font-size: 12px; fill: #1f2328; }
    .title { font-size: 16px; font-weight: 600; }
    .soft { fill: #59636e; }
    .paper { fill: #ffffff; }
    .frame { fill: none; stroke: #8c959f; }
    .grid line { stroke: #d8dee4; }
    .zero, .bar { stroke: #8c959f; }
    .bar { stroke-width: 2; }
    .path { fill: none; stroke-width: 1.6; stroke-linejoin: round; stroke-linecap: round; }
    .k0 { stroke: #0860ca; } .k1 { stroke: #1b8fa8; } .k2 { stroke: #2f9e54; }
    .k3 { stroke: #c79a00; } .k4 { stroke: #d9620c; } .k5 { stroke: #c2186a; }
    .k6 { stroke: #a8b1ba; stroke-width: 1; stroke-dasharray: 3 4; }
    .rule { stroke-width: 1; fill: none; }
    rect.rule { stroke: none; }
    .r0 { stroke: #e08a3c; } rect.r0 { fill: #e5874d; }
    .r1 { stroke: #7d5bd0; } rect.r1 { fill: #7d5bd0; }
    .r2 { stroke: #2f9e54; } rect.r2 { fill: #2f9e54; }
    .asked { stroke: #1f2328; stroke-width: 1; fill: none; stroke-dasharray: 4 2; }
    .off { stroke: #0860ca; stroke-width: 1; fill: none; }
    .start { fill: #ffffff; stroke: #1f2328; stroke-width: 1.5; }
    .end { fill: #1f2328; }
    @media (prefers-color-scheme: dark) {
      text { fill: #f0f6fc; }
      .soft { fill: #9198a1; }
      .paper { fill: #0d1117; }
      .frame, .zero, .bar { stroke: #656c76; }
      .grid line { stroke: #2b323b; }
      .k0 { stroke: #58a6ff; } .k1 { stroke: #4cc3d9; } .k2 { stroke: #56d364; }
      .k3 { stroke: #e3b341; } .k4 { stroke: #f0883e; } .k5 { stroke: #f778ba; }
      .k6 { stroke: #545d68; }
      .asked { stroke: #f0f6fc; }
      .off { stroke: #58a6ff; }
      .start { fill: #0d1117; stroke: #f0f6fc; }
      .end { fill: #f0f6fc; }
    }
  ";
