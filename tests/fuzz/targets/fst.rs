//! FST: whatever the bytes, the file is read or refused, in time and memory that it can account for.
#![no_main]

#[path = "waves.rs"]
mod waves;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| waves::read(bytes, "fst"));
