//! How fast one sample gets its answer, measured on this machine.

use ndarray::Axis;
use taxel_data::Dataset;
use taxel_learn::{Latency, Model, Stopwatch, milliseconds};

use super::threads::alone;
use crate::error::Result;
use crate::values::Speed;

/// Runs before any is timed.
const WARM_UP: usize = 50;
/// Timed runs, where the budget allows.
const RUNS: usize = 1000;
/// The least timed runs of single samples, whatever they cost.
const LEAST: usize = 5;

/// Times `model` on the samples `rows`, one after the other on one thread: 1000 runs after 50 to warm up,
/// fewer where that would take longer than `budget` seconds; then whole batches for a tenth of it.
///
/// # Errors
/// What the model refuses.
pub fn speed(model: &Model, dataset: &Dataset, rows: &[usize], budget: f64) -> Result<Speed> {
    alone(|| timed(model, dataset, rows, budget))
}

fn timed(model: &Model, dataset: &Dataset, rows: &[usize], budget: f64) -> Result<Speed> {
    let sample = |&row: &usize| dataset.x.index_axis(Axis(0), row).iter().copied().collect();
    let samples: Vec<Vec<f32>> = rows.iter().take(RUNS).map(sample).collect();
    let single = model.predictor(1, 1)?;
    let mut workspace = single.workspace()?;
    let watch = Stopwatch { warm_up: WARM_UP, runs: RUNS, least: LEAST, budget };
    let times = watch.time(|run| {
        let (encoding, read) = milliseconds(|| single.read(&mut workspace, &samples[run % samples.len()]));
        read?;
        let (network, answer) = milliseconds(|| single.decide(&mut workspace).map(|_| ()));
        answer.map(|()| (encoding, network))
    })?;
    let latency = |part: fn(&(f64, f64)) -> f64| Latency::of(times.iter().map(part).collect());
    let batch = model.card().batch().min(rows.len());
    let many = model.predictor(batch, 1)?;
    let inputs = many.encode(&dataset.x.select(Axis(0), &rows[..batch]))?;
    let watch = Stopwatch { warm_up: 1, runs: RUNS, least: 1, budget: budget / 10.0 };
    let batches = watch.time(|_| {
        let (ms, answer) = milliseconds(|| many.answer(&inputs));
        answer.map(|_| ms)
    })?;
    let seconds = batches.iter().sum::<f64>() / 1e3;
    Ok(Speed {
        encoding: latency(|time| time.0),
        network: latency(|time| time.1),
        whole: latency(|time| time.0 + time.1),
        samples_per_second: (batches.len() * batch) as f64 / seconds,
        batch,
    })
}
