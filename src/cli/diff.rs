//! `discreta diff`: two waveforms, and where they first differ.

use std::collections::{BTreeMap, BTreeSet};

use super::args::{Assignment, DiffArgs, DontCare};
use super::told::tell;
use super::wave::{globs, left_out, names, no_scope, open, time, width};
use super::{CliError, Format, Out, Status};
use crate::wave::diff::{self, Options, Side};
use crate::wave::read::Waves;
use crate::wave::text::Style;
use crate::wave::text::around::around;

/// Compares, and prints the report.
///
/// # Errors
/// One of the files cannot be read, or the report not be written.
pub fn run(args: &DiffArgs, out: &mut Out) -> Result<Status, CliError> {
    let (mut a, mut b) = (open(&args.a, out)?, open(&args.b, out)?);
    left_out(&a, |_| true);
    left_out(&b, |_| true);
    let common = a.exponent().into_iter().chain(b.exponent()).min().and_then(crate::Timescale::from_exponent);
    let at = |text: &Option<String>, option: &str| text.as_deref().map(|text| time(text, option, common)).transpose();
    let (from, until) = (at(&args.from, "--from")?.unwrap_or(0), at(&args.to, "--to")?.unwrap_or(u64::MAX));
    if from > until {
        return Err(CliError::usage("--from is after --to"));
    }
    let options = Options {
        ignored: ignored([&a, &b], &args.ignore)?,
        renamed: renamed(&a, &b, &args.map),
        from,
        until,
        x_as_dont_care: args.ignore_x.map(|side| match side {
            DontCare::A => Side::A,
            DontCare::B => Side::B,
        }),
        ignore_end: args.ignore_end,
        max_signals: args.max,
        context: args.context.into(),
        scopes: scopes(&a, &b, &args.scope)?,
    };
    let difference = diff::diff(&mut a, &mut b, &options)?;
    if difference.compared == 0 && difference.kinds.count == 0 {
        let text = format!("`{}` and `{}` have no signal of the same name", a.path().display(), b.path().display());
        let there = |waves: &Waves| format!("`{}`: {}", waves.path().display(), waves.scopes_there());
        return Err(CliError::usage(format!("{text}; {}; {}", there(&a), there(&b)))
            .with_hint("say where the circuit stands by --scope, once, or for each of the two"));
    }
    match args.format.format {
        Format::Text => {
            write!(out, "{difference}")?;
            let style = Style { ascii: false, color: true };
            if let Some(picture) = around(&mut a, &mut b, &difference, ["a", "b"], width(None), style)? {
                out.styled(&format!("\n{picture}"))?;
            }
        }
        Format::Json => out.json(&difference)?,
    }
    Ok(Status::of(difference.same))
}

/// Which signal of the second stands for one of the first: by names as they are typed, or in full.
fn renamed(a: &Waves, b: &Waves, maps: &[Assignment]) -> BTreeMap<String, String> {
    let full = |waves: &Waves, typed: &str| {
        let path = typed.replace('.', "/");
        let var = (0..waves.vars().len()).find(|&var| names(waves, var).contains(&path));
        var.map_or_else(|| typed.to_owned(), |var| waves.vars()[var].name.clone())
    };
    let typed = maps.iter().map(|map| (map.name.clone(), map.value.clone()));
    let in_full = maps.iter().map(|map| (full(a, &map.name), full(b, &map.value)));
    typed.chain(in_full).collect()
}

/// The signals of both that match a pattern, in full or from below the top module.
fn ignored(both: [&Waves; 2], texts: &[String]) -> Result<BTreeSet<String>, CliError> {
    let mut ignored = BTreeSet::new();
    for (glob, text) in globs(texts)?.iter().zip(texts) {
        let before = ignored.len();
        for waves in both {
            let matching =
                (0..waves.vars().len()).filter(|&var| names(waves, var).iter().any(|name| glob.is_match(name)));
            ignored.extend(matching.map(|var| waves.vars()[var].name.clone()));
        }
        if ignored.len() == before && !texts.is_empty() {
            tell!("warning: `{text}` matches no other signal\n");
        }
    }
    Ok(ignored)
}

/// What is compared of each waveform: what is below the scope that was named. Where only one has that, the other is compared
/// from the scope on below which it has the same names.
fn scopes(a: &Waves, b: &Waves, given: &[String]) -> Result<[String; 2], CliError> {
    let of = |waves: &Waves, scope: &str| waves.scope(scope).ok_or_else(|| no_scope(waves, scope));
    Ok(match given {
        [] => <[String; 2]>::default(),
        [one] => match (a.scope(one), b.scope(one)) {
            (Some(in_a), Some(in_b)) => [in_a, in_b],
            (Some(in_a), None) => {
                let in_b = b.counterpart(a, &in_a).unwrap_or_default();
                [in_a, in_b]
            }
            (None, Some(in_b)) => [a.counterpart(b, &in_b).unwrap_or_default(), in_b],
            (None, None) => return Err(no_scope(a, one)),
        },
        [in_a, in_b, ..] => [of(a, in_a)?, of(b, in_b)?],
    })
}
