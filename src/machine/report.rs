//! What was measured, as a table for people, JSON, and lines of CSV.

use std::fmt::Write as _;
use std::io;

use serde_json::{Value, json};

use super::clockwork::Times;
use super::plan::Scale;
use super::program::Feed;
use super::{Drawn, Outcome, Settings, Survey};

/// A report of a program.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// How the program is called.
    pub name: &'a str,
    /// The machine.
    pub settings: &'a Settings,
    /// The program.
    pub survey: &'a Survey,
    /// The methods.
    pub outcomes: &'a [Outcome],
}

/// A number with separators of thousands.
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(c);
    }
    text
}

fn plural(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(n), if n == 1 { one } else { many })
}

/// A time with four digits, in the unit that suits it.
#[must_use]
pub fn time(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s >= 1.0 || s == 0.0 => (s, "s"),
        s if s >= 1e-3 => (s * 1e3, "ms"),
        s if s >= 1e-6 => (s * 1e6, "us"),
        s => (s * 1e9, "ns"),
    };
    let decimals = if value >= 100.0 {
        1
    } else if value >= 10.0 {
        2
    } else {
        3
    };
    format!("{value:.decimals$} {unit}")
}

impl Report<'_> {
    fn scale(&self) -> String {
        match &self.settings.scale {
            Scale::Blu(blu) => format!("{blu} mm a BLU"),
            Scale::Steps([x, y, z]) => format!("{x}, {y} and {z} BLU a mm"),
        }
    }

    /// The deviation below which this part of the clocks is, in tenths of a BLU upwards.
    fn within(outcome: &Outcome, part: f64) -> f64 {
        let all: u64 = outcome.run.histogram.iter().sum();
        let mut sum = 0;
        for (bin, n) in outcome.run.histogram.iter().enumerate() {
            sum += n;
            if sum as f64 >= part * all as f64 {
                return (bin + 1) as f64 / 10.0;
            }
        }
        0.0
    }

    /// The table.
    #[must_use]
    pub fn table(&self) -> String {
        let Survey { summary, moves, .. } = *self.survey;
        let mut t = String::new();
        let _ = writeln!(
            t,
            "{}: {}, {} ({}, {}, {}; {} rapid), {:.3} mm",
            self.name,
            plural(summary.blocks, "block", "blocks"),
            plural(moves.iter().sum(), "move", "moves"),
            plural(moves[0], "line", "lines"),
            plural(moves[1], "arc", "arcs"),
            plural(moves[2], "helix", "helices"),
            grouped(self.survey.rapids),
            self.survey.length
        );
        let _ = writeln!(
            t,
            "{}, registers of {} bits; {}, {}",
            self.scale(),
            self.survey.bits,
            plural(self.survey.nothing, "move rounds to nothing", "moves round to nothing"),
            plural(self.survey.flattened, "arc is so flat that it is a line", "arcs are so flat that they are lines"),
        );
        if summary.skipped > 0 || summary.recorded > 0 {
            let _ = writeln!(
                t,
                "{} skipped by /, {} not simulated",
                plural(summary.skipped, "block", "blocks"),
                plural(summary.recorded, "M code", "M codes")
            );
        }
        let bounds = self.survey.bounds.map(|[least, greatest]| format!("{least} … {greatest}"));
        let _ = writeln!(t, "x {}, y {}, z {} BLU", bounds[0], bounds[1], bounds[2]);
        let width = self.outcomes.iter().map(|o| o.run.choice.to_string().len()).max().unwrap_or(6).max(6);
        let _ = writeln!(t, "\nDeviation, BLU");
        let _ = writeln!(
            t,
            "{:width$}  {:>13}  {:>9}  {:>9}  {:>9}  {:>8}  worst block",
            "method", "clocks", "from BLU", "from mm", "99 % <", "50 % <"
        );
        for outcome in self.outcomes {
            let run = &outcome.run;
            let worst = &outcome.worst;
            let place = if worst.line == 0 {
                String::new()
            } else {
                let text: String = worst.text.chars().filter(|c| !c.is_control()).take(40).collect();
                format!("{}:{}  {text}", worst.line, worst.column)
            };
            let _ = writeln!(
                t,
                "{:width$}  {:>13}  {:>9.3}  {:>9.3}  {:>9.1}  {:>8.1}  {place}",
                run.choice.to_string(),
                grouped(run.clocks),
                run.interpolation,
                run.total.0,
                Report::within(outcome, 0.99),
                Report::within(outcome, 0.5)
            );
        }
        let _ = writeln!(t, "\nFeed, 1 = as commanded; tick {}", self.settings.tick.time(1));
        let _ = writeln!(
            t,
            "{:width$}  {:8}  {:>11}  {:>7}  {:>7}  {:>7}  {:>11}  {:>9}  {:>9}",
            "method", "feed", "time", "least", "mean", "most", "pulses/s", "gap", "direction"
        );
        for outcome in self.outcomes {
            let run = &outcome.run;
            let last = self.settings.rules.len() - 1;
            for (i, (rule, times)) in self.settings.rules.iter().zip(&run.times).enumerate() {
                // a DDA has one rule, whichever is asked for
                if run.choice.all_dda() && i != last {
                    continue;
                }
                let feed = if run.choice.all_dda() { "block".to_owned() } else { rule.to_string() };
                let _ = write!(t, "{:width$}  {feed:8}  ", run.choice.to_string());
                let seconds = self.settings.seconds();
                let [least, _, most] = times.speed;
                let mean = run.ideal / times.ticks.max(1) as f64;
                let speed = |v: f64| if v.is_finite() && run.clocks > 0 { format!("{v:.3}") } else { "-".to_owned() };
                let ticks = |n: u64| if n == u64::MAX { "-".to_owned() } else { time(n as f64 * seconds) };
                let rate = if times.gap == u64::MAX {
                    "-".to_owned()
                } else {
                    grouped((1.0 / (times.gap as f64 * seconds)).round() as u64)
                };
                let _ = writeln!(
                    t,
                    "{:>11}  {:>7}  {:>7}  {:>7}  {rate:>11}  {:>9}  {:>9}",
                    time(times.ticks as f64 * seconds),
                    speed(least),
                    speed(mean),
                    speed(most),
                    ticks(times.gap),
                    ticks(times.setup)
                );
            }
        }
        t
    }

    /// The same for programs.
    #[must_use]
    pub fn json(&self) -> Value {
        let Survey { summary, moves, .. } = *self.survey;
        let seconds = self.settings.seconds();
        let scale = match &self.settings.scale {
            Scale::Blu(blu) => json!({ "blu": blu.to_f64() }),
            Scale::Steps(steps) => json!({ "steps_per_mm": steps.map(|s| s.to_f64()) }),
        };
        let methods: Vec<Value> = self
            .outcomes
            .iter()
            .map(|outcome| {
                let run = &outcome.run;
                let feeds: Vec<Value> = self
                    .settings
                    .rules
                    .iter()
                    .zip(&run.times)
                    .map(|(rule, times)| {
                        let mut feed = times_json(times, seconds);
                        feed["feed"] = json!(rule.to_string());
                        feed["speed"]["mean"] = json!(run.ideal / times.ticks.max(1) as f64);
                        feed
                    })
                    .collect();
                json!({
                    "line": run.choice.line.name(),
                    "arc": run.choice.arc.name(),
                    "space": run.choice.space.name(),
                    "centred": run.choice.centred,
                    "clocks": run.clocks,
                    "steps": run.steps,
                    "end": run.at(),
                    "interpolation": run.interpolation,
                    "total": run.total.0,
                    "worst": { "line": outcome.worst.line, "column": outcome.worst.column, "text": outcome.worst.text },
                    "histogram": { "bin": 0.1, "clocks": run.histogram },
                    "feeds": feeds,
                })
            })
            .collect();
        json!({
            "program": {
                "name": self.name,
                "lines": summary.lines,
                "blocks": summary.blocks,
                "skipped": summary.skipped,
                "recorded": summary.recorded,
                "moves": { "lines": moves[0], "arcs": moves[1], "helices": moves[2] },
                "rapids": self.survey.rapids,
                "nothing": self.survey.nothing,
                "flattened": self.survey.flattened,
                "circles": self.survey.circles,
                "length_mm": self.survey.length,
                "dwell_s": self.survey.dwell,
                "bounds": self.survey.bounds,
            },
            "machine": {
                "scale": scale,
                "bits": self.survey.bits,
                "tick_s": seconds,
                "rapid_mm_min": self.settings.rapid.to_f64(),
            },
            "methods": methods,
        })
    }
}

fn times_json(times: &Times, seconds: f64) -> Value {
    let [least, mean, most] = times.speed.map(|v| if v.is_finite() { json!(v) } else { Value::Null });
    let ticks = |n: u64| if n == u64::MAX { Value::Null } else { json!(n as f64 * seconds) };
    json!({
        "time_s": times.ticks as f64 * seconds,
        "speed": { "least": least, "mean": mean, "most": most },
        "gap_s": ticks(times.gap),
        "direction_s": ticks(times.setup),
    })
}

/// The first line of CSV.
pub const CSV: &str = "line,column,method,shape,from_x,from_y,from_z,to_x,to_y,to_z,mm,mm_min,clocks,interpolation,total,\
                       feed,time_s,speed_least,speed_mean,speed_most,gap_s,direction_s\n";

/// The lines of CSV of a block: one for each rule of feed.
///
/// # Errors
/// They cannot be written.
pub fn csv(drawn: &Drawn<'_>, settings: &Settings, to: &mut impl io::Write) -> io::Result<()> {
    let plan = drawn.plan;
    let seconds = settings.seconds();
    let shape = match plan.shape {
        super::plan::Shape::Arc(arc) if plan.from[arc.axes[2]] != plan.to[arc.axes[2]] => "helix",
        super::plan::Shape::Arc(_) => "arc",
        _ if plan.flattened => "flat arc",
        _ if plan.feed == Feed::Rapid => "rapid",
        _ => "line",
    };
    let [a, b] = [plan.from, plan.to].map(|p| p.map(|v| v.to_string()).join(","));
    let speed = plan.speed(settings.rapid.to_f64()) * 60.0 * plan.mm / plan.length;
    for (rule, times) in settings.rules.iter().zip(&drawn.measured.times) {
        let [least, mean, most] = times.speed;
        let ticks = |n: u64| if n == u64::MAX { String::new() } else { format!("{:.9}", n as f64 * seconds) };
        writeln!(
            to,
            "{},{},\"{}\",{shape},{a},{b},{:.6},{speed:.3},{},{:.4},{:.4},{rule},{:.9},{least:.4},{mean:.4},{most:.4},{},{}",
            drawn.line.number,
            drawn.line.place.0 + 1,
            drawn.choice,
            plan.mm,
            drawn.measured.clocks,
            drawn.measured.interpolation,
            drawn.measured.total,
            times.ticks as f64 * seconds,
            ticks(times.gap),
            ticks(times.setup)
        )?;
    }
    Ok(())
}
