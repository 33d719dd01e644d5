//! What a circuit's nets are in the waveform that drives it, and whether they were the same in the run.

use std::collections::HashMap;

use super::names::{Found, Mismatch, Part, named};
use super::{Finder, Replay, differs, tick};
use crate::Value;
use crate::diag::{Code, Diagnostic};
use crate::netlist::{Direction, Netlist, SignalId};
use crate::scenario::glob::{glob_path, glob_set};
use crate::syntax::stimulus::Loose;
use crate::value::Word;
use crate::value::word::words;
use crate::wave::Layout;
use crate::wave::diff::{Difference, KindDifference, Options, Same, Side, diff_pairs};
use crate::wave::play::Tracks;
use crate::wave::read::{ReadError, Waves};
use crate::wave::select::Pick;

/// What is compared.
#[derive(Debug)]
pub struct Expected {
    /// The nets, in the order of the circuit.
    pub signals: Vec<SignalId>,
    /// For each of them its variables in the waveform.
    parts: Vec<Vec<Compared>>,
    /// Those of which synthesis has cut bits off, on either side.
    cut: Vec<Cut>,
    /// Nets that are there with another width: name, and what each is.
    unlike: Vec<(String, String, String)>,
    loose: Option<Loose>,
}

/// A variable of the waveform and the bits of the net that its lowest bits are compared with.
#[derive(Clone, Copy, Debug)]
struct Compared {
    var: usize,
    at: u32,
    width: u32,
    reversed: bool,
}

/// A net of which the waveform and the circuit have different numbers of bits: the lower ones are compared, the others
/// must be constant, or repeat the sign.
#[derive(Debug)]
struct Cut {
    name: String,
    /// Its place among the signals.
    place: usize,
    wave: Found,
    /// Bits of the circuit.
    width: u32,
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
        let mut expected =
            Expected { signals: Vec::new(), parts: Vec::new(), cut: Vec::new(), unlike: Vec::new(), loose };
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
            match finder.names.net(scope, &path, s) {
                Ok(found) if found.width != s.width && s.is_top_port() => {
                    let differs = differs(&path, s.width, found.mismatch());
                    let fault = Diagnostic::new(Code::WidthMismatch, differs);
                    finder.diagnostics.push(fault.at(wave.wave.span, "this waveform"));
                }
                Ok(found) if found.width != s.width && !found.begins_as(s) => {
                    expected.unlike.push((path, bits(found.width), bits(s.width)));
                }
                Ok(found) => {
                    let left = if s.port.is_some() { s.width } else { left(netlist, signal) };
                    if left == 0 {
                        continue;
                    }
                    let parts = found.parts.iter().filter(|part| part.at < left);
                    let compared = |&Part { var, at, width, reversed }: &Part| Compared {
                        var,
                        at,
                        width: width.min(left - at),
                        reversed,
                    };
                    expected.parts.push(parts.map(compared).collect());
                    if found.width != left {
                        let place = expected.signals.len();
                        expected.cut.push(Cut { name: path, place, wave: found, width: left });
                    }
                    expected.signals.push(signal);
                }
                Err(Mismatch::Missing) => {}
                Err(other) if s.is_top_port() => {
                    let fault = Diagnostic::new(Code::WidthMismatch, differs(&path, s.width, other));
                    finder.diagnostics.push(fault.at(wave.wave.span, "this waveform"));
                }
                Err(other) => {
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
        // what a circuit prints can be looked at without any net
        if expected.signals.is_empty() && expected.unlike.is_empty() && !finder.speaks {
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
        let mut picks: Vec<Vec<Pick>> = Vec::new();
        let mut count = 0;
        for parts in &self.parts {
            let mut pick = |&Compared { at, width, .. }: &Compared| {
                let name = format!("v{count}");
                count += 1;
                Pick { var: layout.var(scope, &name, width), lo: at, width }
            };
            picks.push(parts.iter().map(&mut pick).collect());
        }
        for cut in self.cut.iter().filter(|cut| cut.width > cut.wave.width) {
            let var = layout.var(scope, &format!("w{}", cut.place), cut.width);
            picks[cut.place].push(Pick { var, lo: 0, width: cut.width });
        }
        (layout, picks)
    }
}

/// What a waveform has of some signals: each change, in ticks of the circuit.
pub type Golden = HashMap<SignalId, Vec<(u64, Value)>>;

impl Replay {
    /// What the waveform has of all that is to be compared, of those that `wanted` chooses.
    ///
    /// # Errors
    /// Damaged values.
    pub fn golden(&mut self, wanted: impl Fn(SignalId) -> bool) -> Result<Golden, ReadError> {
        let mut golden = Golden::new();
        let Some(expected) = &self.expected else { return Ok(golden) };
        for (signal, parts) in expected.signals.iter().zip(&expected.parts).filter(|(signal, _)| wanted(**signal)) {
            let width = parts.iter().map(|part| part.at + part.width).max().unwrap_or(0);
            let vars: Vec<usize> = parts.iter().map(|part| part.var).collect();
            let tracks = Tracks::load(&mut self.waves, &vars)?;
            let mut player = tracks.play(&self.waves);
            let mut value = vec![Word::x(u64::MAX); words(width)];
            let list = golden.entry(*signal).or_default();
            while let Some(time) = player.time() {
                player.step(&mut |lane, bits| {
                    let Compared { at, width, reversed, .. } = parts[lane];
                    bits.write(&mut value, at, width, reversed);
                });
                list.push((tick(self.scale, time), Value::from_words(&value, width)));
            }
            list.dedup_by(|later, earlier| {
                // of two at one tick the last counts
                let same = later.0 == earlier.0;
                if same {
                    std::mem::swap(later, earlier);
                }
                same
            });
        }
        Ok(golden)
    }

    /// On which side x agrees with anything: in the waveform, in the run.
    #[must_use]
    pub fn loose(&self) -> [bool; 2] {
        let loose = self.expected.as_ref().and_then(|expected| expected.loose);
        [loose == Some(Loose::Wave), loose == Some(Loose::Run)]
    }

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
        let mut pairs = Vec::new();
        for (i, compared) in expected.parts.iter().flatten().enumerate() {
            let of_run = run.find(&format!("run.v{i}"));
            pairs.extend(of_run.map(|run| Same { a: compared.var, b: run, reversed: compared.reversed }));
        }
        let mut unlike = expected.unlike.clone();
        let end = run.end();
        for cut in &expected.cut {
            let settled = if cut.wave.width > cut.width {
                let tick = |time| tick(self.scale, time);
                settled(&mut self.waves, &cut.wave.parts, cut.width, |time| tick(time) <= end)?
            } else {
                let var = run.find(&format!("run.w{}", cut.place));
                let whole = var.map(|var| Part { var, at: 0, width: cut.width, reversed: false });
                settled(&mut run, whole.as_slice(), cut.wave.width, |_| true)?
            };
            if !settled {
                unlike.push((cut.name.clone(), bits(cut.wave.width), bits(cut.width)));
            }
        }
        let mut difference = diff_pairs(&mut self.waves, &mut run, &pairs, &options)?;
        difference.a.name = format!("expected ({})", self.waves.path().display());
        difference.b.name = "this run".to_owned();
        for (name, a, b) in &unlike {
            difference.same = false;
            let unlike = || KindDifference { name: name.clone(), a: a.clone(), b: b.clone() };
            difference.kinds.push(options.max_signals, unlike);
        }
        Ok(Some(difference))
    }
}

/// Whether all bits of a net from `from` up are constant, or repeat the bit below, as the sign does. What is x may be any.
fn settled(waves: &mut Waves, parts: &[Part], from: u32, counts: impl Fn(u64) -> bool) -> Result<bool, ReadError> {
    let width = parts.iter().map(|part| part.at + part.width).max().unwrap_or(0);
    let vars: Vec<usize> = parts.iter().map(|part| part.var).collect();
    let tracks = Tracks::load(waves, &vars)?;
    let mut player = tracks.play(waves);
    let bit = |value: &[Word], bit: u32| {
        let Word { v, u } = value[bit as usize / 64];
        (v >> (bit % 64) & 1, u >> (bit % 64) & 1)
    };
    let mut value = vec![Word::x(u64::MAX); words(width)];
    // of each of those bits which of 0, 1 and z it has been, and whether it was ever another than the sign
    let mut seen = vec![([false; 3], false); (width.saturating_sub(from)) as usize];
    while player.time().is_some_and(&counts) {
        player.step(&mut |lane, bits| {
            let Part { at, width, reversed, .. } = parts[lane];
            bits.write(&mut value, at, width, reversed);
        });
        let sign = bit(&value, from - 1);
        for (i, (levels, unlike)) in (from..width).zip(&mut seen) {
            let (v, u) = bit(&value, i);
            let is_x = (v, u) == (0, 1);
            levels[if u == 0 { v as usize } else { 2 }] |= !is_x;
            *unlike |= u == 0 && sign.1 == 0 && v != sign.0 || v == 1 && u == 1;
        }
    }
    let constant = |levels: &[bool; 3]| levels.iter().filter(|seen| **seen).count() < 2;
    Ok(seen.iter().all(|(levels, unlike)| constant(levels) || !unlike))
}

/// How many bits are left of a net whose highest bits nothing drives: synthesis takes away what nobody reads, and may
/// leave the name as wide as it was.
fn left(netlist: &Netlist, signal: SignalId) -> u32 {
    let mut left = netlist.signal(signal).width;
    for slice in netlist.bits(signal).iter().rev().take_while(|slice| netlist.is_undriven(slice.net)) {
        left -= slice.width;
    }
    left
}

fn bits(n: u32) -> String {
    if n == 1 { "1 bit".to_owned() } else { format!("{n} bits") }
}
