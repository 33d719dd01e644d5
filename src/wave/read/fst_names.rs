//! The names in an FST file.

use std::collections::HashMap;

use super::bytes::Bytes;
use super::fst_blocks::Form;
use super::names::{Array, Outline};
use super::notes::Notes;
use super::{Fault, ValueKind};

/// What the block with the names says.
pub(super) struct Hierarchy {
    pub outline: Outline,
    /// The signals of variables: which signal of the file, and what its values are taken for.
    pub signals: Vec<(u32, ValueKind)>,
}

/// A variable as the file declares it.
struct Declared {
    kind: u8,
    /// As it is in the file.
    length: u64,
    /// The signal, from 1; 0 for a new one.
    alias: u64,
}

impl Declared {
    fn value_kind(&self) -> ValueKind {
        let length = u32::try_from(self.length).unwrap_or(u32::MAX);
        match self.kind {
            0 => ValueKind::Event,
            3 | 4 | 20 | 29 => ValueKind::Real,
            21 => ValueKind::Text,
            // a port has two strengths for each bit, and spaces between
            18 => ValueKind::Bits(length.saturating_sub(2) / 3),
            _ => ValueKind::Bits(length),
        }
    }
}

/// The forms of the signals, where the file does not say them yet.
pub(super) fn forms(bytes: &[u8]) -> Vec<Form> {
    let mut forms = Vec::new();
    let mut outline = Outline::new(bytes.len() as u64);
    let _ = walk(bytes, &mut outline, &mut Notes::default(), |_, var, _| {
        if var.alias == 0 {
            let length = u32::try_from(var.length).unwrap_or(u32::MAX);
            forms.push(match (var.value_kind(), length) {
                (ValueKind::Real, _) => Form::Real,
                (_, 0) => Form::Text,
                (_, length) => Form::Bits(length),
            });
        }
        Ok(())
    });
    forms
}

impl Hierarchy {
    /// Reads the names; `forms` are those of the signals.
    pub fn read(bytes: &[u8], forms: &[Form], notes: &mut Notes) -> Result<Hierarchy, Fault> {
        let mut hierarchy = Hierarchy { outline: Outline::new(bytes.len() as u64), signals: Vec::new() };
        let (mut count, mut known) = (0, HashMap::new());
        let signals = &mut hierarchy.signals;
        walk(bytes, &mut hierarchy.outline, notes, |outline, var, name| {
            let signal = if var.alias == 0 { count } else { var.alias - 1 };
            count += u64::from(var.alias == 0);
            let kind = var.value_kind();
            let form = usize::try_from(signal).ok().and_then(|signal| forms.get(signal));
            let fits = match (kind, form) {
                (_, None) => {
                    outline.leave_out(name, "the file has no signal for it".to_owned());
                    return Ok(());
                }
                (ValueKind::Event, _) | (ValueKind::Real, Some(Form::Real)) => true,
                (ValueKind::Text, Some(form)) => *form != Form::Real,
                (ValueKind::Bits(width), Some(form)) => *form == Form::Bits(width) || width == 0,
                _ => false,
            };
            if !fits {
                outline.leave_out(name, format!("it is {kind}, its values are not"));
                return Ok(());
            }
            let number = *known.entry((signal as u32, kind)).or_insert_with(|| {
                signals.push((signal as u32, kind));
                signals.len() as u32 - 1
            });
            outline.declare(&name, kind, number)
        })?;
        Ok(hierarchy)
    }
}

/// Goes through the entries. What ends within one, or is not known, ends the names.
fn walk(
    bytes: &[u8],
    outline: &mut Outline,
    notes: &mut Notes,
    mut var: impl FnMut(&mut Outline, Declared, String) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut bytes = Bytes(bytes);
    let mut array = None;
    while !bytes.is_empty() {
        let mut entry = || -> Option<Result<(), Fault>> {
            Some(match bytes.byte()? {
                254 => {
                    let kind = bytes.byte()?;
                    let name = bytes.text()?;
                    bytes.text()?;
                    let array = if kind == 22 { array.take().unwrap_or(Array::Packed) } else { Array::No };
                    outline.enter(&name, array)
                }
                255 => {
                    outline.leave();
                    Ok(())
                }
                252 => {
                    let (kind, subtype) = (bytes.byte()?, bytes.byte()?);
                    if kind == 0 && matches!(subtype, 4 | 5) {
                        // where it stands in the source: two numbers
                        bytes.variable()?;
                        bytes.byte()?;
                    } else {
                        bytes.text()?;
                    }
                    bytes.variable()?;
                    if kind == 1 {
                        array = Some(if subtype == 1 { Array::Unpacked } else { Array::Packed });
                    }
                    Ok(())
                }
                253 => Ok(()),
                kind @ 0..=29 => {
                    bytes.byte()?;
                    let name = bytes.text()?;
                    let (length, alias) = (bytes.variable()?, bytes.variable()?);
                    var(outline, Declared { kind, length, alias }, name)
                }
                _ => return None,
            })
        };
        match entry() {
            Some(done) => done?,
            None => {
                notes.cut("its names end within one");
                break;
            }
        }
    }
    Ok(())
}
