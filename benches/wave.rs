//! What a value costs in a waveform: our own writing of VCD's and FST's values beside that of the crates `vcd` and
//! `fst-writer`, the same values, in turns.
//!
//!     cargo bench --bench wave

use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::time::Instant;

use discreta::value::Word;
use discreta::wave::fst::FstWriter;
use discreta::wave::output::Destination;
use discreta::wave::vcd::VcdWriter;
use discreta::wave::{Layout, Sink};
use fst_writer::{FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalType, FstVarDirection, FstVarType};

/// Runs of which the median is taken.
const RUNS: usize = 7;
const TICKS: u64 = 100_000;
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

fn ours(sink: &mut dyn Sink) {
    let mut layout = Layout::default();
    let top = layout.scope("top", None);
    for (i, &width) in WIDTHS.iter().enumerate() {
        layout.var(top, &format!("v{i}"), width);
    }
    sink.begin(&layout).unwrap();
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

fn main() {
    type Way = fn() -> u64;
    let ways: [(&str, Way); 4] = [
        ("VCD, ours", vcd_ours),
        ("VCD, crate `vcd`", vcd_crate),
        ("FST, ours", fst_ours),
        ("FST, crate `fst-writer`", fst_crate),
    ];
    let mut times = [const { Vec::new() }; 4];
    let mut bytes = [0; 4];
    for _ in 0..RUNS {
        for (i, (_, way)) in ways.iter().enumerate() {
            let begin = Instant::now();
            bytes[i] = way();
            times[i].push(begin.elapsed().as_secs_f64());
        }
    }
    let values = TICKS as f64 * WIDTHS.len() as f64;
    println!("{:26}{:>12}{:>14}", "", "ns a value", "bytes a tick");
    let mut medians = [0.0; 4];
    for (i, (name, _)) in ways.iter().enumerate() {
        times[i].sort_unstable_by(f64::total_cmp);
        medians[i] = times[i][RUNS / 2] / values * 1e9;
        println!("{name:26}{:>12.1}{:>14.1}", medians[i], bytes[i] as f64 / TICKS as f64);
    }
    println!(
        "the crates take {:.1} times (VCD) and {:.1} times (FST) as long",
        medians[1] / medians[0],
        medians[3] / medians[2]
    );
}
