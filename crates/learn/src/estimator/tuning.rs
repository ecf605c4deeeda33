//! A trained network that goes on learning from other samples.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use taxel_data::{Dataset, Quantity, Task};
use taxel_engine::Precision;
use taxel_graph::{Graph, Op};

use crate::encoding::Encoder;
use crate::error::{Error, Result};
use crate::estimator::candidate::Candidate;
use crate::estimator::fit::Fit;
use crate::estimator::trainable::Trainable;
use crate::model::{Card, Model, ModelKind};
use crate::problem::require;
use crate::run::options::RunOptions;
use crate::run::protocol::Protocol;
use crate::training::recipe::{BatchNorm, Recipe};

/// How a trained network goes on learning: from few recordings of another sensor of its kind, for example.
///
/// Everything that was fitted to the first samples stays as it is: the scaling of the inputs, and the statistics and weights of batch
/// norm, for which few samples say too little. The other weights go on from what they are.
#[derive(Debug, Clone)]
pub struct Tuning {
    /// Passes over the samples, 1 to 100,000. Default 300.
    pub epochs: usize,
    /// The first learning rate as a share of that of the training, above 0. Default 0.3.
    pub rate: f64,
    /// Seed of the order of the samples. Default 0.
    pub seed: u64,
    /// Threads.
    pub options: RunOptions,
}

impl Default for Tuning {
    fn default() -> Self {
        Tuning { epochs: 300, rate: 0.3, seed: 0, options: RunOptions::default() }
    }
}

impl Tuning {
    /// Returns the number of samples that [`Tuning::run`] trains on, each epoch counted.
    pub fn samples(&self, dataset: &Dataset) -> usize {
        self.epochs * dataset.len()
    }

    /// Trains `model` further on all samples of a data set; `None` if `cancel` was set. `tick` hears how many samples each step
    /// took. What was known of the errors of the first model does not hold for the result, which has no score, no intervals and
    /// no calibration.
    ///
    /// # Errors
    /// A model that is no network, in eight bits or in bf16, samples or targets of another kind than it reads, training that diverges.
    pub fn run(
        &self,
        model: &Model,
        dataset: &Dataset,
        tick: &mut dyn FnMut(usize),
        cancel: &AtomicBool,
    ) -> Result<Option<Model>> {
        let card = model.card();
        let (graph, recipe) = match &card.kind {
            ModelKind::Network { .. } if card.quantized.is_some() => {
                return Err(refused(card, "a network in floats to go on from", "it is in eight bits"));
            }
            ModelKind::Network { .. } if card.precision != Precision::F32 => {
                return Err(refused(card, "a network in floats to go on from", "it is in bf16"));
            }
            ModelKind::Network { graph, recipe, .. } => (graph, recipe),
            ModelKind::Average { .. } => {
                return Err(refused(
                    card,
                    "a network to go on from",
                    "it is an average, whose trees cannot go on",
                ));
            }
            ModelKind::Baseline { .. } => {
                return Err(refused(
                    card,
                    "a network to go on from",
                    "it is a baseline, which is fitted at once",
                ));
            }
        };
        if dataset.task() != card.task {
            let names = |task: &Task| format!("{} {}", task.noun(), names_of(task).join(", "));
            let expected = format!("targets that it has learned, {}", names(&card.task));
            return Err(refused(card, &expected, &format!("these are {}", names(&dataset.task()))));
        }
        let shape = &card.spec.shape;
        if dataset.spec.shape != *shape {
            let expected = format!("samples of shape {shape:?} ({})", card.spec.layout.axes());
            return Err(refused(card, &expected, &format!("these have {:?}", dataset.spec.shape)));
        }
        let reason = "is a share of the learning rate of the training, above 0";
        require(self.rate > 0.0 && self.rate.is_finite(), "rate", self.rate, reason)?;
        let recipe = self.recipe(recipe, graph);
        let start = Some(Arc::new(model.weights().clone()));
        let trainable = Trainable { graph: (**graph).clone(), recipe, search: None, start };
        let candidate = Candidate::trained(&card.name, &card.paper, trainable);
        let protocol = Protocol::default();
        let fit = Fit {
            candidate: &candidate,
            protocol: &protocol,
            seed: self.seed,
            options: self.options.clone(),
            session: None,
        };
        let made = card.inputs.iter().map(|input| (input.name.as_str(), &input.transform));
        let mut encoder = Encoder::of_inputs(dataset, made, card.guard.clone())?;
        let tuned = fit.run(&mut encoder, tick, cancel)?;
        Ok(tuned.map(|tuned| tuned.tuned_from(card)))
    }

    /// Returns the recipe of a training as it goes on: what few samples say too little of is frozen.
    fn recipe(&self, first: &Recipe, graph: &Graph) -> Recipe {
        let norms = graph.nodes().iter().filter(|node| matches!(node.op, Op::BatchNorm { .. }));
        let frozen = first.frozen.iter().cloned().chain(norms.map(|node| node.name.clone()));
        Recipe {
            epochs: self.epochs,
            least_steps: None,
            least_batches: None,
            optimizer: first.optimizer.with_lr(self.rate * first.optimizer.lr()),
            warm_up: 0.0,
            batch_norm: BatchNorm::Running,
            early_stopping: None,
            frozen: frozen.collect(),
            ..first.clone()
        }
    }
}

fn refused(card: &Card, expected: &str, given: &str) -> Error {
    Error::Samples { model: card.name.clone(), expected: expected.into(), given: given.into() }
}

/// Returns the names of the outputs, those of quantities with their units.
fn names_of(task: &Task) -> Vec<String> {
    match task {
        Task::Values(quantities) => {
            let named = |quantity: &Quantity| match &quantity.unit {
                Some(unit) => format!("{} {unit}", quantity.name),
                None => quantity.name.clone(),
            };
            quantities.iter().map(named).collect()
        }
        _ => task.output_names(),
    }
}
