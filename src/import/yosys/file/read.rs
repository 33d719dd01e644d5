//! How the types of the file are read, object by object.

use std::borrow::Cow;
use std::fmt;

use serde::de::{self, DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::super::fields::{Fields, List, Object, Text};
use super::{Bit, Cell, Declared, File, Module, Net, Port, Range, Setting, Term, Terms};

impl<'de> Fields<'de> for &mut File<'de> {
    const WHAT: &'static str = "an object with `modules`";

    fn field<A: MapAccess<'de>>(&mut self, key: &str, _: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        match key {
            "creator" => self.creator = Some(map.next_value::<Text>()?.0),
            "modules" => map.next_value_seed(Object(Modules(self)))?,
            _ => _ = map.next_value::<IgnoredAny>()?,
        }
        Ok(())
    }
}

struct Modules<'f, 'de>(&'f mut File<'de>);

impl<'de> Fields<'de> for Modules<'_, 'de> {
    const WHAT: &'static str = "an object of modules";

    fn field<A: MapAccess<'de>>(&mut self, _: &str, name: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        if self.0.modules.iter().any(|m| m.name == name) {
            return Err(de::Error::custom(format_args!("the module `{name}` is there twice")));
        }
        let mut module = Module { name, ..Module::default() };
        map.next_value_seed(Object(InModule { module: &mut module, terms: &mut self.0.terms }))?;
        self.0.modules.push(module);
        Ok(())
    }
}

struct InModule<'f, 'de> {
    module: &'f mut Module<'de>,
    terms: &'f mut Terms<'de>,
}

impl<'de> InModule<'_, 'de> {
    fn range<T>(list: &[T], start: usize) -> Range {
        Range { start: start as u32, end: list.len() as u32 }
    }

    fn bits<A: MapAccess<'de>>(&mut self, map: &mut A) -> Result<Range, A::Error> {
        let start = self.module.bits.len();
        map.next_value_seed(List(Bits(self.module)))?;
        if u32::try_from(self.module.bits.len()).is_err() {
            return Err(de::Error::custom("a module of 2^32 bits"));
        }
        Ok(InModule::range(&self.module.bits, start))
    }

    fn attributes<A: MapAccess<'de>>(&mut self, map: &mut A) -> Result<Attributes, A::Error> {
        let mut attributes = Attributes::default();
        map.next_value_seed(Object(InAttributes { to: &mut attributes, terms: self.terms }))?;
        Ok(attributes)
    }
}

impl<'de> Fields<'de> for InModule<'_, 'de> {
    const WHAT: &'static str = "a module";

    fn field<A: MapAccess<'de>>(&mut self, key: &str, _: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        match key {
            "attributes" => {
                let attributes = self.attributes(map)?;
                self.module.top = attributes.top;
                self.module.black_box = attributes.black_box;
                self.module.source = attributes.source;
                self.module.own = attributes.own;
                self.module.circuit = attributes.circuit;
            }
            "parameter_default_values" => {
                let mut list = Vec::new();
                map.next_value_seed(Object(Settings { to: &mut list, terms: self.terms }))?;
                self.module.defaults = list;
            }
            "ports" => map.next_value_seed(Object(Ports(self)))?,
            "cells" => map.next_value_seed(Object(Cells(self)))?,
            "memories" => map.next_value_seed(Object(Memories(self.module)))?,
            "netnames" => map.next_value_seed(Object(Nets(self)))?,
            _ => _ = map.next_value::<IgnoredAny>()?,
        }
        Ok(())
    }
}

#[derive(Default)]
struct Attributes {
    source: Option<Term>,
    path: Option<Term>,
    init: Option<Setting>,
    top: bool,
    black_box: bool,
    own: Option<Term>,
    circuit: [Option<Term>; 3],
    values: Vec<(Term, Term)>,
}

struct InAttributes<'f, 'de> {
    to: &'f mut Attributes,
    terms: &'f mut Terms<'de>,
}

impl<'de> Fields<'de> for InAttributes<'_, 'de> {
    const WHAT: &'static str = "an object of attributes";

    fn field<A: MapAccess<'de>>(&mut self, key: &str, _: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        if let Some(bits) = key.strip_prefix("enum_value_") {
            let bits = self.terms.add(Cow::Owned(bits.to_owned()));
            if let Setting::Text(name) = map.next_value_seed(OneSetting(self.terms))? {
                self.to.values.push((bits, name));
            }
            return Ok(());
        }
        if !matches!(key, "src" | "hdlname" | "init" | "top" | "blackbox") && !key.starts_with("discreta") {
            map.next_value::<IgnoredAny>()?;
            return Ok(());
        }
        let setting = map.next_value_seed(OneSetting(self.terms))?;
        let is_set = |terms: &Terms| match setting {
            Setting::Number(n) => n != 0,
            Setting::Text(term) => terms.text(term).contains('1'),
        };
        match (key, setting) {
            ("src", Setting::Text(term)) => self.to.source = Some(term),
            ("hdlname", Setting::Text(term)) => self.to.path = Some(term),
            ("init", _) => self.to.init = Some(setting),
            ("top", _) => self.to.top = is_set(self.terms),
            ("blackbox", _) => self.to.black_box = is_set(self.terms),
            ("discreta", Setting::Text(term)) => self.to.own = Some(term),
            ("discreta_timescale", Setting::Text(term)) => self.to.circuit[0] = Some(term),
            ("discreta_parameters", Setting::Text(term)) => self.to.circuit[1] = Some(term),
            ("discreta_simulation", Setting::Text(term)) => self.to.circuit[2] = Some(term),
            _ => {}
        }
        Ok(())
    }
}

struct Settings<'f, 'de> {
    to: &'f mut Vec<(Term, Setting)>,
    terms: &'f mut Terms<'de>,
}

impl<'de> Fields<'de> for Settings<'_, 'de> {
    const WHAT: &'static str = "an object of parameters";

    fn field<A: MapAccess<'de>>(&mut self, _: &str, name: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        let name = self.terms.add(name);
        let setting = map.next_value_seed(OneSetting(self.terms))?;
        self.to.push((name, setting));
        Ok(())
    }
}

struct OneSetting<'f, 'de>(&'f mut Terms<'de>);

impl<'de> DeserializeSeed<'de> for OneSetting<'_, 'de> {
    type Value = Setting;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Setting, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for OneSetting<'_, 'de> {
    type Value = Setting;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a string or an integer")
    }

    fn visit_borrowed_str<E>(self, text: &'de str) -> Result<Setting, E> {
        Ok(Setting::Text(self.0.add(Cow::Borrowed(text))))
    }

    fn visit_str<E>(self, text: &str) -> Result<Setting, E> {
        Ok(Setting::Text(self.0.add(Cow::Owned(text.to_owned()))))
    }

    fn visit_i64<E>(self, n: i64) -> Result<Setting, E> {
        Ok(Setting::Number(n))
    }

    fn visit_u64<E: de::Error>(self, n: u64) -> Result<Setting, E> {
        i64::try_from(n).map(Setting::Number).map_err(|_| E::custom("the number is too large"))
    }
}

struct Bits<'f, 'de>(&'f mut Module<'de>);

impl<'de> Visitor<'de> for Bits<'_, 'de> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of bits: numbers, \"0\", \"1\", \"x\", \"z\"")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        while let Some(bit) = seq.next_element::<Bit>()? {
            if let Some(number) = bit.number() {
                self.0.bit_end = self.0.bit_end.max(number + 1);
            }
            self.0.bits.push(bit);
        }
        Ok(())
    }
}

impl<'de> de::Deserialize<'de> for Bit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Bit, D::Error> {
        struct OneBit;
        impl Visitor<'_> for OneBit {
            type Value = Bit;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a bit: a number, \"0\", \"1\", \"x\" or \"z\"")
            }
            fn visit_u64<E: de::Error>(self, n: u64) -> Result<Bit, E> {
                let n = u32::try_from(n).ok().filter(|&n| n < Bit::FIRST_CONSTANT);
                n.map(Bit).ok_or_else(|| E::custom("a bit has a number below 2^32 - 4"))
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Bit, E> {
                let constant = ["0", "1", "x", "z"].iter().position(|c| *c == text);
                let constant = constant.ok_or_else(|| E::invalid_value(de::Unexpected::Str(text), &self))?;
                Ok(Bit(Bit::FIRST_CONSTANT + constant as u32))
            }
        }
        deserializer.deserialize_any(OneBit)
    }
}

struct Ports<'f, 'm, 'de>(&'f mut InModule<'m, 'de>);

impl<'de> Fields<'de> for Ports<'_, '_, 'de> {
    const WHAT: &'static str = "an object of ports";

    fn field<A: MapAccess<'de>>(&mut self, _: &str, name: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        let bits = Range::default();
        let port = Port { name, direction: None, bits, has_bits: false, signed: false, offset: 0, upto: false };
        let mut port = InPort(self.0, port);
        map.next_value_seed(Object(&mut port))?;
        let port = port.1;
        self.0.module.ports.push(port);
        Ok(())
    }
}

struct InPort<'f, 'm, 'de>(&'f mut InModule<'m, 'de>, Port<'de>);

impl<'de> Fields<'de> for &mut InPort<'_, '_, 'de> {
    const WHAT: &'static str = "a port";

    fn field<A: MapAccess<'de>>(&mut self, key: &str, _: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        match key {
            "direction" => self.1.direction = Some(self.0.terms.add(map.next_value::<Text>()?.0)),
            "bits" => {
                self.1.bits = self.0.bits(map)?;
                self.1.has_bits = true;
            }
            "signed" => self.1.signed = map.next_value::<i64>()? != 0,
            "offset" => self.1.offset = map.next_value()?,
            "upto" => self.1.upto = map.next_value::<i64>()? != 0,
            _ => _ = map.next_value::<IgnoredAny>()?,
        }
        Ok(())
    }
}

struct Cells<'f, 'm, 'de>(&'f mut InModule<'m, 'de>);

impl<'de> Fields<'de> for Cells<'_, '_, 'de> {
    const WHAT: &'static str = "an object of cells";

    fn field<A: MapAccess<'de>>(&mut self, _: &str, name: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        let mut cell = InCell {
            inside: self.0,
            kind: None,
            hidden: false,
            source: None,
            path: None,
            own: None,
            ranges: Default::default(),
        };
        map.next_value_seed(Object(&mut cell))?;
        let InCell { kind, hidden, source, path, own, ranges: [parameters, connections], .. } = cell;
        let kind = kind.ok_or_else(|| de::Error::custom(format_args!("the cell `{name}` has no `type`")))?;
        self.0.module.cells.push(Cell { name, kind, hidden, source, path, own, parameters, connections });
        Ok(())
    }
}

struct InCell<'f, 'm, 'de> {
    inside: &'f mut InModule<'m, 'de>,
    kind: Option<Term>,
    hidden: bool,
    source: Option<Term>,
    path: Option<Term>,
    own: Option<Term>,
    ranges: [Range; 2],
}

impl<'de> Fields<'de> for &mut InCell<'_, '_, 'de> {
    const WHAT: &'static str = "a cell";

    fn field<A: MapAccess<'de>>(&mut self, key: &str, _: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        match key {
            "hide_name" => self.hidden = map.next_value::<i64>()? != 0,
            "type" => self.kind = Some(self.inside.terms.add(map.next_value::<Text>()?.0)),
            "attributes" => {
                let attributes = self.inside.attributes(map)?;
                (self.source, self.path, self.own) = (attributes.source, attributes.path, attributes.own);
            }
            "parameters" => {
                let InModule { module, terms } = &mut *self.inside;
                let start = module.parameters.len();
                map.next_value_seed(Object(Settings { to: &mut module.parameters, terms }))?;
                self.ranges[0] = InModule::range(&module.parameters, start);
            }
            "connections" => {
                let start = self.inside.module.connections.len();
                map.next_value_seed(Object(Connections(self.inside)))?;
                self.ranges[1] = InModule::range(&self.inside.module.connections, start);
            }
            _ => _ = map.next_value::<IgnoredAny>()?,
        }
        Ok(())
    }
}

struct Connections<'f, 'm, 'de>(&'f mut InModule<'m, 'de>);

impl<'de> Fields<'de> for Connections<'_, '_, 'de> {
    const WHAT: &'static str = "an object of connections";

    fn field<A: MapAccess<'de>>(&mut self, _: &str, name: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        let name = self.0.terms.add(name);
        let bits = self.0.bits(map)?;
        self.0.module.connections.push((name, bits));
        Ok(())
    }
}

struct Memories<'f, 'de>(&'f mut Module<'de>);

impl<'de> Fields<'de> for Memories<'_, 'de> {
    const WHAT: &'static str = "an object of memories";

    fn field<A: MapAccess<'de>>(&mut self, _: &str, name: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        let mut memory = Declared { name, width: 0, size: 0, offset: 0 };
        map.next_value_seed(Object(&mut memory))?;
        self.0.memories.push(memory);
        Ok(())
    }
}

impl<'de> Fields<'de> for &mut Declared<'de> {
    const WHAT: &'static str = "a memory";

    fn field<A: MapAccess<'de>>(&mut self, key: &str, _: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        match key {
            "width" => self.width = map.next_value()?,
            "size" => self.size = map.next_value()?,
            "start_offset" => self.offset = map.next_value()?,
            _ => _ = map.next_value::<IgnoredAny>()?,
        }
        Ok(())
    }
}

struct Nets<'f, 'm, 'de>(&'f mut InModule<'m, 'de>);

impl<'de> Fields<'de> for Nets<'_, '_, 'de> {
    const WHAT: &'static str = "an object of nets";

    fn field<A: MapAccess<'de>>(&mut self, _: &str, name: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        let net = Net {
            name,
            bits: Range::default(),
            hidden: false,
            signed: false,
            offset: 0,
            upto: false,
            init: None,
            path: None,
            source: None,
            values: Vec::new(),
        };
        let mut net = InNet(self.0, net);
        map.next_value_seed(Object(&mut net))?;
        let net = net.1;
        self.0.module.nets.push(net);
        Ok(())
    }
}

struct InNet<'f, 'm, 'de>(&'f mut InModule<'m, 'de>, Net<'de>);

impl<'de> Fields<'de> for &mut InNet<'_, '_, 'de> {
    const WHAT: &'static str = "a net";

    fn field<A: MapAccess<'de>>(&mut self, key: &str, _: Cow<'de, str>, map: &mut A) -> Result<(), A::Error> {
        match key {
            "hide_name" => self.1.hidden = map.next_value::<i64>()? != 0,
            "bits" => self.1.bits = self.0.bits(map)?,
            "signed" => self.1.signed = map.next_value::<i64>()? != 0,
            "offset" => self.1.offset = map.next_value()?,
            "upto" => self.1.upto = map.next_value::<i64>()? != 0,
            "attributes" => {
                let attributes = self.0.attributes(map)?;
                self.1.init = attributes.init;
                self.1.path = attributes.path;
                self.1.source = attributes.source;
                self.1.values = attributes.values;
            }
            _ => _ = map.next_value::<IgnoredAny>()?,
        }
        Ok(())
    }
}
