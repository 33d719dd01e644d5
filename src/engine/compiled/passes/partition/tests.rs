use super::*;
use crate::compiled::ir::interpreter::{Program, Random, run_schedule, seeds, values};

fn root(node: Id, plane: PlaneWord, shared: bool) -> Root {
    Root { node, plane, observed: None, guard: false, shared, group: None, again: false, state: false }
}

/// Partitions of all sizes leave what the graph means, when all run and when only those do that a change wakes.
#[test]
fn partitions_leave_what_the_graph_means() {
    let (mut partitions, mut runs, mut skipped) = (0, 0, 0);
    for seed in 0..seeds(800) {
        let mut r = Random(seed ^ 0x9a27);
        let size = 10 + r.below(150);
        let p = Program::random(&mut r, size);
        let g = &p.graph;
        let mut next = p.room() as u32;
        let mut fresh = || {
            next += 1;
            PlaneWord::at(next - 1)
        };
        let mut roots = |r: &mut Random| -> Vec<Root> {
            (0..1 + r.below(8)).map(|_| root(Id::at(r.below(g.len())), fresh(), r.below(2) == 0)).collect()
        };
        let (settling, sampled) = (roots(&mut r), roots(&mut r));
        let limit = r.pick(&[1, 2, 7, 40, 1000]);
        let schedule = partition(g, &settling, &sampled, limit, &mut fresh);
        partitions += schedule.partitions.len();
        assert!(schedule.partitions.iter().all(|c| c.nodes.len() <= limit.max(1)));
        let mut memory = p.memory(&mut r);
        memory.resize(next as usize, 0);
        schedule.constants.iter().for_each(|(root, n)| memory[root.plane.index()] = *n);
        let mut due = vec![true; schedule.partitions.len()];
        for round in 0..12 {
            let due_now = due.iter().filter(|d| **d).count();
            run_schedule(g, &schedule, &mut due, &mut memory);
            runs += due_now;
            skipped += schedule.partitions.len() - due_now;
            let expected = values(g, &memory);
            for root in settling.iter().chain(&sampled) {
                let found = memory[root.plane.index()];
                assert_eq!(found, expected[root.node.index()], "seed {seed}, round {round}: {:?}", g.op(root.node));
            }
            // a word of state changes, or of what a memory holds
            let contents = p.array().value().index();
            let (plane, mask, slot) = if r.below(3) == 0 {
                (contents + r.below(p.len() - contents), u64::MAX, p.array())
            } else {
                let plane = r.below(p.masks.len());
                (plane, p.masks[plane], Slot::at(plane / 2))
            };
            memory[plane] = r.telling() & mask;
            for &reader in schedule.readers.get(&slot).into_iter().flatten() {
                due[reader as usize] = true;
            }
        }
    }
    println!("{partitions} partitions, {runs} run and {skipped} not");
    assert!(partitions > 2000 && skipped > runs);
}
