//! Cells that act by time rather than by their inputs alone: clocks, delays, the RC node; and the constant.

use super::CellKind;
use super::element::{Element, Kind, Parameter, Port};

/// The parameters of a clock, in ticks.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Clock {
    /// Ticks from one rising edge to the next.
    pub period: u64,
    /// Ticks for which it is 1 in each period.
    pub high: u64,
    /// The tick of the first rising edge; 0 before it.
    pub phase: u64,
}

/// The parameters of an RC delay.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Rc {
    /// R·C in ticks.
    pub tau: f64,
    /// The part of the full swing at which the output rises.
    pub rise: f64,
    /// The part of the full swing at which the output falls, not above `rise`.
    pub fall: f64,
}

/// The voltage of an RC node and the output of the threshold behind it.
///
/// The voltage is that of `v(t) = target + (v0 - target)·e^(-t/RC)`, in parts of the full swing. A node whose input is
/// unknown lies between two known ones, one pulled down and one pulled up: see [`RcDelay`].
#[derive(Clone, Copy, Debug)]
struct Node {
    volts: f64,
    since: u64,
    target: bool,
    output: bool,
}

impl Node {
    fn drive(&mut self, rc: &Rc, now: u64, target: bool) {
        let goal = f64::from(u8::from(self.target));
        let passed = (now - self.since) as f64 / rc.tau;
        self.volts = goal + (self.volts - goal) * libm::exp(-passed);
        self.since = now;
        self.target = target;
    }

    /// The tick, after `since`, at which the output follows the target; rounded up.
    fn due(&self, rc: &Rc) -> Option<u64> {
        if self.target == self.output {
            return None;
        }
        let ratio = if self.target { (1.0 - self.volts) / (1.0 - rc.rise) } else { self.volts / rc.fall };
        let ticks = libm::ceil(rc.tau * libm::log(ratio)).max(1.0);
        (ticks < u64::MAX as f64).then(|| self.since.saturating_add(ticks as u64))
    }
}

/// The state of an RC delay: the lowest and the highest voltage that the node may have. They are the same once the
/// input has been known for long enough; the output is x where they do not agree.
#[derive(Clone, Copy, Debug)]
pub struct RcDelay {
    low: Node,
    high: Node,
}

impl Default for RcDelay {
    /// Any voltage, nothing driven.
    fn default() -> Self {
        let node = |up| Node { volts: f64::from(u8::from(up)), since: 0, target: up, output: up };
        RcDelay { low: node(false), high: node(true) }
    }
}

impl RcDelay {
    /// The input changes, at tick `now`, to 0, 1 or (`None`) unknown.
    pub fn drive(&mut self, rc: &Rc, now: u64, input: Option<bool>) {
        self.low.drive(rc, now, input.unwrap_or(false));
        self.high.drive(rc, now, input.unwrap_or(true));
    }

    /// The next tick at which a threshold is crossed.
    #[must_use]
    pub fn due(&self, rc: &Rc) -> Option<u64> {
        [self.low.due(rc), self.high.due(rc)].into_iter().flatten().min()
    }

    /// Makes the crossings due at tick `now`.
    pub fn cross(&mut self, rc: &Rc, now: u64) {
        for node in [&mut self.low, &mut self.high] {
            if node.due(rc) == Some(now) {
                node.output = node.target;
            }
        }
    }

    /// Its state as numbers, for the lower voltage and then the upper: the bits of the voltage, since when, where it goes,
    /// and the output of its threshold.
    #[must_use]
    pub fn save(&self) -> [u64; 8] {
        let node = |n: &Node| [n.volts.to_bits(), n.since, n.target.into(), n.output.into()];
        let (low, high) = (node(&self.low), node(&self.high));
        std::array::from_fn(|i| if i < 4 { low[i] } else { high[i - 4] })
    }

    /// The state that [`save`](RcDelay::save) gave.
    #[must_use]
    pub fn restore(saved: &[u64; 8]) -> RcDelay {
        let node = |n: &[u64]| Node { volts: f64::from_bits(n[0]), since: n[1], target: n[2] != 0, output: n[3] != 0 };
        RcDelay { low: node(&saved[..4]), high: node(&saved[4..]) }
    }

    /// The output: unknown while it depends on a voltage that is.
    #[must_use]
    pub fn output(&self) -> Option<bool> {
        (self.low.output == self.high.output).then_some(self.low.output)
    }
}

const Y: Port = Port::output("y", "the output");
const TICKS: Kind = Kind::Integer { min: 1, max: i64::MAX };

/// The elements of this family.
pub const ELEMENTS: &[Element] = &[
    Element {
        name: "constant",
        summary: "constant",
        ports: &[Y],
        parameters: &[
            Parameter { name: "width", kind: Kind::WIDTH, default: Some("1"), doc: "bits of `y`" },
            Parameter { name: "value", kind: Kind::Value, default: None, doc: "the value" },
        ],
        meaning: "`y = value`, from time 0. A literal in a connection (`\"4'b10x1\"`) does the same.",
        source: "IEEE 1364-2005, 3.5",
        example: r#"{ "type": "constant", "parameters": { "width": 8, "value": "8'h0f" }, "connections": { "y": "limit" } }"#,
        build: |a| Ok(CellKind::Constant(Box::new(a.value("value")))),
    },
    Element {
        name: "clock",
        summary: "free-running clock",
        ports: &[Y],
        parameters: &[
            Parameter {
                name: "period",
                kind: Kind::Integer { min: 2, max: i64::MAX },
                default: None,
                doc: "ticks from one rising edge to the next",
            },
            Parameter {
                name: "high",
                kind: Kind::Integer { min: 0, max: i64::MAX },
                default: Some("0"),
                doc: "ticks of each period at 1; 0: half",
            },
            Parameter {
                name: "phase",
                kind: Kind::Integer { min: 0, max: i64::MAX },
                default: Some("0"),
                doc: "tick of the first rising edge",
            },
        ],
        meaning: "0 before tick `phase`; 1 at tick t where `(t - phase) mod period < high`, else 0.",
        source: "document B: тактова поредица Δt",
        example: r#"{ "type": "clock", "parameters": { "period": 20, "phase": 10 }, "connections": { "y": "dt" } }"#,
        build: |a| {
            let period = a.integer("period") as u64;
            let high = match a.integer("high") as u64 {
                0 => period / 2,
                high => high,
            };
            if high >= period {
                return Err(format!("a clock of period {period} cannot be high for {high} ticks"));
            }
            Ok(CellKind::Clock(Clock { period, high, phase: a.integer("phase") as u64 }))
        },
    },
    Element {
        name: "delay",
        summary: "plain delay",
        ports: &[Port::input("a", "the input"), Y],
        parameters: &[
            Parameter { name: "width", kind: Kind::WIDTH, default: Some("1"), doc: "bits of `a` and `y`" },
            Parameter { name: "ticks", kind: TICKS, default: Some("1"), doc: "the delay in ticks" },
        ],
        meaning: "`y(t) = a(t - ticks)`, x before that. Every change passes, however short (a transport delay).",
        source: "IEEE 1364-2005, 9.2.2 (intra-assignment delay)",
        example: r#"{ "type": "delay", "parameters": { "ticks": 5 }, "connections": { "a": "pulse", "y": "late" } }"#,
        build: |a| Ok(CellKind::Delay { width: a.width("width"), ticks: a.integer("ticks") as u64, init: None }),
    },
    Element {
        name: "rc_delay",
        summary: "RC delay with a threshold",
        ports: &[Port::input("a", "the input"), Y],
        parameters: &[
            Parameter { name: "r", kind: Kind::Quantity, default: None, doc: "resistance in ohm" },
            Parameter { name: "c", kind: Kind::Quantity, default: None, doc: "capacitance in farad" },
            Parameter {
                name: "rise",
                kind: Kind::Quantity,
                default: Some("0.5"),
                doc: "part of the swing at which `y` rises",
            },
            Parameter {
                name: "fall",
                kind: Kind::Quantity,
                default: Some("0.5"),
                doc: "part of the swing at which `y` falls, at most `rise`",
            },
        ],
        meaning: "The node relaxes towards the input, `v(t) = a + (v0 - a)·e^(-t/RC)`; `y` becomes 1 at the first tick with `v ≥ rise` and 0 at the first with `v ≤ fall`. A step from rest comes through after `RC·ln(1/(1 - rise))`, or `RC·ln(1/fall)`. A pulse too short to reach the threshold vanishes; a second one starts from the voltage that is there. While the input is x the voltage may be anything that some input would give, and `y` is x once that includes both sides.",
        source: "document B: RC група of the synchroniser",
        example: r#"{ "type": "rc_delay", "parameters": { "r": "10k", "c": "100p" }, "connections": { "a": "t2", "y": "t2_late" } }"#,
        build: |a| {
            let (rise, fall) = (a.quantity("rise"), a.quantity("fall"));
            if rise >= 1.0 || fall > rise {
                return Err(format!("thresholds need 0 < fall ≤ rise < 1, not fall = {fall} and rise = {rise}"));
            }
            let tau = a.quantity("r") * a.quantity("c") / a.tick;
            if !(tau.is_finite() && tau >= 1e-6) {
                return Err(format!("R·C is {tau:e} ticks: choose a finer timescale or larger parts"));
            }
            Ok(CellKind::RcDelay(Rc { tau, rise, fall }))
        },
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    const RC: Rc = Rc { tau: 100.0, rise: 0.5, fall: 0.25 };

    fn settle(node: &mut RcDelay) -> Option<(u64, Option<bool>)> {
        let due = node.due(&RC)?;
        node.cross(&RC, due);
        Some((due, node.output()))
    }

    /// 100·ln 2 = 69.31…, 100·ln 4 = 138.63…
    #[test]
    fn a_step_comes_through_after_the_logarithm() {
        let mut node = RcDelay::default();
        node.drive(&RC, 0, Some(false));
        assert_eq!(node.output(), None);
        assert_eq!(settle(&mut node), Some((139, Some(false)))); // from full charge at worst
        node.drive(&RC, 10_000, Some(true));
        assert_eq!(settle(&mut node), Some((10_070, Some(true))));
        node.drive(&RC, 20_000, Some(false));
        assert_eq!(settle(&mut node), Some((20_139, Some(false))));
        assert_eq!(settle(&mut node), None);
    }

    #[test]
    fn short_pulses_vanish_but_leave_charge() {
        let mut node = RcDelay::default();
        node.drive(&RC, 0, Some(false));
        settle(&mut node);
        node.drive(&RC, 10_000, Some(true));
        node.drive(&RC, 10_050, Some(false)); // v = 1 - e^-0.5 = 0.3935
        assert_eq!(node.due(&RC), None);
        node.drive(&RC, 10_070, Some(true)); // v = 0.3935·e^-0.2 = 0.3221
        // 100·ln(0.6779/0.5) = 30.4
        assert_eq!(settle(&mut node), Some((10_101, Some(true))));
    }

    #[test]
    fn an_unknown_input_holds_as_long_as_the_charge_does() {
        let mut node = RcDelay::default();
        node.drive(&RC, 0, Some(true));
        assert_eq!(settle(&mut node), Some((70, Some(true))));
        node.drive(&RC, 10_000, None);
        assert_eq!(settle(&mut node), Some((10_139, None)));
        node.drive(&RC, 20_000, Some(true));
        assert_eq!(settle(&mut node), Some((20_070, Some(true))));
    }
}
