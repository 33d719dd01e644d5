//! The README's circuit is one: it checks, and counts to what one counts by hand. Its commands do what they say, and its
//! links lead somewhere.

use std::path::Path;
use std::process::Command;

const README: &str = include_str!("../../README.md");

#[test]
fn the_circuit_in_the_readme_runs() {
    let circuit = README.split_once("```json\n").unwrap().1.split_once("```").unwrap().0;
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

/// Every `discreta …` between backquotes that names a method or a file, as printed; what they write goes to a folder of
/// its own.
#[test]
fn the_commands_in_the_readme_run() {
    let folder = tempfile::tempdir().unwrap();
    for link in ["circuits", "examples", "traces"] {
        std::os::unix::fs::symlink(Path::new(env!("CARGO_MANIFEST_DIR")).join(link), folder.path().join(link)).unwrap();
    }
    let mut commands = 0;
    for text in README.split('`').filter(|t| t.starts_with("discreta ") && t.contains(['/', '-'])) {
        let arguments: Vec<&str> = text.split_whitespace().skip(1).collect();
        let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
        let output = command.args(&arguments).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
        commands += 1;
    }
    assert!(commands >= 18, "{commands} commands");
}

#[test]
fn the_links_of_the_readme_lead_somewhere() {
    for link in README.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link) {
        let path = link.split('#').next().unwrap();
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        assert!(link.starts_with("https://") || here.exists(), "{link}");
    }
}
