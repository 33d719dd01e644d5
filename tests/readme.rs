//! The README's circuit is one: it checks, and counts to what one counts by hand.

use std::process::Command;

#[test]
fn the_circuit_in_the_readme_runs() {
    let readme = include_str!("../README.md");
    let circuit = readme.split_once("```json\n").unwrap().1.split_once("```").unwrap().0;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("count_up.json");
    std::fs::write(&path, circuit).unwrap();
    let discreta = |command: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_discreta")).arg(command).arg(&path).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(discreta("check").ends_with(": no faults\n"));
    // 20 clocks from 0, modulo 16
    assert!(discreta("run").contains("q = 4"), "{}", discreta("run"));
}
