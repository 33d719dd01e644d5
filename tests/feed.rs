//! The speed block, the synchroniser and the whole system, beside the algorithms of `interpolate::feed`.

mod support;

use discreta::Simulator;
use discreta::interpolate::feed::{Feed, Generator, Margins, Stores};
use discreta::interpolate::{EfLine, LineInput};
use support::Rng;
use support::bench::circuit;
use support::feed::{Found, System};

/// The speed block against the generator, at every edge of its clock, with pulses of the axes and waits at random.
fn speed_block(path: &str) {
    let mut pulses = 0;
    for (seed, (whole, fraction, high)) in [(8, 8, 2), (4, 6, 1), (12, 4, 5), (2, 1, 1)].into_iter().enumerate() {
        let parameters = [("I", i64::from(whole)), ("Q", i64::from(fraction)), ("HIGH", high as i64)];
        let speed_block = circuit(path, &parameters);
        let mut sim = Simulator::new(&speed_block.netlist);
        let input = ["clk", "start", "enable", "constant", "period", "x", "y", "z"].map(|n| sim.input(n).unwrap());
        let [clk, start, enable, constant, period, x, y, z] = input;
        let [dt, elapsed, carried] = ["dt", "elapsed", "fraction"].map(|n| sim.probe(n).unwrap());
        let mut rng = Rng::new(seed as u64);
        for run in 0..40 {
            let (least, most) = ((high + 1).max(2) << fraction, 1 << (whole + fraction));
            // short periods often, for many pulses
            let most = if run % 4 == 0 { most } else { most.min(8 * least) };
            let (number, rule) = (least + rng.below(most - least), rng.one_in(2));
            let mut generator = Generator::new(number, whole, fraction, high, rule).unwrap();
            for (input, value) in [(clk, 0), (constant, u64::from(rule)), (period, number), (start, 1)] {
                sim.set(input, value);
            }
            sim.settle().unwrap();
            sim.set(start, 0);
            sim.set(period, rng.word()); // loaded already
            for tick in 0..600 {
                let (go, axes) = (!rng.one_in(8), rng.below(8));
                for (bit, input) in [x, y, z].into_iter().enumerate() {
                    sim.set(input, axes >> bit);
                }
                sim.set(enable, u64::from(go));
                sim.set(clk, 0);
                sim.settle().unwrap();
                sim.set(clk, 1);
                sim.settle().unwrap();
                let was = generator.dt();
                generator.clock(go, axes.count_ones() as usize);
                pulses += u64::from(generator.dt() && !was);
                let shown = [&dt, &elapsed, &carried].map(|p| sim.number(p).unwrap());
                let expected = [u64::from(generator.dt()), generator.elapsed(), generator.fraction()];
                assert_eq!(shown, expected, "{parameters:?}, period {number}, {rule}, tick {tick}");
            }
        }
    }
    println!("{path}: {pulses} pulses");
    assert!(pulses > 10_000);
}

#[test]
fn the_speed_block_is_the_generator_on_every_clock() {
    speed_block("circuits/feed/speed_block.json");
}

#[test]
fn the_speed_block_of_gates_is_the_generator_on_every_clock() {
    speed_block("circuits/feed/speed_block_gates.json");
}

/// One synchroniser against its store, with steps and pulses in any order that keeps the margins.
#[test]
fn the_synchroniser_is_a_store_of_two_steps() {
    for tau in [2, 7, 15, 100] {
        let synchroniser = circuit("circuits/feed/synchroniser.json", &[("TAU", tau)]);
        let tau = tau as u64;
        let mut sim = Simulator::new(&synchroniser.netlist);
        let [start, step, dt] = ["start", "step", "dt"].map(|n| sim.input(n).unwrap());
        let [drive, stop, waiting, full] = ["drive", "stop", "waiting", "full"].map(|n| sim.probe(n).unwrap());
        for (input, value) in [(step, 0), (dt, 0), (start, 1)] {
            sim.set(input, value);
        }
        sim.settle().unwrap();
        sim.run_to(4 * tau).unwrap();
        sim.set(start, 0);
        let (mut store, mut rng) = (Stores::default(), Rng::new(tau));
        for _ in 0..2000 {
            let pulse = if !store.stop() && rng.one_in(2) { step } else { dt };
            sim.set(pulse, 1);
            sim.settle().unwrap();
            let driven = if pulse == dt { store.take()[0] } else { !store.put([true, false, false]) };
            assert_eq!(sim.number(&drive), Some(u64::from(driven)));
            let width = 1 + rng.below(tau - 1);
            sim.run_to(sim.now() + width).unwrap();
            sim.set(pulse, 0);
            sim.settle().unwrap();
            // long enough for the RC node to come to rest
            sim.run_to(sim.now() + 8 * tau + rng.below(3)).unwrap();
            let shown = [&drive, &stop, &waiting, &full].map(|p| sim.number(p).unwrap());
            let held = store.waiting()[0];
            assert_eq!(shown, [0, u64::from(store.stop()), u64::from(held > 0), u64::from(held > 1)]);
        }
    }
}

/// Random lines, some of them along an axis.
fn lines(rng: &mut Rng, n: usize, most: u64) -> Vec<(u64, u64)> {
    let mut line = || {
        let mut increment = || if rng.one_in(10) { 0 } else { 1 + rng.below(most) };
        (increment(), increment())
    };
    (0..n).map(|_| line()).collect()
}

const MARGINS: Margins = Margins { step: 20, high: 10, tau: 17, hold: 2, tick: 10, dt_high: 2 };

/// Within the margins: no violation, each pulse of Δt with the steps and after the interval that the algorithm has.
#[test]
fn the_system_is_the_algorithm_on_every_pulse_within_the_margins() {
    let mut rng = Rng::new(14);
    let (mut runs, mut pulses, mut refused) = (0, 0, 0);
    for case in 0..200 {
        let step = 6 + rng.below(40);
        let high = 1 + rng.below(step - 2);
        let tau = high + 1 + rng.below(step - high - 1);
        let margins =
            Margins { step, high, tau, hold: 1 + rng.below(3), tick: 2 + rng.below(12), dt_high: 1 + rng.below(6) };
        if margins.check().is_err() {
            refused += 1;
            continue;
        }
        let least = margins.least_ticks();
        let whole = 32 - (4 * least).leading_zeros().min(31) + 34;
        let whole = whole.saturating_sub(32).clamp(6, 12) + 3;
        let mut system = System::new(
            margins,
            [("I", i64::from(whole)), ("STEP_PHASE", rng.below(step) as i64), ("TICK_PHASE", rng.below(20) as i64)],
        );
        for (dx, dy) in lines(&mut rng, 6, 40) {
            let period = (least << 8) + rng.below(3 * least << 8);
            let constant = case % 2 == 0;
            let run = system.draw(dx, dy, period, constant);
            let told = format!("{margins:?}, line ({dx}, {dy}), period {period}");
            assert!(run.violations.iter().all(|v| v.1 == 0), "{told}: {:?}", run.violations);
            let mut generator = Generator::new(period, whole, 8, margins.dt_high, constant).unwrap();
            let feed = Feed::new(EfLine::new(LineInput::new(dx as i64, dy as i64)).unwrap());
            let mut due = generator.interval(0);
            let mut last = None;
            let mut expected = Vec::new();
            for [x, y, _] in feed {
                let at: u64 = *run.pulses.get(expected.len()).map_or(&0, |p| &p.0);
                if let Some(last) = last {
                    assert_eq!(at - last, due * margins.tick, "{told}, pulse {}", expected.len());
                }
                last = Some(at);
                expected.push((at, x, y));
                due = generator.interval(usize::from(x) + usize::from(y));
            }
            assert_eq!(run.pulses, expected, "{told}");
            runs += 1;
            pulses += expected.len();
        }
    }
    println!("{runs} runs, {pulses} pulses of Δt, {refused} settings outside the margins");
    assert!(runs > 300);
}

/// Draws lines at every phase of the interpolator's clock: how many runs gain steps, lose steps, have a runt pulse.
/// `period` is that of Δt in ticks times 2^8.
fn hazards(margins: Margins, extra: &[(&'static str, i64)], period: u64, along_an_axis: bool) -> Found {
    let mut rng = Rng::new(1);
    let mut all = Found::default();
    for phase in 0..margins.step {
        let mut parameters = extra.to_vec();
        parameters.extend([("STEP_PHASE", phase as i64), ("I", 12)]);
        let mut system = System::new(margins, parameters);
        for (dx, dy) in lines(&mut rng, 20, 60) {
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
