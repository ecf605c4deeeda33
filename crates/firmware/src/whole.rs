//! Endings of sums in whole numbers, for processors without floats in hardware.
//!
//! A value in steps of 2⁻ᶠ is `sum · multiplier >> shift`, and an addend's times its own multiplier. It differs from the value
//! that floats give by less than 2⁻¹¹ of an output's step, so that both round alike unless the value is that near a half; there the
//! C takes the floats. The bound: below 2048, where bytes are cut off anyway above 256, each of at most three float
//! roundings is off by 2⁻¹⁴; the multiplier's rounding moves the value by at most 8 of the 2ᶠ, an addend's by 128.

use crate::layer::Conv;

/// Most bits behind the point, and least: with an addend, and without.
const MOST: u32 = 20;
const LEAST: [u32; 2] = [17, 19];
/// Bits that a multiplier has beyond those behind the point, at least.
const SPARE: u32 = 5;

/// Multipliers of a convolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Whole {
    pub multipliers: Vec<i32>,
    pub shift: u32,
    /// Bits behind the point.
    pub fraction: u32,
    pub addend: i32,
    /// The sum of zeros and a half.
    pub base: i32,
}

impl Whole {
    /// Returns the multipliers, where whole numbers hold all values and are exact enough.
    pub fn new(conv: &Conv) -> Option<Whole> {
        let largest = conv.factor.iter().copied().fold(0.0f32, f32::max);
        let least = conv.factor.iter().copied().fold(f32::INFINITY, f32::min);
        let added = conv.addend.map_or(0.0, |addend| f64::from(addend.factor));
        // With the output's zero and a half.
        let bound = f64::from(conv.reach) * f64::from(largest) + 260.0 * added + 257.0;
        let fraction = (31 - bound.log2().ceil() as i64).min(i64::from(MOST)) as u32;
        let is_full = (conv.ending.low, conv.ending.high) == (0.0, 255.0);
        let fits =
            is_full && conv.then.is_none() && least > 0.0 && bound.is_finite() && bound < 2f64.powi(14);
        if !fits || fraction < LEAST[usize::from(conv.addend.is_some())] {
            return None;
        }
        // The largest multiplier has 31 bits.
        let shift = 30 - (f64::from(largest) * f64::from(fraction).exp2()).log2().floor() as i64 - 1;
        if !(1..=62).contains(&shift) {
            return None;
        }
        let unit = (f64::from(fraction) + shift as f64).exp2();
        let multipliers: Vec<i32> =
            conv.factor.iter().map(|factor| (f64::from(*factor) * unit).round() as i32).collect();
        let is_exact = multipliers.iter().all(|multiplier| *multiplier >= 1 << (fraction + SPARE));
        let addend = (added * f64::from(fraction).exp2()).round() as i32;
        let zero = conv.addend.map_or(0, |addend| i32::from(addend.zero));
        let base = ((conv.ending.zero as i32) << fraction) + (1 << (fraction - 1)) + (128 - zero) * addend;
        is_exact.then_some(Whole { multipliers, shift: shift as u32, fraction, addend, base })
    }
}
