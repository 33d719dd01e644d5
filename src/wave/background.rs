//! A sink on a thread of its own, so that a run does not wait for its waveform to be formatted.
//!
//! Times and changes are handed over some thousands at a time, in order; the buffers go round, so nothing is allocated
//! once they have been filled. A fault of the sink is told at the next time, or at the end.

use std::io;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use super::thread::{ended, over, refused};
use super::{Batch as Packed, Batches, Layout, Sink};
use crate::value::{Word, word};

/// How many words or events are handed over at once.
const BATCH: usize = 1 << 14;

/// How many batches may wait.
const WAITING: usize = 4;

enum Event {
    Time(u64),
    /// A variable, whose value is the next among the words.
    Change(u32),
}

#[derive(Default)]
struct Batch {
    events: Vec<Event>,
    words: Vec<Word>,
    /// What comes after them.
    packed: Option<Packed>,
    /// The run is over at this tick.
    end: Option<u64>,
}

/// A [`Sink`] that does what another does, on another thread.
pub struct Background {
    state: State,
    /// Words of each variable.
    sizes: Vec<u32>,
    batch: Batch,
    /// Whether the sink takes changes by the batch.
    packs: bool,
}

enum State {
    New(Box<dyn Sink + Send>),
    Running {
        full: SyncSender<Batch>,
        empty: Receiver<Batch>,
        thread: JoinHandle<io::Result<()>>,
    },
    /// It failed, or is complete.
    Over,
}

impl Background {
    /// The thread starts with [`Sink::begin`].
    pub fn new(mut sink: impl Sink + Send + 'static) -> Background {
        let packs = sink.batches().is_some();
        Background { state: State::New(Box::new(sink)), sizes: Vec::new(), batch: Batch::default(), packs }
    }

    /// Hands the batch over and takes an empty one.
    fn hand_over(&mut self) -> io::Result<()> {
        let State::Running { full, empty, .. } = &self.state else { return Err(over()) };
        let batch = std::mem::take(&mut self.batch);
        let sent = full.send(batch).is_ok();
        if let Some(next) = sent.then(|| empty.try_recv().ok()).flatten() {
            self.batch = next;
        }
        if sent { Ok(()) } else { self.join() }
    }

    /// Waits for the thread to end.
    fn join(&mut self) -> io::Result<()> {
        let State::Running { full, empty, thread } = std::mem::replace(&mut self.state, State::Over) else {
            return Err(over());
        };
        drop((full, empty));
        ended(thread, "writes the waveform")
    }
}

/// What the thread does: every batch, until the end or until nobody sends any more.
fn consume(
    mut sink: Box<dyn Sink + Send>,
    sizes: &[u32],
    full: &Receiver<Batch>,
    empty: &SyncSender<Batch>,
) -> io::Result<()> {
    for mut batch in full {
        let mut at = 0;
        for event in batch.events.drain(..) {
            match event {
                Event::Time(now) => sink.time(now)?,
                Event::Change(var) => {
                    let end = at + sizes[var as usize] as usize;
                    sink.change(var as usize, &batch.words[at..end]);
                    at = end;
                }
            }
        }
        if let Some((packed, sink)) = batch.packed.as_mut().zip(sink.batches()) {
            packed.words = sink.batch(std::mem::take(packed))?;
        }
        if let Some(end) = batch.end {
            return sink.finish(end);
        }
        batch.words.clear();
        // if there are enough, or nobody takes it, it is dropped
        let _ = empty.try_send(batch);
    }
    Ok(())
}

impl Sink for Background {
    fn begin(&mut self, layout: &Layout) -> io::Result<()> {
        let State::New(mut sink) = std::mem::replace(&mut self.state, State::Over) else { return Err(over()) };
        sink.begin(layout)?;
        self.sizes = layout.vars.iter().map(|var| word::words(var.width) as u32).collect();
        let sizes = self.sizes.clone();
        let (full, to_do) = sync_channel(WAITING);
        let (done, empty) = sync_channel(WAITING + 1);
        let thread = std::thread::Builder::new().name("waveform".to_owned());
        let thread = thread.spawn(move || consume(sink, &sizes, &to_do, &done)).map_err(|e| refused(&e))?;
        self.state = State::Running { full, empty, thread };
        Ok(())
    }

    fn time(&mut self, now: u64) -> io::Result<()> {
        if self.batch.words.len().max(self.batch.events.len()) >= BATCH {
            self.hand_over()?;
        }
        self.batch.events.push(Event::Time(now));
        Ok(())
    }

    fn change(&mut self, var: usize, value: &[Word]) {
        self.batch.events.push(Event::Change(var as u32));
        self.batch.words.extend_from_slice(&value[..self.sizes[var] as usize]);
    }

    fn batches(&mut self) -> Option<&mut dyn Batches> {
        self.packs.then_some(self)
    }

    fn finish(&mut self, end: u64) -> io::Result<()> {
        self.batch.end = Some(end);
        self.hand_over()?;
        self.join()
    }
}

impl Batches for Background {
    fn batch(&mut self, batch: Packed) -> io::Result<Vec<u64>> {
        self.batch.packed = Some(batch);
        self.hand_over()?;
        // the thread has done with what was there
        let mut free = self.batch.packed.take().unwrap_or_default().words;
        free.clear();
        Ok(free)
    }
}

/// Nothing stays behind: what is half done is taken away before this returns.
impl Drop for Background {
    fn drop(&mut self) {
        if matches!(self.state, State::Running { .. }) {
            let _ = self.join();
        }
    }
}

#[cfg(test)]
#[path = "background_tests.rs"]
mod tests;
