//! The peak of the instruction.

use super::support::assert_supported;

/// Runs `rounds` of 24 instructions of 16 × 2 products whose sums stay in registers, and returns a sum of them: the most
/// that this processor does, for measurements. Panics where [`supported`](super::supported) is an error.
pub fn burst(rounds: usize) -> f32 {
    assert_supported();
    #[cfg(target_arch = "x86_64")]
    {
        // SAFETY: the features are there, as just asserted.
        unsafe { burst_of_pairs(rounds) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        rounds as f32
    }
}

/// Computes [`burst`].
///
/// # Safety
/// The CPU has AVX512-BF16.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bf16")]
unsafe fn burst_of_pairs(rounds: usize) -> f32 {
    use crate::simd::{Avx512, Pairs, Product, Simd};
    // SAFETY: the caller has checked the features; the array holds the lanes.
    unsafe {
        let ones = f32::from_bits(0x3f80_3f80);
        let a = Avx512::splat(std::hint::black_box(ones));
        let mut sums = [Avx512::splat(0.0); 24];
        for _ in 0..rounds {
            // Known only now, so that no product is moved out of the loop.
            let b = Avx512::splat(std::hint::black_box(ones));
            for sum in &mut sums {
                *sum = <Pairs as Product<Avx512>>::add(a, b, *sum);
            }
        }
        let total = sums.into_iter().fold(Avx512::splat(0.0), |a, b| Avx512::add(a, b));
        let mut lanes = [0.0; Avx512::LANES];
        Avx512::store(lanes.as_mut_ptr(), total);
        lanes[0]
    }
}
