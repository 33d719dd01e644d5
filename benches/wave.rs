//! What a value costs in a waveform: our own writing of VCD's and FST's values, one by one and by the batch, beside that of
//! the crates `vcd` and `fst-writer`, the same values, in turns. And what a run costs of which some nets are traced: the
//! others shall cost nothing.
//!
//!     cargo bench --bench wave
//!
//! All in one thread, and in seconds of the processor where the system tells them.

use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::time::Instant;

use discreta::value::Word;
use discreta::value::changes::{self, Written};
use discreta::wave::batch::{Part, Shape};
use discreta::wave::fst::FstWriter;
use discreta::wave::output::Destination;
use discreta::wave::vcd::VcdWriter;
use discreta::wave::{Batch, Layout, Sink};
use fst_writer::{FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalType, FstVarDirection, FstVarType};

/// Runs of which the median is taken.
const RUNS: usize = 5;
const TICKS: u64 = 500_000;
/// Widths of the variables, all of which change at each tick.
const WIDTHS: [u32; 12] = [1, 1, 1, 1, 1, 1, 5, 8, 16, 32, 32, 32];

/// Counts what it is given.
#[derive(Default)]
struct Counted(u64);

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Counted {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Ok(0)
    }
}

impl Destination for Counted {
    fn complete(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Variable `i` at tick `now`: another value at each.
fn value(i: usize, now: u64) -> u64 {
    let mixed = (now / 2 + i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20 << 1;
    (mixed | now & 1) & (u64::MAX >> (64 - WIDTHS[i]))
}

fn layout() -> Layout {
    let mut layout = Layout::default();
    let top = layout.scope("top", None);
    for (i, &width) in WIDTHS.iter().enumerate() {
        layout.var(top, &format!("v{i}"), width);
    }
    layout
}

/// Seconds of this thread, or of the clock.
fn seconds() -> f64 {
    static BEGIN: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let told = std::fs::read_to_string("/proc/thread-self/schedstat");
    let nanoseconds = told.ok().and_then(|t| t.split(' ').next()?.parse::<f64>().ok()).filter(|&n| n > 0.0);
    nanoseconds.map_or_else(|| BEGIN.get_or_init(Instant::now).elapsed().as_secs_f64(), |n| n / 1e9)
}

/// The values as an engine writes them down, some thousand words at once.
fn records() -> Vec<Vec<u64>> {
    let written = |i: usize| if WIDTHS[i] == 1 { Written::Toggled } else { Written::Known };
    let (mut all, mut words) = (Vec::new(), Vec::new());
    for now in 1..TICKS {
        let values = (0..WIDTHS.len()).map(|i| (i, Word::known(value(i, now)), written(i)));
        changes::write(&mut words, 0, now, WIDTHS.len(), values);
        if words.len() >= 1 << 14 || now == TICKS - 1 {
            all.push(std::mem::take(&mut words));
        }
    }
    all
}

/// Seconds that records take.
fn batches(sink: &mut dyn Sink, records: Vec<Vec<u64>>) -> f64 {
    let mut shape = Shape::default();
    for (i, &width) in WIDTHS.iter().enumerate() {
        let written = if width == 1 { Written::Toggled } else { Written::Known };
        shape.fields.push((written, i as u32));
        shape.parts.push(Part { var: i as u32, word: 0, from: 0, to: 0, width: width as u8 });
    }
    let shapes = Arc::new(vec![Arc::new(shape)]);
    let begin = seconds();
    sink.begin(&layout()).unwrap();
    sink.time(0).unwrap();
    (0..WIDTHS.len()).for_each(|i| sink.change(i, &[Word::known(value(i, 0))]));
    for words in records {
        let batches = sink.batches().expect("both formats take them");
        batches.batch(Batch { words, shapes: Arc::clone(&shapes) }).unwrap();
    }
    sink.finish(TICKS).unwrap();
    seconds() - begin
}

fn ours(sink: &mut dyn Sink) {
    sink.begin(&layout()).unwrap();
    for now in 0..TICKS {
        sink.time(now).unwrap();
        (0..WIDTHS.len()).for_each(|i| sink.change(i, &[Word::known(value(i, now))]));
    }
    sink.finish(TICKS).unwrap();
}

fn vcd_ours() -> u64 {
    let mut to = Counted::default();
    ours(&mut VcdWriter::new(&mut to));
    to.0
}

fn vcd_crate() -> u64 {
    let mut to = Counted::default();
    let mut out = vcd::Writer::new(io::BufWriter::with_capacity(1 << 16, &mut to));
    out.add_module("top").unwrap();
    let ids: Vec<_> = (0..WIDTHS.len()).map(|i| out.add_wire(WIDTHS[i], &format!("v{i}")).unwrap()).collect();
    out.upscope().unwrap();
    out.enddefinitions().unwrap();
    for now in 0..TICKS {
        out.timestamp(now).unwrap();
        for (i, &width) in WIDTHS.iter().enumerate() {
            let value = value(i, now);
            let bit = |at: u32| if value >> at & 1 == 1 { vcd::Value::V1 } else { vcd::Value::V0 };
            match width {
                1 => out.change_scalar(ids[i], bit(0)).unwrap(),
                _ => out.change_vector(ids[i], (0..width).rev().map(bit)).unwrap(),
            }
        }
    }
    out.flush().unwrap();
    drop(out);
    to.0
}

fn fst_ours() -> u64 {
    let mut to = Counted::default();
    ours(&mut FstWriter::new(&mut to));
    to.0
}

fn fst_crate() -> u64 {
    let info = FstInfo {
        start_time: 0,
        timescale_exponent: -9,
        version: String::new(),
        date: String::new(),
        file_type: FstFileType::Verilog,
    };
    let mut header = FstHeaderWriter::new(Cursor::new(Vec::new()), &info).unwrap();
    header.scope("top", "", FstScopeType::Module).unwrap();
    let var = |header: &mut FstHeaderWriter<_>, i: usize| {
        let bits = FstSignalType::bit_vec(WIDTHS[i]);
        header.var(format!("v{i}"), bits, FstVarType::Wire, FstVarDirection::Implicit, None).unwrap()
    };
    let ids: Vec<_> = (0..WIDTHS.len()).map(|i| var(&mut header, i)).collect();
    header.up_scope().unwrap();
    let mut body = header.finish().unwrap();
    let mut text = Vec::new();
    for now in 0..TICKS {
        body.time_change(now).unwrap();
        for (i, &width) in WIDTHS.iter().enumerate() {
            let value = value(i, now);
            text.clear();
            text.extend((0..width).rev().map(|at| b'0' + (value >> at & 1) as u8));
            body.signal_change(ids[i], &text).unwrap();
        }
    }
    body.finish().unwrap().into_inner().len() as u64
}

/// Bytes, and the seconds they took.
fn timed(way: impl Fn() -> u64) -> (u64, f64) {
    let begin = seconds();
    let bytes = way();
    (bytes, seconds() - begin)
}

fn by_batch(records: &[Vec<u64>], fst: bool) -> (u64, f64) {
    let mut to = Counted::default();
    let taken = match fst {
        false => batches(&mut VcdWriter::new(&mut to), records.to_vec()),
        true => batches(&mut FstWriter::new(&mut to), records.to_vec()),
    };
    (to.0, taken)
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

fn values() {
    let records = records();
    type Way<'r> = &'r dyn Fn() -> (u64, f64);
    let ways: [(&str, Way<'_>); 6] = [
        ("VCD, ours", &|| timed(vcd_ours)),
        ("VCD, ours, by the batch", &|| by_batch(&records, false)),
        ("VCD, crate `vcd`", &|| timed(vcd_crate)),
        ("FST, ours", &|| timed(fst_ours)),
        ("FST, ours, by the batch", &|| by_batch(&records, true)),
        ("FST, crate `fst-writer`", &|| timed(fst_crate)),
    ];
    let mut times = [const { Vec::new() }; 6];
    let mut bytes = [0; 6];
    for _ in 0..RUNS {
        for (i, (_, way)) in ways.iter().enumerate() {
            let (length, taken) = way();
            bytes[i] = length;
            times[i].push(taken);
        }
    }
    // the same values come to the same bytes, whatever way they take
    assert_eq!((bytes[0], bytes[3]), (bytes[1], bytes[4]));
    let values = TICKS as f64 * WIDTHS.len() as f64;
    println!("{:26}{:>12}{:>14}", "", "ns a value", "bytes a tick");
    let medians = times.map(|t| median(t) / values * 1e9);
    for (i, (name, _)) in ways.iter().enumerate() {
        println!("{name:26}{:>12.1}{:>14.1}", medians[i], bytes[i] as f64 / TICKS as f64);
    }
    println!(
        "the crates take {:.1} times (VCD) and {:.1} times (FST) as long as ours by the batch",
        medians[2] / medians[1],
        medians[5] / medians[4]
    );
}

fn main() {
    values();
    #[cfg(feature = "compiled")]
    traced::choices();
}

/// A long line at register level, of which nothing, a net that changes once, a register or everything is traced.
#[cfg(feature = "compiled")]
mod traced {
    use std::path::Path;
    use std::sync::atomic::AtomicBool;

    use discreta::Value;
    use discreta::cell::Clock;
    use discreta::engine::CompiledEngine;
    use discreta::netlist::{Netlist, SignalId};
    use discreta::scenario::{Control, DrivenClock, Event, Scenario, run};
    use discreta::wave::Sink;
    use discreta::wave::vcd::VcdWriter;

    use super::{Counted, RUNS, median, seconds};

    /// Clocks of a short run, which is taken off a long one, so that the making of code is not in it.
    const SHORT: u64 = 1_000;
    const CLOCKS: u64 = 2_000_000;
    const PERIOD: u64 = 20;

    /// Seconds and bytes of so many clocks.
    fn go(netlist: &Netlist, trace: &[SignalId], clocks: u64) -> (f64, u64) {
        let set = |name: &str, value: u64| {
            let net = netlist.bits(netlist.find(name).expect("the circuit has it"))[0].net;
            (net, Value::from_u64(value, netlist.net(net).width))
        };
        let clock = Clock { period: PERIOD, high: PERIOD / 2, phase: PERIOD };
        let scenario = Scenario {
            clocks: vec![DrivenClock { name: "dt".into(), net: set("dt", 0).0, clock }],
            inputs: vec![set("dx", 0xff_ffff), set("dy", 0x9a_bcde), set("xh", 0), set("yh", 0), set("start", 1)],
            stimulus: vec![Event { time: 5, sets: vec![set("start", 0)] }],
            limit: PERIOD * clocks,
            limit_given: true,
            trace: trace.to_vec(),
            ..Scenario::default()
        };
        let mut engine = CompiledEngine::new(netlist).expect("registers are compiled");
        let mut to = Counted::default();
        let mut vcd = VcdWriter::new(&mut to);
        let sink: Option<&mut dyn Sink> = if trace.is_empty() { None } else { Some(&mut vcd) };
        let mut control = Control {
            interrupt: &AtomicBool::new(false),
            progress: &mut |_| {},
            message: &mut |_, _, _| {},
            unknown_control_ends: false,
            observers: Vec::new(),
        };
        let begin = seconds();
        run(netlist, &scenario, &mut engine, sink, &mut control).expect("it settles");
        let taken = seconds() - begin;
        drop(vcd);
        (taken, to.0)
    }

    pub fn choices() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("circuits/evaluation/line.json");
        let circuit = discreta::circuit::load_with(file, &[("W", 24)]).expect("it is shipped");
        let netlist = &circuit.netlist;
        let named = |name: &str| vec![netlist.find(name).expect("the circuit has it")];
        let choices: [(&str, Vec<SignalId>); 4] = [
            ("nothing", Vec::new()),
            ("`end`, which stays", named("end")),
            ("`f`, 25 bits", named("f")),
            ("everything", netlist.signal_ids().collect()),
        ];
        let mut times = [const { Vec::new() }; 4];
        let mut bytes = [0; 4];
        for _ in 0..RUNS {
            for (i, (_, trace)) in choices.iter().enumerate() {
                let (short, long) = (go(netlist, trace, SHORT), go(netlist, trace, CLOCKS));
                times[i].push((long.0 - short.0) / (CLOCKS - SHORT) as f64 * 1e9);
                bytes[i] = long.1;
            }
        }
        println!("\n{:26}{:>12}{:>14}{:>12}", "traced, of the line", "ns a clock", "bytes a clock", "variables");
        for ((times, bytes), (name, trace)) in times.into_iter().zip(bytes).zip(&choices) {
            let (ns, bytes) = (median(times), bytes as f64 / CLOCKS as f64);
            println!("{name:26}{ns:>12.1}{bytes:>14.1}{:>12}", trace.len());
        }
    }
}
