//! The command line as it is typed: commands, options, and their help. Nothing is resolved here.
//!
//! Options that mean the same in several commands are one struct that they share.

mod drawing;
mod feed;
mod looking;
mod machine;
mod schematic;
mod shared;
mod sweeping;
mod why;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};

pub use drawing::{
    Center, CompareArgs, CompareFormat, CoordinateArgs, DrawingArgs, InterpolateArgs, PlotArgs, Point, StepsFormat,
};
pub use feed::FeedArgs;
pub use looking::{ViewArgs, WaveTextArgs};
pub use machine::{MachineArgs, MachineFormat, Net, StepDir};
pub use schematic::DrawArgs;
pub use shared::{
    Assignment, ClockOption, Condition, DontCare, ElaborationArgs, EngineArgs, EngineChoice, Format, FormatArgs,
    ResetOption, ScenarioArgs, WaveArgs, XControl,
};
pub use sweeping::SweepArgs;
pub use why::WhyArgs;

/// `discreta`.
#[derive(Parser, Debug)]
#[command(
    name = "discreta",
    version,
    about = "Simulate digital circuits clock by clock",
    long_about = "Simulate digital circuits clock by clock.\n\n\
        A circuit is a JSON file of gates, flip-flops, registers and adders. Run it, look at the waveform in GTKWave \
        or Surfer, and pin it with golden traces.",
    after_help = "Examples:\n  \
        discreta run discreta:evaluation/line -s dx=5 -s dy=3 -o line.vcd\n  \
        discreta check my-circuit.json\n  \
        discreta test traces\n\n\
        Exit status: 0 done; 1 a comparison, expectation or check failed, or a run hit its limit; \
        2 usage, input or output.",
    disable_help_subcommand = true,
    max_term_width = 100
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Run a circuit, and write its waveform
    Run(RunArgs),
    /// Find every fault of circuit files
    Check(CheckArgs),
    /// Run scenarios, and compare them with their golden traces
    Test(TestArgs),
    /// Compare two waveforms, and show the first difference
    Diff(DiffArgs),
    /// Tell where the value of a net comes from: why it is x, or why it is wrong
    Why(WhyArgs),
    /// Print a waveform as text
    Wave(WaveTextArgs),
    /// Make a page that shows a circuit at work: schematic, waveform and path
    View(ViewArgs),
    /// Run a circuit for every combination of values of some inputs, side by side
    Sweep(SweepArgs),
    /// Print what an interpolation algorithm does, step by step, without any circuit
    Interpolate(InterpolateArgs),
    /// Draw the path of a method or of a waveform over the ideal curve, as SVG
    Plot(PlotArgs),
    /// Draw a part program (G-code) by every method, and measure steps, speed and deviation
    Machine(MachineArgs),
    /// Tell the greatest feed of a system, and whether its margins are kept
    Feed(FeedArgs),
    /// Draw the schematic of a circuit, as SVG
    Draw(DrawArgs),
    /// Count what circuits are made of, and how deep their logic is
    Stats(StatsArgs),
    /// Write a circuit for other tools
    Export(ExportArgs),
    /// Measure what the documents say of their methods
    Compare(CompareArgs),
    /// List the circuits that come with discreta
    Circuits(CircuitsArgs),
    /// Copy one of these circuits, to start from
    New(NewArgs),
    /// Print the JSON Schema of the files that you write, for your editor
    Schema(SchemaArgs),
    /// Print a script that completes this command line in your shell
    Completions(CompletionsArgs),
    /// Print the manual page
    Man(ManArgs),
}

/// `discreta run`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta run discreta:evaluation/line
        as the circuit's own scenario says; prints a summary
  discreta run discreta:evaluation/line -s dx=5 -s dy=3 -o line.vcd
        with these inputs; the waveform goes to line.vcd
  discreta run discreta:evaluation/line -o line.vcd --save && gtkwave line.gtkw
        set up for the circuit: groups, signed numbers, coordinates as steps
  discreta run counter.json -p W=16 --cycles 100 --trace 'q' --trace 'stage[*].*' -o -
        100 clocks of a 16-bit counter; some nets, to standard output

  discreta run top.v alu.v -G W=8 --clock clk=10ns -s rst=0 --cycles 1000 -o top.vcd
        Verilog, which Yosys reads; a netlist that it wrote does too
  discreta run cpu.json --stimulus icarus.vcd --scope bench.cpu --expect
        driven as in another simulator, and compared with its results (a; b is this run)

Values are numbers (5, -1) or literals (4'b10x1, 8'hff).
Exit status: 0 stopped as asked; 1 a limit was hit first, or an expectation failed; 2 usage, input or output.")]
pub struct RunArgs {
    /// The circuit: a circuit file, Verilog, a netlist of Yosys (write_json), or a scenario that names one
    #[arg(value_name = "CIRCUIT", value_hint = ValueHint::FilePath)]
    pub circuit: PathBuf,

    /// More files of the same design, if it is Verilog
    #[arg(value_name = "MORE", value_hint = ValueHint::FilePath)]
    pub more: Vec<PathBuf>,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// What happens to the circuit.
    #[command(flatten)]
    pub scenario: ScenarioArgs,

    /// Write the waveform to a file, VCD or FST by its extension, or as VCD to standard output (-); may be given several
    /// times
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Vec<PathBuf>,

    /// Beside each waveform, write a set-up for GTKWave (.gtkw) and Surfer (.sucl)
    #[arg(long, requires = "output")]
    pub save: bool,

    /// Record only nets that match, e.g. 'adder.*' or '**.q'; may be given several times
    #[arg(long, value_name = "GLOB")]
    pub trace: Vec<String>,

    /// The engine, and what to do about x.
    #[command(flatten)]
    pub engine: EngineArgs,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,

    /// A waveform as stimulus.
    #[command(flatten)]
    pub wave: WaveArgs,

    /// Record from this time on: ticks, or with a unit as in 5us
    #[arg(long, value_name = "TIME", requires = "output")]
    pub from: Option<String>,

    /// Record up to this time
    #[arg(long, value_name = "TIME", requires = "output")]
    pub to: Option<String>,

    /// Stop when this holds: an expression over nets, 'a == 3 && u1.busy'; or x:GLOB, when a net that was known becomes x; may be
    /// given several times
    #[arg(long, value_name = "CONDITION")]
    pub stop_on: Vec<String>,

    /// Hold a net at a value for the whole run, whatever drives it; may be given several times
    #[arg(long, value_name = "NET=VALUE", value_parser = shared::assignment)]
    pub force: Vec<Assignment>,

    /// At the end write what a memory holds to a file, as $readmemh reads it; may be given several times
    #[arg(long, value_name = "MEMORY=FILE", value_parser = shared::assignment)]
    pub dump: Vec<Assignment>,

    /// Where what the circuit prints ($display) goes: told with time and source on standard error, or raw on standard output
    #[arg(long, value_name = "HOW", default_value = "told")]
    pub print: Print,

    /// Say more: every output, warnings in full, and which engine ran
    #[arg(short, long)]
    pub verbose: bool,
}

/// How what a circuit prints is shown.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Print {
    /// Line by line with time and source, on standard error.
    Told,
    /// As it is, on standard output, in place of the summary.
    Raw,
}

/// `discreta check`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta check my-circuit.json
  discreta check circuits/**/*.json --format json

Shows every fault, not only the first, with its place and what to do.
Exit status: 0 no errors (there may be warnings); 1 errors; 2 usage, input or output.")]
pub struct CheckArgs {
    /// Circuit files and scenarios
    #[arg(value_name = "CIRCUIT", required = true, value_hint = ValueHint::FilePath)]
    pub circuit: Vec<PathBuf>,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
}

/// `discreta test`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta test
        every scenario below traces/
  discreta test traces/evaluation/line_5_3.json
  discreta test --bless
        make the waveforms of this run the golden ones; look at the changes before you commit them
  discreta test --format github
        in a workflow: failures are shown at their lines in the pull request; --format junit is for other services
  discreta test --filter circle --fail-fast -q
        only scenarios whose path has `circle` in it, up to the first that fails

Exit status: 0 all agree; 1 some differ or fail; 2 usage, input or output.")]
pub struct TestArgs {
    /// Scenarios, or directories to look for them in
    #[arg(value_name = "PATH", default_value = "traces", value_hint = ValueHint::AnyPath)]
    pub path: Vec<PathBuf>,

    /// Replace the golden traces that differ or are missing
    #[arg(long)]
    pub bless: bool,

    /// Run only scenarios whose path contains this; may be given several times
    #[arg(long, value_name = "TEXT")]
    pub filter: Vec<String>,

    /// Print which scenarios there are, and run none
    #[arg(long)]
    pub list: bool,

    /// Stop after the first that fails
    #[arg(long)]
    pub fail_fast: bool,

    /// Print only those that fail, and the summary
    #[arg(short, long)]
    pub quiet: bool,

    /// The engine, and what to do about x.
    #[command(flatten)]
    pub engine: EngineArgs,

    /// Print results for people, for programs, or for a service that runs tests
    #[arg(long, value_name = "FORMAT", default_value = "text")]
    pub format: TestFormat,
}

/// How `test` prints its results.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum TestFormat {
    /// For people.
    Text,
    /// For programs: JSON.
    Json,
    /// JUnit's XML, which most services read.
    Junit,
    /// Annotations of GitHub's workflows.
    Github,
}

/// `discreta diff`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta diff line.vcd traces/evaluation/line_5_3.vcd
  discreta diff mine.vcd icarus.fst --ignore-end --ignore-x b
  discreta diff line.vcd line_tb.vcd --scope testbench.line
        with the waveform of a test bench around the circuit

Signals are matched by their full names, or by their names below --scope. What counts is the value at the end of each tick.
Exit status: 0 the same; 1 different; 2 a file cannot be read, or not to its end, or usage.")]
pub struct DiffArgs {
    /// The first waveform: VCD, FST or GHW
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    pub a: PathBuf,

    /// The second waveform
    #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
    pub b: PathBuf,

    /// Where in a waveform the circuit stands, e.g. bench.dut
    ///
    /// May be given twice, for A and for B. Only signals below this scope are compared, by their names relative to it. If one of the two has no such scope, the
    /// scope in it that has the same names below it is taken.
    #[arg(long, value_name = "PATH")]
    pub scope: Vec<String>,

    /// Let x in A, or in B, agree with anything; otherwise x agrees only with x
    #[arg(long, value_name = "SIDE")]
    pub ignore_x: Option<DontCare>,

    /// Let one of the two end earlier than the other
    #[arg(long)]
    pub ignore_end: bool,

    /// Do not compare nets that match, e.g. 'cache.**'; may be given several times
    #[arg(long, value_name = "GLOB")]
    pub ignore: Vec<String>,

    /// Compare this signal of A with that of B; may be given several times
    #[arg(long, value_name = "A=B", value_parser = shared::assignment)]
    pub map: Vec<Assignment>,

    /// Compare from this time on: ticks, or with a unit as in 5us
    #[arg(long, value_name = "TIME")]
    pub from: Option<String>,

    /// Compare up to this time
    #[arg(long, value_name = "TIME")]
    pub to: Option<String>,

    /// Show at most this many signals in each list
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub max: usize,

    /// Show this many changes before and after the first difference
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub context: u16,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
}

/// `discreta stats`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta stats discreta:evaluation/line discreta:evaluation/line_gates
  discreta stats discreta:evaluation/line_gates -p W=16 --depth 1
        with 16 bits, and the counts of each part of the circuit
  discreta stats my-circuit.json --format json

docs/stats.md says what counts as what.
Exit status: 0 counted; 2 a faulty circuit, usage, input or output.")]
pub struct StatsArgs {
    /// Circuit files, or scenarios that name one
    #[arg(value_name = "CIRCUIT", required = true, value_hint = ValueHint::FilePath)]
    pub circuit: Vec<PathBuf>,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// Go this many levels of modules and blocks down from the top
    ///
    /// Each module and block on the way is counted too.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub depth: u32,

    /// Text or JSON.
    #[command(flatten)]
    pub format: FormatArgs,
}

/// The format that a circuit is written in.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum ExportFormat {
    /// Verilog-2005: modules that can be synthesized, and a test bench.
    Verilog,
    /// A netlist as Yosys writes it: for Yosys, netlistsvg and their like.
    YosysJson,
    /// A graph for Graphviz.
    Dot,
}

/// `discreta export`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta export discreta:evaluation/line --to verilog -o line.v
  discreta export discreta:evaluation/line --to verilog -o line.v --testbench line_tb.v -s dx=5 -s dy=3
        with a test bench that does what `run` does with the same options; then
        iverilog -g2005 -o line line.v line_tb.v && ./line
  discreta export discreta:evaluation/line_gates --to verilog -p W=16
        to standard output

  discreta export discreta:evaluation/line --to yosys-json -o line_netlist.json
        for Yosys (read_json) and discreta to read
  discreta export discreta:evaluation/line_gates --to dot --depth 0 | dot -Tsvg > line.svg

docs/export.md says what each cell becomes.
Exit status: 0 written; 2 a faulty circuit, one that the format cannot hold, usage, input or output.")]
pub struct ExportArgs {
    /// The circuit: a circuit file, Verilog, a netlist of Yosys (write_json), or a scenario that names one
    #[arg(value_name = "CIRCUIT", value_hint = ValueHint::FilePath)]
    pub circuit: PathBuf,

    /// More files of the same design, if it is Verilog
    #[arg(value_name = "MORE", value_hint = ValueHint::FilePath)]
    pub more: Vec<PathBuf>,

    /// The format
    #[arg(long, value_name = "FORMAT")]
    pub to: ExportFormat,

    /// Write to a file; without it, to standard output
    #[arg(short, long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,

    /// Go this many levels of modules and blocks down from the top
    ///
    /// In a graph, instances further down are drawn as boxes; without this option, none are.
    #[arg(long, value_name = "N")]
    pub depth: Option<usize>,

    /// Also write a test bench that runs the scenario; - puts it after the design
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub testbench: Option<PathBuf>,

    /// Parameters and limits.
    #[command(flatten)]
    pub elaboration: ElaborationArgs,

    /// What happens to the circuit in the test bench.
    #[command(flatten)]
    pub scenario: ScenarioArgs,

    /// Record only nets that match, e.g. 'adder.*' or '**.q'; may be given several times
    #[arg(long, value_name = "GLOB", requires = "testbench")]
    pub trace: Vec<String>,
}

/// The kind of file that a schema describes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum SchemaKind {
    /// A circuit file.
    Circuit,
    /// A scenario in a file of its own.
    Scenario,
}

/// `discreta schema`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta schema > circuit.schema.json
        name it in the circuit file: \"$schema\": \"circuit.schema.json\"
  discreta schema scenario")]
pub struct SchemaArgs {
    /// The kind of file
    #[arg(value_name = "OF", default_value = "circuit")]
    pub of: SchemaKind,
}

/// `discreta circuits`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta circuits
  discreta circuits lib
        the modules that any circuit may import: \"import\": [\"discreta:lib/arithmetic\"]

Such a name does wherever a circuit is named: discreta run discreta:evaluation/line -s dx=5")]
pub struct CircuitsArgs {
    /// Only those of a folder: dda, evaluation, feed, lib, quadrant, three_axis
    #[arg(value_name = "FOLDER")]
    pub folder: Option<String>,
}

/// `discreta new`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta new evaluation/line
        writes line.json
  discreta new evaluation/line_gates my-line.json")]
pub struct NewArgs {
    /// The circuit, as `discreta circuits` lists it, with or without `discreta:`
    #[arg(value_name = "CIRCUIT")]
    pub circuit: String,

    /// Where to [default: its name in this folder; `-` is standard output]
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub file: Option<PathBuf>,
}

/// `discreta completions`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta completions bash > ~/.local/share/bash-completion/completions/discreta
  discreta completions fish > ~/.config/fish/completions/discreta.fish")]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// `discreta man`.
#[derive(Args, Debug, Clone)]
#[command(after_help = "\
Examples:
  discreta man | man -l -
  discreta man run > discreta-run.1")]
pub struct ManArgs {
    /// The command; without one, the page of discreta itself
    #[arg(value_name = "COMMAND")]
    pub command: Option<String>,
}

#[cfg(test)]
#[path = "args_tests.rs"]
mod tests;
