//! The signals of a GHW file and their values: each bit of a vector is a signal of its own there.

use std::collections::HashMap;
use std::io::BufRead;
use std::sync::Arc;

use super::ValueKind;
use super::ghw::{Stop, Stream};
use super::ghw_types::{Scalar, Scalared};
use super::signal::{Signal, logic};
use crate::Layout;

/// The values of `std_ulogic` in their order.
const LOGIC: &[u8; 9] = b"UX01ZWLH-";

/// The signals of a file.
#[derive(Default)]
pub(super) struct Signals {
    /// The scalars of the file by their numbers.
    scalars: HashMap<u64, Declared>,
    /// The same in the order of their numbers, once all are known.
    ordered: Vec<Declared>,
    kept: Vec<Kept>,
    vectors: HashMap<Vec<u64>, u32>,
    /// Those of `kept` that have changed at the current time.
    changed: Vec<u32>,
}

struct Declared {
    scalar: Scalar,
    /// What it is, or a bit of.
    users: Vec<(u32, u32)>,
}

/// The signal of a variable.
struct Kept {
    signal: Signal,
    value: Current,
    changed: bool,
}

enum Current {
    /// As [`logic`] has them, the least significant first.
    Bits(Vec<u8>),
    Number(i64),
    Real(f64),
}

impl Signals {
    fn keep(&mut self, kind: ValueKind, value: Current) -> u32 {
        self.kept.push(Kept { signal: Signal::new(kind), value, changed: false });
        self.kept.len() as u32 - 1
    }

    /// A scalar that has values, whether anything wants them or not.
    pub fn declare(&mut self, number: u64, scalar: Scalar) {
        self.scalars.entry(number).or_insert(Declared { scalar, users: Vec::new() });
    }

    /// The signal of a scalar; none if it is of another type elsewhere.
    pub fn scalar(&mut self, number: u64, scalar: Scalar) -> Option<u32> {
        if matches!(scalar, Scalar::Logic | Scalar::Bit) {
            return self.vector(&[number], scalar);
        }
        let known = self.scalars.get(&number);
        if known.is_some_and(|known| known.scalar != scalar) {
            return None;
        }
        if let Some(user) = known.and_then(|known| known.users.first()) {
            return Some(user.0);
        }
        let value = if scalar == Scalar::Real { Current::Real(0.0) } else { Current::Number(0) };
        let signal = self.keep(scalar.kind(), value);
        self.declare(number, scalar);
        self.scalars.entry(number).and_modify(|known| known.users.push((signal, 0)));
        Some(signal)
    }

    /// The signal of a vector, whose bits are these, the most significant first.
    pub fn vector(&mut self, numbers: &[u64], scalar: Scalar) -> Option<u32> {
        if let Some(&known) = self.vectors.get(numbers) {
            return Some(known);
        }
        if numbers.iter().any(|number| self.scalars.get(number).is_some_and(|known| known.scalar != scalar)) {
            numbers.iter().for_each(|&number| self.declare(number, scalar));
            return None;
        }
        let width = u32::try_from(numbers.len()).unwrap_or(u32::MAX).min(Layout::MAX_WIDTH + 1);
        let signal = self.keep(ValueKind::Bits(width), Current::Bits(vec![2; numbers.len()]));
        for (bit, number) in numbers.iter().rev().enumerate() {
            let declared = self.scalars.entry(*number).or_insert(Declared { scalar, users: Vec::new() });
            // what is too wide is not read
            if width <= Layout::MAX_WIDTH {
                declared.users.push((signal, bit as u32));
            }
        }
        self.vectors.insert(numbers.to_vec(), signal);
        Some(signal)
    }

    /// All scalars are known: values refer to them by their order.
    pub fn order(&mut self) {
        let mut scalars: Vec<(u64, Declared)> = std::mem::take(&mut self.scalars).into_iter().collect();
        scalars.sort_by_key(|(number, _)| *number);
        self.ordered = scalars.into_iter().map(|(_, declared)| declared).collect();
        self.vectors = HashMap::new();
    }

    /// The values of all.
    pub fn all(&mut self, stream: &mut Stream<impl BufRead>) -> Result<(), Stop> {
        (0..self.ordered.len()).try_for_each(|i| self.one(stream, i))
    }

    /// The values of some: before each stands how many it is after the last, from 1; 0 ends them.
    pub fn some(&mut self, stream: &mut Stream<impl BufRead>) -> Result<(), Stop> {
        let mut next = 0_u64;
        loop {
            let gap = stream.unsigned()?;
            if gap == 0 {
                return Ok(());
            }
            next = next.saturating_add(gap);
            let i = usize::try_from(next - 1).ok().filter(|&i| i < self.ordered.len());
            self.one(stream, i.ok_or(Stop::Wrong("the number of a signal"))?)?;
        }
    }

    fn one(&mut self, stream: &mut Stream<impl BufRead>, i: usize) -> Result<(), Stop> {
        let Declared { scalar, users } = &self.ordered[i];
        let value = scalar.read(stream)?;
        let code = match (scalar, &value) {
            (Scalar::Logic, Scalared::Number(n)) => {
                let byte = usize::try_from(*n).ok().and_then(|n| LOGIC.get(n));
                byte.and_then(|byte| logic(*byte)).ok_or(Stop::Wrong("a value"))?
            }
            (Scalar::Bit, Scalared::Number(n)) => {
                u8::try_from(*n).ok().filter(|n| *n < 2).ok_or(Stop::Wrong("a value"))?
            }
            _ => 0,
        };
        for &(kept, bit) in users {
            let to = &mut self.kept[kept as usize];
            match (&mut to.value, &value) {
                (Current::Bits(bits), _) => bits[bit as usize] = code,
                (Current::Number(number), Scalared::Number(new)) => *number = *new,
                (Current::Real(number), Scalared::Real(new)) => *number = *new,
                _ => {}
            }
            if !std::mem::replace(&mut to.changed, true) {
                self.changed.push(kept);
            }
        }
        Ok(())
    }

    /// What has changed is the value from now on.
    pub fn settle(&mut self, at: u64) {
        for kept in self.changed.drain(..) {
            let Kept { signal, value, changed } = &mut self.kept[kept as usize];
            *changed = false;
            match (value, signal.kind()) {
                (Current::Bits(bits), _) => signal.bits(at, bits.len() as u32, |i| bits[i]),
                (Current::Number(number), ValueKind::Bits(width)) => {
                    signal.bits(at, width, |i| (*number >> i & 1) as u8);
                }
                (Current::Real(number), _) => signal.real(at, *number),
                _ => {}
            }
        }
    }

    /// All signals with their values.
    pub fn done(self) -> Vec<Arc<Signal>> {
        self.kept.into_iter().map(|kept| Arc::new(kept.signal)).collect()
    }
}
