//! How long one prediction takes.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::metrics::quantile;

/// Times of one sample, one after the other on one thread, from the shortest to the longest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Latency {
    /// Half of the runs took no longer, in ms.
    pub p50_ms: f64,
    /// 95 % of the runs took no longer, in ms.
    pub p95_ms: f64,
    /// Timed runs.
    pub runs: usize,
}

/// How often something is timed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stopwatch {
    /// Runs before any is timed.
    pub warm_up: usize,
    /// Timed runs, where the budget allows.
    pub runs: usize,
    /// The least timed runs, whatever they cost.
    pub least: usize,
    /// Seconds, after which no more than the least runs are made; a tenth of them for warming up.
    pub budget: f64,
}

impl Latency {
    /// Computes the latency from times in ms.
    pub fn of(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        let runs = times.len();
        Latency { p50_ms: quantile(&times, 0.5), p95_ms: quantile(&times, 0.95), runs }
    }
}

impl Stopwatch {
    /// Calls `run` with the number of the run, and gives back what the timed runs say.
    ///
    /// # Errors
    /// The first error of `run`.
    pub fn time<T, E>(&self, mut run: impl FnMut(usize) -> Result<T, E>) -> Result<Vec<T>, E> {
        let begin = Instant::now();
        let spent = || begin.elapsed().as_secs_f64();
        let mut number = 0;
        while number < self.warm_up && (number == 0 || spent() < self.budget / 10.0) {
            run(number)?;
            number += 1;
        }
        let mut timed = vec![];
        while timed.len() < self.runs && (timed.len() < self.least || spent() < self.budget) {
            timed.push(run(number)?);
            number += 1;
        }
        Ok(timed)
    }
}

/// Milliseconds that `work` takes.
pub fn milliseconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let done = std::hint::black_box(work());
    (1e3 * start.elapsed().as_secs_f64(), done)
}
