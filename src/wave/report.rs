//! A [`Difference`] as text for people.

use std::fmt;

use super::diff::{Context, Difference, List};
use crate::Timescale;

/// Bits that are shown one by one; more become hexadecimal digits where that loses nothing.
const MAX_BITS: usize = 16;
/// Characters of one value.
const MAX_TEXT: usize = 40;

/// No column is made wider for one long name.
const MOST_WIDE: usize = 200;

impl fmt::Display for Difference {
    /// The report: where the first difference is, what was around it, then every list.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let time = |ticks| time(self.timescale, ticks);
        if self.same {
            let end = self.a.end.min(self.b.end);
            return writeln!(f, "The same: {} until {}.", count(self.compared, "signal"), time(end));
        }
        let wide = self.a.name.chars().count().max(self.b.name.chars().count()).min(MOST_WIDE);
        writeln!(f, "a  {:wide$}  ends at {}", self.a.name, time(self.a.end))?;
        writeln!(f, "b  {:wide$}  ends at {}", self.b.name, time(self.b.end))?;

        if let (Some(first), Some(context)) = (self.first, &self.context) {
            write!(f, "\nFirst difference at {}: {}", time(first), context.signal)?;
            if let (Some(clock), Some(edges)) = (&context.clock, context.clock_edges) {
                match edges {
                    0 => write!(f, " (before any rising edge of {clock})")?,
                    n => write!(f, " (after {} of {clock})", count(n as usize, "rising edge"))?,
                }
            }
            writeln!(f, "\n")?;
            self.context(f, first, context)?;
            writeln!(f, "\n{} of {} differ:", self.differing, count(self.compared, "signal"))?;
            let rows = self
                .signals
                .iter()
                .map(|signal| vec![time(signal.time), signal.name.clone(), value(&signal.a), value(&signal.b)]);
            table(f, &["time", "signal", "a", "b"], rows.collect(), None)?;
            more(f, self.differing, self.signals.len())?;
        }
        if self.kinds.count > 0 {
            writeln!(f, "\n{} not compared, not of one kind:", count(self.kinds.count, "signal"))?;
            let rows = self.kinds.first.iter().map(|kind| vec![kind.name.clone(), kind.a.clone(), kind.b.clone()]);
            table(f, &["signal", "a", "b"], rows.collect(), None)?;
            more(f, self.kinds.count, self.kinds.first.len())?;
        }
        only(f, "a", &self.only_a)?;
        only(f, "b", &self.only_b)?;
        if self.ends_differ {
            let (short, end) = if self.a.end < self.b.end { ("a", self.a.end) } else { ("b", self.b.end) };
            writeln!(f, "\nThey end at different times; compared until {}, where {short} ends.", time(end))?;
        }
        if self.compared == 0 {
            writeln!(f, "\nNo signal was compared.")?;
        }
        Ok(())
    }
}

impl Difference {
    fn context(&self, f: &mut fmt::Formatter<'_>, first: u64, context: &Context) -> fmt::Result {
        let mut head = vec!["time"];
        head.extend(context.clock.as_deref());
        head.extend(["a", "b"]);
        let rows = context.rows.iter().map(|row| {
            let mut cells = vec![time(self.timescale, row.time)];
            cells.extend(row.clock.clone());
            cells.extend([value(&row.a), value(&row.b)]);
            cells
        });
        let marked = context.rows.iter().position(|row| row.time == first);
        table(f, &head, rows.collect(), marked)
    }
}

fn only(f: &mut fmt::Formatter<'_>, side: &str, list: &List<String>) -> fmt::Result {
    if list.count > 0 {
        writeln!(f, "\n{} only in {side}:", count(list.count, "signal"))?;
        for name in &list.first {
            writeln!(f, "    {name}")?;
        }
        more(f, list.count, list.first.len())?;
    }
    Ok(())
}

fn more(f: &mut fmt::Formatter<'_>, count: usize, shown: usize) -> fmt::Result {
    if count > shown { writeln!(f, "    … and {} more", count - shown) } else { Ok(()) }
}

fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

fn time(timescale: Option<Timescale>, ticks: u64) -> String {
    match timescale {
        Some(timescale) => timescale.time(ticks),
        None => format!("tick {ticks}"),
    }
}

/// Columns as wide as what is in them; times stand to the right.
fn table(f: &mut fmt::Formatter<'_>, head: &[&str], rows: Vec<Vec<String>>, marked: Option<usize>) -> fmt::Result {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([head[column].chars().count()]).max().unwrap_or(0).min(MOST_WIDE)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let head: Vec<String> = head.iter().map(|&cell| cell.to_owned()).collect();
    for (i, row) in std::iter::once(&head).chain(&rows).enumerate() {
        let mark = if i > 0 && marked == Some(i - 1) { "  > " } else { "    " };
        let mut line = mark.to_owned();
        for (cell, &width) in row.iter().zip(&widths) {
            let gap = if line.len() > mark.len() { "  " } else { "" };
            let cell = match cell.as_str() {
                "" => "-",
                cell => cell,
            };
            line += gap;
            line += &if head[0] == "time" && gap.is_empty() {
                format!("{cell:>width$}")
            } else {
                format!("{cell:<width$}")
            };
        }
        writeln!(f, "{}", line.trim_end())?;
    }
    Ok(())
}

/// A value as short as it can be without losing anything, with the number it stands for. Other text is kept.
fn value(text: &str) -> String {
    let bits = text.len();
    if bits < 2 || !text.bytes().all(|bit| matches!(bit, b'0' | b'1' | b'x' | b'z')) {
        return shorten(text);
    }
    let short = match hexadecimal(text) {
        Some(digits) if bits > MAX_BITS => shorten(&format!("{bits}'h{digits}")),
        _ => shorten(text),
    };
    match u64::from_str_radix(text, 2) {
        Ok(number) => format!("{short} ({number})"),
        Err(_) => short,
    }
}

/// Four bits a digit; none if a digit would be neither known nor all x or z.
pub(super) fn hexadecimal(bits: &str) -> Option<String> {
    let bits = bits.as_bytes();
    let first = bits.len() % 4;
    let digits = std::iter::once(&bits[..first]).filter(|digit| !digit.is_empty()).chain(bits[first..].chunks(4));
    digits
        .map(|digit| match digit[0] {
            unknown @ (b'x' | b'z') => digit.iter().all(|&bit| bit == unknown).then_some(unknown as char),
            _ => digit
                .iter()
                .try_fold(0, |n, bit| matches!(bit, b'0' | b'1').then(|| n * 2 + u32::from(bit - b'0')))
                .and_then(|n| char::from_digit(n, 16)),
        })
        .collect()
}

/// Without the middle of what is too long.
fn shorten(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    if chars.len() <= MAX_TEXT {
        return text.to_owned();
    }
    let half = MAX_TEXT / 2;
    let [head, tail] = [&chars[..half], &chars[chars.len() - half..]];
    format!("{}…{}", head.iter().collect::<String>(), tail.iter().collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_short_and_exact() {
        assert_eq!(value("1"), "1");
        assert_eq!(value("0101"), "0101 (5)");
        assert_eq!(value("01x1"), "01x1");
        assert_eq!(value("00000000111100001"), "17'h001e1 (481)");
        assert_eq!(value("xzzzz0000111110100"), "xzzzz0000111110100");
        assert_eq!(value("xxzzzz000011111010"), "18'hxz0fa");
        assert_eq!(value(&"1".repeat(64)), format!("64'hffffffffffffffff ({})", u64::MAX));
        assert_eq!(value(&"10".repeat(100)), "200'haaaaaaaaaaaaaaa…aaaaaaaaaaaaaaaaaaaa");
        assert_eq!(value("state_of_the_machine"), "state_of_the_machine");
    }
}
