//! Models out of trainings: what each says about itself.

use taxel_data::Dataset;
use taxel_guard::Guard;

use crate::encoding::Input;
use crate::estimator::baseline::FittedBaseline;
use crate::estimator::candidate::{Candidate, Trainable};
use crate::model::{Anatomy, Card, FORMAT, Model, ModelInput, TrainedOn, TrainingPart};
use crate::run::environment::COMMIT;
use crate::training::network::Trained;

/// What a model was trained on.
pub(crate) struct Origin<'a> {
    pub dataset: &'a Dataset,
    /// Training samples.
    pub samples: usize,
    /// Repetition and fold; none for all samples.
    pub fold: Option<(usize, usize)>,
    pub seed: u64,
}

/// The model of a trained network.
pub(crate) fn network_model(
    candidate: &Candidate,
    network: &Trainable,
    inputs: &[Input],
    trained: &Trained,
    origin: &Origin,
) -> Model {
    let anatomy = Anatomy::Network {
        graph: Box::new(network.graph.clone()),
        loss: trained.recipe.loss,
        batch: trained.batch,
        recipe: Box::new(trained.recipe.clone()),
    };
    // In the order of the network's inputs.
    let names = network.graph.inputs().map(|node| &node.name);
    let own = names.filter_map(|name| inputs.iter().find(|input| input.name == name));
    Model::new(card(candidate, anatomy, own, guard(inputs), origin), trained.weights.clone())
}

/// The model of a fitted baseline.
pub(crate) fn baseline_model(
    candidate: &Candidate,
    fitted: &FittedBaseline,
    inputs: &[Input],
    origin: &Origin,
) -> Model {
    let anatomy = Anatomy::Baseline { method: fitted.method, series: fitted.shape };
    let card = card(candidate, anatomy, inputs.iter(), guard(inputs), origin);
    Model::new(card, fitted.tensors(origin.dataset.labels.attributes()))
}

/// The guard before the inputs: the same before all.
fn guard(inputs: &[Input]) -> Option<Guard> {
    inputs.first().and_then(|input| input.guard.as_deref().cloned())
}

fn card<'i>(
    candidate: &Candidate,
    anatomy: Anatomy,
    inputs: impl Iterator<Item = &'i Input>,
    guard: Option<Guard>,
    origin: &Origin,
) -> Card {
    let Origin { dataset, samples, fold, seed } = *origin;
    let input = |input: &Input| ModelInput { name: input.name.into(), transform: input.transform.clone() };
    let part = match fold {
        Some((repetition, fold)) => TrainingPart::Fold { repetition, fold },
        None => TrainingPart::Everything,
    };
    Card {
        format: FORMAT,
        taxel: env!("CARGO_PKG_VERSION").into(),
        commit: COMMIT.map(String::from),
        name: candidate.name.clone(),
        paper: candidate.paper.clone(),
        anatomy,
        reading: dataset.reading.clone(),
        guard,
        inputs: inputs.map(input).collect(),
        attributes: dataset.labels.attributes().to_vec(),
        trained_on: TrainedOn {
            source: dataset.source.clone(),
            digest: dataset.digest.clone(),
            samples,
            part,
            seed,
        },
        quantized: None,
        score: None,
        // Of the tensors: filled in with them.
        tensors: String::new(),
    }
}
