//! Tests of reading circuit files.

use proptest::prelude::*;

use super::{CircuitFile, Direction, Module, Signal};
use crate::diag::{Diagnostics, Sources};

fn read(text: &str) -> (Option<CircuitFile>, Vec<String>) {
    let mut sources = Sources::new();
    let file = sources.add("t.json", text.to_owned());
    let mut diagnostics = Diagnostics::new();
    let circuit = CircuitFile::parse(&sources, file, &mut diagnostics);
    diagnostics.sort();
    let told = diagnostics.iter().map(|d| {
        let span = d.place().unwrap();
        assert!(span.start <= span.end && span.end as usize <= text.len());
        assert!(d.render(&sources, false).contains(&d.code.to_string()));
        format!("{} at {}: {}", d.code, sources.slice(span), d.message)
    });
    let told = told.collect();
    (circuit, told)
}

fn module(inside: &str) -> (Module, Vec<String>) {
    let (circuit, told) = read(&format!("{{\"modules\": {{\"m\": {{ {inside} }}}}}}"));
    (circuit.and_then(|mut c| c.modules.swap_remove("m")).and_then(|m| m.0).unwrap_or_default(), told)
}

#[test]
fn the_example_of_the_documentation() {
    let page = include_str!("../../docs/format.md");
    let text = page.split("```json\n").nth(1).unwrap().split("```").next().unwrap();
    let (circuit, told) = read(text);
    assert_eq!(told, [""; 0]);
    let circuit = circuit.unwrap();
    assert_eq!(circuit.timescale.unwrap().0.to_string(), "1ns");
    assert_eq!(circuit.import[0].value, "../lib/arithmetic.json");
    let line = circuit.modules["line"].as_ref().unwrap();
    let ports: Vec<&str> = line.ports.keys().map(|k| k.value.as_str()).collect();
    assert_eq!(ports, ["dt", "dx", "x"], "in the order of the file");
    assert_eq!(line.ports["x"].as_ref().unwrap().direction.value, Direction::Output);
    assert_eq!(line.parameters["W"].as_ref().unwrap().max.as_ref().unwrap().as_number(), Some(32));
    assert_eq!(line.nets["sum"].as_ref().unwrap().width.as_ref().unwrap().text(), "W+1");
    assert!(line.nets["f"].as_ref().unwrap().signed);
    let and1 = line.cells["and1"].as_ref().unwrap();
    assert_eq!(and1.kind.value, "and");
    assert_eq!(and1.parameters["width"].expr().unwrap().text(), "W+1");
    assert!(matches!(&and1.connections["in"], Signal::Concat { parts, .. } if parts.len() == 2));
    let fa = line.cells["fa"].as_ref().unwrap().repeat.as_ref().unwrap();
    assert_eq!((fa.index.value.as_str(), fa.from.is_some(), fa.to.text()), ("i", false, "W"));
    let stage = line.blocks["stage"].as_ref().unwrap();
    assert_eq!(stage.condition.as_ref().unwrap().text(), "W > 1");
}

#[test]
fn short_and_long_forms() {
    let (m, told) = module(
        r#""parameters": { "A": 8, "B": "A*2", "C": { "default": 1, "min": 0 } },
           "nets": { "n": 1, "w": "A+1", "o": {} },
           "cells": { "c": { "type": "dff", "parameters": { "edge": "falling", "init": -1 } } },
           "blocks": { "b": { "repeat": { "i": [1, "A"] } } }"#,
    );
    assert_eq!(told, [""; 0]);
    assert_eq!(m.parameters["B"].as_ref().unwrap().default.text(), "A*2");
    assert_eq!(m.parameters["C"].as_ref().unwrap().min.as_ref().unwrap().as_number(), Some(0));
    assert!(m.nets["o"].as_ref().unwrap().width.is_none());
    let parameters = &m.cells["c"].as_ref().unwrap().parameters;
    assert_eq!(parameters["edge"].word(), Some("falling"));
    assert_eq!(parameters["init"].expr().unwrap().as_number(), Some(-1));
    let repeat = m.blocks["b"].as_ref().unwrap().repeat.as_ref().unwrap();
    assert_eq!((repeat.from.as_ref().unwrap().text(), repeat.to.text()), ("1", "A"));
}

#[test]
fn faults_of_many_parts_at_once() {
    let (m, told) = module(
        r#""parameters": { "A": [], "B": { "min": 1 }, "C": "1 +" },
           "ports": { "p": { "direction": "in" }, "q": { "width": 1 } },
           "nets": { "1n": 1, "n": true, "e": "" , "": 1 },
           "cells": {
             "c": { "type": "and", "parmeters": {}, "connections": { "a": "n[", "b": {}, "y": ["n", "~n"] } },
             "d": { "connections": { "a": "4'b2" }, "repeat": { "i": 1, "j": 2 } },
             "e": { "type": "and", "repeat": {} },
             "f": { "type": "and", "repeat": { "i-": [1] }, "if": "a b" },
             "g": { "type": "and", "parameters": { "width": true } }
           },
           "blocks": { "b": { "blocks": { "c": { "nets": { "n!": 1 }, "port": {} } } } }"#,
    );
    let expected = [
        "wrong-type at []: `A` must be an integer, an expression or an object",
        "missing-field at B: `B` has no field `default`",
        "bad-expression at : an expression ends too early",
        "bad-value at in: `direction` must be `input`, `output` or `inout`",
        "missing-field at q: `q` has no field `direction`",
        "bad-name at 1n: `1n` cannot be the name of a net",
        "wrong-type at true: `n` must be a width (an integer or an expression) or an object",
        "bad-expression at \"\": an expression is missing",
        "bad-name at \"\": a net has an empty name",
        "unknown-field at parmeters: unknown field `parmeters`",
        "bad-signal at : an expression ends too early",
        "wrong-type at {}: `b` must be a signal (a string, an integer or an array)",
        "bad-signal at ~: a signal begins with a name, a number or `(`",
        "missing-field at d: `d` has no field `type`",
        "bad-signal at 2: `2` is not a digit of this base",
        "bad-repeat at j: a `repeat` names one index only",
        "bad-repeat at {}: a `repeat` names no index",
        "bad-repeat at [1]: a range is [from, to]",
        "bad-expression at b: expected an operator or the end of the expression",
        "wrong-type at true: `width` must be an integer, an expression, a word or an array",
        "bad-name at n!: `n!` cannot be the name of a net",
        "unknown-field at port: unknown field `port`",
    ];
    for (told, expected) in told.iter().zip(expected) {
        assert_eq!(told, expected);
    }
    assert_eq!(told.len(), expected.len());
    assert!(m.cells["e"].as_ref().is_none());
    assert!(m.blocks["b"].as_ref().unwrap().blocks["c"].as_ref().is_some());
}

#[test]
fn places_inside_of_strings_with_escapes() {
    let (_, told) = module(r#""nets": { "a": "1 + *", "b": "1\u0020+ *" }"#);
    assert_eq!(
        told,
        ["bad-expression at *: unexpected `*`", "bad-expression at 1\\u0020+ *: unexpected `*`"],
        "written with escapes, the whole string is pointed at"
    );
}

proptest! {
    /// A circuit, damaged at random, is read without panic, and every place lies in it.
    #[test]
    fn damaged_circuits(cuts in prop::collection::vec((0.0..1.0f64, 0usize..4, "[\\[\\]{}:,\"'0-9a-z$é.~+ \n-]{0,3}"), 1..4)) {
        let page = include_str!("../../docs/format.md");
        let mut text = page.split("```json\n").nth(1).unwrap().split("```").next().unwrap().to_owned();
        for (at, length, insert) in cuts {
            let start = text.floor_char_boundary((at * text.len() as f64) as usize);
            let end = text.ceil_char_boundary((start + length).min(text.len()));
            text.replace_range(start..end, &insert);
        }
        read(&text);
    }
}
