//! What a circuit's nets are in the waveform that drives it, and whether they were the same in the run.

use super::names::{Mismatch, named};
use super::{Finder, Replay, differs};
use crate::diag::{Code, Diagnostic};
use crate::netlist::{Direction, Netlist, SignalId};
use crate::scenario::glob::{glob_path, glob_set};
use crate::scenario::stimulus::Loose;
use crate::wave::Layout;
use crate::wave::diff::{Difference, KindDifference, Options, Side, diff_pairs};
use crate::wave::read::{ReadError, Waves};
use crate::wave::select::Pick;

/// What is compared.
#[derive(Debug)]
pub struct Expected {
    /// The nets, in the order of the circuit.
    pub signals: Vec<SignalId>,
    /// For each of them its variables in the waveform, and the bits that they are.
    parts: Vec<Vec<(usize, u32, u32)>>,
    /// Nets that are there with another width: name, and what each is.
    unlike: Vec<(String, String, String)>,
    loose: Option<Loose>,
}

impl Expected {
    /// Every net that people named and that is in the scope or below it, but inputs.
    pub(super) fn find(finder: &mut Finder<'_>, scope: &str) -> Option<Expected> {
        let (netlist, wave) = (finder.netlist, finder.wave);
        let mut ignored = Vec::new();
        for glob in &wave.ignore {
            match glob_set(glob) {
                Ok(set) => ignored.push((glob, set, false)),
                Err(why) => {
                    let text = format!("`{}` is not a pattern for nets: {why}", glob.value);
                    finder.diagnostics.push(Diagnostic::new(Code::BadGlob, text).at(glob.span, ""));
                }
            }
        }
        let loose = wave.ignore_x.as_ref().map(|side| side.value);
        let mut expected = Expected { signals: Vec::new(), parts: Vec::new(), unlike: Vec::new(), loose };
        for signal in named(netlist) {
            let s = netlist.signal(signal);
            if s.is_top_port() && s.port == Some(Direction::Input) {
                continue;
            }
            let path = glob_path(netlist, signal);
            let mut skip = false;
            for (_, set, used) in &mut ignored {
                if set.is_match(&path) {
                    (skip, *used) = (true, true);
                }
            }
            if skip {
                continue;
            }
            let path = netlist.signal_path(signal);
            match finder.names.parts(scope, &path, s.width) {
                Ok(parts) => {
                    expected.signals.push(signal);
                    expected.parts.push(parts.iter().map(|part| (part.var, part.at, part.width)).collect());
                }
                Err(Mismatch::Missing) => {}
                Err(other) if s.is_top_port() => {
                    let fault = Diagnostic::new(Code::WidthMismatch, differs(&path, s.width, other));
                    finder.diagnostics.push(fault.at(wave.wave.span, "this waveform"));
                }
                Err(other) => {
                    let bits = |n: u32| if n == 1 { "1 bit".to_owned() } else { format!("{n} bits") };
                    let there = match other {
                        Mismatch::Kind(kind) => kind.to_string(),
                        Mismatch::Width(n) | Mismatch::Bits(n) => bits(n),
                        Mismatch::Missing => continue,
                    };
                    expected.unlike.push((path, there, bits(s.width)));
                }
            }
        }
        for (glob, _, used) in &ignored {
            if !used {
                let text = format!("`{}` matches no net", glob.value);
                finder.diagnostics.push(Diagnostic::new(Code::NoMatch, text).at(glob.span, ""));
            }
        }
        if expected.signals.is_empty() && expected.unlike.is_empty() {
            let text = format!("there is nothing to compare: {} has no other net of the circuit", finder.place(scope));
            let fault = Diagnostic::new(Code::BadWave, text).at(wave.wave.span, "");
            return finder.fault(fault.help("record the outputs too, or name another scope"));
        }
        Some(expected)
    }

    /// The layout of a waveform of what is compared, and, for each of [`signals`](Expected::signals), its variables.
    #[must_use]
    pub fn layout(&self, netlist: &Netlist) -> (Layout, Vec<Vec<Pick>>) {
        let mut layout = Layout { timescale: netlist.timescale(), ..Layout::default() };
        let scope = layout.scope("run", None);
        let pick = |&(_, lo, width): &(usize, u32, u32)| {
            let name = format!("v{}", layout.vars.len());
            Pick { var: layout.var(scope, &name, width), lo, width }
        };
        let mut pick = pick;
        let picks = self.parts.iter().map(|parts| parts.iter().map(&mut pick).collect()).collect();
        (layout, picks)
    }
}

impl Replay {
    /// Compares a run with what was expected. `run` is the waveform of it, with the [layout](Expected::layout) of what
    /// is compared. None if nothing was expected.
    ///
    /// # Errors
    /// Damaged values.
    pub fn compare(&mut self, mut run: Waves) -> Result<Option<Difference>, ReadError> {
        let Some(expected) = &self.expected else { return Ok(None) };
        let options = Options {
            x_as_dont_care: expected.loose.map(|side| match side {
                Loose::Wave => Side::A,
                Loose::Run => Side::B,
            }),
            ignore_end: true,
            ..Options::default()
        };
        let vars = expected.parts.iter().flatten().map(|&(var, _, _)| var);
        let mut pairs = Vec::new();
        for (i, var) in vars.enumerate() {
            pairs.extend(run.find(&format!("run.v{i}")).map(|run| (var, run)));
        }
        let mut difference = diff_pairs(&mut self.waves, &mut run, &pairs, &options)?;
        difference.a.name = format!("expected ({})", self.waves.path().display());
        difference.b.name = "this run".to_owned();
        for (name, a, b) in &expected.unlike {
            difference.same = false;
            let unlike = || KindDifference { name: name.clone(), a: a.clone(), b: b.clone() };
            difference.kinds.push(options.max_signals, unlike);
        }
        Ok(Some(difference))
    }
}
