#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| gyrowatch_fuzz::ndjson(bytes));
