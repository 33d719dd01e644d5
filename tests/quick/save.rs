//! `run --save`: what GTKWave and Surfer are told of a waveform; and that viewers can read every waveform that is shipped.

use std::path::Path;
use std::process::Command;

use crate::support::program::run;
use discreta::wave::read::Waves;
use needs::needs;

/// Runs a circuit into a folder, with its files for the viewers.
fn saved(circuit: &str, folder: &Path, waveform: &str) -> (String, String) {
    let path = folder.join(waveform);
    let (status, text, told) = run(&["run", circuit, "-o", path.to_str().unwrap(), "--save"]);
    assert_eq!((status, told.as_str()), (0, ""), "{circuit}");
    for extension in ["gtkw", "sucl"] {
        let beside = path.with_extension(extension);
        assert!(text.contains(&format!("wrote {}", beside.display())), "{text}");
    }
    let read = |extension: &str| std::fs::read_to_string(path.with_extension(extension)).unwrap();
    (read("gtkw"), read("sucl"))
}

/// The signals that a save file names.
fn named(gtkw: &str) -> Vec<&str> {
    let traces = gtkw.lines().skip_while(|l| !l.starts_with('@'));
    traces.filter(|l| !l.starts_with(['@', '-', '[', '^'])).collect()
}

#[test]
fn the_line_as_it_suits_the_circuit() {
    let folder = tempfile::tempdir().unwrap();
    let (gtkw, sucl) = saved("circuits/evaluation/line.json", folder.path(), "line.vcd");
    assert_eq!(named(&gtkw)[..3], ["line.dt", "line.start", "line.dx[7:0]"]);
    // f is signed in the circuit, xt a coordinate, both by GTKWave's flags
    assert!(gtkw.contains("@420\nline.f[8:0]\n"), "{gtkw}");
    assert!(gtkw.contains("@8024\nline.xt[7:0]\n@20000\n-\n"), "{gtkw}");
    assert!(sucl.contains("variable_add line.dt\nvariable_add line.start\n"), "{sucl}");
    let focus = sucl.lines().position(|l| l.starts_with("item_focus ") && l.ends_with("_line.f")).unwrap();
    assert_eq!(sucl.lines().nth(focus + 1), Some("item_set_format Signed"));
    assert!(sucl.ends_with("zoom_fit\n"));
    // every name is one of the waveform
    let waves = Waves::open(&folder.path().join("line.vcd")).unwrap();
    let names = sucl.lines().filter_map(|l| l.strip_prefix("variable_add "));
    assert_eq!(names.inspect(|name| assert!(waves.find(name).is_some(), "{name}")).count(), waves.vars().len());
}

/// What GTKWave's and Surfer's documentation say of the two files, by hand.
#[test]
fn values_go_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let (gtkw, sucl) = saved("circuits/quadrant/circle.json", folder.path(), "arc.vcd");
    let filter = gtkw.lines().find(|l| l.starts_with('^') && l.ends_with(".quadrant.txt")).or_else(|| {
        // another signal has the same names, and came first
        let at = gtkw.lines().position(|l| l == "quadrant_circle.quadrants.quadrant[1:0]")?;
        gtkw.lines().nth(at - 1)
    });
    let (_, file) = filter.unwrap().split_once(' ').unwrap();
    let text = std::fs::read_to_string(folder.path().join(file)).unwrap();
    assert_eq!(text, "00 I\n01 II\n10 III\n11 IV\n");
    let at = sucl.lines().position(|l| l.ends_with("_quadrant_circle.quadrants.quadrant")).unwrap();
    let mapping = sucl.lines().nth(at + 1).unwrap().strip_prefix("item_set_format ").unwrap();
    let mapping = folder.path().join(".surfer/mappings").join(mapping).with_extension("txt");
    assert_eq!(std::fs::read_to_string(mapping).unwrap(), "Bits = 2\n0b00 I\n0b01 II\n0b10 III\n0b11 IV\n");
    // a single bit stays a line
    assert!(gtkw.contains("@28\nquadrant_circle.x_dir\n") || !gtkw.contains("^2"), "{gtkw}");
}

#[test]
fn nothing_is_written_beside_what_is_no_file() {
    let (status, text, _) = run(&["run", "circuits/evaluation/line.json", "-o", "-", "--save"]);
    assert!(status == 0 && text.starts_with("$version"), "{text}");
    let (status, _, told) = run(&["run", "circuits/evaluation/line.json", "--save"]);
    assert!(status == 2 && told.contains("--output"), "{told}");
}

/// The real GTKWave loads the file without complaint and shows what it names, in that order.
#[needs(gtkwave)]
#[test]
fn gtkwave_shows_what_is_named() {
    for (circuit, waveform) in [
        ("circuits/evaluation/line.json", "line.vcd"),
        ("circuits/evaluation/line_gates.json", "gates.fst"),
        ("circuits/quadrant/circle.json", "arc.vcd"),
        ("circuits/quadrant/line_3d.json", "space.vcd"),
        ("circuits/feed/system.json", "system.fst"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let (gtkw, _) = saved(circuit, folder.path(), waveform);
        let script = "foreach name [gtkwave::getDisplayedSignals] { puts \"shown $name\" }
            flush stdout
            gtkwave::/File/Quit\n";
        std::fs::write(folder.path().join("list.tcl"), script).unwrap();
        let save = Path::new(waveform).with_extension("gtkw");
        let told = Command::new("xvfb-run")
            .args(["-a", "-s", "-screen 0 1400x900x24", "timeout", "60", "gtkwave", "--rcvar", "splash_disable on"])
            .args(["-S", "list.tcl", waveform, save.to_str().unwrap()])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&told.stdout).into_owned();
        let errors = String::from_utf8_lossy(&told.stderr).into_owned();
        let shown: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("shown ")).collect();
        let named = named(&gtkw);
        assert!(!named.is_empty());
        // groups and the rows of curves are listed too
        let shown: Vec<&str> = shown.into_iter().filter(|name| named.contains(name)).collect();
        assert_eq!(shown, named, "{circuit}: {text}\n{errors}");
        for complaint in ["not found", "Could not", "Error", "error", "Unknown", "syntax"] {
            assert!(!errors.contains(complaint) && !text.contains(complaint), "{circuit}: {text}\n{errors}");
        }
    }
}

/// Surfer's own reader, `wellen`, reads every golden trace.
#[test]
fn every_golden_trace_can_be_read() {
    let mut folders = vec![Path::new("traces").to_owned()];
    let mut traces = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else if entry.extension().is_some_and(|e| e == "vcd") {
                let mut waves = Waves::open(&entry).unwrap_or_else(|e| panic!("{e}"));
                let changes: usize =
                    (0..waves.vars().len()).map(|var| waves.load(var).unwrap().changes().count()).sum();
                assert!(changes > 0, "{}", entry.display());
                traces += 1;
            }
        }
    }
    assert!(traces > 100, "{traces}");
}
