//! Predictions have the same bits on every processor whose vectors have fused multiply–add: AVX-512, AVX2 and NEON.
//!
//! `cargo run --release -p taxel-runtime --example bits > crates/runtime/tests/data/bits.json` writes what is compared;
//! `scripts/arm64.py tests` runs this on 64-bit Arm.
#![allow(clippy::unwrap_used)]

#[path = "common/bits.rs"]
mod bits;

use taxel_kernels::simd::{Level, level};

/// Larger networks take minutes under an emulator; the example predicts with all.
const MOST: u64 = 50_000_000;

#[test]
fn every_network_predicts_the_same_bits_on_every_processor() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/bits.json");
    let wanted: bits::Bits = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let got = bits::of_zoo(MOST).unwrap();
    let missing: Vec<_> = got.keys().filter(|name| !wanted.contains_key(*name)).collect();
    assert!(missing.is_empty(), "write bits.json again: it lacks {missing:?}");
    // Without fused multiply–add every product is rounded before it is added.
    let is_fused = level() != Level::Portable;
    let differs = |name: &&String| is_fused && got[*name] != wanted[*name];
    let differing: Vec<_> = got.keys().filter(differs).collect();
    assert!(differing.is_empty(), "other bits at {}: {differing:?}", level().name());
}
