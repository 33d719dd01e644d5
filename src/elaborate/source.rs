//! Reading a file into [`Sources`], and refusing what is not a text file of bounded size or, by its name, no circuit.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use super::{Limits, builtin};
use crate::diag::{Code, Diagnostic, FileId, Sources, Span};

/// Reads the text file `path`, or standard input (`-`); `sources` calls it by its path as given. Never reads more than
/// [`Limits::file_size`] bytes. A pipe is read once, and then known.
///
/// # Errors
/// A fault without a place: an import adds where it stands.
pub fn read_file(path: &Path, limits: &Limits, sources: &mut Sources) -> Result<FileId, Diagnostic> {
    if let Some(path) = builtin::canonical(path)
        && let Some(text) = builtin::text(&path)
    {
        let name = path.display().to_string();
        return match sources.find(&name) {
            Some(known) => Ok(known),
            None => Ok(sources.add(name, text?.to_owned())),
        };
    }
    let name = path.display().to_string();
    let stdin = name == "-";
    let flows = stdin || is_pipe(path);
    if let Some(known) = sources.find(&name).filter(|_| flows) {
        return Ok(known);
    }
    let size = if flows { 0 } else { size(path)? };
    // Places are 32-bit offsets.
    let limit = limits.file_size.min(u64::from(u32::MAX) - 1);
    let too_large = |size: &str| {
        Diagnostic::new(Code::TooLarge, format!("`{name}` is too large: {size}, the limit is {limit}"))
            .help("if you need that, raise the limit: `--limit file-size=BYTES`")
    };
    if size > limit {
        return Err(too_large(&format!("{size} bytes")));
    }
    let mut bytes = Vec::with_capacity(size as usize);
    // The size may be wrong (as in /proc) or grow.
    let read = if stdin {
        io::stdin().lock().take(limit + 1).read_to_end(&mut bytes)
    } else {
        crate::files::reads(path);
        let file = File::open(path).map_err(|e| failed(path, &e))?;
        file.take(limit + 1).read_to_end(&mut bytes)
    };
    read.map_err(|e| failed(path, &e))?;
    if bytes.len() as u64 > limit {
        return Err(too_large("it grew"));
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(sources.add(name, text)),
        Err(e) => {
            let offset = e.utf8_error().valid_up_to();
            let bytes = e.as_bytes();
            if let [0xff, 0xfe, ..] | [0xfe, 0xff, ..] = bytes {
                let place = Span::new(sources.add(name, String::new()), 0, 0);
                let fault = cannot(path, "it is not UTF-8").at(place, "");
                return Err(fault.help("it looks like UTF-16; save it as UTF-8"));
            }
            // what can be shown of it: all up to there, and the rest of the line
            let line = bytes[offset..].iter().take(200).take_while(|&&b| b != b'\n').count();
            let text = String::from_utf8_lossy(&bytes[..offset + line]).into_owned();
            let file = sources.add(name, text);
            let place = Span::new(file, offset as u32, offset as u32 + 1);
            Err(cannot(path, "it is not UTF-8")
                .at(place, format!("this byte is 0x{:02x}", bytes[offset]))
                .help("save it as UTF-8"))
        }
    }
}

/// What is wrong with a file that is something else by its name, and does not begin as a circuit.
pub(crate) fn not_a_circuit(path: &Path) -> Option<Diagnostic> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    let name = path.display();
    let (what, helps) = match extension.as_str() {
        "vcd" | "fst" | "ghw" | "lxt" | "lxt2" | "vzt" => {
            let drive = format!(
                "or drive a circuit with it: `discreta run CIRCUIT --stimulus {name}`, and compare with `--expect`"
            );
            ("a waveform, not a circuit", vec![format!("look at it: `discreta wave {name}`"), drive])
        }
        "blif" => ("a netlist in BLIF", vec![netlist_of("read_blif", path)]),
        "il" | "rtlil" => ("a design of Yosys", vec![netlist_of("read_rtlil", path)]),
        "edif" | "edf" => ("a netlist in EDIF, which Yosys does not read either", vec![]),
        "svh" | "vh" => ("included by Verilog, and no design of its own", vec![]),
        _ => return None,
    };
    if begins_as_a_circuit(path) {
        return None;
    }
    let fault = Diagnostic::new(Code::NotACircuit, format!("`{name}` is {what}"));
    Some(helps.into_iter().fold(fault, Diagnostic::help))
}

fn netlist_of(command: &str, path: &Path) -> String {
    format!("make it a netlist: yosys -p '{command} {}; prep; write_json netlist.json'", path.display())
}

fn begins_as_a_circuit(path: &Path) -> bool {
    let mut begin = [0; 64];
    let is_file = std::fs::metadata(path).is_ok_and(|m| m.is_file());
    let read = is_file.then(|| File::open(path).ok()?.read(&mut begin).ok()).flatten().unwrap_or(0);
    begin[..read].trim_ascii_start().starts_with(b"{")
}

/// Whether a path is a pipe, such as that of a shell's `<(command)`.
fn is_pipe(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        std::fs::metadata(path).is_ok_and(|m| m.file_type().is_fifo() || m.file_type().is_socket())
    }
    #[cfg(not(unix))]
    false
}

/// The size of a regular file. Does not open it: to open a pipe would wait for its writer.
///
/// # Errors
/// That there is no such file, or that it is none that could be read.
pub(crate) fn size(path: &Path) -> Result<u64, Diagnostic> {
    if let Some(text) = builtin::canonical(path).and_then(|path| builtin::text(&path)) {
        return text.map(|text| text.len() as u64);
    }
    let metadata = std::fs::metadata(path).map_err(|e| failed(path, &e))?;
    if metadata.is_dir() {
        return Err(cannot(path, "it is a directory").help("name a file in it"));
    }
    if !metadata.is_file() {
        return Err(cannot(path, "it is not a regular file").help("write its contents to a file first"));
    }
    Ok(metadata.len())
}

fn cannot(path: &Path, why: &str) -> Diagnostic {
    Diagnostic::new(Code::CannotRead, format!("cannot read `{}`: {why}", path.display()))
}

fn failed(path: &Path, e: &io::Error) -> Diagnostic {
    let fault = cannot(path, &reason(e));
    match e.kind() {
        io::ErrorKind::NotFound => not_found(fault, path),
        _ => fault,
    }
}

/// A path without `.` and `..`, as far as that surely leads to the same file: not through links.
pub(crate) fn normal(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        let directory = || std::fs::symlink_metadata(&short).is_ok_and(|m| m.is_dir());
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(short.components().next_back(), Some(Component::Normal(_))) && directory() =>
            {
                short.pop();
            }
            part => short.push(part),
        }
    }
    if short.as_os_str().is_empty() { path.to_path_buf() } else { short }
}

fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        // without the number of the operating system
        _ => error.to_string().split(" (os error").next().unwrap_or_default().to_lowercase(),
    }
}

/// Offers the name in the same directory that was probably meant.
fn not_found(fault: Diagnostic, path: &Path) -> Diagnostic {
    const LOOK_AT: usize = 1000;
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (Some(name), Ok(entries)) = (path.file_name(), std::fs::read_dir(parent)) else {
        return if parent.is_dir() {
            fault
        } else {
            fault.help(format!("there is no directory `{}` either", parent.display()))
        };
    };
    let entries = entries.take(LOOK_AT).filter_map(|e| e.ok()?.file_name().into_string().ok());
    let mut entries: Vec<String> = entries.collect();
    entries.sort();
    fault.did_you_mean(&name.to_string_lossy(), entries.iter().map(String::as_str))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(path: &Path) -> Result<String, String> {
        let mut sources = Sources::new();
        match read_file(path, &Limits { file_size: 100, ..Limits::default() }, &mut sources) {
            Ok(id) => Ok(sources.text(id).to_owned()),
            Err(d) => {
                let dir = path.parent().unwrap().display().to_string();
                Err(format!("{}: {}; {}", d.code, d.message, d.helps.join(", ")).replace(&dir, "D"))
            }
        }
    }

    #[test]
    fn only_text_files_of_bounded_size_are_read() {
        let dir = tempfile::tempdir().unwrap();
        let file = |name: &str, bytes: &[u8]| {
            let path = dir.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        };
        assert_eq!(read(&file("good.json", b"{}")), Ok("{}".to_owned()));
        assert_eq!(read(&file("edge.json", &[b' '; 100])), Ok(" ".repeat(100)));
        assert_eq!(
            read(&file("large.json", &[b' '; 101])).unwrap_err(),
            "too-large: `D/large.json` is too large: 101 bytes, the limit is 100; \
             if you need that, raise the limit: `--limit file-size=BYTES`"
        );
        assert_eq!(
            read(&file("latin.json", b"{\n\"\xe9\"}")).unwrap_err(),
            "cannot-read: cannot read `D/latin.json`: it is not UTF-8; save it as UTF-8"
        );
        assert!(read(&file("wide.json", b"\xff\xfe{\0")).unwrap_err().contains("UTF-16"));
        assert_eq!(
            read(&dir.path().join("godo.json")).unwrap_err(),
            "cannot-read: cannot read `D/godo.json`: there is no such file; did you mean `good.json`?"
        );
        assert!(read(&dir.path().join("no/a.json")).unwrap_err().contains("there is no directory"));
        std::fs::create_dir(dir.path().join("sub")).unwrap();
        assert_eq!(
            read(&dir.path().join("sub")).unwrap_err(),
            "cannot-read: cannot read `D/sub`: it is a directory; name a file in it"
        );
    }

    #[test]
    fn paths_are_shortened_where_that_leads_to_the_same_file() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(dir.path().join("a/b")).unwrap();
        let short = |path: &str| normal(&dir.path().join(path)).strip_prefix(dir.path()).unwrap().display().to_string();
        assert_eq!(short("a/../c.json"), "c.json");
        assert_eq!(short("a/b/.././../c.json"), "c.json");
        assert_eq!(short("no/../c.json"), "no/../c.json", "there is no such directory");
        assert_eq!(normal(Path::new("../../x/./y.json")), Path::new("../../x/y.json"));
        assert_eq!(normal(Path::new("/../x")), Path::new("/../x"));
        assert_eq!(normal(Path::new(".")), Path::new("."));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("a/b", dir.path().join("link")).unwrap();
            assert_eq!(short("link/../c.json"), "link/../c.json", "this is a/c.json");
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_would_never_end_is_refused_at_once() {
        assert!(read(Path::new("/dev/zero")).unwrap_err().contains("not a regular file"));
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo");
        let write = |bytes: &'static [u8]| {
            let pipe = pipe.clone();
            std::thread::spawn(move || std::fs::write(pipe, bytes).is_ok())
        };
        let writer = write(b"{}");
        assert_eq!(read(&pipe), Ok("{}".to_owned()));
        assert!(writer.join().unwrap());
        let writer = write(&[b' '; 200]);
        assert!(read(&pipe).unwrap_err().starts_with("too-large"), "what flows is bounded too");
        writer.join().unwrap();
        // Its size is said to be 0.
        if Path::new("/proc/self/status").exists() {
            assert!(read(Path::new("/proc/self/status")).unwrap_err().starts_with("too-large"));
        }
    }
}
