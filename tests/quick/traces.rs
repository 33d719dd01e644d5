//! The golden traces: the program still makes them, and they are what the algorithms do on every clock.
//!
//! They are read here by the `vcd` crate's parser and followed by the algorithm, so neither our writer, our reader nor
//! the engine vouches for itself.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Command;

use discreta::interpolate::{
    ArcInput, ArcPath, CurveInput, DdaCircle, DdaCirclePrinted, DdaCurve, DdaLine, DdaLine3d, DdaLinePrinted, EfCircle,
    EfCircleFast, EfCirclePrinted, EfLine, EfLine3d, EfLineFast, EfLineFastPrinted, InputError, Interpolator, Karibsky,
    KaribskyPrinted, Line3dInput, LineInput, Method, Options, Printed, Quadrants, Request,
};
use vcd::{IdCode, ScopeItem, Value};

/// Makes the algorithm of what the inputs say at START; the number that a net shows then, by its name.
type Start = fn(&dyn Fn(&str) -> i64) -> Box<dyn Interpolator>;

/// The algorithms, by how the path of a trace below `traces/` begins. The first that fits is taken.
const ALGORITHMS: &[(&str, Start)] = &[
    ("evaluation/line_centred_", |net| Box::new(EfLine::centred(line(net, 8)).unwrap())),
    ("evaluation/line_", |net| Box::new(EfLine::new(line(net, 8)).unwrap())),
    ("evaluation/fast_line_x_", |net| Box::new(EfLineFastPrinted::diagram(line(net, 8)).unwrap())),
    ("evaluation/fast_line_centred_", |net| Box::new(EfLineFast::centred(line(net, 8)).unwrap())),
    ("evaluation/fast_line_", |net| Box::new(EfLineFast::new(line(net, 8)).unwrap())),
    ("evaluation/fast_circle_cw_", |net| Box::new(EfCircleFast::new(arc(net, true)).unwrap())),
    ("evaluation/fast_circle_", |net| Box::new(EfCircleFast::new(arc(net, false)).unwrap())),
    ("dda/line_as_printed_", |net| Box::new(DdaLinePrinted::new(line(net, 3), &Options::default()).unwrap())),
    ("dda/circle_as_printed_", |net| {
        Box::new(DdaCirclePrinted::new(dda_arc(net, 3, false), &Options::default()).unwrap())
    }),
    ("dda/line_half_", |net| dda_line(net, 3, Options { half_preload: true, ..Options::default() })),
    ("dda/line_normalised_", |net| dda_line(net, 8, Options { normalise: true, ..Options::default() })),
    ("dda/line_", |net| dda_line(net, 3, Options::default())),
    ("dda/circle_half_", |net| dda_circle(net, 3, false, Options { half_preload: true, ..Options::default() })),
    ("dda/circle_parallel_", |net| dda_circle(net, 3, false, Options { parallel: true, ..Options::default() })),
    ("dda/circle_normalised_", |net| dda_circle(net, 6, false, Options { normalise: true, ..Options::default() })),
    ("dda/circle_clockwise_", |net| dda_circle(net, 3, true, Options::default())),
    ("dda/circle_", |net| dda_circle(net, 3, false, Options::default())),
    ("feed/paced_circle_", |net| dda_circle(net, 6, false, Options { normalise: true, ..Options::default() })),
    ("feed/paced_line_", |net| dda_line(net, 8, Options { normalise: true, ..Options::default() })),
    ("evaluation/circle_as_printed_", |net| Box::new(EfCirclePrinted::new(arc(net, false)).unwrap())),
    ("evaluation/circle_cw_", |net| Box::new(EfCircle::new(arc(net, true)).unwrap())),
    ("evaluation/circle_gates_cw_", |net| Box::new(EfCircle::new(arc(net, true)).unwrap())),
    ("evaluation/circle_", |net| Box::new(EfCircle::new(arc(net, false)).unwrap())),
    ("evaluation/karibsky_as_printed_", |net| Box::new(KaribskyPrinted::new(arc(net, true)).unwrap())),
    ("evaluation/karibsky_cw_", |net| Box::new(Karibsky::new(arc(net, true)).unwrap())),
    ("evaluation/karibsky_gates_cw_", |net| Box::new(Karibsky::new(arc(net, true)).unwrap())),
    ("evaluation/karibsky_", |net| Box::new(Karibsky::new(arc(net, false)).unwrap())),
    ("quadrant/circle_", |net| Box::new(quadrants(net, |input| Ok(Box::new(EfCircle::new(input)?))))),
    ("quadrant/fast_circle_", |net| Box::new(quadrants(net, |input| Ok(Box::new(EfCircleFast::new(input)?))))),
    ("quadrant/karibsky_", |net| Box::new(quadrants(net, |input| Ok(Box::new(Karibsky::new(input)?))))),
    ("quadrant/line_3d_", |net| {
        let [from, d] = [["xh", "yh", "zh"], ["dx", "dy", "dz"]].map(|names| names.map(|name| signed(net, name)));
        let to = [0, 1, 2].map(|axis| from[axis] + d[axis]);
        let request = Request { from, bits: Some(8), ..Request::new(Method::EfLine3d, to) };
        request.draw().unwrap().interpolator
    }),
    ("quadrant/line_", |net| signed_line(net, Method::EfLine)),
    ("quadrant/dda_line_", |net| signed_line(net, Method::DdaLine)),
    ("quadrant/fast_line_", |net| signed_line(net, Method::EfLineFast)),
    ("dda/curve_parallel_", |net| curve(net, false, (true, false), Printed::default())),
    ("dda/curve_half_", |net| curve(net, false, (false, true), Printed::default())),
    ("dda/curve_clockwise_", |net| curve(net, true, (false, false), Printed::default())),
    ("dda/curve_printed_", |net| curve(net, false, (false, false), Printed { signs: true, by: true })),
    ("dda/curve_by_", |net| curve(net, false, (false, false), Printed { signs: false, by: true })),
    ("dda/curve_", |net| curve(net, false, (false, false), Printed::default())),
    ("three_axis/line_", |net| Box::new(EfLine3d::new(line_3d(net, 8)).unwrap())),
    ("three_axis/dda_line_half_", |net| Box::new(DdaLine3d::new(line_3d(net, 3), true).unwrap())),
    ("three_axis/dda_line_", |net| Box::new(DdaLine3d::new(line_3d(net, 3), false).unwrap())),
];

fn line(net: &dyn Fn(&str) -> i64, bits: u32) -> LineInput {
    LineInput { xh: net("xh"), yh: net("yh"), dx: net("dx"), dy: net("dy"), bits }
}

fn dda_line(net: &dyn Fn(&str) -> i64, bits: u32, options: Options) -> Box<dyn Interpolator> {
    Box::new(DdaLine::new(line(net, bits), &options).unwrap())
}

fn dda_circle(net: &dyn Fn(&str) -> i64, bits: u32, clockwise: bool, options: Options) -> Box<dyn Interpolator> {
    Box::new(DdaCircle::new(dda_arc(net, bits, clockwise), &options).unwrap())
}

fn dda_arc(net: &dyn Fn(&str) -> i64, bits: u32, clockwise: bool) -> ArcInput {
    ArcInput { xh: net("xh"), yh: net("yh"), dx: net("dx"), dy: net("dy"), f0: 0, clockwise, bits }
}

fn line_3d(net: &dyn Fn(&str) -> i64, bits: u32) -> Line3dInput {
    Line3dInput { start: ["xh", "yh", "zh"].map(net), increment: ["dx", "dy", "dz"].map(net), bits }
}

/// A coordinate of 9 bits in two's complement.
fn signed(net: &dyn Fn(&str) -> i64, name: &str) -> i64 {
    net(name) << 55 >> 55
}

/// What the inputs of a line's circuit for all quadrants say.
fn signed_line(net: &dyn Fn(&str) -> i64, method: Method) -> Box<dyn Interpolator> {
    let [xh, yh, dx, dy] = ["xh", "yh", "dx", "dy"].map(|name| signed(net, name));
    let request = Request { from: [xh, yh, 0], bits: Some(8), ..Request::new(method, [xh + dx, yh + dy, 0]) };
    request.draw().unwrap().interpolator
}

/// What the inputs of an arc's circuit for all quadrants say.
fn quadrants(
    net: &dyn Fn(&str) -> i64,
    core: impl Fn(ArcInput) -> Result<Box<dyn Interpolator>, InputError> + 'static,
) -> Quadrants {
    let point = |x: &str, y: &str| [signed(net, x), signed(net, y)];
    let path = ArcPath {
        center: point("xc", "yc"),
        from: point("xh", "yh"),
        to: point("xk", "yk"),
        full: true,
        long: None,
        clockwise: net("cw") == 1,
        f0: net("f0") << 54 >> 54,
        bits: 8,
    };
    Quadrants::new(path, true, core).unwrap()
}

/// A curve through the start point, whose coefficients have 7 bits and whose coordinates 6, in two's complement.
fn curve(
    net: &dyn Fn(&str) -> i64,
    clockwise: bool,
    (parallel, half_preload): (bool, bool),
    printed: Printed,
) -> Box<dyn Interpolator> {
    let coefficient = |name| net(name) << 57 >> 57;
    let coordinate = |name| net(name) << 58 >> 58;
    let mut coefficients = [0; 6];
    coefficients[..5].copy_from_slice(&["a", "b", "c", "d", "e"].map(coefficient));
    let [start, end] = [["xh", "yh"], ["xk", "yk"]].map(|point| point.map(coordinate));
    let mut input = CurveInput { coefficients, start, end, clockwise, bits: 6 };
    input.coefficients[5] = -input.value(start) as i64;
    let options = Options { parallel, half_preload, ..Options::default() };
    Box::new(DdaCurve::with_misprints(input, &options, printed).unwrap())
}

/// What the inputs of an arc's circuit say; `f0` has 10 bits in two's complement.
fn arc(net: &dyn Fn(&str) -> i64, clockwise: bool) -> ArcInput {
    let f0 = net("f0") << 54 >> 54;
    ArcInput { xh: net("xh"), yh: net("yh"), dx: net("dx"), dy: net("dy"), f0, clockwise, bits: 8 }
}

/// Traces of circuits that are no interpolators, or fail as they are to; each has a test of its own elsewhere, or its
/// scenario says what is to come of it.
const OTHERS: &[&str] = &["evaluation/circle_worded", "feed/speed_block", "feed/synchroniser", "feed/system"];

/// What the nets show, by their names; nothing while a bit is unknown.
type Nets = HashMap<String, Option<u64>>;

/// The widths of the nets of the top scope, and of those of its interpolator, `core` or `core_line`, that it does not show itself, and their
/// values after each instant at which something changes.
fn instants(path: &Path) -> (HashMap<String, u32>, BTreeMap<u64, Nets>) {
    let mut parser = vcd::Parser::new(BufReader::new(File::open(path).unwrap()));
    let header = parser.parse_header().unwrap();
    let [top] = &header
        .items
        .iter()
        .filter_map(|i| if let ScopeItem::Scope(s) = i { Some(s) } else { None })
        .collect::<Vec<_>>()[..]
    else {
        panic!("one top scope")
    };
    let mut names: HashMap<IdCode, Vec<String>> = HashMap::new();
    let mut widths = HashMap::new();
    let core = top.items.iter().filter_map(|i| match i {
        ScopeItem::Scope(s) if ["core", "core_line"].contains(&&*s.identifier) => Some(&s.items),
        _ => None,
    });
    for item in top.items.iter().chain(core.flatten()) {
        if let ScopeItem::Var(v) = item
            && !widths.contains_key(&v.reference)
        {
            names.entry(v.code).or_default().push(v.reference.clone());
            widths.insert(v.reference.clone(), v.size);
        }
    }
    let mut now = 0;
    let mut values = HashMap::new();
    let mut all = BTreeMap::new();
    for command in parser {
        let (id, value) = match command.unwrap() {
            vcd::Command::Timestamp(t) => {
                all.insert(now, values.clone());
                now = t;
                continue;
            }
            vcd::Command::ChangeScalar(id, v) => (id, vec![v]),
            vcd::Command::ChangeVector(id, v) => (id, v.iter().collect()),
            _ => continue,
        };
        let number = value.iter().try_fold(0u64, |n, bit| match bit {
            Value::V0 => Some(n << 1),
            Value::V1 => Some(n << 1 | 1),
            _ => None,
        });
        for name in names.get(&id).into_iter().flatten() {
            values.insert(name.clone(), number);
        }
    }
    all.insert(now, values);
    (widths, all)
}

/// Follows a trace with the algorithm; returns the clocks compared.
fn follow(path: &Path, start: Start) -> usize {
    let (widths, instants) = instants(path);
    let instants: Vec<_> = instants.into_iter().collect();
    let mut algorithm: Option<Box<dyn Interpolator>> = None;
    let mut compared = 0;
    let mut steps = Vec::new();
    for (i, (time, now)) in instants.iter().enumerate() {
        let get = |name: &str| {
            now.get(name)
                .copied()
                .flatten()
                .unwrap_or_else(|| panic!("{}: {name} is unknown at {time}: {now:?}", path.display()))
        };
        let before = |name: &str| i.checked_sub(1).and_then(|i| instants[i].1[name]);
        // the registers: what the algorithm has and what the trace shows, a net at a time
        let compare = |a: &dyn Interpolator, when: &str| {
            let (c, columns) = (a.state(), a.columns());
            let at = columns.at.iter().zip(c.at.map(|v| v as u64));
            let registers =
                at.chain(columns.left.iter().zip(c.left)).chain(columns.sum.iter().zip(c.sum.map(|v| v as u64)));
            for (name, value) in registers.chain([(&"end", u64::from(c.end))]) {
                let mask = u64::MAX >> (64 - widths[*name]);
                assert_eq!(get(name), value & mask, "{} at {time}, {when}: {name}", path.display());
            }
        };
        if get("start") == 1 {
            let a = start(&|name| get(name) as i64);
            compare(&*a, "START");
            algorithm = Some(a);
            continue;
        }
        let Some(a) = &mut algorithm else { continue };
        let axes = &["x", "y", "z"][..a.columns().at.len()];
        match (before("dt"), get("dt")) {
            (Some(0), 1) => steps = axes.iter().map(|axis| get(axis)).collect(),
            (Some(1), 0) => {
                let step = a.next().map_or([0; 3], |c| c.step);
                let expected: Vec<u64> = axes.iter().zip(step).map(|(_, s)| u64::from(s != 0)).collect();
                assert_eq!(steps, expected, "{} at {time}: pulses", path.display());
                compared += 1;
            }
            _ => {}
        }
        compare(&**a, "after it");
        if get("dt") == 0 {
            assert!(axes.iter().all(|axis| get(axis) == 0), "{} at {time}: a pulse without a clock", path.display());
        }
    }
    compared
}

/// The files of an extension below a folder.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path, extension));
        } else if path.extension().is_some_and(|e| e == extension) {
            all.push(path);
        }
    }
    all
}

#[test]
fn golden_traces_follow_the_algorithm_on_every_clock() {
    let (mut traces, mut compared) = (0, 0);
    for path in files(Path::new("traces"), "vcd") {
        let name = path.strip_prefix("traces").unwrap().to_str().unwrap();
        if OTHERS.iter().any(|prefix| name.starts_with(prefix)) {
            continue;
        }
        let found = ALGORITHMS.iter().find(|(prefix, _)| name.starts_with(prefix));
        let (_, start) = found.unwrap_or_else(|| panic!("no algorithm is known for {name}"));
        compared += follow(&path, *start);
        traces += 1;
    }
    assert!(traces >= 11 && compared >= 580, "{traces} traces, {compared} clocks");
}

#[test]
fn the_program_makes_the_golden_traces() {
    let output = Command::new(env!("CARGO_BIN_EXE_discreta")).args(["test", "traces"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let scenarios = files(Path::new("traces"), "json").len();
    assert!(text.contains(&format!("{scenarios} passed, 0 failed")), "{text}");
    assert_eq!(scenarios, files(Path::new("traces"), "vcd").len(), "each has a golden trace");
}

/// Byte for byte, each by an engine that is told, so that none runs on another unseen.
#[cfg(feature = "compiled")]
#[test]
fn each_engine_makes_the_golden_traces() {
    let (mut compiled, mut refused) = (0, Vec::new());
    for path in files(Path::new("traces"), "json") {
        let test = |engine: &str| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_discreta"));
            let output = command.args(["test", "--engine", engine]).arg(&path).output().unwrap();
            (output.status.success(), format!("{output:?}"))
        };
        let (passed, told) = test("event");
        assert!(passed, "{told}");
        let (passed, told) = test("compiled");
        compiled += usize::from(passed);
        if !passed {
            assert!(told.contains("cannot be compiled: it has an RC delay"), "{told}");
            refused.push(path);
        }
    }
    println!(
        "{compiled} golden traces on the event and the compiled engine; with RC delays, on the first alone: {refused:?}"
    );
    assert!(compiled > 0, "{compiled}");
}
