//! Kinds of models: a network, a baseline or an average of some.

use serde::{Deserialize, Serialize};
use taxel_baselines::Method;
use taxel_graph::{Graph, Loss};

use crate::training::recipe::Recipe;

/// A network, a baseline or an average of some, with all that opening it needs besides tensors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum ModelKind {
    /// A network.
    Network {
        /// The network itself.
        graph: Box<Graph>,
        /// The loss that its outputs were trained for: it says how they become probabilities.
        loss: Loss,
        /// Samples that are predicted at a time at most.
        batch: usize,
        /// How it was trained.
        recipe: Box<Recipe>,
    },
    /// A baseline.
    Baseline {
        /// The method with its settings.
        method: Method,
        /// Channels and length of the series that it reads.
        series: [usize; 2],
    },
    /// The mean of what several networks and baselines predict, each counting alike.
    Average {
        /// Those that are averaged.
        members: Vec<AverageMember>,
    },
}

/// A network or baseline of an average. Its tensors are those of the model file that begin with its number and a point, such as `0.`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AverageMember {
    /// Name of its row in the experiment.
    pub name: String,
    /// A network or a baseline.
    #[serde(rename = "estimator")]
    pub kind: ModelKind,
    /// Number of its inputs, which follow those of the members before it.
    pub inputs: usize,
}
