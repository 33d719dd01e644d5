//! A save file of GTKWave: `gtkwave run.gtkw`, or `gtkwave run.vcd run.gtkw`.
//!
//! The flags of a trace are those of GTKWave's manual, "Save File": each line `@` and a hexadecimal number holds for the
//! names below it.

use std::fmt::Write as _;

use super::{Shown, View};
use crate::value::ValueNames;

const HEX: u32 = 0x2;
const DECIMAL: u32 = 0x4;
const BINARY: u32 = 0x8;
const RIGHT: u32 = 0x20;
const BLANK: u32 = 0x200;
const SIGNED: u32 = 0x400;
const COLLAPSED: u32 = 0x1000;
const TRANSLATED: u32 = 0x2000;
const STEPS: u32 = 0x8000;
const STRETCH: u32 = 0x2_0000;
const CLOSED: u32 = 0x40_0000;
const GROUP: u32 = 0x80_0000;
const GROUP_END: u32 = 0x100_0000;

/// Wider numbers are hexadecimal.
const DECIMAL_BITS: u32 = 16;
/// Rows of a curve besides its own.
const TALL: usize = 3;
/// Columns of pixels that the waves have, at least, in the window that the file asks for.
const PIXELS: f64 = 700.0;
/// Those of a frame: the zoom is the logarithm of the time of one, to base 2 and negated.
const FRAME: f64 = 200.0;

impl View {
    /// The save file.
    #[must_use]
    pub fn gtkwave(&self) -> String {
        let mut text = String::from("[*] made by discreta\n");
        let _ = writeln!(text, "[dumpfile] \"{}\"", self.waveform);
        // GTKWave counts in the unit alone
        let end = self.end as f64 * f64::from(self.timescale.count());
        let zoom = -(end.max(1.0) / PIXELS * FRAME).log2();
        let _ = write!(text, "[timestart] 0\n[size] 1280 800\n[pos] -1 -1\n*{zoom:.6} 0 -1 -1\n");
        for scope in self.trees() {
            let _ = writeln!(text, "[treeopen] {scope}.");
        }
        text += "[sst_width] 180\n[signals_width] 200\n[sst_expanded] 1\n[sst_vpaned_height] 200\n";
        let mut flags = 0;
        let mut open: Vec<&str> = Vec::new();
        for signal in &self.signals {
            // the top scope is no group
            let scopes: Vec<&str> = signal.scopes.iter().skip(1).map(String::as_str).collect();
            let common = open.iter().zip(&scopes).take_while(|(a, b)| a == b).count();
            while open.len() > common {
                self.close(&mut text, &mut flags, &mut open);
            }
            for scope in &scopes[common..] {
                open.push(scope);
                set(&mut text, &mut flags, GROUP | BLANK | if self.is_open(&open) { 0 } else { CLOSED });
                let _ = writeln!(text, "-{scope}");
            }
            set(&mut text, &mut flags, style(signal));
            // the filter stands between the flags and the name, and holds for those behind it too
            if let Some(number) = self.names_of(signal).and_then(|n| self.names.iter().position(|(name, _)| name == n))
            {
                let _ = writeln!(text, "^{} {}", number + 1, self.filter(number));
            }
            let _ = writeln!(text, "{}", named(signal));
            if signal.steps {
                set(&mut text, &mut flags, STRETCH);
                text += &"-\n".repeat(TALL);
            }
        }
        while !open.is_empty() {
            self.close(&mut text, &mut flags, &mut open);
        }
        text += "[pattern_trace] 1\n[pattern_trace] 0\n";
        text
    }

    /// Ends the innermost group.
    fn close(&self, text: &mut String, flags: &mut u32, open: &mut Vec<&str>) {
        let shut = if self.is_open(open) { 0 } else { CLOSED | COLLAPSED };
        set(text, flags, GROUP_END | BLANK | shut);
        let _ = writeln!(text, "-{}", open.pop().unwrap_or_default());
    }

    /// Whether a group is shown open: one right below the top that holds what has names for its values.
    fn is_open(&self, scopes: &[&str]) -> bool {
        let within = |s: &Shown| s.scopes.len() == 2 && scopes == [s.scopes[1].as_str()];
        self.signals.iter().any(|s| within(s) && s.values.is_some())
    }

    /// The file of a translate filter.
    fn filter(&self, number: usize) -> String {
        format!("{}.{}.txt", self.stem(), self.names[number].0)
    }

    /// The translate filters that the save file names: files and what is in them, a value and its name in each line.
    #[must_use]
    pub fn gtkwave_filters(&self) -> Vec<(String, String)> {
        let lines = |names: &ValueNames| names.iter().map(|(v, name)| format!("{} {name}\n", v.bit_string())).collect();
        self.names.iter().enumerate().map(|(number, (_, names))| (self.filter(number), lines(names))).collect()
    }

    /// The top scopes.
    fn trees(&self) -> Vec<&str> {
        let mut trees: Vec<&str> = self.signals.iter().filter_map(|s| s.scopes.first().map(String::as_str)).collect();
        trees.dedup();
        trees
    }
}

fn set(text: &mut String, now: &mut u32, flags: u32) {
    if *now != flags {
        *now = flags;
        let _ = writeln!(text, "@{flags:x}");
    }
}

fn style(signal: &Shown) -> u32 {
    let radix = match signal.width {
        // the filter compares what would be shown
        _ if signal.values.is_some() => BINARY | TRANSLATED,
        1 => BINARY,
        _ if signal.signed => SIGNED,
        2..=DECIMAL_BITS => DECIMAL,
        _ if signal.steps => DECIMAL,
        _ => HEX,
    };
    RIGHT | radix | if signal.steps { STEPS } else { 0 }
}

/// A vector is named with its bits.
fn named(signal: &Shown) -> String {
    match signal.width {
        1 => signal.path(),
        width => format!("{}[{}:0]", signal.path(), width - 1),
    }
}

#[cfg(test)]
mod tests {
    use crate::save::tests::example;

    /// By hand from GTKWave's manual.
    #[test]
    fn a_save_file() {
        let text = example().gtkwave();
        let (head, traces) = text.split_at(text.find("@28").unwrap());
        assert_eq!(
            traces,
            "@28\ntop.clk\ntop.rst\n@2028\n^1 run.state.txt\ntop.state[1:0]\n@24\ntop.q[7:0]\n@420\ntop.f[8:0]\n@8024\ntop.xt[7:0]\n@20000\n-\n-\n-\n\
             @22\ntop.wide[31:0]\n@c00200\n-u\n@28\ntop.u.a\n@c00200\n-v\n@24\ntop.u.v.b[3:0]\n\
             @1401200\n-v\n-u\n[pattern_trace] 1\n[pattern_trace] 0\n"
        );
        assert_eq!(example().gtkwave_filters(), [("run.state.txt".into(), "00 idle\n01 load it\nzz free\n".into())]);
        assert!(head.contains("[dumpfile] \"run.vcd\"\n") && head.contains("[treeopen] top.\n"), "{head}");
        // 1000 ns in 700 pixels: 2^8.1584 ns in 200
        assert!(head.contains("\n*-8.158429 0 -1 -1\n"), "{head}");
    }
}
