//! Products of bf16 with sums in f32, by the instruction `vdpbf16ps` of AVX512-BF16.
//!
//! A bf16 is the upper half of a float: 8 bits of mantissa, the same exponents. Factors are rounded to it (nearest,
//! even), two of them lie in the 32 bits of one float, and the kernels of [`tile`](crate::tile) take two products per
//! lane. A sum goes through its products in order, each fused with it, so that it does not depend on blocks or threads:
//! `fma(a1, b1, fma(a0, b0, sum))` of the rounded factors, where subnormal numbers count as zero.

mod burst;
mod pack;
mod product;

pub use burst::burst;
pub use product::{HalfMatrix, multiply};

pub(crate) use pack::{pair_columns_of_rows, pair_rows, pair_with_later};

use std::sync::OnceLock;

use crate::simd::{Level, level};

/// Checks whether this processor multiplies bf16.
///
/// # Errors
/// The reason why not.
pub fn supported() -> Result<(), &'static str> {
    static SUPPORTED: OnceLock<Result<(), &'static str>> = OnceLock::new();
    *SUPPORTED.get_or_init(|| {
        if !cfg!(target_arch = "x86_64") {
            return Err("taxel multiplies bf16 on x86-64 processors only");
        }
        #[cfg(target_arch = "x86_64")]
        if !is_x86_feature_detected!("avx512bf16") {
            return Err("this processor has no AVX512-BF16");
        }
        if level() != Level::Avx512 {
            return Err("TAXEL_SIMD asks for vectors without products of bf16");
        }
        Ok(())
    })
}

/// Panics where [`supported`] is an error.
#[expect(clippy::panic, reason = "callers check before they make a plan with bf16")]
pub(crate) fn assert_supported() {
    if let Err(reason) = supported() {
        panic!("products of bf16: {reason}");
    }
}

#[cfg(test)]
mod tests;
