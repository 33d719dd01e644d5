//! For each shipped circuit the cases of a short proof: inputs, and the algorithm that says what comes of them.

use discreta::circuit::Circuit;
use discreta::interpolate::{DdaLine3d, EfLine, EfLine3d, Interpolator, Line3dInput, LineInput};

use super::bench::Bench;

/// Inputs by name, and the algorithm that is to agree on every clock.
pub type Case = (Vec<(&'static str, u64)>, Box<dyn Interpolator>);

/// A circuit and what shows that it is right.
pub struct Proof {
    /// Its file below `circuits/`.
    pub path: &'static str,
    /// The values of its parameters that the cases are for.
    pub parameters: &'static [(&'static str, i64)],
    /// The cases: few enough for a second, and all that are possible in the width chosen.
    pub cases: fn() -> Vec<Case>,
}

impl Proof {
    /// Draws every case; the first difference, if there is one.
    pub fn run(&self, circuit: &Circuit) -> Result<(), String> {
        let mut cases = (self.cases)();
        let columns = cases[0].1.columns();
        let mut bench = Bench::new(circuit, columns);
        for (inputs, algorithm) in &mut cases {
            let set: Vec<_> = inputs.iter().map(|&(name, value)| (bench.input(name), value)).collect();
            bench.draw(&set, algorithm.as_mut()).map_err(|fault| format!("{inputs:?}, {fault}"))?;
        }
        Ok(())
    }
}

/// Every circuit that has one.
pub const PROOFS: &[Proof] = &[
    Proof { path: "evaluation/line.json", parameters: &[("W", 3)], cases: ef_lines },
    Proof { path: "evaluation/line_gates.json", parameters: &[("W", 3)], cases: ef_lines },
    Proof { path: "three_axis/line.json", parameters: &[("W", 2)], cases: ef_lines_3d },
    Proof { path: "three_axis/line_gates.json", parameters: &[("W", 2)], cases: ef_lines_3d },
    Proof { path: "three_axis/dda_line.json", parameters: &[("W", 2)], cases: dda_lines_3d },
    Proof { path: "three_axis/dda_line_gates.json", parameters: &[("W", 2)], cases: dda_lines_3d },
];

/// Every line of 3 bits, from start points that change.
fn lines(algorithm: impl Fn(LineInput) -> Box<dyn Interpolator>) -> Vec<Case> {
    let pairs = (0..8).flat_map(|dx| (0..8).map(move |dy| (dx, dy)));
    pairs
        .map(|(dx, dy)| {
            let (xh, yh) = ((dx * 3) & 7, (dy * 5 + 1) & 7);
            let inputs = [("dx", dx), ("dy", dy), ("xh", xh), ("yh", yh)].map(|(name, v)| (name, v as u64)).to_vec();
            (inputs, algorithm(LineInput { xh, yh, dx, dy, bits: 3 }))
        })
        .collect()
}

fn ef_lines() -> Vec<Case> {
    lines(|input| Box::new(EfLine::new(input).unwrap()))
}

/// Every line in space of 2 bits, from start points that change.
fn lines_3d(algorithm: impl Fn(Line3dInput) -> Box<dyn Interpolator>) -> Vec<Case> {
    (0..64)
        .map(|k| {
            let increment = [k >> 4, (k >> 2) & 3, k & 3];
            let start = [(k + 1) & 3, (k / 3) & 3, (k / 5) & 3];
            let names = ["dx", "dy", "dz", "xh", "yh", "zh"].into_iter();
            let inputs = names.zip(increment.into_iter().chain(start)).map(|(name, v)| (name, v as u64)).collect();
            (inputs, algorithm(Line3dInput { start, increment, bits: 2 }))
        })
        .collect()
}

fn ef_lines_3d() -> Vec<Case> {
    lines_3d(|input| Box::new(EfLine3d::new(input).unwrap()))
}

fn dda_lines_3d() -> Vec<Case> {
    lines_3d(|input| Box::new(DdaLine3d::new(input, false).unwrap()))
}
