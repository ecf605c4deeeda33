//! The fuzz target of every reader: `TAXEL_FUZZ_READER` names it, as in `READERS`.

#![no_main]

taxel_fuzz::libfuzzer_sys::fuzz_target!(|bytes: &[u8]| taxel_fuzz::read(taxel_fuzz::asked(), bytes));
