//! Evaluation phases: which variant runs, partitions in order, edges, and what storage cells take at them.

use crate::compiled::ir::places::Slot;
use crate::compiled::lower::layout::Part;
use crate::compiled::runtime::variants::Variant;
use crate::compiled::runtime::{CompiledEngine, MOST_LOOP_RUNS, bit_of, codegen, feedback, set_bit, word_of};
use crate::netlist::NetId;
use crate::value::Word;
use crate::{UnknownControl, Unsettled, endless};

/// Runs of the partition of a loop that never settles.
const ENDLESS: u32 = u32::MAX;

impl CompiledEngine {
    /// The number of a variant in which these slots of state may be unknown, or all.
    pub(crate) fn variant(&mut self, unknown: Option<Vec<Slot>>) -> usize {
        if let Some(found) = self.variants.list.iter().position(|f| f.unknown == unknown) {
            return found;
        }
        let request = self.request();
        let mut end = self.memory.len() as u32;
        let variant = Variant::new(&self.netlist, &request, unknown, &mut end);
        let variant = variant.unwrap_or_else(|e| panic!("code for the circuit cannot be made: {e}"));
        self.memory.resize(end as usize, Word::ZERO);
        self.variants.list.push(variant);
        self.diagnostics.report.variants += 1;
        self.variants.list.len() - 1
    }

    /// Goes on in a variant, everything to be computed anew.
    pub(crate) fn enter(&mut self, number: usize) {
        if self.variants.current != Some(number) {
            self.variants.list[number].entered = self.diagnostics.report.phases();
        }
        self.variants.current = Some(number);
        self.variants.guard_failed = false;
        self.variants.stale = false;
        self.memory[0] = Word::ZERO;
        let variant = &self.variants.list[number];
        for &(plane, value, observed) in &variant.constants {
            let word = &mut self.memory[plane.slot().index()];
            let plane = if plane.is_value() { &mut word.v } else { &mut word.u };
            if std::mem::replace(plane, value) != value
                && let Some(bit) = observed
            {
                set_bit(&mut self.memory, self.variants.shared.changed, bit);
            }
        }
        for partition in 0..variant.machine.len() {
            let (word, bit) = codegen::dirty_bit(variant.settling, partition as u32);
            *word_of(&mut self.memory, variant.dirty + word) |= bit;
        }
        // what this variant takes to be known is
        for i in 0..self.diagnostics.seen.len() {
            if variant.doubtful.binary_search(&(i as u32)).is_err() {
                self.diagnostics.seen[i] = true;
            }
        }
    }

    /// Sees to it that there is a variant that allows what is unknown.
    pub(crate) fn ready(&mut self) {
        if let Some(number) = self.variants.current.filter(|_| !self.variants.guard_failed) {
            if self.variants.stale {
                self.enter(number);
            }
            return;
        }
        let number = self.choose();
        self.enter(number);
    }

    /// Runs the dirty ones among some partitions, in order.
    #[inline(always)]
    pub(crate) fn run_partitions(&mut self, late: bool) {
        let variant = self.variants.running();
        let settling = variant.settling.div_ceil(64);
        let (first, partition, n) = if late {
            (settling, variant.settling, variant.machine.len() - variant.settling)
        } else {
            (0, 0, variant.settling)
        };
        for word in 0..n.div_ceil(64) {
            let at = variant.dirty + (first + word) as u32;
            loop {
                let bits = word_of(&mut self.memory, at);
                if *bits == 0 {
                    break;
                }
                let number = partition + word * 64 + bits.trailing_zeros() as usize;
                *bits &= *bits - 1;
                variant.machine.run(number, &mut self.memory);
                // what has become unknown must not be read as known
                if self.memory[0].v != 0 {
                    return;
                }
                if let (false, Some(group)) = (self.layout.loops.is_empty(), variant.groups[number]) {
                    let runs = &mut self.settling.loop_runs[group as usize];
                    if *runs == ENDLESS {
                        // it has run once more, for those that read what it computes
                        *word_of(&mut self.memory, at) &= !codegen::dirty_bit(variant.settling, number as u32).1;
                        continue;
                    }
                    *runs += 1;
                    if *runs > MOST_LOOP_RUNS {
                        // it may never settle: that is found out step by step
                        *runs = 0;
                        let bit = codegen::dirty_bit(variant.settling, number as u32).1;
                        *word_of(&mut self.memory, at) &= !bit;
                        let settled =
                            self.settling.fixpoint.run(&self.netlist, &self.layout, &mut self.memory, group as usize);
                        // from what they came to the code goes on
                        for (_, slots) in
                            feedback::places(&self.netlist, &self.layout, &self.layout.loops[group as usize])
                        {
                            for slot in slots {
                                for &(word, bits) in variant.wakes(Slot::at(slot)) {
                                    *word_of(&mut self.memory, variant.dirty + word) |= bits;
                                }
                                if !variant.allows(Slot::at(slot)) {
                                    self.memory[0].v |= self.memory[slot].u;
                                }
                            }
                        }
                        *word_of(&mut self.memory, at) |= bit;
                        if let Err(nets) = settled {
                            // what keeps changing is x by now
                            self.settling.loop_runs[group as usize] = ENDLESS;
                            for net in nets {
                                if !self.settling.endless.contains(&net) {
                                    self.settling.endless.push(net);
                                }
                            }
                        }
                        if self.memory[0].v != 0 {
                            // code that takes it to be known would overwrite what has just become x
                            return;
                        }
                    }
                }
            }
        }
    }

    /// Writes a slot of state; if that changes it, wakes what reads it.
    #[inline(always)]
    pub(crate) fn put(&mut self, slot: Slot, net: NetId, new: Word) -> bool {
        let at = &mut self.memory[slot.index()];
        if *at == new {
            return false;
        }
        *at = new;
        if let Some(number) = self.variants.current {
            let variant = &self.variants.list[number];
            for &(word, bits) in variant.wakes(slot) {
                *word_of(&mut self.memory, variant.dirty + word) |= bits;
            }
            self.variants.guard_failed |= new.u != 0 && !variant.allows(slot);
        }
        if let Some(bit) = self.observation.number[net.index()] {
            self.observation.note(bit as usize);
        }
        true
    }

    /// Runs all that is to be settled. Feedback that never settles is reported after all else has.
    pub(crate) fn settle_partitions(&mut self) -> Result<(), Unsettled> {
        // a loop that never settles in this phase does not do so in another variant
        self.settling.loop_runs.fill(0);
        loop {
            self.ready();
            self.run_partitions(false);
            if self.memory[0].v == 0 {
                break;
            }
            self.memory[0].v = 0;
            self.variants.guard_failed = true;
        }
        if self.settling.endless.is_empty() {
            return Ok(());
        }
        Err(Unsettled { time: self.clocks.now, nets: std::mem::take(&mut self.settling.endless), clocked: false })
    }

    /// Lists the storage cells whose clock has made its edge since the last look.
    pub(crate) fn edges(&mut self) {
        self.settling.active.clear();
        for (i, &(slot, shift)) in self.settling.pins.iter().enumerate() {
            let new = bit_of(self.memory[slot.index()], shift);
            if self.settling.pins_before[i] == new {
                continue;
            }
            let old = std::mem::replace(&mut self.settling.pins_before[i], new).read();
            let new = new.read();
            let pin = &self.layout.pins[i];
            if self.settling.first {
                if pin.level && new.is_one() {
                    self.settling.active.extend(&pin.rising);
                }
                continue;
            }
            if old == new {
                continue;
            }
            let list = if old.is_zero() || new.is_one() { &pin.rising } else { &pin.falling };
            self.settling.active.extend(list);
            if old.is_zero() && new.u != 0 {
                self.settling.active.extend(&pin.unknown);
            }
        }
        if !self.settling.active.is_empty() {
            self.run_partitions(true);
        }
    }

    /// Lets the cells listed take what was computed for them.
    pub(crate) fn commit(&mut self) {
        let none_fixed = self.variants.running().fixed.is_empty();
        if !self.layout.memories.is_empty() {
            self.commit_ports();
        }
        for i in 0..self.settling.active.len() {
            let s = self.layout.stored[self.settling.active[i] as usize];
            if s.part != Part::Whole {
                continue;
            }
            for k in 0..s.words {
                let mut new = self.memory[(s.stage + k).index()];
                if !none_fixed {
                    new = self.fixed(s.slot + k, new);
                }
                self.put(s.slot + k, s.net, new);
            }
        }
    }

    /// What asynchronous controls make of a word that is sampled, where that is a constant.
    pub(crate) fn fixed(&self, slot: Slot, mut new: Word) -> Word {
        let variant = self.variants.running();
        for &(plane, value) in variant.fixed.iter().filter(|f| f.0.slot() == slot) {
            if plane.is_value() {
                new.v = value;
            } else if variant.allows(slot) {
                new.u = value;
            }
        }
        new
    }

    pub(crate) fn phase(&mut self) -> Result<(), Unsettled> {
        self.settling.touched = false;
        self.on_demand.clear();
        if let Some((slot, level)) = self.clocks.pending.take() {
            self.put_input(slot, Word::known(level.into()));
        }
        if !self.observation.prepared {
            self.prepare();
        }
        self.settling.started = true;
        let mut rounds = 0;
        let mut back = endless::Return::new();
        loop {
            self.settle_partitions()?;
            self.edges();
            if self.settling.active.is_empty() {
                break;
            }
            rounds += 1;
            if rounds > endless::HONEST_ROUNDS
                && (rounds >= endless::ROUNDS || back.has(|kept| self.is_sampled(kept), || self.sampled()))
            {
                return Err(self.oscillation());
            }
            self.commit();
        }
        self.settling.first = false;
        self.collect_changes();
        self.check_controls();
        self.count(1);
        self.improve();
        Ok(())
    }

    pub(crate) fn count(&mut self, phases: u64) {
        let variant = self.variants.running_mut();
        variant.phases += phases;
        match &variant.unknown {
            None => self.diagnostics.report.four_valued += phases,
            Some(list) if list.is_empty() => self.diagnostics.report.known += phases,
            Some(_) => self.diagnostics.report.mixed += phases,
        }
    }

    /// All that decides how a phase goes on once the cells have sampled: the state, contents of memories, and the cells.
    fn sampled(&self) -> (Vec<Word>, Vec<u32>) {
        (self.memory[self.held()].to_vec(), self.settling.active.clone())
    }

    fn is_sampled(&self, (state, active): &(Vec<Word>, Vec<u32>)) -> bool {
        self.memory[self.held()] == **state && self.settling.active == *active
    }

    /// Where state and the contents of memories lie, which follow it.
    fn held(&self) -> std::ops::Range<usize> {
        let end = self.layout.memories.iter().map(|m| m.contents + m.len).max().unwrap_or_default();
        self.layout.leaves.start.index()..self.layout.leaves.end.max(end).index()
    }

    /// The nets that clocked cells keep changing, until all is as it was.
    pub(crate) fn oscillation(&mut self) -> Unsettled {
        let mut nets = Vec::new();
        let start = self.sampled();
        for _ in 0..endless::SHOWN_ROUNDS {
            for &number in &self.settling.active {
                let s = self.layout.stored[number as usize];
                let old = &self.memory[s.slot.index()..][..s.words as usize];
                let differs = match s.part {
                    Part::Whole => *old != self.memory[s.stage.index()..][..s.words as usize],
                    Part::Read(_) => {
                        let mut ports: Vec<u32> =
                            self.settling.active.iter().copied().filter(|&n| self.stored(n).cell == s.cell).collect();
                        ports.sort_unstable();
                        ports.dedup();
                        *old != *self.port_reads(s, &ports)
                    }
                    Part::Write(_) => false,
                };
                if differs {
                    nets.push(s.net);
                }
            }
            self.commit();
            if self.settle_partitions().is_err() {
                break;
            }
            self.edges();
            if self.is_sampled(&start) {
                break;
            }
        }
        nets.sort_unstable();
        nets.dedup();
        Unsettled { time: self.clocks.now, nets, clocked: true }
    }

    /// Lists the observed nets whose bits generated code has set, or has them written down.
    pub(crate) fn collect_changes(&mut self) {
        for word in 0..self.observation.nets.len().div_ceil(64) {
            let mut bits = std::mem::take(word_of(&mut self.memory, self.variants.shared.changed + word as u32));
            while bits != 0 {
                self.observation.note(word * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
        self.write_down();
    }

    /// Lists the observed nets that have changed in edges, which have written down themselves what they are to.
    pub(crate) fn list_changes(&mut self) {
        for word in 0..self.observation.nets.len().div_ceil(64) {
            let mut bits = std::mem::take(word_of(&mut self.memory, self.variants.shared.changed + word as u32));
            while bits != 0 {
                self.observation.list(self.observation.nets[word * 64 + bits.trailing_zeros() as usize]);
                bits &= bits - 1;
            }
        }
    }

    /// Reports controls that have become unknown.
    pub(crate) fn check_controls(&mut self) {
        let variant = self.variants.running();
        if variant.doubtful.is_empty() {
            return;
        }
        let mut unknown: Vec<u32> = Vec::new();
        for &number in &variant.doubtful {
            let (slot, shift) = self.diagnostics.places[number as usize];
            let seen = &mut self.diagnostics.seen[number as usize];
            if bit_of(self.memory[slot.index()], shift).is_known() {
                *seen = true;
            } else if *seen {
                unknown.extend(&self.layout.controls[number as usize].1);
            }
        }
        unknown.sort_unstable();
        for number in unknown {
            let pin = self.layout.control_pins[number as usize];
            if !std::mem::replace(&mut self.diagnostics.reported[pin.cell.index()], true) {
                self.diagnostics.unknown_controls.push(UnknownControl {
                    time: self.clocks.now,
                    cell: pin.cell,
                    pin: pin.pin,
                    net: pin.net,
                });
            }
        }
    }
}
