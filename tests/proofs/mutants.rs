//! Broken circuit files by the thousand: whatever is done to a good one, it is refused or it runs, and soon.
//!
//! The changes are drawn from a generator with a fixed seed, so that a failure can be had again by its number.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use crate::support::Rng;
use discreta::circuit::{Limits, Loader};
use discreta::engine::EventEngine;
use discreta::scenario::{Control, Scenario};

/// No mutant may take longer.
const PATIENCE: Duration = Duration::from_secs(20);
/// How many there are, unless the environment's `MUTANTS` asks for more.
const MUTANTS: u64 = 2000;
/// Ticks that a mutant runs.
const TICKS: u64 = 1000;

/// What a number or text of a file may become.
const VALUES: &[&str] = &[
    "0",
    "1",
    "-1",
    "2",
    "3",
    "64",
    "65",
    "1e3",
    "1.5",
    "65536",
    "1099511627776",
    "9223372036854775807",
    "-9223372036854775808",
    "99999999999999999999",
    "null",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\"x\"",
    "\"W\"",
    "\"W+1\"",
    "\"1 << 62\"",
    "\"W/0\"",
    "\"f[W]\"",
    "\"f[0:W]\"",
    "\"4'b10x1\"",
    "\"64'd0\"",
    "\"(W+1){f}\"",
    "\"f\"",
    "\"dt\"",
    "\"start\"",
    "\"x\"",
    "\"end\"",
    "\"0ns\"",
    "\"1s\"",
    "\"falling\"",
    "\"line\"",
    "\"counter\"",
    "\"tristate\"",
    "\"delay\"",
    "\"not\"",
    "\"xor\"",
    "\"**\"",
    "[\"f\", \"f\"]",
    "[[\"f\"]]",
    "{ \"i\": 3 }",
    "{ \"i\": \"W\" }",
    "{ \"x\": { \"period\": 2 } }",
];

/// Words that may stand for one another without a fault, so that the circuit is another one that runs.
const GROUPS: &[&[&str]] = &[
    &["\"and\"", "\"or\"", "\"nand\"", "\"nor\"", "\"xor\"", "\"xnor\""],
    &["\"not\"", "\"buf\"", "\"delay\""],
    &["\"rising\"", "\"falling\""],
    &["\"x\"", "\"y\"", "\"start\"", "\"end\"", "\"dt\"", "\"allow_x\"", "\"allow_y\"", "\"not_sign\"", "\"running\""],
    &["\"dx\"", "\"dy\"", "\"xh\"", "\"yh\"", "\"kox\"", "\"koy\""],
    &["0", "1", "3", "5", "8", "255", "\"8'bx1\""],
    &["\"5ns\"", "\"10ns\"", "\"20ns\"", "\"21ns\"", "\"0ns\""],
];

/// Places of the strings, numbers and words in a JSON text.
fn tokens(text: &str) -> Vec<std::ops::Range<usize>> {
    let bytes = text.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let start = at;
        match bytes[at] {
            b'"' => {
                at += 1;
                // a mutant's string may have lost its end
                while bytes.get(at).is_some_and(|&b| b != b'"') {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
                at = (at + 1).min(bytes.len());
                found.push(start..at);
            }
            b if b.is_ascii_alphanumeric() || b == b'-' => {
                while bytes.get(at).is_some_and(|b| b.is_ascii_alphanumeric() || b"-+.".contains(b)) {
                    at += 1;
                }
                found.push(start..at);
            }
            _ => at += 1,
        }
    }
    found
}

/// A good file with one to three things wrong.
fn mutant(good: &str, number: u64) -> Vec<u8> {
    let mut random = Rng::new(number);
    let mut text = good.to_owned();
    if number.is_multiple_of(4) {
        for _ in 0..=random.below(3) {
            let group = random.pick(GROUPS);
            let found: Vec<_> = tokens(&text).into_iter().filter(|t| group.contains(&&text[t.clone()])).collect();
            if !found.is_empty() {
                text.replace_range(random.pick(&found).clone(), random.pick::<&str>(group));
            }
        }
        return text.into_bytes();
    }
    for _ in 0..=random.below(3) {
        let tokens = tokens(&text);
        let (one, other) = (random.pick(&tokens).clone(), random.pick(&tokens).clone());
        match random.below(8) {
            // a value becomes another one of the file, or a strange one
            0..=2 => {
                let new = text[other].to_owned();
                text.replace_range(one, &new);
            }
            3 | 4 => text.replace_range(one, random.pick::<&str>(VALUES)),
            // a letter of a token changes
            5 => {
                let at = one.start + random.below(one.len() as u64) as usize;
                if text.is_char_boundary(at) && text.is_char_boundary(at + 1) {
                    text.replace_range(
                        at..=at,
                        random.pick::<&str>(&["a", "0", "9", "[", "]", ":", "(", "+", "'", "\\", "é"]),
                    );
                }
            }
            // lines go, or come twice
            6 => {
                let mut lines: Vec<&str> = text.lines().collect();
                let at = random.below(lines.len() as u64) as usize;
                if random.below(2) == 0 {
                    lines.remove(at);
                } else {
                    lines.insert(at, lines[at]);
                }
                text = lines.join("\n") + "\n";
            }
            // any bytes; no further changes, since it may be no text any more
            _ => {
                let mut bytes = text.into_bytes();
                for _ in 0..=random.below(4) {
                    let at = random.below(bytes.len() as u64) as usize;
                    match random.below(3) {
                        0 => bytes[at] = random.word() as u8,
                        1 => drop(bytes.remove(at)),
                        _ => bytes.truncate(at + 1),
                    }
                }
                return bytes;
            }
        }
    }
    text.into_bytes()
}

/// Reads, elaborates, resolves and, if there is no fault, runs. Whether it ran.
fn check(path: &Path) -> bool {
    let limits = Limits { cells: 100_000, bits: 1 << 20, repeat: 10_000, ..Limits::default() };
    let mut loader = Loader::new(limits);
    let file = loader.open(path);
    let circuit = file.and_then(|file| loader.elaborate(file, &[]));
    if let Some(file) = file {
        loader.check_rest(file);
    }
    let scenario = circuit.as_ref().filter(|_| !loader.diagnostics.has_errors()).map(|circuit| {
        Scenario::resolve(circuit, &circuit.simulation.clone().unwrap_or_default(), &mut loader.diagnostics)
    });
    loader.diagnostics.sort();
    let told = loader.diagnostics.render(&loader.sources, false);
    assert_eq!(told.is_empty(), loader.diagnostics.is_empty());
    let (Some(circuit), Some(mut scenario), false) = (circuit, scenario, loader.diagnostics.has_errors()) else {
        assert!(told.contains("error["), "refused without a reason: {told}");
        return false;
    };
    scenario.limit = scenario.limit.min(TICKS);
    let mut engine = EventEngine::new(&circuit.netlist);
    let (interrupt, mut progress) = (AtomicBool::new(false), |_| {});
    let mut control = Control {
        interrupt: &interrupt,
        progress: &mut progress,
        message: &mut |_, _, _| {},
        unknown_control_ends: false,
        observers: Vec::new(),
    };
    // it may well not settle
    let _ = discreta::scenario::run(&circuit.netlist, &scenario, &mut engine, None, &mut control);
    true
}

#[test]
fn no_mutant_panics_or_hangs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(dir.path().join("circuits/lib")).unwrap();
    for library in std::fs::read_dir(root.join("circuits/lib")).unwrap() {
        let library = library.unwrap().path();
        std::fs::copy(&library, dir.path().join("circuits/lib").join(library.file_name().unwrap())).unwrap();
    }
    std::fs::create_dir(dir.path().join("circuits/evaluation")).unwrap();
    let path: PathBuf = dir.path().join("circuits/evaluation/mutant.json");
    let good = |name: &str| std::fs::read_to_string(root.join("circuits/evaluation").join(name)).unwrap();
    let goods = [good("line.json"), good("line_gates.json")];
    for text in &goods {
        std::fs::write(&path, text).unwrap();
        assert!(check(&path), "the file itself is good");
    }
    let mutants = std::env::var("MUTANTS").map_or(MUTANTS, |n| n.parse().expect("MUTANTS is a number"));
    let (mut ran, mut bad) = (0, Vec::new());
    for number in 0..mutants {
        let bytes = mutant(&goods[number as usize / 4 % goods.len()], number);
        std::fs::write(&path, &bytes).unwrap();
        let started = Instant::now();
        match std::panic::catch_unwind(|| check(&path)) {
            Ok(fine) => ran += u64::from(fine),
            Err(_) => bad.push(format!("mutant {number} panics")),
        }
        if started.elapsed() > PATIENCE {
            bad.push(format!("mutant {number} takes {:?}", started.elapsed()));
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
    // else the changes would be too gross to get beyond the reader, or too small to matter
    assert!((mutants / 10..mutants * 9 / 10).contains(&ran), "{ran} of {mutants} ran");
}
