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
use serde::de::value::SeqDeserializer;
use serde::de::{
    self, Deserialize, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess,
    SeqAccess, VariantAccess, Visitor,
};

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
struct Reading<'a> {
    file: FileId,
    diagnostics: RefCell<&'a mut Diagnostics>,
    /// What has been told: a part may be read several times.
    told: RefCell<HashSet<(Code, Option<Span>)>>,
    /// Fields of structs (by the offset of their name) whose values are faulty. They are left out when the struct is
    /// read again for the faults of its other fields.
    failed: RefCell<HashSet<usize>>,
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

    fn tell(&self, error: Error, node: Node<'_>) {
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

struct Property<'a> {
    name: &'a str,
    span: Span,
    property: &'a ObjectProp<'a>,
}

/// A value in the tree, and the key that it stands under.
#[derive(Clone, Copy)]
struct Node<'a> {
    value: &'a Value<'a>,
    key: Option<(&'a str, Span)>,
    reading: &'a Reading<'a>,
}

impl<'a> Node<'a> {
    fn span(&self) -> Span {
        match self.value {
            Value::StringLit(s) => self.reading.inside(s.range),
            value => self.reading.span(value.range()),
        }
    }

    fn under(self, value: &'a Value<'a>, key: Option<(&'a str, Span)>) -> Node<'a> {
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

/// The place, then the part itself: what a `Spanned` reads.
struct Placed<T> {
    part: T,
    span: Option<Span>,
}

impl<'de, T: Deserializer<'de, Error = Error> + Copy> SeqAccess<'de> for Placed<T> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        match self.span.take() {
            Some(s) => seed.deserialize(SeqDeserializer::new([s.file.0, s.start, s.end].into_iter())).map(Some),
            None => seed.deserialize(self.part).map(Some),
        }
    }
}

/// Attempts at one value: what a `Recover` reads. A failed one gives no element, and another one is worth while if it
/// found a faulty field of a struct, which the next one will pass over.
struct Attempts<'a> {
    node: Node<'a>,
    again: bool,
}

impl<'de> SeqAccess<'de> for Attempts<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        let reading = self.node.reading;
        let failed = reading.failed.borrow().len();
        match seed.deserialize(self.node) {
            Ok(value) => Ok(Some(value)),
            Err(error) => {
                reading.tell(error, self.node);
                self.again = reading.failed.borrow().len() > failed;
                Ok(None)
            }
        }
    }

    fn size_hint(&self) -> Option<usize> {
        Some(usize::from(self.again))
    }
}

struct Elements<'a> {
    rest: std::slice::Iter<'a, Value<'a>>,
    array: Node<'a>,
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        let Some(value) = self.rest.next() else { return Ok(None) };
        let node = self.array.under(value, None);
        seed.deserialize(node).map(Some).map_err(|error| {
            node.reading.tell(error, node);
            Error::TOLD
        })
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// The entries of a map or fields of a struct.
struct Entries<'a> {
    rest: std::vec::IntoIter<Property<'a>>,
    value: Option<Property<'a>>,
    node: Node<'a>,
    is_struct: bool,
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        let Some(property) = self.rest.next() else { return Ok(None) };
        let key = Key { name: property.name, span: property.span };
        self.value = Some(property);
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Error> {
        let property = self.value.take().ok_or(Error::TOLD)?;
        let node = self.node.under(&property.property.value, Some((property.name, property.span)));
        seed.deserialize(node).map_err(|error| {
            node.reading.tell(error, node);
            if self.is_struct {
                node.reading.failed.borrow_mut().insert(property.property.name.start());
            }
            Error::TOLD
        })
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// The name of a property.
#[derive(Clone, Copy)]
struct Key<'a> {
    name: &'a str,
    span: Span,
}

impl<'de> Deserializer<'de> for Key<'_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_str(self.name)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, Error> {
        match name {
            SPANNED => visitor.visit_seq(Placed { part: self, span: Some(self.span) }),
            _ => visitor.visit_newtype_struct(self),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

/// A word, or a kind of value together with the value.
struct Variant<'a> {
    name: &'static str,
    node: Node<'a>,
}

impl<'de, 'a> EnumAccess<'de> for Variant<'a> {
    type Error = Error;
    type Variant = Node<'a>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Node<'a>), Error> {
        let name: de::value::StrDeserializer<'_, Error> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self.node))
    }
}

impl<'de> VariantAccess<'de> for Node<'_> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Error> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_seq(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, fields: &'static [&'static str], visitor: V) -> Result<V::Value, Error> {
        self.deserialize_struct("", fields, visitor)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Spanned, fault};
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    struct Thing {
        name: Spanned<String>,
        #[serde(default)]
        count: u8,
        flag: Option<bool>,
        color: Option<Color>,
        #[serde(default)]
        parts: IndexMap<Spanned<String>, Recover<Thing>>,
        #[serde(default, deserialize_with = "every")]
        numbers: Vec<Even>,
        #[serde(default, deserialize_with = "every")]
        table: IndexMap<String, Even>,
        form: Option<Form>,
        #[serde(default, deserialize_with = "or_default")]
        doc: Option<String>,
    }

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Color {
        Red,
        Green,
        Blue,
    }

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(rename = "$discreta::Kind a number or a list", rename_all = "lowercase")]
    enum Form {
        Integer(i64),
        Number(f64),
        Array(Vec<Spanned<i64>>),
    }

    /// A type that reads its own text.
    #[derive(Debug, PartialEq)]
    struct Even(i64);

    impl<'de> Deserialize<'de> for Even {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let number = Spanned::<i64>::deserialize(deserializer)?;
            match number.value % 2 {
                0 => Ok(Even(number.value)),
                _ => Err(fault(Diagnostic::new(Code::BadValue, format!("{number} is odd")).at(number.span, ""))),
            }
        }
    }

    fn read<T: DeserializeOwned>(text: &str) -> (Option<T>, Vec<String>) {
        let mut sources = Sources::new();
        let file = sources.add("t.json", text.to_owned());
        let mut diagnostics = Diagnostics::new();
        let value = parse(&sources, file, &mut diagnostics);
        diagnostics.sort();
        let told = diagnostics.iter().map(|d| {
            let place = d.place().map_or("", |span| sources.slice(span));
            let help = d.helps.first().map_or(String::new(), |h| format!(" ({h})"));
            format!("{} at {place}: {}{help}", d.code, d.message)
        });
        (value, told.collect())
    }

    fn told(text: &str) -> Vec<String> {
        read::<Thing>(text).1
    }

    #[test]
    fn values_and_their_places() {
        let text = r#"{"name": "it", "count": 3, "flag": true, "color": "green", "form": [1, 22],
            "parts": {"b": {"name": "\u00e9"}, "a": {"name": ""}}, "numbers": [2, 4]}"#;
        let (thing, told) = read::<Thing>(text);
        assert_eq!(told, [""; 0]);
        let thing = thing.unwrap();
        let at = |span: Span| &text[span.start as usize..span.end as usize];
        assert_eq!((&*thing.name.value, at(thing.name.span)), ("it", "it"));
        assert_eq!((thing.count, thing.flag, thing.color), (3, Some(true), Some(Color::Green)));
        assert_eq!(thing.numbers, [Even(2), Even(4)]);
        let Some(Form::Array(list)) = thing.form else { panic!() };
        assert_eq!((list[1].value, at(list[1].span)), (22, "22"));
        let (key, b) = thing.parts.get_index(0).unwrap();
        assert_eq!((at(key.span), at(b.as_ref().unwrap().name.span)), ("b", "\\u00e9"));
        assert_eq!(thing.parts.get("a").unwrap().as_ref().unwrap().name.value, "");
        assert_eq!(at(thing.parts.get("a").unwrap().as_ref().unwrap().name.span), "\"\"");
    }

    #[test]
    fn all_faults_are_told_at_once() {
        let text = r#"{
            "name": 1, "count": 300, "flag": "yes", "color": "gren", "colour": 1, "zzz": 2, "flag": true,
            "parts": {
                "a": { "name": "a", "count": "b", "form": "s" },
                "b": { },
                "c": { "name": "c", "numbers": [1, 2, 3, "d"], "parts": { "e": 5, "f": { "name": null } } },
                "a": { "name": [] },
                "g": { "name": "fine" }
            },
            "form": null
        }"#;
        let (thing, told) = read::<Thing>(text);
        assert!(thing.is_none());
        let expected = [
            "wrong-type at 1: `name` must be a string",
            "bad-value at 300: invalid value: integer `300`, expected u8",
            "wrong-type at yes: `flag` must be `true` or `false`",
            "bad-value at gren: `color` must be `red`, `green` or `blue` (did you mean `green`?)",
            "unknown-field at colour: unknown field `colour` (did you mean `color`?)",
            "unknown-field at zzz: unknown field `zzz`",
            "duplicate-key at flag: `flag` is given twice",
            "wrong-type at b: `count` must be an integer",
            "wrong-type at s: `form` must be a number or a list",
            "missing-field at b: `b` has no field `name`",
            "bad-value at 1: 1 is odd",
            "bad-value at 3: 3 is odd",
            "wrong-type at d: expected an integer",
            "wrong-type at 5: `e` must be an object",
            "wrong-type at null: `name` must be a string (leave the field out instead)",
            "duplicate-key at a: `a` is given twice",
            "wrong-type at null: `form` must be a number or a list (leave the field out instead)",
        ];
        assert_eq!(told, expected);
    }

    #[test]
    fn a_faulty_part_leaves_the_others() {
        let text = r#"{"name": "x", "parts": {"a": {"name": 1}, "b": {"name": "y"}}, "table": {"k": 2}}"#;
        let (thing, told) = read::<Thing>(text);
        assert_eq!(told, ["wrong-type at 1: `name` must be a string"]);
        let thing = thing.unwrap();
        assert!(thing.parts["a"].as_ref().is_none());
        assert!(thing.parts["b"].as_ref().is_some());
        assert_eq!(thing.table["k"], Even(2));
    }

    #[test]
    fn every_fault_of_a_table_is_told_before_it_fails() {
        let (thing, told) = read::<Thing>(r#"{"name": "x", "table": {"k": 1, "l": 2, "m": 3}, "count": "c"}"#);
        assert!(thing.is_none());
        assert_eq!(
            told,
            ["bad-value at 1: 1 is odd", "bad-value at 3: 3 is odd", "wrong-type at c: `count` must be an integer"]
        );
    }

    #[test]
    fn a_field_that_does_not_matter() {
        let (thing, told) = read::<Thing>(r#"{"name": "x", "doc": 1, "flag": true}"#);
        assert_eq!(told, ["wrong-type at 1: `doc` must be a string"]);
        let thing = thing.unwrap();
        assert_eq!((thing.doc, thing.flag), (None, Some(true)));
        assert_eq!(read::<Thing>(r#"{"name": "x", "doc": "d"}"#).0.unwrap().doc.unwrap(), "d");
    }

    #[test]
    fn numbers() {
        assert_eq!(told(r#"{"name": "x", "form": 1.5}"#), [""; 0]);
        assert_eq!(told(r#"{"name": "x", "form": -9223372036854775808}"#), [""; 0]);
        assert_eq!(
            told(r#"{"name": "x", "form": 9223372036854775808}"#),
            ["bad-value at 9223372036854775808: a number must fit 64 bits"]
        );
        assert_eq!(told(r#"{"name": "x", "count": 1.0}"#), ["wrong-type at 1.0: `count` must be an integer"]);
        assert_eq!(told(r#"{"name": "x", "count": 1e2}"#), ["wrong-type at 1e2: `count` must be an integer"]);
        assert_eq!(
            told(r#"{"name": "x", "count": -1}"#),
            ["bad-value at -1: invalid value: integer `-1`, expected u8"]
        );
    }

    #[test]
    fn duplicate_keys_of_small_and_large_objects() {
        for size in [2, 12, 13, 1000] {
            let table: Vec<String> = (0..size).map(|n| format!("\"k{}\": 2", n % (size - 1))).collect();
            let text = format!("{{\"name\": \"x\", \"table\": {{{}}}}}", table.join(","));
            assert_eq!(told(&text), ["duplicate-key at k0: `k0` is given twice"], "{size}");
        }
    }

    #[test]
    fn the_root() {
        assert_eq!(told("[]"), ["wrong-type at []: expected an object"]);
        assert_eq!(told("{}"), ["missing-field at {: the field `name` is missing"]);
        assert_eq!(told(r#"{"name": }"#), ["json-syntax at }: unexpected close brace"]);
    }

    /// Reading again for further faults must not multiply with the depth, nor with the number of faulty parts.
    #[test]
    fn the_work_is_bounded_by_the_size() {
        let mut deep = String::from("{\"count\": \"x\"}");
        for _ in 0..60 {
            deep = format!("{{\"parts\": {{\"p\": {deep}}}, \"count\": \"x\", \"flag\": 1, \"form\": null}}");
        }
        assert_eq!(told(&deep).len(), 4 * 60 + 2);
        let parts: Vec<String> = (0..50_000).map(|n| format!("\"p{n}\": {{\"count\": null, \"flag\": 0}}")).collect();
        let table: Vec<String> = (0..50_000).map(|n| format!("\"p{n}\": {}", 2 * n + 1)).collect();
        let wide = format!("{{\"parts\": {{{}}}, \"table\": {{{}}}}}", parts.join(","), table.join(","));
        assert_eq!(told(&wide).len(), 10_000);
    }
}
