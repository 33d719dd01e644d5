//! What cells without state give, as functions on nodes: the functions of the cell room once more.

use crate::cell::{AddOp, Alu, CellKind, CompareOp, DivideOp, ShiftOp};
use crate::compiled::ir::graph::{Graph, Id};
use crate::compiled::lower::four::{Bits, Two, append, slice};
use crate::compiled::lower::wide;
use crate::value::Word;
use crate::value::word::{mask, word_mask, words};

/// The outputs of a cell without state.
pub(crate) fn combinational(g: &mut Graph, kind: &CellKind, ins: &[Bits]) -> Vec<Bits> {
    let out = match kind {
        CellKind::Gate { op, width, inputs } => {
            let parts: Vec<Bits> = (0..*inputs).map(|k| slice(g, &ins[0], k * width, *width)).collect();
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let start = g.two(op.identity(m));
                    let joined = parts.iter().fold(start, |all, part| g.join(*op, all, part[i]));
                    g.finish(*op, joined, m)
                })
                .collect()
        }
        CellKind::AndOr { width, inputs } => {
            let mut all = g.zeros(*width);
            for k in 0..*inputs {
                let (part, s) = (slice(g, &ins[0], k * width, *width), slice(g, &ins[1], k, 1)[0]);
                for (i, all) in all.iter_mut().enumerate() {
                    let m = word_mask(*width, i);
                    let gate = Two { v: g.splat(s.v, m), u: g.splat(s.u, m) };
                    let one = g.and4(part[i], gate);
                    *all = g.or4(*all, one);
                }
            }
            all
        }
        CellKind::Mux { width, inputs } => mux(g, *width, *inputs, &ins[0], ins[1][0]),
        CellKind::HalfAdder | CellKind::FullAdder => {
            let (a, b) = (ins[0][0], ins[1][0]);
            let (half, both) = (g.xor4(a, b), g.and4(a, b));
            if *kind == CellKind::HalfAdder {
                return vec![vec![half], vec![both]];
            }
            let ci = ins[2][0];
            let (s, passed) = (g.xor4(half, ci), g.and4(half, ci));
            return vec![vec![s], vec![g.or4(both, passed)]];
        }
        CellKind::Adder { op, width } => {
            let sub = match op {
                AddOp::Add => g.two(Word::ZERO),
                AddOp::Sub => g.two(Word::known(1)),
                AddOp::AddSub => ins[3][0],
            };
            let (y, co) = g.sum(*width, &ins[0], &ins[1], ins[2][0], sub);
            return vec![y, vec![co]];
        }
        CellKind::Multiply { a_width, b_width, signed } if *a_width.max(b_width) <= 64 => {
            multiply(g, *a_width, *b_width, *signed, ins)
        }
        CellKind::Multiply { a_width, b_width, signed } => wide::multiply(g, (*a_width, *b_width), *signed, ins),
        CellKind::Compare { op, width, signed } => vec![compare(g, *op, *width, *signed, &ins[0], &ins[1])],
        CellKind::Shift { op, a_width, b_width, width } if *a_width.max(b_width).max(width) <= 64 => {
            vec![shift(g, *op, (*a_width, *b_width, *width), ins[0][0], ins[1][0])]
        }
        CellKind::Shift { op, a_width, b_width, width } => {
            wide::shift(g, *op, (*a_width, *b_width, *width), &ins[0], &ins[1])
        }
        CellKind::Divide { op, width, signed } if *width <= 64 => {
            vec![divide(g, *op, *width, *signed, ins[0][0], ins[1][0])]
        }
        CellKind::Divide { op, width, signed } => wide::divide(g, *op, *width, *signed, ins),
        CellKind::Power { width, b_width, a_signed, b_signed } => {
            vec![wide::power(g, (*width, *b_width), (*a_signed, *b_signed), ins[0][0], ins[1][0])]
        }
        CellKind::OneHotMux { width, inputs } => one_hot(g, *width, *inputs, ins),
        CellKind::Demux { width, select } => demux(g, *width, *select, &ins[0], ins[1][0]),
        CellKind::BitMux { width } => (0..words(*width))
            .map(|i| {
                let (a, b, s) = (ins[0][i], ins[1][i], ins[2][i]);
                let both = g.merge4(a, b);
                let one = g.ones(s);
                let any = g.or(s.v, s.u);
                let all = g.constant(word_mask(*width, i));
                let zero = g.and_not(all, any);
                let mut pick = |a: Id, b: Id, both: Id| {
                    let (x, y, z) = (g.and(a, zero), g.and(b, one), g.and(both, s.u));
                    let xy = g.or(x, y);
                    g.or(xy, z)
                };
                Two { v: pick(a.v, b.v, both.v), u: pick(a.u, b.u, both.u) }
            })
            .collect(),
        CellKind::BitSame { width } => (0..words(*width))
            .map(|i| {
                let (a, b) = (ins[0][i], ins[1][i]);
                let (v, u) = (g.xor(a.v, b.v), g.xor(a.u, b.u));
                let differ = g.or(v, u);
                let same = g.not(differ, word_mask(*width, i));
                g.known(same)
            })
            .collect(),
        CellKind::Products { width, table } => {
            let mut any = g.constant(0);
            for product in table.chunks_exact(words(*width)) {
                let mut against = g.constant(0);
                for (i, &(zero, one)) in product.iter().enumerate() {
                    let (ones, some) = (g.ones(ins[0][i]), g.or(ins[0][i].v, ins[0][i].u));
                    let (zero, one) = (g.constant(zero), g.constant(one));
                    let (a, b) = (g.and(zero, ones), g.and_not(one, some));
                    let ab = g.or(a, b);
                    against = g.or(against, ab);
                }
                let against = g.any(against);
                let holds = g.not(against, 1);
                any = g.or(any, holds);
            }
            vec![g.known(any)]
        }
        CellKind::CarrySave { width } => {
            let (mut x, mut y) = (Vec::new(), Vec::new());
            for ((&a, &b), &c) in ins[0].iter().zip(&ins[1]).zip(&ins[2]).take(words(*width)) {
                let u = g.or(a.u, b.u);
                let u = g.or(u, c.u);
                let (a, b, c) = (g.and_not(a.v, u), g.and_not(b.v, u), g.and_not(c.v, u));
                let ab = g.xor(a, b);
                y.push(Two { v: g.xor(ab, c), u });
                let (both, passed) = (g.and(a, b), g.and(c, ab));
                x.push(Two { v: g.or(both, passed), u });
            }
            return vec![x, y];
        }
        CellKind::Carry { width } => {
            let (p, q) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
            let unknown = g.or(p, q);
            let unknown = g.or(unknown, ins[2][0].u);
            let mut carry = ins[2][0].v;
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let mut all = g.constant(0);
                    for k in 0..m.count_ones() {
                        let (p, q) = (g.bits(ins[0][i].v, k, 1), g.bits(ins[1][i].v, k, 1));
                        let passed = g.and(p, carry);
                        carry = g.or(q, passed);
                        let placed = g.shl(carry, k);
                        all = g.or(all, placed);
                    }
                    g.unless(unknown, all, m)
                })
                .collect()
        }
        CellKind::Alu(alu) => return alu_of(g, alu, ins),
        CellKind::Tristate { width } => {
            let en = ins[1][0];
            let (one, zero) = (g.is_one(en), g.is_zero4(en));
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let (z, x) = (g.two(Word::z(m)), g.two(Word::x(m)));
                    let off = g.pick4(zero, z, x);
                    g.pick4(one, ins[0][i], off)
                })
                .collect()
        }
        CellKind::Resolve { width, inputs } => {
            let parts: Vec<Bits> = (0..*inputs).map(|k| slice(g, &ins[0], k * width, *width)).collect();
            (0..words(*width))
                .map(|i| {
                    let m = word_mask(*width, i);
                    let none = g.two(Word::z(m));
                    parts.iter().fold(none, |all, part| g.resolve4(all, part[i], m))
                })
                .collect()
        }
        CellKind::Constant(value) => g.literal(value),
        _ => unreachable!("storage and time are not combinational, and what is not supported does not come here"),
    };
    vec![out]
}

fn mux(g: &mut Graph, width: u32, inputs: u32, ins: &[Two], s: Two) -> Bits {
    let bits = crate::cell::select::select_width(inputs);
    let mut level: Vec<Bits> = (0..inputs).map(|k| slice(g, ins, k * width, width)).collect();
    for bit in 0..bits {
        let s = g.bits4(s, bit, 1);
        if level.len() % 2 == 1 {
            let x = g.x(width); // what lies beyond the inputs
            level.push(x);
        }
        level = level
            .chunks_exact(2)
            .map(|pair| pair[0].iter().zip(&pair[1]).map(|(&zero, &one)| g.mux4(s, one, zero)).collect())
            .collect();
    }
    level.swap_remove(0)
}

fn multiply(g: &mut Graph, a_width: u32, b_width: u32, signed: bool, ins: &[Bits]) -> Bits {
    let width = a_width + b_width;
    let (x, y) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
    let unknown = g.or(x, y);
    let (mut a, mut b) = (ins[0][0].v, ins[1][0].v);
    if signed {
        (a, b) = (g.extend(a, a_width), g.extend(b, b_width));
    }
    let mut parts = vec![g.mul(a, b)];
    if width > 64 {
        parts.push(g.mul_high(a, b, signed));
    }
    parts
        .into_iter()
        .enumerate()
        .map(|(i, part)| {
            let m = word_mask(width, i);
            let all = g.constant(m);
            let part = g.and(part, all);
            g.unless(unknown, part, m)
        })
        .collect()
}

fn compare(g: &mut Graph, op: CompareOp, width: u32, signed: bool, a: &[Two], b: &[Two]) -> Two {
    let n = words(width);
    if matches!(op, CompareOp::Same | CompareOp::Differs) {
        let mut differ = g.constant(0);
        for i in 0..n {
            let (v, u) = (g.xor(a[i].v, b[i].v), g.xor(a[i].u, b[i].u));
            let vu = g.or(v, u);
            differ = g.or(differ, vu);
        }
        let differ = g.any(differ);
        let y = if op == CompareOp::Differs { differ } else { g.not(differ, 1) };
        return g.known(y);
    }
    let (x, y) = (g.any_unknown(a), g.any_unknown(b));
    let unknown = g.or(x, y);
    if matches!(op, CompareOp::Eq | CompareOp::Ne) {
        let mut differ = g.constant(0);
        for i in 0..n {
            let (v, u) = (g.xor(a[i].v, b[i].v), g.or(a[i].u, b[i].u));
            let certain = g.and_not(v, u);
            differ = g.or(differ, certain);
        }
        let differ = g.any(differ);
        let y = if op == CompareOp::Ne { differ } else { g.not(differ, 1) };
        let unknown = g.and_not(unknown, differ);
        return g.unless(unknown, y, 1);
    }
    let (a, b) = if matches!(op, CompareOp::Gt | CompareOp::Le) { (b, a) } else { (a, b) };
    let mut less = g.constant(0);
    for i in 0..n {
        let sign = if signed && i == n - 1 { 1 << ((width - 1) % 64) } else { 0 };
        let sign = g.constant(sign);
        let (a, b) = (g.xor(a[i].v, sign), g.xor(b[i].v, sign));
        let (here, same) = (g.less(a, b), g.eq(a, b));
        let below = g.and(same, less);
        less = g.or(here, below);
    }
    let y = if matches!(op, CompareOp::Le | CompareOp::Ge) { g.not(less, 1) } else { less };
    g.unless(unknown, y, 1)
}

fn shift(g: &mut Graph, op: ShiftOp, (a_width, b_width, width): (u32, u32, u32), a: Two, b: Two) -> Two {
    let unknown = g.any(b.u);
    let m = mask(width);
    let limit = g.constant(64);
    let zero = g.constant(0);
    let signed = matches!(op, ShiftOp::Both | ShiftOp::PartSigned);
    let negative = if signed { g.bits(b.v, b_width - 1, 1) } else { zero };
    let number = if signed { g.extend(b.v, b_width) } else { b.v };
    let minus = g.sub(zero, number);
    // how far to the left and to the right, and whether that is within a word
    let (left_by, right_by) = if op == ShiftOp::Left { (b.v, zero) } else { (minus, number) };
    let (left_fits, right_fits) = (g.less(left_by, limit), g.less(right_by, limit));
    let moved = |g: &mut Graph, a: Id| {
        let left = |g: &mut Graph| {
            let y = g.shl_by(a, left_by);
            g.select(left_fits, y, zero)
        };
        let right = |g: &mut Graph| {
            let y = g.shr_by(a, right_by);
            g.select(right_fits, y, zero)
        };
        let y = match op {
            ShiftOp::Left => left(g),
            ShiftOp::Right | ShiftOp::Part => right(g),
            ShiftOp::RightSigned => {
                let whole = g.extend(a, a_width);
                let most = g.constant(63);
                let by = g.select(right_fits, right_by, most);
                g.sar_by(whole, by)
            }
            ShiftOp::Both | ShiftOp::PartSigned => {
                let (l, r) = (left(g), right(g));
                g.select(negative, l, r)
            }
        };
        let all = g.constant(m);
        g.and(y, all)
    };
    let (v, mut u) = (moved(g, a.v), moved(g, a.u));
    if matches!(op, ShiftOp::Part | ShiftOp::PartSigned) {
        let whole = g.constant(mask(a_width));
        let inside = moved(g, whole);
        let all = g.constant(m);
        let outside = g.and_not(all, inside);
        u = g.or(u, outside);
    }
    let all = g.splat(unknown, m);
    Two { v: g.select(unknown, zero, v), u: g.or(u, all) }
}

fn divide(g: &mut Graph, op: DivideOp, width: u32, signed: bool, a: Two, b: Two) -> Two {
    let m = mask(width);
    let either = g.or(a.u, b.u);
    let zero = g.constant(0);
    let by_zero = g.eq(b.v, zero);
    let unknown = g.any(either);
    let unknown = g.or(unknown, by_zero);
    let one = g.constant(1);
    let all = g.constant(m);
    let sign = |g: &mut Graph, a: Id| if signed { g.bits(a, width - 1, 1) } else { zero };
    let (a_negative, b_negative) = (sign(g, a.v), sign(g, b.v));
    let negated_if = |g: &mut Graph, s: Id, a: Id| {
        let minus = g.sub(zero, a);
        let minus = g.and(minus, all);
        g.select(s, minus, a)
    };
    let (x, y) = (negated_if(g, a_negative, a.v), negated_if(g, b_negative, b.v));
    let y = g.select(by_zero, one, y);
    let (q, r) = (g.div(x, y), g.rem(x, y));
    let differ = g.xor(a_negative, b_negative);
    let inexact = g.any(r);
    let down = g.and(differ, inexact);
    let result = match op {
        DivideOp::Quotient => negated_if(g, differ, q),
        DivideOp::Floor => {
            let truncated = negated_if(g, differ, q);
            let floored = g.xor(q, all);
            g.select(down, floored, truncated)
        }
        DivideOp::Remainder => negated_if(g, a_negative, r),
        DivideOp::Modulo => {
            let same = negated_if(g, a_negative, r);
            let rest = g.sub(y, r);
            let rest = negated_if(g, b_negative, rest);
            g.select(down, rest, same)
        }
    };
    let result = g.and(result, all);
    g.unless(unknown, result, m)
}

/// Lines of a select up to which it is looked for whether two can be active.
const PLAIN: usize = 64;

fn one_hot(g: &mut Graph, width: u32, inputs: u32, ins: &[Bits]) -> Bits {
    let lines: Vec<Id> = (0..inputs)
        .map(|k| {
            let s = slice(g, &ins[2], k, 1)[0];
            g.is_one(s)
        })
        .collect();
    let mut several = g.any_unknown(&ins[2]);
    let (mut before, one) = (g.constant(0), g.constant(1));
    let plain = inputs as usize <= PLAIN && g.exclusive(&lines);
    for &line in ins[2].iter().take(words(inputs)).filter(|_| !plain) {
        // more than one line of this word, or one here and one before
        let s = g.ones(line);
        let less = g.sub(s, one);
        let rest = g.and(s, less);
        let (more, some) = (g.any(rest), g.any(s));
        let both = g.and(before, some);
        several = g.or(several, more);
        several = g.or(several, both);
        before = g.or(before, some);
    }
    // what holds while none is active does not matter where one always is
    let covered = plain && g.is(several, 0) && g.exhaustive(&lines);
    let mut y = if covered { slice(g, &ins[1], 0, width) } else { ins[0].clone() };
    for k in u32::from(covered)..inputs {
        let (part, s) = (slice(g, &ins[1], k * width, width), lines[k as usize]);
        for (y, part) in y.iter_mut().zip(part) {
            *y = g.pick4(s, part, *y);
        }
    }
    for (i, y) in y.iter_mut().enumerate() {
        let x = g.two(Word::x(word_mask(width, i)));
        *y = g.pick4(several, x, *y);
    }
    y
}

fn demux(g: &mut Graph, width: u32, select: u32, a: &[Two], s: Two) -> Bits {
    let mut all = Vec::new();
    let unknown = g.any(s.u);
    let none = g.two(Word::ZERO);
    let passed: Bits = a
        .iter()
        .map(|&a| {
            let merged = g.merge4(a, none);
            g.pick4(unknown, merged, a)
        })
        .collect();
    for k in 0..1u64 << select {
        let number = g.constant(k);
        let differ = g.xor(s.v, number);
        let differ = g.and_not(differ, s.u);
        let differ = g.any(differ);
        let part: Bits = passed.iter().map(|&w| g.pick4(differ, none, w)).collect();
        append(g, &mut all, k as u32 * width, &part, width);
    }
    all
}

fn alu_of(g: &mut Graph, alu: &Alu, ins: &[Bits]) -> Vec<Bits> {
    let (ci, bi) = (ins[2][0], ins[3][0]);
    let (p, q) = (g.any_unknown(&ins[0]), g.any_unknown(&ins[1]));
    let unknown = g.or(p, q);
    let controls = g.or(ci.u, bi.u);
    let unknown = g.or(unknown, controls);
    let operand = |g: &mut Graph, a: &[Two], from: u32, i: usize| {
        let m = word_mask(alu.width, i);
        let none = g.two(Word::ZERO);
        let own = if i < words(from) { g.mask4(a[i], m) } else { none };
        if i + 1 < words(from) || from >= alu.width || !alu.signed {
            return own;
        }
        let last = a[words(from) - 1];
        let above = m & !(if i < words(from) { word_mask(from, i) } else { 0 });
        let sign = g.bits4(last, (from - 1) % 64, 1);
        let high = Two { v: g.splat(sign.v, above), u: g.splat(sign.u, above) };
        Two { v: g.or(own.v, high.v), u: g.or(own.u, high.u) }
    };
    let (mut x, mut y, mut co) = (Vec::new(), Vec::new(), Vec::new());
    let mut carry = ci.v;
    for i in 0..words(alu.width) {
        let m = word_mask(alu.width, i);
        let (a, b) = (operand(g, &ins[0], alu.a_width, i), operand(g, &ins[1], alu.b_width, i));
        let invert = Two { v: g.splat(bi.v, m), u: g.splat(bi.u, m) };
        let b = g.xor4(b, invert);
        x.push(g.xor4(a, b));
        let s = g.add(a.v, b.v);
        let sum = g.add(s, carry);
        let (c1, c2) = (g.less(s, a.v), g.less(sum, s));
        let into = g.xor(sum, a.v);
        let into = g.xor(into, b.v);
        let (both, some) = (g.and(a.v, b.v), g.or(a.v, b.v));
        let passed = g.and(into, some);
        let out = g.or(both, passed);
        let all = g.constant(m);
        let (sum, out) = (g.and(sum, all), g.and(out, all));
        y.push(g.unless(unknown, sum, m));
        co.push(g.unless(unknown, out, m));
        carry = g.or(c1, c2);
    }
    vec![x, y, co]
}
