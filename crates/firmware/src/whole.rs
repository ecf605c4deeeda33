//! Endings of sums in whole numbers, for processors without floats in hardware.
//!
//! A value with [`FRACTION`] bits behind the point is the upper word of a sum, shifted left, times a multiplier. It differs from the
//! value that floats give by less than [`MARGIN`], so that both round alike unless the value is that near to a half; there the
//! C takes the floats.
//!
//! The bound has three parts. Floats: bytes that are not cut off come of values whose parts are all within a `range`, and each of
//! at most [`ROUNDINGS`] roundings is off by half of its last place. Whole numbers: the upper word is cut off, also where it is
//! added up from halves. The addend's multiplier is rounded, for up to 255 steps; it has [`MORE`] bits.

use crate::layer::Conv;

/// Bits behind the point.
pub(crate) const FRACTION: u32 = 16;
/// How near to a half floats decide, in those bits.
pub(crate) const MARGIN: i32 = 64;
/// Roundings of a sum, its two products, an addend, its product, two sums and a zero.
const ROUNDINGS: f64 = 8.0;
/// The most that the upper word of a product and the constants may miss.
const CUT_OFF: f64 = 7.0;
/// More bits behind the point of an addend's multiplier.
pub(crate) const MORE: u32 = 4;

/// Multipliers of a convolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Whole {
    pub multipliers: Vec<i32>,
    /// By how much sums are shifted left.
    pub shift: u32,
    pub addend: i32,
    /// The sum of zeros and a half, less 128, and the margin.
    pub base: i32,
}

impl Whole {
    /// Returns the multipliers, where whole numbers hold all values and are exact enough.
    pub fn new(conv: &Conv) -> Option<Whole> {
        let (after, offset, ending) = match conv.then {
            None => (1.0, 0.0, conv.ending),
            Some(then) => {
                let is_open = conv.ending.zero == 0.0
                    && (conv.ending.low, conv.ending.high) == (f32::NEG_INFINITY, f32::INFINITY);
                if !is_open {
                    return None;
                }
                (f64::from(then.factor), f64::from(then.shift), then.ending)
            }
        };
        let one = f64::from(FRACTION).exp2();
        let factors: Vec<f64> = conv.factor.iter().map(|factor| f64::from(*factor) * after).collect();
        let added = conv.addend.map_or(0.0, |addend| f64::from(addend.factor) * after);
        // What is left of 31 bits beside the largest sum.
        let shift = (conv.reach.max(1) as u32).leading_zeros() - 1;
        let unit = one * f64::from(32 - shift).exp2();
        let multipliers: Vec<f64> = factors.iter().map(|factor| (factor * unit).round()).collect();
        let is_full = (ending.low, ending.high) == (0.0, 255.0);
        let most = f64::from(i32::MAX);
        let in_range = multipliers.iter().all(|m| (1.0..most).contains(m));
        if !is_full || !in_range {
            return None;
        }
        let largest = factors.iter().copied().fold(0.0, f64::max);
        // No sum of whole numbers is too large.
        let bound = f64::from(conv.reach) * largest + 256.0 * added + offset.abs() + 512.0;
        // Values beyond it are cut off.
        let range = 257.0 + 256.0 * added + offset.abs() + f64::from(ending.zero);
        let of_floats = ROUNDINGS * range * (-24f64).exp2() * one;
        let of_multiplier = f64::from(conv.reach) * (f64::from(shift) - 33.0).exp2();
        let finer = f64::from(MORE).exp2();
        let of_addend = if conv.addend.is_some() { 1.0 + 128.0 / finer } else { 0.0 };
        let is_small = bound * one < most && 256.0 * added * one * finer < most;
        if !is_small || of_floats + of_multiplier + of_addend + CUT_OFF > f64::from(MARGIN) {
            return None;
        }
        let addend = (added * one * finer).round() as i32;
        let zero = conv.addend.map_or(0, |addend| i32::from(addend.zero));
        let base = ((f64::from(ending.zero) - 127.5 + offset) * one).round() as i32;
        Some(Whole {
            multipliers: multipliers.iter().map(|m| *m as i32).collect(),
            shift,
            addend,
            base: base + (((128 - zero) * addend) >> MORE) + MARGIN,
        })
    }
}
