//! Rows of a sweep, as `--join` reads them.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    // two parts, told apart by a byte that no row has
    let parts: Result<Vec<_>, _> = text.split('\u{c}').map(discreta::sweep::table::read).collect();
    let _ = parts.map(discreta::sweep::table::order);
});
