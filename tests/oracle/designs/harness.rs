//! A design, its stimulus, and the way of both through Icarus and through Yosys and discreta.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use discreta::wave::read::Waves;
use serde_json::{Value as Json, json};

use super::compare::{Compared, Rules, compare};
use crate::support::runs::run_everywhere;
use crate::support::tool::tool;
use crate::support::{folder, repository};

/// A clock: 0, 1 from `first` on, each for half a period (ns).
pub struct Clock {
    pub net: &'static str,
    pub period: u64,
    pub first: u64,
}

/// An input of the top module that is no clock.
pub struct Input {
    pub net: &'static str,
    pub width: u32,
    /// Its value from 1 ns on, as Verilog and discreta write it.
    pub value: &'static str,
    /// A port in both directions: z here leaves it to the design.
    pub both_ways: bool,
}

pub const fn input(net: &'static str, width: u32, value: &'static str) -> Input {
    Input { net, width, value, both_ways: false }
}

/// At this time (ns) an input gets a value.
pub type Change = (u64, &'static str, String);

/// From when on netlist and source agree, where that is not from the start.
pub struct Known {
    /// For words, in ns.
    pub words: u64,
    /// For gates, in ns.
    pub gates: u64,
    /// Why not before.
    pub because: &'static str,
}

pub struct Design {
    /// The top module.
    pub name: &'static str,
    /// Its source, below `tests/verilog`.
    pub source: &'static str,
    /// Files that it reads, below `tests/verilog`.
    pub files: &'static [&'static str],
    pub clocks: &'static [Clock],
    pub inputs: Vec<Input>,
    pub stimulus: fn() -> Vec<Change>,
    /// How long it runs, in ns.
    pub end: u64,
    pub known: Known,
    /// States that synthesis encodes anew.
    pub recoded: &'static [&'static str],
    /// Why gates know values where the source has x, if they do.
    pub gates_know_more: &'static str,
    /// Nets of Icarus that no netlist of words has: `*` stands for anything.
    pub absent: &'static [&'static str],
    /// Memories whose words are nets where memories are made of flip-flops: name and number of words.
    pub words: &'static [(&'static str, u32)],
    /// Passes that make gates of it, in place of `synth` and `synth -flatten`.
    pub gates: Option<&'static str>,
    /// How long gates run, if not as long as words.
    pub gates_end: Option<u64>,
    /// At which levels it is run.
    pub levels: &'static [Level],
    /// Texts of the source and what a mutant has in their place.
    pub mutants: &'static [(&'static str, &'static str)],
    /// At every level at least so many nets and changes are compared.
    pub least: (usize, usize),
}

/// How far Yosys takes a design.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Level {
    /// `prep`.
    Words,
    /// `prep -flatten`, parameters as numbers.
    FlatWords,
    /// `synth`: gates.
    Gates,
    /// `synth -flatten`.
    FlatGates,
    /// Tables of four inputs.
    Luts,
    /// NAND, NOR, AND-OR-invert.
    Cmos,
}

impl Level {
    pub const ALL: [Level; 6] =
        [Level::Words, Level::FlatWords, Level::Gates, Level::FlatGates, Level::Luts, Level::Cmos];

    pub fn is_gates(self) -> bool {
        !matches!(self, Level::Words | Level::FlatWords)
    }

    /// The passes of Yosys, and what writes the netlist. The last two begin with what `FlatGates` left.
    fn passes(self, design: &Design) -> String {
        let top = design.name;
        // without `tribuf` Yosys makes gates of drivers that are z now and then
        let begin = format!("design -load source; hierarchy -check -top {top}; proc; tribuf");
        let synth = design.gates.unwrap_or("synth");
        match self {
            Level::Words => format!("design -load source; prep -top {top}; write_json"),
            Level::FlatWords => format!("design -load source; prep -flatten -top {top}; write_json -compat-int"),
            Level::Gates => format!("{begin}; {synth}; write_json"),
            Level::FlatGates => format!("{begin}; flatten; {synth}; design -save gates; write_json"),
            Level::Luts => "design -load gates; abc -lut 4; opt_clean; write_json -compat-int".to_owned(),
            Level::Cmos => "design -load gates; abc -g cmos4; opt_clean; write_json".to_owned(),
        }
    }
}

impl Design {
    pub fn source(&self) -> PathBuf {
        repository("tests/verilog").join(self.source)
    }

    /// A folder of its own, with the files that it reads.
    pub fn folder(&self, what: &str) -> PathBuf {
        let folder = folder(&format!("designs_{}{what}", self.name));
        for file in self.files {
            let from = repository("tests/verilog").join(file);
            std::fs::copy(&from, folder.join(from.file_name().unwrap())).unwrap();
        }
        folder
    }

    /// The bench in Verilog.
    fn bench(&self) -> String {
        let mut bench = "`timescale 1ns/1ns\nmodule bench;\n".to_owned();
        let mut ports = Vec::new();
        for Clock { net, period, first } in self.clocks {
            let half = period / 2;
            writeln!(
                bench,
                "  reg \\{net} = 0;\n  initial begin #{first} \\{net} = 1; forever #{half} \\{net} = ~\\{net} ; end"
            )
            .unwrap();
            ports.push(format!(".\\{net} (\\{net} )"));
        }
        for Input { net, width, value, both_ways } in &self.inputs {
            writeln!(bench, "  reg [{}:0] \\{net} ;\n  initial #1 \\{net} = {value};", width - 1).unwrap();
            if *both_ways {
                writeln!(bench, "  wire [{}:0] \\{net}$ = \\{net} ;", width - 1).unwrap();
            }
            ports.push(format!(".\\{net} (\\{net}{} )", if *both_ways { "$" } else { "" }));
        }
        writeln!(bench, "  \\{top} \\{top} ({});", ports.join(", "), top = self.name).unwrap();
        writeln!(bench, "  initial begin\n    $dumpfile(\"icarus.vcd\");\n    $dumpvars(0, \\{} );", self.name)
            .unwrap();
        for (memory, words) in self.words {
            (0..*words).for_each(|i| writeln!(bench, "    $dumpvars(1, \\{} .{memory}[{i}]);", self.name).unwrap());
        }
        let mut now = 0;
        for (at, net, value) in (self.stimulus)() {
            writeln!(bench, "    #{} \\{net} = {value};", at - now).unwrap();
            now = at;
        }
        writeln!(bench, "    #{} $finish;\n  end\nendmodule", self.end - now).unwrap();
        bench
    }

    /// What Icarus makes of the source.
    pub fn icarus(&self, folder: &Path) -> Waves {
        std::fs::write(folder.join("bench.v"), self.bench()).unwrap();
        let source = self.source();
        // as of 2012 what a variable has at the start is no change, hence no edge
        tool(folder, "iverilog", &["-g2012", "-s", "bench", "-o", "bench.vvp", "bench.v", source.to_str().unwrap()]);
        tool(folder, "vvp", &["-n", "bench.vvp"]);
        Waves::open(&folder.join("icarus.vcd")).unwrap()
    }

    /// What Yosys makes of a source at some levels, all in one run of it.
    pub fn synthesise(&self, folder: &Path, source: &Path, levels: &[Level]) {
        self.synthesise_by("yosys", folder, source, levels);
    }

    /// The same, by the Yosys of this name.
    pub fn synthesise_by(&self, yosys: &str, folder: &Path, source: &Path, levels: &[Level]) {
        let mut script = format!("read_verilog {}; design -save source", source.display());
        for level in levels {
            // a newer one makes no words of several drivers of a net without `tribuf`
            let words = format!("hierarchy -check -top {}; proc; tribuf; prep", self.name);
            let passes = level.passes(self);
            let passes = if yosys == "yosys" { passes } else { passes.replacen("prep", &words, 1) };
            write!(script, "; {passes} {level:?}.json").unwrap();
        }
        tool(folder, yosys, &["-q", "-p", &script]);
    }

    /// What discreta makes of the netlist of a level.
    pub fn discreta(&self, folder: &Path, level: Level) -> Waves {
        let clocks: serde_json::Map<String, Json> = (self.clocks.iter())
            .map(|c| (c.net.to_owned(), json!({ "period": c.period, "phase": c.first, "high": c.period / 2 })))
            .collect();
        let begin = self.inputs.iter().map(|i| (1, i.net, i.value.to_owned()));
        let stimulus: Vec<Json> = begin
            .chain((self.stimulus)())
            .filter(|(at, ..)| *at < self.end_at(level))
            .map(|(at, net, value)| json!({ "at": at, "set": { (net): value } }))
            .collect();
        let scenario = json!({ "circuit": format!("{level:?}.json"), "simulation": {
            "clocks": clocks, "stimulus": stimulus, "limit": { "time": self.end_at(level) } } });
        let [file, waves] = ["scenario.json", "vcd"].map(|end| folder.join(format!("{level:?}.{end}")));
        std::fs::write(&file, scenario.to_string()).unwrap();
        let ran = run_everywhere(folder, &["run", file.to_str().unwrap(), "-o", waves.to_str().unwrap()]);
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        Waves::open(&waves).unwrap()
    }

    /// Whether a net that Icarus has may be missing in a netlist of words.
    pub fn may_lack(&self, net: &str) -> bool {
        self.absent.iter().any(|pattern| matches(net, pattern))
    }

    /// The ports of the top module.
    fn ports(&self, folder: &Path, level: Level) -> Vec<String> {
        let netlist = std::fs::read(folder.join(format!("{level:?}.json"))).unwrap();
        let netlist: Json = serde_json::from_slice(&netlist).unwrap();
        netlist["modules"][self.name]["ports"].as_object().unwrap().keys().cloned().collect()
    }

    fn end_at(&self, level: Level) -> u64 {
        if level.is_gates() { self.gates_end.unwrap_or(self.end) } else { self.end }
    }

    /// Compares the two at a level.
    pub fn compare(&self, folder: &Path, icarus: &mut Waves, ours: &mut Waves, level: Level) -> Compared {
        let from = if level.is_gates() { self.known.gates } else { self.known.words };
        let ports = self.ports(folder, level);
        for port in &ports {
            let has = |waves: &Waves, above: &str| waves.find(&format!("{above}{}.{port}", self.name)).is_some();
            assert!(has(icarus, "bench.") && has(ours, ""), "{} {level:?} has no {port}", self.name);
        }
        let rules = Rules {
            over: from..self.end_at(level),
            may_lose: level.is_gates().then_some(&ports[..]),
            recoded: if level.is_gates() { self.recoded } else { &[] },
            x_is_free: level.is_gates() && !self.gates_know_more.is_empty(),
        };
        compare(icarus, ours, &rules)
    }
}

/// Whether a net is meant by a name with at most one `*`.
pub fn matches(net: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        Some((begin, end)) => net.starts_with(begin) && net.ends_with(end) && net.len() >= begin.len() + end.len(),
        None => net == pattern,
    }
}
