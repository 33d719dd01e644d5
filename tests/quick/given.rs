//! Values that inputs are given: negative numbers only where there is a sign, wherever they are given; and what is expected
//! of a run follows them.

use serde_json::json;

use crate::support::{folder, program};

/// A circuit with a port of a width, signed or not, and a scenario beside it.
fn circuit(width: u32, signed: bool, simulation: &serde_json::Value) -> String {
    let folder = folder(&format!("given_{width}_{signed}"));
    let port = |direction: &str| json!({ "direction": direction, "width": width, "signed": signed });
    let file = json!({ "modules": { "t": {
        "ports": { "a": port("input"), "y": port("output") },
        "cells": { "b": { "type": "buf", "parameters": { "width": width }, "connections": { "a": "a", "y": "y" } } } } },
        "simulation": simulation });
    let path = folder.join("t.json");
    std::fs::write(&path, file.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_port_without_a_sign_takes_no_negative_number() {
    let plain = json!({ "inputs": { "a": 0 }, "limit": { "time": 9 } });
    let held = json!({ "inputs": { "a": -1 }, "limit": { "time": 9 } });
    let later = json!({ "inputs": { "a": 0 }, "stimulus": [{ "at": 5, "set": { "a": -1 } }], "limit": { "time": 9 } });
    for width in [1, 2, 8, 63, 64, 65, 100] {
        for signed in [false, true] {
            let mut runs = vec![
                (&plain, vec!["run", "", "-s", "a=-1"]),
                (&held, vec!["run", ""]),
                (&later, vec!["run", ""]),
                (&held, vec!["check", ""]),
            ];
            if width <= 64 && !signed {
                runs.push((&plain, vec!["sweep", "", "--over", "a=-1..0", "--show", "y"]));
                runs.push((&plain, vec!["sweep", "", "--over", "a=0,-1", "--show", "y"]));
            }
            for (simulation, mut line) in runs {
                let file = circuit(width, signed, simulation);
                line[1] = &file;
                let (status, text, told) = program::run(&line);
                if line[0] == "check" && !signed {
                    assert_ne!(status, 0, "{line:?}: {text}");
                } else if signed {
                    assert_eq!(status, 0, "{width} bits, {line:?}: {told}");
                } else {
                    assert_eq!(status, 2, "{width} bits, {line:?}: {text}");
                    assert!(told.contains("-1 is negative") && told.contains("without a sign"), "{told}");
                }
            }
        }
    }
}

#[test]
fn a_pattern_of_bits_is_taken_without_a_sign() {
    let file = circuit(8, false, &json!({ "inputs": { "a": "8'd249" }, "limit": { "time": 9 } }));
    let (status, text, told) = program::run(&["run", &file]);
    assert_eq!(status, 0, "{told}");
    assert!(text.contains("y = 249"), "{text}");
}

#[test]
fn the_feed_is_expected_to_make_the_steps_that_it_is_told() {
    for (dx, dy) in [(5, 3), (3, 5), (40, 23), (7, 7), (0, 4), (1, 0), (0, 0), (200, 83)] {
        let (status, _, told) = program::command("run", &format!("circuits/feed/system.json -s dx={dx} -s dy={dy}"));
        assert_eq!((status, told.as_str()), (0, ""), "{dx}, {dy}");
    }
}

#[test]
fn a_feed_clock_that_stops_the_interpolator_for_ever_is_named() {
    let line = "circuits/feed/system.json -s dx=40 -s dy=23 -s period=1000";
    let (status, _, told) = program::command("run", line);
    assert_eq!(status, 1);
    assert!(told.contains("timing check `pace`"), "{told}");
}

#[test]
fn what_is_expected_needs_inputs_with_numbers() {
    let expects = |inputs: serde_json::Value| {
        let file = circuit(
            4,
            false,
            &json!({ "inputs": inputs, "limit": { "time": 9 },
            "expect": [{ "net": "y", "pulses": "a - a" }] }),
        );
        program::run(&["run", &file])
    };
    assert_eq!(expects(json!({ "a": 3 })).0, 0);
    let (status, _, told) = expects(json!({ "a": "4'b1x00" }));
    assert!(status == 2 && told.contains("`a` is 4'b1x00 at the start, which is no number"), "{told}");
    let (status, _, told) = expects(json!({}));
    assert!(status == 2 && told.contains("the input `a` has no value at the start"), "{told}");
}
