//! The program as a user runs it.
#![allow(dead_code)] // each test uses a part

use std::path::Path;
use std::process::{Command, Output};

/// `discreta` with these arguments, in the repository, its colours its own choice.
pub fn discreta(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
    command.args(args).current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
    command
}

/// Exit status, standard output, standard error.
pub fn ended(output: Output) -> (i32, String, String) {
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().expect("no signal ended it"), text(output.stdout), text(output.stderr))
}

/// How `discreta` ends with these arguments.
pub fn run(args: &[&str]) -> (i32, String, String) {
    ended(discreta(args).output().unwrap())
}

/// How it ends in a folder with a line of arguments split at spaces; what Yosys made is kept in that folder.
pub fn run_in(folder: &Path, line: &str) -> (i32, String, String) {
    let mut command = discreta(&line.split_whitespace().collect::<Vec<_>>());
    ended(command.current_dir(folder).env("XDG_CACHE_HOME", folder.join("cache")).output().unwrap())
}

/// How a command of it ends with a line of arguments split at spaces.
pub fn command(name: &str, line: &str) -> (i32, String, String) {
    run(&[name].into_iter().chain(line.split_whitespace()).collect::<Vec<_>>())
}
