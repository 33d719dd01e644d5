//! Processes: what is built once and kept, and runs with their time and memory.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How long a build may take, all its commands together.
const BUILD: Duration = Duration::from_secs(2400);
/// How long a run may take.
const RUN: &str = "120";

/// Where everything is kept.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("target/peers")
}

/// A program that `install.sh` installed.
pub fn tool(name: &str) -> PathBuf {
    root().join("tools/bin").join(name)
}

/// The Python packages of `install.sh`.
pub fn packages() -> Result<PathBuf, String> {
    let lib = root().join("tools/lib");
    let folders = std::fs::read_dir(&lib).map_err(|_| "run benches/peers/install.sh first".to_owned())?;
    let python = folders.flatten().next().ok_or("run benches/peers/install.sh first")?;
    Ok(python.path().join("site-packages"))
}

/// What a build has left.
pub struct Built {
    pub folder: PathBuf,
    /// How long it took; see [`build`].
    pub seconds: f64,
}

/// Seconds of processor time of the processes that this one has waited for, and of theirs.
fn processor() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(13) + ticks(14)) / 100.0 // a hundred a second on every Linux
}

/// The folder that a name, in which there is all that its content depends on, stands for; commands fill it the first time.
/// What failed once is not tried again. Seconds are those of the clock or, where the machine had other things to do, those
/// of the processor.
pub fn build(name: &str, commands: impl FnOnce(&Path) -> Result<Vec<Command>, String>) -> Result<Built, String> {
    let folder = root().join("built").join(name);
    let done = folder.join("seconds");
    if let Ok(text) = std::fs::read_to_string(&done) {
        return text.trim().parse().map(|seconds| Built { folder, seconds }).map_err(|_| text);
    }
    let text = |e: std::io::Error| format!("{}: {e}", folder.display());
    let _ = std::fs::remove_dir_all(&folder); // of a build that was interrupted
    std::fs::create_dir_all(&folder).map_err(text)?;
    eprintln!("building {name}");
    let (begin, used) = (Instant::now(), processor());
    let mut failed = None;
    for command in commands(&folder)? {
        let left = BUILD.saturating_sub(begin.elapsed()).as_secs().max(1);
        let mut limited = Command::new("timeout");
        limited.arg(left.to_string()).arg(command.get_program()).args(command.get_args());
        limited.current_dir(command.get_current_dir().unwrap_or(&folder));
        for (name, value) in command.get_envs() {
            limited.env(name, value.unwrap_or_default());
        }
        let output = limited.output().map_err(text)?;
        if !output.status.success() {
            let program = Path::new(command.get_program()).file_name().unwrap_or_default().to_string_lossy();
            failed = Some(if output.status.code() == Some(124) {
                format!("not ready after {} s", BUILD.as_secs())
            } else {
                let said = String::from_utf8_lossy(&output.stderr);
                eprintln!("{said}");
                format!("{program} fails: {}", said.lines().last().unwrap_or_default())
            });
            break;
        }
    }
    let seconds = begin.elapsed().as_secs_f64().min(processor() - used);
    std::fs::write(&done, failed.clone().unwrap_or_else(|| seconds.to_string())).map_err(text)?;
    match failed {
        Some(why) => Err(why),
        None => Ok(Built { folder, seconds }),
    }
}

/// A program that `install.sh` installed, or else the one of the system.
pub fn either(name: &str, system: &str) -> PathBuf {
    let program = tool(name);
    if program.exists() { program } else { PathBuf::from(system) }
}

/// Seconds that a run took.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    pub clock: f64,
    pub user: f64,
    pub system: f64,
}

/// Runs a command, and tells how many seconds of the clock or, where that is less, of processors it took, and what it
/// printed.
pub fn timed(command: &Command) -> Result<(f64, String), String> {
    times(command).map(|(t, said)| (t.clock.min(t.user + t.system), said))
}

/// Runs a command, and tells how long it took and what it printed. `bash` measures in milliseconds, alone what the command
/// takes.
pub fn times(command: &Command) -> Result<(Times, String), String> {
    let mut timed = Command::new("timeout");
    timed.args([RUN, "bash", "-c", "TIMEFORMAT='seconds %R %U %S'; time \"$@\"", "bash"]);
    timed.arg(command.get_program()).args(command.get_args());
    let output = timed.output().map_err(|e| e.to_string())?;
    let said = String::from_utf8_lossy(&output.stderr);
    let line = said.lines().rev().find_map(|l| l.strip_prefix("seconds ")).unwrap_or_default();
    let times: Vec<f64> = line.split(' ').filter_map(|t| t.parse().ok()).collect();
    match times[..] {
        [clock, user, system] if output.status.success() => {
            Ok((Times { clock, user, system }, String::from_utf8_lossy(&output.stdout).into_owned()))
        }
        _ => Err(format!("ends with {}: {}", output.status, said.lines().next().unwrap_or_default())),
    }
}

/// Runs a command, and tells the most memory that it had at once, in bytes.
pub fn peak(command: &Command) -> Result<u64, String> {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut child = Command::new(command.get_program());
    child.args(command.get_args()).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let begin = Instant::now();
    let child = child.spawn().map_err(|e| format!("{program}: {e}"))?;
    let id = child.id().to_string();
    let (ended, peak) = (AtomicBool::new(false), AtomicU64::new(0));
    let result = std::thread::scope(|threads| {
        threads.spawn(|| {
            let status = format!("/proc/{id}/status");
            while !ended.load(Ordering::Relaxed) {
                if let Some(bytes) = std::fs::read_to_string(&status).ok().as_deref().and_then(memory) {
                    peak.fetch_max(bytes, Ordering::Relaxed);
                }
                std::thread::sleep(Duration::from_millis(4));
                if begin.elapsed().as_secs_f64() > RUN.parse().unwrap_or(f64::MAX) {
                    let _ = Command::new("kill").arg(&id).status();
                }
            }
        });
        let output = child.wait_with_output();
        ended.store(true, Ordering::Relaxed);
        output
    });
    let output = result.map_err(|e| format!("{program}: {e}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{program} ends with {}: {}", output.status, said.lines().next().unwrap_or_default()));
    }
    Ok(peak.into_inner())
}

/// The line of `/proc/N/status` about the most memory.
fn memory(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kib| kib * 1024)
}
