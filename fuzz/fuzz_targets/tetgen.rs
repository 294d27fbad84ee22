#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    modiolus_fuzz::tetgen("a.node", bytes);
    modiolus_fuzz::tetgen("a.ele", bytes);
});
