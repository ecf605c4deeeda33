//! A baseline as its model file holds it.

use taxel_baselines::{Fitted, Method, Saved};
use taxel_data::Task;
use taxel_learn::Model;

use crate::error::{Error, Result};

/// Reads a baseline of classes or values.
///
/// # Errors
/// Tensors that do not fit, and a baseline of several attributes.
pub(crate) fn fitted(model: &Model, method: &Method, series: [usize; 2]) -> Result<Fitted> {
    let (card, mut saved) = (model.card(), Saved::default());
    for (name, tensor) in model.weights().iter() {
        saved.insert(name, &tensor.data);
    }
    let outputs = card.task.outputs();
    let read = match &card.task {
        Task::Values(_) => Fitted::read_values(method, series, outputs, &saved),
        Task::Classes(_) => Fitted::read(method, series, outputs, &saved),
        Task::Levels(_) => {
            let reason = "is a baseline of several attributes, which only `taxel predict` knows".into();
            return Err(Error::Export { model: card.name.clone(), reason });
        }
    };
    read.map_err(|source| taxel_learn::Error::Baseline { baseline: card.name.clone(), source }.into())
}
