//! A circuit file with a scenario: whatever the bytes, it is loaded, or its faults are told.
#![no_main]

#[path = "files.rs"]
mod files;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| files::load(bytes, "scenario.json"));
