//! The values in an FST file.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Arc;

use super::bytes::Bytes;
use super::fst_blocks::{Block, Form, part};
use super::notes::Notes;
use super::signal::{Signal, logic};
use super::{Fault, Input, ValueKind, unpack};

/// The values, which are read when they are asked for.
pub(super) struct Values {
    input: Box<dyn Input>,
    little: bool,
    sections: Vec<Section>,
    forms: Vec<Form>,
    /// The signals of variables: which signal of the file, and what its values are taken for.
    signals: Vec<(u32, ValueKind)>,
}

/// A block with values.
struct Section {
    block: Block,
    /// The entry of the table of times at which it begins.
    start: u64,
    /// The entry for each of its times.
    times: Vec<u64>,
    /// Where what tells the places of the changes ends.
    chain: u64,
}

/// What stands where in a section.
struct Parts {
    /// The values before the first change, if they count.
    frame: Option<Vec<u8>>,
    /// Where the method of packing stands, from which places count.
    base: u64,
    method: u8,
    /// Where the changes of each signal are.
    places: Vec<Option<(u64, u64)>>,
}

/// Which signals do the same as far as has been looked.
struct Alike {
    /// The class of each.
    classes: Vec<u32>,
    /// The first of each class.
    firsts: Vec<usize>,
}

impl Alike {
    fn new<K: Hash + Eq>(keys: impl Iterator<Item = K>) -> Alike {
        let keys: Vec<K> = keys.collect();
        let mut alike = Alike { classes: vec![0; keys.len()], firsts: Vec::new() };
        let mut keys = keys.into_iter().map(Some).collect::<Vec<_>>();
        alike.part(|at| keys[at].take());
        alike
    }

    /// Parts those for which `key` differs.
    fn part<K: Hash + Eq>(&mut self, mut key: impl FnMut(usize) -> K) {
        let mut known: HashMap<(u32, K), u32> = HashMap::new();
        self.firsts.clear();
        for (at, class) in self.classes.iter_mut().enumerate() {
            let new = self.firsts.len() as u32;
            let found = *known.entry((*class, key(at))).or_insert(new);
            if found == new {
                self.firsts.push(at);
            }
            *class = found;
        }
    }
}

/// Where the changes of a signal are.
#[derive(Clone, Copy)]
enum Place {
    None,
    /// They are those of another.
    Same(usize),
    /// From there to there, counted from the method by which they are packed.
    At(u64, u64),
}

/// The last three numbers of a section.
const TAIL: u64 = 24;
/// The first three.
const HEAD: u64 = 24;

impl Values {
    /// The values of a file, and the table of all times.
    pub fn new(
        mut input: Box<dyn Input>,
        little: bool,
        blocks: Vec<Block>,
        forms: Vec<Form>,
        signals: Vec<(u32, ValueKind)>,
        notes: &mut Notes,
    ) -> Result<(Values, Vec<u64>), Fault> {
        let mut times = Vec::new();
        let mut sections = Vec::new();
        for block in blocks {
            sections.push(Section::new(&mut *input, block, &mut times, notes)?);
        }
        Ok((Values { input, little, sections, forms, signals }, times))
    }

    /// The signals of these numbers, in this order. Those that do the same are read once: a file may give the same changes
    /// to any number of them.
    pub fn load(&mut self, wanted: &[u32]) -> Result<Vec<Arc<Signal>>, Fault> {
        let mut alike = Alike::new(wanted.iter().map(|&number| {
            let (file, kind) = self.signals[number as usize];
            (self.forms[file as usize], kind)
        }));
        for i in 0..self.sections.len() {
            let parts = self.parts(i)?;
            alike.part(|at| parts.places[self.signals[wanted[at] as usize].0 as usize]);
            if let Some(frame) = &parts.frame {
                let starts = self.starts();
                alike.part(|at| {
                    let file = self.signals[wanted[at] as usize].0 as usize;
                    frame.get(starts[file]..starts[file + 1]).map(<[u8]>::to_vec)
                });
            }
        }
        let firsts: Vec<u32> = alike.firsts.iter().map(|&at| wanted[at]).collect();
        let mut loaded: Vec<Signal> =
            firsts.iter().map(|&number| Signal::new(self.signals[number as usize].1)).collect();
        for i in 0..self.sections.len() {
            let Parts { frame, base, method, places } = self.parts(i)?;
            if let Some(frame) = frame {
                self.begin(&frame, self.sections[i].start, &firsts, &mut loaded);
            }
            for (signal, &number) in loaded.iter_mut().zip(&firsts) {
                let (file, _) = self.signals[number as usize];
                let Some((from, to)) = places[file as usize] else { continue };
                let packed = part(&mut *self.input, base + from, to - from)?;
                let section = &self.sections[i];
                let decoder = Decoder { form: self.forms[file as usize], little: self.little, times: &section.times };
                let decoded = changes(&packed, method).and_then(|changes| decoder.decode(&changes, signal));
                decoded.ok_or_else(|| section.wrong())?;
            }
        }
        let loaded: Vec<Arc<Signal>> = loaded.into_iter().map(Arc::new).collect();
        Ok(alike.classes.iter().map(|&class| loaded[class as usize].clone()).collect())
    }

    /// What stands where in a section.
    fn parts(&mut self, i: usize) -> Result<Parts, Fault> {
        let (section, input) = (&self.sections[i], &mut *self.input);
        let wrong = || section.wrong();
        let Block { at, length, .. } = section.block;
        // three numbers of at most ten bytes each tell of the values at the beginning
        let head = part(input, at + HEAD, (length - HEAD).min(30))?;
        let mut bytes = Bytes(&head);
        let (unpacked, packed) = (bytes.variable().ok_or_else(wrong)?, bytes.variable().ok_or_else(wrong)?);
        bytes.variable().ok_or_else(wrong)?;
        let frame = at + HEAD + (head.len() - bytes.0.len()) as u64;
        let behind = frame.checked_add(packed).filter(|&end| end <= section.chain).ok_or_else(wrong)?;
        let begins = i == 0 && section.times.first().is_none_or(|&first| first > section.start);
        let frame = match begins {
            true => Some(unpack::zlib_or_plain(&part(input, frame, packed)?, unpacked).ok_or_else(wrong)?),
            false => None,
        };
        let head = part(input, behind, (section.chain - behind).min(11))?;
        let mut bytes = Bytes(&head);
        bytes.variable().ok_or_else(wrong)?;
        let base = behind + (head.len() - bytes.0.len()) as u64;
        let method = bytes.byte().ok_or_else(wrong)?;
        let places = section.places(input, base, self.forms.len()).ok_or_else(wrong)??;
        let place = |place: &Place| match place {
            Place::None => Ok(None),
            Place::At(from, to) => Ok(Some((*from, *to))),
            Place::Same(other) => match places.get(*other) {
                Some(Place::At(from, to)) => Ok(Some((*from, *to))),
                _ => Err(wrong()),
            },
        };
        let places = places.iter().map(place).collect::<Result<_, _>>()?;
        Ok(Parts { frame, base, method, places })
    }

    /// Where the first value of each signal begins among those of all, and where the last ends.
    fn starts(&self) -> Vec<usize> {
        let mut starts = Vec::with_capacity(self.forms.len() + 1);
        let mut end = 0_usize;
        starts.push(0);
        for form in &self.forms {
            end = end.saturating_add(match form {
                Form::Bits(width) => *width as usize,
                Form::Real => 8,
                Form::Text => 0,
            });
            starts.push(end);
        }
        starts
    }

    /// The values that signals have before their first change.
    fn begin(&self, frame: &[u8], at: u64, wanted: &[u32], loaded: &mut [Signal]) {
        let starts = self.starts();
        for (signal, &number) in loaded.iter_mut().zip(wanted) {
            let (file, kind) = self.signals[number as usize];
            let bytes = frame.get(starts[file as usize]..starts[file as usize + 1]).unwrap_or_default();
            match (self.forms[file as usize], kind) {
                // an event is there only when it happens
                (Form::Text, _) | (_, ValueKind::Event) => {}
                _ if bytes.is_empty() => {}
                (form, _) => drop(put(signal, form, bytes, self.little, at)),
            }
        }
    }
}

impl Section {
    fn wrong(&self) -> Fault {
        Fault::Malformed(format!("the values in the block at byte {} are wrong", self.block.at - 9))
    }

    fn new(input: &mut dyn Input, block: Block, times: &mut Vec<u64>, notes: &mut Notes) -> Result<Section, Fault> {
        let begin = block.at - 9;
        let wrong = || Fault::Malformed(format!("the times in the block at byte {begin} are wrong"));
        let Block { at, length, .. } = block;
        if length < HEAD + 4 + 8 + TAIL {
            return Err(wrong());
        }
        let start = Bytes(&part(input, at, 8)?).number().ok_or_else(wrong)?;
        let tail = part(input, at + length - TAIL, TAIL)?;
        let mut bytes = Bytes(&tail);
        let mut next = || bytes.number().ok_or_else(wrong);
        let (unpacked, packed, count) = (next()?, next()?, next()?);
        let room = length - HEAD - 4 - 8 - TAIL;
        // a time takes a byte at least
        if packed > room || count > unpacked {
            return Err(wrong());
        }
        let from = at + length - TAIL - packed;
        let list = unpack::zlib_or_plain(&part(input, from, packed)?, unpacked).ok_or_else(wrong)?;
        let mut list = Bytes(&list);
        let mut section = Section { block, start: 0, times: Vec::new(), chain: from - 8 };
        let mut now = 0_u64;
        let enter = |times: &mut Vec<u64>, now: u64| {
            if times.last().is_none_or(|&last| last < now) {
                times.push(now);
            }
            times.len() as u64 - 1
        };
        for i in 0..count {
            let gap = list.variable().ok_or_else(wrong)?;
            now = now.checked_add(gap).ok_or_else(wrong)?;
            if i == 0 && times.is_empty() {
                enter(times, start.min(now));
            }
            if times.last().is_some_and(|&last| last > now) {
                notes.add("back", || {
                    format!("the block at byte {begin}: time goes back to {now}; it is taken to stand still")
                });
            }
            section.times.push(enter(times, now));
        }
        if count == 0 && times.is_empty() {
            enter(times, start);
        }
        Ok(section)
    }

    /// Where the changes of each signal are. `base` is where the method of packing stands, from which places count.
    fn places(&self, input: &mut dyn Input, base: u64, count: usize) -> Option<Result<Vec<Place>, Fault>> {
        let length = match part(input, self.chain, 8) {
            Ok(length) => Bytes(&length).number()?,
            Err(fault) => return Some(Err(fault)),
        };
        let end = self.chain.checked_sub(base)?.checked_sub(length)?;
        let chain = match part(input, self.chain - length, length) {
            Ok(chain) => chain,
            Err(fault) => return Some(Err(fault)),
        };
        let mut chain = Bytes(&chain);
        let mut places = Vec::new();
        // the last one with changes, and where these begin
        let mut last: Option<(usize, u64)> = None;
        let mut alias = 0;
        let mut at = |places: &mut Vec<Place>, from: u64| -> Option<()> {
            if let Some((i, before)) = last {
                places[i] = Place::At(before, Some(from).filter(|&from| before < from && from <= end)?);
            }
            last = Some((places.len(), from));
            places.push(Place::None);
            Some(())
        };
        let mut offset = 0_u64;
        while !chain.is_empty() {
            if self.block.kind == 8 && chain.0[0] & 1 == 1 {
                match chain.signed()? >> 1 {
                    0 => places.push(Place::Same(alias)),
                    back @ ..0 => {
                        alias = usize::try_from(back.checked_neg()? - 1).ok()?;
                        places.push(Place::Same(alias));
                    }
                    forth => {
                        offset = offset.checked_add(forth.cast_unsigned())?;
                        at(&mut places, offset)?;
                    }
                }
            } else {
                match chain.variable()? {
                    0 if self.block.kind != 8 => {
                        alias = usize::try_from(chain.variable()?.checked_sub(1)?).ok()?;
                        places.push(Place::Same(alias));
                    }
                    forth if forth & 1 == 1 => {
                        offset = offset.checked_add(forth >> 1)?;
                        at(&mut places, offset)?;
                    }
                    none => {
                        let none = usize::try_from(none >> 1).ok()?;
                        let length = places.len().checked_add(none).filter(|&length| length <= count)?;
                        places.resize(length, Place::None);
                    }
                }
            }
            if places.len() > count {
                return None;
            }
        }
        if let Some((i, from)) = last {
            places[i] = Place::At(from, Some(end).filter(|&end| from < end)?);
        }
        places.resize(count, Place::None);
        Some(Ok(places))
    }
}

/// The changes of a signal, unpacked.
fn changes(bytes: &[u8], method: u8) -> Option<Vec<u8>> {
    let mut bytes = Bytes(bytes);
    match bytes.variable()? {
        0 => Some(bytes.0.to_vec()),
        unpacked => match method {
            b'4' => unpack::lz4(bytes.0, unpacked),
            b'F' => unpack::fastlz(bytes.0, unpacked),
            _ => unpack::zlib(bytes.0, unpacked),
        },
    }
}

struct Decoder<'a> {
    form: Form,
    little: bool,
    times: &'a [u64],
}

impl Decoder<'_> {
    /// Each change begins with how many times it is after the last.
    fn decode(&self, changes: &[u8], signal: &mut Signal) -> Option<()> {
        let mut bytes = Bytes(changes);
        let mut time = 0_u64;
        let mut text = Vec::new();
        while !bytes.is_empty() {
            let head = bytes.variable()?;
            let gap = match self.form {
                Form::Bits(1) => head >> if head & 1 == 0 { 2 } else { 4 },
                _ => head >> 1,
            };
            time = time.checked_add(gap)?;
            let at = *self.times.get(usize::try_from(time).ok()?)?;
            let length = match self.form {
                Form::Bits(1) => {
                    let bit = (head >> 1) as usize;
                    let value = if head & 1 == 0 { b'0' | (bit & 1) as u8 } else { b"xzhuwl-?"[bit & 7] };
                    put(signal, self.form, &[value], self.little, at)?;
                    continue;
                }
                Form::Text => bytes.variable()?,
                Form::Bits(width) => width.into(),
                Form::Real => 8,
            };
            if head & 1 == 1 || self.form == Form::Text {
                put(signal, self.form, bytes.take(length)?, self.little, at)?;
            } else {
                let packed = bytes.take(length.div_ceil(8))?;
                text.clear();
                text.extend((0..length as usize).map(|i| b'0' | packed[i / 8] >> (7 - i % 8) & 1));
                put(signal, self.form, &text, self.little, at)?;
            }
        }
        Some(())
    }
}

/// A value as the file has it.
fn put(signal: &mut Signal, form: Form, bytes: &[u8], little: bool, at: u64) -> Option<()> {
    match (signal.kind(), form) {
        (ValueKind::Event, _) => signal.event(at),
        (ValueKind::Real, _) => {
            let bytes = *bytes.first_chunk()?;
            signal.real(at, if little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) });
        }
        // GTKWave's writer takes bytes, most often of UTF-8
        (ValueKind::Text, _) => signal.text(at, &String::from_utf8_lossy(bytes)),
        // what is no value of its nine is unknown
        (ValueKind::Bits(width), _) => {
            signal.bits(at, width, |i| bytes.get(width as usize - 1 - i).map_or(2, |byte| logic(*byte).unwrap_or(2)));
        }
    }
    Some(())
}
