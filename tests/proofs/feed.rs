//! The speed block, the synchroniser and the whole system, beside the algorithms of `interpolate::feed`.

use crate::support::bench::circuit;
use crate::support::engines::{self, simulator};
use crate::support::feed::{self, Found, System};
use crate::support::{Rng, folder, repository};
use discreta::circuit::{Circuit, load_with};
use discreta::interpolate::feed::{Generator, Margins};
use discreta::interpolate::{ArcInput, DdaCircle, DdaLine, Interpolator, LineInput, Options};
use serde_json::{Value, json};

const SPEED_BLOCKS: [&str; 2] = ["circuits/feed/speed_block.json", "circuits/feed/speed_block_gates.json"];

#[test]
fn the_speed_block_is_the_generator_on_every_clock() {
    for path in SPEED_BLOCKS {
        let mut pulses = 0;
        for (whole, fraction, high) in [(8, 8, 2), (4, 6, 1), (12, 4, 5), (2, 1, 1), (20, 12, 3)] {
            let parameters = [("I", i64::from(whole)), ("Q", i64::from(fraction)), ("HIGH", high as i64)];
            let shifts = [("S", if whole == 2 { 2 } else { 3 })];
            let parameters = [&parameters[..], &shifts].concat();
            let proof = feed::speed_block(&circuit(path, &parameters), whole, fraction, high);
            pulses += proof.unwrap_or_else(|fault| panic!("{path}, {parameters:?}: {fault}"));
        }
        println!("{path}: {pulses} pulses");
        assert!(pulses > 10_000);
    }
    engines::ran(0, 0);
}

#[test]
fn the_synchroniser_is_a_store_of_two_steps() {
    for tau in [2, 7, 15, 100] {
        let synchroniser = circuit("circuits/feed/synchroniser.json", &[("TAU", tau)]);
        feed::synchroniser(&synchroniser, tau as u64).unwrap_or_else(|fault| panic!("τ = {tau}: {fault}"));
    }
    engines::ran(0, 0);
}

const PACED: &str = "circuits/feed/paced.json";
const NORMALISED: [Options; 2] = {
    let plain = Options { as_printed: false, half_preload: false, parallel: false, normalise: false, centred: false };
    [plain, Options { normalise: true, ..plain }]
};

fn generator(period: u64) -> Generator {
    Generator::new(period, 16, 8, 2, false).unwrap()
}

/// Ticks that the clocks of an interpolator take, each 2^shifts periods.
fn duration(mut interpolator: impl Interpolator, period: u64) -> u64 {
    let (mut generator, mut ticks) = (generator(period), 0);
    loop {
        let shifts = interpolator.state().sum[2] as u32;
        if interpolator.next().is_none() {
            return ticks;
        }
        ticks += generator.interval(0, shifts);
    }
}

/// The longest interval of a normalised arc, ticks.
fn longest(arc: ArcInput, period: u64) -> f64 {
    let circle = DdaCircle::new(arc, &NORMALISED[1]).unwrap();
    let most =
        circle.state().sum[2].max(circle.filter(|clock| !clock.end).map(|clock| clock.sum[2]).max().unwrap_or(0));
    (period << most) as f64 / 256.0
}

/// The normalised quarter is the algorithms on every clock of `clk`, and takes as long as the one that is not, but for
/// less than two of its longest intervals.
#[test]
fn a_paced_quarter_takes_the_time_of_one_without_normalisation() {
    for clockwise in [false, true] {
        let circuits = [0, 1].map(|normalise| {
            circuit(PACED, &[("W", 6), ("CLOCKWISE", i64::from(clockwise)), ("NORMALISE", normalise)])
        });
        let mut benches = circuits.each_ref().map(|circuit| simulator(&circuit.netlist));
        let mut rng = Rng::new(6);
        for r in 1..64 {
            let (from, to) = if clockwise { ((0, r), (r, 0)) } else { ((r, 0), (0, r)) };
            let arc = ArcInput::between(from, to, clockwise, 6);
            let inputs = [arc.xh, arc.yh, arc.dx, arc.dy].map(|v| v as u64);
            let period = (3 << 8) + rng.below(2 << 8);
            let [plain, normalised] = [0, 1].map(|n| {
                let circle = DdaCircle::new(arc, &NORMALISED[n]).unwrap();
                let ticks = feed::paced(&mut benches[n], "core", inputs, period, circle.clone(), generator(period));
                let ticks = ticks.unwrap_or_else(|fault| panic!("R = {r}, {period}, {clockwise}: {fault}"));
                // the end comes with the trailing edge of the last pulse
                assert_eq!(ticks, duration(circle, period) + 2);
                ticks
            });
            let longest = longest(arc, period);
            assert!(
                normalised.abs_diff(plain) as f64 <= 2.0 * longest + 1.0,
                "R = {r}: {normalised} ticks, {plain} without"
            );
        }
    }
    engines::ran(0, 0);
}

/// A line takes exactly as long: 2^p periods.
#[test]
fn a_paced_line_takes_exactly_the_time_of_one_without_normalisation() {
    let circuits = [0, 1].map(|normalise| circuit(PACED, &[("W", 5), ("LINE", 1), ("NORMALISE", normalise)]));
    let mut benches = circuits.each_ref().map(|circuit| simulator(&circuit.netlist));
    let mut rng = Rng::new(5);
    for _ in 0..80 {
        let [dx, dy] = [0; 2].map(|_| rng.below(32) >> rng.below(5));
        let [xh, yh] = [dx, dy].map(|d| rng.below(32 - d));
        let period = (3 << 8) + rng.below(2 << 8);
        for n in [0, 1] {
            let [xh, yh, dx, dy] = [xh, yh, dx, dy].map(|v| v as i64);
            let line = DdaLine::new(LineInput { xh, yh, dx, dy, bits: 5 }, &NORMALISED[n]).unwrap();
            let inputs = [xh, yh, dx, dy].map(|v| v as u64);
            let ticks = feed::paced(&mut benches[n], "core_line", inputs, period, line, generator(period));
            let ticks = ticks.unwrap_or_else(|fault| panic!("({dx}, {dy}), {period}: {fault}"));
            assert_eq!(ticks, if dx + dy == 0 { 0 } else { ((period << 5) >> 8) + 2 }, "({dx}, {dy})");
        }
    }
    engines::ran(0, 0);
}

/// All quarters of 8 bits, by the algorithms.
#[test]
fn every_8_bit_quarter_takes_the_time_of_one_without_normalisation() {
    let period = 832;
    let mut worst: f64 = 0.0;
    for r in 1..256 {
        let arc = ArcInput::between((r, 0), (0, r), false, 8);
        let [plain, normalised] =
            NORMALISED.each_ref().map(|options| duration(DdaCircle::new(arc, options).unwrap(), period));
        let longest = longest(arc, period);
        let off = (normalised as f64 - plain as f64).abs();
        assert!(off <= 2.0 * longest + 1.0, "R = {r}: {normalised} ticks, {plain} without");
        worst = worst.max(off / longest);
    }
    println!("at most {worst:.3} of the longest interval");
    assert!((1.0..2.0).contains(&worst));
}

/// Within the margins: no violation, each pulse of Δt with the steps and after the interval that the algorithm has.
#[test]
fn the_system_is_the_algorithm_on_every_pulse_within_the_margins() {
    let mut rng = Rng::new(14);
    let (mut runs, mut pulses, mut refused) = (0, 0, 0);
    for _ in 0..200 {
        let step = 6 + rng.below(40);
        let high = 1 + rng.below(step - 2);
        let tau = high + 1 + rng.below(step - high - 1);
        let (hold, tick, dt_high) = (1 + rng.below(3), 2 + rng.below(12), 1 + rng.below(6));
        let margins = Margins { step, high, tau, hold, tick, dt_high };
        if margins.check().is_err() {
            refused += 1;
            continue;
        }
        let phases = [("STEP_PHASE", rng.below(step) as i64), ("TICK_PHASE", rng.below(20) as i64), ("I", 12)];
        let mut system = System::new(margins, phases);
        for line in feed::lines(&mut rng, 6, 40) {
            let period = (margins.least_ticks() << 8) + rng.below((3 * margins.least_ticks()) << 8);
            let proof = system.prove(margins, line, period, rng.one_in(2));
            // the next with a START half way
            system.start_again(rng.below((40 * period * tick) >> 8));
            pulses += proof.unwrap_or_else(|fault| panic!("{margins:?}, {phases:?}, line {line:?}: {fault}"));
            runs += 1;
        }
    }
    println!("{runs} runs, {pulses} pulses of Δt, {refused} settings outside the margins");
    assert!(runs > 300);
}

const MARGINS: Margins = Margins { step: 20, high: 10, tau: 17, hold: 2, tick: 10, dt_high: 2 };

/// Draws lines at every phase of the interpolator's clock: how many runs gain steps, lose steps, have a runt pulse.
/// `period` is that of Δt in ticks times 2^8.
fn hazards(margins: Margins, extra: &[(&'static str, i64)], period: u64, along_an_axis: bool) -> Found {
    let mut rng = Rng::new(1);
    let mut all = Found::default();
    for phase in 0..margins.step {
        let mut parameters = extra.to_vec();
        parameters.extend([("STEP_PHASE", phase as i64), ("I", 12)]);
        let mut system = System::new(margins, parameters);
        for (dx, dy) in feed::lines(&mut rng, 20, 60) {
            let (dx, dy) = if along_an_axis { (dx * dy + 2, 0) } else { (dx, dy) };
            if dx + dy > 0 {
                all.add(&system.draw(dx, dy, period, false), (dx, dy));
            }
        }
    }
    let (gained, lost, faulty) = (all.gained(), all.lost(), all.faulty());
    println!("{margins:?}, {extra:?}: of {} runs {gained} gain, {lost} lose, {faulty} at fault", all.runs.len());
    assert!(all.runs.len() > 350);
    all
}

#[test]
fn a_delay_shorter_than_the_step_pulse_makes_every_run_gain_steps() {
    for tau in [2, 5, 9] {
        let found = hazards(Margins { tau, ..MARGINS }, &[], 20 << 8, false);
        assert_eq!(found.gained(), found.runs.len());
    }
}

/// The step comes 10 to 29 ns after Δt. In the earlier phases the RC node has not fallen, which takes 17 ns; in the later
/// ones it has, but what charge is left makes it rise again within the step pulse. So the phase does not matter, and the
/// lines that gain steps are those on which an axis whose store has just been emptied steps next: nearer to the diagonal
/// than 1 : 2.
#[test]
fn a_free_running_clock_makes_a_third_of_the_runs_gain_steps() {
    let free = Margins { hold: 0, ..MARGINS };
    for period in [20 << 8, (20 << 8) + 77] {
        let found = hazards(free, &[], period, false);
        let share = found.share(found.gained());
        assert!((0.3..=0.4).contains(&share), "{share}");
        assert_eq!(found.lost(), 0);
        for run in &found.runs {
            let (dx, dy) = run.line;
            assert_eq!(run.gained, dx != dy && 2 * dx.min(dy) > dx.max(dy) || dx == dy && dx > 1, "({dx}, {dy})");
        }
    }
}

#[test]
fn a_clock_held_after_the_feed_clock_never_gains_or_loses_a_step() {
    for period in [20 << 8, (20 << 8) + 77, 12 << 8] {
        assert_eq!(hazards(MARGINS, &[], period, false).faulty(), 0);
    }
}

#[test]
fn a_delay_longer_than_the_period_of_the_steps_loses_steps() {
    let long = Margins { tau: 35, hold: 5, ..MARGINS };
    let found = hazards(long, &[], 30 << 8, true);
    assert_eq!(found.lost(), found.runs.len(), "the second step of the first fill");
    // a longer one also where a step of the other axis comes between
    let longer = Margins { tau: 55, hold: 8, ..MARGINS };
    let found = hazards(longer, &[], 30 << 8, false);
    println!("{} of {} lose steps", found.lost(), found.runs.len());
    assert!(found.share(found.lost()) > 0.5 && found.gained() == 0);
}

#[test]
fn a_pulse_during_the_first_fill_is_cut() {
    let found = hazards(MARGINS, &[("FILL", 0)], 13 << 8, false);
    assert!(found.count(|run| run.runt) > 10);
    assert_eq!(hazards(MARGINS, &[("FILL", 1)], 13 << 8, false).faulty(), 0);
}

/// The proofs above notice a fault: each of these changes one thing in a circuit, and has to be caught.
#[test]
fn faults_in_the_circuits_are_caught() {
    type Proof = fn(Circuit) -> Result<(), String>;
    /// A module, its file, its proof, and the cell, field and wrong value of each fault.
    type Faults<'f> = (&'f str, &'f str, Proof, &'f [(&'f str, Value)]);
    let speed: Proof = |c| feed::speed_block(&c, 8, 8, 2).map(|_| ());
    let sync: Proof = |c| feed::synchroniser(&c, 15);
    let system: Proof = |c| {
        let (mut system, mut rng) = (System::of(c, MARGINS.tau), Rng::new(2));
        let mut lines = feed::lines(&mut rng, 12, 20);
        lines.extend([(1, 0), (0, 1), (1, 1), (9, 9)]);
        // the longest first fill, with START at every phase
        lines.extend([(0, 5); 20]);
        let margins = Margins { high: 12, dt_high: 1, ..MARGINS };
        assert_eq!((margins.check(), margins.least_ticks()), (Ok(()), 11));
        for (n, line) in (0..).zip(lines) {
            system.prove(margins, line, (11 << 8) + n % 2 * 300, n % 3 == 0)?;
            system.start_again(100 + 37 * n);
        }
        Ok(())
    };
    let paced: Proof = |c| {
        let mut sim = simulator(&c.netlist);
        for r in [5, 9] {
            let arc = ArcInput::between((r, 0), (0, r), false, 6);
            let circle = DdaCircle::new(arc, &NORMALISED[1]).unwrap();
            feed::paced(&mut sim, "core", [r, 0, r, r].map(|v| v as u64), 900, circle, generator(900))?;
        }
        Ok(())
    };
    let faults: [Faults; 4] = [
        (
            "speed_block",
            "circuits/feed/speed_block.json",
            speed,
            &[
                ("register1/connections/async_load", json!("1'b1")),
                ("register2/connections/en", json!("1'b1")),
                ("register2/connections/d", json!(["z", "y", "y"])),
                ("and1/type", json!("or")),
                ("choice/connections/in", json!(["9'd256", "9'd255", "two", "three"])),
                ("two/parameters/value", json!(362)),
                ("three/parameters/value", json!(442)),
                ("shift/connections/a", json!("period")),
                ("shift/connections/s", json!("3'd0")),
                ("scale/connections/a", json!("programmed")),
                ("adder/connections/b", json!(["(I+2)'d0", "fraction[Q+7:1]"])),
                ("register3/connections/load", json!("due")),
                ("register3/connections/reset", json!("1'b0")),
                ("counter/connections/d", json!(0)),
                ("counter/connections/en", json!("1'b1")),
                ("counter/connections/async_load", json!("1'b0")),
                ("comparator1/type", json!("gt")),
                ("comparator2/type", json!("gt")),
                ("and2/connections/in", json!(["due", "due"])),
                ("pulse/connections/en", json!("fire")),
                ("pulse/connections/reset", json!("1'b0")),
            ],
        ),
        (
            "synchroniser",
            "circuits/feed/synchroniser.json",
            sync,
            &[
                ("rc/connections/a", json!("step")),
                ("and1/type", json!("or")),
                ("and1/connections/in", json!(["step", "waiting"])),
                ("t1/connections/d", json!("full")),
                ("t1/parameters/edge", json!("rising")),
                ("t1/connections/set", json!("1'b0")),
                ("t2/connections/d", json!("1'b0")),
                ("t2/connections/set", json!("second")),
                ("t2/parameters/edge", json!("rising")),
                ("t1/connections/reset", json!("1'b0")),
                ("t2/connections/reset", json!("1'b0")),
                ("and2/type", json!("or")),
                ("and3/connections/in", json!(["dt", "full"])),
                ("and3/connections/in", json!(["waiting", "waiting"])),
            ],
        ),
        (
            "system",
            "circuits/feed/system.json",
            system,
            &[
                ("generator/parameters/high", json!("STEP_HIGH + 7")),
                ("sync_x/connections/step", json!("step_y")),
                ("sync_y/connections/dt", json!("clk")),
                ("speed/connections/x", json!("step_x")),
                ("speed/connections/y", json!("1'b0")),
                ("speed/connections/constant", json!("1'b1")),
                ("or1/connections/in", json!(["stop_x", "stop_x"])),
                ("or2/connections/in", json!(["start", "start"])),
                ("held/connections/d", json!("1'b0")),
                ("nor1/connections/in", json!(["hold[HOLD]", "ended"])),
                ("gate/parameters/edge", json!("rising")),
                ("gate/connections/d", json!("1'b1")),
                ("and1/connections/in", json!(["fast", "go"])),
                ("or3/connections/in", json!(["stop", "stop"])),
                ("and3/connections/in", json!(["rest", "rest"])),
                ("trigger/connections/r", json!("1'b0")),
                ("nor2/connections/in", json!(["not_ended", "waiting_x"])),
                ("and2/connections/in", json!(["first", "first"])),
            ],
        ),
        (
            "paced",
            PACED,
            paced,
            &[
                ("core/connections/dt", json!("clk")),
                ("core/connections/start", json!("1'b0")),
                ("core/parameters", json!({ "W": "W", "CLOCKWISE": "CLOCKWISE", "NORMALISE": 0 })),
                ("not1/type", json!("buf")),
                ("speed/connections/shifts", json!("(clog2(W))'d0")),
                ("speed/connections/start", json!("1'b0")),
                ("speed/connections/enable", json!("1'b1")),
                ("speed/connections/constant", json!("1'b1")),
                ("speed/connections/period", json!(["period[I+Q-2:0]", "1'b0"])),
            ],
        ),
    ];
    let mut unnoticed = Vec::new();
    for (module, path, proof, faults) in faults {
        let mut correct = std::fs::read_to_string(repository(path)).unwrap();
        for import in [
            "../evaluation/line.json",
            "../dda/circle.json",
            "../dda/line.json",
            "../lib/normalise.json",
            "synchroniser.json",
            "speed_block.json",
        ] {
            let whole = repository("circuits/feed").join(import);
            correct = correct.replace(&format!("\"{import}\""), &format!("{whole:?}"));
        }
        let parameters: &[(&str, i64)] = match module {
            "system" => &[("STEP_HIGH", 12), ("HIGH", 1)],
            "paced" => &[("W", 6)],
            _ => &[],
        };
        let caught = |text: &str, name: String| {
            let file = folder("feed_faults").join(name + ".json");
            std::fs::write(&file, text).unwrap();
            proof(load_with(&file, parameters).unwrap_or_else(|fault| panic!("{fault}")))
        };
        assert_eq!(caught(&correct, module.to_owned()), Ok(()));
        for (n, (place, wrong)) in faults.iter().enumerate() {
            let (cell, key) = (place.split('/').next().unwrap(), place.rsplit('/').next().unwrap());
            // the value of the key that comes next after the cell's name
            let mut at = correct.find("\"cells\"").unwrap();
            for sought in [format!("\"{cell}\": {{"), format!("\"{key}\": ")] {
                at += correct[at..].find(&sought).unwrap_or_else(|| panic!("{place}")) + sought.len();
            }
            let mut values = serde_json::Deserializer::from_str(&correct[at..]).into_iter::<Value>();
            assert_ne!(&values.next().unwrap().unwrap(), wrong, "{place} is no fault");
            let end = at + values.byte_offset();
            let faulty = format!("{}{wrong}{}", &correct[..at], &correct[end..]);
            if caught(&faulty, format!("{module}_{n}")).is_ok() {
                unnoticed.push(format!("{module}: {place} = {wrong}"));
            }
        }
    }
    assert_eq!(unnoticed, [""; 0]);
    engines::ran(0, 0);
}
