//! Flip-flops and latches, of words by their parameters and of one bit by their names.
//!
//! Negative polarities are inverters, the clock's its edge. A set and a reset for each bit make a cell for each bit. Where
//! `simlib.v` waits for edges of several controls of which one loads what changes, or of which one may stay when
//! another goes, so does the cell ([`CellKind::EdgeFlop`]); elsewhere levels give the same.

use super::{Fault, Lower, Site, own};
use crate::cell::{CellKind, CompareOp, Edge, Flop, GateOp};
use crate::netlist::Bus;
use crate::{Logic, Value};

/// A control: its port, and whether it acts while 1.
type Control = Option<(&'static str, bool)>;

/// What a storage cell has. Ports are named as the cell names them.
#[derive(Clone, Default, Debug, PartialEq)]
pub(crate) struct Store {
    clock: Control,
    enable: Control,
    async_reset: Control,
    sync_reset: Control,
    /// The enable decides about the synchronous reset too.
    enable_first: bool,
    load: Control,
    set: Control,
    clear: Control,
    /// What a reset loads, repeated if it is shorter than the cell.
    reset_value: Option<Value>,
    /// No clock: open while enabled.
    latch: bool,
    /// Neither clock nor data.
    sr: bool,
}

/// A cell of one bit, if that is what the name says: `$_SDFFCE_PN0P_`.
pub(super) fn gate(name: &str) -> Option<Store> {
    let name = name.strip_prefix("$_")?.strip_suffix('_')?;
    let (family, letters) = name.split_once('_').unwrap_or((name, ""));
    let mut letters = letters.chars();
    let polarity = |letter: Option<char>| match letter? {
        'P' => Some(true),
        'N' => Some(false),
        _ => None,
    };
    macro_rules! control {
        ($port:literal) => {
            Some(($port, polarity(letters.next())?))
        };
    }
    let mut store = Store::default();
    let reset_value = |letter: Option<char>| match letter? {
        '0' => Some(Some(Value::from_u64(0, 1))),
        '1' => Some(Some(Value::from_u64(1, 1))),
        _ => None,
    };
    match family {
        "FF" => {}
        "SR" => {
            store.sr = true;
            (store.set, store.clear) = (control!("S"), control!("R"));
        }
        "DFF" | "DFFE" => {
            store.clock = control!("C");
            let plain = if family == "DFF" { 0 } else { 1 };
            if letters.clone().count() > plain {
                store.async_reset = control!("R");
                store.reset_value = reset_value(letters.next())?;
            }
            if plain == 1 {
                store.enable = control!("E");
            }
        }
        "SDFF" | "SDFFE" | "SDFFCE" => {
            store.clock = control!("C");
            store.sync_reset = control!("R");
            store.reset_value = reset_value(letters.next())?;
            if family != "SDFF" {
                store.enable = control!("E");
            }
            store.enable_first = family == "SDFFCE";
        }
        "ALDFF" | "ALDFFE" => {
            (store.clock, store.load) = (control!("C"), control!("L"));
            if family == "ALDFFE" {
                store.enable = control!("E");
            }
        }
        "DFFSR" | "DFFSRE" => {
            (store.clock, store.set, store.clear) = (control!("C"), control!("S"), control!("R"));
            if family == "DFFSRE" {
                store.enable = control!("E");
            }
        }
        "DLATCH" => {
            store.latch = true;
            store.enable = control!("E");
            if letters.clone().next().is_some() {
                store.async_reset = control!("R");
                store.reset_value = reset_value(letters.next())?;
            }
        }
        "DLATCHSR" => {
            store.latch = true;
            (store.enable, store.set, store.clear) = (control!("E"), control!("S"), control!("R"));
        }
        _ => return None,
    }
    letters.next().is_none().then_some(store)
}

/// The cells of words.
pub(super) fn find(name: &str) -> Option<Lower> {
    macro_rules! store {
        ($($part:ident)*) => {
            |s| {
                let store = Store::default()$(.$part(s))*;
                lower(s, store)
            }
        };
    }
    Some(match name {
        "$ff" => store!(),
        "$sr" => store!(no_data set_clear),
        "$dff" => store!(clocked),
        "$dffe" => store!(clocked enabled),
        "$dffsr" => store!(clocked set_clear),
        "$dffsre" => store!(clocked set_clear enabled),
        "$adff" => store!(clocked reset),
        "$adffe" => store!(clocked reset enabled),
        "$aldff" => store!(clocked loaded),
        "$aldffe" => store!(clocked loaded enabled),
        "$sdff" => store!(clocked synchronous),
        "$sdffe" => store!(clocked synchronous enabled),
        "$sdffce" => store!(clocked synchronous enabled chip_enable),
        "$dlatch" => store!(opened enabled),
        "$adlatch" => store!(opened enabled reset),
        "$dlatchsr" => store!(opened enabled set_clear),
        _ => return None,
    })
}

impl Store {
    fn clocked(mut self, s: &Site) -> Store {
        self.clock = Some(("CLK", s.positive("CLK_POLARITY")));
        self
    }
    fn opened(mut self, _: &Site) -> Store {
        self.latch = true;
        self
    }
    fn no_data(mut self, _: &Site) -> Store {
        self.sr = true;
        self
    }
    fn enabled(mut self, s: &Site) -> Store {
        self.enable = Some(("EN", s.positive("EN_POLARITY")));
        self
    }
    fn set_clear(mut self, s: &Site) -> Store {
        self.set = Some(("SET", s.positive("SET_POLARITY")));
        self.clear = Some(("CLR", s.positive("CLR_POLARITY")));
        self
    }
    fn loaded(mut self, s: &Site) -> Store {
        self.load = Some(("ALOAD", s.positive("ALOAD_POLARITY")));
        self
    }
    fn reset(mut self, s: &Site) -> Store {
        self.async_reset = Some(("ARST", s.positive("ARST_POLARITY")));
        self.reset_value = Some(s.sized("ARST_VALUE", s.written("Q").len() as u32));
        self
    }
    fn synchronous(mut self, s: &Site) -> Store {
        self.sync_reset = Some(("SRST", s.positive("SRST_POLARITY")));
        self.reset_value = Some(s.sized("SRST_VALUE", s.written("Q").len() as u32));
        self
    }
    fn chip_enable(mut self, _: &Site) -> Store {
        self.enable_first = true;
        self
    }
}

/// A control of one bit as it acts while 1; nothing where the cell has none.
fn control(s: &mut Site, control: Control) -> Result<Bus, Fault> {
    let Some((port, positive)) = control else { return Ok(Bus::default()) };
    let bit = s.bit(port)?;
    match s.written(port)[0].constant() {
        Some(constant) if !positive => {
            let inverse = match constant {
                Logic::Zero => Logic::One,
                Logic::One => Logic::Zero,
                Logic::X | Logic::Z => Logic::X,
            };
            Ok(s.constant(inverse, 1))
        }
        None if !positive => Ok(s.invert(&bit)),
        _ => Ok(bit),
    }
}

/// One bit of a control that has one for each bit of the cell.
fn bit_of(s: &mut Site, control: Control, width: u32, i: u32) -> Result<Bus, Fault> {
    let Some((port, positive)) = control else { return Ok(Bus::default()) };
    let bus = s.input(port);
    s.expect_width(port, bus.width(), width)?;
    let bit = bus.bit(i);
    Ok(if positive { bit } else { s.invert(&bit) })
}

pub(super) fn lower(s: &mut Site, store: Store) -> Result<(), Fault> {
    let q = s.output("Q");
    let width = q.width();
    if width == 0 {
        return Ok(());
    }
    let mut init = Value::unknown(width);
    for (i, bit) in s.written("Q").iter().enumerate() {
        init.set_bit(i as u32, s.import.init(s.here, *bit));
    }
    let d = if store.sr { Bus::default() } else { s.input("D") };
    if !store.sr {
        s.expect_width("D", d.width(), width)?;
    }
    if store.set.is_some() {
        return (0..width).try_for_each(|i| one_of_several(s, &store, &d, &q, &init, i));
    }
    let edge = match store.clock {
        Some((_, false)) => Edge::Falling,
        _ => Edge::Rising,
    };
    let reset_value = store.reset_value.clone().unwrap_or_else(|| Value::unknown(width));
    let flop = Box::new(Flop { edge, set_value: Value::unknown(width), reset_value, init });
    let open = Bus::default;
    let (reset, mut sync_reset) = (control(s, store.async_reset)?, control(s, store.sync_reset)?);
    let enable = control(s, store.enable)?;
    let Some((clock, _)) = store.clock else {
        if store.latch {
            s.cell(CellKind::Latch(flop), vec![enable, d, open(), reset], vec![q]);
        } else {
            // one step of the global clock is one tick
            let init = Some(Box::new(flop.init));
            s.cell(CellKind::Delay { width, ticks: 1, init }, vec![d], vec![q]);
        }
        return Ok(());
    };
    let clock = s.bit(clock)?;
    if store.load.is_some() {
        let (ad, load) = (s.input("AD"), control(s, store.load)?);
        s.expect_width("AD", ad.width(), width)?;
        if s.is_own(own::LEVEL) {
            // one data pin has both
            let data = if ad == d {
                d
            } else {
                let (one, loads, data) = (s.constant(Logic::One, 1), s.spare(1), s.spare(width));
                let same = CellKind::Compare { op: CompareOp::Same, width: 1, signed: false };
                s.helper("loads", same, vec![load.clone(), one], vec![loads.clone()]);
                let mux = CellKind::Mux { width, inputs: 2 };
                s.helper("data", mux, vec![Bus::concat([&d, &ad]), loads], vec![data.clone()]);
                data
            };
            s.cell(CellKind::Flop(flop), vec![clock, data, load, open(), open(), enable], vec![q]);
            return Ok(());
        }
        s.cell(CellKind::EdgeFlop(flop), vec![clock, d, ad, load, open(), open(), enable], vec![q]);
        return Ok(());
    }
    if store.enable_first {
        sync_reset = s.gate("reset", GateOp::And, 1, &[&sync_reset, &enable]);
    }
    s.cell(CellKind::Flop(flop), vec![clock, d, open(), open(), reset, enable, open(), sync_reset], vec![q]);
    Ok(())
}

/// Bit `i` of a cell with a set and a clear for each bit.
fn one_of_several(s: &mut Site, store: &Store, d: &Bus, q: &Bus, init: &Value, i: u32) -> Result<(), Fault> {
    let width = q.width();
    let (set, clear) = (bit_of(s, store.set, width, i)?, bit_of(s, store.clear, width, i)?);
    let enable = control(s, store.enable)?;
    let mut first = Value::unknown(1);
    first.set_bit(0, init.bit(i));
    let name = if width == 1 { s.cell.name.to_string() } else { format!("{}[{i}]", s.cell.name) };
    let edge = if matches!(store.clock, Some((_, false))) { Edge::Falling } else { Edge::Rising };
    let flop = Flop { edge, set_value: Value::from_u64(1, 1), reset_value: Value::from_u64(0, 1), init: first };
    let (kind, inputs) = match store.clock {
        _ if store.sr => (CellKind::Sr { set_dominates: false, init: flop.init }, vec![set, clear]),
        Some((clock, _)) => {
            let open = Bus::default;
            let clock = s.bit(clock)?;
            if s.is_own(own::LEVEL) {
                (CellKind::Flop(Box::new(flop)), vec![clock, d.bit(i), open(), set, clear, enable])
            } else {
                let inputs = vec![clock, d.bit(i), open(), open(), set, clear, enable];
                (CellKind::EdgeFlop(Box::new(flop)), inputs)
            }
        }
        None => (CellKind::Latch(Box::new(flop)), vec![enable, d.bit(i), set, clear]),
    };
    s.import.builder.cell(s.here.scope, &name, kind, inputs, vec![q.bit(i)]);
    Ok(())
}
