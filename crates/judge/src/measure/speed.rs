//! Time that the prediction of one sample takes on this machine.

use ndarray::{ArrayRef, Axis, IxDyn};
use taxel_learn::{Latency, Model, Stopwatch, milliseconds};

use super::threads::on;
use crate::error::Result;
use crate::values::Speed;

/// Runs before any is timed.
const WARM_UP: usize = 50;
/// Timed runs, where the budget allows.
const RUNS: usize = 1000;
/// The least timed runs of single samples, whatever they cost.
const LEAST: usize = 5;

/// Times `model` on raw samples `[n, ..]`, one after the other on one thread: 1000 runs after 50 to warm up,
/// fewer where that would take longer than `budget` seconds; then whole batches for a tenth of it.
///
/// # Errors
/// Samples that the model refuses.
pub fn speed(model: &Model, x: &ArrayRef<f32, IxDyn>, budget: f64) -> Result<Speed> {
    on(1, || timed(model, x, budget))
}

fn timed(model: &Model, x: &ArrayRef<f32, IxDyn>, budget: f64) -> Result<Speed> {
    let batch = model.card().batch().min(x.shape().first().copied().unwrap_or(0));
    let many = model.predictor(batch, 1)?;
    // Encoded first: it refuses samples of another shape by name.
    let inputs = many.encode(&x.slice_axis(Axis(0), (..batch).into()))?;
    let samples: Vec<Vec<f32>> =
        x.axis_iter(Axis(0)).take(RUNS).map(|sample| sample.iter().copied().collect()).collect();
    let single = model.predictor(1, 1)?;
    let mut workspace = single.workspace()?;
    let watch = Stopwatch { warm_up: WARM_UP, runs: RUNS, least: LEAST, budget };
    let times = watch.time(|run| {
        let (encoding, read) = milliseconds(|| single.read(&mut workspace, &samples[run % samples.len()]));
        read?;
        let (network, done) = milliseconds(|| {
            let done = single.decide(&mut workspace).map(|_| ());
            // Where the model has a gate.
            std::hint::black_box(single.familiarity(&mut workspace, 1.0));
            done
        });
        done.map(|()| (encoding, network))
    })?;
    let latency = |part: fn(&(f64, f64)) -> f64| Latency::of(times.iter().map(part).collect());
    let watch = Stopwatch { warm_up: 1, runs: RUNS, least: 1, budget: budget / 10.0 };
    let batches = watch.time(|_| {
        let (ms, done) = milliseconds(|| many.predict_encoded(&inputs));
        done.map(|_| ms)
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
