use std::fmt::Write as _;

use proptest::prelude::*;

use super::*;

const ICARUS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/waves/counter.vcd");
const FST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/waves/counter.fst");

type Changes = Vec<(u64, String)>;

/// Opens these bytes as a file and loads everything.
fn open(bytes: &[u8]) -> Result<Vec<(String, Changes)>, String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.wave");
    std::fs::write(&path, bytes).unwrap();
    let all = || {
        let mut waves = Waves::open(&path)?;
        let names: Vec<_> = waves.vars().iter().map(|var| var.name.clone()).collect();
        let load = |(i, name)| Ok((name, waves.load(i)?.changes().collect()));
        names.into_iter().enumerate().map(load).collect::<Result<_, ReadError>>()
    };
    all().map_err(|error| error.to_string().replace(path.to_str().unwrap(), "FILE"))
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
    }
}

#[test]
fn parts_of_a_vector_are_joined_and_names_given_twice_told_apart() {
    let file = "$scope module top $end $var wire 1 ! q [0] $end $var wire 1 \" q [1] $end $var wire 2 # p [3:2] $end \
                $var wire 2 $ p [1:0] $end $var wire 1 % r $end $var wire 1 & r $end $upscope $end \
                $scope module fa[3] $end $var wire 1 ' s $end $upscope $end $enddefinitions $end\n#0\n1!\n0\"\n";
    let read = open(file.as_bytes()).unwrap();
    assert_eq!(read[0].1, text(&[(0, "01")]));
    let names: Vec<_> = read.into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["top.q", "top.p", "top.r", "top.r#2", "fa[3].s"]);
}

#[test]
fn a_file_that_ends_with_its_header_has_no_values() {
    let file = "$scope module top $end $var wire 1 ! q $end $upscope $end $enddefinitions $end\n";
    assert_eq!(open(file.as_bytes()), Ok(vec![("top.q".into(), vec![])]));
}

/// Each fault is an error that says what is wrong, whether `wellen` returns it, panics or does not notice.
#[test]
fn damaged_files() {
    let header = "$timescale 1 ns $end $scope module top $end $var wire 1 ! a $end $var wire 4 \" b $end \
                  $upscope $end $enddefinitions $end\n";
    let fst = std::fs::read(FST).unwrap();
    let body = |body: &str| format!("{header}{body}").into_bytes();
    let deep = "$scope module a $end ".repeat(names::MAX_DEPTH + 1);
    let cases: &[(&str, Vec<u8>, &str)] = &[
        ("empty", vec![], "it is empty"),
        ("text", b"hello\n".to_vec(), "it is not a waveform"),
        ("JSON", b"{ \"modules\": {} }\n".to_vec(), "it is not a waveform"),
        ("header cut off", b"$scope module top $end\n".to_vec(), "it is cut off: its header has no end"),
        ("last line cut off", body("#0\n1!\n#1"), "it is cut off: its last line (4) is not complete"),
        ("time goes back", body("#5\n1!\n#3\n0!\n"), "it is damaged: line 4: time goes back from 5 to 3"),
        ("unknown identifier", body("#0\n1?\n"), "it is damaged: the reader gave up (index out of bounds"),
        ("value too wide", body("#0\nb10101 \"\n"), "10101 for signal of size 4"),
        ("value of no kind", body("#0\nb10k1 \"\n"), ""),
        ("garbage", body("#0\nhello !\n"), ""),
        ("time is no number", body("#zero\n"), "it is damaged: line 2: `#zero` is no time"),
        ("too many scopes closed", b"$upscope $end $upscope $end $enddefinitions $end\n#0\n".to_vec(), ""),
        ("no width", b"$scope module a $end $var wire w ! a $end $enddefinitions $end\n#0\n".to_vec(), "length"),
        (
            "huge width",
            b"$scope module a $end $var wire 4000000000 ! a $end $enddefinitions $end\n#0\n".to_vec(),
            "it is damaged: `a.a` is 4000000000 bits wide; at most 16777216 are read",
        ),
        ("timescale", body("#0\n").replacen_bytes(b"1 ns", b"7 ns"), "it is damaged: its timescale is 7 of a unit"),
        (
            "too deep",
            format!("{deep} $var wire 1 ! a $end $enddefinitions $end\n#0\n").into_bytes(),
            "it is damaged: more than 10000 scopes inside one another",
        ),
        ("FST cut off", fst[..fst.len() - 1].to_vec(), "it is cut off: the section at byte"),
        ("FST with its header alone", fst[..330].to_vec(), ""),
    ];
    for (what, bytes, expected) in cases {
        let error = open(bytes).expect_err(what);
        let expected = format!("cannot read the waveform `FILE`: {expected}");
        let (head, tail) = expected.split_at("cannot read the waveform `FILE`: ".len());
        assert!(error.starts_with(head) && error.contains(tail) && error.len() > head.len(), "{what}: {error}");
    }
}

trait Replace {
    fn replacen_bytes(self, from: &[u8], to: &[u8]) -> Vec<u8>;
}

impl Replace for Vec<u8> {
    fn replacen_bytes(mut self, from: &[u8], to: &[u8]) -> Vec<u8> {
        let at = self.windows(from.len()).position(|window| window == from).unwrap();
        self.splice(at..at + from.len(), to.iter().copied());
        self
    }
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

/// The hook that keeps the reader's panics quiet does so on this thread, within the call, and nowhere else.
#[test]
fn other_panics_stay_panics() {
    assert!(guarded(|| -> Result<(), Fault> { panic!("inside") }).is_err());
    let caught = std::panic::catch_unwind(|| panic!("outside"));
    assert_eq!(caught.unwrap_err().downcast_ref::<&str>(), Some(&"outside"));
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
    #![proptest_config(ProptestConfig::with_cases(FUZZ))]

    #[test]
    fn a_damaged_vcd_is_read_or_refused(mutations in mutations()) {
        let mut original = std::fs::read_to_string(ICARUS).unwrap();
        writeln!(original, "$comment more $end").unwrap();
        let _ = open(&mutate(original.into_bytes(), &mutations));
    }

    #[test]
    fn a_damaged_fst_is_read_or_refused(mutations in mutations()) {
        let _ = open(&mutate(std::fs::read(FST).unwrap(), &mutations));
    }
}

const FUZZ: u32 = 300;
