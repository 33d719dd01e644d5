//! `discreta plot`: the path of a method or of a waveform over the ideal curve, as SVG.

use std::io::Write as _;
use std::path::Path;

use super::args::{DrawingArgs, PlotArgs, Point};
use super::progress::Progress;
use super::sample::{readings, sampled, signed};
use super::wave::{declaring, opened};
use super::{CliError, Out, Status, drawing, interrupt};
use crate::interpolate::{Drawing, Ideal, Method};
use crate::plot::{Picture, Recording};
use crate::wave::output::{Destination, Output};

/// Clocks between two looks at the terminal and at Ctrl-C.
const OFTEN: u64 = 1 << 20;

/// Runs the command.
///
/// # Errors
/// What cannot be drawn, a waveform without the nets, a picture that cannot be written.
pub fn run(args: &PlotArgs, out: &mut Out) -> Result<Status, CliError> {
    let plotted = match args.what.parse::<Method>() {
        Ok(method) => of_method(method, args)?,
        Err(unknown) if !is_waveform(Path::new(&args.what)) => {
            return Err(CliError::usage(format!("{unknown}")).with_hint("name a method, or a waveform that is there"));
        }
        Err(_) => of_trace(Path::new(&args.what), args, out)?,
    };
    let picture =
        Picture { title: &plotted.title, note: &plotted.note, ideal: &plotted.ideal, recording: &plotted.recording };
    let svg = picture.svg();
    if args.output.as_os_str() == "-" {
        out.bytes(svg.as_bytes())?;
    } else {
        let mut file = Output::create(&args.output)?;
        file.write_all(svg.as_bytes())?;
        file.complete()?;
        let (deviation, clock) = plotted.recording.worst();
        let (file, clocks) = (args.output.display(), plotted.recording.clocks());
        out.write_fmt(format_args!(
            "wrote {file}: {clocks} clocks, at most {:.3} BLU off, at clock {clock}\n",
            deviation.abs()
        ))?;
    }
    out.flush()?;
    if let Some(stopped) = &plotted.stopped {
        CliError::usage(stopped.as_str()).print();
    }
    Ok(Status::of(plotted.stopped.is_none()))
}

/// What there is to show.
struct Plotted {
    title: String,
    note: String,
    ideal: Ideal,
    recording: Recording,
    /// Why the end was not reached.
    stopped: Option<String>,
}

/// A file that is there, or looks as if it should be: reading it tells what is wrong.
fn is_waveform(path: &Path) -> bool {
    path.exists() || path.extension().is_some_and(|e| ["vcd", "fst", "ghw"].iter().any(|known| e == *known))
}

fn of_method(method: Method, args: &PlotArgs) -> Result<Plotted, CliError> {
    let of_traces = [
        ("--x", args.coordinates.x.is_some()),
        ("--y", args.coordinates.y.is_some()),
        ("--z", args.coordinates.z.is_some()),
        ("--dt", args.coordinates.dt.is_some()),
        ("--signed", args.coordinates.signed),
        ("--scope", args.scope.is_some()),
        ("--circuit", args.circuit.is_some()),
    ];
    if let Some((option, _)) = of_traces.into_iter().find(|(_, given)| *given) {
        return Err(CliError::usage(format!("{method} has no option {option}")).with_hint("it is for waveforms"));
    }
    let (request, drawing) = drawing::draw(method, &args.drawing)?;
    let Drawing { mut interpolator, ideal, bits } = drawing;
    let axes = interpolator.columns().at.len();
    interrupt::watch();
    let mut progress = Progress::new("drawing", "clocks", None);
    let away = |at: [i64; 3]| ideal.deviation(at.map(|v| v as f64));
    let start = interpolator.state().at;
    let mut recording = Recording::new(axes, start, away(start));
    for c in interpolator.by_ref() {
        recording.push(c.at, away(c.at));
        if recording.clocks().is_multiple_of(OFTEN) {
            progress.set(recording.clocks());
            if interrupt::interrupted() {
                return Err(CliError::usage("interrupted; nothing was drawn"));
            }
        }
    }
    let stopped = interpolator.stopped().map(|s| s.to_string());
    let title = drawing::title(&request, axes);
    let mut note = note(&recording, Some(bits), stopped.is_some());
    if let Some(conic) = request.conic {
        let conic: Vec<String> = conic.iter().map(i64::to_string).collect();
        note = format!("A…F = {}; {note}", conic.join(", "));
    }
    Ok(Plotted { title, note, ideal, recording, stopped })
}

fn note(recording: &Recording, bits: Option<u32>, stopped: bool) -> String {
    let clocks = recording.clocks();
    let mut note = format!("{clocks} clock{}", if clocks == 1 { "" } else { "s" });
    if let Some(bits) = bits {
        note += &format!(", registers of {bits} bits");
    }
    if stopped {
        note += "; the end was not reached";
    }
    note
}

fn of_trace(path: &Path, args: &PlotArgs, out: &mut Out) -> Result<Plotted, CliError> {
    if let Some(option) = args.drawing.of_methods_alone() {
        return Err(CliError::usage(format!("a waveform has no option {option}")).with_hint("it is for methods"));
    }
    let mut waves = opened(path, args.scope.as_deref(), out)?;
    let mut coordinates = args.coordinates.clone();
    let circuit = declaring(args.circuit.as_deref())?;
    let readings = match &circuit {
        Some(circuit) => {
            coordinates.signed |= signed(circuit, &waves, &coordinates)?;
            vec![sampled(&mut waves, &coordinates)?]
        }
        None => readings(&mut waves, &coordinates)?,
    };
    let axes = 2 + usize::from(args.coordinates.z.is_some());
    // of readings that may both be meant that which comes nearer to the curve
    let mut traced = Vec::new();
    for reading in &readings {
        let points: Vec<[i64; 3]> = reading.iter().map(|point| point.at).collect();
        traced.push(traced_over(path, args, axes, &points)?);
    }
    let worst = |plotted: &Plotted| plotted.recording.worst().0.abs();
    let best = (0..traced.len()).min_by(|&a, &b| worst(&traced[a]).total_cmp(&worst(&traced[b])));
    Ok(traced.swap_remove(best.unwrap_or(0)))
}

/// A path over the curve that it is to follow.
fn traced_over(path: &Path, args: &PlotArgs, axes: usize, points: &[[i64; 3]]) -> Result<Plotted, CliError> {
    let DrawingArgs { to, from, center, ccw, cw, .. } = args.drawing;
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
        let fault = format!("in `{}` the coordinates are never known at a clock", path.display());
        return Err(CliError::usage(fault).with_hint("does START come before the first clock?"));
    };
    let given = |point: Option<Point>, otherwise| point.map_or(otherwise, |p| [p.x, p.y, p.z.unwrap_or(0)]);
    let (from, to) = (given(from, first), given(to, last));
    let arc = center.is_some() || ccw || cw;
    if arc && axes == 3 {
        return Err(CliError::usage("arcs lie in the plane: --z does not go with --center, --cw and --ccw"));
    }
    let plane = |p: [i64; 3]| [p[0] as f64, p[1] as f64];
    let ideal = if arc {
        Ideal::arc(center.map_or([0.0; 2], |c| c.exact()), plane(from), plane(to), cw)
    } else {
        Ideal::segment(from, to)
    };
    let away = |at: [i64; 3]| ideal.deviation(at.map(|v| v as f64));
    let mut recording = Recording::new(axes, first, away(first));
    points[1..].iter().for_each(|&at| recording.push(at, away(at)));
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let shape = if arc { "an arc" } else { "a line" };
    let title = format!("{name}: {shape} {} → {}", drawing::point(from, axes), drawing::point(to, axes));
    let note = note(&recording, None, false);
    Ok(Plotted { title, note, ideal, recording, stopped: None })
}
