//! The batch engine against the event engine: every net, every lane, at every instant.

use std::sync::Arc;

use crate::support::design::{CLOCKS, Design};
use crate::support::{Rng, repository};
use discreta::cell::{CellKind, GateOp, ShiftOp};
use discreta::circuit::load;
use discreta::engine::batch::{BatchEngine, Program};
use discreta::netlist::{Netlist, SignalId};
use discreta::{Logic, Probe, Simulator, Value};

const LANES: usize = 12;
const SEEDS: u64 = 150;

/// A lane of the batch engine and a simulator of its own beside it.
struct Lane {
    sim: Simulator,
    /// It has not settled, in both.
    over: bool,
}

/// What both show.
struct Pair<'n> {
    netlist: &'n Netlist,
    signals: Vec<(SignalId, Probe)>,
    lanes: Vec<Lane>,
    /// Where each lane is in its block.
    places: Vec<usize>,
    batch: BatchEngine,
    now: u64,
}

fn set_of(batch: &BatchEngine, lanes: impl Iterator<Item = usize>) -> Vec<u64> {
    let mut set = vec![0; batch.lane_words()];
    lanes.for_each(|lane| set[lane / 64] |= 1 << (lane % 64));
    set
}

impl<'n> Pair<'n> {
    fn new(netlist: &'n Netlist, rng: &mut Rng) -> Pair<'n> {
        let program = Arc::new(Program::new(netlist).expect("no delays"));
        let lanes: Vec<Lane> = (0..LANES).map(|_| Lane { sim: Simulator::new(netlist), over: false }).collect();
        let signals = netlist.signal_ids();
        let signals = signals.map(|s| (s, lanes[0].sim.probe(&netlist.signal_path(s)).unwrap())).collect();
        let batch = BatchEngine::new(program.clone(), 1 + rng.below(1000) as usize);
        let mut places: Vec<usize> = (0..batch.lanes()).collect();
        rng.shuffle(&mut places);
        places.truncate(LANES);
        let mut pair = Pair { netlist, signals, lanes, places, batch, now: 0 };
        let rest = set_of(&pair.batch, 0..pair.batch.lanes());
        let mine = set_of(&pair.batch, pair.places.iter().copied());
        let others: Vec<u64> = rest.iter().zip(&mine).map(|(a, b)| a & !b).collect();
        pair.batch.stop(&others);
        for &(net, clock) in program.clock_cells() {
            pair.batch.drive(net, &Value::from_u64(u64::from(clock.phase == 0), 1), &rest);
        }
        pair
    }

    /// Sets inputs of a lane, settled by the next [`settle`](Pair::settle).
    fn set(&mut self, lane: usize, name: &str, value: &Value) {
        let net = self.netlist.signal(self.netlist.find(name).unwrap()).drive.unwrap();
        let input = self.lanes[lane].sim.input(name).unwrap();
        self.lanes[lane].sim.set_value(input, value);
        let lanes = set_of(&self.batch, std::iter::once(self.places[lane]));
        self.batch.drive(net, value, &lanes);
    }

    fn settle(&mut self, label: &str) {
        self.batch.settle();
        let errors = self.lanes.iter_mut().map(|l| !l.over && l.sim.settle().is_err());
        let errors: Vec<bool> = errors.collect();
        self.compare(&errors, label);
    }

    /// Runs the clocks within the netlist.
    fn run_to(&mut self, time: u64, program: &Program, label: &str) {
        let mut edges = Vec::new();
        for &(net, c) in program.clock_cells() {
            for t in self.now + 1..=time {
                let since = t.checked_sub(c.phase).map(|t| t % c.period);
                if since == Some(0) || since == Some(c.high) {
                    edges.push((t, net, since == Some(0)));
                }
            }
        }
        edges.sort();
        let all = set_of(&self.batch, 0..self.batch.lanes());
        for (_, net, level) in edges {
            self.batch.drive(net, &Value::from_u64(level.into(), 1), &all);
            self.batch.settle();
        }
        self.now = time;
        let errors: Vec<bool> = self.lanes.iter_mut().map(|l| !l.over && l.sim.run_to(time).is_err()).collect();
        self.compare(&errors, label);
    }

    fn compare(&mut self, errors: &[bool], label: &str) {
        let unsettled = self.batch.unsettled();
        for (number, lane) in self.lanes.iter_mut().enumerate() {
            let place = self.places[number];
            lane.over |= errors[number];
            assert_eq!(unsettled[place / 64] >> (place % 64) & 1 == 1, lane.over, "{label}, lane {number}: unsettled");
            if lane.over {
                continue;
            }
            for (signal, probe) in &self.signals {
                let (found, expected) = (self.batch.value(self.netlist.bits(*signal), place), lane.sim.value(probe));
                let name = self.netlist.signal_path(*signal);
                assert_eq!(found, expected, "{label}, lane {number}: {name}, batch first");
            }
        }
    }

    /// Begins a lane anew.
    fn restart(&mut self, lane: usize) {
        self.lanes[lane] = Lane { sim: Simulator::new(self.netlist), over: false };
        self.batch.restart(&set_of(&self.batch, std::iter::once(self.places[lane])));
    }
}

/// Random stimulus of the inputs of a random netlist; `restarts` where nothing in it runs by time.
fn drive(
    label: &str,
    design: &Design,
    netlist: &Netlist,
    rng: &mut Rng,
    restarts: bool,
    unknowns: &[u64],
) -> (usize, usize, u64) {
    let program = Program::new(netlist).unwrap();
    let mut pair = Pair::new(netlist, rng);
    let unknown: Vec<u64> = (0..LANES).map(|_| *rng.pick(unknowns)).collect();
    let mut fresh = [true; LANES];
    let steps = 16;
    for n in 0..steps {
        let label = format!("{label}, step {n}");
        for lane in 0..LANES {
            if restarts && rng.one_in(25) {
                pair.restart(lane);
                fresh[lane] = true;
            }
            for (i, (name, width)) in design.signals[..design.inputs].iter().enumerate() {
                let rest = ["s", "r"].contains(&name.as_str()) && !rng.one_in(4);
                if fresh[lane] || rest {
                    pair.set(lane, name, &Value::repeat(Logic::Zero, *width));
                } else if rng.one_in(2) {
                    let clock = CLOCKS.contains(&i) && !rng.one_in(8);
                    pair.set(lane, name, &rng.four_valued(*width, if clock { u64::MAX } else { unknown[lane] }));
                }
            }
            fresh[lane] = false;
        }
        pair.settle(&label);
        if !restarts && rng.one_in(2) {
            pair.run_to(n * 3, &program, &label);
        }
    }
    let over = pair.lanes.iter().filter(|l| l.over).count();
    (steps as usize * LANES, over, pair.batch.known_instants())
}

/// Nothing that is x of itself: states begin known, one driver of the bus is left.
fn make_known(design: &mut Design, rng: &mut Rng) {
    let mut driven = false;
    design.cells.retain(|c| !matches!(c.kind, CellKind::Tristate { .. }) || !std::mem::replace(&mut driven, true));
    for cell in &mut design.cells {
        match &mut cell.kind {
            kind @ CellKind::Tristate { .. } => {
                *kind = CellKind::Gate { op: GateOp::Buf, width: 4, inputs: 1 };
                cell.inputs.truncate(1);
            }
            CellKind::Flop(f) | CellKind::Latch(f) | CellKind::EdgeFlop(f) => {
                for value in [&mut f.init, &mut f.set_value, &mut f.reset_value] {
                    *value = rng.known(value.width());
                }
            }
            // of which there is no such form
            &mut CellKind::Power { width, b_width, .. } => {
                cell.kind = CellKind::Shift { op: ShiftOp::Left, a_width: width, b_width, width };
            }
            CellKind::Counter(c) => c.init = rng.known(c.init.width()),
            CellKind::Accumulator(a) => a.init = rng.known(a.init.width()),
            CellKind::Sr { init, .. } => *init = rng.known(1),
            CellKind::Constant(value) => **value = rng.known(value.width()),
            _ => {}
        }
    }
}

/// No delays, and no clocks where lanes begin anew.
fn without_time(design: &mut Design, restarts: bool) {
    for cell in &mut design.cells {
        match cell.kind {
            CellKind::Delay { width, .. } => cell.kind = CellKind::Gate { op: GateOp::Buf, width, inputs: 1 },
            CellKind::RcDelay(_) => cell.kind = CellKind::Gate { op: GateOp::Not, width: 1, inputs: 1 },
            CellKind::Clock(_) if restarts => cell.kind = CellKind::Constant(Box::new(Value::from_u64(1, 1))),
            _ => {}
        }
    }
}

#[test]
fn random_netlists_are_as_in_the_event_engine_in_every_lane() {
    let (mut instants, mut unsettled, mut settled) = (0, 0, 0);
    for seed in 0..150 {
        let mut rng = Rng::new(seed);
        let restarts = seed % 3 == 0;
        let mut design = if seed % 2 == 0 { Design::ordered(&mut rng) } else { Design::new(&mut rng) };
        without_time(&mut design, restarts);
        let netlist = design.build(&mut rng);
        let unknowns = &[u64::MAX, 30, 6];
        let (n, over, _) = drive(&format!("seed {seed}"), &design, &netlist, &mut rng, restarts, unknowns);
        instants += n;
        unsettled += over;
        settled += LANES - over;
    }
    println!("{instants} instants of lanes; {settled} lanes settled to the end, {unsettled} did not");
    assert!(settled > 900 && unsettled > 50, "{settled} settled, {unsettled} did not");
}

/// The form for what is all known: in most netlists nothing is ever x, in some a lane is now and then.
#[test]
fn random_netlists_without_x_are_as_in_the_event_engine_in_every_lane() {
    let (mut known, mut used) = (0, 0);
    for seed in 0..SEEDS {
        let mut rng = Rng::new(1000 + seed);
        let restarts = seed % 3 == 0;
        let mut design = if seed % 2 == 0 { Design::ordered(&mut rng) } else { Design::new(&mut rng) };
        make_known(&mut design, &mut rng);
        without_time(&mut design, restarts);
        let netlist = design.build(&mut rng);
        let unknowns = if seed % 5 == 0 { &[u64::MAX, 200][..] } else { &[u64::MAX] };
        let (_, _, n) = drive(&format!("seed {seed}"), &design, &netlist, &mut rng, restarts, unknowns);
        known += n;
        used += usize::from(n > 0);
    }
    println!("{known} instants in the known form, of {used} netlists");
    assert!(known > 500 && used > 40, "{known} instants, {used} netlists");
}

#[test]
fn the_shipped_circuits_are_as_in_the_event_engine_in_every_lane() {
    let mut circuits = 0;
    for folder in ["evaluation", "dda", "three_axis", "quadrant"] {
        for entry in std::fs::read_dir(repository(&format!("circuits/{folder}"))).unwrap() {
            let path = entry.unwrap().path();
            let circuit = load(&path).unwrap();
            let netlist = &circuit.netlist;
            let inputs: Vec<(String, u32)> =
                netlist.signals().iter().filter(|s| s.drive.is_some()).map(|s| (s.name.clone(), s.width)).collect();
            let mut rng = Rng::named(&path.to_string_lossy());
            let mut pair = Pair::new(netlist, &mut rng);
            let label = path.display().to_string();
            for n in 0..60u64 {
                for lane in 0..LANES {
                    for (name, width) in &inputs {
                        let unknown = if lane % 3 == 2 { 40 } else { u64::MAX };
                        let value = match name.as_str() {
                            "dt" => Value::from_u64(n % 2, 1),
                            "start" => Value::from_u64(u64::from(n == 0 || n % 20 == 2 * (lane as u64 % 5)), 1),
                            _ if n == 0 || rng.one_in(20) => rng.four_valued(*width, unknown),
                            _ => continue,
                        };
                        pair.set(lane, name, &value);
                    }
                }
                pair.settle(&format!("{label}, step {n}"));
            }
            circuits += 1;
        }
    }
    assert!(circuits > 20, "{circuits} circuits");
}
