//! What a circuit file calls the values of a port or net: read against its width.

use indexmap::IndexMap;

use super::Name;
use crate::Value;
use crate::diag::{Code, Diagnostic, Diagnostics};
use crate::value::ValueNames;

/// Names by their values, as they are written.
pub type Written = IndexMap<Name, Name>;

/// The names of the values of a net of so many bits. A faulty one is told and left out.
pub(crate) fn read(written: &Written, width: u32, diagnostics: &mut Diagnostics) -> Option<ValueNames> {
    let mut names: Vec<(Value, String)> = Vec::new();
    let mut keys: Vec<&Name> = Vec::new();
    let s = if width == 1 { "" } else { "s" };
    for (key, name) in written {
        if let Some(why) = ValueNames::unfit(name) {
            let fault = Diagnostic::new(Code::BadValue, format!("a value's name {why}"));
            diagnostics.push(fault.at(name.span, "").note(format!(
                "viewers read names line by line: 1 to {} characters, no `#`, no spaces at the ends",
                ValueNames::LONGEST
            )));
        }
        match Value::for_width(key, width) {
            Err(e) => diagnostics
                .push(Diagnostic::new(Code::BadValue, e.to_string()).at(key.span, format!("for {width} bit{s}"))),
            Ok(value) => match names.iter().position(|(named, _)| *named == value) {
                Some(first) => diagnostics.push(
                    Diagnostic::new(Code::BadValue, format!("`{}` is named already", key.value))
                        .at(key.span, "the same value")
                        .also(keys[first].span, "here"),
                ),
                None => {
                    names.push((value, name.value.clone()));
                    keys.push(key);
                }
            },
        }
    }
    (!names.is_empty()).then(|| ValueNames::new(names))
}
