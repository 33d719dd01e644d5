use std::process::Command;

use needs::needs;
use proptest::prelude::*;

use super::*;
use crate::samples::wellen_agrees;

const ICARUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/waves/counter.vcd");
const FST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/waves/counter.fst");
const GHW: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/waves/ghdl.ghw");

const HEADER: &str = "$timescale 1 ns $end $scope module top $end $var wire 1 ! a $end $var wire 4 \" b $end \
                      $upscope $end $enddefinitions $end\n";

type Changes = Vec<(u64, String)>;

/// A file read as a whole.
#[derive(Debug)]
struct Whole {
    vars: Vec<(String, Changes)>,
    warnings: Vec<String>,
    left_out: Vec<(String, String)>,
    cut: bool,
    exponent: Option<i32>,
    end: u64,
}

impl Whole {
    fn of(&self, name: &str) -> &Changes {
        let found = self.vars.iter().find(|(var, _)| var == name);
        &found.unwrap_or_else(|| panic!("{name} not in {:?}", self.vars)).1
    }
}

fn whole(path: &Path) -> Result<Whole, ReadError> {
    let mut waves = Waves::open(path)?;
    let names: Vec<_> = waves.vars().iter().map(|var| var.name.clone()).collect();
    let all: Vec<usize> = (0..names.len()).collect();
    let loaded = waves.load_all(&all)?;
    let vars = names.into_iter().zip(loaded.iter().map(|series| series.changes().collect())).collect();
    let left_out = waves.left_out().iter().map(|out| (out.name.clone(), out.why.clone())).collect();
    let (warnings, cut, exponent, end) = (waves.warnings(), waves.is_cut(), waves.exponent(), waves.end());
    Ok(Whole { vars, warnings, left_out, cut, exponent, end })
}

/// Opens these bytes as a file and loads everything.
fn open(bytes: &[u8]) -> Result<Whole, String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.wave");
    std::fs::write(&path, bytes).unwrap();
    whole(&path).map_err(|error| error.to_string().replace(path.to_str().unwrap(), "FILE"))
}

/// A file with the header above.
fn vcd(body: &str) -> Whole {
    open(format!("{HEADER}{body}").as_bytes()).unwrap()
}

fn changes(file: &str, name: &str) -> Changes {
    let mut waves = Waves::open(Path::new(file)).unwrap();
    let var = waves.find(name).unwrap_or_else(|| panic!("{name} not in {:?}", waves.vars()));
    waves.load(var).unwrap().changes().collect()
}

fn text(changes: &[(u64, &str)]) -> Changes {
    changes.iter().map(|&(time, value)| (time, value.to_owned())).collect()
}

/// The values are what the Verilog beside the file says.
#[test]
fn what_icarus_wrote() {
    for file in [ICARUS, FST] {
        let waves = Waves::open(Path::new(file)).unwrap();
        assert_eq!((waves.warnings(), waves.left_out()), (vec![], &[][..]));
        assert_eq!(waves.timescale(), Some(Timescale::default()));
        assert_eq!(waves.end(), 112, "{file}");
        let names: Vec<_> = waves.vars().iter().map(|var| (var.name.as_str(), var.kind)).collect();
        assert!(names.contains(&("top.dut.q", ValueKind::Bits(8))), "{names:?}");
        assert_eq!(names.len(), 8);
        assert_eq!(changes(file, "top.reset"), text(&[(0, "x"), (3, "1"), (12, "0")]));
        let q = changes(file, "top.dut.q");
        assert_eq!(q[..4], text(&[(0, "xxxxxxxx"), (3, "00000000"), (15, "00000011"), (25, "00000110")]));
        let t = changes(file, "top.t");
        assert_eq!(t[..4], text(&[(0, "xxxx"), (3, "0000"), (15, "z01x"), (25, "0110")]));
        wellen_agrees(Path::new(file));
    }
}

/// A counter by GHDL, with a record, numbers, an enumeration, a vector of bits: what each clock of 5 ns does to it.
#[test]
fn what_ghdl_wrote() {
    let waves = Waves::open(Path::new(GHW)).unwrap();
    assert_eq!((waves.warnings(), waves.left_out(), waves.exponent()), (vec![], &[][..], Some(-15)));
    let kind = |name: &str| waves.vars()[waves.find(name).unwrap()].kind;
    assert_eq!([kind("t.clk"), kind("t.x"), kind("t.i")], [ValueKind::Bits(1), ValueKind::Real, ValueKind::Bits(32)]);
    let clock = changes(GHW, "t.clk");
    assert_eq!(clock[..3], text(&[(0, "0"), (5_000_000, "1"), (10_000_000, "0")]));
    let q: Vec<_> = changes(GHW, "t.q")
        .into_iter()
        .map(|(time, q)| (time / 5_000_000, u64::from_str_radix(&q, 2).unwrap()))
        .collect();
    assert_eq!(q, (0..=10).map(|n| (if n == 0 { 0 } else { 2 * n - 1 }, n)).collect::<Vec<_>>());
    let x: Vec<f64> = changes(GHW, "t.x").into_iter().map(|(_, x)| x.parse().unwrap()).collect();
    assert!(x.windows(2).all(|pair| pair[1] == 1.5 * pair[0]), "{x:?}");
}

#[test]
fn parts_of_a_vector_are_joined_and_names_given_twice_told_apart() {
    let file = "$scope module top $end $var wire 1 ! q [0] $end $var wire 1 \" q [1] $end $var wire 2 # p [3:2] $end \
                $var wire 2 $ p [1:0] $end $var wire 1 % r $end $var wire 1 & r $end $upscope $end \
                $scope module fa[3] $end $var wire 1 ' s $end $upscope $end $enddefinitions $end\n#0\n1!\n0\"\nb1x #\n";
    let read = open(file.as_bytes()).unwrap();
    assert_eq!(read.vars[0].1, text(&[(0, "01")]));
    assert_eq!(read.vars[1].1, text(&[(0, "1xxx")]));
    let names: Vec<_> = read.vars.into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["top.q", "top.p", "top.r", "top.r#2", "fa[3].s"]);
}

/// Elements of arrays as Verilator and Icarus write them, at any depth.
#[test]
fn elements_of_arrays_are_below_their_array() {
    let file = "$scope module top $end $var wire 8 ! mem[3] [7:0] $end $var wire 8 \" deep[1][2] [7:0] $end \
                $var wire 1 # \\odd[x] $end $upscope $end $enddefinitions $end\n#0\nb101 !\n";
    let names: Vec<_> = open(file.as_bytes()).unwrap().vars.into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["top.mem.[3]", "top.deep.[1].[2]", "top.odd.[x]"]);
}

#[test]
fn a_file_that_ends_with_its_header_has_no_values() {
    let file = "$scope module top $end $var wire 1 ! q $end $upscope $end $enddefinitions $end\n";
    let read = open(file.as_bytes()).unwrap();
    assert_eq!((read.vars, read.cut, read.warnings), (vec![("top.q".into(), vec![])], false, vec![]));
}

/// What GTKWave takes for harmless is read, with a word about it where something is not as it says.
#[test]
fn oddities_are_read() {
    /// The body, what `a` and `b` do, and the beginning of the warning.
    type Case = (&'static str, Steps, Steps, &'static str);
    type Steps = &'static [(u64, &'static str)];
    let cases: &[Case] = &[
        ("#0\n1!\n#5\n0!", &[(0, "1"), (5, "0")], &[], "its last line (5) has no end"),
        (
            "#5\n1!\n#3\n0!\n#4\n1!\n#9\n0!\n",
            &[(5, "1"), (9, "0")],
            &[],
            "line 4: time goes back from 5 to 3; it is taken to stand still (and 1 more)",
        ),
        (
            "#3.2\n1!\n#5.9\n0!\n",
            &[(3, "1"), (5, "0")],
            &[],
            "line 2: the time `3.2` is between two ticks; it is taken as 3 (and 1 more)",
        ),
        ("#1e1\n1!\n#20.0\n0!\n", &[(10, "1"), (20, "0")], &[], ""),
        ("#zero\n1!\n#2\n0!\n", &[(0, "1"), (2, "0")], &[], "line 2: `#zero` is no time"),
        ("1!\n#3\n0!\n", &[(0, "1"), (3, "0")], &[], ""),
        ("#0\n1?\n1!\n", &[(0, "1")], &[], "line 3: the value of `?` is passed over: no variable is called so"),
        ("#0\nhello !\n1!\n", &[(0, "1")], &[], "line 3: the value of `ello` is passed over"),
        ("#0 1! b1 \" #2 0!\n", &[(0, "1"), (2, "0")], &[(0, "0001")], ""),
        ("#0\n$dumpvars\nx!\nbx \"\n$end\n#1\n$dumpoff\nz!\n$end\n", &[(0, "x"), (1, "z")], &[(0, "xxxx")], ""),
        ("$comment #9 $enddefinitions $end\n#0\n1!\n", &[(0, "1")], &[], ""),
        ("#0\nb000001 \"\nbxxxxxx \"\nb00x \"\n", &[], &[(0, "000x")], ""),
        ("#0\nbU1-H \"\nL!\n#1\nbW \"\nH!\n", &[(0, "0"), (1, "1")], &[(0, "x1x1"), (1, "xxxx")], ""),
        ("#0\n$dumpports\npD 6 0 !\npUNZL 0 0 \"\n$end\n", &[(0, "0")], &[(0, "1xz0")], ""),
        ("#0\n1!\n$vcdclose #7 $end\n", &[(0, "1")], &[], ""),
    ];
    for (body, a, b, warning) in cases {
        let read = vcd(body);
        assert_eq!((read.of("top.a"), read.of("top.b")), (&text(a), &text(b)), "{body}");
        let warnings = read.warnings.join("\n");
        assert!(warnings.starts_with(warning) && warning.is_empty() == warnings.is_empty(), "{body}: {warnings}");
        assert!(!read.cut && read.left_out.is_empty(), "{body}");
    }
    assert_eq!(vcd("#0\n$vcdclose #7 $end\n").end, 7);
}

#[test]
fn odd_headers_are_read() {
    let file = "\u{feff}$comment $enddefinitions and #5 are text $end\n$scope module my$end_scope $end\n$upscope\n$end \
                $var wire 1 ! my$end_flag $end $var wire 1 \" $end $upscope $end $var wire 1 # late $end\n\
                $upscope $end $odd x y $end $enddefinitions $end #0 1! 0\"\n1# #5\n";
    let read = open(file.as_bytes()).unwrap();
    let names: Vec<_> = read.vars.iter().map(|(name, _)| name.as_str()).collect();
    // a name that is missing is the identifier
    assert_eq!(names, ["my$end_flag", "\"", "late"]);
    assert_eq!((read.of("late"), read.end), (&text(&[(0, "1")]), 5));
    assert_eq!(read.warnings, ["line 4: a scope ends that has not begun (and 1 more)"]);
}

/// Any number of a unit: those that are 1, 10 or 100 are a tick, others that many.
#[test]
fn timescales_of_all_kinds() {
    let cases = [
        ("1ns", Some(-9), 3, false),
        ("100 us", Some(-4), 3, false),
        ("10\nps", Some(-11), 3, false),
        ("0ps", Some(-12), 3, true),
        ("ps", Some(-12), 3, true),
        ("244 ns", Some(-9), 732, true),
        ("1000 fs", Some(-15), 3000, true),
        ("7 parsecs", None, 3, true),
    ];
    for (timescale, exponent, end, warned) in cases {
        let file = format!("$timescale {timescale} $end $var wire 1 ! a $end $enddefinitions $end\n#3\n1!\n");
        let read = open(file.as_bytes()).unwrap();
        assert_eq!((read.exponent, read.end, !read.warnings.is_empty()), (exponent, end, warned), "{timescale}");
    }
}

/// A variable with values that are none of its kind, or of a kind that there is not, is left out; the rest is read.
#[test]
fn one_odd_variable_is_left_out() {
    let cases = [
        ("wire 4 ? odd", "b10101 ?", "line 3: `10101` has more than 4 bits"),
        ("wire 1 ? odd", "b10 ?", "line 3: `10` has more than 1 bit"),
        ("wire 4 ? odd", "b1x1x1 ?", "line 3: `1x1x1` has more than 4 bits"),
        ("wire 4 ? odd", "b10k1 ?", "line 3: `10k1` is not bits"),
        ("wire 4 ? odd", "r2.5 ?", "line 3: `2.5` is not 4 bits"),
        ("wire 4 ? odd", "b ?", "line 3: `` is not a value"),
        ("real 64 ? odd", "rabc ?", "line 3: `abc` is not a number"),
        ("real 64 ? odd", "shigh ?", "line 3: `high` is not a real number"),
        ("real 64 ? odd", "b101 ?", "line 3: `101` is not a real number"),
        ("string 1 ? odd", "b101 ?", "line 3: `101` is not text"),
        ("wire 0 ? odd", "b ?", "it is 0 bits wide; 1 to 16777216 are read"),
        ("wire 16777217 ? odd", "b1 ?", "it is 16777217 bits wide; 1 to 16777216 are read"),
        ("wire 4294967295 ? odd", "b1 ?", "it is 4294967295 bits wide; 1 to 16777216 are read"),
        ("wire 4294967296 ? odd", "b1 ?", "line 2: its width `4294967296` is no number up to 2^32-1"),
        ("wire w ? odd", "b1 ?", "line 2: its width `w` is no number up to 2^32-1"),
    ];
    for (declaration, value, why) in cases {
        let file = format!(
            "$scope module t $end\n$var {declaration} $end $var wire 1 ! good $end $upscope $end $enddefinitions $end #0\n{value}\n1!\n#3\n{value}\n0!\n"
        );
        let read = open(file.as_bytes()).unwrap();
        assert_eq!(read.vars, [("t.good".to_owned(), text(&[(0, "1"), (3, "0")]))], "{declaration}");
        assert_eq!(read.left_out, [("t.odd".to_owned(), why.to_owned())], "{declaration}");
        assert!(!read.cut);
    }
    // widths that are read, to the last
    for width in [1, 2, 63, 64, 65, 65_535, 65_536] {
        let file = format!("$var wire {width} ! a $end $enddefinitions $end\n#0\nb1 !\n");
        let read = open(file.as_bytes()).unwrap();
        assert_eq!(read.vars[0].1[0].1.len(), width);
    }
    let widest = b"$var wire 16777216 ! a $end $enddefinitions $end\n#0\n";
    assert_eq!(open(widest).unwrap().vars.len(), 1);
}

/// By hand from GHDL's description of the format: an array of two dimensions, in either order of bytes, and a bit.
#[test]
fn an_array_of_several_dimensions_is_left_out_of_ghw() {
    for big in [false, true] {
        let four = |n: u32| if big { n.to_be_bytes() } else { n.to_le_bytes() };
        let eight = |n: u64| if big { n.to_be_bytes() } else { n.to_le_bytes() };
        let mut file = b"GHDLwave\n\x10\x00\x01".to_vec();
        file.extend([if big { 2 } else { 1 }, 4, 1, 0]);
        file.extend(b"STR\0\0\0\0\0");
        file.extend([four(6), four(14)].concat());
        // each text ends with how much of it the next one has
        file.extend(b"'0'\x01'1'\x00bit\x00m\x00good\x00top\x00EOS\0");
        file.extend(b"TYP\0\0\0\0\0");
        file.extend(four(4));
        file.extend([22, 3, 2, 1, 2]);
        file.extend([25, 0]);
        file.extend([31, 0, 1, 2, 2, 2]);
        file.extend([35, 0, 3, 25, 0, 1, 25 | 0x80, 2, 0]);
        file.extend(b"\0WKT\0\0\0\0\0\0HIE\0\0\0\0\0");
        file.extend([four(1), four(2), four(7)].concat());
        file.extend([3, 6, 16, 4, 4, 1, 2, 3, 4, 5, 6, 16, 5, 1, 7, 15, 0]);
        file.extend(b"EOH\0SNP\0\0\0\0\0");
        file.extend(eight(0));
        file.extend(b"\0\0\0\0\0\0\0ESN\0CYC\0");
        file.extend(eight(5));
        file.extend(b"\x07\x01\x00\x03\x07\x00\x00\x7fECY\0TAI\0");
        let read = open(&file).unwrap();
        assert_eq!(read.vars, [("top.good".to_owned(), text(&[(0, "0"), (5, "1"), (8, "0")]))]);
        assert_eq!(read.left_out, [("top.m".to_owned(), "it is an array of 2 dimensions; one is read".to_owned())]);
        assert!(!read.cut, "{:?}", read.warnings);
    }
}

/// The same identifier as a bit, a vector and a number is three variables.
#[test]
fn one_identifier_of_several_kinds() {
    let file = "$var wire 1 ! a $end $var wire 4 ! b $end $var wire 4 ! c $end $var real 64 ! r $end $enddefinitions $end\n#0\n1!\n";
    let read = open(file.as_bytes()).unwrap();
    assert_eq!(
        (read.of("a"), read.of("b"), read.of("c")),
        (&text(&[(0, "1")]), &text(&[(0, "0001")]), &text(&[(0, "0001")]))
    );
    assert_eq!(read.left_out[0].0, "r");
}

#[test]
fn texts_and_identifiers_of_all_kinds() {
    let long = "~".repeat(500);
    let file = format!(
        "$var string 1 s s $end $var event 1 {long} e $end $var real 64 ~~~~ r $end $var wire 1 €ß w $end $enddefinitions $end\n\
         #0\nsa\\040b\\x41\\n\\q\\ s\nr-1.5e3 ~~~~\n1€ß\n#1\n1{long}\ns s\n#2\n1{long}\n"
    );
    let read = open(file.as_bytes()).unwrap();
    assert_eq!(read.of("s"), &text(&[(0, "a bA\n\\q\\"), (1, "")]));
    assert_eq!((read.of("r"), read.of("w")), (&text(&[(0, "-1500")]), &text(&[(0, "1")])));
    assert_eq!(read.of("e"), &text(&[(1, ""), (2, "")]));
}

/// What nothing can be made of is an error that says why.
#[test]
fn damaged_files() {
    let fst = std::fs::read(FST).unwrap();
    let ghw = std::fs::read(GHW).unwrap();
    let deep = "$scope module a $end ".repeat(names::MAX_DEPTH + 1);
    let long = format!("$scope module {} $end ", "n".repeat(60)).repeat(names::MAX_DEPTH);
    let cases: &[(&str, Vec<u8>, &str)] = &[
        ("empty", vec![], "it is empty"),
        ("text", b"hello\n".to_vec(), "it is not a waveform"),
        ("JSON", b"{ \"modules\": {} }\n".to_vec(), "it is not a waveform"),
        (
            "too long",
            long.into_bytes(),
            "it is damaged: its names are longer, scopes and all, than a thousand times the file",
        ),
        ("too deep", deep.clone().into_bytes(), "it is damaged: more than 10000 scopes inside one another"),
        (
            "time",
            format!("{HEADER}#18446744073709551615\n").replace("1 ns", "7 ns").into_bytes(),
            "it is damaged: line 2: the time 18446744073709551615 is more than 2^64-1 ticks",
        ),
        ("FST cut off", fst[..fst.len() - 1].to_vec(), "it is cut off: the block at byte"),
        (
            "FST with its header alone",
            fst[..330].to_vec(),
            "it is cut off: its end is missing; its names, which come last, are not there",
        ),
        ("FST with half a header", fst[..100].to_vec(), "it is cut off: its header is not complete"),
        ("GHW in its texts", ghw[..100].to_vec(), "it is cut off: its names are not complete"),
        ("GHW in its types", ghw[..0x120].to_vec(), "it is cut off: its names are not complete"),
    ];
    for (what, bytes, expected) in cases {
        let error = open(bytes).expect_err(what);
        let expected = format!("cannot read the waveform `FILE`: {expected}");
        assert!(error.starts_with(&expected), "{what}: {error}");
    }
    let deepest = &deep[..deep.len() - "$scope module a $end ".len()];
    assert!(open(deepest.as_bytes()).unwrap().cut);
}

/// A count or a length that is changed to any size asks for no more memory and time than the file can fill.
#[test]
fn numbers_of_any_size_are_borne() {
    for file in [FST, GHW] {
        let bytes = std::fs::read(file).unwrap();
        for at in 0..bytes.len() {
            for (new, count) in [(0, 1), (1, 1), (0x7f, 1), (0xff, 1), (0xff, 8)] {
                let mut bytes = bytes.clone();
                bytes[at..].iter_mut().take(count).for_each(|byte| *byte = new);
                let _ = open(&bytes);
            }
        }
    }
}

/// Cut off anywhere, a file is read as far as it goes: what is read is the beginning of what the whole file has.
#[test]
fn cut_files_are_read_as_far_as_they_go() {
    for file in [ICARUS, GHW] {
        let bytes = std::fs::read(file).unwrap();
        let whole = open(&bytes).unwrap();
        let mut read = 0;
        for length in 1..bytes.len() {
            let Ok(part) = open(&bytes[..length]) else { continue };
            read += 1;
            assert!(part.cut || part.vars.len() == whole.vars.len(), "{length}");
            for ((name, part), (_, whole)) in part.vars.iter().zip(&whole.vars) {
                // the last time is not complete
                let before = part.len().saturating_sub(1);
                assert!(part.len() <= whole.len() && part[..before] == whole[..before], "{file}, {length}: {name}");
            }
        }
        // all but those that end in the names of a GHW, or are not yet known for what they are
        assert!(read > bytes.len() / 3, "{read} of {}", bytes.len());
    }
    let cut = |body: &str| {
        let read = vcd(body);
        assert!(read.cut == read.warnings.iter().any(|text| text.starts_with("it is cut off: ")));
        read.cut
    };
    assert!(
        cut("#0\n1!\nb010")
            && cut("#0\n1!\n1")
            && cut("#0\n$comment more")
            && cut("#0\n$dumpvars\n1!\n")
            && cut("#0\n$dum")
    );
    assert!(cut("#110\n1!\n#12\n#1") && cut("#110\n1!\n#1"));
    assert!(cut("#0\n1!\nb0101 ?") && !cut("#0\n1!\nb0101 \"") && !cut("#0\n1!\n#5"));
    assert!(open(b"$scope module a $end $var wire 1 ! a $end $va").unwrap().cut);
    assert!(open(b"$scope module a $end $var wire 1 ! a $end").unwrap().cut);
}

#[test]
fn what_is_no_file() {
    let error = |path: &str| Waves::open(Path::new(path)).err().unwrap();
    let missing = error("no/such.vcd");
    assert_eq!(missing.to_string(), "cannot read the waveform `no/such.vcd`: no such file or directory");
    assert_eq!(missing.hint(), Some("check the spelling of the path"));
    let directory = error(env!("CARGO_MANIFEST_DIR"));
    assert!(directory.to_string().ends_with("it is not a regular file"), "{directory}");
    if cfg!(unix) {
        assert_eq!(error("/dev/zero").to_string(), "cannot read the waveform `/dev/zero`: it is not a regular file");
    }
}

fn run(program: &str, args: &[&str], dir: &Path) {
    let output = Command::new(program).args(args).current_dir(dir).output().unwrap();
    assert!(output.status.success(), "{program} {args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Files that compress well and files that do not, by each method that GTKWave packs with, alone and as a whole.
#[needs(vcd2fst)]
#[test]
fn all_packings_of_fst() {
    let dir = tempfile::tempdir().unwrap();
    for (kind, values, width) in
        [("quiet", 20_000_u64, 8), ("dense", 3_000, 64), ("wide", 50, 5000), ("bit", 100_000, 1)]
    {
        // `vcd2fst` goes by lines
        let mut body = format!(
            "$timescale 1 ns $end\n$scope module t $end\n$var wire {width} ! q $end\n$var wire 1 \" clk $end\n\
             $var real 64 # r $end\n$var string 1 % s $end\n$upscope $end\n$enddefinitions $end\n"
        );
        let mut state = 1_u64;
        for n in 0..values {
            body += &format!("#{}\n{}\"\n", 5 * n, n % 2);
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            if kind != "quiet" {
                body += &format!("b{:b} !\n", state >> (64 - width.min(64)));
            }
            if n % 1000 == 0 {
                body += &format!("r{} #\nst{} %\nbx !\n", n as f64 / 8.0, n / 7);
            }
        }
        std::fs::write(dir.path().join("a.vcd"), body).unwrap();
        let expected = whole(&dir.path().join("a.vcd")).unwrap();
        for packing in ["-4", "-F", "-Z"] {
            for compressed in [false, true] {
                let mut args = vec![packing];
                args.extend(compressed.then_some("-c"));
                args.extend(["a.vcd", "a.fst"]);
                run("vcd2fst", &args, dir.path());
                let read = whole(&dir.path().join("a.fst")).unwrap();
                assert_eq!(read.end, expected.end, "{kind} {args:?}");
                for (name, changes) in &expected.vars {
                    assert!(read.of(name) == changes, "{kind} {args:?}: {name}");
                }
            }
        }
    }
}

/// Variables with the same changes are read once; one that differs in a single change is another.
#[test]
fn many_that_are_alike_are_read_once() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.fst");
    let mut writer = crate::fst::FstWriter::new(crate::output::Output::create(&path).unwrap());
    let mut layout = crate::Layout::default();
    let top = layout.scope("top", None);
    let vars: Vec<usize> = (0..200).map(|i| layout.var(top, &format!("v{i}"), 8)).collect();
    use crate::Sink;
    writer.begin(&layout).unwrap();
    for n in 0..500 {
        writer.time(n).unwrap();
        // two of them are not as the others
        for &var in &vars {
            let value = if var == 7 && n > 3 || var == 150 && n == 499 { 1 } else { n % 200 };
            writer.change(var, &[crate::value::Word::known(value)]);
        }
    }
    writer.finish(500).unwrap();
    let mut waves = Waves::open(&path).unwrap();
    let loaded = waves.signals(&(0..200).collect::<Vec<_>>()).unwrap();
    let same = |a: usize, b: usize| Arc::ptr_eq(&loaded[a], &loaded[b]);
    assert!(same(0, 1) && same(0, 199) && !same(0, 7) && !same(0, 150) && !same(7, 150));
    wellen_agrees(&path);
}

fn mutations() -> impl Strategy<Value = Vec<(prop::sample::Index, u8, u8)>> {
    proptest::collection::vec((any::<prop::sample::Index>(), 0..5_u8, any::<u8>()), 1..6)
}

/// Changes, removes, repeats and cuts bytes.
fn mutate(mut bytes: Vec<u8>, mutations: &[(prop::sample::Index, u8, u8)]) -> Vec<u8> {
    for (index, what, byte) in mutations {
        if bytes.is_empty() {
            break;
        }
        let at = index.index(bytes.len());
        match what {
            0 => bytes[at] = *byte,
            1 => bytes[at] ^= 1 << (byte % 8),
            2 => drop(bytes.remove(at)),
            3 => bytes.insert(at, *byte),
            _ => {
                let some: Vec<u8> = bytes[at..].iter().copied().take(usize::from(*byte)).collect();
                bytes.splice(at..at, some);
            }
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_damaged_file_is_read_or_refused(mutations in mutations()) {
        for file in [ICARUS, FST, GHW] {
            let _ = open(&mutate(std::fs::read(file).unwrap(), &mutations));
        }
    }
}
