use super::*;
use crate::compiled::ir::interpreter::{Program, Random, run, seeds, values};
use crate::compiled::ir::record::Record;
use crate::compiled::ir::schedule::Partition;
use crate::compiled::ir::stores::Store;

/// Two edges on the same state as one step: where nothing keeps the step from being taken, it leaves what the edges leave
/// one after the other, and neither of them bails out, fails a guard, or changes what is observed.
#[test]
fn a_cycle_is_its_edges_one_after_the_other() {
    let (mut taken, mut left, mut refused) = (0, 0, 0);
    for seed in 0..seeds(1500) {
        let mut r = Random(seed ^ 0xc1c1);
        let size = 10 + r.below(60);
        // both read the same program, of which each makes other state
        let mut p = Program::random(&mut r, size);
        let mut partitions = [p.partition(&mut r), p.partition(&mut r)];
        for store in partitions.iter_mut().flat_map(|c| &mut c.stores) {
            store.compared = !store.guard && r.below(6) == 0;
        }
        let edges =
            partitions.map(|partition| EdgeCode { graph: p.graph.clone(), partition, record: Record::default() });
        let Some(step) = compose(&[&edges[0], &edges[1]]) else {
            refused += 1;
            continue;
        };
        for _ in 0..12 {
            let memory = p.memory(&mut r);
            let now = values(&step.graph, &memory);
            let mut after = memory.clone();
            let ran: Vec<bool> = edges
                .iter()
                .map(|edge| {
                    let before = after.clone();
                    let guard = run(&edge.graph, &edge.partition, &mut after);
                    let same = |s: &&Store| s.compared && before[s.plane.index()] != after[s.plane.index()];
                    guard == Some(false) && !edge.partition.stores.iter().any(|s| same(&s))
                })
                .collect();
            if step.bail_outs.iter().any(|&n| now[n.index()] != 0) {
                left += 1;
                continue;
            }
            taken += 1;
            assert_eq!(ran, [true, true], "seed {seed}");
            let stores = step.stores.iter().map(|&(plane, node)| Store::plain(node, plane)).collect();
            let whole = Partition { stores, puts: step.puts.clone(), ..Partition::default() };
            let mut found = memory.clone();
            assert_eq!(run(&step.graph, &whole, &mut found), Some(false));
            assert_eq!(found, after, "seed {seed}");
        }
    }
    println!("{taken} cycles taken, {left} left, {refused} not made");
    assert!(taken > 2000 && left > 500);
}
