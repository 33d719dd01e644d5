//! The reference pages that are made from the code: `BLESS=1 cargo test --test quick docs` renews them.

use std::fmt::Write as _;

use discreta::cell::element::{Kind, Parameter, Port};
use discreta::cell::{Element, elements};
use discreta::diag::{Code, Severity};

/// Compares a page with its file, or writes it.
fn check(path: &str, page: &str) {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&file, page).unwrap();
        return;
    }
    let found = std::fs::read_to_string(&file).unwrap_or_default();
    let line = found.lines().zip(page.lines()).position(|(a, b)| a != b);
    let line = line.unwrap_or(found.lines().count().min(page.lines().count())) + 1;
    assert!(
        found == page,
        "{path} is not up to date from line {line} on; renew it: BLESS=1 cargo test --test quick docs"
    );
}

/// A text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// The families in the order of `elements`, by their first element.
const FAMILIES: &[(&str, &str)] = &[
    ("and", "Gates"),
    ("half_adder", "Arithmetic"),
    ("mux", "Multiplexers, comparators and drivers"),
    ("sr", "Flip-flops, latches and registers"),
    ("counter", "Counters and accumulators"),
    ("constant", "Constants, clocks and delays"),
];

fn kind(parameter: &Parameter) -> String {
    match parameter.kind {
        kind if kind == Kind::WIDTH => "width, 1 or more".into(),
        Kind::Integer { min, max: i64::MAX } => format!("integer, {min} or more"),
        Kind::Integer { min, max } => format!("integer, {min} to {max}"),
        Kind::Word(words) => words.iter().map(|w| format!("`\"{w}\"`")).collect::<Vec<_>>().join(" or "),
        Kind::Value => "value of `width` bits".into(),
        Kind::Quantity => "positive quantity: a number, SI prefix allowed, or an expression".into(),
    }
}

/// What an input reads when it is not connected.
fn unconnected(port: &Port) -> &'static str {
    match port.pin {
        _ if port.required => "required",
        "en" => "default 1",
        _ => "default 0",
    }
}

fn elements_page() -> String {
    let mut page = String::from(
        "# Elements

<!-- made from src/cell by `BLESS=1 cargo test --test quick docs` -->

What a cell's `type` may name besides a module. Each description stands beside the code in `src/cell/`. The tables are
checked against it, the examples are loaded, and every element runs beside Icarus Verilog on random inputs with x and z
in `tests/elements/`. How x, z, edges and time are meant: [meaning](meaning.md); how to write a cell: [format](format.md).
",
    );
    for (first, family) in FAMILIES {
        let members = members(first);
        let links: Vec<String> = members.iter().map(|e| format!("[`{0}`](#{0})", e.name)).collect();
        writeln!(page, "\n**{family}**: {}", links.join(" ")).unwrap();
    }
    for (first, family) in FAMILIES {
        writeln!(page, "\n## {family}").unwrap();
        for element in members(first) {
            describe(&mut page, element);
        }
    }
    page
}

/// The elements from one up to the next family.
fn members(first: &str) -> Vec<&'static Element> {
    let next = |e: &&Element| e.name != first && FAMILIES.iter().any(|(f, _)| *f == e.name);
    let from = elements().skip_while(|e| e.name != first);
    from.take_while(|e| !next(e)).collect()
}

fn describe(page: &mut String, element: &Element) {
    writeln!(page, "\n### {}\n\n{}.\n", element.name, capital(element.summary)).unwrap();
    writeln!(page, "{}\n\nSource: {}.\n\n| port | | |\n|---|---|---|", element.meaning, element.source).unwrap();
    for port in element.ports {
        let direction = if port.output { "output" } else { "input" };
        let several = if port.several { ", an array" } else { "" };
        let when = if port.output { String::new() } else { format!(", {}", unconnected(port)) };
        writeln!(page, "| `{}` | {direction}{several}{when} | {} |", port.name, cell(port.doc)).unwrap();
    }
    if !element.parameters.is_empty() {
        writeln!(page, "\n| parameter | | default | |\n|---|---|---|---|").unwrap();
        for p in element.parameters {
            let default = p.default.map_or("required".into(), |d| format!("`{d}`"));
            writeln!(page, "| `{}` | {} | {default} | {} |", p.name, cell(&kind(p)), cell(p.doc)).unwrap();
        }
    }
    writeln!(page, "\n```json\n{}\n```", element.example.replace("NAME", element.name)).unwrap();
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}

fn errors_page() -> String {
    let mut page = String::from(
        "# Errors and warnings

<!-- made from src/diag/code.rs by `BLESS=1 cargo test --test quick docs` -->

Every fault that is found in a circuit or scenario has one of these codes, in text as in `--format json`. The meaning of a
code never changes. `allow` in a module silences a warning where it is meant.
",
    );
    for (severity, title) in [(Severity::Error, "Errors"), (Severity::Warning, "Warnings")] {
        writeln!(page, "\n## {title}\n\n| code | |\n|---|---|").unwrap();
        for code in Code::ALL.iter().filter(|c| c.severity() == severity) {
            writeln!(page, "| `{code}` | {} |", cell(code.explain())).unwrap();
        }
    }
    page
}

#[test]
fn the_reference_of_elements_is_current() {
    let page = elements_page();
    for element in elements() {
        assert_eq!(page.matches(&format!("\n### {}\n", element.name)).count(), 1, "{}", element.name);
    }
    check("docs/elements.md", &page);
}

#[test]
fn the_reference_of_errors_is_current() {
    check("docs/errors.md", &errors_page());
}

/// Each fact names the test that shows it: `NAME` in `FILE`, below `src/interpolate` if it is not in `tests/`.
#[test]
fn every_fact_has_its_test() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("docs/facts.md")).unwrap();
    let mut facts = 0;
    for line in page.lines().filter(|line| line.contains("` in `")) {
        let Some((before, after)) = line.split_once("` in `") else { continue };
        let (name, file) = (before.rsplit('`').next().unwrap(), after.split('`').next().unwrap());
        if name == "NAME" {
            continue;
        }
        let path = if file.starts_with("tests/") { root.join(file) } else { root.join("src/interpolate").join(file) };
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(text.contains(&format!("fn {name}() {{")), "{file} has no test {name}");
        facts += 1;
    }
    assert!(facts > 30, "{facts}");
}
