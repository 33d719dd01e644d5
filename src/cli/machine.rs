//! `discreta machine`: a whole part program through the interpolators.

mod capture;
mod record;

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use self::record::Record;
use super::args::{MachineArgs, MachineFormat};
use super::progress::Progress;
use super::{CliError, Out, Status, interrupt};
use crate::machine::clockwork::Rule;
use crate::machine::draw::Choice;
use crate::machine::measure::Point;
use crate::machine::picture::Picture;
use crate::machine::plan::{Plan, Scale};
use crate::machine::program::{self, Decimal, Faults, Line, Refusal, Tolerance};
use crate::machine::report::{self, Report};
use crate::machine::{Drawn, See, Settings};
use crate::wave::output::{Destination, Output};

/// A program is looked at for interruption and progress this often, in moves.
const OFTEN: u64 = 256;

/// Runs the command. The program is read twice: nothing is printed before all of it is known to be right.
///
/// # Errors
/// Faults of the program, options that contradict each other, output that cannot be written.
pub fn run(args: &MachineArgs, out: &mut Out) -> Result<Status, CliError> {
    contradictions(args)?;
    let settings = settings(args);
    if let Some(waveform) = &args.waveform {
        return capture::run(args, waveform, &settings, out);
    }
    let Some(program) = &args.program else {
        return Err(CliError::usage("no program is named"));
    };
    let mut source = Source::open(program)?;
    outputs(args, program)?;
    interrupt::watch();
    let mut faults = Faults::default();
    let mut watch = Watch::new("reading", source.bytes);
    if args.format == MachineFormat::Canon {
        let checked = program::read(source.begin()?, &source.name, settings.program, &mut faults, |line, _| {
            if watch.stop(line.bytes) { Err(Refusal::Stop) } else { Ok(()) }
        });
        watch.finish("nothing was printed")?;
        source.read(checked)?;
        told(&faults)?;
        return canon(&mut source, &settings, out);
    }
    let survey = crate::machine::survey(source.begin()?, &source.name, &settings, &mut faults, |b| watch.stop(b));
    watch.finish("nothing was drawn")?;
    let survey = source.read(survey)?;
    told(&faults)?;
    if survey.moves == [0; 3] {
        return Err(CliError::usage(format!("`{}` moves nothing", source.name))
            .with_hint("a part program has lines such as G1 X10 Y5 F300"));
    }
    let mut watch = Watch::new("drawing", source.bytes);
    let mut seen = Seen { settings: &settings, csv: None, picture: None, record: None };
    if args.format == MachineFormat::Csv {
        out.bytes(report::CSV.as_bytes())?;
        seen.csv = Some(Vec::new());
    }
    if args.plot.is_some() {
        seen.picture = Some(Picture::new(settings.rules.len(), settings.seconds(), settings.rapid.to_f64()));
    }
    if let Some(path) = &args.output {
        seen.record = Some(Record::begin(path, settings.tick)?);
    }
    let mut faults = Faults::default();
    let mut sink = ToOut { seen, out, failed: None };
    let begun = source.begin()?;
    let outcomes =
        crate::machine::run(begun, &source.name, &settings, &survey, &mut faults, &mut sink, |b| watch.stop(b));
    let ToOut { mut seen, out, failed } = sink;
    watch.finish("the program was not drawn to its end")?;
    if let Some(error) = failed {
        return Err(error);
    }
    if let Some(error) = seen.record.as_mut().and_then(Record::failed) {
        return Err(error.into());
    }
    let outcomes = source.read(outcomes)?;
    if faults.diagnostics.has_errors() {
        return Err(CliError::Input(faults.diagnostics.render(&faults.sources, false)));
    }
    if let Some(record) = seen.record.take() {
        record.finish()?;
    }
    let report = Report { name: &source.name, settings: &settings, survey: &survey, outcomes: &outcomes };
    let picture = seen.picture.take();
    match args.format {
        MachineFormat::Table => out.bytes(report.table().as_bytes())?,
        MachineFormat::Json => out.json(&report.json())?,
        MachineFormat::Csv | MachineFormat::Canon => {}
    }
    if let (Some(picture), Some(path)) = (picture, &args.plot) {
        let mut file = Output::create(path)?;
        file.write_all(picture.svg(&report).as_bytes())?;
        file.complete()?;
    }
    out.flush()?;
    Ok(Status::Done)
}

/// Files that are written are not the program, and not one file.
fn outputs(args: &MachineArgs, program: &Path) -> Result<(), CliError> {
    let written: Vec<&PathBuf> = args.plot.iter().chain(&args.output).collect();
    if let Some(path) = written.iter().find(|path| same_file(path, program)) {
        let fault = CliError::usage(format!("`{}` is the program itself", path.display()));
        return Err(fault.with_hint("give what is written another name"));
    }
    if let [a, b] = written[..]
        && (a == b || same_file(a, b))
    {
        return Err(CliError::usage(format!("`{}` is to be both the picture and the waveform", a.display()))
            .with_hint("give one of them another name"));
    }
    Ok(())
}

/// Options of which one makes the other mean nothing.
fn contradictions(args: &MachineArgs) -> Result<(), CliError> {
    let drawn = [
        ("--plot", args.plot.is_some()),
        ("--output", args.output.is_some()),
        ("--method", !args.method.is_empty()),
        ("--feed", !args.feed.is_empty()),
        ("--centred", args.centred),
        ("--bits", args.bits.is_some()),
        ("--blu", args.blu.is_some()),
        ("--steps-per-mm", args.steps_per_mm.is_some()),
    ];
    if args.format == MachineFormat::Canon
        && let Some((option, _)) = drawn.into_iter().find(|(_, given)| *given)
    {
        return Err(CliError::usage(format!("--format canon draws nothing, so {option} has no meaning"))
            .with_hint("leave one of them out"));
    }
    if args.waveform.is_some() {
        // the size of a step is that of the capture
        let meaning = ["--blu", "--steps-per-mm"];
        let other = drawn.into_iter().find(|(option, given)| *given && !meaning.contains(option));
        if let Some((option, _)) = other {
            return Err(CliError::usage(format!("--waveform is measured, not drawn, so {option} has no meaning"))
                .with_hint("leave one of them out"));
        }
        if args.format == MachineFormat::Canon {
            return Err(
                CliError::usage("--format canon prints a program, not a waveform").with_hint("leave --waveform out")
            );
        }
    }
    for (i, choice) in args.method.iter().enumerate() {
        if args.method[..i].contains(choice) {
            return Err(CliError::usage(format!("--method {choice} is given twice")));
        }
    }
    for (i, rule) in args.feed.iter().enumerate() {
        if args.feed[..i].contains(rule) {
            return Err(CliError::usage(format!("--feed {rule} is given twice")));
        }
    }
    Ok(())
}

fn settings(args: &MachineArgs) -> Settings {
    let blu = args.blu.unwrap_or_else(|| Decimal::scaled(1, 2).unwrap_or_default());
    let mut choices = if args.method.is_empty() { Choice::ALL.to_vec() } else { args.method.clone() };
    for choice in &mut choices {
        choice.centred = args.centred;
    }
    Settings {
        scale: args.steps_per_mm.map_or(Scale::Blu(blu), Scale::Steps),
        tick: args.tick,
        rapid: args.rapid,
        bits: args.bits,
        choices,
        rules: if args.feed.is_empty() { Rule::ALL.to_vec() } else { args.feed.clone() },
        program: program::Options {
            skip_optional: args.block_delete,
            tolerance: args.arc_tolerance.map_or_else(Tolerance::default, |mm| Tolerance::of(mm.to_f64())),
        },
    }
}

/// Prints warnings, and ends with the errors if there are any.
fn told(faults: &Faults) -> Result<(), CliError> {
    let rendered = faults.diagnostics.render(&faults.sources, false);
    if faults.diagnostics.has_errors() {
        return Err(CliError::Input(rendered));
    }
    if !faults.diagnostics.is_empty() {
        CliError::Input(rendered).print();
    }
    Ok(())
}

fn canon(source: &mut Source, settings: &Settings, out: &mut Out) -> Result<Status, CliError> {
    let mut failed = None;
    let mut faults = Faults::default();
    let read = program::read(source.begin()?, &source.name, settings.program, &mut faults, |line, canon| {
        if interrupt::interrupted() {
            return Err(Refusal::Stop);
        }
        for text in canon.to_string().lines() {
            if let Err(error) = out.write_fmt(format_args!("{:>6} {text}\n", line.number)) {
                failed = Some(error);
                return Err(Refusal::Stop);
            }
        }
        Ok(())
    });
    source.read(read)?;
    match failed {
        Some(error) => Err(error),
        None => out.flush().map(|()| Status::Done),
    }
}

/// A program that can be read twice.
struct Source {
    name: String,
    file: File,
    bytes: Option<u64>,
}

impl Source {
    /// Standard input and pipes are kept in a file first, which nobody else sees.
    fn open(path: &Path) -> Result<Source, CliError> {
        let (name, mut from): (String, Box<dyn Read>) = if path.as_os_str() == "-" {
            ("<stdin>".to_owned(), Box::new(io::stdin().lock()))
        } else {
            let name = path.display().to_string();
            let fault = |source| CliError::Io { message: format!("cannot read `{name}`"), source };
            let file = File::open(path).map_err(fault)?;
            let about = file.metadata().map_err(fault)?;
            if about.is_dir() {
                return Err(CliError::usage(format!("`{name}` is a folder")).with_hint("name a part program"));
            }
            if about.is_file() {
                crate::files::reads(path);
                return Ok(Source { name, file, bytes: Some(about.len()) });
            }
            (name, Box::new(file))
        };
        let fault = |source| CliError::Io { message: format!("cannot keep what `{name}` gives"), source };
        let mut file = tempfile::tempfile().map_err(fault)?;
        let bytes = io::copy(&mut from, &mut file).map_err(fault)?;
        Ok(Source { name, file, bytes: Some(bytes) })
    }

    fn begin(&mut self) -> Result<impl BufRead + use<>, CliError> {
        let name = &self.name;
        let fault = |source| CliError::Io { message: format!("cannot read `{name}`"), source };
        self.file.seek(SeekFrom::Start(0)).map_err(fault)?;
        Ok(BufReader::with_capacity(1 << 16, self.file.try_clone().map_err(fault)?))
    }

    fn read<T>(&self, result: io::Result<T>) -> Result<T, CliError> {
        result.map_err(|source| CliError::Io { message: format!("cannot read `{}`", self.name), source })
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// How far reading is, and whether the user wants it to stop.
struct Watch {
    progress: Progress,
    moves: u64,
}

impl Watch {
    fn new(label: &str, bytes: Option<u64>) -> Watch {
        Watch { progress: Progress::new(label, "bytes", bytes), moves: 0 }
    }

    fn stop(&mut self, bytes: u64) -> bool {
        self.moves += 1;
        if self.moves.is_multiple_of(OFTEN) {
            self.progress.set(bytes);
        }
        interrupt::interrupted()
    }

    fn finish(&mut self, left: &str) -> Result<(), CliError> {
        self.progress.clear();
        if interrupt::interrupted() { Err(CliError::usage(format!("interrupted; {left}"))) } else { Ok(()) }
    }
}

/// What looks at the program being drawn.
struct Seen<'a> {
    settings: &'a Settings,
    csv: Option<Vec<u8>>,
    picture: Option<Picture>,
    record: Option<Record>,
}

/// The same with a place for its text.
struct ToOut<'a> {
    seen: Seen<'a>,
    out: &'a mut Out,
    failed: Option<CliError>,
}

impl See for ToOut<'_> {
    fn clock(&mut self, index: usize, point: &Point) {
        if index > 0 {
            return;
        }
        if let Some(picture) = &mut self.seen.picture {
            picture.clock(point);
        }
        if let Some(record) = &mut self.seen.record {
            record.clock(point);
        }
    }

    fn begin(&mut self, plan: &Plan, line: Line<'_>) {
        if let Some(record) = &mut self.seen.record {
            record.line(line.number);
        }
        if let Some(picture) = &mut self.seen.picture {
            picture.begin(plan);
        }
    }

    fn wait(&mut self, seconds: f64) {
        if let Some(picture) = &mut self.seen.picture {
            picture.wait(seconds);
        }
    }

    fn block(&mut self, drawn: &Drawn<'_>) -> io::Result<()> {
        if let Some(buffer) = &mut self.seen.csv {
            buffer.clear();
            report::csv(drawn, self.seen.settings, buffer)?;
            if let Err(error) = self.out.bytes(buffer) {
                self.failed = Some(error);
                return Err(io::ErrorKind::Other.into());
            }
        }
        if let Some(record) = &mut self.seen.record {
            record.check()?;
        }
        if drawn.index == 0
            && let Some(picture) = &mut self.seen.picture
        {
            picture.end(drawn);
        }
        Ok(())
    }
}
