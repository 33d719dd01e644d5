use std::io::Write;

use proptest::prelude::*;

use super::*;
use crate::output::{Destination, Output};
use crate::samples::{layout, record, runs};
use crate::vcd::VcdWriter;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn the_bytes_are_those_of_the_sink_itself((widths, steps, tail) in runs()) {
        let layout = layout(&widths);
        let mut expected = Vec::new();
        record(&mut VcdWriter::new(&mut expected), &layout, &steps, tail);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vcd");
        record(&mut Background::new(VcdWriter::new(Output::create(&path).unwrap())), &layout, &steps, tail);
        prop_assert_eq!(std::fs::read(&path).unwrap(), expected);
    }
}

/// Many more than fit into the batches that may wait.
#[test]
fn nothing_is_lost_or_out_of_order() {
    let steps: Vec<_> = (0..10 * BATCH as u64 * WAITING as u64)
        .map(|n| (n % 2, (n % 3) as usize, crate::Value::from_u64(n, [1, 8, 70][(n % 3) as usize])))
        .collect();
    let layout = layout(&[1, 8, 70]);
    let mut expected = Vec::new();
    record(&mut VcdWriter::new(&mut expected), &layout, &steps, 1);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.vcd");
    record(&mut Background::new(VcdWriter::new(Output::create(&path).unwrap())), &layout, &steps, 1);
    assert!(std::fs::read(&path).unwrap() == expected);
}

/// Takes so many bytes and then no more.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Destination for Full {
    fn complete(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_fault_is_told_once_and_ends_it() {
    let layout = layout(&[64]);
    let mut sink = Background::new(VcdWriter::new(Full(1_000_000)));
    sink.begin(&layout).unwrap();
    let mut told = None;
    for now in 0..10_000_000 {
        if let Err(error) = sink.time(now) {
            told = Some(error.kind());
            break;
        }
        sink.change(0, &[Word::known(now)]);
    }
    assert_eq!(told, Some(io::ErrorKind::StorageFull));

    let mut sink = Background::new(VcdWriter::new(Full(300)));
    sink.begin(&layout).unwrap();
    for now in 0..10 {
        sink.time(now).unwrap();
        sink.change(0, &[Word::known(now)]);
    }
    assert_eq!(sink.finish(10).unwrap_err().kind(), io::ErrorKind::StorageFull);
}

#[test]
fn dropped_before_it_is_complete_nothing_is_left() {
    let dir = tempfile::tempdir().unwrap();
    let mut sink = Background::new(VcdWriter::new(Output::create(&dir.path().join("a.vcd")).unwrap()));
    sink.begin(&layout(&[1])).unwrap();
    sink.time(0).unwrap();
    drop(sink);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}
