//! What bytes come to, in short: to know again what was seen before, not to keep anybody from forging it.

use std::fmt::{self, Write as _};

/// FNV-1a of 64 bits over what is written to it, the same on every machine.
#[derive(Clone, Debug)]
pub struct Digest(u64);

impl Default for Digest {
    fn default() -> Digest {
        Digest(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    /// More bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// A line more.
    pub fn line(&mut self, line: &str) {
        let _ = writeln!(self, "{line}");
    }

    /// As a number.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.0
    }

    /// As text: 16 hex digits.
    #[must_use]
    pub fn text(&self) -> String {
        format!("{:016x}", self.0)
    }
}

impl fmt::Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of FNV's authors (draft-eastlake-fnv, section 6).
    #[test]
    fn published_values() {
        for (text, number) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut digest = Digest::default();
            digest.bytes(text.as_bytes());
            assert_eq!(digest.number(), number, "{text}");
        }
    }
}
