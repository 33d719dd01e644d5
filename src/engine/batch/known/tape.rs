//! A graph of functions as straight code over planes: which functions are left, in which order, and where each puts its
//! result.
//!
//! Functions that only one other needs are made part of it while that has no more than three inputs. Those that are
//! alike are brought together, so that one loop runs many of them; results that nothing keeps share a few planes, which
//! stay in the first cache however large the netlist is.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::ops::Range;

use super::logic::{Lit, Logic, Node, depends, inverted, moved};

/// Functions among which alike ones are looked for.
const WINDOW: usize = 160;

/// The plane that is 0 in all lanes.
const ZERO: u32 = 0;

/// One function: its result's plane, and its inputs'.
pub(super) type Instruction = [u32; 4];

/// A step of a tape.
#[derive(Debug)]
pub(super) enum Step {
    /// Runs in order.
    Straight(Range<usize>),
    /// Runs again and again, until no plane differs from its copy; which is then the same.
    Loop(Range<usize>, Vec<(u32, u32)>),
}

/// Straight code.
#[derive(Debug, Default)]
pub(super) struct Tape {
    pub instructions: Vec<Instruction>,
    /// A table and how many instructions with it follow.
    pub runs: Vec<(u8, u32)>,
    pub steps: Vec<Step>,
    /// Functions that it computes.
    pub functions: u64,
    /// Planes that are used for what nothing keeps.
    pub scratch: u32,
}

/// A part of what is to be computed.
pub(super) struct Part {
    /// Nodes of the graph up to here, those of the parts before it left out.
    pub end: usize,
    /// What goes into which plane.
    pub roots: Vec<(Lit, u32)>,
    /// Of a loop: the copies and their planes.
    pub pairs: Option<Vec<(u32, u32)>>,
}

/// A table over inputs in the order that all tables of its kind are brought into.
fn canonical(t: u8) -> (u8, [usize; 3]) {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let used = (0..3).filter(|&i| depends(t, i)).count();
    let fits = |t: u8| (0..3).all(|i| depends(t, i) == (i < used));
    let all = ORDERS.into_iter().map(|places| (moved(t, places), places)).filter(|(t, _)| fits(*t));
    all.min().unwrap_or((t, ORDERS[0]))
}

/// One function that is computed.
struct Item {
    table: u8,
    ins: Vec<usize>,
    /// Where its result is kept, if anywhere, and whether inverted.
    home: Option<u32>,
    inverts: bool,
    part: usize,
}

struct Emit<'l> {
    logic: &'l Logic,
    /// By node, and copies behind them.
    items: Vec<Option<Item>>,
    uses: Vec<u32>,
    /// By part.
    lists: Vec<Vec<usize>>,
}

/// Makes a tape of a graph. With `at_once` what is put into planes is put there at the end, as far as others read what
/// was there.
pub(super) fn emit(logic: &Logic, parts: Vec<Part>, at_once: bool, scratch: u32) -> Tape {
    let mut e = Emit { logic, items: Vec::new(), uses: vec![0; logic.nodes.len()], lists: Vec::new() };
    e.collect(&parts);
    let functions = e.items.iter().flatten().count() as u64;
    e.fuse();
    let late = e.bind(&parts, at_once);
    let mut tape = e.schedule(&parts, late, scratch);
    tape.functions = functions;
    tape
}

impl Emit<'_> {
    /// What is needed.
    fn collect(&mut self, parts: &[Part]) {
        for (lit, _) in parts.iter().flat_map(|p| &p.roots) {
            self.uses[lit.node()] += 1;
        }
        let part_of = |node: usize| parts.partition_point(|p| p.end <= node);
        self.items.resize_with(self.logic.nodes.len(), || None);
        for number in (0..self.logic.nodes.len()).rev() {
            if let (Node::Table(table, ins), true) = (self.logic.nodes[number], self.uses[number] > 0) {
                let ins: Vec<usize> = (0..3).filter(|&i| depends(table, i)).map(|i| ins[i] as usize).collect();
                ins.iter().for_each(|&i| self.uses[i] += 1);
                self.items[number] = Some(Item { table, ins, home: None, inverts: false, part: part_of(number) });
            }
        }
    }

    /// Makes functions that one other alone needs part of it.
    fn fuse(&mut self) {
        for number in 0..self.items.len() {
            let Some(mut item) = self.items[number].take() else { continue };
            while let Some((inner, ins)) = item.ins.iter().find_map(|&i| {
                let inner = self.items[i].as_ref().filter(|inner| self.uses[i] == 1 && inner.part == item.part)?;
                let mut ins: Vec<usize> = item.ins.iter().copied().filter(|&k| k != i).collect();
                inner.ins.iter().for_each(|k| {
                    if !ins.contains(k) {
                        ins.push(*k);
                    }
                });
                (ins.len() <= 3).then_some((i, ins))
            }) {
                let Some(part) = self.items[inner].take() else { break };
                let look = |table: u8, of: &[usize], values: &dyn Fn(usize) -> bool| {
                    let at = (0..3).fold(0, |at, i| at << 1 | u8::from(of.get(i).is_some_and(|&i| values(i))));
                    table >> at & 1 == 1
                };
                let table = (0..8u8).fold(0, |all, at| {
                    let outer = |i: usize| ins.iter().position(|&k| k == i).is_some_and(|k| at >> (2 - k) & 1 == 1);
                    let of_part = look(part.table, &part.ins, &outer);
                    let bit = look(item.table, &item.ins, &|i| if i == inner { of_part } else { outer(i) });
                    all | u8::from(bit) << at
                });
                for i in &part.ins {
                    if item.ins.contains(i) {
                        self.uses[*i] -= 1;
                    }
                }
                (item.table, item.ins) = (table, ins);
                // what it does not depend on any more
                for i in (0..item.ins.len()).rev().filter(|&i| !depends(table, i)) {
                    self.uses[item.ins[i]] -= 1;
                }
                let kept: Vec<usize> = (0..item.ins.len()).filter(|&i| depends(table, i)).collect();
                let mut places = [2; 3];
                let dropped = (0..3).filter(|i| !kept.contains(i));
                kept.iter().copied().chain(dropped).enumerate().for_each(|(to, from)| places[from] = to);
                item.table = moved(item.table, places);
                item.ins = kept.into_iter().map(|i| item.ins[i]).collect();
            }
            self.items[number] = Some(item);
        }
    }

    fn copy(&mut self, lit: Lit, plane: Option<u32>, part: usize) -> usize {
        let table = if lit.inverted() { 0x0f } else { 0xf0 };
        self.items.push(Some(Item { table, ins: vec![lit.node()], home: plane, inverts: false, part }));
        self.items.len() - 1
    }

    /// Says where results are kept; the copies that are to be made last.
    fn bind(&mut self, parts: &[Part], at_once: bool) -> Vec<usize> {
        let mut readers: HashMap<u32, Vec<usize>> = HashMap::new();
        for (number, item) in self.items.iter().enumerate() {
            for &i in item.iter().flat_map(|item| &item.ins) {
                if let Node::Source(plane) = self.logic.nodes[i] {
                    readers.entry(plane).or_default().push(number);
                }
            }
        }
        let mut late = Vec::new();
        for (part, p) in parts.iter().enumerate() {
            for &(lit, plane) in &p.roots {
                let node = lit.node();
                if self.logic.nodes[node] == Node::Source(plane) && !lit.inverted() {
                    continue;
                }
                let others = at_once && readers.get(&plane).is_some_and(|all| all.iter().any(|&r| r != node));
                match &mut self.items[node] {
                    Some(item) if item.home.is_none() && item.part == part && !others => {
                        (item.home, item.inverts) = (Some(plane), lit.inverted());
                    }
                    Some(_) if !at_once => _ = self.copy(lit, Some(plane), part),
                    Some(_) => late.push(self.copy(lit, Some(plane), part)),
                    None if !at_once => _ = self.copy(lit, Some(plane), part),
                    None => {
                        // what is read may be overwritten first
                        self.copy(lit, None, part);
                        let held = Item {
                            table: 0xf0,
                            ins: vec![self.items.len() - 1],
                            home: Some(plane),
                            inverts: false,
                            part,
                        };
                        self.items.push(Some(held));
                        late.push(self.items.len() - 1);
                    }
                }
            }
        }
        let mut is_late = vec![false; self.items.len()];
        late.iter().for_each(|&number| is_late[number] = true);
        self.lists = vec![Vec::new(); parts.len()];
        for (number, item) in self.items.iter().enumerate() {
            if let Some(item) = item
                && !is_late[number]
            {
                self.lists[item.part].push(number);
            }
        }
        late
    }

    /// An order of a part's items in which those of one table come together.
    fn order(&self, part: usize) -> Vec<usize> {
        let list = &self.lists[part];
        let place: HashMap<usize, usize> = list.iter().enumerate().map(|(at, &n)| (n, at)).collect();
        let mut readers: HashMap<u32, Vec<usize>> = HashMap::new();
        let mut waits = vec![0u32; list.len()];
        let mut wakes: Vec<Vec<usize>> = vec![Vec::new(); list.len()];
        for (at, &number) in list.iter().enumerate() {
            for &i in self.items[number].iter().flat_map(|item| &item.ins) {
                if let Some(&from) = place.get(&i) {
                    wakes[from].push(at);
                    waits[at] += 1;
                } else if let Some(Node::Source(plane)) = self.logic.nodes.get(i) {
                    readers.entry(*plane).or_default().push(at);
                }
            }
        }
        // who writes to a plane comes after all who read what was there
        for (at, &number) in list.iter().enumerate() {
            let home = self.items[number].as_ref().and_then(|item| item.home);
            for &reader in home.and_then(|plane| readers.get(&plane)).into_iter().flatten() {
                if reader != at {
                    wakes[reader].push(at);
                    waits[at] += 1;
                }
            }
        }
        let table = |at: usize| self.instruction_table(list[at]).0;
        let mut ready: BTreeMap<u8, VecDeque<usize>> = BTreeMap::new();
        let (mut opened, mut done, mut first) = (0, vec![false; list.len()], 0);
        let mut current = 0;
        let mut order = Vec::with_capacity(list.len());
        while order.len() < list.len() {
            while opened < list.len().min(first + WINDOW) {
                if waits[opened] == 0 {
                    ready.entry(table(opened)).or_default().push_back(opened);
                }
                opened += 1;
            }
            if ready.get(&current).is_none_or(VecDeque::is_empty) {
                let most = ready.iter().max_by_key(|(_, all)| all.len());
                current = most.map_or(current, |m| *m.0);
            }
            // a window without anything ready cannot be: its first waits for nothing within it but what is before it,
            // unless it overwrites what others read
            let Some(at) = ready.get_mut(&current).and_then(VecDeque::pop_front) else {
                if opened == list.len() {
                    unreachable!("functions wait for each other");
                }
                first = opened;
                continue;
            };
            order.push(list[at]);
            done[at] = true;
            while first < list.len() && done[first] {
                first += 1;
            }
            for &next in &wakes[at] {
                waits[next] -= 1;
                if waits[next] == 0 && next < opened {
                    ready.entry(table(next)).or_default().push_back(next);
                }
            }
        }
        order
    }

    /// The table of an item as it is run, and where its inputs stand in it.
    fn instruction_table(&self, number: usize) -> (u8, [usize; 3]) {
        let Some(item) = &self.items[number] else { return (0, [0; 3]) };
        let mut table = item.table;
        for (i, &from) in item.ins.iter().enumerate() {
            if self.items[from].as_ref().is_some_and(|from| from.inverts) {
                table = inverted(table, i);
            }
        }
        canonical(if item.inverts { !table } else { table })
    }

    fn schedule(&self, parts: &[Part], late: Vec<usize>, scratch: u32) -> Tape {
        let mut tape = Tape::default();
        let mut orders: Vec<Vec<usize>> = (0..parts.len()).map(|part| self.order(part)).collect();
        if let Some(last) = orders.last_mut() {
            last.extend(late);
        }
        // the place after which a result is needed no more
        let mut last_use = vec![0usize; self.items.len()];
        let mut at = 0;
        for (part, order) in orders.iter().enumerate() {
            let end = at + order.len();
            for &number in order {
                let Some(item) = &self.items[number] else { continue };
                for &i in &item.ins {
                    let outside = self.items[i].as_ref().is_some_and(|from| from.part != part);
                    let until = if parts[part].pairs.is_some() && outside { end } else { at };
                    last_use[i] = last_use[i].max(until);
                }
                at += 1;
            }
        }
        let mut slots = vec![0u32; self.items.len()];
        let (mut free, mut used) = (Vec::new(), 0);
        let mut expiring: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        let mut at = 0;
        for (part, order) in orders.iter().enumerate() {
            let start = tape.runs.len();
            for &number in order {
                let Some(item) = &self.items[number] else { continue };
                while let Some(entry) = expiring.first_entry().filter(|e| *e.key() <= at) {
                    free.extend(entry.remove());
                }
                let (table, places) = self.instruction_table(number);
                let mut instruction = [0; 4];
                for (i, &from) in item.ins.iter().enumerate() {
                    instruction[1 + places[i]] = match self.logic.nodes.get(from) {
                        Some(Node::Zero) => ZERO,
                        Some(Node::Source(plane)) => *plane,
                        _ => slots[from],
                    };
                }
                // what it does not depend on is not read
                for i in item.ins.len()..3 {
                    instruction[1 + i] = instruction[1];
                }
                slots[number] = item.home.unwrap_or_else(|| {
                    let slot = free.pop().unwrap_or_else(|| {
                        used += 1;
                        scratch + used - 1
                    });
                    expiring.entry(last_use[number]).or_default().push(slot);
                    slot
                });
                instruction[0] = slots[number];
                tape.instructions.push(instruction);
                match tape.runs[start..].last_mut() {
                    Some(run) if run.0 == table => run.1 += 1,
                    _ => tape.runs.push((table, 1)),
                }
                at += 1;
            }
            let runs = start..tape.runs.len();
            match &parts[part].pairs {
                Some(pairs) => tape.steps.push(Step::Loop(runs, pairs.clone())),
                None if runs.is_empty() => {}
                None => tape.steps.push(Step::Straight(runs)),
            }
        }
        tape.scratch = used;
        tape
    }
}

#[cfg(test)]
mod tests {
    use super::super::machine::TABLES;
    use super::*;

    #[test]
    fn every_table_has_code() {
        let mut all: Vec<u8> = (0..=255).map(|t| canonical(t).0).filter(|&t| (0..3).all(|i| depends(t, i))).collect();
        all.extend((0..=255).filter(|&t| !depends(t, 2)).map(|t| canonical(t).0));
        all.sort_unstable();
        all.dedup();
        assert!(all.iter().all(|t| TABLES.contains(t)), "{all:x?}");
    }
}
