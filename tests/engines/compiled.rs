//! The compiled engine against the event engine: every net at every tick, on random netlists with x and z at random
//! times, whatever is observed and however the circuit is cut.
#![cfg(feature = "compiled")]

use crate::support;

use std::sync::Arc;

use crate::support::design::{CLOCKS, Cell, Design, Operand};
use crate::support::{Rng, repository};
use discreta::Value;
use discreta::cell::memory::{ReadPort, WritePort};
use discreta::cell::{AddOp, CellKind, Clock, Edge, Flop, GateOp, Memory};
use discreta::engine::{AutoEngine, CompiledEngine, Engine, EventEngine, Unsettled};
use discreta::netlist::{NetId, Netlist};
use discreta::value::Word;
use needs::needs;

/// Two engines on one netlist.
pub(super) struct Pair<'n> {
    netlist: &'n Netlist,
    /// Nets that a cell reads or that have a name.
    used: Vec<bool>,
    pub event: EventEngine,
    pub compiled: CompiledEngine,
}

impl<'n> Pair<'n> {
    pub fn new(netlist: &'n Netlist, chunk: usize, observed: impl Fn(NetId) -> bool) -> Pair<'n> {
        let mut event = EventEngine::new(netlist);
        let mut compiled = CompiledEngine::with_partition_size(netlist, chunk).unwrap();
        for net in netlist.net_ids().filter(|&n| observed(n)) {
            event.observe(net);
            compiled.observe(net);
        }
        Pair { netlist, used: netlist.used(), event, compiled }
    }

    /// The same, its first input a clock; the other inputs, each with its width.
    pub fn clocked(
        netlist: &'n Netlist,
        design: &Design,
        chunk: usize,
        observed: Option<usize>,
    ) -> (Pair<'n>, Vec<(NetId, u32)>) {
        let mut pair = Pair::new(netlist, chunk, |net| Some(net.index()) == observed);
        let mut inputs: Vec<(NetId, u32)> = (0..design.inputs)
            .map(|i| (netlist.bits(netlist.find(&design.signals[i].0).unwrap())[0].net, design.signals[i].1))
            .collect();
        let (net, _) = inputs.remove(0);
        let clock = Clock { period: 4, high: 2, phase: 1 };
        pair.event.add_clock(net, clock);
        pair.compiled.add_clock(net, clock);
        (pair, inputs)
    }

    pub fn drive(&mut self, net: NetId, value: &Value) {
        let words: Vec<Word> = value.words().collect();
        self.event.drive(net, &words);
        self.compiled.drive(net, &words);
    }

    /// Whether both settle.
    pub fn settle(&mut self, label: &dyn Fn() -> String) -> bool {
        let (a, b) = (self.event.settle(), self.compiled.settle());
        assert_eq!(sorted(a.clone()), sorted(b), "{}", label());
        if a.is_ok() {
            self.compare(label);
        }
        a.is_ok()
    }

    fn run_to(&mut self, until: u64, label: &dyn Fn() -> String) -> bool {
        (self.event.now()..=until).all(|tick| self.run_far(tick, label))
    }

    /// Runs both to a tick without a look in between.
    pub fn run_far(&mut self, until: u64, label: &dyn Fn() -> String) -> bool {
        loop {
            let (a, b) = (to(&mut self.event, until), to(&mut self.compiled, until));
            assert_eq!(sorted(a.clone()), sorted(b), "{}", label());
            if a.is_err() {
                return false;
            }
            if self.event.now() == until && self.compiled.now() == until {
                self.compare(label);
                return true;
            }
        }
    }

    fn compare(&mut self, label: &dyn Fn() -> String) {
        for net in self.netlist.net_ids() {
            let (a, b) = (self.event.read(net), self.compiled.read(net));
            // an inverted output that nobody can see has no value in the event engine
            if !self.used[net.index()] && self.netlist.net_name(net).ends_with(".qn") {
                continue;
            }
            assert_eq!(a, b, "{}: {} at {}", label(), self.netlist.net_name(net), self.event.now());
        }
        for cell in self.netlist.cell_ids() {
            // what nobody reads the event engine may leave out
            if let Some(contents) = self.event.contents(cell) {
                assert_eq!(
                    Some(contents),
                    self.compiled.contents(cell),
                    "{}: {}",
                    label(),
                    self.netlist.cell_path(cell)
                );
            }
        }
        let (a, b) = (self.event.take_unknown_controls(), self.compiled.take_unknown_controls());
        assert_eq!(a, b, "{}", label());
        // of the nets that went away and came back, only the event engine tells
        for net in self.compiled.changes() {
            assert!(self.event.changes().contains(net), "{}: {}", label(), self.netlist.net_name(*net));
        }
        self.event.clear_changes();
        self.compiled.clear_changes();
        assert_eq!(self.event.next_event(), self.compiled.next_event(), "{}", label());
    }
}

/// Advances without looking at what changes on the way.
fn to(engine: &mut dyn Engine, tick: u64) -> Result<(), Unsettled> {
    while engine.advance(tick)? {}
    Ok(())
}

/// The nets of a loop are told in no order.
fn sorted(result: Result<(), Unsettled>) -> Result<(), Unsettled> {
    result.map_err(|mut e| {
        e.nets.sort_unstable();
        e
    })
}

/// `width` bits of some of the first `end` signals.
fn operand(rng: &mut Rng, design: &Design, width: u32, end: usize) -> Operand {
    let (mut all, mut left) = (Vec::new(), width);
    while left > 0 {
        let signal = rng.below(end as u64) as usize;
        let have = design.signals[signal].1;
        let n = have.min(left);
        all.push((signal, rng.below(u64::from(have - n + 1)) as u32, n));
        left -= n;
    }
    all
}

/// Adds a signal that a cell gives.
fn add(design: &mut Design, kind: CellKind, inputs: Vec<Operand>) -> usize {
    let mut outputs = Vec::new();
    for (pin, name) in kind.outputs().iter().enumerate() {
        outputs.push(design.signals.len());
        design.signals.push((format!("m{}_{name}", design.cells.len()), kind.output_width(pin)));
    }
    let first = outputs[0];
    design.cells.push(Cell { kind, inputs, outputs });
    first
}

/// A memory of any kind but those that are written by level.
fn memory(rng: &mut Rng) -> Memory {
    let width = *rng.pick(&[1, 2, 3, 5, 8, 16, 31, 32, 64, 70, 130]);
    let size = *rng.pick(&[1, 2, 3, 5, 8, 16, 20]);
    let (reads, writes) = (1 + rng.below(3) as usize, rng.below(4) as usize);
    let mut init = Memory::contents(width, size);
    let known = *rng.pick(&[0, 50, 100]);
    for i in 0..size {
        if rng.below(100) < known {
            let value = if rng.one_in(8) { rng.four_valued(width, 3) } else { rng.known(width) };
            Memory::set_word(width, &mut init, i, &value, |_| true);
        }
    }
    let clock = |rng: &mut Rng| *rng.pick(&[None, Some(Edge::Rising), Some(Edge::Rising), Some(Edge::Falling)]);
    let flags = |rng: &mut Rng, n: usize, often| (0..n).map(|_| rng.one_in(often)).collect::<Box<[bool]>>();
    let read = |rng: &mut Rng| ReadPort {
        clock: clock(rng),
        wide: false,
        transparent: flags(rng, writes, 3),
        collides: flags(rng, writes, 6),
        arst_value: rng.four_valued(width, 20),
        srst_value: rng.four_valued(width, 20),
        enable_first: rng.one_in(2),
    };
    let reads: Vec<ReadPort> = (0..reads).map(|_| read(rng)).collect();
    let write = |rng: &mut Rng| WritePort {
        clock: Some(*rng.pick(&[Edge::Rising, Edge::Rising, Edge::Falling])),
        wide: false,
        priority: vec![false; writes].into(),
    };
    let ports = width * reads.len() as u32;
    Memory {
        width,
        size,
        offset: *rng.pick(&[0, 0, 0, 3, -2]),
        abits: *rng.pick(&[1, 2, 3, 4, 5, 33]),
        init: Arc::from(init),
        start: if rng.one_in(2) { Value::unknown(ports) } else { rng.four_valued(ports, 10) },
        reads,
        writes: (0..writes).map(|_| write(rng)).collect(),
    }
}

/// Adds memories, and cells that read what they give.
pub(super) fn add_memories(rng: &mut Rng, design: &mut Design) {
    let zero = add(design, CellKind::Constant(Box::new(Value::from_u64(0, 1))), vec![]);
    let one = add(design, CellKind::Constant(Box::new(Value::from_u64(1, 1))), vec![]);
    let mut given = Vec::new();
    for _ in 0..1 + rng.below(2) {
        let m = memory(rng);
        let (n, k, width) = (m.reads.len(), m.writes.len(), m.width);
        let q = design.signals.len();
        let clock = |rng: &mut Rng, design: &Design| match rng.below(8) {
            0 => operand(rng, design, 1, q),
            _ => vec![(rng.below(CLOCKS.end as u64) as usize, 0, 1)],
        };
        let constant = |rng: &mut Rng, design: &Design, value: usize, often| match rng.one_in(often) {
            true => operand(rng, design, 1, design.inputs),
            false => vec![(value, 0, 1)],
        };
        let one_clock = clock(rng, design);
        let clocks = |rng: &mut Rng, design: &Design, n: usize| -> Operand {
            (0..n).flat_map(|_| if rng.one_in(3) { clock(rng, design) } else { one_clock.clone() }).collect()
        };
        let rd_clk = clocks(rng, design, n);
        let rd_en = (0..n).flat_map(|_| constant(rng, design, one, 2)).collect();
        let rd_arst = (0..n).flat_map(|_| constant(rng, design, zero, 5)).collect();
        let rd_srst = (0..n).flat_map(|_| constant(rng, design, zero, 4)).collect();
        let mut rd_addr = Operand::new();
        for (port, spec) in m.reads.iter().enumerate() {
            // a port may read where one before it says
            let before = port as u32 * width;
            if before >= m.abits && rng.one_in(4) {
                rd_addr.push((q, rng.below(u64::from(before - m.abits + 1)) as u32, m.abits));
            } else if spec.clock.is_some() && rng.one_in(4) {
                rd_addr.extend(operand(rng, design, m.abits, design.signals.len()));
            } else {
                rd_addr.extend(address(rng, design, m.abits, q, zero));
            }
        }
        let wr_clk = clocks(rng, design, k);
        let mut wr_en = Operand::new();
        for _ in 0..k {
            match rng.below(3) {
                0 => wr_en.extend(operand(rng, design, width, q)),
                1 => wr_en.extend(vec![(one, 0, 1); width as usize]),
                _ => wr_en.extend(vec![operand(rng, design, 1, design.inputs)[0]; width as usize]),
            }
        }
        let mut wr_addr = Operand::new();
        for _ in 0..k {
            match rng.one_in(3) {
                true if !rd_addr.is_empty() => wr_addr.extend(cut(&rd_addr, m.abits)),
                _ => wr_addr.extend(address(rng, design, m.abits, q, zero)),
            }
        }
        let wr_data = (0..k).flat_map(|_| operand(rng, design, width, q)).collect();
        let inputs = vec![rd_clk, rd_en, rd_arst, rd_srst, rd_addr, wr_clk, wr_en, wr_addr, wr_data];
        given.push(add(design, CellKind::Memory(Box::new(m)), inputs));
    }
    // what reads what the memories give
    for q in given {
        for _ in 0..3 {
            let width = design.signals[q].1.min(70);
            let lo = rng.below(u64::from(design.signals[q].1 - width + 1)) as u32;
            let (a, b) = (vec![(q, lo, width)], operand(rng, design, width, design.signals.len()));
            let flop = Flop {
                edge: *rng.pick(&[Edge::Rising, Edge::Falling]),
                set_value: rng.known(width),
                reset_value: rng.known(width),
                init: rng.known(width),
            };
            match rng.below(4) {
                0 => add(design, CellKind::Adder { op: AddOp::Add, width }, vec![a, b, vec![]]),
                1 => {
                    let both = [a, b].concat();
                    add(design, CellKind::Gate { op: GateOp::And, width, inputs: 2 }, vec![both])
                }
                2 => {
                    let (both, s) = ([a, b].concat(), operand(rng, design, 1, design.inputs));
                    add(design, CellKind::Mux { width, inputs: 2 }, vec![both, s])
                }
                _ => {
                    let clk = vec![(rng.below(CLOCKS.end as u64) as usize, 0, 1)];
                    let pins = vec![clk, a, vec![], vec![], vec![], vec![], vec![], vec![]];
                    add(design, CellKind::Flop(Box::new(flop)), pins)
                }
            };
        }
    }
    // and state of before
    let last = design.signals.len();
    for c in 0..design.cells.len() {
        if matches!(design.cells[c].kind, CellKind::EdgeFlop(_)) {
            let width = design.cells[c].kind.input_width(1);
            design.cells[c].inputs[1] = operand(rng, design, width, last);
        }
    }
}

/// The first `width` bits.
fn cut(from: &Operand, width: u32) -> Operand {
    let (mut out, mut left) = (Operand::new(), width);
    for &(signal, lo, n) in from {
        out.extend((left > 0).then_some((signal, lo, n.min(left))));
        left -= n.min(left);
    }
    out
}

/// An address, most of the time a small one.
fn address(rng: &mut Rng, design: &Design, width: u32, end: usize, zero: usize) -> Operand {
    let low = width.min(1 + rng.below(4) as u32);
    let mut all = operand(rng, design, low, end);
    if rng.one_in(4) {
        all.extend(operand(rng, design, width - low, end));
    } else {
        all.extend(vec![(zero, 0, 1); (width - low) as usize]);
    }
    all
}

fn random(seed: u64, totals: &mut [u64; 6]) {
    let mut rng = Rng::new(seed);
    let mut design = if seed.is_multiple_of(3) { Design::new(&mut rng) } else { Design::ordered(&mut rng) };
    if !seed.is_multiple_of(4) {
        add_memories(&mut rng, &mut design);
    }
    run_random(seed, rng, &design, totals);
}

/// Storage in a tangle of asynchronous controls and clocks, at times with memories among it.
fn tangled(seed: u64, totals: &mut [u64; 6]) {
    let mut rng = Rng::new(seed);
    let mut design = Design::tangled(&mut rng);
    if seed.is_multiple_of(4) {
        add_memories(&mut rng, &mut design);
    }
    run_random(seed, rng, &design, totals);
}

/// Runs a design on both engines, driven at random.
fn run_random(seed: u64, mut rng: Rng, design: &Design, totals: &mut [u64; 6]) {
    let netlist = design.build(&mut rng);
    if let Err(why) = CompiledEngine::supports(&netlist) {
        assert!(["feedback", "delay"].iter().any(|w| why.to_string().contains(w)), "seed {seed}: {why}");
        totals[0] += 1;
        return;
    }
    let all = rng.one_in(2);
    let chunk = *rng.pick(&[1, 2, 5, 30, 1000]);
    let mut pair = Pair::new(&netlist, chunk, |net| all || net.index() % 3 == 0);
    let inputs: Vec<(NetId, u32, bool)> = (0..design.inputs)
        .map(|i| {
            let signal = netlist.find(&design.signals[i].0).unwrap();
            (netlist.bits(signal)[0].net, design.signals[i].1, CLOCKS.contains(&i))
        })
        .collect();
    if rng.one_in(2) {
        let clock = Clock { period: 5, high: 2, phase: rng.below(3) };
        pair.event.add_clock(inputs[0].0, clock);
        pair.compiled.add_clock(inputs[0].0, clock);
    }
    let clocked = pair.event.next_event().is_some_and(|_| rng.one_in(2));
    // how often a bit is x or z, and whether that stops after a while
    let mut unknown = *rng.pick(&[u64::MAX, 200, 20, 6]);
    for n in 0..60u64 {
        let label = || format!("seed {seed}, chunks of {chunk}, step {n}");
        if n == 20 && rng.one_in(2) {
            unknown = u64::MAX;
        }
        for (i, &(net, width, is_clock)) in inputs.iter().enumerate() {
            if n == 0 && !rng.one_in(8) {
                pair.drive(net, &Value::from_u64(0, width));
            } else if rng.one_in(2) && !(clocked && i == 0) {
                let often = if is_clock { unknown.saturating_mul(10) } else { unknown };
                pair.drive(net, &rng.four_valued(width, often));
            }
        }
        if !pair.settle(&label) || rng.one_in(3) && !pair.run_to(n * 2, &label) {
            totals[1] += 1;
            return;
        }
        totals[2] += 1;
    }
    let report = pair.compiled.report();
    totals[3] += report.known;
    totals[4] += report.mixed;
    totals[5] += report.four_valued;
}

/// Numbers for random netlists, from `FIRST` on, `DISCRETA_SEEDS` being one past the last.
pub(super) fn seeds(most: u64) -> std::ops::Range<u64> {
    let number = |name: &str| std::env::var(name).ok().and_then(|s| s.parse().ok());
    number("FIRST").unwrap_or(0)..number("DISCRETA_SEEDS").unwrap_or(most)
}

#[test]
fn storage_that_controls_itself_is_the_same_on_both_engines() {
    let seeds = seeds(1000);
    let first = seeds.start;
    let mut totals = [0; 6];
    for seed in seeds {
        tangled(seed, &mut totals);
    }
    let [left_out, unsettled, steps, known, mixed, four_valued] = totals;
    println!("{steps} steps; {left_out} with long loops left out, {unsettled} never settled");
    println!("waves: {known} known, {mixed} mixed, {four_valued} four-valued");
    assert!(first > 0 || steps > 10_000 && known > 5000 && four_valued > 5000);
}

#[test]
fn random_netlists_are_the_same_on_both_engines() {
    let seeds = seeds(300);
    let first = seeds.start;
    let mut totals = [0; 6];
    for seed in seeds {
        random(seed, &mut totals);
    }
    let [left_out, unsettled, steps, known, mixed, four_valued] = totals;
    println!("{steps} steps; {left_out} with delays or long loops left out, {unsettled} never settled");
    println!("waves: {known} known, {mixed} mixed, {four_valued} four-valued");
    assert!(first > 0 || steps > 5000 && known > 500 && four_valued > 500);
}

/// Circuits of parts that are alike, on a clock that runs for long while little is observed: ticks in pieces, which share
/// their code.
#[test]
fn repeated_netlists_are_the_same_on_both_engines() {
    let seeds = std::env::var("DISCRETA_SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(72);
    let (mut instants, mut known, mut mixed) = (0, 0, 0);
    for seed in 0..seeds {
        let mut rng = Rng::new(seed);
        let mut design = Design::ordered(&mut rng);
        if rng.one_in(2) {
            add_memories(&mut rng, &mut design);
        }
        let times = 4 + rng.below(4) as usize;
        let netlist = design.repeated(&mut rng, times).build(&mut rng);
        if CompiledEngine::supports(&netlist).is_err() {
            continue;
        }
        let observed = rng.one_in(3).then(|| rng.below(netlist.nets().len() as u64) as usize);
        let chunk = *rng.pick(&[1, 2, 5, 20]);
        let (mut pair, inputs) = Pair::clocked(&netlist, &design, chunk, observed);
        for n in 0..16u64 {
            let label = || format!("seed {seed}, {times} times, chunks of {chunk}, step {n}");
            for &(net, width) in &inputs {
                if n == 0 || rng.one_in(4) {
                    pair.drive(net, &rng.four_valued(width, if n % 7 == 5 { 8 } else { u64::MAX }));
                }
            }
            if !pair.settle(&label) || !pair.run_far(80 * (n + 1), &label) {
                break;
            }
            instants += 1;
        }
        known += pair.compiled.report().known;
        mixed += pair.compiled.report().mixed;
    }
    println!("{instants} instants, waves: {known} known, {mixed} mixed");
    assert!(seeds < 60 || instants > 800 && known > 8000 && mixed > 8000);
}

/// The command line: the same bytes of waveform, and what is said of the engine.
#[test]
fn the_command_line_chooses_an_engine() {
    let run = |circuit: &str, engine: &str, more: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_discreta"));
        command.current_dir(repository("")).args(["run", circuit, "--engine", engine]).args(more);
        command.output().unwrap()
    };
    for circuit in ["circuits/evaluation/line.json", "circuits/dda/line_gates.json"] {
        let [event, compiled] = ["event", "compiled"].map(|engine| run(circuit, engine, &["-o", "-"]).stdout);
        assert!(event.len() > 1000 && event == compiled, "{circuit}");
    }
    let text = |o: Vec<u8>| String::from_utf8(o).unwrap();
    let said = text(run("circuits/evaluation/line.json", "compiled", &["-v"]).stdout);
    assert!(said.contains("engine compiled") && said.contains("all known"), "{said}");
    let refused = run("circuits/feed/system.json", "compiled", &[]);
    let said = text(refused.stderr);
    assert!(refused.status.code() == Some(2) && said.contains("RC delay"), "{said}");
    let said = text(run("circuits/feed/system.json", "auto", &["-v"]).stdout);
    assert!(said.contains("engine event") && said.contains("not compiled: it has an RC delay"), "{said}");
}

/// A computer, whole: its memory, its registers that nothing has written, its program to the end, all nets.
#[needs(yosys)]
#[test]
fn a_computer_runs_its_program_the_same() {
    let folder = support::folder("compiled_computer");
    let design = repository("tests/verilog/cpu/cpu.v");
    let script = format!("read_verilog {}; prep -top cpu; write_json cpu.json", design.display());
    support::tool::tool(&folder, "yosys", &["-q", "-p", &script]);
    let run = |engine: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_discreta"));
        command.current_dir(&folder).args(["run", "cpu.json", "--engine", engine, "-v", "--clock", "clk=10ns"]);
        command.args(["-s", "rst=0", "--until", "done", "-o", &format!("{engine}.vcd")]);
        let ran = command.output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        let said = String::from_utf8(ran.stdout).unwrap();
        (said, std::fs::read(folder.join(format!("{engine}.vcd"))).unwrap())
    };
    let ((event, expected), (compiled, got)) = (run("event"), run("compiled"));
    assert!(event.contains("stopped at done = 1") && event.contains("status = 0"), "{event}");
    assert!(compiled.contains("stopped at done = 1") && compiled.contains("all known, 2 four-valued"), "{compiled}");
    assert!(expected.len() > 1_000_000 && expected == got);
}

/// The shipped circuits, driven as people would and then at random, by all three engines.
#[test]
fn shipped_circuits_are_the_same_on_all_engines() {
    let mut compiled = 0;
    for path in [
        "evaluation/line",
        "evaluation/line_gates",
        "evaluation/circle",
        "evaluation/karibsky_gates",
        "dda/circle",
        "dda/curve",
        "feed/speed_block_gates",
        "three_axis/dda_line_gates",
        "quadrant/circle",
        "feed/system",
    ] {
        let circuit = discreta::circuit::load(repository(&format!("circuits/{path}.json"))).unwrap();
        let netlist = &circuit.netlist;
        let mut rng = Rng::named(path);
        let mut engines: Vec<Box<dyn Engine>> =
            vec![Box::new(EventEngine::new(netlist)), Box::new(AutoEngine::with_patience(netlist, 500))];
        if let Ok(engine) = CompiledEngine::new(netlist) {
            engines.push(Box::new(engine));
            compiled += 1;
        }
        let inputs: Vec<(NetId, u32, String)> = netlist
            .signal_ids()
            .filter_map(|s| Some((netlist.signal(s).drive?, netlist.signal(s).width, netlist.signal_path(s))))
            .collect();
        for engine in &mut engines {
            netlist.net_ids().step_by(2).for_each(|net| engine.observe(net));
        }
        'drive: for step in 0..400 {
            for (net, width, name) in &inputs {
                let often = if step % 100 < 10 { 30 } else { u64::MAX };
                let value = match name.as_str() {
                    "dt" => Value::from_u64(step % 2, 1),
                    "start" | "rst" => Value::from_u64(u64::from(step % 100 == 4), 1),
                    _ if step == 0 || rng.one_in(40) => rng.four_valued(*width, often),
                    _ => continue,
                };
                let words: Vec<Word> = value.words().collect();
                engines.iter_mut().for_each(|e| e.drive(*net, &words));
            }
            let results: Vec<_> = engines.iter_mut().map(|e| e.settle().is_ok()).collect();
            assert!(results.iter().all(|r| *r == results[0]), "{path}, step {step}: {results:?}");
            if !results[0] {
                break 'drive;
            }
            let (first, rest) = engines.split_at_mut(1);
            let told = first[0].take_unknown_controls();
            first[0].clear_changes();
            for engine in rest {
                // what no signal shows the event engine need not compute
                for net in netlist.signal_ids().flat_map(|s| netlist.bits(s)).map(|s| s.net) {
                    let (a, b) = (first[0].read(net), engine.read(net));
                    assert_eq!(a, b, "{path}, step {step}, {}: {}", netlist.net_name(net), engine.summary());
                }
                assert_eq!(told, engine.take_unknown_controls(), "{path}, step {step}");
                engine.clear_changes();
            }
        }
        assert!(engines[1].summary().contains("compiled"), "{path}: {}", engines[1].summary());
    }
    assert_eq!(compiled, 9, "one has an RC delay");
}
