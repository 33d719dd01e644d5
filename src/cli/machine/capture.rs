//! `--waveform`: the step pulses of a waveform, counted, and compared with a program.

use std::path::Path;

use serde_json::{Value, json};

use super::{Source, Watch, told};
use crate::cli::args::{MachineArgs, MachineFormat, Net, StepDir};
use crate::cli::sample::{self, Changes};
use crate::cli::{CliError, Out, Status, interrupt};
use crate::machine::Settings;
use crate::machine::capture::{Aligned, Block, Counted, Fault, Pulse, Wrong, align, count};
use crate::machine::plan::{Plan, Shape};
use crate::machine::program::{self, Canon, Faults, Refusal};
use crate::machine::report::time;
use crate::wave::read::Waves;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Runs the command.
///
/// # Errors
/// A waveform or program that cannot be read, nets that are not there or unknown.
pub fn run(args: &MachineArgs, waveform: &Path, settings: &Settings, out: &mut Out) -> Result<Status, CliError> {
    interrupt::watch();
    let mut waves = Waves::open(waveform)?;
    let seconds = waves.timescale().map_or(1e-9, |t| t.femtoseconds() as f64 * 1e-15);
    let pulses = pulses(&mut waves, args)?;
    let counted = count(&pulses);
    let name = waveform.display().to_string();
    let Some(program) = &args.program else {
        match args.format {
            MachineFormat::Json => out.json(&json!({ "waveform": counted_json(&name, &counted, seconds) }))?,
            MachineFormat::Csv => {
                return Err(CliError::usage("--format csv has a line for each block: name the program"));
            }
            _ => out.bytes(counted_text(&name, &counted, seconds).as_bytes())?,
        }
        out.flush()?;
        return Ok(Status::Done);
    };
    let mut source = Source::open(program)?;
    let blocks = blocks(&mut source, settings)?;
    if blocks.is_empty() {
        return Err(CliError::usage(format!("`{}` moves nothing", source.name)));
    }
    let aligned = align(&pulses, &blocks);
    let rapid = settings.rapid.to_f64();
    match args.format {
        MachineFormat::Json => out.json(&json!({
            "waveform": counted_json(&name, &counted, seconds),
            "program": source.name,
            "blocks": blocks.iter().filter(|b| b.plan.shape != Shape::Nothing).count(),
            "found": aligned.blocks.iter().filter(|s| s.pulses > 0).count(),
            "total": aligned.total.0,
            "worst": blocks.get(aligned.total.1).map(|b| json!({ "line": b.line, "column": b.column, "text": b.text })),
            "faults": aligned.faults.iter().map(|f| fault_json(f, &blocks, seconds)).collect::<Value>(),
        }))?,
        MachineFormat::Csv => csv(out, &aligned, &blocks, seconds, rapid)?,
        _ => {
            out.bytes(counted_text(&name, &counted, seconds).as_bytes())?;
            out.bytes(aligned_text(&source.name, &aligned, &blocks, seconds).as_bytes())?;
        }
    }
    out.flush()?;
    Ok(Status::of(aligned.faults.is_empty()))
}

/// The program's moves in BLU, with their places.
fn blocks(source: &mut Source, settings: &Settings) -> Result<Vec<Block>, CliError> {
    let mut faults = Faults::default();
    let mut blocks = Vec::new();
    let mut watch = Watch::new("reading", source.bytes);
    let read = program::read(source.begin()?, &source.name, settings.program, &mut faults, |line, canon| {
        if watch.stop(line.bytes) {
            return Err(Refusal::Stop);
        }
        if let Canon::Move(step) = canon {
            let plan = Plan::new(step, &settings.scale, line.at())?;
            let text = program::readable(line.text).trim().into();
            blocks.push(Block { plan, line: line.number, column: line.place.0 + 1, text });
        }
        Ok(())
    });
    watch.finish("nothing was compared")?;
    source.read(read)?;
    told(&faults)?;
    Ok(blocks)
}

/// All pulses in the order of time.
fn pulses(waves: &mut Waves, args: &MachineArgs) -> Result<Vec<Pulse>, CliError> {
    let given = [&args.x, &args.y, &args.z];
    let any = given.iter().any(|nets| nets.is_some());
    let mut all = Vec::new();
    for (axis, nets) in given.into_iter().enumerate() {
        let name = AXES[axis];
        let default = StepDir {
            step: Net { name: format!("{name}_step"), inverted: false },
            dir: Net { name: format!("{name}_dir"), inverted: false },
        };
        let nets = match nets {
            Some(nets) => nets,
            // where some are named, an axis without is one that there is not
            None if any => continue,
            None => &default,
        };
        let option = format!("--{name}");
        let step = sample::changes(waves, &nets.step.name, &option)?;
        let dir = sample::changes(waves, &nets.dir.name, &option)?;
        axis_pulses(&mut all, axis as u8, nets, &step, &dir)?;
    }
    all.sort_by_key(|p: &Pulse| (p.time, p.axis));
    Ok(all)
}

fn axis_pulses(all: &mut Vec<Pulse>, axis: u8, nets: &StepDir, step: &Changes, dir: &Changes) -> Result<(), CliError> {
    for (net, changes) in [(&nets.step, step), (&nets.dir, dir)] {
        if let Some((_, value)) = changes.iter().find(|(_, value)| value.len() != 1) {
            return Err(CliError::usage(format!("`{}` has {} bits", net.name, value.len()))
                .with_hint("step and direction are nets of one bit each"));
        }
    }
    let (active, idle) = if nets.step.inverted { ("0", "1") } else { ("1", "0") };
    let forward = if nets.dir.inverted { "0" } else { "1" };
    let mut before = "";
    let mut next = 0;
    let mut turned: Option<u64> = None;
    let mut stepped = false;
    for (time, value) in step {
        let begins = value == active && before == idle;
        before = if value == active {
            active
        } else if value == idle {
            idle
        } else {
            ""
        };
        if !begins {
            continue;
        }
        while dir.get(next).is_some_and(|(t, _)| t <= time) {
            turned = (next > 0).then_some(dir[next].0);
            next += 1;
        }
        let level = next.checked_sub(1).map_or("x", |i| dir[i].1.as_str());
        if level != "0" && level != "1" {
            return Err(CliError::usage(format!("`{}` is {level} at the step at {time}", nets.dir.name))
                .with_hint("a direction is 0 or 1 when a step begins"));
        }
        let step = if level == forward { 1 } else { -1 };
        let turned = turned.take().filter(|_| stepped).map(|t| time - t);
        all.push(Pulse { time: *time, axis, step, turned });
        stepped = true;
    }
    Ok(())
}

fn counted_text(name: &str, counted: &Counted, seconds: f64) -> String {
    let [x, y, z] = counted.pulses;
    let mut text = format!("{name}: {} pulses (x {x}, y {y}, z {z})", x + y + z);
    if let Some([first, last]) = counted.times {
        text += &format!(", from {} to {}", at(first, seconds), at(last, seconds));
    }
    let [x, y, z] = counted.end;
    text += &format!("; it ends {x}, {y}, {z} BLU from its start\n");
    if let Some((gap, when)) = counted.gap {
        let rate = 1.0 / (gap as f64 * seconds);
        text +=
            &format!("shortest gap {} ({rate:.0} pulses/s), at {}\n", time(gap as f64 * seconds), at(when, seconds));
    }
    if let Some((setup, when)) = counted.setup {
        text += &format!(
            "shortest time from direction to step {}, at {}\n",
            time(setup as f64 * seconds),
            at(when, seconds)
        );
    }
    text
}

/// A time of the waveform, to its tick as far as that can be read.
fn at(ticks: u64, seconds: f64) -> String {
    format!("{:.9} s", ticks as f64 * seconds)
}

fn counted_json(name: &str, counted: &Counted, seconds: f64) -> Value {
    let pair = |pair: Option<(u64, u64)>| {
        pair.map(|(v, when)| json!({ "s": v as f64 * seconds, "at_s": when as f64 * seconds }))
    };
    json!({
        "name": name,
        "pulses": counted.pulses,
        "end": counted.end,
        "from_s": counted.times.map(|t| t[0] as f64 * seconds),
        "to_s": counted.times.map(|t| t[1] as f64 * seconds),
        "gap": pair(counted.gap),
        "direction": pair(counted.setup),
    })
}

fn wrong(fault: &Fault) -> String {
    let axis = fault.axis.map_or("", |a| AXES[usize::from(a)]);
    let steps = |n: u64| if n == 1 { format!("one {axis} step") } else { format!("{n} {axis} steps") };
    match fault.wrong {
        Wrong::Missing(n) => format!("{} missing", steps(n)),
        Wrong::Extra(n) => format!("{} too many", steps(n)),
        Wrong::Direction => format!("one {axis} step in the wrong direction: the direction came late, or early"),
        Wrong::Elsewhere => "from here on this is not the program's path".to_owned(),
        Wrong::Short => "the capture ends before the program".to_owned(),
        Wrong::Long => "pulses go on behind the end of the program".to_owned(),
    }
}

fn aligned_text(name: &str, aligned: &Aligned, blocks: &[Block], seconds: f64) -> String {
    let found = aligned.blocks.iter().filter(|s| s.pulses > 0).count();
    let all = blocks.iter().filter(|b| b.plan.shape != Shape::Nothing).count();
    let mut text = format!("{name}: {found} of {all} moves found; at most {:.3} BLU off", aligned.total.0);
    if let Some(block) = blocks.get(aligned.total.1).filter(|_| aligned.total.0 > 0.0) {
        text += &format!(", in {}:{}  {}", block.line, block.column, shown(&block.text));
    }
    text += "\n";
    for fault in &aligned.faults {
        let block = &blocks[fault.block];
        text += &format!(
            "at {}: {}, in {name}:{}:{}  {}\n",
            at(fault.time, seconds),
            wrong(fault),
            block.line,
            block.column,
            shown(&block.text)
        );
    }
    if aligned.faults.is_empty() {
        text += "every step is there, none is too many\n";
    }
    text
}

fn shown(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(60).collect()
}

fn fault_json(fault: &Fault, blocks: &[Block], seconds: f64) -> Value {
    let block = &blocks[fault.block];
    let (kind, steps) = match fault.wrong {
        Wrong::Missing(n) => ("missing", Some(n)),
        Wrong::Extra(n) => ("extra", Some(n)),
        Wrong::Direction => ("direction", Some(1)),
        Wrong::Elsewhere => ("elsewhere", None),
        Wrong::Short => ("short", None),
        Wrong::Long => ("long", None),
    };
    json!({
        "kind": kind,
        "steps": steps,
        "axis": fault.axis.map(|a| AXES[usize::from(a)]),
        "at_s": fault.time as f64 * seconds,
        "at_ticks": fault.time,
        "line": block.line,
        "column": block.column,
        "text": block.text,
    })
}

fn csv(out: &mut Out, aligned: &Aligned, blocks: &[Block], seconds: f64, rapid: f64) -> Result<(), CliError> {
    out.bytes(b"line,column,pulses,from_s,to_s,mm,mm_min,mean_mm_min,total\n")?;
    let mut from = 0.0;
    for (seen, block) in aligned.blocks.iter().zip(blocks) {
        if seen.pulses == 0 {
            continue;
        }
        let to = seen.to as f64 * seconds;
        let plan = &block.plan;
        let asked = plan.speed(rapid) * 60.0 * plan.mm / plan.length;
        out.write_fmt(format_args!(
            "{},{},{},{from:.9},{to:.9},{:.6},{asked:.3},{:.3},{:.4}\n",
            block.line,
            block.column,
            seen.pulses,
            plan.mm,
            plan.mm / (to - from) * 60.0,
            seen.total
        ))?;
        from = to;
    }
    Ok(())
}
