//! A series in few numbers, channel after channel.

use rayon::prelude::*;

use crate::{FeatureMatrix, Series};

/// Steps before the last one to which [`summary`] takes differences, as far as the series is so long.
const LAGS: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// Returns the number of features that [`summary`] writes for series of `shape` (channels, length).
pub(crate) fn summary_width([channels, length]: [usize; 2]) -> usize {
    let lags = LAGS.iter().filter(|lag| **lag < length).count();
    channels * if length > 1 { 5 + lags } else { 1 }
}

/// Writes features of one recording of channels of `length`, channel after channel: the last step, its differences to 1, 2,
/// 4, 8, 16 and 32 steps before, mean, SD (of the population), minimum and maximum over time, in the unit of the readings. A
/// series of one step gives that alone.
pub(crate) fn summary(recording: &[f32], length: usize, features: &mut [f32]) {
    let each = features.len() / (recording.len() / length).max(1);
    for (channel, features) in recording.chunks_exact(length).zip(features.chunks_exact_mut(each)) {
        let last = channel[length - 1];
        features[0] = last;
        if length == 1 {
            continue;
        }
        let (differences, whole) = features[1..].split_at_mut(each - 5);
        for (difference, lag) in differences.iter_mut().zip(LAGS) {
            // Finite, as the readings are.
            *difference = (last - channel[length - 1 - lag]).clamp(f32::MIN, f32::MAX);
        }
        let mean = mean(channel);
        let square = channel.iter().map(|value| (f64::from(*value) - mean).powi(2)).sum::<f64>();
        whole[0] = mean as f32;
        whole[1] = (square / length as f64).sqrt() as f32;
        whole[2] = channel.iter().copied().fold(f32::INFINITY, f32::min);
        whole[3] = channel.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    }
}

/// Writes the last step of every channel, then the mean over time of every channel: `[2 × channels]`, in the unit of the
/// readings.
pub(crate) fn levels(recording: &[f32], length: usize, features: &mut [f32]) {
    let (last, means) = features.split_at_mut(features.len() / 2);
    for ((channel, last), level) in recording.chunks_exact(length).zip(last).zip(means) {
        *last = channel[length - 1];
        *level = mean(channel) as f32;
    }
}

/// Makes a matrix `[n, width]` of what `write` says of each recording, which gets a row and makes its memory by `memory`.
pub(crate) fn each_recording<M>(
    x: &Series,
    width: usize,
    memory: impl Fn() -> M + Sync + Send,
    write: impl Fn(&mut M, &[f32], &mut [f32]) + Sync + Send,
) -> FeatureMatrix {
    let mut values = vec![0.0; x.len() * width];
    values
        .par_chunks_exact_mut(width)
        .enumerate()
        .for_each_init(memory, |memory, (i, row)| write(memory, x.sample(i), row));
    FeatureMatrix::new(values, width).weighted(x.weights)
}

fn mean(channel: &[f32]) -> f64 {
    channel.iter().map(|value| f64::from(*value)).sum::<f64>() / channel.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_is_told_by_its_end_its_changes_and_its_spread() {
        let recording = [1.0, 2.0, 4.0, 8.0, 0.0, 0.0, 0.0, 4.0];
        assert_eq!(summary_width([2, 4]), 14);
        let mut features = [f32::NAN; 14];
        summary(&recording, 4, &mut features);
        // Differences to one and two steps before; four before is not there.
        let sd = |squares: f64| (squares / 4.0).sqrt() as f32;
        let first = [8.0, 4.0, 6.0, 3.75, sd(2.75 * 2.75 + 1.75 * 1.75 + 0.0625 + 4.25 * 4.25), 1.0, 8.0];
        let second = [4.0, 4.0, 4.0, 1.0, sd(12.0), 0.0, 4.0];
        assert_eq!(features, [first, second].concat()[..]);
        let mut level = [f32::NAN; 4];
        levels(&recording, 4, &mut level);
        assert_eq!(level, [8.0, 4.0, 3.75, 1.0]);
        let mut alone = [f32::NAN; 3];
        assert_eq!((summary_width([3, 1]), summary_width([1, 33])), (3, 11));
        summary(&[5.0, 6.0, 7.0], 1, &mut alone);
        assert_eq!(alone, [5.0, 6.0, 7.0]);
    }
}
