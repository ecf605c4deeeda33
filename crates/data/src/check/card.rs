//! The card of a data set: its content, and warnings before training on it.

use crate::check::quantities::QuantitySummary;
use crate::check::shortcut::Shortcut;
use crate::check::values::ChannelRange;
use crate::length::lengths::Lengths;
use serde::{Serialize, Serializer};
use taxel_base::Layout;

/// One class and its size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClassCount {
    /// Label in `y`.
    pub label: u32,
    /// Class name.
    pub name: String,
    /// Number of samples.
    pub samples: usize,
}

/// The groups of a data set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupSummary {
    /// Name, such as `session` or `trial/12`.
    pub name: String,
    /// Number of groups.
    pub groups: usize,
    /// Fewest and most samples in a group.
    pub samples: [usize; 2],
    /// Fewest and most classes in a group.
    pub classes: [usize; 2],
    /// Classes that occur in one group only: left out, they are never trained.
    pub classes_in_one_group: Vec<String>,
}

/// Copies of one recording that carry different labels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contradiction {
    /// Indices of the samples, ascending.
    pub rows: Vec<usize>,
    /// Where they come from.
    pub sources: Vec<String>,
    /// Class name of each, or its value.
    pub labels: Vec<String>,
}

/// The description of a data set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    /// Name of the data set.
    pub name: String,
    /// BLAKE3 of the content, in hexadecimal.
    pub digest: String,
    /// Shape of `x`, samples first.
    pub shape: Vec<usize>,
    /// Axes of a sample; a guess from rank and type where they are not given. In JSON the axes of `x`: `N×C×T`.
    #[serde(rename = "axes", serialize_with = "axes")]
    pub layout: Layout,
    /// Lengths of the recordings, where they are unequal or a rule for them is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lengths: Option<Lengths>,
    /// How the file was read, where it could be read otherwise: a table as long or wide, its time stamps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub read_as: Vec<String>,
    /// Type of the stored values.
    pub dtype: String,
    /// Classes by label.
    pub classes: Vec<ClassCount>,
    /// Meaning of the columns of labels, where there are several; of a card by [`check`](crate::check) only.
    pub labels: Option<String>,
    /// Figures of each quantity, where targets are values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub quantities: Vec<QuantitySummary>,
    /// Share of the largest class, 0..1: the score of always answering it.
    pub majority_share: f64,
    /// Groups, where the data set has them.
    pub groups: Option<GroupSummary>,
    /// Further arrays of the `.npz`; any of whole numbers `[N]` can serve as groups.
    pub other_arrays: Vec<String>,
    /// Files of the folder that were passed over: hidden ones, and files that systems leave behind.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignored: Vec<String>,
    /// Lowest and highest finite value.
    pub range: Option<[f32; 2]>,
    /// Shares of finite values equal to the lowest and to the highest one, 0..1.
    pub saturation: [f64; 2],
    /// Number of NaN values.
    pub nan: usize,
    /// Number of infinite values.
    pub infinite: usize,
    /// Ranges per channel (or feature, or colour); empty for pressure images.
    pub channels: Vec<ChannelRange>,
    /// Number of taxels (channels, features or pixels).
    pub taxels: usize,
    /// Indices of taxels with one value in all samples: `[c]` or `[row, column]`.
    pub constant_taxels: Vec<Vec<usize>>,
    /// Indices of samples in which all values are equal.
    pub constant_samples: Vec<usize>,
    /// Sets of exact copies with one label, by index.
    pub duplicates: Vec<Vec<usize>>,
    /// Sets of exact copies with different labels.
    pub contradictions: Vec<Contradiction>,
    /// Share of samples that a few global statistics alone tell apart; none for under 40 samples or one class.
    pub shortcut: Option<Shortcut>,
    /// Sources of rows left out on request.
    pub dropped: Vec<String>,
    /// Samples left out on request because they have no target; of a card by [`check`](crate::check) only.
    #[serde(skip_serializing_if = "is_zero")]
    pub without_target: usize,
    /// Problems that keep the data set from being loaded; empty if it loads.
    pub problems: Vec<String>,
    /// Warnings: the data set loads, but scores may be distorted.
    pub warnings: Vec<String>,
}

impl Card {
    /// Returns the axes of `x` as people write them: `N×C×T`.
    pub(crate) fn axes(&self) -> &'static str {
        letters(self.layout)
    }
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

fn letters(layout: Layout) -> &'static str {
    match layout {
        Layout::Features => "N×F",
        Layout::Series => "N×C×T",
        Layout::Image => "N×H×W",
        Layout::Colour => "N×3×H×W",
        Layout::Sequence => "N×T×H×W",
        Layout::Fingers => "N×F×C×T",
    }
}

fn axes<S: Serializer>(layout: &Layout, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(letters(*layout))
}
