//! What cells do to known bits, as functions of [`Logic`]. Bit for bit the functions of the cell room, for operands
//! without x and z; where those give x all the same, a guard says so.

use super::logic::{Lit, Logic};
use crate::batch::build::loads_known;
use crate::batch::combine::bit_of_value;
use crate::cell::{AddOp, CellKind, CompareOp, DivideOp, GateOp, ShiftOp};

/// The most operations that a cell may take: beyond it lane by lane is no slower.
const MOST: u32 = 1 << 16;

/// Whether there is a form of a cell here; `acts` tells whether a pin may ever be other than 0.
pub(super) fn has_form(kind: &CellKind, acts: impl Fn(usize) -> bool) -> bool {
    match kind {
        CellKind::Tristate { .. } | CellKind::Resolve { .. } | CellKind::Power { .. } => false,
        CellKind::Flop(_) | CellKind::EdgeFlop(_) | CellKind::Latch(_) | CellKind::Counter(_) => {
            loads_known(kind, acts)
        }
        CellKind::Multiply { a_width, b_width, .. } => (a_width + b_width) * (a_width + b_width) <= MOST,
        CellKind::Divide { width, .. } => width * width <= MOST / 4,
        CellKind::Demux { width, select } => width << select <= MOST,
        CellKind::Mux { width, inputs } => width * inputs <= MOST,
        _ => true,
    }
}

/// The outputs of a cell without a state. What it gives where `guard` is 1 is not known.
pub(super) fn outputs(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], guard: &mut Lit) -> Vec<Vec<Lit>> {
    let one = |bits: Vec<Lit>| vec![bits];
    match *kind {
        CellKind::Gate { op, width, inputs } => one((0..width as usize)
            .map(|i| {
                let mut ins = (0..inputs as usize).map(|k| pins[0][k * width as usize + i]);
                let first = ins.next().unwrap_or(Lit::FALSE);
                let all = ins.fold(first, |all, bit| match op {
                    GateOp::And | GateOp::Nand => l.and(all, bit),
                    GateOp::Xor | GateOp::Xnor => l.xor(all, bit),
                    _ => l.or(all, bit),
                });
                all.invert_if(op.inverts())
            })
            .collect()),
        CellKind::AndOr { width, inputs } => one((0..width as usize)
            .map(|i| {
                (0..inputs as usize).fold(Lit::FALSE, |all, k| {
                    l.table(0xf0 | 0xcc & 0xaa, [all, pins[0][k * width as usize + i], pins[1][k]])
                })
            })
            .collect()),
        CellKind::Mux { width, inputs } => {
            let (width, inputs) = (width as usize, inputs as usize);
            let sel = &pins[1];
            let out = (0..width).map(|i| {
                let mut tree: Vec<Lit> = (0..1usize << sel.len())
                    .map(|k| pins[0].get(k * width + i).copied().unwrap_or(Lit::FALSE))
                    .collect();
                for &s in sel {
                    tree = tree.chunks_exact(2).map(|pair| l.choose(s, pair[0], pair[1])).collect();
                }
                tree[0]
            });
            let out = out.collect();
            if inputs < 1 << sel.len() {
                let most: Vec<Lit> = (0..sel.len()).map(|i| Lit::constant((inputs - 1) >> i & 1 == 1)).collect();
                let beyond = l.less(&most, sel);
                *guard = l.or(*guard, beyond);
            }
            one(out)
        }
        CellKind::HalfAdder => vec![vec![l.xor(pins[0][0], pins[1][0])], vec![l.and(pins[0][0], pins[1][0])]],
        CellKind::FullAdder => {
            let [a, b, c] = [0, 1, 2].map(|pin| pins[pin][0]);
            vec![vec![l.xor3(a, b, c)], vec![l.majority(a, b, c)]]
        }
        CellKind::Adder { op, .. } => {
            let sub = match op {
                AddOp::Add => Lit::FALSE,
                AddOp::Sub => Lit::TRUE,
                AddOp::AddSub => pins[3][0],
            };
            let b: Vec<Lit> = pins[1].iter().map(|&b| l.xor(b, sub)).collect();
            let carry = l.xor(pins[2][0], sub);
            let (sum, carry) = l.add(&pins[0], &b, carry);
            vec![sum, vec![l.xor(carry, sub)]]
        }
        CellKind::Multiply { a_width, b_width, signed } => {
            let width = (a_width + b_width) as usize;
            let [a, b] = [0, 1].map(|pin| extended(&pins[pin], width, signed));
            let mut sum = vec![Lit::FALSE; width];
            for (i, &digit) in b.iter().enumerate() {
                let row: Vec<Lit> = a[..width - i].iter().map(|&a| l.and(a, digit)).collect();
                let (high, _) = l.add(&sum[i..], &row, Lit::FALSE);
                sum.splice(i.., high);
            }
            one(sum)
        }
        CellKind::Compare { op, signed, .. } => {
            let (mut a, mut b) = (pins[0].clone(), pins[1].clone());
            let y = match op {
                CompareOp::Eq | CompareOp::Same | CompareOp::Ne | CompareOp::Differs => {
                    let differs =
                        a.iter().zip(&b).fold(Lit::FALSE, |all, (&a, &b)| l.table(0xf0 | 0xcc ^ 0xaa, [all, a, b]));
                    differs.invert_if(matches!(op, CompareOp::Eq | CompareOp::Same))
                }
                _ => {
                    if let (true, Some(a), Some(b)) = (signed, a.last_mut(), b.last_mut()) {
                        (*a, *b) = (!*a, !*b);
                    }
                    let swapped = matches!(op, CompareOp::Gt | CompareOp::Le);
                    let less = if swapped { l.less(&b, &a) } else { l.less(&a, &b) };
                    less.invert_if(matches!(op, CompareOp::Le | CompareOp::Ge))
                }
            };
            vec![vec![y]]
        }
        CellKind::Shift { op, width, .. } => one(shift(l, op, width as usize, &pins[0], &pins[1], guard)),
        CellKind::Divide { op, signed, .. } => one(divide(l, op, signed, &pins[0], &pins[1], guard)),
        CellKind::OneHotMux { width, inputs } => {
            let width = width as usize;
            let mut chosen = pins[0].clone();
            let mut before = Lit::FALSE;
            for k in 0..inputs as usize {
                let s = pins[2][k];
                chosen = l.choose_all(s, &chosen, &pins[1][k * width..(k + 1) * width]);
                // two lines at once
                *guard = l.table(0xf0 | 0xcc & 0xaa, [*guard, before, s]);
                before = l.or(before, s);
            }
            one(chosen)
        }
        CellKind::Demux { select, .. } => {
            let lines = (0..1u32 << select).map(|k| {
                pins[1].iter().enumerate().fold(Lit::TRUE, |all, (i, &s)| l.and(all, s.invert_if(k >> i & 1 == 0)))
            });
            let lines: Vec<Lit> = lines.collect();
            one(lines
                .iter()
                .flat_map(|&line| pins[0].iter().map(move |&a| (line, a)))
                .map(|(s, a)| l.and(s, a))
                .collect())
        }
        CellKind::BitMux { .. } => {
            one((0..pins[0].len()).map(|i| l.choose(pins[2][i], pins[0][i], pins[1][i])).collect())
        }
        CellKind::BitSame { .. } => one((0..pins[0].len()).map(|i| !l.xor(pins[0][i], pins[1][i])).collect()),
        CellKind::Products { width, ref table } => {
            let products = table.chunks_exact((width as usize).div_ceil(64)).map(|product| {
                pins[0].iter().enumerate().fold(Lit::TRUE, |all, (i, &a)| {
                    let (zero, one) = product[i / 64];
                    let all = if zero >> (i % 64) & 1 == 1 { l.and(all, !a) } else { all };
                    if one >> (i % 64) & 1 == 1 { l.and(all, a) } else { all }
                })
            });
            let products: Vec<Lit> = products.collect();
            vec![vec![l.any(&products)]]
        }
        CellKind::CarrySave { .. } => {
            let bits = (0..pins[0].len()).map(|i| [0, 1, 2].map(|pin| pins[pin][i]));
            let both = bits.map(|[a, b, c]| (l.majority(a, b, c), l.xor3(a, b, c)));
            let (carries, sums) = both.unzip();
            vec![carries, sums]
        }
        CellKind::Carry { .. } => {
            let mut carry = pins[2][0];
            one((0..pins[0].len())
                .map(|i| {
                    carry = l.table(0xf0 | 0xcc & 0xaa, [pins[1][i], pins[0][i], carry]);
                    carry
                })
                .collect())
        }
        CellKind::Alu(alu) => {
            let [a, b] = [0, 1].map(|pin| extended(&pins[pin], alu.width as usize, alu.signed));
            let b: Vec<Lit> = b.into_iter().map(|b| l.xor(b, pins[3][0])).collect();
            let mut carry = pins[2][0];
            let mut all = vec![Vec::new(); 3];
            for (&a, &b) in a.iter().zip(&b) {
                all[0].push(l.xor(a, b));
                all[1].push(l.xor3(a, b, carry));
                carry = l.majority(a, b, carry);
                all[2].push(carry);
            }
            all
        }
        CellKind::IsZero { .. } => vec![vec![!l.any(&pins[0])]],
        _ => Vec::new(),
    }
}

/// A number of another width: cut off, or with its sign or zeros in front.
fn extended(bits: &[Lit], width: usize, signed: bool) -> Vec<Lit> {
    let fill = if signed { bits.last().copied().unwrap_or(Lit::FALSE) } else { Lit::FALSE };
    (0..width).map(|i| bits.get(i).copied().unwrap_or(fill)).collect()
}

fn shift(l: &mut Logic, op: ShiftOp, width: usize, a: &[Lit], b: &[Lit], guard: &mut Lit) -> Vec<Lit> {
    let all = a.len().max(width);
    let right = |l: &mut Logic, fill: Lit, bits: Vec<Lit>, amount: &[Lit]| {
        amount.iter().enumerate().fold(bits, |bits, (j, &s)| {
            let by = if j < 32 { 1usize << j } else { usize::MAX };
            (0..bits.len())
                .map(|i| l.choose(s, bits[i], i.checked_add(by).and_then(|i| bits.get(i)).copied().unwrap_or(fill)))
                .collect()
        })
    };
    let padded = |fill: Lit| -> Vec<Lit> { (0..all).map(|i| a.get(i).copied().unwrap_or(fill)).collect() };
    let left = |l: &mut Logic, amount: &[Lit]| {
        let mut bits = padded(Lit::FALSE);
        bits.reverse();
        let mut bits = right(l, Lit::FALSE, bits, amount);
        bits.reverse();
        bits
    };
    let mut y = match op {
        ShiftOp::Left => left(l, b),
        ShiftOp::Right => right(l, Lit::FALSE, padded(Lit::FALSE), b),
        ShiftOp::RightSigned => {
            let sign = a.last().copied().unwrap_or(Lit::FALSE);
            right(l, sign, padded(sign), b)
        }
        ShiftOp::Both => {
            let negative = b.last().copied().unwrap_or(Lit::FALSE);
            let to_right = right(l, Lit::FALSE, padded(Lit::FALSE), b);
            let minus = l.negate_if(Lit::TRUE, b);
            let to_left = left(l, &minus);
            l.choose_all(negative, &to_right, &to_left)
        }
        ShiftOp::Part | ShiftOp::PartSigned => {
            // what is beyond `a` is x
            let inside = (0..all).map(|i| Lit::constant(i < a.len())).collect();
            let inside = right(l, Lit::FALSE, inside, b);
            for &inside in &inside[..width] {
                *guard = l.or(*guard, !inside);
            }
            if op == ShiftOp::PartSigned {
                *guard = l.or(*guard, b.last().copied().unwrap_or(Lit::FALSE));
            }
            right(l, Lit::FALSE, padded(Lit::FALSE), b)
        }
    };
    y.truncate(width);
    y
}

fn divide(l: &mut Logic, op: DivideOp, signed: bool, a: &[Lit], b: &[Lit], guard: &mut Lit) -> Vec<Lit> {
    let n = a.len();
    let some = l.any(b);
    *guard = l.or(*guard, !some);
    let sign = |bits: &[Lit]| if signed { bits.last().copied().unwrap_or(Lit::FALSE) } else { Lit::FALSE };
    let (minus_a, minus_b) = (sign(a), sign(b));
    let (a, b) = (l.negate_if(minus_a, a), l.negate_if(minus_b, b));
    // one bit at a time, the remainder a bit wider than the divisor
    let wide: Vec<Lit> = b.iter().map(|&b| !b).chain([Lit::TRUE]).collect();
    let (mut q, mut r) = (vec![Lit::FALSE; n], vec![Lit::FALSE; n]);
    for i in (0..n).rev() {
        let shifted: Vec<Lit> = std::iter::once(a[i]).chain(r).collect();
        let (difference, fits) = l.add(&shifted, &wide, Lit::TRUE);
        q[i] = fits;
        r = l.choose_all(fits, &shifted[..n], &difference[..n]);
    }
    let unlike = l.xor(minus_a, minus_b);
    let rest = l.any(&r);
    let down = l.and(unlike, rest);
    match op {
        DivideOp::Quotient => l.negate_if(unlike, &q),
        DivideOp::Floor => {
            // -q - 1 is !q
            let negative = l.negate_if(unlike, &q);
            let below: Vec<Lit> = q.iter().map(|&q| !q).collect();
            l.choose_all(down, &negative, &below)
        }
        DivideOp::Remainder => l.negate_if(minus_a, &r),
        DivideOp::Modulo => {
            // of the magnitudes b - r, with the sign of b
            let minus_r: Vec<Lit> = r.iter().map(|&r| !r).collect();
            let (up, _) = l.add(&b, &minus_r, Lit::TRUE);
            let up = l.negate_if(minus_b, &up);
            let plain = l.negate_if(minus_a, &r);
            l.choose_all(down, &plain, &up)
        }
    }
}

/// The state of a cell after its levels have acted on it, and its pins from `pins`.
pub(super) fn level(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], q: &[Lit]) -> Vec<Lit> {
    let (reset, set, load) = match kind {
        CellKind::Sr { set_dominates, .. } => {
            let (set, reset) = (pins[0][0], pins[1][0]);
            let reset = if *set_dominates { l.and(reset, !set) } else { reset };
            // set, unless reset
            return vec![l.table(!0xf0 & (0xcc | 0xaa), [reset, set, q[0]])];
        }
        CellKind::Latch(_) => (pins[3][0], pins[2][0], pins[0][0]),
        CellKind::Flop(_) => (pins[4][0], pins[3][0], pins[2][0]),
        CellKind::Counter(_) => (pins[3][0], Lit::FALSE, pins[2][0]),
        CellKind::Accumulator(_) => (pins[3][0], Lit::FALSE, Lit::FALSE),
        _ => return q.to_vec(),
    };
    (0..q.len()).map(|i| held(l, kind, i, [reset, set, load], pins[1][i], q[i])).collect()
}

/// A bit that is reset, or set, or loaded, or kept.
fn held(l: &mut Logic, kind: &CellKind, i: usize, [reset, set, load]: [Lit; 3], d: Lit, q: Lit) -> Lit {
    let (set_value, reset_value) = match kind {
        CellKind::Flop(f) | CellKind::Latch(f) | CellKind::EdgeFlop(f) => {
            (Lit::constant(bit_of_value(&f.set_value, i as u32)), Lit::constant(bit_of_value(&f.reset_value, i as u32)))
        }
        _ => (Lit::FALSE, Lit::FALSE),
    };
    let y = l.choose(load, q, d);
    let y = l.choose(set, y, set_value);
    l.choose(reset, y, reset_value)
}

/// The output that is made from the state.
pub(super) fn derived(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], q: &[Lit]) -> Vec<Lit> {
    match kind {
        CellKind::Counter(_) => vec![!l.any(q)],
        CellKind::Accumulator(_) => vec![l.add(q, &pins[1], pins[2][0]).1],
        _ => q.iter().map(|&q| !q).collect(),
    }
}

/// What a cell with a clock takes at its edge.
pub(super) fn sampled(l: &mut Logic, kind: &CellKind, pins: &[Vec<Lit>], q: &[Lit]) -> Vec<Lit> {
    let pin = |pin: usize| pins[pin][0];
    match kind {
        CellKind::Flop(_) => (0..q.len())
            .map(|i| {
                let d = pins[1][i];
                let y = held(l, kind, i, [pin(7), pin(6), pin(5)], d, q[i]);
                held(l, kind, i, [pin(4), pin(3), pin(2)], d, y)
            })
            .collect(),
        CellKind::EdgeFlop(_) => (0..q.len())
            .map(|i| {
                let y = l.choose(pin(6), q[i], pins[1][i]);
                held(l, kind, i, [pin(5), pin(4), pin(3)], pins[2][i], y)
            })
            .collect(),
        CellKind::Counter(c) => {
            let down = pin(5);
            let step: Vec<Lit> =
                (0..q.len()).map(|i| l.xor(Lit::constant(bit_of_value(&c.step, i as u32)), down)).collect();
            let (sum, _) = l.add(q, &step, down);
            let load = l.or(pin(2), pin(6));
            (0..q.len())
                .map(|i| {
                    let y = l.choose(pin(4), q[i], sum[i]);
                    held(l, kind, i, [pin(3), Lit::FALSE, load], pins[1][i], y)
                })
                .collect()
        }
        CellKind::Accumulator(_) => {
            let (sum, _) = l.add(q, &pins[1], pin(2));
            (0..q.len())
                .map(|i| {
                    let y = l.choose(pin(4), q[i], sum[i]);
                    l.and(y, !pin(3))
                })
                .collect()
        }
        _ => q.to_vec(),
    }
}
