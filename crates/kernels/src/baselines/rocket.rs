//! MiniRocket's convolutions, and how often each lies above its thresholds.
//!
//! Sums are taken in the order of channels and taps, whatever the width of the vectors: products by 2 and −1 are exact,
//! so every CPU finds the same values and the same counts.

use std::ops::Range;

use crate::buffer::Buffer;
use crate::lengths::{at_least, exactly};
use crate::simd::{Simd, at_level, level};

/// Length of a kernel.
const TAPS: usize = 9;
/// Recordings have fewer readings: counts are floats.
pub const LONGEST: usize = 1 << 24;
/// Vectors of positions that are convolved side by side.
const WIDE: usize = 4;
/// Values beyond the end of a row that vectors may touch: of the widest level.
const SLACK: usize = WIDE * 16;
/// Counts that run side by side, so that additions do not wait for each other.
const SIDE: usize = 4;

/// A convolution of one recording: −1 at nine places, 2 at three of them, summed over some channels; zeros beyond the
/// ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Dilated {
    /// Distance of neighbouring places.
    pub dilation: usize,
    /// Places of weight 2, each below 9.
    pub twos: [usize; 3],
    /// Channels that are read.
    pub channels: Vec<usize>,
    /// Thresholds.
    pub biases: Vec<f32>,
    /// Positions that are counted.
    pub counted: Range<usize>,
}

/// Convolutions of recordings of one shape, with the order of their thresholds in vectors.
#[derive(Debug, Clone, PartialEq)]
pub struct Rocket {
    channels: usize,
    length: usize,
    /// Zeros before and after the values of a channel.
    margin: usize,
    /// Distance of neighbouring channels.
    row: usize,
    convolutions: Vec<Dilated>,
    /// Thresholds of each convolution, filled up with infinity to whole vectors.
    biases: Vec<f32>,
    features: usize,
}

/// Memory for the features of one recording after the other.
#[derive(Debug)]
pub struct RocketMemory {
    padded: Buffer,
    output: Buffer,
    counts: Buffer,
}

impl Rocket {
    /// Makes the convolutions of recordings of `channels` × `length`.
    pub fn new(channels: usize, length: usize, convolutions: Vec<Dilated>) -> Self {
        let lanes = level().lanes();
        for convolution in &convolutions {
            assert!(
                convolution.channels.iter().all(|&channel| channel < channels),
                "a channel that there is not"
            );
            assert!(convolution.twos.iter().all(|&place| place < TAPS), "a place outside the kernel");
            assert!(
                convolution.counted.start < convolution.counted.end && convolution.counted.end <= length,
                "positions outside"
            );
            assert!(convolution.dilation <= length, "a dilation beyond the recording");
        }
        assert!(length < LONGEST, "recordings of {length} readings");
        let margin =
            TAPS / 2 * convolutions.iter().map(|convolution| convolution.dilation).max().unwrap_or(0);
        let mut biases = vec![];
        for convolution in &convolutions {
            biases.extend_from_slice(&convolution.biases);
            biases.resize(biases.len().next_multiple_of(lanes), f32::INFINITY);
        }
        let features = convolutions.iter().map(|convolution| convolution.biases.len()).sum();
        let row = margin + length + SLACK + margin;
        Rocket { channels, length, margin, row, convolutions, biases, features }
    }

    /// Returns the convolutions.
    pub fn convolutions(&self) -> &[Dilated] {
        &self.convolutions
    }

    /// Makes the memory for one thread.
    pub fn work(&self) -> RocketMemory {
        let most = self.convolutions.iter().map(|convolution| convolution.biases.len()).max().unwrap_or(0);
        RocketMemory {
            padded: Buffer::zeros(self.channels * self.row),
            output: Buffer::zeros(self.length + SLACK),
            counts: Buffer::zeros(most + SLACK),
        }
    }

    /// Computes the share of the counted positions at which each convolution of `recording`, channel after channel,
    /// lies above each of its thresholds.
    pub fn shares(&self, recording: &[f32], work: &mut RocketMemory, features: &mut [f32]) {
        self.pad(recording, work);
        exactly("features", features.len(), self.features);
        shares(self, work, features);
    }

    /// Computes the values of convolution number `which` of `recording`, one per position.
    pub fn convolve(&self, which: usize, recording: &[f32], work: &mut RocketMemory, output: &mut [f32]) {
        exactly("output of a convolution", output.len(), self.length);
        self.pad(recording, work);
        convolve(self, which, work);
        output.copy_from_slice(&work.output[..self.length]);
    }

    /// Returns the number of thresholds of all convolutions.
    pub fn features(&self) -> usize {
        self.features
    }

    fn pad(&self, recording: &[f32], work: &mut RocketMemory) {
        exactly("recording", recording.len(), self.channels * self.length);
        exactly("padded recording", work.padded.len(), self.channels * self.row);
        let rows = work.padded.chunks_exact_mut(self.row).zip(recording.chunks_exact(self.length));
        rows.for_each(|(row, values)| row[self.margin..][..self.length].copy_from_slice(values));
    }
}

at_level! {
    fn shares(rocket: &Rocket, work: &mut RocketMemory, features: &mut [f32]) = shares_at
}
at_level! {
    fn convolve(rocket: &Rocket, which: usize, work: &mut RocketMemory) = convolve_at
}

/// Computes [`Rocket::shares`] of the padded recording in `work`, with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`, for whose vectors the rocket was made.
#[inline(always)]
unsafe fn shares_at<S: Simd>(rocket: &Rocket, work: &mut RocketMemory, mut features: &mut [f32]) {
    let mut biases = rocket.biases.as_slice();
    for (which, convolution) in rocket.convolutions.iter().enumerate() {
        // SAFETY: the caller has checked the features.
        unsafe { convolve_at::<S>(rocket, which, work) };
        let count = convolution.biases.len();
        let (first, rest) = biases.split_at(count.next_multiple_of(S::LANES));
        biases = rest;
        let values = &work.output[convolution.counted.clone()];
        let counts = &mut work.counts[..first.len()];
        // SAFETY: as above; there is a count for every threshold.
        unsafe { counts_at::<S>(values, first, counts) };
        let positions = values.len() as f64;
        let (to, rest) = features.split_at_mut(count);
        features = rest;
        to.iter_mut().zip(counts).for_each(|(to, n)| *to = (f64::from(*n) / positions) as f32);
    }
}

/// Writes the values of a convolution at all positions, and some more, to `work.output`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn convolve_at<S: Simd>(rocket: &Rocket, which: usize, work: &mut RocketMemory) {
    let Rocket { channels, length, margin, row, convolutions, .. } = rocket;
    let Dilated { dilation, twos, channels: read, .. } = &convolutions[which];
    let step = WIDE * S::LANES;
    at_least("padded recording", work.padded.len(), channels * row);
    at_least("output of a convolution", work.output.len(), length + SLACK);
    let (padded, output) = (work.padded.as_ptr(), work.output.as_mut_ptr());
    for t in (0..*length).step_by(step) {
        // SAFETY: the lengths are asserted above. A block begins at t < length and is no longer than `SLACK`, so it ends
        // inside the output and, `margin` (which no tap reaches beyond) before and after, inside its padded row.
        unsafe {
            let mut sums = [S::splat(0.0); WIDE];
            for channel in read {
                let from = padded.add(channel * row + t + margin - TAPS / 2 * dilation);
                for tap in 0..TAPS {
                    let weight = S::splat(if twos.contains(&tap) { 2.0 } else { -1.0 });
                    for (v, sum) in sums.iter_mut().enumerate() {
                        let x = S::load(from.add(tap * dilation + v * S::LANES));
                        *sum = S::fma(weight, x, *sum);
                    }
                }
            }
            for (v, sum) in sums.iter().enumerate() {
                S::store(output.add(t + v * S::LANES), *sum);
            }
        }
    }
}

/// Counts how many of `values` lie above each of `limits`, which are whole vectors.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn counts_at<S: Simd>(values: &[f32], limits: &[f32], counts: &mut [f32]) {
    let mut at = 0;
    while at < limits.len() {
        let left = (limits.len() - at) / S::LANES;
        let (limits, counts) = (&limits[at..], &mut counts[at..]);
        // SAFETY: the caller has checked the features; so many whole vectors are left.
        at += S::LANES
            * unsafe {
                match left {
                    4.. => block::<S, 4, 1>(values, limits, counts),
                    2.. => block::<S, 2, 2>(values, limits, counts),
                    _ => block::<S, 1, 4>(values, limits, counts),
                }
            };
    }
}

/// Counts for `N` vectors of limits, in `U` sums that each take every `U`-th value; returns `N`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn block<S: Simd, const N: usize, const U: usize>(
    values: &[f32],
    limits: &[f32],
    counts: &mut [f32],
) -> usize {
    const { assert!(N * U == SIDE) };
    at_least("limits", limits.len(), N * S::LANES);
    at_least("counts", counts.len(), N * S::LANES);
    // SAFETY: the lengths are asserted above.
    unsafe {
        let mut bounds = [S::splat(0.0); N];
        bounds.iter_mut().enumerate().for_each(|(n, v)| *v = S::load(limits.as_ptr().add(n * S::LANES)));
        let mut sums = [[S::splat(0.0); N]; U];
        let (blocks, rest) = values.as_chunks::<U>();
        for block in blocks {
            for (sums, value) in sums.iter_mut().zip(block) {
                let value = S::splat(*value);
                sums.iter_mut()
                    .zip(&bounds)
                    .for_each(|(sum, limit)| *sum = S::count_above(*sum, value, *limit));
            }
        }
        for value in rest {
            let value = S::splat(*value);
            sums[0]
                .iter_mut()
                .zip(&bounds)
                .for_each(|(sum, limit)| *sum = S::count_above(*sum, value, *limit));
        }
        for n in 0..N {
            let mut sum = sums[0][n];
            sums[1..].iter().for_each(|sums| sum = S::add(sum, sums[n]));
            S::store(counts.as_mut_ptr().add(n * S::LANES), sum);
        }
    }
    N
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes a convolution by the definition, one value at a time.
    fn plainly(convolution: &Dilated, recording: &[f32], length: usize) -> Vec<f32> {
        let mut output = vec![0.0f32; length];
        for &channel in &convolution.channels {
            let values = &recording[channel * length..][..length];
            for tap in 0..TAPS {
                let weight = if convolution.twos.contains(&tap) { 2.0 } else { -1.0 };
                for (t, sum) in output.iter_mut().enumerate() {
                    let at = (t + tap * convolution.dilation).checked_sub(TAPS / 2 * convolution.dilation);
                    if let Some(value) = at.and_then(|at| values.get(at)) {
                        *sum += weight * value;
                    }
                }
            }
        }
        output
    }

    #[test]
    fn every_value_and_every_count_is_that_of_the_definition() {
        let lengths = [17, 9, 15, 16, 50, 64, 65, 75, 130];
        for length in lengths.into_iter().take(if cfg!(miri) { 1 } else { 9 }) {
            let channels = 3;
            let wave = |i: usize| ((i * 37 % 101) as f32 * 0.37 - 18.0).sin() * 1.7;
            let recording: Vec<f32> = (0..channels * length).map(wave).collect();
            let one = |i: usize| {
                let dilation = 1 + i % ((length - 1) / 8).max(1);
                let inner = if i.is_multiple_of(2) { 0 } else { TAPS / 2 * dilation };
                Dilated {
                    dilation,
                    twos: [i % 3, 3 + i % 2, 6 + i % 3],
                    channels: (0..1 + i % channels).rev().collect(),
                    biases: (0..i * 5 % 71).map(|b| wave(b * 13 + i)).collect(),
                    counted: inner..length - inner,
                }
            };
            let rocket = Rocket::new(channels, length, (0..30).map(one).collect());
            let mut features = vec![0.0; rocket.features];
            let (mut work, mut output) = (rocket.work(), vec![0.0; length]);
            // Twice: nothing of a recording may be left for the next.
            for _ in 0..2 {
                rocket.shares(&recording, &mut work, &mut features);
            }
            let mut got = features.iter();
            for (which, convolution) in rocket.convolutions().iter().enumerate() {
                let want = plainly(convolution, &recording, length);
                rocket.convolve(which, &recording, &mut work, &mut output);
                assert_eq!(output, want, "length {length}, convolution {which}");
                for bias in &convolution.biases {
                    let above = want[convolution.counted.clone()].iter().filter(|v| *v > bias).count();
                    let share = (above as f64 / convolution.counted.len() as f64) as f32;
                    assert_eq!(got.next().copied(), Some(share), "length {length}, convolution {which}");
                }
            }
        }
    }
}
