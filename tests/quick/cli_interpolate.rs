//! `discreta interpolate`: what every format prints, and what is refused. The steps and values are those that the
//! documents' formulas give by hand.

use crate::support::program;

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

fn discreta(args: &[&str]) -> Command {
    program::discreta(&[&["interpolate"], args].concat())
}

/// Exit status, standard output, standard error of a command line split at spaces.
fn run(line: &str) -> (i32, String, String) {
    program::command("interpolate", line)
}

/// What it prints when it succeeds.
#[track_caller]
fn prints(line: &str) -> String {
    let (status, stdout, stderr) = run(line);
    assert_eq!((status, stderr.as_str()), (0, ""), "{line}");
    stdout
}

#[track_caller]
fn refused(line: &str, part: &str) {
    let (status, stdout, stderr) = run(line);
    assert_eq!((status, stdout.as_str()), (2, ""), "{line}: {stderr}");
    assert!(stderr.contains(part), "{line} does not say {part:?} but\n{stderr}");
}

#[test]
fn a_table() {
    snapbox::assert_data_eq!(
        prints("ef-circle --from 5,0 --to 0,5"),
        snapbox::str![[r#"
 clock  step      XT      YT     KOX     KOY       F  end
     0             5       0       5       5       0
     1     X       4       0       4       5      -9
     2     Y       4       1       4       4      -8
     3     Y       4       2       4       3      -5
     4     Y       4       3       4       2       0
     5     X       3       3       3       2      -7
     6     Y       3       4       3       1       0
     7     X       2       4       2       1      -5
     8     Y       2       5       2       0       4
     9     X       1       5       1       0       1
    10     X       0       5       0       0       0  end

"#]]
    );
}

/// Whatever the numbers: every row ends a column where the header does.
#[test]
fn columns_stay_right_aligned() {
    for line in ["ef-line --to 5,3", "ef-line --to 4294967295,4294967295", "ef-line --from -70000,0 --to 2000000,0"] {
        let mut child = discreta(&line.split_whitespace().collect::<Vec<_>>()).stdout(Stdio::piped()).spawn().unwrap();
        let lines: Vec<String> =
            BufReader::new(child.stdout.take().unwrap()).lines().take(9).map(Result::unwrap).collect();
        child.wait().unwrap();
        let ends = |line: &str| -> Vec<usize> {
            line.match_indices(' ').map(|(i, _)| i).filter(|&i| i > 0 && line.as_bytes()[i - 1] != b' ').collect()
        };
        let header = ends(&lines[0]);
        for row in &lines[2..] {
            let row = format!("{row} ");
            for end in ends(&row) {
                assert!(header.contains(&end) || row[..end].ends_with("end"), "{line}:\n{}", lines.join("\n"));
            }
        }
    }
}

#[test]
fn comma_separated_values() {
    let csv = prints("ef-line --to 5,3 --format csv");
    let rows: Vec<&str> = csv.lines().collect();
    assert_eq!((rows.len(), rows[0]), (9, "clock,step,x,y,xt,yt,kox,koy,f,end"));
    assert_eq!((rows[1], rows[8]), ("1,X,1,0,1,0,4,3,-3,0", "8,X,1,0,5,3,0,0,0,1"));
    let offset = prints("ef-line --to 8,6 --offset 5 --side left --format csv");
    assert!(offset.ends_with("14,X,1,0,5,10,0,0,0,1\n"), "{offset}");
    // no clock, no row
    assert_eq!(prints("ef-line --to 0,0 --format csv").lines().count(), 1);
}

#[test]
fn json_for_programs() {
    let text = prints("ef-line --from 1,1 --to 3,2 --format json");
    let expected = json!({
        "method": "ef-line", "from": [1, 1], "to": [3, 2], "offset": null, "bits": 8,
        "columns": ["xt", "yt", "kox", "koy", "f"],
        "start": { "xt": 1, "yt": 1, "kox": 2, "koy": 1, "f": 0, "end": false },
        "clocks": [
            { "clock": 1, "step": "X", "steps": [1, 0], "xt": 2, "yt": 1, "kox": 1, "koy": 1, "f": -1, "end": false },
            { "clock": 2, "step": "Y", "steps": [0, 1], "xt": 2, "yt": 2, "kox": 1, "koy": 0, "f": 1, "end": false },
            { "clock": 3, "step": "X", "steps": [1, 0], "xt": 3, "yt": 2, "kox": 0, "koy": 0, "f": 0, "end": true },
        ],
        "finished": true, "stopped": null,
        // (2, 1) is as far off on one side as (2, 2) on the other: 1/√5
        "deviation": { "greatest": 0.447_213_595_499_957_9, "clock": 1 },
    });
    assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), expected, "{text}");
    let nothing: Value = serde_json::from_str(&prints("ef-line --to 0,0 --format json")).unwrap();
    assert_eq!((&nothing["clocks"], &nothing["finished"]), (&json!([]), &json!(true)));
}

/// The documents' golden vectors; see `docs/drawing.md` for the letters.
#[test]
fn steps() {
    for (line, expected) in [
        ("ef-line --to 5,3", "XYXYXXYX\n"),
        ("ef-line --to 0,0", "\n"),
        ("ef-circle --from 5,0 --to 0,5", "XYYYXYXYXX\n"),
        ("ef-circle --from 0,5 --to 5,0 --cw", "YXXXYXYXYY\n"),
        ("dda-circle --from 5,0 --to 0,5 --bits 3", "-Y-YY-D-D-XX-X\n"),
        ("dda-circle --from 5,0 --to 0,5 --bits 3 --half-preload", "Y-YXY-D-XYX-X\n"),
        ("dda-line --to 5,4 --bits 3", "-D-DXYXD\n"),
        ("ef-line-fast --to 7,3", "XDXDXDX\n"),
        ("ef-line --to -5,-3", "XYXYXXYX\n"),
        ("ef-circle --from -2,3 --to -7,8 --center -7,3", "XYYYXYXYXX\n"),
        // moved by 5 along the normal (−3, 4)/5: from (−3, 4) to (5, 10)
        ("ef-line --to 8,6 --offset 5 --side left", "XYXYXYXXYXYXYX\n"),
        ("grossman --from 5,0 --to 0,5 --ccw", "XYYYXYXYXX\n"),
    ] {
        assert_eq!(prints(&format!("{line} --format steps")), expected, "{line}");
    }
}

#[test]
fn what_does_not_end_says_so() {
    for format in ["table", "csv", "json", "steps"] {
        let (status, stdout, stderr) = run(&format!("ef-line --to 0,3 --as-printed --format {format}"));
        assert_eq!((status, stderr.as_str()), (1, "error: stopped by the watchdog: no end within 6 clocks\n"));
        match format {
            "steps" => assert_eq!(stdout, "XYYYYY\n"),
            "json" => {
                let json: Value = serde_json::from_str(&stdout).unwrap();
                assert_eq!((&json["finished"], &json["clocks"][5]["kox"]), (&json!(false), &json!(255)));
                assert_eq!(json["stopped"], "stopped by the watchdog: no end within 6 clocks");
            }
            _ => assert!(!stdout.contains("  end\n1") && stdout.lines().count() > 6, "{stdout}"),
        }
    }
}

#[test]
fn what_a_method_does_not_have_is_refused_by_name() {
    refused("ef-line --to 5,3 --half-preload", "ef-line has no option --half-preload");
    refused("ef-line --to 5,3 --parallel", "ef-line has no option --parallel");
    refused("ef-line --to 5,3 --center 1,1", "ef-line has no option --center");
    refused("ef-line --to 5,3 --cw", "ef-line has no option --cw");
    refused("ef-line --to 5,3 --ccw", "ef-line has no option --ccw");
    refused("ef-circle --from 5,0 --to 0,5 --centred", "ef-circle has no option --centred");
    refused("dda-line --to 5,3 --parallel", "dda-line has no option --parallel");
    refused("dda-line --to 5,3 --centred", "dda-line has no option --centred");
    refused("dda-line --to 5,3 --conic 1,0,1,0,0,-25", "dda-line has no option --conic");
    refused("ef-line --to 5,3 --normalise", "ef-line has no option --normalise");
    refused("ef-line-3d --to 5,3,1 --offset 3 --side left", "ef-line-3d has no option --offset");
    refused("ef-line --to 5,3 --offset 3", "--side");
    refused("ef-line --to 5,3 --side left", "--offset");
    refused("ef-line --to 5,3 --offset 3 --side top", "no side is called 'top'");
    refused("ef-line --to 5,3,1", "ef-line draws in the plane: write --to X,Y");
    refused("ef-circle --from 5,0,0 --to 0,5", "ef-circle draws in the plane: write --from X,Y");
    refused("ef-line-3d --to 5,3", "ef-line-3d draws in space: write --to X,Y,Z");
}

#[test]
fn what_is_missing_or_cannot_be_drawn_is_refused() {
    refused("ef-line", "ef-line needs --to");
    refused("ef-circle --to 0,5", "ef-circle needs --from");
    refused("dda-circle --to 0,5", "dda-circle needs --from");
    refused("dda-curve --from 5,0 --to 5,0", "dda-curve needs --conic");
    refused("dda-curve --from 5,0 --to 5,0 --conic 1,2,3", "write it as six whole numbers");
    refused("ef-lin --to 5,3", "a similar value exists: 'ef-line'");
    refused("ef-line --to 5", "write it as two whole numbers, X,Y");
    refused("ef-line --to 99999999999,3", "is above 4294967295");
    refused("ef-line --to 256,3 --bits 8", "DX = 256 is above 255, the greatest of 8 bits");
    refused("ef-line --to 5,3 --bits 33", "registers of 33 bits");
    refused("ef-line --to 5,3 --bits 0", "registers of 0 bits");
    refused("ef-line --from -9223372036854775808,0 --to 9223372036854775807,0", "is outside");
    refused("ef-circle --from 0,0 --to 0,0", "the radius is 0");
}

/// By hand: around (½, 0) through (3, 0) R² = 6.25; the centre is rounded to (1, 0), from which the start point has 4, so
/// F₀ = 4 − 6. And R² = 9 − 1 with F₀ = 1.
#[test]
fn circles_off_the_grid() {
    let json = |line: &str| serde_json::from_str::<Value>(&prints(line)).unwrap();
    let rounded = json("ef-circle --from 3,0 --to 0,2 --center 0.5,0 --format json");
    assert_eq!(rounded["start"]["f"], -2);
    assert_eq!(json("ef-circle --from 3,0 --to 0,3 --center 0.0,0 --format json")["start"]["f"], 0);
    let off = json("ef-circle --from 3,0 --to 0,3 --f0 1 --format json");
    assert_eq!((&off["start"]["f"], &off["finished"]), (&json!(1), &json!(true)));
    // (3, 0) is 3 - √8 outside
    assert!(off["deviation"]["greatest"].as_f64().unwrap() >= 3.0 - 8_f64.sqrt() - 1e-12);
    // every full circle around a centre off the grid keeps within 1 + √½ of the exact one
    for line in ["--center 0.49,-0.3 --from 40,3 --to 40,3", "--center -7.5,2.25 --from 0,0 --to 0,0 --cw"] {
        let drawn = json(&format!("ef-circle-fast {line} --format json"));
        let greatest = drawn["deviation"]["greatest"].as_f64().unwrap();
        assert!(drawn["finished"] == true && greatest <= 1.0 + 0.5_f64.sqrt(), "{line}: {greatest}");
    }
    refused("ef-line --to 5,3 --f0 1", "--f0");
    refused("dda-circle --from 5,0 --to 0,5 --f0 1", "--f0");
    refused("dda-circle --from 5,0 --to 0,5 --center 0.5,0", "--center");
    refused("ef-circle --from 5,0 --to 0,5 --center 0.5", "write it as two numbers, X,Y");
}
