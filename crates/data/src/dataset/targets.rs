//! Targets of the samples, and the task that they pose.

use crate::dataset::labels::{Attribute, Labels};
use crate::dataset::target_steps::TargetSteps;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::{self, Display, Formatter};

/// Parts into which splits cut the range of a value, so that each part of a split holds low and high ones.
const STRATA: usize = 10;

/// One measured quantity, such as a force.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// `force`.
    pub name: String,
    /// `N`, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
}

impl Display for Quantity {
    /// Writes the name with its unit: `force (N)`.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        self.unit.as_ref().map_or(Ok(()), |unit| write!(f, " ({unit})"))
    }
}

/// The task of a data set: it names the outputs of a model.
///
/// A task goes with the data set, the results of a run and the card of a model.
///
/// ```
/// use taxel_data::{Quantity, Task};
///
/// let task = Task::Values(vec![Quantity { name: "force".into(), unit: Some("N".into()) }]);
/// assert_eq!((task.outputs(), task.output_names()), (1, vec!["force".to_string()]));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub enum Task {
    /// One class for each sample, by name.
    Classes(Vec<String>),
    /// One level for each of several attributes; levels are ordered.
    Levels(Vec<Attribute>),
    /// One number for each quantity.
    Values(Vec<Quantity>),
}

/// A task as it stands in `results.json` and in the card of a model.
#[derive(Serialize, Deserialize)]
struct Written {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    classes: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    attributes: Vec<Attribute>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    quantities: Vec<Quantity>,
}

impl From<Task> for Written {
    fn from(task: Task) -> Self {
        let mut written = Written { classes: vec![], attributes: vec![], quantities: vec![] };
        match task {
            Task::Classes(classes) => written.classes = classes,
            Task::Levels(attributes) => {
                written.classes = level_names(&attributes);
                written.attributes = attributes;
            }
            Task::Values(quantities) => written.quantities = quantities,
        }
        written
    }
}

impl TryFrom<Written> for Task {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        let Written { classes, attributes, quantities } = written;
        match (attributes.is_empty(), quantities.is_empty()) {
            (true, true) => Ok(Task::Classes(classes)),
            (true, false) if classes.is_empty() => Ok(Task::Values(quantities)),
            (false, true) if classes.is_empty() || classes == level_names(&attributes) => {
                Ok(Task::Levels(attributes))
            }
            _ => Err("names classes, attributes and quantities that are not of one task".into()),
        }
    }
}

/// Lists the names of the outputs of several attributes: `elasticity:soft`.
fn level_names(attributes: &[Attribute]) -> Vec<String> {
    let levels = |attribute: &Attribute| {
        let name = &attribute.name;
        attribute.classes.iter().map(|level| format!("{name}:{level}")).collect::<Vec<_>>()
    };
    attributes.iter().flat_map(levels).collect()
}

impl Task {
    /// Returns the number of outputs of a model: one per class, level or quantity.
    pub fn outputs(&self) -> usize {
        match self {
            Task::Classes(classes) => classes.len(),
            Task::Levels(attributes) => attributes.iter().map(|attribute| attribute.classes.len()).sum(),
            Task::Values(quantities) => quantities.len(),
        }
    }

    /// Returns the names of the outputs: classes, `attribute:level`, or quantities.
    pub fn output_names(&self) -> Vec<String> {
        match self {
            Task::Classes(classes) => classes.clone(),
            Task::Levels(attributes) => level_names(attributes),
            Task::Values(quantities) => quantities.iter().map(|quantity| quantity.name.clone()).collect(),
        }
    }

    /// Returns the attributes of classes and levels; one of the name `class` for classes, none for values.
    pub fn attributes(&self) -> Vec<Attribute> {
        match self {
            Task::Classes(classes) => vec![Attribute { name: "class".into(), classes: classes.clone() }],
            Task::Levels(attributes) => attributes.clone(),
            Task::Values(_) => vec![],
        }
    }

    /// Returns the quantities of values; none for classes and levels.
    pub fn quantities(&self) -> &[Quantity] {
        match self {
            Task::Values(quantities) => quantities,
            Task::Classes(_) | Task::Levels(_) => &[],
        }
    }

    /// Counts the outputs in words: `3 classes`, `1 quantity`.
    pub fn counted(&self) -> String {
        match (self.outputs(), self) {
            (1, Task::Values(_)) => "1 quantity".into(),
            (outputs, _) => format!("{outputs} {}", self.noun()),
        }
    }

    /// Returns the noun of the parts that splits keep even: `class`, `combination of levels` or `part of the range`.
    pub fn stratum(&self) -> &'static str {
        match self {
            Task::Classes(_) => "class",
            Task::Levels(_) => "combination of levels",
            Task::Values(_) => "part of the range",
        }
    }

    /// Returns the plural noun of the outputs: `classes`, `levels` or `quantities`.
    pub fn noun(&self) -> &'static str {
        match self {
            Task::Classes(_) => "classes",
            Task::Levels(_) => "levels",
            Task::Values(_) => "quantities",
        }
    }
}

/// Values `[N, quantities]`, row-major, each in its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    quantities: Vec<Quantity>,
    values: Vec<f32>,
}

impl Values {
    /// Takes values `[N, quantities]`, row-major, all finite.
    pub fn new(quantities: Vec<Quantity>, values: Vec<f32>) -> Self {
        Values { quantities, values }
    }

    /// Returns the quantities.
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// Returns all values `[N, quantities]`, row-major.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Returns the number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.values.len() / self.quantities.len().max(1)
    }

    /// Returns the values of `rows`, `[rows, quantities]`.
    pub fn of(&self, rows: &[usize]) -> Vec<f32> {
        let width = self.quantities.len();
        rows.iter().flat_map(|&row| &self.values[row * width..(row + 1) * width]).copied().collect()
    }

    /// Returns for each sample the part of the first quantity's range that it lies in, by rank: parts are equally large.
    fn strata(&self) -> Vec<u32> {
        let first: Vec<f32> = self.values.iter().step_by(self.quantities.len().max(1)).copied().collect();
        let mut order: Vec<usize> = (0..first.len()).collect();
        order.sort_by(|&a, &b| first[a].total_cmp(&first[b]));
        let parts = STRATA.min((first.len() / 2).max(1));
        let mut strata = vec![0; first.len()];
        for (rank, &row) in order.iter().enumerate() {
            // Equal values stay together.
            let same = rank > 0 && first[order[rank - 1]] == first[row];
            strata[row] = if same { strata[order[rank - 1]] } else { (rank * parts / first.len()) as u32 };
        }
        strata
    }
}

/// The targets of the samples.
#[derive(Debug, Clone, PartialEq)]
pub enum Targets {
    /// One class for each sample.
    Classes {
        /// One attribute of the name `class`.
        labels: Labels,
        /// All label columns of a file that holds several, of which the class is one.
        columns: Option<Labels>,
        /// The time steps that classes belong to, where they are not those of whole recordings.
        steps: Option<TargetSteps>,
    },
    /// One level for each of several attributes.
    Levels(Labels),
    /// One number for each of several quantities.
    Values(Values),
}

impl Targets {
    /// Takes one class per sample, by its place in `classes`.
    pub fn classes(classes: &[String], labels: &[u32]) -> Self {
        Targets::Classes { labels: Labels::of_classes(classes, labels), columns: None, steps: None }
    }

    /// Says which time steps classes belong to; levels and values keep none.
    pub(crate) fn at_steps(mut self, at: Option<TargetSteps>) -> Self {
        if let Targets::Classes { steps, .. } = &mut self {
            *steps = at;
        }
        self
    }

    /// Returns the time steps that classes belong to, where they are not those of whole recordings.
    pub fn steps(&self) -> Option<&TargetSteps> {
        match self {
            Targets::Classes { steps, .. } => steps.as_ref(),
            Targets::Levels(_) | Targets::Values(_) => None,
        }
    }

    /// Returns the task that they pose.
    pub fn task(&self) -> Task {
        match self {
            Targets::Classes { labels, .. } => Task::Classes(labels.attributes()[0].classes.clone()),
            Targets::Levels(labels) => Task::Levels(labels.attributes().to_vec()),
            Targets::Values(values) => Task::Values(values.quantities().to_vec()),
        }
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        match self {
            Targets::Classes { labels, .. } | Targets::Levels(labels) => labels.len(),
            Targets::Values(values) => values.rows(),
        }
    }

    /// Checks whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the labels of classes or levels; none for values.
    pub fn labels(&self) -> Option<&Labels> {
        match self {
            Targets::Classes { labels, .. } | Targets::Levels(labels) => Some(labels),
            Targets::Values(_) => None,
        }
    }

    /// Returns the values; none for classes and levels.
    pub fn values(&self) -> Option<&Values> {
        match self {
            Targets::Values(values) => Some(values),
            Targets::Classes { .. } | Targets::Levels(_) => None,
        }
    }

    /// Returns all label columns of a file that holds several.
    pub fn columns(&self) -> Option<&Labels> {
        match self {
            Targets::Classes { columns, .. } => columns.as_ref(),
            Targets::Levels(labels) => Some(labels),
            Targets::Values(_) => None,
        }
    }

    /// Returns the stratum of each sample, which splits keep even: its class, the combination of its levels in ascending
    /// order, or the part of the first quantity's range that it lies in.
    pub fn strata(&self) -> Cow<'_, [u32]> {
        match self {
            Targets::Classes { labels, .. } => labels.values().into(),
            Targets::Levels(labels) => combinations(labels).into(),
            Targets::Values(values) => values.strata().into(),
        }
    }

    /// Returns the targets of `rows`, in that order.
    pub(crate) fn select(&self, rows: &[usize]) -> Self {
        match self {
            Targets::Classes { labels, columns, steps } => Targets::Classes {
                labels: labels.select(rows),
                columns: columns.as_ref().map(|columns| columns.select(rows)),
                steps: steps.as_ref().map(|steps| steps.of(rows)),
            },
            Targets::Levels(labels) => Targets::Levels(labels.select(rows)),
            Targets::Values(values) => {
                Targets::Values(Values::new(values.quantities.clone(), values.of(rows)))
            }
        }
    }
}

/// Returns for each sample the number of its combination of levels, of those that occur, in ascending order.
fn combinations(labels: &Labels) -> Vec<u32> {
    let width = labels.attributes().len().max(1);
    let rows = || labels.values().chunks_exact(width);
    let mut all: Vec<&[u32]> = rows().collect();
    all.sort_unstable();
    all.dedup();
    let number: HashMap<&[u32], u32> = all.into_iter().zip(0..).collect();
    rows().map(|levels| number[levels]).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn values(of: &[f32]) -> Targets {
        let force = Quantity { name: "force".into(), unit: Some("N".into()) };
        Targets::Values(Values::new(vec![force], of.to_vec()))
    }

    #[test]
    fn a_task_comes_back_from_its_json() {
        let attribute = |name: &str| Attribute { name: name.into(), classes: vec!["0".into(), "1".into()] };
        let classes = Task::Classes(vec!["a".into(), "b".into()]);
        let levels = Task::Levels(vec![attribute("elasticity"), attribute("hardness")]);
        for task in [classes, levels, values(&[1.0]).task()] {
            let text = serde_json::to_string(&task).unwrap();
            assert_eq!(serde_json::from_str::<Task>(&text).unwrap(), task, "{text}");
        }
        assert_eq!(
            (values(&[1.0]).task().counted().as_str(), values(&[1.0]).task().stratum()),
            ("1 quantity", "part of the range")
        );
        let mixed = r#"{"classes": ["a"], "quantities": [{"name": "force"}]}"#;
        assert!(serde_json::from_str::<Task>(mixed).is_err());
    }

    #[test]
    fn strata_of_values_are_parts_of_equal_size_that_keep_equal_values_together() {
        let rising: Vec<f32> = (0..40).map(|i| (39 - i) as f32).collect();
        let strata = values(&rising).strata().into_owned();
        assert_eq!((strata[0], strata[39]), (9, 0));
        assert!((0..10).all(|part| strata.iter().filter(|stratum| **stratum == part).count() == 4));
        assert_eq!(*values(&[2.0, 2.0, 2.0, 5.0]).strata(), [0, 0, 0, 1]);
    }

    #[test]
    fn several_quantities_are_read_row_by_row() {
        let quantity = |name: &str| Quantity { name: name.into(), unit: None };
        let rows = [[4.0, 0.5], [3.0, 1.5], [2.0, 2.5], [1.0, 3.5]];
        let values = Values::new(vec![quantity("force"), quantity("height")], rows.concat());
        assert_eq!(values.of(&[2, 0, 3, 2]), [rows[2], rows[0], rows[3], rows[2]].concat());
        assert!(values.of(&[]).is_empty());
        // Parts are those of the first quantity.
        assert_eq!(*Targets::Values(values).strata(), [1, 1, 0, 0]);
    }

    #[test]
    fn strata_of_levels_are_their_combinations() {
        let attribute = |name: &str| Attribute { name: name.into(), classes: vec!["0".into(), "1".into()] };
        let labels = Labels::new(vec![attribute("a"), attribute("b")], vec![1, 0, 0, 1, 1, 0]);
        assert_eq!(*Targets::Levels(labels).strata(), [1, 0, 1]);
    }
}
