//! Two waveforms of one design, net by net and time by time.

use std::collections::BTreeSet;
use std::ops::Range;

use discreta::wave::read::{ValueKind, Waves};

/// What was compared, and what differs.
#[derive(Default)]
pub struct Compared {
    /// Nets that both have.
    pub nets: usize,
    /// How often they change, as Icarus has it.
    pub changes: usize,
    /// At how many times.
    pub times: usize,
    /// How many bits these nets have.
    pub bits: usize,
    /// Bits that nothing drives any more because nothing needs them.
    pub gone: usize,
    /// Values that are the same only because Icarus has x.
    pub free: usize,
    /// Nets that only Icarus has: their paths below the bench.
    pub absent: Vec<String>,
    /// The first differences, one a net.
    pub differences: Vec<Difference>,
    /// Nets that differ before the time from which on they are compared.
    pub before: usize,
}

#[derive(Debug)]
#[allow(dead_code)] // to be shown
pub struct Difference {
    pub time: u64,
    pub net: String,
    pub icarus: String,
    pub discreta: String,
}

/// Every time at which one of two nets changes, with the value of each then.
fn merged<'a>(one: &'a [(u64, String)], other: &'a [(u64, String)]) -> Vec<(u64, &'a str, &'a str)> {
    let mut times: Vec<u64> = one.iter().chain(other).map(|c| c.0).collect();
    times.sort_unstable();
    times.dedup();
    let (mut a, mut b) = (one.iter().peekable(), other.iter().peekable());
    let (mut of_one, mut of_other) = ("", "");
    times
        .into_iter()
        .map(|time| {
            while let Some((_, value)) = a.next_if(|c| c.0 == time) {
                of_one = value;
            }
            while let Some((_, value)) = b.next_if(|c| c.0 == time) {
                of_other = value;
            }
            (time, of_one, of_other)
        })
        .collect()
}

/// When two waveforms are the same.
pub struct Rules<'a> {
    /// When they are compared.
    pub over: Range<u64>,
    /// Synthesis may take the driver of a bit away that nothing reads, or put x in its place; such bits are z or x
    /// throughout, and counted. Not of these ports of the top module.
    pub may_lose: Option<&'a [String]>,
    /// States that synthesis encodes as it likes: not compared.
    pub recoded: &'a [&'a str],
    /// A bit that is x in Icarus agrees with anything; counted.
    pub x_is_free: bool,
}

/// Compares all nets that both have, by their paths, at every tick.
pub fn compare(icarus: &mut Waves, ours: &mut Waves, rules: &Rules) -> Compared {
    let Rules { over, may_lose, recoded, x_is_free } = rules;
    let mut told = Compared::default();
    let mut times = BTreeSet::new();
    let vars: Vec<(usize, String)> = icarus.vars().iter().map(|v| v.name.clone()).enumerate().collect();
    for (at, name) in vars {
        let Some(path) = name.strip_prefix("bench.") else { continue };
        let Some(our_at) = ours.find(path).filter(|_| !recoded.contains(&path)) else {
            told.absent.push(path.to_owned());
            continue;
        };
        let ValueKind::Bits(width) = ours.vars()[our_at].kind else { panic!("{path} has no bits") };
        let ValueKind::Bits(theirs_width) = icarus.vars()[at].kind else { panic!("{path} has no bits") };
        assert!(width <= theirs_width, "{path}");
        let theirs: Vec<(u64, String)> = icarus.load(at).unwrap().changes().collect();
        // `wreduce` takes high bits off that nothing reads
        let narrower = "z".repeat((theirs_width - width) as usize);
        let ours: Vec<(u64, String)> =
            ours.load(our_at).unwrap().changes().map(|(t, v)| (t, format!("{narrower}{v}"))).collect();
        told.nets += 1;
        told.bits += theirs_width as usize;

        let mut gone = vec![false; theirs_width as usize];
        gone[..narrower.len()].fill(true);
        told.gone += narrower.len();
        let is_port = |ports: &[String]| path.split_once('.').is_some_and(|(_, net)| ports.iter().any(|p| p == net));
        if may_lose.is_some_and(|ports| !is_port(ports)) {
            let all = |list: &[(u64, String)], bit: usize, is: u8| list.iter().all(|(_, v)| v.as_bytes()[bit] == is);
            for (bit, gone) in gone.iter_mut().enumerate() {
                *gone |= [b'x', b'z'].iter().any(|is| all(&ours, bit, *is) && !all(&theirs, bit, *is));
            }
            told.gone += gone.iter().filter(|g| **g).count() - narrower.len();
        }
        let bits_differ = |a: &str, b: &str, free: bool| {
            a.bytes().zip(b.bytes()).zip(&gone).any(|((a, b), gone)| a != b && !gone && !(free && a == b'x'))
        };
        let differs = |(_, a, b): &(u64, &str, &str)| a.len() != b.len() || bits_differ(a, b, *x_is_free);

        let both = merged(&theirs, &ours);
        let begin = both.partition_point(|m| m.0 <= over.start).saturating_sub(1); // what holds when it begins
        told.before += usize::from(both[..begin].iter().any(differs));
        let compared = &both[begin..both.partition_point(|m| m.0 < over.end)];
        if let Some((time, icarus, discreta)) = compared.iter().find(|m| differs(m)) {
            let (time, icarus, discreta) = ((*time).max(over.start), (*icarus).to_owned(), (*discreta).to_owned());
            told.differences.push(Difference { time, net: path.to_owned(), icarus, discreta });
        }
        told.free += compared.iter().filter(|m| !differs(m) && bits_differ(m.1, m.2, false)).count();
        let changes = theirs.iter().map(|c| c.0).filter(|t| over.contains(t));
        told.changes += changes.clone().count();
        times.extend(changes);
    }
    told.times = times.len();
    told.differences.sort_by_key(|d| d.time);
    told
}
