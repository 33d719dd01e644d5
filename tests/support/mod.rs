//! What several tests share: a seeded source of numbers, and circuit files written on the spot.
#![allow(dead_code)] // each test uses a part

pub mod bench;
pub mod design;
pub mod engines;
pub mod feed;
pub mod lanes;
pub mod pairs;
pub mod program;
pub mod proofs;
pub mod random_verilog;
pub mod replays;
pub mod rng;
pub mod runs;
pub mod schematic;
pub mod tool;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use discreta::circuit::{self, Circuit};
pub use rng::Rng;

/// A path below the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Where a test may write; of its own, so that tests do not meet.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    folder
}

/// Writes a circuit file and loads it, with its warnings unread.
pub fn load(folder: &Path, name: &str, file: &serde_json::Value) -> Result<Circuit, String> {
    static FILES: AtomicUsize = AtomicUsize::new(0); // tests run side by side and may choose the same name
    let path = folder.join(format!("{name}_{}.json", FILES.fetch_add(1, Ordering::Relaxed)));
    std::fs::write(&path, serde_json::to_string_pretty(file).unwrap()).unwrap();
    circuit::load(&path).map_err(|e| e.to_string())
}
