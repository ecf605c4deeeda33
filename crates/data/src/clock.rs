//! Time stamps: their rate, and recordings brought to equal steps.

use std::fmt::{self, Display, Formatter};

/// Stamps count as regular while they stay within this share of a step of equal steps, earliest to latest.
const JITTER: f64 = 0.2;

/// The steps from one time stamp to the next, in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Timing {
    /// Of regular stamps the mean step, of irregular ones the median.
    pub step: f64,
    pub is_regular: bool,
    shortest: f64,
    longest: f64,
}

impl Timing {
    /// Of recordings whose stamps rise; none where no recording has two readings.
    pub fn of(recordings: &[&[f64]]) -> Option<Self> {
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
        Some(Self { step: if is_regular { mean } else { median }, is_regular, shortest, longest })
    }

    /// Readings per second (Hz), to six digits: stamps are no better.
    pub fn rate(&self) -> f64 {
        let rate = 1.0 / self.step;
        let scale = 10f64.powi(5 - rate.log10().floor() as i32);
        (rate * scale).round() / scale
    }

    /// Number of equal steps' readings from the first stamp to the last.
    pub fn readings(&self, times: &[f64]) -> f64 {
        let [first, last] = [times.first(), times.last()].map(|time| time.copied().unwrap_or(0.0));
        // A last stamp that is on the grid but for rounding is not lost.
        ((last - first) / self.step + 1e-6).floor() + 1.0
    }

    /// Linear interpolation at equal steps from the first stamp: `values` `[time, channels]` become
    /// `[channels, readings]`.
    pub fn resampled(&self, times: &[f64], values: &[f32], channels: usize) -> Vec<f32> {
        let readings = self.readings(times) as usize;
        let mut out = vec![0.0; readings * channels];
        let mut after = 1;
        for i in 0..readings {
            let time = times[0] + i as f64 * self.step;
            while after + 1 < times.len() && times[after] < time {
                after += 1;
            }
            let next = after.min(times.len() - 1);
            let before = next.saturating_sub(1);
            let span = times[next] - times[before];
            let share = if span > 0.0 { ((time - times[before]) / span).min(1.0) } else { 0.0 };
            for channel in 0..channels {
                let at = |row: usize| f64::from(values[row * channels + channel]);
                let [a, b] = [at(before), at(next)];
                // Also where the next reading is no number.
                let value = if share == 0.0 { a } else { a + (b - a) * share };
                out[channel * readings + i] = value as f32;
            }
        }
        out
    }
}

impl Display for Timing {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let rate = self.rate();
        if self.is_regular {
            return write!(f, "time stamps give {rate} Hz");
        }
        let [shortest, longest] = [self.shortest, self.longest].map(|step| format!("{:.3}", step * 1e3));
        write!(
            f,
            "time stamps are irregular, {shortest} to {longest} ms apart: linearly interpolated to {rate} Hz, \
             the median step"
        )
    }
}
