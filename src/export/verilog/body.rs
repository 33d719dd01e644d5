//! What stands in a module: ports, wires, what is one wire by two names, cells, instances, blocks.

use super::design::STARTED;
use super::names::{Taken, identifier};
use super::text::range;
use super::writer::Writer;
use super::{cells, storage};
use crate::netlist::Direction;
use crate::netlist::hierarchy::{Cell, Piece};

impl Writer<'_> {
    pub fn module(&mut self) {
        let module = self.module;
        let variables = self.variables();
        let name = identifier(&self.modules[self.number]);
        let mut head = String::new();
        let ports = module.ports();
        for (w, port) in ports.iter().enumerate() {
            let way = match port.port {
                Some(Direction::Output) => "output",
                Some(Direction::Inout) => "inout ",
                _ => "input ",
            };
            let kind = if variables[w] { "reg " } else { "wire" };
            let comma = if w + 1 < ports.len() { "," } else { "" };
            let declared = format!("    {way} {kind} {}{}{comma}\n", range(port.width), self.wires[w]);
            let unread = port.port == Some(Direction::Input) && self.read[w].contains(&false);
            let lints = [(unread, "UNUSED", "not all is read"), (self.circular[w], "UNOPTFLAT", "feedback")];
            for (_, lint, why) in lints.iter().filter(|l| l.0) {
                head += &format!("    /* verilator lint_off {lint} */ // {why}\n");
            }
            head += &declared;
            for (_, lint, _) in lints.iter().filter(|l| l.0) {
                head += &format!("    /* verilator lint_on {lint} */\n");
            }
        }
        match ports.is_empty() {
            true => self.line(format!("module {name};")),
            false => {
                self.text += &format!("module {name}(\n{head});\n");
            }
        }
        self.indent = 4;
        let head = self.text.len();
        self.block(0, &variables);
        if let Some(started) = self.started.clone() {
            let name = self.fresh(0, "start");
            let text = format!("    wire {started};\n    {STARTED} {name} (.started({started}));\n");
            self.text.insert_str(head, &text);
        }
        self.indent = 0;
        self.line("endmodule");
    }

    /// Which wires are variables: those that one storage cell alone drives.
    fn variables(&self) -> Vec<bool> {
        let mut variables = vec![false; self.module.wires.len()];
        for cell in &self.module.cells {
            let kind = &self.netlist.cell(cell.id).kind;
            for state in storage::variables(cell, kind) {
                if let Some(wire) = self.own_wire(&state) {
                    variables[wire] = true;
                }
            }
        }
        variables
    }

    fn block(&mut self, block: usize, variables: &[bool]) {
        let module = self.module;
        let ports = module.ports().len();
        let of_block = |w: &usize| module.wires[*w].block == block && *w >= ports;
        // by what Verilator is not to tell of them
        let class = |w: usize| (self.read[w].contains(&false), self.circular[w]);
        let mut classes: Vec<((bool, bool), usize)> =
            (0..module.wires.len()).filter(of_block).map(|w| (class(w), w)).collect();
        classes.sort_by_key(|c| c.0);
        for group in classes.chunk_by(|a, b| a.0 == b.0) {
            let (unread, circular) = group[0].0;
            let lints = [(unread, "UNUSED", "to be looked at; not all is read"), (circular, "UNOPTFLAT", "feedback")];
            for (_, lint, why) in lints.iter().filter(|l| l.0) {
                self.line(format!("/* verilator lint_off {lint} */ // {why}"));
            }
            group.iter().for_each(|&(_, w)| self.declare(w, variables[w]));
            for (_, lint, _) in lints.iter().filter(|l| l.0) {
                self.line(format!("/* verilator lint_on {lint} */"));
            }
        }
        for w in (0..module.wires.len()).filter(|&w| module.wires[w].block == block) {
            self.alias(w);
        }
        for (c, cell) in module.cells.iter().enumerate().filter(|(_, c)| c.block == block) {
            match self.closing[c] {
                true => self.closing(cell),
                false => cells::write(self, cell),
            }
        }
        for (i, _) in module.instances.iter().enumerate().filter(|(_, x)| x.block == block) {
            self.instance(i);
        }
        for inner in (0..module.blocks.len()).filter(|&b| module.blocks[b].parent == Some(block)) {
            let name = self.fresh(block, &module.blocks[inner].name);
            self.blocks[inner] = name.clone();
            self.line(format!("if (1) begin : {name}"));
            self.indent += 4;
            self.block(inner, variables);
            self.indent -= 4;
            self.line("end");
        }
    }

    /// A cell that closes a circle: its output goes through a module, so that tools see that it is meant.
    fn closing(&mut self, cell: &Cell) {
        self.support.insert("discreta_feedback");
        let width = self.kind(cell).output_width(0);
        let out = self.helper(cell, "out");
        self.line("/* verilator lint_off UNOPTFLAT */ // feedback");
        self.line(format!("wire {}{out};", range(width)));
        self.line("/* verilator lint_on UNOPTFLAT */");
        self.instead = Some(out.clone());
        cells::write(self, cell);
        self.instead = None;
        let q = self.text_of(&cell.outputs[0]);
        let name = self.helper(cell, "feedback");
        self.line(format!("discreta_feedback #(.WIDTH({width})) {name} (.a({out}), .q({q}));"));
    }

    fn declare(&mut self, w: usize, variable: bool) {
        let wire = &self.module.wires[w];
        let kind = if variable { "reg " } else { "wire" };
        let text = format!("{kind} {}{};", range(wire.width), self.wires[w]);
        self.line(text);
    }

    /// What a wire shows of others.
    fn alias(&mut self, w: usize) {
        for (lo, run) in self.module.wires[w].shown_of_others(w) {
            let to = self.select(w, lo, super::text::width(&run));
            let from = self.text_of(&run);
            self.line(format!("assign {to} = {from};"));
        }
    }

    fn instance(&mut self, i: usize) {
        let instance = &self.module.instances[i];
        let inner = &self.hierarchy.modules()[instance.module];
        let name = self.fresh(instance.block, &instance.name);
        self.instances[i] = name.clone();
        let mut taken = Taken::default();
        let mut connections = Vec::new();
        for (port, pieces) in inner.ports().iter().zip(&instance.ports) {
            let port_name = identifier(&taken.fresh(&[0], &port.name.replace(char::is_whitespace, "_")));
            let open = pieces.iter().filter(|p| matches!(p, Piece::Open(_))).count();
            let to = if open == pieces.len() {
                String::new()
            } else if open == 0 {
                self.text_of(pieces)
            } else {
                // some of an output's bits are needed, others not
                let mut filled = Vec::new();
                for piece in pieces {
                    filled.push(match piece {
                        Piece::Open(width) => {
                            let spare = self.fresh(instance.block, &format!("{}_open", port.name));
                            self.unused(&format!("wire {}{spare};", range(*width)));
                            spare
                        }
                        piece => self.text_of(std::slice::from_ref(piece)),
                    });
                }
                filled.reverse();
                format!("{{{}}}", filled.join(", "))
            };
            connections.push((port_name, to));
        }
        let module = identifier(&self.modules[instance.module]);
        let open = connections.iter().any(|c| c.1.is_empty());
        if open {
            self.line("/* verilator lint_off PINCONNECTEMPTY */ // not needed here");
        }
        let list: Vec<String> = connections.iter().map(|(port, to)| format!(".{port}({to})")).collect();
        let gap = if name.ends_with(' ') { "" } else { " " };
        let short = format!("{module} {name}{gap}({});", list.join(", "));
        if short.len() + self.indent <= 116 {
            self.line(short);
        } else {
            self.line(format!("{module} {name}{gap}("));
            self.line(list.iter().map(|l| format!("    {l}")).collect::<Vec<_>>().join(",\n"));
            self.line(");");
        }
        if open {
            self.line("/* verilator lint_on PINCONNECTEMPTY */");
        }
    }
}
