//! Yosys' JSON netlists, as `write_json` writes them.
//!
//! [`mod@file`] reads the text, `import` builds the netlist with `cells` for what each cell does, [`origin`] keeps where
//! everything comes from. `docs/yosys.md` says what is taken.

pub(crate) mod cells;
mod fields;
pub mod file;
pub mod format;
mod import;
pub mod monitor;
pub mod origin;
pub(crate) mod own;
mod report;

use std::borrow::Cow;

use indexmap::IndexMap;
use serde::Deserialize;
use serde::de::IgnoredAny;

pub(crate) use import::{Contents, Imported, import};
pub use monitor::Monitor;
pub use origin::Origins;
pub(crate) use report::report;

/// Whether a text is such a netlist: it says that Yosys or we wrote it, or a port of a module has `bits`.
#[must_use]
pub fn is_yosys(text: &str) -> bool {
    // as Yosys begins it, so that large files need not be read twice
    let begin = text.trim_start().strip_prefix('{').and_then(|t| t.trim_start().strip_prefix("\"creator\""));
    if let Some(says) = begin.and_then(|t| t.trim_start().strip_prefix(':')) {
        return ["\"Yosys", "\"discreta"].iter().any(|tool| says.trim_start().starts_with(tool));
    }
    #[derive(Deserialize)]
    struct Keys<'a> {
        #[serde(borrow)]
        creator: Option<Cow<'a, str>>,
        #[serde(borrow)]
        modules: Option<IndexMap<Cow<'a, str>, Module<'a>>>,
    }
    #[derive(Deserialize)]
    struct Module<'a> {
        #[serde(borrow)]
        ports: Option<IndexMap<Cow<'a, str>, Port>>,
    }
    #[derive(Deserialize)]
    struct Port {
        bits: Option<IgnoredAny>,
    }
    let Ok(keys) = serde_json::from_str::<Keys>(text) else { return false };
    let ports = keys.modules.iter().flat_map(|m| m.values()).filter_map(|m| m.ports.as_ref());
    keys.creator.is_some_and(|c| c.starts_with("Yosys") || c.starts_with("discreta"))
        || ports.flat_map(|p| p.values()).any(|p| p.bits.is_some())
}

/// What the source was of the thing whose name stands at `place` in a netlist as `write_json` lays it out: its attribute
/// `src`, and for a port that of its net.
pub fn source_of(text: &str, place: std::ops::Range<usize>) -> Option<&str> {
    let line = text[..place.start].rfind('\n')? + 1;
    let indent = text[line..].len() - text[line..].trim_start_matches(' ').len();
    let end = format!("\n{}}}", &text[line..line + indent]);
    let source = |from: usize| {
        let body = &text[from..from + text[from..].find(&end)?];
        body.split_once("\"src\": \"")?.1.split('"').next()
    };
    source(place.end).or_else(|| {
        let nets = place.end + text[place.end..].find("\"netnames\": {")?;
        let name = format!("\n{}{}\": {{", &text[line..line + indent], &text[line + indent..place.end]);
        source(nets + text[nets..].find(&name)? + name.len())
    })
}

#[cfg(test)]
mod tests {
    use super::{is_yosys, source_of};

    #[test]
    fn the_source_of_a_port_is_that_of_its_net() {
        let text = "{\n  \"modules\": {\n    \"t\": {\n      \"attributes\": {\n        \"src\": \"t.v:1.1-9.2\"\n      },\n      \"ports\": {\n        \"a\": {\n          \"bits\": [ 2 ]\n        }\n      },\n      \"netnames\": {\n        \"a\": {\n          \"attributes\": {\n            \"src\": \"t.v:2.3-2.4\"\n          }\n        }\n      }\n    }\n  }\n}";
        let of = |name: &str, nth: usize| {
            let at = text.match_indices(name).nth(nth).unwrap().0 + 1;
            source_of(text, at..at + 1)
        };
        assert_eq!(of("\"t\"", 0), Some("t.v:1.1-9.2"));
        assert_eq!(of("\"a\"", 0), Some("t.v:2.3-2.4"));
        assert_eq!(of("\"a\"", 1), Some("t.v:2.3-2.4"));
        assert_eq!(source_of("{}", 1..2), None);
    }

    #[test]
    fn recognised_by_content() {
        assert!(is_yosys(" {\n \"creator\": \"Yosys 0.23 (git sha1 7ce5011c24b)\", broken"));
        assert!(is_yosys(r#"{ "modules": { "m": { "ports": { "a": { "direction": "input", "bits": [2] } } } } }"#));
        assert!(is_yosys(r#"{ "modules": {}, "creator": "Yosys 0.70" }"#));
        assert!(!is_yosys(r#"{ "modules": { "m": { "ports": { "a": { "direction": "input", "width": 2 } } } } }"#));
        assert!(!is_yosys(r#"{ "creator": "somebody", "modules": {} }"#));
        assert!(!is_yosys("{ \"modules\": "));
    }
}
