//! The latencies of predictions, in memory of a fixed size.

use std::time::Duration;

/// Neighbouring bins are so many times apart.
const STEP: f64 = 1.01;
/// Where the first bin begins, in seconds.
const LEAST: f64 = 1e-7;
/// Bins up to some 46 minutes.
const BINS: usize = 2400;

/// A histogram of durations that is right to 1 %, from 0.1 µs on.
#[derive(Debug, Clone)]
pub struct LatencyHistogram {
    bins: Vec<u64>,
    count: u64,
    most: Duration,
}

impl Default for LatencyHistogram {
    fn default() -> Self {
        LatencyHistogram { bins: vec![0; BINS], count: 0, most: Duration::ZERO }
    }
}

impl LatencyHistogram {
    /// Adds a duration.
    pub fn push(&mut self, duration: Duration) {
        let bin = (duration.as_secs_f64() / LEAST).max(1.0).ln() / STEP.ln();
        self.bins[(bin as usize).min(BINS - 1)] += 1;
        self.count += 1;
        self.most = self.most.max(duration);
    }

    /// Counts the durations.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the longest, in ms.
    pub fn most_ms(&self) -> f64 {
        self.most.as_nanos() as f64 / 1e6
    }

    /// Returns the time that a share of them, 0 to 1, did not exceed, in ms, to 1 %; none of no durations.
    pub fn quantile_ms(&self, share: f64) -> Option<f64> {
        let rank = (share * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let reached = |bin: &u64| {
            seen += bin;
            seen >= rank
        };
        let bin = self.bins.iter().position(reached).filter(|_| self.count > 0)?;
        Some((1e3 * LEAST * STEP.powi(bin as i32 + 1)).min(self.most_ms()))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_a_hundredth() {
        let mut spread = LatencyHistogram::default();
        assert_eq!(spread.quantile_ms(0.5), None);
        (1..=1000).for_each(|i| spread.push(Duration::from_micros(i)));
        for (share, ms) in [(0.5, 0.5), (0.99, 0.99), (0.0, 0.001), (1.0, 1.0)] {
            let quantile = spread.quantile_ms(share).unwrap();
            assert!((quantile / ms - 1.0).abs() < 0.011, "{share}: {quantile}");
        }
        spread.push(Duration::from_secs(100_000));
        assert_eq!((spread.count(), spread.most_ms()), (1001, 1e8));
        spread.push(Duration::ZERO);
    }
}
