//! Runs of all simulators in turns, and what of them counts.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::peers::{Ready, Simulator, Trace};
use crate::process;
use crate::workload::Design;

/// How much is measured.
pub struct Effort {
    /// Runs of which the median is taken.
    pub runs: usize,
    /// Seconds that a run shall take.
    pub seconds: f64,
}

/// One simulator on one design, recording one thing.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Figures {
    pub simulator: String,
    pub trace: String,
    /// Why there is nothing else.
    pub missing: Option<String>,
    /// Which engine ran, as it says.
    pub engine: Option<String>,
    /// From the netlist to the end of the first cycle.
    pub first: f64,
    pub cycles: u64,
    /// Cycles a second, without what comes before the first.
    pub rate: f64,
    /// The slowest and the fastest run.
    pub spread: (f64, f64),
    /// The most memory of a run, in bytes.
    pub peak: u64,
    /// Of the waveform, for each cycle.
    pub bytes: Option<f64>,
    /// Variables that a VCD has.
    pub variables: Option<u64>,
}

/// All on one design.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Measured {
    pub workload: String,
    pub title: String,
    pub cells: usize,
    pub figures: Vec<Figures>,
}

impl Measured {
    pub fn of(&self, simulator: Simulator, trace: Trace) -> Option<&Figures> {
        let found = self.figures.iter().find(|f| f.simulator == simulator.name() && f.trace == trace.name());
        found.filter(|f| f.missing.is_none())
    }
}

struct Candidate {
    ready: Ready,
    /// Time of a run of one cycle.
    start: f64,
    cycles: u64,
    times: Vec<f64>,
    sum: Option<u32>,
    wrong: Option<String>,
    figures: Figures,
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Where waveforms go: into memory where that is possible, so that no disk is measured.
fn waveform(trace: Trace) -> Option<PathBuf> {
    let shared = Path::new("/dev/shm");
    let folder = if shared.is_dir() { shared.to_owned() } else { process::root() };
    (trace != Trace::Nothing).then(|| folder.join(format!("discreta-peers-{}.{}", std::process::id(), trace.name())))
}

/// Two digits of a number.
fn round(cycles: f64) -> u64 {
    let unit = 10f64.powf((cycles.max(10.0).log10() - 1.0).floor());
    ((cycles / unit).round() * unit) as u64
}

/// Measures one design, recording one thing.
pub fn measure(design: &Design, trace: Trace, effort: &Effort) -> Vec<Figures> {
    let mut result = Vec::new();
    let mut candidates = Vec::new();
    for simulator in Simulator::ALL {
        if simulator == Simulator::Event && trace != Trace::Nothing {
            continue;
        }
        let figures = Figures { simulator: simulator.name().into(), trace: trace.name().into(), ..Figures::default() };
        match candidate(simulator, design, trace, effort, figures.clone()) {
            Ok(candidate) => candidates.push(candidate),
            Err(why) => {
                eprintln!("{}, {}: {}: {why}", design.workload.name, trace.name(), simulator.name());
                result.push(Figures { missing: Some(why), ..figures });
            }
        }
    }
    // all that make code run as long as the first of them needs for the given time, unless that is long for them
    if let Some(cycles) = candidates.iter().find(|c| !c.ready.simulator.interprets()).map(|c| c.cycles) {
        for candidate in &mut candidates {
            if !candidate.ready.simulator.interprets() && candidate.cycles * 4 > cycles {
                candidate.cycles = cycles;
            }
        }
    }
    let file = waveform(trace);
    for _ in 0..effort.runs {
        for candidate in &mut candidates {
            let command = candidate.ready.command(candidate.cycles, file.as_deref());
            match process::timed(&command).and_then(|(t, said)| Ok((t, candidate.ready.result(&said)?))) {
                Ok((seconds, (sum, engine))) => {
                    candidate.times.push(seconds - candidate.start);
                    candidate.figures.engine = engine;
                    candidate.sum = Some(sum);
                }
                Err(why) => eprintln!("{}: {why}", candidate.ready.simulator.name()),
            }
            if let Some(file) = &file {
                let size = std::fs::metadata(file).map_or(0, |m| m.len());
                candidate.figures.bytes = Some(size as f64 / candidate.cycles as f64);
                if trace == Trace::Vcd && candidate.figures.variables.is_none() {
                    candidate.figures.variables = variables(file);
                }
                let _ = std::fs::remove_file(file);
            }
        }
    }
    for candidate in &mut candidates {
        let command = candidate.ready.command(candidate.cycles, file.as_deref());
        candidate.figures.peak = process::peak(&command).unwrap_or(0);
        file.as_ref().map(std::fs::remove_file);
    }
    compare(&mut candidates);
    for mut candidate in candidates {
        let mut figures = candidate.figures;
        figures.missing = candidate.wrong.or_else(|| candidate.times.is_empty().then(|| "did not end".to_owned()));
        if figures.missing.is_none() {
            let n = candidate.cycles as f64;
            figures.cycles = candidate.cycles;
            figures.rate = n / median(&mut candidate.times);
            figures.spread = (n / candidate.times[candidate.times.len() - 1], n / candidate.times[0]);
        }
        result.push(figures);
    }
    result
}

/// Builds one, unless that is known to take too long.
pub fn ready(simulator: Simulator, design: &Design, trace: Trace) -> Result<Ready, String> {
    if design.workload.large && simulator == Simulator::Cxxrtl {
        return Err("left out: a sixteenth of it takes minutes to compile".to_owned());
    }
    simulator.prepare(design, trace)
}

/// Builds one, and finds how long a run takes.
fn candidate(
    simulator: Simulator,
    design: &Design,
    trace: Trace,
    effort: &Effort,
    mut figures: Figures,
) -> Result<Candidate, String> {
    let ready = ready(simulator, design, trace)?;
    let file = waveform(trace);
    let run = |cycles| process::timed(&ready.command(cycles, file.as_deref())).map(|r| r.0);
    let mut starts = Vec::new();
    for _ in 0..3 {
        starts.push(run(1)?);
    }
    let start = median(&mut starts);
    figures.first = ready.seconds + start;
    let mut cycles = 1000;
    loop {
        let steady = (run(cycles)? - start).max(1e-4);
        if steady > effort.seconds / 8.0 {
            cycles = round(cycles as f64 * effort.seconds / steady);
            break;
        }
        cycles = (cycles as f64 * (effort.seconds / 4.0 / steady).clamp(2.0, 50.0)) as u64;
    }
    if let Some(file) = &file {
        let _ = std::fs::remove_file(file);
    }
    Ok(Candidate { ready, start, cycles, times: Vec::new(), sum: None, wrong: None, figures })
}

/// Holds the checksums against that of the first that makes code, which is asked for as many cycles as each of them ran.
fn compare(candidates: &mut [Candidate]) {
    let Some(at) = candidates.iter().position(|c| !c.ready.simulator.interprets()) else { return };
    let reference = candidates[at].ready.simulator.name();
    let mut known = vec![(candidates[at].cycles, candidates[at].sum)];
    for i in 0..candidates.len() {
        let Candidate { cycles, sum, .. } = candidates[i];
        if !known.iter().any(|k| k.0 == cycles) {
            let file = waveform(candidates[at].ready.trace);
            let said = process::timed(&candidates[at].ready.command(cycles, file.as_deref()));
            file.map(std::fs::remove_file);
            known.push((cycles, said.ok().and_then(|(_, said)| Some(candidates[at].ready.result(&said).ok()?.0))));
        }
        let expected = known.iter().find(|k| k.0 == cycles).and_then(|k| k.1);
        if sum.is_some() && sum != expected {
            let hex = |sum: Option<u32>| sum.map_or_else(|| "nothing".to_owned(), |s| format!("{s:08x}"));
            let why = format!("wrong: {} after {cycles} cycles, and {reference} {}", hex(sum), hex(expected));
            eprintln!("{}: {why}", candidates[i].ready.simulator.name());
            candidates[i].wrong = Some(why);
        }
    }
}

/// How many variables a VCD declares.
fn variables(file: &Path) -> Option<u64> {
    let mut count = 0;
    for line in BufReader::new(File::open(file).ok()?).lines() {
        let line = line.ok()?;
        count += u64::from(line.trim_start().starts_with("$var"));
        if line.contains("$enddefinitions") {
            break;
        }
    }
    Some(count)
}
