//! Exponential and logarithm in additions and products of 32-bit floats alone: every processor, C library and compiler
//! gives the same bits, where those of the systems' libraries differ in the last one.
//!
//! `crates/firmware` prints the same operations as C. No product and sum may be fused.

use std::f32::consts::LOG2_E;

/// Adding 1.5·2²³ rounds to a whole number and leaves it in the low bits.
const ROUND: f32 = 12_582_912.0;
/// ln 2 in two parts, of which a product of the first with an exponent is exact.
pub const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
/// Below this e^x is less than the smallest normal number, and counts as 0.
pub const LEAST: f32 = -87.33;
/// Above this e^x counts as infinite, just before it is.
pub const MOST: f32 = 88.0;
/// Coefficients of e^x = 1 + x + x²·p(x), the highest power first.
pub const EXP: [f32; 6] = [1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 0.5];
/// Coefficients of ln(1 + x) = x − x²/2 + x³·p(x), the highest power first.
pub const LN: [f32; 9] = [
    7.037_683_6e-2,
    -1.151_461e-1,
    1.167_699_9e-1,
    -1.242_014_1e-1,
    1.424_932_3e-1,
    -1.666_805_8e-1,
    2.000_071_5e-1,
    -2.499_999_4e-1,
    3.333_333e-1,
];

/// Returns eˣ within 2 units in the last place; 0 where it would be below the normal numbers, and infinity above e⁸⁸. NaN
/// stays NaN.
///
/// Cody and Waite's reduction to ±ln 2 / 2 and Cephes' polynomial.
///
/// ```
/// assert_eq!(taxel_base::exponential::exp(0.0), 1.0);
/// assert_eq!(taxel_base::exponential::exp(-100.0), 0.0);
/// ```
pub fn exp(x: f32) -> f32 {
    if x < LEAST {
        return 0.0;
    }
    if x > MOST {
        return f32::INFINITY;
    }
    let shifted = x * LOG2_E + ROUND;
    let power = shifted - ROUND;
    let rest = (x - power * LN_2[0]) - power * LN_2[1];
    let polynomial = EXP[1..].iter().fold(EXP[0], |sum, coefficient| sum * rest + coefficient);
    let fraction = polynomial * rest * rest + rest + 1.0;
    fraction * f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23))
}

/// Returns the natural logarithm of a positive normal number within 2 units in the last place; that of other numbers is not
/// meant to be used.
///
/// ```
/// assert_eq!(taxel_base::exponential::ln(1.0), 0.0);
/// ```
pub fn ln(x: f32) -> f32 {
    /// The bits of √½.
    const ROOT: u32 = 0x3f35_04f3;
    let bits = x.to_bits().wrapping_sub(ROOT);
    // An exponent that brings the fraction between √½ and √2.
    let power = (bits as i32 >> 23) as f32;
    let fraction = f32::from_bits((bits & 0x007f_ffff) + ROOT) - 1.0;
    let square = fraction * fraction;
    let polynomial = LN[1..].iter().fold(LN[0], |sum, coefficient| sum * fraction + coefficient);
    let small = polynomial * fraction * square + power * LN_2[1] - 0.5 * square;
    (fraction + small) + power * LN_2[0]
}

/// Takes the softmax of one row in place; a row with NaN gives NaN. What is below the normal numbers becomes 0.
///
/// ```
/// let mut row = [0.0, 0.0];
/// taxel_base::exponential::softmax(&mut row);
/// assert_eq!(row, [0.5; 2]);
/// ```
pub fn softmax(row: &mut [f32]) {
    let largest = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    row.iter_mut().for_each(|v| *v = exp(*v - largest));
    shares(row);
}

/// Divides a row by its sum, in place. What is below the normal numbers becomes 0.
pub fn shares(row: &mut [f32]) {
    let sum = row.iter().fold(0.0, |sum, v| sum + v);
    for v in row {
        let share = *v / sum;
        *v = if share < f32::MIN_POSITIVE { 0.0 } else { share };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the distance from the double-precision value in units of the last place.
    fn units(found: f32, wanted: f64) -> f64 {
        let exponent = wanted.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor();
        (f64::from(found) - wanted).abs() / (exponent - 23.0).exp2()
    }

    #[test]
    fn exp_is_within_two_units_everywhere() {
        let mut worst = 0.0f64;
        for i in -8_733_000..=8_800_000 {
            let x = i as f32 / 100_000.0;
            worst = worst.max(units(exp(x), f64::from(x).exp()));
        }
        for bits in (0..0x42b0_0000u32).step_by(if cfg!(miri) { 1 << 20 } else { 97 }) {
            let x = -f32::from_bits(bits);
            if x >= LEAST {
                worst = worst.max(units(exp(x), f64::from(x).exp()));
            }
        }
        assert!(worst < 2.0, "{worst} units");
    }

    #[test]
    fn exp_ends_where_the_normal_numbers_do() {
        assert!(exp(LEAST) >= f32::MIN_POSITIVE && exp(f32::NEG_INFINITY) == 0.0);
        assert!(exp(MOST).is_finite() && exp(88.1) == f32::INFINITY && exp(f32::NAN).is_nan());
        assert_eq!([exp(0.0), exp(-0.0)], [1.0; 2]);
    }

    #[test]
    fn ln_is_within_two_units_everywhere() {
        let mut worst = 0.0f64;
        for bits in (0x0080_0000..0x7f80_0000u32).step_by(if cfg!(miri) { 1 << 20 } else { 101 }) {
            let x = f32::from_bits(bits);
            let wanted = f64::from(x).ln();
            // Near 1 the value itself is small.
            let error = if (x - 1.0).abs() < 0.3 {
                units(ln(x), wanted).min((f64::from(ln(x)) - wanted).abs() / f64::from(f32::EPSILON / 8.0))
            } else {
                units(ln(x), wanted)
            };
            worst = worst.max(error);
        }
        assert!(worst < 2.0, "{worst} units");
    }

    #[test]
    fn shares_add_up_and_hide_no_nan() {
        let mut row = [1.0, 2.0, -200.0];
        softmax(&mut row);
        assert!((row[0] + row[1] - 1.0).abs() < 1e-6 && row[2] == 0.0, "{row:?}");
        let mut row = [1.0, f32::NAN];
        softmax(&mut row);
        assert!(row.iter().all(|v| v.is_nan()), "{row:?}");
    }
}
