//! Whether a sample is like those of the training, as C.

use crate::literals::{float, floats};

/// The gate of a model of one attribute: the relative Mahalanobis distance of its logits, and how far is too far.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    /// Mean logits `[classes]`.
    pub center: Vec<f32>,
    /// Lower triangle of the matrix that brings deviations from a class to variance 1, row by row.
    pub within: Vec<f32>,
    /// The same for deviations from the center.
    pub around: Vec<f32>,
    /// Means of the classes, less the center, times `within`: `[classes with samples, classes]`.
    pub means: Vec<f32>,
    /// A sample that is farther is unknown.
    pub limit: f32,
}

impl Gate {
    /// Returns the bytes of the tables.
    pub(crate) fn table_bytes(&self) -> usize {
        let Gate { center, within, around, means, .. } = self;
        4 * (center.len() + within.len() + around.len() + means.len())
    }

    /// Writes tables and functions.
    pub(crate) fn text(&self) -> String {
        let Gate { center, within, around, means, limit } = self;
        let tables = [
            ("gate_center", center),
            ("gate_within", within),
            ("gate_around", around),
            ("gate_means", means),
        ];
        let tables: String = tables.into_iter().map(|(name, values)| floats(name, values)).collect();
        let rows = means.len() / center.len().max(1);
        let functions = include_str!("../c/answers/gate.c")
            .replace("@rows@", &rows.to_string())
            .replace("@limit@", &float(*limit));
        format!("\n{tables}\n{functions}")
    }
}
