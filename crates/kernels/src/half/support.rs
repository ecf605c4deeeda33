//! Whether this processor multiplies bf16.

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
        if !is_x86_feature_detected!("avx512bf16")
            || !is_x86_feature_detected!("avx512bw")
            || !is_x86_feature_detected!("avx512vl")
        {
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
