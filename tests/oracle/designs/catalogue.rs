//! The designs and what is done to them. Inputs change between the edges of clocks.

use super::harness::{Change, Clock, Design, Input, Known, Level, input};
use crate::support::Rng;

const SAME: Known = Known { words: 0, gates: 0, because: "" };

const PLAIN: Design = Design {
    name: "",
    source: "",
    files: &[],
    clocks: &[Clock { net: "clk", period: 10, first: 5 }],
    inputs: Vec::new(),
    stimulus: Vec::new,
    end: 0,
    known: SAME,
    recoded: &[],
    gates_know_more: "",
    absent: &[],
    words: &[],
    gates: None,
    gates_end: None,
    levels: &Level::ALL,
    mutants: &[],
    least: (0, 0),
};

/// A number as an input takes it.
fn number(width: u32, value: u64) -> String {
    format!("{width}'d{}", value & (u64::MAX >> (64 - width)))
}

/// Changes in order of time.
#[derive(Default)]
struct Stimulus(Vec<Change>);

impl Stimulus {
    fn at(&mut self, time: u64, net: &'static str, width: u32, value: u64) -> &mut Stimulus {
        self.0.push((time, net, number(width, value)));
        self
    }

    fn literal(&mut self, time: u64, net: &'static str, value: &str) -> &mut Stimulus {
        self.0.push((time, net, value.to_owned()));
        self
    }
}

/// All of them.
pub fn all() -> Vec<Design> {
    vec![uart(), fifo(), crc(), divider(), lfsr(), arbiter(), latches(), bus(), clocks(), numbers(), names(), cpu()]
}

pub fn uart() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("uart"));
        s.at(17, "rst", 1, 0);
        // a byte takes 11 bits of 8 samples of 3 clocks; one in four is disturbed somewhere
        for byte in 0..12 {
            let begin = 57 + byte * 2800;
            s.at(begin, "data", 8, rng.word()).at(begin, "send", 1, 1).at(begin + 20, "send", 1, 0);
            if byte % 4 == 3 {
                let from = begin + 300 + 10 * rng.below(200);
                s.at(from, "noise", 1, 1).at(from + 200, "noise", 1, 0);
            }
        }
        // a glitch that is no start bit
        s.at(34007, "noise", 1, 1).at(34037, "noise", 1, 0);
        s.0
    }
    Design {
        name: "uart",
        source: "uart.v",
        inputs: vec![input("rst", 1, "1"), input("send", 1, "0"), input("data", 8, "8'h00"), input("noise", 1, "0")],
        stimulus,
        end: 36000,
        mutants: &[
            ("^data ^ ODD;\n        {", "^data;\n        {"),
            ("samples[0] & samples[2]", "samples[0] | samples[2]"),
        ],
        absent: &["uart.receiver.vote.*"],
        least: (44, 45_000),
        ..PLAIN
    }
}

pub fn fifo() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("fifo"));
        s.at(3, "write_rst_n", 1, 0).at(4, "read_rst_n", 1, 0).at(26, "write_rst_n", 1, 1).at(33, "read_rst_n", 1, 1);
        // pushes more than it pops, then less; edges are at 5 + 10 n and at 8 + 14 n
        for step in 4..700 {
            let (push, pop) = if step / 100 % 2 == 0 { (2, 5) } else { (5, 2) };
            let time = 10 * step + 1;
            s.at(time, "push", 1, u64::from(rng.below(push) < 1)).at(time, "data", 8, rng.word());
            if (time % 14) != 8 && time % 7 != 1 {
                s.at(time, "pop", 1, u64::from(rng.below(pop) < 1));
            }
        }
        s.0
    }
    Design {
        name: "fifo",
        source: "fifo.v",
        clocks: &[Clock { net: "write_clk", period: 10, first: 5 }, Clock { net: "read_clk", period: 14, first: 8 }],
        inputs: vec![
            input("write_rst_n", 1, "1"),
            input("read_rst_n", 1, "1"),
            input("push", 1, "0"),
            input("pop", 1, "0"),
            input("data", 8, "8'h00"),
        ],
        stimulus,
        end: 7000,
        words: &[("words", 8)],
        absent: &["fifo.words.*"],
        mutants: &[("next ^ (next >> 1)", "next ^ (next >> 2)"), ("~read_seen[BITS:BITS-1]", "read_seen[BITS:BITS-1]")],
        least: (45, 13_000),
        ..PLAIN
    }
}

pub fn crc() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("crc"));
        s.at(17, "clear", 1, 0);
        for byte in 0..120 {
            let begin = 27 + byte * 110;
            s.at(begin, "data", 8, rng.word()).at(begin, "start", 1, 1).at(begin + 10, "start", 1, 0);
            if byte == 60 {
                s.at(begin + 40, "clear", 1, 1).at(begin + 60, "clear", 1, 0);
            }
        }
        s.0
    }
    Design {
        name: "crc",
        source: "crc.v",
        inputs: vec![input("clear", 1, "1"), input("start", 1, "0"), input("data", 8, "8'h00")],
        stimulus,
        end: 13400,
        mutants: &[("^ 32'hedb88320", "^ 32'hedb88321"), ("i == 31", "i >= 30")],
        absent: &["crc.bytes.step.*", "crc.bits.enable"],
        gates_know_more: "what is shifted in is x in the source, and never looked at",
        least: (54, 30_000),
        ..PLAIN
    }
}

pub fn divider() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("divider"));
        s.at(17, "rst", 1, 0);
        for pair in 0..70 {
            let begin = 27 + pair * 150;
            let (n, d) = match pair {
                0 => (0x800, 0xfff), // the least number by -1
                1 => (5, 0),
                2 => (0, 0xff9),
                _ => (rng.word(), rng.word() >> rng.below(40)),
            };
            s.at(begin, "n", 12, n).at(begin, "d", 12, d).at(begin, "start", 1, 1).at(begin + 10, "start", 1, 0);
        }
        s.0
    }
    Design {
        name: "divider",
        source: "divider.v",
        inputs: vec![input("rst", 1, "1"), input("start", 1, "0"), input("n", 12, "12'd0"), input("d", 12, "12'd1")],
        stimulus,
        end: 10600,
        mutants: &[("n < 0 ? -n : n", "n < 1 ? ~n : n"), ("negative_n ? -r", "negative ? -r")],
        least: (26, 11_700),
        ..PLAIN
    }
}

pub fn lfsr() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("lfsr"));
        for step in 0..60 {
            s.at(7 + 100 * step, "enable", 3, rng.word());
        }
        s.0
    }
    Design {
        name: "lfsr",
        source: "lfsr.v",
        inputs: vec![input("enable", 3, "3'b111")],
        stimulus,
        end: 6100,
        mutants: &[("^(state & TAPS)", "~^(state & TAPS)"), ("state[2:0] == 0", "state[2:0] == 1")],
        least: (18, 7_900),
        ..PLAIN
    }
}

pub fn arbiter() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("arbiter"));
        s.at(3, "rst", 1, 1).at(13, "rst", 1, 0);
        for step in 2..400 {
            let asks = if step / 50 % 2 == 0 { rng.word() } else { rng.word() & rng.word() & rng.word() };
            s.at(10 * step + 2, "ask", 5, asks);
        }
        s.at(4008, "rst", 1, 1).at(4012, "rst", 1, 0);
        for step in 402..450 {
            s.at(10 * step + 2, "ask", 5, rng.word());
        }
        s.0
    }
    Design {
        name: "arbiter",
        source: "arbiter.v",
        inputs: vec![input("rst", 1, "0"), input("ask", 5, "5'd0")],
        stimulus,
        end: 4600,
        mutants: &[("requests & ~below", "requests & below"), ("left <= NUMBER + 1", "left <= NUMBER + 2")],
        known: Known {
            words: 3,
            gates: 3,
            because: "`always @*` waits for a change of `grant`, which the reset makes",
        },
        least: (48, 7_900),
        ..PLAIN
    }
}

pub fn latches() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("latches"));
        // one input at a time, for two that change together may race; set and reset never both
        let mut set_or_reset = 0;
        for step in 0..1500 {
            let time = 5 + 5 * step;
            match step % 6 {
                0 => s.at(time, "phase1", 1, 1),
                1 => s.at(time, "phase1", 1, 0),
                3 => s.at(time, "phase2", 1, 1),
                4 => s.at(time, "phase2", 1, 0),
                _ => match rng.below(5) {
                    0 => s.at(time, "data", 4, rng.word()),
                    1 => s.at(time, "address", 2, rng.word()),
                    2 => s.at(time, "write", 1, rng.word()),
                    3 => s.at(time, "clear_n", 1, u64::from(!rng.one_in(3))),
                    _ => {
                        set_or_reset = if set_or_reset == 0 { 1 + rng.below(2) } else { 0 };
                        s.at(time, "set", 1, set_or_reset & 1).at(time, "reset", 1, set_or_reset >> 1)
                    }
                },
            };
        }
        s.0
    }
    Design {
        name: "latches",
        source: "latches.v",
        clocks: &[],
        inputs: vec![
            input("phase1", 1, "0"),
            input("phase2", 1, "0"),
            input("clear_n", 1, "1"),
            input("data", 4, "4'h5"),
            input("address", 2, "2'd0"),
            input("write", 1, "0"),
            input("set", 1, "0"),
            input("reset", 1, "0"),
        ],
        stimulus,
        end: 7600,
        mutants: &[("if (q) chosen = data", "if (!q) chosen = data"), (".open(~clk)", ".open(clk)")],
        absent: &["latches.both.master.open"],
        least: (78, 9_600),
        ..PLAIN
    }
}

pub fn bus() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("bus"));
        s.at(3, "rst", 1, 1).at(13, "rst", 1, 0);
        for step in 2..400 {
            let time = 10 * step + 2;
            s.at(time, "address", 2, rng.word()).at(time, "read", 1, rng.word()).at(time, "write", 1, rng.word());
            let direction = rng.below(4); // not both at once: a loop
            s.at(time, "inward", 1, u64::from(direction == 1)).at(time, "outward", 1, u64::from(direction > 1));
            // sometimes against what the design drives, with some bits left to it
            let pins: String = (0..8).map(|_| *rng.pick(&['0', '1', 'z', 'z'])).collect();
            s.literal(time, "pins", &if rng.one_in(2) { format!("8'b{pins}") } else { "8'bz".to_owned() });
        }
        s.0
    }
    Design {
        name: "bus",
        source: "bus.v",
        inputs: vec![
            input("rst", 1, "0"),
            input("address", 2, "2'd0"),
            input("read", 1, "0"),
            input("write", 1, "0"),
            input("inward", 1, "0"),
            input("outward", 1, "0"),
            Input { both_ways: true, ..input("pins", 8, "8'bz") },
        ],
        stimulus,
        end: 4100,
        mutants: &[("drive ? out", "drive ? ~out"), ("some <= |shared", "some <= &shared")],
        // z, which registers take from the bus, is x to a table or a gate
        levels: &[Level::Words, Level::FlatWords, Level::Gates, Level::FlatGates],
        least: (74, 20_700),
        ..PLAIN
    }
}

pub fn clocks() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("clocks"));
        s.at(3, "rst_n", 1, 0).at(4, "clear", 1, 1).at(7, "clear", 1, 0).at(23, "rst_n", 1, 1);
        // edges of `clk` are at 5 n, those of `other` at 9 + 13 n; `select` is unknown at first, for whether `other` falls to
        // its first 0 is a race in Verilog

        for time in (31..6000).filter(|t| t % 5 == 1 || t % 5 == 3).filter(|t| ![8, 9].contains(&(t % 13))) {
            match rng.below(9) {
                0 => s.at(time, "enable", 1, rng.word()),
                1 if time % 100 > 80 => s.at(time, "select", 1, rng.word()),
                2 | 3 => s.at(time, "d", 4, rng.word()),
                4 => s.at(time, "set", 1, 1).at(time + 1, "set", 1, 0),
                5 => s.at(time, "clear", 1, 1).at(time + 1, "clear", 1, 0),
                6 if time % 1000 > 985 => s.at(time, "rst_n", 1, 0).at(time + 1, "rst_n", 1, 1),
                _ => &mut s,
            };
        }
        s.0
    }
    Design {
        name: "clocks",
        source: "clocks.v",
        clocks: &[Clock { net: "clk", period: 10, first: 5 }, Clock { net: "other", period: 26, first: 9 }],
        inputs: vec![
            input("rst_n", 1, "1"),
            input("enable", 1, "0"),
            input("select", 1, "0"),
            input("d", 4, "4'h3"),
            input("set", 1, "0"),
            input("clear", 1, "0"),
        ],
        stimulus,
        end: 6100,
        mutants: &[("if (!clk) open", "if (clk) open"), ("always @(negedge clk0", "always @(posedge clk0")],
        absent: &["clocks.both.rst"],
        least: (76, 29_000),
        ..PLAIN
    }
}

pub fn numbers() -> Design {
    fn stimulus() -> Vec<Change> {
        let (mut s, mut rng) = (Stimulus::default(), Rng::named("numbers"));
        s.at(17, "rst", 1, 0);
        for step in 3..500 {
            let time = 10 * step;
            s.at(time, "a", 8, rng.word()).at(time, "b", 8, rng.word()).at(time, "u", 8, rng.word());
            s.at(time, "at.place", 3, rng.word());
        }
        s.0
    }
    Design {
        name: "numbers",
        source: "numbers.v",
        inputs: vec![
            input("rst", 1, "1"),
            input("a", 8, "8'd0"),
            input("b", 8, "8'd0"),
            input("u", 8, "8'd0"),
            input("at.place", 3, "3'd0"),
        ],
        stimulus,
        end: 5100,
        mutants: &[("a >= b ?", "a > b ?"), ("(b >> 2)", "(b >>> 2)")],
        absent: &["numbers.clamp.*", "numbers.leading_one.*", "numbers.reversed.*", "numbers.square_root.*"],
        known: Known { words: 0, gates: 5, because: "high bits of `root` are always 0, also before the first clock" },
        least: (66, 24_900),
        ..PLAIN
    }
}

pub fn names() -> Design {
    fn stimulus() -> Vec<Change> {
        let mut s = Stimulus::default();
        for (at, net, value) in [
            (2, "rst_n", "1'd0"),
            (12, "rst_n", "1'd1"),
            (22, "sel", "2'd1"),
            (32, "in.data", "8'h5a"),
            (42, "sel", "2'd2"),
            (62, "in.data", "8'hx7"),
            (82, "sel", "2'd3"),
            (102, "sel", "2'd2"),
            (122, "in.data", "8'h11"),
            (142, "sel", "2'bx0"),
            (162, "sel", "2'd1"),
            (177, "rst_n", "1'd0"),
        ] {
            s.literal(at, net, value);
        }
        s.0
    }
    Design {
        name: "names",
        source: "names.v",
        inputs: vec![
            input("rst_n", 1, "1"),
            input("in.data", 8, "8'h93"),
            input("sel", 2, "2'd0"),
            Input { both_ways: true, ..input("bus", 4, "4'bz") },
        ],
        stimulus,
        end: 200,
        mutants: &[("d ^ y", "d & y")],
        gates_know_more: "arithmetic on words is x in all bits where one is",
        least: (25, 300),
        ..PLAIN
    }
}

/// All gates but for the memory, whose words would be 131,072 flip-flops.
const CPU_GATES: &str = "synth -run begin:fine -top cpu; opt -fast -full; memory_map */x */core.registers.x; \
    opt -undriven -fine; techmap; opt -fast; abc -fast; opt -fast";

pub fn cpu() -> Design {
    fn stimulus() -> Vec<Change> {
        let mut s = Stimulus::default();
        s.at(27, "rst", 1, 0);
        s.0
    }
    Design {
        name: "cpu",
        source: "cpu/cpu.v",
        files: &["cpu/program.hex"],
        inputs: vec![input("rst", 1, "1")],
        stimulus,
        end: 235_000,
        gates: Some(CPU_GATES),
        gates_end: Some(30_000),
        mutants: &[("{1'b0, a} - {1'b0, b}", "{1'b0, a} - {1'b1, b}")],
        recoded: &["cpu.core.state"],
        least: (78, 75_000),
        ..PLAIN
    }
}
