//! Comparing two waveforms: what differs, where first, and what was around it.
//!
//! Variables are matched by their full names and compared by the values that they have at the end of each tick, over
//! the time that both waveforms cover. Different timescales are brought to the finer one. What is reported is bounded,
//! what is counted is not.

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::sync::Arc;

use serde::Serialize;

use super::read::signal::Signal;
use super::read::{self, ReadError, ValueKind, WaveVar, Waves};
use super::scopes;
use super::walk::{Point, Source, Walk, same};
use crate::Timescale;

/// How many pairs of variables are in memory together.
const BATCH: usize = 2048;

/// One of the two waveforms.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The first.
    A,
    /// The second.
    B,
}

/// How to compare.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Options {
    /// A bit that is x on this side agrees with anything. Otherwise x agrees with x alone.
    pub x_as_dont_care: Option<Side>,
    /// Whether waveforms that end at different times may be the same.
    pub ignore_end: bool,
    /// How many variables each list of the report holds.
    pub max_signals: usize,
    /// How many times before and after the first difference are reported.
    pub context: usize,
    /// Of each waveform only what is below this scope is compared, by its name from there on; nothing is the top.
    pub scopes: [String; 2],
    /// Variables, by their full names, that are not compared.
    pub ignored: BTreeSet<String>,
    /// Variables of the first, by their names below the scope, that are called otherwise in the second.
    pub renamed: BTreeMap<String, String>,
    /// The first time that is compared, in ticks of the finer timescale.
    pub from: u64,
    /// The last time that is compared.
    pub until: u64,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            x_as_dont_care: None,
            ignore_end: false,
            max_signals: 20,
            context: 5,
            scopes: Default::default(),
            ignored: BTreeSet::new(),
            renamed: BTreeMap::new(),
            from: 0,
            until: u64::MAX,
        }
    }
}

/// What [`diff`] found. All times are in ticks of [`timescale`](Difference::timescale).
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Difference {
    /// Whether nothing that counts differs.
    pub same: bool,
    /// How long a tick is; none if neither file says.
    #[serde(serialize_with = "as_text")]
    pub timescale: Option<Timescale>,
    /// The first waveform: its name and its end.
    pub a: Party,
    /// The second waveform: its name and its end.
    pub b: Party,
    /// Whether it counts that the two end at different times.
    pub ends_differ: bool,
    /// How many variables were compared.
    pub compared: usize,
    /// How many of their values: at each time at which one changes in either, up to its first difference.
    pub values: u64,
    /// How many of them differ.
    pub differing: usize,
    /// The first time at which any does.
    pub first: Option<u64>,
    /// Those that differ, the first to do so first.
    pub signals: Vec<SignalDifference>,
    /// What was around the first difference.
    pub context: Option<Context>,
    /// Variables that have values of different kinds or widths, and were not compared.
    pub kinds: List<KindDifference>,
    /// Variables that only the first has.
    pub only_a: List<String>,
    /// Variables that only the second has.
    pub only_b: List<String>,
}

/// One of the two waveforms.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Party {
    /// What it is called in the report: its path, unless the caller knows better (`expected`).
    pub name: String,
    /// Its last time, in ticks of the common timescale.
    pub end: u64,
}

/// The first difference of one variable.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct SignalDifference {
    /// The full name of the variable.
    pub name: String,
    /// The first tick at whose end the values differ.
    pub time: u64,
    /// The value in the first: bits, the most significant first; empty where there is none.
    pub a: String,
    /// The value in the second, in the same form.
    pub b: String,
}

/// A variable whose values are of different kinds.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct KindDifference {
    /// The full name of the variable.
    pub name: String,
    /// What they are in the first, e.g. `8 bits`.
    pub a: String,
    /// What they are in the second.
    pub b: String,
}

/// The first of a number of things.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct List<T> {
    /// How many there are.
    pub count: usize,
    /// The first of them.
    pub first: Vec<T>,
}

impl<T> Default for List<T> {
    fn default() -> List<T> {
        List { count: 0, first: Vec::new() }
    }
}

impl<T> List<T> {
    /// Counts an item, and keeps it while there are fewer than `max`.
    pub fn push(&mut self, max: usize, item: impl FnOnce() -> T) {
        self.count += 1;
        if self.first.len() < max {
            self.first.push(item());
        }
    }
}

/// What a variable did around its first difference.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Context {
    /// The full name of the variable.
    pub signal: String,
    /// A variable that looks like its clock: one bit, the same in both, with rising edges at equal distances.
    pub clock: Option<String>,
    /// How many rising edges the clock has made when the difference shows, one at that time included.
    pub clock_edges: Option<u64>,
    /// The times around, in order: where the variable or the clock changes.
    pub rows: Vec<Row>,
}

/// The values at one time.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Row {
    /// The tick.
    pub time: u64,
    /// The clock's value from then on, if it is known.
    pub clock: Option<String>,
    /// The variable in the first from then on.
    pub a: String,
    /// The variable in the second from then on.
    pub b: String,
}

fn as_text<S: serde::Serializer>(timescale: &Option<Timescale>, to: S) -> Result<S::Ok, S::Error> {
    timescale.map(|timescale| timescale.to_string()).serialize(to)
}

/// Compares two waveforms.
///
/// # Errors
/// Values that are damaged, or times that are too great for the common timescale.
pub fn diff(a: &mut Waves, b: &mut Waves, options: &Options) -> Result<Difference, ReadError> {
    diff_of(a, b, None, options)
}

/// Two variables, given by their indices, that should have the same values.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Same {
    /// The index in the first waveform.
    pub a: usize,
    /// The index in the second.
    pub b: usize,
    /// Whether the bits of the first stand in the opposite order.
    pub reversed: bool,
}

/// Compares some variables of two waveforms and leaves all others aside. Of bits of different widths the lowest are
/// compared. What comes before the first time of the first waveform is not compared.
///
/// # Errors
/// As [`diff`].
///
/// # Panics
/// If there is no such variable.
pub fn diff_pairs(a: &mut Waves, b: &mut Waves, pairs: &[Same], options: &Options) -> Result<Difference, ReadError> {
    diff_of(a, b, Some(pairs), options)
}

fn diff_of(a: &mut Waves, b: &mut Waves, given: Option<&[Same]>, options: &Options) -> Result<Difference, ReadError> {
    let common = match (a.exponent(), b.exponent()) {
        (Some(x), Some(y)) => Some(x.min(y)),
        (x, y) => x.or(y),
    };
    let scale = Scale { a: factor(a, common)?, b: factor(b, common)? };
    let (end_a, end_b) = (a.end() * scale.a, b.end() * scale.b);
    let mut result = Difference {
        same: true,
        timescale: common.and_then(Timescale::from_exponent),
        a: Party { name: a.path().display().to_string(), end: end_a },
        b: Party { name: b.path().display().to_string(), end: end_b },
        ends_differ: end_a.min(options.until) != end_b.min(options.until) && !options.ignore_end,
        compared: 0,
        values: 0,
        differing: 0,
        first: None,
        signals: Vec::new(),
        context: None,
        kinds: List::default(),
        only_a: List::default(),
        only_b: List::default(),
    };
    let mut matched = Matched::default();
    match given {
        None => matched.by_name(a, b, options, &mut result),
        Some(pairs) => pairs.iter().for_each(|pair| matched.add(a, b, pair, &mut result)),
    }
    let pairs = matched.list();
    let from = given.map_or(0, |_| a.start() * scale.a).max(options.from);
    let compare = Compare {
        from,
        until: end_a.min(end_b).min(options.until),
        windowed: options.from > 0,
        scale,
        dont_care: options.x_as_dont_care,
    };

    let (mut found, clock) = compare.all(a, b, &pairs, &mut result.values)?;
    found.sort_by_key(|found| (found.time, found.var));
    result.differing = found.len();
    result.first = found.first().map(|found| found.time);
    for &Found { time, var, pair } in found.iter().take(options.max_signals) {
        let (row, _) = compare.around(a, b, pair, None, time, 0)?;
        let name = a.vars()[var].name.clone();
        let (a, b) = row.into_iter().next().map_or_else(Default::default, |row| (row.a, row.b));
        result.signals.push(SignalDifference { name, time, a, b });
    }
    if let Some(&Found { time, var, pair }) = found.first() {
        let clock = clock.filter(|(_, clock)| *clock != pair);
        let clock = match clock {
            Some((var, clock)) if compare.is_clock(a, b, clock, time)? => Some((var, clock)),
            _ => None,
        };
        let (rows, edges) = compare.around(a, b, pair, clock.map(|(_, clock)| clock), time, options.context)?;
        result.context = Some(Context {
            signal: a.vars()[var].name.clone(),
            clock: clock.map(|(var, _)| a.vars()[var].name.clone()),
            clock_edges: clock.map(|_| edges),
            rows,
        });
    }
    result.same = !result.ends_differ
        && result.differing == 0
        && result.kinds.count + result.only_a.count + result.only_b.count == 0;
    Ok(result)
}

/// How many common ticks one of the waveform's is; its times are known to fit.
fn factor(waves: &Waves, common: Option<i32>) -> Result<u64, ReadError> {
    let digits = match (waves.exponent(), common) {
        (Some(own), Some(common)) => own.abs_diff(common),
        _ => 0,
    };
    let factor = 10_u64.checked_pow(digits).filter(|factor| waves.end().checked_mul(*factor).is_some());
    factor.ok_or_else(|| {
        let text = format!("its last time, {} ticks, is too large for the timescale of the other", waves.end());
        ReadError::malformed(waves.path(), text)
    })
}

/// A signal of each side and what its values are.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Pair {
    a: u32,
    b: u32,
    kind: ValueKind,
    /// Whether the bits of the first stand in the opposite order.
    reversed: bool,
}

/// What is in both: each pair of signals once, with the variables (of the first) that have it.
#[derive(Default)]
struct Matched(BTreeMap<(u32, u32, bool), (Pair, Vec<usize>)>);

impl Matched {
    fn by_name(&mut self, a: &Waves, b: &Waves, options: &Options, result: &mut Difference) {
        let [scope_a, scope_b] = &options.scopes;
        let (list_a, list_b) = (below(a, scope_a), below(b, scope_b));
        let index = |list: &[(usize, &str)]| list.iter().rev().map(|&(i, name)| (name.to_owned(), i)).collect();
        let all_b: HashMap<String, usize> = index(&list_b);
        let ignored = |name: &str| options.ignored.contains(name);
        let mut met: BTreeSet<&str> = BTreeSet::new();
        for &(i, name) in &list_a {
            let there = options.renamed.get(name).map_or(name, String::as_str);
            met.insert(there);
            if ignored(&a.vars()[i].name) {
                continue;
            }
            match all_b.get(there) {
                Some(&other) => self.pair(a, i, b, other, options, result),
                None => result.only_a.push(options.max_signals, || a.vars()[i].name.clone()),
            }
        }
        for &(i, _) in list_b.iter().filter(|(i, name)| !met.contains(*name) && !ignored(&b.vars()[*i].name)) {
            result.only_b.push(options.max_signals, || b.vars()[i].name.clone());
        }
    }

    fn pair(&mut self, a: &Waves, i: usize, b: &Waves, j: usize, options: &Options, result: &mut Difference) {
        let (var, other) = (&a.vars()[i], &b.vars()[j]);
        if var.kind != other.kind {
            result.kinds.push(options.max_signals, || KindDifference {
                name: var.name.clone(),
                a: var.kind.to_string(),
                b: other.kind.to_string(),
            });
            return;
        }
        // bits that stand one by one count as the other declares them
        let upwards = |var: &WaveVar| !var.joined && var.index.is_some_and(|(msb, lsb)| msb < lsb);
        let reversed = var.joined && upwards(other) || other.joined && upwards(var);
        self.add(a, b, &Same { a: i, b: j, reversed }, result);
    }

    fn add(&mut self, a: &Waves, b: &Waves, same: &Same, result: &mut Difference) {
        let (var, other, reversed) = (&a.vars()[same.a], &b.vars()[same.b], same.reversed);
        result.compared += 1;
        let pair = Pair { a: var.signal, b: other.signal, kind: var.kind, reversed };
        self.0.entry((pair.a, pair.b, reversed)).or_insert((pair, Vec::new())).1.push(same.a);
    }

    fn list(self) -> Vec<(Pair, Vec<usize>)> {
        self.0.into_values().collect()
    }
}

/// The variables that are compared, by their names from the scope on.
fn below<'w>(waves: &'w Waves, scope: &str) -> Vec<(usize, &'w str)> {
    waves.vars().iter().enumerate().filter_map(|(i, var)| Some((i, scopes::below(&var.name, scope)?))).collect()
}

/// The value in the first waveform as the second would write it.
fn first_text<'a>(walk: &Walk<'a, impl Point<'a>>, pair: Pair) -> String {
    let text = walk.text(0, pair.kind);
    if pair.reversed { text.chars().rev().collect() } else { text }
}

/// Whether bits, the most significant first, are the same; of different widths the lowest are looked at.
fn same_bits(a: &str, b: &str, dont_care: Option<Side>) -> bool {
    a.bytes().rev().zip(b.bytes().rev()).all(|(a, b)| {
        let any = match dont_care {
            None => false,
            Some(Side::A) => a == b'x',
            Some(Side::B) => b == b'x',
        };
        any || a == b
    })
}

#[derive(Clone, Copy)]
struct Scale {
    a: u64,
    b: u64,
}

struct Compare {
    /// Earlier times are not compared.
    from: u64,
    /// Later times are not compared.
    until: u64,
    /// Whether what differs from before `from` on counts.
    windowed: bool,
    scale: Scale,
    dont_care: Option<Side>,
}

/// A variable by its index and the pair of signals it has.
type Named = (usize, Pair);

/// The first difference of a variable.
struct Found {
    time: u64,
    var: usize,
    pair: Pair,
}

impl Compare {
    /// The first difference of each variable that has one, and what may be the clock: the one-bit
    /// variable that changes most often.
    fn all(
        &self,
        a: &mut Waves,
        b: &mut Waves,
        pairs: &[(Pair, Vec<usize>)],
        values: &mut u64,
    ) -> Result<(Vec<Found>, Option<Named>), ReadError> {
        let mut found = Vec::new();
        let mut clock: Option<(usize, Named)> = None;
        for batch in pairs.chunks(BATCH) {
            let loaded_a = load(a, batch.iter().map(|(pair, _)| pair.a))?;
            let loaded_b = load(b, batch.iter().map(|(pair, _)| pair.b))?;
            for (pair, vars) in batch {
                let (signal_a, signal_b) = (loaded_a.get(&pair.a), loaded_b.get(&pair.b));
                let walk = self.walk([(signal_a, a, self.scale.a), (signal_b, b, self.scale.b)]);
                if let Some(time) = self.first_difference(walk, *pair, values) {
                    found.extend(vars.iter().map(|&var| Found { time, var, pair: *pair }));
                }
                if pair.kind == ValueKind::Bits(1)
                    && let Some(changes) = signal_a.map(|signal| signal.len())
                    && clock.is_none_or(|(most, _)| changes > most)
                {
                    clock = Some((changes, (vars[0], *pair)));
                }
            }
        }
        Ok((found, clock.map(|(_, clock)| clock)))
    }

    fn differs<'a>(&self, walk: &Walk<'a, impl Point<'a>>, pair: Pair) -> bool {
        let same = if pair.reversed {
            same_bits(&first_text(walk, pair), &walk.text(1, pair.kind), self.dont_care)
        } else {
            same(walk.value(0, pair.kind), walk.value(1, pair.kind), self.dont_care)
        };
        !same
    }

    fn first_difference<'a>(&self, mut walk: Walk<'a, impl Point<'a>>, pair: Pair, values: &mut u64) -> Option<u64> {
        // whether they differed when the window began, which may be between two changes
        let mut held = false;
        while let Some(time) = walk.next() {
            if held && time > self.from {
                return Some(self.from);
            }
            if time > self.until {
                return None;
            }
            if time < self.from {
                held = self.windowed && self.differs(&walk, pair);
                continue;
            }
            held = false;
            *values += 1;
            if self.differs(&walk, pair) {
                return Some(time);
            }
        }
        held.then_some(self.from)
    }

    /// The rows around a time, `count` on each side of it, and the number of rising edges of the clock until then.
    fn around(
        &self,
        a: &mut Waves,
        b: &mut Waves,
        pair: Pair,
        clock: Option<Pair>,
        time: u64,
        count: usize,
    ) -> Result<(Vec<Row>, u64), ReadError> {
        let loaded_a = load(a, std::iter::once(pair.a).chain(clock.map(|clock| clock.a)))?;
        let loaded_b = load(b, std::iter::once(pair.b))?;
        let clock = clock.and_then(|clock| loaded_a.get(&clock.a));
        let mut walk = self.walk([
            (loaded_a.get(&pair.a), a, self.scale.a),
            (loaded_b.get(&pair.b), b, self.scale.b),
            (clock, a, self.scale.a),
        ]);
        let mut rows = VecDeque::new();
        let (mut edges, mut before, mut after) = (0, None, 0);
        while let Some(now) = walk.next() {
            if now > self.until || after > count {
                break;
            }
            let level = clock.map(|_| walk.text(2, ValueKind::Bits(1)));
            if now <= time && before.as_deref() == Some("0") && level.as_deref() == Some("1") {
                edges += 1;
            }
            before.clone_from(&level);
            rows.push_back(Row { time: now, clock: level, a: first_text(&walk, pair), b: walk.text(1, pair.kind) });
            if now >= time {
                after += 1;
            } else if rows.len() > count {
                rows.pop_front();
            }
        }
        Ok((rows.into(), edges))
    }

    /// Whether a variable is the same in both until a time, with at least three rising edges at equal distances.
    fn is_clock(&self, a: &mut Waves, b: &mut Waves, pair: Pair, until: u64) -> Result<bool, ReadError> {
        let loaded_a = load(a, std::iter::once(pair.a))?;
        let loaded_b = load(b, std::iter::once(pair.b))?;
        let mut walk = self.walk([(loaded_a.get(&pair.a), a, self.scale.a), (loaded_b.get(&pair.b), b, self.scale.b)]);
        let (mut edges, mut before, mut last, mut period) = (0, String::new(), None, None);
        while let Some(now) = walk.next() {
            let [x, y] = [walk.text(0, pair.kind), walk.text(1, pair.kind)];
            if now <= until && x != y {
                return Ok(false);
            }
            // The clock goes on after the difference, and may need that to be known as one.
            if now > until && edges >= 3 {
                break;
            }
            if before == "0" && x == "1" {
                let distance = last.map(|last| now - last);
                if period.is_some() && distance != period {
                    return Ok(false);
                }
                (last, period, edges) = (Some(now), distance, edges + 1);
            }
            before = x;
        }
        Ok(edges >= 3)
    }

    fn walk<'a, const N: usize>(
        &self,
        sources: [(Option<&'a Signal>, &'a Waves, u64); N],
    ) -> Walk<'a, impl Point<'a> + use<'a, N>> {
        let sources = sources.map(|(signal, waves, factor)| {
            let points = signal.into_iter().flat_map(|signal| read::changes(signal, waves.times()));
            Source { points: points.map(move |(time, value)| (time * factor, value)).peekable(), last: None }
        });
        Walk { sources: sources.into(), now: 0 }
    }
}

/// Signals by their numbers.
struct Loaded(HashMap<u32, Arc<Signal>>);

impl Loaded {
    fn get(&self, signal: &u32) -> Option<&Signal> {
        self.0.get(signal).map(|signal| &**signal)
    }
}

fn load(waves: &mut Waves, signals: impl Iterator<Item = u32>) -> Result<Loaded, ReadError> {
    let signals: Vec<u32> = signals.collect();
    Ok(Loaded(signals.iter().copied().zip(waves.signals(&signals)?).collect()))
}

#[cfg(test)]
#[path = "diff_tests.rs"]
mod tests;
