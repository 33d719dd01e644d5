//! Progress of what takes longer than a second, on a terminal.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Nothing is shown before this.
const PATIENCE: Duration = Duration::from_secs(1);

/// A line on standard error that says how far a command is; silent where that is no terminal.
pub struct Progress {
    label: String,
    unit: &'static str,
    total: Option<u64>,
    started: Instant,
    /// None: nobody is watching.
    bar: Option<Option<ProgressBar>>,
}

impl Progress {
    /// Starts. `total` is how much there is to do, if that is known; `unit` what it is counted in (`cycles`).
    #[must_use]
    pub fn new(label: &str, unit: &'static str, total: Option<u64>) -> Progress {
        let watched = std::io::stderr().is_terminal();
        Progress { label: label.to_owned(), unit, total, started: Instant::now(), bar: watched.then_some(None) }
    }

    /// So much is done. Asks the clock: call it a thousand times a second, not a million.
    pub fn set(&mut self, done: u64) {
        let Some(bar) = &mut self.bar else { return };
        if bar.is_none() && self.started.elapsed() >= PATIENCE {
            *bar = Some(draw(&self.label, self.unit, self.total, self.started));
        }
        if let Some(bar) = bar {
            bar.set_position(done);
        }
    }

    /// Takes the line away, so that other text can be printed. Dropping does the same.
    pub fn clear(&mut self) {
        if let Some(Some(bar)) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

fn draw(label: &str, unit: &str, total: Option<u64>, started: Instant) -> ProgressBar {
    let (bar, template) = match total {
        Some(total) => (
            ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr()),
            format!("{{msg}} {{wide_bar}} {{percent}} % of {{human_len}} {unit}, {{eta}} left"),
        ),
        None => (
            ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()),
            format!("{{spinner}} {{msg}}: {{human_pos}} {unit}, {{elapsed}}"),
        ),
    };
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.with_style(style).with_message(label.to_owned()).with_elapsed(started.elapsed())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_templates_are_ones() {
        for total in [None, Some(5)] {
            let bar = draw("run", "cycles", total, Instant::now());
            assert_eq!((bar.message().as_str(), bar.length()), ("run", total));
        }
        for template in ["{msg} {wide_bar} {percent} % of {human_len} x, {eta} left", "{spinner} {human_pos}"] {
            assert!(ProgressStyle::with_template(template).is_ok(), "{template}");
        }
    }

    #[test]
    fn nothing_is_shown_before_a_second_has_passed() {
        let mut progress = Progress::new("run", "cycles", Some(10));
        progress.bar = Some(None);
        progress.set(1);
        assert!(matches!(progress.bar, Some(None)));
        progress.started -= PATIENCE;
        progress.set(2);
        assert_eq!(progress.bar.as_ref().and_then(Option::as_ref).map(ProgressBar::position), Some(2));
    }
}
