//! The program as a user runs it.
#![allow(dead_code)] // each test uses a part

use std::process::Command;

/// Exit status, standard output, standard error of `discreta` with these arguments, run in the repository.
pub fn discreta(args: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
    command.args(args).current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
    let output = command.output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().expect("no signal ended it"), text(output.stdout), text(output.stderr))
}

/// The same for a command with a line of arguments split at spaces.
pub fn command(name: &str, line: &str) -> (i32, String, String) {
    discreta(&[name].into_iter().chain(line.split_whitespace()).collect::<Vec<_>>())
}
