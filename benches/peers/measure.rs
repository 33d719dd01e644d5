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
    /// Cycles a second of the last three quarters of a run.
    pub rate: f64,
    /// What a run takes more than its cycles would at that rate: the start, and code that is made while it runs.
    pub lead: f64,
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
    cycles: u64,
    /// Of runs of a quarter of the cycles.
    quarters: Vec<f64>,
    /// What the whole run takes more than the quarter before it.
    times: Vec<f64>,
    sum: Option<u32>,
    wrong: Option<String>,
    figures: Figures,
}

impl Candidate {
    /// A run of a quarter and a whole one. What the first has more of the start than of cycles, the second has too.
    fn run(&mut self, file: Option<&Path>) -> Result<(), String> {
        let timed = |cycles| {
            let (seconds, said) = process::timed(&self.ready.command(cycles, file))?;
            Ok::<_, String>((seconds, self.ready.result(&said)?))
        };
        let (quarter, _) = timed(self.cycles / 4)?;
        let (whole, (sum, engine)) = timed(self.cycles)?;
        self.quarters.push(quarter);
        self.times.push((whole - quarter).max(1e-9));
        self.figures.engine = engine;
        self.sum = Some(sum);
        Ok(())
    }
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
            if let Err(why) = candidate.run(file.as_deref()) {
                eprintln!("{}: {why}", candidate.ready.simulator.name());
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
            let quarter = candidate.cycles / 4;
            let n = (candidate.cycles - quarter) as f64;
            figures.cycles = candidate.cycles;
            figures.rate = n / median(&mut candidate.times);
            figures.spread = (n / candidate.times[candidate.times.len() - 1], n / candidate.times[0]);
            figures.lead = (median(&mut candidate.quarters) - quarter as f64 / figures.rate).max(0.0);
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
    figures.first = ready.seconds + median(&mut starts);
    // Code is made while it runs, too: a rate is one when a longer run has no better one.
    let mut quarter = 250;
    let mut before = f64::INFINITY;
    let cycles = loop {
        let steady = (run(4 * quarter)? - run(quarter)?).max(1e-4);
        let each = steady / (3 * quarter) as f64;
        if steady > effort.seconds / 8.0 && each > before * 0.8 || steady > effort.seconds * 8.0 {
            break round(effort.seconds / each).max(4);
        }
        before = each;
        quarter = (quarter as f64 * (effort.seconds / 4.0 / steady).clamp(2.0, 50.0)) as u64;
    };
    if let Some(file) = &file {
        let _ = std::fs::remove_file(file);
    }
    Ok(Candidate { ready, cycles, quarters: Vec::new(), times: Vec::new(), sum: None, wrong: None, figures })
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
