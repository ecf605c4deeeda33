//! How fast one sample gets its answer, measured on this machine.

use std::time::Instant;

use ndarray::Axis;
use serde::{Deserialize, Serialize};
use taxel_trainer::FoldKey;
use taxel_trainer::metrics::quantile;

use crate::case::Case;
use crate::error::Result;

/// Runs before any is timed.
const WARM_UP: usize = 50;
/// Timed runs, where the budget allows.
const RUNS: usize = 1000;
/// The least timed runs, whatever they cost.
const LEAST: usize = 5;

/// Times of one sample on one thread, batch 1, and of whole batches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// The network alone: half of the runs took no longer, in ms.
    pub p50_ms: f64,
    /// The network alone: 95 % of the runs took no longer, in ms.
    pub p95_ms: f64,
    /// Encoding of one sample alone, median in ms.
    pub encoding_p50_ms: f64,
    /// From raw reading to probabilities, median in ms.
    pub whole_p50_ms: f64,
    /// From raw reading to probabilities, 95 % of the runs, in ms.
    pub whole_p95_ms: f64,
    /// Timed runs of each; 1000, or as many as fit in the budget.
    pub runs: usize,
    /// Encoded samples per second, in batches of `batch` on one thread.
    pub samples_per_second: f64,
    /// The batch of training.
    pub batch: usize,
}

impl Speed {
    /// Times the model of `key` on test samples, one after the other: 1000 runs after 50 to warm up, fewer
    /// where that would take longer than `budget` seconds; then whole batches for a tenth of it.
    ///
    /// # Errors
    /// A model that is missing or damaged.
    pub fn measure(case: &Case, key: &FoldKey, budget: f64) -> Result<Self> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        match pool {
            Ok(pool) => pool.install(|| measure(case, key, budget)),
            Err(_) => measure(case, key, budget),
        }
    }
}

fn measure(case: &Case, key: &FoldKey, budget: f64) -> Result<Speed> {
    let source = &case.samples.source;
    let rows = case.folder.record(key)?.map_or(vec![0], |record| record.index);
    let mut model = case.predictor(key, 1, 1)?;
    let samples: Vec<_> = rows.iter().take(RUNS).map(|&row| case.samples.x.select(Axis(0), &[row])).collect();
    let begin = Instant::now();
    let spent = || begin.elapsed().as_secs_f64();
    let (mut encoding, mut network, mut whole) = (vec![], vec![], vec![]);
    for run in 0..WARM_UP + RUNS {
        let warm = if spent() < budget / 10.0 { WARM_UP } else { WARM_UP.min(run) };
        if spent() > budget && whole.len() >= LEAST {
            break;
        }
        let start = Instant::now();
        let inputs = model.encode(&samples[run % samples.len()], source)?;
        let encoded = Instant::now();
        std::hint::black_box(model.answer(&inputs)?);
        let done = Instant::now();
        if run >= warm {
            let ms = |from: Instant, to: Instant| 1e3 * (to - from).as_secs_f64();
            encoding.push(ms(start, encoded));
            network.push(ms(encoded, done));
            whole.push(ms(start, done));
        }
    }
    for times in [&mut encoding, &mut network, &mut whole] {
        times.sort_by(f64::total_cmp);
    }
    let batch = case.batch(&key.network).min(rows.len());
    let mut model = case.predictor(key, batch, 1)?;
    let inputs = model.encode(&case.samples.x.select(Axis(0), &rows[..batch]), source)?;
    model.answer(&inputs)?;
    let (start, mut batches) = (Instant::now(), 0);
    while batches < LEAST || (start.elapsed().as_secs_f64() < budget / 10.0 && batches < RUNS) {
        std::hint::black_box(model.answer(&inputs)?);
        batches += 1;
        if start.elapsed().as_secs_f64() > budget {
            break;
        }
    }
    Ok(Speed {
        p50_ms: quantile(&network, 0.5),
        p95_ms: quantile(&network, 0.95),
        encoding_p50_ms: quantile(&encoding, 0.5),
        whole_p50_ms: quantile(&whole, 0.5),
        whole_p95_ms: quantile(&whole, 0.95),
        runs: whole.len(),
        samples_per_second: (batches * batch) as f64 / start.elapsed().as_secs_f64(),
        batch,
    })
}
