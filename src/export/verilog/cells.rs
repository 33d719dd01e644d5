//! Cells without state: operators and the expressions that mean the same, x and z included.

use super::text::{literal, part, range, repeat, zeros};
use super::writer::Writer;
use super::{memory, storage};
use crate::cell::pin::several::IN;
use crate::cell::pin::{self, add, add_sub, binary, chosen, ternary};
use crate::cell::{AddOp, CellKind, CompareOp, DivideOp, GateOp, ShiftOp};
use crate::netlist::hierarchy::Cell;

/// Writes a cell.
pub(super) fn write(w: &mut Writer<'_>, cell: &Cell) {
    let kind = w.kind(cell);
    let of = |w: &Writer<'_>, pin: usize| w.input(cell, pin);
    // input k of a pin that takes several
    let several =
        |w: &Writer<'_>, pin: usize, k: u32, width: u32| w.text_of(&part(&cell.inputs[pin], k * width, width));
    let bit = |w: &Writer<'_>, pin: usize, i: u32| {
        if cell.inputs[pin].is_empty() { "1'b0".to_owned() } else { w.text_of(&part(&cell.inputs[pin], i, 1)) }
    };
    if (0..cell.outputs.len()).all(|pin| Writer::is_open(cell, pin)) && kind.init().is_none() {
        return;
    }
    let y = match kind {
        CellKind::Gate { op: GateOp::Not, .. } => format!("~{}", of(w, IN)),
        // a buffer gives x for z
        CellKind::Gate { op: GateOp::Buf, width, .. } => format!("{} | {}", of(w, IN), zeros(*width)),
        CellKind::Gate { op, width, inputs } => {
            let sign = match op {
                GateOp::And | GateOp::Nand => "&",
                GateOp::Xor | GateOp::Xnor => "^",
                GateOp::Or | GateOp::Nor | GateOp::Buf | GateOp::Not => "|",
            };
            let pieces = &cell.inputs[IN];
            let joined = if *width == 1 && (pieces.len() == 1 || *inputs > 16) && *inputs > 1 {
                format!("{sign}{}", of(w, IN))
            } else {
                let all: Vec<String> = (0..*inputs).map(|k| several(w, IN, k, *width)).collect();
                all.join(&format!(" {sign} "))
            };
            // of a single input, x for z
            let joined = if *inputs == 1 { format!("{joined} | {}", zeros(*width)) } else { joined };
            if op.inverts() { format!("~({joined})") } else { joined }
        }
        CellKind::AndOr { width, inputs } => {
            let term = |k| {
                format!(
                    "({} & {})",
                    several(w, pin::and_or::IN, k, *width),
                    repeat(*width, &bit(w, pin::and_or::SEL, k))
                )
            };
            (0..*inputs).map(term).collect::<Vec<_>>().join(" | ")
        }
        CellKind::Majority { .. } => {
            let (a, b, c) = (of(w, ternary::A), of(w, ternary::B), of(w, ternary::C));
            format!("({a} & {b}) | (({a} | {b}) & {c})")
        }
        CellKind::Mux { width, inputs } => {
            let ins: Vec<String> = (0..*inputs).map(|k| several(w, pin::mux::IN, k, *width)).collect();
            let lines: Vec<String> = (0..kind.input_width(pin::mux::S)).map(|i| bit(w, pin::mux::S, i)).collect();
            mux(*width, &ins, &lines, 0, lines.len())
        }
        CellKind::HalfAdder => {
            let (a, b) = (of(w, binary::A), of(w, binary::B));
            w.assign(cell, 0, &format!("{a} ^ {b}"));
            format!("{a} & {b}")
        }
        CellKind::FullAdder => {
            let (a, b, c) = (of(w, pin::full_adder::A), of(w, pin::full_adder::B), of(w, pin::full_adder::CI));
            w.assign(cell, 0, &format!("{a} ^ {b} ^ {c}"));
            format!("({a} & {b}) | (({a} ^ {b}) & {c})")
        }
        CellKind::Adder { op, width } => return adder(w, cell, *op, *width),
        CellKind::Multiply { a_width, b_width, signed } => {
            let extended = |w: &Writer<'_>, pin: usize, own: u32, more: u32| {
                let high = if *signed { repeat(more, &bit(w, pin, own - 1)) } else { zeros(more) };
                format!("{{{high}, {}}}", of(w, pin))
            };
            format!("{} * {}", extended(w, binary::A, *a_width, *b_width), extended(w, binary::B, *b_width, *a_width))
        }
        CellKind::Compare { op, signed, .. } => {
            let sign = match op {
                CompareOp::Eq => "==",
                CompareOp::Ne => "!=",
                CompareOp::Lt => "<",
                CompareOp::Le => "<=",
                CompareOp::Gt => ">",
                CompareOp::Ge => ">=",
                CompareOp::Same => "===",
                CompareOp::Differs => "!==",
            };
            let (a, b) = (of(w, binary::A), of(w, binary::B));
            let order = !matches!(op, CompareOp::Eq | CompareOp::Ne | CompareOp::Same | CompareOp::Differs);
            if *signed && order { format!("$signed({a}) {sign} $signed({b})") } else { format!("{a} {sign} {b}") }
        }
        CellKind::Shift { op, a_width, b_width, width } => {
            let text = shift(w, cell, *op, *a_width, *b_width, *width);
            return w.assign(cell, 0, &text);
        }
        CellKind::Divide { op, width, signed } => divide(w, cell, *op, *width, *signed),
        CellKind::Power { width, b_width, a_signed, b_signed } => {
            power(w, cell, *width, *b_width, *a_signed, *b_signed)
        }
        CellKind::OneHotMux { width, inputs } => {
            let s = of(w, chosen::S);
            let mut text = format!("{s} === {} ? {}", zeros(*inputs), of(w, chosen::A));
            for k in 0..*inputs {
                let line: String = (0..*inputs).rev().map(|i| if i == k { '1' } else { '0' }).collect();
                text += &format!(" :\n        {s} === {inputs}'b{line} ? {}", several(w, chosen::B, k, *width));
            }
            format!("{text} :\n        {width}'bx")
        }
        CellKind::Demux { width, select } => {
            let (a, s) = (of(w, pin::demux::A), of(w, pin::demux::S));
            let one = |k| format!("{s} == {select}'d{k} ? {a} : {}", zeros(*width));
            format!("{{{}}}", (0..1u32 << select).rev().map(one).collect::<Vec<_>>().join(",\n        "))
        }
        CellKind::BitMux { width } => {
            let one = |i| format!("{} ? {} : {}", bit(w, chosen::S, i), bit(w, chosen::B, i), bit(w, chosen::A, i));
            format!("{{{}}}", (0..*width).rev().map(one).collect::<Vec<_>>().join(", "))
        }
        CellKind::BitSame { width } => {
            let one = |i| format!("{} === {}", bit(w, binary::A, i), bit(w, binary::B, i));
            format!("{{{}}}", (0..*width).rev().map(one).collect::<Vec<_>>().join(", "))
        }
        CellKind::Products { width, table } => {
            let words = width.div_ceil(64).max(1) as usize;
            let product = |wants: &[(u64, u64)]| {
                let literals = (0..*width).filter_map(|i| {
                    let (zero, one) = wants[i as usize / 64];
                    let wanted = |word: u64| word >> (i % 64) & 1 == 1;
                    match (wanted(zero), wanted(one)) {
                        (false, false) => None,
                        (true, false) => Some(format!("{} !== 1'b1", bit(w, pin::unary::A, i))),
                        (false, true) => Some(format!("{} !== 1'b0", bit(w, pin::unary::A, i))),
                        // both at once: only what is unknown
                        (true, true) => Some(format!("{0} !== 1'b0 && {0} !== 1'b1", bit(w, pin::unary::A, i))),
                    }
                });
                let literals: Vec<String> = literals.collect();
                if literals.is_empty() { "1'b1".to_owned() } else { format!("({})", literals.join(" && ")) }
            };
            let all: Vec<String> = table.chunks_exact(words).map(product).collect();
            if all.is_empty() { "1'b0".to_owned() } else { all.join(" || ") }
        }
        CellKind::CarrySave { .. } => {
            let (a, b, c) = (of(w, ternary::A), of(w, ternary::B), of(w, ternary::C));
            w.assign(cell, 1, &format!("{a} ^ {b} ^ {c}"));
            // where any of the three is unknown, the carry is too
            let text = format!("(({a} & {b}) | ({c} & ({a} ^ {b}))) ^ (({a} ^ {b} ^ {c}) ^ ({a} ^ {b} ^ {c}))");
            return w.assign(cell, 0, &text);
        }
        CellKind::Carry { width } => {
            // the carries of an addition that generates and propagates at the same places; all x where p or g is
            let (p, g, ci) = (of(w, pin::carry::P), of(w, pin::carry::G), of(w, pin::carry::CI));
            let wide = |text: &str| format!("{{1'b0, {text}}}");
            let (into, sum) = (w.helper(cell, "into"), w.helper(cell, "sum"));
            let all = format!("{{{p}, {g}}}");
            let (p, g) = (wide(&format!("({p} | {g})")), wide(&g));
            w.line(format!("wire [{width}:0] {sum} = {p} + {g} + {{{}, {ci}}};", zeros(*width)));
            w.unused(&format!("wire [{width}:0] {into} = {sum} ^ {p} ^ {g};"));
            format!("{into}[{width}:1] ^ {}", repeat(*width, &format!("(^{all} ^ ^{all})")))
        }
        CellKind::Alu(shape) => return alu(w, cell, shape),
        CellKind::IsZero { width } => format!("~{}{}", if *width == 1 { "" } else { "|" }, of(w, pin::unary::A)),
        CellKind::Tristate { width } => {
            format!("{} ? {} : {width}'bz", of(w, pin::tristate::EN), of(w, pin::tristate::A))
        }
        CellKind::Constant(value) => literal(value),
        CellKind::Resolve { .. } => return,
        CellKind::Clock(clock) => return storage::clock(w, cell, *clock),
        CellKind::Delay { width, ticks, init } => return storage::delay(w, cell, *width, *ticks, init.as_deref()),
        CellKind::RcDelay(rc) => return storage::rc_delay(w, cell, *rc),
        CellKind::Memory(m) => return memory::write(w, cell, m),
        CellKind::Sr { .. }
        | CellKind::Latch(_)
        | CellKind::Flop(_)
        | CellKind::EdgeFlop(_)
        | CellKind::Counter(_)
        | CellKind::Accumulator(_) => return kind.storage().into_iter().for_each(|kind| storage::write(w, cell, kind)),
    };
    // the last output: the one before it, if there is one, is assigned already
    w.assign(cell, cell.outputs.len() - 1, &y);
}

/// `?:` by one bit of the select after another, x beyond the last input.
fn mux(width: u32, ins: &[String], lines: &[String], base: usize, bits: usize) -> String {
    if bits == 0 {
        return ins.get(base).cloned().unwrap_or_else(|| format!("{width}'bx"));
    }
    let half = base + (1 << (bits - 1));
    if half >= ins.len() && base >= ins.len() {
        return format!("{width}'bx");
    }
    let (low, high) = (mux(width, ins, lines, base, bits - 1), mux(width, ins, lines, half, bits - 1));
    let nested = |text: String| if text.contains('?') { format!("({text})") } else { text };
    format!("{} ? {} : {}", lines[bits - 1], nested(high), nested(low))
}

fn adder(w: &mut Writer<'_>, cell: &Cell, op: AddOp, width: u32) {
    let (a, b) = (w.input(cell, add::A), w.input(cell, add::B));
    let has = |pin: usize| cell.inputs.get(pin).is_some_and(|p| !storage::is_never(p));
    let carry = |w: &Writer<'_>, wide: u32, text: Option<String>| {
        let text = text.or_else(|| has(add::CI).then(|| w.input(cell, add::CI)));
        text.map(|ci| if wide == 1 { ci } else { format!("{{{}, {ci}}}", zeros(wide - 1)) })
    };
    let sign = if op == AddOp::Sub { "-" } else { "+" };
    let sum = |b: String, a: String, ci: Option<String>| match ci {
        Some(ci) => format!("{a} {sign} {b} {sign} {ci}"),
        None => format!("{a} {sign} {b}"),
    };
    let no_carry = Writer::is_open(cell, 1);
    let wide = |text: &str| format!("{{1'b0, {text}}}");
    if op != AddOp::AddSub || !has(add_sub::SUB) {
        if no_carry {
            let ci = carry(w, width, None);
            return w.assign(cell, 0, &sum(b, a, ci));
        }
        let all = w.helper(cell, "all");
        let ci = carry(w, width + 1, None);
        let declaration = format!("wire [{width}:0] {all} = {};", sum(wide(&b), wide(&a), ci));
        match Writer::is_open(cell, 0) {
            true => w.unused(&declaration),
            false => w.line(declaration),
        }
        w.assign(cell, 0, &format!("{all}[{}:0]", width - 1));
        return w.assign(cell, 1, &format!("{all}[{width}]"));
    }
    let sub = w.input(cell, add_sub::SUB);
    let inverted = format!("({b} ^ {})", repeat(width, &sub));
    let ci = if has(add::CI) { format!("({} ^ {sub})", w.input(cell, add::CI)) } else { sub.clone() };
    if no_carry {
        let ci = carry(w, width, Some(ci));
        return w.assign(cell, 0, &sum(inverted, a, ci));
    }
    let all = w.helper(cell, "all");
    let ci = carry(w, width + 1, Some(ci));
    let declaration = format!("wire [{width}:0] {all} = {};", sum(wide(&inverted), wide(&a), ci));
    match Writer::is_open(cell, 0) {
        true => w.unused(&declaration),
        false => w.line(declaration),
    }
    w.assign(cell, 0, &format!("{all}[{}:0]", width - 1));
    w.assign(cell, 1, &format!("{all}[{width}] ^ {sub}"));
}

/// Names an input pin, so that parts of it can be taken.
fn named(w: &mut Writer<'_>, cell: &Cell, pin: usize, signed: bool) -> String {
    let kind = w.kind(cell);
    let name = w.helper(cell, kind.inputs()[pin].name);
    let sign = if signed { "signed " } else { "" };
    let text = format!("wire {sign}{}{name} = {};", range(kind.input_width(pin)), w.input(cell, pin));
    w.unused(&text);
    name
}

fn shift(w: &mut Writer<'_>, cell: &Cell, op: ShiftOp, a_width: u32, b_width: u32, width: u32) -> String {
    let b = w.input(cell, binary::B);
    // as wide as operand and result
    let wide = a_width.max(width);
    let fill = |w: &mut Writer<'_>, signed: bool| {
        let a = named(w, cell, binary::A, false);
        let high = match (wide - a_width, signed) {
            (0, _) => return a,
            (n, true) if a_width == 1 => repeat(n, &a),
            (n, true) => repeat(n, &format!("{a}[{}]", a_width - 1)),
            (n, false) => zeros(n),
        };
        format!("{{{high}, {a}}}")
    };
    let cut = |w: &mut Writer<'_>, text: String| {
        if wide == width {
            return text;
        }
        let all = w.helper(cell, "all");
        w.unused(&format!("wire {}{all} = {text};", range(wide)));
        format!("{all}[{}:0]", width - 1)
    };
    match op {
        ShiftOp::Left => {
            let a = fill(w, false);
            cut(w, format!("{a} << {b}"))
        }
        ShiftOp::Right => {
            let a = fill(w, false);
            cut(w, format!("{a} >> {b}"))
        }
        ShiftOp::RightSigned => {
            let a = fill(w, true);
            cut(w, format!("$unsigned($signed({a}) >>> {b})"))
        }
        ShiftOp::Both => {
            let (a, b) = (fill(w, false), named(w, cell, binary::B, false));
            let top = if b_width == 1 { b.clone() } else { format!("{b}[{}]", b_width - 1) };
            // the negative of the most negative amount has a bit more
            cut(w, format!("{top} ? {a} << -{{1'b1, {b}}} : {a} >> {b}"))
        }
        ShiftOp::Part | ShiftOp::PartSigned => {
            let (a, b) = (named(w, cell, binary::A, false), named(w, cell, binary::B, op == ShiftOp::PartSigned));
            match a_width {
                // one bit cannot be indexed
                1 => {
                    let two = w.helper(cell, "vector");
                    w.unused(&format!("wire [1:0] {two} = {{1'bx, {a}}};"));
                    format!("{two}[{b} +: {width}]")
                }
                _ => format!("{a}[{b} +: {width}]"),
            }
        }
    }
}

fn divide(w: &mut Writer<'_>, cell: &Cell, op: DivideOp, width: u32, signed: bool) -> String {
    let (a, b) = (w.input(cell, binary::A), w.input(cell, binary::B));
    let sign = |text: &str| if signed { format!("$signed({text})") } else { text.to_owned() };
    let whole = |text: String| if signed { format!("$unsigned({text})") } else { text };
    let quotient = whole(format!("{} / {}", sign(&a), sign(&b)));
    let rest = whole(format!("{} % {}", sign(&a), sign(&b)));
    if !signed || matches!(op, DivideOp::Quotient | DivideOp::Remainder) {
        return if matches!(op, DivideOp::Quotient | DivideOp::Floor) { quotient } else { rest };
    }
    // rounded down: one less where there is a rest and the signs differ
    let (q, r) = (w.helper(cell, "quotient"), w.helper(cell, "rest"));
    let (a, b) = (named(w, cell, binary::A, false), named(w, cell, binary::B, false));
    let top = |x: &str| if width == 1 { x.to_owned() } else { format!("{x}[{}]", width - 1) };
    w.line(format!("wire {}{r} = {rest};", range(width)));
    let down = format!("(|{r} && ({} ^ {}))", top(&a), top(&b));
    if op == DivideOp::Floor {
        w.line(format!("wire {}{q} = {quotient};", range(width)));
        format!("{q} - {}", extended(width, &down))
    } else {
        format!("{r} + ({b} & {})", repeat(width, &down))
    }
}

fn extended(width: u32, bit: &str) -> String {
    if width == 1 { bit.to_owned() } else { format!("{{{}, {bit}}}", zeros(width - 1)) }
}

fn power(w: &mut Writer<'_>, cell: &Cell, width: u32, b_width: u32, a_signed: bool, b_signed: bool) -> String {
    let (a, b) = (named(w, cell, binary::A, false), named(w, cell, binary::B, false));
    let plain = format!("{a} ** {b}");
    if !b_signed {
        return plain;
    }
    // IEEE 1364-2005, table 5-6
    let top = |x: &str, n: u32| if n == 1 { x.to_owned() } else { format!("{x}[{}]", n - 1) };
    let low = |x: &str, n: u32| if n == 1 { x.to_owned() } else { format!("{x}[0]") };
    let one = extended(width, "1'b1");
    let minus = match a_signed {
        true => format!("&{a} ? ({} ? {a} : {one}) : ", low(&b, b_width)),
        false => String::new(),
    };
    let negative = format!("{a} == {} ? {width}'bx : {minus}{a} == {one} ? {one} : {}", zeros(width), zeros(width));
    format!("^{{{a}, {b}}} === 1'bx ? {width}'bx : {} ? ({negative}) : {plain}", top(&b, b_width))
}

fn alu(w: &mut Writer<'_>, cell: &Cell, alu: &crate::cell::Alu) {
    let n = alu.width;
    let operand = |w: &mut Writer<'_>, pin: usize, own: u32| {
        let name = named(w, cell, pin, false);
        let top = if own == 1 { name.clone() } else { format!("{name}[{}]", own - 1) };
        let text = match own {
            own if own == n => name.clone(),
            own if own > n => format!("{name}[{}:0]", n - 1),
            own if alu.signed => format!("{{{}, {name}}}", repeat(n - own, &top)),
            own => format!("{{{}, {name}}}", zeros(n - own)),
        };
        (name, text)
    };
    let (a, b) = (operand(w, pin::alu::A, alu.a_width), operand(w, pin::alu::B, alu.b_width));
    let (ci, bi) = (w.input(cell, pin::alu::CI), w.input(cell, pin::alu::BI));
    let (first, second) = (w.helper(cell, "first"), w.helper(cell, "second"));
    w.line(format!("wire [{n}:0] {first} = {{1'b0, {}}};", a.1));
    w.line(format!("wire [{n}:0] {second} = {{1'b0, {} ^ {}}};", b.1, repeat(n, &bi)));
    let (sum, into) = (w.helper(cell, "sum"), w.helper(cell, "into"));
    // what is cut off makes the sum x too
    let unknown = format!("(^{{{}, {}}} ^ ^{{{}, {}}})", a.0, b.0, a.0, b.0);
    w.unused(&format!(
        "wire [{n}:0] {sum} = {first} + {second} + {{{}, {ci}}} + {{{}, {unknown}}};",
        zeros(n),
        zeros(n)
    ));
    w.unused(&format!("wire [{n}:0] {into} = {sum} ^ {first} ^ {second};"));
    w.assign(cell, 0, &format!("{first}[{}:0] ^ {second}[{}:0]", n - 1, n - 1));
    w.assign(cell, 1, &format!("{sum}[{}:0]", n - 1));
    w.assign(cell, 2, &format!("{into}[{n}:1]"));
}
