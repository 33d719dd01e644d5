//! `discreta wave`: a waveform as text.

use std::collections::{HashMap, HashSet};
use std::io::IsTerminal;
use std::path::Path;

use globset::GlobSet;

use super::args::WaveTextArgs;
use super::loading::{faults, rendered_from as rendered};
use super::prepare::circuit_of;
use super::told::styled;
use super::{CliError, Out, Status};
use crate::Timescale;
use crate::circuit::{Circuit, Limits};
use crate::diag::{Diagnostics, Sources, Span};
use crate::netlist::Signal;
use crate::scenario::{TimeText, glob_set};
use crate::wave::read::{ValueKind, Waves};
use crate::wave::text::{Axis, Legible, Picture, Radix, Style, Trace, margin};

/// Characters of a line where no terminal says so.
const WIDTH: usize = 100;

/// Prints the waveform.
///
/// # Errors
/// A file that cannot be read, a glob that matches nothing, times that are none.
pub fn run(args: &WaveTextArgs, out: &mut Out) -> Result<Status, CliError> {
    let mut waves = opened(&args.waveform, args.scope.as_deref(), out)?;
    let signed = globs(&args.signed)?;
    let wanted = globs(&args.signals)?;
    left_out(&waves, |name| {
        let names = names_of(name);
        wanted.is_empty() || wanted.iter().any(|glob| names.iter().any(|name| glob.is_match(name)))
    });
    let (shown, left) = shown(&waves, &wanted, &args.signals)?;
    let time = |text: &Option<String>, option| text.as_deref().map(|t| time(t, option, waves.timescale())).transpose();
    let from = time(&args.from, "--from")?;
    let to = time(&args.to, "--to")?;
    let (begin, end) = (from.unwrap_or(waves.start()), to.unwrap_or(waves.end()));
    if begin > end {
        return Err(CliError::usage("the window ends before it begins").with_hint("let --from be before --to"));
    }
    let circuit = declaring(args.circuit.as_deref())?;
    let mut traces = Vec::new();
    let loaded = Trace::load_all(&mut waves, &shown)?;
    for (var, trace) in shown.into_iter().zip(loaded) {
        let known = circuit.as_ref().and_then(|circuit| declared(circuit, &waves, var));
        let is_signed = names(&waves, var).iter().any(|name| signed.iter().any(|glob| glob.is_match(name)));
        let is_signed = is_signed || args.radix == Radix::Auto && known.is_some_and(|signal| signal.signed);
        let radix = if is_signed { Radix::Signed } else { args.radix };
        let values = known.and_then(|signal| signal.values.clone());
        traces.push(Trace { values, radix, ..trace });
    }
    // rows of one scope stand together, where the first of them stands
    if args.signals.is_empty() {
        let mut order: HashMap<String, usize> = HashMap::new();
        for trace in &traces {
            let next = order.len();
            order.entry(trace.scope.clone()).or_insert(next);
        }
        traces.sort_by_key(|t| order.get(&t.scope).copied());
    }
    let style = Style { ascii: args.ascii, color: true };
    let columns = width(args.width).saturating_sub(margin(&traces));
    let legible = if to.is_some() { Legible::Whole } else { Legible::Begin };
    let axis = Axis::new(&traces, begin, end, columns.max(10), legible);
    let axis = if axis.to == waves.end() { axis.with_end(columns) } else { axis };
    let picture = Picture { traces: &traces, timescale: waves.timescale(), axis, mark: None, style };
    out.styled(&picture.to_string())?;
    let more = if args.ascii { "..." } else { "…" };
    if axis.to < end {
        let timescale = waves.timescale();
        let (next, end) = (written(timescale, axis.to + 1), written(timescale, end));
        out.write_fmt(format_args!("{more} until {end}: go on with --from {next}, or see all with --to {end}\n"))?;
    }
    if left > 0 {
        out.write_fmt(format_args!("{more} and {left} signals in scopes below: --signals '**' shows all\n"))?;
    }
    Ok(Status::Done)
}

/// Opens a waveform, and tells what is doubtful about it, but for what is left out of it.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn open(path: &Path, out: &mut Out) -> Result<Waves, CliError> {
    let waves = Waves::open(path)?;
    for text in waves.warnings() {
        warn(&format!("`{}`: {text}", path.display()));
    }
    out.incomplete(waves.is_cut());
    Ok(waves)
}

/// Tells which variables are left out of a waveform, of those that `wanted` takes by their full names.
pub(super) fn left_out(waves: &Waves, wanted: impl Fn(&str) -> bool) {
    const SHOWN: usize = 20;
    let mut more = 0;
    for (n, out) in waves.left_out().iter().filter(|out| wanted(&out.name)).enumerate() {
        if n < SHOWN {
            warn(&format!("`{}`: `{}` is left out: {}", waves.path().display(), out.name, out.why));
        } else {
            more += 1;
        }
    }
    if more > 0 {
        warn(&format!("`{}`: and {more} more are left out", waves.path().display()));
    }
}

/// A sentence without its end, to standard error. Names in it come from a file.
fn warn(text: &str) {
    styled(&format!("\x1b[1;33mwarning\x1b[0m: {}\n", crate::safe::name(text)));
}

/// A waveform, or what is below a scope of it.
///
/// # Errors
/// A file that cannot be read, a scope that is not there.
pub(super) fn opened(path: &Path, scope: Option<&str>, out: &mut Out) -> Result<Waves, CliError> {
    let mut waves = open(path, out)?;
    if let Some(scope) = scope {
        let found = waves.scope(scope).ok_or_else(|| no_scope(&waves, scope))?;
        waves.narrow(&found);
    }
    Ok(waves)
}

/// A circuit that says more of a waveform.
pub(super) fn declaring(path: Option<&Path>) -> Result<Option<Circuit>, CliError> {
    let load = |path: &Path| {
        let mut loader = super::loading::plain(Limits::default());
        let circuit = circuit_of(&mut loader, path, &[]);
        faults(&mut loader, circuit)
    };
    path.map(load).transpose()
}

/// What to say of a scope that a waveform does not have.
pub(super) fn no_scope(waves: &Waves, scope: &str) -> CliError {
    let text = format!("`{}` has no scope `{scope}`: {}", waves.path().display(), waves.scopes_there());
    let nearest = crate::diag::nearest(scope, waves.scopes().iter().map(String::as_str));
    CliError::usage(text).with_hint(match nearest {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => "write its path from the top down, as in bench.dut".to_owned(),
    })
}

/// The characters of a line.
pub(super) fn width(given: Option<u16>) -> usize {
    let terminal = || terminal_size::terminal_size().filter(|_| std::io::stdout().is_terminal());
    given.map(usize::from).or_else(|| terminal().map(|(width, _)| usize::from(width.0))).unwrap_or(WIDTH)
}

/// A time as it can be typed.
fn written(timescale: Option<Timescale>, ticks: u64) -> String {
    timescale.map_or_else(|| ticks.to_string(), |t| t.time(ticks).replace(' ', ""))
}

pub(super) fn globs(texts: &[String]) -> Result<Vec<GlobSet>, CliError> {
    let glob = |text: &String| glob_set(text).map_err(|e| CliError::usage(format!("`{text}` is no pattern: {e}")));
    texts.iter().map(glob).collect()
}

/// The names by which a variable can be matched, with `/` between scopes: the full one, and that below the top module.
pub(super) fn names(waves: &Waves, var: usize) -> Vec<String> {
    names_of(&waves.vars()[var].name)
}

fn names_of(name: &str) -> Vec<String> {
    let full = name.replace('.', "/");
    let below = full.split_once('/').map(|(_, rest)| rest.to_owned());
    [Some(full), below].into_iter().flatten().collect()
}

/// What a circuit says of a variable: its signal of the same path and width below the top.
pub(super) fn declared<'c>(circuit: &'c Circuit, waves: &Waves, var: usize) -> Option<&'c Signal> {
    let var = &waves.vars()[var];
    let (_, path) = var.name.split_once('.')?;
    let signal = circuit.netlist.signal(circuit.netlist.find(path)?);
    (ValueKind::Bits(signal.width) == var.kind).then_some(signal)
}

/// The variables to show, and how many further down are left out because nothing asked for them.
fn shown(waves: &Waves, globs: &[GlobSet], texts: &[String]) -> Result<(Vec<usize>, usize), CliError> {
    let vars = || 0..waves.vars().len();
    // several names of one thing are one row
    let originals = waves.originals();
    let mut list = Vec::new();
    if globs.is_empty() {
        let depth = |var: usize| waves.vars()[var].scope().matches('.').count();
        let top = vars().map(depth).min();
        let (mut shown, mut left) = (HashSet::new(), HashSet::new());
        for var in vars() {
            if Some(depth(var)) != top {
                left.insert(originals[var]);
            } else if shown.insert(originals[var]) {
                list.push(var);
            }
        }
        return Ok((list, left.difference(&shown).count()));
    }
    let mut listed = HashSet::new();
    for (glob, text) in globs.iter().zip(texts) {
        let mut known = HashSet::new();
        let mut any = false;
        for var in vars().filter(|&var| names(waves, var).iter().any(|name| glob.is_match(name))) {
            any = true;
            // a signal under several of its names is one row, but each pattern shows the one that it names
            if !listed.contains(&var) && known.insert(originals[var]) {
                listed.insert(var);
                list.push(var);
            }
        }
        if !any {
            let fault = CliError::usage(format!("no signal of `{}` matches `{text}`", waves.path().display()));
            return Err(fault.with_hint("`*` stays in a scope, `**` crosses them"));
        }
    }
    Ok((list, 0))
}

/// A time of the command line in ticks of the waveform.
pub(super) fn time(text: &str, option: &str, timescale: Option<Timescale>) -> Result<u64, CliError> {
    let mut sources = Sources::default();
    let file = sources.add(option, text.to_owned());
    let parsed = TimeText::parse(text, Span::new(file, 0, text.len() as u32));
    let ticks = parsed.and_then(|time| time.ticks(timescale.unwrap_or_default(), &()));
    ticks.map_err(|fault| {
        let mut faults = Diagnostics::new();
        faults.push(fault);
        CliError::Input(rendered(&faults, &sources))
    })
}
