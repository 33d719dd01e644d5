//! Functions of an edge that do the same on other data, merged: a circuit of 64 equal computers is the code of one.
//!
//! What two functions address is told apart by its distance: all that lies equally far is addressed from one base, which the
//! call passes. State of equal parts lies in the same order, so a few bases are enough. Constants that differ are loaded.
//!
//! Sound: functions are merged only if their operations are the same one by one, up to the places that they load and store and
//! the values of constants, and if nothing in them tells of changes.

use crate::compiled::ir::graph::{Graph, Id, Map, Op};
use crate::compiled::ir::places::{PlaneWord, Slot};
use crate::compiled::ir::schedule::{Partition, Schedule};
use crate::compiled::ir::stores::Put;
use crate::compiled::ir::stores::Store;

/// Bases up to which a code is shared, and one more for constants: what a call hands over in registers.
const BASES: usize = 5;
/// Constants up to which a code is shared that are not the same in all that share it.
const VARIED: usize = 16;

/// Whose code a piece runs, and where its data lie.
#[derive(Clone, Debug)]
pub(crate) struct Call {
    /// The number of the piece.
    pub code: usize,
    /// For each base how many plane words its data lie after those of that piece. Base 0 is the same for all.
    pub moved: Vec<i64>,
}

/// Where a code that is shared finds its data.
#[derive(Clone, Default, Debug)]
pub(crate) struct Data {
    /// The base of each plane word that it reads or writes; of others it is base 0.
    pub base: Map<PlaneWord, usize>,
    /// Constants that lie in memory, since they are not the same in all that share it.
    pub constants: Map<Id, PlaneWord>,
}

/// Pieces that share code.
#[derive(Debug)]
pub(crate) struct Merged {
    /// For each piece whose code it runs.
    pub calls: Vec<Call>,
    /// For each piece where its own code finds its data.
    pub data: Vec<Data>,
    /// What is to be in memory before any of it runs.
    pub constants: Vec<(PlaneWord, u64)>,
}

/// Pieces with one code.
struct Class {
    /// The data of the first of them, in the order of its shape, and the base of each.
    first: Used,
    base: Vec<usize>,
    /// The constants that are not the same in all.
    varied: Vec<usize>,
    members: Vec<Member>,
}

struct Member {
    number: usize,
    moved: Vec<i64>,
    constants: Vec<u64>,
}

/// Which pieces of a plan are alike. `fresh` gives places, one after another.
pub(crate) fn merge(graph: &Graph, schedule: &Schedule, mut fresh: impl FnMut() -> PlaneWord) -> Merged {
    let mut classes: Vec<Class> = Vec::new();
    let mut of_shape: Map<Vec<Part>, Vec<usize>> = Map::default();
    for (number, partition) in schedule.partitions.iter().enumerate() {
        let Some(Shape { parts, used, .. }) = Shape::of(graph, schedule, partition) else {
            classes.push(Class::new(graph, number, Used::default()));
            continue;
        };
        let known = of_shape.entry(parts).or_default();
        if known.iter().any(|&class| classes[class].join(graph, number, &used)) {
            continue;
        }
        known.push(classes.len());
        classes.push(Class::new(graph, number, used));
    }
    let own = |number| Call { code: number, moved: Vec::new() };
    let calls = (0..schedule.partitions.len()).map(own).collect();
    let mut all = Merged { calls, data: vec![Data::default(); schedule.partitions.len()], constants: Vec::new() };
    classes.into_iter().for_each(|class| class.finish(&mut all, &mut fresh));
    all
}

impl Class {
    fn new(graph: &Graph, first: usize, used: Used) -> Class {
        let member = Member { number: first, moved: vec![0], constants: used.values(graph) };
        Class { base: vec![0; used.planes.len()], first: used, varied: Vec::new(), members: vec![member] }
    }

    /// Takes up a piece of the same shape, unless that takes too many bases or constants.
    fn join(&mut self, graph: &Graph, number: usize, used: &Used) -> bool {
        // a base for what has had the same until now and lies equally far
        let mut groups: Vec<(usize, i64)> = vec![(0, 0)];
        let mut base = Vec::with_capacity(used.planes.len());
        for ((&plane, &first), &before) in used.planes.iter().zip(&self.first.planes).zip(&self.base) {
            let group = (before, plane.distance(first));
            let at = groups.iter().position(|&g| g == group).unwrap_or_else(|| {
                groups.push(group);
                groups.len() - 1
            });
            base.push(at);
            if groups.len() > BASES {
                return false;
            }
        }
        let constants = used.values(graph);
        let differs = |i: &usize| self.varied.contains(i) || constants[*i] != self.members[0].constants[*i];
        let varied: Vec<usize> = (0..constants.len()).filter(differs).collect();
        if varied.len() > VARIED {
            return false;
        }
        for member in &mut self.members {
            member.moved = groups.iter().map(|&(before, _)| member.moved[before]).collect();
        }
        let moved = groups.iter().map(|g| g.1).collect();
        self.members.push(Member { number, moved, constants });
        (self.base, self.varied) = (base, varied);
        true
    }

    /// Tells of its pieces, and lays down the constants that are not the same in all.
    fn finish(self, all: &mut Merged, mut fresh: impl FnMut() -> PlaneWord) {
        let code = self.members[0].number;
        let Data { base, constants } = &mut all.data[code];
        base.extend(self.first.planes.into_iter().zip(self.base));
        let mut first = None;
        for Member { number, mut moved, constants: values } in self.members {
            let places: Vec<PlaneWord> = self.varied.iter().map(|_| fresh()).collect();
            all.constants.extend(places.iter().zip(&self.varied).map(|(&plane, &i)| (plane, values[i])));
            if let Some(&begin) = places.first() {
                if number == code {
                    base.extend(places.iter().map(|&plane| (plane, moved.len())));
                    constants.extend(self.varied.iter().map(|&i| self.first.constants[i]).zip(places));
                }
                moved.push(begin.distance(*first.get_or_insert(begin)));
            }
            all.calls[number] = Call { code, moved };
        }
    }
}

/// The data that a piece works on, in the order in which its shape names them.
#[derive(Default)]
struct Used {
    planes: Vec<PlaneWord>,
    constants: Vec<Id>,
}

impl Used {
    fn values(&self, graph: &Graph) -> Vec<u64> {
        self.constants.iter().map(|&node| graph.value(node).expect("it is a constant")).collect()
    }
}

/// What a piece does, whatever data it does it on: nodes and plane words by numbers of their own.
#[derive(PartialEq, Eq, Hash, Debug)]
enum Part {
    Node(Op),
    Constant,
    Store { node: Id, plane: PlaneWord, guard: bool },
    Put(Put),
    Abort(Id),
}

struct Shape<'s> {
    graph: &'s Graph,
    schedule: &'s Schedule,
    /// The nodes of the piece.
    own: Map<Id, ()>,
    parts: Vec<Part>,
    used: Used,
    plane_numbers: Map<PlaneWord, PlaneWord>,
    numbers: Map<Id, Id>,
}

impl Shape<'_> {
    /// The shape of a piece, unless it tells of changes, each of which has a bit of its own, or is a loop.
    fn of<'s>(graph: &'s Graph, schedule: &'s Schedule, partition: &Partition) -> Option<Shape<'s>> {
        let plain = |s: &Store| !s.compared && !s.again && s.observed.is_none();
        if partition.group.is_some() || !partition.stores.iter().all(plain) {
            return None;
        }
        let mut s = Shape {
            graph,
            schedule,
            own: partition.nodes.iter().map(|&node| (node, ())).collect(),
            parts: Vec::new(),
            used: Used::default(),
            plane_numbers: Map::default(),
            numbers: Map::default(),
        };
        for store in &partition.stores {
            let (node, plane) = (s.node(store.node), s.plane(store.plane));
            s.parts.push(Part::Store { node, plane, guard: store.guard });
        }
        for put in &partition.puts {
            let [index, mask, v, u] = put.nodes().map(|node| s.node(node));
            let slot = s.slot(put.slot);
            s.parts.push(Part::Put(Put { slot, index, mask, v, u, ..*put }));
        }
        for &bail_out in &partition.bail_outs {
            let node = s.node(bail_out);
            s.parts.push(Part::Abort(node));
        }
        Some(s)
    }

    /// The number of the first plane word of an array, in place of its slot.
    fn slot(&mut self, slot: Slot) -> Slot {
        Slot::at(self.plane(slot.value()).index())
    }

    fn plane(&mut self, plane: PlaneWord) -> PlaneWord {
        let next = PlaneWord::at(self.used.planes.len() as u32);
        *self.plane_numbers.entry(plane).or_insert_with(|| {
            self.used.planes.push(plane);
            next
        })
    }

    /// The number of a node, after all below it has got one.
    fn node(&mut self, root: Id) -> Id {
        let graph = self.graph;
        let mut stack = vec![root];
        while let Some(&at) = stack.last() {
            if self.numbers.contains_key(&at) {
                stack.pop();
                continue;
            }
            let op = graph.op(at);
            let before = stack.len();
            if self.own.contains_key(&at) {
                stack.extend(op.operands().filter(|o| !self.numbers.contains_key(o)));
            }
            if stack.len() > before {
                continue;
            }
            stack.pop();
            let part = match op {
                Op::Const(_) => {
                    self.used.constants.push(at);
                    Part::Constant
                }
                Op::Load(plane) => Part::Node(Op::Load(self.plane(plane))),
                _ if !self.own.contains_key(&at) => Part::Node(Op::Load(self.plane(self.schedule.place[&at]))),
                Op::Element { slot, index, size, plane } => {
                    Part::Node(Op::Element { slot: self.slot(slot), index: self.numbers[&index], size, plane })
                }
                op => Part::Node(op.with(|o| self.numbers[&o])),
            };
            self.parts.push(part);
            self.numbers.insert(at, Id::at(self.numbers.len()));
        }
        self.numbers[&root]
    }
}

#[cfg(test)]
mod tests;
