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

#[cfg(test)]
mod tests {
    use super::is_yosys;

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
