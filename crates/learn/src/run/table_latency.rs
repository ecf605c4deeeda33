//! The latency that stands in the table of a run: one encoded sample, batch 1, one thread.

use taxel_graph::{Graph, Weights};
use taxel_runtime::Frozen;

use crate::encoding::Input;
use crate::error::Result;
use crate::latency::{Latency, Stopwatch, milliseconds};
use crate::training::feed::Feed;

/// It costs two seconds at most.
const TABLE: Stopwatch = Stopwatch { warm_up: 20, runs: 200, least: 5, budget: 2.0 };

/// Measures the time of the sample `row` through a network.
pub(crate) fn of_network(graph: &Graph, weights: &Weights, inputs: &[Input], row: usize) -> Result<Latency> {
    let frozen = Frozen::new(graph, weights)?;
    let mut workspace = frozen.workspace();
    let mut feed = Feed::new(graph, inputs)?;
    let sample = feed.rows(&[row]);
    let run = |_| timed(|| Ok(frozen.predict(&mut workspace, &sample)?[0]));
    Ok(Latency::of(TABLE.time(run)?))
}

/// Times `predict`, which predicts one sample.
pub(crate) fn of_prediction(mut predict: impl FnMut() -> Result<()>) -> Result<Latency> {
    Ok(Latency::of(TABLE.time(|_| timed(&mut predict))?))
}

/// Milliseconds of something that may fail.
fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<f64> {
    let (ms, done) = milliseconds(work);
    done.map(|_| ms)
}
