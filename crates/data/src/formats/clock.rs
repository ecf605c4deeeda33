//! Measures the rate of time stamps, and brings recordings to equal steps.

use crate::formats::stamps::Plain;
use std::fmt::{self, Display, Formatter};

/// Largest distance of regular stamps from equal steps, earliest to latest, as a share of a step.
const JITTER: f64 = 0.2;
/// Most times that recordings may grow when they are brought to equal steps, beyond the first few time steps.
const GAPS: f64 = 16.0;
const FEW: f64 = 4096.0;

/// Seconds from one time step to the next; outside of them, numbers are no time stamps.
const STEPS: std::ops::Range<f64> = 1e-12..1e12;

/// Largest relative distance of the rate of regular stamps from the wanted one: clocks are no better.
const CLOCK: f64 = 0.01;

/// Largest relative difference of two rates that is no other sensor: clocks and rounding.
pub(crate) const RATE_TOLERANCE: f64 = 0.02;

/// The steps from one time stamp to the next, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Timing {
    /// The wanted step; where none is wanted, of regular stamps the mean, of irregular ones the median.
    pub step: f64,
    /// Recordings are taken as they are.
    pub is_regular: bool,
    /// The rate (Hz) that is wanted.
    wanted: Option<f64>,
    shortest: f64,
    longest: f64,
}

impl Timing {
    /// Measures recordings whose stamps rise, for the `wanted` rate (Hz) or their own; none where no recording has two time
    /// steps.
    pub fn of(recordings: &[&[f64]], wanted: Option<f64>) -> Option<Self> {
        let mut steps: Vec<f64> =
            recordings.iter().flat_map(|times| times.windows(2).map(|pair| pair[1] - pair[0])).collect();
        steps.sort_by(f64::total_cmp);
        let (shortest, longest) = (*steps.first()?, *steps.last()?);
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        let is_regular = recordings.iter().all(|times| {
            let off = times.iter().enumerate().map(|(i, time)| time - times[0] - i as f64 * mean);
            let (low, high) = off.fold((0.0f64, 0.0f64), |(low, high), off| (low.min(off), high.max(off)));
            high - low <= JITTER * mean
        });
        let middle = steps.len() / 2;
        let median = match steps.len() % 2 {
            0 => (steps[middle - 1] + steps[middle]) / 2.0,
            _ => steps[middle],
        };
        let step = if is_regular { mean } else { median };
        Some(match wanted {
            None => Self { step, is_regular, wanted, shortest, longest },
            Some(rate) => {
                let is_regular = is_regular && (step * rate - 1.0).abs() <= CLOCK;
                Self { step: 1.0 / rate, is_regular, wanted, shortest, longest }
            }
        })
    }

    /// Checks whether the step is one of time stamps.
    pub fn is_likely(&self) -> bool {
        STEPS.contains(&self.step)
    }

    /// Returns the time steps per second (Hz), to six digits: stamps are no better.
    pub fn rate(&self) -> f64 {
        let rate = self.wanted.unwrap_or(1.0 / self.step);
        let scale = 10f64.powi(5 - rate.log10().floor() as i32);
        (rate * scale).round() / scale
    }

    /// Counts the equal steps from the first stamp to the last.
    pub fn readings(&self, times: &[f64]) -> f64 {
        let [first, last] = [times.first(), times.last()].map(|time| time.copied().unwrap_or(0.0));
        // A last stamp that is on the grid but for rounding is not lost.
        ((last - first) / self.step + 1e-6).floor() + 1.0
    }

    /// Says why recordings are not brought to equal steps: most of the result would be gaps. None where they are.
    pub fn gaps(&self, recordings: &[&[f64]]) -> Option<String> {
        let have: usize = recordings.iter().map(|times| times.len()).sum();
        let readings: f64 = recordings.iter().map(|times| self.readings(times)).sum();
        (readings > have as f64 * GAPS + FEW).then(|| {
            format!(
                "at equal steps of {:.3} ms, {}, its {have} readings would be {:.0}, most of them in gaps of up to {:.3} s; \
                 cut the recording at its gaps",
                Plain(self.step * 1e3),
                if self.wanted.is_some() { "those of the model" } else { "the median" },
                Plain(readings),
                Plain(self.longest)
            )
        })
    }

    /// Interpolates `values` `[time, channels]` linearly at equal steps from the first stamp, and adds them to `out` as
    /// `[steps, channels]`.
    pub fn resample(&self, times: &[f64], values: &[f32], channels: usize, out: &mut Vec<f32>) {
        interpolate(times, values, channels, self.times(times), out);
    }

    /// Returns the times of equal steps from the first stamp on.
    fn times(&self, times: &[f64]) -> impl Iterator<Item = f64> + use<> {
        let (first, step) = (times[0], self.step);
        (0..self.readings(times) as usize).map(move |i| first + i as f64 * step)
    }
}

/// The place of a time between two stamps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interpolation {
    before: usize,
    next: usize,
    share: f64,
}

impl Interpolation {
    /// Interpolates a quantity that has a value at each stamp.
    pub fn value(self, at: impl Fn(usize) -> f32) -> f32 {
        let [a, b] = [self.before, self.next].map(|row| f64::from(at(row)));
        // At a stamp the next value does not count, which may be NaN.
        let value = if self.share == 0.0 { a } else { a + (b - a) * self.share };
        value as f32
    }
}

/// Appends to `out` rows `[times, channels]`: linearly interpolated at rising `times` between the rows `values`
/// `[stamps, channels]` at rising `stamps`, of which there is one at least. Beyond the ends a row is the nearest.
pub fn interpolate(
    stamps: &[f64],
    values: &[f32],
    channels: usize,
    times: impl Iterator<Item = f64>,
    out: &mut Vec<f32>,
) {
    let value = |place: Interpolation, channel| place.value(|row: usize| values[row * channels + channel]);
    places(stamps, times).for_each(|place| out.extend((0..channels).map(|channel| value(place, channel))));
}

/// Finds the places of rising `times` among rising `stamps`, of which there is one at least.
pub(crate) fn places(
    stamps: &[f64],
    times: impl Iterator<Item = f64>,
) -> impl Iterator<Item = Interpolation> {
    let mut after = 1;
    times.map(move |time| {
        while after + 1 < stamps.len() && stamps[after] < time {
            after += 1;
        }
        let next = after.min(stamps.len() - 1);
        let before = next.saturating_sub(1);
        let span = stamps[next] - stamps[before];
        let share = if span > 0.0 { ((time - stamps[before]) / span).clamp(0.0, 1.0) } else { 0.0 };
        Interpolation { before, next, share }
    })
}

impl Display for Timing {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let rate = self.rate();
        if self.is_regular {
            return write!(f, "time stamps give {rate} Hz");
        }
        let [shortest, longest] =
            [self.shortest, self.longest].map(|step| format!("{:.3}", Plain(step * 1e3)));
        let whose = if self.wanted.is_some() { "the model's rate" } else { "the median step" };
        write!(
            f,
            "time stamps are irregular, {shortest} to {longest} ms apart: linearly interpolated to {rate} Hz, {whose}"
        )
    }
}
