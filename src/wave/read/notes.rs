//! What is doubtful about a waveform that was read nevertheless.

use std::fmt::Write as _;

/// Kinds of doubts that are told; there are not many.
const KINDS: usize = 20;

/// What a reader found doubtful: of each kind the first, and how many there were.
#[derive(Clone, Debug, Default)]
pub(super) struct Notes {
    kinds: Vec<(&'static str, String, u64)>,
    /// Where the file breaks off, if it does.
    pub cut: Option<String>,
}

impl Notes {
    /// Notes one; `text` says what, for the first of its kind.
    pub fn add(&mut self, kind: &'static str, text: impl FnOnce() -> String) {
        let room = self.kinds.len() < KINDS;
        match self.kinds.iter_mut().find(|(known, ..)| *known == kind) {
            Some((.., count)) => *count += 1,
            None if room => self.kinds.push((kind, text(), 1)),
            None => {}
        }
    }

    /// Notes that the file breaks off; the first reason counts.
    pub fn cut(&mut self, why: impl Into<String>) {
        self.cut.get_or_insert_with(|| why.into());
    }

    /// All of them as text.
    pub fn warnings(&self) -> Vec<String> {
        let told = self.kinds.iter().map(|(_, text, count)| {
            let mut text = text.clone();
            if *count > 1 {
                let _ = write!(text, " (and {} more)", count - 1);
            }
            text
        });
        let cut = self.cut.iter().map(|why| format!("it is cut off: {why}; what is there was read"));
        told.chain(cut).collect()
    }
}
