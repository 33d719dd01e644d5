//! `--dump`: what memories hold at the end of a run, as `$readmemh` reads it.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::CliError;
use super::args::Assignment;
use crate::cell::{CellKind, Memory};
use crate::netlist::{CellId, Netlist};
use crate::value::Word;
use crate::wave::output::{Destination as _, Output};
use crate::{Logic, Value};

/// The memories that are asked for.
///
/// # Errors
/// One that the circuit does not have.
pub(super) fn memories(netlist: &Netlist, asked: &[Assignment]) -> Result<Vec<CellId>, CliError> {
    let all = || netlist.cell_ids().filter(|&cell| matches!(netlist.cell(cell).kind, CellKind::Memory(_)));
    let find = |asked: &Assignment| {
        let name = asked.name.trim_start_matches('\\');
        all().find(|&cell| netlist.cell_path(cell) == name).ok_or_else(|| {
            let names: Vec<String> = all().map(|cell| netlist.cell_path(cell)).collect();
            let hint = if names.is_empty() { "it has none".to_owned() } else { format!("it has {}", names.join(", ")) };
            CliError::usage(format!("the circuit has no memory `{name}`")).with_hint(hint)
        })
    };
    asked.iter().map(find).collect()
}

/// Writes the words of a memory to a file.
///
/// # Errors
/// It cannot be written.
pub(super) fn write(netlist: &Netlist, cell: CellId, contents: Option<&[Word]>, path: &Path) -> Result<(), CliError> {
    let CellKind::Memory(m) = &netlist.cell(cell).kind else { return Ok(()) };
    let name = netlist.cell_path(cell);
    let Some(contents) = contents else {
        return Err(CliError::usage(format!("nothing reads memory `{name}`, so it is not simulated")));
    };
    let mut text = format!("// {name}: {} words of {} bits\n", m.size, m.width);
    if m.offset != 0 {
        let _ = writeln!(text, "@{:x}", m.offset);
    }
    for index in 0..m.size {
        let _ = writeln!(text, "{}", hex(&Memory::word(m.width, contents, index)));
    }
    let mut to = Output::create(path)?;
    to.write_all(text.as_bytes())?;
    to.complete()?;
    Ok(())
}

/// Hex digits of a value; one with bits that are x or z is x or z as a whole, which is as exact as digits can be.
fn hex(value: &Value) -> String {
    let digit = |lo: u32| {
        let bits: Vec<Logic> = (lo..(lo + 4).min(value.width())).map(|bit| value.bit(bit)).collect();
        if bits.contains(&Logic::X) || bits.contains(&Logic::Z) && bits.iter().any(|b| *b != Logic::Z) {
            return 'x';
        }
        if bits.contains(&Logic::Z) {
            return 'z';
        }
        let number = bits.iter().enumerate().filter(|(_, bit)| **bit == Logic::One).map(|(i, _)| 1 << i).sum();
        char::from_digit(number, 16).unwrap_or('x')
    };
    (0..value.width()).step_by(4).rev().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_readmemh() {
        let of = |text: &str| hex(&text.parse::<Value>().unwrap());
        assert_eq!(of("8'ha5"), "a5");
        assert_eq!(of("9'h1a5"), "1a5");
        assert_eq!(of("8'b1x10zzzz"), "xz");
        assert_eq!(of("65'h1000000000000000f"), "1000000000000000f");
        assert_eq!(of("3'b101"), "5");
    }
}
