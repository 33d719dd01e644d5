//! `discreta plot`: what is in a picture, what is refused, and that the pictures of the documentation are current:
//! `BLESS=1 cargo test --test quick plot` renews them.

use crate::support::program;

use std::path::Path;

const TRACE: &str = "traces/evaluation/line_5_3.vcd";

/// Exit status, standard output, standard error of a command line split at spaces.
fn plot(line: &str) -> (i32, String, String) {
    program::command("plot", line)
}

/// The picture.
#[track_caller]
fn svg(line: &str) -> String {
    let (status, stdout, stderr) = plot(line);
    assert_eq!((status, stderr.as_str()), (0, ""), "{line}");
    well_formed(&stdout);
    stdout
}

#[track_caller]
fn refused(line: &str, parts: &[&str]) {
    let (status, stdout, stderr) = plot(line);
    assert_eq!((status, stdout.as_str()), (2, ""), "{line}: {stderr}");
    for part in parts {
        assert!(stderr.contains(part), "{line} does not say {part:?} but\n{stderr}");
    }
}

/// Every tag is closed in order, attributes are quoted, and nothing is loaded from elsewhere.
#[track_caller]
fn well_formed(svg: &str) {
    let mut open = Vec::new();
    let (before, style) = svg.split_once("<![CDATA[").unwrap();
    let (_, after) = style.split_once("]]>").unwrap();
    for text in [before, after] {
        for tag in text.split('<').skip(1) {
            let (tag, _) = tag.split_once('>').unwrap();
            assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
            let name = tag.split_whitespace().next().unwrap();
            match name.strip_prefix('/') {
                Some(name) => assert_eq!(open.pop(), Some(name)),
                None if !tag.ends_with('/') => open.push(name),
                None => {}
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
    assert!(!svg.contains("href") && !svg.contains("url(") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    for part in ["role=\"img\"", "<title id=\"title\">", "<desc id=\"desc\">", "prefers-color-scheme: dark", "viewBox="]
    {
        assert!(svg.contains(part), "{part}");
    }
}

/// An attribute of every element of a class that has it, in order.
fn attributes(svg: &str, class: &str, name: &str) -> Vec<String> {
    let elements = svg.lines().filter(|l| l.contains(&format!("class=\"{class}\"")));
    let value = |l: &str| Some(l.split_once(&format!(" {name}=\""))?.1.split_once('"')?.0.to_owned());
    elements.filter_map(value).collect()
}

/// The points of the first line of a class.
fn points(svg: &str, class: &str) -> Vec<(f64, f64)> {
    let data = attributes(svg, class, "d").remove(0);
    let pairs = data.split(['M', 'L']).skip(1).map(|p| p.trim_end_matches('Z').split_once(',').unwrap());
    pairs.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).collect()
}

/// From pixel to pixel of the same size, up on the page for y: XYXYXXYX.
#[test]
fn the_path_is_the_steps() {
    let picture = svg("ef-line --to 5,3");
    let number = |v: &String| v.parse::<f64>().unwrap();
    let (x, y) = (attributes(&picture, "dot", "cx"), attributes(&picture, "dot", "cy"));
    let dots: Vec<(f64, f64)> = x.iter().zip(&y).map(|(x, y)| (number(x), number(y))).collect();
    let blu = dots[1].0 - dots[0].0;
    let path = &dots[..9];
    let steps: String = path
        .windows(2)
        .map(|w| match ((w[1].0 - w[0].0) / blu, (w[0].1 - w[1].1) / blu) {
            (x, y) if (x - 1.0).abs() < 0.01 && y.abs() < 0.01 => 'X',
            (x, y) if x.abs() < 0.01 && (y - 1.0).abs() < 0.01 => 'Y',
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(steps, "XYXYXXYX");
    // the ideal line joins the ends
    assert_eq!((points(&picture, "ideal")[0], *points(&picture, "ideal").last().unwrap()), (path[0], path[8]));
    // F(2, 2) = 2·5 − 2·3 = 4, and the line is √34 long
    assert!(picture.contains(">0.686 BLU at clock 4<"), "{picture}");
    // beneath it the deviations F/√34 of F = 0 −3 2 −1 4 1 −2 3 0
    let beneath = &dots[9..];
    let unit = (beneath[0].1 - beneath[4].1) / 4.0;
    for (dot, f) in beneath.iter().zip([0, -3, 2, -1, 4, 1, -2, 3, 0]) {
        assert!((beneath[0].1 - dot.1 - unit * f64::from(f)).abs() < 0.05, "{f}: {beneath:?}");
    }
}

#[test]
fn a_waveform_gives_the_same_path() {
    let (of_method, of_trace) = (svg("ef-line --to 5,3"), svg(TRACE));
    assert_eq!(points(&of_method, "path"), points(&of_trace, "path"));
    assert!(of_trace.contains("line_5_3.vcd: a line (0, 0) → (5, 3)") && of_trace.contains(">0.686 BLU at clock 4<"));
    // over another curve: (2, 2) is 3 off the circle of radius √2 … through (1, 1), at clock 8 (5, 3) is √34 − √2 away
    let arc = svg(&format!("{TRACE} --from 1,1 --to 0,1 --ccw"));
    assert!(arc.contains(">4.417 BLU at clock 8<"), "{arc}");
    let named = svg(&format!("{TRACE} --x line.yt --y line.xt --dt line.dt"));
    assert!(named.contains("(0, 0) → (3, 5)"), "{named}");
}

#[test]
fn signed_coordinates_of_a_waveform() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("back.vcd");
    let text = "$timescale 1ns $end\n$scope module m $end\n$var wire 1 c dt $end\n$var wire 4 x xt $end\n\
                $var wire 4 y yt $end\n$upscope $end\n$enddefinitions $end\n#0\n0c\nb0 x\nb0 y\n#1\n1c\n#2\n0c\nb1111 x\n\
                #3\n1c\n#4\n0c\nb1110 x\n#5\n";
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    assert!(svg(&format!("{path} --signed")).contains("(0, 0) → (-2, 0)"));
    // a path does not leap from 0 to 15
    assert!(svg(path).contains("(0, 0) → (-2, 0)"));
    std::fs::write(path, text.replace("b0 x", "b1000 x").replace("b1111 x", "b111 x").replace("b1110 x", "b110 x"))
        .unwrap();
    assert!(svg(path).contains("(8, 0) → (6, 0)"), "nor from -8 to 7");
    std::fs::write(path, text.replace("b1111 x", "b1x11 x")).unwrap();
    refused(path, &["a coordinate is unknown before the edge of the clock at 3"]);
}

#[test]
fn pictures_are_well_formed_and_always_the_same() {
    for line in [
        "ef-line --to 0,0",
        "ef-line --to 0,7",
        "ef-circle --from 1,0 --to 0,1",
        "ef-circle --from 100,0 --to 0,100",
        "dda-circle --from 200,0 --to 0,200 --half-preload",
        "ef-line-3d --to 12,7,5",
        "ef-line --from 70000,70000 --to 70003,70001",
        "ef-circle-fast --from -30,20 --to 30,20 --cw",
        "ef-circle --from 45,5 --to 45,5 --center 5,5 --offset 6 --side left",
        "dda-curve --from 100,0 --to 100,0 --conic 1,0,1,0,0,-10000 --parallel",
    ] {
        assert_eq!(svg(line), svg(line), "{line}");
    }
}

#[test]
fn long_paths_make_small_files() {
    for line in ["ef-line --to 300000,200000", "ef-circle --from 60000,0 --to 0,60000", "dda-line --to 65535,3"] {
        let picture = svg(line);
        assert!(picture.len() < 150_000, "{line}: {} bytes", picture.len());
        assert!(picture.contains("class=\"band\""), "{line}");
    }
    // all of it is there: the path ends where the ideal line ends
    let picture = svg("ef-line --to 300000,200000");
    assert_eq!(points(&picture, "path").last(), points(&picture, "ideal").last());
}

#[test]
fn a_file_is_written_whole_and_told() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("line.svg");
    let (status, stdout, _) = plot(&format!("ef-line --to 5,3 -o {}", path.display()));
    let expected = format!("wrote {}: 8 clocks, at most 0.686 BLU off, at clock 4\n", path.display());
    assert_eq!((status, stdout), (0, expected));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), svg("ef-line --to 5,3"));
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    refused("ef-line --to 5,3 -o no/such/line.svg", &["cannot write `no/such/line.svg`", "make the directory first"]);
}

#[test]
fn what_does_not_end_is_drawn_and_told() {
    let (status, stdout, stderr) = plot("ef-line --to 0,3 --as-printed");
    assert_eq!((status, stderr.as_str()), (1, "error: stopped by the watchdog: no end within 6 clocks\n"));
    assert!(stdout.contains("the end was not reached"), "{stdout}");
}

#[test]
fn what_cannot_be_meant_is_refused() {
    refused("ef-lin --to 5,3", &["no method is called 'ef-lin'", "name a method, or a waveform"]);
    refused("ef-line --to 5,3 --signed", &["ef-line has no option --signed"]);
    refused("ef-line --to 5,3 --cw", &["ef-line has no option --cw"]);
    refused("no/such.vcd", &["cannot read the waveform `no/such.vcd`"]);
    refused("Cargo.toml", &["cannot read the waveform `Cargo.toml`"]);
    refused(&format!("{TRACE} --bits 8"), &["a waveform has no option --bits"]);
    refused(&format!("{TRACE} --x nothing"), &["has no net `nothing`", "name another with --x"]);
    refused(&format!("{TRACE} --z kox --cw"), &["arcs lie in the plane"]);
    refused("tests/bad/line.vcd", &["cannot read"]);
}

#[test]
fn the_pictures_of_the_documentation_are_current() {
    for (file, line) in [
        ("ef_circle.svg", "ef-circle --from 10,0 --to 0,10"),
        ("dda_circle.svg", "dda-circle --from 10,0 --to 0,10 --bits 4 --parallel"),
        ("ef_line_3d.svg", "ef-line-3d --to 12,7,5"),
        ("dda_curve.svg", "dda-curve --from 60,0 --to 60,0 --conic 1,1,1,0,0,-3600"),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/pictures").join(file);
        let picture = svg(line);
        if std::env::var_os("BLESS").is_some() {
            std::fs::write(&path, &picture).unwrap();
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            found == picture,
            "docs/pictures/{file} is not up to date; renew it: BLESS=1 cargo test --test quick plot"
        );
    }
}

/// What a circuit's coordinates are is told from their path, or by the circuit: in every quadrant, for every method, around
/// other centres. That which `--signed` gives is the measure.
#[test]
fn signs_are_found() {
    let dir = tempfile::tempdir().unwrap();
    let wave = dir.path().join("w.vcd").display().to_string();
    let mut told = 0;
    for circuit in ["circle", "fast_circle", "karibsky"] {
        for (from, to) in
            [([6, 6], [-6, 6]), ([-6, 6], [-6, -6]), ([-5, -1], [-1, -5]), ([3, 4], [-4, 3]), ([5, -2], [2, 5])]
        {
            for center in [[0, 0], [-20, -15], [-20, 15]] {
                let file = format!("circuits/quadrant/{circuit}.json");
                let at = |p: [i64; 2]| [p[0] + center[0], p[1] + center[1]];
                let ([xh, yh], [xk, yk]) = (at(from), at(to));
                let sets = format!(
                    "-s xh={xh} -s yh={yh} -s xk={xk} -s yk={yk} -s xc={} -s yc={} -s cw=0",
                    center[0], center[1]
                );
                let (status, _, err) = program::command("run", &format!("{file} {sets} --cycles 60 -o {wave}"));
                if status == 2 {
                    // a method that has no centre, or no such arc
                    println!("{file} {sets}: {err}");
                    continue;
                }
                let line = format!("{wave} --center {},{}", center[0], center[1]);
                let signed = svg(&format!("{line} --signed"));
                assert_eq!(svg(&line), signed, "{file} {sets}");
                assert_eq!(svg(&format!("{line} --circuit {file}")), signed, "{file} {sets}");
                told += 1;
            }
        }
    }
    assert!(told >= 30, "{told}");
}
