//! Picks the width of a kernel when it is called.

/// Defines the safe `fn name(..)` that runs the unsafe `body::<S>(..)` at the CPU's level.
///
/// The CPU's features are all that a body may ask of its caller. The lengths that its loops rely on it
/// asserts itself, before the first of them.
macro_rules! at_level {
    ($(#[$meta:meta])* $vis:vis fn $name:ident($($arg:ident: $ty:ty),* $(,)?) = $body:ident) => {
        $(#[$meta])*
        #[allow(clippy::too_many_arguments)]
        $vis fn $name($($arg: $ty),*) {
            #[cfg(target_arch = "x86_64")]
            {
                #[allow(clippy::too_many_arguments)]
                #[target_feature(enable = "avx512f")]
                unsafe fn avx512($($arg: $ty),*) {
                    // SAFETY: the caller has checked the feature; the body asks for nothing else.
                    unsafe { $body::<$crate::simd::Avx512>($($arg),*) }
                }
                #[allow(clippy::too_many_arguments)]
                #[target_feature(enable = "avx2,fma")]
                unsafe fn avx2($($arg: $ty),*) {
                    // SAFETY: the caller has checked the features; the body asks for nothing else.
                    unsafe { $body::<$crate::simd::Avx2>($($arg),*) }
                }
                match $crate::simd::level() {
                    // SAFETY: `level` has found the features on this CPU.
                    $crate::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    $crate::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::simd::Level::Portable | $crate::simd::Level::Neon => {}
                }
            }
            #[cfg(target_arch = "aarch64")]
            if $crate::simd::level() == $crate::simd::Level::Neon {
                // SAFETY: NEON belongs to the architecture; the body asks for nothing else.
                return unsafe { $body::<$crate::simd::Neon>($($arg),*) };
            }
            // SAFETY: the portable level needs no feature; the body asks for nothing else.
            unsafe { $body::<$crate::simd::Portable>($($arg),*) }
        }
    };
}
pub(crate) use at_level;
