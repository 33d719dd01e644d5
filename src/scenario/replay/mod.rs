//! A waveform in place of a stimulus: what it drives (`names` finds it, `together` says in which order, `feed` does it),
//! and what is compared with it (`expected`).

mod expected;
mod feed;
mod names;
mod together;

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

use crate::Timescale;
use crate::diag::{Code, Diagnostic, Diagnostics, Span};
use crate::elaborate::Circuit;
use crate::json::Spanned;
use crate::netlist::{Bit, Direction, NetId, Netlist, Signal, SignalId};
use crate::syntax::scenario::Simulation;
use crate::syntax::stimulus::WaveStimulus;
use crate::value::Word;
use crate::value::word::words;
use crate::wave::play::Tracks;
use crate::wave::read::{ReadError, Waves};
use crate::wave::scopes::some;

pub use expected::{Expected, Golden};
pub use feed::Feed;
use names::{Mismatch, Names, Part};
use together::{Unit, mask, together};

/// An input that the waveform drives.
#[derive(Debug)]
struct Driven {
    signal: SignalId,
    net: NetId,
    width: u32,
    /// Whether what nothing drives is z: the circuit may drive it too.
    floats: bool,
    /// Those of its bits that are clocks, as a mask of its words.
    clocks: Vec<u64>,
    /// What it changes together with, among the [units](Replay::units).
    unit: usize,
    /// The first of its variables among the [lanes](Replay::lanes).
    lane: usize,
}

/// A variable that is played: the input of which it is a part, the lowest bit of that part, its width.
#[derive(Clone, Copy, Debug)]
struct Lane {
    input: usize,
    at: u32,
    width: u32,
    reversed: bool,
}

impl Lane {
    fn has(&self, bit: u32) -> bool {
        (self.at..self.at + self.width).contains(&bit)
    }

    /// The bit of the variable that is a bit of the input.
    fn bit(&self, bit: u32) -> u32 {
        if self.reversed { self.width - 1 - (bit - self.at) } else { bit - self.at }
    }
}

/// How the ticks of the waveform and those of the circuit go together.
#[derive(Clone, Copy, Debug)]
enum Scale {
    /// One of the waveform is so many of the circuit.
    Times(u64),
    /// So many of the waveform are one of the circuit.
    Over(u64),
}

/// The tick of the circuit for a time of the waveform.
fn tick(scale: Scale, time: u64) -> u64 {
    match scale {
        Scale::Times(n) => time * n,
        Scale::Over(n) => time / n,
    }
}

/// A bit of an input that is a clock.
#[derive(Clone, Debug)]
pub(super) struct ClockBit {
    /// Its name.
    pub name: String,
    lane: usize,
    bit: u32,
}

/// A waveform that drives a circuit.
pub struct Replay {
    waves: Waves,
    scope: String,
    inputs: Vec<Driven>,
    /// What changes together, if one assignment changes all bits of a vector; none if it was said which bits come first.
    units: Option<Vec<Unit>>,
    lanes: Vec<Lane>,
    tracks: Tracks,
    scale: Scale,
    /// The clock whose cycles count.
    clock: Option<ClockBit>,
    expected: Option<Expected>,
}

impl fmt::Debug for Replay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Replay({} in `{}`)", self.waves.path().display(), self.scope)
    }
}

/// Opens the waveform that a scenario names; its path is relative to the file `from`.
pub fn open(wave: &WaveStimulus, from: &str, diagnostics: &mut Diagnostics) -> Option<Waves> {
    let path = Path::new(from).parent().unwrap_or(Path::new("")).join(&*wave.wave.value);
    let opened = Waves::open(&crate::elaborate::normal(&path));
    let fault = |e: crate::wave::read::ReadError| {
        let fault = Diagnostic::new(Code::BadWave, e.to_string()).at(wave.wave.span, "");
        e.hint().into_iter().fold(fault, Diagnostic::help)
    };
    let waves = opened.map_err(|e| diagnostics.push(fault(e))).ok()?;
    let left_out = waves.left_out().iter().map(|out| format!("`{}` is left out: {}", out.name, out.why));
    for text in waves.warnings().into_iter().chain(left_out.take(LEFT_OUT)) {
        diagnostics.push(Diagnostic::new(Code::DoubtfulWave, text).at(wave.wave.span, "this waveform"));
    }
    Some(waves)
}

/// Variables of a waveform that are left out and told of.
const LEFT_OUT: usize = 20;

impl Replay {
    /// Finds the inputs of a circuit, and what is to be compared, in a waveform. Every fault goes into `diagnostics`.
    pub fn new(
        circuit: &Circuit,
        simulation: &Simulation,
        wave: &WaveStimulus,
        mut waves: Waves,
        diagnostics: &mut Diagnostics,
    ) -> Option<Replay> {
        let before = diagnostics.errors();
        let netlist = &circuit.netlist;
        let speaks = !circuit.monitors.is_empty();
        let driven = driven(netlist, simulation);
        let candidates = match wave.scope {
            None => candidates(netlist, &mut waves, &driven),
            Some(_) => Ok(Vec::new()),
        };
        let candidates = match candidates {
            Ok(candidates) => candidates,
            Err(e) => {
                diagnostics.push(Diagnostic::new(Code::BadWave, e.to_string()).at(wave.wave.span, ""));
                return None;
            }
        };
        let finder = Finder { netlist, speaks, wave, waves: &waves, names: Names::new(&waves), diagnostics };
        let (scope, found, expected) = finder.find(driven, &candidates)?;
        let mut vars = Vec::new();
        let (mut inputs, mut lanes) = (Vec::new(), Vec::new());
        for (signal, parts) in found {
            let s = netlist.signal(signal);
            let Some(net) = s.drive else { continue };
            let floats = s.port == Some(Direction::Inout);
            let lane = lanes.len();
            for part in parts {
                let Part { at, width, reversed, .. } = part;
                lanes.push(Lane { input: inputs.len(), at, width, reversed });
                vars.push(part.var);
            }
            let (clocks, unit) = (Vec::new(), 0);
            inputs.push(Driven { signal, net, width: s.width, floats, clocks, unit, lane });
        }
        let tell = |text: String| Diagnostic::new(Code::BadWave, text).at(wave.wave.span, "");
        let tracks = match Tracks::load(&mut waves, &vars) {
            Ok(tracks) => tracks,
            Err(e) => {
                diagnostics.push(tell(e.to_string()));
                return None;
            }
        };
        let units = if wave.first.is_empty() {
            let found = together(netlist, &mut inputs, &lanes, &waves, &tracks, &vars);
            if let Some(gate) = found.ambiguous.first() {
                let more = found.ambiguous.len() - 1;
                diagnostics.push(ambiguous(netlist, &inputs, gate, more).at(wave.wave.span, ""));
            }
            Some(found.units)
        } else {
            let bits = wave.first.iter().flat_map(|name| first(netlist, name, &inputs, diagnostics));
            let bits: BTreeSet<Bit> = bits.collect();
            inputs.iter_mut().for_each(|driven| driven.clocks = mask(driven, |bit| bits.contains(&bit)));
            None
        };
        let scalars = inputs.iter().filter(|driven| driven.width == 1);
        let clock = scalars.chain(inputs.iter().filter(|driven| driven.width > 1)).find_map(|driven| {
            let is_clock = |bit: &u32| driven.clocks[*bit as usize / 64] >> (bit % 64) & 1 == 1;
            let bit = (0..driven.width).find(is_clock)?;
            let own = driven.lane..lanes.len();
            let lane = own.clone().find(|&lane| lanes[lane].has(bit))?;
            Some(ClockBit { name: bit_name(netlist.signal(driven.signal), bit), lane, bit: lanes[lane].bit(bit) })
        });
        let scale = match scale(&waves, netlist.timescale()) {
            Ok(scale) => scale,
            Err(text) => {
                diagnostics.push(tell(text));
                return None;
            }
        };
        let replay = Replay { waves, scope, inputs, units, lanes, tracks, scale, clock, expected };
        replay.on_ticks(netlist, wave.wave.span, diagnostics);
        (diagnostics.errors() == before).then_some(replay)
    }

    /// Tells of changes that are between two ticks of the circuit.
    fn on_ticks(&self, netlist: &Netlist, span: Span, diagnostics: &mut Diagnostics) {
        let Scale::Over(ticks) = self.scale else { return };
        for (lane, &Lane { input, .. }) in self.lanes.iter().enumerate() {
            if let Some(time) = self.tracks.times(&self.waves, lane).find(|time| !time.is_multiple_of(ticks)) {
                let at = self.waves.timescale().map_or_else(|| format!("tick {time}"), |t| t.time(time));
                let name = &netlist.signal(self.inputs[input].signal).name;
                let text = format!(
                    "in the waveform `{name}` changes at {at}, which is not a whole number of ticks of {}",
                    netlist.timescale()
                );
                let fault = Diagnostic::new(Code::BadTime, text).at(span, "");
                diagnostics.push(fault.help("give the circuit a finer `timescale`"));
                return;
            }
        }
    }

    /// Whether the waveform breaks off.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.waves.is_cut()
    }

    /// The waveform's file.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.waves.path()
    }

    /// Where in its hierarchy the circuit stands; empty at the top.
    #[must_use]
    pub fn scope(&self) -> &str {
        &self.scope
    }

    /// The inputs that it drives, in the order of the circuit.
    pub fn inputs(&self) -> impl Iterator<Item = SignalId> + '_ {
        self.inputs.iter().map(|driven| driven.signal)
    }

    /// The nets of those inputs.
    pub fn driven(&self) -> impl Iterator<Item = NetId> + '_ {
        self.inputs.iter().map(|driven| driven.net)
    }

    /// The last tick.
    #[must_use]
    pub fn end(&self) -> u64 {
        self.tick(self.waves.end())
    }

    fn tick(&self, time: u64) -> u64 {
        tick(self.scale, time)
    }

    /// What is compared, if something is.
    #[must_use]
    pub fn expected(&self) -> Option<&Expected> {
        self.expected.as_ref()
    }

    /// The changes from the beginning on.
    #[must_use]
    pub fn feed(&self) -> Feed<'_> {
        Feed::new(self)
    }

    /// The first input, or bit of one, that is a clock, for [`last_of`](Replay::last_of).
    pub(super) fn clock(&self) -> Option<&ClockBit> {
        self.clock.as_ref()
    }

    /// The tick of the falling edge that ends so many cycles of a clock, or the last before its first rising edge; if
    /// it has not as many, how many it has.
    pub(super) fn last_of(&self, clock: &ClockBit, cycles: u64) -> Result<u64, u64> {
        let (mut rises, mut falls, mut high, mut low) = (0, 0, false, false);
        for (time, bit) in self.tracks.bit(&self.waves, clock.lane, clock.bit) {
            let tick = self.tick(time);
            if bit.is_one() && low {
                rises += 1;
                if cycles == 0 {
                    return Ok(tick.saturating_sub(1));
                }
            }
            if bit.is_zero() && high && rises > 0 {
                falls += 1;
                if falls == cycles {
                    return Ok(tick);
                }
            }
            (high, low) = (bit.is_one(), bit.is_zero());
        }
        if cycles == 0 { Ok(self.end()) } else { Err(falls) }
    }
}

/// The bits of an input that are to come first, `a`, `a[3]`, or `a[7:4]`; none if there are no such.
fn first(netlist: &Netlist, name: &crate::syntax::Name, inputs: &[Driven], diagnostics: &mut Diagnostics) -> Vec<Bit> {
    let find = |name: &str| inputs.iter().find(|driven| netlist.signal(driven.signal).name == name);
    if let Some(driven) = find(&name.value) {
        return (0..driven.width).map(|bit| (driven.net, bit)).collect();
    }
    let part = name.value.strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    if let Some((driven, range)) = part.and_then(|(stem, range)| Some((find(stem)?, range))) {
        let (from, to) = range.split_once(':').unwrap_or((range, range));
        let bit = |index: &str| netlist.signal(driven.signal).bit(index.trim().parse().ok()?);
        if let (Some(from), Some(to)) = (bit(from), bit(to)) {
            return (from.min(to)..=from.max(to)).map(|bit| (driven.net, bit)).collect();
        }
    }
    let names = inputs.iter().map(|driven| netlist.signal(driven.signal).name.as_str());
    let text = format!("the waveform drives no input `{}`", name.value);
    let fault = Diagnostic::new(Code::UnknownNet, text).at(name.span, "this cannot come first");
    diagnostics.push(fault.did_you_mean(name, names));
    Vec::new()
}

/// A bit of an input as people write it.
fn bit_name(signal: &Signal, bit: u32) -> String {
    if signal.width == 1 { signal.name.clone() } else { format!("{}[{}]", signal.name, signal.index(bit)) }
}

/// What to say of gates of latches that may be the clock, or data.
fn ambiguous(netlist: &Netlist, inputs: &[Driven], gate: &Bit, more: usize) -> Diagnostic {
    let name = |(net, bit): Bit| {
        let driven = inputs.iter().find(|driven| driven.net == net);
        driven.map_or_else(String::new, |driven| bit_name(netlist.signal(driven.signal), bit))
    };
    let others = match more {
        0 => String::new(),
        1 => " and another".to_owned(),
        n => format!(" and {n} others"),
    };
    let gate = name(*gate);
    let text = format!("`{gate}`{others}, the enable of a latch, sometimes changes at the same time as a clock");
    let clocks: Vec<String> = inputs
        .iter()
        .flat_map(|driven| (0..driven.width).map(move |bit| (driven, bit)))
        .filter(|(driven, bit)| driven.clocks[*bit as usize / 64] >> (bit % 64) & 1 == 1)
        .map(|(driven, bit)| format!("--first {}", name((driven.net, bit))))
        .collect();
    Diagnostic::new(Code::AmbiguousOrder, text)
        .note("here it changes after the clock, as data does")
        .help(format!("if it changes with the clock, say so: `{} --first {gate}`", clocks.join(" ")))
}

/// How ticks go together. Of a file that does not say, one is one of the circuit.
fn scale(waves: &Waves, timescale: Timescale) -> Result<Scale, String> {
    let Some(exponent) = waves.exponent() else { return Ok(Scale::Times(1)) };
    let factor = 10u64.checked_pow(exponent.abs_diff(timescale.exponent()));
    if exponent < timescale.exponent() {
        // what is finer than any number of ticks is on one only at 0
        return Ok(Scale::Over(factor.unwrap_or(u64::MAX)));
    }
    let factor = factor.filter(|n| waves.end().checked_mul(*n).is_some());
    factor.map(Scale::Times).ok_or_else(|| {
        format!("the waveform's last time, {} of its ticks, is more than 2^64-1 ticks of {timescale}", waves.end())
    })
}

/// The inputs that a waveform drives: all that nothing else does.
fn driven(netlist: &Netlist, simulation: &Simulation) -> Vec<SignalId> {
    let given = |name: &str| simulation.inputs.contains_key(name) || simulation.clocks.contains_key(name);
    let input = |&s: &SignalId| netlist.signal(s).drive.is_some() && !given(&netlist.signal(s).name);
    netlist.signal_ids().filter(input).collect()
}

/// Where a circuit may stand: the scopes that have what is wanted, or without that all outputs; one alone if the others
/// have fewer nets of it, or the same with the same values.
fn candidates(netlist: &Netlist, waves: &mut Waves, wanted: &[SignalId]) -> Result<Vec<String>, ReadError> {
    let output = |&s: &SignalId| netlist.signal(s).port != Some(Direction::Input);
    let outputs: Vec<SignalId> = netlist.ports().filter(output).collect();
    let wanted = if wanted.is_empty() { &outputs[..] } else { wanted };
    let names = Names::new(waves);
    let (scopes, pairs) = names.scopes_with(wanted, netlist);
    let mut scopes: Vec<String> = scopes.into_iter().map(str::to_owned).collect();
    if let Some(pairs) = pairs {
        let mut alike = true;
        for (a, b) in pairs {
            alike = alike && same_values(waves, &a, &b)?;
        }
        if alike {
            scopes.truncate(1);
        }
    }
    Ok(scopes)
}

/// Whether the parts of two nets have the same values at every time.
fn same_values(waves: &mut Waves, a: &[Part], b: &[Part]) -> Result<bool, ReadError> {
    let parts: Vec<Part> = a.iter().chain(b).copied().collect();
    let vars: Vec<usize> = parts.iter().map(|part| part.var).collect();
    let tracks = Tracks::load(waves, &vars)?;
    let width = parts.iter().map(|part| part.at + part.width).max().unwrap_or(0);
    let mut values = [(); 2].map(|()| vec![Word::x(u64::MAX); words(width)]);
    let mut player = tracks.play(waves);
    while player.time().is_some() {
        player.step(&mut |lane, bits| {
            let Part { at, width, reversed, .. } = parts[lane];
            bits.write(&mut values[usize::from(lane >= a.len())], at, width, reversed);
        });
        if values[0] != values[1] {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Looks a circuit up in a waveform.
struct Finder<'a> {
    netlist: &'a Netlist,
    /// Whether the circuit prints or checks something itself.
    speaks: bool,
    wave: &'a WaveStimulus,
    waves: &'a Waves,
    names: Names<'a>,
    diagnostics: &'a mut Diagnostics,
}

type Found = (String, Vec<(SignalId, Vec<Part>)>, Option<Expected>);

impl Finder<'_> {
    fn fault<T>(&mut self, fault: Diagnostic) -> Option<T> {
        self.diagnostics.push(fault);
        None
    }

    fn find(mut self, inputs: Vec<SignalId>, candidates: &[String]) -> Option<Found> {
        let netlist = self.netlist;
        let scope = match &self.wave.scope {
            Some(scope) => self.given(scope)?,
            None => self.only(candidates, &inputs)?,
        };
        let mut found = Vec::new();
        let mut missing = Vec::new();
        for signal in inputs {
            let (name, width) = (&netlist.signal(signal).name, netlist.signal(signal).width);
            match self.names.parts(&scope, name, netlist.signal(signal)) {
                Ok(parts) => found.push((signal, parts)),
                Err(Mismatch::Missing) => missing.push(format!("`{name}`")),
                Err(other) => {
                    let fault = Diagnostic::new(Code::WidthMismatch, differs(name, width, other));
                    self.diagnostics.push(fault.at(self.wave.wave.span, "this waveform"));
                }
            }
        }
        if !missing.is_empty() {
            let text = format!("{} lacks the input{} {}", self.place(&scope), plural(&missing), missing.join(", "));
            let fault = Diagnostic::new(Code::BadWave, text).at(self.wave.wave.span, "");
            self.diagnostics
                .push(fault.help("give it by `-s NET=VALUE` or `--clock NET=PERIOD`, or name another scope"));
        }
        let expected = match self.wave.expect {
            true => Some(Expected::find(&mut self, &scope)?),
            false => None,
        };
        Some((scope, found, expected))
    }

    /// The scope that was named.
    fn given(&mut self, scope: &Spanned<String>) -> Option<String> {
        if let Some(found) = self.waves.scope(&scope.value) {
            return Some(found);
        }
        let text = format!("`{}` has no scope `{}`", self.waves.path().display(), scope.value);
        let fault = Diagnostic::new(Code::BadWave, text).at(scope.span, "");
        let fault = fault.note(self.waves.scopes_there());
        self.fault(fault.did_you_mean(&scope.value, self.waves.scopes().iter().map(String::as_str)))
    }

    /// The only scope that has what is wanted.
    fn only(&mut self, scopes: &[String], wanted: &[SignalId]) -> Option<String> {
        let span = self.wave.wave.span;
        let file = self.waves.path().display();
        match scopes {
            [one] => Some(one.clone()),
            [] => {
                let name = |s: &SignalId| self.netlist.signal(*s).name.as_str();
                let list: Vec<String> = wanted.iter().map(|s| format!("`{}`", name(s))).collect();
                let text = match &list[..] {
                    [] => format!("no scope of `{file}` has all outputs of the circuit"),
                    _ => format!("no scope of `{file}` has the input{} {}", plural(&list), list.join(", ")),
                };
                let fault = Diagnostic::new(Code::BadWave, text).at(span, "");
                let fault = match self.names.nets_of_scopes(self.netlist).nearest(wanted) {
                    Some(scope) => {
                        let lacks = wanted.iter().map(name).filter(|name| !self.names.has(scope, name));
                        let lacks: Vec<String> = lacks.map(|name| format!("`{name}`")).collect();
                        fault.note(format!("{} lacks {}", self.place(scope), lacks.join(", ")))
                    }
                    None => fault,
                };
                self.fault(fault.help("give what is not in it by `-s NET=VALUE` or `--clock NET=PERIOD`"))
            }
            _ => {
                let text = format!("several scopes of `{file}` have all inputs of the circuit");
                let fault = Diagnostic::new(Code::BadWave, text).at(span, "");
                let fault = fault.note(some(scopes.iter().map(String::as_str)));
                self.fault(fault.help(format!("name one, as in `--scope {}`", scopes[scopes.len() - 1])))
            }
        }
    }

    fn place(&self, scope: &str) -> String {
        match scope {
            "" => format!("the top of `{}`", self.waves.path().display()),
            _ => format!("the scope `{scope}` of `{}`", self.waves.path().display()),
        }
    }
}

/// What a net is in the waveform, if not what it is in the circuit.
fn differs(name: &str, width: u32, how: Mismatch) -> String {
    let bits = |n: u32| if n == 1 { "1 bit".to_owned() } else { format!("{n} bits") };
    let here = bits(width);
    match how {
        Mismatch::Missing => format!("`{name}` is not in the waveform"),
        Mismatch::Kind(kind) => format!("`{name}` is {kind} in the waveform, {here} in the circuit"),
        Mismatch::Width(found) => format!("`{name}` has {} in the waveform, {here} in the circuit", bits(found)),
        Mismatch::Bits(found) => {
            format!("`{name}` is recorded in parts of {} in all; in the circuit it has {here}", bits(found))
        }
    }
}

fn plural(list: &[String]) -> &'static str {
    if list.len() == 1 { "" } else { "s" }
}
