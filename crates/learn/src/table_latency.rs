//! The latency that stands in the table of a run: one encoded sample, batch 1, one thread.

use taxel_engine::{Engine, Mode, Options};
use taxel_graph::{Graph, Weights};

use crate::baseline::FittedBaseline;
use crate::encoding::Input;
use crate::error::Result;
use crate::feed::Feed;
use crate::latency::{Latency, Stopwatch, milliseconds};
use crate::part::pool;

/// It costs two seconds at most.
const TABLE: Stopwatch = Stopwatch { warm_up: 20, runs: 200, least: 5, budget: 2.0 };

/// Time of the sample `row` through a network.
pub(crate) fn of_network(graph: &Graph, weights: &Weights, inputs: &[Input], row: usize) -> Result<Latency> {
    let mut engine = Engine::new(graph, weights, Options { batch: 1, threads: 1, ..Options::default() })?;
    let mut feed = Feed::new(graph, inputs)?;
    let run = |_| timed(|| feed.forward(&mut engine, &[row], Mode::Eval).map(|logits| logits[0]));
    Ok(Latency::of(TABLE.time(run)?))
}

/// Time of one sample through a baseline.
pub(crate) fn of_baseline(fitted: &FittedBaseline, sample: &[f32]) -> Result<Latency> {
    let run = || TABLE.time(|_| timed(|| fitted.scores(sample)));
    Ok(Latency::of(pool(1)?.install(run)?))
}

/// Milliseconds of something that may fail.
fn timed<T>(work: impl FnOnce() -> Result<T>) -> Result<f64> {
    let (ms, done) = milliseconds(work);
    done.map(|_| ms)
}
