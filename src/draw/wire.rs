//! The lines of one net: pieces that lie on one another become one, and dots mark where three or more meet.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::svg::number;

/// A coordinate in halves of a pixel, so that it can be compared.
fn key(value: f64) -> i64 {
    (value * 2.0).round() as i64
}

fn pixels(key: i64) -> f64 {
    key as f64 / 2.0
}

/// Lines and dots.
pub(super) struct Lines {
    /// Height, left, right.
    pub across: Vec<[f64; 3]>,
    /// Position, top, bottom.
    pub down: Vec<[f64; 3]>,
    pub dots: Vec<[f64; 2]>,
}

/// Spans on one line, joined where they touch.
fn joined(by_line: BTreeMap<i64, Vec<(i64, i64)>>) -> Vec<(i64, i64, i64)> {
    let mut all = Vec::new();
    for (line, mut spans) in by_line {
        spans.sort_unstable();
        let mut open: Option<(i64, i64)> = None;
        for (from, to) in spans {
            open = match open {
                Some((a, b)) if from <= b => Some((a, b.max(to))),
                Some((a, b)) => {
                    all.push((line, a, b));
                    Some((from, to))
                }
                None => Some((from, to)),
            };
        }
        all.extend(open.map(|(a, b)| (line, a, b)));
    }
    all
}

impl Lines {
    pub fn of(pieces: &[[[f64; 2]; 2]]) -> Lines {
        let (mut across, mut down) = (BTreeMap::<i64, Vec<_>>::new(), BTreeMap::<i64, Vec<_>>::new());
        let mut ends = std::collections::BTreeSet::new();
        for &[[x1, y1], [x2, y2]] in pieces {
            let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(key);
            ends.extend([(x1, y1), (x2, y2)]);
            if y1 == y2 {
                across.entry(y1).or_default().push((x1.min(x2), x1.max(x2)));
            } else {
                down.entry(x1).or_default().push((y1.min(y2), y1.max(y2)));
            }
        }
        let (across, down) = (joined(across), joined(down));
        let mut dots = Vec::new();
        for (x, y) in ends {
            let arms = |lines: &[(i64, i64, i64)], line: i64, at: i64| -> usize {
                let on = lines.iter().filter(|l| l.0 == line && l.1 <= at && at <= l.2);
                on.map(|l| usize::from(l.1 < at) + usize::from(at < l.2)).sum()
            };
            if arms(&across, y, x) + arms(&down, x, y) > 2 {
                dots.push([pixels(x), pixels(y)]);
            }
        }
        let whole = |lines: Vec<(i64, i64, i64)>| lines.into_iter().map(|(l, a, b)| [l, a, b].map(pixels)).collect();
        Lines { across: whole(across), down: whole(down), dots }
    }

    /// The lines as an SVG path.
    pub fn path(&self) -> String {
        let mut text = String::new();
        for [y, from, to] in self.across.iter().map(|l| l.map(number)) {
            let _ = write!(text, "M{from} {y}H{to}");
        }
        for [x, from, to] in self.down.iter().map(|l| l.map(number)) {
            let _ = write!(text, "M{x} {from}V{to}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::Lines;

    #[test]
    fn branches_have_a_dot_and_corners_have_none() {
        let lines = Lines::of(&[
            [[0.0, 0.0], [10.0, 0.0]],
            [[10.0, 0.0], [10.0, 20.0]],
            [[0.0, 0.0], [5.0, 0.0]],
            [[5.0, 0.0], [5.0, -8.5]],
        ]);
        assert_eq!(lines.path(), "M0 0H10M5 -8.5V0M10 0V20");
        assert_eq!(lines.dots, [[5.0, 0.0]]);
    }
}
