//! What names mean at one place of a module: parameters and indices, nets and ports.

use std::collections::HashMap;

use indexmap::IndexMap;

use super::{Names, Signal};
use crate::Value;
use crate::cell::element::Port;
use crate::diag::{Code, Diagnostic, Diagnostics, Span};
use crate::netlist::{Builder, Bus, SignalId};

/// A net or port.
#[derive(Clone, Debug)]
pub(super) struct Declared {
    pub signal: SignalId,
    pub bus: Bus,
    /// Where it is declared.
    pub span: Span,
    /// Whether its width could not be told, which is told already.
    pub faulty: bool,
}

/// Nets by name, those of a block hiding those around it.
#[derive(Debug)]
pub(super) struct Nets<'a> {
    pub own: HashMap<String, Declared>,
    pub outer: Option<&'a Nets<'a>>,
}

impl Nets<'_> {
    pub fn get(&self, name: &str) -> Option<&Declared> {
        self.own.get(name).or_else(|| self.outer?.get(name))
    }

    pub fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.own.keys().map(String::as_str).collect();
        names.extend(self.outer.map(Nets::names).unwrap_or_default());
        names.sort_unstable();
        names
    }
}

/// Why a signal has no bits: the faults are recorded, and the nets that it names are not to be complained of further.
#[derive(Debug)]
pub(super) struct Faulty;

/// Reads signals at one place of a module.
pub(super) struct Reader<'a> {
    pub nets: &'a Nets<'a>,
    pub values: &'a IndexMap<String, i64>,
    pub builder: &'a mut Builder,
    pub diagnostics: &'a mut Diagnostics,
    /// The widest bus that is allowed.
    pub most_bits: u64,
    /// The most bits that there may be of everything.
    pub most_in_all: u64,
}

impl Reader<'_> {
    /// The bits of a signal. `width` is that of the port, which a plain number takes on.
    pub fn bus(&mut self, signal: &Signal, width: Option<u32>) -> Result<Bus, Faulty> {
        let result = self.read(signal, width);
        result.map_err(|d| {
            if let Some(d) = d {
                self.diagnostics.push(*d);
            }
            Faulty
        })
    }

    fn number(&self, expr: &super::Expr) -> Result<i64, Option<Box<Diagnostic>>> {
        expr.eval(self.values).map_err(|d| Some(Box::new(d)))
    }

    fn net(&self, name: &super::Name) -> Result<Declared, Option<Box<Diagnostic>>> {
        let found = self.nets.get(name).cloned();
        if found.as_ref().is_some_and(|net| net.faulty) {
            return Err(None);
        }
        found.ok_or_else(|| {
            let names = self.nets.names();
            let fault = Diagnostic::new(Code::UnknownNet, format!("there is no net or port `{}` here", name.value))
                .at(name.span, "not declared");
            Some(Box::new(fault.did_you_mean(name, names)))
        })
    }

    fn read(&mut self, signal: &Signal, width: Option<u32>) -> Result<Bus, Option<Box<Diagnostic>>> {
        let fail = |d: Diagnostic| Err(Some(Box::new(d)));
        match signal {
            Signal::Name { name, .. } => Ok(self.net(name)?.bus),
            Signal::Select { name, index, .. } => {
                let at = self.number(index)?;
                let net = self.net(name)?;
                self.slice(name, &net, (at, at), &self.with(index), index.span())
            }
            Signal::Slice { name, hi, lo, .. } => {
                let (high, low) = (self.number(hi)?, self.number(lo)?);
                let net = self.net(name)?;
                let with = format!("{}{}", self.with(hi), if hi == lo { String::new() } else { self.with(lo) });
                self.slice(name, &net, (high, low), &with, hi.span().to(lo.span()))
            }
            Signal::Constant(constant) => {
                let size = self.number(&constant.size)?;
                if u64::try_from(size).is_ok_and(|size| size > self.most_bits) {
                    return Err(Some(Box::new(self.too_wide("a constant", size as u64, constant.size.span()))));
                }
                let value = constant.constant(size).map_err(|d| Some(Box::new(d)))?;
                self.constant(&value, constant.span)
            }
            Signal::Repeat { count, of, .. } => {
                let times = self.number(count)?;
                let bus = self.read(of, None)?;
                let total = u64::try_from(times).unwrap_or(0).saturating_mul(u64::from(bus.width()));
                if times < 1 {
                    return fail(
                        Diagnostic::new(Code::BadSignal, format!("a signal cannot be repeated {times} times"))
                            .at(count.span(), format!("this is {times}")),
                    );
                }
                if total > self.most_bits {
                    return fail(self.too_wide("a repetition", total, count.span()));
                }
                Ok(Bus::concat(std::iter::repeat_n(&bus, times as usize)))
            }
            Signal::Concat { parts, span } => {
                if parts.is_empty() {
                    return fail(
                        Diagnostic::new(Code::BadSignal, "a concatenation of nothing").at(*span, "name a signal"),
                    );
                }
                let mut all = Vec::new();
                let mut faulty = false;
                let mut total = 0;
                for part in parts {
                    if let Signal::Number { value, span } = part {
                        self.diagnostics.push(
                            Diagnostic::new(Code::BadSignal, "a number within a concatenation has no width")
                                .at(*span, "how many bits?")
                                .help(format!("write \"4'd{value}\" with the width that is meant")),
                        );
                        faulty = true;
                        continue;
                    }
                    match self.bus(part, None) {
                        Ok(bus) => {
                            total += u64::from(bus.width());
                            all.push(bus);
                        }
                        Err(Faulty) => faulty = true,
                    }
                    // before more memory is taken
                    if total > self.most_bits {
                        return fail(self.too_wide("a concatenation", total, part.span()));
                    }
                }
                if faulty {
                    return Err(None);
                }
                Ok(Bus::concat(all.iter().rev()))
            }
            Signal::Number { value, span } => {
                let Some(width) = width else {
                    return fail(
                        Diagnostic::new(Code::BadSignal, "a number has no width here").at(*span, "how many bits?"),
                    );
                };
                match Value::for_width(&value.to_string(), width) {
                    Ok(value) => self.constant(&value, *span),
                    Err(e) => fail(
                        Diagnostic::new(Code::WidthMismatch, e.to_string())
                            .at(*span, format!("the port is {width} bit{} wide", s(width))),
                    ),
                }
            }
        }
    }

    /// A signal that is wider than is allowed.
    fn too_wide(&self, what: &str, bits: u64, place: Span) -> Diagnostic {
        Diagnostic::new(Code::TooLarge, format!("{what} comes to {bits} bits, the limit is {}", self.most_bits))
            .at(place, format!("{bits} bits up to here"))
            .help("if you need that, raise the limit: `--limit width=BITS`")
    }

    fn constant(&mut self, value: &Value, place: Span) -> Result<Bus, Option<Box<Diagnostic>>> {
        if u64::from(self.builder.bit_count()) + u64::from(value.width()) > self.most_in_all {
            let message = format!("the circuit passes the limit of {} bits of all nets together", self.most_in_all);
            return Err(Some(Box::new(
                Diagnostic::new(Code::TooLarge, message)
                    .at(place, "with this constant")
                    .help("if you need that, raise the limit: `--limit bits=BITS`"),
            )));
        }
        Ok(self.builder.constant(value))
    }

    /// The indices of `repeat` and the parameters that an expression uses, with their values, for a label.
    fn with(&self, expr: &super::Expr) -> String {
        let used = expr.names().into_iter().filter_map(|n| Some(format!("{n} = {}", self.values.get(n)?)));
        let used: Vec<String> = used.collect();
        if used.is_empty() || expr.as_name().is_some() { String::new() } else { format!(" with {}", used.join(", ")) }
    }

    fn slice(
        &self,
        name: &super::Name,
        net: &Declared,
        (high, low): (i64, i64),
        with: &str,
        place: Span,
    ) -> Result<Bus, Option<Box<Diagnostic>>> {
        let width = i64::from(net.bus.width());
        let fault = if high < low {
            Diagnostic::new(
                Code::IndexOutOfRange,
                format!("a slice goes from the high bit to the low one, not [{high}:{low}]"),
            )
            .at(place, format!("this is [{high}:{low}]{with}"))
            .help(format!("the bits are numbered from 0 at the low end: write [{low}:{high}]"))
        } else if low < 0 || high >= width {
            let bits = if high == low { format!("bit {high}") } else { format!("bits {high} to {low}") };
            Diagnostic::new(Code::IndexOutOfRange, format!("`{}` has no {bits}", name.value))
                .at(
                    place,
                    if high == low { format!("this is {high}{with}") } else { format!("this is [{high}:{low}]{with}") },
                )
                .also(net.span, format!("declared with {width} bit{}, {} to 0", s(net.bus.width()), width - 1))
        } else {
            return Ok(net.bus.slice(low as u32, (high - low + 1) as u32));
        };
        Err(Some(Box::new(fault)))
    }

    /// The inputs of a port that takes several, one after another, and how many there are.
    /// `why` adds where the width of each comes from.
    pub fn several(
        &mut self,
        port: &Port,
        signal: &Signal,
        width: u32,
        why: &dyn Fn(Diagnostic) -> Diagnostic,
    ) -> Result<(Bus, u32), Faulty> {
        let Signal::Concat { parts, span } = signal else {
            let bus = self.bus(signal, None)?;
            if width == 1 {
                let inputs = bus.width();
                return Ok((bus, inputs));
            }
            self.diagnostics.push(
                Diagnostic::new(
                    Code::WidthMismatch,
                    format!("`{}` takes an array with one member for each input", port.name),
                )
                .at(
                    signal.span(),
                    format!("one signal of {} bit{}; each input has {width}", bus.width(), s(bus.width())),
                )
                .help("write [\"first\", \"second\", …]"),
            );
            return Err(Faulty);
        };
        if parts.is_empty() {
            self.diagnostics.push(
                Diagnostic::new(Code::UnconnectedPort, format!("`{}` has no inputs", port.name))
                    .at(*span, "name the inputs here"),
            );
            return Err(Faulty);
        }
        if parts.len() as u64 * u64::from(width) > self.most_in_all {
            let message = format!("{} inputs of {width} bits pass the limit of {} bits", parts.len(), self.most_in_all);
            let fault = Diagnostic::new(Code::TooLarge, message).at(*span, "these inputs");
            self.diagnostics.push(fault.help("if you need that, raise the limit: `--limit bits=BITS`"));
            return Err(Faulty);
        }
        let mut all = Vec::new();
        let mut faulty = false;
        for (i, part) in parts.iter().enumerate() {
            match self.bus(part, Some(width)) {
                Ok(bus) if bus.width() == width => all.push(bus),
                Ok(bus) => {
                    faulty = true;
                    let fault = Diagnostic::new(
                        Code::WidthMismatch,
                        format!(
                            "input {i} of `{}` is {width} bit{} wide, but this signal is {}",
                            port.name,
                            s(width),
                            bus.width()
                        ),
                    )
                    .at(part.span(), format!("{} bit{}", bus.width(), s(bus.width())));
                    let mut fault = self.where_from(part, fault);
                    if parts.len() == 1 && width == 1 {
                        fault = fault.help("without the array, every bit of the signal is one input");
                    } else if bus.width() == 1 {
                        let name = if let Signal::Name { name, .. } = part { &name.value } else { "…" };
                        fault = fault.help(format!("\"{width}{{{name}}}\" repeats a bit"));
                    }
                    self.diagnostics.push(why(fault));
                }
                Err(Faulty) => faulty = true,
            }
        }
        if faulty { Err(Faulty) } else { Ok((Bus::concat(&all), all.len() as u32)) }
    }

    /// Adds where the width of a signal comes from.
    pub fn where_from(&self, signal: &Signal, fault: Diagnostic) -> Diagnostic {
        let mut names = Vec::new();
        nets_of(signal, &mut names);
        names.iter().take(4).fold(fault, |d, name| match self.nets.get(name) {
            Some(net) => {
                d.also(net.span, format!("`{}` is declared with {} bit{}", name, net.bus.width(), s(net.bus.width())))
            }
            None => d,
        })
    }
}

/// The names of the nets in a signal, each once.
pub(super) fn nets_of<'s>(signal: &'s Signal, names: &mut Vec<&'s str>) {
    match signal {
        Signal::Name { name, .. } | Signal::Select { name, .. } | Signal::Slice { name, .. } => {
            if !names.contains(&name.value.as_str()) {
                names.push(name);
            }
        }
        Signal::Repeat { of, .. } => nets_of(of, names),
        Signal::Concat { parts, .. } => parts.iter().for_each(|p| nets_of(p, names)),
        Signal::Constant(_) | Signal::Number { .. } => {}
    }
}

/// Whether a signal holds a constant.
pub(super) fn constant_in(signal: &Signal) -> Option<Span> {
    match signal {
        Signal::Constant(c) => Some(c.span),
        Signal::Number { span, .. } => Some(*span),
        Signal::Repeat { of, .. } => constant_in(of),
        Signal::Concat { parts, .. } => parts.iter().find_map(constant_in),
        _ => None,
    }
}

/// The plural ending.
pub(super) fn s(n: u32) -> &'static str {
    if n == 1 { "" } else { "s" }
}

/// The value of an expression, or the fault recorded.
pub(super) fn eval(expr: &super::Expr, values: &dyn Names, diagnostics: &mut Diagnostics) -> Option<i64> {
    expr.eval(values).map_err(|d| diagnostics.push(d)).ok()
}
