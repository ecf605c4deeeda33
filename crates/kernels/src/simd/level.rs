//! Which width of vectors this CPU has.

use std::sync::OnceLock;

/// The widths that kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Four floats, any CPU.
    Portable,
    /// Eight floats with fused multiply–add.
    Avx2,
    /// Sixteen floats with masks; eight where half of them would stay empty.
    Avx512,
}

impl Level {
    /// Returns its name: `AVX-512`, `AVX2` or `portable`.
    pub fn name(self) -> &'static str {
        match self {
            Level::Portable => "portable",
            Level::Avx2 => "AVX2",
            Level::Avx512 => "AVX-512",
        }
    }
}

/// Returns the widest level of this CPU. `TAXEL_SIMD=portable` or `avx2` asks for a narrower one; no other value
/// changes anything. [`matmul`](crate::matmul) knows nothing of it: `gemm` asks the CPU by itself.
pub fn level() -> Level {
    static LEVEL: OnceLock<Level> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        let wanted = std::env::var_os("TAXEL_SIMD");
        let is_wanted = |name: &str| wanted.as_deref().is_some_and(|wanted| wanted == name);
        if is_wanted("portable") {
            return Level::Portable;
        }
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
        Level::Portable
    })
}
