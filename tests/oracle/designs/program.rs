//! What the program of the CPU has to print, computed here, and what it printed.

use std::fmt::Write as _;

use discreta::wave::read::Waves;

/// The primes below a bound, the CRC-32 of the sieve, pseudo-random numbers sorted.
pub fn expected(bound: usize, numbers: usize) -> String {
    let is_prime = |n: usize| n >= 2 && (2..n).all(|d| !n.is_multiple_of(d));
    let mut text: String = (0..bound).filter(|n| is_prime(*n)).map(|n| format!("{n} ")).collect();
    // 0 and 1 are not crossed out
    let sieve: Vec<u8> = (0..bound).map(|n| u8::from(n >= 2 && !is_prime(n))).collect();
    write!(text, "\ncrc {:08x}\nsorted", crc(&sieve)).unwrap();
    let mut state = 1u32;
    let mut drawn: Vec<i32> = (0..numbers)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state.cast_signed() >> 20
        })
        .collect();
    drawn.sort_unstable();
    drawn.iter().for_each(|n| write!(text, " {n}").unwrap());
    text + "\n"
}

/// CRC-32 as a remainder of polynomials: the message with its bits reversed in each byte, the first 32 bits inverted.
fn crc(message: &[u8]) -> u32 {
    let bits = message.iter().flat_map(|byte| (0..8).map(move |i| byte >> i & 1 == 1));
    let mut bits: Vec<bool> = bits.chain([false; 32]).collect();
    bits[..32].iter_mut().for_each(|bit| *bit = !*bit);
    let divisor: Vec<bool> = (0..33).map(|i| 0x1_04c1_1db7_u64 >> (32 - i) & 1 == 1).collect();
    for at in 0..bits.len() - 32 {
        if bits[at] {
            bits[at..].iter_mut().zip(&divisor).for_each(|(bit, d)| *bit ^= d);
        }
    }
    let remainder = &bits[bits.len() - 32..];
    !remainder.iter().enumerate().map(|(i, bit)| u32::from(*bit) << i).sum::<u32>()
}

/// What came out of the port, a character in each clock (10 ns) in which `put` is 1; and whether the program ended well.
pub fn printed(waves: &mut Waves) -> (String, bool) {
    let mut changes = |net: &str| -> Vec<(u64, String)> {
        let at = waves.find(net).unwrap();
        waves.load(at).unwrap().changes().collect()
    };
    let [put, character, done, status] = ["put", "character", "done", "status"].map(|n| changes(&format!("cpu.{n}")));
    let mut text = String::new();
    for (begin, end) in put.iter().zip(&put[1..]).filter(|(begin, _)| begin.1 == "1").map(|(b, e)| (b.0, e.0)) {
        for time in (begin..end).step_by(10) {
            let now = character.iter().rfind(|c| c.0 <= time).unwrap();
            text.push(char::from(u8::from_str_radix(&now.1, 2).unwrap()));
        }
    }
    let zero = status.last().is_some_and(|s| s.1.bytes().all(|b| b == b'0'));
    (text, done.last().is_some_and(|d| d.1 == "1") && zero)
}

/// The check value that catalogues of CRCs print.
#[test]
fn the_crc_is_that_of_the_catalogues() {
    assert_eq!(crc(b"123456789"), 0xcbf4_3926);
}
