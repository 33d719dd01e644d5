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

/// Memories: of sizes that are powers of two and not, with addresses that reach further and not, all kinds of ports.
/// Where several ports or clocks meet, one clock drives all, or Verilog would leave the order open.
fn memories() -> Vec<Case> {
    let mut cases = Vec::new();
    for &w in WIDTHS {
        for (words, a) in [(1, 1), (5, 3), (16, 4), (70, 8)] {
            let write = |port: u32| {
                let lo = |width: u32| format!("[{}:{}]", (port + 1) * width - 1, port * width);
                format!(
                    "for (i = 0; i < {w}; i = i + 1) if (wr_en[{port} * {w} + i] === 1'b1)
      mem[wr_addr{}][i] = wr_data[{port} * {w} + i];",
                    lo(a)
                )
            };
            let (last, range) = (words - 1, format!("[{}:0]", w - 1));
            let size = |case: Case| case.parameter("width", w).parameter("words", words).parameter("address", a);
            let writing = [("wr_en", w), ("wr_addr", a), ("wr_data", w)];

            let plain = format!(
                "reg {range} mem [0:{last}]; integer i; wire {range} rd_data = mem[rd_addr];
  initial for (i = 0; i < {words}; i = i + 1) mem[i] = 1;
  always @(negedge wr_clk) begin {} end",
                write(0)
            );
            let inputs = [&[("wr_clk", 1), ("rd_addr", a)], &writing[..]].concat();
            let case = size(Case::new("memory", &inputs, &[("rd_data", w)], &plain));
            cases.push(case.parameter("write_edge", "falling").parameter("init", "1").clock("wr_clk", true));

            let level = format!(
                "reg {range} mem [0:{last}]; integer i; reg {range} rd_data;
  always @(wr_en, wr_addr, wr_data, rd_addr) begin {} rd_data = mem[rd_addr]; end",
                write(0)
            );
            let inputs = [&[("rd_addr", a)], &writing[..]].concat();
            let case = size(Case::new("memory", &inputs, &[("rd_data", w)], &level));
            cases.push(case.parameter("write_edge", "none"));

            for transparent in [0, 1] {
                let part = |port: u32, width: u32| format!("[{}:{}]", (port + 1) * width - 1, port * width);
                let read = |port: u32| {
                    // as a bypass has it, whether there is such a word or not
                    let bypass = |from: u32| {
                        format!(
                            "for (i = 0; i < {w}; i = i + 1)
        if ((rd_addr{} == wr_addr{}) === 1'b1 && wr_en[{from} * {w} + i] === 1'b1)
          rd_data[{port} * {w} + i] = wr_data[{from} * {w} + i];",
                            part(port, a),
                            part(from, a)
                        )
                    };
                    let seen = if transparent == 1 { bypass(0) + &bypass(1) } else { String::new() };
                    let (to, at) = (part(port, w), part(port, a));
                    format!("if (rd_en[{port}] === 1'b1) begin rd_data{to} = mem[rd_addr{at}]; {seen} end")
                };
                let clocked = format!(
                    "reg {range} mem [0:{last}]; integer i; reg [2*{w}-1:0] rd_data;
  always @(posedge clk) begin {}\n{}\n{}\n{} end",
                    read(0),
                    read(1),
                    write(0),
                    write(1)
                );
                let inputs = [
                    ("clk", 1),
                    ("rd_en", 2),
                    ("rd_addr", 2 * a),
                    ("wr_en", 2 * w),
                    ("wr_addr", 2 * a),
                    ("wr_data", 2 * w),
                ];
                let mut case = size(Case::new("memory", &inputs, &[("rd_data", 2 * w)], &clocked));
                case = case.parameter("transparent", transparent);
                case.cells = Some(serde_json::json!({ "cell": {
                    "type": "memory",
                    "parameters": { "width": w, "words": words, "address": a, "reads": 2, "writes": 2,
                                    "read_edge": "rising", "transparent": transparent },
                    "connections": { "rd_clk": "2{clk}", "rd_en": "rd_en", "rd_addr": "rd_addr", "rd_data": "rd_data",
                        "wr_clk": "2{clk}", "wr_en": "wr_en", "wr_addr": "wr_addr", "wr_data": "wr_data" } } }));
                cases.push(case.clock("clk", false));
            }
        }
    }
    // contents from a file and from a list; the address is as wide as 6 words need
    let folder = crate::support::folder("elements_memories");
    std::fs::write(folder.join("rom.hex"), "// six words\n1f x_1 @3 z /* no fourth */ 7\n@5\n00A").unwrap();
    let rom = "reg [8:0] mem [0:5]; wire [8:0] rd_data = mem[rd_addr];";
    let file = format!("{rom} initial $readmemh(\"rom.hex\", mem);");
    let list = format!("{rom} initial begin mem[0] = 300; mem[1] = -1; mem[2] = 9'bx1z; end");
    for (init, model) in [(serde_json::json!("rom.hex"), file), (serde_json::json!([300, -1, "9'bx1z"]), list)] {
        let mut case = Case::new("memory", &[("rd_addr", 3)], &[("rd_data", 9)], &model).parameter("init", &init);
        case.cells = Some(serde_json::json!({ "cell": {
            "type": "memory", "parameters": { "width": 9, "words": 6, "writes": 0, "init": init },
            "connections": { "rd_addr": "rd_addr", "rd_data": "rd_data" } } }));
        cases.push(case);
    }
    cases
}

pub fn cases() -> impl Iterator<Item = Case> {
    flip_flops().into_iter().chain(counters()).chain(memories())
}

#[needs(iverilog)]
#[test]
fn memories_do_what_arrays_do() {
    compare("memories", &memories());
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
