//! The latency in the table of a run: one raw sample to its answer, batch 1, one thread.

use ndarray::Axis;
use taxel_data::Dataset;

use crate::error::Result;
use crate::latency::{Latency, Stopwatch, milliseconds};
use crate::model::Model;

/// It costs two seconds at most.
const TABLE: Stopwatch = Stopwatch { warm_up: 20, runs: 200, least: 5, budget: 2.0 };

/// Times the prediction for sample `row`, encoding included.
pub(crate) fn of_model(model: &Model, dataset: &Dataset, row: usize) -> Result<Latency> {
    let sample: Vec<f32> = dataset.x.index_axis(Axis(0), row).iter().copied().collect();
    let predictor = model.predictor(1, 1)?;
    let mut workspace = predictor.workspace()?;
    let times = TABLE.time(|_| {
        let (ms, done) = milliseconds(|| predictor.predict_one(&mut workspace, &sample).map(|_| ()));
        done.map(|()| ms)
    })?;
    Ok(Latency::of(times))
}
