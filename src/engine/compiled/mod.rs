//! The compiled engine: the same values as the event engine, by machine code made for the circuit.
//!
//! The way of a circuit: `lower` makes a `graph` of operations on machine words of it, two planes for each four-valued
//! word; `plan` cuts that into chunks; `codegen` makes a function of each, which `machine` calls. A `form` is the result
//! for what is taken to be known: where state and inputs hold no x or z, their unknown planes are 0, and the graph folds
//! to two-valued logic by itself. What that can make unknown nevertheless (a division by zero, a select out of range) is
//! still computed exactly; only where it reaches state is the form left, before anything is computed from it.
//! `wiring` knows clocks and controls, `peek` evaluates what nobody keeps.
//!
//! A wave here: chunks of which an input has changed run in order; storage cells whose clock made its edge take what was
//! computed for them; and again until no clock makes an edge.

mod codegen;
mod form;
mod fuse;
mod graph;
mod lower;
mod machine;
mod peek;
mod plan;
mod steps;
mod wiring;

use std::collections::HashMap;

use super::{Engine, EventEngine, UnknownControl, Unsettled};
use crate::cell::{CellKind, Clock};
use crate::netlist::{NetId, Netlist};
use crate::value::Word;
use crate::value::word::words;

use codegen::Shared;
use form::{DEFAULT_CHUNK, Form, Kept, Wanted};
use peek::Peeked;
use steps::Steps;
use wiring::Wiring;

/// Rounds of clock edges within one wave after which it counts as endless, as in the event engine.
const ENDLESS: usize = 1_000_008;
/// Ticks that were left before they did anything after which they are no longer tried.
const ABORTS: u32 = 64;
/// Runs of a loop's chunk after which it is looked at step by step.
const STEPS_COMPILED: u32 = 64;
/// Waves in a form after which ticks are made in one piece.
const WARM: u64 = 16;
/// Waves in the four-valued form after which one is made that takes all to be known that is.
const PATIENCE: u64 = 64;
const NEVER: u64 = u64::MAX;

/// The engine that compiles; see [`Engine`] and `docs/engines.md`.
#[derive(Debug)]
pub struct CompiledEngine<'n> {
    netlist: &'n Netlist,
    wiring: Wiring,
    memory: Vec<Word>,
    kept: Vec<Kept>,
    observed: Vec<Option<u32>>,
    observed_nets: Vec<NetId>,
    /// Where the bits of observed nets that have changed begin; set when a form is made.
    shared: Shared,
    forms: Vec<Form>,
    current: Option<usize>,
    /// The state holds what the current form takes to be known, and is not.
    alarmed: bool,
    /// Ticks in one piece have run, which do not keep what chunks leave each other.
    stale: bool,
    /// An input of one bit that changes at the next wave.
    pending: Option<(u32, bool)>,
    /// How often in turn a tick could not be made in one piece.
    aborted: u32,
    /// Something has been written since the last wave.
    touched: bool,
    chunk: usize,
    watches: Vec<Watch>,
    /// Slot and shift of each clock pin and of each control bit.
    pin_places: Vec<(u32, u32)>,
    control_places: Vec<(u32, u32)>,
    control_seen: Vec<bool>,
    reported: Vec<bool>,
    unknown_controls: Vec<UnknownControl>,
    active: Vec<u32>,
    changes: Vec<NetId>,
    listed: Vec<bool>,
    peeked: Peeked,
    /// How often the chunk of each loop has run since all was settled.
    loop_runs: Vec<u32>,
    steps: Steps,
    /// Nets of loops that never settle.
    endless: Vec<NetId>,
    clocks: Vec<Source>,
    next_clock: u64,
    now: u64,
    started: bool,
    /// A slot that was unknown when last looked for, and how long that has gone on.
    last_unknown: u32,
    waiting: u64,
    patience: u64,
    report: EngineReport,
}

/// How a run went, in the compiled engine's own terms.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct EngineReport {
    /// Waves in which all state and inputs were known.
    pub known: u64,
    /// Waves in which some state was taken to be unknown, and the rest to be known.
    pub mixed: u64,
    /// Waves in the four-valued form.
    pub four_valued: u64,
    /// Forms that were compiled.
    pub forms: u64,
}

#[derive(Clone, Copy, Debug)]
struct Watch {
    /// The bit when edges were last looked for.
    old: Word,
    /// Whether it has had a known value.
    seen: bool,
}

#[derive(Debug)]
struct Source {
    slot: u32,
    clock: Clock,
    high: bool,
    next: u64,
}

impl<'n> CompiledEngine<'n> {
    /// Whether the engine can run a netlist, and if not, why.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn supports(netlist: &Netlist) -> Result<(), String> {
        let order = netlist.order();
        if let Some(group) = order.groups.iter().find(|g| g.len() > lower::LOOP) {
            let first = netlist.cell_path(order.sequence[group.start]);
            return Err(format!("it has combinational feedback through {} cells (`{first}` …)", group.len()));
        }
        for id in netlist.cell_ids() {
            if let Some(what) = lower::unsupported(&netlist.cell(id).kind) {
                return Err(format!("it has {what} (`{}`)", netlist.cell_path(id)));
            }
        }
        Ok(())
    }

    /// An engine at tick 0, with nothing settled yet. Code is made at the first wave, when it is known what is observed.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn new(netlist: &'n Netlist) -> Result<CompiledEngine<'n>, String> {
        CompiledEngine::with_chunk(netlist, DEFAULT_CHUNK)
    }

    /// The same with at most `chunk` operations computed together.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub fn with_chunk(netlist: &'n Netlist, chunk: usize) -> Result<CompiledEngine<'n>, String> {
        CompiledEngine::supports(netlist)?;
        // slot 0 has the alarm
        let wiring = Wiring::new(netlist, 1);
        let memory = wiring.initial.clone();
        let bit = |b: wiring::Bit| {
            let w = wiring::initial(netlist, b.net)[b.lo as usize / 64];
            bit_of(w, b.lo % 64)
        };
        let watch = |p: &wiring::ClockPin| {
            let first = bit(p.bit);
            let old = if p.level && first.is_one() { Word::x(1) } else { first };
            Watch { old, seen: p.level || first.is_known() }
        };
        let watches = wiring.pins.iter().map(watch).collect();
        let control_seen = wiring.controls.iter().map(|c| bit(c.0).is_known()).collect();
        let mut engine = CompiledEngine {
            netlist,
            memory,
            kept: Vec::new(),
            observed: vec![None; netlist.nets().len()],
            observed_nets: Vec::new(),
            shared: Shared { alarm: 0, changed: 0, dirty: 0 },
            forms: Vec::new(),
            current: None,
            alarmed: false,
            stale: false,
            pending: None,
            aborted: 0,
            touched: true,
            chunk,
            watches,
            pin_places: Vec::new(),
            control_places: Vec::new(),
            control_seen,
            reported: vec![false; netlist.cells().len()],
            unknown_controls: Vec::new(),
            active: Vec::new(),
            changes: Vec::new(),
            listed: vec![false; netlist.nets().len()],
            peeked: Peeked::new(netlist.nets().len()),
            loop_runs: vec![0; wiring.loops.len()],
            steps: Steps::default(),
            endless: Vec::new(),
            clocks: Vec::new(),
            next_clock: NEVER,
            now: 0,
            started: false,
            last_unknown: wiring.leaves.start,
            waiting: 0,
            patience: PATIENCE,
            report: EngineReport::default(),
            wiring,
        };
        for cell in netlist.cell_ids() {
            if let CellKind::Clock(clock) = netlist.cell(cell).kind {
                engine.add_clock(netlist.output(cell, 0), clock);
            }
        }
        Ok(engine)
    }

    /// An engine that goes on from where the event engine is, with everything settled and no changes untold.
    ///
    /// # Errors
    /// What the netlist has that is not compiled.
    pub(super) fn resume(
        netlist: &'n Netlist,
        from: &EventEngine,
        observed: &[NetId],
    ) -> Result<CompiledEngine<'n>, String> {
        let mut engine = CompiledEngine::new(netlist)?;
        let given = from.hand_over();
        for i in 0..engine.wiring.leaf_net.len() {
            let net = engine.wiring.leaf_net[i];
            let slot = engine.wiring.leaves.start + i as u32;
            let word = slot - engine.wiring.slot[net.index()].expect("state has a place");
            engine.memory[slot as usize] = from.read(net)[word as usize];
        }
        engine.now = from.now();
        engine.started = true;
        let seen: HashMap<(NetId, u32, bool), bool> =
            given.seen.iter().map(|&(net, lo, level, seen)| ((net, lo, level), seen)).collect();
        for (pin, watch) in engine.wiring.pins.iter().zip(&mut engine.watches) {
            let word = from.read(pin.bit.net)[pin.bit.lo as usize / 64];
            let seen = seen.get(&(pin.bit.net, pin.bit.lo, pin.level)).copied().unwrap_or(watch.seen);
            *watch = Watch { old: bit_of(word, pin.bit.lo % 64), seen };
        }
        for (control, (_, pins)) in engine.control_seen.iter_mut().zip(&engine.wiring.controls) {
            *control = given.control_seen[pins[0] as usize];
        }
        engine.reported[..given.reported.len()].copy_from_slice(&given.reported);
        engine.clocks.clear();
        for (net, clock, high, next) in given.clocks {
            let slot = engine.wiring.slot[net.index()].expect("an input has a place");
            engine.clocks.push(Source { slot, clock, high, next });
        }
        engine.next_clock = engine.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        engine.changes.clear();
        engine.listed.fill(false);
        for &net in observed {
            engine.observe(net);
        }
        Ok(engine)
    }

    /// How the run has gone.
    #[must_use]
    pub fn report(&self) -> EngineReport {
        self.report
    }

    /// What is kept in memory: clock pins, controls, observed nets. Code made for other nets goes.
    fn prepare(&mut self) {
        let observed = self.observed_nets.iter().map(|&net| (net, true));
        let pins = self.wiring.pins.iter().map(|p| (p.bit.net, true));
        let controls = self.wiring.controls.iter().map(|c| (c.0.net, false));
        let mut nets: Vec<(NetId, bool)> = Vec::new();
        let mut seen = vec![false; self.netlist.nets().len()];
        for (net, always) in observed.chain(pins).chain(controls) {
            if !std::mem::replace(&mut seen[net.index()], true) {
                nets.push((net, always));
            }
        }
        // places of what was kept before stay; those of old code are not used again
        for &(net, _) in &nets {
            self.place(net);
        }
        self.shared.changed = self.memory.len() as u32 * 2;
        self.memory.extend((0..self.observed_nets.len().div_ceil(128)).map(|_| Word::ZERO));
        let kept = |(net, always): (NetId, bool)| Kept { net, observed: self.observed[net.index()], always };
        self.kept = nets.into_iter().map(kept).collect();
        let place =
            |b: wiring::Bit, slot: &[Option<u32>]| (slot[b.net.index()].expect("it is kept") + b.lo / 64, b.lo % 64);
        self.pin_places = self.wiring.pins.iter().map(|p| place(p.bit, &self.wiring.slot)).collect();
        self.control_places = self.wiring.controls.iter().map(|c| place(c.0, &self.wiring.slot)).collect();
        self.forms.clear();
        self.current = None;
    }

    /// Gives a net a place with its present value, if it has none.
    fn place(&mut self, net: NetId) {
        if self.wiring.slot[net.index()].is_none() {
            let now = if self.started { self.read(net).to_vec() } else { wiring::initial(self.netlist, net) };
            self.wiring.slot[net.index()] = Some(self.memory.len() as u32);
            self.memory.extend(now);
        }
    }

    /// The number of a form in which these slots of state may be unknown, or all.
    fn form(&mut self, unknown: Option<Vec<u32>>) -> usize {
        if let Some(found) = self.forms.iter().position(|f| f.unknown == unknown) {
            return found;
        }
        let wanted = Wanted { wiring: &self.wiring, kept: &self.kept, shared: self.shared, chunk: self.chunk };
        let mut end = self.memory.len() as u32;
        let form = Form::new(self.netlist, &wanted, unknown, &mut end);
        let form = form.unwrap_or_else(|e| panic!("code for the circuit cannot be made: {e}"));
        self.memory.resize(end as usize, Word::ZERO);
        self.forms.push(form);
        self.report.forms += 1;
        self.forms.len() - 1
    }

    /// Goes on in a form, everything to be computed anew.
    fn enter(&mut self, number: usize) {
        self.current = Some(number);
        self.alarmed = false;
        self.stale = false;
        self.memory[0] = Word::ZERO;
        let form = &self.forms[number];
        for &(half, value, observed) in &form.constants {
            let word = &mut self.memory[half as usize / 2];
            let plane = if half % 2 == 0 { &mut word.v } else { &mut word.u };
            if std::mem::replace(plane, value) != value
                && let Some(bit) = observed
            {
                set_bit(&mut self.memory, self.shared.changed, bit);
            }
        }
        for chunk in 0..form.machine.len() {
            let (word, bit) = codegen::dirty_bit(form.settling, chunk as u32);
            *half(&mut self.memory, form.dirty + word) |= bit;
        }
        // what this form takes to be known is
        for i in 0..self.control_seen.len() {
            if form.doubtful.binary_search(&(i as u32)).is_err() {
                self.control_seen[i] = true;
            }
        }
    }

    /// The first unknown slot of state from a place on, round to it.
    fn find_unknown(&self) -> Option<u32> {
        let leaves = self.wiring.leaves.clone();
        let is = |&slot: &u32| self.memory[slot as usize].u != 0;
        (self.last_unknown..leaves.end).find(is).or_else(|| (leaves.start..self.last_unknown).find(is))
    }

    /// All unknown slots of state.
    fn all_unknown(&self) -> Vec<u32> {
        self.wiring.leaves.clone().filter(|&slot| self.memory[slot as usize].u != 0).collect()
    }

    /// Sees to it that there is a form that allows what is unknown.
    fn ready(&mut self) {
        if let Some(number) = self.current.filter(|_| !self.alarmed) {
            if self.stale {
                self.enter(number);
            }
            return;
        }
        if self.current.is_some() {
            // the next attempt at a faster form is to wait longer
            self.patience = (self.patience * 2).min(1 << 20);
            self.waiting = 0;
        }
        let number = if self.find_unknown().is_none() { self.form(Some(Vec::new())) } else { self.form(None) };
        self.enter(number);
    }

    /// Goes over to a faster form if there is one for what has become known.
    fn improve(&mut self) {
        let Some(number) = self.current.filter(|&n| self.forms[n].unknown.as_ref().is_none_or(|u| !u.is_empty()))
        else {
            return;
        };
        match self.find_unknown() {
            None => {
                let number = self.form(Some(Vec::new()));
                self.enter(number);
            }
            Some(slot) => {
                self.last_unknown = slot;
                self.waiting += 1;
                if self.forms[number].is_general() && self.waiting >= self.patience {
                    self.waiting = 0;
                    let mut unknown = self.all_unknown();
                    if let Some(old) = self.forms.iter().filter_map(|f| f.unknown.as_ref()).max_by_key(|u| u.len()) {
                        // what was unknown before may be so again
                        unknown.extend(old);
                        unknown.sort_unstable();
                        unknown.dedup();
                    }
                    if unknown.len() < self.wiring.leaves.len() {
                        self.forms.retain(|f| f.unknown.as_ref().is_none_or(Vec::is_empty));
                        let number = self.form(Some(unknown));
                        self.enter(number);
                    }
                }
            }
        }
    }

    /// Runs the dirty ones among some chunks, in order.
    #[inline(always)]
    fn run_chunks(&mut self, late: bool) {
        let form = &self.forms[self.current.expect("there is a form")];
        let settling = form.settling.div_ceil(64);
        let (first, chunk, n) =
            if late { (settling, form.settling, form.machine.len() - form.settling) } else { (0, 0, form.settling) };
        for word in 0..n.div_ceil(64) {
            let at = form.dirty + (first + word) as u32;
            loop {
                let bits = half(&mut self.memory, at);
                if *bits == 0 {
                    break;
                }
                let number = chunk + word * 64 + bits.trailing_zeros() as usize;
                *bits &= *bits - 1;
                form.machine.run(number, &mut self.memory);
                // what has become unknown must not be read as known
                if self.memory[0].v != 0 {
                    return;
                }
                if let (false, Some(group)) = (self.wiring.loops.is_empty(), form.groups[number]) {
                    let runs = &mut self.loop_runs[group as usize];
                    *runs += 1;
                    if *runs > STEPS_COMPILED {
                        // it may never settle: that is found out step by step
                        *runs = 0;
                        let bit = codegen::dirty_bit(form.settling, number as u32).1;
                        *half(&mut self.memory, at) &= !bit;
                        let settled = self.steps.run(self.netlist, &self.wiring, &mut self.memory, group as usize);
                        match settled {
                            // from what they came to the code goes on
                            Ok(()) => {
                                for &cell in &self.wiring.loops[group as usize] {
                                    for pin in 0..self.netlist.cell(cell).kind.outputs().len() {
                                        let net = self.netlist.output(cell, pin);
                                        let slot = self.wiring.slot[net.index()].expect("it has a place");
                                        for slot in slot..slot + words(self.netlist.net(net).width) as u32 {
                                            for &(word, bits) in form.wakes(slot) {
                                                *half(&mut self.memory, form.dirty + word) |= bits;
                                            }
                                            if !form.allows(slot) {
                                                self.memory[0].v |= self.memory[slot as usize].u;
                                            }
                                        }
                                    }
                                }
                                *half(&mut self.memory, at) |= bit;
                            }
                            Err(nets) => self.endless.extend(nets),
                        }
                    }
                }
            }
        }
    }

    /// Writes a slot of state; if that changes it, wakes what reads it.
    #[inline(always)]
    fn put(&mut self, slot: u32, net: NetId, new: Word) -> bool {
        let at = &mut self.memory[slot as usize];
        if *at == new {
            return false;
        }
        *at = new;
        if let Some(number) = self.current {
            let form = &self.forms[number];
            for &(word, bits) in form.wakes(slot) {
                *half(&mut self.memory, form.dirty + word) |= bits;
            }
            self.alarmed |= new.u != 0 && !form.allows(slot);
        }
        if self.observed[net.index()].is_some() {
            self.list_change(net);
        }
        true
    }

    fn list_change(&mut self, net: NetId) {
        if !std::mem::replace(&mut self.listed[net.index()], true) {
            self.changes.push(net);
        }
    }

    /// Runs all that is to be settled. Feedback that never settles is reported after all else has.
    fn settle_chunks(&mut self) -> Result<(), Unsettled> {
        loop {
            self.loop_runs.fill(0);
            self.ready();
            self.run_chunks(false);
            if !self.endless.is_empty() {
                return Err(Unsettled { time: self.now, nets: std::mem::take(&mut self.endless), clocked: false });
            }
            if self.memory[0].v == 0 {
                return Ok(());
            }
            self.memory[0].v = 0;
            self.alarmed = true;
        }
    }

    /// Lists the storage cells whose clock has made its edge since the last look.
    fn edges(&mut self) {
        self.active.clear();
        for (i, &(slot, shift)) in self.pin_places.iter().enumerate() {
            let new = bit_of(self.memory[slot as usize], shift);
            let watch = &mut self.watches[i];
            if watch.old == new {
                continue;
            }
            let old = std::mem::replace(&mut watch.old, new).read();
            let new = new.read();
            if !watch.seen {
                watch.seen = new.u == 0;
                continue;
            }
            if old == new {
                continue;
            }
            let pin = &self.wiring.pins[i];
            let list = if old.is_zero() || new.is_one() { &pin.rising } else { &pin.falling };
            self.active.extend(list);
            if old.is_zero() && new.u != 0 {
                self.active.extend(&pin.unknown);
            }
        }
        if !self.active.is_empty() {
            self.run_chunks(true);
        }
    }

    /// Lets the cells listed take what was computed for them.
    fn commit(&mut self) {
        let none_fixed = self.forms[self.current.expect("there is a form")].fixed.is_empty();
        for i in 0..self.active.len() {
            let s = self.wiring.stored[self.active[i] as usize];
            for k in 0..s.words {
                let mut new = self.memory[(s.stage + k) as usize];
                if !none_fixed {
                    new = self.fixed(s.slot + k, new);
                }
                self.put(s.slot + k, s.net, new);
            }
        }
    }

    /// What asynchronous controls make of a word that is sampled, where that is a constant.
    fn fixed(&self, slot: u32, mut new: Word) -> Word {
        let form = &self.forms[self.current.expect("there is a form")];
        for &(half, value) in form.fixed.iter().filter(|f| f.0 / 2 == slot) {
            if half % 2 == 0 {
                new.v = value;
            } else if form.allows(slot) {
                new.u = value;
            }
        }
        new
    }

    fn wave(&mut self) -> Result<(), Unsettled> {
        self.touched = false;
        self.peeked.clear();
        if let Some((slot, level)) = self.pending.take() {
            self.put_input(slot, Word::known(level.into()));
        }
        if self.shared.changed == 0 {
            self.prepare();
        }
        self.started = true;
        let mut rounds = 0;
        loop {
            self.settle_chunks()?;
            self.edges();
            if self.active.is_empty() {
                break;
            }
            rounds += 1;
            if rounds >= ENDLESS {
                return Err(self.oscillation());
            }
            self.commit();
        }
        self.collect_changes();
        self.check_controls();
        self.count(1);
        self.improve();
        Ok(())
    }

    fn count(&mut self, waves: u64) {
        let form = &mut self.forms[self.current.expect("there is a form")];
        form.waves += waves;
        match &form.unknown {
            None => self.report.four_valued += waves,
            Some(list) if list.is_empty() => self.report.known += waves,
            Some(_) => self.report.mixed += waves,
        }
    }

    /// Changes an input of one bit to and fro, up to `most` times (which is odd, or it goes back to where it was), until
    /// an observed net changes, in one piece. How many times it did, and whether it can do so at all.
    fn ticks(&mut self, slot: u32, level: bool, most: u64) -> Option<u64> {
        let number = self.current.filter(|_| !self.alarmed && !self.touched && self.shared.changed != 0)?;
        if self.memory[slot as usize] != Word::known((!level).into()) {
            return None;
        }
        let form = &mut self.forms[number];
        if form.waves < WARM || !form.doubtful.is_empty() || self.watches.iter().any(|w| !w.seen) {
            return None;
        }
        let wanted = Wanted { wiring: &self.wiring, kept: &self.kept, shared: self.shared, chunk: self.chunk };
        let made = form.ticks(&wanted, slot)?;
        let net = self.wiring.leaf_net[(slot - self.wiring.leaves.start) as usize];
        let observed = self.observed[net.index()].is_some();
        let done = if level && most >= 2 && !observed {
            made.circle.run(&mut self.memory, most / 2)
        } else {
            made.single[usize::from(level)].run(&mut self.memory, 1)
        };
        if done == 0 {
            // what it met it cannot do in one piece
            self.aborted += 1;
            if self.aborted > ABORTS {
                form.forget_ticks(slot);
                self.aborted = 0;
            }
            return None;
        }
        self.aborted = 0;
        self.peeked.clear();
        let level = level ^ (done % 2 == 0);
        self.memory[slot as usize] = Word::known(level.into());
        self.stale = true;
        for (watch, &(slot, shift)) in self.watches.iter_mut().zip(&self.pin_places) {
            watch.old = bit_of(self.memory[slot as usize], shift);
        }
        if observed {
            self.list_change(net);
        }
        self.collect_changes();
        self.count(done);
        if self.memory[0].v != 0 {
            self.memory[0].v = 0;
            self.alarmed = true;
        }
        Some(done)
    }

    /// One wave after an input of one bit has changed.
    fn tick(&mut self, slot: u32, level: bool) -> Result<(), Unsettled> {
        if self.ticks(slot, level, 1).is_none() {
            self.put_input(slot, Word::known(level.into()));
            return self.wave();
        }
        self.after_ticks()
    }

    /// Goes on from ticks: what they made unknown is seen to.
    fn after_ticks(&mut self) -> Result<(), Unsettled> {
        if self.alarmed {
            return self.wave();
        }
        self.improve();
        Ok(())
    }

    /// Whether the one clock that is due next is the only one there is, and runs in one piece; then it does, up to tick
    /// `until`.
    fn run_clock(&mut self, until: u64) -> Result<bool, Unsettled> {
        let due = self.clocks.iter().filter(|c| c.next == self.next_clock).count();
        if due != 1 || self.pending.is_some() {
            return Ok(false);
        }
        let Some(c) = self.clocks.iter().find(|c| c.next == self.next_clock) else { return Ok(false) };
        let (slot, level, clock, next) = (c.slot, !c.high, c.clock, c.next);
        // whole periods from the rising edge on, as long as no other clock is due
        let end = match self.clocks.len() {
            1 => until,
            _ => next,
        };
        let most =
            if level && end - next >= clock.high { 2 * ((end - next - clock.high) / clock.period + 1) } else { 1 };
        let Some(done) = self.ticks(slot, level, most.min(1 << 20)) else { return Ok(false) };
        // the last of them
        let last = match (level, done) {
            (true, n) if n % 2 == 0 => next + (n / 2 - 1) * clock.period + clock.high,
            (true, n) => next + n / 2 * clock.period,
            (false, _) => next,
        };
        self.now = last;
        let high = level ^ (done % 2 == 0);
        let wait = if high { clock.high } else { clock.period - clock.high };
        for c in self.clocks.iter_mut().filter(|c| c.slot == slot) {
            (c.high, c.next) = (high, last.saturating_add(wait));
        }
        self.next_clock = self.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        self.after_ticks()?;
        Ok(true)
    }

    /// The nets that clocked cells keep changing.
    fn oscillation(&mut self) -> Unsettled {
        let mut nets = Vec::new();
        for _ in 0..64 {
            for &number in &self.active {
                let s = self.wiring.stored[number as usize];
                let differs =
                    (0..s.words).any(|k| self.memory[(s.slot + k) as usize] != self.memory[(s.stage + k) as usize]);
                if differs {
                    nets.push(s.net);
                }
            }
            self.commit();
            if self.settle_chunks().is_err() {
                break;
            }
            self.edges();
        }
        nets.sort_unstable();
        nets.dedup();
        Unsettled { time: self.now, nets, clocked: true }
    }

    /// Lists the observed nets whose bits generated code has set.
    fn collect_changes(&mut self) {
        for word in 0..self.observed_nets.len().div_ceil(64) {
            let mut bits = std::mem::take(half(&mut self.memory, self.shared.changed + word as u32));
            while bits != 0 {
                let net = self.observed_nets[word * 64 + bits.trailing_zeros() as usize];
                bits &= bits - 1;
                self.list_change(net);
            }
        }
    }

    /// Reports controls that have become unknown.
    fn check_controls(&mut self) {
        let form = &self.forms[self.current.expect("there is a form")];
        if form.doubtful.is_empty() {
            return;
        }
        let mut unknown: Vec<u32> = Vec::new();
        for &number in &form.doubtful {
            let (slot, shift) = self.control_places[number as usize];
            let seen = &mut self.control_seen[number as usize];
            if bit_of(self.memory[slot as usize], shift).is_known() {
                *seen = true;
            } else if *seen {
                unknown.extend(&self.wiring.controls[number as usize].1);
            }
        }
        unknown.sort_unstable();
        for number in unknown {
            let pin = self.wiring.control_pins[number as usize];
            if !std::mem::replace(&mut self.reported[pin.cell.index()], true) {
                self.unknown_controls.push(UnknownControl {
                    time: self.now,
                    cell: pin.cell,
                    pin: pin.pin,
                    net: pin.net,
                });
            }
        }
    }

    fn has_news(&self) -> bool {
        !(self.changes.is_empty() && self.unknown_controls.is_empty())
    }

    /// Makes the clock edges of tick `now`.
    fn fire(&mut self) {
        self.next_clock = NEVER;
        for i in 0..self.clocks.len() {
            let c = &mut self.clocks[i];
            if c.next == self.now {
                c.high = !c.high;
                let wait = if c.high { c.clock.high } else { c.clock.period - c.clock.high };
                c.next = self.now.saturating_add(wait);
                let (slot, level) = (c.slot, Word::known(u64::from(c.high)));
                self.put_input(slot, level);
            }
            self.next_clock = self.next_clock.min(self.clocks[i].next);
        }
    }

    fn put_input(&mut self, slot: u32, new: Word) {
        self.touched = true;
        let net = self.wiring.leaf_net[(slot - self.wiring.leaves.start) as usize];
        self.put(slot, net, new);
    }

    fn held(&self, net: NetId) -> Option<&[Word]> {
        let slot = self.wiring.slot[net.index()]?;
        let keeps = self.current.is_none_or(|n| self.forms[n].keeps[net.index()]);
        if !keeps && !self.wiring.leaves.contains(&slot) {
            return None;
        }
        let slot = slot as usize;
        Some(&self.memory[slot..slot + words(self.netlist.net(net).width)])
    }
}

impl Engine for CompiledEngine<'_> {
    fn now(&self) -> u64 {
        self.now
    }

    fn read(&self, net: NetId) -> &[Word] {
        self.peeked.read(self.netlist, &|net| self.held(net), net)
    }

    fn observe(&mut self, net: NetId) {
        if self.observed[net.index()].is_none() {
            self.observed[net.index()] = Some(self.observed_nets.len() as u32);
            self.observed_nets.push(net);
            if self.started {
                self.place(net);
            }
            // made anew at the next wave
            self.shared.changed = 0;
        }
    }

    fn add_clock(&mut self, net: NetId, clock: Clock) {
        let slot = self.wiring.slot[net.index()].expect("an input has a place");
        self.clocks.retain(|c| c.slot != slot);
        let high = clock.phase == 0;
        let next = if high { clock.high } else { clock.phase };
        self.clocks.push(Source { slot, clock, high, next });
        self.next_clock = self.clocks.iter().map(|c| c.next).min().unwrap_or(NEVER);
        self.put_input(slot, Word::known(u64::from(high)));
    }

    fn drive(&mut self, net: NetId, value: &[Word]) {
        self.peeked.clear();
        let slot = self.wiring.slot[net.index()].expect("an input has a place");
        if let Some((before, level)) = self.pending.take() {
            self.put_input(before, Word::known(level.into()));
        }
        // an input of one bit that changes alone may be a tick
        if let (false, 1, &[new]) = (self.touched, self.netlist.net(net).width, value)
            && new.is_known()
            && self.memory[slot as usize] == Word::known(new.v ^ 1)
        {
            self.pending = Some((slot, new.v == 1));
            return;
        }
        for (i, &word) in (0..).zip(value).take(words(self.netlist.net(net).width)) {
            self.put_input(slot + i, word);
        }
    }

    fn settle(&mut self) -> Result<(), Unsettled> {
        match self.pending.take() {
            Some((slot, level)) => self.tick(slot, level),
            None => self.wave(),
        }
    }

    fn advance(&mut self, until: u64) -> Result<bool, Unsettled> {
        if !self.started {
            self.wave()?;
            if self.has_news() {
                return Ok(true);
            }
        }
        while self.next_clock <= until && self.next_clock != NEVER {
            if !self.run_clock(until)? {
                self.now = self.next_clock;
                self.fire();
                self.wave()?;
            }
            if self.has_news() {
                return Ok(true);
            }
        }
        self.now = until;
        Ok(false)
    }

    fn next_event(&self) -> Option<u64> {
        (self.next_clock != NEVER).then_some(self.next_clock)
    }

    fn changes(&self) -> &[NetId] {
        &self.changes
    }

    fn clear_changes(&mut self) {
        for net in self.changes.drain(..) {
            self.listed[net.index()] = false;
        }
    }

    fn take_unknown_controls(&mut self) -> Vec<UnknownControl> {
        std::mem::take(&mut self.unknown_controls)
    }

    fn events(&self) -> Option<u64> {
        None
    }

    fn summary(&self) -> String {
        let EngineReport { known, mixed, four_valued, .. } = self.report;
        let mixed = if mixed > 0 { format!("{mixed} with some unknown, ") } else { String::new() };
        format!(
            "engine compiled, {} waves: {known} all known, {mixed}{four_valued} four-valued",
            known + self.report.mixed + four_valued
        )
    }
}

/// Half a slot.
#[inline(always)]
fn half(memory: &mut [Word], half: u32) -> &mut u64 {
    let word = &mut memory[half as usize / 2];
    if half % 2 == 0 { &mut word.v } else { &mut word.u }
}

fn set_bit(memory: &mut [Word], first: u32, bit: u32) {
    *half(memory, first + bit / 64) |= 1 << (bit % 64);
}

#[inline(always)]
fn bit_of(w: Word, shift: u32) -> Word {
    Word { v: w.v >> shift & 1, u: w.u >> shift & 1 }
}
