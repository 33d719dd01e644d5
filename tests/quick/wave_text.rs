//! `discreta wave`: waveforms as text, as a user sees them.

use std::path::Path;

use crate::support::program::{command, run};
use discreta::wave::read::{ValueKind, Waves};

const COUNTER: &str = "tests/waves/counter.vcd";

fn write(text: &str) -> tempfile::NamedTempFile {
    let file = tempfile::Builder::new().suffix(".vcd").tempfile().unwrap();
    std::fs::write(file.path(), text).unwrap();
    file
}

/// A clock, a bus with x and z, a signal further down, one under two names, and an impulse too short for a column.
const SMALL: &str = "$timescale 1ns $end $scope module top $end $var wire 1 ! clk $end $var wire 4 \" q [3:0] $end
$scope module u $end $var wire 1 # d $end $var wire 1 ! clk $end $upscope $end $upscope $end $enddefinitions $end
#0\n0!\nbx \"\nx#\n#10\n1!\nb101 \"\nz#\n#20\n0!\n1#\n#30\n1!\nbz \"\n#40\n0!\nbx1 \"\n";

#[test]
fn levels_values_unknown_bits_and_scopes() {
    let file = write(SMALL);
    let path = file.path().to_str().unwrap();
    let (status, text, told) = command("wave", &format!("{path} --signals ** --ascii"));
    let expected = r#"
       |0 ns-----|10-------|20-------|30-------|40----
top
  clk  __________/"""""""""\_________/"""""""""\______
  q    xxxxxxxxxx| 5                 |zzzzzzzzz| xxx1
top.u
  d    xxxxxxxxxxzzzzzzzzzz"""""""""""""""""""""""""""
"#;
    assert_eq!((status, text.as_str(), told.as_str()), (0, &expected[1..], ""));
    // the order of the patterns, a window, and the other signs
    let (_, text, _) = command("wave", &format!("{path} -s u.d -s top.q --from 10ns --to 35 --radix bin"));
    let expected = "
     ├10 ns────├20───────├30───
top.u
  d  zzzzzzzzzz▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔
top
  q   0101               ╳zzzzz
";
    assert_eq!(text, expected[1..]);
    // what only other scopes hold is counted, not forgotten
    let (_, text, _) = command("wave", path);
    assert!(text.ends_with("… and 1 signals in scopes below: --signals '**' shows all\n"), "{text}");
}

#[test]
fn what_is_too_quick_for_a_column_shows() {
    let mut text = SMALL[..SMALL.find("#0\n").unwrap()].to_owned();
    for n in 0..200 {
        text += &format!("#{}\n{}!\n", n * 100, n % 2);
    }
    // 1 for one tick within the second half of the trace
    text += "#19990\n1#\n#19991\n0#\n#20000\n";
    let file = write(&text);
    let path = file.path().to_str().unwrap();
    let (_, text, _) = command("wave", &format!("{path} -s clk -s u.d --to 20000 --ascii --width 60"));
    let row = |name: &str| text.lines().find(|l| l.trim_start().starts_with(name)).unwrap().to_owned();
    assert!(row("clk").contains("##########"), "{text}");
    assert_eq!(row("d ").matches('#').count(), 1, "{text}");
}

/// Each column of a row of levels has the level that the file has there.
#[test]
fn rows_read_back_are_the_trace() {
    let path = "traces/evaluation/line_5_3.vcd";
    let (status, text, _) = command("wave", &format!("{path} --signals ** --ascii --width 2000"));
    assert_eq!(status, 0);
    let mut waves = Waves::open(Path::new(path)).unwrap();
    let ruler = text.lines().next().unwrap();
    let margin = ruler.find('|').unwrap();
    let per_tick = (ruler[margin + 1..].find('|').unwrap() + 1) as u64
        / ruler[margin + 1..].split('|').nth(1).unwrap().trim_end_matches('-').parse::<u64>().unwrap();
    assert!(per_tick >= 1, "{ruler}");
    let mut columns = 0;
    for line in text.lines().skip(2) {
        let (name, row) = (line[..margin].trim(), &line[margin..]);
        let var = waves.find(&format!("line.{name}")).unwrap();
        if waves.vars()[var].kind != ValueKind::Bits(1) {
            continue;
        }
        let changes: Vec<_> = waves.load(var).unwrap().changes().collect();
        for (column, sign) in row.chars().enumerate() {
            let tick = column as u64 / per_tick;
            let value = changes.iter().rev().find(|(t, _)| *t <= tick).map_or("x", |(_, v)| v.as_str());
            let expected: &[char] = match value {
                "0" => &['_', '\\'],
                "1" => &['"', '/'],
                _ => &['x'],
            };
            assert!(expected.contains(&sign), "{name} at {tick}: {sign}");
            columns += 1;
        }
    }
    assert!(columns > 1000, "{columns}");
}

#[test]
fn lines_fit_the_width_and_formats_agree() {
    for width in [20, 47, 80, 133] {
        for path in [COUNTER, "traces/evaluation/line_255_254.vcd", "traces/feed/system_5_3.vcd"] {
            let (status, text, _) = command("wave", &format!("{path} --signals ** --width {width}"));
            assert_eq!(status, 0);
            let names = text.lines().filter(|l| !l.starts_with('…'));
            // a name is not broken: a row has ten columns at least
            let longest = names.map(|l| l.chars().count()).max().unwrap();
            assert!(longest <= width.max(60), "{path} {width}: {longest}\n{text}");
        }
    }
    let text = |path| run(&["wave", path, "--ascii"]);
    assert_eq!(text(COUNTER), text("tests/waves/counter.fst"));
    assert!(text(COUNTER).1.is_ascii() && !run(&["wave", COUNTER]).1.contains('\u{1b}'));
}

#[test]
fn what_is_long_says_how_to_go_on() {
    let (_, text, _) = command("wave", "traces/evaluation/line_255_254.vcd --ascii --width 80");
    let last = text.lines().last().unwrap();
    let next = last.split_whitespace().skip_while(|w| *w != "--from").nth(1).unwrap().trim_end_matches(',');
    assert!(last.starts_with("... until 10190ns: go on with --from "), "{last}");
    let (status, text, _) = command("wave", &format!("traces/evaluation/line_255_254.vcd --from {next}"));
    assert!(status == 0 && text.lines().count() > 10, "{text}");
}

#[test]
fn what_cannot_be_shown_is_2() {
    for (line, expected) in [
        ("--signals nothing", "no signal of `tests/waves/counter.vcd` matches `nothing`"),
        ("--signals a\\", "is no pattern"),
        ("--from 20ns --to 10ns", "the window ends before it begins"),
        ("--from 5parsecs", "is not a unit of time"),
        ("--from 1.5", "not a whole number of ticks"),
        ("--radix oct", "is no radix"),
        ("--width 5", "invalid value"),
    ] {
        let (status, text, told) = command("wave", &format!("{COUNTER} {line}"));
        assert_eq!((status, text.as_str()), (2, ""), "{line}");
        assert!(told.contains(expected), "{line}: {told}");
    }
    assert_eq!(command("wave", "Cargo.toml").0, 2);
}

/// A golden trace with one value changed: the report of `test` shows both, one above the other.
#[test]
fn a_failing_test_draws_what_was_around() {
    let folder = tempfile::tempdir().unwrap();
    let circuits = Path::new(env!("CARGO_MANIFEST_DIR")).join("circuits/evaluation/line.json");
    let scenario = std::fs::read_to_string("traces/evaluation/line_5_3.json").unwrap();
    let mut scenario: serde_json::Value = serde_json::from_str(&scenario).unwrap();
    scenario["circuit"] = circuits.to_str().unwrap().into();
    let path = folder.path().join("line.json");
    std::fs::write(&path, scenario.to_string()).unwrap();
    let golden = std::fs::read_to_string("traces/evaluation/line_5_3.vcd").unwrap();
    // f after the second clock is 2; let it be 6
    let wrong = golden.replacen("b000000010 ,", "b000000110 ,", 1);
    assert_ne!(wrong, golden);
    std::fs::write(folder.path().join("line.vcd"), wrong).unwrap();
    let (status, text, _) = run(&["test", path.to_str().unwrap()]);
    assert_eq!(status, 1);
    let row = |name: &str| text.lines().find(|l| l.trim_start().starts_with(name)).unwrap_or_else(|| panic!("{text}"));
    let (golden, ran) = (row("line.f (golden)"), row("line.f (run)"));
    let column = text.lines().find_map(|l| l.find('▲')).unwrap();
    let at = |row: &str| row.chars().skip(column).take(3).collect::<String>();
    assert_eq!([at(golden), at(ran)], ["╳ 6", "╳ 2"], "{text}");
}

/// What docs/viewing.md shows is what the command prints: `BLESS=1 cargo test --test quick wave_text` renews it.
#[test]
fn the_page_of_the_docs_is_current() {
    let path = "docs/viewing.md";
    let page = std::fs::read_to_string(path).unwrap();
    let marker = "```text\n$ discreta wave ";
    let mut parts = page.split(marker);
    let mut renewed = parts.next().unwrap().to_owned();
    let mut blocks = 0;
    for part in parts {
        let (line, rest) = part.split_once('\n').unwrap();
        let (_, rest) = rest.split_once("```\n").unwrap();
        let (status, text, _) = command("wave", line);
        assert_eq!(status, 0);
        renewed += &format!("{marker}{line}\n{text}```\n{rest}");
        blocks += 1;
    }
    assert_eq!(blocks, 2);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(path, &renewed).unwrap();
    }
    assert!(page == renewed || std::env::var_os("BLESS").is_some(), "{path} is not up to date: BLESS=1 renews it");
}
