//! `discreta compare`: its numbers against the documents' formulas and against what is known of the methods, its formats,
//! and that `docs/comparison.md` is current: `BLESS=1 cargo test --test quick compare` renews it.

use crate::support::program;

use std::path::Path;
use std::sync::OnceLock;

use serde_json::Value;

/// Exit status, standard output, standard error of a command line split at spaces.
fn compare(line: &str) -> (i32, String, String) {
    program::command("compare", line)
}

#[track_caller]
fn json(line: &str) -> Value {
    let (status, stdout, stderr) = compare(&format!("{line} --format json"));
    assert_eq!((status, stderr.as_str()), (0, ""), "{line}");
    serde_json::from_str(&stdout).unwrap()
}

/// Everything of 8 bits, measured once.
fn eight_bits() -> &'static Value {
    static ONCE: OnceLock<Value> = OnceLock::new();
    ONCE.get_or_init(|| json("--bits 8"))
}

#[track_caller]
fn row<'a>(all: &'a Value, kind: &str, method: &str) -> &'a Value {
    let group = all["groups"].as_array().unwrap().iter().find(|g| g["kind"] == kind).unwrap();
    let row = group["rows"].as_array().unwrap().iter().find(|r| r["method"] == method);
    row.unwrap_or_else(|| panic!("{kind} has no {method}"))
}

/// A measure to so many decimals.
fn number(row: &Value, path: &str, decimals: usize) -> String {
    format!("{:.decimals$}", row.pointer(path).unwrap().as_f64().unwrap())
}

#[track_caller]
fn refused(line: &str, parts: &[&str]) {
    let (status, stdout, stderr) = compare(line);
    assert_eq!((status, stdout.as_str()), (2, ""), "{line}: {stderr}");
    for part in parts {
        assert!(stderr.contains(part), "{line} does not say {part:?} but\n{stderr}");
    }
}

/// After n clocks of p bits a DDA line is at (⌊n·ΔX/2^p⌋, ⌊n·ΔY/2^p⌋).
#[test]
fn a_dda_line_is_where_its_formula_says() {
    let (mut most, mut sum, mut clocks) = (0.0_f64, 0.0, 0);
    for (dx, dy) in (0..32_u32).flat_map(|dx| (0..32_u32).map(move |dy| (dx, dy))).skip(1) {
        let length = f64::from(dx * dx + dy * dy).sqrt();
        for n in 1..=32 {
            let (x, y) = (n * dx / 32, n * dy / 32);
            let away = (f64::from(y * dx) - f64::from(x * dy)).abs() / length;
            (most, sum, clocks) = (most.max(away), sum + away, clocks + 1);
        }
    }
    let measured = json("--bits 5");
    let line = row(&measured, "lines", "dda-line");
    assert_eq!(number(line, "/deviation/most", 9), format!("{most:.9}"));
    assert_eq!(number(line, "/deviation/mean", 9), format!("{:.9}", sum / f64::from(clocks)));
    assert_eq!((&line["clocks"]["mean"], &line["clocks"]["most"]), (&32.0.into(), &32.into()));
    // and the standard method takes a clock for each BLU, one more along y
    let steps: u32 = (0..32).flat_map(|dx| (0..32).map(move |dy| dx + dy + u32::from(dx == 0 && dy > 0))).sum();
    let standard = row(&measured, "lines", "ef-line");
    assert_eq!(number(standard, "/clocks/mean", 6), format!("{:.6}", f64::from(steps) / 1023.0));
}

/// x² + y² − R² picks the axis, with nothing but that formula.
#[test]
fn grossmans_arcs_are_where_the_function_leads() {
    let (mut outside, mut inside) = (0.0_f64, 0.0_f64);
    for r in 1..64_i32 {
        let (mut x, mut y) = (r, 0);
        while (x, y) != (0, r) {
            if x * x + y * y >= r * r && x > 0 || y == r {
                x -= 1;
            } else {
                y += 1;
            }
            let away = f64::from(x * x + y * y).sqrt() - f64::from(r);
            (outside, inside) = (outside.max(away), inside.min(away));
        }
    }
    let measured = json("--bits 6");
    let arc = row(&measured, "quarters", "grossman (ef-circle)");
    assert_eq!(number(arc, "/deviation/outside", 9), format!("{outside:.9}"));
    assert_eq!(number(arc, "/deviation/inside", 9), format!("{inside:.9}"));
}

/// What is known of the methods by brute force elsewhere.
#[test]
fn known_numbers_of_8_bits() {
    let all = eight_bits();
    for (kind, method, path, decimals, expected) in [
        ("lines", "dda-line", "/deviation/most", 4, "0.9961"),
        ("lines", "dda-line --half-preload", "/deviation/most", 4, "0.7044"),
        ("lines", "ef-line --centred", "/deviation/most", 4, "0.7071"),
        ("lines", "ef-line-fast --centred", "/deviation/most", 1, "0.5"),
        ("lines", "ef-line", "/speed/ratio", 3, "1.414"),
        ("lines", "ef-line-fast", "/speed_141/least", 3, "0.925"),
        ("lines", "ef-line-fast", "/speed_141/greatest", 3, "1.003"),
        ("lines", "ef-line-fast", "/speed_141/ratio", 3, "1.084"),
        ("quarters", "grossman (ef-circle)", "/deviation/most", 3, "1.000"),
        ("quarters", "ef-circle-fast", "/deviation/most", 3, "0.998"),
        ("arcs", "karibsky", "/deviation/most", 3, "1.412"),
        ("quarters", "dda-circle", "/deviation/outside", 3, "1.462"),
        ("quarters", "dda-circle", "/deviation/inside", 3, "-0.190"),
        ("quarters", "dda-circle --half-preload", "/deviation/outside", 3, "0.918"),
        ("quarters", "dda-circle --half-preload", "/deviation/inside", 3, "-0.657"),
        ("quarters", "dda-circle --parallel", "/deviation/outside", 3, "1.766"),
        ("quarters", "dda-circle --parallel", "/deviation/inside", 3, "-0.151"),
        ("quarters", "dda-circle --parallel --half-preload", "/deviation/outside", 3, "1.242"),
        ("quarters", "dda-circle --parallel --half-preload", "/deviation/inside", 3, "-0.645"),
    ] {
        assert_eq!(number(row(all, kind, method), path, decimals), expected, "{kind} {method} {path}");
    }
    for kind in ["lines", "quarters"] {
        let group = all["groups"].as_array().unwrap().iter().find(|g| g["kind"] == kind).unwrap();
        for row in group["rows"].as_array().unwrap() {
            assert_eq!((&row["exact"], &row["unfinished"]), (&row["segments"], &0.into()), "{row}");
            assert!(row["f_wrong"].is_null() || row["f_wrong"] == 0, "{row}");
        }
    }
    assert_eq!(row(all, "lines", "ef-line")["segments"], 65_535);
}

#[test]
fn claims_are_judged_by_what_was_measured() {
    let claims = eight_bits()["claims"].as_array().unwrap();
    let holds = |start: &str| {
        let claim = claims.iter().find(|c| c["claim"].as_str().unwrap().starts_with(start));
        claim.unwrap_or_else(|| panic!("{start}"))["holds"].clone()
    };
    for (claim, expected) in [
        ("At most one BLU off: line by DDA", true),
        ("At most one BLU off: circle by DDA", false),
        ("Exact to one pulse: circle by Grossman", true),
        ("Exact to one pulse: circle by Karibsky", false),
        ("Grossman against every circle here: least equipment", false),
        ("No accumulated error", true),
        ("2^p clocks whatever the length: line", true),
        ("2^p clocks whatever the length: circle", false),
        ("The speed changes 1.4 times", true),
        ("×1.41 keeps the speed constant", false),
        ("×1.41 and ×1.73 keep the speed constant", false),
    ] {
        assert_eq!(holds(claim), expected, "{claim}");
    }
    // with few bits a circle by DDA keeps within a BLU, and the verdict follows
    let few = json("--bits 4");
    let circle = few["claims"].as_array().unwrap().iter().find(|c| c["claim"] == "At most one BLU off: circle by DDA");
    let most = ["dda-circle", "dda-circle --parallel"]
        .map(|m| row(&few, "quarters", m).pointer("/deviation/most").unwrap().as_f64().unwrap());
    assert_eq!(circle.unwrap()["holds"], most.iter().all(|&d| d <= 1.0), "{most:?}");
}

#[test]
fn a_sample_is_stated_and_always_the_same() {
    let line = "--bits 12 --sample 20 --seed 7";
    let (status, text, stderr) = compare(line);
    assert_eq!((status, stderr.as_str()), (0, ""));
    assert_eq!(text.matches("20 of them drawn by seed 7").count(), 5, "{text}");
    assert_eq!(compare(line).1, text);
    assert_ne!(compare("--bits 12 --sample 20 --seed 8").1, text);
    assert_eq!(row(&json(line), "lines", "dda-line")["clocks"]["most"], 4096);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    refused("--circuits docs", &["there is no circuit `docs/evaluation/line.json` of ef-line", "--circuits DIR"]);
    refused("--bits 12", &["they may be 4 to 9", "draw a sample: --sample 2000"]);
    refused("--bits 40 --sample 10", &["they may be 4 to 20"]);
    refused("--bits 3", &["they may be 4 to 9"]);
    refused("--seed 3", &["--sample"]);
    refused("--sample 0", &["0"]);
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("evaluation")).unwrap();
    std::fs::write(dir.path().join("evaluation/line.json"), "{ \"modules\": 5 }").unwrap();
    refused(&format!("--circuits {}", dir.path().display()), &["error["]);
}

#[test]
fn every_measure_is_defined_in_help_and_page() {
    let (_, help, _) = compare("--help");
    let (_, page, _) = compare("--bits 4 --format markdown");
    for measure in ["gates", "depth", "elements", "deviation", "speed", "F wrong"] {
        assert!(help.contains(&format!("  {measure}: ")), "{measure}: {help}");
        assert!(page.contains(&format!("| {measure} | ")), "{measure}: {page}");
    }
}

#[test]
fn the_page_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/comparison.md");
    let (status, page, stderr) = compare("--format markdown");
    assert_eq!((status, stderr.as_str()), (0, ""));
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == page, "docs/comparison.md is not up to date; renew it: BLESS=1 cargo test --test quick compare");
}
