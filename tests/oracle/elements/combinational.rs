//! Elements without state, against Verilog operators and primitives.
//!
//! One operator is spelt out: for an unknown condition `a ? b : c` gives x for a z on both sides by table 5-21 of
//! IEEE 1364-2005, and so do the elements; Icarus gives z.

use needs::needs;
use serde_json::json;

use super::icarus::{Case, compare};

const WIDTHS: &[u32] = &[1, 2, 8, 63, 64, 65, 100, 129];

fn gates() -> Vec<Case> {
    let mut cases = Vec::new();
    let several = [
        ("and", "&", ""),
        ("or", "|", ""),
        ("xor", "^", ""),
        ("nand", "&", "~"),
        ("nor", "|", "~"),
        ("xnor", "^", "~"),
    ];
    for (element, operator, invert) in several {
        for &width in WIDTHS {
            for fan_in in [2, 3, 5] {
                let operands: Vec<String> = (0..fan_in).map(|k| format!("in{k}")).collect();
                let y = format!("wire [{width}-1:0] y = {invert}({});", operands.join(operator));
                let inputs = vec![("in", width); fan_in];
                cases.push(Case::new(element, &inputs, &[("y", width)], &y).parameter("width", width));
            }
        }
        // 70 inputs of one bit are more than a word
        let operands: Vec<String> = (0..70).map(|k| format!("in{k}")).collect();
        let y = format!("wire y = {invert}({operator}{{{}}});", operands.join(","));
        cases.push(Case::new(element, &[("in", 1); 70], &[("y", 1)], &y));
    }
    for element in ["buf", "not"] {
        for &width in WIDTHS {
            let y = format!("wire [{width}-1:0] y; {element} gate [{width}-1:0] (y, a);");
            cases.push(Case::new(element, &[("a", width)], &[("y", width)], &y).parameter("width", width));
        }
    }
    for &width in WIDTHS {
        let inputs = [("a", width), ("b", width), ("c", width)];
        let y = format!("wire [{width}-1:0] y = (a & b) | (a & c) | (b & c);");
        cases.push(Case::new("majority", &inputs, &[("y", width)], &y).parameter("width", width));
        cases.push(Case::new("is_zero", &[("a", width)], &[("y", 1)], "wire y = ~|a;").parameter("width", width));
        for fan_in in [1, 2, 4] {
            let terms: Vec<String> = (0..fan_in).map(|k| format!("(in{k} & {{{width}{{sel[{k}]}}}})")).collect();
            let y = format!("wire [{width}-1:0] y = {};", terms.join(" | "));
            let mut inputs = vec![("in", width); fan_in];
            inputs.push(("sel", fan_in as u32));
            cases.push(Case::new("and_or", &inputs, &[("y", width)], &y).parameter("width", width));
        }
    }
    cases
}

/// A tree of `?:` over the bits of the select, x beyond the last input.
fn mux_tree(width: u32, inputs: u32, base: u32, bits: u32) -> String {
    if bits == 0 {
        return if base < inputs { format!("in{base}") } else { format!("{{{width}{{1'bx}}}}") };
    }
    let half = base + (1 << (bits - 1));
    let (low, high) = (mux_tree(width, inputs, base, bits - 1), mux_tree(width, inputs, half, bits - 1));
    conditional(&format!("s[{}]", bits - 1), &high, &low, width)
}

/// `s ? high : low`, with table 5-21 in AND and OR: 0 and 0 give 0, 1 and 1 give 1, all else x.
fn conditional(s: &str, high: &str, low: &str, width: u32) -> String {
    let agreed = format!("({low} & {high}) | (({low} | {high}) & {{{width}{{1'bx}}}})");
    format!("({s} === 1'b1 ? {high} : {s} === 1'b0 ? {low} : {agreed})")
}

fn selection() -> Vec<Case> {
    let mut cases = Vec::new();
    for &width in WIDTHS {
        for (inputs, select) in [(2, 1), (3, 2), (4, 2), (5, 3), (8, 3)] {
            let y = format!("wire [{width}-1:0] y = {};", mux_tree(width, inputs, 0, select));
            let mut ports = vec![("in", width); inputs as usize];
            ports.push(("s", select));
            cases.push(Case::new("mux", &ports, &[("y", width)], &y).parameter("width", width));
        }
        for (element, operator) in [("eq", "=="), ("ne", "!="), ("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">=")] {
            for signed in [0, 1] {
                let y = match signed {
                    0 => format!("wire y = a {operator} b;"),
                    _ => format!("wire y = $signed(a) {operator} $signed(b);"),
                };
                let case = Case::new(element, &[("a", width), ("b", width)], &[("y", 1)], &y);
                cases.push(case.parameter("width", width).parameter("signed", signed));
            }
        }
        let y = format!("wire [{width}-1:0] y = {};", conditional("en", "a", &format!("{{{width}{{1'bz}}}}"), width));
        cases.push(Case::new("tristate", &[("a", width), ("en", 1)], &[("y", width)], &y).parameter("width", width));
    }
    cases
}

/// Three tri-state buffers on one net, over all of it and over its ends.
fn buses() -> Vec<Case> {
    let mut cases = Vec::new();
    for &w in &WIDTHS[1..] {
        let half = w / 2;
        let inputs = [("a", w), ("b", half), ("c", w - half), ("en_a", 1), ("en_b", 1), ("en_c", 1)];
        let driver = |name: &str, part: &str, width: u32| {
            let y = conditional(&format!("en_{name}"), name, &format!("{{{width}{{1'bz}}}}"), width);
            format!("assign {part} = {y};\n  ")
        };
        let (low, high) = (format!("y[{}:0]", half - 1), format!("y[{}:{half}]", w - 1));
        let model = format!("wire [{w}-1:0] y;\n  ")
            + &driver("a", "y", w)
            + &driver("b", &low, half)
            + &driver("c", &high, w - half);
        let cell = |name: &str, part: &str, width: u32| {
            json!({ "type": "tristate", "parameters": { "width": width },
                    "connections": { "a": name, "en": format!("en_{name}"), "y": part } })
        };
        let mut case = Case::new("tristate", &inputs, &[("y", w)], &model);
        case.cells =
            Some(json!({ "a": cell("a", "y", w), "b": cell("b", &low, half), "c": cell("c", &high, w - half) }));
        cases.push(case);
    }
    cases
}

fn arithmetic() -> Vec<Case> {
    let mut cases = vec![
        Case::new("half_adder", &[("a", 1), ("b", 1)], &[("s", 1), ("co", 1)], "wire s = a ^ b, co = a & b;"),
        Case::new(
            "full_adder",
            &[("a", 1), ("b", 1), ("ci", 1)],
            &[("s", 1), ("co", 1)],
            "wire s = a ^ b ^ ci, co = (a & b) | ((a ^ b) & ci);",
        ),
    ];
    for &width in WIDTHS {
        let operands = [("a", width), ("b", width)];
        let with = |pins: &[(&'static str, u32)]| [&operands[..], pins].concat();
        let add = format!("wire [{width}-1:0] y; wire co; assign {{co, y}} = a + b + ci;");
        let sub = format!("wire [{width}-1:0] y; wire bo; assign {{bo, y}} = {{1'b0, a}} - {{1'b0, b}} - bi;");
        let either = format!(
            "wire [{width}-1:0] y; wire co;
  assign {{co, y}} = sub === 1'b0 ? a + b + ci : sub === 1'b1 ? {{1'b0, a}} - {{1'b0, b}} - ci : {{{}{{1'bx}}}};",
            width + 1
        );
        for (element, pins, carry, model) in [
            ("adder", &[("ci", 1)][..], "co", &add),
            ("subtractor", &[("bi", 1)], "bo", &sub),
            ("add_sub", &[("ci", 1), ("sub", 1)], "co", &either),
        ] {
            let case = Case::new(element, &with(pins), &[("y", width), (carry, 1)], model);
            cases.push(case.parameter("width", width));
        }
    }
    for (a, b) in [(1, 1), (1, 8), (8, 1), (4, 8), (32, 32), (63, 65), (64, 64), (65, 64), (100, 31)] {
        for signed in [0, 1] {
            let (width, sign) = (a + b, if signed == 1 { "signed" } else { "unsigned" });
            let y = format!("wire [{width}-1:0] y = ${sign}(a) * ${sign}(b);");
            let case = Case::new("multiplier", &[("a", a), ("b", b)], &[("y", width)], &y);
            cases.push(case.parameter("a_width", a).parameter("b_width", b).parameter("signed", signed));
        }
    }
    cases
}

fn constants() -> Vec<Case> {
    let literals = [(1, "1'b0"), (4, "4'b10x1"), (65, "65'h1_2345_6789_abcd_efxz"), (8, "8'd200"), (100, "100'bz")];
    let case = |(width, text): &(u32, &str)| {
        let y = format!("wire [{width}-1:0] y = {text};");
        Case::new("constant", &[], &[("y", *width)], &y).parameter("width", width).parameter("value", text)
    };
    literals.iter().map(case).collect()
}

pub fn cases() -> impl Iterator<Item = Case> {
    [gates(), selection(), arithmetic(), constants()].into_iter().flatten()
}

#[needs(iverilog)]
#[test]
fn gates_do_what_verilog_operators_do() {
    compare("gates", &gates());
}

#[needs(iverilog)]
#[test]
fn multiplexers_comparators_and_drivers_do_what_verilog_operators_do() {
    compare("selection", &selection());
}

#[needs(iverilog)]
#[test]
fn buses_resolve_as_verilog_wires_do() {
    compare("buses", &buses());
}

#[needs(iverilog)]
#[test]
fn arithmetic_does_what_verilog_operators_do() {
    compare("arithmetic", &arithmetic());
}

#[needs(iverilog)]
#[test]
fn constants_are_verilog_literals() {
    compare("constants", &constants());
}
