//! The numbers between exact sums and what is stored, one by one: the arithmetic that the printed C repeats, and the
//! digests by which the C is checked at every threshold.

use taxel_kernels::frozen::bytes::Ending;

/// A digest of 32-bit words (FNV-1a, low byte first), which C computes as well.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Digest(pub u32);

impl Digest {
    pub fn new() -> Self {
        Digest(0x811c_9dc5)
    }

    pub fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }
}

/// Returns the float that is stored for `value` steps.
pub(crate) fn ended(value: f32, ending: &Ending) -> f32 {
    let value = value + ending.zero;
    let value = if value > ending.low { value } else { ending.low };
    if value < ending.high { value } else { ending.high }
}

/// Returns the byte that is stored for `value` steps.
pub(crate) fn byte(value: f32, ending: &Ending) -> u8 {
    ended(value, ending).round_ties_even() as u8
}

/// Returns the steps of a sum, and of an addend where there is one.
pub(crate) fn steps(sum: i32, factor: f32, addend: Option<(u8, f32, f32)>) -> f32 {
    let value = sum as f32 * factor;
    match addend {
        None => value,
        Some((byte, zero, factor)) => value + (f32::from(byte) - zero) * factor,
    }
}

/// Adds the least sums from `-reach` to `reach` at which `byte` is at least 1, 2, .. 255 (`reach + 1` where none is) to a
/// digest. `byte` must not fall.
pub(crate) fn add_thresholds(digest: &mut Digest, reach: i32, byte: impl Fn(i32) -> u8) {
    let (mut least, mut stride) = (-reach, 0);
    for wanted in 1..=255u8 {
        let next = threshold(least, reach, stride, |sum| byte(sum) >= wanted);
        stride = i64::from(next) - i64::from(least) - 1;
        least = next;
        digest.word(least as u32);
    }
}

/// Returns the least number from `low` to `high` that is `enough`, or `high + 1`. It is looked for in wider and wider strides,
/// then by halves.
fn threshold(low: i32, high: i32, mut stride: i64, enough: impl Fn(i32) -> bool) -> i32 {
    let (mut below, mut above) = (i64::from(low) - 1, i64::from(high) + 1);
    let mut at = i64::from(low) + stride;
    while stride > 0 && at < i64::from(high) {
        if enough(at as i32) {
            above = at;
            break;
        }
        below = at;
        at += stride;
        stride *= 2;
    }
    while above - below > 1 {
        let middle = (above + below) / 2;
        if enough(middle as i32) {
            above = middle;
        } else {
            below = middle;
        }
    }
    above as i32
}

/// Returns the float at a place of their order: neighbours are neighbours, 0 is at 0.
pub(crate) fn ordered(place: i32) -> f32 {
    if place < 0 { -f32::from_bits(place.unsigned_abs()) } else { f32::from_bits(place as u32) }
}

/// The place up to which [`ordered`] floats are tried: 1.7 · 10³⁸.
pub(crate) const LARGEST: i32 = 0x7f00_0000;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use taxel_kernels::frozen::bytes::{ByteOutput, ByteScale, Conv, Sums, Target};
    use taxel_kernels::frozen::{ImagePlace, Route};
    use taxel_kernels::{Rectifier, Window3};

    use super::*;

    /// Returns the bytes that the kernel of a convolution stores for these sums: one filter for each, whose bias it is.
    fn stored(bias: &[i32], unit: f32, output: ByteScale, addend: Option<(u8, ByteScale)>) -> Vec<u8> {
        let filters = bias.len();
        let window =
            Window3 { input: [1; 3], output: [1; 3], kernel: [1; 3], stride: [1; 3], before: [0; 3] };
        let place = ImagePlace::dense([1; 3], filters);
        let sums = Sums {
            weight: &vec![0; filters],
            unit: &vec![unit; filters],
            bias,
            input: ByteScale { step: 1.0, zero: 0 },
            addend: addend.map(|(_, scale)| scale),
            output: ByteOutput::Bytes(output),
        };
        let route = Route {
            from: ImagePlace::dense([1; 3], 1),
            to: place,
            addend: addend.map(|_| place),
            rectifier: Rectifier::Relu,
        };
        let conv = Conv::new(&window, [1; 3], 1, &sums, route);
        let mut y = vec![0; filters];
        let added = addend.map(|(byte, _)| vec![byte; filters]);
        conv.run(&[0; 4], added.as_deref(), Target::Bytes(&mut y));
        y
    }

    #[test]
    fn numbers_are_those_of_the_kernels_around_every_threshold() {
        let output = ByteScale { step: 0.037, zero: 13 };
        let from = ByteScale { step: 0.021, zero: 77 };
        let written = ByteOutput::Bytes(output);
        let ending = written.ending(Rectifier::Relu);
        for unit in [1.3e-4f32, 7.7e-6, 0.011] {
            let factor = written.factor(unit);
            for added in [None, Some(0u8), Some(99), Some(255)] {
                let addend = added.map(|byte| (byte, f32::from(from.zero), written.factor(from.step)));
                let one = |sum: i32| byte(steps(sum, factor, addend), &ending);
                let reach = 1 << 26;
                let mut sums = vec![];
                for wanted in 14..=255 {
                    let least = threshold(-reach, reach, 0, |sum| one(sum) >= wanted);
                    sums.extend([least - 1, least]);
                }
                let found = stored(&sums, unit, output, added.map(|byte| (byte, from)));
                assert_eq!(found, sums.iter().map(|sum| one(*sum)).collect::<Vec<_>>());
                assert!(found.is_sorted() && found.windows(2).any(|pair| pair[0] < pair[1]));
            }
        }
    }

    #[test]
    fn ordered_floats_rise() {
        assert_eq!(ordered(0), 0.0);
        assert!(ordered(LARGEST) > 1e38 && ordered(-LARGEST) < -1e38);
        assert!([-5, -1, 0, 1, 7].map(ordered).is_sorted());
    }
}
