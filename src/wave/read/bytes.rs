//! Numbers and texts out of bytes. None where the bytes end before that.

/// Bytes that are yet to come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a>(pub &'a [u8]);

impl<'a> Bytes<'a> {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn take(&mut self, n: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(n).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    pub fn byte(&mut self) -> Option<u8> {
        Some(self.take(1)?[0])
    }

    /// Eight bytes, the highest first.
    pub fn number(&mut self) -> Option<u64> {
        Some(u64::from_be_bytes(*self.take(8)?.first_chunk()?))
    }

    /// Seven bits a byte, the lowest first, the eighth set in all but the last. None also for more than 64 bits.
    pub fn variable(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    /// The same in two's complement.
    pub fn signed(&mut self) -> Option<i64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= i64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                let extension = if byte & 0x40 != 0 && shift + 7 < 64 { -1 << (shift + 7) } else { 0 };
                return Some(number | extension);
            }
        }
        None
    }

    /// A text that ends with a zero byte.
    pub fn text(&mut self) -> Option<String> {
        let length = self.0.iter().position(|byte| *byte == 0)?;
        let text = String::from_utf8_lossy(self.take(length as u64)?).into_owned();
        self.byte()?;
        Some(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_variable_length() {
        let unsigned = |bytes: &[u8]| Bytes(bytes).variable();
        assert_eq!(
            [unsigned(&[0]), unsigned(&[0x7f]), unsigned(&[0xe5, 0x8e, 0x26])],
            [Some(0), Some(127), Some(624_485)]
        );
        let most = [&[0xff; 9][..], &[1]].concat();
        assert_eq!((unsigned(&most), unsigned(&[0xff; 11]), unsigned(&[0x80])), (Some(u64::MAX), None, None));
        let signed = |bytes: &[u8]| Bytes(bytes).signed();
        assert_eq!(
            [signed(&[0x13]), signed(&[0x7b]), signed(&[0xc0, 0xbb, 0x78])],
            [Some(19), Some(-5), Some(-123_456)]
        );
        let least = [&[0x80; 9][..], &[0x7f]].concat();
        assert_eq!(signed(&least), Some(i64::MIN));
        assert_eq!(Bytes(b"ab\0c").text(), Some("ab".to_owned()));
        assert_eq!(Bytes(b"ab").text(), None);
    }
}
