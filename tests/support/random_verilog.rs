//! Random designs in Verilog of the shapes in which ports and nets are hard: bits repeated, constants on ports, inputs
//! that go straight to outputs, parts that overlap, ranges that count upwards or begin elsewhere, one net on two ports,
//! ports left open; with registers, memories with and without write ports, and hierarchy between them.

use std::fmt::Write as _;

use super::rng::Rng;

/// A port or net of a module.
#[derive(Clone)]
pub struct Net {
    pub name: String,
    pub width: u32,
    /// The index of the leftmost bit and of the rightmost.
    range: (u32, u32),
}

impl Net {
    fn new(rng: &mut Rng, name: String) -> Net {
        let width = *rng.pick(&[1, 1, 1, 2, 2, 3, 4, 4, 5, 8, 9, 16, 31, 32, 33, 63, 64, 65]);
        let first = if rng.one_in(4) { rng.below(5) as u32 } else { 0 };
        let (low, high) = (first, first + width - 1);
        Net { name, width, range: if rng.one_in(4) { (low, high) } else { (high, low) } }
    }

    /// A net of one bit.
    pub fn bit(name: &str) -> Net {
        Net::vector(name, 0, 0)
    }

    /// A net of these indices, left and right.
    pub fn vector(name: &str, left: u32, right: u32) -> Net {
        Net { name: name.to_owned(), width: left.abs_diff(right) + 1, range: (left, right) }
    }

    fn declared(&self) -> String {
        match self.is_scalar() {
            true => self.name.clone(),
            false => format!("[{}:{}] {}", self.range.0, self.range.1, self.name),
        }
    }

    fn is_scalar(&self) -> bool {
        self.width == 1 && self.range == (0, 0)
    }

    /// Some adjacent bits of it.
    fn part(&self, rng: &mut Rng) -> (String, u32) {
        if self.is_scalar() || rng.one_in(3) {
            return (self.name.clone(), self.width);
        }
        let width = if rng.one_in(2) { 1 } else { 1 + rng.below(self.width.into()) as u32 };
        let at = rng.below((self.width - width + 1).into()) as u32;
        let index = |from_right: u32| {
            let (left, right) = self.range;
            if left >= right { right + from_right } else { right - from_right }
        };
        match width {
            1 => (format!("{}[{}]", self.name, index(at)), 1),
            _ => (format!("{}[{}:{}]", self.name, index(at + width - 1), index(at)), width),
        }
    }
}

/// A module as others see it.
struct Module {
    name: String,
    inputs: Vec<Net>,
    outputs: Vec<Net>,
}

/// A design: its text, the top module last, and the inputs of that which are not the clock.
pub struct Design {
    pub text: String,
    pub inputs: Vec<Net>,
}

impl Design {
    /// Draws a design, whose top is `top`.
    pub fn new(rng: &mut Rng) -> Design {
        let mut text = String::new();
        let mut modules: Vec<Module> = Vec::new();
        for n in 0..rng.below(4) {
            let module = module(rng, &mut text, &format!("m{n}"), &modules);
            modules.push(module);
        }
        let top = module(rng, &mut text, "top", &modules);
        Design { text, inputs: top.inputs.into_iter().filter(|i| i.name != "clk").collect() }
    }
}

fn constant(rng: &mut Rng, width: u32) -> String {
    let digits: String = (0..width).map(|_| *rng.pick(&["0", "1"])).collect();
    format!("{width}'b{digits}")
}

/// An expression of so many bits that only moves bits: parts, repetitions, constants.
fn moved(rng: &mut Rng, nets: &[Net], width: u32) -> String {
    let mut parts = Vec::new();
    let mut left = width;
    while left > 0 {
        let (text, own) = match rng.below(6) {
            0 => {
                let own = 1 + rng.below(left.into()) as u32;
                (constant(rng, own), own)
            }
            _ => rng.pick(nets).part(rng),
        };
        if own > left {
            let Some(net) = nets.iter().find(|n| n.is_scalar()) else { continue };
            parts.push(net.name.clone());
            left -= 1;
            continue;
        }
        let most = left / own;
        let times = if rng.one_in(3) { 1 + rng.below(most.min(4).into()) as u32 } else { 1 };
        parts.push(if times > 1 { format!("{{{times}{{{text}}}}}") } else { text });
        left -= own * times;
    }
    if parts.len() == 1 { parts.remove(0) } else { format!("{{{}}}", parts.join(", ")) }
}

/// An expression that computes something of about so many bits.
fn computed(rng: &mut Rng, nets: &[Net], width: u32, depth: u32) -> String {
    if depth == 0 || rng.one_in(4) {
        return moved(rng, nets, width);
    }
    let mut inner = |width: u32| computed(rng, nets, width, depth - 1);
    let (a, b, one) = (inner(width), inner(width), inner(1));
    match rng.below(14) {
        0 => format!("~({a})"),
        1 => format!("({a}) & ({b})"),
        2 => format!("({a}) | ({b})"),
        3 => format!("({a}) ^ ({b})"),
        4 => format!("({a}) + ({b})"),
        5 => format!("({a}) - ({b})"),
        6 => format!("({one}) ? ({a}) : ({b})"),
        7 => format!("{{{width}{{&({a})}}}}"),
        8 => format!("{{{width}{{^({a})}}}}"),
        9 => format!("{{{width}{{({a}) < ({b})}}}}"),
        10 => format!("{{{width}{{({a}) == ({b})}}}}"),
        11 => format!("({a}) >> {}", rng.below(u64::from(width) + 1)),
        12 => format!("$signed({a}) >>> {}", rng.below(u64::from(width) + 1)),
        _ => format!("({a}) ~^ ({b})"),
    }
}

/// A value for an output or net: mostly moved bits, as those are what ports are hard for.
fn value(rng: &mut Rng, nets: &[Net], width: u32) -> String {
    match rng.below(5) {
        0 => {
            let net = rng.pick(nets);
            format!("{{{width}{{&{}}}}}", net.name)
        }
        1 | 2 => moved(rng, nets, width),
        _ => computed(rng, nets, width, 2),
    }
}

fn module(rng: &mut Rng, text: &mut String, name: &str, others: &[Module]) -> Module {
    let mut inputs = vec![Net::bit("clk"), Net::bit("r")];
    inputs.extend((0..1 + rng.below(3)).map(|n| Net::new(rng, format!("i{n}"))));
    let outputs: Vec<Net> = (0..1 + rng.below(4)).map(|n| Net::new(rng, format!("o{n}"))).collect();
    let ports = inputs.iter().map(|i| format!("input {}", i.declared()));
    let ports: Vec<String> = ports.chain(outputs.iter().map(|o| format!("output {}", o.declared()))).collect();
    writeln!(text, "module {name}({});", ports.join(", ")).unwrap();
    // what may be read: each thing reads only what is above it, so that nothing goes round but through registers
    let mut known: Vec<Net> = inputs[1..].to_vec();
    let registers: Vec<Net> = (0..rng.below(3)).map(|n| Net::new(rng, format!("q{n}"))).collect();
    for q in &registers {
        writeln!(text, "  reg {};", q.declared()).unwrap();
        if rng.one_in(2) {
            writeln!(text, "  initial {} = {};", q.name, constant(rng, q.width)).unwrap();
        }
    }
    known.extend(registers.iter().cloned());
    for n in 0..rng.below(5) {
        match rng.below(3) {
            0 if !others.is_empty() => {
                let of = rng.pick(others);
                instance(rng, text, n, of, &mut known);
            }
            1 if rng.one_in(2) => memory(rng, text, n, &mut known),
            _ => {
                let w = Net::new(rng, format!("w{n}"));
                let is = value(rng, &known, w.width);
                writeln!(text, "  wire {};\n  assign {} = {is};", w.declared(), w.name).unwrap();
                known.push(w);
            }
        }
    }
    for q in &registers {
        let next = value(rng, &known, q.width);
        let enable = computed(rng, &known, 1, 1);
        let start = constant(rng, q.width);
        let name = &q.name;
        let line = match rng.below(4) {
            0 => format!("always @(posedge clk) {name} <= {next};"),
            1 => format!("always @(posedge clk) if ({enable}) {name} <= {next};"),
            2 => format!("always @(posedge clk) if (r) {name} <= {start}; else {name} <= {next};"),
            _ => format!("always @(posedge clk or posedge r) if (r) {name} <= {start}; else {name} <= {next};"),
        };
        writeln!(text, "  {line}").unwrap();
    }
    for o in &outputs {
        // whole, or in two parts
        let is = value(rng, &known, o.width);
        writeln!(text, "  assign {} = {is};", o.name).unwrap();
        known.push(o.clone());
    }
    writeln!(text, "endmodule").unwrap();
    Module { name: name.to_owned(), inputs, outputs }
}

fn instance(rng: &mut Rng, text: &mut String, n: u64, of: &Module, known: &mut Vec<Net>) {
    let mut connections = Vec::new();
    for input in &of.inputs {
        let to = match input.name.as_str() {
            "clk" => "clk".to_owned(),
            _ if rng.one_in(10) => continue,
            _ => value(rng, known, input.width),
        };
        connections.push(format!(".{}({to})", input.name));
    }
    let mut made = Vec::new();
    for output in &of.outputs {
        if rng.one_in(6) {
            if rng.one_in(2) {
                connections.push(format!(".{}()", output.name));
            }
            continue;
        }
        // to one net, or to two that share it
        let mut nets = vec![Net { name: format!("u{n}_{}", output.name), ..output.clone() }];
        if output.width > 1 && rng.one_in(3) {
            let low = 1 + rng.below(u64::from(output.width) - 1) as u32;
            let part = |suffix: &str, width: u32| Net {
                name: format!("u{n}_{}{suffix}", output.name),
                width,
                range: (width - 1, 0),
            };
            nets = vec![part("h", output.width - low), part("l", low)];
        }
        for net in &nets {
            writeln!(text, "  wire {};", net.declared()).unwrap();
        }
        let names: Vec<&str> = nets.iter().map(|n| n.name.as_str()).collect();
        connections.push(format!(".{}({{{}}})", output.name, names.join(", ")));
        made.extend(nets);
    }
    writeln!(text, "  {} u{n}({});", of.name, connections.join(", ")).unwrap();
    known.extend(made);
}

fn memory(rng: &mut Rng, text: &mut String, n: u64, known: &mut Vec<Net>) {
    let address = 1 + rng.below(4) as u32;
    let word = Net { name: format!("d{n}"), range: (0, 0), ..Net::new(rng, String::new()) };
    let word = Net { range: (word.width - 1, 0), ..word };
    let words = if rng.one_in(3) { 1 + rng.below(1 << address) } else { 1 << address };
    writeln!(text, "  reg [{}:0] mem{n} [0:{}];\n  wire {};", word.width - 1, words - 1, word.declared()).unwrap();
    if rng.one_in(2) {
        let lines: Vec<String> = (0..words).map(|w| format!("mem{n}[{w}] = {};", constant(rng, word.width))).collect();
        writeln!(text, "  initial begin {} end", lines.join(" ")).unwrap();
    }
    if rng.one_in(2) {
        let (to, what, when) = (moved(rng, known, address), moved(rng, known, word.width), computed(rng, known, 1, 1));
        writeln!(text, "  always @(posedge clk) if ({when}) mem{n}[{to}] <= {what};").unwrap();
    }
    writeln!(text, "  assign {} = mem{n}[{}];", word.name, moved(rng, known, address)).unwrap();
    known.push(word);
}
