//! Products against a plain model of rounding and order. They need AVX512-BF16, so `scripts/check` runs them where
//! `/proc/cpuinfo` names it.

use super::{HalfMatrix, multiply, pair_columns_of_rows, pair_rows, pair_with_later};
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

/// Returns the two values of a pair.
fn halves(pair: f32) -> [f32; 2] {
    [pair.to_bits() & 0xffff_0000, pair.to_bits() << 16].map(f32::from_bits)
}

#[test]
#[ignore = "needs avx512_bf16"]
fn values_are_paired_and_rounded_to_the_nearest_needs_bf16() {
    let halfway = [0x3f80_8000, 0x3f81_8000, 0x3f80_8001, 0x3f80_7fff, 0xbf81_8000].map(f32::from_bits);
    let all: Vec<f32> = values(171, 1)
        .into_iter()
        .chain(halfway)
        .chain([0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY])
        .collect();
    let rounded = |value: f32| if value.is_finite() { nearest(value) } else { value };
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    for len in (0..70).chain([all.len()]) {
        let expected: Vec<f32> = all[..len].iter().map(|value| rounded(*value)).collect();
        let mut pairs = vec![9.0; len.div_ceil(2) + 1];
        pair_columns_of_rows(len, len + 1, &[&all[..len], &[3.0]].concat(), &mut pairs[..len.div_ceil(2)]);
        let found: Vec<f32> = pairs[..len.div_ceil(2)].iter().flat_map(|pair| halves(*pair)).collect();
        assert_eq!((bits(&found[..len]), pairs[len.div_ceil(2)]), (bits(&expected), 9.0), "{len} neighbours");
        assert!(found[len..].iter().all(|value| value.to_bits() == 0), "{len}: a pair is filled with 0");

        // Rows one after the other, of which the last has no second.
        let rows = [&all[..len], &all[all.len() - len..], &all[..len]].concat();
        let mut pairs = vec![9.0; 2 * len + 1];
        pair_rows(3, len, len, &rows, &mut pairs);
        let (first, second): (Vec<f32>, Vec<f32>) =
            pairs[..len].iter().map(|pair| halves(*pair)).map(|[first, second]| (first, second)).unzip();
        let other: Vec<f32> = all[all.len() - len..].iter().map(|value| rounded(*value)).collect();
        assert_eq!((bits(&first), bits(&second)), (bits(&expected), bits(&other)), "two rows of {len}");
        let alone: Vec<f32> = pairs[len..2 * len].iter().flat_map(|pair| halves(*pair)).collect();
        let zeros = expected.iter().flat_map(|value| [*value, 0.0]).collect::<Vec<_>>();
        assert_eq!((bits(&alone), pairs[2 * len]), (bits(&zeros), 9.0), "a row of {len} alone");

        let mut later = vec![9.0; len];
        pair_with_later(5, &all[..len], &mut later);
        for (i, pair) in later.iter().enumerate() {
            let second = all[..len].get(i + 5).map_or(0.0, |value| rounded(*value));
            assert_eq!(bits(&halves(*pair)), bits(&[expected[i], second]), "{i} of {len}");
        }
    }
    let mut nan = [0.0];
    pair_columns_of_rows(1, 1, &[f32::NAN], &mut nan);
    assert!(halves(nan[0])[0].is_nan());
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
