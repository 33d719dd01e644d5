//! `discreta diff`: two waveforms, and where they first differ.

use super::args::{DiffArgs, DontCare};
use super::wave::{left_out, no_scope, open, width};
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
    let options = Options {
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
