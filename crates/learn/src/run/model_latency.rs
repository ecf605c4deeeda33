//! The latency of a saved model, for the table of a run.

use ndarray::Axis;
use taxel_data::Dataset;

use crate::error::Result;
use crate::latency::Latency;
use crate::model::Predictor;
use crate::run::table_latency::of_prediction;

/// Times the prediction for sample `row`, after it is encoded.
pub(crate) fn of_model(predictor: &Predictor, dataset: &Dataset, row: usize) -> Result<Latency> {
    let sample: Vec<f32> = dataset.x.index_axis(Axis(0), row).iter().copied().collect();
    let mut workspace = predictor.workspace()?;
    predictor.read(&mut workspace, &sample)?;
    of_prediction(|| predictor.decide(&mut workspace).map(|_| ()))
}
