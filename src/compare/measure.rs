//! Draws every set with every method, on several threads: which one draws what changes nothing.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::motion::Watch;
use super::{Group, Motion, Row, Set, Variant};

/// Measures all methods over all sets; none if it was told to stop.
#[must_use]
pub fn measure(sets: &[Set], watch: Watch<'_>, threads: usize) -> Option<Vec<Group>> {
    let jobs: Vec<(usize, Variant)> =
        sets.iter().enumerate().flat_map(|(i, set)| set.variants().iter().map(move |&v| (i, v))).collect();
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Option<Motion>)>> = Mutex::new(Vec::new());
    let work = || {
        loop {
            let job = next.fetch_add(1, Ordering::Relaxed);
            let Some(&(set, variant)) = jobs.get(job) else { break };
            let motion = Motion::of(variant, &sets[set], watch);
            let stopped = motion.is_none();
            if let Ok(mut done) = done.lock() {
                done.push((job, motion));
            }
            if stopped {
                break;
            }
        }
    };
    thread::scope(|scope| {
        // this thread works too, so that it needs no other
        for _ in 1..threads.clamp(1, jobs.len().max(1)) {
            if thread::Builder::new().spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        work();
    });
    let mut done = done.into_inner().ok()?;
    done.sort_by_key(|&(job, _)| job);
    let mut groups: Vec<Group> =
        sets.iter().map(|set| Group { kind: set.kind, set: set.to_string(), rows: Vec::new() }).collect();
    if done.len() < jobs.len() {
        return None;
    }
    for (job, motion) in done {
        let (set, variant) = jobs[job];
        groups[set].rows.push(Row { method: variant.name(), motion: motion? });
    }
    Some(groups)
}
