//! [`Bench`](super::bench::Bench) for thousands of drawings at once: each is a lane of the batch engine, compared with its
//! algorithm on every clock at both levels of `dt`. What the other engines show is shown equal to the batch engine's lanes
//! by `engines`, and once a circuit by `Bench` on all of them, so exhaustive proofs need not run three times.

use std::sync::Arc;

use discreta::circuit::Circuit;
use discreta::engine::batch::{BatchEngine, Program};
use discreta::interpolate::{Clock, Columns, Interpolator, Stopped};
use discreta::netlist::{NetId, Slice};
use discreta::value::Word;

use super::bench::Bench;

/// A drawing: inputs in the order of [`Lanes::new`], and the algorithm that says what comes of them.
pub struct Drawing<A> {
    pub inputs: Vec<u64>,
    pub algorithm: A,
}

/// Lanes that run side by side: what a block of them reads stays in cache.
const BLOCK: usize = 2048;

/// A net that is compared, bit by bit.
struct Shown {
    name: String,
    bits: Vec<Slice>,
}

/// A circuit, drawn on by [`BLOCK`] lanes at a time, without a reset between one block and the next.
pub struct Lanes<'c> {
    circuit: &'c Circuit,
    engine: BatchEngine,
    start: NetId,
    dt: NetId,
    inputs: Vec<NetId>,
    columns: Columns,
    shown: Vec<Shown>,
    directions: Vec<Option<Slice>>,
    stops: Option<[Vec<Slice>; 2]>,
    pub clocks: u64,
}

/// 64 words of 64 bits, rows for columns.
fn transpose(rows: &mut [u64; 64]) {
    let (mut size, mut mask) = (32, 0x0000_0000_ffff_ffff_u64);
    while size > 0 {
        let mut k = 0;
        while k < 64 {
            let t = (rows[k] >> size ^ rows[k + size]) & mask;
            rows[k] ^= t << size;
            rows[k + size] ^= t;
            k = (k + size + 1) & !size;
        }
        size /= 2;
        mask ^= mask << size;
    }
}

impl<'c> Lanes<'c> {
    pub fn new(circuit: &'c Circuit, columns: Columns, inputs: &[&str]) -> Lanes<'c> {
        let netlist = &circuit.netlist;
        let program = Program::new(netlist).unwrap_or_else(|why| panic!("not for the batch engine: {why:?}"));
        let mut engine = BatchEngine::new(Arc::new(program), BLOCK);
        let find = |name: &str| netlist.find(name).map(|signal| netlist.bits(signal));
        let net = |name: &str| find(name).unwrap_or_else(|| panic!("no `{name}`"))[0].net;
        let axes = &["x", "y", "z"][..columns.at.len()];
        let names = columns.at.iter().chain(columns.left).chain(columns.sum).chain(&["end"]).chain(axes);
        let bits = |slices: &[Slice]| -> Vec<Slice> {
            slices.iter().flat_map(|s| (s.lo..s.lo + s.width).map(|lo| Slice { net: s.net, lo, width: 1 })).collect()
        };
        let shown = names
            .map(|&name| {
                // a register that a circuit around an interpolator does not show is the interpolator's
                let slices = find(name).or_else(|| find(&format!("core.{name}")));
                let slices = slices.unwrap_or_else(|| panic!("the circuit shows no `{name}`"));
                Shown { name: name.to_owned(), bits: bits(slices) }
            })
            .collect();
        let one = |name: &str| find(name).map(bits);
        let directions = axes.iter().map(|axis| one(&format!("{axis}_dir")).map(|bits| bits[0])).collect();
        let stops = one("overflow").zip(one("watchdog")).map(|(a, b)| [a, b]);
        let (start, dt) = (net("start"), net("dt"));
        engine.drive_each(dt, |_| Some(Word::ZERO));
        let inputs = inputs.iter().map(|name| net(name)).collect();
        Lanes { circuit, engine, start, dt, inputs, columns, shown, directions, stops, clocks: 0 }
    }

    fn level(&mut self, net: NetId, level: u64) -> Result<(), String> {
        self.engine.drive_each(net, |_| Some(Word::known(level)));
        self.engine.settle();
        if self.engine.any_unsettled() { Err("it does not settle".to_owned()) } else { Ok(()) }
    }

    /// What the nets are to show at rest (no pulses) or, with steps, while `dt` is high.
    fn values(&self, c: &Clock, step: [i8; 3]) -> impl Iterator<Item = u64> + use<> {
        let Columns { at, left, sum } = self.columns;
        let mut all = [0; 13];
        let values = (c.at.iter().take(at.len()).map(|&v| v as u64))
            .chain(c.left.iter().take(left.len()).copied())
            .chain(c.sum.iter().take(sum.len()).map(|&v| v as u64))
            .chain([u64::from(c.end)])
            .chain(step.iter().take(at.len()).map(|&s| u64::from(s != 0)));
        let mut count = 0;
        for (to, from) in all.iter_mut().zip(values) {
            *to = from;
            count += 1;
        }
        all.into_iter().take(count)
    }

    /// The first lane in which a net is not what it is to be.
    fn check(&self, now: &[(Clock, [i8; 3])]) -> Option<(usize, String)> {
        let words = self.engine.lane_words();
        // the values of each net in 64 lanes at a time become its bits in these lanes
        let mut planes: Vec<Vec<Vec<u64>>> = self.shown.iter().map(|s| vec![vec![0; words]; s.bits.len()]).collect();
        for (word, lanes) in now.chunks(64).enumerate() {
            let mut rows = vec![[0u64; 64]; self.shown.len()];
            for (lane, (clock, step)) in lanes.iter().enumerate() {
                for (row, value) in rows.iter_mut().zip(self.values(clock, *step)) {
                    row[lane] = value;
                }
            }
            for (row, planes) in rows.iter_mut().zip(&mut planes) {
                transpose(row);
                for (plane, &bits) in planes.iter_mut().zip(row.iter()) {
                    plane[word] = bits;
                }
            }
        }
        let mut differ = vec![0u64; words];
        for (shown, planes) in self.shown.iter().zip(&planes) {
            for (&bit, plane) in shown.bits.iter().zip(planes) {
                self.engine.differ(bit, plane, &mut differ);
            }
            if let Some(lane) = first_of(&differ, now.len()) {
                let value = self.engine.value(&shown.bits, lane);
                return Some((lane, format!("{} shows {value:?}, expected {:?}", shown.name, now[lane])));
            }
        }
        for (axis, direction) in self.directions.iter().enumerate() {
            let Some(bit) = *direction else { continue };
            let mut negative = vec![0u64; words];
            let mut steps = vec![0u64; words];
            for (lane, (_, step)) in now.iter().enumerate() {
                negative[lane / 64] |= u64::from(step[axis] < 0) << (lane % 64);
                steps[lane / 64] |= u64::from(step[axis] != 0) << (lane % 64);
            }
            let mut differ = vec![0u64; words];
            self.engine.differ(bit, &negative, &mut differ);
            differ.iter_mut().zip(&steps).for_each(|(d, s)| *d &= s);
            if let Some(lane) = first_of(&differ, now.len()) {
                return Some((lane, format!("a step {:?} in the wrong direction", now[lane].1)));
            }
        }
        None
    }

    /// Draws all of them, block by block, each to its end and two clocks more.
    pub fn draw<A: Interpolator>(&mut self, drawings: &mut dyn Iterator<Item = Drawing<A>>) -> Result<(), String> {
        loop {
            let mut block: Vec<Drawing<A>> = drawings.take(BLOCK).collect();
            if block.is_empty() {
                return Ok(());
            }
            let (lane, fault) = match self.draw_block(&mut block) {
                Ok(()) => continue,
                Err(fault) => fault,
            };
            let names = self.inputs.iter().map(|&net| self.circuit.netlist.net_name(net));
            let inputs: Vec<String> = names.zip(&block[lane].inputs).map(|(n, v)| format!("{n}={v}")).collect();
            return Err(format!("{}: {fault}", inputs.join(" ")));
        }
    }

    fn draw_block<A: Interpolator>(&mut self, block: &mut [Drawing<A>]) -> Result<(), (usize, String)> {
        let unsettled = |fault: String| (0, fault);
        let set = |lanes: &mut Lanes<'_>, block: &[Drawing<A>], flip: u64| {
            for i in 0..lanes.inputs.len() {
                let net = lanes.inputs[i];
                let width = lanes.circuit.netlist.net(net).width;
                let mask = if width >= 64 { u64::MAX } else { (1 << width) - 1 };
                // lanes without a drawing do as the first
                let value = |lane: usize| (block.get(lane).unwrap_or(&block[0]).inputs[i] ^ flip) & mask;
                lanes.engine.drive_each(net, |lane| Some(Word::known(value(lane))));
            }
        };
        set(self, block, 0);
        let mut last: Vec<Clock> = block.iter().map(|d| d.algorithm.state()).collect();
        let rest = |last: &[Clock]| last.iter().map(|&c| (c, [0; 3])).collect::<Vec<_>>();
        for level in [1, 0] {
            // already while start is 1
            self.level(self.start, level).map_err(unsettled)?;
            if let Some((lane, fault)) = self.check(&rest(&last)) {
                return Err((lane, format!("start = {level}: {fault}")));
            }
        }
        // after START the inputs no longer matter
        set(self, block, u64::MAX);
        let (mut clock, mut beyond) = (0u64, 0);
        while beyond < 2 {
            let next: Vec<Option<Clock>> = block.iter_mut().map(|d| d.algorithm.next()).collect();
            clock += 1;
            self.clocks += next.iter().flatten().count() as u64;
            // while dt is high: the pulses, and the registers as they were
            let pulses = last.iter().zip(&next).map(|(&c, n)| (c, n.map_or([0; 3], |n| n.step)));
            let pulses: Vec<_> = pulses.collect();
            self.level(self.dt, 1).map_err(unsettled)?;
            if let Some((lane, fault)) = self.check(&pulses) {
                return Err((lane, format!("clock {clock}, dt = 1: {fault}")));
            }
            self.level(self.dt, 0).map_err(unsettled)?;
            if next.iter().all(Option::is_none) {
                beyond += 1;
            }
            last.iter_mut().zip(next).for_each(|(last, next)| *last = next.unwrap_or(*last));
            if let Some((lane, fault)) = self.check(&rest(&last)) {
                return Err((lane, format!("clock {clock}, dt = 0: {fault}")));
            }
        }
        for (lane, drawing) in block.iter().enumerate() {
            let stopped = drawing.algorithm.stopped();
            if let Some(nets) = &self.stops {
                let shown = nets.each_ref().map(|bits| self.engine.number(bits, lane));
                let expected = [
                    matches!(stopped, Some(Stopped::Overflow { .. })),
                    matches!(stopped, Some(Stopped::Watchdog { .. })),
                ];
                if shown != expected.map(|stop| Some(u64::from(stop))) {
                    return Err((lane, format!("overflow and watchdog show {shown:?}, expected {stopped:?}")));
                }
            } else if !last[lane].end {
                return Err((lane, format!("the algorithm stopped without its end: {stopped:?}")));
            }
        }
        Ok(())
    }
}

fn first_of(lanes: &[u64], count: usize) -> Option<usize> {
    let word = lanes.iter().position(|&w| w != 0)?;
    let lane = word * 64 + lanes[word].trailing_zeros() as usize;
    (lane < count).then_some(lane)
}

/// Drawings from which lanes are worth their while.
const MANY: usize = 500;
/// Of many drawings one in so many is drawn on every engine (a prime, so that no pattern of the inputs keeps step).
const SELDOM: usize = 199;

/// Draws all of them: in lanes where they are many, and then some of them on every engine; else all on every engine. The
/// clocks compared.
pub fn draw_all<A: Interpolator, I: Iterator<Item = Drawing<A>>>(
    circuit: &Circuit,
    columns: Columns,
    inputs: &[&str],
    drawings: impl Fn() -> I,
) -> Result<u64, String> {
    let many = drawings().count() >= MANY;
    let mut clocks = 0;
    if many {
        let mut lanes = Lanes::new(circuit, columns, inputs);
        lanes.draw(&mut drawings())?;
        clocks += lanes.clocks;
    }
    let mut bench = Bench::new(circuit, columns);
    let ports: Vec<_> = inputs.iter().map(|name| bench.input(name)).collect();
    for Drawing { inputs: values, mut algorithm } in drawings().step_by(if many { SELDOM } else { 1 }) {
        let set: Vec<_> = ports.iter().copied().zip(values.iter().copied()).collect();
        let named = || inputs.iter().zip(&values).map(|(n, v)| format!("{n}={v}")).collect::<Vec<_>>().join(" ");
        bench.draw(&set, &mut algorithm).map_err(|fault| format!("{}: {fault}", named()))?;
    }
    Ok(clocks + bench.clocks)
}
