//! The deserializer over the syntax tree.
//!
//! It checks more than serde asks for (unknown fields, duplicate keys) and goes on after faults: see [`Recover`].

use std::cell::RefCell;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;

use indexmap::IndexMap;
use jsonc_parser::ast::{Object, ObjectProp, Value};
use jsonc_parser::common::{Range, Ranged};
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Visitor};

use super::access::{Attempts, Elements, Entries, Placed, Variant};
use super::fault::{Error, told};
use super::spanned::{RECOVER, Recover, SPANNED};
use super::syntax;
use crate::diag::{Code, Diagnostic, Diagnostics, FileId, Sources, Span};

/// What the serde name of an enum starts with that is told apart by the kind of JSON value: its variants are named
/// `integer`, `number`, `boolean`, `string`, `array` and `object`, each holding one value. The rest of the name says
/// what is expected, e.g. `$discreta::Kind an integer or an expression`.
pub const KIND: &str = "$discreta::Kind ";

/// Reads the JSON text `file` as a `T`. All faults go into `diagnostics`; the value is there unless the text is not
/// JSON or faulty outside of all [`Recover`].
pub fn parse<T: DeserializeOwned>(sources: &Sources, file: FileId, diagnostics: &mut Diagnostics) -> Option<T> {
    let tree = match syntax::tree(sources.text(file), file) {
        Ok(tree) => tree,
        Err(fault) => {
            diagnostics.push(fault);
            return None;
        }
    };
    let reading =
        Reading { file, diagnostics: RefCell::new(diagnostics), told: <_>::default(), failed: <_>::default() };
    let root = Node { value: &tree, key: None, reading: &reading };
    match Recover::deserialize(root) {
        Ok(Recover(value)) => value,
        Err(error) => {
            reading.tell(error, root);
            None
        }
    }
}

/// For `#[serde(deserialize_with = "json::every")]` on a map or list whose parts do not [`Recover`]: all faults are
/// told, and then it fails as a whole.
///
/// # Errors
/// If any part cannot be read.
pub fn every<'de, D: Deserializer<'de>, C: Every<'de>>(deserializer: D) -> Result<C, D::Error> {
    C::every(deserializer)
}

/// For `#[serde(default, deserialize_with = "json::or_default")]` on a field that is not worth losing the rest for: a
/// fault is told, and the field is taken for left out.
///
/// # Errors
/// Only those of a deserializer other than [`parse`]'s.
pub fn or_default<'de, D: Deserializer<'de>, T: Deserialize<'de> + Default>(deserializer: D) -> Result<T, D::Error> {
    Ok(Recover::<T>::deserialize(deserializer)?.0.unwrap_or_default())
}

/// What [`every`] can read.
pub trait Every<'de>: Sized {
    /// See [`every`].
    ///
    /// # Errors
    /// If any part cannot be read.
    fn every<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;
}

impl<'de, T: Deserialize<'de>> Every<'de> for Vec<T> {
    fn every<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let list = Vec::<Recover<T>>::deserialize(deserializer)?;
        list.into_iter().map(|part| part.0.ok_or_else(told)).collect()
    }
}

impl<'de, K: Deserialize<'de> + Hash + Eq, V: Deserialize<'de>> Every<'de> for IndexMap<K, V> {
    fn every<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let map = IndexMap::<K, Recover<V>>::deserialize(deserializer)?;
        map.into_iter().map(|(key, part)| Ok((key, part.0.ok_or_else(told)?))).collect()
    }
}

impl<'de, T: Every<'de>> Every<'de> for Option<T> {
    fn every<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::every(deserializer).map(Some)
    }
}

/// The reading of one text.
pub(super) struct Reading<'a> {
    file: FileId,
    diagnostics: RefCell<&'a mut Diagnostics>,
    /// What has been told: a part may be read several times.
    told: RefCell<HashSet<(Code, Option<Span>)>>,
    /// Fields of structs (by the offset of their name) whose values are faulty. They are left out when the struct is
    /// read again for the faults of its other fields.
    pub(super) failed: RefCell<HashSet<usize>>,
}

impl Reading<'_> {
    fn span(&self, range: Range) -> Span {
        Span::new(self.file, range.start as u32, range.end as u32)
    }

    /// The place between the quotes, unless nothing stands there.
    fn inside(&self, range: Range) -> Span {
        let quotes = usize::from(range.end > range.start + 2);
        self.span(Range { start: range.start + quotes, end: range.end - quotes })
    }

    fn push(&self, fault: Diagnostic) {
        if self.told.borrow_mut().insert((fault.code, fault.place())) {
            self.diagnostics.borrow_mut().push(fault);
        }
    }

    pub(super) fn tell(&self, error: Error, node: Node<'_>) {
        match error {
            Error::Faults(list) => list.into_iter().for_each(|fault| self.push(fault)),
            Error::Here(code, message) => self.push(Diagnostic::new(code, message).at(node.span(), "")),
            Error::Missing(field) => self.push(node.missing(field)),
        }
    }

    /// The properties of an object, each name once; tells of those that are given again.
    fn properties<'a>(&self, object: &'a Object<'a>) -> Vec<Property<'a>> {
        // Most objects are small: they are looked through; only large ones are worth a table.
        const SMALL: usize = 12;
        let mut table: HashMap<&str, Span> = HashMap::new();
        let mut properties: Vec<Property<'a>> = Vec::with_capacity(object.properties.len());
        for property in &object.properties {
            let name = property.name.as_str();
            let span = self.inside(property.name.range());
            let before = match object.properties.len() {
                0..=SMALL => properties.iter().find(|p| p.name == name).map(|p| p.span),
                _ => match table.entry(name) {
                    Entry::Occupied(first) => Some(*first.get()),
                    Entry::Vacant(free) => {
                        free.insert(span);
                        None
                    }
                },
            };
            if let Some(before) = before {
                let fault = Diagnostic::new(Code::DuplicateKey, format!("`{name}` is given twice"));
                self.push(fault.at(span, "here again").also(before, "first here"));
                continue;
            }
            properties.push(Property { name, span, property });
        }
        properties
    }
}

pub(super) struct Property<'a> {
    pub(super) name: &'a str,
    pub(super) span: Span,
    pub(super) property: &'a ObjectProp<'a>,
}

/// A value in the tree, and the key that it stands under.
#[derive(Clone, Copy)]
pub(super) struct Node<'a> {
    pub(super) value: &'a Value<'a>,
    pub(super) key: Option<(&'a str, Span)>,
    pub(super) reading: &'a Reading<'a>,
}

impl<'a> Node<'a> {
    fn span(&self) -> Span {
        match self.value {
            Value::StringLit(s) => self.reading.inside(s.range),
            value => self.reading.span(value.range()),
        }
    }

    pub(super) fn under(self, value: &'a Value<'a>, key: Option<(&'a str, Span)>) -> Node<'a> {
        Node { value, key, ..self }
    }

    fn found(&self) -> String {
        match self.value {
            Value::StringLit(_) => "a string".to_owned(),
            Value::NumberLit(_) => "a number".to_owned(),
            Value::BooleanLit(b) => format!("`{}`", b.value),
            Value::Object(_) => "an object".to_owned(),
            Value::Array(_) => "an array".to_owned(),
            Value::NullKeyword(_) => "`null`".to_owned(),
        }
    }

    fn must_be(&self, code: Code, expected: &str) -> Diagnostic {
        Diagnostic::new(
            code,
            match self.key {
                Some((key, _)) => format!("`{key}` must be {expected}"),
                None => format!("expected {expected}"),
            },
        )
    }

    fn wrong_type(&self, expected: &str) -> Error {
        let mut fault = self.must_be(Code::WrongType, expected).at(self.span(), format!("this is {}", self.found()));
        if let Value::NullKeyword(_) = self.value {
            fault = fault.help("leave the field out instead");
        }
        Error::Faults(vec![fault])
    }

    fn missing(&self, field: &str) -> Diagnostic {
        let (message, span) = match self.key {
            Some((key, span)) => (format!("`{key}` has no field `{field}`"), span),
            None => {
                let span = self.span();
                (format!("the field `{field}` is missing"), Span { end: span.start + 1, ..span })
            }
        };
        Diagnostic::new(Code::MissingField, message).at(span, format!("`{field}` is missing"))
    }

    fn integer(&self, expected: &str) -> Result<i64, Error> {
        let Value::NumberLit(number) = self.value else {
            return Err(self.wrong_type(expected));
        };
        number.value.parse().map_err(|_| {
            Error::Faults(vec![if is_integer(number.value) {
                Diagnostic::new(Code::BadValue, "a number must fit 64 bits")
                    .at(self.span(), "this is outside of -2^63 to 2^63-1")
            } else {
                self.must_be(Code::WrongType, expected).at(self.span(), "this is not an integer")
            }])
        })
    }

    fn object(&self) -> Result<&'a Object<'a>, Error> {
        match self.value {
            Value::Object(object) => Ok(object),
            _ => Err(self.wrong_type("an object")),
        }
    }

    fn unknown_word(&self, word: &str, known: &[&str]) -> Error {
        let fault = self.must_be(Code::BadValue, &alternatives(known)).at(self.span(), "unknown word");
        Error::Faults(vec![fault.did_you_mean(word, known.iter().copied())])
    }
}

fn is_integer(number: &str) -> bool {
    !number.contains(['.', 'e', 'E'])
}

fn alternatives(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|w| format!("`{w}`")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.concat(),
    }
}

macro_rules! integers {
    ($($method:ident)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            visitor.visit_i64(self.integer("an integer")?)
        }
    )*};
}

impl<'de> Deserializer<'de> for Node<'_> {
    type Error = Error;

    integers!(deserialize_i8 deserialize_i16 deserialize_i32 deserialize_i64);
    integers!(deserialize_u8 deserialize_u16 deserialize_u32 deserialize_u64);

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value {
            Value::StringLit(s) => visitor.visit_str(&s.value),
            Value::NumberLit(n) if is_integer(n.value) => self.deserialize_i64(visitor),
            Value::NumberLit(_) => self.deserialize_f64(visitor),
            Value::BooleanLit(b) => visitor.visit_bool(b.value),
            Value::Object(_) => self.deserialize_map(visitor),
            Value::Array(_) => self.deserialize_seq(visitor),
            Value::NullKeyword(_) => visitor.visit_unit(),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value {
            Value::BooleanLit(b) => visitor.visit_bool(b.value),
            _ => Err(self.wrong_type("`true` or `false`")),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value {
            Value::NumberLit(n) => visitor.visit_f64(n.value.parse().unwrap_or(f64::INFINITY)),
            _ => Err(self.wrong_type("a number")),
        }
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_f64(visitor)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value {
            Value::StringLit(s) => visitor.visit_str(&s.value),
            _ => Err(self.wrong_type("a string")),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_str(visitor)
    }

    fn deserialize_char<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_str(visitor)
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_str(visitor)
    }

    fn deserialize_bytes<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_str(visitor)
    }

    fn deserialize_byte_buf<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_str(visitor)
    }

    /// A field is left out or has a value; `null` is not another way to leave it out.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value {
            Value::NullKeyword(_) => visitor.visit_unit(),
            _ => Err(self.wrong_type("`null`")),
        }
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_unit(visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, Error> {
        match name {
            SPANNED => visitor.visit_seq(Placed { part: self, span: Some(self.span()) }),
            RECOVER => visitor.visit_seq(Attempts { node: self, again: true }),
            _ => visitor.visit_newtype_struct(self),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.value {
            Value::Array(array) => visitor.visit_seq(Elements { rest: array.elements.iter(), array: self }),
            _ => Err(self.wrong_type("an array")),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let properties = self.reading.properties(self.object()?);
        visitor.visit_map(Entries { rest: properties.into_iter(), value: None, node: self, is_struct: false })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let mut properties = self.reading.properties(self.object()?);
        properties.retain(|p| {
            let known = fields.contains(&p.name);
            if !known {
                let fault = Diagnostic::new(Code::UnknownField, format!("unknown field `{}`", p.name));
                let fault = fault.at(p.span, "not a field of this object");
                self.reading.push(match crate::diag::nearest(p.name, fields.iter().copied()) {
                    Some(name) => fault.help(format!("did you mean `{name}`?")),
                    None => {
                        fault.note(format!("the fields here are {}", alternatives(fields).replace(" or ", " and ")))
                    }
                });
            }
            known
        });
        let mut left_out = Vec::new();
        properties.retain(|p| {
            let failed = self.reading.failed.borrow().contains(&p.property.name.start());
            if failed {
                left_out.push(p.name);
            }
            !failed
        });
        let entries = Entries { rest: properties.into_iter(), value: None, node: self, is_struct: true };
        match visitor.visit_map(entries) {
            Ok(_) if !left_out.is_empty() => Err(Error::TOLD),
            Err(Error::Missing(field)) if left_out.contains(&field) => Err(Error::TOLD),
            Err(Error::Missing(field)) => Err(Error::Faults(vec![self.missing(field)])),
            result => result,
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        if let Some(expected) = name.strip_prefix(KIND) {
            let kind = match self.value {
                Value::StringLit(_) => "string",
                Value::NumberLit(n) if !variants.contains(&"number") || is_integer(n.value) => "integer",
                Value::NumberLit(_) => "number",
                Value::BooleanLit(_) => "boolean",
                Value::Object(_) => "object",
                Value::Array(_) => "array",
                Value::NullKeyword(_) => "null",
            };
            if kind == "integer" {
                self.integer(expected)?;
            }
            return match variants.contains(&kind) {
                true => visitor.visit_enum(Variant { name: kind, node: self }),
                false => Err(self.wrong_type(expected)),
            };
        }
        match self.value {
            Value::StringLit(s) => match variants.iter().find(|&&v| v == s.value) {
                Some(&name) => visitor.visit_enum(Variant { name, node: self }),
                None => Err(self.unknown_word(&s.value, variants)),
            },
            _ => Err(self.wrong_type(&alternatives(variants))),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    serde::forward_to_deserialize_any! { i128 u128 }
}
