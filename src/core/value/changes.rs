//! Changes of words over time, packed: what an engine writes down while it goes on, and a waveform reads.
//!
//! A record is what one evaluation phase has changed. It begins with two numbers, its shape and its tick; then
//! comes a bit for each field of the shape, the first field's being the highest of the first word, and then the
//! values of the fields whose bit is 1, in order. What a field is part of is for those to know who gave the shape.

use super::Word;

/// How the new value of a field stands in a record.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Written {
    /// Not at all: it is one bit, known before and after, that is now the other.
    Toggled,
    /// As its value plane: all of it is known.
    Known,
    /// As its value plane and its unknown plane.
    Both,
}

impl Written {
    /// How many numbers that is.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            Written::Toggled => 0,
            Written::Known => 1,
            Written::Both => 2,
        }
    }
}

/// The new value of a field.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Change {
    /// Bit 0 is the other one now.
    Toggle,
    /// The whole word.
    Set(Word),
}

impl Change {
    /// Puts what changes of a part into the word that it is part of.
    #[inline(always)]
    pub fn put(self, word: &mut Word, from: u8, to: u8, mask: u64) {
        match self {
            Change::Toggle => word.v ^= 1 << to,
            Change::Set(new) => {
                let keep = !(mask << to);
                word.v = word.v & keep | (new.v >> from & mask) << to;
                word.u = word.u & keep | (new.u >> from & mask) << to;
            }
        }
    }
}

/// Numbers that a record has before its bits.
pub const HEAD: usize = 2;

/// The most numbers that a record with such fields can have.
#[must_use]
pub fn longest(fields: impl ExactSizeIterator<Item = Written>) -> usize {
    let masks = fields.len().div_ceil(64);
    HEAD + masks + fields.map(Written::size).sum::<usize>()
}

/// What reads records.
pub trait Reader {
    /// What can go wrong.
    type Error;

    /// How many fields a shape has.
    fn fields(&self, shape: usize) -> usize;

    /// Takes a record: its bits, and its values with all that follows. Returns how many of these are its own, as
    /// [`each`] does.
    ///
    /// # Errors
    /// The reader's.
    fn record(&mut self, shape: usize, time: u64, bits: &[u64], values: &[u64]) -> Result<usize, Self::Error>;
}

/// Reads records in order.
///
/// # Errors
/// The first of the reader.
///
/// # Panics
/// If these are not whole records of the shapes that the reader knows.
pub fn read<R: Reader>(mut words: &[u64], reader: &mut R) -> Result<(), R::Error> {
    while let [shape, time, rest @ ..] = words {
        let shape = *shape as usize;
        let (bits, values) = rest.split_at(reader.fields(shape).div_ceil(64));
        words = &values[reader.record(shape, *time, bits, values)?..];
    }
    Ok(())
}

/// Tells of each field of a record that has changed; returns how many values it has.
///
/// # Panics
/// If there are fewer.
#[inline(always)]
pub fn each(
    bits: &[u64],
    values: &[u64],
    written: impl Fn(usize) -> Written,
    mut change: impl FnMut(usize, Change),
) -> usize {
    let mut at = 0;
    for (i, &word) in bits.iter().enumerate() {
        let mut bits = word;
        while bits != 0 {
            let first = bits.leading_zeros();
            bits &= !(1 << 63 >> first);
            let field = i * 64 + first as usize;
            let new = match written(field) {
                Written::Toggled => Change::Toggle,
                Written::Known => Change::Set(Word::known(values[at])),
                Written::Both => Change::Set(Word { v: values[at], u: values[at + 1] }),
            };
            at += written(field).size();
            change(field, new);
        }
    }
    at
}

/// Where the first record of tick `time` or later begins, or the end.
#[must_use]
pub fn before(
    words: &[u64],
    written: impl Fn(usize, usize) -> Written,
    fields: impl Fn(usize) -> usize,
    time: u64,
) -> usize {
    struct Count<W, F>(W, F, u64, usize);
    impl<W: Fn(usize, usize) -> Written, F: Fn(usize) -> usize> Reader for Count<W, F> {
        type Error = ();
        fn fields(&self, shape: usize) -> usize {
            (self.1)(shape)
        }
        fn record(&mut self, shape: usize, time: u64, bits: &[u64], values: &[u64]) -> Result<usize, ()> {
            if time >= self.2 {
                return Err(());
            }
            let used = each(bits, values, |field| (self.0)(shape, field), |_, _| {});
            self.3 += HEAD + bits.len() + used;
            Ok(used)
        }
    }
    let mut count = Count(written, fields, time, 0);
    // an end before all were read is what is looked for
    _ = read(words, &mut count);
    count.3
}

/// Writes one record: the fields that have changed, in order, each with its value.
pub fn write(
    to: &mut Vec<u64>,
    shape: usize,
    time: u64,
    fields: usize,
    changed: impl Iterator<Item = (usize, Word, Written)>,
) {
    to.extend([shape as u64, time]);
    let masks = to.len();
    to.resize(masks + fields.div_ceil(64), 0);
    for (field, word, written) in changed {
        to[masks + field / 64] |= 1 << 63 >> (field % 64);
        match written {
            Written::Toggled => {}
            Written::Known => to.push(word.v),
            Written::Both => to.extend([word.v, word.u]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Seen(Vec<(u64, Vec<(usize, Change)>)>);

    impl Reader for Seen {
        type Error = ();
        fn fields(&self, shape: usize) -> usize {
            [3, 130][shape]
        }
        fn record(&mut self, _: usize, time: u64, bits: &[u64], values: &[u64]) -> Result<usize, ()> {
            let mut changes = Vec::new();
            let written = |field: usize| [Written::Toggled, Written::Known, Written::Both][field % 3];
            let used = each(bits, values, written, |field, change| changes.push((field, change)));
            self.0.push((time, changes));
            Ok(used)
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let mut words = Vec::new();
        let (known, both) = (Word::known(77), Word { v: 1, u: 3 });
        let all = [(0, Word::ZERO, Written::Toggled), (64, known, Written::Known), (128, both, Written::Both)];
        write(&mut words, 1, 5, 130, all.into_iter());
        write(&mut words, 0, 6, 3, all.into_iter().take(1));
        write(&mut words, 0, 6, 3, std::iter::empty());
        assert_eq!(words.len(), 2 + 3 + 3 + 3 + 3);
        let mut seen = Seen::default();
        read(&words, &mut seen).unwrap();
        let first = vec![(0, Change::Toggle), (64, Change::Set(known)), (128, Change::Set(both))];
        assert_eq!(seen.0, [(5, first), (6, vec![(0, Change::Toggle)]), (6, vec![])]);
    }

    #[test]
    fn the_longest_record_is_the_sum_of_its_parts() {
        let fields = [Written::Toggled, Written::Known, Written::Both];
        assert_eq!(longest(fields.into_iter()), 2 + 1 + 3);
        assert_eq!(longest([Written::Toggled; 65].into_iter()), 2 + 2);
    }
}
