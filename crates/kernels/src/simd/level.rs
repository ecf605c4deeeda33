//! Which width of vectors this CPU has.

use std::sync::OnceLock;

/// The widths that kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Four floats, any CPU.
    Portable,
    /// Four floats with fused multiply–add, on 64-bit Arm.
    Neon,
    /// Eight floats with fused multiply–add.
    Avx2,
    /// Sixteen floats with masks; eight where half of them would stay empty.
    Avx512,
}

impl Level {
    /// Returns its name: `AVX-512`, `AVX2`, `NEON` or `portable`.
    pub fn name(self) -> &'static str {
        match self {
            Level::Portable => "portable",
            Level::Neon => "NEON",
            Level::Avx2 => "AVX2",
            Level::Avx512 => "AVX-512",
        }
    }

    /// Returns the number of floats in one vector.
    pub(crate) fn lanes(self) -> usize {
        match self {
            Level::Portable | Level::Neon => 4,
            Level::Avx2 => 8,
            Level::Avx512 => 16,
        }
    }
}

/// Checks whether `TAXEL_SIMD` has this value.
pub(crate) fn is_wanted(name: &str) -> bool {
    std::env::var_os("TAXEL_SIMD").is_some_and(|wanted| wanted == name)
}

/// Returns the widest level of this CPU. `TAXEL_SIMD` asks for a narrower one: `portable` everywhere, `avx2` on x86-64,
/// on Arm `neon`, which does without products of bytes; no other value changes anything. [`matmul`](crate::matmul)
/// knows nothing of it: `gemm` asks the CPU by itself.
pub fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        if is_wanted("portable") {
            return Level::Portable;
        }
        #[cfg(target_arch = "aarch64")]
        return Level::Neon;
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
            if avx2 && is_x86_feature_detected!("avx512f") && !is_wanted("avx2") {
                return Level::Avx512;
            }
            if avx2 {
                return Level::Avx2;
            }
        }
        #[cfg(not(target_arch = "aarch64"))]
        Level::Portable
    })
}
