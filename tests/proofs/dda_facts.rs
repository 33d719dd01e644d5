//! What brute force says of the algorithms by differential increments: clocks, deviations, starving arcs, what the printed
//! programs do. The numbers stand in docs/interpolators-dda.md.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use discreta::interpolate::dda::normalise::shifts;
use discreta::interpolate::{
    ArcInput, Clock, DdaCircle, DdaCirclePrinted, DdaLine, DdaLinePrinted, Ideal, Interpolator, LineInput, Method,
    Options, Request, Watchdog,
};

const PLAIN: Options =
    Options { as_printed: false, half_preload: false, parallel: false, normalise: false, centred: false };
/// Sequential, sequential from half, parallel, parallel from half.
const SETTINGS: [Options; 4] = [
    PLAIN,
    Options { half_preload: true, ..PLAIN },
    Options { parallel: true, ..PLAIN },
    Options { parallel: true, half_preload: true, ..PLAIN },
];

fn line(dx: i64, dy: i64, bits: u32, options: Options) -> DdaLine {
    DdaLine::new(LineInput { bits, ..LineInput::new(dx, dy) }, &options).unwrap()
}

fn quarter(r: i64, bits: u32) -> ArcInput {
    ArcInput::between((r, 0), (0, r), false, bits)
}

fn letters(clocks: impl Iterator<Item = Clock>) -> String {
    clocks.map(|c| c.letter()).collect()
}

fn point(c: &Clock) -> [f64; 3] {
    c.at.map(|v| v as f64)
}

#[test]
fn golden_lines() {
    let clocks: Vec<Clock> = line(5, 4, 3, PLAIN).collect();
    assert_eq!(letters(clocks.iter().copied()), "-D-DXYXD");
    // by hand: 5, 10 − 8, 7, 12 − 8 …; 4, 8 − 8, 4 …
    assert_eq!(clocks.iter().map(|c| c.sum[0]).collect::<Vec<_>>(), [5, 2, 7, 4, 1, 6, 3, 0]);
    assert_eq!(clocks.iter().map(|c| c.sum[1]).collect::<Vec<_>>(), [4, 0, 4, 0, 4, 0, 4, 0]);
    assert_eq!(clocks.iter().map(|c| c.left[0]).collect::<Vec<_>>(), [5, 4, 4, 3, 2, 2, 1, 0]);
    assert_eq!(letters(line(5, 4, 3, SETTINGS[1])), "D-DXYXYX");
    // 101 and 100 have their top bits set already; 010 and 001 are shifted once: 100 and 010
    assert_eq!(letters(line(5, 4, 3, Options { normalise: true, ..PLAIN })), "-D-DXYXD");
    assert_eq!(letters(line(2, 1, 3, Options { normalise: true, ..PLAIN })), "-X-D");
    assert_eq!(letters(line(0, 0, 3, PLAIN)), "");
    assert_eq!(letters(line(0, 3, 3, PLAIN)), "--Y--Y-Y");
}

#[test]
fn golden_quarters() {
    let steps = |arc, options| letters(DdaCircle::new(arc, &options).unwrap());
    assert_eq!(steps(quarter(5, 3), PLAIN), "-Y-YY-D-D-XX-X");
    assert_eq!(steps(quarter(5, 3), SETTINGS[1]), "Y-YXY-D-XYX-X");
    // clockwise is the mirror image, x for y
    let mirrored = |steps: &str| -> String {
        steps
            .chars()
            .map(|c| {
                if c == 'X' {
                    'Y'
                } else if c == 'Y' {
                    'X'
                } else {
                    c
                }
            })
            .collect()
    };
    let clockwise = ArcInput::between((0, 5), (5, 0), true, 3);
    for options in SETTINGS.into_iter().flat_map(|o| [o, Options { normalise: true, ..o }]) {
        assert_eq!(steps(clockwise, options), mirrored(&steps(quarter(5, 3), options)));
    }
    // sy: 5, 10 − 8, 7, 12 − 8, 9 − 8; sx takes y: 0, 0, 1, 2, 4, 7
    let sums: Vec<_> = DdaCircle::new(quarter(5, 3), &PLAIN).unwrap().take(6).map(|c| (c.sum[0], c.sum[1])).collect();
    assert_eq!(sums, [(0, 5), (0, 2), (1, 7), (2, 4), (4, 1), (7, 6)]);
}

/// Against ⌊n·Δ/2^p⌋, which the accumulators are to compute.
#[test]
fn every_line_ends_at_exactly_clock_2_to_the_p() {
    for bits in 4..=8 {
        let volume = 1_i64 << bits;
        for (dx, dy) in (0..volume).flat_map(|dx| (0..volume).map(move |dy| (dx, dy))).skip(1) {
            let mut n = 0;
            for c in line(dx, dy, bits, PLAIN) {
                n += 1;
                assert_eq!(c.at, [n * dx / volume, n * dy / volume, 0]);
                assert_eq!(c.end, n == volume, "({dx}, {dy})");
            }
            assert_eq!(n, volume);
        }
    }
}

#[test]
fn every_normalised_line_ends_at_clock_2_to_the_p_less_s_on_the_same_points() {
    for bits in 4..=8 {
        let volume = 1_i64 << bits;
        let options = Options { normalise: true, ..PLAIN };
        for (dx, dy) in (0..volume).flat_map(|dx| (0..volume).map(move |dy| (dx, dy))).skip(1) {
            let s = (dx.max(dy) as f64).log2().floor() as u32;
            let s = bits - 1 - s;
            let mut n = 0;
            for c in line(dx, dy, bits, options) {
                n += 1;
                assert_eq!(c.sum[2], i64::from(s));
                // the point that the line without normalisation has at clock n·2^s
                assert_eq!(c.at, [((n * dx) << s) / volume, ((n * dy) << s) / volume, 0]);
            }
            assert_eq!(n, volume >> s, "({dx}, {dy})");
        }
    }
}

/// The largest deviation of the lines of 8 bits, BLU.
fn worst_line(options: Options) -> f64 {
    let mut worst = 0_f64;
    for (dx, dy) in (0..256).flat_map(|dx| (0..256).map(move |dy| (dx, dy))).skip(1) {
        let ideal = Ideal::segment([0; 3], [dx, dy, 0]);
        for c in line(dx, dy, 8, options) {
            worst = worst.max(ideal.deviation(point(&c)).abs());
        }
    }
    worst
}

#[test]
fn the_deviation_of_lines() {
    assert_eq!(format!("{:.4}", worst_line(PLAIN)), "0.9961");
    assert_eq!(format!("{:.4}", worst_line(Options { normalise: true, ..PLAIN })), "0.9961");
    assert_eq!(format!("{:.4}", worst_line(SETTINGS[1])), "0.7044");
}

/// The greatest and the least deviation of the quarters of 8 bits, BLU, outside and inside.
fn worst_quarters(options: Options) -> String {
    let (mut outside, mut inside) = (0_f64, 0_f64);
    for r in 1..256 {
        let ideal = Ideal::arc([0.0; 2], [r as f64, 0.0], [0.0, r as f64], false);
        for c in DdaCircle::new(quarter(r, 8), &options).unwrap() {
            let deviation = ideal.deviation(point(&c));
            (outside, inside) = (outside.max(deviation), inside.min(deviation));
        }
    }
    format!("{outside:+.3}/{inside:.3}")
}

#[test]
fn the_deviation_of_quarters() {
    assert_eq!(SETTINGS.map(worst_quarters), ["+1.462/-0.190", "+0.918/-0.657", "+1.766/-0.151", "+1.242/-0.645"]);
    let normalised = SETTINGS.map(|o| worst_quarters(Options { normalise: true, ..o }));
    assert_eq!(normalised, ["+1.462/-0.106", "+0.918/-0.838", "+1.766/-0.030", "+1.259/-0.519"]);
}

#[test]
fn a_quarter_takes_half_pi_times_2_to_the_p_clocks() {
    let clocks = SETTINGS
        .into_iter()
        .flat_map(|options| (16..256).map(move |r| DdaCircle::new(quarter(r, 8), &options).unwrap().count()));
    let clocks: BTreeSet<usize> = clocks.collect();
    assert_eq!((clocks.first(), clocks.last()), (Some(&394), Some(&405)));
    assert_eq!((FRAC_PI_2 * 256.0).round(), 402.0);
    // with radius 1 each of the two steps takes a whole volume
    assert_eq!(DdaCircle::new(quarter(1, 8), &PLAIN).unwrap().count(), 512);
}

/// Arcs of 6 bits from every point with x² + y² ≤ 63², to every other point of the circle with a smaller x and its y
/// rounded.
fn rounded_arcs() -> Vec<ArcInput> {
    let mut arcs = Vec::new();
    for (xh, yh) in (0..64).flat_map(|x| (0..64).map(move |y| (x, y))) {
        let square = xh * xh + yh * yh;
        for xk in (0..xh).filter(|_| square <= 63 * 63) {
            let yk = ((square - xk * xk) as f64).sqrt().round() as i64;
            arcs.push(ArcInput::between((xh, yh), (xk, yk), false, 6));
        }
    }
    arcs
}

#[test]
fn starving_arcs_are_finished() {
    let arcs = rounded_arcs();
    assert_eq!(arcs.len(), 84_213);
    let mut starved = [0; 4];
    for (options, starved) in SETTINGS.iter().zip(&mut starved) {
        for &arc in &arcs {
            let mut circle = DdaCircle::new(arc, options).unwrap();
            let bound = circle.bound();
            let clocks = circle.by_ref().count() as u64;
            let last = circle.state();
            assert_eq!((last.end, (last.at[0], last.at[1])), (true, arc.end()), "{arc:?}");
            assert!(clocks <= bound.min(128), "{arc:?} takes {clocks}");
            *starved += usize::from(circle.starved());
        }
    }
    assert_eq!(starved, [471, 294, 166, 0]);
    // the example: x is 0 when y is still a step short, which is made at once
    let example = DdaCircle::new(ArcInput::between((2, 3), (0, 4), false, 3), &PLAIN).unwrap();
    let clocks: Vec<Clock> = example.collect();
    assert_eq!(clocks[clocks.len() - 2].at, [0, 3, 0]);
    assert_eq!(clocks.last().map(|c| (c.step, c.at, c.end)), Some(([0, 1, 0], [0, 4, 0], true)));
}

/// Every arc that is not refused ends, within 3.1·2^p clocks as measured, and within the bound as proved.
#[test]
fn every_arc_ends_within_the_bound_of_the_watchdog() {
    let mut most = 0;
    for options in SETTINGS.into_iter().flat_map(|o| [o, Options { normalise: true, ..o }]) {
        for (xh, yh, xk, yk) in (0..1 << 16).map(|n| (n >> 12, n >> 8 & 15, n >> 4 & 15, n & 15)) {
            for clockwise in [false, true] {
                let arc = ArcInput::between((xh, yh), (xk, yk), clockwise, 4);
                let Ok(mut circle) = DdaCircle::new(arc, &options) else { continue };
                let bound = circle.bound();
                let clocks = circle.by_ref().take(1000).count() as u64;
                assert!(circle.state().end && clocks <= bound, "{arc:?} takes {clocks} of {bound}");
                most = most.max(clocks);
            }
        }
    }
    assert_eq!(most, 49);
}

/// The greatest quarter: its bound passes 64 bits, and it begins nevertheless.
#[test]
fn the_greatest_quarter_begins() {
    let r = (1 << 32) - 1;
    let circle = DdaCircle::new(quarter(r, 32), &PLAIN).unwrap();
    assert_eq!(circle.bound(), u64::MAX);
    let request = Request { from: [r, 0, 0], ..Request::new(Method::DdaCircle, [0, r, 0]) };
    let mut drawing = request.draw().unwrap();
    // r, 2r − 2^32, …: a carry on every clock but the first
    assert_eq!(drawing.bits, 32);
    assert_eq!(letters(drawing.interpolator.by_ref().take(5)), "-YYYY");
}

/// A clock that shifts by s stands for 2^s clocks, each R/(V·2^p) long: the way made is V·t at every clock.
#[test]
fn quarters_keep_their_speed() {
    for options in SETTINGS.into_iter().flat_map(|o| [o, Options { normalise: true, ..o }]) {
        for r in 1..256 {
            let plain = Options { normalise: false, ..options };
            let plain = DdaCircle::new(quarter(r, 8), &plain).unwrap().count() as f64;
            let mut circle = DdaCircle::new(quarter(r, 8), &options).unwrap();
            let (mut time, mut greatest) = (0.0, 0.0_f64);
            while !circle.state().end {
                let state = circle.state();
                let s = if options.normalise { shifts(state.at[0], state.at[1], 8) } else { 0 };
                assert_eq!(state.sum[2], i64::from(s));
                let interval = f64::from(1 << state.sum[2]);
                (time, greatest) = (time + interval, greatest.max(interval));
                let c = circle.next().unwrap();
                let way = (c.at[1] as f64).atan2(c.at[0] as f64) * r as f64;
                // at the very end the arc may stand still for a while
                let late = way - time / 256.0 * r as f64;
                assert!(c.end || late.abs() < 1.6, "{late} BLU at {c:?}, R = {r}");
            }
            assert!((time - plain).abs() < 2.0 * greatest, "{time} for {plain} clocks, R = {r}");
        }
    }
}

#[test]
fn shifts_of_every_8_bit_pair() {
    for (a, b) in (0..256).flat_map(|a| (0..256).map(move |b| (a, b))).skip(1) {
        // the text: doubled until there is a 1 in the top bit of either
        let (mut x, mut y, mut doubled) = (a, b, 0);
        while x < 128 && y < 128 {
            (x, y, doubled) = (2 * x, 2 * y, doubled + 1);
        }
        assert_eq!(shifts(a, b, 8), doubled);
    }
    assert_eq!([2, 3, 4, 5, 16, 17, 32].map(|bits| shifts(0, 0, bits)), [1, 3, 3, 7, 15, 31, 31]);
}

/// FLAG counts every carry and is never cleared, and only FLAG = 1 moves: one step of the line is made, or none.
#[test]
fn as_printed_the_device_makes_one_step_of_a_line_or_none() {
    let mut made = [0; 3];
    for (dx, dy) in (0..16).flat_map(|dx| (0..16).map(move |dy| (dx, dy))).skip(1) {
        let printed = DdaLinePrinted::new(LineInput { bits: 4, ..LineInput::new(dx, dy) }, &PLAIN).unwrap();
        let clocks: Vec<Clock> = printed.collect();
        // the cells are right all the same
        let cells = |c: &Clock| (c.at, c.left, c.sum, c.end);
        assert!(clocks.iter().map(cells).eq(line(dx, dy, 4, PLAIN).collect::<Vec<_>>().iter().map(cells)));
        let moved: usize = clocks.iter().map(Clock::axes).sum();
        made[moved] += 1;
        assert!(moved as i64 == dx + dy || moved < 2);
    }
    // none where both axes carry in the same first pass
    assert_eq!(made[2], 0);
    let together = (0..16_i32).flat_map(|dx| (0..16).map(move |dy| (dx, dy)));
    let first = |d: i32| if d == 0 { None } else { Some((16 + d - 1) / d) };
    assert_eq!(made[0], together.filter(|&(dx, dy)| first(dx).is_some() && first(dx) == first(dy)).count());
}

#[test]
fn as_printed_quarters_miss_their_end() {
    let missed = |parallel| {
        (1..256).filter(move |&r| {
            let printed = DdaCirclePrinted::new(quarter(r, 8), &Options { parallel, ..PLAIN }).unwrap();
            let bound = printed.bound();
            let mut watched = Watchdog::new(printed, bound);
            assert!(watched.by_ref().count() <= 768);
            watched.stopped().is_some()
        })
    };
    assert_eq!((missed(false).count(), missed(true).count()), (116, 255));
    // with a stop of each axis alone, all of them end
    let ends = |&(r, options): &(i64, Options)| DdaCircle::new(quarter(r, 8), &options).unwrap().last().unwrap().end;
    assert!((1..256).flat_map(|r| SETTINGS.map(|o| (r, o))).all(|q| ends(&q)));
}

#[test]
fn what_cannot_be_drawn_is_refused_with_its_limit() {
    let line = |dx, dy, options| DdaLine::new(LineInput::new(dx, dy), &options).map(|_| ()).unwrap_err().to_string();
    assert_eq!(line(256, 0, PLAIN), "DX = 256 is above 255, the greatest of 8 bits");
    assert_eq!(line(5, 4, Options { parallel: true, ..PLAIN }), "dda-line has no option --parallel");
    let arc = |from, to, options| {
        DdaCircle::new(ArcInput::between(from, to, false, 8), &options).map(|_| ()).unwrap_err().to_string()
    };
    assert_eq!(arc((0, 0), (0, 5), PLAIN), "the start point is the centre: the radius is 0");
    assert_eq!(arc((3, 4), (5, 0), PLAIN), "DX = -2 is negative: the line or arc has to lie in the first quadrant");
    assert_eq!(
        arc((5, 0), (0, 25), PLAIN),
        "the end point (0, 25) is off the circle: it is 25.00 from the centre, the start point 5.00, and they may differ by \
         less than 2"
    );
    let centred = Options { centred: true, ..PLAIN };
    assert_eq!(arc((5, 0), (0, 5), centred), "dda-circle has no option --centred");
    let request = Request {
        from: [5, 0, 0],
        options: Options { as_printed: true, normalise: true, ..PLAIN },
        ..Request::new(Method::DdaCircle, [0, 5, 0])
    };
    let refused = request.draw().map(|_| ()).unwrap_err().to_string();
    assert_eq!(refused, "dda-circle has no option --normalise together with --as-printed");
}
