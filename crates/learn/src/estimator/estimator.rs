//! The trait of everything that learns from samples, and of what it has learned.

use std::fmt::Debug;
use std::sync::Arc;

use serde_json::Value;
use taxel_data::{Dataset, Fold, Task};
use taxel_faults::TrainingFaults;
use taxel_graph::Weights;

use crate::encoding::{Encoder, Input};
use crate::error::Result;
use crate::estimator::trainable::Trainable;
use crate::model::ModelKind;
use crate::run::records::{Costs, FoldRecord};
use crate::training::feature_cache::FeatureCache;
use crate::training::hooks::Hooks;
use crate::training::part::TrainingKey;
use crate::training::teacher::Teacher;

/// A network or a baseline with its settings: everything that learns from samples.
///
/// One place, `train_fold`, trains any of them on one fold. The trait is implemented here alone: a custom network
/// is a graph, which [`Candidate::network`](crate::Candidate::network) takes.
pub trait Estimator: Debug + Send + Sync {
    /// Returns the names of the inputs that it reads.
    fn inputs(&self) -> Vec<&str>;

    /// Checks its settings.
    ///
    /// # Errors
    /// The first that is out of range.
    fn check(&self) -> Result<()>;

    /// Checks that it can learn from `samples` of the encoder's samples; `name` is that of its candidate.
    ///
    /// # Errors
    /// Inputs that the encoding does not make, another number of outputs, settings that the task does not allow.
    fn check_samples(&self, name: &str, samples: usize, encoder: &Encoder) -> Result<()>;

    /// Returns why it cannot be fitted to `samples` samples of the encoder's data set, where a run leaves it out.
    fn unfit(&self, _samples: usize, _encoder: &Encoder) -> Option<String> {
        None
    }

    /// Returns the faults that it is trained under, as they were set.
    fn faults(&self) -> Option<&TrainingFaults>;

    /// Returns the same trained under `faults`.
    fn under(&self, faults: &TrainingFaults) -> Arc<dyn Estimator>;

    /// Checks whether training under faults changes what it learns.
    fn gains_by_faults(&self) -> bool {
        true
    }

    /// Returns what a prediction costs, as far as that is known before training.
    fn costs(&self) -> Costs;

    /// Returns how many samples its training on `fold` sees at most, repeated ones each time; 0 where it costs nothing.
    fn samples(&self, _fold: &Fold) -> usize {
        0
    }

    /// Returns the multiply-accumulates that each of these samples costs.
    fn work_per_sample(&self) -> u64 {
        0
    }

    /// Returns the tensors that do not come from the checkpoint that it starts from.
    ///
    /// # Errors
    /// A checkpoint of another network.
    fn drawn(&self) -> Result<Vec<String>> {
        Ok(vec![])
    }

    /// Adds all that its training depends on to what identifies a run.
    fn identify(&self, identity: &mut Value);

    /// Checks whether it decides classes by logits.
    fn has_logits(&self) -> bool {
        true
    }

    /// Returns itself as a network; none for a baseline.
    fn as_network(&self) -> Option<&Trainable> {
        None
    }

    /// Learns from a training set and predicts its test part; none if cancelled.
    ///
    /// # Errors
    /// An error of the method, training that diverges.
    fn fit(&self, set: &TrainingSet, hooks: &mut Hooks) -> Result<Option<Trained>>;
}

/// The samples that an estimator learns from and is tested on.
pub struct TrainingSet<'a> {
    /// Name of the candidate.
    pub name: &'a str,
    /// The samples.
    pub dataset: &'a Dataset,
    /// Inputs of all samples, fitted on the training part.
    pub inputs: &'a [Input],
    /// Which samples are for what; the test part may be empty.
    pub fold: &'a Fold,
    /// Groups that no two parts may share, one number per sample.
    pub units: Option<&'a [u32]>,
    /// Which training it is: every random choice is keyed by it.
    pub part: TrainingKey,
    /// Worker threads; results do not depend on them.
    pub threads: usize,
    /// Whose predictions it learns from beside the targets; baselines do not listen.
    pub teacher: Option<&'a Teacher>,
    /// Features that frozen parts have made of samples.
    pub cache: &'a FeatureCache,
}

impl TrainingSet<'_> {
    /// Returns the weight of each training sample, 1 on average; none where all count alike.
    pub(crate) fn weights(&self) -> Option<Vec<f32>> {
        let all = self.dataset.weights_over(&self.fold.train)?;
        Some(self.fold.train.iter().map(|row| all[*row]).collect())
    }
}

/// The result of a training.
pub struct Trained {
    /// The fitted estimator.
    pub fitted: Box<dyn Fitted>,
    /// Its outputs for the test part `[test samples, outputs]`, row-major.
    pub outputs: Vec<f32>,
    /// How far below and above them it expects the true values, `[test samples, quantities, 2]`; empty where it says nothing of it.
    pub spread: Vec<f32>,
    /// Mean loss over the test part; 0 of none.
    pub test_loss: f64,
    /// Seconds of training.
    pub train_seconds: f64,
    /// Seconds of testing.
    pub test_seconds: f64,
    /// Samples that training saw, repeated ones each time.
    pub samples: u64,
}

/// An estimator that has learned.
pub trait Fitted {
    /// Returns what kind of model it is, for the card.
    fn kind(&self) -> ModelKind;

    /// Returns its tensors under the names that a model file gives them.
    fn tensors(&self, task: &Task) -> Weights;

    /// Returns the inputs of its model, in its order.
    fn inputs<'i>(&self, inputs: &'i [Input]) -> Vec<&'i Input>;

    /// Returns logits or values of the training samples `[n, outputs]`, each as if its inseparable group had not been learned, where
    /// that costs no training: of a ridge.
    ///
    /// # Errors
    /// Samples that the method refuses.
    fn left_out(&self, _set: &TrainingSet) -> Result<Option<Vec<f32>>> {
        Ok(None)
    }

    /// Adds what happened in training to the record of a fold.
    ///
    /// # Errors
    /// A checkpoint of another network.
    fn complete(&self, record: FoldRecord) -> Result<FoldRecord>;
}
