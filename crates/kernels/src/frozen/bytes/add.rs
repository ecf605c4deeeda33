//! The sum of two values in bytes.

use crate::frozen::place::ImagePlace;
use crate::lengths::at_least;
use crate::rows::vectors;
use crate::simd::{Simd, at_level};
use crate::view::Rectifier;

use super::ByteScale;
use super::map::store_at;
use super::output::{ByteOutput, Ending, Target};

/// `y = rectifier(a + b)` between places.
pub struct Add {
    from: [ImagePlace; 2],
    to: ImagePlace,
    output: ByteOutput,
    ending: Ending,
    /// Steps of the output in one of each input, and what is left of their zeros.
    factors: [f32; 2],
    shift: f32,
}

impl Add {
    /// Makes the sum of both inputs with their scales.
    pub fn new(
        inputs: [(ImagePlace, ByteScale); 2],
        (to, output): (ImagePlace, ByteOutput),
        rectifier: Rectifier,
    ) -> Self {
        let same = |from: &ImagePlace| from.size == to.size && from.channels == to.channels;
        assert!(
            inputs.iter().all(|(from, _)| same(from)),
            "places of one shape are needed: {inputs:?} {to:?}"
        );
        let (factors, shift) = Add::coefficients(inputs.map(|(_, scale)| scale), output);
        let from = inputs.map(|(place, _)| place);
        Add { from, to, output, ending: output.ending(rectifier), factors, shift }
    }

    /// Returns the factors of both inputs and the shift: a stored number is an [`Ending`] of
    /// `(factor · a + factor · b) + shift`.
    pub fn coefficients(inputs: [ByteScale; 2], output: ByteOutput) -> ([f32; 2], f32) {
        let steps = inputs.map(|scale| f64::from(scale.step) * output.steps());
        let zeros = inputs.map(|scale| f64::from(scale.zero));
        (steps.map(|step| step as f32), -(steps[0] * zeros[0] + steps[1] * zeros[1]) as f32)
    }

    /// Computes all values.
    pub fn run(&self, a: &[u8], b: &[u8], mut y: Target) {
        run(self, a, b, &mut y);
    }
}

at_level! {
    fn run(sum: &Add, a: &[u8], b: &[u8], y: &mut Target) = run_at
}

/// Computes [`Add::run`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn run_at<S: Simd>(sum: &Add, a: &[u8], b: &[u8], y: &mut Target) {
    at_least("the first addend", a.len(), sum.from[0].end());
    at_least("the second addend", b.len(), sum.from[1].end());
    at_least("room for sums", y.len(), sum.to.end());
    assert!(y.fits(sum.output), "memory for {:?} is needed", sum.output);
    let ImagePlace { size: [_, _, columns], channels, pitch, .. } = sum.to;
    let starts = sum.from[0].rows().zip(sum.from[1].rows()).zip(sum.to.rows());
    for ((first, second), to) in starts {
        for column in 0..columns {
            let [first, second] =
                [first + column * sum.from[0].pitch[2], second + column * sum.from[1].pitch[2]];
            let to = to + column * pitch[2];
            vectors!(S, channels, c, n, {
                // SAFETY: the ends of the places are asserted to lie inside the slices; `c + n <= channels`.
                unsafe {
                    let a = S::load_bytes(a.as_ptr().add(first + c), n);
                    let b = S::load_bytes(b.as_ptr().add(second + c), n);
                    let [of_a, of_b] = sum.factors.map(|factor| S::splat(factor));
                    let value = S::add(S::mul(a, of_a), S::mul(b, of_b));
                    let value = S::add(value, S::splat(sum.shift));
                    store_at::<S>(y, to + c, n, value, &sum.ending);
                }
            });
        }
    }
}
