//! Elements with state, against `always` blocks. Yosys' simulation library (`simlib.v`) is what they follow, in that an
//! x or z on a control is inactive and that an asynchronous control which goes from 0 to x samples as an edge does.
//! Unlike some of its cells, levels are levels: a set still high when a reset ends sets, and `d` passes while a load is
//! high.

use needs::needs;

use super::icarus::{Case, compare};

const WIDTHS: &[u32] = &[1, 4, 63, 64, 65, 100];

fn verilog_edge(edge: &str) -> &'static str {
    if edge == "falling" { "negedge" } else { "posedge" }
}

fn flip_flops() -> Vec<Case> {
    let mut cases = Vec::new();
    for &w in WIDTHS {
        for edge in ["rising", "falling"] {
            let on = verilog_edge(edge);
            let plain = format!("reg [{w}-1:0] q; wire [{w}-1:0] qn = ~q; always @({on} clk) q = d;");
            let case = Case::new("dff", &[("clk", 1), ("d", w)], &[("q", w), ("qn", w)], &plain);
            cases.push(case.parameter("width", w).parameter("edge", edge).clock("clk", edge == "falling"));

            let enabled = format!("reg [{w}-1:0] q; always @({on} clk) if (en) q = d;");
            let case = Case::new("dff", &[("clk", 1), ("d", w), ("en", 1)], &[("q", w)], &enabled);
            cases.push(case.parameter("width", w).parameter("edge", edge).clock("clk", edge == "falling"));

            let whole = format!(
                "reg [{w}-1:0] q = {w}'b1; wire [{w}-1:0] qn = ~q;
  always @({on} clk or posedge set or posedge reset)
    if (reset) q = {w}'bx0; else if (set) q = {w}'b1;
    else if (sync_reset) q = {w}'bx0; else if (sync_set) q = {w}'b1; else if (en) q = d;
  always @(set or reset) if (reset) q = {w}'bx0; else if (set) q = {w}'b1;"
            );
            let pins = [("clk", 1), ("d", w), ("en", 1), ("set", 1), ("reset", 1), ("sync_set", 1), ("sync_reset", 1)];
            // a literal of one bit has no room for x0
            let reset_value = if w == 1 { "1'b0".to_string() } else { format!("{w}'bx0") };
            let case = Case::new("dff", &pins, &[("q", w), ("qn", w)], &whole.replace("1'bx0", "1'b0"));
            let case = case.parameter("width", w).parameter("edge", edge).parameter("reset_value", reset_value);
            let case = case.parameter("set_value", format!("{w}'b1")).parameter("init", format!("{w}'b1"));
            cases.push(case.clock("clk", edge == "falling"));

            let register = format!(
                "reg [{w}-1:0] q;
  always @({on} clk or posedge async_load or posedge reset)
    if (reset) q = 1; else if (async_load) q = d; else if (load) q = d;
  always @(reset or async_load or d) if (reset) q = 1; else if (async_load) q = d;"
            );
            let pins = [("clk", 1), ("d", w), ("load", 1), ("async_load", 1), ("reset", 1)];
            let case = Case::new("register", &pins, &[("q", w)], &register);
            let case = case.parameter("width", w).parameter("edge", edge).parameter("reset_value", 1);
            cases.push(case.clock("clk", edge == "falling"));
        }
        let latch = format!(
            "reg [{w}-1:0] q; wire [{w}-1:0] qn = ~q;
  always @* if (reset) q = 0; else if (set) q = {{{w}{{1'b1}}}}; else if (en) q = d;"
        );
        let pins = [("en", 1), ("d", w), ("set", 1), ("reset", 1)];
        cases.push(Case::new("latch", &pins, &[("q", w), ("qn", w)], &latch).parameter("width", w));
    }
    for (dominant, first, second) in
        [("reset", "if (r) q = 0", "if (s) q = 1"), ("set", "if (s) q = 1", "if (r) q = 0")]
    {
        let model = format!("reg q; wire qn = ~q; always @(s or r) {first}; else {second};");
        let case = Case::new("sr", &[("s", 1), ("r", 1)], &[("q", 1), ("qn", 1)], &model);
        cases.push(case.parameter("dominant", dominant));
    }
    cases
}

fn counters() -> Vec<Case> {
    let mut cases = Vec::new();
    for &w in WIDTHS {
        for edge in ["rising", "falling"] {
            let on = verilog_edge(edge);
            for step in if w == 1 { &[1u64][..] } else { &[1, 3] } {
                let model = format!(
                    "reg [{w}-1:0] q = 1; wire zero = ~|q;
  always @({on} clk or posedge async_load or posedge reset)
    if (reset) q = 0; else if (async_load) q = d; else if (load) q = d;
    else if (en) q = down === 1'b1 ? q - {step} : down === 1'b0 ? q + {step} : {{{w}{{1'bx}}}};
  always @(reset or async_load or d) if (reset) q = 0; else if (async_load) q = d;"
                );
                let pins = [("clk", 1), ("en", 1), ("down", 1), ("d", w), ("load", 1), ("async_load", 1), ("reset", 1)];
                let case = Case::new("counter", &pins, &[("q", w), ("zero", 1)], &model).parameter("width", w);
                let case = case.parameter("edge", edge).parameter("step", step).parameter("init", 1);
                cases.push(case.clock("clk", edge == "falling"));
            }
            let model = format!(
                "reg [{w}-1:0] q; wire [{w}-1:0] sum; wire co; assign {{co, sum}} = q + d + ci;
  always @({on} clk or posedge reset) if (reset) q = 0; else if (en) q = q + d + ci;
  always @(reset) if (reset) q = 0;"
            );
            let pins = [("clk", 1), ("d", w), ("ci", 1), ("en", 1), ("reset", 1)];
            let case = Case::new("accumulator", &pins, &[("q", w), ("co", 1)], &model).parameter("width", w);
            cases.push(case.parameter("edge", edge).clock("clk", edge == "falling"));
        }
    }
    cases
}

pub fn cases() -> impl Iterator<Item = Case> {
    flip_flops().into_iter().chain(counters())
}

#[needs(iverilog)]
#[test]
fn flip_flops_latches_and_registers_do_what_always_blocks_do() {
    compare("storage", &flip_flops());
}

#[needs(iverilog)]
#[test]
fn counters_and_accumulators_do_what_always_blocks_do() {
    compare("counters", &counters());
}
