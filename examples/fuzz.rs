//! Random netlists with x and z at random times on all engines, every net compared after every instant, until it is
//! stopped or they differ. `docs/inside-the-compiled-engine.md` says more.
//!
//!     cargo run --example fuzz -- --seed 1
//!     cargo run --example fuzz -- --seed 17 --only

#![allow(dead_code)] // of what the tests share only a part is used

#[path = "../tests/support/design.rs"]
mod design;
#[path = "../tests/support/engines.rs"]
mod engines;
#[path = "../tests/support/rng.rs"]
mod rng;

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use clap::Parser;
use discreta::Value;
use discreta::cell::CellKind;
use discreta::netlist::Netlist;
use serde_json::{Value as Json, json};

use design::{CLOCKS, Cell, Design};
use engines::simulator;
use rng::Rng;

/// Ticks from one change of inputs to the next.
const SPACING: u64 = 3;

#[derive(Parser)]
#[command(about = "Random netlists on all engines, compared until they differ")]
struct Options {
    /// The first netlist; each has the number of the one before it and one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What the netlists are of: all kinds of cells, or storage in a tangle of asynchronous controls and clocks
    #[arg(long, value_enum, default_value = "mixed")]
    shape: Shape,
    /// No netlist but the first
    #[arg(long)]
    only: bool,
    /// Netlists after which to end well; none is no end
    #[arg(long)]
    count: Option<u64>,
    /// Where a netlist on which they differ is written
    #[arg(long, default_value = "target/fuzz")]
    folder: std::path::PathBuf,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
enum Shape {
    Mixed,
    Tangled,
}

impl std::fmt::Display for Shape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if *self == Shape::Mixed { "mixed" } else { "tangled" })
    }
}

/// A netlist and what its inputs are set to, tick by tick.
#[derive(Clone)]
struct Case {
    seed: u64,
    design: Design,
    stimulus: Vec<(u64, Vec<(String, Value)>)>,
}

impl Case {
    fn new(seed: u64, shape: Shape) -> Case {
        let mut rng = Rng::new(seed);
        let design = match shape {
            Shape::Mixed if seed.is_multiple_of(3) => Design::new(&mut rng),
            Shape::Mixed => Design::ordered(&mut rng),
            Shape::Tangled => Design::tangled(&mut rng),
        };
        // how often a bit is x or z, and whether that stops after a while
        let mut unknown = *rng.pick(&[u64::MAX, 200, 20, 6]);
        let end = rng.one_in(2).then_some(20);
        let stimulus = (0..60).map(|n| {
            if end == Some(n) {
                unknown = u64::MAX;
            }
            let mut values = Vec::new();
            for (i, (name, width)) in design.signals[..design.inputs].iter().enumerate() {
                if n == 0 && !rng.one_in(8) {
                    values.push((name.clone(), Value::from_u64(0, *width)));
                } else if rng.one_in(2) {
                    let often = if CLOCKS.contains(&i) { unknown.saturating_mul(10) } else { unknown };
                    values.push((name.clone(), rng.four_valued(*width, often)));
                }
            }
            (n * SPACING, values)
        });
        let stimulus = stimulus.collect();
        Case { seed, design, stimulus }
    }

    fn netlist(&self) -> Netlist {
        self.design.build(&mut Rng::new(self.seed))
    }

    /// Runs it on all engines. Where they differ, how.
    fn differs(&self) -> Option<String> {
        let run = || {
            let netlist = self.netlist();
            let mut sim = simulator(&netlist);
            for (tick, values) in &self.stimulus {
                if sim.run_to(*tick).is_err() {
                    return;
                }
                for (name, value) in values {
                    let input = sim.input(name).expect("an input of the netlist");
                    sim.set_value(input, value);
                }
                if sim.settle().is_err() {
                    return;
                }
            }
        };
        catch_unwind(AssertUnwindSafe(run)).err().map(|_| TOLD.take())
    }

    /// What still differs when cells and changes that do not matter are gone, and how it does.
    fn shrunk(mut self, mut told: String) -> (Case, String) {
        let mut less = true;
        while less {
            less = false;
            for at in (0..self.stimulus.len()).rev() {
                let mut candidate = self.clone();
                candidate.stimulus.remove(at);
                if let Some(other) = candidate.differs() {
                    (self, told, less) = (candidate, other, true);
                }
            }
            for at in (0..self.design.cells.len()).rev() {
                let mut candidate = self.clone();
                // of a bus with several drivers each is left out alone
                let cell = candidate.design.cells.remove(at);
                let shared = |s| candidate.design.cells.iter().any(|c| c.outputs.contains(s));
                let constants: Vec<Cell> = (cell.outputs.iter().filter(|&s| !shared(s)))
                    .map(|&s| {
                        let value = Value::unknown(candidate.design.signals[s].1);
                        Cell { kind: CellKind::Constant(Box::new(value)), inputs: vec![], outputs: vec![s] }
                    })
                    .collect();
                if matches!(cell.kind, CellKind::Constant(_)) {
                    continue;
                }
                candidate.design.cells.extend(constants);
                if let Some(other) = candidate.differs() {
                    (self, told, less) = (candidate, other, true);
                }
            }
        }
        (self, told)
    }

    /// Writes it as a circuit and a scenario, and returns the command that shows the difference.
    fn write(&self, folder: &Path) -> std::io::Result<String> {
        std::fs::create_dir_all(folder)?;
        let at = |end: &str| folder.join(format!("{}.{end}", self.seed));
        std::fs::write(at("json"), discreta::export::yosys::write(&self.netlist(), &Default::default()))?;
        let changes = self.stimulus.iter().flat_map(|(tick, values)| {
            values.iter().map(move |(name, value)| {
                json!({ "at": tick, "set": { (name): format!("{}'b{}", value.width(), value.bit_string()) } })
            })
        });
        let end = self.stimulus.last().map_or(0, |s| s.0);
        let scenario = json!({ "circuit": format!("{}.json", self.seed), "simulation": {
            "stimulus": changes.collect::<Vec<Json>>(), "limit": { "time": end + 1 } } });
        std::fs::write(at("scenario.json"), scenario.to_string())?;
        let run = |engine: &str| {
            format!(
                "discreta run {} --engine {engine} --x-control ignore -o {}",
                at("scenario.json").display(),
                at(&format!("{engine}.vcd")).display()
            )
        };
        let [event, compiled] = ["event.vcd", "compiled.vcd"].map(at);
        Ok(format!("{}\n{}\ndiscreta diff {} {}", run("event"), run("compiled"), event.display(), compiled.display()))
    }
}

thread_local! {
    /// What the last panic said: how the engines differ.
    static TOLD: RefCell<String> = const { RefCell::new(String::new()) };
}

fn main() -> std::io::Result<()> {
    let options = Options::parse();
    std::panic::set_hook(Box::new(|info| {
        TOLD.replace(info.to_string());
    }));
    let (begun, mut last) = (Instant::now(), Instant::now());
    let count = if options.only { 1 } else { options.count.unwrap_or(u64::MAX) };
    for n in 0..count {
        let seed = options.seed + n;
        let case = Case::new(seed, options.shape);
        if let Some(told) = case.differs() {
            println!("seed {seed} differs; {told}\nmaking it smaller …");
            let (case, told) = case.shrunk(told);
            let cells = case.design.cells.iter().filter(|c| !matches!(c.kind, CellKind::Constant(_))).count();
            println!("{cells} cells, {} changes are left; {told}\n", case.stimulus.len());
            println!(
                "{}\n\ncargo run --example fuzz -- --shape {} --seed {seed} --only",
                case.write(&options.folder)?,
                options.shape
            );
            std::process::exit(1);
        }
        if last.elapsed() > Duration::from_secs(2) || n + 1 == count {
            let rate = (n + 1) as f64 / begun.elapsed().as_secs_f64();
            let engines::Ran { event, compiled, batch, compared } = engines::so_far();
            println!(
                "seeds {} to {seed}, {rate:.0}/s: {event} on event, {compiled} on compiled, {batch} on batch; all nets compared {compared} times",
                options.seed
            );
            last = Instant::now();
        }
    }
    Ok(())
}
