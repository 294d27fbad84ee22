#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| modiolus_fuzz::map(bytes));
