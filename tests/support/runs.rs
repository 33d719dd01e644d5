//! The program's `run` on every engine that takes the circuit, with the bytes of the waveforms compared.
#![allow(dead_code)] // each test uses a part

use std::path::Path;
use std::process::{Command, Output};

use super::engines::count;

/// `discreta run` with these arguments, of which one after `-o` names a waveform: on the event engine, and where the
/// circuit can be compiled on the compiled engine, which has to end in the same way and to write the same bytes. What the
/// event engine did.
pub fn run_everywhere(folder: &Path, arguments: &[&str]) -> Output {
    let run = |engine: &str, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
        command.current_dir(folder).args(arguments).args(["--engine", engine]).output().unwrap()
    };
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let event = run("event", arguments);
    count(|ran| ran.event += 1);
    if !cfg!(feature = "compiled") {
        return event;
    }
    let at = arguments.iter().position(|a| *a == "-o").expect("a waveform") + 1;
    let other = format!("{}.compiled.vcd", arguments[at]);
    let mut arguments = arguments.to_vec();
    let waves = std::mem::replace(&mut arguments[at], &other);
    let compiled = run("compiled", &arguments);
    let told = text(&compiled.stderr);
    if let Some((_, why)) = told.split_once("cannot be compiled: ") {
        super::engines::may_refuse(why);
        return event;
    }
    let label = arguments.join(" ");
    assert_eq!(compiled.status.code(), event.status.code(), "{label}: {told}");
    assert_eq!(text(&compiled.stdout).replace(&other, waves), text(&event.stdout), "{label}");
    assert_eq!(told.replace(&other, waves), text(&event.stderr), "{label}");
    if let Ok(expected) = std::fs::read(folder.join(waves)) {
        // not by `assert_eq`, which would print all of both
        assert!(std::fs::read(folder.join(&other)).unwrap() == expected, "{label}: the waveforms differ");
        std::fs::remove_file(folder.join(&other)).unwrap();
    }
    count(|ran| {
        ran.compiled += 1;
        ran.compared += 1;
    });
    event
}
