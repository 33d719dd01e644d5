//! The feed system, hazards and all, beside a model of its own in Verilog on Icarus: `tests/verilog/feed_tb.v`.

use std::process::Command;

use crate::support::feed::System;
use crate::support::{Rng, folder, repository};
use discreta::interpolate::feed::Margins;
use discreta::wave::read::Waves;
use needs::needs;

/// The defaults of the circuit.
const SAFE: Margins = Margins { step: 20, high: 10, tau: 17, hold: 2, tick: 10, dt_high: 2 };

/// The rising edges of Δt as Icarus has them: time, and which drives step.
fn icarus(m: Margins, start: u64, line: (u64, u64), period: u64, constant: bool) -> Vec<(u64, bool, bool)> {
    let name = format!("{m:?}{start}{line:?}{period}{constant}").replace(|c: char| !c.is_alphanumeric(), "");
    let vvp = folder("feed_icarus").join(name + ".vvp");
    let mut compile = Command::new("iverilog");
    compile.args(["-g2005", "-s", "feed_tb", "-o"]).arg(&vvp);
    let parameters = [
        ("DX", line.0),
        ("DY", line.1),
        ("STEP", m.step),
        ("STEP_HIGH", m.high),
        ("TICK", m.tick),
        ("HIGH", m.dt_high),
        ("TAU", m.tau),
        ("HOLD", m.hold),
        ("START", start),
        ("PERIOD", period),
        ("CONSTANT", u64::from(constant)),
    ];
    for (name, value) in parameters {
        compile.arg(format!("-Pfeed_tb.{name}={value}"));
    }
    compile.arg(repository("benches/verilog/line_rtl.v")).arg(repository("tests/verilog/feed_tb.v"));
    let output = compile.output().expect("this test compares with Icarus Verilog: apt-get install iverilog");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = Command::new("vvp").arg("-n").arg(&vvp).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("\nend "), "{text}");
    let pulses = text.lines().filter_map(|line| {
        let [time, x, y] = line.split(' ').collect::<Vec<_>>()[..] else { return None };
        Some((time.parse().unwrap(), x == "1", y == "1"))
    });
    pulses.collect()
}

#[needs(iverilog)]
#[test]
fn icarus_agrees_within_the_margins_and_outside() {
    let settings = [
        SAFE,
        Margins { step: 40, high: 10, tau: 21, ..SAFE },
        Margins { tau: 8, ..SAFE },
        Margins { hold: 0, ..SAFE },
        Margins { hold: 1, ..SAFE },
        Margins { tau: 35, hold: 5, ..SAFE },
    ];
    let (mut rng, mut pulses) = (Rng::new(3), 0);
    for margins in settings {
        // the scenario's own line, one on the diagonal, one along x, one at random
        for line in [(5, 3), (9, 9), (6, 0), (rng.below(30), 1 + rng.below(30))] {
            let (period, constant) = ((margins.least_ticks() << 8) + rng.below(2000), rng.one_in(2));
            let run = System::new(margins, []).draw(line.0, line.1, period, constant);
            let theirs = icarus(margins, 2 * margins.tau + 2, line, period, constant);
            assert_eq!(run.pulses, theirs, "{margins:?}, line {line:?}, period {period}, {constant}");
            pulses += theirs.len();
        }
    }
    println!("{pulses} pulses of Δt");
}

/// Of the golden trace every pulse, at its time.
#[needs(iverilog)]
#[test]
fn icarus_agrees_with_the_golden_trace() {
    let mut waves = Waves::open(&repository("traces/feed/system_5_3.vcd")).unwrap();
    // the times at which each becomes 1
    let [dt, x, y] = ["system.dt", "system.x", "system.y"].map(|name| {
        let var = waves.find(name).unwrap();
        let changes: Vec<(u64, String)> = waves.load(var).unwrap().changes().collect();
        changes.into_iter().filter(|c| c.1 == "1").map(|c| c.0).collect::<Vec<_>>()
    });
    let golden: Vec<_> = dt.iter().map(|t| (*t, x.contains(t), y.contains(t))).collect();
    assert_eq!(golden.len(), 5);
    assert_eq!(golden, icarus(SAFE, 22, (5, 3), 3200, true));
}
