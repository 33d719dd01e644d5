//! `discreta why`: where the value of a net comes from.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value as Json, json};

use super::args::{EngineArgs, EngineChoice, Format, WaveArgs, WhyArgs, XControl};
use super::loading::{faults, loader};
use super::prepare::{Changes, Prepared, prepare, ticks};
use super::report::{shown, time};
use super::simulate::{Extras, observed};
use super::{CliError, Out, Status, interrupt};
use crate::elaborate::Loader;
use crate::netlist::{CellId, NetId, Netlist, SignalId, Slice};
use crate::why::{Cause, Control, Culprit, End, History, Link, Read, Seen, chain, cone, differ};
use crate::{Logic, Value};

/// Runs the command.
///
/// # Errors
/// Faults of the circuit or scenario, a net or time that is not there.
pub fn run(args: &WhyArgs, out: &mut Out) -> Result<Status, CliError> {
    let [files @ .., net] = &args.words[..] else { return Err(CliError::usage("name a circuit and a net")) };
    let [circuit, more @ ..] = files else { return Err(CliError::usage("name a circuit and a net")) };
    let net = net.to_string_lossy();
    let mut loader = loader(&args.elaboration, more)?;
    let wave = WaveArgs {
        stimulus: args.expect.clone().or_else(|| args.stimulus.clone()),
        scope: args.scope.clone(),
        expect: args.expect.is_some(),
        ignore: Vec::new(),
        ignore_x: args.ignore_x,
        first: args.first.clone(),
    };
    let wave = wave.stimulus.is_some().then_some(&wave);
    let changes = Changes { wave, ..Changes::of(&args.elaboration, &args.scenario, &[]) };
    let prepared = prepare(&mut loader, circuit, &changes);
    let mut prepared = faults(&mut loader, prepared)?;
    let (signal, slices) = bits(&prepared.circuit.netlist, &net)?;
    let at = args.at.as_deref().map(|text| ticks(&prepared.circuit, &mut loader, "--at", text)).transpose()?;
    if let Some(at) = at {
        prepared.scenario.limit = prepared.scenario.limit.min(at);
        prepared.scenario.until = None;
        prepared.scenario.limit_given = true;
    }
    // what is looked for is told; what else is expected is not
    prepared.scenario.expect.clear();
    prepared.scenario.checks.clear();
    prepared.scenario.monitors.clear();

    interrupt::watch();
    let nets = cone(&prepared.circuit.netlist, &slices);
    let golden = match &mut prepared.replay {
        Some(replay) if args.expect.is_some() => {
            let netlist = &prepared.circuit.netlist;
            replay.golden(|signal| netlist.bits(signal).iter().any(|slice| nets.contains(&slice.net)))?
        }
        _ => crate::scenario::replay::Golden::new(),
    };
    let mut history = History::of(nets);
    let engine = EngineArgs { engine: EngineChoice::Event, x_control: XControl::Ignore };
    let mut extras = Extras { observers: vec![&mut history], ..Extras::default() };
    let (outcome, _) = observed(&mut prepared, &loader, &engine, None, &mut extras, "running")?;
    if history.full {
        return Err(
            CliError::usage("the run is too long to be kept whole").with_hint("end it sooner: --at, --time, --cycles")
        );
    }
    let at_end = at.unwrap_or(outcome.time);
    if at_end > outcome.time {
        let end = time(&prepared.circuit.netlist, outcome.time);
        return Err(CliError::usage(format!(
            "the run ends at {end}, before {}",
            args.at.as_deref().unwrap_or_default()
        )));
    }
    let mut tell = Tell { prepared: &prepared, loader: &mut loader, history: &history };
    let loose = prepared.replay.as_ref().map_or([false; 2], |replay| replay.loose());
    if args.expect.is_some() {
        let netlist = &prepared.circuit.netlist;
        if !golden.contains_key(&signal) {
            let known = golden.keys().map(|&s| netlist.signal_path(s)).min();
            let hint =
                known.map_or_else(|| "name an output".to_owned(), |name| format!("it has, for example, `{name}`"));
            return Err(
                CliError::usage(format!("the waveform has no net `{}`", netlist.signal_path(signal))).with_hint(hint)
            );
        }
        let found = differ(netlist, &history, &golden, loose, signal, at);
        let status = Status::of(found.is_none());
        match args.format.format {
            Format::Text => out.write_fmt(format_args!("{}", tell.difference(&net, at, found.as_ref())))?,
            Format::Json => out.json(&tell.difference_json(&net, found.as_ref()))?,
        }
        return Ok(status);
    }
    let slice = interesting(&history, &slices, at_end);
    // what is x has one origin, what is known has ever earlier ones
    let lost = history.at(slice, at_end).bits().any(is_unknown);
    let steps = args.steps.unwrap_or(if lost { 1000 } else { 12 });
    let (links, end) = chain(&prepared.circuit.netlist, &history, slice, at_end, steps);
    match args.format.format {
        Format::Text => out.write_fmt(format_args!("{}", tell.chain(&net, &slices, at_end, &links, end)))?,
        Format::Json => out.json(&tell.chain_json(&net, &slices, at_end, &links, end))?,
    }
    Ok(Status::Done)
}

/// The signal that a text names, and its bits or those that it picks.
fn bits(netlist: &Netlist, text: &str) -> Result<(SignalId, Vec<Slice>), CliError> {
    let text = text.trim().trim_start_matches('\\');
    if let Some(signal) = netlist.find(text) {
        return Ok((signal, netlist.bits(signal).to_vec()));
    }
    let part = text.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    if let Some((signal, range)) = part.and_then(|(stem, range)| Some((netlist.find(stem)?, range))) {
        let (from, to) = range.split_once(':').unwrap_or((range, range));
        let bit = |index: &str| netlist.signal(signal).bit(index.trim().parse().ok()?);
        if let (Some(from), Some(to)) = (bit(from), bit(to)) {
            let wanted = from.min(to)..=from.max(to);
            let all = netlist.bits(signal).iter().flat_map(|s| (s.lo..s.lo + s.width).map(|lo| (s.net, lo)));
            let picked = all.enumerate().filter(|(i, _)| wanted.contains(&(*i as u32)));
            let slices = picked.map(|(_, (net, lo))| Slice { net, lo, width: 1 });
            return Ok((signal, joined(slices)));
        }
        return Err(CliError::usage(format!("`{}` has no bits [{range}]", netlist.signal_path(signal))));
    }
    let names: Vec<String> = netlist.signal_ids().map(|s| netlist.signal_path(s)).collect();
    let error = CliError::usage(format!("the circuit has no net `{text}`"));
    Err(match crate::diag::nearest(text, names.iter().map(String::as_str)) {
        Some(near) => error.with_hint(format!("did you mean `{near}`?")),
        None => error.with_hint("a net is named by its path below the top module, as in `u1.q`"),
    })
}

/// Slices with neighbours joined.
fn joined(slices: impl Iterator<Item = Slice>) -> Vec<Slice> {
    let mut all: Vec<Slice> = Vec::new();
    for slice in slices {
        match all.last_mut() {
            Some(last) if last.net == slice.net && last.lo + last.width == slice.lo => last.width += slice.width,
            _ => all.push(slice),
        }
    }
    all
}

fn is_unknown(bit: Logic) -> bool {
    matches!(bit, Logic::X | Logic::Z)
}

/// Of several slices the first run of bits that are x or z, else that which changed last.
fn interesting(history: &History, slices: &[Slice], time: u64) -> Slice {
    for slice in slices {
        let value = history.at(*slice, time);
        if let Some(from) = (0..slice.width).find(|&bit| is_unknown(value.bit(bit))) {
            let width = (from..slice.width).take_while(|&bit| is_unknown(value.bit(bit))).count() as u32;
            return Slice { net: slice.net, lo: slice.lo + from, width };
        }
    }
    *slices.iter().rev().max_by_key(|slice| history.since(**slice, time)).unwrap_or(&slices[0])
}

/// Writes down what was found.
struct Tell<'t> {
    prepared: &'t Prepared,
    loader: &'t mut Loader,
    history: &'t History,
}

impl Tell<'_> {
    fn netlist(&self) -> &Netlist {
        &self.prepared.circuit.netlist
    }

    fn time(&self, ticks: u64) -> String {
        time(self.netlist(), ticks)
    }

    /// The signal that shows all of a slice, nearest to the top, and which bits of it; one that a tool made up at last.
    fn signal(&self, slice: Slice) -> Option<(SignalId, u32)> {
        let netlist = self.netlist();
        let place = |signal: SignalId| {
            let mut at = 0;
            for part in netlist.bits(signal) {
                let within =
                    part.net == slice.net && part.lo <= slice.lo && slice.lo + slice.width <= part.lo + part.width;
                if within {
                    return Some((signal, at + slice.lo - part.lo));
                }
                at += part.width;
            }
            None
        };
        let found = netlist.signal_ids().filter_map(place);
        found.min_by_key(|(signal, _)| {
            let s = netlist.signal(*signal);
            (s.hidden, netlist.scope_path(s.scope).len(), s.name.len())
        })
    }

    /// The name of a slice: a signal or bits of one; none for what has none that people gave.
    fn name(&self, slice: Slice) -> Option<String> {
        let netlist = self.netlist();
        let (signal, lo) = self.signal(slice)?;
        let s = netlist.signal(signal);
        if s.hidden {
            return None;
        }
        let path = netlist.signal_path(signal);
        let (low, high) = (s.index(lo), s.index(lo + slice.width - 1));
        Some(match slice.width {
            width if width == s.width => path,
            1 => format!("{path}[{low}]"),
            _ => format!("{path}[{high}:{low}]"),
        })
    }

    /// The same, of what has no name the cell that makes it.
    fn named(&self, slice: Slice) -> String {
        self.name(slice).unwrap_or_else(|| match self.netlist().net(slice.net).driver {
            crate::netlist::Driver::Cell(cell, _) => format!("({})", self.netlist().cell(cell).element),
            crate::netlist::Driver::Input(signal) => self.netlist().signal_path(signal),
        })
    }

    /// The names of what is read, and `=`; nothing if it has none.
    fn equals(&self, slices: &[Slice]) -> String {
        if slices.iter().any(|slice| self.name(*slice).is_some()) {
            format!("{} = ", self.names(slices))
        } else {
            String::new()
        }
    }

    /// The names of several slices.
    fn names(&self, slices: &[Slice]) -> String {
        match slices {
            [one] => self.named(*one),
            [_, _, ..] if slices.len() <= 4 => {
                let names: Vec<String> = slices.iter().rev().map(|slice| self.named(*slice)).collect();
                format!("{{{}}}", names.join(", "))
            }
            [first, .., last] => format!("{{{}, …, {}}}", self.named(*last), self.named(*first)),
            [] => "(nothing)".to_owned(),
        }
    }

    /// A value: a number where that is all of a signal, else bits.
    fn value(&self, slices: &[Slice], value: &Value) -> String {
        if let [one] = slices
            && let Some((signal, _)) = self.signal(*one)
            && self.netlist().signal(signal).width == one.width
            && !self.netlist().signal(signal).hidden
        {
            return shown(self.netlist(), signal, value);
        }
        value.to_u64().filter(|_| value.width() > 1).map_or_else(|| value.to_string(), |n| n.to_string())
    }

    /// Where a cell comes from, `cpu.v:12.3-14.8`, and the text of that line, if it is there.
    fn source(&mut self, cell: CellId) -> Option<(String, Option<String>)> {
        let source = self.prepared.circuit.cell_source(cell, &self.loader.sources).map(str::to_owned);
        let span = match &source {
            Some(source) => {
                let file = source.split('|').next().and_then(|s| s.rsplit_once(':')).map(|(file, _)| file.to_owned());
                if let Some(file) = file.filter(|file| self.loader.sources.find(file).is_none()) {
                    // the source of a netlist may be where it was
                    let _ = self.loader.read(Path::new(&file));
                }
                self.loader.sources.place(source)
            }
            None => self.prepared.circuit.cell_place(cell),
        };
        let sources = &self.loader.sources;
        let line = span.map(|span| {
            let (line, _) = sources.line_col(span);
            let text = sources.text(span.file).lines().nth(line - 1).unwrap_or_default();
            (format!("{}:{line}", sources.name(span.file)), text.trim().to_owned())
        });
        match (source, line) {
            (Some(_), Some((place, text))) => Some((place, Some(text))),
            (Some(source), None) => Some((source, None)),
            (None, Some((place, _))) => Some((place, None)),
            (None, None) => None,
        }
    }

    /// What a cell is, in words: its kind and its name if people gave it one.
    fn what(&self, cell: CellId) -> String {
        let netlist = self.netlist();
        let c = netlist.cell(cell);
        let name = if c.name.contains('$') { String::new() } else { format!(" `{}`", netlist.cell_path(cell)) };
        format!("{}{name}", c.element)
    }

    /// The sentence that says what made a value.
    fn cause(&self, link: &Link) -> String {
        let netlist = self.netlist();
        let pin = |cell: CellId, pin: usize| {
            let name = netlist.cell(cell).kind.inputs()[pin].name;
            let net = netlist.input(cell, pin).first().map_or_else(String::new, |s| format!(" (`{}`)", self.named(*s)));
            format!("`{name}`{net}")
        };
        match &link.step.cause {
            Cause::Input(signal) => match self.history.at(link.step.slice, link.step.time).is_known() {
                true => format!("an input, so since {}", self.time(link.step.since)),
                false => format!("an input: nothing sets `{}`", netlist.signal_path(*signal)),
            },
            Cause::Constant(_) => "a constant".to_owned(),
            Cause::Undriven => "nothing drives it".to_owned(),
            Cause::Clock(_) => "a clock of the circuit".to_owned(),
            Cause::Gate(cell) => self.what(*cell),
            Cause::Edge { cell, pin: number, time } => {
                format!("{}, taken at the edge of {} at {}", self.what(*cell), pin(*cell, *number), self.time(*time))
            }
            Cause::Level { cell, pin: number } => format!("{}, by its {}", self.what(*cell), pin(*cell, *number)),
            Cause::Start(cell) => format!("{}: nothing has set it since the start", self.what(*cell)),
            Cause::Unwritten { cell, word } => format!("{}: nothing has written word {word}", self.what(*cell)),
            Cause::Written { cell, time, word } => {
                format!("{}: word {word} was written at {}", self.what(*cell), self.time(*time))
            }
            Cause::Delayed(cell) => self.what(*cell),
        }
    }

    fn read(&self, read: &Read) -> String {
        format!("{} = {}{}", read.pin, self.equals(&read.slices), self.value(&read.slices, &read.value))
    }

    fn control(&self, control: &Control) -> String {
        format!("{} = {}{}", control.pin, self.equals(&control.slices), self.value(&control.slices, &control.value))
    }

    /// The last sentence: where it comes from.
    fn end(&mut self, links: &[Link], end: End) -> String {
        let last = links.last().map(|link| (link.step.slice, link.step.cause.cell()));
        let name = last.map_or_else(String::new, |(slice, _)| self.named(slice));
        let unknown = links.first().is_some_and(|link| !link.step.value.is_known());
        let place =
            last.and_then(|(_, cell)| self.source(cell?)).map_or_else(String::new, |(place, _)| format!(" ({place})"));
        match end {
            End::Input(signal) => {
                let input = self.netlist().signal_path(signal);
                let hint = if unknown { format!(": set it, `-s {input}=…`") } else { String::new() };
                format!("it comes from the input `{input}`{hint}")
            }
            End::Undriven => format!("it comes from `{name}`, which nothing drives"),
            End::Uninitialised(_) => {
                format!(
                    "it comes from the register `{name}`{place}, which nothing has set: reset it, or give it an initial value"
                )
            }
            End::Unwritten(_) => format!("it comes from a word of a memory{place} that nothing has written"),
            End::MakesUnknown(cell) => {
                let divides = self.netlist().cell(cell).element.starts_with("div")
                    || matches!(self.netlist().cell(cell).kind, crate::cell::CellKind::Divide { .. });
                let why = if divides {
                    "a division by zero"
                } else {
                    "a result that is x though what it is made of is known"
                };
                format!("it comes from {why}{place}")
            }
            End::Constant if unknown => format!("it comes from a constant x{place}"),
            End::Constant => "it comes from constants".to_owned(),
            End::Clock => format!("it comes from the clock `{name}`"),
            End::Loop => format!("it goes round in a loop that nothing ever set: `{name}`{place}"),
            End::Delayed => "nothing has come through the delay yet".to_owned(),
            End::Limit => "there is more: --steps shows it".to_owned(),
        }
    }

    fn chain(&mut self, net: &str, slices: &[Slice], at: u64, links: &[Link], end: End) -> String {
        let value = self.value(slices, &self.history.joined(slices, at));
        let mut text = format!("{net} = {value} at {}\n", self.time(at));
        let first = links.first().map(|link| &link.step);
        let whole = |step: &&crate::why::Step| slices == [step.slice] && self.name(step.slice).as_deref() == Some(net);
        let mut before: Option<(NetId, u64)> = first.filter(whole).map(|step| (step.slice.net, step.time));
        for link in links {
            let step = &link.step;
            let since = if step.since == step.time || step.since == 0 && step.time == at {
                String::new()
            } else {
                format!(", so since {}", self.time(step.since))
            };
            // what has no name is a part of what was named last
            if self.name(step.slice).is_some() && before != Some((step.slice.net, step.time)) || before.is_none() {
                let value = self.value(&[step.slice], &step.value);
                let _ = writeln!(text, "\n{} = {value} at {}{since}", self.named(step.slice), self.time(step.time));
            }
            before = Some((step.slice.net, step.time));
            let _ = writeln!(text, "    {}", self.cause(link));
            if let Some((place, line)) = step.cause.cell().and_then(|cell| self.source(cell)) {
                let _ = writeln!(text, "    {place}{}", line.map_or_else(String::new, |line| format!(": {line}")));
            }
            for (i, read) in step.reads.iter().enumerate() {
                let mark = if link.followed == Some(i) { "→" } else { " " };
                let _ = writeln!(text, "  {mark}   {}", self.read(read));
            }
            for control in &step.controls {
                let _ = writeln!(text, "      {}", self.control(control));
            }
        }
        let end = self.end(links, end);
        let _ = writeln!(text, "\n{end}");
        text
    }

    fn chain_json(&mut self, net: &str, slices: &[Slice], at: u64, links: &[Link], end: End) -> Json {
        let value = self.history.joined(slices, at);
        let mut steps = Vec::new();
        for link in links {
            let step = &link.step;
            let source = step.cause.cell().and_then(|cell| self.source(cell));
            let reads: Vec<Json> = step.reads.iter().enumerate().map(|(i, read)| {
                json!({ "pin": read.pin, "net": self.names(&read.slices), "value": read.value.to_string(), "time": read.time,
                        "matters": read.matters, "followed": link.followed == Some(i) })
            }).collect();
            let controls: Vec<Json> = step
                .controls
                .iter()
                .map(|c| json!({ "pin": c.pin, "net": self.names(&c.slices), "value": c.value.to_string() }))
                .collect();
            steps.push(json!({ "net": self.named(step.slice), "value": step.value.to_string(), "time": step.time,
                "since": step.since, "cause": self.cause(link), "source": source.map(|s| s.0), "reads": reads,
                "controls": controls }));
        }
        json!({ "net": net, "value": value.to_string(), "time": at, "steps": steps, "end": format!("{end:?}"),
                "because": self.end(links, end) })
    }

    fn seen(&self, seen: &Seen) -> String {
        let netlist = self.netlist();
        let show = |value: &Value| {
            if value.width() == netlist.signal(seen.signal).width {
                shown(netlist, seen.signal, value)
            } else {
                value.to_string()
            }
        };
        let at = self.time(seen.time);
        format!(
            "{} is {} at {at}, expected: {}",
            netlist.signal_path(seen.signal),
            show(&seen.found),
            show(&seen.expected)
        )
    }

    /// The lines of the source that cells come from, each once, in order.
    fn lines(&mut self, cells: &[CellId]) -> Vec<(String, Option<String>)> {
        let mut lines: Vec<(String, Option<String>)> = Vec::new();
        for &cell in cells {
            let Some(line) = self.source(cell) else { continue };
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        lines
    }

    fn difference(&mut self, net: &str, at: Option<u64>, found: Option<&Culprit>) -> String {
        let Some(culprit) = found else {
            let when = at.map_or_else(|| "at any time".to_owned(), |at| format!("at {}", self.time(at)));
            return format!("{net} does not differ {when}\n");
        };
        let mut text = String::new();
        for (i, seen) in culprit.way.iter().enumerate() {
            let _ = writeln!(text, "{}{}", if i == 0 { "" } else { "because " }, self.seen(seen));
        }
        let equal: Vec<String> = culprit.equal.iter().map(|&s| self.netlist().signal_path(s)).collect();
        let last = culprit.way.last().map_or_else(String::new, |seen| self.netlist().signal_path(seen.signal));
        let _ = match &equal[..] {
            names if culprit.wired => {
                let place = culprit.way.last().map(|seen| self.prepared.circuit.place(seen.signal));
                let place = place.map_or_else(String::new, |span| {
                    let sources = &self.loader.sources;
                    let span = sources.origin(span);
                    format!(" ({}:{})", sources.name(span.file), sources.line_col(span).0)
                });
                writeln!(
                    text,
                    "\n`{last}`{place} is the first net that differs: it is wired to {}, as expected there. Look at how it is \
                     connected.",
                    names.join(", ")
                )
            }
            [] => writeln!(text, "\n`{last}` is the first net that differs. It is made here:"),
            names => writeln!(
                text,
                "\n`{last}` is the first net that differs: what it is made of is as expected ({}). It is made here:",
                names.join(", ")
            ),
        };
        if culprit.wired {
            return text;
        }
        for (place, line) in self.lines(&culprit.cells) {
            let _ = writeln!(text, "  {place}{}", line.map_or_else(String::new, |line| format!(": {line}")));
        }
        if culprit.cells.is_empty() {
            let _ = writeln!(text, "  nothing: it is an input");
        }
        text
    }

    fn difference_json(&mut self, net: &str, found: Option<&Culprit>) -> Json {
        let Some(culprit) = found else { return json!({ "net": net, "same": true }) };
        let way: Vec<Json> = culprit.way.iter().map(|seen| {
            json!({ "net": self.netlist().signal_path(seen.signal), "time": seen.time, "expected": seen.expected.to_string(),
                    "found": seen.found.to_string() })
        }).collect();
        let equal: Vec<String> = culprit.equal.iter().map(|&s| self.netlist().signal_path(s)).collect();
        let lines: Vec<Json> = self
            .lines(&culprit.cells)
            .into_iter()
            .map(|(place, line)| json!({ "source": place, "line": line }))
            .collect();
        json!({ "net": net, "same": false, "way": way, "equal": equal, "wired": culprit.wired, "made_by": lines })
    }
}
