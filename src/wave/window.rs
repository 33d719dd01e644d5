//! A part of a waveform in time.

use std::io;

use super::{Layout, Sink};
use crate::value::Word;
use crate::value::word::words;

/// Hands on what happens from one tick to another: it begins with the values that there are then.
pub struct Window<S> {
    sink: S,
    from: u64,
    to: u64,
    /// The values so far, until it has begun.
    values: Vec<Vec<Word>>,
    now: u64,
    begun: bool,
}

impl<S: Sink> Window<S> {
    /// A sink that hands on to another what happens from tick `from` to tick `to`, both included.
    pub fn new(sink: S, from: u64, to: u64) -> Window<S> {
        Window { sink, from, to, values: Vec::new(), now: 0, begun: false }
    }

    /// Gives the first values.
    fn start(&mut self, at: u64) -> io::Result<()> {
        self.begun = true;
        self.sink.time(at)?;
        for (var, value) in std::mem::take(&mut self.values).into_iter().enumerate().filter(|(_, v)| !v.is_empty()) {
            self.sink.change(var, &value);
        }
        Ok(())
    }
}

impl<S: Sink> Sink for Window<S> {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        self.values = layout.vars.iter().map(|var| vec![Word::x(u64::MAX); words(var.width)]).collect();
        for (var, value) in layout.vars.iter().zip(&mut self.values) {
            if var.alias_of.is_some() {
                value.clear();
            } else if let Some(last) = value.last_mut().filter(|_| !var.width.is_multiple_of(64)) {
                *last = Word::x((1 << (var.width % 64)) - 1);
            }
        }
        self.sink.begin(layout)
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        // what came before the window, as it was when that begins
        if !self.begun && now > self.from && self.now <= self.from {
            self.start(self.from)?;
        }
        self.now = now;
        if self.begun && now <= self.to { self.sink.time(now) } else { Ok(()) }
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        if !self.begun {
            self.values[var].clear();
            self.values[var].extend_from_slice(value);
        } else if self.now <= self.to {
            self.sink.change(var, value);
        }
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        if !self.begun {
            self.start(self.from.min(end))?;
        }
        self.sink.finish(end.min(self.to).max(self.from.min(end)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vcd::VcdWriter;

    fn written(from: u64, to: u64) -> String {
        let mut layout = Layout::default();
        let scope = layout.scope("t", None);
        layout.var(scope, "a", 1);
        layout.var(scope, "b", 70);
        let mut bytes = Vec::new();
        let mut window = Window::new(VcdWriter::new(&mut bytes), from, to);
        window.begin(&layout).unwrap();
        for (time, a) in [(0, 0), (10, 1), (20, 0), (30, 1)] {
            window.time(time).unwrap();
            window.change(0, &[Word::known(a)]);
        }
        window.finish(40).unwrap();
        drop(window);
        let text = String::from_utf8(bytes).unwrap();
        text.split_once("$enddefinitions $end\n").unwrap().1.replace(['\n', '$'], " ")
    }

    #[test]
    fn it_begins_with_what_there_is_and_ends_when_it_is_over() {
        let x = "x".repeat(70);
        let all = |text: &str| text.replace("BX", &format!("b{x} \""));
        assert_eq!(written(0, 99).trim(), all("#0  dumpvars 0! BX  end #10 1! #20 0! #30 1! #40"));
        assert_eq!(written(15, 25).trim(), all("#15  dumpvars 1! BX  end #20 0! #25"));
        assert_eq!(written(10, 20).trim(), all("#10  dumpvars 1! BX  end #20 0!"));
        assert_eq!(written(35, 99).trim(), all("#35  dumpvars 1! BX  end #40"));
        assert_eq!(written(50, 60).trim(), all("#40  dumpvars 1! BX  end"));
    }
}
