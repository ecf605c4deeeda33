//! `results.json`: scores of every network and baseline, with their spread.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use taxel_data::{Dataset, Shortcut, Source, Task};

use crate::error::Result;
use crate::estimator::candidate::{Hardening, Published};
use crate::metrics::{Confusion, LevelScores, LookAlikes, MeanEstimate, Metric, Scores};
use crate::model::Score;
use crate::problem::Problem;
use crate::run::leaks::Leak;
use crate::run::protocol::Protocol;
use crate::run::records::{Change, Costs, FoldKey, FoldRecord, OtherStatistics};

/// Scores of one fold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoldScores {
    /// Repetition, from 0.
    pub repetition: usize,
    /// Fold, from 0.
    pub fold: usize,
    /// Number of training samples.
    pub train_samples: usize,
    /// Number of test samples.
    pub test_samples: usize,
    /// Mean loss over the test samples.
    pub test_loss: f64,
    /// The metrics of the task by name, in their units.
    #[serde(flatten)]
    pub scores: Scores,
    /// Whether the training diverged ([`FoldRecord::diverged`]): then the scores say nothing about the network.
    #[serde(default, skip_serializing_if = "crate::json_file::is_default")]
    pub diverged: bool,
}

/// One network of `results.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NetworkResults {
    /// Name of the row.
    pub network: String,
    /// The network or baseline whose row it is; in a learning curve several rows are of one.
    #[serde(default)]
    pub candidate: String,
    /// Name in the registry, or of the baseline.
    pub zoo: String,
    /// Training samples per class, in a learning curve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per_class: Option<usize>,
    /// Where it is published.
    pub paper: String,
    /// Its sizes and settings; what is left out has the default of the zoo.
    pub settings: Map<String, Value>,
    /// Tensors that did not come from the checkpoint that it started from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawn: Vec<String>,
    /// Mean over finished folds of what training changed, where the network started from a checkpoint.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
    /// Mean over finished folds of what the other kind of batch-norm statistics does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other_statistics: Option<OtherStatistics>,
    /// Folds whose training diverged: finished ones ([`FoldScores::diverged`]), and in the run that wrote this
    /// those that were stopped because their loss was not finite.
    #[serde(default, skip_serializing_if = "crate::json_file::is_default")]
    pub diverged: usize,
    /// Its costs.
    pub costs: Costs,
    /// Finished folds.
    pub folds: Vec<FoldScores>,
    /// Mean over finished folds, by metric.
    pub mean: Option<Scores>,
    /// Sample standard deviation (n - 1) over finished folds, by metric.
    pub sd: Option<Scores>,
    /// 95 % interval of the primary metric over samples, or over groups where there are some
    /// ([`MeanEstimate`](crate::metrics::MeanEstimate)). None for a single group. `results.json` of older versions has a
    /// bootstrap interval; [`RunFolder::finished`](crate::RunFolder::finished) computes it anew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Number of groups that the interval rests on: fewer than [`FEW_GROUPS`](crate::metrics::FEW_GROUPS) are too few.
    /// None where samples are not grouped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_groups: Option<usize>,
    /// Counts `[true][predicted]` summed over finished folds; none with several attributes.
    pub confusion: Option<Confusion>,
    /// Where mistakes go between the groups of look-alikes that the config names.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_alikes: Option<LookAlikes>,
    /// Scores of each of several attributes over all finished folds together, shares in `[0, 1]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<LevelScores>,
    /// Scores that its authors report on their data, in %.
    pub published: Option<Published>,
    /// Its fault augmentation; none if it was trained on clean samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hardening: Option<Hardening>,
    /// The row whose models these are in eight bits; none of models in floats.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantized: Option<String>,
}

/// `results.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// Name of the experiment.
    pub name: String,
    /// One line for tables and reports.
    pub title: Option<String>,
    /// Whether every fold is in it.
    pub complete: bool,
    /// The folds that are not.
    pub missing: Vec<FoldKey>,
    /// The data that the scores were measured on: `simulated: ..` or `real: ..`.
    pub source: Source,
    /// BLAKE3 of the samples.
    pub data_digest: String,
    /// Digest of the [facts](taxel_data::Facts) about the samples; none in folders of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data_facts: Option<String>,
    /// Number of samples.
    pub samples: usize,
    /// Shape of one sample.
    pub sample_shape: Vec<usize>,
    /// The task: `classes`, with several `attributes` too, or `quantities`.
    #[serde(flatten)]
    pub task: Task,
    /// Classes that look alike, by the name of their group.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub look_alikes: BTreeMap<String, Vec<String>>,
    /// How samples were divided.
    pub protocol: Protocol,
    /// Folds of one repetition.
    pub folds: usize,
    /// Baselines and networks that were left out, and why.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left_out: BTreeMap<String, String>,
    /// Real recordings that a few global statistics tell apart: part of every score may not be touch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortcut: Option<Shortcut>,
    /// Leaks, which make the scores doubtful; empty in folders of older versions too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub leaks: Vec<Leak>,
    /// Seed of the experiment.
    pub seed: u64,
    /// Unit of the metrics of labels, and of `published`: `percent`; of values `quantity`.
    pub unit: String,
    /// In the order of the config.
    pub networks: Vec<NetworkResults>,
}

impl Results {
    /// Checks whether the scores were measured on this data set: on its samples, under the same facts.
    pub fn is_of(&self, dataset: &Dataset) -> bool {
        let facts = self.data_facts.as_ref();
        self.data_digest == dataset.digest && facts.is_none_or(|facts| *facts == dataset.facts().digest())
    }

    /// Makes results without networks and without folds.
    pub(crate) fn empty(dataset: &Dataset, protocol: &Protocol, seed: u64) -> Self {
        let task = dataset.task();
        Results {
            name: String::new(),
            title: None,
            complete: false,
            missing: vec![],
            source: dataset.source.clone(),
            data_digest: dataset.digest.clone(),
            data_facts: Some(dataset.facts().digest()),
            samples: dataset.len(),
            sample_shape: dataset.spec.shape.clone(),
            look_alikes: BTreeMap::new(),
            protocol: protocol.clone(),
            folds: 0,
            left_out: BTreeMap::new(),
            shortcut: None,
            leaks: vec![],
            seed,
            unit: if task.quantities().is_empty() { "percent" } else { "quantity" }.into(),
            task,
            networks: vec![],
        }
    }

    /// Returns the metric by which rows are compared.
    pub fn primary(&self) -> &'static Metric {
        Metric::primary(&self.task)
    }

    /// Returns the row in floats whose models the row `network` holds in eight bits; any other row stands for itself.
    pub fn in_floats<'n>(&'n self, network: &'n str) -> &'n str {
        let row = self.networks.iter().find(|row| row.network == network);
        row.and_then(|row| row.quantized.as_deref()).unwrap_or(network)
    }

    /// Returns the cross-validated score of a row, for the card of a model; none without a finished fold.
    pub fn score(&self, network: &str) -> Option<Score> {
        let row = self.networks.iter().find(|row| row.network == network)?;
        Some(Score {
            protocol: self.protocol.clone(),
            folds: row.folds.len(),
            mean: row.mean.clone()?,
            sd: row.sd.clone(),
            interval: row.interval,
        })
    }
}

/// Facts about the data that scores need besides the predictions.
#[derive(Debug, Clone)]
pub(crate) struct ScoringContext {
    /// The task.
    pub task: Task,
    /// The sample that each row is a copy of.
    pub samples: Vec<u32>,
    /// The group of each row; none where samples are not grouped.
    pub groups: Option<Vec<u32>>,
    /// Groups of look-alikes with their classes.
    pub look_alikes: Vec<(String, Vec<usize>)>,
}

impl ScoringContext {
    /// Collects the facts about these samples.
    ///
    /// # Errors
    /// A class that is in no or in two groups of look-alikes.
    pub(crate) fn of(dataset: &Dataset, look_alikes: &BTreeMap<String, Vec<String>>) -> Result<Self> {
        let (task, names) = (dataset.task(), dataset.output_names());
        let mut groups: Vec<(String, Vec<usize>)> = vec![];
        for (name, classes) in look_alikes {
            // Of the classes that were kept, so that one list serves every subset.
            let position = |class: &String| names.iter().position(|known| known == class);
            let members: Vec<usize> = classes.iter().filter_map(position).collect();
            if !members.is_empty() {
                groups.push((name.clone(), members));
            }
        }
        let named: Vec<usize> = groups.iter().flat_map(|(_, classes)| classes).copied().collect();
        let torn = (0..names.len()).find(|c| named.iter().filter(|n| *n == c).count() != 1);
        if let Some(class) = torn.filter(|_| !look_alikes.is_empty()) {
            let reason = "must be in exactly one group; every class needs one";
            let value = format!("{:?}", names[class]);
            return Err(Problem::new("data.look_alikes", value, reason).into());
        }
        let samples = dataset.units.clone().unwrap_or_else(|| (0..dataset.len() as u32).collect());
        Ok(ScoringContext { task, samples, groups: dataset.groups.clone(), look_alikes: groups })
    }
}

fn mean_changes(records: &[&FoldRecord]) -> Vec<Change> {
    let Some(first) = records.first() else { return vec![] };
    let mean = |(i, change): (usize, &Change)| {
        let sum: f64 = records.iter().filter_map(|r| r.changes.get(i)).map(|other| other.change).sum();
        Change { layer: change.layer.clone(), change: sum / records.len() as f64 }
    };
    first.changes.iter().enumerate().map(mean).collect()
}

/// Computes the mean score and loss with the other batch-norm statistics; none unless every fold has them.
fn mean_other(records: &[&FoldRecord]) -> Option<OtherStatistics> {
    let each: Vec<OtherStatistics> = records.iter().map(|r| r.other_statistics).collect::<Option<_>>()?;
    let mean = |value: fn(&OtherStatistics) -> f64| each.iter().map(value).sum::<f64>() / each.len() as f64;
    let batch_norm = each.first()?.batch_norm;
    Some(OtherStatistics { batch_norm, score: mean(|o| o.score), test_loss: mean(|o| o.test_loss) })
}

impl NetworkResults {
    /// Puts the finished folds and all that follows from them in.
    pub(crate) fn fill(&mut self, records: &[&FoldRecord], frame: &ScoringContext) -> Result<()> {
        self.tally(records, frame)?;
        self.diverged = self.folds.iter().filter(|fold| fold.diverged).count();
        self.set_interval(records, frame);
        Ok(())
    }

    /// Sets the interval of the primary metric, and what it rests on.
    pub(crate) fn set_interval(&mut self, records: &[&FoldRecord], frame: &ScoringContext) {
        let estimate = estimate(records, frame);
        let scale = Metric::primary(&frame.task).unit.scale();
        self.interval = estimate.and_then(|mean| mean.interval(0.95)).map(|ends| ends.map(|end| scale * end));
        self.interval_groups = estimate.and_then(|mean| mean.groups);
    }

    /// Returns the mean over finished folds of the metric `name`, in its unit.
    pub fn score(&self, name: &str) -> Option<f64> {
        self.mean.as_ref()?.get(name)
    }

    /// Returns the mean over finished folds of the primary metric, in its unit.
    pub fn primary(&self) -> Option<f64> {
        self.mean.as_ref()?.primary()
    }

    /// Returns the standard deviation over finished folds of the primary metric, in its unit.
    pub fn primary_spread(&self) -> Option<f64> {
        self.sd.as_ref()?.primary()
    }

    /// Returns the standard deviation over finished folds of the metric `name`, in its unit.
    pub fn spread(&self, name: &str) -> Option<f64> {
        self.sd.as_ref()?.get(name)
    }

    /// Counts the folds whose training diverged, of those that were trained: `2 of 5 folds`.
    pub fn diverged_folds(&self) -> String {
        format!("{} of {} folds", self.diverged, self.folds.len() + self.stopped())
    }

    /// Folds whose loss was not finite: they have no scores, and training them again would end in the same way.
    pub fn stopped(&self) -> usize {
        self.diverged.saturating_sub(self.folds.iter().filter(|fold| fold.diverged).count())
    }

    /// Checks whether the row is what follows from the records of its folds; the interval is not compared.
    pub(crate) fn follows_from(&self, records: &[&FoldRecord], frame: &ScoringContext) -> Result<bool> {
        let mut again = self.clone();
        again.tally(records, frame)?;
        // A folder of an older version knows fewer metrics.
        let same = |old: &Option<Scores>, new: &Option<Scores>| match (old, new) {
            (Some(old), Some(new)) => old.is_part_of(new),
            (old, new) => old == new,
        };
        let mut folds = self.folds.iter().zip(&again.folds);
        let follows = same(&self.mean, &again.mean)
            && same(&self.sd, &again.sd)
            && folds.all(|(old, new)| old.scores.is_part_of(&new.scores));
        (again.mean, again.sd) = (self.mean.clone(), self.sd.clone());
        for (new, old) in again.folds.iter_mut().zip(&self.folds) {
            new.scores = old.scores.clone();
        }
        Ok(follows && again == *self)
    }

    /// Computes everything but the interval and the count of diverged folds.
    fn tally(&mut self, records: &[&FoldRecord], frame: &ScoringContext) -> Result<()> {
        self.folds.clear();
        let mut sums: Vec<Confusion> = vec![];
        for record in records {
            self.folds.push(FoldScores {
                repetition: record.key.repetition,
                fold: record.key.fold,
                train_samples: record.train_samples,
                test_samples: record.index.len(),
                test_loss: record.test_loss,
                scores: record.scores(&frame.task)?,
                diverged: record.diverged,
            });
            let confusions = record.confusions(&frame.task)?;
            if sums.is_empty() {
                sums = confusions;
            } else {
                sums.iter_mut().zip(&confusions).for_each(|(sum, counts)| sum.add(counts));
            }
        }
        // The most that any fold needs.
        let costs = records.iter().filter_map(|record| record.costs);
        if let Some(most) = costs.max_by_key(|costs| (costs.macs, costs.parameters)) {
            self.costs = most;
        }
        self.changes = mean_changes(records);
        self.other_statistics = mean_other(records);
        (self.confusion, self.look_alikes, self.attributes) = (None, None, vec![]);
        match sums.as_slice() {
            [] => {}
            [one] => {
                if !frame.look_alikes.is_empty() {
                    self.look_alikes = Some(one.look_alikes(&frame.look_alikes)?);
                }
                self.confusion = Some(one.clone());
            }
            _ => self.attributes = sums.into_iter().map(LevelScores::of).collect(),
        }
        (self.mean, self.sd) =
            Scores::mean_sd(&self.folds.iter().map(|fold| &fold.scores).collect::<Vec<_>>());
        Ok(())
    }
}

/// Estimates the primary metric from the folds' samples; none for a single group, or for a metric that is no mean over
/// samples.
fn estimate(records: &[&FoldRecord], frame: &ScoringContext) -> Option<MeanEstimate> {
    let primary = Metric::primary(&frame.task);
    let (mut terms, mut rows) = (vec![], vec![]);
    for record in records {
        terms.extend(primary.terms(&frame.task, &record.outcome)?);
        rows.extend_from_slice(&record.index);
    }
    let of = |names: &Vec<u32>| rows.iter().map(|&row| names.get(row).copied()).collect::<Option<Vec<u32>>>();
    let groups = match &frame.groups {
        Some(groups) => Some(of(groups)?),
        None => None,
    };
    primary.estimate(&terms, &of(&frame.samples)?, groups.as_deref())
}
