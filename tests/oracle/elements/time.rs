//! Clocks and delays against their formulas, tick by tick.

use discreta::circuit::Circuit;
use discreta::{Logic, Value};
use serde_json::json;

use crate::support::engines::{self, simulator};
use crate::support::{Rng, folder, load};

/// The elements that this file tests.
pub const ELEMENTS: &[&str] = &["clock", "delay", "rc_delay"];

fn circuit(name: &str, timescale: &str, element: &str, width: u32, parameters: serde_json::Value) -> Circuit {
    let mut ports = json!({ "y": { "direction": "output", "width": width } });
    let mut connections = json!({ "y": "y" });
    if element != "clock" {
        ports["a"] = json!({ "direction": "input", "width": width });
        connections["a"] = json!("a");
    }
    let cell = json!({ "type": element, "parameters": parameters, "connections": connections });
    let file = json!({ "timescale": timescale, "modules": { "test": { "ports": ports, "cells": { "cell": cell } } } });
    load(&folder("elements_of_time"), name, &file).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn a_clock_is_its_formula() {
    for (period, high, phase) in [(2, 0, 0), (2, 1, 1), (10, 3, 0), (10, 9, 4), (7, 0, 20), (20, 10, 20), (100, 1, 99)]
    {
        let parameters = json!({ "period": period, "high": high, "phase": phase });
        let circuit = circuit(&format!("clock_{period}_{high}_{phase}"), "1ns", "clock", 1, parameters);
        let mut sim = simulator(&circuit.netlist);
        let y = sim.probe("y").unwrap();
        let high = if high == 0 { period / 2 } else { high };
        for t in 0..500u64 {
            sim.run_to(t).unwrap();
            let expected = t >= phase && (t - phase) % period < high;
            assert_eq!(sim.number(&y), Some(u64::from(expected)), "{period} {high} {phase} at {t}");
        }
    }
    engines::ran(0, 0);
}

#[test]
fn a_delay_gives_what_was() {
    for (width, ticks) in [(1, 1), (1, 7), (8, 3), (64, 20), (70, 5)] {
        let name = format!("delay_{width}_{ticks}");
        let circuit = circuit(&name, "1ns", "delay", width, json!({ "width": width, "ticks": ticks }));
        let mut sim = simulator(&circuit.netlist);
        let (a, y) = (sim.input("a").unwrap(), sim.probe("y").unwrap());
        let mut rng = Rng::named(&name);
        let mut past = vec![Value::unknown(width)];
        for t in 0..2000 {
            sim.run_to(t as u64).unwrap();
            let mut now = past.last().unwrap().clone();
            if rng.one_in(3) {
                now = rng.four_valued(width, 4);
            }
            sim.set_value(a, &now);
            sim.settle().unwrap();
            past.push(now); // past[t + 1] is the value at t
            let expected = if t >= ticks { past[t - ticks + 1].clone() } else { Value::unknown(width) };
            assert_eq!(sim.value(&y), expected, "{name} at {t}");
        }
    }
    engines::ran(0, 0);
}

/// From rest: RC·ln(1 / (1 - rise)) up and RC·ln(1 / fall) down, worked out by hand and rounded up to a tick.
#[test]
fn an_rc_step_takes_the_time_that_the_textbook_says() {
    for (timescale, r, c, rise, fall, up, down) in [
        // 1 µs · ln 2 = 693.147 ns
        ("1ns", "10k", "100p", "0.5", "0.5", 694, 694),
        ("10ns", "10k", "100p", "0.5", "0.5", 70, 70),
        // 4.7 µs · ln (1 / 0.3) = 5658.67 ns both ways
        ("1ns", "4.7k", "1n", "0.7", "0.3", 5659, 5659),
        // 1 s · ln 2 = 693147.18 µs, 1 s · ln 5 = 1609437.91 µs
        ("1us", "1M", "1u", "0.5", "0.2", 693_148, 1_609_438),
        // 47 Ω · 22 pF = 1.034 ns; · ln 4 = 1.43 ns, · ln 2 = 0.717 ns
        ("100ps", "47", "22p", "0.75", "0.5", 15, 8),
    ] {
        let name = format!("rc_{timescale}_{r}_{c}_{rise}");
        let parameters = json!({ "r": r, "c": c, "rise": rise, "fall": fall });
        let circuit = circuit(&name, timescale, "rc_delay", 1, parameters);
        let mut sim = simulator(&circuit.netlist);
        let (a, y) = (sim.input("a").unwrap(), sim.probe("y").unwrap());
        sim.set(a, 0);
        sim.settle().unwrap();
        let mut now = 100_000_000; // rest
        for (level, ticks) in [(1, up), (0, down), (1, up)] {
            sim.run_to(now).unwrap();
            assert_eq!(sim.number(&y), Some(1 - level), "{name}: rest");
            sim.set(a, level);
            sim.settle().unwrap();
            sim.run_to(now + ticks - 1).unwrap();
            assert_eq!(sim.number(&y), Some(1 - level), "{name}: too early");
            sim.run_to(now + ticks).unwrap();
            assert_eq!(sim.number(&y), Some(level), "{name}: too late");
            now += 100_000_000;
        }
    }
    engines::ran(0, 0);
}

/// A node followed tick by tick: v(t + 1) = goal + (v(t) - goal)·e^(-1/RC).
#[derive(Clone, Copy)]
struct Node {
    volts: f64,
    output: bool,
}

impl Node {
    fn tick(&mut self, goal: bool, tau: f64, rise: f64, fall: f64) {
        let goal = f64::from(u8::from(goal));
        self.volts = goal + (self.volts - goal) * (-1.0 / tau).exp();
        if self.volts >= rise {
            self.output = true;
        } else if self.volts <= fall {
            self.output = false;
        }
    }
}

#[test]
fn an_rc_node_follows_pulse_trains() {
    for (n, (tau, rise, fall)) in
        [(20.0, 0.5, 0.5), (13.7, 0.8, 0.2), (50.0, 0.6, 0.55), (3.0, 0.9, 0.1)].into_iter().enumerate()
    {
        let parameters = json!({ "r": tau.to_string(), "c": "1n", "rise": rise.to_string(), "fall": fall.to_string() });
        let circuit = circuit(&format!("rc_train_{n}"), "1ns", "rc_delay", 1, parameters);
        let mut sim = simulator(&circuit.netlist);
        let (a, y) = (sim.input("a").unwrap(), sim.probe("y").unwrap());
        let mut rng = Rng::new(n as u64);
        // what the voltage may be: anything, until the input has been known for long enough
        let (mut low, mut high) = (Node { volts: 0.0, output: false }, Node { volts: 1.0, output: true });
        let (mut input, mut changes, mut last) = (None, 0, Logic::X);
        for t in 0..100_000u64 {
            sim.run_to(t).unwrap();
            if t > 0 {
                low.tick(input.unwrap_or(false), tau, rise, fall);
                high.tick(input.unwrap_or(true), tau, rise, fall);
            }
            if rng.one_in((tau * 1.2) as u64) {
                input = *rng.pick(&[Some(false), Some(true), Some(false), Some(true), None]);
                let bit = input.map_or(Logic::X, |b| if b { Logic::One } else { Logic::Zero });
                sim.set_value(a, &Value::repeat(bit, 1));
            }
            sim.settle().unwrap();
            let expected = match (low.output, high.output) {
                (true, true) => Logic::One,
                (false, false) => Logic::Zero,
                _ => Logic::X,
            };
            assert_eq!(sim.value(&y).bit(0), expected, "RC {tau} at {t}");
            changes += usize::from(std::mem::replace(&mut last, expected) != expected);
        }
        assert!(changes > 500, "{changes} changes test nothing");
    }
    engines::ran(0, 0);
}
