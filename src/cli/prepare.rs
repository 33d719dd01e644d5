//! From what the command line names to a circuit and a scenario ready to run: a circuit file with its own scenario, or
//! a scenario file that names a circuit, with what the options change.

use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::CliError;
use super::args::{Assignment, ClockOption, Condition, DontCare, ElaborationArgs, ResetOption, ScenarioArgs, WaveArgs};
use crate::diag::{Code, Diagnostic, Severity, Span};
use crate::elaborate::{Circuit, Language, Loader, built_in_import, normal, not_a_circuit, size};
use crate::import::yosys::is_yosys;
use crate::json::{Recover, Spanned};
use crate::scenario::{
    Clock, Limit, Loose, Scenario, ScenarioFile, Simulation, Stimuli, Stimulus, TimeText, Until, ValueText,
};
use crate::scenario::{Replay, WaveStimulus, replay};
use crate::syntax::{Expr, Name, ParameterValue};

/// What the options of a command change of a scenario.
#[derive(Debug, Clone, Default)]
pub struct Changes<'a> {
    /// Parameters of the top module.
    pub parameters: &'a [Assignment],
    /// Inputs to hold.
    pub sets: &'a [Assignment],
    /// Inputs that are clocks.
    pub clocks: &'a [ClockOption],
    /// Inputs that are active from the start to a time.
    pub resets: &'a [ResetOption],
    /// Cycles to run.
    pub cycles: Option<u64>,
    /// Time to run.
    pub time: Option<&'a str>,
    /// What to stop at.
    pub until: Option<&'a Condition>,
    /// Globs of nets to trace.
    pub trace: &'a [String],
    /// A waveform that drives the inputs.
    pub wave: Option<&'a WaveArgs>,
    /// Whether nothing will be run, so that a circuit without any scenario has no fault.
    pub checking: bool,
}

impl<'a> Changes<'a> {
    /// Those that several commands share.
    pub fn of(elaboration: &'a ElaborationArgs, scenario: &'a ScenarioArgs, trace: &'a [String]) -> Changes<'a> {
        Changes {
            parameters: &elaboration.parameter,
            sets: &scenario.set,
            clocks: &scenario.clock,
            resets: &scenario.reset,
            cycles: scenario.cycles,
            time: scenario.time.as_deref(),
            until: scenario.until.as_ref(),
            trace,
            ..Changes::default()
        }
    }
}

/// A circuit with its scenario.
#[derive(Debug)]
pub struct Prepared {
    /// The circuit.
    pub circuit: Circuit,
    /// The scenario.
    pub scenario: Scenario,
    /// The waveform that drives it, if one does.
    pub replay: Option<Replay>,
    /// The circuit file, as it is reached from here.
    pub path: PathBuf,
}

/// Reads what `path` names. Every fault is among the loader's diagnostics; there may be some even if it succeeds.
pub fn prepare(loader: &mut Loader, path: &Path, changes: &Changes<'_>) -> Option<Prepared> {
    let (circuit_path, file_parameters, own) = match scenario_file(loader, path)? {
        Some((circuit, parameters, simulation)) => (circuit, parameters, Some(simulation)),
        None => (path.to_path_buf(), Vec::new(), None),
    };
    let before = loader.diagnostics.errors();
    let handle = loader.open(&circuit_path)?;
    let parameters = with(loader, file_parameters, changes.parameters);
    let mut circuit = loader.elaborate(handle, &parameters)?;
    // names cannot be resolved against a circuit that is not whole, but they can if only its scenario is faulty
    let within = |d: &&Diagnostic| {
        d.severity() == Severity::Error
            && matches!((circuit.simulation_span, d.place()), (Some(s), Some(p)) if s.to(p) == s && s.file == p.file)
    };
    let of_scenario = loader.diagnostics.iter().filter(within).count();
    if loader.diagnostics.errors() > before + of_scenario {
        return None;
    }
    if own.is_none() && circuit.simulation_span.is_none() && changes.checking {
        return None;
    }
    let base = circuit.simulation.take().unwrap_or_default();
    let simulation = changed(loader, &own.unwrap_or_default().over(&base), changes);
    let replay = replay(loader, &mut circuit, &simulation);
    if simulation.wave().is_some() && replay.is_none() {
        return None;
    }
    let mut scenario = Scenario::resolve_with(&circuit, &simulation, replay.as_ref(), &mut loader.diagnostics);
    if changes.until.is_none() && (changes.cycles.is_some() || changes.time.is_some()) {
        // who asks for so many cycles is content to get them
        scenario.limit_fails = false;
    }
    Some(Prepared { circuit, scenario, replay, path: circuit_path })
}

/// The waveform that drives the inputs, if the scenario names one and it can.
fn replay(loader: &mut Loader, circuit: &mut Circuit, simulation: &Simulation) -> Option<Replay> {
    let wave = simulation.wave()?;
    let waves = replay::open(wave, loader.sources.name(wave.wave.span.file), &mut loader.diagnostics)?;
    if let Some(timescale) = waves.timescale() {
        circuit.adopt(timescale);
    }
    Replay::new(circuit, simulation, wave, waves, &mut loader.diagnostics)
}

/// The circuit that `path` names, or of the scenario that it names, with parameters set; the scenario is left aside.
pub fn circuit_of(loader: &mut Loader, path: &Path, parameters: &[Assignment]) -> Option<Circuit> {
    let (circuit, own) = match scenario_file(loader, path)? {
        Some((circuit, own, _)) => (circuit, own),
        None => (path.to_path_buf(), Vec::new()),
    };
    let handle = loader.open(&circuit)?;
    let parameters = with(loader, own, parameters);
    loader.elaborate(handle, &parameters)
}

/// Parameters of which some are given otherwise on the command line.
fn with(
    loader: &mut Loader,
    mut parameters: Vec<(Name, ParameterValue)>,
    changes: &[Assignment],
) -> Vec<(Name, ParameterValue)> {
    for Assignment { name, value } in changes {
        let given = loader.parameter(name, value);
        parameters.retain(|(n, _)| n.value != given.0.value);
        parameters.push(given);
    }
    parameters
}

type FromFile = (PathBuf, Vec<(Name, ParameterValue)>, Simulation);

/// Whether a file is a scenario rather than a circuit. Whatever cannot be told apart is taken for a circuit, the reading
/// of which tells what is wrong with it.
pub fn is_scenario(loader: &mut Loader, path: &Path) -> bool {
    !is_other(path) && loader.read(path).is_ok_and(|file| names_a_circuit(loader.sources.text(file)))
}

/// Whether a file is no JSON by its name.
fn is_other(path: &Path) -> bool {
    Language::of(path).is_some() || not_a_circuit(path).is_some()
}

fn names_a_circuit(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Keys {
        circuit: Option<IgnoredAny>,
        modules: Option<IgnoredAny>,
    }
    !is_yosys(text) && matches!(serde_json::from_str(text), Ok(Keys { circuit: Some(_), modules: None }))
}

/// What a scenario file says; `Some(None)` if the file is not one.
fn scenario_file(loader: &mut Loader, path: &Path) -> Option<Option<FromFile>> {
    if is_other(path) {
        return Some(None);
    }
    let file = loader.read(path).map_err(|fault| loader.diagnostics.push(fault)).ok()?;
    if !names_a_circuit(loader.sources.text(file)) {
        return Some(None);
    }
    let scenario = ScenarioFile::parse(&loader.sources, file, &mut loader.diagnostics)?;
    let parameters = scenario.parameters.into_iter().filter_map(|(n, v)| Some((n, v.0?))).collect();
    let folder = path.parent().unwrap_or(Path::new(""));
    let circuit = built_in_import(folder, &scenario.circuit.value);
    let circuit = circuit.unwrap_or_else(|| normal(&folder.join(&*scenario.circuit.value)));
    if let Err(fault) = size(&circuit) {
        loader.diagnostics.push(fault.at(scenario.circuit.span, "the circuit, relative to this file"));
        return None;
    }
    let beside = |file: &str| normal(&path.parent().unwrap_or(Path::new("")).join(file));
    if let Some(verilog) = scenario.verilog.and_then(|v| v.0) {
        let synthesis = loader.synthesis();
        synthesis.sources.extend(verilog.sources.iter().map(|file| beside(&file.value)));
        synthesis.include.extend(verilog.include.iter().map(|folder| beside(&folder.value)));
        synthesis.define.extend(verilog.define.into_iter().map(|define| define.value));
        synthesis.black_boxes.extend(verilog.black_boxes.into_iter().map(|name| name.value));
        if let Some(top) = verilog.top {
            loader.set_default_top(&top.value, top.span);
        }
    }
    for (name, file) in scenario.memories {
        let Some(file) = file.0 else { continue };
        let contents = beside(&file.value);
        loader.fill_memory(name, &contents, file.span);
    }
    if is_scenario(loader, &circuit) {
        let message = format!("`{}` is a scenario, not a circuit", circuit.display());
        let fault = Diagnostic::new(Code::BadScenario, message).at(scenario.circuit.span, "it names a circuit itself");
        loader.diagnostics.push(fault.help("name the circuit file itself"));
        return None;
    }
    Some(Some((circuit, parameters, scenario.simulation.and_then(|s| s.0).unwrap_or_default())))
}

/// The scenario with the changes of the command line.
fn changed(loader: &mut Loader, simulation: &Simulation, changes: &Changes<'_>) -> Simulation {
    let mut options = Simulation::default();
    let mut simulation = simulation.clone();
    for Assignment { name, value } in changes.sets {
        let (name, span) = typed(loader, "-s", name, value);
        // an input that is held is no clock any more, and nothing changes it
        simulation.clocks.shift_remove(name.value.as_str());
        simulation.without_changes_of(name.value.as_str());
        options.inputs.shift_remove(name.value.as_str());
        options.inputs.insert(name, Recover(Some(ValueText::new(value.as_str(), span))));
    }
    for option in changes.clocks {
        if let Some((name, clock)) = clock(loader, option) {
            simulation.inputs.shift_remove(name.value.as_str());
            simulation.without_changes_of(name.value.as_str());
            options.clocks.insert(name, Recover(Some(clock)));
        }
    }
    if !changes.resets.is_empty() {
        options.stimulus = resets(loader, &mut simulation, &mut options, changes.resets);
    }
    if let (Some(_), Some(reset)) = (changes.wave, changes.resets.first()) {
        let (_, span) = typed(loader, "--reset", &reset.net, &reset.time);
        let fault = Diagnostic::new(Code::BadScenario, "a waveform drives the inputs, and `--reset` too");
        loader.diagnostics.push(fault.at(span, "leave it out"));
    }
    if let Some(args) = changes.wave {
        options.stimulus = wave(loader, args).map(|wave| Recover(Some(Stimuli::Wave(Box::new(wave)))));
    }
    if let Some(Condition { net, value }) = changes.until {
        let (net, span) = typed(loader, "--until", net, value.as_deref().unwrap_or_default());
        let value = value.as_ref().map(|v| ValueText::new(v.as_str(), span));
        options.until = Some(Recover(Some(Until { net, value })));
    }
    if changes.cycles.is_some() || changes.time.is_some() {
        let cycles = changes.cycles.map(|n| {
            let text = n.to_string();
            let file = loader.sources.add("--cycles", text.clone());
            Expr::number(i64::try_from(n).unwrap_or(i64::MAX), Span::new(file, 0, text.len() as u32))
        });
        let time = changes.time.and_then(|text| {
            let file = loader.sources.add("--time", text.to_owned());
            let time = TimeText::parse(text, Span::new(file, 0, text.len() as u32));
            time.map_err(|d| loader.diagnostics.push(d)).ok()
        });
        options.limit = Some(Recover(Some(Limit { cycles, time })));
    }
    if !changes.trace.is_empty() {
        let globs = changes.trace.iter().map(|glob| {
            let file = loader.sources.add("--trace", glob.clone());
            Spanned::new(glob.clone(), Span::new(file, 0, glob.len() as u32))
        });
        options.trace = Some(globs.collect());
    }
    options.over(&simulation)
}

/// A clock of the command line, as a scenario would have it.
fn clock(loader: &mut Loader, option: &ClockOption) -> Option<(Name, Clock)> {
    let (name, span) = typed(loader, "--clock", &option.net, &option.period);
    let mut time = |text: &str, span: Option<Span>| {
        let span = span.unwrap_or_else(|| {
            let file = loader.sources.add("--clock", text.to_owned());
            Span::new(file, 0, text.len() as u32)
        });
        TimeText::parse(text, span).map_err(|d| loader.diagnostics.push(d)).ok()
    };
    let period = time(&option.period, Some(span))?;
    let high = option.high.as_deref().map(|text| time(text, None));
    let phase = option.phase.as_deref().map(|text| time(text, None));
    Some((name, Clock { doc: None, period, high: high.flatten(), duty: None, phase: phase.flatten() }))
}

/// The changes of a scenario and those of resets on the command line, which hold whatever the scenario says of these inputs.
fn resets(
    loader: &mut Loader,
    simulation: &mut Simulation,
    options: &mut Simulation,
    resets: &[ResetOption],
) -> Option<Recover<Stimuli>> {
    let mut added = Vec::new();
    for ResetOption { net, time, low } in resets {
        let (name, span) = typed(loader, "--reset", net, time);
        simulation.clocks.shift_remove(name.value.as_str());
        simulation.without_changes_of(name.value.as_str());
        let start = ValueText::new(if *low { "0" } else { "1" }, span);
        options.inputs.insert(name.clone(), Recover(Some(start)));
        match TimeText::parse(time, span) {
            Ok(at) => {
                let end = ValueText::new(if *low { "1" } else { "0" }, span);
                added.push(Stimulus { doc: None, at: Some(at), on: None, set: IndexMap::from([(name, end)]) });
            }
            Err(fault) => loader.diagnostics.push(fault),
        }
    }
    let added = added.into_iter().map(|stimulus| Recover(Some(stimulus)));
    match simulation.stimulus.take() {
        // a waveform drives all inputs but those that are given
        Some(Recover(Some(Stimuli::Wave(wave)))) => {
            let span = wave.wave.span;
            let text = "a waveform drives the inputs, and `--reset` too";
            loader.diagnostics.push(Diagnostic::new(Code::BadScenario, text).at(span, "leave one of them out"));
            Some(Recover(Some(Stimuli::Wave(wave))))
        }
        Some(Recover(Some(Stimuli::Changes(mut changes)))) => {
            changes.extend(added);
            Some(Recover(Some(Stimuli::Changes(changes))))
        }
        _ => Some(Recover(Some(Stimuli::Changes(added.collect())))),
    }
}

/// A waveform of the command line, as a scenario would have it.
fn wave(loader: &mut Loader, args: &WaveArgs) -> Option<WaveStimulus> {
    let path = args.stimulus.as_ref()?.display().to_string();
    let mut text = |option: &str, text: &str| {
        let file = loader.sources.add(option, text.to_owned());
        Spanned::new(text.to_owned(), Span::new(file, 0, text.len() as u32))
    };
    let loose = args.ignore_x.map(|side| match side {
        DontCare::A => Loose::Wave,
        DontCare::B => Loose::Run,
    });
    Some(WaveStimulus {
        doc: None,
        wave: text("--stimulus", &path),
        scope: args.scope.as_deref().map(|scope| text("--scope", scope)),
        first: args.first.iter().map(|name| text("--first", name.trim().trim_start_matches('\\'))).collect(),
        expect: args.expect,
        ignore: args.ignore.iter().map(|glob| text("--ignore", glob)).collect(),
        ignore_x: loose.map(|side| Spanned::new(side, Span::default())),
    })
}

/// A name, and the place of its value, of an option; faults will show it as typed.
pub(super) fn typed(loader: &mut Loader, option: &str, name: &str, value: &str) -> (Name, Span) {
    let text = if value.is_empty() { name.to_owned() } else { format!("{name}={value}") };
    let length = text.len() as u32;
    let file = loader.sources.add(option, text);
    let end = name.len() as u32;
    (Name::new(name.to_owned(), Span::new(file, 0, end)), Span::new(file, (end + 1).min(length), length))
}

/// Rising edges of a scenario's clocks up to a tick, by name.
#[must_use]
pub fn cycles(scenario: &Scenario, time: u64) -> IndexMap<String, u64> {
    let count = |c: &crate::cell::Clock| if time < c.phase { 0 } else { (time - c.phase) / c.period + 1 };
    scenario.clocks.iter().map(|c| (c.name.clone(), count(&c.clock))).collect()
}

/// A time of the command line.
///
/// # Errors
/// If it is none.
pub(super) fn ticks(circuit: &Circuit, loader: &mut Loader, option: &str, text: &str) -> Result<u64, CliError> {
    let file = loader.sources.add(option, text.to_owned());
    let span = Span::new(file, 0, text.len() as u32);
    let found = TimeText::parse(text, span).and_then(|t| t.ticks(circuit.netlist.timescale(), &circuit.parameters));
    found.map_err(|fault| CliError::Input(fault.render(&loader.sources, false)))
}
