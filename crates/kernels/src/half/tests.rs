//! Products against a plain model of rounding and order. They need AVX512-BF16, so `scripts/check` runs them where
//! `/proc/cpuinfo` names it.

use super::pack::pair;
use super::{HalfMatrix, multiply};
use crate::matmul::Matrix;

/// Returns the nearest bf16, by comparing both neighbours.
fn nearest(value: f32) -> f32 {
    let below = f32::from_bits(value.to_bits() & 0xffff_0000);
    let above = f32::from_bits(below.to_bits().wrapping_add(0x1_0000));
    let (down, up) = (f64::from(value) - f64::from(below), f64::from(above) - f64::from(value));
    match down.abs().total_cmp(&up.abs()) {
        std::cmp::Ordering::Less => below,
        std::cmp::Ordering::Greater => above,
        std::cmp::Ordering::Equal if (below.to_bits() >> 16).is_multiple_of(2) => below,
        std::cmp::Ordering::Equal => above,
    }
}

/// Returns values in -1..1 with all 24 bits of a mantissa in use.
pub(crate) fn values(len: usize, salt: u32) -> Vec<f32> {
    let mut state = salt.wrapping_mul(2_654_435_769) | 1;
    let next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    std::iter::repeat_with(next).take(len).collect()
}

#[test]
fn rounds_to_the_nearest_bf16() {
    let halfway = [0x3f80_8000, 0x3f81_8000, 0x3f80_8001, 0x3f80_7fff, 0xbf81_8000].map(f32::from_bits);
    for value in values(1000, 1).into_iter().chain(halfway).chain([0.0, -0.0, f32::INFINITY]) {
        let bits = pair(value, value).to_bits();
        let expected = if value.is_finite() { nearest(value) } else { value };
        assert_eq!(bits & 0xffff_0000, expected.to_bits(), "{value}");
        assert_eq!(bits << 16, expected.to_bits(), "{value}");
    }
    assert!(f32::from_bits(pair(f32::NAN, 0.0).to_bits()).is_nan());
}

#[test]
#[ignore = "needs avx512_bf16"]
fn products_have_the_bits_of_the_model_needs_bf16() {
    for (m, k, n) in [(1, 1, 1), (3, 7, 5), (5, 70, 33), (29, 601, 501), (60, 530, 520), (4, 0, 3)] {
        let (a, b, start) = (values(m * k, 2), values(k * n, 3), values(m * n, 4));
        for accumulate in [false, true] {
            let mut model = if accumulate { start.clone() } else { vec![0.0; m * n] };
            for i in 0..m {
                for j in 0..n {
                    let sum = &mut model[i * n + j];
                    for p in 0..k {
                        *sum = nearest(a[i * k + p]).mul_add(nearest(b[p * n + j]), *sum);
                    }
                }
            }
            let turn = |x: &[f32], rows: usize, columns: usize| -> Vec<f32> {
                (0..rows * columns).map(|i| x[i % rows * columns + i / rows]).collect()
            };
            let (at, bt) = (turn(&a, m, k), turn(&b, k, n));
            let firsts = [Matrix::new(&a, m, k), Matrix::new(&at, k, m).t()];
            let seconds = [Matrix::new(&b, k, n), Matrix::new(&bt, n, k).t()];
            for (a, b) in firsts.into_iter().flat_map(|a| seconds.map(|b| (a, b))) {
                let mut out = start.clone();
                multiply(&mut out, n, a, b, accumulate);
                assert_eq!(out, model, "{m}×{k}×{n}, {accumulate}");
                let (mut packed, mut again) = (HalfMatrix::default(), start.clone());
                packed.pack(b);
                packed.multiply(&mut again, n, a, accumulate);
                assert_eq!(again, model, "packed: {m}×{k}×{n}, {accumulate}");
            }
        }
    }
}
