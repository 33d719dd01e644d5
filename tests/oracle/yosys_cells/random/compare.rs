//! The same netlists on both simulators.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use discreta::Value;

use super::design::Design;
use super::generate::FRAME;
use crate::support::engines::{Sim, simulator};
use crate::yosys_cells::batch::{OWN, library};

/// Units of time that the bench takes before the first tick, to give all state its first value.
const WARM: u64 = 10;

/// The first net and tick at which the two differ.
#[derive(Debug, Clone)]
pub struct Difference {
    pub tick: u64,
    pub net: String,
    pub wire: usize,
    pub ours: String,
    pub theirs: String,
}

/// What came of a comparison.
#[derive(Default)]
pub struct Outcome {
    /// Of each netlist, what differs.
    pub differences: Vec<Option<Difference>>,
    /// Changes of nets that Icarus had.
    pub changes: u64,
    /// Nets at ticks that were equal, and those of them that had no x or z.
    pub compared: u64,
    pub known: u64,
}

/// The level of each input at each tick at which one changes: tick, values in the order of the inputs.
fn rows(design: &Design) -> Vec<(u64, Vec<Value>)> {
    let mut events: Vec<(u64, usize, Value)> = Vec::new();
    for (i, input) in design.inputs.iter().enumerate() {
        match input.clock {
            Some(clock) => {
                events.push((0, i, Value::from_u64(0, 1)));
                let mut rise = clock.phase;
                while rise <= design.end {
                    events.push((rise, i, Value::from_u64(1, 1)));
                    events.push((rise + clock.high, i, Value::from_u64(0, 1)));
                    rise += clock.period;
                }
            }
            None => events.extend(input.values.iter().map(|(at, value)| (*at, i, value.clone()))),
        }
    }
    events.retain(|e| e.0 <= design.end);
    events.sort_by_key(|e| e.0);
    let mut now: Vec<Value> = design.inputs.iter().map(|i| Value::unknown(design.wires[i.wire])).collect();
    let mut rows: Vec<(u64, Vec<Value>)> = Vec::new();
    for (tick, input, value) in events {
        now[input] = value;
        match rows.last_mut() {
            Some(last) if last.0 == tick => last.1.clone_from(&now),
            _ => rows.push((tick, now.clone())),
        }
    }
    rows
}

/// Cells whose model is an `always` block, which waits for a change of what it reads.
const WAITING: &[&str] = &[
    "$shiftx",
    "$sop",
    "$macc",
    "$macc_v2",
    "$pmux",
    "$pow",
    "$lcu",
    "$alu",
    "$div",
    "$mod",
    "$divfloor",
    "$modfloor",
];

/// The bench of some netlists, and its stimulus.
pub fn bench(designs: &[Design]) -> (String, String) {
    let all: Vec<Vec<(u64, Vec<Value>)>> = designs.iter().map(rows).collect();
    let mut ticks: Vec<u64> = all.iter().flatten().map(|r| r.0).collect();
    ticks.sort_unstable();
    ticks.dedup();
    let total: u32 = designs.iter().flat_map(|d| d.inputs.iter().map(|i| d.wires[i.wire])).sum();
    let (mut text, mut scopes, mut at) = (String::new(), Vec::new(), 0);
    let (mut kicks, mut releases, mut presets) = (String::new(), String::new(), String::new());
    for (n, design) in designs.iter().enumerate() {
        text += &design.verilog(n);
    }
    writeln!(text, "module bench;\nreg k0, k1, kx, kz; reg [{total}-1:0] in; integer r;").unwrap();
    writeln!(text, "reg [{total}+31:0] rows [0:{}];", ticks.len() - 1).unwrap();
    for (n, design) in designs.iter().enumerate() {
        let ports = design.inputs.iter().map(|i| {
            let from = at;
            at += design.wires[i.wire];
            format!(".w{}(in[{}:{from}])", i.wire, at - 1)
        });
        writeln!(text, "d{n}_m0 n{n} ({});", ports.collect::<Vec<_>>().join(", ")).unwrap();
        scopes.extend(
            (0..design.groups.len()).map(|g| format!("n{n}.{}", design.path(g)).trim_end_matches('.').to_owned()),
        );
        for (i, item) in design.items.iter().enumerate().filter(|i| WAITING.contains(&i.1.cell.kind.as_str())) {
            let (path, (pin, width)) = (design.path(item.group), item.cell.inputs[0]);
            writeln!(kicks, "  force n{n}.{path}c{i}.{pin} = {width}'b0;").unwrap();
            writeln!(releases, "  release n{n}.{path}c{i}.{pin};").unwrap();
        }
        for (i, item) in design.items.iter().enumerate().filter(|i| i.1.preset) {
            let width = item.cell.outputs[0].1;
            let init = item.cell.init.clone().unwrap_or_else(|| Value::unknown(width));
            writeln!(presets, "    n{n}.{}c{i}.Q = {width}'b{};", design.path(item.group), init.bit_string()).unwrap();
        }
    }
    write!(
        text,
        "initial begin\n  $readmemb(\"stimulus.txt\", rows); $dumpfile(\"icarus.vcd\"); $dumpvars(1, {});\n  \
         {{k0, k1, kx, kz}} = 4'b01xz; in = rows[0]; #1;\n{kicks}#1;\n{releases}  \
         repeat ({WARM} - 3) begin #1;\n{presets}  end\n  \
         for (r = 1; r < {}; r = r + 1) begin #(rows[r][{total} +: 32] + {WARM} - $time); in = rows[r]; end\n  \
         #({} + {WARM} - $time) $finish;\nend\nendmodule\n",
        scopes.join(", "),
        ticks.len(),
        designs.iter().map(|d| d.end).max().unwrap_or(0) + 1,
    )
    .unwrap();
    let mut stimulus = String::new();
    let mut place = vec![0; all.len()];
    for tick in ticks {
        write!(stimulus, "{tick:032b}").unwrap();
        for (place, rows) in place.iter_mut().zip(&all) {
            while rows.get(*place + 1).is_some_and(|r| r.0 <= tick) {
                *place += 1;
            }
        }
        // the first input is the lowest
        for (place, rows) in place.iter().zip(&all).rev() {
            rows[*place].1.iter().rev().for_each(|v| stimulus += &v.bit_string());
        }
        stimulus.push('\n');
    }
    (text, stimulus)
}

/// Runs Icarus on a bench; the waveform.
fn icarus(folder: &Path, designs: &[Design], models: &str) -> String {
    let (text, stimulus) = bench(designs);
    std::fs::write(folder.join("bench.v"), text).unwrap();
    std::fs::write(folder.join("models.v"), models).unwrap();
    std::fs::write(folder.join("stimulus.txt"), stimulus).unwrap();
    let mut compiler = Command::new("iverilog");
    let compiler =
        compiler.current_dir(folder).args(["-g2012", "-s", "bench", "-o", "bench.vvp", "models.v", "bench.v"]);
    let told = compiler.output().unwrap();
    assert!(told.status.success(), "{}: {}", folder.display(), String::from_utf8_lossy(&told.stderr));
    let told = Command::new("vvp").current_dir(folder).args(["-n", "bench.vvp"]).output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    std::fs::read_to_string(folder.join("icarus.vcd")).unwrap()
}

/// The bits of a value in a waveform, which leaves out leading ones that follow from the next.
fn extended(bits: &str, width: u32) -> String {
    let fill = match bits.as_bytes().first() {
        Some(b'x') => "x",
        Some(b'z') => "z",
        _ => "0",
    };
    fill.repeat((width as usize).saturating_sub(bits.len())) + bits
}

/// A net on both sides.
struct Net {
    name: String,
    wire: usize,
    probe: discreta::Probe,
    ours: Value,
    shown: String,
    theirs: String,
    known: bool,
}

/// The models of all cells.
pub fn models() -> String {
    let read = |name| std::fs::read_to_string(library().join(name)).unwrap();
    [read("simlib.v"), read("simcells.v"), OWN.to_owned()].join("\n")
}

/// Runs netlists on both, on Icarus with these models.
pub fn compare(folder: &Path, designs: &[Design], models: &str) -> Outcome {
    let write = |design: &Design| {
        let path = folder.join(format!("netlist_{}.json", design.seed));
        std::fs::write(&path, serde_json::to_string(&design.json()).unwrap()).unwrap();
        path
    };
    compare_files(folder, designs, models, &designs.iter().map(write).collect::<Vec<_>>())
}

/// The same, with netlists that someone has written.
pub fn compare_files(folder: &Path, designs: &[Design], models: &str, files: &[PathBuf]) -> Outcome {
    let waves = icarus(folder, designs, models);
    let mut outcome = Outcome::default();
    let circuits: Vec<_> = files
        .iter()
        .map(|path| {
            let circuit = discreta::circuit::load(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            std::fs::remove_file(path).unwrap();
            circuit
        })
        .collect();
    let mut sims: Vec<Sim> = circuits.iter().map(|c| simulator(&c.netlist)).collect();
    // what a name in the waveform is
    let mut nets: Vec<Vec<Net>> = Vec::new();
    let mut named: HashMap<String, (usize, usize)> = HashMap::new();
    for (n, (design, sim)) in designs.iter().zip(&sims).enumerate() {
        let mut list = Vec::new();
        for (name, wire) in design.names() {
            named.insert(format!("n{n}.{name}"), (n, list.len()));
            let width = design.wires[wire];
            let probe = sim.probe(&name).unwrap_or_else(|e| panic!("{e}"));
            let (ours, shown) = (Value::unknown(width), "x".repeat(width as usize));
            list.push(Net { name, wire, probe, ours, theirs: shown.clone(), shown, known: false });
        }
        nets.push(list);
    }
    let mut by_code: HashMap<&str, Vec<(usize, usize)>> = HashMap::new();
    let mut scope: Vec<&str> = Vec::new();
    let mut lines = waves.lines();
    for line in lines.by_ref() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["$scope", _, name, ..] => scope.push(name),
            ["$upscope", ..] => drop(scope.pop()),
            ["$var", _, _, code, name, ..] => {
                let name = [&scope[1..], &[name]].concat().join(".");
                by_code.entry(code).or_default().extend(named.remove(&name));
            }
            ["$enddefinitions", ..] => break,
            _ => {}
        }
    }
    assert!(named.is_empty(), "Icarus has no {:?}", named.keys().next());

    let mut inputs = Vec::new();
    for (design, sim) in designs.iter().zip(&mut sims) {
        let handles: Vec<_> = design.inputs.iter().map(|i| sim.input(&format!("w{}", i.wire)).unwrap()).collect();
        for (input, &handle) in design.inputs.iter().zip(&handles) {
            if let Some(clock) = input.clock {
                sim.clock(handle, clock);
            }
        }
        inputs.push(handles);
    }
    outcome.differences = vec![None; designs.len()];
    let mut next: Vec<Vec<usize>> = designs.iter().map(|d| vec![0; d.inputs.len()]).collect();
    let (mut stirred, mut events) = (vec![false; designs.len()], vec![0; designs.len()]);
    let mut lines = lines.peekable();
    let end = designs.iter().map(|d| d.end).max().unwrap_or(0);
    for tick in 0..=end {
        // what Icarus has changed up to the end of this tick
        while let Some(line) = lines.peek() {
            match line.as_bytes().first() {
                Some(b'#') if line[1..].parse::<u64>().unwrap() > tick + WARM => break,
                Some(b'0' | b'1' | b'x' | b'z' | b'b') => {
                    let vector = line.split_once(' ').filter(|_| line.starts_with('b'));
                    let (bits, code) = vector.map_or((&line[..1], &line[1..]), |(bits, code)| (&bits[1..], code));
                    for &(n, i) in by_code.get(code).into_iter().flatten() {
                        let net = &mut nets[n][i];
                        net.theirs = extended(bits, net.ours.width());
                        outcome.changes += 1;
                        stirred[n] = true;
                    }
                }
                _ => {}
            }
            lines.next();
        }
        for (n, (design, sim)) in designs.iter().zip(&mut sims).enumerate() {
            if outcome.differences[n].is_some() || tick > design.end {
                continue;
            }
            // the first values are there before all settles, as they are in the bench
            if tick > 0 {
                sim.run_to(tick).unwrap_or_else(|e| panic!("seed {}: {e}", design.seed));
            }
            let mut changed = tick == 0;
            for (i, input) in design.inputs.iter().enumerate() {
                let at = &mut next[n][i];
                while let Some((_, value)) = input.values.get(*at).filter(|v| v.0 <= tick) {
                    sim.set_value(inputs[n][i], value);
                    (*at, changed) = (*at + 1, true);
                }
            }
            if changed {
                sim.settle().unwrap_or_else(|e| panic!("seed {}: {e}", design.seed));
            }
            // delays need the first ticks to be what they are in the bench, which has begun before
            if tick < FRAME {
                continue;
            }
            // where neither has changed anything all are still equal
            let moved = std::mem::take(&mut stirred[n]) || sim.events() != events[n] || tick == FRAME;
            events[n] = sim.events();
            if !moved {
                outcome.compared += nets[n].len() as u64;
                outcome.known += nets[n].iter().filter(|net| net.known).count() as u64;
                continue;
            }
            for net in &mut nets[n] {
                let ours = sim.value(&net.probe);
                if ours != net.ours {
                    (net.shown, net.known) = (ours.bit_string(), ours.is_known());
                    net.ours = ours;
                }
                outcome.compared += 1;
                outcome.known += u64::from(net.known);
                if net.shown != net.theirs {
                    let (ours, theirs) = (net.shown.clone(), net.theirs.clone());
                    let found = Difference { tick, net: net.name.clone(), wire: net.wire, ours, theirs };
                    outcome.differences[n] = Some(found);
                    break;
                }
            }
        }
    }
    outcome
}
