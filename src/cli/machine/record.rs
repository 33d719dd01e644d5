//! The pulses of the drives as a waveform.

use std::io;
use std::path::Path;

use crate::Timescale;
use crate::cli::CliError;
use crate::machine::clockwork::HIGH;
use crate::machine::measure::Point;
use crate::value::Word;
use crate::wave::{self, Kind, Layout, Sink};

/// The names of the axes in it.
const AXES: [&str; 3] = ["x", "y", "z"];

/// A waveform of step, direction and clock, and of the line that is being drawn.
pub struct Record {
    sink: Box<dyn Sink>,
    /// The clock before.
    last: u64,
    step: [bool; 3],
    forward: [bool; 3],
    line: u64,
    /// The line that the present move has, until it is written.
    next: u64,
    failed: Option<io::Error>,
}

/// Variables: the clock, then step and direction of each axis, then the line.
const LINE: usize = 7;

impl Record {
    /// Opens it.
    ///
    /// # Errors
    /// A file of another kind, or one that cannot be written.
    pub fn begin(path: &Path, tick: Timescale) -> Result<Record, CliError> {
        let Some(kind) = Kind::of(path) else {
            let fault = CliError::usage(format!("`{}` is neither .vcd nor .fst", path.display()));
            return Err(fault.with_hint("the kind of waveform is told by its extension"));
        };
        let mut layout = Layout { timescale: tick, ..Layout::default() };
        let top = layout.scope("machine", None);
        layout.var(top, "dt", 1);
        for axis in AXES {
            layout.var(top, &format!("{axis}_step"), 1);
            layout.var(top, &format!("{axis}_dir"), 1);
        }
        layout.var(top, "line", 32);
        let mut sink = wave::open(path, kind)?;
        sink.begin(&layout)?;
        sink.time(0)?;
        for var in 0..LINE {
            let forward = var > 0 && var % 2 == 0;
            sink.change(var, &[bit(forward)]);
        }
        sink.change(LINE, &[Word { v: 0, u: 0 }]);
        Ok(Record { sink, last: 0, step: [false; 3], forward: [true; 3], line: 0, next: 0, failed: None })
    }

    /// A move of this line begins.
    pub fn line(&mut self, line: u64) {
        self.next = line;
    }

    /// A clock.
    pub fn clock(&mut self, point: &Point) {
        if self.failed.is_none() {
            self.failed = self.write(point).err();
        }
    }

    /// The pulse before ends, and with that the directions of this one are set; then it begins.
    fn write(&mut self, point: &Point) -> io::Result<()> {
        let now = point.time[0];
        let wait = now - self.last;
        self.fall(self.last + HIGH.min(wait / 2))?;
        for axis in 0..3 {
            let forward = point.step[axis] > 0;
            if point.step[axis] != 0 && forward != self.forward[axis] {
                self.forward[axis] = forward;
                self.sink.change(2 + 2 * axis, &[bit(forward)]);
            }
        }
        if self.next != self.line {
            self.line = self.next;
            self.sink.change(LINE, &[Word { v: self.line & u64::from(u32::MAX), u: 0 }]);
        }
        self.sink.time(now)?;
        self.sink.change(0, &[bit(true)]);
        for axis in 0..3 {
            self.step[axis] = point.step[axis] != 0;
            if self.step[axis] {
                self.sink.change(1 + 2 * axis, &[bit(true)]);
            }
        }
        self.last = now;
        Ok(())
    }

    fn fall(&mut self, at: u64) -> io::Result<()> {
        self.sink.time(at)?;
        self.sink.change(0, &[bit(false)]);
        for axis in 0..3 {
            if self.step[axis] {
                self.sink.change(1 + 2 * axis, &[bit(false)]);
            }
        }
        Ok(())
    }

    /// Whether all could be written so far.
    ///
    /// # Errors
    /// If not: what [`failed`](Record::failed) tells.
    pub fn check(&self) -> io::Result<()> {
        if self.failed.is_some() { Err(io::ErrorKind::Other.into()) } else { Ok(()) }
    }

    /// Why something could not be written.
    pub fn failed(&mut self) -> Option<io::Error> {
        self.failed.take()
    }

    /// Ends the last pulse and the waveform.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> Result<(), CliError> {
        self.fall(self.last + HIGH)?;
        self.sink.finish(self.last + 2 * HIGH)?;
        Ok(())
    }
}

fn bit(one: bool) -> Word {
    Word { v: u64::from(one), u: 0 }
}
