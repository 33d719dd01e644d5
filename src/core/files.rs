//! Which files a command reads and which it writes, so that no output takes the place of an input or of another output,
//! however the paths are spelled: relative, through links of either kind, as standard output.
//!
//! Whatever opens a file says so here: [`reads`] and [`writes`]. Only a command asks for it ([`watch`]); a program that
//! uses the crate may write what it has read. It knows nothing of what is in a file.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The files of the command that runs; none where nobody watches.
static FILES: Mutex<Option<Files>> = Mutex::new(None);

#[derive(Default)]
struct Files {
    inputs: Vec<Identity>,
    outputs: Vec<PathBuf>,
}

/// What tells a file from others, by whatever name.
#[derive(Clone, PartialEq, Eq)]
#[cfg_attr(unix, derive(Copy))]
struct Identity(#[cfg(unix)] (u64, u64), #[cfg(not(unix))] PathBuf);

impl Identity {
    /// Of a regular file that is there.
    fn of(path: &Path) -> Option<Identity> {
        Identity::from(&fs::metadata(path).ok()?, path)
    }

    #[cfg(unix)]
    fn from(metadata: &Metadata, _: &Path) -> Option<Identity> {
        use std::os::unix::fs::MetadataExt;
        metadata.is_file().then(|| Identity((metadata.dev(), metadata.ino())))
    }

    #[cfg(not(unix))]
    fn from(metadata: &Metadata, path: &Path) -> Option<Identity> {
        metadata.is_file().then(|| path.canonicalize().ok().map(Identity)).flatten()
    }

    /// Of the file that standard output is, if it is one.
    #[cfg(unix)]
    fn of_stdout() -> Option<Identity> {
        use std::os::fd::AsFd;
        let held = io::stdout().as_fd().try_clone_to_owned().ok()?;
        Identity::from(&fs::File::from(held).metadata().ok()?, Path::new("-"))
    }

    #[cfg(not(unix))]
    fn of_stdout() -> Option<Identity> {
        None
    }
}

/// Begins to watch, with nothing read or written yet.
pub fn watch() {
    *FILES.lock().unwrap_or_else(PoisonError::into_inner) = Some(Files::default());
}

fn watched<T>(look: impl FnOnce(&mut Files) -> T) -> Option<T> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner).as_mut().map(look)
}

/// A file is about to be read.
pub fn reads(path: &Path) {
    watched(|files| files.inputs.extend(Identity::of(path)));
}

/// Where a path leads, whether there is something or not: what is written there is found again by it.
#[must_use]
pub fn resolved(path: &Path) -> PathBuf {
    let beside = |path: &Path| {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(parent.canonicalize().ok()?.join(path.file_name()?))
    };
    let dangling = || fs::read_link(path).ok().map(|to| path.parent().unwrap_or(Path::new("")).join(to));
    let found = path.canonicalize().ok().or_else(|| beside(&dangling().unwrap_or_else(|| path.to_owned())));
    found.unwrap_or_else(|| path.to_owned())
}

/// A file is about to be written: as an output of its own, until it is [given back](gives_back).
///
/// # Errors
/// That the command reads it, or writes something else there.
pub fn writes(path: &Path) -> io::Result<()> {
    let taken = |why: &str| Err(io::Error::new(io::ErrorKind::AlreadyExists, why));
    let special = fs::metadata(path).is_ok_and(|m| !m.is_file());
    watched(|files| {
        if special {
            return Ok(());
        }
        if Identity::of(path).is_some_and(|this| files.inputs.contains(&this)) {
            return taken("it is an input of this command");
        }
        let to = resolved(path);
        if files.outputs.contains(&to) {
            return taken("another output of this command goes there");
        }
        files.outputs.push(to);
        Ok(())
    })
    .unwrap_or(Ok(()))
}

/// Nothing is written there after all.
pub fn gives_back(path: &Path) {
    watched(|files| {
        let to = resolved(path);
        files.outputs.retain(|output| *output != to);
    });
}

/// Standard output is about to be written.
///
/// # Errors
/// That it goes to a file that the command reads: what was read of it is no longer what it was.
pub fn writes_stdout() -> io::Result<()> {
    let same = |files: &mut Files| Identity::of_stdout().is_some_and(|this| files.inputs.contains(&this));
    match watched(same) {
        Some(true) => Err(io::Error::new(io::ErrorKind::AlreadyExists, "it goes to a file that this command reads")),
        _ => Ok(()),
    }
}
