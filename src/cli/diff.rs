//! `discreta diff`: two waveforms, and where they first differ.

use super::args::{DiffArgs, DontCare};
use super::wave::width;
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
    let options = Options {
        x_as_dont_care: args.ignore_x.map(|side| match side {
            DontCare::A => Side::A,
            DontCare::B => Side::B,
        }),
        ignore_end: args.ignore_end,
        max_signals: args.max,
        context: args.context.into(),
        scope: args.scope.clone(),
    };
    let (mut a, mut b) = (Waves::open(&args.a)?, Waves::open(&args.b)?);
    if let Some(scope) = args.scope.as_deref().filter(|s| !diff::has_scope(&a, s) && !diff::has_scope(&b, s)) {
        return Err(CliError::usage(format!("neither waveform has anything below `{scope}`")));
    }
    let difference = diff::diff(&mut a, &mut b, &options)?;
    match args.format.format {
        Format::Text => {
            write!(out, "{difference}")?;
            let style = Style { ascii: false, color: true };
            if let Some(picture) = around(&mut a, &mut b, &difference, ["a", "b"], width(None), style)? {
                write!(out, "\n{picture}")?;
            }
        }
        Format::Json => out.json(&difference)?,
    }
    Ok(Status::of(difference.same))
}
