//! `discreta sweep`: a circuit for every combination of values of some inputs, and the parts of such a sweep joined.

use std::fmt::Write as _;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::args::{Assignment, SweepArgs};
use super::loading::{faults, loader};
use super::prepare::{Changes, Prepared, prepare};
use super::progress::Progress;
use super::told::tell;
use super::{CliError, Out, Status, interrupt};
use crate::digest::Digest;
use crate::engine::batch::vectors;
use crate::netlist::{Direction, NetId, SignalId};
use crate::scenario::Scenario;
use crate::sweep::part::{self, Part, Rows};
use crate::sweep::run::Statistics;
use crate::sweep::{Against, Form, Over, Plan, Sweep, SweepError, Table};
use crate::wave::output::{Destination, Output};

/// Rows between two looks at how far it is, and between two times that what there is becomes safe in the file.
const STRIDE: u64 = 1024;

/// Runs the command.
///
/// # Errors
/// Faults of the circuit, the scenario or what is to be swept; results that cannot be written.
pub fn run(args: &SweepArgs, out: &mut Out) -> Result<Status, CliError> {
    match &args.circuit {
        Some(circuit) if args.join.is_empty() => sweep(args, circuit, out),
        _ => join(args, out),
    }
}

fn sweep(args: &SweepArgs, path: &Path, out: &mut Out) -> Result<Status, CliError> {
    interrupt::watch();
    let started = Instant::now();
    let form = match &args.output {
        Some(file) => form_of(file)?,
        None => Form::Csv,
    };
    if args.shard.is_some() && args.output.is_none() {
        return Err(
            CliError::usage("--shard needs --output").with_hint("name a file for the part, ending in .csv or .json")
        );
    }
    let mut loader = loader(&args.elaboration, &args.more)?;
    // what is swept is held, so that it has to be an input
    let mut sets = args.scenario.set.clone();
    for (i, over) in args.over.iter().enumerate() {
        if args.over[..i].iter().any(|o| o.net == over.net)
            || sets[..args.scenario.set.len()].iter().any(|s| s.name == over.net)
        {
            return Err(CliError::usage(format!("`{}` is given twice", over.net)));
        }
        sets.push(Assignment { name: over.net.clone(), value: over.text(0) });
    }
    let changes = Changes { sets: &sets, ..Changes::of(&args.elaboration, &args.scenario, &args.show) };
    let prepared = prepare(&mut loader, path, &changes);
    let prepared = faults(&mut loader, prepared)?;
    if prepared.replay.is_some() {
        return Err(CliError::usage("a waveform drives the inputs of this scenario, so they cannot be swept")
            .with_hint("name the circuit itself: the waveform replaces its own scenario"));
    }
    let Prepared { circuit, scenario, .. } = &prepared;
    let netlist = &circuit.netlist;
    let usage = |e: &dyn std::fmt::Display| CliError::usage(e.to_string());
    let mut swept: Vec<SignalId> = Vec::new();
    let mut axes = Vec::new();
    for over in &args.over {
        let signal = netlist.find(&over.net).ok_or_else(|| usage(&format!("the circuit has no net `{}`", over.net)))?;
        let of = netlist.signal(signal);
        axes.push(over.values(of.width, of.signed).map_err(|e| usage(&e))?);
        swept.push(signal);
    }
    let mut plan = Plan::new(axes).map_err(|e| usage(&e))?;
    if let Some(count) = args.sample {
        plan = plan.sample(count, args.seed).map_err(|e| usage(&e))?;
    }
    if let Some(shard) = args.shard {
        plan = plan.shard(shard);
    }
    let nets: Vec<NetId> = swept.iter().filter_map(|&s| netlist.signal(s).drive).collect();
    let against = match args.against {
        Some(method) => Some(
            Against::new(method, circuit, scenario, &nets)
                .map_err(|e| CliError::usage(e.message.clone()).with_hint(e.help))?,
        ),
        None => None,
    };
    if !(scenario.expect.is_empty() && scenario.checks.is_empty() && scenario.monitors.is_empty()) {
        tell!("note: a sweep does not check expectations, timing checks and the circuit's own assertions\n");
    }
    let is_output = |s: &SignalId| matches!(netlist.signal(*s).port, Some(Direction::Output | Direction::Inout));
    let outputs = match args.show.is_empty() {
        true => netlist.ports().filter(is_output).collect(),
        false => scenario.trace.clone(),
    };
    let sweep = Sweep { netlist, scenario, nets, plan, outputs, against, threads: args.threads.into(), lanes: 0 };
    let clock = scenario.clocks.first().map(|c| c.clock);
    let inputs = swept.iter().map(|&s| (netlist.signal(s).width, netlist.signal(s).signed)).collect();
    let table = Table::new(netlist, &sweep.plan, swept, sweep.outputs.clone(), clock, sweep.against.is_some(), form);
    let columns = table.columns();
    let part = Part {
        circuit: path.display().to_string(),
        over: args.over.iter().map(Over::to_string).collect(),
        inputs,
        sample: args.sample.map(|count| (count, args.seed)),
        id: identity(args, &prepared, &columns),
        form,
        rows: [sweep.plan.rows.start, sweep.plan.rows.end, sweep.plan.total()],
    };

    let mut tally = Tally { form, swept: args.over.len(), compared: args.against.is_some(), ..Tally::default() };
    let mut results = match &args.output {
        Some(file) => Results::file(file, &part, &columns, args.resume, &mut tally)?,
        None => {
            out.write_fmt(format_args!("{}", part::head(&Part { rows: [0; 3], ..part.clone() }, &columns)))?;
            Results::Stdout
        }
    };
    let begun = part.rows[0] + tally.rows;
    let mut progress = Progress::new("sweeping", "runs", Some(part.rows[1] - part.rows[0]));
    let sweeping = Instant::now();
    let mut broken = None;
    let ran = sweep.run(begun, interrupt::flag(), &|row| table.line(row), &mut |number, line| {
        tally.add(number, line);
        if tally.rows.is_multiple_of(STRIDE) {
            progress.set(tally.rows);
            results.flush()?;
        }
        let written = results.line(line, out);
        written.map_err(|e| {
            broken = Some(e);
            io::Error::other("the rows cannot be written")
        })
    });
    let took = sweeping.elapsed();
    progress.clear();
    let interrupted = match ran {
        Ok(statistics) => {
            results.finish(&part, &columns, out)?;
            if args.verbose {
                verbose(&sweep, &statistics, took, started.elapsed());
            }
            false
        }
        Err(SweepError::Interrupted(_)) => true,
        Err(SweepError::Sink(_)) if broken.as_ref().is_some_and(CliError::is_broken_pipe) => {
            return Ok(Status::of(tally.as_asked(scenario)));
        }
        Err(SweepError::Sink(e)) => return Err(broken.unwrap_or_else(|| e.into())),
        Err(SweepError::Threads(source)) => {
            return Err(CliError::Io { message: "cannot sweep: the system gives no thread".to_owned(), source });
        }
        Err(e @ SweepError::Foreign(_)) => {
            return Err(usage(&e).with_hint("leave --against out: the sweep itself takes every circuit"));
        }
    };
    out.flush()?;
    let mut text = tally.text(args.against.map(|m| m.name()));
    if let Some((row, why)) = &tally.first {
        let _ = write!(text, "first difference, {why}:\n  {}\n", command(args, path, &sweep.plan, *row));
    }
    if interrupted {
        let rest = part.rows[1] - part.rows[0] - tally.rows;
        let _ = write!(text, "interrupted, {rest} runs are left");
        text += match results.keep()? {
            Some(_) => "; the same command with --resume goes on\n",
            None => "\n",
        };
    }
    match (&args.output, interrupted) {
        (Some(file), false) => out.write_fmt(format_args!("{text}wrote {}\n", file.display()))?,
        _ => tell!("{text}"),
    }
    Ok(Status::of(tally.as_asked(scenario) && !interrupted))
}

/// What the extension of a file says of its form.
fn form_of(file: &Path) -> Result<Form, CliError> {
    match file.extension().and_then(|e| e.to_str()) {
        Some("csv") => Ok(Form::Csv),
        Some("json") => Ok(Form::Json),
        _ => Err(CliError::usage(format!("cannot write `{}`: results are written as CSV or JSON", file.display()))
            .with_hint("end the name in .csv or .json")),
    }
}

/// What tells a sweep from another: its circuit, its scenario, its values, its columns.
fn identity(args: &SweepArgs, prepared: &Prepared, columns: &[String]) -> String {
    let mut hash = Digest::default();
    let Prepared { circuit, scenario, .. } = prepared;
    let over: Vec<String> = args.over.iter().map(Over::to_string).collect();
    let sample = args.sample.map(|n| (n, args.seed));
    let _ = write!(hash, "{} {over:?} {sample:?} {:?} {columns:?}", env!("CARGO_PKG_VERSION"), args.against);
    for cell in circuit.netlist.cell_ids() {
        let cell_of = circuit.netlist.cell(cell);
        let _ = write!(hash, "{:?}", cell_of.kind);
        for pin in 0..cell_of.kind.inputs().len() {
            let _ = write!(hash, "{:?}", circuit.netlist.input(cell, pin));
        }
    }
    for signal in circuit.netlist.signal_ids() {
        let _ = write!(hash, "{} {:?}", circuit.netlist.signal_path(signal), circuit.netlist.bits(signal));
    }
    let Scenario { clocks, inputs, stimulus, until, limit, limit_given, .. } = scenario;
    let _ = write!(hash, "{clocks:?} {inputs:?} {stimulus:?} {until:?} {limit} {limit_given}");
    hash.text()
}

/// How the runs ended, by their rows.
#[derive(Default)]
struct Tally {
    form: Form,
    /// Columns before that which says why a run ended.
    swept: usize,
    compared: bool,
    rows: u64,
    until: u64,
    limit: u64,
    idle: u64,
    unsettled: u64,
    refused: u64,
    differ: u64,
    /// The first row that differs, and how.
    first: Option<(u64, String)>,
}

impl Tally {
    /// Whether every run ended as it was to.
    fn as_asked(&self, scenario: &Scenario) -> bool {
        self.unsettled == 0
            && self.differ == 0
            && (self.limit == 0 || !scenario.limit_fails)
            && (self.idle == 0 || scenario.until.is_none())
    }

    fn add(&mut self, number: u64, line: &str) {
        self.rows += 1;
        // values hold neither commas nor quotes
        let stop = line.split(',').nth(self.swept).unwrap_or_default();
        match stop.trim_matches('"') {
            "until" => self.until += 1,
            "limit" => self.limit += 1,
            "idle" => self.idle += 1,
            _ => self.unsettled += 1,
        }
        let same = if self.form == Form::Json { line.ends_with(",\"\"]") } else { line.ends_with(',') };
        if !self.compared || same {
            return;
        }
        let rest = line.rfind("\"clock ").or_else(|| line.rfind(",clock ")).map(|at| &line[at + 1..]);
        match rest {
            Some(why) => {
                self.differ += 1;
                let why = why.trim_end_matches([']', '"']).to_owned();
                self.first.get_or_insert((number, why));
            }
            None => self.refused += 1,
        }
    }

    fn text(&self, method: Option<&str>) -> String {
        let mut text = format!("{} run{}", self.rows, if self.rows == 1 { "" } else { "s" });
        let ends = [(self.until, "until"), (self.limit, "limit"), (self.idle, "idle"), (self.unsettled, "unsettled")];
        let ends: Vec<String> = ends.iter().filter(|e| e.0 > 0).map(|(n, what)| format!("{n} {what}")).collect();
        if !ends.is_empty() {
            let _ = write!(text, ": {}", ends.join(", "));
        }
        if let Some(method) = method {
            match self.differ {
                0 => _ = write!(text, "; none differs from {method}"),
                1 => _ = write!(text, "; 1 differs from {method}"),
                n => _ = write!(text, "; {n} differ from {method}"),
            }
            if self.refused > 0 {
                let _ = write!(text, ", which refuses {}", self.refused);
            }
        }
        text + "\n"
    }
}

/// The command that runs one row alone, with a waveform.
fn command(args: &SweepArgs, path: &Path, plan: &Plan, row: u64) -> String {
    let mut words = vec!["discreta".to_owned(), "run".to_owned(), path.display().to_string()];
    let mut option = |name: &str, value: String| words.extend([name.to_owned(), value]);
    for a in &args.elaboration.parameter {
        option("-p", format!("{}={}", a.name, a.value));
    }
    if let Some(top) = &args.elaboration.top {
        option("--top", top.clone());
    }
    for a in &args.elaboration.limit {
        option("--limit", format!("{}={}", a.name, a.value));
    }
    for a in &args.scenario.set {
        option("-s", format!("{}={}", a.name, a.value));
    }
    for (over, index) in args.over.iter().zip(plan.indices(row)) {
        option("-s", format!("{}={}", over.net, over.text(index)));
    }
    for c in &args.scenario.clock {
        let high = c.high.as_ref().map_or(String::new(), |t| format!(",high={t}"));
        let phase = c.phase.as_ref().map_or(String::new(), |t| format!(",phase={t}"));
        option("--clock", format!("{}={}{high}{phase}", c.net, c.period));
    }
    if let Some(n) = args.scenario.cycles {
        option("--cycles", n.to_string());
    }
    if let Some(time) = &args.scenario.time {
        option("--time", time.clone());
    }
    if let Some(until) = &args.scenario.until {
        option("--until", until.value.as_ref().map_or(until.net.clone(), |v| format!("{}={v}", until.net)));
    }
    option("-o", "difference.vcd".to_owned());
    let plain = |word: &str| word.chars().all(|c| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c));
    let quoted = words.iter().map(|w| if plain(w) { w.clone() } else { format!("'{}'", w.replace('\'', r"'\''")) });
    quoted.collect::<Vec<_>>().join(" ")
}

fn verbose(sweep: &Sweep<'_>, s: &Statistics, took: std::time::Duration, all: std::time::Duration) {
    let engine = match sweep.foreign() {
        None => format!("engine batch, {} lanes on {} threads, vectors {}", s.lanes, s.threads, vectors()),
        Some(cell) => format!(
            "engine event, {} threads: the batch engine does not take {}",
            s.threads,
            sweep.netlist.cell_path(cell)
        ),
    };
    let alone =
        if s.events > 0 && s.lanes > 0 { format!(", {} runs on the event engine", s.events) } else { String::new() };
    tell!("{engine}{alone}\n");
    tell!(
        "{} instants, {} of blocks all known, {:.3e} bits of cells evaluated, {:.3} s of {:.3} s\n",
        s.instants,
        s.known,
        s.evaluated as f64,
        took.as_secs_f64(),
        all.as_secs_f64()
    );
}

/// Where rows go.
enum Results {
    Stdout,
    /// A file beside the output, that holds what a part is and a row a line, until all are there.
    File {
        output: PathBuf,
        part: PathBuf,
        rows: BufWriter<File>,
    },
}

/// The file in which rows wait until all are there.
fn waiting(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

fn cannot(what: &str, path: &Path, source: io::Error) -> CliError {
    CliError::Io { message: format!("cannot {what} `{}`", path.display()), source }
}

/// Opens the file in which rows wait, which no other sweep may have open: two would mix their rows.
fn alone(path: &Path, output: &Path) -> Result<File, CliError> {
    let fail = |e| cannot("write", path, e);
    crate::files::writes(path).map_err(fail)?;
    loop {
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(fail)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                let message = format!("cannot write `{}`: another sweep is writing it", output.display());
                return Err(CliError::usage(message).with_hint("wait for that, or name another file"));
            }
            // where files cannot be locked nothing can be known
            Err(TryLockError::Error(_)) => return Ok(file),
            Ok(()) => {}
        }
        // the other sweep may have ended, and taken its file away, since this one opened it
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let number = |m: fs::Metadata| (m.dev(), m.ino());
            if fs::metadata(path).map(number).ok() != file.metadata().map(number).ok() {
                continue;
            }
        }
        return Ok(file);
    }
}

impl Results {
    /// Begins a file of rows, or goes on with it.
    fn file(
        output: &Path,
        part: &Part,
        columns: &[String],
        resume: bool,
        tally: &mut Tally,
    ) -> Result<Results, CliError> {
        // that it can be written is to be known before the work
        Output::check(output)?;
        let path = waiting(output);
        let there = resume && path.exists();
        let mut file = alone(&path, output)?;
        let line = serde_json::json!(part).to_string();
        let fail = |e| cannot("write", &path, e);
        if there {
            let names = columns.iter().map(|name| part::field(part.form, name)).collect::<Vec<_>>().join(",");
            let names = if part.form == Form::Json { format!("[{names}]") } else { names };
            let rows = Rows::of(part, &names).map_err(CliError::usage)?;
            let mut lines = BufReader::new(&mut file);
            let (mut whole, mut text) = (0u64, String::new());
            let other = || {
                CliError::usage(format!("`{}` is of another sweep", path.display()))
                    .with_hint("remove it, or leave --resume out to begin anew")
            };
            for first in std::iter::once(true).chain(std::iter::repeat(false)) {
                text.clear();
                let n = lines.read_line(&mut text).map_err(|e| cannot("read", &path, e))?;
                // what broke off within a line is run again
                let Some(row) = text.strip_suffix('\n') else { break };
                whole += n as u64;
                match first {
                    true if row != line => return Err(other()),
                    true => {}
                    false if tally.rows == part.rows[1] - part.rows[0] => return Err(other()),
                    false => {
                        let number = part.rows[0] + tally.rows;
                        rows.check(number, row).map_err(|why| {
                            let line = tally.rows + 2;
                            CliError::usage(format!("`{}`, line {line}: {why}", path.display()))
                                .with_hint("remove it, or leave --resume out to begin anew")
                        })?;
                        tally.add(number, row);
                    }
                }
            }
            if whole == 0 {
                return Err(other());
            }
            file.set_len(whole).map_err(fail)?;
            file.seek(io::SeekFrom::End(0)).map_err(fail)?;
            return Ok(Results::File { output: output.to_owned(), part: path, rows: BufWriter::new(file) });
        }
        file.set_len(0).map_err(fail)?;
        let mut rows = BufWriter::new(file);
        writeln!(rows, "{line}").map_err(fail)?;
        rows.flush().map_err(fail)?;
        Ok(Results::File { output: output.to_owned(), part: path, rows })
    }

    fn line(&mut self, line: &str, out: &mut Out) -> Result<(), CliError> {
        match self {
            Results::Stdout => {
                out.write_fmt(format_args!("{line}\n"))?;
                // nobody reads: the rest need not be run
                if out.is_closed() { Err(CliError::stdout(io::ErrorKind::BrokenPipe.into())) } else { Ok(()) }
            }
            Results::File { part, rows, .. } => {
                let written = rows.write_all(line.as_bytes()).and_then(|()| rows.write_all(b"\n"));
                written.map_err(|e| cannot("write", part, e))
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Results::Stdout => Ok(()),
            Results::File { rows, .. } => rows.flush(),
        }
    }

    /// What stays when not all rows are there.
    fn keep(mut self) -> Result<Option<PathBuf>, CliError> {
        self.flush().map_err(|e| cannot("write", &self.path(), e))?;
        match self {
            Results::Stdout => Ok(None),
            Results::File { part, .. } => Ok(Some(part)),
        }
    }

    fn path(&self) -> PathBuf {
        match self {
            Results::Stdout => PathBuf::from("-"),
            Results::File { part, .. } => part.clone(),
        }
    }

    /// All rows are there.
    fn finish(&mut self, what: &Part, columns: &[String], out: &mut Out) -> Result<(), CliError> {
        self.flush().map_err(|e| cannot("write", &self.path(), e))?;
        let Results::File { output, part: waiting, .. } = self else { return out.flush() };
        let reading = |e| cannot("read", waiting, e);
        let mut lines = BufReader::new(File::open(&*waiting).map_err(reading)?).lines();
        lines.next();
        let mut to = BufWriter::new(Output::create(output)?);
        to.write_all(part::head(what, columns).as_bytes())?;
        let (mut any, mut digest) = (false, Digest::default());
        for line in lines {
            let line = line.map_err(reading)?;
            if any {
                to.write_all(part::between(what.form).as_bytes())?;
            }
            to.write_all(line.as_bytes())?;
            digest.line(&line);
            any = true;
        }
        to.write_all(part::tail(what, any, &digest).as_bytes())?;
        complete(to)?;
        fs::remove_file(&*waiting).map_err(|e| cannot("remove", waiting, e))
    }
}

fn complete(to: BufWriter<Output>) -> Result<(), CliError> {
    to.into_inner().map_err(|e| CliError::from(e.into_error()))?.complete()?;
    Ok(())
}

/// Puts the parts of a sweep together.
fn join(args: &SweepArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut texts = Vec::new();
    for path in &args.join {
        crate::files::reads(path);
        texts.push(fs::read_to_string(path).map_err(|e| cannot("read", path, e))?);
    }
    let fault = |number: usize, why: String| CliError::usage(format!("`{}`: {why}", args.join[number].display()));
    let mut parts = Vec::new();
    for (number, text) in texts.iter().enumerate() {
        parts.push(part::read(text).map_err(|(line, why)| match line {
            Some(line) => CliError::usage(format!("`{}`, line {line}: {why}", args.join[number].display())),
            None => fault(number, why),
        })?);
    }
    let parts = part::order(parts).map_err(|(number, why)| fault(number, why))?;
    let first = &parts[0];
    if let Some(file) = &args.output
        && form_of(file)? != first.part.form
    {
        return Err(CliError::usage("the parts are in another form than the output")
            .with_hint("parts and output end in .csv, or all in .json"));
    }
    let total = first.part.rows[2];
    let whole = Part { rows: [0, total, total], ..first.part.clone() };
    let head = match whole.form {
        Form::Csv => format!("{}\n", first.columns),
        Form::Json => part::head_of(&whole, first.columns),
    };
    let mut write = |text: &str, to: &mut Option<BufWriter<Output>>| -> Result<(), CliError> {
        match to {
            Some(to) => Ok(to.write_all(text.as_bytes())?),
            None => out.write_fmt(format_args!("{text}")),
        }
    };
    let mut to = match &args.output {
        Some(file) => Some(BufWriter::new(Output::create(file)?)),
        None => None,
    };
    write(&head, &mut to)?;
    let (mut any, mut digest) = (false, Digest::default());
    for line in parts.iter().flat_map(|p| &p.lines) {
        if any {
            write(part::between(whole.form), &mut to)?;
        }
        write(line, &mut to)?;
        digest.line(line);
        any = true;
    }
    write(&part::tail(&whole, any, &digest), &mut to)?;
    if let (Some(to), Some(file)) = (to, &args.output) {
        complete(to)?;
        out.write_fmt(format_args!("{total} runs of {} parts\nwrote {}\n", parts.len(), file.display()))?;
    }
    Ok(Status::Done)
}
