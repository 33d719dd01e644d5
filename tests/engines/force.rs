//! Nets that are held, state that is set, and whole states that are saved: the same on all engines, and where values stand
//! here, as IEEE 1364-2005 says of `force` and `release` (9.3.2).

use discreta::Value;
use discreta::cell::{CellKind, Clock, GateOp};
use discreta::engine::{Engine, EventEngine, Refused, Snapshot, SnapshotError};
use discreta::netlist::{Builder, Bus, NetId, Netlist, Slice};
use discreta::value::Word;

use crate::support::Rng;
use crate::support::design::{CLOCKS, Design};
use crate::support::engines::Together;

fn invert(b: &mut Builder, name: &str, a: &Bus, y: &Bus) {
    let kind = CellKind::Gate { op: GateOp::Not, width: a.width(), inputs: 1 };
    b.cell(b.top(), name, kind, vec![a.clone()], vec![y.clone()]);
}

/// `n = ~d`, sampled into `q` at `clk`; `m = ~q`.
fn circuit() -> Netlist {
    let mut b = Builder::new("top");
    let (clk, d) = (b.input("clk", 1), b.input("d", 4));
    let (n, q, m) = (b.net("n", 4), b.net("q", 4), b.output("m", 4));
    invert(&mut b, "not1", &d, &n);
    b.dff("ff", &clk, &n, &q);
    invert(&mut b, "not2", &q, &m);
    b.finish().unwrap()
}

struct Run {
    netlist: Netlist,
    engine: Together,
}

impl Run {
    fn new(netlist: Netlist) -> Run {
        Run { engine: Together::new(&netlist), netlist }
    }

    fn bits(&self, name: &str) -> Slice {
        self.netlist.bits(self.netlist.find(name).unwrap())[0]
    }

    fn set(&mut self, name: &str, value: u64) {
        self.engine.drive(self.bits(name).net, &[Word::known(value)]);
        self.engine.settle().unwrap();
    }

    fn tick(&mut self) {
        self.set("clk", 1);
        self.set("clk", 0);
    }

    fn force(&mut self, name: &str, value: u64) {
        self.engine.force(self.bits(name), &[Word::known(value)]).unwrap();
        self.engine.settle().unwrap();
    }

    fn release(&mut self, name: &str) {
        self.engine.release(self.bits(name));
        self.engine.settle().unwrap();
    }

    fn shows(&self, expected: [(&str, u64); 3]) {
        for (name, value) in expected {
            assert_eq!(self.engine.read(self.bits(name).net), [Word::known(value)], "{name}");
        }
    }
}

#[test]
fn a_forced_net_is_what_it_is_held_at_and_then_what_drives_it() {
    let mut run = Run::new(circuit());
    run.set("clk", 0);
    run.set("d", 5);
    run.tick();
    run.shows([("n", 10), ("q", 10), ("m", 5)]);
    run.force("n", 3);
    run.shows([("n", 3), ("q", 10), ("m", 5)]);
    run.set("d", 1);
    run.tick();
    run.shows([("n", 3), ("q", 3), ("m", 12)]);
    run.release("n");
    run.shows([("n", 14), ("q", 3), ("m", 12)]);
    run.tick();
    run.shows([("n", 14), ("q", 14), ("m", 1)]);
    // an input has, when it is released, what it was driven to meanwhile
    run.force("d", 0);
    run.set("d", 7);
    run.shows([("d", 0), ("n", 15), ("q", 14)]);
    run.release("d");
    run.shows([("d", 7), ("n", 8), ("q", 14)]);
}

#[test]
fn forced_storage_keeps_what_it_was_held_at_until_it_samples() {
    let mut run = Run::new(circuit());
    run.set("clk", 0);
    run.set("d", 0);
    run.tick();
    run.force("q", 6);
    run.tick();
    run.shows([("n", 15), ("q", 6), ("m", 9)]);
    run.release("q");
    run.shows([("n", 15), ("q", 6), ("m", 9)]);
    run.tick();
    run.shows([("n", 15), ("q", 15), ("m", 0)]);
    run.engine.deposit(run.bits("q"), &[Word::known(2)]).unwrap();
    run.engine.settle().unwrap();
    run.shows([("n", 15), ("q", 2), ("m", 13)]);
    run.tick();
    run.shows([("n", 15), ("q", 15), ("m", 0)]);
    // some bits
    run.engine.force(Slice { lo: 1, width: 2, ..run.bits("m") }, &[Word::known(0b11)]).unwrap();
    run.engine.settle().unwrap();
    run.shows([("n", 15), ("q", 15), ("m", 0b0110)]);
}

#[test]
fn what_cannot_be_forced_is_told() {
    let mut b = Builder::new("top");
    let a = b.input("a", 1);
    let (zero, y, z) = (b.constant(&Value::from_u64(0, 1)), b.output("y", 1), b.output("z", 1));
    let both = b.gate("and1", GateOp::And, &[&a, &zero]);
    invert(&mut b, "not1", &both, &y);
    invert(&mut b, "not2", &a, &z);
    let mut run = Run::new(b.finish().unwrap());
    let (y, z) = (run.bits("y"), run.bits("z"));
    assert_eq!(run.engine.force(y, &[Word::ZERO]), Err(Refused::Constant(y.net)));
    assert!(Refused::Constant(y.net).text(&run.netlist).contains("constants decide `y`"));
    assert_eq!(run.engine.deposit(z, &[Word::ZERO]), Err(Refused::NoState(z.net)));
    assert!(!run.engine.is_forced());
}

fn words(rng: &mut Rng, width: u32) -> Vec<Word> {
    let value = if rng.one_in(4) { rng.four_valued(width, 4) } else { rng.known(width) };
    value.words().collect()
}

/// Some bits of a net.
fn some_bits(rng: &mut Rng, netlist: &Netlist) -> Slice {
    let net = NetId::new(rng.below(netlist.nets().len() as u64) as usize);
    let width = netlist.net(net).width;
    let lo = rng.below(width.into()) as u32;
    let part = Slice { net, lo, width: 1 + rng.below(u64::from(width - lo)) as u32 };
    if rng.one_in(2) { Slice { net, lo: 0, width } } else { part }
}

fn design(seed: u64, rng: &mut Rng) -> Netlist {
    let design = match seed % 3 {
        0 => Design::new(rng),
        1 => Design::tangled(rng),
        _ => Design::ordered(rng),
    };
    design.build(rng)
}

/// Drives an input, or more, at random.
fn stimulate(rng: &mut Rng, netlist: &Netlist, engine: &mut dyn Engine) -> Result<(), ()> {
    let inputs: Vec<NetId> = netlist.signals().iter().filter_map(|s| s.drive).collect();
    for _ in 0..1 + rng.below(3) {
        let end = if rng.one_in(2) { CLOCKS.end } else { inputs.len() };
        let net = *rng.pick(&inputs[..end]);
        let value = words(rng, netlist.net(net).width);
        engine.drive(net, &value);
    }
    engine.settle().map_err(drop)?;
    if rng.one_in(3) {
        let until = engine.now() + rng.below(6);
        while engine.advance(until).map_err(drop)? {}
    }
    Ok(())
}

/// What all nets are.
fn all(netlist: &Netlist, engine: &dyn Engine) -> Vec<Word> {
    netlist.net_ids().flat_map(|net| engine.read(net).to_vec()).collect()
}

/// [`Together`] compares the engines after every phase; whatever is held, set, saved and gone back to must not part them.
#[test]
fn engines_agree_whatever_is_held_and_set() {
    let (mut forced, mut deposited) = (0, 0);
    for seed in 0..90 {
        let mut rng = Rng::new(seed);
        let netlist = design(seed, &mut rng);
        let mut engine = Together::new(&netlist);
        if rng.one_in(2) {
            let clk = netlist.signal(netlist.find("clk0").unwrap()).drive.unwrap();
            engine.add_clock(clk, Clock { period: 5, high: 2, phase: 1 });
        }
        let mut held: Vec<Slice> = Vec::new();
        let mut saved: Option<Snapshot> = None;
        for _ in 0..60 {
            if stimulate(&mut rng, &netlist, &mut engine).is_err() {
                break;
            }
            let bits = some_bits(&mut rng, &netlist);
            let value = words(&mut rng, bits.width);
            match rng.below(8) {
                0 | 1 if engine.force(bits, &value).is_ok() => {
                    held.push(bits);
                    forced += 1;
                }
                2 => deposited += u32::from(engine.deposit(bits, &value).is_ok()),
                3 => saved = Some(engine.save()),
                4 => {
                    if let Some(saved) = &saved {
                        engine.restore(saved).unwrap();
                    }
                }
                5 | 6 => held.drain(..).for_each(|bits| engine.release(bits)),
                _ => {}
            }
        }
    }
    assert!(forced > 200 && deposited > 50, "{forced} {deposited}");
    crate::support::engines::ran(30, 0);
}

/// What follows a state does so again when it is gone back to, on every engine and from every engine.
#[test]
fn a_saved_state_goes_on_as_it_did() {
    let mut compared = 0;
    for seed in 0..60 {
        let mut rng = Rng::new(1000 + seed);
        let netlist = design(seed, &mut rng);
        let mut engines: Vec<Box<dyn Engine>> = vec![Box::new(EventEngine::new(&netlist))];
        #[cfg(feature = "compiled")]
        if let Ok(engine) = discreta::engine::CompiledEngine::new(&netlist) {
            engines.push(Box::new(engine));
            engines.push(Box::new(discreta::engine::AutoEngine::with_patience(&netlist, 50)));
        }
        let before = rng.below(12);
        let held = some_bits(&mut rng, &netlist);
        let stimulus = rng.clone();
        let mut states = Vec::new();
        for engine in &mut engines {
            let mut rng = stimulus.clone();
            if (0..before).any(|_| stimulate(&mut rng, &netlist, &mut **engine).is_err()) {
                break;
            }
            if rng.one_in(3) {
                _ = engine.force(held, &words(&mut rng, held.width));
                if engine.settle().is_err() {
                    break;
                }
            }
            let state = Snapshot::from_bytes(&engine.save().to_bytes()).unwrap();
            assert_eq!(state, engine.save());
            let after = rng.clone();
            let mut shown = Vec::new();
            for _ in 0..20 {
                let settled = stimulate(&mut rng, &netlist, &mut **engine).is_ok();
                shown.push((settled, engine.now(), engine.next_event(), all(&netlist, &**engine)));
                if !settled {
                    break;
                }
            }
            states.push((state, after, shown));
        }
        for (state, after, shown) in states {
            for engine in &mut engines {
                let mut rng = after.clone();
                engine.restore(&state).unwrap();
                for (i, (settled, now, next, nets)) in shown.iter().enumerate() {
                    assert_eq!(stimulate(&mut rng, &netlist, &mut **engine).is_ok(), *settled, "seed {seed}, step {i}");
                    assert_eq!((engine.now(), engine.next_event()), (*now, *next), "seed {seed}, step {i}");
                    if *settled {
                        let found = all(&netlist, &**engine);
                        assert_eq!(found, *nets, "seed {seed}, step {i}: {}", engine.summary());
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 1500, "{compared}");
}

#[test]
fn a_state_of_another_circuit_is_refused() {
    let saved = EventEngine::new(&circuit()).save();
    let mut b = Builder::new("top");
    let (a, y) = (b.input("a", 4), b.output("y", 4));
    invert(&mut b, "not1", &a, &y);
    let mut run = Run::new(b.finish().unwrap());
    run.set("a", 3);
    assert_eq!(run.engine.restore(&saved), Err(SnapshotError::OtherNetlist));
    assert_eq!(run.engine.read(run.bits("y").net), [Word::known(12)]);
    // built alike it is the same
    assert!(saved.is_of(&circuit()));
}
