//! Identifiers: escaped where Verilog needs it, no two alike where it wants them different.

use std::collections::{HashMap, HashSet};

/// What is no name in Verilog or SystemVerilog (IEEE 1364-2005, annex B; IEEE 1800-2017, annex B).
const KEYWORDS: &str = " accept_on alias always always_comb always_ff always_latch and assert assign assume automatic before
begin bind bins binsof bit break buf bufif0 bufif1 byte case casex casez cell chandle checker class clocking cmos config
const constraint context continue cover covergroup coverpoint cross deassign default defparam design disable dist do edge
else end endcase endchecker endclass endclocking endconfig endfunction endgenerate endgroup endinterface endmodule
endpackage endprimitive endprogram endproperty endsequence endspecify endtable endtask enum event eventually expect export
extends extern final first_match for force foreach forever fork forkjoin function generate genvar global highz0 highz1 if
iff ifnone ignore_bins illegal_bins implements implies import incdir include initial inout input inside instance int
integer interconnect interface intersect join join_any join_none large let liblist library local localparam logic longint
macromodule matches medium modport module nand negedge nettype new nexttime nmos nor noshowcancelled not notif0 notif1
null or output package packed parameter pmos posedge primitive priority program property protected pull0 pull1 pulldown
pullup pulsestyle_ondetect pulsestyle_onevent pure rand randc randcase randsequence rcmos real realtime ref reg reject_on
release repeat restrict return rnmos rpmos rtran rtranif0 rtranif1 s_always s_eventually s_nexttime s_until s_until_with
scalared sequence shortint shortreal showcancelled signed small soft solve specify specparam static string strong strong0
strong1 struct super supply0 supply1 sync_accept_on sync_reject_on table tagged task this throughout time timeprecision
timeunit tran tranif0 tranif1 tri tri0 tri1 triand trior trireg type typedef union unique unique0 unsigned until
until_with untyped use uwire var vectored virtual void wait wait_order wand weak weak0 weak1 while wildcard wire with
within wor xnor xor ";

/// A name as Verilog writes it; what is escaped ends with a blank.
pub(super) fn identifier(name: &str) -> String {
    let simple = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '$')
        && !KEYWORDS.split_whitespace().any(|k| k == name);
    if simple {
        return name.to_owned();
    }
    let printable = |c: char| if c.is_ascii_graphic() { c.to_string() } else { format!("_{:x}", u32::from(c)) };
    let name: String = name.chars().map(printable).collect();
    format!("\\{} ", if name.is_empty() { "_" } else { &name })
}

/// The name of a module that Yosys made of one with parameters, as this simulator names such: the module, then each
/// parameter and its value (`$paramod\fifo\W=s32'…1000` is `fifo_W8`). Others stay.
pub(super) fn readable(name: &str) -> String {
    let Some(rest) = name.strip_prefix("$paramod") else { return name.to_owned() };
    // of long lists of parameters there is a hash
    let (hash, rest) = match rest.strip_prefix('$').and_then(|rest| rest.split_once('\\')) {
        Some((hash, rest)) => (Some(hash), rest),
        None => (None, rest.trim_start_matches('\\')),
    };
    let mut parts = rest.split('\\');
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let Some((parameter, value)) = part.split_once('=') else { return name.to_owned() };
        let digits = value.rsplit('\'').next().unwrap_or_default();
        let signed = value.starts_with('s');
        let value = match u128::from_str_radix(digits, 2) {
            // a negative number
            Ok(n) if signed && digits.len() == 32 && n >> 31 == 1 => format!("m{}", (1u128 << 32) - n),
            Ok(n) if digits.len() <= 32 => n.to_string(),
            Ok(n) => format!("{n:x}"),
            Err(_) => digits.chars().filter(char::is_ascii_alphanumeric).take(16).collect(),
        };
        text += &format!("_{parameter}{value}");
    }
    text + &hash.map(|h| format!("_{}", &h[..h.len().min(8)])).unwrap_or_default()
}

/// The names that are taken in one module.
#[derive(Default)]
pub(super) struct Taken {
    names: HashSet<(usize, String)>,
    /// For a block and a name the last number that was tried for it: those before it are taken.
    last: HashMap<(usize, String), u32>,
}

impl Taken {
    /// A name that nothing has in any of these blocks, as near to `base` as can be; taken in the first from now on.
    pub fn fresh(&mut self, blocks: &[usize], base: &str) -> String {
        let free = |name: &str| blocks.iter().all(|&b| !self.names.contains(&(b, name.to_owned())));
        let name = if free(base) {
            base.to_owned()
        } else {
            let last = self.last.entry((blocks[0], base.to_owned())).or_insert(1);
            loop {
                *last += 1;
                let name = format!("{base}_{last}");
                if free(&name) {
                    break name;
                }
            }
        };
        self.names.insert((blocks[0], name.clone()));
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_of_yosys_with_parameters() {
        let eight = "s32'00000000000000000000000000001000";
        for (name, expected) in [
            ("fifo", "fifo"),
            (&*format!("$paramod\\fifo\\W={eight}"), "fifo_W8"),
            (&format!("$paramod\\fifo\\W={eight}\\CODE=2'10"), "fifo_W8_CODE2"),
            ("$paramod\\at\\FIRST=s32'11111111111111111111111111111101", "at_FIRSTm3"),
            ("$paramod$0123456789abcdef\\ram", "ram_01234567"),
        ] {
            assert_eq!(readable(name), expected);
        }
    }
}
