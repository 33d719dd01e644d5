//! What is written beside a waveform for the viewers: `run --save`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::CliError;
use super::prepare::Prepared;
use crate::netlist::{Direction, SignalId};
use crate::wave::output::{Destination, Output};
use crate::wave::save::{Role, Shown, View};

/// The nets that `plot` takes for coordinates.
const COORDINATES: [&str; 3] = ["xt", "yt", "zt"];

/// Writes both files beside each waveform that is a file.
///
/// # Errors
/// One that cannot be written.
pub(super) fn beside(prepared: &Prepared, waveforms: &[PathBuf], end: u64) -> Result<Vec<PathBuf>, CliError> {
    let mut written = Vec::new();
    for waveform in waveforms.iter().filter(|path| path.extension().is_some()) {
        let view = view(prepared, waveform, end);
        let mut files =
            vec![(waveform.with_extension("gtkw"), view.gtkwave()), (waveform.with_extension("sucl"), view.surfer())];
        files.extend(view.gtkwave_filters().into_iter().map(|(name, text)| (waveform.with_file_name(name), text)));
        let mappings = view.surfer_mappings();
        if !mappings.is_empty() {
            let folder = waveform.with_file_name(".surfer").join("mappings");
            std::fs::create_dir_all(&folder).map_err(|source| CliError::Io {
                message: format!("cannot make the folder `{}`", folder.display()),
                source,
            })?;
            files.extend(mappings.into_iter().map(|(name, text)| (folder.join(name), text)));
        }
        for (path, text) in files {
            // run.vcd and run.fst have one name for both
            if !written.contains(&path) {
                let mut file = Output::create(&path)?;
                file.write_all(text.as_bytes())?;
                file.complete()?;
                written.push(path);
            }
        }
    }
    Ok(written)
}

fn view(prepared: &Prepared, waveform: &Path, end: u64) -> View {
    let netlist = &prepared.circuit.netlist;
    let clocks: Vec<&str> = prepared.scenario.clocks.iter().map(|clock| clock.name.as_str()).collect();
    let shown = |&id: &SignalId| {
        let signal = netlist.signal(id);
        let mut scopes = Vec::new();
        let mut next = Some(signal.scope);
        while let Some(scope) = next.map(|scope| &netlist.scopes()[scope.index()]) {
            scopes.push(scope.name.clone());
            next = scope.parent;
        }
        scopes.reverse();
        let top = scopes.len() == 1;
        let role = match signal.port {
            _ if top && clocks.contains(&signal.name.as_str()) => Role::Clock,
            Some(Direction::Input) if signal.width == 1 => Role::Control,
            _ => Role::Data,
        };
        let steps = top && signal.width > 1 && COORDINATES.contains(&signal.name.as_str());
        let (width, signed, values) = (signal.width, signal.signed, signal.values.clone());
        Shown { scopes, name: signal.name.clone(), width, role, signed, steps, values }
    };
    let name = waveform.file_name().unwrap_or_default().to_string_lossy();
    View::new(&name, netlist.timescale(), end, prepared.scenario.trace.iter().map(shown).collect())
}
