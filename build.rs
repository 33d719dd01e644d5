//! Lists the circuits of `circuits/`, which travel in the program.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn find(folder: &Path, found: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            find(&path, found)?;
        } else if path.extension().is_some_and(|e| e == "json") {
            found.push(path);
        }
    }
    Ok(())
}

fn main() -> io::Result<()> {
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR").expect("Cargo says it")).join("circuits");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut found = Vec::new();
    find(&folder, &mut found)?;
    found.sort();
    let mut list = String::from("&[\n");
    for path in found {
        let below = path.strip_prefix(&folder).expect("it was found there");
        let name: Vec<&str> = below.iter().filter_map(|part| part.to_str()).collect();
        // schemas are no circuits
        if name.len() > 1 {
            let _ = writeln!(list, "    ({:?}, include_str!({:?})),", name.join("/"), path.display().to_string());
        }
    }
    list.push_str("]\n");
    fs::write(Path::new(&env::var("OUT_DIR").expect("Cargo says it")).join("circuits.rs"), list)
}
