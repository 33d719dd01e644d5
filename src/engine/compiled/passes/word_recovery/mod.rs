//! Word recovery: gates put together into operations on words. Bits that are computed alike from bits that lie side by side
//! become one operation, carry chains additions, trees of gates over the bits of a word comparisons.
//!
//! Single bits of state get bit-slice lanes of a word that they share, by the names that people gave to buses. From what each
//! such word becomes the way goes down: the operands of operations of one kind are words again, until they are bits that have
//! a word already, or are the same in all lanes, or differ and are put together one by one.
//!
//! Sound: a word holds in each of its lanes exactly the bit that was asked for there, and 0 in every other lane, so that parts
//! join with an OR. Operations that share a word do not depend on each other: they are on one level, a chain being one node.
//! Only nodes whose known-bits mask is 1 are bits.

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::PlaneWord;
use crate::compiled::ir::stores::Put;

pub(crate) mod chains;
mod gather;
mod rows;
mod step;
mod tree;

use chains::{Chain, bit_of};
use rows::in_rows;
pub(crate) use step::{Place, Step};

/// Bits of a word: the lane and the node of each.
type Lanes = Vec<(u8, Id)>;

/// The deepest logic that is packed.
const DEEPEST: u32 = 300;

/// Nodes that may be looked at in finding the chains that are worth it.
pub(crate) const TRIALS: usize = 1 << 17;

/// Bits of one kind that make it worth a word.
pub(crate) const LEAST: usize = 3;

/// The same with words of bits.
#[derive(Debug)]
pub(crate) struct Recovered {
    pub step: Step,
    pub places: Vec<Place>,
    #[cfg(test)]
    pub chains: usize,
    /// For nodes of the step the node here that is the same, or has it in a lane.
    #[cfg(test)]
    pub same: Vec<(Id, Id, Option<u8>)>,
}

/// What operations that share a word have in common.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Class {
    And,
    AndNot,
    Or,
    Not,
    Xor,
    /// Multiplexers with this select.
    Select(Id),
}

/// Where bits come from that one operation can bring into their lanes together.
#[derive(PartialEq, Eq, Hash)]
enum Source {
    /// Out of a carry chain.
    Chain(u32),
    /// A word of the graph, and by how many lanes it is to be shifted.
    Bit(Id, u8),
    /// A word that is made already, and by how many lanes it is to be shifted.
    Home(Id, u8),
    /// Operations of one class on one level, which may become a word.
    Class(Class, u32),
    /// Nothing else.
    Alone(Id),
}

struct Recovery<'g> {
    g: &'g Graph,
    out: Graph,
    levels: Vec<u32>,
    looks: Vec<u32>,
    /// How often a node is used.
    uses: Vec<u32>,
    /// The word here and the lane in it where a node of one bit lies.
    homes: Vec<(Id, u8)>,
    scalars: Vec<Id>,
    words: Map<Vec<(u8, Id)>, Id>,
    chains: &'g [Chain],
    /// The chain to be made before a node has a home.
    of_chain: Map<Id, u32>,
    made: Vec<bool>,
    least: usize,
    /// How many words of state take the same bits in the same lanes.
    demand: Map<Lanes, usize>,
}

/// Packs a step, the single bits of state in the lanes of `groups`, from `least` bits of a kind on; `fresh` gives their
/// words places. Tries what it is without some chains until `trials` nodes have been looked at. None where the logic is too
/// deep for that.
pub(crate) fn recover(
    step: &mut Step,
    groups: &[Vec<(u8, PlaneWord)>],
    least: usize,
    trials: usize,
    fresh: &mut dyn FnMut() -> PlaneWord,
) -> Option<Recovered> {
    let lanes = groups.iter().flatten().map(|&(lane, plane)| (plane, lane)).collect();
    *step = in_rows(step, &lanes);
    let mut chains = chains::find(&mut step.graph, &lanes);
    let uses = step.uses();
    chains.retain(|chain| !chain.is_tree(&step.graph, &uses));
    let places = step.places(groups, fresh);
    let mut best = attempt(step, &uses, &places, &chains, least)?;
    // a chain whose stages have little in common costs more than it gains
    let (mut at, mut looked) = (0, 0);
    while at < chains.len() && looked < trials {
        let chain = chains.remove(at);
        looked += step.graph.len();
        match attempt(step, &uses, &places, &chains, least) {
            Some(without) if without.step.cost() < best.step.cost() => best = without,
            _ => {
                chains.insert(at, chain);
                at += 1;
            }
        }
    }
    Some(best)
}

/// Packs a step that has these chains.
fn attempt(step: &Step, uses: &[u32], places: &[Place], chains: &[Chain], least: usize) -> Option<Recovered> {
    let g = &step.graph;
    let levels = level(g, chains);
    if levels.iter().copied().max().unwrap_or(0) > DEEPEST {
        return None;
    }
    let mut p = Recovery {
        g,
        out: Graph::default(),
        looks: chains::looks(g, 3),
        levels,
        uses: uses.to_vec(),
        homes: vec![(Id::NONE, 0); g.len()],
        scalars: vec![Id::NONE; g.len()],
        words: Map::default(),
        made: vec![false; chains.len()],
        chains,
        of_chain: Map::default(),
        least,
        demand: Map::default(),
    };
    p.carries();
    let loads = step.loads();
    let next: Map<PlaneWord, Id> = step.stores.iter().copied().collect();
    let mut roots: Vec<(PlaneWord, Lanes)> = Vec::new();
    let mut in_group: Map<PlaneWord, ()> = Map::default();
    for place in places {
        let mask = place.lanes.iter().fold(0, |m, l| m | 1 << l.0);
        let word = p.out.load(place.word, mask);
        for &(lane, plane) in &place.lanes {
            in_group.insert(plane, ());
            if let Some(&load) = loads.get(&plane) {
                p.homes[load.index()] = (word, lane);
            }
        }
        roots.push((place.word, place.lanes.iter().map(|&(lane, plane)| (lane, next[&plane])).collect()));
    }
    roots.iter().for_each(|(_, lanes)| p.expect(lanes));
    p.gather(&step.needed(), roots.iter().flat_map(|r| &r.1).map(|r| r.1));
    roots.sort_by_key(|r| std::cmp::Reverse(r.1.len()));
    let mut stores = Vec::new();
    for (place, lanes) in roots {
        let word = p.word(&lanes);
        if p.out.op(word) != Op::Load(place) {
            stores.push((place, word));
        }
    }
    for &(plane, node) in step.stores.iter().filter(|s| !in_group.contains_key(&s.0)) {
        let node = p.bit(node);
        stores.push((plane, node));
    }
    let bail_outs = step.bail_outs.iter().map(|&a| p.bit(a)).collect();
    let puts = step.puts.iter().map(|put| Put {
        index: p.bit(put.index),
        mask: p.bit(put.mask),
        v: p.bit(put.v),
        u: p.bit(put.u),
        ..*put
    });
    let puts = puts.collect();
    #[cfg(test)]
    let same = g
        .ids()
        .flat_map(|n| [(n, p.scalars[n.index()], None), (n, p.homes[n.index()].0, Some(p.homes[n.index()].1))])
        .filter(|s| s.1 != Id::NONE)
        .collect();
    Some(Recovered {
        #[cfg(test)]
        same,
        step: Step { graph: p.out, stores, puts, bail_outs },
        places: places.to_vec(),
        #[cfg(test)]
        chains: chains.len(),
    })
}

/// How far up each node lies, a chain being one node.
fn level(g: &Graph, chains: &[Chain]) -> Vec<u32> {
    let mut of: Map<Id, usize> = Map::default();
    for (number, chain) in chains.iter().enumerate() {
        chain.stages.iter().for_each(|s| _ = of.insert(s.out, number));
    }
    const NEW: u32 = u32::MAX;
    const OPEN: u32 = u32::MAX - 1;
    let n = g.len();
    let mut levels = vec![NEW; n + chains.len()];
    let mut stack = Vec::new();
    for root in 0..n {
        stack.push(root);
        while let Some(&at) = stack.last() {
            if levels[at] < OPEN {
                stack.pop();
                continue;
            }
            levels[at] = OPEN;
            let (mut top, before) = (0, stack.len());
            // where a chain reads its own carries, the way back does not count
            let mut look = |to: usize| match levels[to] {
                NEW => stack.push(to),
                OPEN => {}
                level => top = top.max(level + 1),
            };
            if at >= n {
                let Chain { base, stages } = &chains[at - n];
                look(base.index());
                stages.iter().flat_map(|s| [s.kill, s.make]).for_each(|o| look(o.index()));
            } else if let Some(&chain) = of.get(&Id::at(at)) {
                look(n + chain);
            } else {
                g.op(Id::at(at)).operands().for_each(|o| look(o.index()));
            }
            if stack.len() == before {
                levels[at] = top;
                stack.pop();
            }
        }
    }
    levels.truncate(n);
    levels
}

impl Recovery<'_> {
    /// Notes which nodes come out of a chain.
    fn carries(&mut self) {
        for (number, chain) in (0..).zip(self.chains) {
            for stage in &chain.stages {
                self.of_chain.insert(stage.out, number);
                if self.has_sum(stage) {
                    self.of_chain.entry(stage.sum).or_insert(number);
                }
            }
        }
    }

    /// Whether somebody has the sum of a stage.
    fn has_sum(&self, stage: &chains::Stage) -> bool {
        let sum = stage.sum;
        self.uses[sum.index()] > 0 && self.g.possible_bits(sum) == 1 && !self.g.op(sum).is_leaf()
    }

    /// Where a bit lies, if it has a lane of a word, or will have as soon as its chain is made.
    fn home(&mut self, node: Id) -> Option<(Id, u8)> {
        if self.homes[node.index()].0 == Id::NONE {
            if let Some(&chain) = self.of_chain.get(&node) {
                self.chain(chain as usize);
            } else if let Some((word, lane)) = bit_of(self.g, node)
                && self.g.possible_bits(word) > 1
            {
                self.homes[node.index()] = (self.bit(word), lane);
            }
        }
        Some(self.homes[node.index()]).filter(|h| h.0 != Id::NONE)
    }

    /// The lane in which a node best lies: that of some bit below it.
    fn hint(&self, node: Id, depth: u32) -> Option<u8> {
        let (word, lane) = self.homes[node.index()];
        if word != Id::NONE {
            return Some(lane);
        }
        if let Some((_, lane)) = bit_of(self.g, node) {
            return Some(lane);
        }
        if depth == 0 {
            return None;
        }
        self.g.op(node).operands().find_map(|o| self.hint(o, depth - 1))
    }

    /// Makes a chain: an addition of what its stages make.
    fn chain(&mut self, number: usize) {
        if std::mem::replace(&mut self.made[number], true) {
            return;
        }
        let Chain { base, stages } = &self.chains[number];
        let (base, n) = (*base, stages.len());
        let middle = n / 2;
        let hint = [stages[middle].kill, stages[middle].make].into_iter().find_map(|m| self.hint(m, 3));
        let first = usize::from(hint.unwrap_or(0)).saturating_sub(middle);
        let first = if first + n > 63 { 0 } else { first as u8 };
        let lanes = |of: &dyn Fn(usize) -> Id| (0..n).map(|i| (first + i as u8, of(i))).collect::<Vec<_>>();
        let kill = self.word(&lanes(&|i| stages[i].kill));
        let make = self.word(&lanes(&|i| stages[i].make));
        let base_here = self.bit(base);
        let g = &mut self.out;
        let placed = g.shl(base_here, first.into());
        let sum = g.add(kill, make);
        let sum = g.add(sum, placed);
        let apart = g.xor(kill, make);
        let carries = g.xor(sum, apart);
        let mask = ((1u64 << n) - 1) << first;
        let inverse = g.not(sum, mask | 1 << (usize::from(first) + n));
        for (i, stage) in stages.iter().enumerate() {
            let lane = first + i as u8;
            self.homes[stage.out.index()] = (if i + 1 == n { sum } else { carries }, lane + 1);
            if self.has_sum(stage) && self.homes[stage.sum.index()].0 == Id::NONE {
                self.homes[stage.sum.index()] = (if stage.inverted { inverse } else { sum }, lane);
            }
        }
    }

    /// A node as it is here.
    fn bit(&mut self, node: Id) -> Id {
        if self.scalars[node.index()] != Id::NONE {
            return self.scalars[node.index()];
        }
        let g = self.g;
        let made = match g.op(node) {
            Op::Const(n) => self.out.constant(n),
            Op::Load(plane) => match self.homes[node.index()] {
                (Id::NONE, _) => self.out.load(plane, g.possible_bits(node)),
                (word, lane) => self.out.bits(word, lane.into(), 1),
            },
            _ if g.possible_bits(node) == 1 && self.home(node).is_some() => {
                let (word, lane) = self.homes[node.index()];
                self.out.bits(word, lane.into(), 1)
            }
            Op::And(..) | Op::Or(..) | Op::AndNot(..) if g.possible_bits(node) == 1 => self.tree(node),
            Op::Or(..) => self.joined(node),
            op => self.plainly(node, op),
        };
        self.scalars[node.index()] = made;
        made
    }

    fn plainly(&mut self, node: Id, op: Op) -> Id {
        let operands: Vec<(Id, Id)> = op.operands().map(|o| (o, self.bit(o))).collect();
        let at = |o: Id| operands.iter().find(|p| p.0 == o).expect("it is an operand").1;
        self.out.rebuild(op, self.g.possible_bits(node), at)
    }

    /// A word put together of bits.
    fn joined(&mut self, node: Id) -> Id {
        let (mut lanes, mut rest, mut stack) = (Vec::new(), Vec::new(), vec![node]);
        let mut taken = 0u64;
        while let Some(at) = stack.pop() {
            let (bit, lane) = match self.g.op(at) {
                Op::Or(x, y) if at == node || self.uses[at.index()] == 1 => {
                    stack.extend([x, y]);
                    continue;
                }
                Op::Shl(x, k) if self.g.possible_bits(x) == 1 => (x, k),
                _ if self.g.possible_bits(at) == 1 => (at, 0),
                _ => {
                    rest.push(at);
                    continue;
                }
            };
            if taken >> lane & 1 == 1 {
                rest.push(at);
            } else {
                taken |= 1 << lane;
                lanes.push((lane, bit));
            }
        }
        if lanes.len() < 2 {
            return self.plainly(node, self.g.op(node));
        }
        lanes.sort_unstable();
        let mut all = self.word(&lanes);
        for part in rest {
            let part = self.bit(part);
            all = self.out.or(all, part);
        }
        all
    }

    /// What operations that are to share a word have in common; none for those that stay single.
    fn class(&self, node: Id) -> Option<Class> {
        if self.g.possible_bits(node) != 1 {
            return None;
        }
        Some(match self.g.op(node) {
            Op::And(a, b) if self.g.possible_bits(a) | self.g.possible_bits(b) == 1 => Class::And,
            Op::AndNot(a, b) if self.g.possible_bits(a) | self.g.possible_bits(b) == 1 => Class::AndNot,
            Op::Or(..) => Class::Or,
            Op::Xor(_, c) if self.g.is(c, 1) => Class::Not,
            Op::Xor(..) => Class::Xor,
            Op::Select(s, ..) => Class::Select(s),
            _ => return None,
        })
    }

    /// Bits in lanes as a word; what is not in them is 0.
    fn word(&mut self, lanes: &[(u8, Id)]) -> Id {
        if let [(lane, node)] = *lanes {
            let bit = self.bit(node);
            return self.out.shl(bit, lane.into());
        }
        if let Some(&word) = self.words.get(lanes) {
            return word;
        }
        let mut all = self.out.constant(0);
        // what is the same in several lanes
        let mut count: Map<Id, u64> = Map::default();
        lanes.iter().for_each(|&(lane, n)| *count.entry(n).or_default() |= 1 << lane);
        let mut ones = 0u64;
        let mut splats: Vec<(Id, u64)> = Vec::new();
        let mut rest: Lanes = Vec::new();
        for &(lane, node) in lanes {
            match self.g.value(node) {
                Some(0) => {}
                Some(_) => ones |= 1 << lane,
                None if count[&node].count_ones() >= 3 => {
                    if !splats.iter().any(|s| s.0 == node) {
                        splats.push((node, count[&node]));
                    }
                }
                None => rest.push((lane, node)),
            }
        }
        for (node, mask) in splats {
            let bit = self.bit(node);
            let part = self.out.splat(bit, mask);
            all = self.out.or(all, part);
        }
        // what lies in a word already
        let mut parts: Vec<(Id, i32, u64)> = Vec::new();
        let mut classes: Vec<((Class, u32), Lanes)> = Vec::new();
        let mut single: Lanes = Vec::new();
        for (lane, node) in rest {
            if let Some((word, at)) = self.home(node) {
                let by = i32::from(at) - i32::from(lane);
                match parts.iter_mut().find(|p| (p.0, p.1) == (word, by)) {
                    Some(part) => part.2 |= 1 << lane,
                    None => parts.push((word, by, 1 << lane)),
                }
                continue;
            }
            let Some(class) = self.class(node) else {
                single.push((lane, node));
                continue;
            };
            let class = (class, self.levels[node.index()]);
            match classes.iter_mut().find(|c| c.0 == class) {
                Some(found) => found.1.push((lane, node)),
                None => classes.push((class, vec![(lane, node)])),
            }
        }
        for (word, by, mask) in parts {
            let g = &mut self.out;
            let moved = if by >= 0 { g.shr(word, by as u32) } else { g.shl(word, -by as u32) };
            let mask = g.constant(mask);
            let part = g.and(moved, mask);
            all = g.or(all, part);
        }
        // what nothing else needs may lie on several levels: nobody can come between
        let mut late: Vec<(Class, Lanes)> = Vec::new();
        for ((class, _), list) in classes {
            if self.share(class, &list, &mut all) {
                continue;
            }
            for (lane, node) in list {
                match late.iter_mut().find(|l| l.0 == class) {
                    _ if self.uses[node.index()] != 1 => single.push((lane, node)),
                    Some(found) => found.1.push((lane, node)),
                    None => late.push((class, vec![(lane, node)])),
                }
            }
        }
        for (class, mut list) in late {
            list.sort_unstable();
            if !self.share(class, &list, &mut all) {
                single.extend(list);
            }
        }
        for (lane, node) in single {
            let bit = self.bit(node);
            let g = &mut self.out;
            let placed = g.shl(bit, lane.into());
            all = g.or(all, placed);
        }
        let ones = self.out.constant(ones);
        let all = self.out.or(all, ones);
        self.words.insert(lanes.to_vec(), all);
        all
    }

    /// Counts what a word of state will take.
    fn expect(&mut self, lanes: &[(u8, Id)]) {
        let mut classes: Vec<(Class, Lanes)> = Vec::new();
        for &(lane, node) in lanes.iter().filter(|l| self.uses[l.1.index()] == 1) {
            let Some(class) = self.class(node).filter(|&class| class != Class::Not) else { continue };
            match classes.iter_mut().find(|c| c.0 == class) {
                Some(found) => found.1.push((lane, node)),
                None => classes.push((class, vec![(lane, node)])),
            }
        }
        for (_, list) in classes {
            self.operands(&list).into_iter().for_each(|lanes| *self.demand.entry(lanes).or_default() += 1);
        }
    }

    /// Makes one operation of lanes of one class, if that pays, and joins it to a word.
    fn share(&mut self, class: Class, list: &[(u8, Id)], all: &mut Id) -> bool {
        if list.len() < self.least || !self.pays(list) {
            return false;
        }
        let part = self.together(class, list);
        for &(lane, node) in list {
            if self.homes[node.index()].0 == Id::NONE {
                self.homes[node.index()] = (part, lane);
            }
        }
        *all = self.out.or(*all, part);
        true
    }

    /// The two operands of lanes of one class, such that those that look alike stand together.
    fn operands(&self, list: &[(u8, Id)]) -> [Vec<(u8, Id)>; 2] {
        let mut out = [Vec::new(), Vec::new()];
        for &(lane, node) in list {
            let (mut a, mut b) = match self.g.op(node) {
                Op::And(a, b) | Op::Or(a, b) | Op::Xor(a, b) => {
                    // those that lie in words by these, others by what they look like
                    let key = |n: Id| match self.homes[n.index()].0 {
                        Id::NONE => (true, self.looks[n.index()], Id::NONE),
                        word => (false, 0, word),
                    };
                    if key(a) <= key(b) { (a, b) } else { (b, a) }
                }
                Op::AndNot(a, b) | Op::Select(_, a, b) => (a, b),
                _ => unreachable!("it is of a class"),
            };
            // an operand that all have is always on the same side
            if !matches!(self.g.op(node), Op::AndNot(..) | Op::Select(..))
                && let Some(&(_, first)) = out[0].first()
                && (b == first || out[1].first().is_some_and(|f: &(u8, Id)| f.1 == a))
            {
                std::mem::swap(&mut a, &mut b);
            }
            out[0].push((lane, a));
            out[1].push((lane, b));
        }
        out
    }

    /// Whether the operands lie together well enough.
    fn pays(&mut self, list: &[(u8, Id)]) -> bool {
        let inverts = matches!(self.g.op(list[0].1), Op::Xor(_, c) if self.g.is(c, 1));
        let operands = self.operands(list);
        let mut cost = 1;
        for lanes in &operands[..if inverts { 1 } else { 2 }] {
            if self.words.contains_key(lanes) {
                cost += 1;
                continue;
            }
            let mut side = 0;
            let mut sources: Map<Source, usize> = Map::default();
            let mut seen: Vec<Id> = Vec::new();
            for &(lane, node) in lanes {
                if self.g.value(node).is_some() || seen.contains(&node) {
                    continue;
                }
                seen.push(node);
                *sources.entry(self.source(lane, node)).or_default() += 1;
            }
            for (source, n) in sources {
                let lies = matches!(source, Source::Chain(_) | Source::Bit(..) | Source::Home(..));
                side += if lies || n >= self.least { 1 } else { 2 * n };
            }
            // what several words take is put together once
            cost += side.div_ceil(self.demand.get(lanes).copied().unwrap_or(1));
        }
        cost <= list.len() + 1
    }

    /// Where a bit that is wanted in a lane comes from.
    fn source(&self, lane: u8, node: Id) -> Source {
        match self.homes[node.index()] {
            (Id::NONE, _) => {}
            (word, at) => return Source::Home(word, at.wrapping_sub(lane)),
        }
        if let Some(&chain) = self.of_chain.get(&node) {
            return Source::Chain(chain);
        }
        if let Some((word, at)) = bit_of(self.g, node) {
            return Source::Bit(word, at.wrapping_sub(lane));
        }
        self.class(node).map_or(Source::Alone(node), |class| Source::Class(class, self.levels[node.index()]))
    }

    /// Operations of one class in their lanes.
    fn together(&mut self, class: Class, list: &[(u8, Id)]) -> Id {
        if class == Class::Not {
            let operands: Vec<(u8, Id)> = list
                .iter()
                .map(|&(lane, node)| (lane, self.g.op(node).operands().next().expect("it has two")))
                .collect();
            let word = self.word(&operands);
            return self.out.not(word, list.iter().fold(0, |m, l| m | 1 << l.0));
        }
        let [a, b] = self.operands(list);
        let (a, b) = (self.word(&a), self.word(&b));
        match class {
            Class::And => self.out.and(a, b),
            Class::AndNot => self.out.and_not(a, b),
            Class::Or => self.out.or(a, b),
            Class::Not | Class::Xor => self.out.xor(a, b),
            Class::Select(s) => {
                let s = self.bit(s);
                self.out.select(s, a, b)
            }
        }
    }
}

#[cfg(test)]
mod tests;
