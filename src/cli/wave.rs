//! `discreta wave`: a waveform as text.

use std::io::IsTerminal;
use std::path::Path;

use globset::GlobSet;

use super::args::WaveTextArgs;
use super::prepare::circuit_of;
use super::run::{faults, rendered_from as rendered};
use super::{CliError, Out, Status};
use crate::Timescale;
use crate::circuit::{Circuit, Limits, Loader};
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
    let mut waves = opened(&args.waveform, args.scope.as_deref())?;
    let signed = globs(&args.signed)?;
    let (shown, left) = shown(&waves, &globs(&args.signals)?, &args.signals)?;
    let time = |text: &Option<String>, option| text.as_deref().map(|t| time(t, option, waves.timescale())).transpose();
    let from = time(&args.from, "--from")?;
    let to = time(&args.to, "--to")?;
    let (begin, end) = (from.unwrap_or(waves.start()), to.unwrap_or(waves.end()));
    if begin > end {
        return Err(CliError::usage("the window ends before it begins").with_hint("let --from be before --to"));
    }
    let circuit = declaring(args.circuit.as_deref())?;
    let mut traces = Vec::new();
    for var in shown {
        let known = circuit.as_ref().and_then(|circuit| declared(circuit, &waves, var));
        let is_signed = names(&waves, var).iter().any(|name| signed.iter().any(|glob| glob.is_match(name)));
        let is_signed = is_signed || args.radix == Radix::Auto && known.is_some_and(|signal| signal.signed);
        let radix = if is_signed { Radix::Signed } else { args.radix };
        let values = known.and_then(|signal| signal.values.clone());
        traces.push(Trace { values, ..Trace::load(&mut waves, var, radix)? });
    }
    // rows of one scope stand together, where the first of them stands
    if args.signals.is_empty() {
        let order: Vec<String> = traces.iter().map(|t| t.scope.clone()).collect();
        traces.sort_by_key(|t| order.iter().position(|scope| *scope == t.scope));
    }
    let style = Style { ascii: args.ascii, color: true };
    let columns = width(args.width).saturating_sub(margin(&traces));
    let legible = if to.is_some() { Legible::Whole } else { Legible::Begin };
    let axis = Axis::new(&traces, begin, end, columns.max(10), legible);
    let axis = if axis.to == waves.end() { axis.with_end(columns) } else { axis };
    out.write_fmt(format_args!(
        "{}",
        Picture { traces: &traces, timescale: waves.timescale(), axis, mark: None, style }
    ))?;
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

/// A waveform, or what is below a scope of it.
///
/// # Errors
/// A file that cannot be read, a scope that is not there.
pub(super) fn opened(path: &Path, scope: Option<&str>) -> Result<Waves, CliError> {
    let mut waves = Waves::open(path)?;
    if let Some(scope) = scope {
        let found = waves.scope(scope).ok_or_else(|| no_scope(&waves, scope))?;
        waves.narrow(&found);
    }
    Ok(waves)
}

/// A circuit that says more of a waveform.
pub(super) fn declaring(path: Option<&Path>) -> Result<Option<Circuit>, CliError> {
    let load = |path: &Path| {
        let mut loader = Loader::new(Limits::default());
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

fn globs(texts: &[String]) -> Result<Vec<GlobSet>, CliError> {
    let glob = |text: &String| glob_set(text).map_err(|e| CliError::usage(format!("`{text}` is no pattern: {e}")));
    texts.iter().map(glob).collect()
}

/// The names by which a variable can be matched, with `/` between scopes: the full one, and that below the top module.
fn names(waves: &Waves, var: usize) -> Vec<String> {
    let var = &waves.vars()[var];
    let full = var.name.replace('.', "/");
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
    let new = |list: &[usize], var: usize| !list.iter().any(|&other| waves.are_one(var, other));
    let mut list = Vec::new();
    if globs.is_empty() {
        let depth = |var: usize| waves.vars()[var].scope().matches('.').count();
        let top = vars().map(depth).min();
        let mut left = Vec::new();
        for var in vars() {
            let to = if Some(depth(var)) == top { &mut list } else { &mut left };
            if new(to, var) {
                to.push(var);
            }
        }
        left.retain(|&var| new(&list, var));
        return Ok((list, left.len()));
    }
    for (glob, text) in globs.iter().zip(texts) {
        let before = list.len();
        let mut any = false;
        for var in vars().filter(|&var| names(waves, var).iter().any(|name| glob.is_match(name))) {
            any = true;
            // a signal under several of its names is one row, but each pattern shows the one that it names
            if !list.contains(&var) && (new(&list[before..], var)) {
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
fn time(text: &str, option: &str, timescale: Option<Timescale>) -> Result<u64, CliError> {
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
