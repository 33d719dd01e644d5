//! The test bench: a scenario in Verilog, with every instant in the order that a circuit's meaning has
//! (`docs/meaning.md`): first the clocks and the delays, and when nothing moves any more the stimulus.
//!
//! All inputs change by nonblocking assignments, as what is clocked does, so none comes before another of its
//! phase. The second phase waits until as many rounds of such assignments are over as the first can have.

use std::collections::HashMap;
use std::fmt::Write as _;

use super::Refused;
use super::design::{Design, bench_timescale};
use super::names::{Taken, identifier};
use super::start::rounds;
use super::storage::clocks;
use super::text::{literal, range};
use crate::cell::CellKind;
use crate::netlist::{Direction, NetId, Netlist, ScopeId, SignalId};
use crate::scenario::Scenario;

/// A scenario to be written as a test bench.
#[derive(Clone, Copy, Debug)]
pub struct Bench<'a> {
    /// The circuit as it was written.
    pub design: &'a Design<'a>,
    /// What happens to it. What it expects and checks is not in the test bench.
    pub scenario: &'a Scenario,
    /// The file that the waveform goes to.
    pub dump: &'a str,
}

impl Bench<'_> {
    /// The module.
    ///
    /// # Errors
    /// What cannot be said in Verilog: times beyond 63 bits, a file name with a quotation mark.
    pub fn write(&self) -> Result<String, Refused> {
        let (design, netlist, scenario) = (self.design, self.design.netlist, self.scenario);
        let far = |t: u64| t > i64::MAX as u64;
        if scenario.stimulus.iter().any(|e| far(e.time)) || scenario.limit_given && far(scenario.limit) {
            return Err(Refused("a test bench cannot wait for more than 2^63 ticks".into()));
        }
        if self.dump.contains(['"', '\\', '\n']) {
            return Err(Refused(format!("`{}` cannot be the name of a dump file in Verilog", self.dump)));
        }
        let mut text = String::new();
        let top = &design.modules[0];
        let mut taken = Taken::default();
        let bench = identifier(&taken.fresh(&[0], "testbench"));
        let ports: Vec<SignalId> = netlist.ports().collect();
        let mut names: HashMap<NetId, String> = HashMap::new();
        let _ = writeln!(text, "// The scenario of {}: a test bench for Icarus Verilog and its like", top.trim_end());
        let _ = writeln!(text, "`timescale {0} / {0}", bench_timescale(netlist));
        let _ = writeln!(text, "\nmodule {bench};");
        // inputs are variables that begin as clocks do, or unknown
        let clocking = clocks(netlist);
        let clock_of = |net: NetId| scenario.clocks.iter().find(|c| c.net == net);
        let mut connections = Vec::new();
        let port_names: Vec<String> = {
            let mut inner = Taken::default();
            ports
                .iter()
                .map(|&p| inner.fresh(&[0], &netlist.signal(p).name.replace(char::is_whitespace, "_")))
                .collect()
        };
        // the instance has the name of the top module, so that its waveform has the same scopes
        let dut = identifier(&taken.fresh(&[0], &netlist.scopes()[0].name.replace(char::is_whitespace, "_")));
        for (&port, port_name) in ports.iter().zip(&port_names) {
            let signal = netlist.signal(port);
            let name = identifier(&taken.fresh(&[0], port_name));
            let width = range(signal.width);
            match (signal.drive, signal.port) {
                (Some(net), Some(Direction::Inout)) => {
                    let driver = identifier(&taken.fresh(&[0], &format!("{port_name}_driver")));
                    let _ = writeln!(text, "    reg  {width}{driver} = {}'bz;", signal.width);
                    let _ = writeln!(text, "    wire {width}{name} = {driver};");
                    names.insert(net, driver);
                }
                (Some(net), _) => {
                    // that a clock begins is no edge of it, but a change of anything else
                    let clock = clock_of(net).filter(|_| clocking.contains(&net));
                    let first = clock.map(|c| format!(" = 1'b{}", u8::from(c.clock.phase == 0)));
                    let _ = writeln!(text, "    reg  {width}{name}{};", first.unwrap_or_default());
                    names.insert(net, name.clone());
                }
                _ => _ = writeln!(text, "    wire {width}{name};"),
            }
            connections.push(format!("        .{}({name})", identifier(port_name)));
        }
        let gap = if dut.ends_with(' ') { "" } else { " " };
        let _ = writeln!(text, "\n    {top} {dut}{gap}(\n{}\n    );", connections.join(",\n"));
        for clock in &scenario.clocks {
            let (name, c) = (&names[&clock.net], clock.clock);
            let _ = write!(text, "\n    initial begin\n");
            if !clocking.contains(&clock.net) {
                let _ = writeln!(text, "        #0 {name} = 1'b{};", u8::from(c.phase == 0));
            }
            let _ = write!(text, "        #{};\n        forever begin\n", c.phase);
            let _ = write!(text, "            {name} <= 1'b1;\n            #{} {name} <= 1'b0;\n", c.high);
            let _ = write!(text, "            #{};\n        end\n    end\n", c.period - c.high);
        }
        let rounds = rounds(netlist);
        let round = identifier(&taken.fresh(&[0], "round"));
        let settle = identifier(&taken.fresh(&[0], "settle"));
        let _ = writeln!(text, "\n    // waits at one time until all that is clocked has changed");
        let _ = writeln!(text, "    reg {round} = 1'b0;\n    task {settle};");
        let _ = writeln!(
            text,
            "        repeat ({rounds}) begin\n            {round} <= ~{round};\n            @({round});"
        );
        let _ = writeln!(text, "        end\n    endtask");
        self.stimulus(&mut text, &names, &settle);
        self.end(&mut text, design, &mut taken, &dut, rounds)?;
        self.dump(&mut text, design, &dut);
        text += "endmodule\n";
        Ok(text)
    }

    /// What the inputs do.
    fn stimulus(&self, text: &mut String, names: &HashMap<NetId, String>, settle: &str) {
        let scenario = self.scenario;
        if scenario.inputs.is_empty() && scenario.stimulus.is_empty() {
            return;
        }
        let _ = writeln!(text, "\n    initial begin");
        // when everything waits for changes
        let _ = writeln!(text, "        #0;");
        for (net, value) in &scenario.inputs {
            let _ = writeln!(text, "        {} = {};", names[net], literal(value));
        }
        let mut now = 0;
        for event in &scenario.stimulus {
            if event.time > now {
                let _ = writeln!(text, "        #{};", event.time - now);
                now = event.time;
            }
            let _ = writeln!(text, "        {settle};");
            for (net, value) in &event.sets {
                let _ = writeln!(text, "        {} <= {};", names[net], literal(value));
            }
        }
        let _ = writeln!(text, "    end");
    }

    /// When it ends.
    fn end(
        &self,
        text: &mut String,
        design: &Design<'_>,
        taken: &mut Taken,
        dut: &str,
        rounds: usize,
    ) -> Result<(), Refused> {
        let (netlist, scenario) = (self.design.netlist, self.scenario);
        let last = identifier(&taken.fresh(&[0], "last"));
        let finish = identifier(&taken.fresh(&[0], "finish"));
        // after both phases of the instant
        let _ = writeln!(text, "\n    reg {last} = 1'b0;\n    task {finish};");
        let _ = writeln!(text, "        begin");
        let _ = writeln!(text, "            repeat ({}) begin", 3 * rounds);
        let _ = writeln!(text, "                {last} <= ~{last};\n                @({last});\n            end");
        if let Some((signal, value)) = &scenario.until {
            let net = self
                .path(design, dut, *signal)
                .ok_or_else(|| Refused(format!("`{}` has no name in the Verilog", netlist.signal_path(*signal))))?;
            let _ = writeln!(text, "            if ({net} === {}) $finish;", literal(value));
            let _ = writeln!(text, "        end\n    endtask");
            let _ = writeln!(text, "    initial begin\n        #0 {finish};");
            let _ = writeln!(text, "        forever @({net}) {finish};\n    end");
        } else {
            let _ = writeln!(text, "            $finish;\n        end\n    endtask");
        }
        // without clocks it ends by itself when nothing is left to do
        let ticking =
            !scenario.clocks.is_empty() || netlist.cells().iter().any(|c| matches!(c.kind, CellKind::Clock(_)));
        if ticking || scenario.limit_given && scenario.until.is_none() {
            let _ = writeln!(text, "    initial begin\n        #{};", scenario.limit);
            match scenario.until {
                Some(_) => {
                    let wait = format!("repeat ({}) begin {last} <= ~{last}; @({last}); end", 3 * rounds);
                    let _ = writeln!(text, "        {wait}\n        $finish;\n    end");
                }
                None => _ = writeln!(text, "        {finish};\n    end"),
            }
        }
        Ok(())
    }

    /// The same nets as `run` records, scope by scope.
    fn dump(&self, text: &mut String, design: &Design<'_>, dut: &str) {
        let _ = writeln!(text, "\n    initial begin\n        $dumpfile(\"{}\");", self.dump);
        for &signal in &self.scenario.trace {
            if let Some(path) = self.path(design, dut, signal) {
                let _ = writeln!(text, "        $dumpvars(1, {path});");
            }
        }
        let _ = writeln!(text, "    end");
    }

    /// Where a signal is, from the test bench.
    fn path(&self, design: &Design<'_>, dut: &str, id: SignalId) -> Option<String> {
        let netlist = self.design.netlist;
        let signal = netlist.signal(id);
        let (prefix, module, block) = scope_path(netlist, design, dut, signal.scope)?;
        let same =
            |w: &crate::netlist::hierarchy::Wire| w.signal.is_some() && w.block == block && w.name == signal.name;
        let wire = design.hierarchy.modules()[module].wires.iter().position(same)?;
        Some(format!("{prefix}.{}", design.names[module].wires[wire]))
    }
}

/// The path of a scope, its module and the block within it.
fn scope_path(netlist: &Netlist, design: &Design<'_>, dut: &str, scope: ScopeId) -> Option<(String, usize, usize)> {
    let own = &netlist.scopes()[scope.index()];
    let Some(parent) = own.parent else { return Some((dut.to_owned(), 0, 0)) };
    let (prefix, module, block) = scope_path(netlist, design, dut, parent)?;
    let around = &design.hierarchy.modules()[module];
    if let Some(inner) = design.hierarchy.module_of(scope) {
        let same = |i: &crate::netlist::hierarchy::Instance| i.block == block && i.name == own.name;
        let instance = around.instances.iter().position(same)?;
        return Some((format!("{prefix}.{}", design.names[module].instances[instance]), inner, 0));
    }
    let inner = around.blocks.iter().position(|b| b.parent == Some(block) && b.name == own.name)?;
    Some((format!("{prefix}.{}", design.names[module].blocks[inner]), module, inner))
}
