//! This simulator beside Verilator, CXXRTL and Icarus Verilog on the same netlists (docs/speed.md).
//!
//!     benches/peers/install.sh
//!     cargo bench --bench peers [-- [DESIGN…] [--quick] [--no-trace] [--build] [--resume]]
//!     cargo bench --bench peers -- --verilog FILE… --top MODULE --clock PORT [OPTION…]
//!
//! Prints tables of Markdown, and leaves the figures in target/peers/results.json.

mod measure;
mod own;
mod peers;
mod process;
mod table;
mod workload;

use std::process::{Command, ExitCode};

use measure::{Effort, Measured};
use peers::{Simulator, Trace};

const USAGE: &str = "cargo bench --bench peers [-- [DESIGN…] [--quick] [--no-trace] [--build] [--resume]]

  DESIGN      one of these, by default all:";

/// What the machine is and does.
fn machine() -> String {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let info = read("/proc/cpuinfo");
    let model = info.lines().find(|l| l.starts_with("model name")).and_then(|l| l.split(": ").nth(1)).unwrap_or("?");
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let load = read("/proc/loadavg");
    let date = Command::new("date").args(["-u", "+%Y-%m-%d %H:%M UTC"]).output();
    let date = date.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned()).unwrap_or_default();
    format!("{date}; {model}, {cores} cores, load {}", load.split(' ').next().unwrap_or("?"))
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(own) = own::parse(&arguments) {
        println!("{}\n", machine());
        return match own.map(|own| own::run(&own)) {
            Ok(Ok(true)) => ExitCode::SUCCESS,
            Ok(Ok(false)) => ExitCode::FAILURE,
            Ok(Err(why)) => {
                eprintln!("{why}");
                ExitCode::from(2)
            }
            Err(why) => {
                eprintln!("{why}\n\n{}", own::USAGE);
                ExitCode::from(2)
            }
        };
    }
    let (mut chosen, mut quick, mut traces, mut resume, mut only) = (Vec::new(), false, true, false, false);
    for argument in arguments {
        match argument.as_str() {
            "--bench" => {} // from cargo
            "--quick" => quick = true,
            "--no-trace" => traces = false,
            "--build" => only = true,
            "--resume" => resume = true,
            name => match workload::ALL.iter().find(|w| w.name == name) {
                Some(workload) => chosen.push(workload),
                None => {
                    eprintln!("{USAGE}");
                    for w in &workload::ALL {
                        eprintln!("              {:13} {}", w.name, w.title);
                    }
                    eprintln!(
                        "  --quick     shorter runs, and fewer\n  --no-trace  no waveforms\n  \
                         --build     build everything, and run nothing\n  \
                         --resume    leave out what target/peers/results.json has\n\n{}",
                        own::USAGE
                    );
                    return ExitCode::from(2);
                }
            },
        }
    }
    if chosen.is_empty() {
        chosen = workload::ALL.iter().collect();
    }
    if let Err(why) = process::packages() {
        eprintln!("{why}");
        return ExitCode::from(2);
    }
    let effort = if quick { Effort { runs: 3, seconds: 0.5 } } else { Effort { runs: 5, seconds: 2.0 } };
    let results = process::root().join("results.json");
    let mut measured: Vec<Measured> = if resume {
        std::fs::read_to_string(&results).ok().and_then(|t| serde_json::from_str(&t).ok()).unwrap_or_default()
    } else {
        Vec::new()
    };
    println!("{}; medians of {} runs of some {} s, in turns\n", machine(), effort.runs, effort.seconds);
    for simulator in [Simulator::Verilator, Simulator::Cxxrtl, Simulator::Icarus, Simulator::Discreta] {
        println!("- {}: {}", simulator.name(), simulator.version());
    }
    println!();
    let mut faults = 0;
    for workload in chosen {
        if measured.iter().any(|m| m.workload == workload.name) {
            continue;
        }
        let design = match workload::prepare(workload) {
            Ok(design) => design,
            Err(why) => {
                eprintln!("{}: {why}", workload.name);
                faults += 1;
                continue;
            }
        };
        if only {
            for trace in Trace::ALL.into_iter().filter(|&t| t == Trace::Nothing || traces && workload.traced) {
                for simulator in Simulator::ALL {
                    if let Err(why) = measure::ready(simulator, &design, trace) {
                        eprintln!("{}, {}: {}: {why}", workload.name, trace.name(), simulator.name());
                    }
                }
            }
            continue;
        }
        let mut all = Measured {
            workload: workload.name.into(),
            title: workload.title.into(),
            cells: design.cells,
            figures: Vec::new(),
        };
        for trace in Trace::ALL {
            if trace == Trace::Nothing || traces && workload.traced {
                all.figures.extend(measure::measure(&design, trace, &effort));
            }
        }
        eprint!("{}", table::tables(std::slice::from_ref(&all)));
        measured.push(all);
        let text = serde_json::to_string_pretty(&measured).expect("figures are JSON");
        if let Err(e) = std::fs::write(&results, text) {
            eprintln!("{}: {e}", results.display());
        }
    }
    print!("{}", table::tables(&measured));
    let figures = measured.iter().flat_map(|m| &m.figures);
    let wrong = figures.filter(|f| f.missing.as_deref().is_some_and(|w| w.starts_with("wrong"))).count();
    if wrong + faults > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
