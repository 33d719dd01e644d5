//! `discreta view`: a page that shows a circuit, or a waveform, at work.

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::Path;

use super::args::{CoordinateArgs, ViewArgs};
use super::loading::{faults, loader};
use super::prepare::{Changes, Prepared, prepare};
use super::report::Report;
use super::sample::{edges, moved, sampled};
use super::simulate::simulate;
use super::wave::{left_out, opened};
use super::{CliError, Out, Status, interrupt};
use crate::draw;
use crate::interpolate::Ideal;
use crate::netlist::Direction;
use crate::value::Word;
use crate::view::Page;
use crate::view::pack::{About, MAX_CHANGES, PackError, Signals};
use crate::view::route::{Reached, Route, followed};
use crate::wave::output::{Destination, Output};
use crate::wave::read::Waves;
use crate::wave::vcd::VcdWriter;
use crate::wave::{Batches, Layout, Sink};

/// Runs the command.
///
/// # Errors
/// A faulty circuit, a waveform that cannot be read, a page that cannot be written.
pub fn run(args: &ViewArgs, out: &mut Out) -> Result<Status, CliError> {
    let (page, status) = if is_waveform(&args.what) { of_waveform(args, out)? } else { of_circuit(args)? };
    let html = page.html();
    if args.output.as_os_str() == "-" {
        out.bytes(html.as_bytes())?;
        return Ok(status);
    }
    let mut file = Output::create(&args.output)?;
    file.write_all(html.as_bytes())?;
    file.complete()?;
    let signals = page.signals.signals.iter().filter(|s| !s.hidden).count();
    let path = match &page.route {
        Some(route) => format!(", a path of {} {}s", route.times.len() - 1, route.unit),
        None => String::new(),
    };
    let drawing = if page.schematic.is_ok() { "a schematic, " } else { "" };
    out.write_fmt(format_args!("wrote {}: {drawing}{signals} signals{path}\n", args.output.display()))?;
    Ok(status)
}

/// Whether a file is one by its name.
fn is_waveform(path: &Path) -> bool {
    path.extension().is_some_and(|e| ["vcd", "fst", "ghw"].iter().any(|known| e.eq_ignore_ascii_case(known)))
}

fn of_waveform(args: &ViewArgs, out: &mut Out) -> Result<(Page, Status), CliError> {
    let given = [
        ("--parameter", !args.elaboration.parameter.is_empty()),
        ("--set", !args.scenario.set.is_empty()),
        ("--clock", !args.scenario.clock.is_empty()),
        ("--cycles", args.scenario.cycles.is_some()),
        ("--time", args.scenario.time.is_some()),
        ("--until", args.scenario.until.is_some()),
        ("--trace", !args.trace.is_empty()),
    ];
    if let Some((option, _)) = given.iter().find(|(_, given)| *given) {
        return Err(CliError::usage(format!("a waveform has no option {option}")).with_hint("it is for circuits"));
    }
    let mut waves = opened(&args.what, args.scope.as_deref(), out)?;
    left_out(&waves, |_| true);
    let signals = packed(&mut waves, |_| About::default())?;
    let name = args.what.file_name().unwrap_or(args.what.as_os_str()).to_string_lossy().into_owned();
    let shown = signals.signals.len();
    let page = Page {
        title: name,
        note: format!(
            "{shown} signals until {}",
            waves.timescale().map_or_else(|| waves.end().to_string(), |t| t.time(waves.end()))
        ),
        timescale: waves.timescale(),
        schematic: Err("A waveform alone has no schematic: give the circuit to have one".to_owned()),
        route: route(&mut waves, args, &args.coordinates)?,
        signals,
    };
    Ok((page, Status::Done))
}

fn of_circuit(args: &ViewArgs) -> Result<(Page, Status), CliError> {
    if args.scope.is_some() {
        return Err(CliError::usage("a circuit has no option --scope").with_hint("it is for waveforms"));
    }
    interrupt::watch();
    let mut loader = loader(&args.elaboration, &args.more)?;
    let changes = Changes::of(&args.elaboration, &args.scenario, &args.trace);
    let prepared = prepare(&mut loader, &args.what, &changes);
    let mut prepared = faults(&mut loader, prepared)?;
    if args.trace.is_empty() {
        // wires show what they have, so all of them are recorded
        prepared.scenario.trace = prepared.circuit.netlist.signal_ids().collect();
    }

    // the reader wants a file
    let held = tempfile::Builder::new().suffix(".vcd").tempfile();
    let held = held.map_err(|source| CliError::Io { message: "cannot keep the waveform".to_owned(), source })?;
    let mut sink = Numbered(VcdWriter::new(Output::create(held.path())?));
    let (outcome, difference) = simulate(&mut prepared, &loader, &args.engine, Some(&mut sink), "running")?;
    drop(sink);
    let difference = difference.as_ref();
    let report = Report { prepared: &prepared, loader: &loader, outcome: &outcome, files: &[], difference };
    report.warnings(false);
    report.notes(args.engine.x_control);
    let text = report.text(false);
    let note = text.lines().next().unwrap_or_default();
    let note = note.split_once(": ").map_or(note, |(_, note)| note).to_owned();

    let mut waves = Waves::open(held.path())?;
    let netlist = &prepared.circuit.netlist;
    let top = netlist.scopes().first().map_or("", |scope| scope.name.as_str());
    waves.rename(|numbered| {
        let number: usize = numbered.rsplit_once(NUMBERED)?.1.parse().ok()?;
        let signal = *prepared.scenario.trace.get(number)?;
        let path = format!("{top}.{}", netlist.signal_path(signal));
        let scopes = path.len() - netlist.signal(signal).name.len() - 1;
        Some((path, scopes))
    });
    let about = about(&prepared);
    let signals = packed(&mut waves, |name| about.get(name).cloned().unwrap_or_default())?;
    let mut coordinates = args.coordinates.clone();
    let nets = [coordinates.x.as_deref().unwrap_or("xt"), coordinates.y.as_deref().unwrap_or("yt")];
    coordinates.signed |= nets.iter().filter_map(|net| netlist.find(net)).any(|id| netlist.signal(id).signed);
    let options = draw::Options { depth: args.depth, ..draw::Options::default() };
    let page = Page {
        title: netlist.scopes().first().map_or_else(String::new, |top| top.name.clone()),
        note,
        timescale: Some(netlist.timescale()),
        schematic: draw::svg(netlist, &options).map_err(|why| format!("No schematic: {why}")),
        route: route(&mut waves, args, &coordinates)?,
        signals,
    };
    Ok((page, report.status()))
}

/// What names begin with that are numbers.
const NUMBERED: &str = ".v";

/// Hands on a waveform whose variables are called by their numbers: a reader takes brackets, dots and backslashes in names
/// for more than a part of them, and the schematic calls a net what it is.
struct Numbered<S>(S);

impl<S: Sink> Sink for Numbered<S> {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        let mut layout = layout.clone();
        for (i, scope) in layout.scopes.iter_mut().enumerate() {
            scope.name = format!("s{i}");
        }
        for (i, var) in layout.vars.iter_mut().enumerate() {
            var.name = format!("{}{i}", &NUMBERED[1..]);
        }
        self.0.begin(&layout)
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        self.0.time(now)
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        self.0.change(var, value);
    }

    fn batches(&mut self) -> Option<&mut dyn Batches> {
        self.0.batches()
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        self.0.finish(end)
    }
}

/// What the circuit says of its signals, by their full names in a waveform.
fn about(prepared: &Prepared) -> HashMap<String, About> {
    let netlist = &prepared.circuit.netlist;
    let top = netlist.scopes().first().map_or("", |scope| scope.name.as_str());
    let clocks: Vec<&str> = prepared.scenario.clocks.iter().map(|clock| clock.name.as_str()).collect();
    let of = |id| {
        let signal = netlist.signal(id);
        let path = netlist.signal_path(id);
        let port = match signal.port.filter(|_| !path.contains('.')) {
            Some(Direction::Input) => "in",
            Some(Direction::Output) => "out",
            Some(Direction::Inout) => "inout",
            None => "",
        };
        let clock = clocks.contains(&path.as_str());
        let values = signal.values.iter().flat_map(|names| names.iter());
        let values = values.map(|(value, name)| (value.bit_string(), name.to_owned())).collect();
        (format!("{top}.{path}"), About { signed: signal.signed, port, clock, hidden: signal.hidden, values })
    };
    netlist.signal_ids().map(of).collect()
}

fn packed(waves: &mut Waves, about: impl Fn(&str) -> About) -> Result<Signals, CliError> {
    Signals::of(waves, about).map_err(|e| match e {
        PackError::Read(e) => e.into(),
        PackError::TooMany => CliError::usage(format!("a page holds at most {MAX_CHANGES} changes"))
            .with_hint("show fewer nets by --trace, or a shorter run by --time"),
    })
}

/// The path, if there is one: what was asked for must be there, what goes without saying need not.
fn route(waves: &mut Waves, args: &ViewArgs, given: &CoordinateArgs) -> Result<Option<Route>, CliError> {
    let asked =
        args.center.is_some() || given.x.is_some() || given.y.is_some() || given.z.is_some() || given.dt.is_some();
    let mut coordinates = given.clone();
    if coordinates.z.is_none() && coordinates.x.is_none() {
        let third = waves.vars().iter().filter(|v| v.name.ends_with(".zt")).min_by_key(|v| v.name.matches('.').count());
        coordinates.z = third.map(|v| v.name.clone());
    }
    let axes = 2 + usize::from(coordinates.z.is_some());
    let (unit, points) = match (sampled(waves, &coordinates), moved(waves, &coordinates)) {
        (Err(e), _) | (_, Err(e)) if asked => return Err(e),
        (_, Err(_)) => return Ok(None),
        // where something else than dt clocks the coordinates, they move between its edges
        (Ok(points), Ok(moved)) if changes(&points) >= changes(&moved) => ("clock", points),
        (_, Ok(moved)) => ("step", moved),
    };
    let ideal = match (args.center, points.first(), points.last()) {
        (Some(center), Some(first), Some(last)) => {
            let plane = |p: [i64; 3]| [p[0] as f64, p[1] as f64];
            Some(Ideal::arc(plane([center.x, center.y, 0]), plane(first.at), plane(last.at), args.cw))
        }
        _ => followed(axes, &points),
    };
    let mut route = Route::new(axes, unit, &points, ideal);
    if let Some(route) = route.as_mut().filter(|_| unit == "clock") {
        route.clocks = edges(waves, &coordinates)?;
    }
    Ok(route)
}

/// How often a path leaves a point.
fn changes(points: &[Reached]) -> usize {
    points.windows(2).filter(|pair| pair[0].at != pair[1].at).count()
}
