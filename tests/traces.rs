//! The golden traces: the program still makes them, and they are what the algorithm does on every clock.
//!
//! They are read here by the `vcd` crate's parser and followed by [`EfLine`], so neither our writer, our reader nor the
//! engine vouches for itself.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::process::Command;

use discreta::interpolate::{EfLine, EfLineInput};
use vcd::{IdCode, ScopeItem, Value};

/// The values of the top scope's nets after each instant at which something changes.
fn instants(path: &Path) -> BTreeMap<u64, HashMap<String, Option<u64>>> {
    let mut parser = vcd::Parser::new(BufReader::new(File::open(path).unwrap()));
    let header = parser.parse_header().unwrap();
    let [top] = &header
        .items
        .iter()
        .filter_map(|i| if let ScopeItem::Scope(s) = i { Some(s) } else { None })
        .collect::<Vec<_>>()[..]
    else {
        panic!("one top scope")
    };
    let mut names: HashMap<IdCode, Vec<String>> = HashMap::new();
    for item in &top.items {
        if let ScopeItem::Var(v) = item {
            names.entry(v.code).or_default().push(v.reference.clone());
        }
    }
    let mut now = 0;
    let mut values = HashMap::new();
    let mut all = BTreeMap::new();
    for command in parser {
        let (id, value) = match command.unwrap() {
            vcd::Command::Timestamp(t) => {
                all.insert(now, values.clone());
                now = t;
                continue;
            }
            vcd::Command::ChangeScalar(id, v) => (id, vec![v]),
            vcd::Command::ChangeVector(id, v) => (id, v.iter().collect()),
            _ => continue,
        };
        let number = value.iter().try_fold(0u64, |n, bit| match bit {
            Value::V0 => Some(n << 1),
            Value::V1 => Some(n << 1 | 1),
            _ => None,
        });
        for name in names.get(&id).into_iter().flatten() {
            values.insert(name.clone(), number);
        }
    }
    all.insert(now, values);
    all
}

/// Follows a trace with the algorithm; returns the clocks compared.
fn follow(path: &Path) -> usize {
    let instants: Vec<_> = instants(path).into_iter().collect();
    let mut algorithm: Option<EfLine> = None;
    let mut compared = 0;
    let mut steps = (0, 0);
    for (i, (time, now)) in instants.iter().enumerate() {
        let get = |name: &str| {
            now.get(name)
                .copied()
                .flatten()
                .unwrap_or_else(|| panic!("{}: {name} is unknown at {time}: {now:?}", path.display()))
        };
        let before = |name: &str| i.checked_sub(1).and_then(|i| instants[i].1[name]);
        let state = |a: &EfLine| {
            let s = a.state();
            // F in two's complement of 9 bits
            [s.xt, s.yt, s.kox, s.koy, s.f as u64 & 0x1ff, u64::from(s.end)]
        };
        let held = || ["xt", "yt", "kox", "koy", "f", "end"].map(get);
        if get("start") == 1 {
            let number = |name: &str| get(name) as i64;
            let input = EfLineInput { xh: number("xh"), yh: number("yh"), dx: number("dx"), dy: number("dy"), bits: 8 };
            let a = EfLine::new(input).unwrap();
            assert_eq!(held(), state(&a), "{} at {time}, START", path.display());
            algorithm = Some(a);
            continue;
        }
        let Some(a) = &mut algorithm else { continue };
        match (before("dt"), get("dt")) {
            (Some(0), 1) => steps = (get("x"), get("y")),
            (Some(1), 0) => {
                let clock = a.next();
                let expected = clock.map_or((0, 0), |c| (u64::from(c.x), u64::from(c.y)));
                assert_eq!(steps, expected, "{} at {time}: pulses", path.display());
                compared += 1;
            }
            _ => {}
        }
        assert_eq!(held(), state(a), "{} at {time}", path.display());
        if get("dt") == 0 {
            assert_eq!((get("x"), get("y")), (0, 0), "{} at {time}: a pulse without a clock", path.display());
        }
    }
    compared
}

#[test]
fn golden_traces_follow_the_algorithm_on_every_clock() {
    let mut compared = 0;
    let mut traces = 0;
    for entry in std::fs::read_dir("traces").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "vcd") {
            compared += follow(&path);
            traces += 1;
        }
    }
    assert!(traces >= 11 && compared >= 580, "{traces} traces, {compared} clocks");
}

#[test]
fn the_program_makes_the_golden_traces() {
    let output = Command::new(env!("CARGO_BIN_EXE_discreta")).args(["test", "traces"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("11 passed, 0 failed"), "{text}");
}
