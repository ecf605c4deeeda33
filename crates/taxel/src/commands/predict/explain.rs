//! The parts that a prediction rests on: each sensor and each part of the window replaced by what a sensor at rest reads.

use ndarray::{ArrayRef, Axis, IxDyn};
use serde_json::{Value, json};
use taxel::learn::metrics::Levels;
use taxel::learn::{MaskGrid, Masked, at_rest};
use taxel::{Card, Predictions, Predictor};

/// Most samples that are explained: each is predicted many times.
const MOST: usize = 100;
/// Parts of a sample that are printed.
const SHOWN: usize = 5;

/// A part of a sample and what changes without it: of each attribute the probability of the named class, of each quantity its value.
struct Part {
    name: String,
    changes: Vec<f32>,
}

/// The parts of each sample, those that change most first.
pub struct Explained(Vec<Vec<Part>>);

impl Explained {
    /// Predicts each raw sample again without each of its parts.
    ///
    /// # Errors
    /// More samples than are explained, samples that the model refuses.
    pub fn of(
        predictor: &Predictor,
        card: &Card,
        x: &ArrayRef<f32, IxDyn>,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let count = x.shape()[0];
        if count > MOST {
            return Err(format!(
                "--explain: explains at most {MOST} samples, and these are {count}; name fewer recordings"
            )
            .into());
        }
        let grid = MaskGrid::of(&card.spec);
        let masks = grid.masks(false);
        let mut all = vec![];
        for sample in x.axis_iter(Axis(0)) {
            let values: Vec<f32> = sample.iter().copied().collect();
            let reference = at_rest(&card.spec, &values);
            let found = grid.predict(predictor, &card.spec.shape, (&values, &reference), &masks)?;
            let answers = answers(card, &found);
            let change = |(at, masked): (usize, Masked)| Part {
                name: grid.name(masked),
                changes: answers[at + 1]
                    .iter()
                    .zip(&answers[0])
                    .map(|(without, with)| without - with)
                    .collect(),
            };
            let mut parts: Vec<Part> = masks.iter().copied().enumerate().map(change).collect();
            let size = |part: &Part| part.changes.iter().fold(0.0f32, |most, change| most.max(change.abs()));
            parts.sort_by(|a, b| size(b).total_cmp(&size(a)));
            all.push(parts);
        }
        Ok(Explained(all))
    }

    /// Returns what the prediction of a sample rests on, line by line.
    pub fn words(&self, i: usize) -> String {
        let line = |part: &Part| {
            let changes: Vec<String> = part.changes.iter().map(|change| format!("{change:+.3}")).collect();
            format!("  without {}: {}\n", part.name, changes.join(", "))
        };
        self.0[i].iter().take(SHOWN).map(line).collect()
    }

    /// Returns the same for programs, all parts.
    pub fn json(&self, i: usize) -> Value {
        self.0[i].iter().map(|part| json!({ "without": part.name, "change": part.changes })).collect()
    }
}

/// Returns the answers for the whole sample and without each part: the probabilities of the classes that the whole one has, or the
/// values.
fn answers(card: &Card, found: &Predictions) -> Vec<Vec<f32>> {
    if !card.task.quantities().is_empty() {
        return (0..found.len()).map(|row| found.row(row).to_vec()).collect();
    }
    let sizes = Levels::of_task(&card.task).sizes().to_vec();
    let named = &found.labels[..sizes.len()];
    let of = |row: usize| {
        let mut begin = 0;
        let each = sizes.iter().zip(named).map(|(size, label)| {
            let probability = found.row(row)[begin + *label as usize];
            begin += size;
            probability
        });
        each.collect()
    };
    (0..found.len()).map(of).collect()
}
