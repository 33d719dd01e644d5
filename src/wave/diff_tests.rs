use std::path::Path;

use super::*;
use crate::Unit;
use crate::value::{Value, Word};
use crate::vcd::VcdWriter;
use crate::{Layout, Sink};

const ICARUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/waves/counter.vcd");
const FST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/waves/counter.fst");

/// `body` behind a header with `top.clk`, `top.q [3:0]` and, in `top.fa[3]`, `s`.
fn vcd(timescale: &str, body: &str) -> String {
    format!(
        "$timescale {timescale} $end $scope module top $end $var wire 1 ! clk $end $var wire 4 \" q [3:0] $end \
         $scope module fa[3] $end $var wire 1 # s $end $upscope $end $upscope $end $enddefinitions $end\n{body}"
    )
}

fn compare_with(a: &str, b: &str, options: &Options) -> Difference {
    let dir = tempfile::tempdir().unwrap();
    let open = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::write(&path, text).unwrap();
        Waves::open(&path).unwrap()
    };
    let mut difference = diff(&mut open("a.vcd", a), &mut open("b.vcd", b), options).unwrap();
    difference.a.name = "a.vcd".into();
    difference.b.name = "b.vcd".into();
    difference
}

fn compare(a: &str, b: &str) -> Difference {
    compare_with(a, b, &Options::default())
}

/// A clock of 10 ticks with `q` counting its rising edges, and `wrong` at one of them.
fn counting(edges: u32, wrong: Option<u32>) -> String {
    let mut body = String::from("#0\n0!\nb0000 \"\n0#\n");
    for n in 1..=edges {
        let q = if wrong == Some(n) { 15 } else { n & 7 };
        body += &format!("#{}\n1!\nb{q:04b} \"\n#{}\n0!\n", n * 10, n * 10 + 5);
    }
    vcd("1 ns", &body)
}

#[test]
fn the_same_with_any_way_of_saying_so() {
    // Extended from the left, said twice, undone within a tick, in another order, by another name of the unit.
    let a = vcd("1 ns", "#0\n0!\nbx \"\n#5\nb1 \"\n1!\n#9\n");
    let b = vcd("1ns", "#0\n$dumpvars\nbxxxx \"\n0!\n$end\n#2\n0!\n#5\n0!\n1!\nb0110 \"\nb0001 \"\n#9\n");
    let difference = compare(&a, &b);
    assert!(difference.same, "{difference}");
    assert_eq!(difference.compared, 3);
    assert_eq!(difference.to_string(), "The same: 3 signals until 9 ns.\n");
}

#[test]
fn the_report_of_a_wrong_value() {
    let difference = compare(&counting(12, Some(7)), &counting(12, None));
    assert!(!difference.same);
    assert_eq!((difference.first, difference.differing, difference.compared), (Some(70), 1, 3));
    let expected = "\
a  a.vcd  ends at 125 ns
b  b.vcd  ends at 125 ns

First difference at 70 ns: top.q (after 7 rising edges of top.clk)

     time  top.clk  a          b
    45 ns  0        0100 (4)   0100 (4)
    50 ns  1        0101 (5)   0101 (5)
    55 ns  0        0101 (5)   0101 (5)
    60 ns  1        0110 (6)   0110 (6)
    65 ns  0        0110 (6)   0110 (6)
  > 70 ns  1        1111 (15)  0111 (7)
    75 ns  0        1111 (15)  0111 (7)
    80 ns  1        0000 (0)   0000 (0)
    85 ns  0        0000 (0)   0000 (0)
    90 ns  1        0001 (1)   0001 (1)
    95 ns  0        0001 (1)   0001 (1)

1 of 3 signals differ:
     time  signal  a          b
    70 ns  top.q   1111 (15)  0111 (7)
";
    assert_eq!(difference.to_string(), expected);
}

#[test]
fn a_difference_before_the_clock_starts() {
    let report = compare(&counting(4, None), &counting(4, None).replacen("b0000", "b0001", 1)).to_string();
    assert!(report.contains("First difference at 0 ns: top.q (before any rising edge of top.clk)"), "{report}");
}

#[test]
fn the_order_is_that_of_time_and_what_is_shown_is_bounded() {
    let a = vcd("1 ns", "#0\n0!\nb0000 \"\n0#\n#5\n1!\n#6\n1#\n#9\n");
    let b = vcd("1 ns", "#0\n0!\nb0000 \"\n0#\n#3\nb0010 \"\n#6\n0#\n#9\n");
    let difference = compare(&a, &b);
    let found: Vec<_> = difference.signals.iter().map(|s| (s.time, s.name.as_str(), &*s.a, &*s.b)).collect();
    assert_eq!(found, [(3, "top.q", "0000", "0010"), (5, "top.clk", "1", "0"), (6, "top.fa[3].s", "1", "0")]);

    let difference = compare_with(&a, &b, &Options { max_signals: 2, ..Options::default() });
    assert_eq!((difference.differing, difference.signals.len()), (3, 2));
    assert!(difference.to_string().contains("… and 1 more"), "{difference}");
}

#[test]
fn x_is_compared_exactly_unless_one_side_does_not_care() {
    let [x, one] = ["#0\nb1x0x \"\n#9\n", "#0\nb1100 \"\n#9\n"].map(|body| vcd("1 ns", body));
    let same = |a, b, side| compare_with(a, b, &Options { x_as_dont_care: side, ..Options::default() }).same;
    assert!(!same(&x, &one, None));
    assert!(same(&x, &one, Some(Side::A)));
    assert!(!same(&x, &one, Some(Side::B)));
    assert!(same(&one, &x, Some(Side::B)));
    assert!(!same(&one, &x, Some(Side::A)));
    let other = vcd("1 ns", "#0\nb0100 \"\n#9\n");
    assert!(!same(&x, &other, Some(Side::A)));
}

#[test]
fn what_has_no_value_yet_is_x() {
    let a = vcd("1 ns", "#0\n0!\n#5\nb0001 \"\n#9\n");
    assert!(compare(&a, &vcd("1 ns", "#0\n0!\nbx \"\nx#\n#5\nb0001 \"\n#9\n")).same);
    let difference = compare(&a, &vcd("1 ns", "#0\n0!\nb0 \"\n#5\nb0001 \"\n#9\n"));
    assert_eq!(difference.signals[0].a, "xxxx");
    assert_eq!(difference.first, Some(0));
}

#[test]
fn timescales_are_brought_to_the_finer_one() {
    let a = vcd("10 ns", "#0\n0!\n#5\n1!\n#9\n");
    let b = vcd("100ps", "#0\n0!\n#500\n1!\n#900\n");
    assert!(compare(&a, &b).same);
    let difference = compare(&a, &vcd("100ps", "#0\n0!\n#501\n1!\n#900\n"));
    assert_eq!(difference.timescale, Timescale::new(100, Unit::Ps));
    assert_eq!(difference.first, Some(500));
    assert!(difference.to_string().contains("First difference at 50000 ps: top.clk"), "{difference}");
    let late = vcd("1 s", &format!("#0\n0!\n#{}\n", u64::MAX / 2));
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("a"), late).unwrap();
    std::fs::write(dir.path().join("b"), &b).unwrap();
    let [mut a, mut b] = ["a", "b"].map(|name| Waves::open(&dir.path().join(name)).unwrap());
    let error = diff(&mut a, &mut b, &Options::default()).unwrap_err().to_string();
    assert!(error.ends_with("is too large for the timescale of the other"), "{error}");
}

#[test]
fn an_earlier_end_is_a_difference_of_its_own() {
    let a = vcd("1 ns", "#0\n0!\n#10\n1!\n");
    let b = vcd("1 ns", "#0\n0!\n#10\n1!\n#20\n0!\n");
    let difference = compare(&a, &b);
    assert!(!difference.same && difference.ends_differ);
    assert_eq!(difference.differing, 0);
    assert_eq!(
        difference.to_string(),
        "a  a.vcd  ends at 10 ns\nb  b.vcd  ends at 20 ns\n\n\
         They end at different times; compared until 10 ns, where a ends.\n"
    );
    assert!(compare_with(&a, &b, &Options { ignore_end: true, ..Options::default() }).same);
}

#[test]
fn what_only_one_has_and_what_is_of_another_width() {
    let a = "$timescale 1 ns $end $scope module t $end $var wire 1 ! p $end $var wire 8 \" q $end $var real 64 $ r $end \
             $upscope $end $enddefinitions $end\n#0\n1!\n";
    let b = "$timescale 1 ns $end $scope module t $end $var wire 1 ! o $end $var wire 4 \" q $end $var wire 64 $ r $end \
             $upscope $end $enddefinitions $end\n#0\n1!\n";
    let difference = compare(a, b);
    assert!(!difference.same);
    let expected = "\
a  a.vcd  ends at 0 ns
b  b.vcd  ends at 0 ns

2 signals not compared, not of one kind:
    signal  a              b
    t.q     8 bits         4 bits
    t.r     a real number  64 bits

1 signal only in a:
    t.p

1 signal only in b:
    t.o

No signal was compared.
";
    assert_eq!(difference.to_string(), expected);
}

#[test]
fn numbers_text_and_events() {
    let file = |body: &str| {
        format!(
            "$timescale 1 ns $end $scope module t $end $var real 64 ! r $end $var string 1 \" s $end \
             $var event 1 # e $end $upscope $end $enddefinitions $end\n{body}"
        )
    };
    let a = file("#0\nr1.5 !\nsidle \"\n#5\n1#\nrnan !\n#9\n");
    assert!(compare(&a, &a).same);
    let found = |b: &str| {
        let difference = compare(&a, &file(b));
        let s = difference.signals.first().expect("differs").clone();
        (s.name, s.time, s.a, s.b)
    };
    let expect = |name: &str, time, a: &str, b: &str| (name.to_owned(), time, a.to_owned(), b.to_owned());
    assert_eq!(found("#0\nr2.5 !\nsidle \"\n#5\n1#\nrnan !\n#9\n"), expect("t.r", 0, "1.5", "2.5"));
    assert_eq!(found("#0\nr1.5 !\nsbusy \"\n#5\n1#\nrnan !\n#9\n"), expect("t.s", 0, "idle", "busy"));
    assert_eq!(found("#0\nr1.5 !\nsidle \"\n#5\nrnan !\n#6\n1#\n#9\n"), expect("t.e", 5, "event", ""));
}

#[test]
fn icarus_and_gtkwave_agree_about_one_run() {
    let [mut vcd, mut fst] = [ICARUS, FST].map(|path| Waves::open(Path::new(path)).unwrap());
    let difference = diff(&mut vcd, &mut fst, &Options::default()).unwrap();
    assert!(difference.same, "{difference}");
    assert_eq!(difference.compared, 8);
}

/// The circuit of `tests/waves/counter.v`, by hand, written by our writer: as Icarus has it.
#[test]
fn our_writer_and_icarus_agree() {
    let mut layout = Layout::default();
    let top = layout.scope("top", None);
    let dut = layout.scope("dut", Some(top));
    let [q, t] = [("q", 8), ("t", 4)].map(|(name, width)| layout.var(top, name, width));
    let [clk, reset] = ["clk", "reset"].map(|name| layout.var(top, name, 1));
    for (name, of) in [("q", q), ("t", t), ("clk", clk), ("reset", reset)] {
        layout.alias(dut, name, of);
    }
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("ours.vcd");
    let mut sink = VcdWriter::new(crate::output::Output::create(&path).unwrap());
    sink.begin(&layout).unwrap();
    let mut count: Option<u64> = None;
    for now in 0..112 {
        sink.time(now).unwrap();
        if now % 5 == 0 {
            sink.change(clk, &[Word::known(now / 5 % 2)]);
        }
        match now {
            3 => sink.change(reset, &[Word::known(1)]),
            12 => sink.change(reset, &[Word::known(0)]),
            _ => {}
        }
        if (3..12).contains(&now) {
            count = Some(0);
        } else if now % 10 == 5 {
            count = count.map(|n| n + 3);
        }
        if let Some(n) = count {
            sink.change(q, &[Word::known(n)]);
            let odd: Value = "4'bz01x".parse().unwrap();
            let value = if n % 2 == 1 { odd } else { Value::from_u64(n, 4) };
            sink.change(t, &value.words().collect::<Vec<_>>());
        }
    }
    sink.finish(112).unwrap();
    drop(sink);

    let [mut ours, mut icarus] = [&*path, Path::new(ICARUS)].map(|path| Waves::open(path).unwrap());
    let difference = diff(&mut ours, &mut icarus, &Options::default()).unwrap();
    assert!(difference.same, "{difference}");
    assert_eq!(difference.compared, 8);
}

#[test]
fn as_json() {
    let difference = compare(&counting(3, Some(2)), &counting(3, None));
    let json = serde_json::to_value(&difference).unwrap();
    assert_eq!(json["same"], false);
    assert_eq!(json["timescale"], "1ns");
    assert_eq!(json["first"], 20);
    let signals = serde_json::json!([{ "name": "top.q", "time": 20, "a": "1111", "b": "0010" }]);
    assert_eq!(json["signals"], signals);
    assert_eq!(json["context"]["clock"], "top.clk");
    assert_eq!(json["context"]["clock_edges"], 2);
}
