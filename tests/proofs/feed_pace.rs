//! What is left of the constant speed: length over time of every accelerated line, beside the commanded speed.

use discreta::interpolate::feed::pace;
use discreta::interpolate::{Clock, EfLine, EfLine3d, EfLineFast, Line3dInput, LineInput};

/// The slowest and the fastest, with and without the rule.
#[derive(Clone, Copy, Debug)]
struct Range {
    raw: (f64, f64),
    constant: (f64, f64),
}

impl Range {
    const EMPTY: Range = Range { raw: (f64::MAX, 0.0), constant: (f64::MAX, 0.0) };

    fn add(&mut self, length: f64, clocks: &[usize]) {
        for (range, constant) in [(&mut self.raw, false), (&mut self.constant, true)] {
            let speed = pace(length, clocks.iter().copied(), constant);
            *range = (range.0.min(speed), range.1.max(speed));
        }
    }

    fn shown(self) -> [String; 4] {
        [self.raw.0, self.raw.1, self.constant.0, self.constant.1].map(|n| format!("{n:.3}"))
    }
}

fn every_8_bit_line<I: Iterator<Item = Clock>>(new: impl Fn(LineInput) -> I) -> Range {
    let (mut range, mut axes) = (Range::EMPTY, Vec::new());
    for dx in 0..256 {
        for dy in 0..256 {
            if dx + dy > 0 {
                axes.clear();
                axes.extend(new(LineInput::new(dx, dy)).map(|c| c.axes()));
                range.add(((dx * dx + dy * dy) as f64).sqrt(), &axes);
            }
        }
    }
    range
}

/// By hand: n steps of which m are diagonal take n + 0.41·m, least √(1 + q²) / (1 + 0.41·q) at q = m/n = 0.41, 1/1.0808;
/// greatest at q = 1, √2/1.41.
#[test]
fn every_8_bit_accelerated_line() {
    let range = every_8_bit_line(|line| EfLineFast::new(line).unwrap());
    assert_eq!(range.shown(), ["1.000", "1.414", "0.925", "1.003"]);
    assert_eq!(format!("{:.3}", range.constant.1 / range.constant.0), "1.084");
}

#[test]
fn every_8_bit_line_of_one_step_a_clock() {
    // a clock without a step, which x = 0 has, is lost time: (0, 1) takes two intervals
    let range = every_8_bit_line(|line| EfLine::new(line).unwrap().filter(|c| c.axes() > 0));
    assert_eq!(range.shown()[..2], ["0.707", "1.000"]);
    assert_eq!(range.raw, range.constant, "the rule has nothing to do");
}

fn every_6_bit_line_in_space<I: Iterator<Item = Clock>>(new: impl Fn(Line3dInput) -> I) -> Range {
    let (mut range, mut axes) = (Range::EMPTY, Vec::new());
    for n in 1..1 << 18 {
        let increment = [n & 63, n >> 6 & 63, n >> 12];
        axes.clear();
        axes.extend(new(Line3dInput { start: [0; 3], increment, bits: 6 }).map(|c| c.axes()));
        let length = (increment.iter().map(|d| d * d).sum::<i64>() as f64).sqrt();
        range.add(length, &axes);
    }
    println!("{range:?}");
    range
}

/// Steps of the second and third axis seldom fall together, and two steps of two axes take longer (2.82) than one of
/// three and one of one (2.73): so a line in space may be slower than 0.887.
#[test]
fn every_6_bit_accelerated_line_in_space() {
    let range = every_6_bit_line_in_space(|line| EfLine3d::new(line).unwrap());
    assert_eq!(range.shown(), ["1.000", "1.732", "0.868", "1.003"]);
    let centred = every_6_bit_line_in_space(|line| EfLine3d::centred(line).unwrap());
    assert_eq!(centred.shown(), ["1.000", "1.732", "0.869", "1.003"]);
}

/// If each step of the third axis fell on one of the second: n steps, m of them of two axes or three, k of three.
#[test]
fn every_6_bit_line_in_space_whose_steps_fall_together() {
    let mut range = Range::EMPTY;
    for n in 1..64_usize {
        for (m, k) in (0..=n).flat_map(|m| (0..=m).map(move |k| (m, k))) {
            let axes: Vec<usize> = (0..n).map(|i| 1 + usize::from(i < m) + usize::from(i < k)).collect();
            range.add(((n * n + m * m + k * k) as f64).sqrt(), &axes);
        }
    }
    assert_eq!(range.shown(), ["1.000", "1.732", "0.887", "1.003"]);
}
