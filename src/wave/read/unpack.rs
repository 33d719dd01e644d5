//! Unpacking what FST has packed: zlib, gzip, LZ4 and FastLZ.
//!
//! The length that a file gives is never taken at its word: what is made room for grows with what comes out, or is
//! within what the format can make of the bytes that are there.

use miniz_oxide::inflate::{decompress_to_vec_with_limit, decompress_to_vec_zlib_with_limit};

use super::bytes::Bytes;

/// The most that LZ4 makes of a byte: a byte of a length stands for 255 more.
const LZ4_RATIO: u64 = 255;
/// What comes without any byte of a length: the literals and the match of one token.
const LZ4_TOKEN: u64 = 64;

/// Bytes that are `unpacked` long; as they are if they are as long packed.
pub(super) fn zlib_or_plain(packed: &[u8], unpacked: u64) -> Option<Vec<u8>> {
    if packed.len() as u64 == unpacked { Some(packed.to_vec()) } else { zlib(packed, unpacked) }
}

/// What zlib packed.
pub(super) fn zlib(packed: &[u8], unpacked: u64) -> Option<Vec<u8>> {
    let bytes = decompress_to_vec_zlib_with_limit(packed, usize::try_from(unpacked).ok()?).ok()?;
    (bytes.len() as u64 == unpacked).then_some(bytes)
}

/// What gzip packed (RFC 1952). Without a length of its own, and where the file is cut off, what comes out counts.
pub(super) fn gzip(packed: &[u8], unpacked: u64) -> Option<Vec<u8>> {
    let mut bytes = Bytes(packed);
    let &[0x1f, 0x8b, 8, flags, ..] = bytes.take(10)? else { return None };
    if flags & 4 != 0 {
        let length = u16::from_le_bytes(*bytes.take(2)?.first_chunk()?);
        bytes.take(length.into())?;
    }
    for text in [8, 16] {
        if flags & text != 0 {
            bytes.text()?;
        }
    }
    if flags & 2 != 0 {
        bytes.take(2)?;
    }
    match decompress_to_vec_with_limit(bytes.0, usize::try_from(unpacked).ok()?) {
        Ok(bytes) => Some(bytes),
        Err(error) => Some(error.output),
    }
}

/// What LZ4 packed, in its format of blocks.
pub(super) fn lz4(packed: &[u8], unpacked: u64) -> Option<Vec<u8>> {
    if unpacked > (packed.len() as u64).checked_mul(LZ4_RATIO)?.checked_add(LZ4_TOKEN)? {
        return None;
    }
    let bytes = lz4_flex::decompress(packed, usize::try_from(unpacked).ok()?).ok()?;
    (bytes.len() as u64 == unpacked).then_some(bytes)
}

/// What FastLZ packed, at either of its levels.
pub(super) fn fastlz(packed: &[u8], unpacked: u64) -> Option<Vec<u8>> {
    let level = packed.first()? >> 5;
    if level > 1 {
        return None;
    }
    let mut out: Vec<u8> = Vec::new();
    let mut bytes = Bytes(packed);
    let mut control = bytes.byte()? & 31;
    loop {
        if control < 32 {
            out.extend(bytes.take(u64::from(control) + 1)?);
        } else {
            let mut length = usize::from(control >> 5) + 2;
            let mut distance = usize::from(control & 31) << 8;
            if control >> 5 == 7 {
                loop {
                    let more = bytes.byte()?;
                    length += usize::from(more);
                    if level == 0 || more != 255 {
                        break;
                    }
                }
            }
            let low = bytes.byte()?;
            distance += usize::from(low);
            // level 2 has distances beyond those that fit into the control byte
            if level == 1 && low == 255 && control & 31 == 31 {
                distance = usize::from(u16::from_be_bytes(*bytes.take(2)?.first_chunk()?)) + 8191;
            }
            let from = out.len().checked_sub(distance + 1)?;
            if out.len() + length > usize::try_from(unpacked).ok()? {
                return None;
            }
            for i in 0..length {
                out.push(out[from + i]);
            }
        }
        match bytes.byte() {
            Some(next) => control = next,
            None => break,
        }
    }
    (out.len() as u64 == unpacked).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The most that each method makes of its bytes is unpacked; one byte more than there is, is not.
    #[test]
    fn extremes_of_packing() {
        for length in [0, 1, 63, 64, 65, 65_535, 65_536, 1 << 24] {
            let zeros = vec![0; length];
            let packed = lz4_flex::compress(&zeros);
            assert_eq!(lz4(&packed, length as u64), Some(zeros.clone()), "{length}");
            assert_eq!(lz4(&packed, length as u64 + 1), None);
            let packed = miniz_oxide::deflate::compress_to_vec_zlib(&zeros, 9);
            assert_eq!(zlib(&packed, length as u64), Some(zeros), "{length}");
            assert_eq!(zlib(&packed, length as u64 + 1), None);
        }
        assert_eq!(lz4(&[0; 4], 1 << 62), None);
        assert_eq!(zlib(&[0x78, 1, 3, 0], 1 << 62), None);
    }

    /// By hand from the description of the format: literals, a short match, a long one.
    #[test]
    fn fastlz_of_both_levels() {
        // three literals, then 3 bytes from 3 back
        assert_eq!(fastlz(&[2, b'a', b'b', b'c', 0b001_00000, 2], 6), Some(b"abcabc".to_vec()));
        // a match of 9 + 10 bytes from 1 back
        assert_eq!(fastlz(&[0, b'a', 0b111_00000, 10, 0], 20), Some(vec![b'a'; 20]));
        // level 2: a length of several bytes
        assert_eq!(fastlz(&[0x20, b'a', 0b111_00000, 255, 0, 0], 265), Some(vec![b'a'; 265]));
        // back behind the beginning, too long, cut off
        assert_eq!(fastlz(&[0, b'a', 0b001_00000, 1], 4), None);
        assert_eq!(fastlz(&[0, b'a', 0b001_00000, 0], 3), None);
        assert_eq!(fastlz(&[5, b'a'], 6), None);
    }
}
