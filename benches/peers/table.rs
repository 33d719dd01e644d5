//! The figures as tables of Markdown.

use std::fmt::Write as _;

use crate::measure::{Figures, Measured};
use crate::peers::{Simulator, Trace};

/// A number with three digits, and a unit of thousands.
fn number(n: f64) -> String {
    let (n, unit) = match n {
        n if n >= 1e9 => (n / 1e9, " G"),
        n if n >= 1e6 => (n / 1e6, " M"),
        n if n >= 1e3 => (n / 1e3, " k"),
        n => (n, ""),
    };
    if n >= 100.0 {
        format!("{n:.0}{unit}")
    } else if n >= 10.0 {
        format!("{n:.1}{unit}")
    } else {
        format!("{n:.2}{unit}")
    }
}

fn seconds(s: f64) -> String {
    if s >= 10.0 {
        format!("{s:.0} s")
    } else if s >= 0.1 {
        format!("{s:.2} s")
    } else {
        format!("{:.1} ms", s * 1e3)
    }
}

fn cell<T>(value: Option<T>, text: impl Fn(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), text)
}

/// How many times more cycles a second the first makes.
fn ratio(ours: Option<&Figures>, theirs: Option<&Figures>) -> String {
    cell(ours.zip(theirs), |(a, b)| format!("**{}×**", number(a.rate / b.rate)))
}

fn rows(text: &mut String, head: &[&str], rows: &[Vec<String>]) {
    writeln!(text, "| {} |\n|---{}|", head.join(" | "), "|---:".repeat(head.len() - 1)).unwrap();
    for row in rows {
        writeln!(text, "| {} |", row.join(" | ")).unwrap();
    }
    text.push('\n');
}

/// What an engine says of itself, in a word.
fn engine(figures: Option<&Figures>) -> String {
    let said = figures.and_then(|f| f.engine.as_deref());
    cell(said, |s| s.split([' ', ',']).nth(1).unwrap_or("?").to_owned())
}

/// All tables.
pub fn tables(measured: &[Measured]) -> String {
    use Simulator::{Cxxrtl, Discreta, Event, Icarus, Verilator};
    let mut text = String::from("Cycles a second, nothing recorded:\n\n");
    let plain = |m: &Measured, s| m.of(s, Trace::Nothing).cloned();
    let lines: Vec<Vec<String>> = measured
        .iter()
        .map(|m| {
            let [v, c, i, d, e] = [Verilator, Cxxrtl, Icarus, Discreta, Event].map(|s| plain(m, s));
            let rate = |f: &Option<Figures>| cell(f.as_ref(), |f| number(f.rate));
            let (d, e) = (d.as_ref(), e.as_ref());
            vec![
                format!("{} ({} cells)", m.title, m.cells),
                rate(&v),
                rate(&c),
                rate(&i),
                cell(d, |f| number(f.rate)) + &format!(" {}", engine(d)),
                ratio(d, v.as_ref()),
                ratio(d, c.as_ref()),
                cell(e, |f| number(f.rate)),
                ratio(e, i.as_ref()),
            ]
        })
        .collect();
    let head = [
        "design",
        "Verilator",
        "CXXRTL",
        "Icarus",
        "discreta",
        "÷ Verilator",
        "÷ CXXRTL",
        "its event engine",
        "÷ Icarus",
    ];
    rows(&mut text, &head, &lines);

    text += "From the netlist to the end of the first cycle, and what discreta loses before its speed is steady; the most memory of a run:\n\n";
    let lines: Vec<Vec<String>> = measured
        .iter()
        .map(|m| {
            let all = [Verilator, Cxxrtl, Icarus, Discreta, Event].map(|s| plain(m, s));
            let mut row = vec![m.title.clone()];
            row.extend(all.iter().map(|f| cell(f.as_ref(), |f| seconds(f.first))));
            row.push(cell(all[3].as_ref(), |f| seconds(f.lead)));
            row.extend(all[..4].iter().map(|f| cell(f.as_ref(), |f| format!("{:.1} MB", f.peak as f64 / 1e6))));
            row.push(cell(all[3].as_ref(), |f| number(f.peak as f64 / m.cells as f64)));
            row
        })
        .collect();
    let head = [
        "design",
        "Verilator",
        "CXXRTL",
        "Icarus",
        "discreta",
        "its event engine",
        "until steady",
        "Verilator",
        "CXXRTL",
        "Icarus",
        "discreta",
        "bytes/cell",
    ];
    rows(&mut text, &head, &lines);

    let mut lines = Vec::new();
    for m in measured {
        for trace in [Trace::Vcd, Trace::Fst] {
            let all = [Verilator, Cxxrtl, Icarus, Discreta].map(|s| m.of(s, trace));
            if all.iter().all(Option::is_none) {
                continue;
            }
            let mut row = vec![format!("{}, {}", m.title, trace.name().to_uppercase())];
            for (figures, simulator) in all.iter().zip([Verilator, Cxxrtl, Icarus, Discreta]) {
                let bytes = |f: &Figures| cell(f.bytes, |b| format!("{b:.1} B"));
                let slower = |f: &Figures| {
                    cell(m.of(simulator, Trace::Nothing), |p| format!("{}× slower", number(p.rate / f.rate)))
                };
                row.push(cell(*figures, |f| format!("{}; {}; {}", number(f.rate), bytes(f), slower(f))));
            }
            row.push(ratio(all[3], all[0]));
            row.push(ratio(all[3], all[1]));
            lines.push(row);
        }
    }
    if !lines.is_empty() {
        text += "All named nets recorded: cycles a second, bytes a cycle, against nothing recorded:\n\n";
        let head = ["design", "Verilator", "CXXRTL", "Icarus", "discreta", "÷ Verilator", "÷ CXXRTL"];
        rows(&mut text, &head, &lines);
    }

    let mut missing: Vec<String> = Vec::new();
    for m in measured {
        for f in &m.figures {
            if let Some(why) = &f.missing {
                let line = format!("- {}, {}: {}: {why}", m.title, f.simulator, f.trace);
                missing.push(line);
            }
        }
        if let Some(said) = m.of(Discreta, Trace::Nothing).and_then(|f| f.engine.as_deref()) {
            missing.push(format!("- {}: {said}", m.title));
        }
    }
    text + &missing.join("\n") + "\n"
}
