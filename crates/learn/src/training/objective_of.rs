//! The objective of a recipe on a data set.

use taxel_data::{Dataset, Labels, Targets as DatasetTargets};
use taxel_graph::{Graph, Weights};

use crate::error::Result;
use crate::training::label_objective::LabelObjective;
use crate::training::objective::{Backward, Objective, Taught};
use crate::training::recipe::Recipe;
use crate::training::value_objective::ValueObjective;

/// Makes the objective of a recipe, whose loss is known, on the training samples `rows`.
pub(crate) fn objective<'d>(
    recipe: &Recipe,
    graph: &Graph,
    dataset: &'d Dataset,
    rows: &[usize],
) -> Box<dyn Objective + 'd> {
    match &dataset.targets {
        DatasetTargets::Classes { labels, .. } | DatasetTargets::Levels(labels) => {
            Box::new(OfLabels { objective: LabelObjective::new(recipe, labels, rows), labels })
        }
        DatasetTargets::Values(values) => {
            let loss = recipe.loss_for(&dataset.task());
            Box::new(ValueObjective::new(loss, graph, dataset, values, rows))
        }
    }
}

/// The objective on the labels of a data set.
struct OfLabels<'d> {
    objective: LabelObjective,
    labels: &'d Labels,
}

impl Objective for OfLabels<'_> {
    fn backward(&self, rows: &[usize], taught: Taught, backward: Backward) -> taxel_engine::Result<f32> {
        let taught = taught.map(|teacher| (teacher, rows));
        self.objective.backward(&self.labels.of(rows), taught, backward)
    }

    fn loss(&self, outputs: &[f32], rows: &[usize]) -> f64 {
        self.objective.value(outputs, &self.labels.of(rows))
    }

    fn idle(&self) -> f64 {
        self.objective.idle()
    }

    fn score(&self, outputs: &[f32], rows: &[usize]) -> (f64, usize) {
        let labels = self.labels.of(rows);
        (100.0 * self.objective.correct(outputs, &labels) as f64, labels.len())
    }

    fn answers(&self, mut outputs: Vec<f32>) -> Vec<f32> {
        self.objective.probabilities(&mut outputs);
        outputs
    }

    fn finished(&self, _graph: &Graph, weights: Weights) -> Result<Weights> {
        Ok(weights)
    }

    fn begun(&self, _graph: &Graph, weights: Weights) -> Result<Weights> {
        Ok(weights)
    }

    fn answers_of_model(&self, outputs: Vec<f32>) -> Vec<f32> {
        self.answers(outputs)
    }

    fn test_loss(&self, outputs: &[f32], rows: &[usize]) -> Result<f64> {
        Ok(self.loss(outputs, rows))
    }
}
