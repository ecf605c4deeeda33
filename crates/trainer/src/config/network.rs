//! `[[networks]]`: what is trained, what it does otherwise, what its authors report.

use serde::{Deserialize, Serialize};

use crate::config::train::{Train, TrainOverride};

/// One of `[[networks]]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// Name in the zoo.
    pub name: String,
    /// Name in tables and files, where one network is there twice. Default the zoo's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Settings of the network other than its input and output sizes, which come from the data.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub set: toml::Table,
    /// Checkpoint that every fold starts from, `.safetensors` or `.pth`; `${NAME}` is an environment
    /// variable. A head for another number of classes is made anew. Default fresh weights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<String>,
    /// What this network does otherwise in training.
    #[serde(default, skip_serializing_if = "is_default")]
    pub train: TrainOverride,
    /// What its authors report on their own data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<Published>,
}

/// Published scores in %, each `[mean, SD]`, or `[mean]` where no spread is published: never measured here,
/// never on these data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Where they stand: `paper 000, Table 5`.
    pub table: String,
    /// Accuracy.
    pub accuracy: Vec<f64>,
    /// Macro precision.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub precision: Option<Vec<f64>>,
    /// Macro recall.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recall: Option<Vec<f64>>,
    /// Macro F1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub f1: Option<Vec<f64>>,
    /// "Model size" as printed, in MB; the papers' are 2^20 bytes (`docs/costs.md`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub megabytes: Option<f64>,
    /// As printed; what a paper counts as an operation is its own (`docs/costs.md`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gflops: Option<f64>,
}

fn is_default(train: &TrainOverride) -> bool {
    *train == TrainOverride::default()
}

impl Network {
    /// Name in tables and files.
    pub fn label(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.name)
    }

    /// The experiment's training with this network's own values in it.
    pub fn train(&self, all: &Train) -> Train {
        self.train.over(all)
    }
}
