//! Elements that Yosys has no cell for, as the attribute `discreta` names them: of modules that stand for one, of cells
//! that are read otherwise than Yosys simulates them.
//!
//! A module with `discreta = "counter edge=falling step=8'b00000001 init=8'bxxxxxxxx"` is that element, its ports the
//! element's pins, whatever cells it holds for others to see.

use std::fmt::Write as _;

use crate::Value;
use crate::cell::{Accumulator, CellKind, Clock, Counter, Edge, Flop, Rc};

/// An `$aldff` or `$dffsr` whose asynchronous controls act by their level.
pub const LEVEL: &str = "level";
/// A `$pos` that makes x of z.
pub const BUFFER: &str = "buf";

/// The element that a kind is, as text; none for a kind that Yosys has cells for.
#[must_use]
pub fn text(kind: &CellKind, element: &str) -> Option<String> {
    let bits = |value: &Value| format!("{}'b{}", value.width(), value.bit_string());
    let mut text = match kind {
        CellKind::Sr { set_dominates: true, init } => format!("sr dominant=set init={}", bits(init)),
        CellKind::Latch(f) => {
            format!("latch set={} reset={} init={}", bits(&f.set_value), bits(&f.reset_value), bits(&f.init))
        }
        CellKind::Flop(f) | CellKind::EdgeFlop(f) => {
            let name = kind.element();
            let values = [("set", &f.set_value), ("reset", &f.reset_value), ("init", &f.init)];
            let values: Vec<String> = values.iter().map(|(name, v)| format!("{name}={}", bits(v))).collect();
            format!("{name} edge={} {}", edge_name(f.edge), values.join(" "))
        }
        CellKind::Counter(c) => {
            format!("counter edge={} step={} init={}", edge_name(c.edge), bits(&c.step), bits(&c.init))
        }
        CellKind::Accumulator(a) => format!("accumulator edge={} init={}", edge_name(a.edge), bits(&a.init)),
        CellKind::Clock(c) => format!("clock period={} high={} phase={}", c.period, c.high, c.phase),
        CellKind::Delay { width, ticks, init } => {
            let init = init.as_ref().map_or(String::new(), |v| format!(" init={}", bits(v)));
            format!("delay width={width} ticks={ticks}{init}")
        }
        CellKind::RcDelay(rc) => format!("rc_delay tau={:?} rise={:?} fall={:?}", rc.tau, rc.rise, rc.fall),
        // the others Yosys has cells for: the export names each
        _ => return None,
    };
    if element != kind.element() {
        let _ = write!(text, " as={element}");
    }
    Some(text)
}

const fn edge_name(edge: Edge) -> &'static str {
    match edge {
        Edge::Rising => "rising",
        Edge::Falling => "falling",
    }
}

/// The element that a text names, and as which it was drawn.
#[must_use]
pub fn parse(text: &str) -> Option<(CellKind, &'static str)> {
    let mut words = text.split_ascii_whitespace();
    let name = words.next()?;
    let settings: Vec<(&str, &str)> = words.map(|w| w.split_once('=')).collect::<Option<_>>()?;
    let find = |name: &str| settings.iter().find(|s| s.0 == name).map(|s| s.1);
    let value = |name| find(name)?.parse::<Value>().ok().filter(|v: &Value| v.width() > 0);
    let number = |name| find(name)?.parse::<u64>().ok();
    let real = |name| find(name)?.parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0);
    let edge = || match find("edge")? {
        "rising" => Some(Edge::Rising),
        "falling" => Some(Edge::Falling),
        _ => None,
    };
    let flop = |edge| {
        let flop = Flop { edge, set_value: value("set")?, reset_value: value("reset")?, init: value("init")? };
        let width = flop.init.width();
        (flop.set_value.width() == width && flop.reset_value.width() == width).then(|| Box::new(flop))
    };
    let kind = match name {
        "dff" => CellKind::Flop(flop(edge()?)?),
        "edge_dff" => CellKind::EdgeFlop(flop(edge()?)?),
        "sr" if find("dominant") == Some("set") => {
            CellKind::Sr { set_dominates: true, init: value("init").filter(|v| v.width() == 1)? }
        }
        "latch" => CellKind::Latch(flop(Edge::Rising)?),
        "counter" => {
            let counter = Counter { edge: edge()?, step: value("step")?, init: value("init")? };
            (counter.step.width() == counter.init.width()).then(|| CellKind::Counter(Box::new(counter)))?
        }
        "accumulator" => CellKind::Accumulator(Box::new(Accumulator { edge: edge()?, init: value("init")? })),
        "clock" => {
            let clock = Clock { period: number("period")?, high: number("high")?, phase: number("phase")? };
            (clock.period >= 2 && (1..clock.period).contains(&clock.high)).then_some(CellKind::Clock(clock))?
        }
        "delay" => {
            let width = u32::try_from(number("width")?).ok().filter(|&w| w > 0)?;
            let init = match find("init") {
                Some(_) => Some(Box::new(value("init").filter(|v| v.width() == width)?)),
                None => None,
            };
            CellKind::Delay { width, ticks: number("ticks").filter(|&t| t > 0)?, init }
        }
        "rc_delay" => {
            let rc = Rc { tau: real("tau")?, rise: real("rise")?, fall: real("fall")? };
            (rc.rise < 1.0 && rc.fall <= rc.rise).then_some(CellKind::RcDelay(rc))?
        }
        _ => return None,
    };
    let element = match find("as") {
        Some(name) => crate::cell::element(name)?.name,
        None => kind.element(),
    };
    Some((kind, element))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let v = |text: &str| text.parse::<Value>().unwrap();
        let flop = Flop { edge: Edge::Falling, set_value: v("3'b01x"), reset_value: v("3'b110"), init: v("3'bz0x") };
        for kind in [
            CellKind::Sr { set_dominates: true, init: v("1'bz") },
            CellKind::Flop(Box::new(flop.clone())),
            CellKind::EdgeFlop(Box::new(flop)),
            CellKind::Counter(Box::new(Counter { edge: Edge::Rising, step: v("70'd3"), init: v("70'd5") })),
            CellKind::Delay { width: 4, ticks: 7, init: None },
            CellKind::Delay { width: 2, ticks: 7, init: Some(Box::new(v("2'b1x"))) },
            CellKind::RcDelay(Rc { tau: 1.0 / 3.0, rise: 0.632, fall: 0.1 }),
            CellKind::Clock(Clock { period: 7, high: 3, phase: 2 }),
        ] {
            let element = kind.element();
            assert_eq!(parse(&text(&kind, element).unwrap()), Some((kind, element)));
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for text in [
            "",
            "level",
            "clock period=1 high=1 phase=0",
            "clock period=4 high=4 phase=0",
            "delay width=0 ticks=1",
            "delay width=2 ticks=0",
            "delay width=2 ticks=1 init=3'b000",
            "rc_delay tau=inf rise=0.5 fall=0.5",
            "rc_delay tau=1 rise=0.5 fall=0.6",
            "rc_delay tau=1 rise=1 fall=0.6",
            "counter edge=up step=1'b1 init=1'b1",
            "counter edge=rising step=2'b1 init=1'b1",
            "dff edge=rising set=1'b1 reset=1'b1 init=2'b1",
            "dff edge=rising set=1'b1 reset=1'b1",
            "latch set=1'b1 reset=1'b1 init=1'b1 as=nothing",
        ] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
