//! Comparing a run with the waveform that drives it: what is compared is recorded aside, in a file that is gone afterwards.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Write};

use tempfile::NamedTempFile;

use super::CliError;
use super::prepare::Prepared;
use crate::netlist::SignalId;
use crate::scenario::{Outcome, Scenario, layout};
use crate::wave::Sink;
use crate::wave::diff::Difference;
use crate::wave::output::Destination;
use crate::wave::read::Waves;
use crate::wave::select::{Pick, Select, Tee};
use crate::wave::vcd::VcdWriter;

/// The file aside.
struct Aside(File);

impl Write for Aside {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Destination for Aside {
    fn complete(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Runs a scenario by `go`, which is given it with all traced that is compared, and a sink for that; what `sink` gets is
/// what it would get otherwise. If the waveform that drives it is to be compared with, also says how it compares.
///
/// # Errors
/// What `go` says, or a file that cannot be kept or read.
pub(super) fn compared(
    prepared: &mut Prepared,
    sink: Option<&mut dyn Sink>,
    go: impl FnOnce(&Prepared, &Scenario, Option<&mut dyn Sink>) -> Result<Outcome, CliError>,
) -> Result<(Outcome, Option<Difference>), CliError> {
    let Some(expected) = prepared.replay.as_ref().and_then(|replay| replay.expected()) else {
        return Ok((go(prepared, &prepared.scenario, sink)?, None));
    };
    let cannot = |source| CliError::Io { message: "cannot keep the run for comparison".to_owned(), source };
    let file = tempfile::Builder::new().suffix(".vcd").tempfile().map_err(cannot)?;
    let netlist = &prepared.circuit.netlist;
    let mut scenario = prepared.scenario.clone();
    let recorded = if sink.is_some() { std::mem::take(&mut scenario.trace) } else { Vec::new() };
    let all: BTreeSet<SignalId> = recorded.iter().chain(&expected.signals).copied().collect();
    scenario.trace = all.into_iter().collect();
    // of each signal that is traced, where it goes
    let whereto = |signals: &[SignalId], mut picks: Vec<Vec<Pick>>| -> Vec<Vec<Pick>> {
        let place = |signal: &SignalId| signals.binary_search(signal).ok();
        scenario.trace.iter().map(|s| place(s).map_or_else(Vec::new, |i| std::mem::take(&mut picks[i]))).collect()
    };

    let (own, picks) = expected.layout(netlist);
    let mut writer = VcdWriter::new(Aside(file.reopen().map_err(cannot)?));
    let mut aside = Select::new(&mut writer, own, whereto(&expected.signals, picks));
    let outcome = match sink {
        None => go(prepared, &scenario, Some(&mut aside))?,
        Some(sink) => {
            let whole =
                |(var, &signal): (usize, &SignalId)| vec![Pick { var, lo: 0, width: netlist.signal(signal).width }];
            let picks = recorded.iter().enumerate().map(whole).collect();
            let mut outer = Select::new(sink, layout(netlist, &recorded), whereto(&recorded, picks));
            go(prepared, &scenario, Some(&mut Tee(vec![&mut outer as &mut dyn Sink, &mut aside])))?
        }
    };
    drop(writer);
    let difference = difference(prepared, &file)?;
    Ok((outcome, difference))
}

fn difference(prepared: &mut Prepared, file: &NamedTempFile) -> Result<Option<Difference>, CliError> {
    let Some(replay) = &mut prepared.replay else { return Ok(None) };
    Ok(replay.compare(Waves::open(file.path())?)?)
}
