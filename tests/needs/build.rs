//! Looks for the tools that tests compare with. `DISCRETA_ALL_TOOLS=1`, as in CI: one that is missing is an error.

use std::collections::BTreeSet;
use std::env;
use std::path::PathBuf;

include!("src/tools.rs");

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/tools.rs");
    println!("cargo::rerun-if-env-changed=PATH");
    println!("cargo::rerun-if-env-changed=DISCRETA_ALL_TOOLS");
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect();
    let (mut missing, mut watched) = (Vec::new(), BTreeSet::new());
    for (tool, programs, install) in TOOLS {
        for program in *programs {
            let program = format!("{program}{}", env::consts::EXE_SUFFIX);
            match folders.iter().map(|f| f.join(&program)).find(|p| p.is_file()) {
                Some(found) => {
                    watched.insert(found);
                }
                None if missing.last() != Some(tool) => missing.push(*tool),
                None => {}
            }
        }
        if missing.last() == Some(tool) {
            // an installation changes one of these folders
            watched.extend(folders.iter().filter(|f| f.is_absolute() && f.is_dir()).cloned());
            if env::var("DISCRETA_ALL_TOOLS").is_ok_and(|v| v == "1") {
                println!("cargo::error=DISCRETA_ALL_TOOLS=1, but {tool} is not on PATH: {install}");
            }
        }
    }
    for path in watched {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    println!("cargo::rustc-env=MISSING_TOOLS={}", missing.join(" "));
}
