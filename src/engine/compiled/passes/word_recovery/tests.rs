use super::*;

use crate::compiled::ir::interpreter::{Program, Random, seeds, values};

/// A carry of two bits and one, in one of the ways in which people and tools write it.
fn carry(r: &mut Random, g: &mut Graph, way: usize, a: Id, b: Id, c: Id) -> Id {
    let (both, either, apart) = (g.and(a, b), g.or(a, b), g.xor(a, b));
    match way {
        0 => {
            let passed = g.and(apart, c);
            g.or(both, passed)
        }
        1 => {
            let passed = g.and(either, c);
            g.or(both, passed)
        }
        2 => g.select(apart, c, a),
        3 => {
            let (x, y) = (g.and(a, c), g.and(b, c));
            let xy = g.or(x, y);
            g.or(both, xy)
        }
        4 => {
            // of NANDs alone
            let (n1, passed) = (g.not(both, 1), g.and(apart, c));
            let n2 = g.not(passed, 1);
            let all = g.and(n1, n2);
            g.not(all, 1)
        }
        _ => {
            let way = r.below(5);
            carry(r, g, way, a, b, c)
        }
    }
}

/// A sum of two buses, rippling or looking ahead.
fn sum(r: &mut Random, g: &mut Graph, a: &[Id], b: &[Id], mut c: Id) -> Vec<Id> {
    let way = r.below(7);
    let n = a.len();
    let mut out = Vec::new();
    if way == 6 {
        // spans of 2, 4 and 8, as a prefix network has them
        let mut generates: Vec<Id> = (0..n).map(|i| g.and(a[i], b[i])).collect();
        let mut passes: Vec<Id> = (0..n).map(|i| g.xor(a[i], b[i])).collect();
        let apart = passes.clone();
        let passed = g.and(passes[0], c);
        generates[0] = g.or(generates[0], passed);
        let mut span = 1;
        while span < n {
            for i in (span..n).rev() {
                let through = g.and(passes[i], generates[i - span]);
                generates[i] = g.or(generates[i], through);
                passes[i] = g.and(passes[i], passes[i - span]);
            }
            span *= 2;
        }
        for i in 0..n {
            out.push(g.xor(apart[i], if i == 0 { c } else { generates[i - 1] }));
        }
        return out;
    }
    for i in 0..n {
        let apart = g.xor(a[i], b[i]);
        out.push(g.xor(apart, c));
        c = carry(r, g, way, a[i], b[i], c);
    }
    out.push(c);
    out
}

/// The lanes of each group of state.
type Groups = Vec<Vec<(u8, PlaneWord)>>;

fn random(r: &mut Random) -> (Step, Groups, Vec<u64>) {
    let mut g = if r.below(2) == 0 { Graph::default() } else { Graph::factoring() };
    let mut groups = Groups::new();
    let mut buses: Vec<Vec<Id>> = Vec::new();
    let mut masks: Vec<u64> = Vec::new();
    for _ in 0..3 + r.below(4) {
        let width = 3 + r.below(20);
        let (first, up) = (PlaneWord::at(masks.len() as u32), r.below(5) != 0);
        let lanes = (0..width as u32).map(|i| (if up { i } else { width as u32 - 1 - i } as u8, first + i)).collect();
        groups.push(lanes);
        buses.push((0..width as u32).map(|i| g.load(first + i, 1)).collect());
        masks.extend((0..width).map(|_| 1));
    }
    // a word beside the bits
    let word = g.load(PlaneWord::at(masks.len() as u32), 0xff_ffff);
    masks.push(0xff_ffff);
    buses.push((0..24).map(|i| g.bits(word, i, 1)).collect());
    let mut bits: Vec<Id> = buses.concat();
    for _ in 0..4 + r.below(12) {
        let (x, y) = (buses[r.below(buses.len())].clone(), buses[r.below(buses.len())].clone());
        let n = x.len().min(y.len());
        let (mut x, mut y) = (x[..n].to_vec(), y[..n].to_vec());
        let s = bits[r.below(bits.len())];
        let inverts = |r: &mut Random, g: &mut Graph, bus: &mut Vec<Id>| {
            if r.below(4) == 0 {
                bus.iter_mut().for_each(|b| *b = g.not(*b, 1));
            }
        };
        inverts(r, &mut g, &mut x);
        inverts(r, &mut g, &mut y);
        if r.below(6) == 0 {
            y = vec![g.constant(r.word() & 1); n];
        }
        let made: Vec<Id> = match r.below(9) {
            0 => x.iter().zip(&y).map(|(&a, &b)| g.and(a, b)).collect(),
            1 => x.iter().zip(&y).map(|(&a, &b)| g.or(a, b)).collect(),
            2 => x.iter().zip(&y).map(|(&a, &b)| g.xor(a, b)).collect(),
            3 => x.iter().zip(&y).map(|(&a, &b)| g.select(s, a, b)).collect(),
            4 => x.iter().zip(&y).map(|(&a, &b)| g.and_not(a, b)).collect(),
            5 => {
                // all, some
                let (mut all, mut some) = (x[0], y[0]);
                for i in 1..n {
                    all = if r.below(4) == 0 { g.and_not(all, x[i]) } else { g.and(all, x[i]) };
                    some = g.or(some, y[i]);
                }
                vec![all, some, s]
            }
            6 => (0..n).map(|i| if r.below(3) == 0 { s } else { x[(i + 1) % n] }).collect(),
            _ => {
                let base = match r.below(3) {
                    0 => g.constant(0),
                    1 => g.constant(1),
                    _ => s,
                };
                sum(r, &mut g, &x, &y, base)
            }
        };
        bits.extend(&made);
        if made.len() > 2 {
            buses.push(made);
        }
    }
    let mut stores = Vec::new();
    for (plane, mask) in masks.iter().enumerate() {
        if *mask != 1 {
            // a word put together of bits
            let mut all = g.constant(0);
            for i in 0..24 {
                let bit = bits[r.below(bits.len())];
                let placed = g.shl(bit, i);
                all = g.or(all, placed);
            }
            stores.push((PlaneWord::at(plane as u32), all));
        }
    }
    for group in &groups {
        let bus = buses[r.below(buses.len())].clone();
        for (i, &(_, plane)) in group.iter().enumerate() {
            let node = if r.below(9) == 0 { bits[r.below(bits.len())] } else { bus[i % bus.len()] };
            stores.push((plane, node));
        }
    }
    let bail_outs = vec![bits[r.below(bits.len())]];
    (Step { graph: g, stores, puts: Vec::new(), bail_outs }, groups, masks)
}

/// Random logic of buses, with adders in all shapes: what is stored is the same before and after.
#[test]
fn packed_steps_do_the_same() {
    let seeds = seeds(400);
    let (mut chains, mut fewer, mut before, mut after) = (0, 0, 0, 0);
    for seed in 0..seeds {
        let mut r = Random(seed);
        let (mut step, groups, masks) = random(&mut r);
        let (plain, stores, bail_outs) = (std::mem::take(&mut step.graph), step.stores.clone(), step.bail_outs.clone());
        step.graph = Graph::default();
        let copy = Step { graph: plain, stores: stores.clone(), puts: Vec::new(), bail_outs: bail_outs.clone() };
        let mut step = in_rows(&copy, &Map::default());
        let least = 2 + r.below(3);
        let mut end = masks.len() as u32;
        let mut fresh = || {
            end += 1;
            PlaneWord::at(end - 1)
        };
        let trials = if seed % 4 == 0 { TRIALS } else { 0 };
        let packed = recover(&mut step, &groups, least, trials, &mut fresh).expect("it is not too deep");
        if trials > 0 {
            let mut other = in_rows(&copy, &Map::default());
            let all = recover(&mut other, &groups, least, 0, &mut fresh).expect("it is not too deep");
            assert!(packed.step.cost() <= all.step.cost(), "seed {seed}");
            fewer += all.chains - packed.chains;
        }
        chains += packed.chains;
        before += copy.needed().len();
        after += packed.step.needed().len();
        for _ in 0..24 {
            let memory: Vec<u64> =
                masks.iter().map(|m| if r.below(8) == 0 { *m } else { r.word() & r.word() & m }).collect();
            let old = values(&copy.graph, &memory);
            let mid = values(&step.graph, &memory);
            for (a, b) in stores.iter().zip(&step.stores) {
                assert_eq!(old[a.1.index()], mid[b.1.index()], "rows, seed {seed}");
            }
            let mut words = memory.clone();
            words.resize(masks.len() + groups.len(), 0);
            for Place { word, lanes } in &packed.places {
                words[word.index()] = lanes.iter().fold(0, |all, &(lane, h)| all | memory[h.index()] << lane);
            }
            let new = values(&packed.step.graph, &words);
            assert_eq!(old[bail_outs[0].index()], new[packed.step.bail_outs[0].index()], "seed {seed}");
            let mid = values(&step.graph, &memory);
            for &(node, here, lane) in &packed.same {
                let is = lane.map_or(new[here.index()], |lane| new[here.index()] >> lane & 1);
                assert_eq!(
                    is,
                    mid[node.index()],
                    "seed {seed}: {node:?} {:?} {here:?} {:?} {lane:?}",
                    step.graph.op(node),
                    packed.step.graph.op(here)
                );
            }
            let next: Map<PlaneWord, u64> = packed.step.stores.iter().map(|&(p, n)| (p, new[n.index()])).collect();
            for &(plane, node) in &stores {
                let at = packed.places.iter().find_map(|place| {
                    let lane = place.lanes.iter().find(|l| l.1 == plane)?.0;
                    Some((place.word, lane, 1))
                });
                let (at, lane, mask) = at.unwrap_or((plane, 0, u64::MAX));
                let word = next.get(&at).copied().unwrap_or(words[at.index()]);
                let found = Some(word >> lane & mask);
                assert_eq!(found, Some(old[node.index()]), "seed {seed}: {plane:?}");
            }
        }
    }
    println!("{chains} chains, {fewer} left out; {before} operations, packed {after}");
    assert!(seeds < 400 || chains > 400 && fewer > 20);
}

/// A file of eight words of eight bits: single bits are read from it, and written on several levels, as an adder's are.
/// The multiplexers are words all the same: 7 of the reading and 8 of the writing, with little around them.
#[test]
fn a_register_file_is_packed() {
    let mut g = Graph::default();
    let (words, bits) = (8, 8);
    let groups: Groups =
        (0..words).map(|w| (0..bits).map(|b| (b as u8, PlaneWord::at(w * bits + b))).collect()).collect();
    let first = words * bits;
    let address: Vec<Id> = (0..3).map(|i| g.load(PlaneWord::at(first + i), 1)).collect();
    let mut read = Vec::new();
    for b in 0..bits {
        let mut level: Vec<Id> = (0..words).map(|w| g.load(PlaneWord::at(w * bits + b), 1)).collect();
        for &s in &address {
            level = level.chunks(2).map(|pair| g.select(s, pair[1], pair[0])).collect();
        }
        read.push(level[0]);
    }
    // what is written takes a bit of what is read after the other
    let mut carry = g.load(PlaneWord::at(first + 3), 1);
    let mut stores = Vec::new();
    for (b, &bit) in (0..).zip(&read) {
        let other = g.load(PlaneWord::at(first + 4 + b), 1);
        let apart = g.xor(bit, other);
        let written = g.select(apart, carry, other);
        let both = g.and_not(carry, bit);
        carry = g.xor(both, other);
        for w in 0..words {
            let enable = g.load(PlaneWord::at(first + 20 + w), 1);
            let old = g.load(PlaneWord::at(w * bits + b), 1);
            stores.push((PlaneWord::at(w * bits + b), g.select(enable, written, old)));
        }
    }
    let mut step = Step { graph: g, stores, puts: Vec::new(), bail_outs: Vec::new() };
    let plain = step.needed().len();
    let mut end = first + 40;
    let mut fresh = || {
        end += 1;
        PlaneWord::at(end - 1)
    };
    let packed = recover(&mut step, &groups, 3, TRIALS, &mut fresh).unwrap();
    let kinds = |step: &Step| step.needed().iter().filter(|&&n| matches!(step.graph.op(n), Op::Select(..))).count();
    // the last carry is not needed
    assert_eq!((plain, kinds(&step)), (56 + 64 + 4 * 8 - 2, 56 + 64 + 8));
    assert_eq!(kinds(&packed.step), 7 + 8 + 8, "{:?}", packed.step.needed().len());
    // eight bits are taken out, eight put in
    assert!(packed.step.needed().len() <= 7 + 8 + 4 * 8 + 2 * 8 + 2 * 8, "{}", packed.step.needed().len());
}

/// Whether a counter of 24 bits and another have gone to zero, as gates one after another: it is a comparison each.
#[test]
fn a_long_or_is_a_comparison() {
    let mut g = Graph::default();
    let (words, bits) = (2, 24);
    let groups: Groups =
        (0..words).map(|w| (0..bits).map(|b| (b as u8, PlaneWord::at(w * bits + b))).collect()).collect();
    let mut any = g.load(PlaneWord::at(0), 1);
    for b in 0..bits {
        for w in 0..words {
            let bit = g.load(PlaneWord::at(w * bits + b), 1);
            any = g.or(bit, any);
        }
    }
    let enable = g.load(PlaneWord::at(words * bits), 1);
    // what makes the bits state of a word
    let mut stores: Vec<(PlaneWord, Id)> = (0..words * bits)
        .map(PlaneWord::at)
        .map(|plane| {
            let bit = g.load(plane, 1);
            (plane, g.and(bit, enable))
        })
        .collect();
    stores.push((PlaneWord::at(words * bits + 1), any));
    let mut step = Step { graph: g, stores, puts: Vec::new(), bail_outs: Vec::new() };
    assert_eq!(step.needed().len(), 47 + 48);
    let mut end = words * bits + 2;
    let mut fresh = || {
        end += 1;
        PlaneWord::at(end - 1)
    };
    let packed = recover(&mut step, &groups, 3, 0, &mut fresh).unwrap();
    // spread and AND for each word; a comparison for each and what joins them
    let nodes = packed.step.needed();
    assert_eq!(packed.chains, 0);
    assert!(
        nodes.len() <= 2 * 2 + 2 * 2 + 2,
        "{:?}",
        nodes.iter().map(|&n| packed.step.graph.op(n)).collect::<Vec<_>>()
    );
}

/// What a chain says of its stages is so: the carry out is made or passed on, what makes one does not stop one, and the sum
/// is that of an adder.
#[test]
fn chains_carry() {
    let (mut found, mut stages) = (0, 0);
    for seed in 0..seeds(300) {
        let mut r = Random(seed ^ 0xca);
        let (Step { graph: mut g, .. }, groups, masks) = random(&mut r);
        let lanes = groups.iter().flatten().map(|&(lane, plane)| (plane, lane)).collect();
        let chains = chains::find(&mut g, &lanes);
        found += chains.len();
        stages += chains.iter().map(|c| c.stages.len()).sum::<usize>();
        for _ in 0..16 {
            let memory: Vec<u64> = masks.iter().map(|m| r.word() & m).collect();
            let now = values(&g, &memory);
            let is = |n: Id| now[n.index()];
            for Chain { base, stages } in &chains {
                let mut carry = is(*base);
                for stage in stages {
                    let (kill, make) = (is(stage.kill), is(stage.make));
                    assert_eq!(make & !kill, 0, "seed {seed}");
                    assert_eq!(is(stage.sum), kill ^ make ^ carry ^ u64::from(stage.inverted), "seed {seed}");
                    carry = make | kill & carry;
                    assert_eq!(is(stage.out), carry, "seed {seed}");
                }
            }
        }
    }
    println!("{found} chains, {stages} stages");
    assert!(found > 400 && stages > 2000);
}

/// Steps of all operations, with memories: words of bits do what the bits do.
#[test]
fn steps_of_all_operations_do_the_same() {
    let (mut packed_words, mut seen) = (0, 0);
    for seed in 0..seeds(400) {
        let mut r = Random(seed ^ 0xa11);
        let size = 20 + r.below(80);
        let mut p = Program::random(&mut r, size);
        let partition = p.partition(&mut r);
        let stores: Vec<(PlaneWord, Id)> =
            partition.stores.iter().filter(|s| !s.guard).map(|s| (s.plane, s.node)).collect();
        let bits: Vec<PlaneWord> =
            (0..p.masks.len() as u32).map(PlaneWord::at).filter(|h| p.masks[h.index()] == 1).collect();
        let group: Vec<(u8, PlaneWord)> =
            bits.iter().enumerate().map(|(lane, &plane)| (3 * lane as u8, plane)).collect();
        let step = Step {
            graph: p.graph.clone(),
            stores: stores.clone(),
            puts: partition.puts.clone(),
            bail_outs: partition.bail_outs.clone(),
        };
        let mut rows = in_rows(&step, &Map::default());
        let mut end = p.room() as u32;
        let mut fresh = || {
            end += 1;
            PlaneWord::at(end - 1)
        };
        let Some(packed) = recover(&mut rows, &[group], 2, 0, &mut fresh) else { continue };
        seen += 1;
        packed_words += packed.places.len();
        for _ in 0..12 {
            let memory = p.memory(&mut r);
            let mut words = memory.clone();
            words.resize(end as usize, 0);
            for Place { word, lanes } in &packed.places {
                words[word.index()] = lanes.iter().fold(0, |all, &(lane, h)| all | memory[h.index()] << lane);
            }
            let (old, rowed, new) =
                (values(&p.graph, &memory), values(&rows.graph, &memory), values(&packed.step.graph, &words));
            let is = |list: &[u64], n: Id| list[n.index()];
            for (which, now, then) in [("rows", &rows, &rowed), ("words", &packed.step, &new)] {
                for (&a, &b) in step.bail_outs.iter().zip(&now.bail_outs) {
                    assert_eq!(is(&old, a), is(then, b), "{which}, seed {seed}");
                }
                for (a, b) in step.puts.iter().zip(&now.puts) {
                    let pairs = a.nodes().into_iter().zip(b.nodes());
                    pairs.for_each(|(a, b)| assert_eq!(is(&old, a), is(then, b), "{which}, seed {seed}"));
                }
            }
            let next: Map<PlaneWord, u64> = packed.step.stores.iter().map(|&(h, n)| (h, is(&new, n))).collect();
            for &(plane, node) in &stores {
                let lane = |place: &Place| Some((place.word, place.lanes.iter().find(|l| l.1 == plane)?.0));
                let found = match packed.places.iter().find_map(lane) {
                    Some((word, lane)) => next.get(&word).copied().unwrap_or(words[word.index()]) >> lane & 1,
                    None => next[&plane],
                };
                assert_eq!(found, is(&old, node), "seed {seed}: {plane:?}");
            }
        }
    }
    println!("{packed_words} words, {seen} steps");
    assert!(packed_words > 100 && seen > 300);
}
