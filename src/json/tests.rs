//! Tests of the deserializer.

use indexmap::IndexMap;
use serde::de::{Deserialize, DeserializeOwned, Deserializer};

use super::{Recover, Spanned, every, fault, or_default, parse};
use crate::diag::{Code, Diagnostic, Diagnostics, Sources, Span};

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
    assert_eq!(told(r#"{"name": "x", "count": -1}"#), ["bad-value at -1: invalid value: integer `-1`, expected u8"]);
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
