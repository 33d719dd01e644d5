//! What the deserializer hands to visitors: the parts of lists, objects, places and variants.

use jsonc_parser::ast::Value;
use jsonc_parser::common::Ranged;
use serde::de::value::{SeqDeserializer, StrDeserializer};
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, VariantAccess, Visitor,
};

use super::de::{Node, Property};
use super::fault::Error;
use super::spanned::SPANNED;
use crate::diag::Span;

/// The place, then the part itself: what a `Spanned` reads.
pub(super) struct Placed<T> {
    pub(super) part: T,
    pub(super) span: Option<Span>,
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
pub(super) struct Attempts<'a> {
    pub(super) node: Node<'a>,
    pub(super) again: bool,
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

pub(super) struct Elements<'a> {
    pub(super) rest: std::slice::Iter<'a, Value<'a>>,
    pub(super) array: Node<'a>,
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
pub(super) struct Entries<'a> {
    pub(super) rest: std::vec::IntoIter<Property<'a>>,
    pub(super) value: Option<Property<'a>>,
    pub(super) node: Node<'a>,
    pub(super) is_struct: bool,
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
pub(super) struct Variant<'a> {
    pub(super) name: &'static str,
    pub(super) node: Node<'a>,
}

impl<'de, 'a> EnumAccess<'de> for Variant<'a> {
    type Error = Error;
    type Variant = Node<'a>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Node<'a>), Error> {
        let name: StrDeserializer<'_, Error> = self.name.into_deserializer();
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
