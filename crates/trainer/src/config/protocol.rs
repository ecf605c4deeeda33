//! The `[protocol]` table: how samples become training, validation and test parts.

use serde::{Deserialize, Serialize};

/// The kinds of protocol.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProtocolKind {
    /// Every sample is tested once per repetition (paper 000: stratified, 5 folds).
    #[default]
    KFold,
    /// One random cut per repetition (paper 002: 80/10/10, 20 repetitions; paper 001: 75/25).
    RandomSplits,
    /// A learning curve (paper 003): per repetition one random test part, and from the rest as many
    /// training samples of each class as `per_class` says, the smaller sets inside the larger ones.
    FewSamples,
    /// Each group (object, session) is tested once, all others are trained on.
    LeaveGroupOut,
    /// The cut that the data set's authors made.
    Official,
}

/// What a part keeps even or together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Split {
    /// Classes are spread evenly; exact copies stay in one part.
    #[default]
    Stratified,
    /// No group (session, object, block) is in two parts.
    Group,
}

/// The `[protocol]` table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Protocol {
    /// The kind of protocol.
    pub kind: ProtocolKind,
    /// K-fold: folds, 2 to 1000. Default 5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folds: Option<usize>,
    /// What a part keeps even or together.
    pub split: Split,
    /// How often everything is repeated with other parts, 1 to 1000. Default 1.
    pub repetitions: usize,
    /// Random splits and few samples: share that is tested, (0, 1). Default 0.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test: Option<f64>,
    /// Random splits: share for validation, `[0, 1)`. Default 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub validation: Option<f64>,
    /// Few samples: training samples of each class, ascending. Default `[1, 2, 5, 10, 20]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_class: Option<Vec<usize>>,
}

impl Default for Protocol {
    fn default() -> Self {
        Protocol {
            kind: ProtocolKind::KFold,
            folds: None,
            split: Split::Stratified,
            repetitions: 1,
            test: None,
            validation: None,
            per_class: None,
        }
    }
}

impl Protocol {
    /// Fills in what the kind of protocol needs.
    pub(crate) fn fill_defaults(&mut self) {
        match self.kind {
            ProtocolKind::KFold => {
                self.folds.get_or_insert(5);
            }
            ProtocolKind::RandomSplits => {
                self.test.get_or_insert(0.2);
            }
            ProtocolKind::FewSamples => {
                self.test.get_or_insert(0.2);
                self.per_class.get_or_insert_with(|| vec![1, 2, 5, 10, 20]);
            }
            ProtocolKind::LeaveGroupOut | ProtocolKind::Official => {}
        }
    }

    /// The protocol in a few words, for captions: `stratified 5-fold, 2 repetitions`.
    pub fn words(&self) -> String {
        let split = match self.split {
            Split::Stratified => "stratified",
            Split::Group => "grouped",
        };
        let percent = |share: Option<f64>| format!("{:.0} %", 100.0 * share.unwrap_or(0.0));
        let mut words = match self.kind {
            ProtocolKind::KFold => format!("{split} {}-fold", self.folds.unwrap_or(5)),
            ProtocolKind::RandomSplits => match self.validation.unwrap_or(0.0) > 0.0 {
                true => format!(
                    "{split} random splits ({} test, {} validation)",
                    percent(self.test),
                    percent(self.validation)
                ),
                false => format!("{split} random splits ({} test)", percent(self.test)),
            },
            ProtocolKind::FewSamples => {
                format!("few samples per class, {split} random {} test", percent(self.test))
            }
            ProtocolKind::LeaveGroupOut => "leave one group out".into(),
            ProtocolKind::Official => "the data set's own split".into(),
        };
        if self.repetitions > 1 {
            words.push_str(&format!(", {} repetitions", self.repetitions));
        }
        words
    }
}
