//! A model as a file, and back.

use std::path::Path;

use ndarray::{ArrayRef, IxDyn};
use serde_json::{Value, json};
use taxel_baselines::Method;
use taxel_checkpoint::Cause;
use taxel_data::Layout;
use taxel_engine::Precision;
use taxel_graph::{Graph, Weights};

use super::card::{Card, FORMAT, Quantized, TrainedOn, TrainingPart};
use super::digest::digest;
use super::kind::ModelKind;
use super::members::members;
use super::multiplied::multiplied;
use super::predictions::Predictions;
use super::predictor::Predictor;
use crate::certainty::{Certainty, Intervals};
use crate::error::{Error, Result};
use crate::estimator::baseline::FittedBaseline;
use crate::problem::within;
use crate::training::recipe::LARGEST_BATCH;

/// A trained network or baseline that says all about itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    card: Card,
    weights: Weights,
}

impl Model {
    /// Makes a model of its parts; the card's digest is that of `weights`.
    pub(crate) fn new(card: Card, weights: Weights) -> Self {
        let tensors = digest(&weights);
        Model { card: Card { tensors, ..card }, weights }
    }

    /// Reads a model file, and the digest that stands last in its card: that of the card, which holds that of
    /// the tensors.
    ///
    /// # Errors
    /// As [`Model::open`], wherever the file stands.
    pub(crate) fn read(path: &Path) -> Result<(Self, String)> {
        let (weights, text) = taxel_checkpoint::read(path)?;
        Self::assembled(path, weights, text)
    }

    /// Reads the bytes of a model file; `origin` names them in messages.
    ///
    /// # Errors
    /// As [`Model::open`].
    pub fn from_bytes(bytes: &[u8], origin: &str) -> Result<Self> {
        let path = Path::new(origin);
        let read = taxel_checkpoint::from_bytes(bytes);
        let (weights, text) = read.map_err(|cause| Error::damaged(path, cause.to_string()))?;
        Ok(Self::assembled(path, weights, text)?.0)
    }

    /// Returns the bytes of the model's file.
    ///
    /// # Errors
    /// A card that cannot be written as JSON.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let path = Path::new(&self.card.name);
        let text = self.text(path)?.0;
        self.bytes(&text).map_err(|cause| Error::damaged(path, cause.to_string()))
    }

    /// Returns the bytes of a file whose card is `text`.
    fn bytes(&self, text: &str) -> std::result::Result<Vec<u8>, Cause> {
        match (&self.card.quantized, self.card.graph()) {
            (Some(_), Some(graph)) => {
                taxel_checkpoint::to_bytes_rounded(&self.weights, &multiplied(graph), text)
            }
            (None, Some(graph)) if self.card.precision == Precision::Bf16 => {
                taxel_checkpoint::to_bytes_halved(&self.weights, &multiplied(graph), text)
            }
            _ => taxel_checkpoint::to_bytes(&self.weights, text),
        }
    }

    /// Returns the card as the text of the file that `path` names, and its digest.
    fn text(&self, path: &Path) -> Result<(String, String)> {
        let text = serde_json::to_string(&self.card);
        let refuse = |e| Error::damaged(path, format!("the card cannot be encoded: {e}"));
        text.map(|text| sealed(&text)).map_err(refuse)
    }

    fn assembled(path: &Path, weights: Weights, text: Option<String>) -> Result<(Self, String)> {
        let no_model = "holds no model card: it is a checkpoint, or was written by an older version; make a \
                        model of it by training";
        let text = text.filter(|text| !text.is_empty()).ok_or_else(|| Error::damaged(path, no_model))?;
        let (card, digest) = read_card(path, &text)?;
        check(path, &card, &weights)?;
        Ok((Model { card, weights }, digest))
    }

    /// Writes the model, whole or not at all. Equal models give equal bytes.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        self.write(path).map(|_| ())
    }

    /// Writes the file as [`Model::save`] does, and returns the digest of the card.
    pub(crate) fn write(&self, path: &Path) -> Result<String> {
        let (text, digest) = self.text(path)?;
        taxel_checkpoint::write_bytes(path, self.bytes(&text))?;
        Ok(digest)
    }

    /// Returns the card.
    pub fn card(&self) -> &Card {
        &self.card
    }

    /// Returns its tensors, under PyTorch's names.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Returns the same model, which was trained on all samples of its data set and not on a fold.
    pub fn of_everything(self) -> Self {
        let trained_on = TrainedOn { part: TrainingPart::Everything, ..self.card.trained_on };
        Model { card: Card { trained_on, ..self.card }, ..self }
    }

    /// Returns the same model, whose training went on from that of `before`. Values that one of the two has met are in its range.
    pub(crate) fn tuned_from(self, before: &Card) -> Self {
        let ranges = self.card.trained_on.ranges.with(&before.trained_on.ranges);
        let trained_on =
            TrainedOn { tuned_from: Some(before.tensors.clone()), ranges, ..self.card.trained_on };
        Model { card: Card { trained_on, ..self.card }, ..self }
    }

    /// Returns the same model with a score that was measured elsewhere.
    pub fn with_score(self, score: Option<super::card::Score>) -> Self {
        Model { card: Card { score, ..self.card }, ..self }
    }

    /// Returns the same model with intervals around its values, or without any.
    pub fn with_intervals(self, intervals: Option<Intervals>) -> Self {
        Model { card: Card { intervals, format: FORMAT, ..self.card }, ..self }
    }

    /// Returns the same model with probabilities that say what they mean, or as the method answers by itself.
    pub fn with_certainty(self, certainty: Option<Certainty>) -> Self {
        Model { card: Card { certainty, format: FORMAT, ..self.card }, ..self }
    }

    /// Opens the model for many samples, at most `batch` at a time on each of `threads` threads. Predictions depend
    /// on neither; a network's are those of its own test, bit for bit.
    ///
    /// # Errors
    /// An error of the runtime.
    pub fn predictor(&self, batch: usize, threads: usize) -> Result<Predictor> {
        Predictor::new(&self.card, &self.weights, batch, threads)
    }

    /// Predicts raw samples `[n, ..]`, each of the shape that the card states.
    ///
    /// # Errors
    /// Samples of another shape, or readings that are not finite or cannot be encoded.
    pub fn predict(&self, x: &ArrayRef<f32, IxDyn>) -> Result<Predictions> {
        self.predictor(self.card.batch(), 1)?.predict(x)
    }
}

/// Reads the card of a model file and its digest, if this version knows its format.
fn read_card(path: &Path, text: &str) -> Result<(Card, String)> {
    let broken = |e: serde_json::Error| Error::damaged(path, format!("its model card cannot be read: {e}"));
    // The format first: a newer card may hold what this version cannot read.
    let value: Value = serde_json::from_str(text).map_err(broken)?;
    match value.get("format").and_then(Value::as_u64) {
        Some(format) if (1..=u64::from(FORMAT)).contains(&format) => {}
        Some(format) => {
            let by = value.get("taxel").and_then(Value::as_str).unwrap_or("another version");
            let reason = format!(
                "is a model of format {format}, written by taxel {by}; this version ({}) reads formats up to \
                 {FORMAT}: open it with taxel {by} or newer",
                env!("CARGO_PKG_VERSION")
            );
            return Err(Error::damaged(path, reason));
        }
        None if value.get("network").is_some() => {
            let reason =
                "holds a network with its weights, but no model: train it, as [[networks]] file = \"...\"";
            return Err(Error::damaged(path, reason));
        }
        None => {
            let reason =
                "was written by a version without model files, or by another program; train it again";
            return Err(Error::damaged(path, reason));
        }
    }
    let card = text.rsplit_once(SEAL).map_or(String::new(), |(card, _)| format!("{card}}}"));
    let (as_written, digest) = sealed(&card);
    if as_written != text {
        let reason = "its card is not the one that was written (digests differ); fit the model again";
        return Err(Error::damaged(path, reason));
    }
    let card = match value.get("attributes").filter(|_| value.get("task").is_none()) {
        Some(_) => serde_json::from_value(upgraded(value)),
        None => serde_json::from_str(&card),
    };
    card.map(|card| (card, digest)).map_err(broken)
}

/// Returns a card of format 1 or 2 as one of this format: its `attributes` as a `task`, without the digest of its text.
fn upgraded(mut card: Value) -> Value {
    let Some(fields) = card.as_object_mut() else { return card };
    fields.remove("digest");
    let attributes = fields.remove("attributes").unwrap_or_default();
    let task = match attributes.as_array().map(Vec::as_slice) {
        Some([one]) => json!({ "classes": one.get("classes") }),
        _ => json!({ "attributes": attributes }),
    };
    fields.insert("task".into(), task);
    fields.insert("format".into(), json!(FORMAT));
    card
}

/// The text between a card and the digest of its text.
const SEAL: &str = ",\"digest\":\"";

/// Returns the JSON text of a card, with its own BLAKE3 as a last key; and that digest.
fn sealed(card: &str) -> (String, String) {
    let digest = blake3::hash(card.as_bytes()).to_hex().to_string();
    (format!("{}{SEAL}{digest}\"}}", card.strip_suffix('}').unwrap_or(card)), digest)
}

/// Checks that tensors and card belong together.
fn check(path: &Path, card: &Card, weights: &Weights) -> Result<()> {
    let refuse = |reason: String| Error::damaged(path, reason);
    check_reading(card).map_err(refuse)?;
    check_kind(card, weights).map_err(refuse)?;
    if digest(weights) != card.tensors {
        let reason =
            "its tensors are not those that its card was written for (digests differ); fit the model again";
        return Err(Error::damaged(path, reason));
    }
    Ok(())
}

/// Checks that the tensors are those of a network, of a baseline, or of the members of an average; says what is wrong otherwise.
fn check_kind(card: &Card, weights: &Weights) -> std::result::Result<(), String> {
    match &card.kind {
        ModelKind::Network { graph, batch, .. } => check_network(card, weights, graph, *batch),
        ModelKind::Baseline { method, series } => check_baseline(card, weights, *method, *series),
        ModelKind::Average { .. } => {
            let members = members(card, weights)?;
            if members.iter().map(|member| member.weights.len()).sum::<usize>() != weights.len() {
                return Err("it has tensors that none of the members of its average has".into());
            }
            if card.quantized.is_some() {
                return Err("its card says eight bits, which an average has not".into());
            }
            if card.precision != Precision::F32 {
                return Err("its card says bf16, which an average has not".into());
            }
            members.iter().try_for_each(|member| {
                check_kind(&member.card, &member.weights)
                    .map_err(|reason| format!("of {}, which it averages: {reason}", member.card.name))
            })
        }
    }
}

/// Checks what a card says of the readings and the task; says what is wrong otherwise.
fn check_reading(card: &Card) -> std::result::Result<(), String> {
    if card.task.outputs() == 0 || card.levels().sizes().contains(&0) {
        return Err("its card names no classes".into());
    }
    let (layout, shape) = (card.spec.layout, &card.spec.shape);
    if !layout.fits(shape) {
        return Err(format!("its card says that a {layout} reading has shape {shape:?}, which none has"));
    }
    card.readings_gate().map_or(Ok(()), |readings| readings.check_of(layout, shape))?;
    if let Some(Certainty { temperature, tenths, seen, .. }) = &card.certainty {
        seen.as_ref().map_or(Ok(()), |seen| seen.check(card.levels().sizes()))?;
        let is_none = |temperature: &&f64| !(temperature.is_finite() && **temperature > 0.0);
        if let Some(temperature) = tenths.iter().chain([temperature]).find(is_none) {
            return Err(format!("its card says a temperature of {temperature}, which none is"));
        }
        if !matches!(tenths.len(), 0 | 10) {
            return Err(format!("its card says temperatures of {} tenths", tenths.len()));
        }
    }
    let guarded = card.guard.as_ref().map_or(Ok(()), |guard| guard.check(layout, shape));
    guarded.map_err(|reason| format!("its card does not hold together: {reason}"))
}

/// Checks that the tensors are those of a network, and that it fits the rest of its card; says what is wrong otherwise.
fn check_network(
    card: &Card,
    weights: &Weights,
    graph: &Graph,
    batch: usize,
) -> std::result::Result<(), String> {
    if let Err(error) = weights.check(graph) {
        return Err(format!("its tensors are not those of its network: {error}"));
    }
    let outputs = card.width();
    let shape = graph.outputs().first().map_or(&[][..], |(_, id)| &graph.nodes()[*id].shape);
    if shape.iter().product::<usize>() != outputs {
        return Err(format!("its network has outputs {shape:?}, its card needs {outputs}"));
    }
    if let Some(reason) = card.quantized.as_ref().and_then(nonsense) {
        return Err(format!("its card does not hold together: {reason}"));
    }
    if card.quantized.is_some() && card.precision != Precision::F32 {
        return Err("its card does not hold together: it says eight bits and bf16".into());
    }
    let names = graph.inputs().map(|node| node.name.as_str());
    if !names.eq(card.inputs.iter().map(|input| input.name.as_str())) {
        return Err("its network reads other inputs than its card makes".into());
    }
    for (node, input) in graph.inputs().zip(&card.inputs) {
        if !makes(&input.transform.sizes(), &node.shape) {
            let (name, shape) = (&node.name, &node.shape);
            return Err(format!("its network reads `{name}` of shape {shape:?}, its card makes another"));
        }
    }
    within("batch", batch, 1, LARGEST_BATCH).map_err(|problem| format!("its card says {problem}"))
}

/// Checks that the tensors are those of a baseline, and that it fits the rest of its card; says what is wrong otherwise.
fn check_baseline(
    card: &Card,
    weights: &Weights,
    method: Method,
    series: [usize; 2],
) -> std::result::Result<(), String> {
    if let Err(error) = FittedBaseline::read(method, series, &card.task, weights) {
        return Err(format!("its tensors are not those of its baseline: {error}"));
    }
    if card.inputs.len() != 1 {
        return Err("a baseline reads one input; its card makes another number".into());
    }
    // Trees read a row of features as channels of one step.
    let is_row = card.spec.layout == Layout::Features && series[1] == 1;
    let made = if is_row { [1, series[0]] } else { series };
    if !makes(&card.inputs[0].transform.sizes(), &made) {
        return Err(format!("its baseline reads series of shape {series:?}, its card makes others"));
    }
    Ok(())
}

/// Returns what is impossible in a model of eight bits, if anything is.
fn nonsense(quantized: &Quantized) -> Option<String> {
    let broken = quantized
        .ranges
        .iter()
        .find(|(_, [low, high])| !(low.is_finite() && high.is_finite() && low <= high));
    match broken {
        Some((name, range)) => Some(format!("the values of {name} reach over {range:?}")),
        None if quantized.bits != 8 => Some(format!("values of {} bits", quantized.bits)),
        None => None,
    }
}

/// Checks whether an input of `shape` may end in axes of `sizes`, before memory is allocated.
fn makes(sizes: &[usize], shape: &[usize]) -> bool {
    let values = sizes.iter().try_fold(1usize, |values, size| values.checked_mul(*size));
    // A whole sample as one row is a multiple of them.
    let row = |n: &usize| values.is_some_and(|values| values > 0 && n.is_multiple_of(values));
    shape.ends_with(sizes) || matches!(shape, [n] | [1, n] if row(n))
}
