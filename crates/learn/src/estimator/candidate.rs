//! Candidates of a comparison: networks with their recipes, and baselines.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_faults::{Fault, TrainingFaults};
use taxel_graph::Graph;

use crate::encoding::Encoder;
use crate::error::Result;
use crate::estimator::average::{Average, Member};
use crate::estimator::baseline::Baseline;
use crate::estimator::estimator::Estimator;
use crate::estimator::trainable::Trainable;
use crate::model::digest;
use crate::problem::{Check, fault_problem, require};
use crate::training::recipe::Recipe;

/// Ending of the names of fault-augmented rows.
const HARDENED: &str = ".hardened";

/// One network or baseline of an experiment, under the name that tables and files give it.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Letters, digits, `.`, `_`, `-`, not starting with a dot: it names files.
    pub name: String,
    /// The network or baseline.
    pub estimator: Arc<dyn Estimator>,
    /// Name in the registry, or of the baseline.
    pub zoo: String,
    /// Where it is published.
    pub paper: String,
    /// Sizes and settings that its graph was built with, for readers of the results.
    pub settings: Map<String, Value>,
    /// Scores that its authors report on their data.
    pub published: Option<Published>,
    /// The candidate that [`Candidate::hardened`] made it of, if it did.
    pub twin: Option<Twin>,
}

/// The candidate that another one was made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Twin {
    /// Name of the candidate that is trained alike, but on clean samples.
    pub clean: String,
    /// The fault that is left out of training to see how it is met unknown.
    pub unmet: Option<Fault>,
}

/// The fault augmentation of a row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hardening {
    /// Faults of its training samples.
    pub faults: TrainingFaults,
    /// The row that was trained alike, but on clean samples, where the run has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clean: Option<String>,
    /// The fault that was left out of training to see how it is met unknown: the row is there for that alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unmet: Option<Fault>,
}

/// Published scores in %, each `[mean, SD]`, or `[mean]` where no spread is published: never measured here,
/// never on these data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Where they stand: `Kaewrakmuk and Srinonchat 2026, Table 5`.
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
    /// Seconds of one training as printed, on the authors' machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

impl Candidate {
    /// Makes a candidate of a network, under the name of its graph.
    pub fn network(graph: Graph, recipe: Recipe) -> Self {
        let name = graph.name().to_string();
        Self::new(name, "", Arc::new(Trainable { graph, recipe, search: None, start: None }))
    }

    /// Makes a candidate of a network that has been trained before.
    pub(crate) fn trained(name: &str, paper: &str, network: Trainable) -> Self {
        Self::new(name.into(), paper, Arc::new(network))
    }

    /// Makes a candidate of a baseline, under the name of its method.
    pub fn baseline(method: Method) -> Self {
        Self::new(method.name().into(), method.reference(), Arc::new(Baseline { method, faults: None }))
    }

    /// Makes a candidate that predicts the mean of what `members` predict, each counting alike.
    pub fn average(name: String, members: &[Candidate]) -> Self {
        let member = |own: &Candidate| Member { name: own.name.clone(), estimator: own.estimator.clone() };
        let members = members.iter().map(member).collect();
        Self { zoo: "average".into(), ..Self::new(name, "", Arc::new(Average { members })) }
    }

    fn new(name: String, paper: &str, estimator: Arc<dyn Estimator>) -> Self {
        Candidate {
            zoo: name.clone(),
            name,
            estimator,
            paper: paper.into(),
            settings: Map::new(),
            published: None,
            twin: None,
        }
    }

    /// Returns the same candidate with `faults` added to its training samples, as `<name>.hardened`; with a fault
    /// that is left `unmet` as `<name>.without-<fault>`.
    pub fn hardened(&self, faults: &TrainingFaults, unmet: Option<Fault>) -> Self {
        let mut faults = faults.clone();
        let name = match unmet {
            Some(fault) => {
                faults.without.push(fault);
                format!("{}.without-{fault}", self.name)
            }
            None => augmented(&self.name),
        };
        Candidate {
            name,
            estimator: self.estimator.under(&faults),
            // What is published was not trained so.
            published: None,
            twin: Some(Twin { clean: self.name.clone(), unmet }),
            ..self.clone()
        }
    }

    /// Returns the faults that are added to its training samples; none where it is trained on clean samples.
    pub fn faults(&self) -> Option<&TrainingFaults> {
        self.estimator.faults().filter(|faults| !faults.is_clean())
    }

    /// Returns the names of the inputs that it reads.
    pub fn inputs(&self) -> Vec<&str> {
        self.estimator.inputs()
    }

    /// Refuses faults without a meaning for the samples.
    ///
    /// # Errors
    /// The first of them.
    pub(crate) fn check_faults(&self, dataset: &Dataset) -> Result<()> {
        let Some(faults) = self.faults() else { return Ok(()) };
        faults.plan(dataset.spec.layout, &dataset.spec.shape).map_err(fault_problem)?;
        Ok(())
    }

    /// Returns the digest of its network and of the weights that this starts from; none of a baseline.
    pub(crate) fn network_digest(&self) -> Option<String> {
        let Trainable { graph, start, .. } = self.estimator.as_network()?;
        let both = json!([graph, start.as_deref().map(digest)]);
        Some(blake3::hash(both.to_string().as_bytes()).to_hex().to_string())
    }

    /// Returns all that its training depends on beside samples and seed.
    pub fn identity(&self) -> Value {
        let mut identity = json!({ "network": self.network_digest() });
        self.estimator.identify(&mut identity);
        identity
    }

    /// Refuses samples of which it cannot be trained on `samples`.
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub(crate) fn check_samples(&self, samples: usize, encoder: &Encoder) -> Result<()> {
        self.check_faults(encoder.dataset())?;
        self.estimator.check_samples(&self.name, samples, encoder)
    }

    /// Checks the name, the published scores, the recipe and the frozen nodes.
    ///
    /// # Errors
    /// A name that cannot name files, a recipe out of range, published scores that are none, frozen nodes that
    /// the network does not have.
    pub fn check(&self) -> Result<()> {
        file_name("name", &self.name)?;
        if let Some(published) = &self.published {
            published.check().map_err(|problem| problem.below("published"))?;
        }
        self.estimator.check()
    }
}

/// Returns the name that [`Candidate::hardened`] made `<name>.hardened` of; any other name stands for itself.
pub fn clean(name: &str) -> &str {
    name.strip_suffix(HARDENED).unwrap_or(name)
}

/// Returns the name of the fault-augmented twin of a row that is trained clean.
pub fn augmented(name: &str) -> String {
    format!("{name}{HARDENED}")
}

/// Checks that a name is safe as part of a file name: 1 to 100 letters, digits, `.`, `_` or `-`, not starting with a
/// dot.
///
/// # Errors
/// Any other name.
pub fn file_name(key: &str, name: &str) -> Check {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    let safe = !name.is_empty() && name.len() <= 100 && !name.starts_with('.') && name.chars().all(plain);
    let reason = "must be 1 to 100 letters, digits, `.`, `_` or `-`, not starting with `.`: it names files";
    require(safe, key, format!("{name:?}"), reason)
}

impl Published {
    /// Checks scores and costs.
    ///
    /// # Errors
    /// Scores that are no percentages, costs that are not above 0.
    pub fn check(&self) -> Check {
        let scores = [
            ("accuracy", Some(&self.accuracy)),
            ("precision", self.precision.as_ref()),
            ("recall", self.recall.as_ref()),
            ("f1", self.f1.as_ref()),
        ];
        for (name, score) in scores.into_iter().filter_map(|(name, score)| Some((name, score?))) {
            let percent = (1..=2).contains(&score.len()) && score.iter().all(|v| (0.0..=100.0).contains(v));
            let reason = "must be [mean, SD] or [mean] in %, each in [0, 100]";
            require(percent, name, format!("{score:?}"), reason)?;
        }
        for (name, cost) in
            [("megabytes", self.megabytes), ("gflops", self.gflops), ("seconds", self.seconds)]
        {
            if let Some(cost) = cost {
                require(cost.is_finite() && cost > 0.0, name, cost, "must be above 0")?;
            }
        }
        Ok(())
    }
}
