//! Finds channels whose signal is lost where numbers of 64 bits become f32.
//!
//! f32 holds seven digits. A signal of 0.01 on an offset of a million is rounded away, and the rest looks like steps.

use std::fmt::{self, Display, Formatter};

/// Largest error of rounding, as a share of the spread of a channel, that leaves its signal as it is.
const LOST: f64 = 1e-3;
/// A spread below this share of the values is the rounding of f64 itself: the channel does not change.
const CONSTANT: f64 = 1e-12;
/// Most channels that are watched one by one; those beyond share one.
const CHANNELS: usize = 1 << 16;

/// Up to here f64 holds every whole number.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// Checks whether a number is whole and f32 does not hold it: above 2^24 not every one.
pub(crate) fn is_rounded_whole(value: f64) -> bool {
    value.fract() == 0.0 && value.abs() <= WHOLE && f64::from(value as f32) != value
}

/// Watches numbers of 64 bits, channel by channel.
#[derive(Debug, Default)]
pub(crate) struct Precision {
    channels: Vec<Seen>,
}

#[derive(Debug, Clone, Copy)]
struct Seen {
    low: f64,
    high: f64,
    /// The largest error of rounding so far.
    error: f64,
}

/// A channel whose signal f32 does not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lossy {
    pub channel: usize,
    low: f64,
    high: f64,
    error: f64,
}

impl Precision {
    /// Rounds a value to f32, and watches what is lost.
    pub fn rounded(&mut self, channel: usize, value: f64) -> f32 {
        let short = value as f32;
        self.see(channel, value, short);
        short
    }

    /// Watches a value and what it becomes. Values that are not finite say nothing.
    pub fn see(&mut self, channel: usize, value: f64, short: f32) {
        let error = (value - f64::from(short)).abs();
        let channel = channel.min(CHANNELS);
        if !error.is_finite() {
            return;
        }
        if channel >= self.channels.len() {
            let none = Seen { low: f64::INFINITY, high: f64::NEG_INFINITY, error: 0.0 };
            self.channels.resize(channel + 1, none);
        }
        let seen = &mut self.channels[channel];
        (seen.low, seen.high) = (seen.low.min(value), seen.high.max(value));
        seen.error = seen.error.max(error);
    }

    /// Returns the first channel whose signal is lost: the error of rounding is more than a thousandth of its spread.
    pub fn lossy(&self) -> Option<Lossy> {
        self.channels.iter().enumerate().find_map(|(channel, seen)| {
            let Seen { low, high, error } = *seen;
            let spread = high - low;
            let changes = spread > CONSTANT * low.abs().max(high.abs());
            (changes && error > LOST * spread).then_some(Lossy { channel, low, high, error })
        })
    }
}

impl Display for Lossy {
    /// Says what is lost and how to fix it, after the name of the channel.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { low, high, error, .. } = self;
        write!(
            f,
            "goes from {low:?} to {high:?}, and f32, in which all is computed, is wrong there by up to {error:.1e}: its \
             signal would be lost; subtract its offset before you save it, or leave it out"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lossy(values: &[f64]) -> Option<usize> {
        let mut precision = Precision::default();
        for value in values {
            assert_eq!(precision.rounded(0, 1.5), 1.5);
            assert_eq!(precision.rounded(1, *value).to_bits(), (*value as f32).to_bits());
        }
        precision.lossy().map(|lossy| lossy.channel)
    }

    #[test]
    fn a_thousandth_of_the_spread_may_be_lost() {
        let ramp =
            |offset: f64, step: f64| (0..100).map(|i| offset + step * f64::from(i)).collect::<Vec<_>>();
        assert_eq!(lossy(&ramp(1e6, 0.01)), Some(1), "up to 0.03 of 1");
        assert_eq!(lossy(&ramp(1e6, 1.0)), None, "whole numbers are exact");
        assert_eq!(lossy(&ramp(1e5, 0.37)), None, "0.004 of 37");
        assert_eq!(lossy(&ramp(1.7e9, 0.01)), Some(1), "seconds since 1970");
        assert_eq!(lossy(&ramp(-1e6, -0.01)), Some(1));
        assert_eq!(lossy(&ramp(0.0, 1e-9)), None);
    }

    #[test]
    fn what_does_not_change_has_no_signal() {
        assert_eq!(lossy(&[0.1; 9]), None);
        assert_eq!(lossy(&[0.1, 0.1 + 1e-16, 0.1 - 1e-16]), None, "rounding of f64");
        assert_eq!(lossy(&[f64::NAN, f64::INFINITY, 1e9 + 0.1]), None);
        assert_eq!(Precision::default().lossy(), None);
    }

    #[test]
    fn channels_beyond_count_share_one() {
        let mut precision = Precision::default();
        precision.rounded(usize::MAX, 1e9);
        precision.rounded(usize::MAX - 1, 1e9 + 0.5);
        assert_eq!(precision.lossy().map(|lossy| lossy.channel), Some(CHANNELS));
        assert_eq!(precision.channels.len(), CHANNELS + 1);
    }
}
