//! A block of lanes, and one evaluation phase in all of them: as in the event engine, but what one lane does all do.

use super::combine::Seen;
use super::known::Known;
use super::lanes::{Chunk, Four, LANES, Planes};
use super::program::Program;
use crate::cell::CellKind;
use crate::value::Word;

/// Steps of a feedback group, and rounds of clock edges within a phase, after which a lane that has not settled is left
/// to the event engine, which can tell whether it ever will.
const PATIENCE: usize = 256;

/// Edge detection at one bit.
#[derive(Debug)]
pub(super) struct Watched {
    pub pending: bool,
    /// The bit when edges were last looked for.
    old: Vec<Four>,
}

impl Watched {
    /// What the bit was in a chunk of lanes when it was last looked at; known in all that run.
    pub fn recall(&mut self, c: usize, old: Chunk) {
        self.old[c] = Four::known(old);
    }
}

#[derive(Debug)]
pub(super) struct State {
    pub planes: Planes,
    /// Operations to run, a bit each; `lowest` is the first word that may have one.
    pub dirty: Vec<u64>,
    pub lowest: usize,
    pub watched: Vec<Watched>,
    pub pending: Vec<u32>,
    /// For each store the lanes in which its clock has made its edge.
    pub triggers: Vec<Vec<Chunk>>,
    triggered: Vec<u32>,
    is_triggered: Vec<bool>,
    /// Lanes that run; the others see no edges.
    pub active: Vec<Chunk>,
    /// Lanes that have not settled yet: what their bits become until then is no edge.
    first: Vec<Chunk>,
    /// Lanes that did not settle.
    pub unsettled: Vec<Chunk>,
    /// Lanes whose feedback is held, those that run no more among them; and whether there may be any.
    frozen: Vec<Chunk>,
    freezes: bool,
    // scratch, a chunk of lanes each
    pub masks: [Vec<Chunk>; 3],
    /// What has been seen of the bits of an operation; as many as any has, and none but while one runs.
    pub seen: Vec<Seen>,
    batch: Vec<u32>,
    /// Operations run, each in all lanes, a bit of output each.
    pub evaluated: u64,
    pub known: Known,
}

impl State {
    pub fn new(p: &Program, chunks: usize) -> State {
        let scratch = || vec![Chunk::ZERO; chunks];
        let outputs = |kind: &CellKind| (0..kind.outputs().len()).map(|pin| kind.output_width(pin) as usize).sum();
        let widest = p.cells.iter().map(outputs).max().unwrap_or(0);
        let mut state = State {
            planes: Planes::new(p.initial.len(), chunks),
            dirty: vec![0; p.ops.len().div_ceil(64)],
            lowest: 0,
            watched: (0..p.watches.len())
                .map(|_| Watched { pending: false, old: vec![Four::default(); chunks] })
                .collect(),
            pending: Vec::new(),
            triggers: vec![scratch(); p.stores.len()],
            triggered: Vec::new(),
            is_triggered: vec![false; p.stores.len()],
            active: scratch(),
            first: scratch(),
            unsettled: scratch(),
            frozen: scratch(),
            freezes: false,
            masks: [scratch(), scratch(), scratch()],
            seen: vec![Seen::default(); widest],
            batch: Vec::new(),
            evaluated: 0,
            known: Known::default(),
        };
        state.planes.write::<true>(super::program::ONE, |_| Four::known(Chunk::ONES));
        state.restart(p, &vec![Chunk::ONES; chunks]);
        state
    }

    pub fn lanes(&self) -> usize {
        self.planes.chunks * LANES
    }

    /// Puts some lanes back to the start, with nothing settled yet.
    pub fn restart(&mut self, p: &Program, lanes: &[Chunk]) {
        self.leave(p);
        for (bit, &init) in p.initial.iter().enumerate().skip(2) {
            let bit = bit as u32;
            let plane = self.planes.plane::<false>(bit);
            self.planes
                .write::<false>(bit, |c| plane.get(c).within(!lanes[c]).join(Four::splat(init).within(lanes[c])));
        }
        for (number, watch) in p.watches.iter().enumerate() {
            let first = p.initial[watch.bit as usize];
            let acts = watch.level && first.is_one();
            let old = Four::splat(if acts { Word::x(1) } else { first });
            let watched = &mut self.watched[number];
            for (c, &lanes) in lanes.iter().enumerate() {
                watched.old[c] = watched.old[c].within(!lanes).join(old.within(lanes));
            }
            if acts && !std::mem::replace(&mut watched.pending, true) {
                self.pending.push(number as u32);
            }
        }
        for (c, &lanes) in lanes.iter().enumerate() {
            self.active[c] |= lanes;
            self.first[c] |= lanes;
            self.unsettled[c] = self.unsettled[c] & !lanes;
            self.frozen[c] = self.frozen[c] & !lanes;
        }
        self.freezes = self.frozen.iter().any(|c| c.any());
        self.run_all(p);
    }

    /// All operations are to run.
    pub fn run_all(&mut self, p: &Program) {
        self.dirty.fill(u64::MAX);
        if let Some(last) = self.dirty.last_mut() {
            *last = crate::value::word::mask((p.ops.len() - (p.ops.len() - 1) / 64 * 64) as u32);
        }
        self.lowest = 0;
    }

    /// One evaluation phase: until nothing changes in any lane that runs.
    #[inline(always)]
    pub fn settle(&mut self, p: &Program) {
        for _ in 0..PATIENCE {
            self.combinational(p);
            if self.pending.is_empty() {
                self.first.fill(Chunk::ZERO);
                return;
            }
            self.edges(p);
            self.clock(p);
        }
        // who is still clocked is given up
        self.combinational(p);
        self.edges(p);
        let mut late = vec![Chunk::ZERO; self.planes.chunks];
        for &store in &self.triggered {
            self.triggers[store as usize].iter().zip(&mut late).for_each(|(t, late)| *late |= *t);
        }
        self.triggered.clear();
        self.is_triggered.fill(false);
        self.first.fill(Chunk::ZERO);
        self.give_up(&late);
    }

    fn give_up(&mut self, lanes: &[Chunk]) {
        for (c, &lanes) in lanes.iter().enumerate() {
            self.unsettled[c] |= lanes & self.active[c];
            self.active[c] = self.active[c] & !lanes;
            self.frozen[c] |= lanes;
            self.freezes |= lanes.any();
        }
    }

    /// Runs dirty operations in order until there are none.
    #[inline(always)]
    fn combinational(&mut self, p: &Program) {
        while self.lowest < self.dirty.len() {
            let word = self.lowest;
            let bits = self.dirty[word];
            if bits == 0 {
                self.lowest += 1;
                continue;
            }
            let number = word * 64 + bits.trailing_zeros() as usize;
            match p.ops[number].group {
                0 => {
                    self.dirty[word] = bits & (bits - 1);
                    self.one(p, number);
                }
                group => self.feedback(p, group as usize - 1),
            }
        }
    }

    #[inline(always)]
    fn one(&mut self, p: &Program, number: usize) {
        let op = &p.ops[number];
        let pins = &p.pool[op.pins[0] as usize..op.pins[op.pin_count as usize] as usize];
        self.evaluated += u64::from(op.width);
        if op.keeps_known && self.planes.all_known(pins) {
            self.run::<true>(p, op);
        } else {
            self.run::<false>(p, op);
        }
    }

    /// Iterates a feedback group until it has settled in every lane that runs. In each step all operations compute from
    /// the values before it.
    fn feedback(&mut self, p: &Program, group: usize) {
        let g = &p.groups[group];
        for step in 0.. {
            self.batch.clear();
            for number in g.ops.clone() {
                let (word, bit) = (number / 64, 1u64 << (number % 64));
                if self.dirty[word] & bit != 0 {
                    self.dirty[word] &= !bit;
                    self.batch.push(number as u32);
                }
            }
            if self.batch.is_empty() {
                return;
            }
            let batch = std::mem::take(&mut self.batch);
            for &number in &batch {
                self.one(p, number as usize);
            }
            if step >= PATIENCE {
                self.give_up_changing(g, &batch);
            }
            for &number in &batch {
                for &(copy, bit) in &g.outputs[number as usize - g.ops.start] {
                    let changed = self.commit(copy, bit);
                    self.tell(p, bit, changed);
                }
            }
            self.batch = batch;
        }
    }

    /// Gives up the lanes in which a step of a group changes anything.
    fn give_up_changing(&mut self, g: &super::program::Group, batch: &[u32]) {
        let mut late = vec![Chunk::ZERO; self.planes.chunks];
        for &number in batch {
            for &(copy, bit) in &g.outputs[number as usize - g.ops.start] {
                let [new, old] = [copy, bit].map(|bit| self.planes.plane::<false>(bit));
                for (c, late) in late.iter_mut().enumerate() {
                    let (new, old) = (new.get(c), old.get(c));
                    *late |= (new.v ^ old.v) | (new.u ^ old.u);
                }
            }
        }
        self.give_up(&late);
    }

    /// Copies a bit to another in the lanes that have not been given up.
    fn commit(&mut self, from: u32, to: u32) -> bool {
        if !self.freezes {
            return self.planes.copy(from, to);
        }
        let [from, old] = [from, to].map(|bit| self.planes.plane::<false>(bit));
        let frozen = &self.frozen;
        self.planes.write::<false>(to, |c| from.get(c).within(!frozen[c]).join(old.get(c).within(frozen[c])))
    }

    /// Finds the edges made since the last time, and the stores that they trigger in which lanes.
    #[inline(always)]
    fn edges(&mut self, p: &Program) {
        while let Some(number) = self.pending.pop() {
            let (watch, watched) = (&p.watches[number as usize], &mut self.watched[number as usize]);
            watched.pending = false;
            let plane = self.planes.plane::<false>(watch.bit);
            let (mut rose, mut fell, mut blurred) = (Chunk::ZERO, Chunk::ZERO, Chunk::ZERO);
            let [rising, falling, unknown] = &mut self.masks;
            for c in 0..self.planes.chunks {
                let (raw, old) = (plane.get(c), watched.old[c].read());
                watched.old[c] = raw;
                let new = raw.read();
                let first = self.first[c] & self.active[c];
                let moved = ((old.v ^ new.v) | (old.u ^ new.u)) & self.active[c] & !first;
                rising[c] = moved & (old.zeros() | new.ones());
                if watch.level {
                    // such a control acts if it is active from the start
                    rising[c] |= first & new.ones() & !old.ones();
                }
                falling[c] = moved & !(old.zeros() | new.ones());
                unknown[c] = moved & old.zeros() & new.u;
                rose |= rising[c];
                fell |= falling[c];
                blurred |= unknown[c];
            }
            for (any, lanes, stores) in [
                (rose, &*rising, &watch.rising),
                (fell, &*falling, &watch.falling),
                (blurred, &*unknown, &watch.unknown),
            ] {
                if !any.any() {
                    continue;
                }
                for &store in stores {
                    let triggers = &mut self.triggers[store as usize];
                    if std::mem::replace(&mut self.is_triggered[store as usize], true) {
                        triggers.iter_mut().zip(lanes).for_each(|(t, lanes)| *t |= *lanes);
                    } else {
                        triggers.copy_from_slice(lanes);
                        self.triggered.push(store);
                    }
                }
            }
        }
    }

    /// All triggered stores sample; then their states change.
    #[inline(always)]
    fn clock(&mut self, p: &Program) {
        let mut triggered = std::mem::take(&mut self.triggered);
        // no closure: it would not be inlined
        let mut kept = 0;
        for at in 0..triggered.len() {
            let number = triggered[at];
            self.is_triggered[number as usize] = false;
            let store = &p.stores[number as usize];
            let op = &store.op;
            let pins = &p.pool[op.pins[0] as usize..op.pins[op.pin_count as usize] as usize];
            self.evaluated += u64::from(op.width);
            let changes = if op.keeps_known && self.planes.all_known(pins) {
                self.sample::<true>(p, store, number as usize)
            } else {
                self.sample::<false>(p, store, number as usize)
            };
            if changes {
                triggered[kept] = number;
                kept += 1;
            }
        }
        triggered.truncate(kept);
        for &number in &triggered {
            let store = &p.stores[number as usize];
            for i in 0..store.op.width {
                let changed = self.planes.copy(store.next + i, store.q + i);
                self.tell(p, store.q + i, changed);
            }
        }
        triggered.clear();
        self.triggered = triggered;
    }
}
