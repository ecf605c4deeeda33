//! The card of a model, which is the metadata of its file.
//!
//! The file is safetensors. Its tensors bear PyTorch's names; its metadata hold one JSON text under the key
//! `taxel`, which is a [`Card`] and, as its last key `digest`, the BLAKE3 of the text without that key.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};
use taxel_base::thousands;
use taxel_data::{Dataset, SampleSpec, Source, Tare, Task};
use taxel_engine::Precision;
use taxel_graph::{Graph, Loss};
use taxel_guard::Guard;

use crate::certainty::{Certainty, Intervals};
use crate::encoding::Transform;
use crate::metrics::{Levels, Metric, Scores, metrics};
use crate::model::kind::ModelKind;
use crate::model::ranges::Ranges;
use crate::run::protocol::Protocol;

/// Number of the format of model files that this version writes: 4. It reads 1, 2, which was that of models in eight bits,
/// and 3, whose models are not calibrated.
pub const FORMAT: u32 = 4;

/// Everything that a model says about itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// Number of the format; a reader of another one refuses the file.
    pub format: u32,
    /// Version of taxel that wrote it.
    pub taxel: String,
    /// Git commit that this version was built from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// Name in its experiment.
    pub name: String,
    /// Where the network or baseline is published.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub paper: String,
    /// A network, a baseline or an average of some.
    #[serde(rename = "estimator", alias = "anatomy")]
    pub kind: ModelKind,
    /// One raw sample: layout, shape, unit, rate, full scale.
    #[serde(rename = "reading")]
    pub spec: SampleSpec,
    /// The guard, which finds and replaces broken channels and taxels of raw samples; none without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard: Option<Guard>,
    /// How raw samples become inputs, everything fitted included; in the order of the network's inputs.
    pub inputs: Vec<ModelInput>,
    /// The predicted quantity: a class, levels of several attributes, or values.
    pub task: Task,
    /// How its values are written in eight bits; none in a model of 32-bit floats.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantized: Option<Quantized>,
    /// Numbers that the products of its convolutions and linear layers are made of, and their weights: `bf16`, or `f32`, which
    /// is left out.
    #[serde(default, skip_serializing_if = "is_f32")]
    pub precision: Precision,
    /// The samples that it has learned from.
    pub trained_on: TrainedOn,
    /// How its recipe scored on samples that it had not seen; none where that was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score: Option<Score>,
    /// How its probabilities are brought to what they say; none of values, and of a model that is not calibrated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certainty: Option<Certainty>,
    /// The intervals around its values; none of classes, and of a model without held-out predictions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intervals: Option<Intervals>,
    /// BLAKE3 of the tensors in order of their names: name, shape, values.
    pub tensors: String,
}

fn is_f32(precision: &Precision) -> bool {
    *precision == Precision::F32
}

/// An input of a model and how it is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelInput {
    /// `signal`, `image`, `tensor`, `series`, or what an own network calls it.
    pub name: String,
    /// From raw samples to this input.
    pub transform: Transform,
}

/// How a network predicts in eight bits: weights are signed bytes with a scale for each output, values between layers
/// are bytes over the ranges that they had on samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantized {
    /// Of a weight and of a value: 8.
    pub bits: u32,
    /// BLAKE3 of the data set that the ranges were seen on.
    pub digest: String,
    /// Samples of it that were looked at.
    pub samples: usize,
    /// The least and the largest value of each node, by name.
    pub ranges: BTreeMap<String, [f32; 2]>,
}

/// The samples that a model has learned from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainedOn {
    /// `simulated: ..` or `real: ..`.
    pub source: Source,
    /// BLAKE3 of the data set.
    pub digest: String,
    /// Samples that it was trained on, those held back for early stopping included.
    pub samples: usize,
    /// Which part of the data set they are.
    pub part: TrainingPart,
    /// Seed of every random choice.
    pub seed: u64,
    /// Ranges of the raw values, channel by channel; empty in a model of an older version.
    #[serde(default, skip_serializing_if = "Ranges::is_empty")]
    pub ranges: Ranges,
    /// Marks of some of the samples, by which they are known again in any data set; empty in a model of an older version.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<u32>,
    /// The model that the training went on from, by the BLAKE3 of its tensors; none of one that began with fresh weights.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tuned_from: Option<String>,
}

/// Which part of a data set a model was trained on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrainingPart {
    /// All samples.
    Everything,
    /// All but the test part of a fold (and what the protocol leaves out).
    Fold {
        /// Repetition, from 0.
        repetition: usize,
        /// Fold, from 0.
        fold: usize,
    },
}

/// Cross-validated scores: of other models with the same recipe, each on samples that it had not seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Score {
    /// How samples were divided.
    pub protocol: Protocol,
    /// Folds behind the mean.
    pub folds: usize,
    /// Mean over folds, by metric.
    pub mean: Scores,
    /// Sample standard deviation (n - 1) over folds, by metric.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd: Option<Scores>,
    /// 95 % interval of the primary metric.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
}

/// Says that nothing is known of the errors of a model.
const WITHOUT_INTERVALS: &str = "no intervals: how far off its values may be is not known";
/// Says that nothing is known of the probabilities of a model.
const NOT_CALIBRATED: &str = "not calibrated: its probabilities may be too high or too low";

impl Card {
    /// Returns the sizes of the attributes, whose outputs lie one after the other; none of values.
    pub fn levels(&self) -> Levels {
        Levels::of_task(&self.task)
    }

    /// Returns the network; none for a baseline and for an average.
    pub fn graph(&self) -> Option<&Graph> {
        match &self.kind {
            ModelKind::Network { graph, .. } => Some(graph),
            ModelKind::Baseline { .. } | ModelKind::Average { .. } => None,
        }
    }

    /// Returns the loss of a network that has learned values; none of other models.
    pub(crate) fn value_loss(&self) -> Option<Loss> {
        match (&self.kind, &self.task) {
            (ModelKind::Network { loss, .. }, Task::Values(_)) => Some(*loss),
            _ => None,
        }
    }

    /// Returns the number of values that it computes for one sample, of which the first ones answer.
    pub(crate) fn width(&self) -> usize {
        self.task.outputs() * self.value_loss().map_or(1, Loss::outputs_per_target)
    }

    /// Returns the labels of a data set `[n, attributes]` as the numbers of the model's classes of the same names.
    ///
    /// # Errors
    /// A model of values, or recordings that hold some; a class that the model does not know. The model is the subject.
    pub fn labels_of(&self, dataset: &Dataset) -> Result<Vec<u32>, String> {
        let known = self.task.attributes();
        let labels = dataset.targets.labels().filter(|_| !known.is_empty());
        let labels =
            labels.ok_or("predicts values, or the recordings hold some: only classes have probabilities")?;
        let given = labels.attributes();
        if given.len() != known.len() {
            return Err(format!(
                "predicts {} attributes, and the recordings have {}",
                known.len(),
                given.len()
            ));
        }
        let mut numbers: Vec<Vec<u32>> = vec![];
        for (known, given) in known.iter().zip(given) {
            let number = |class: &String| {
                let at = known.classes.iter().position(|name| name == class);
                at.map(|at| at as u32)
                    .ok_or_else(|| format!("knows no class {class:?}; it knows {}", known.classes.join(", ")))
            };
            numbers.push(given.classes.iter().map(number).collect::<Result<_, _>>()?);
        }
        let columns = numbers.iter().cycle();
        Ok(labels.values().iter().zip(columns).map(|(label, numbers)| numbers[*label as usize]).collect())
    }

    /// Returns the number of samples that are predicted at a time.
    pub fn batch(&self) -> usize {
        match self.kind {
            ModelKind::Network { batch, .. } => batch,
            ModelKind::Baseline { .. } | ModelKind::Average { .. } => 64,
        }
    }
}

impl fmt::Display for Card {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_kind(f)?;
        self.write_bits(f)?;
        self.write_inputs(f)?;
        self.write_task(f)?;
        let TrainedOn { source, digest, samples, part, seed, tuned_from, .. } = &self.trained_on;
        let part = match part {
            TrainingPart::Everything => "all of them".to_string(),
            TrainingPart::Fold { repetition, fold } => format!("repetition {repetition}, fold {fold}"),
        };
        line(f, "trained on", format!("{source}, {samples} samples ({part}), seed {seed}"))?;
        line(f, "data digest", digest.clone())?;
        tuned_from
            .as_ref()
            .map_or(Ok(()), |tensors| line(f, "tuned from", format!("the model of tensors {tensors}")))?;
        let score = match &self.score {
            None => "not measured".into(),
            Some(score) => score.words(&self.task),
        };
        line(f, "scored", score)?;
        let words = match &self.task {
            Task::Values(_) => self.intervals.as_ref().map_or(WITHOUT_INTERVALS.into(), ToString::to_string),
            Task::Classes(_) | Task::Levels(_) => {
                self.certainty.as_ref().map_or(NOT_CALIBRATED.into(), ToString::to_string)
            }
        };
        line(f, "certainty", words)?;
        let commit = self.commit.as_ref().map_or(String::new(), |commit| format!(" at {commit}"));
        line(f, "written by", format!("taxel {}{commit}, format {}", self.taxel, self.format))
    }
}

/// Writes what `key` of a card is.
fn line(f: &mut fmt::Formatter<'_>, key: &str, text: String) -> fmt::Result {
    writeln!(f, "{key:<12} {text}")
}

impl Card {
    /// Writes which network or baseline it is.
    fn write_kind(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let paper = if self.paper.is_empty() { String::new() } else { format!(" ({})", self.paper) };
        match &self.kind {
            ModelKind::Network { graph, .. } => {
                let cost = graph.cost();
                let network =
                    if graph.name() == self.name { String::new() } else { format!(": {}", graph.name()) };
                line(f, "network", format!("{}{network}{paper}", self.name))?;
                line(
                    f,
                    "size",
                    format!("{} parameters, {} MACs", thousands(cost.parameters), thousands(cost.macs)),
                )
            }
            ModelKind::Baseline { method, .. } => {
                line(f, "baseline", format!("{}{paper}", self.name))?;
                let method = serde_json::to_value(method).map_err(|_| fmt::Error)?;
                let settings = method.as_object().into_iter().flatten().filter(|(key, _)| *key != "name");
                let settings: Vec<String> = settings.map(|(key, value)| format!("{key} = {value}")).collect();
                if settings.is_empty() {
                    return Ok(());
                }
                line(f, "settings", settings.join(", "))
            }
            ModelKind::Average { members } => {
                let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
                line(f, "average", format!("{}: the mean of {}", self.name, names.join(" and ")))
            }
        }
    }

    /// Writes how its weights and values are kept in fewer bits, if they are.
    fn write_bits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.precision == Precision::Bf16 {
            let text = "16 per weight and factor (bf16), sums and values in 32; certainty as measured in 32";
            return line(f, "in bits", text.into());
        }
        let Some(Quantized { bits, digest, samples, .. }) = &self.quantized else { return Ok(()) };
        let seen = if *digest == self.trained_on.digest {
            "the training data".into()
        } else {
            format!("data {digest}")
        };
        line(f, "in bits", format!("{bits} per weight and value, ranges seen on {samples} samples of {seen}"))
    }

    /// Writes what it reads, and which inputs it makes of that.
    fn write_inputs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SampleSpec { layout, shape, length, topics, unit, rate, full_scale, table, .. } = &self.spec;
        let sizes: Vec<String> = shape.iter().map(usize::to_string).collect();
        let mut reading = format!("{layout}, {}: {}", layout.axes(), sizes.join(" × "));
        unit.iter().for_each(|unit| reading += &format!(", in {unit}"));
        rate.iter().for_each(|rate| reading += &format!(", {rate} Hz"));
        full_scale.iter().for_each(|full| reading += &format!(", full scale {full}"));
        line(f, "reads", reading)?;
        let columns = || table.as_ref().map_or(&[][..], |table| table.columns.as_slice());
        let names =
            Some(&self.spec.channel_names[..]).filter(|names| !names.is_empty()).unwrap_or_else(columns);
        if !names.is_empty() {
            line(f, "channels", shortened(names))?;
        }
        if let Some(words) = self.spec.tare.as_ref().and_then(Tare::words) {
            line(f, "less", format!("{words} (tare)"))?;
        }
        if let Some(rule) = length {
            line(f, "recordings", rule.key())?;
        }
        if !topics.is_empty() {
            line(f, "topics", topics.join(" + "))?;
        }
        if let Some(left) = self.inputs.iter().find_map(|input| input.transform.reduction()) {
            line(f, "of which", left.words())?;
        }
        if let Some(guard) = &self.guard {
            line(f, "guard", guard.words())?;
        }
        let inputs: Vec<&str> = self.inputs.iter().map(|input| input.name.as_str()).collect();
        line(f, "inputs", inputs.join(" + "))
    }

    /// Writes what it predicts.
    fn write_task(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for attribute in &self.task.attributes() {
            line(f, "answers", format!("{}: {}", attribute.name, shortened(&attribute.classes)))?;
        }
        for quantity in self.task.quantities() {
            let unit = quantity.unit.as_ref().map_or(String::new(), |unit| format!(", in {unit}"));
            line(f, "answers", format!("{}: a value{unit}", quantity.name))?;
        }
        Ok(())
    }
}

impl Score {
    /// Says the metrics of a table of `task` that have a column of their own, the first and the last of them:
    /// `accuracy 90.83 ± 2.70 %, macro-F1 90.81 ± 2.71 % (stratified 5-fold, 5 folds of samples that were not trained on)`.
    pub fn words(&self, task: &Task) -> String {
        let shown: Vec<&Metric> = metrics(task).iter().filter(|metric| metric.is_shown).collect();
        let ends = [shown.first(), shown.last()];
        let said = ends.into_iter().flatten().filter_map(|metric| {
            let mean = self.mean.get(metric.name)?;
            let sd = self.sd.as_ref().and_then(|sd| sd.get(metric.name));
            let spread = sd.map_or(String::new(), |sd| format!(" ± {sd:.2}"));
            let unit = metric.unit_of(task).map_or(String::new(), |unit| format!(" {unit}"));
            Some(format!("{} {mean:.2}{spread}{unit}", metric.in_words()))
        });
        let (said, protocol) = (said.collect::<Vec<_>>().join(", "), self.protocol.words(task));
        format!("{said} ({protocol}, {} folds of samples that were not trained on)", self.folds)
    }
}

/// Joins the names of a list; of a long one the first 12 and their number in all.
fn shortened(names: &[String]) -> String {
    const MOST: usize = 12;
    if names.len() > MOST {
        format!("{}, … ({} in all)", names[..MOST].join(", "), names.len())
    } else {
        names.join(", ")
    }
}
