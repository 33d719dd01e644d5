//! The oracles are a model of what was recorded, `wellen`, which reads FST by a crate of another author, and GTKWave's `fst2vcd`.

use proptest::prelude::*;

use super::*;
use crate::Sink;
use crate::output::{Output, OutputError};
use crate::read::Waves;
use crate::samples::{check_values, end, layout, model, record, runs, sample, wellen_agrees};
use crate::value::Word;

proptest! {
    #[test]
    fn what_was_written_is_read((widths, steps, tail) in runs()) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.fst");
        let layout = layout(&widths);
        record(&mut FstWriter::new(Output::create(&path).unwrap()), &layout, &steps, tail);
        check_values(&path, &layout, &model(&widths, &steps));
        wellen_agrees(&path);
        prop_assert_eq!(Waves::open(&path).unwrap().end(), end(&steps, tail).max(1));
    }
}

/// A bit and a vector of each name, and an alias of another scope that is declared first.
#[test]
fn names_of_all_kinds_are_read_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.fst");
    let mut layout = Layout::default();
    let top = layout.scope("top", None);
    let inner = layout.scope("u.1[2]", Some(top));
    let last = layout.scope("last", None);
    let mut steps = Vec::new();
    for name in ["a", "b.c", "größe", "e=f", "$h$1"] {
        let vector = layout.var(last, name, 4);
        let bit = layout.var(inner, name, 1);
        layout.alias(top, name, vector);
        steps.extend([(1, vector, "4'b10xz".parse().unwrap()), (0, bit, "1'b1".parse().unwrap())]);
    }
    let widths: Vec<u32> = layout.vars.iter().map(|var| var.width).collect();
    let mut expected = model(&widths, &steps);
    expected.get_mut(&0).unwrap().retain(|&var, _| layout.vars[var].alias_of.is_none());
    record(&mut FstWriter::new(Output::create(&path).unwrap()), &layout, &steps, 1);
    check_values(&path, &layout, &expected);
}

/// As VCD again, by GTKWave's own library.
#[test]
fn gtkwave_takes_it() {
    let (widths, steps) = sample();
    let layout = layout(&widths);
    let dir = tempfile::tempdir().unwrap();
    let (fst, vcd) = (dir.path().join("a.fst"), dir.path().join("a.vcd"));
    record(&mut FstWriter::new(Output::create(&fst).unwrap()), &layout, &steps, 1);
    match std::process::Command::new("fst2vcd").arg("-f").arg(&fst).arg("-o").arg(&vcd).output() {
        Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
        Err(error) => panic!("cannot run fst2vcd, of the Debian package gtkwave: {error}"),
    }
    check_values(&vcd, &layout, &model(&widths, &steps));
}

/// GTKWave's library makes room for what a section says it needs, and unpacks changes that are the same once each.
#[test]
fn gtkwave_has_room_for_many_that_are_the_same() {
    const SAME: usize = 200;
    const TICKS: u64 = 10_000;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.fst");
    let mut fst = FstWriter::new(Output::create(&path).unwrap());
    fst.begin(&layout(&[64; SAME])).unwrap();
    for now in 0..TICKS {
        fst.time(now).unwrap();
        let value = now.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (0..SAME).for_each(|var| fst.change(var, &[Word::known(value)]));
    }
    fst.finish(TICKS).unwrap();
    let output = std::process::Command::new("fst2vcd").arg(&path).output().expect("of the Debian package gtkwave");
    assert!(output.status.success(), "{}", output.status);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().filter(|line| line.starts_with('b')).count() as u64, SAME as u64 * TICKS);
}

/// Changes go to the file in sections, and all of them are read back.
#[test]
fn memory_does_not_grow_with_the_run() {
    const TICKS: u64 = 1_500_000;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.fst");
    let mut fst = FstWriter::new(Output::create(&path).unwrap());
    fst.begin(&layout(&[1, 64])).unwrap();
    let mut most = 0;
    for now in 0..TICKS {
        fst.time(now).unwrap();
        fst.change(0, &[Word::known(now & 1)]);
        fst.change(1, &[Word::known(now.wrapping_mul(0x9e37_79b9_7f4a_7c15))]);
        most = most.max(fst.format().section.size());
    }
    fst.finish(TICKS).unwrap();
    assert!((SECTION..SECTION + 1000).contains(&most), "{most}");

    let mut waves = Waves::open(&path).unwrap();
    let wide = waves.find("top.stage[0].v1").unwrap();
    let mut now = 0_u64;
    for (time, value) in waves.load(wide).unwrap().changes() {
        assert_eq!((time, value), (now, format!("{:064b}", now.wrapping_mul(0x9e37_79b9_7f4a_7c15))));
        now += 1;
    }
    assert_eq!(now, TICKS);
}

#[test]
fn a_name_that_is_too_long_is_an_error_before_anything_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.fst");
    let mut long = layout(&[1]);
    long.vars[0].name = "n".repeat(LONGEST);
    let error = FstWriter::new(Output::create(&path).unwrap()).begin(&long).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    assert!(error.to_string().contains("up to 498 bytes"), "{error}");
    assert!(!path.exists());
}

#[test]
fn a_place_without_a_way_back_is_an_error() {
    let error = FstWriter::new(Output::create("-".as_ref()).unwrap()).begin(&layout(&[1])).unwrap_err();
    assert_eq!(OutputError::of(&error).unwrap().kind(), io::ErrorKind::NotSeekable);
}
