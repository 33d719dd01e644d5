//! The graph and its rewrites against the interpreter.

use super::graph::{Graph, Id, Op};
use super::interpreter::{Program, Random, evaluate, seeds, values};
use super::places::{PlaneWord, Slot};

/// Results worked out by hand, one or more for each operation.
#[test]
fn operations_mean_what_they_say() {
    let memory = [0x0706_0504_0302_0100, 0xf7f6_f5f4_f3f2_f1f0, 0x0f0e_0d0c_0b0a_0908, 0xfffe_fdfc_fbfa_f9f8];
    let of = |op: Op, operands: [u64; 3]| evaluate(op, &memory, |id| operands[id.index()]);
    let [a, b, c] = [0, 1, 2].map(Id::at);
    let minus = |n: u64| n.wrapping_neg();
    assert_eq!(of(Op::Const(7), [0; 3]), 7);
    assert_eq!(of(Op::Load(PlaneWord::at(1)), [0; 3]), 0xf7f6_f5f4_f3f2_f1f0);
    assert_eq!(of(Op::And(a, b), [0b1100, 0b1010, 0]), 0b1000);
    assert_eq!(of(Op::AndNot(a, b), [0b1100, 0b1010, 0]), 0b0100);
    assert_eq!(of(Op::Or(a, b), [0b1100, 0b1010, 0]), 0b1110);
    assert_eq!(of(Op::Xor(a, b), [0b1100, 0b1010, 0]), 0b0110);
    assert_eq!(of(Op::Add(a, b), [u64::MAX, 2, 0]), 1);
    assert_eq!(of(Op::Sub(a, b), [1, 2, 0]), u64::MAX);
    assert_eq!(of(Op::Mul(a, b), [1 << 63, 3, 0]), 1 << 63);
    assert_eq!(of(Op::MulHigh(a, b), [1 << 63, 6, 0]), 3);
    assert_eq!(of(Op::MulHigh(a, b), [u64::MAX, u64::MAX, 0]), u64::MAX - 1);
    assert_eq!(of(Op::MulHighSigned(a, b), [u64::MAX, u64::MAX, 0]), 0);
    assert_eq!(of(Op::MulHighSigned(a, b), [u64::MAX, 5, 0]), u64::MAX);
    assert_eq!(of(Op::Shl(a, 63), [3, 0, 0]), 1 << 63);
    assert_eq!(of(Op::Shr(a, 63), [1 << 63, 0, 0]), 1);
    assert_eq!(of(Op::ShlBy(a, b), [3, 63, 0]), 1 << 63);
    assert_eq!(of(Op::ShrBy(a, b), [minus(16), 60, 0]), 15);
    assert_eq!(of(Op::SarBy(a, b), [minus(16), 2, 0]), minus(4));
    assert_eq!(of(Op::Eq(a, b), [4, 4, 0]) + of(Op::Eq(a, b), [4, 5, 0]), 1);
    assert_eq!(of(Op::Less(a, b), [4, u64::MAX, 0]) + of(Op::Less(a, b), [4, 4, 0]), 1);
    assert_eq!([of(Op::Select(a, b, c), [1, 5, 6]), of(Op::Select(a, b, c), [0, 5, 6])], [5, 6]);
    assert_eq!([of(Op::Div(a, b), [minus(1), 10, 0]), of(Op::Rem(a, b), [minus(1), 10, 0])], [1844674407370955161, 5]);
    assert_eq!(of(Op::Count(a), [0xf0f0, 0, 0]), 8);
    let element = |size, plane, index| of(Op::Element { slot: Slot::default(), index: a, size, plane }, [index, 0, 0]);
    assert_eq!([element(0, 0, 9), element(0, 1, 9)], [0x09, 0xf9]);
    assert_eq!([element(1, 0, 3), element(1, 1, 5)], [0x0706, 0xfbfa]);
    assert_eq!([element(2, 0, 2), element(2, 1, 1)], [0x0b0a_0908, 0xf7f6_f5f4]);
    assert_eq!([element(3, 0, 1), element(3, 1, 1)], [memory[2], memory[3]]);
}

/// Hash-consing, folding and algebraic simplification leave what every operation means as it is, and no bit is 1 of which
/// the known-bits mask says otherwise (`values` looks).
#[test]
fn graphs_mean_what_was_written() {
    let mut folded = 0;
    for seed in 0..seeds(3000) {
        let mut r = Random(seed);
        let size = 10 + r.below(90);
        let p = Program::random(&mut r, size);
        for _ in 0..8 {
            let memory = p.memory(&mut r);
            let (written, built) = (p.values(&memory), values(&p.graph, &memory));
            for (step, &node) in p.nodes.iter().enumerate() {
                let (op, here) = (p.steps[step], p.graph.op(node));
                assert_eq!(written[step], built[node.index()], "seed {seed}: step {step}, {op:?} as {here:?}");
            }
        }
        folded += p.steps.len().saturating_sub(p.graph.len());
    }
    println!("{folded} operations fewer");
    assert!(folded > 1000);
}

/// The operations that two levels of gates are made of.
const GATES: [fn(&mut Graph, Id, Id) -> Id; 8] = [
    Graph::and,
    Graph::or,
    Graph::xor,
    Graph::and_not,
    Graph::add,
    |g, a, _| g.not(a, 1),
    |g, a, b| {
        let one = g.constant(1);
        let not = g.xor(b, one);
        g.and_not(a, not)
    },
    |g, a, b| {
        let s = g.load(PlaneWord::at(3), 1);
        g.select(s, a, b)
    },
];

/// What they are, on words; `s` is the select of the last.
fn gate(number: usize, a: u64, b: u64, s: u64) -> u64 {
    match number {
        0 => a & b,
        1 => a | b,
        2 => a ^ b,
        3 => a & !b,
        4 => a.wrapping_add(b),
        5 => a ^ 1,
        6 => a & !(b ^ 1),
        _ => [b, a][s as usize],
    }
}

/// Every composition of three gates over four inputs, as bits and as words: the algebraic simplifications are found by
/// the shape of two levels, so all shapes that they look for are among these.
#[test]
fn every_composition_of_three_gates_is_simplified_soundly() {
    for wide in [false, true] {
        let mask = if wide { u64::MAX } else { 1 };
        for (top, left, right) in (0..512).map(|n| (n / 64, n / 8 % 8, n % 8)) {
            // inputs: three of the memory, and a constant
            for inputs in 0..256usize {
                let mut g = Graph::factoring();
                let leaf: Vec<Id> = (0..3).map(|word| g.load(PlaneWord::at(word), mask)).collect();
                let constants = [g.constant(1), g.constant(mask)];
                let at = |n: usize| if n == 3 { constants[top % 2] } else { leaf[n] };
                let ports = [inputs / 64, inputs / 16 % 4, inputs / 4 % 4, inputs % 4];
                let [a, b, c, d] = ports.map(at);
                let (x, y) = (GATES[left](&mut g, a, b), GATES[right](&mut g, c, d));
                let root = GATES[top](&mut g, x, y);
                // all combinations of three bits, side by side in words
                let memories: Vec<[u64; 4]> = match wide {
                    true => vec![[0xf0f0, 0xcccc, 0xaaaa, 0], [u64::MAX - 0xf0, !0xcc, 0xaa << 56, 1]],
                    false => (0..16).map(|n| [n & 1, n >> 1 & 1, n >> 2 & 1, n >> 3]).collect(),
                };
                for memory in memories {
                    let [a, b, c, d] = ports.map(|n| if n == 3 { [1, mask][top % 2] } else { memory[n] });
                    let (x, y) = (gate(left, a, b, memory[3]), gate(right, c, d, memory[3]));
                    let expected = gate(top, x, y, memory[3]);
                    let found = values(&g, &memory)[root.index()];
                    assert_eq!(found, expected, "{top}({left} of {a} {b}, {right} of {c} {d}), wide: {wide}");
                }
            }
        }
    }
}

/// What the facts say follows from a condition does, in every memory that is tried.
#[test]
fn facts_hold() {
    let (mut conditions, mut exclusive, mut exhaustive, mut given) = (0, 0, 0, 0);
    for seed in 0..seeds(1500) {
        let mut r = Random(seed ^ 0xfac7);
        let size = 30 + r.below(60);
        let mut p = Program::random(&mut r, size);
        let g = &mut p.graph;
        // comparisons of one word with several constants, as decoders have them
        let (word, bits) = (g.load(PlaneWord::default(), p.masks[0]), p.masks[0].count_ones().min(3));
        let word = g.bits(word, 0, bits);
        let decoded: Vec<Id> = (0..1 << bits)
            .map(|n| {
                let n = g.constant(n);
                g.eq(word, n)
            })
            .collect();
        let conditional: Vec<Id> = g.ids().filter(|&n| g.possible_bits(n) == 1).collect();
        let mut lists: Vec<Vec<Id>> = (0..60)
            .map(|_| {
                let from = if r.below(3) == 0 { &decoded } else { &conditional };
                (0..2 + r.below(3)).map(|_| r.pick(from)).collect()
            })
            .collect();
        lists.push(decoded);
        let said: Vec<(bool, bool)> = lists.iter().map(|l| (g.exclusive(l), g.exhaustive(l))).collect();
        exclusive += said.iter().filter(|s| s.0).count();
        exhaustive += said.iter().filter(|s| s.1).count();
        let when: Vec<(Id, Id)> = g.ids().filter_map(|n| Some((n, g.condition(n)?))).collect();
        conditions += when.iter().filter(|w| w.0 != w.1).count();
        let mut implied: Vec<(Id, Id, Id)> = Vec::new();
        for &(node, when) in &when {
            implied.push((node, when, g.given(when, node)));
            let other = Id::at(r.below(g.len()));
            implied.push((other, when, g.given(when, other)));
        }
        given += implied.iter().filter(|i| i.0 != i.2).count();
        for _ in 0..16 {
            let memory = p.memory(&mut r);
            let now = values(&p.graph, &memory);
            for (list, &(exclusive, exhaustive)) in lists.iter().zip(&said) {
                // the same node twice in a list is not excluded by itself
                let ones = list.iter().filter(|n| now[n.index()] == 1).count();
                assert!(!exclusive || ones <= 1, "seed {seed}: {list:?}");
                assert!(!exhaustive || ones >= 1, "seed {seed}: {list:?}");
            }
            for &(node, when) in &when {
                assert!(now[node.index()] == 0 || now[when.index()] == 1, "seed {seed}: {node:?}");
            }
            for &(node, when, then) in &implied {
                assert!(now[when.index()] != 1 || now[node.index()] == now[then.index()], "seed {seed}: {node:?}");
            }
        }
    }
    println!("{conditions} conditions, {exclusive} exclusive lists, {exhaustive} exhaustive, {given} nodes given");
    assert!(conditions > 500 && exclusive > 500 && exhaustive > 100 && given > 100);
}
