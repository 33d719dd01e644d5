//! Where a waveform goes, and that no half file ever takes the place of a whole one.
//!
//! A file is written under a temporary name beside its own and renamed when complete; dropped before that, nothing is
//! left behind. What is no regular file (`/dev/null`, a pipe) is written as it comes, `-` is standard output.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::files;

/// A [`Write`] that is told when what it was given is all.
pub trait Destination: Write {
    /// Everything has been written: flush it and make it last.
    ///
    /// # Errors
    /// What stands in the way; an unfinished file is then gone.
    fn complete(&mut self) -> io::Result<()>;

    /// Writes a piece, and gives back a buffer that can be used again, with anything in it.
    ///
    /// # Errors
    /// As for writing.
    fn give(&mut self, piece: Piece) -> io::Result<Vec<u8>> {
        let bytes = piece.bytes();
        self.write_all(&bytes)?;
        Ok(bytes)
    }
}

/// Something to be written.
pub enum Piece {
    /// These bytes.
    Made(Vec<u8>),
    /// What this makes, where there is time for it.
    Later(Box<dyn FnOnce() -> Vec<u8> + Send>),
}

impl Piece {
    /// The bytes.
    #[must_use]
    pub fn bytes(self) -> Vec<u8> {
        match self {
            Piece::Made(bytes) => bytes,
            Piece::Later(make) => make(),
        }
    }
}

impl Destination for Vec<u8> {
    fn complete(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<D: Destination + ?Sized> Destination for &mut D {
    fn complete(&mut self) -> io::Result<()> {
        (**self).complete()
    }

    fn give(&mut self, piece: Piece) -> io::Result<Vec<u8>> {
        (**self).give(piece)
    }
}

impl<D: Destination + ?Sized> Destination for Box<D> {
    fn complete(&mut self) -> io::Result<()> {
        (**self).complete()
    }

    fn give(&mut self, piece: Piece) -> io::Result<Vec<u8>> {
        (**self).give(piece)
    }
}

/// A place for a file that is being made.
///
/// Errors of its [`Write`] and [`Destination`] hold an [`OutputError`], and keep the kind of what caused it.
///
/// ```
/// # mod discreta {
/// #     pub use discreta_core::*;
/// #     pub mod wave { pub use discreta_wave::*; }
/// # }
/// use std::io::Write;
/// use discreta::wave::output::{Destination, Output};
///
/// let dir = tempfile::tempdir()?;
/// let path = dir.path().join("run.vcd");
/// let mut output = Output::create(&path)?;
/// output.write_all(b"$version")?;
/// assert!(!path.exists());
/// output.complete()?;
/// assert_eq!(std::fs::read(&path)?, b"$version");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Output {
    path: PathBuf,
    target: Target,
}

enum Target {
    Stdout(io::Stdout),
    Direct(File),
    /// Renamed to the path when complete.
    Temporary(NamedTempFile, PathBuf),
    Complete,
}

impl Output {
    /// Opens a place to write to: a path, or `-` for standard output.
    ///
    /// # Errors
    /// That the path cannot be written, found before anything is.
    pub fn create(path: &Path) -> Result<Output, OutputError> {
        let fail = |action, source| Err(OutputError { path: path.to_owned(), action, source });
        let made = |target| Ok(Output { path: path.to_owned(), target });
        if path.as_os_str() == "-" {
            if let Err(error) = files::writes_stdout() {
                return fail(Action::Open, error);
            }
            return made(Target::Stdout(io::stdout()));
        }
        if let Err(error) = files::writes(path) {
            return fail(Action::Open, error);
        }
        let existing = match fs::metadata(path) {
            Ok(existing) => Some(existing),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return fail(Action::Open, error),
        };
        if let Some(existing) = &existing {
            // What may not be written must not be replaced either. Opening does not change it.
            match OpenOptions::new().write(true).open(path) {
                Ok(file) if !existing.is_file() => return made(Target::Direct(file)),
                Ok(_) => {}
                Err(error) => return fail(Action::Open, error),
            }
        }
        // The file that a link leads to is replaced, not the link.
        let target = match fs::canonicalize(path).or_else(|_| fs::read_link(path).map(|to| directory(path).join(to))) {
            Ok(target) => target,
            Err(_) => path.to_owned(),
        };
        match temporary(&target, existing.map(|existing| existing.permissions())) {
            Ok(file) => made(Target::Temporary(file, target)),
            Err(error) => fail(Action::Open, error),
        }
    }

    /// Whether a place can be written to; nothing happens to it yet.
    ///
    /// # Errors
    /// As those of [`create`](Output::create).
    pub fn check(path: &Path) -> Result<(), OutputError> {
        drop(Output::create(path)?);
        files::gives_back(path);
        Ok(())
    }

    /// The path as it was given.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes the half file away at once, rather than when this is dropped, and names the cause.
    fn fail(&mut self, source: io::Error) -> io::Error {
        // Asked to try again: nothing has failed yet.
        if source.kind() == io::ErrorKind::Interrupted {
            return source;
        }
        let action = match std::mem::replace(&mut self.target, Target::Complete) {
            Target::Temporary(..) => Action::Write,
            _ => Action::Stream,
        };
        let kind = source.kind();
        io::Error::new(kind, OutputError { path: self.path.clone(), action, source })
    }
}

/// The directory that holds a path.
fn directory(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn temporary(target: &Path, permissions: Option<fs::Permissions>) -> io::Result<NamedTempFile> {
    let Some(name) = target.file_name() else { return Err(io::ErrorKind::IsADirectory.into()) };
    let mut prefix = std::ffi::OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Less the umask, as for any new file.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(directory(target))?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions)?;
    }
    Ok(file)
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.target {
            Target::Stdout(stdout) => stdout.write(bytes),
            Target::Direct(file) => file.write(bytes),
            Target::Temporary(file, _) => file.write(bytes),
            Target::Complete => return Err(io::Error::other("written to after it was complete or had failed")),
        };
        written.map_err(|error| self.fail(error))
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = match &mut self.target {
            Target::Stdout(stdout) => stdout.flush(),
            Target::Direct(file) => file.flush(),
            Target::Temporary(file, _) => file.flush(),
            Target::Complete => Ok(()),
        };
        flushed.map_err(|error| self.fail(error))
    }
}

/// Only a file can be gone back in.
impl Seek for Output {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let moved = match &mut self.target {
            Target::Temporary(file, _) => file.seek(to),
            Target::Direct(file) => file.seek(to),
            Target::Stdout(_) => Err(io::ErrorKind::NotSeekable.into()),
            Target::Complete => return Err(io::Error::other("moved in after it was complete or had failed")),
        };
        moved.map_err(|error| self.fail(error))
    }
}

impl Destination for Output {
    fn complete(&mut self) -> io::Result<()> {
        self.flush()?;
        if let Target::Temporary(file, target) = std::mem::replace(&mut self.target, Target::Complete) {
            file.persist(target).map_err(|error| {
                let kind = error.error.kind();
                io::Error::new(
                    kind,
                    OutputError { path: self.path.clone(), action: Action::Write, source: error.error },
                )
            })?;
        }
        Ok(())
    }
}

/// A place that could not be written.
#[derive(Debug)]
pub struct OutputError {
    path: PathBuf,
    action: Action,
    source: io::Error,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Action {
    /// Nothing is there yet.
    Open,
    /// A file that is not there before it is complete.
    Write,
    /// What is no file: who reads it has seen the beginning.
    Stream,
}

impl OutputError {
    /// The output error inside of an I/O error, if there is one.
    #[must_use]
    pub fn of(error: &io::Error) -> Option<&OutputError> {
        error.get_ref()?.downcast_ref()
    }

    /// Where.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What kind of fault: [`BrokenPipe`](io::ErrorKind::BrokenPipe) when nobody reads any more, which is no fault of
    /// anyone.
    #[must_use]
    pub fn kind(&self) -> io::ErrorKind {
        self.source.kind()
    }

    /// What one can do about it.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        let directory = directory(&self.path);
        match self.source.kind() {
            io::ErrorKind::NotFound => Some(format!("make the directory first: mkdir -p {}", directory.display())),
            io::ErrorKind::NotADirectory => Some(format!("`{}` is not a directory", directory.display())),
            io::ErrorKind::NotSeekable => Some("FST can only go to a file; write VCD here".to_owned()),
            io::ErrorKind::IsADirectory => Some("name a file in it".to_owned()),
            io::ErrorKind::AlreadyExists => Some("name another file".to_owned()),
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                Some("choose a place that you may write to, or `-` for standard output".to_owned())
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
                Some("make room, write elsewhere, or record fewer nets".to_owned())
            }
            _ => None,
        }
    }
}

impl fmt::Display for OutputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.path.as_os_str() == "-" {
            f.write_str("cannot write to standard output")?;
        } else {
            write!(f, "cannot write `{}`", self.path.display())?;
        }
        write!(f, ": {}", reason(&self.source))?;
        match self.action {
            Action::Open => Ok(()),
            Action::Write => f.write_str("; nothing was left there"),
            Action::Stream => f.write_str("; what was written is not complete"),
        }
    }
}

/// The fault without the number of the operating system, which tells a user nothing.
pub fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or_default();
    let mut chars = text.chars();
    match chars.next() {
        Some(first) => first.to_lowercase().chain(chars).collect(),
        None => "unknown fault".to_owned(),
    }
}

impl std::error::Error for OutputError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(dir: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_only_when_complete() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vcd");
        fs::write(&path, "old").unwrap();
        let mut output = Output::create(&path).unwrap();
        output.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        output.complete().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(entries(dir.path()), ["a.vcd"]);
    }

    #[test]
    fn dropped_before_it_is_complete_nothing_is_left() {
        let dir = tempfile::tempdir().unwrap();
        let mut output = Output::create(&dir.path().join("a.vcd")).unwrap();
        output.write_all(b"half").unwrap();
        assert_eq!(entries(dir.path()).len(), 1);
        drop(output);
        assert!(entries(dir.path()).is_empty());
    }

    #[test]
    fn faults_are_found_before_anything_is_written() {
        let dir = tempfile::tempdir().unwrap();
        let fault = |path: &Path| Output::create(path).err().expect("must fail");

        let missing = fault(&dir.path().join("no/such/a.vcd"));
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
        assert!(missing.hint().unwrap().starts_with("make the directory first: mkdir -p "), "{:?}", missing.hint());
        assert!(missing.to_string().ends_with("no/such/a.vcd`: no such file or directory"), "{missing}");

        let directory = fault(dir.path());
        assert_eq!(directory.kind(), io::ErrorKind::IsADirectory);

        fs::write(dir.path().join("file"), "").unwrap();
        assert_eq!(fault(&dir.path().join("file/a.vcd")).kind(), io::ErrorKind::NotADirectory);
        assert_eq!(entries(dir.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_the_file_before_or_of_a_new_one() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        let path = dir.path().join("a.vcd");
        Output::create(&path).unwrap().complete().unwrap();
        fs::write(dir.path().join("plain"), "").unwrap();
        assert_eq!(mode(&path), mode(&dir.path().join("plain")));

        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        Output::create(&path).unwrap().complete().unwrap();
        assert_eq!(mode(&path), 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_keeps_leading_to_its_file() {
        let dir = tempfile::tempdir().unwrap();
        let (link, file) = (dir.path().join("link"), dir.path().join("file"));
        std::os::unix::fs::symlink("file", &link).unwrap();
        for text in ["first", "second"] {
            let mut output = Output::create(&link).unwrap();
            output.write_all(text.as_bytes()).unwrap();
            output.complete().unwrap();
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_an_error_that_names_it() {
        let mut output = Output::create(Path::new("/dev/full")).unwrap();
        let error = output.write_all(b"x").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        let error = OutputError::of(&error).unwrap();
        assert_eq!(
            error.to_string(),
            "cannot write `/dev/full`: no space left on device; what was written is not complete"
        );
        let mut output = Output::create(Path::new("/dev/null")).unwrap();
        output.write_all(b"x").unwrap();
        output.complete().unwrap();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_closed_pipe_is_told_from_other_faults() {
        let dir = tempfile::tempdir().unwrap();
        let fifo = dir.path().join("fifo");
        assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        let reader = std::thread::spawn({
            let fifo = fifo.clone();
            move || drop(File::open(fifo).unwrap())
        });
        let mut output = Output::create(&fifo).unwrap();
        reader.join().unwrap();
        let error = output.write_all(b"x").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
        assert!(OutputError::of(&error).is_some());
    }
}
