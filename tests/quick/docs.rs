//! The reference pages that are made from the code (`BLESS=1 cargo test --test quick docs` renews them), and whether the
//! pages hang together: each is in the contents, every link leads somewhere.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use discreta::cell::element::{Kind, Parameter, Port};
use discreta::cell::{Element, elements};
use discreta::diag::{Code, Severity};

/// Compares a page with its file, or writes it.
fn check(path: &str, page: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
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
    ("memory", "Memories"),
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
        Kind::Contents => "value, array of values, or name of a file".into(),
    }
}

/// What an input reads when it is not connected.
fn unconnected(port: &Port) -> &'static str {
    match port.pin {
        _ if port.required => "required",
        _ if port.doc.contains("required") => "see there",
        "en" | "rd_en" => "default 1",
        _ => "default 0",
    }
}

fn elements_page() -> String {
    let mut page = String::from(
        "# Elements

<!-- made from src/cell by `BLESS=1 cargo test --test quick docs` -->

What a cell's `type` may name besides a module. Each description stands beside the code in `src/core/cell/`. The tables are
checked against it, the examples are loaded, and every element runs beside Icarus Verilog on random inputs with x and z
in `tests/oracle/elements/`. How x, z, edges and time are meant: [meaning](meaning.md); how to write a cell: [format](format.md).
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
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
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

/// Every Markdown page below a folder, from the root of the repository.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.append(&mut pages(&path));
        } else if path.extension().is_some_and(|e| e == "md") {
            found.push(path);
        }
    }
    found
}

/// The targets of the links and pictures of a page, outside of its code.
fn links(page: &str) -> Vec<String> {
    let mut code = false;
    let text: Vec<&str> = page
        .lines()
        .filter(|line| {
            let fence = line.trim_start().starts_with("```");
            code ^= fence;
            !code && !fence
        })
        .collect();
    // what stands between backquotes is no link
    let text = text.join("\n").split('`').step_by(2).collect::<Vec<_>>().join("code");
    let mut found = Vec::new();
    for (opening, closing) in [("](", ")"), ("src=\"", "\""), ("srcset=\"", "\"")] {
        let targets = text.split(opening).skip(1).filter_map(|rest| rest.split_once(closing));
        found.extend(targets.map(|(target, _)| target.to_owned()));
    }
    found
}

/// The anchors of a page's headings, as GitHub and rustdoc make them.
fn anchors(page: &str) -> Vec<String> {
    let headings = page.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| {
            let kept = line.trim_start_matches('#').trim().to_lowercase();
            kept.chars()
                .filter(|c| c.is_alphanumeric() || "-_ ".contains(*c))
                .map(|c| if c == ' ' { '-' } else { c })
                .collect()
        })
        .collect()
}

#[test]
fn every_page_is_in_the_contents() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let contents = std::fs::read_to_string(docs.join("README.md")).unwrap();
    let listed: Vec<String> = links(&contents).iter().map(|l| l.split('#').next().unwrap().to_owned()).collect();
    let all = pages(&docs);
    assert!(all.len() > 30, "{}", all.len());
    for page in all {
        let name = page.strip_prefix(&docs).unwrap().to_str().unwrap();
        assert!(name == "README.md" || listed.iter().any(|l| l == name), "docs/README.md does not list {name}");
    }
    let readme = include_str!("../../README.md");
    assert!(links(readme).iter().any(|l| l == "docs/README.md"), "README.md does not lead to docs/README.md");
}

#[test]
fn every_link_leads_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = pages(&root.join("docs"));
    all.extend([root.join("README.md"), root.join("CHANGELOG.md")]);
    let (mut followed, mut broken) = (0, Vec::new());
    for page in all {
        let text = std::fs::read_to_string(&page).unwrap();
        for link in links(&text).iter().filter(|l| !l.contains("://") && !l.starts_with("mailto:")) {
            let (path, anchor) = link.split_once('#').map_or((link.as_str(), None), |(path, a)| (path, Some(a)));
            let target = if path.is_empty() { page.clone() } else { page.parent().unwrap().join(path) };
            let leads = target.exists()
                && anchor.is_none_or(|a| {
                    target.extension().is_none_or(|e| e != "md")
                        || anchors(&std::fs::read_to_string(&target).unwrap()).iter().any(|have| have == a)
                });
            if !leads {
                broken.push(format!("{}: {link}", page.strip_prefix(root).unwrap().display()));
            }
            followed += 1;
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
    assert!(followed > 200, "{followed}");
}

/// The circuit of the first steps has no fault, and does what its scenario expects: three pulses in five clocks.
#[test]
fn the_circuit_of_the_first_steps_runs() {
    let page = include_str!("../../docs/first-steps.md");
    let circuit = page.split_once("```json\n").unwrap().1.split_once("```").unwrap().0;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("blink.json");
    for (circuit, works) in [(circuit.to_owned(), true), (circuit.replace("\"pulses\": 3", "\"pulses\": 4"), false)] {
        std::fs::write(&path, circuit).unwrap();
        let run = |command: &str| {
            let output = Command::new(env!("CARGO_BIN_EXE_discreta")).arg(command).arg(&path).output().unwrap();
            (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
        };
        assert!(run("check").0, "{}", run("check").1);
        assert_eq!(run("run").0, works, "{}", run("run").1);
    }
}

/// What a page names between backquotes as a path of the repository is there.
#[test]
fn every_path_in_the_pages_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = pages(&root.join("docs"));
    all.push(root.join("README.md"));
    let (mut found, mut missing) = (0, Vec::new());
    for page in all {
        let text = std::fs::read_to_string(&page).unwrap();
        for quoted in text.split('`').skip(1).step_by(2) {
            let path = ["tests/", "src/", "benches/", "examples/", "circuits/", "traces/"];
            let plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
            // made by a campaign
            if !path.iter().any(|p| quoted.starts_with(p)) || !quoted.chars().all(plain) || quoted == "tests/fuzz/found"
            {
                continue;
            }
            found += 1;
            if !root.join(quoted).exists() {
                missing.push(format!("{}: {quoted}", page.strip_prefix(root).unwrap().display()));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
    assert!(found > 100, "{found}");
}
