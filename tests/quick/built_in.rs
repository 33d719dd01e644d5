//! The circuits that travel in the program: they are those of the repository, work anywhere, and can be copied.

use std::fs;
use std::process::Command;

use discreta::circuit;

use crate::support::folder;

fn run(at: &std::path::Path, line: &str) -> (Option<i32>, String, String) {
    let done = Command::new(env!("CARGO_BIN_EXE_discreta")).args(line.split(' ')).current_dir(at).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (done.status.code(), text(done.stdout), text(done.stderr))
}

#[test]
fn each_is_the_circuit_of_its_file_and_so_is_a_copy() {
    let at = folder("built_in_copies");
    let mut tops = 0;
    for (name, text) in circuit::built_in() {
        let path = format!("circuits/{name}.json");
        assert_eq!(text, fs::read_to_string(&path).unwrap());
        let copy = at.join(format!("{}.json", name.replace('/', "_")));
        let _ = fs::remove_file(&copy);
        let (status, _, told) = run(&at, &format!("new {name} {}", copy.display()));
        assert_eq!(status, Some(0), "{told}");
        let load = |name: &str| circuit::load(name).map(|c| c.netlist.fingerprint()).map_err(|e| e.to_string());
        match load(&path) {
            Ok(own) => {
                assert_eq!(load(&format!("discreta:{name}")), Ok(own));
                assert_eq!(load(copy.to_str().unwrap()), Ok(own), "{name}");
                tops += 1;
            }
            // a library: its copy is as good
            Err(_) => assert_eq!(run(&at, &format!("check {}", copy.display())).0, Some(0), "{name}"),
        }
    }
    assert!(tops > 20, "{tops}");
}

#[test]
fn they_run_where_no_file_is() {
    let at = folder("built_in_anywhere");
    let _ = fs::remove_file(at.join("line.json"));
    let (status, told, _) = run(&at, "run discreta:evaluation/line -s dx=5 -s dy=3");
    assert!(status == Some(0) && told.contains("end"), "{told}");
    let text = r#"{ "import": ["discreta:lib/arithmetic"], "modules": { "top": {
        "ports": { "a": { "direction": "input", "width": 4 }, "b": { "direction": "input", "width": 4 },
            "y": { "direction": "output", "width": 4 } }, "nets": { "c": {}, "zero": {} },
        "cells": { "add": { "type": "ripple_adder", "parameters": { "W": 4 },
            "connections": { "a": "a", "b": "b", "ci": "1'b0", "s": "y" } } } } } }"#;
    fs::write(at.join("own.json"), text).unwrap();
    let (status, _, told) = run(&at, "check own.json");
    assert!(!told.contains("discreta:lib/arithmetic"), "{status:?} {told}");
    fs::write(at.join("scenario.json"), r#"{ "circuit": "discreta:evaluation/line" }"#).unwrap();
    assert_eq!(run(&at, "run scenario.json").0, Some(0));

    let (status, told, _) = run(&at, "circuits");
    assert!(status == Some(0) && told.contains("discreta:evaluation/line ") && told.lines().count() > 30, "{told}");
    assert!(told.lines().all(|l| l.split_once("  ").is_some_and(|(_, about)| about.trim().len() > 10)), "{told}");
    let (status, told, _) = run(&at, "circuits lib");
    assert!(status == Some(0) && told.lines().all(|l| l.starts_with("discreta:lib/")), "{told}");
}

#[test]
fn what_is_not_there_is_told_and_nothing_is_overwritten() {
    let at = folder("built_in_faults");
    let _ = fs::remove_file(at.join("line.json"));
    let (status, _, told) = run(&at, "run discreta:evaluation/lime");
    assert!(status == Some(2) && told.contains("did you mean `discreta:evaluation/line`?"), "{told}");
    let (status, _, told) = run(&at, "new evaluation/lime");
    assert!(status == Some(2) && told.contains("did you mean `evaluation/line`?"), "{told}");
    let (status, _, told) = run(&at, "circuits nothing");
    assert!(status == Some(2) && told.contains("dda, evaluation"), "{told}");
    assert_eq!(run(&at, "new evaluation/line").0, Some(0));
    assert_eq!(run(&at, "run line.json").0, Some(0));
    let before = fs::read_to_string(at.join("line.json")).unwrap();
    let (status, _, told) = run(&at, "new evaluation/line");
    assert!(status == Some(2) && told.contains("is there already"), "{told}");
    assert_eq!(fs::read_to_string(at.join("line.json")).unwrap(), before);
}
