//! A block: the words of one line, put together and checked against each other, before anything is done.

use std::ops::Range;

use super::decimal::Decimal;
use super::expression::{Name, Parameters};
use super::fault::Fault;
use super::words::{Cursor, Item, Word};
use crate::diag::Code;

/// Of the codes of one group a block has at most one.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Group {
    /// Codes for this block alone: G4, G10, G28, G30, G92 …
    Once,
    /// G0 to G3, G80.
    Motion,
    /// G17 to G19.
    Plane,
    /// G90, G91.
    Distance,
    /// G90.1, G91.1.
    Centers,
    /// G93, G94.
    FeedMode,
    /// G20, G21.
    Units,
    /// G40 to G42.
    Radius,
    /// G43, G49.
    Length,
    /// G54 to G59.3.
    System,
    /// G61, G64.
    Path,
    /// G53, which goes with a motion.
    Absolute,
}

/// How many groups there are.
const GROUPS: usize = 12;

/// The group of a code, ten times its number.
const fn group(code: i64) -> Option<Group> {
    Some(match code {
        40 | 100 | 280 | 300 | 920 | 921 | 922 | 923 => Group::Once,
        0 | 10 | 20 | 30 | 800 => Group::Motion,
        170 | 180 | 190 => Group::Plane,
        900 | 910 => Group::Distance,
        901 | 911 => Group::Centers,
        930 | 940 => Group::FeedMode,
        200 | 210 => Group::Units,
        400 => Group::Radius,
        430 | 490 => Group::Length,
        540 | 550 | 560 | 570 | 580 | 590 | 591 | 592 | 593 => Group::System,
        610 | 611 | 640 => Group::Path,
        530 => Group::Absolute,
        _ => return None,
    })
}

/// What to do about a code that is known elsewhere.
fn advice(code: i64) -> &'static str {
    match code {
        330..=331 => "thread cutting follows a spindle, which is not simulated: write the moves as G1",
        380..=389 => "probing needs a probe, which is not simulated: take the block out",
        730..=739 | 760 | 810..=899 | 980 | 990 => "expand the canned cycle into its G0 and G1 moves",
        410..=429 => "the radius of a tool is not taken in here: let the CAM system put out the tool's path",
        431..=439 => "tool lengths are 0 here: use G43, or take the block out",
        950 => "write the feed in units a minute, G94, or inverse time, G93",
        50..=59 => "splines are not read: write the curve as G1, G2 and G3",
        _ => "docs/machine.md lists the words that are read",
    }
}

/// A code of a block.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct GCode {
    /// Ten times its number.
    pub code: i64,
    /// Where it stands.
    pub at: Range<usize>,
}

/// The words of one line.
#[derive(Clone, Default, Debug)]
pub struct Block {
    g: [Option<GCode>; GROUPS],
    m: Vec<(i64, Range<usize>)>,
    words: [Option<Word>; 26],
    assignments: Vec<(Name, Decimal)>,
    /// `/`: the line may be left out.
    pub optional: bool,
    /// Nothing but `%`.
    pub percent: bool,
    /// The line has something other than comments.
    pub any: bool,
}

impl Block {
    /// Reads a line.
    ///
    /// # Errors
    /// A word that is no word, is not known, or stands twice.
    pub fn read(&mut self, line: &[u8], parameters: &Parameters) -> Result<(), Fault> {
        self.g.fill(None);
        self.m.clear();
        self.words.fill(None);
        self.assignments.clear();
        (self.optional, self.percent, self.any) = (false, false, false);
        let mut cursor = Cursor::new(line);
        while let Some(item) = cursor.item(parameters)? {
            match item {
                Item::Word(word) => self.word(word)?,
                Item::Assignment(name, value) => self.assignments.push((name, value)),
                Item::Optional if !self.any => self.optional = true,
                Item::Percent if !self.any => self.percent = true,
                Item::Optional | Item::Percent => {
                    let at = cursor.at() - 1;
                    let what = if item == Item::Percent { "`%` stands alone on its line" } else { "`/` begins a line" };
                    return Err(
                        Fault::new(Code::BadWord, at..at + 1, what).help("put it on a line of its own, or take it out")
                    );
                }
            }
            if self.percent && self.any {
                let at = cursor.at() - 1;
                return Err(Fault::new(Code::BadWord, at..at + 1, "`%` stands alone on its line")
                    .help("put it on a line of its own, or take it out"));
            }
            self.any = true;
        }
        Ok(())
    }

    fn word(&mut self, word: Word) -> Result<(), Fault> {
        let at = word.at.clone();
        let name = char::from(word.letter);
        match word.letter {
            b'G' => return self.g_code(word),
            b'M' => return self.m_code(word),
            b'D' | b'F' | b'H' | b'I' | b'J' | b'K' | b'L' | b'N' | b'P' | b'Q' | b'R' | b'S' | b'T' | b'X' | b'Y'
            | b'Z' => {}
            b'A' | b'B' | b'C' | b'U' | b'V' | b'W' => {
                return Err(Fault::new(Code::BadWord, at, format!("this machine has no axis {name}"))
                    .help("it has X, Y and Z: take the word out, or the moves of that axis"));
            }
            b'E' => {
                return Err(Fault::new(Code::BadWord, at, "E (an extruder, or an exponent) is not read")
                    .help("take the word out; numbers are written out, 0.001 for 1e-3"));
            }
            _ => return Err(Fault::new(Code::BadWord, at, format!("there is no word {name}")).help(advice(-1))),
        }
        let place = &mut self.words[usize::from(word.letter - b'A')];
        if let Some(first) = place {
            let first = first.at.start + 1;
            return Err(Fault::new(Code::BadBlock, at, format!("a second {name} in one block"))
                .label(format!("the first is at column {first}"))
                .help("take one of them out"));
        }
        *place = Some(word);
        Ok(())
    }

    fn g_code(&mut self, word: Word) -> Result<(), Fault> {
        let code = word.value.times(Decimal::whole(10)).and_then(Decimal::to_whole);
        let Some((code, group)) = code.and_then(|code| group(code).map(|group| (code, group))) else {
            return Err(Fault::new(Code::BadWord, word.at, format!("G{} is not read here", word.value))
                .help(advice(code.unwrap_or(-1))));
        };
        let place = &mut self.g[group as usize];
        if let Some(first) = place {
            let message = format!("{} and {} in one block", g_name(first.code), g_name(code));
            return Err(Fault::new(Code::BadBlock, word.at, message)
                .label(format!("the first is at column {}", first.at.start + 1))
                .help("they belong to one group: write them in two blocks, or take one out"));
        }
        *place = Some(GCode { code, at: word.at });
        Ok(())
    }

    fn m_code(&mut self, word: Word) -> Result<(), Fault> {
        match word.value.to_whole() {
            Some(code @ (0..=9 | 30)) => {
                if self.m.iter().any(|m| m.0 == code) {
                    return Err(Fault::new(Code::BadBlock, word.at, format!("a second M{code} in one block"))
                        .help("take one of them out"));
                }
                self.m.push((code, word.at));
                Ok(())
            }
            _ => Err(Fault::new(Code::BadWord, word.at, format!("M{} is not read here", word.value))
                .help("M0 to M9 and M30 are; take the word out if it does not move an axis")),
        }
    }

    /// The code of a group, if the block has one.
    #[must_use]
    pub fn g(&self, group: Group) -> Option<&GCode> {
        self.g[group as usize].as_ref()
    }

    /// Whether the block has an M code.
    #[must_use]
    pub fn m(&self, code: i64) -> bool {
        self.m.iter().any(|m| m.0 == code)
    }

    /// The word of a letter, if the block has one.
    #[must_use]
    pub fn get(&self, letter: u8) -> Option<&Word> {
        self.words[usize::from(letter - b'A')].as_ref()
    }

    /// The first word of some letters.
    #[must_use]
    pub fn first(&self, letters: &[u8]) -> Option<&Word> {
        letters.iter().filter_map(|&l| self.get(l)).min_by_key(|w| w.at.start)
    }

    /// Whether the block has X, Y or Z.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.first(b"XYZ").is_some()
    }

    /// The parameters that the block sets, once all else of it has been read.
    pub fn assign(&self, parameters: &mut Parameters) {
        for (name, value) in &self.assignments {
            parameters.set(name.clone(), *value);
        }
    }

    /// Refuses words that no code of the block uses.
    ///
    /// # Errors
    /// The first such word.
    pub fn check(&self, motion: i64) -> Result<(), Fault> {
        let once = self.g(Group::Once).map_or(-1, |g| g.code);
        let arc = matches!(motion, 20 | 30);
        let path = self.g(Group::Path).is_some_and(|g| g.code == 640);
        let length = self.g(Group::Length).is_some_and(|g| g.code == 430);
        let uses = [
            (b'I', arc, "an arc"),
            (b'J', arc, "an arc"),
            (b'K', arc, "an arc"),
            (b'R', arc, "an arc"),
            (b'P', arc || path || matches!(once, 40 | 100), "an arc, G4, G10 or G64"),
            (b'Q', path, "G64"),
            (b'L', once == 100, "G10"),
            (b'H', length, "G43"),
            (b'D', false, "G41 or G42"),
        ];
        for (letter, used, by) in uses {
            if let Some(word) = self.get(letter).filter(|_| !used) {
                let name = char::from(letter);
                return Err(Fault::new(Code::BadBlock, word.at.clone(), format!("nothing in this block uses {name}"))
                    .help(format!("{name} goes with {by}: take it out, or write the code that it is for")));
            }
        }
        Ok(())
    }
}

/// A code as it is written: `G92.1` for 921.
#[must_use]
pub fn g_name(code: i64) -> String {
    if code % 10 == 0 { format!("G{}", code / 10) } else { format!("G{}.{}", code / 10, code % 10) }
}

impl Block {
    /// What a fault of the whole block points at: from its first word of motion to its last word of any axis.
    #[must_use]
    pub fn place(&self) -> Range<usize> {
        let words = b"XYZIJKRP".iter().filter_map(|&l| self.get(l)).map(|w| w.at.clone());
        let motion = self.g(Group::Motion).map(|g| g.at.clone());
        let mut all = words.chain(motion);
        let first = all.next().unwrap_or(0..1);
        all.fold(first, |a, b| a.start.min(b.start)..a.end.max(b.end))
    }
}
