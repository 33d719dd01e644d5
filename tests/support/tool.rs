//! Other programs. That they are there is for `#[needs(…)]` to say.
#![allow(dead_code)] // each test uses a part

use std::path::Path;
use std::process::{Command, Output};

/// How a tool succeeded.
fn succeeded(folder: &Path, name: &str, arguments: &[&str]) -> Output {
    let told = Command::new(name).current_dir(folder).args(arguments).output();
    let told = told.unwrap_or_else(|e| panic!("{name}: {e}; install it"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(told.status.success(), "{name} {}: {}{}", arguments.join(" "), text(&told.stdout), text(&told.stderr));
    told
}

/// Runs a tool, which must succeed; what it prints.
pub fn tool(folder: &Path, name: &str, arguments: &[&str]) -> String {
    String::from_utf8_lossy(&succeeded(folder, name, arguments).stdout).into_owned()
}

/// Runs a tool, which must succeed; what it says on standard error.
pub fn complaints(folder: &Path, name: &str, arguments: &[&str]) -> String {
    String::from_utf8_lossy(&succeeded(folder, name, arguments).stderr).into_owned()
}
