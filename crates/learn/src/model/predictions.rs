//! What a model says about samples.

use serde::Serialize;
use taxel_data::Attribute;

use crate::metrics::Levels;

/// Answers to `n` samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Predictions {
    /// What is answered: one attribute called `class`, or several.
    pub attributes: Vec<Attribute>,
    /// Probabilities `[n, outputs]`, row-major: the classes, or the levels of the attributes one after the
    /// other.
    pub probabilities: Vec<f32>,
    /// The likeliest class or level of each attribute, `[n, attributes]`.
    pub labels: Vec<u32>,
}

/// One attribute of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer<'a> {
    /// Name of the attribute.
    pub attribute: &'a str,
    /// The likeliest class or level.
    pub class: &'a str,
    /// Its probability, 0 to 1.
    pub probability: f32,
}

impl Predictions {
    pub(super) fn new(attributes: Vec<Attribute>, probabilities: Vec<f32>) -> Self {
        let labels = levels(&attributes).predicted(&probabilities);
        Predictions { attributes, probabilities, labels }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.labels.len() / self.attributes.len().max(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    /// Number of probabilities of one sample.
    pub fn outputs(&self) -> usize {
        self.attributes.iter().map(|own| own.classes.len()).sum()
    }

    /// The answers to sample `i`, one per attribute.
    pub fn answers(&self, i: usize) -> Vec<Answer<'_>> {
        let width = self.attributes.len();
        let labels = &self.labels[i * width..(i + 1) * width];
        let mut first = i * self.outputs();
        let mut answers = vec![];
        for (own, &label) in self.attributes.iter().zip(labels) {
            let probability = self.probabilities[first + label as usize];
            answers.push(Answer { attribute: &own.name, class: &own.classes[label as usize], probability });
            first += own.classes.len();
        }
        answers
    }

    /// The likeliest class of sample `i`; of several attributes the first one's.
    pub fn class(&self, i: usize) -> &str {
        self.answers(i)[0].class
    }
}

fn levels(attributes: &[Attribute]) -> Levels {
    Levels::new(&attributes.iter().map(|own| own.classes.len()).collect::<Vec<_>>())
}
