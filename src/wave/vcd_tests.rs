//! The oracles are the `vcd` crate's own writer of values, `wellen`, a reader, and GTKWave's `vcd2fst`.

use needs::needs;
use proptest::prelude::*;

use super::*;
use crate::Sink;
use crate::read::Waves;
use crate::samples::{Step, check_values, end, layout, model, record, runs, sample, wellen_agrees};
use crate::value::{Logic, Value};

fn write(layout: &Layout, steps: &[Step], tail: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    record(&mut VcdWriter::new(&mut bytes), layout, steps, tail);
    bytes
}

fn bits(value: &Value) -> impl Iterator<Item = vcd::Value> {
    value.bits().map(|bit| match bit {
        Logic::Zero => vcd::Value::V0,
        Logic::One => vcd::Value::V1,
        Logic::X => vcd::Value::X,
        Logic::Z => vcd::Value::Z,
    })
}

/// The same by the `vcd` crate alone, value by value.
fn reference(widths: &[u32], steps: &[Step], tail: u64) -> Vec<u8> {
    let mut out = vcd::Writer::new(Vec::new());
    out.version("discreta").unwrap();
    out.timescale(1, TimescaleUnit::NS).unwrap();
    let mut ids = vec![IdCode::FIRST];
    for _ in widths {
        ids.push(ids.last().unwrap().next());
    }
    let var = |out: &mut vcd::Writer<Vec<u8>>, i: usize, name: &str| {
        let kind = [VarType::Wire, VarType::Reg, VarType::Integer][i % 3];
        let range = (widths[i] > 1).then(|| ReferenceIndex::Range(widths[i] as i32 - 1, 0));
        out.var_def(kind, widths[i], ids[i], name, range).unwrap();
    };
    let vars = |out: &mut vcd::Writer<Vec<u8>>, scope: usize| {
        (scope..widths.len()).step_by(3).for_each(|i| var(out, i, &format!("v{i}")));
    };
    out.add_module("top").unwrap();
    vars(&mut out, 0);
    out.scope_def(ScopeType::Begin, "stage[0]").unwrap();
    vars(&mut out, 1);
    out.upscope().unwrap();
    out.upscope().unwrap();
    out.add_module("other").unwrap();
    vars(&mut out, 2);
    var(&mut out, 0, "again");
    out.upscope().unwrap();
    out.enddefinitions().unwrap();

    let ticks = model(widths, steps);
    for (&time, changes) in &ticks {
        out.timestamp(time).unwrap();
        if time == 0 {
            out.begin(SimulationCommand::Dumpvars).unwrap();
        }
        for (&var, value) in changes {
            match widths[var] {
                1 => out.change_scalar(ids[var], bits(value).next().unwrap()).unwrap(),
                _ => out.change_vector(ids[var], bits(value)).unwrap(),
            }
        }
        if time == 0 {
            out.end().unwrap();
        }
    }
    let end = end(steps, tail);
    if ticks.last_key_value().unwrap().0 != &end {
        out.timestamp(end).unwrap();
    }
    std::mem::take(out.writer())
}

proptest! {
    #[test]
    fn the_bytes_are_those_of_the_vcd_crate((widths, steps, tail) in runs()) {
        let ours = String::from_utf8(write(&layout(&widths), &steps, tail)).unwrap();
        let theirs = String::from_utf8(reference(&widths, &steps, tail)).unwrap();
        prop_assert_eq!(ours, theirs);
    }

    #[test]
    fn what_was_written_is_read((widths, steps, tail) in runs()) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vcd");
        let layout = layout(&widths);
        std::fs::write(&path, write(&layout, &steps, tail)).unwrap();
        check_values(&path, &layout, &model(&widths, &steps));
        wellen_agrees(&path);
        prop_assert_eq!(Waves::open(&path).unwrap().end(), end(&steps, tail));
    }

    #[test]
    fn the_order_within_a_tick_does_not_matter(
        (widths, mut steps, tail) in runs(), order in proptest::collection::vec(any::<u32>(), 40)
    ) {
        // One change a tick and variable, so that any order ends with the same values.
        let mut seen = std::collections::HashSet::new();
        let mut now = 0;
        for (distance, ..) in &mut steps {
            now += *distance;
            *distance = now;
        }
        steps.retain(|(now, var, _)| seen.insert((*now, *var)));
        let mut shuffled: Vec<_> = steps.iter().cloned().zip(order).collect();
        shuffled.sort_by_key(|((now, ..), order)| (*now, *order));
        let mut shuffled: Vec<Step> = shuffled.into_iter().map(|(step, _)| step).collect();
        for steps in [&mut steps, &mut shuffled] {
            let mut before = 0;
            for (now, ..) in steps {
                (*now, before) = (*now - before, *now);
            }
        }
        let layout = layout(&widths);
        prop_assert_eq!(write(&layout, &steps, tail), write(&layout, &shuffled, tail));
    }
}

/// The header must be whole; from there on the end of any line will do.
#[test]
fn cut_off_at_a_line_it_reads_as_the_run_up_to_there() {
    let (widths, steps) = sample();
    let bytes = write(&layout(&widths), &steps, 1);
    let text = std::str::from_utf8(&bytes).unwrap();
    let header = text.find("$enddefinitions $end\n").unwrap() + "$enddefinitions $end\n".len();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vcd");
    let whole = model(&widths, &steps);
    let mut cuts = 0;
    for (at, _) in text.match_indices('\n').filter(|(at, _)| at + 1 >= header) {
        let cut = &text[..=at];
        std::fs::write(&path, cut).unwrap();
        // Only whole ticks can be compared with the model: those before the last time that the cut has.
        let mut waves = Waves::open(&path).unwrap();
        let end = waves.end();
        for (i, name) in ["top.v0", "top.stage[0].v1", "other.v2"].into_iter().enumerate() {
            let var = waves.find(name).unwrap();
            let changes: Vec<_> = waves.load(var).unwrap().changes().filter(|(time, _)| *time < end).collect();
            let expected: Vec<_> =
                whole.range(..end).filter_map(|(&time, changes)| Some((time, changes.get(&i)?.bit_string()))).collect();
            assert_eq!(changes, expected, "{name} in\n{cut}");
        }
        cuts += 1;
    }
    assert!(cuts > 60, "{cuts}");
}

#[needs(vcd2fst)]
#[test]
fn gtkwave_takes_it() {
    let (widths, steps) = sample();
    let layout = layout(&widths);
    let dir = tempfile::tempdir().unwrap();
    let (vcd, fst) = (dir.path().join("a.vcd"), dir.path().join("a.fst"));
    std::fs::write(&vcd, write(&layout, &steps, 1)).unwrap();
    match std::process::Command::new("vcd2fst").arg(&vcd).arg(&fst).output() {
        Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
        Err(error) => panic!("cannot run vcd2fst, of the Debian package gtkwave: {error}"),
    }
    check_values(&fst, &layout, &model(&widths, &steps));
}

#[test]
fn the_whole_file() {
    let mut layout = Layout { timescale: crate::Timescale::new(10, Unit::Us).unwrap(), ..Layout::default() };
    let top = layout.scope("top", None);
    let adder = layout.scope("fa[3]", Some(top));
    let sum = layout.var(top, "sum", 4);
    let clock = layout.var(top, "clk", 1);
    layout.vars[sum].kind = VarKind::Reg;
    layout.alias(adder, "s", sum);
    let steps = [
        (0, clock, Value::from_u64(0, 1)),
        (5, clock, Value::from_u64(1, 1)),
        (0, sum, Value::from_u64(3, 4)),
        (0, sum, "4'b10xz".parse().unwrap()),
        // Undone within the tick, and written again as it was: neither shows.
        (5, clock, Value::from_u64(0, 1)),
        (0, clock, Value::from_u64(1, 1)),
        (1, sum, "4'b10xz".parse().unwrap()),
        (4, clock, Value::from_u64(0, 1)),
    ];
    let text = String::from_utf8(write(&layout, &steps, 5)).unwrap();
    let expected = "\
$version
    discreta
$end
$timescale 10 us $end
$scope module top $end
$var reg 4 ! sum [3:0] $end
$var wire 1 \" clk $end
$scope module fa[3] $end
$var reg 4 ! s [3:0] $end
$upscope $end
$upscope $end
$enddefinitions $end
#0
$dumpvars
bxxxx !
0\"
$end
#5
b10xz !
1\"
#15
0\"
#20
";
    assert_eq!(text, expected);
}

#[test]
fn time_that_goes_back_is_an_error() {
    let mut vcd = VcdWriter::new(Vec::new());
    vcd.begin(&layout(&[1])).unwrap();
    vcd.time(5).unwrap();
    assert_eq!(vcd.time(4).unwrap_err().to_string(), "time goes back from 5 to 4");
    assert_eq!(vcd.finish(4).unwrap_err().kind(), io::ErrorKind::InvalidInput);
}

#[test]
fn a_bad_name_is_an_error_before_anything_is_written() {
    let mut bad = layout(&[1]);
    bad.vars[0].name = "a b".into();
    let mut bytes = Vec::new();
    let error = VcdWriter::new(&mut bytes).begin(&bad).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    assert!(bytes.is_empty());
}

#[test]
fn no_identifier_ends_a_declaration() {
    let id = |text: &str| text.parse::<IdCode>().unwrap();
    assert_eq!(id("#end").next(), id("$end"));
    assert_eq!(following(id("#end")), id("%end"));
    assert_eq!(following(id("%end")), id("&end"));
}

/// What has been given to the destination is all but the last lines, however long the run.
#[test]
fn memory_does_not_grow_with_the_run() {
    let mut vcd = VcdWriter::new(Vec::new());
    vcd.begin(&layout(&[1, 64])).unwrap();
    for now in 0..200_000 {
        vcd.time(now).unwrap();
        vcd.change(0, &[Word::known(now & 1)]);
        vcd.change(1, &[Word::known(now)]);
        assert!(vcd.format().out.writer().capacity() <= 2 * CHUNK);
    }
    assert!(vcd.format().destination.len() > 100 * CHUNK);
    assert!(vcd.format().destination.ends_with(b"\n"));
}
