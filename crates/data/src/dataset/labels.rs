//! Labels with the names of their levels.

use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// One attribute of the samples and the names of its levels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Attribute {
    /// `elasticity`; `class` where samples have one class each.
    pub name: String,
    /// Names by label.
    pub classes: Vec<String>,
}

/// Labels `[N, attributes]` with the names of their levels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    attributes: Vec<Attribute>,
    values: Vec<u32>,
}

impl Labels {
    /// Takes labels `[N, attributes]`, row-major; each below the number of its attribute's classes.
    pub fn new(attributes: Vec<Attribute>, values: Vec<u32>) -> Self {
        Self { attributes, values }
    }

    /// Takes one class per sample: a single attribute of the name `class`.
    pub fn of_classes(classes: &[String], values: &[u32]) -> Self {
        let attribute = Attribute { name: "class".into(), classes: classes.to_vec() };
        Self::new(vec![attribute], values.to_vec())
    }

    /// Takes labels `[N, attributes]`, row-major, of attributes without names: they become `attribute-0`,
    /// `attribute-1`, ...
    pub fn numbered(classes: Vec<Vec<String>>, values: Vec<u32>) -> Self {
        let attribute =
            |(i, classes): (usize, Vec<String>)| Attribute { name: format!("attribute-{i}"), classes };
        Self::new(classes.into_iter().enumerate().map(attribute).collect(), values)
    }

    /// Returns the attributes; one of the name `class` where samples have one class each.
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }

    /// Returns the number of levels of each attribute.
    pub fn sizes(&self) -> Vec<usize> {
        self.attributes.iter().map(|attribute| attribute.classes.len()).collect()
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.values.len() / self.attributes.len().max(1)
    }

    /// Checks whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns the labels of `rows`, `[rows, attributes]`.
    pub fn of(&self, rows: &[usize]) -> Vec<u32> {
        let width = self.attributes.len();
        rows.iter().flat_map(|&row| &self.values[row * width..(row + 1) * width]).copied().collect()
    }

    /// Returns all labels `[N, attributes]`, row-major.
    pub fn values(&self) -> &[u32] {
        &self.values
    }

    /// Returns the same attributes with the labels of `rows` only.
    pub(crate) fn select(&self, rows: &[usize]) -> Self {
        Self::new(self.attributes.clone(), self.of(rows))
    }
}

/// Sorts the names that occur, each once, and returns them with the position of each sample's name: numbers by value
/// (2 before 10), then words by the alphabet.
pub(crate) fn by_name(names: Vec<String>) -> (Vec<String>, Vec<u32>) {
    let mut classes = names.clone();
    let number = |name: &str| name.parse::<f64>().unwrap_or(f64::INFINITY);
    classes.sort_by(|a, b| number(a).total_cmp(&number(b)).then(a.cmp(b)));
    classes.dedup();
    let position: HashMap<&str, u32> = classes.iter().map(String::as_str).zip(0..).collect();
    let labels = names.iter().map(|name| position[name.as_str()]).collect();
    (classes, labels)
}
