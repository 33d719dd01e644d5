//! What a memory of a circuit file holds at the start: one value, an array of them, or a file.

use std::sync::Arc;

use super::arguments::{Context, value};
use super::{ParameterText, ParameterValue};
use crate::Value;
use crate::cell::Memory;
use crate::diag::{Code, Diagnostic, Diagnostics, Span};
use crate::import::readmem::{self, Shape};
use crate::value::Word;

/// The name of a file that `init` of a memory gives: no literal or expression has a dot.
pub(super) fn file_name(given: &ParameterValue) -> Option<&str> {
    given.word().filter(|text| text.contains('.'))
}

/// Reads the contents of a memory; what is not given is x. `place` is where they are given, or the memory.
pub(super) fn read(
    shape: Shape,
    given: Option<&ParameterValue>,
    place: Span,
    context: &Context<'_>,
    diagnostics: &mut Diagnostics,
) -> Option<Arc<[Word]>> {
    let bits = u64::from(shape.size) * u64::from(shape.width);
    if bits > context.limits.bits {
        let message = format!("the memory has {bits} bits, the limit is {}", context.limits.bits);
        let fault = Diagnostic::new(Code::TooLarge, message).at(place, "");
        diagnostics.push(fault.help("if you need that, raise the limit: `--limit bits=VALUE`"));
        return None;
    }
    let mut all = Memory::contents(shape.width, shape.size);
    let mut put = |index, value: &Value| Memory::set_word(shape.width, &mut all, index, value, |_| true);
    let Some(given) = given else { return Some(all.into()) };
    if let Some(name) = file_name(given) {
        // a file that cannot be read has been told of
        let (file, text) = (context.text)(name)?;
        let mut faults = Diagnostics::new();
        readmem::read(text, file, shape, &mut faults, put);
        let good = !faults.has_errors();
        diagnostics.append(faults);
        return good.then(|| all.into());
    }
    let ParameterText::Array(words) = &given.value else {
        let value = value("init", given, shape.width, context, diagnostics)?;
        (0..shape.size).for_each(|index| put(index, &value));
        return Some(all.into());
    };
    if let Some(surplus) = words.0.get(shape.size as usize) {
        let message = format!("`init` has {} words, the memory {}", words.0.len(), shape.size);
        let fault = Diagnostic::new(Code::BadContents, message).at(surplus.span, "the first that has no place");
        diagnostics.push(fault.help("give the memory more `words`, or leave these out"));
        return None;
    }
    let mut good = true;
    for (index, word) in words.0.iter().enumerate() {
        match value("init", word, shape.width, context, diagnostics) {
            Some(value) => put(index as u32, &value),
            None => good = false,
        }
    }
    good.then(|| all.into())
}
