//! A command file of Surfer: `surfer run.vcd --command-file run.sucl`, or File → Run command file.
//!
//! Each line is a command as it can be typed behind the space bar (Surfer's documentation, "Commands"). There is none that
//! draws a curve; the steps of coordinates are chosen by hand (Analog → Step).

use std::fmt::Write as _;

use super::{Shown, View};
use crate::value::ValueNames;

impl View {
    /// The command file.
    #[must_use]
    pub fn surfer(&self) -> String {
        let mut text = format!("# surfer {} --command-file …\n", self.waveform);
        // what is added stands behind the focus, or at the end if nothing has it
        text += "item_unfocus\n";
        let mut items: Vec<Option<&Shown>> = Vec::new();
        let mut scope: &[String] = &[];
        for signal in &self.signals {
            if signal.scopes != scope {
                scope = &signal.scopes;
                if scope.len() > 1 {
                    let _ = writeln!(text, "divider_add {}", scope[1..].join("."));
                    items.push(None);
                }
            }
            let _ = writeln!(text, "variable_add {}", signal.path());
            items.push(Some(signal));
        }
        for (number, signal) in items.iter().enumerate().filter_map(|(n, s)| Some((n, (*s)?))) {
            if let Some(format) = self.names_of(signal).map(|n| self.mapping(n)).or_else(|| format(signal)) {
                let place = place(number, items.len());
                let _ = writeln!(text, "item_focus {place}_{}\nitem_set_format {format}", signal.path());
            }
        }
        text += "item_unfocus\nzoom_fit\n";
        text
    }

    /// The name of a mapping: that of its file.
    fn mapping(&self, name: &str) -> String {
        format!("{}_{name}", self.stem())
    }

    /// The mappings of values to names that the command file uses: files, which belong into `.surfer/mappings/` of the
    /// folder where Surfer is begun, and what is in them (Surfer's documentation, "Mapping Translators").
    #[must_use]
    pub fn surfer_mappings(&self) -> Vec<(String, String)> {
        let text = |names: &ValueNames| {
            let width = names.iter().next().map_or(0, |(value, _)| value.width());
            let lines: String = names.iter().map(|(v, name)| format!("0b{} {name}\n", v.bit_string())).collect();
            format!("Bits = {width}\n{lines}")
        };
        self.names.iter().map(|(name, names)| (format!("{}.txt", self.mapping(name)), text(names))).collect()
    }
}

/// How numbers are written, where it is not Surfer's own choice (hexadecimal).
fn format(signal: &Shown) -> Option<String> {
    match signal.width {
        1 => None,
        _ if signal.signed => Some("Signed".to_owned()),
        2..=16 => Some("Unsigned".to_owned()),
        _ if signal.steps => Some("Unsigned".to_owned()),
        _ => None,
    }
}

/// The number of an item as Surfer writes it: hexadecimal with the digits a to p, as many as the number of items needs.
fn place(number: usize, items: usize) -> String {
    let digits = items.max(1).ilog(16) as usize + 1;
    (0..digits).rev().map(|digit| (b'a' + (number >> (4 * digit) & 15) as u8) as char).collect()
}

#[cfg(test)]
mod tests {
    use super::place;
    use crate::save::tests::example;

    #[test]
    fn a_command_file() {
        let expected = "# surfer run.vcd --command-file …\nitem_unfocus\n\
            variable_add top.clk\nvariable_add top.rst\nvariable_add top.state\nvariable_add top.q\nvariable_add top.f\nvariable_add top.xt\n\
            variable_add top.wide\ndivider_add u\nvariable_add top.u.a\ndivider_add u.v\nvariable_add top.u.v.b\n\
            item_focus c_top.state\nitem_set_format run_state\nitem_focus d_top.q\nitem_set_format Unsigned\n\
            item_focus e_top.f\nitem_set_format Signed\nitem_focus f_top.xt\nitem_set_format Unsigned\n\
            item_focus k_top.u.v.b\nitem_set_format Unsigned\n\
            item_unfocus\nzoom_fit\n";
        assert_eq!(example().surfer(), expected);
        let mapping = "Bits = 2\n0b00 idle\n0b01 load it\n0bzz free\n";
        assert_eq!(example().surfer_mappings(), [("run_state.txt".into(), mapping.into())]);
        // 0x1a and 5 of some 300
        assert_eq!([place(0x1a, 300), place(5, 300), place(15, 15)], ["abk", "aaf", "p"]);
    }
}
