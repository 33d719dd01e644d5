//! A command file of Surfer: `surfer run.vcd --command-file run.sucl`, or File → Run command file.
//!
//! Each line is a command as it can be typed behind the space bar (Surfer's documentation, "Commands"). There is none that
//! draws a curve; the steps of coordinates are chosen by hand (Analog → Step).

use std::fmt::Write as _;

use super::{Shown, View};

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
            if let Some(format) = format(signal) {
                let place = place(number, items.len());
                let _ = writeln!(text, "item_focus {place}_{}\nitem_set_format {format}", signal.path());
            }
        }
        text += "item_unfocus\nzoom_fit\n";
        text
    }
}

/// How numbers are written, where it is not Surfer's own choice (hexadecimal).
fn format(signal: &Shown) -> Option<&'static str> {
    match signal.width {
        1 => None,
        _ if signal.signed => Some("Signed"),
        2..=16 => Some("Unsigned"),
        _ if signal.steps => Some("Unsigned"),
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
    use crate::wave::save::tests::example;

    #[test]
    fn a_command_file() {
        let expected = "# surfer run.vcd --command-file …\nitem_unfocus\n\
            variable_add top.clk\nvariable_add top.rst\nvariable_add top.q\nvariable_add top.f\nvariable_add top.xt\n\
            variable_add top.wide\ndivider_add u\nvariable_add top.u.a\ndivider_add u.v\nvariable_add top.u.v.b\n\
            item_focus c_top.q\nitem_set_format Unsigned\nitem_focus d_top.f\nitem_set_format Signed\n\
            item_focus e_top.xt\nitem_set_format Unsigned\nitem_focus j_top.u.v.b\nitem_set_format Unsigned\n\
            item_unfocus\nzoom_fit\n";
        assert_eq!(example().surfer(), expected);
        // 0x1a and 5 of some 300
        assert_eq!([place(0x1a, 300), place(5, 300), place(15, 15)], ["abk", "aaf", "p"]);
    }
}
