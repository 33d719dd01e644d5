//! The modes that a program sets, and what its blocks mean in them. The order of what a block does is LinuxCNC's.

use std::ops::Range;

use super::arc::{Request, Tolerance};
use super::block::{Block, Group, g_name};
use super::canon::{Canon, Feed, Move, Path, Plane, Units};
use super::decimal::Decimal;
use super::fault::Fault;
use crate::diag::Code;

type Point = [Decimal; 3];

/// The names of the axes, as words.
const AXES: [u8; 3] = *b"XYZ";

/// The state of the machine as the program sees it.
#[derive(Clone, Debug)]
pub struct Modes {
    units: Units,
    plane: Plane,
    incremental: bool,
    absolute_centers: bool,
    inverse: bool,
    /// Ten times the number of the G code; none after G80.
    motion: Option<i64>,
    /// Millimetres a minute; none before the first F.
    feed: Option<Decimal>,
    /// In machine coordinates, mm.
    position: Point,
    systems: [Point; 9],
    system: usize,
    g92: Point,
    /// What G92.3 brings back.
    g92_kept: Point,
    tolerance: Tolerance,
    /// A block before could not be done, so that nobody knows where the machine would be.
    lost: bool,
}

impl Modes {
    /// As a program begins: millimetres, XY, absolute, G54, no motion mode, at the machine's origin.
    #[must_use]
    pub const fn new(tolerance: Tolerance) -> Modes {
        Modes {
            units: Units::Millimetres,
            plane: Plane::Xy,
            incremental: false,
            absolute_centers: false,
            inverse: false,
            motion: None,
            feed: None,
            position: [Decimal::ZERO; 3],
            systems: [[Decimal::ZERO; 3]; 9],
            system: 0,
            g92: [Decimal::ZERO; 3],
            g92_kept: [Decimal::ZERO; 3],
            tolerance,
            lost: false,
        }
    }

    /// A block could not be read: what depends on the position is not judged any more.
    pub const fn lose(&mut self) {
        self.lost = true;
    }

    /// Whether a block before could not be read or done.
    #[must_use]
    pub const fn is_lost(&self) -> bool {
        self.lost
    }

    fn origin(&self) -> Point {
        [0, 1, 2].map(|a| self.systems[self.system][a] + self.g92[a])
    }

    /// Does a block: what happens goes to `to` in its order, what other controls may see in another way to `warnings`.
    ///
    /// # Errors
    /// A block that contradicts itself or lacks a word. Whether the rest of the program goes on from there is told by
    /// [`is_lost`](Modes::is_lost).
    pub fn execute(&mut self, block: &Block, to: &mut Vec<Canon>, warnings: &mut Vec<Fault>) -> Result<(), Fault> {
        let motion = self.motion_of(block)?;
        block.check(motion.unwrap_or(-1))?;
        let before = self.units;
        if let Some(g) = block.g(Group::Units) {
            self.units = if g.code == 200 { Units::Inches } else { Units::Millimetres };
        }
        self.feed_words(block, before, to, warnings)?;
        if let Some(g) = block.g(Group::Once).filter(|g| g.code == 40) {
            to.push(Canon::Dwell(dwell(block, g.at.clone())?));
        }
        if let Some(g) = block.g(Group::Plane) {
            self.plane = [Plane::Xy, Plane::Xz, Plane::Yz][((g.code - 170) / 10) as usize];
            to.push(Canon::Plane(self.plane));
        }
        if block.g(Group::Units).is_some() {
            to.push(Canon::Units(self.units));
        }
        if let Some(g) = block.g(Group::Length).filter(|g| g.code == 430) {
            warnings.push(
                Fault::new(Code::DoubtfulBlock, g.at.clone(), "G43 has no effect: every tool has the length 0 here")
                    .help("the path is that of the tool's tip"),
            );
        }
        if let Some(g) = block.g(Group::System) {
            let system = system_of(g.code);
            if system != self.system {
                self.system = system;
                self.tell_system(to);
                to.push(Canon::Offset(self.g92, self.units));
            }
        }
        if let Some(g) = block.g(Group::Distance) {
            self.incremental = g.code == 910;
        }
        if let Some(g) = block.g(Group::Centers) {
            self.absolute_centers = g.code == 901;
        }
        match block.g(Group::Once).map(|g| (g.code, g.at.clone())) {
            Some((100, at)) => self.set_system(block, at, to)?,
            Some((280 | 300, _)) => self.home(block, to),
            Some((code @ 920..=923, at)) => self.offset(block, code, at, to)?,
            _ => {}
        }
        match motion {
            Some(code) => self.go(block, code, to, warnings),
            None => Ok(()),
        }?;
        if let Some(g) = block.g(Group::Motion) {
            self.motion = (g.code != 800).then_some(g.code);
        }
        for code in [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 30] {
            if block.m(code) {
                to.push(Canon::Recorded(code));
            }
        }
        Ok(())
    }

    /// The motion that the block is for, if it is for one.
    fn motion_of(&self, block: &Block) -> Result<Option<i64>, Fault> {
        let once = block.g(Group::Once).filter(|g| matches!(g.code, 100 | 280 | 300 | 920));
        let given = block.g(Group::Motion);
        if let Some(word) = block.first(b"XYZ") {
            match (once, given) {
                (Some(once), Some(given)) if given.code != 800 => {
                    let message = format!("X, Y and Z are for {} or for {}", g_name(once.code), g_name(given.code));
                    return Err(Fault::new(Code::BadBlock, given.at.clone(), message).help("write two blocks"));
                }
                (None, Some(given)) if given.code == 800 => {
                    return Err(Fault::new(
                        Code::BadBlock,
                        word.at.clone(),
                        "G80 ends the motion mode: nothing moves here",
                    )
                    .help("take G80 out, or write the move in a block of its own with G0 or G1"));
                }
                (None, None) if self.motion.is_none() => {
                    return Err(Fault::new(Code::BadBlock, word.at.clone(), "nothing says how to move there")
                        .help("write G0, G1, G2 or G3 in this block or in one before"));
                }
                _ => {}
            }
        }
        let motion = match (once, given) {
            (Some(_), _) => None,
            (None, Some(given)) => (given.code != 800).then_some(given.code),
            // a full circle needs no end point
            (None, None) if block.moves() || block.first(b"IJK").is_some() => self.motion,
            (None, None) => None,
        };
        if let Some(g) = block.g(Group::Absolute) {
            let at = g.at.clone();
            if !matches!(motion, Some(0 | 10)) {
                return Err(
                    Fault::new(Code::BadBlock, at, "G53 goes with G0 or G1").help("write G53 G0 X… in one block")
                );
            }
            let incremental = block.g(Group::Distance).map_or(self.incremental, |g| g.code == 910);
            if incremental {
                return Err(Fault::new(Code::BadBlock, at, "G53 in incremental distances (G91)")
                    .help("machine coordinates are absolute: write G90 before"));
            }
        }
        Ok(motion)
    }

    fn feed_words(
        &mut self,
        block: &Block,
        before: Units,
        to: &mut Vec<Canon>,
        warnings: &mut Vec<Fault>,
    ) -> Result<(), Fault> {
        if let Some(g) = block.g(Group::FeedMode) {
            let inverse = g.code == 930;
            if inverse != self.inverse {
                // the number of one mode means nothing in the other
                self.feed = None;
            }
            self.inverse = inverse;
        }
        let Some(f) = block.get(b'F') else { return Ok(()) };
        if f.value.signum() < 0 {
            return Err(Fault::new(Code::BadBlock, f.at.clone(), format!("a feed of {}", f.value))
                .help("a feed is above 0; the direction comes from the end point"));
        }
        if self.inverse {
            return Ok(());
        }
        if before != self.units {
            warnings.push(
                Fault::new(Code::DoubtfulBlock, f.at.clone(), "F stands in the block that changes the unit")
                    .help("it is taken in the new one here; LinuxCNC takes it in the old one: write G20 or G21 before"),
            );
        }
        to.push(Canon::Feed(f.value));
        self.feed = Some(self.units.to_mm(f.value)).filter(|f| f.signum() > 0);
        Ok(())
    }

    fn tell_system(&self, to: &mut Vec<Canon>) {
        to.push(Canon::System(self.system + 1, self.systems[self.system], self.units));
    }

    /// A word of an axis, mm.
    fn word(&self, block: &Block, axis: usize) -> Option<Decimal> {
        block.get(AXES[axis]).map(|w| self.units.to_mm(w.value))
    }

    /// G10 L2: the origin of a coordinate system. G10 L20: so that the machine stands at this point of it.
    fn set_system(&mut self, block: &Block, at: Range<usize>, to: &mut Vec<Canon>) -> Result<(), Fault> {
        let place = |word: u8| block.get(word).map_or(at.clone(), |w| w.at.clone());
        let here = match block.get(b'L').and_then(|w| w.value.to_whole()) {
            Some(2) => false,
            Some(20) => true,
            _ => {
                return Err(Fault::new(Code::BadBlock, place(b'L'), "G10 is read with L2 or L20")
                    .help("L1, L10 and L11 set tools, which have no measures here"));
            }
        };
        let system = match block.get(b'P').and_then(|w| w.value.to_whole()) {
            Some(0) => self.system,
            Some(n @ 1..=9) => (n - 1) as usize,
            _ => {
                return Err(Fault::new(Code::BadBlock, place(b'P'), "G10 names a coordinate system with P1 to P9")
                    .help("P1 is G54; P0 is the present one"));
            }
        };
        for axis in 0..3 {
            if let Some(v) = self.word(block, axis) {
                self.systems[system][axis] = if here { self.position[axis] - self.g92[axis] - v } else { v };
            }
        }
        if system == self.system {
            self.tell_system(to);
        }
        Ok(())
    }

    /// G28, G30: by way of the point given to the machine's origin, those axes that are named, or else all.
    fn home(&mut self, block: &Block, to: &mut Vec<Canon>) {
        let named = block.moves();
        let by = self.target(block, false);
        self.push(by, Path::Line, Feed::Rapid, to);
        let home = [0, 1, 2].map(|a| if !named || self.word(block, a).is_some() { Decimal::ZERO } else { by[a] });
        self.push(home, Path::Line, Feed::Rapid, to);
    }

    fn offset(&mut self, block: &Block, code: i64, at: Range<usize>, to: &mut Vec<Canon>) -> Result<(), Fault> {
        match code {
            920 => {
                if !block.moves() {
                    return Err(Fault::new(Code::BadBlock, at, "G92 without X, Y or Z")
                        .help("give the coordinates that the present position shall have; G92.1 clears the offset"));
                }
                for axis in 0..3 {
                    if let Some(v) = self.word(block, axis) {
                        self.g92[axis] = self.position[axis] - self.systems[self.system][axis] - v;
                    }
                }
                self.g92_kept = self.g92;
            }
            921 => (self.g92, self.g92_kept) = ([Decimal::ZERO; 3], [Decimal::ZERO; 3]),
            922 => self.g92 = [Decimal::ZERO; 3],
            _ => self.g92 = self.g92_kept,
        }
        to.push(Canon::Offset(self.g92, self.units));
        Ok(())
    }

    /// Where the block's X, Y and Z are.
    fn target(&self, block: &Block, machine: bool) -> Point {
        let origin = self.origin();
        [0, 1, 2].map(|axis| match self.word(block, axis) {
            Some(v) if machine => v,
            Some(v) if self.incremental => self.position[axis] + v,
            Some(v) => origin[axis] + v,
            None => self.position[axis],
        })
    }

    fn push(&mut self, target: Point, path: Path, feed: Feed, to: &mut Vec<Canon>) {
        let step = Move { from: self.position, to: target, path, feed, origin: self.origin(), units: self.units };
        self.position = target;
        to.push(Canon::Move(step));
    }

    fn go(&mut self, block: &Block, code: i64, to: &mut Vec<Canon>, warnings: &mut Vec<Fault>) -> Result<(), Fault> {
        let target = self.target(block, block.g(Group::Absolute).is_some());
        let arc = matches!(code, 20 | 30);
        // a G0 or G1 alone sets the mode
        if !arc && !block.moves() {
            return Ok(());
        }
        let feed = match (code, self.inverse, block.get(b'F')) {
            (0, ..) => Feed::Rapid,
            (_, true, Some(f)) if f.value.signum() > 0 => Feed::Inverse(f.value),
            (_, true, _) => {
                self.position = target;
                return Err(Fault::new(Code::BadBlock, block.place(), "a move in inverse time (G93) without F")
                    .help("in G93 every move has its own F: 60 divided by its seconds"));
            }
            (_, false, _) => match self.feed {
                Some(feed) => Feed::PerMinute(feed),
                None if self.lost => Feed::Rapid,
                None => {
                    self.position = target;
                    return Err(Fault::new(Code::BadBlock, block.place(), format!("{} without a feed", g_name(code)))
                        .help("write F, above 0, in this block or in one before"));
                }
            },
        };
        let path = if arc {
            let request = Request {
                block,
                from: self.position,
                to: target,
                plane: self.plane,
                absolute: self.absolute_centers.then(|| self.origin()),
                units: self.units,
                clockwise: code == 20,
                tolerance: self.tolerance,
            };
            match request.arc(warnings) {
                Ok(arc) => Path::Arc(arc),
                Err(fault) => {
                    self.position = target;
                    return Err(fault);
                }
            }
        } else {
            Path::Line
        };
        self.push(target, path, feed, to);
        Ok(())
    }
}

/// The coordinate system of G54 to G59.3, from 0.
fn system_of(code: i64) -> usize {
    (if code <= 590 { (code - 540) / 10 } else { code - 590 + 5 }) as usize
}

/// The seconds of G4.
fn dwell(block: &Block, at: Range<usize>) -> Result<Decimal, Fault> {
    match block.get(b'P') {
        Some(p) if p.value.signum() >= 0 => Ok(p.value),
        Some(p) => {
            Err(Fault::new(Code::BadBlock, p.at.clone(), "a dwell of negative time").help("P is in seconds, 0 or more"))
        }
        None => Err(Fault::new(Code::BadBlock, at, "G4 without its time").help("write P and the seconds: G4 P0.5")),
    }
}
