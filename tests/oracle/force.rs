//! `force` and `release` as Icarus Verilog has them, on every engine: nets and registers, whole and in part, x and z among the
//! values.

use std::fmt::Write as _;
use std::fs;

use discreta::{EngineKind, Simulator, Value, circuit};
use needs::needs;

use crate::support::tool::tool;
use crate::support::{Rng, folder};

const DUT: &str =
    "module dut(input clk, input rst, input [7:0] d, output reg [69:0] q, output [7:0] y, output reg [7:0] c);
  wire [7:0] n = d ^ q[7:0];
  assign y = n + c;
  always @(posedge clk) q <= {q[61:0], n};
  always @(posedge clk or posedge rst) if (rst) c <= 8'd0; else c <= c + y[3:0];
endmodule
";

/// What can be forced, and its width.
const FORCED: [(&str, u32); 5] = [("n", 8), ("q", 70), ("y", 8), ("c", 8), ("d", 8)];

/// The same steps for both: the body of a bench, and what is done to a simulator.
enum Step {
    Poke(&'static str, Value),
    Force(&'static str, Value),
    Release(&'static str),
    Show,
}

fn steps(rng: &mut Rng) -> Vec<Step> {
    let one = |n: u64| Value::from_u64(n, 1);
    let mut all = vec![Step::Poke("clk", one(0)), Step::Poke("rst", one(1)), Step::Poke("d", Value::from_u64(1, 8))];
    all.extend([Step::Show, Step::Poke("rst", one(0)), Step::Force("q", Value::from_u64(9, 70)), Step::Show]);
    all.extend([Step::Release("q"), Step::Show]);
    let mut held = Vec::new();
    for _ in 0..60 {
        if rng.one_in(2) {
            all.push(Step::Poke("d", rng.known(8)));
        }
        if rng.one_in(3) {
            let (name, width) = *rng.pick(&FORCED);
            let value = if rng.one_in(4) { rng.four_valued(width, 3) } else { rng.known(width) };
            all.push(Step::Force(name, value));
            held.push(name);
        }
        if rng.one_in(3) && !held.is_empty() {
            all.push(Step::Release(held.swap_remove(rng.below(held.len() as u64) as usize)));
        }
        all.push(Step::Show);
        for level in [1, 0] {
            all.extend([Step::Poke("clk", one(level)), Step::Show]);
        }
    }
    all
}

fn bench(steps: &[Step]) -> String {
    let mut text = String::from(
        "module bench;\n  reg clk, rst; reg [7:0] d; wire [69:0] q; wire [7:0] y, c;\n  \
         dut dut(.clk(clk), .rst(rst), .d(d), .q(q), .y(y), .c(c));\n  initial begin\n",
    );
    for step in steps {
        _ = match step {
            Step::Poke(name, value) => writeln!(text, "    {name} = {}'b{};", value.width(), value.bit_string()),
            Step::Force(name, value) => {
                writeln!(text, "    force dut.{name} = {}'b{};", value.width(), value.bit_string())
            }
            Step::Release(name) => writeln!(text, "    release dut.{name};"),
            Step::Show => writeln!(text, "    #1 $display(\"%b %b %b %b\", dut.n, dut.q, dut.y, dut.c);"),
        };
    }
    text + "  end\nendmodule\n"
}

#[needs(iverilog, yosys)]
#[test]
fn forces_are_those_of_icarus() {
    let folder = folder("force_icarus");
    fs::write(folder.join("dut.v"), DUT).unwrap();
    let dut = circuit::load(folder.join("dut.v")).unwrap();
    let mut shown = 0;
    for seed in 0..8 {
        let steps = steps(&mut Rng::new(seed));
        fs::write(folder.join("bench.v"), bench(&steps)).unwrap();
        tool(&folder, "iverilog", &["-o", "bench", "dut.v", "bench.v"]);
        let expected = tool(&folder, "vvp", &["bench"]);
        for kind in [EngineKind::Event, EngineKind::Auto, EngineKind::Compiled] {
            if kind == EngineKind::Compiled && !cfg!(feature = "compiled") {
                continue;
            }
            let mut sim = Simulator::with(&dut, kind).unwrap();
            let mut lines = expected.lines();
            for (i, step) in steps.iter().enumerate() {
                match step {
                    Step::Poke(name, value) => sim.poke(name, value).unwrap(),
                    Step::Force(name, value) => sim.force(name, value).unwrap(),
                    Step::Release(name) => sim.release(name).unwrap(),
                    Step::Show => {
                        sim.settle().unwrap();
                        let found = ["n", "q", "y", "c"].map(|name| sim.peek(name).unwrap().bit_string()).join(" ");
                        assert_eq!(Some(found.as_str()), lines.next(), "seed {seed}, step {i}, {kind:?}");
                        shown += 1;
                    }
                }
            }
        }
    }
    assert!(shown > 2000, "{shown}");
}
