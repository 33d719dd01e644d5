//! Waves: which form runs, chunks in order, edges and what is taken at them.

use crate::compiled::ir::places::Slot;
use crate::compiled::lower::layout::Part;
use crate::compiled::runtime::narrow::Looks;
use crate::compiled::runtime::variants::Form;
use crate::compiled::runtime::{CompiledEngine, STEPS_COMPILED, bit_of, codegen, feedback, set_bit, word_of};
use crate::netlist::NetId;
use crate::value::Word;
use crate::{UnknownControl, Unsettled, endless};

/// Runs of the chunk of a loop that never settles.
const ENDLESS: u32 = u32::MAX;

impl CompiledEngine<'_> {
    /// The number of a form in which these slots of state may be unknown, or all.
    pub(crate) fn form(&mut self, unknown: Option<Vec<Slot>>) -> usize {
        if let Some(found) = self.forms.iter().position(|f| f.unknown == unknown) {
            return found;
        }
        let wanted = self.wanted();
        let mut end = self.memory.len() as u32;
        let form = Form::new(self.netlist, &wanted, unknown, &mut end);
        let form = form.unwrap_or_else(|e| panic!("code for the circuit cannot be made: {e}"));
        self.memory.resize(end as usize, Word::ZERO);
        self.forms.push(form);
        self.report.forms += 1;
        self.forms.len() - 1
    }

    /// Goes on in a form, everything to be computed anew.
    pub(crate) fn enter(&mut self, number: usize) {
        self.current = Some(number);
        self.alarmed = false;
        self.stale = false;
        self.memory[0] = Word::ZERO;
        let form = &self.forms[number];
        for &(plane, value, observed) in &form.constants {
            let word = &mut self.memory[plane.slot().index()];
            let plane = if plane.is_value() { &mut word.v } else { &mut word.u };
            if std::mem::replace(plane, value) != value
                && let Some(bit) = observed
            {
                set_bit(&mut self.memory, self.shared.changed, bit);
            }
        }
        for chunk in 0..form.machine.len() {
            let (word, bit) = codegen::dirty_bit(form.settling, chunk as u32);
            *word_of(&mut self.memory, form.dirty + word) |= bit;
        }
        // what this form takes to be known is
        for i in 0..self.control_seen.len() {
            if form.doubtful.binary_search(&(i as u32)).is_err() {
                self.control_seen[i] = true;
            }
        }
    }

    /// Sees to it that there is a form that allows what is unknown.
    pub(crate) fn ready(&mut self) {
        if let Some(number) = self.current.filter(|_| !self.alarmed) {
            if self.stale {
                self.enter(number);
            }
            return;
        }
        if self.current.is_some() {
            // the next attempt at a faster form is to wait longer
            self.patience = (self.patience * 2).min(1 << 20);
        }
        self.looks = Looks::from(self.report.waves(), self.patience / 2);
        let number = if self.find_unknown().is_none() { self.form(Some(Vec::new())) } else { self.form(None) };
        self.enter(number);
    }

    /// Runs the dirty ones among some chunks, in order.
    #[inline(always)]
    pub(crate) fn run_chunks(&mut self, late: bool) {
        let form = &self.forms[self.current.expect("there is a form")];
        let settling = form.settling.div_ceil(64);
        let (first, chunk, n) =
            if late { (settling, form.settling, form.machine.len() - form.settling) } else { (0, 0, form.settling) };
        for word in 0..n.div_ceil(64) {
            let at = form.dirty + (first + word) as u32;
            loop {
                let bits = word_of(&mut self.memory, at);
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
                    if *runs == ENDLESS {
                        // it has run once more, for those that read what it computes
                        *word_of(&mut self.memory, at) &= !codegen::dirty_bit(form.settling, number as u32).1;
                        continue;
                    }
                    *runs += 1;
                    if *runs > STEPS_COMPILED {
                        // it may never settle: that is found out step by step
                        *runs = 0;
                        let bit = codegen::dirty_bit(form.settling, number as u32).1;
                        *word_of(&mut self.memory, at) &= !bit;
                        let settled = self.steps.run(self.netlist, &self.wiring, &mut self.memory, group as usize);
                        // from what they came to the code goes on
                        for (_, slots) in
                            feedback::places(self.netlist, &self.wiring, &self.wiring.loops[group as usize])
                        {
                            for slot in slots {
                                for &(word, bits) in form.wakes(Slot::at(slot)) {
                                    *word_of(&mut self.memory, form.dirty + word) |= bits;
                                }
                                if !form.allows(Slot::at(slot)) {
                                    self.memory[0].v |= self.memory[slot].u;
                                }
                            }
                        }
                        *word_of(&mut self.memory, at) |= bit;
                        if let Err(nets) = settled {
                            // what keeps changing is x by now
                            self.loop_runs[group as usize] = ENDLESS;
                            for net in nets {
                                if !self.endless.contains(&net) {
                                    self.endless.push(net);
                                }
                            }
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
        if let Some(number) = self.current {
            let form = &self.forms[number];
            for &(word, bits) in form.wakes(slot) {
                *word_of(&mut self.memory, form.dirty + word) |= bits;
            }
            self.alarmed |= new.u != 0 && !form.allows(slot);
        }
        if let Some(bit) = self.observed[net.index()] {
            self.note(bit as usize);
        }
        true
    }

    /// Sees to it that a change of an observed or traced net becomes known.
    #[inline(always)]
    pub(crate) fn note(&mut self, bit: usize) {
        if self.stops[bit] {
            self.list_change(self.observed_nets[bit]);
        }
        if self.tracing.nets[bit] {
            self.tracing.changed.insert(bit);
        }
    }

    pub(crate) fn list_change(&mut self, net: NetId) {
        if !std::mem::replace(&mut self.listed[net.index()], true) {
            self.changes.push(net);
        }
    }

    /// Runs all that is to be settled. Feedback that never settles is reported after all else has.
    pub(crate) fn settle_chunks(&mut self) -> Result<(), Unsettled> {
        loop {
            self.loop_runs.fill(0);
            self.ready();
            self.run_chunks(false);
            if self.memory[0].v == 0 {
                break;
            }
            self.memory[0].v = 0;
            self.alarmed = true;
        }
        if self.endless.is_empty() {
            return Ok(());
        }
        Err(Unsettled { time: self.now, nets: std::mem::take(&mut self.endless), clocked: false })
    }

    /// Lists the storage cells whose clock has made its edge since the last look.
    pub(crate) fn edges(&mut self) {
        self.active.clear();
        for (i, &(slot, shift)) in self.pin_places.iter().enumerate() {
            let new = bit_of(self.memory[slot.index()], shift);
            if self.watches[i] == new {
                continue;
            }
            let old = std::mem::replace(&mut self.watches[i], new).read();
            let new = new.read();
            let pin = &self.wiring.pins[i];
            if self.first {
                if pin.level && new.is_one() {
                    self.active.extend(&pin.rising);
                }
                continue;
            }
            if old == new {
                continue;
            }
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
    pub(crate) fn commit(&mut self) {
        let none_fixed = self.forms[self.current.expect("there is a form")].fixed.is_empty();
        if !self.wiring.memories.is_empty() {
            self.commit_ports();
        }
        for i in 0..self.active.len() {
            let s = self.wiring.stored[self.active[i] as usize];
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
        let form = &self.forms[self.current.expect("there is a form")];
        for &(plane, value) in form.fixed.iter().filter(|f| f.0.slot() == slot) {
            if plane.is_value() {
                new.v = value;
            } else if form.allows(slot) {
                new.u = value;
            }
        }
        new
    }

    pub(crate) fn wave(&mut self) -> Result<(), Unsettled> {
        self.touched = false;
        self.peeked.clear();
        if let Some((slot, level)) = self.pending.take() {
            self.put_input(slot, Word::known(level.into()));
        }
        if !self.prepared {
            self.prepare();
        }
        self.started = true;
        let mut rounds = 0;
        let mut back = endless::Return::new();
        loop {
            self.settle_chunks()?;
            self.edges();
            if self.active.is_empty() {
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
        self.first = false;
        self.collect_changes();
        self.check_controls();
        self.count(1);
        self.improve();
        Ok(())
    }

    pub(crate) fn count(&mut self, waves: u64) {
        let form = &mut self.forms[self.current.expect("there is a form")];
        form.waves += waves;
        match &form.unknown {
            None => self.report.four_valued += waves,
            Some(list) if list.is_empty() => self.report.known += waves,
            Some(_) => self.report.mixed += waves,
        }
    }

    /// All that decides how a wave goes on once the cells have sampled: the state, contents of memories, and the cells.
    fn sampled(&self) -> (Vec<Word>, Vec<u32>) {
        (self.memory[self.held()].to_vec(), self.active.clone())
    }

    fn is_sampled(&self, (state, active): &(Vec<Word>, Vec<u32>)) -> bool {
        self.memory[self.held()] == **state && self.active == *active
    }

    /// Where state and the contents of memories lie, which follow it.
    fn held(&self) -> std::ops::Range<usize> {
        let end = self.wiring.memories.iter().map(|m| m.contents + m.len).max().unwrap_or_default();
        self.wiring.leaves.start.index()..self.wiring.leaves.end.max(end).index()
    }

    /// The nets that clocked cells keep changing, until all is as it was.
    pub(crate) fn oscillation(&mut self) -> Unsettled {
        let mut nets = Vec::new();
        let start = self.sampled();
        for _ in 0..endless::SHOWN_ROUNDS {
            for &number in &self.active {
                let s = self.wiring.stored[number as usize];
                let old = &self.memory[s.slot.index()..][..s.words as usize];
                let differs = match s.part {
                    Part::Whole => *old != self.memory[s.stage.index()..][..s.words as usize],
                    Part::Read(_) => {
                        let mut ports: Vec<u32> =
                            self.active.iter().copied().filter(|&n| self.stored(n).cell == s.cell).collect();
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
            if self.settle_chunks().is_err() {
                break;
            }
            self.edges();
            if self.is_sampled(&start) {
                break;
            }
        }
        nets.sort_unstable();
        nets.dedup();
        Unsettled { time: self.now, nets, clocked: true }
    }

    /// Lists the observed nets whose bits generated code has set, or has them written down.
    pub(crate) fn collect_changes(&mut self) {
        for word in 0..self.observed_nets.len().div_ceil(64) {
            let mut bits = std::mem::take(word_of(&mut self.memory, self.shared.changed + word as u32));
            while bits != 0 {
                self.note(word * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
        self.write_down();
    }

    /// Lists the observed nets that have changed in ticks, which have written down themselves what they are to.
    pub(crate) fn list_changes(&mut self) {
        for word in 0..self.observed_nets.len().div_ceil(64) {
            let mut bits = std::mem::take(word_of(&mut self.memory, self.shared.changed + word as u32));
            while bits != 0 {
                self.list_change(self.observed_nets[word * 64 + bits.trailing_zeros() as usize]);
                bits &= bits - 1;
            }
        }
    }

    /// Reports controls that have become unknown.
    pub(crate) fn check_controls(&mut self) {
        let form = &self.forms[self.current.expect("there is a form")];
        if form.doubtful.is_empty() {
            return;
        }
        let mut unknown: Vec<u32> = Vec::new();
        for &number in &form.doubtful {
            let (slot, shift) = self.control_places[number as usize];
            let seen = &mut self.control_seen[number as usize];
            if bit_of(self.memory[slot.index()], shift).is_known() {
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
}
