//! Every kind of cell in random shapes, exported as Verilog and run by Icarus beside this simulator on random inputs of
//! 0, 1, x and z.
//!
//! Where an unknown condition chooses between z and z, Icarus gives z and IEEE 1364-2005, table 5-21, x: what goes
//! through such a choice is never z here.

use std::fmt::Write as _;

use crate::support::engines::{self, simulator};
use crate::support::tool::complaints;
use crate::support::{Rng, folder};
use discreta::cell::memory::{ReadPort, WritePort};
use discreta::cell::pin::{counter, edge_flop};
use discreta::cell::samples::{Sort, sample};
use discreta::cell::{CellKind, Edge, Memory, Role, ShiftOp};
use discreta::export::verilog;
use discreta::netlist::{Builder, Bus, Netlist};
use discreta::{Logic, Value};
use needs::needs;

const VECTORS: usize = 300;
const SPACING: u64 = 10;
const ROUNDS: u64 = 12;
/// In one round.
const MEMORIES: usize = 40;

fn width(rng: &mut Rng) -> u32 {
    *rng.pick(&[1, 1, 2, 3, 4, 5, 8, 16, 31, 32, 33, 63, 64, 65, 70])
}

/// Some cells of each kind; memories have a test of their own, and the resolution of drivers is no cell there.
fn kinds(rng: &mut Rng) -> Vec<(&'static str, CellKind)> {
    let mut all: Vec<(&'static str, CellKind)> = Vec::new();
    for &sort in Sort::ALL {
        let times = match sort {
            Sort::Memory | Sort::Resolve => 0,
            Sort::Compare | Sort::Gate => 16,
            Sort::Flop | Sort::Divide | Sort::Shift => 8,
            _ => 4,
        };
        for _ in 0..times {
            let width = match sort {
                // what Icarus takes long over
                Sort::Multiply | Sort::Divide | Sort::Power | Sort::Alu | Sort::Shift => 1 + rng.below(20) as u32,
                Sort::Products | Sort::Demux => 1 + rng.below(9) as u32,
                _ => width(rng),
            };
            let kind = match sample(sort, width, &mut |n| rng.below(n)) {
                // of a longer index of a part Icarus takes the low bits, where IEEE 1364-2005, 5.2.1 has x
                CellKind::Shift { op: op @ (ShiftOp::Part | ShiftOp::PartSigned), a_width, b_width, width } => {
                    CellKind::Shift { op, a_width, b_width: b_width.min(31), width }
                }
                kind => kind,
            };
            all.push((kind.element(), kind));
        }
    }
    all
}

struct Pin {
    width: u32,
    /// Of a control or a clock: the value at which it is quiet, as it is at first; if that is 0, it mostly is.
    control: Option<Value>,
    /// Whether z would go through an unknown choice.
    no_z: bool,
    /// Of the addresses of a memory: how many, the first and how many there are.
    addresses: Option<(u32, i64, u64)>,
}

struct Drawn {
    netlist: Netlist,
    inputs: Vec<Pin>,
    /// Widths, and the cell's kind.
    outputs: Vec<(u32, &'static str)>,
}

/// Memories of all kinds: the usual ones with one clock, and whatever there can be with several.
fn memory(rng: &mut Rng) -> (Memory, [Vec<usize>; 2], Vec<Edge>) {
    let width = *rng.pick(&[1, 2, 4, 8, 8, 13, 32, 64, 65, 70]);
    let size = *rng.pick(&[1, 2, 4, 5, 8, 8, 16, 16, 19]);
    let offset = *rng.pick(&[0, 0, 0, 0, 1, 3, -1, -4]);
    let abits = *rng.pick(&[2, 3, 4, 4, 5, 31, 32, 33, 40, 64]);
    let usual = rng.one_in(2);
    let (r, w) = (1 + rng.below(3) as usize, rng.below(if usual { 2 } else { 4 }) as usize);
    let clocks = if usual { 1 } else { 1 + rng.below(3) as usize };
    let edges: Vec<Edge> = (0..clocks).map(|_| *rng.pick(&[Edge::Rising, Edge::Falling])).collect();
    let of = [r, w].map(|n| (0..n).map(|_| rng.below(clocks as u64) as usize).collect::<Vec<_>>());
    let mut init = Memory::contents(width, size);
    let unknown = *rng.pick(&[u64::MAX, 1, 6]);
    if !rng.one_in(3) {
        (0..size).for_each(|i| Memory::set_word(width, &mut init, i, &rng.four_valued(width, unknown), |_| true));
    }
    let level = if usual { 3 } else { 4 };
    let write = |port: usize, rng: &mut Rng| {
        let clock = if !usual && rng.one_in(4) { None } else { Some(edges[of[1][port]]) };
        WritePort { clock, wide: false, priority: vec![true; port].into() }
    };
    let writes: Vec<WritePort> = (0..w).map(|port| write(port, rng)).collect();
    let read = |port: usize, rng: &mut Rng| {
        let clock = if rng.one_in(level) { None } else { Some(edges[of[0][port]]) };
        let both = |w: &WritePort| clock.is_some() && w.clock.is_some();
        let transparent: Vec<bool> = writes.iter().map(|w| both(w) && rng.one_in(3)).collect();
        let collides = writes.iter().zip(&transparent).map(|(w, &t)| both(w) && !t && rng.one_in(4)).collect();
        let (arst_value, srst_value) = (rng.four_valued(width, 8), rng.four_valued(width, 8));
        let enable_first = rng.one_in(2);
        ReadPort { clock, wide: false, transparent: transparent.into(), collides, arst_value, srst_value, enable_first }
    };
    let reads: Vec<ReadPort> = (0..r).map(|port| read(port, rng)).collect();
    let start = rng.four_valued(r as u32 * width, unknown);
    (Memory { width, size, offset, abits, init: init.into(), start, reads, writes }, of, edges)
}

fn draw_memories(rng: &mut Rng) -> Drawn {
    let mut b = Builder::new("cells");
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for n in 0..MEMORIES {
        let (m, of, edges) = memory(rng);
        let clocks = b.input(&format!("c{n}"), edges.len() as u32);
        let mut quiet = Value::from_u64(0, edges.len() as u32);
        let falling = (0..).zip(&edges).filter(|e| *e.1 == Edge::Falling);
        falling.for_each(|(i, _)| quiet.set_bit(i, Logic::One));
        inputs.push(Pin { width: clocks.width(), control: Some(quiet), no_z: false, addresses: None });
        let (r, w, place) = (m.reads.len() as u32, m.writes.len() as u32, (i64::from(m.offset), u64::from(m.size)));
        let wide = m.width * r;
        let kind = CellKind::Memory(Box::new(m));
        let mut ins = Vec::new();
        for (k, pin) in kind.inputs().iter().enumerate() {
            let width = kind.input_width(k);
            if pin.role == Role::Clock {
                let bits: Vec<Bus> = of[k / 5].iter().map(|&clock| clocks.bit(clock as u32)).collect();
                ins.push(Bus::concat(&bits));
                continue;
            }
            // what is tied needs no condition
            if width == 0 || (k == 1 || k == 6) && rng.one_in(4) {
                ins.push(if width == 0 { Bus::default() } else { b.constant(&Value::repeat(Logic::One, width)) });
                continue;
            }
            if (k == 2 || k == 3) && rng.one_in(2) {
                ins.push(b.constant(&Value::from_u64(0, width)));
                continue;
            }
            // a write enable for each byte
            let bytes = k == 6 && rng.one_in(2);
            let own = if bytes { width.div_ceil(8) } else { width };
            let port = b.input(&format!("i{n}_{k}"), own);
            let bit = |i: u32| port.bit(if bytes { i / 8 } else { i });
            ins.push(if bytes { Bus::concat(&(0..width).map(bit).collect::<Vec<_>>()) } else { port });
            let control = (pin.role == Role::Level).then(|| Value::from_u64(0, width));
            let ports = if k == 4 { r } else { w };
            let addresses = (k == 4 || k == 7).then_some((ports, place.0, place.1));
            inputs.push(Pin { width: own, control, no_z: false, addresses });
        }
        let out = b.output(&format!("o{n}"), wide);
        outputs.push((wide, "memory"));
        b.cell(b.top(), &format!("memory{n}"), kind, ins, vec![out]);
    }
    Drawn { netlist: b.finish().unwrap(), inputs, outputs }
}

/// Addresses of which most are there, and often the same.
fn addresses(rng: &mut Rng, width: u32, (ports, first, size): (u32, i64, u64)) -> Value {
    let mut value = Value::from_u64(0, width);
    let own = width / ports;
    let same = first + rng.below(size.min(3)) as i64;
    for port in 0..ports {
        let at = if rng.one_in(2) { same } else { first - 1 + rng.below(size + 2) as i64 };
        let at = Value::from_i64(at, own);
        (0..own).for_each(|i| value.set_bit(port * own + i, at.bit(i)));
    }
    value
}

fn draw(rng: &mut Rng) -> Drawn {
    let mut b = Builder::new("cells");
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for (n, (name, kind)) in kinds(rng).into_iter().enumerate() {
        let mut ins = Vec::new();
        for (k, pin) in kind.inputs().iter().enumerate() {
            let optional = !pin.required;
            // a load needs its data
            let data =
                matches!((&kind, k), (CellKind::Counter(_), counter::D) | (CellKind::EdgeFlop(_), edge_flop::AD));
            if optional && !data && rng.one_in(2) {
                ins.push(Bus::default());
                continue;
            }
            // a trigger that is tied never becomes active; what happens before the first instant is the simulator's
            if optional && !data && pin.role != Role::Trigger && rng.one_in(8) {
                let tied = Value::from_u64(rng.below(2), 1);
                ins.push(b.constant(&tied));
                continue;
            }
            let width = kind.input_width(k);
            ins.push(b.input(&format!("i{n}_{k}"), width));
            let control = match pin.role {
                Role::Clock => Some(kind.edge() == Some(Edge::Falling)),
                Role::Level | Role::Trigger => Some(false),
                _ => None,
            };
            let control = control.map(|quiet| Value::from_u64(u64::from(quiet), 1));
            let no_z = matches!(kind, CellKind::Mux { .. } | CellKind::BitMux { .. } | CellKind::Tristate { .. });
            inputs.push(Pin { width, control, no_z, addresses: None });
        }
        let mut outs = Vec::new();
        for k in 0..kind.outputs().len() {
            let width = kind.output_width(k);
            outs.push(b.output(&format!("o{n}_{k}"), width));
            outputs.push((width, name));
        }
        b.cell(b.top(), &format!("{name}{n}"), kind, ins, outs);
    }
    Drawn { netlist: b.finish().unwrap(), inputs, outputs }
}

fn stimulus(rng: &mut Rng, pins: &[Pin]) -> Vec<Vec<Value>> {
    let mut vectors: Vec<Vec<Value>> = Vec::new();
    for n in 0..VECTORS {
        let one = |(i, pin): (usize, &Pin)| {
            if let (0, Some(quiet)) = (n, &pin.control) {
                return quiet.clone();
            }
            if let Some(place) = pin.addresses
                && !rng.one_in(8)
            {
                return addresses(rng, pin.width, place);
            }
            let unknown = *rng.pick(&[u64::MAX, u64::MAX, u64::MAX, 60, 12, 2]);
            let mut value = match rng.below(10) {
                0..=3 if pin.control == Some(Value::from_u64(0, pin.width)) => Value::from_u64(0, pin.width),
                0 => Value::from_u64(0, pin.width),
                1 => Value::repeat(Logic::One, pin.width),
                2 if n > 0 => vectors[n - 1][i].clone(),
                _ => rng.four_valued(pin.width, unknown),
            };
            for bit in 0..pin.width {
                if pin.no_z && value.bit(bit) == Logic::Z {
                    value.set_bit(bit, Logic::X);
                }
            }
            value
        };
        let vector = pins.iter().enumerate().map(one).collect();
        vectors.push(vector);
    }
    vectors
}

#[needs(iverilog)]
#[test]
fn every_kind_of_cell_runs_on_icarus_as_here() {
    run_on_icarus_as_here("export_elements", draw);
    engines::ran(0, 0);
}

#[needs(iverilog)]
#[test]
fn memories_run_on_icarus_as_here() {
    run_on_icarus_as_here("export_memories", draw_memories);
    engines::ran(0, 0);
}

fn run_on_icarus_as_here(place: &str, draw: fn(&mut Rng) -> Drawn) {
    let folder = folder(place);
    let (mut cells, mut values, mut faults) = (0, 0, String::new());
    for round in 0..ROUNDS {
        let mut rng = Rng::new(round);
        let Drawn { netlist, inputs, outputs } = draw(&mut rng);
        let vectors = stimulus(&mut rng, &inputs);
        let ports: Vec<_> = netlist.ports().map(|p| netlist.signal(p)).collect();
        let (ins, outs): (Vec<_>, Vec<_>) = ports.iter().partition(|p| p.drive.is_some());
        // Verilog
        let mut bench = String::from("`timescale 1ns / 1ns\nmodule bench;\n");
        for port in &ports {
            let kind = if port.drive.is_some() { "reg" } else { "wire" };
            writeln!(bench, "  {kind} [{}:0] {};", port.width - 1, port.name).unwrap();
        }
        let list = |of: &[&discreta::netlist::Signal]| of.iter().map(|p| p.name.clone()).collect::<Vec<_>>().join(", ");
        let connections: Vec<String> = ports.iter().map(|p| format!(".{0}({0})", p.name)).collect();
        let total: u32 = inputs.iter().map(|i| i.width).sum();
        writeln!(bench, "  cells cells ({});", connections.join(", ")).unwrap();
        writeln!(bench, "  reg [{}:0] v [0:{}]; integer n, f; reg r = 0;", total - 1, VECTORS - 1).unwrap();
        writeln!(bench, "  initial begin\n    $readmemb(\"{round}.in\", v); f = $fopen(\"{round}.out\");").unwrap();
        // the first vector comes when all has settled without any
        let settled = netlist.cells().iter().filter(|c| c.kind.init().is_some()).count() + 4;
        writeln!(bench, "    #0;\n    repeat ({settled}) begin r <= ~r; @(r); end").unwrap();
        writeln!(bench, "    for (n = 0; n < {VECTORS}; n = n + 1) begin").unwrap();
        writeln!(bench, "      {{{}}} = v[n]; #{};", list(&ins), SPACING - 1).unwrap();
        // with what changes at that tick itself
        writeln!(bench, "      repeat (4) begin r <= ~r; @(r); end").unwrap();
        writeln!(bench, "      $fdisplay(f, \"%b\", {{{}}}); #1;\n    end\n    $finish;", list(&outs)).unwrap();
        writeln!(bench, "  end\nendmodule").unwrap();
        std::fs::write(folder.join(format!("{round}.v")), verilog::Design::of(&netlist).text().to_owned() + &bench)
            .unwrap();
        let line = |vector: &Vec<Value>| vector.iter().map(Value::bit_string).collect::<String>() + "\n";
        std::fs::write(folder.join(format!("{round}.in")), vectors.iter().map(line).collect::<String>()).unwrap();
        let (design, compiled) = (format!("{round}.v"), format!("{round}.vvp"));
        assert_eq!(complaints(&folder, "iverilog", &["-g2005", "-o", &compiled, &design]), "");
        assert_eq!(complaints(&folder, "vvp", &["-n", &compiled]), "");
        let theirs = std::fs::read_to_string(folder.join(format!("{round}.out"))).unwrap();
        let theirs: Vec<&str> = theirs.lines().collect();
        assert_eq!(theirs.len(), VECTORS);
        // here
        let mut sim = simulator(&netlist);
        let drives: Vec<_> = ins.iter().map(|p| sim.input(&p.name).unwrap()).collect();
        let probes: Vec<_> = outs.iter().map(|p| sim.probe(&p.name).unwrap()).collect();
        let mut wrong = vec![false; outs.len()];
        for (n, vector) in vectors.iter().enumerate() {
            sim.run_to(n as u64 * SPACING).unwrap();
            drives.iter().zip(vector).for_each(|(&input, value)| sim.set_value(input, value));
            sim.settle().unwrap();
            sim.run_to(n as u64 * SPACING + SPACING - 1).unwrap();
            let mut at = 0;
            for (k, (probe, &(width, kind))) in probes.iter().zip(&outputs).enumerate() {
                let ours = sim.value(probe).bit_string();
                let found = &theirs[n][at..at + width as usize];
                at += width as usize;
                values += 1;
                if ours != found && !std::mem::replace(&mut wrong[k], true) {
                    writeln!(faults, "round {round}, {kind}, {}, vector {n}: {ours}, Icarus {found}", outs[k].name)
                        .unwrap();
                }
            }
        }
        cells += netlist.cells().len();
    }
    assert!(faults.is_empty(), "what differs from Icarus:\n{faults}");
    println!("{place}: {cells} cells, {values} values equal");
}
