//! What each flip-flop and latch is in Yosys' cells.
//!
//! Where Yosys has a cell of the same meaning it is that. Its `$aldff` and `$dffsr` differ in one thing: simulated, they
//! wait for the edge of a control; ours act by level, as the hardware that they are made into does. So they have an
//! attribute by which we know them again. What needs several cells is a module of its own.

use super::draw::{Draw, ONE};
use super::model::{Bit, Bits, Setting, constant};
use super::own::{Own, by_level};
use crate::cell::{CellKind, Edge, Flop};
use crate::{Logic, Value};

/// A control that loads at once.
pub struct Async {
    pub control: Bit,
    pub data: Bits,
}

fn polarity(on: bool) -> Setting {
    Setting::Value(Value::from_u64(u64::from(on), 1))
}

fn complement(d: &mut Draw, q: &[Bit], outs: &[Bits]) {
    if outs.get(1).is_some_and(|qn| d.is_used(qn)) {
        d.unary("qn", "$not", q, outs[1].clone());
    }
}

/// An SR flip-flop. Yosys' is dominated by its reset; one that is dominated by its set is that, inverted.
pub fn sr(d: &mut Draw, set_dominates: bool, init: &Value, ins: &[Bits], outs: &[Bits]) {
    if set_dominates && init.bit(0) == Logic::Z {
        // no inverter gives that
        let kind = CellKind::Sr { set_dominates, init: init.clone() };
        return Own::of(&kind, kind.element(), ins, outs, d).put(d, &kind, ins, outs);
    }
    let parameters =
        vec![("WIDTH", Setting::Number(1)), ("SET_POLARITY", polarity(true)), ("CLR_POLARITY", polarity(true))];
    let (set, reset) = (ins[0].clone(), ins[1].clone());
    if !set_dominates {
        let q = d.state(&outs[0], init);
        d.put("", "$sr", parameters, vec![("SET", set), ("CLR", reset)], vec![("Q", q)]);
    } else {
        let inverse = d.fresh("inverse", 1);
        let inverted = match init.bit(0) {
            Logic::Zero => Logic::One,
            Logic::One => Logic::Zero,
            _ => Logic::X,
        };
        let inverse = d.state(&inverse, &Value::repeat(inverted, 1));
        d.put("inverse", "$sr", parameters, vec![("SET", reset), ("CLR", set)], vec![("Q", inverse.clone())]);
        d.unary("", "$not", &inverse, outs[0].clone());
    }
    complement(d, &outs[0], outs);
}

/// A set or a reset of one bit that makes all bits one of its values.
fn all(value: &Value, bit: Logic) -> bool {
    value.bits().all(|b| b == bit)
}

/// A transparent latch.
pub fn latch(d: &mut Draw, f: &Flop, element: &'static str, ins: &[Bits], outs: &[Bits]) {
    let [en, data, set, reset] = ins else { return };
    let width = f.init.width();
    let mut parameters = vec![("WIDTH", Setting::Number(width)), ("EN_POLARITY", polarity(true))];
    let mut inputs = vec![("EN", en.clone()), ("D", data.clone())];
    let (set, reset) = (Draw::active(set), Draw::active(reset));
    let plain = all(&f.set_value, Logic::One) && all(&f.reset_value, Logic::Zero);
    if set.is_some() && reset.is_some() && !plain {
        let kind = CellKind::Latch(Box::new(f.clone()));
        return Own::of(&kind, element, ins, outs, d).put(d, &kind, ins, outs);
    }
    let outputs = vec![("Q", d.state(&outs[0], &f.init))];
    match (set, reset) {
        (None, None) => _ = d.put("", "$dlatch", parameters, inputs, outputs),
        (Some(set), Some(reset)) => {
            parameters.extend([("SET_POLARITY", polarity(true)), ("CLR_POLARITY", polarity(true))]);
            inputs.extend([("SET", vec![set; width as usize]), ("CLR", vec![reset; width as usize])]);
            d.put("", "$dlatchsr", parameters, inputs, outputs);
        }
        (set, reset) => {
            let value = if set.is_some() { &f.set_value } else { &f.reset_value };
            parameters.extend([("ARST_POLARITY", polarity(true)), ("ARST_VALUE", Setting::Value(value.clone()))]);
            inputs.push(("ARST", set.or(reset).into_iter().collect()));
            d.put("", "$adlatch", parameters, inputs, outputs);
        }
    }
    complement(d, &outs[0], outs);
}

/// A latch that is open while a bit is 1.
pub fn open_latch(d: &mut Draw, f: &Flop, en: Bit, data: &[Bit], q: &[Bit]) {
    let q = d.state(q, &f.init);
    let parameters = vec![("WIDTH", Setting::Number(q.len() as u32)), ("EN_POLARITY", polarity(true))];
    d.put("", "$dlatch", parameters, vec![("EN", vec![en]), ("D", data.to_vec())], vec![("Q", q)]);
}

/// A D flip-flop or register.
pub fn flop(d: &mut Draw, f: &Flop, element: &'static str, ins: &[Bits], outs: &[Bits]) {
    let [clk, data, aload, set, reset, en, sync_set, sync_reset] = ins else { return };
    let [aload, set, reset] = [aload, set, reset].map(|pin| Draw::active(pin));
    let synchronous = [sync_set, sync_reset].into_iter().filter(|pin| Draw::active(pin).is_some()).count();
    let q = &outs[0];
    let asynchronous = [aload, set, reset].iter().flatten().count();
    let both = (aload, set, reset, synchronous);
    let simple = match both {
        _ if asynchronous < 2 => aload.is_none() || synchronous == 0,
        (None, Some(_), Some(_), 0) => all(&f.set_value, Logic::One) && all(&f.reset_value, Logic::Zero),
        _ => false,
    };
    if !simple {
        let kind = CellKind::Flop(Box::new(f.clone()));
        return Own::of(&kind, element, ins, outs, d).put(d, &kind, ins, outs);
    }
    if let (Some(set), Some(reset)) = (set, reset) {
        let q = &d.state(q, &f.init);
        by_level(set_clear(d, f.edge, clk, data, &vec![set; q.len()], &vec![reset; q.len()], en, q));
    } else if asynchronous == 0 && synchronous == 1 {
        let (control, value) = match Draw::active(sync_set) {
            Some(bit) => (bit, &f.set_value),
            None => (sync_reset[0], &f.reset_value),
        };
        let q = d.state(q, &f.init);
        let (mut parameters, mut inputs) = clocked(f.edge, clk, data, en, &q);
        parameters.extend([("SRST_POLARITY", polarity(true)), ("SRST_VALUE", Setting::Value(value.clone()))]);
        inputs.push(("SRST", vec![control]));
        let kind = if Draw::always(en) { "$sdff" } else { "$sdffe" };
        d.put("", kind, parameters, inputs, vec![("Q", q)]);
    } else {
        let (loaded, enable) = self::synchronous(d, f, data, en, sync_set, sync_reset);
        let control = |control, data| Async { control, data };
        let load = aload.map(|bit| control(bit, data.clone()));
        let set = set.map(|bit| control(bit, constant(&f.set_value)));
        let reset = reset.map(|bit| control(bit, constant(&f.reset_value)));
        let controls: Vec<Async> = load.into_iter().chain(set).chain(reset).collect();
        with_controls(d, f, clk[0], (loaded, enable), &controls, q);
    }
    complement(d, &outs[0], outs);
}

/// Data and enable of a flip-flop with its synchronous set and reset in them. An unknown set or reset is inactive.
pub fn synchronous(d: &mut Draw, f: &Flop, data: &[Bit], en: &[Bit], set: &[Bit], reset: &[Bit]) -> (Bits, Bits) {
    let (mut data, mut en) = (data.to_vec(), en.to_vec());
    for (part, pin, value) in [("sync_set", set, &f.set_value), ("sync_reset", reset, &f.reset_value)] {
        let Some(control) = Draw::active(pin) else { continue };
        let control = d.is_one(&format!("{part}_is_1"), control);
        let next = d.fresh(part, data.len());
        d.mux(part, &data, &constant(value), control, next.clone());
        data = next;
        if !Draw::always(&en) {
            en = d.any(&format!("{part}_en"), &[en[0], control]).into_iter().collect();
        }
    }
    (data, en)
}

/// One control that loads for several, of which each is stronger than those before it.
pub fn one_load(d: &mut Draw, controls: &[Async]) -> (Option<Bit>, Bits) {
    let lines: Vec<Bit> = controls.iter().map(|c| c.control).collect();
    let mut data = controls.first().map_or(Bits::new(), |c| c.data.clone());
    for (i, stronger) in controls.iter().enumerate().skip(1) {
        let next = d.fresh(&format!("ad{i}"), data.len());
        d.mux(&format!("ad{i}"), &data, &stronger.data, stronger.control, next.clone());
        data = next;
    }
    (d.any("aload", &lines), data)
}

type Pins = (Vec<(&'static str, Setting)>, Vec<(&'static str, Bits)>);

/// What all flip-flops have.
fn clocked(edge: Edge, clk: &[Bit], data: &[Bit], en: &[Bit], q: &[Bit]) -> Pins {
    let mut parameters =
        vec![("WIDTH", Setting::Number(q.len() as u32)), ("CLK_POLARITY", polarity(edge == Edge::Rising))];
    let mut inputs = vec![("CLK", clk.to_vec()), ("D", data.to_vec())];
    if !Draw::always(en) {
        parameters.push(("EN_POLARITY", polarity(true)));
        inputs.push(("EN", en.to_vec()));
    }
    (parameters, inputs)
}

/// A flip-flop with data and enable, and asynchronous controls, the weakest first.
pub fn with_controls(d: &mut Draw, f: &Flop, clk: Bit, (data, en): (Bits, Bits), controls: &[Async], q: &[Bit]) {
    let q = &d.state(q, &f.init);
    let (mut parameters, mut inputs) = clocked(f.edge, &[clk], &data, &en, q);
    let always = Draw::always(&en);
    let outputs = vec![("Q", q.to_vec())];
    let values: Option<Vec<Logic>> = controls.first().and_then(|c| {
        let bits = c.data.iter().map(|bit| match bit {
            Bit::Constant(logic) => Some(*logic),
            Bit::Net(_) => None,
        });
        bits.collect()
    });
    match (controls, values) {
        ([], _) => _ = d.put("", if always { "$dff" } else { "$dffe" }, parameters, inputs, outputs),
        ([one], Some(values)) => {
            let mut value = Value::unknown(values.len() as u32);
            values.iter().enumerate().for_each(|(i, &bit)| value.set_bit(i as u32, bit));
            parameters.extend([("ARST_POLARITY", polarity(true)), ("ARST_VALUE", Setting::Value(value))]);
            inputs.push(("ARST", vec![one.control]));
            d.put("", if always { "$adff" } else { "$adffe" }, parameters, inputs, outputs);
        }
        _ => {
            let (load, ad) = one_load(d, controls);
            parameters.push(("ALOAD_POLARITY", polarity(true)));
            inputs.extend([("ALOAD", load.into_iter().collect()), ("AD", ad)]);
            by_level(d.put("", if always { "$aldff" } else { "$aldffe" }, parameters, inputs, outputs));
        }
    }
}

/// A flip-flop with a set and a clear for each bit.
#[expect(clippy::too_many_arguments, reason = "they are its pins")]
fn set_clear<'d>(
    d: &'d mut Draw,
    edge: Edge,
    clk: &[Bit],
    data: &[Bit],
    set: &[Bit],
    clear: &[Bit],
    en: &[Bit],
    q: &[Bit],
) -> &'d mut super::model::Cell {
    let (mut parameters, mut inputs) = clocked(edge, clk, data, en, q);
    parameters.extend([("SET_POLARITY", polarity(true)), ("CLR_POLARITY", polarity(true))]);
    inputs.extend([("SET", set.to_vec()), ("CLR", clear.to_vec())]);
    d.put("", if Draw::always(en) { "$dffsr" } else { "$dffsre" }, parameters, inputs, vec![("Q", q.to_vec())])
}

/// A flip-flop whose asynchronous controls act when they become active: Yosys' own.
pub fn edge_flop(d: &mut Draw, f: &Flop, element: &'static str, ins: &[Bits], outs: &[Bits]) {
    let [clk, data, ad, aload, set, reset, en] = ins else { return };
    let plain = (aload.is_empty(), set.is_empty(), reset.is_empty());
    match plain {
        (false, true, true) if !ad.is_empty() => {
            let q = d.state(&outs[0], &f.init);
            let (mut parameters, mut inputs) = clocked(f.edge, clk, data, en, &q);
            parameters.push(("ALOAD_POLARITY", polarity(true)));
            inputs.extend([("ALOAD", aload.clone()), ("AD", ad.clone())]);
            let kind = if Draw::always(en) { "$aldff" } else { "$aldffe" };
            d.put("", kind, parameters, inputs, vec![("Q", q)]);
        }
        (true, false, false) if all(&f.set_value, Logic::One) && all(&f.reset_value, Logic::Zero) => {
            let q = d.state(&outs[0], &f.init);
            let (set, clear) = (vec![set[0]; q.len()], vec![reset[0]; q.len()]);
            set_clear(d, f.edge, clk, data, &set, &clear, en, &q);
        }
        _ => {
            let kind = CellKind::EdgeFlop(Box::new(f.clone()));
            Own::of(&kind, element, ins, outs, d).put(d, &kind, ins, outs);
        }
    }
}

impl Draw<'_> {
    /// Whether an enable is always 1.
    pub fn always(en: &[Bit]) -> bool {
        en.first().is_none_or(|&bit| bit == ONE)
    }
}
