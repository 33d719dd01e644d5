use super::*;
use crate::compiled::ir::graph::{Id, Op};
use crate::compiled::ir::interpreter::{Program, Random, run, run_schedule, seeds};
use crate::compiled::ir::places::Slot;
use crate::compiled::ir::record::Record;
use crate::compiled::ir::schedule::Root;
use crate::compiled::passes::partition::partition;
use crate::value::Word;

/// The number of an operation, so that a test can say which it has had.
fn kind(op: Op) -> usize {
    match op {
        Op::Const(_) => 0,
        Op::Load(_) => 1,
        Op::And(..) => 2,
        Op::AndNot(..) => 3,
        Op::Or(..) => 4,
        Op::Xor(..) => 5,
        Op::Add(..) => 6,
        Op::Sub(..) => 7,
        Op::Mul(..) => 8,
        Op::MulHigh(..) => 9,
        Op::MulHighSigned(..) => 10,
        Op::Shl(..) => 11,
        Op::Shr(..) => 12,
        Op::ShlBy(..) => 13,
        Op::ShrBy(..) => 14,
        Op::SarBy(..) => 15,
        Op::Eq(..) => 16,
        Op::Less(..) => 17,
        Op::Select(..) => 18,
        Op::Div(..) => 19,
        Op::Rem(..) => 20,
        Op::Count(_) => 21,
        Op::Element { size, .. } => 22 + usize::from(size),
    }
}

fn words(memory: &[u64]) -> Vec<Word> {
    memory.chunks(2).map(|pair| Word { v: pair[0], u: pair.get(1).copied().unwrap_or_default() }).collect()
}

fn halves(memory: &[Word]) -> Vec<u64> {
    memory.iter().flat_map(|w| [w.v, w.u]).collect()
}

/// Machine code of partitions of all sizes does what the interpreter does: it leaves the same in memory, wakes the same
/// partitions and notes the same nets as changed. Each operation is among what is run.
#[test]
fn partitions_in_machine_code_do_what_is_interpreted() {
    let (mut kinds, mut in_use) = ([0; 26], Vec::new());
    for seed in 0..seeds(600) {
        let mut r = Random(seed ^ 0xc0de);
        let size = 10 + r.below(120);
        let p = Program::random(&mut r, size);
        let g = &p.graph;
        let mut next = p.room() as u32;
        let mut fresh = || {
            next += 1;
            PlaneWord::at(next - 1)
        };
        let mut roots = |r: &mut Random| -> Vec<Root> {
            (0..1 + r.below(8))
                .map(|_| {
                    let node = Id::at(r.below(g.len()));
                    let observed = (r.below(3) == 0).then(|| r.below(100) as u32);
                    let shared = r.below(2) == 0;
                    Root {
                        node,
                        plane: fresh(),
                        observed,
                        guard: false,
                        shared,
                        group: None,
                        again: false,
                        state: false,
                    }
                })
                .collect()
        };
        let (settling, sampled) = (roots(&mut r), roots(&mut r));
        let schedule = partition(g, &settling, &sampled, r.pick(&[1, 5, 30, 1000]), &mut fresh);
        schedule.partitions.iter().flat_map(|c| &c.nodes).for_each(|&n| kinds[kind(g.op(n))] += 1);
        let end = PlaneWord::at(next.next_multiple_of(2));
        let dirty = end + 4;
        let shared = Shared { guard: end, changed: end + 2, dirty, log: None };
        let machine = compile(g, &schedule, shared).unwrap();
        // what is the same is made once; of all that is in use here, each has its own
        let again = compile(g, &schedule, shared).unwrap();
        assert!(again.shares(&machine), "seed {seed}");
        in_use.push(again);
        let late = schedule.partitions.len() - schedule.settling;
        let mut memory = p.memory(&mut r);
        memory.resize((dirty.index() + schedule.settling.div_ceil(64) + late.div_ceil(64)).next_multiple_of(2), 0);
        let mut due = vec![true; schedule.partitions.len()];
        for _ in 0..6 {
            let (mut interpreted, mut ran) = (memory.clone(), words(&memory));
            let mut expected = due.clone();
            run_schedule(g, &schedule, &mut expected, &mut interpreted);
            for number in 0..schedule.partitions.len() {
                if !std::mem::replace(&mut due[number], false) {
                    continue;
                }
                machine.run(number, &mut ran);
                let mut here = halves(&ran);
                for (woken, due) in (0..).zip(&mut due) {
                    let (word, bit) = dirty_bit(schedule.settling, woken);
                    *due |= here[(dirty + word).index()] & bit != 0;
                    here[(dirty + word).index()] &= !bit;
                }
                ran = words(&here);
            }
            let here = halves(&ran);
            // bits of nets whose roots have changed
            for root in settling.iter().chain(&sampled).filter(|s| g.value(s.node).is_none()) {
                let Some(bit) = root.observed else { continue };
                let at = (shared.changed + bit / 64).index();
                if interpreted[root.plane.index()] != memory[root.plane.index()] {
                    assert!(here[at] >> (bit % 64) & 1 == 1, "seed {seed}: {bit}");
                    interpreted[at] |= 1 << (bit % 64);
                }
            }
            assert_eq!(here, interpreted, "seed {seed}");
            // on to other state
            memory = here;
            memory[shared.changed.index()..][..2].fill(0);
            for (plane, new) in p.memory(&mut r).into_iter().enumerate().take(p.len()) {
                if r.below(3) == 0 {
                    memory[plane] = new;
                    let slot = Slot::at(plane / 2).min(p.array());
                    schedule.readers.get(&slot).into_iter().flatten().for_each(|&reader| due[reader as usize] = true);
                }
            }
        }
    }
    println!("{kinds:?}");
    assert!(kinds[2..].iter().all(|&n| n > 20), "{kinds:?}");
}

/// Machine code of edges, alone and one after another in a loop, does what the interpreter does: state, elements of all
/// sizes, how many edges are run, and why no more are.
#[test]
fn edges_in_machine_code_do_what_is_interpreted() {
    let (mut ran_edges, mut left) = (0, 0);
    for seed in 0..seeds(600) {
        let mut r = Random(seed ^ 0xed6e);
        let mut p = {
            let size = 10 + r.below(80);
            Program::random(&mut r, size)
        };
        let count = 1 + r.below(2);
        let partitions: Vec<Partition> = (0..count).map(|_| p.partition(&mut r)).collect();
        let edges: Vec<EdgeCode> = partitions
            .into_iter()
            .map(|partition| EdgeCode { graph: p.graph.clone(), partition, record: Record::default() })
            .collect();
        let room = PlaneWord::at(p.room() as u32);
        let mut next = p.room() as u32 + 4;
        let fresh = || {
            next += 1;
            PlaneWord::at(next - 1)
        };
        let shared = Shared { guard: room, changed: room + 2, dirty: room, log: None };
        let list: Vec<&EdgeCode> = edges.iter().collect();
        let edge_loop = compile_loop(&list, r.pick(&[4, 20, 1 << 20]), shared, fresh).unwrap();
        for _ in 0..8 {
            let mut memory = p.memory(&mut r);
            memory.resize(next.next_multiple_of(2) as usize, 0);
            let mut ran = words(&memory);
            let rounds = 1 + r.below(6) as u64;
            let done = edge_loop.run(&mut ran, rounds);
            let mut expected = 0;
            for edge in (0..rounds).flat_map(|_| &edges) {
                let Some(guard) = run(&edge.graph, &edge.partition, &mut memory) else { break };
                expected += 1;
                if guard {
                    break;
                }
            }
            assert_eq!(done, expected, "seed {seed}");
            let here = halves(&ran);
            assert_eq!(here[..p.room()], memory[..p.room()], "seed {seed}");
            ran_edges += done;
            left += u64::from(done < rounds * count as u64);
        }
    }
    println!("{ran_edges} edges, left {left} times");
    assert!(ran_edges > 2000 && left > 60);
}
