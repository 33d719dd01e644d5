//! Which combinations of values a sweep runs, and in which order.

use std::collections::BTreeSet;
use std::ops::Range;
use std::str::FromStr;
use std::{error, fmt};

use crate::Value;
use crate::random;
use crate::value::Word;

/// The values of one input, as they were asked for: `NET=A..B`, `NET=A..B..STEP` or `NET=A,B,C`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Over {
    /// The input.
    pub net: String,
    /// Its values.
    pub values: Values,
}

/// Values in order.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Values {
    /// From the first to the last, both included, by a step of 1 or more.
    Range {
        /// The first.
        first: i64,
        /// The last, if the step leads there.
        last: i64,
        /// How far each is from the one before it.
        step: u64,
    },
    /// One by one, as they are written.
    List(Vec<String>),
}

impl FromStr for Over {
    type Err = String;

    fn from_str(text: &str) -> Result<Over, String> {
        const WRITE: &str = "write it as NET=A..B, NET=A..B..STEP or NET=A,B,C";
        // a name as Verilog escapes it may hold anything up to white space
        let split = match text.strip_prefix('\\') {
            Some(escaped) => escaped
                .split_once(char::is_whitespace)
                .and_then(|(net, rest)| Some((net, rest.trim_start().strip_prefix('=')?))),
            None => text.split_once('='),
        };
        let (net, values) = split.map(|(net, values)| (net.trim(), values.trim())).ok_or(WRITE)?;
        if net.is_empty() || values.is_empty() {
            return Err(WRITE.into());
        }
        let values = if values.contains("..") {
            let mut parts = values.split("..");
            let mut number = || parts.next().map(|n| n.trim().parse::<i64>());
            let (first, last, step) = (number(), number(), number());
            let (Some(Ok(first)), Some(Ok(last)), None) = (first, last, parts.next()) else { return Err(WRITE.into()) };
            let step = match step {
                None => 1,
                Some(Ok(step)) if step > 0 => step.unsigned_abs(),
                Some(_) => return Err("the step is a number of 1 or more".into()),
            };
            if last < first {
                return Err(format!("the range is empty: {last} is below {first}"));
            }
            Values::Range { first, last, step }
        } else {
            let list: Vec<String> = values.split(',').map(|v| v.trim().to_owned()).collect();
            if list.iter().any(String::is_empty) {
                return Err(WRITE.into());
            }
            Values::List(list)
        };
        Ok(Over { net: net.to_owned(), values })
    }
}

impl fmt::Display for Over {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}=", self.net)?;
        match &self.values {
            Values::Range { first, last, step: 1 } => write!(f, "{first}..{last}"),
            Values::Range { first, last, step } => write!(f, "{first}..{last}..{step}"),
            Values::List(list) => f.write_str(&list.join(",")),
        }
    }
}

impl Over {
    /// How many values there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        match &self.values {
            Values::Range { first, last, step } => (last.abs_diff(*first) / step).saturating_add(1),
            Values::List(list) => list.len() as u64,
        }
    }

    /// Value number `index` as text.
    #[must_use]
    pub fn text(&self, index: u64) -> String {
        match &self.values {
            Values::Range { .. } => self.number(index).to_string(),
            Values::List(list) => list[index as usize].clone(),
        }
    }

    /// Of a range, number `index`.
    fn number(&self, index: u64) -> i64 {
        match &self.values {
            Values::Range { first, step, .. } => first.wrapping_add((index * step) as i64),
            Values::List(_) => 0,
        }
    }

    /// The values for an input of so many bits, which takes negative numbers if it is `signed`.
    ///
    /// # Errors
    /// A value that does not fit or is negative without a sign, or an input of more than 64 bits.
    pub fn values(&self, width: u32, signed: bool) -> Result<Axis, PlanError> {
        let fault = |why: String| PlanError(format!("`{}`: {why}", self.net));
        if width > 64 {
            return Err(fault(format!("an input of {width} bits cannot be swept, 64 are the most")));
        }
        let word = |text: &str| {
            let value = Value::given(text, width, signed).map_err(|e| fault(format!("`{text}`: {e}")))?;
            Ok(value.words().next().unwrap_or_default())
        };
        match &self.values {
            Values::Range { first, step, .. } => {
                word(&self.text(0))?;
                word(&self.text(self.count() - 1))?;
                Ok(Axis::Range {
                    first: *first,
                    step: *step,
                    count: self.count(),
                    mask: crate::value::word::mask(width),
                })
            }
            Values::List(list) => list.iter().map(|text| word(text)).collect::<Result<_, _>>().map(Axis::List),
        }
    }
}

/// The values of one input, of its width.
#[derive(Clone, Debug)]
pub enum Axis {
    /// Numbers.
    Range {
        /// The first.
        first: i64,
        /// How far each is from the one before it.
        step: u64,
        /// How many.
        count: u64,
        /// The bits of the input.
        mask: u64,
    },
    /// Any values.
    List(Vec<Word>),
}

impl Axis {
    /// How many values there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        match self {
            Axis::Range { count, .. } => *count,
            Axis::List(list) => list.len() as u64,
        }
    }

    /// Value number `index`.
    #[must_use]
    pub fn value(&self, index: u64) -> Word {
        match self {
            Axis::Range { first, step, mask, .. } => Word::known((*first as u64).wrapping_add(index * step) & mask),
            Axis::List(list) => list[index as usize],
        }
    }
}

/// A part of a sweep: number `.0` of `.1`, from 1 up.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Shard(pub u64, pub u64);

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match numbers {
            Some((i, n)) if (1..=n).contains(&i) => Ok(Shard(i, n)),
            _ => Err("write it as I/N, from 1/N to N/N".into()),
        }
    }
}

/// Why a sweep is not possible.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PlanError(String);

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl error::Error for PlanError {}

/// The most combinations that a sample takes, as it keeps their numbers.
const MOST_SAMPLED: u64 = 1 << 26;

/// The combinations that are run: each input's values in order, the last input's fastest.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The values of each input.
    pub axes: Vec<Axis>,
    /// The numbers of the combinations in a sample, in order.
    sample: Option<Vec<u64>>,
    /// The rows of the whole sweep.
    total: u64,
    /// The rows of this part of it.
    pub rows: Range<u64>,
}

impl Plan {
    /// All combinations.
    ///
    /// # Errors
    /// If there are more than 2^64.
    pub fn new(axes: Vec<Axis>) -> Result<Plan, PlanError> {
        let total = axes.iter().try_fold(1u64, |n, axis| n.checked_mul(axis.count()));
        let total = total.ok_or_else(|| PlanError("there are more than 2^64 combinations".into()))?;
        Ok(Plan { axes, sample: None, total, rows: 0..total })
    }

    /// `count` different combinations, drawn by a seed, in the order of all.
    ///
    /// # Errors
    /// If that is more than can be kept.
    pub fn sample(mut self, count: u64, seed: u64) -> Result<Plan, PlanError> {
        if count >= self.total {
            return Ok(self);
        }
        if count > MOST_SAMPLED {
            return Err(PlanError(format!("a sample holds {MOST_SAMPLED} combinations at most")));
        }
        // Floyd's way to draw without drawing twice
        let mut state = seed;
        let mut drawn = BTreeSet::new();
        for most in self.total - count..self.total {
            let number = below(&mut state, most);
            if !drawn.insert(number) {
                drawn.insert(most);
            }
        }
        (self.total, self.rows) = (count, 0..count);
        self.sample = Some(drawn.into_iter().collect());
        Ok(self)
    }

    /// A part of it.
    #[must_use]
    pub fn shard(mut self, Shard(i, n): Shard) -> Plan {
        let at = |i: u64| (u128::from(self.total) * u128::from(i) / u128::from(n)) as u64;
        self.rows = at(i - 1)..at(i);
        self
    }

    /// The rows of the whole sweep, of which this may be a part.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }

    /// The number of each input's value in a row.
    pub fn indices(&self, row: u64) -> impl DoubleEndedIterator<Item = u64> + ExactSizeIterator + use<> {
        let mut rest = self.sample.as_ref().map_or(row, |s| s[row as usize]);
        let mut indices: Vec<u64> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let index = rest % axis.count();
                rest /= axis.count();
                index
            })
            .collect();
        indices.reverse();
        indices.into_iter()
    }

    /// The value of one input in a row.
    #[must_use]
    pub fn value(&self, axis: usize, row: u64) -> Word {
        let number = self.sample.as_ref().map_or(row, |s| s[row as usize]);
        let rest = self.axes[axis + 1..].iter().fold(number, |rest, axis| rest / axis.count());
        self.axes[axis].value(rest % self.axes[axis].count())
    }

    /// The value of each input in a row.
    pub fn values(&self, row: u64) -> impl Iterator<Item = Word> {
        (0..self.axes.len()).map(move |axis| self.value(axis, row))
    }
}

/// A number from 0 to `most`.
fn below(state: &mut u64, most: u64) -> u64 {
    ((u128::from(random::next(state)) * (u128::from(most) + 1)) >> 64) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(overs: &[&str], width: u32) -> Plan {
        let axes = overs.iter().map(|o| o.parse::<Over>().unwrap().values(width, true).unwrap());
        Plan::new(axes.collect()).unwrap()
    }

    fn rows(plan: &Plan) -> Vec<Vec<u64>> {
        plan.rows.clone().map(|row| plan.values(row).map(|w| w.v).collect()).collect()
    }

    #[test]
    fn the_last_input_changes_fastest() {
        assert_eq!(rows(&plan(&["a=0..1", "b=3..5"], 4)), [[0, 3], [0, 4], [0, 5], [1, 3], [1, 4], [1, 5]]);
        assert_eq!(rows(&plan(&["a=-2..2..2"], 4)), [[14], [0], [2]]);
        assert_eq!(rows(&plan(&["a=1,4'b0110, 3"], 4)), [[1], [6], [3]]);
        assert_eq!(plan(&["a=0..255", "b=0..255"], 8).total(), 65536);
    }

    #[test]
    fn what_is_no_range_is_told() {
        let fault = |text: &str| text.parse::<Over>().unwrap_err();
        for text in ["a", "=1..2", "a=", "a=1..", "a=1..2..3..4", "a=x..2", "a=1,,2"] {
            assert!(fault(text).starts_with("write it as NET=A..B"), "{text}");
        }
        assert_eq!(fault("a=5..3"), "the range is empty: 3 is below 5");
        assert_eq!(fault("a=1..9..0"), "the step is a number of 1 or more");
        let wide = "a=0..16".parse::<Over>().unwrap().values(4, true).unwrap_err().to_string();
        assert!(wide.starts_with("`a`: `16`: "), "{wide}");
        assert!("a=0..1".parse::<Over>().unwrap().values(65, true).is_err());
        let many = "a=0..4294967296".parse::<Over>().unwrap().values(40, true).unwrap();
        assert!(Plan::new(vec![many.clone(), many]).is_err());
        for text in ["0/4", "5/4", "1", "a/b", "1/0"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }

    #[test]
    fn shards_are_the_whole_once() {
        for n in [1, 3, 7, 100] {
            let parts = (1..=n).flat_map(|i| plan(&["a=0..9"], 4).shard(Shard(i, n)).rows);
            assert_eq!(parts.collect::<Vec<_>>(), (0..10).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_sample_is_of_different_combinations_in_order() {
        let sample = |count, seed| rows(&plan(&["a=0..9", "b=0..9"], 4).sample(count, seed).unwrap());
        let all = sample(100, 1);
        assert_eq!(all.len(), 100);
        for count in [1, 30, 99] {
            let some = sample(count, 7);
            assert_eq!(some.len() as u64, count);
            assert!(some.is_sorted() && some.windows(2).all(|w| w[0] != w[1]) && some.iter().all(|r| all.contains(r)));
            assert_eq!(some, sample(count, 7));
        }
        assert_ne!(sample(30, 7), sample(30, 8));
    }
}
