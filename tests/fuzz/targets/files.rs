//! Loads files as the commands do.

use discreta::circuit::{Limits, Loader};

/// Writes a file, and loads it with small limits: bombs of copies and widths are the business of these.
pub fn load(bytes: &[u8], name: &str) {
    let dir = tempfile::tempdir().expect("a place for a file");
    let path = dir.path().join(name);
    std::fs::write(&path, bytes).expect("room for a file");
    let mut limits = Limits::default();
    for limit in ["cells=10000", "bits=1000000", "width=4096"] {
        limits.set(limit).expect("it is one");
    }
    let mut loader = Loader::new(limits);
    if let Some(file) = loader.open(&path) {
        let _ = loader.elaborate(file, &[]);
        loader.check_rest(file);
    }
    let _ = loader.diagnostics.render(&loader.sources, false);
}
