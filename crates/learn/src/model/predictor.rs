//! A model opened for prediction: raw samples in, probabilities out.

use std::sync::Arc;

use ndarray::{ArrayD, ArrayRef, Axis, CowArray, IxDyn, Slice};
use taxel_graph::Weights;
use taxel_guard::{Guard, ReplacedElement, Watch};

use super::card::{Card, ModelInput};
use super::open::open;
use super::predictions::Predictions;
use super::ready::Ready;
use super::workspace::Workspace;
use crate::certainty::{Summary, familiarity, tempered};
use crate::encoding::{Transform, mended};
use crate::error::{Error, Result};
use crate::metrics::{around, spread};

/// Raw samples `[n, ..]`, whoever owns them.
type RawSamples = ArrayRef<f32, IxDyn>;

/// Raw values that are encoded together, about: 1 MiB of them.
const PIECE: usize = 1 << 18;
/// Samples that are encoded together at least.
const LEAST: usize = 256;

/// A model opened for prediction; threads share one.
///
/// [`Predictor::encode`] and [`Predictor::predict_encoded`] are the two halves of [`Predictor::predict`].
pub struct Predictor {
    card: Card,
    guard: Option<Arc<Guard>>,
    outputs: usize,
    /// Values that the model computes for one sample, of which the first `outputs` answer.
    width: usize,
    /// Classes of each attribute; none of values.
    sizes: Vec<usize>,
    method: Box<dyn Ready>,
}

impl Predictor {
    pub(super) fn new(card: &Card, weights: &Weights, batch: usize, threads: usize) -> Result<Self> {
        let method = open(card, weights, batch, threads)?;
        let guard = card.guard.clone().map(Arc::new);
        let sizes = card.levels().sizes().to_vec();
        let outputs = card.task.outputs();
        Ok(Predictor { outputs, width: card.width(), sizes, card: card.clone(), guard, method })
    }

    /// Returns the same predictor with another guard, or without one, whatever the model's card says.
    ///
    /// # Errors
    /// A guard of other samples than the model reads.
    pub fn guarded(self, guard: Option<Arc<Guard>>) -> Result<Self> {
        let Card { spec, name, .. } = &self.card;
        let fits = guard.as_ref().map_or(Ok(()), |guard| guard.check(spec.layout, &spec.shape));
        match fits {
            Ok(()) => Ok(Predictor { guard, ..self }),
            Err(given) => {
                let expected = format!("a guard of samples of shape {:?}", spec.shape);
                Err(Error::Samples { model: name.clone(), expected, given })
            }
        }
    }

    /// Returns the guard before the inputs, if there is one.
    pub fn guard(&self) -> Option<&Guard> {
        self.guard.as_deref()
    }

    /// Returns the findings of the guard in raw samples `[n, ..]`, one list for each; nothing without a guard.
    ///
    /// # Errors
    /// As [`Predictor::encode`], but that nothing is encoded.
    pub fn found(&self, x: &RawSamples) -> Result<Vec<Vec<ReplacedElement>>> {
        let x = &*self.kept(x)?;
        Ok(match &self.guard {
            Some(guard) => mended(guard, x).1,
            None => vec![vec![]; x.len_of(Axis(0))],
        })
    }

    /// Says which of raw samples `[n, ..]` hold values far outside those of the training; none where none does.
    ///
    /// # Errors
    /// As [`Predictor::encode`], but that nothing is encoded.
    pub fn range_warning(&self, x: &RawSamples) -> Result<Option<String>> {
        let kept = self.kept(x)?;
        let values = kept.as_standard_layout();
        let each = self.card.spec.shape.iter().product::<usize>().max(1);
        let samples = values.as_slice().unwrap_or_default().chunks(each);
        Ok(self.card.trained_on.ranges.warning(samples, &self.card.spec.channel_names))
    }

    /// Returns the card of the model.
    pub fn card(&self) -> &Card {
        &self.card
    }

    /// Encodes raw samples `[n, ..]` as the model's inputs.
    ///
    /// # Errors
    /// Samples of another shape than the model reads, or readings that are not finite or cannot be encoded.
    pub fn encode(&self, x: &RawSamples) -> Result<Vec<ArrayD<f32>>> {
        let kept = self.kept(x)?;
        self.encode_mended(&self.mended(&kept))
    }

    /// Returns samples as the guard hands them on.
    pub(super) fn mended<'x>(&self, kept: &'x RawSamples) -> CowArray<'x, f32, IxDyn> {
        match &self.guard {
            Some(guard) => mended(guard, kept).0.into(),
            None => kept.view().into(),
        }
    }

    /// Encodes what the guard hands on.
    fn encode_mended(&self, x: &RawSamples) -> Result<Vec<ArrayD<f32>>> {
        let (n, readings, name) = (x.len_of(Axis(0)), x.as_standard_layout(), &self.card.name);
        let of_one = (readings.len() / n.max(1)).max(1);
        let encoded = |transform: &Transform| -> Result<ArrayD<f32>> {
            let mut encoder = transform.compile(x.shape().get(1..).unwrap_or_default(), name)?;
            let mut input = ArrayD::zeros([&[n], encoder.shape()].concat());
            let each = encoder.shape().iter().product::<usize>().max(1);
            if let (Some(readings), Some(values)) = (readings.as_slice(), input.as_slice_mut()) {
                for (reading, values) in readings.chunks_exact(of_one).zip(values.chunks_exact_mut(each)) {
                    encoder.encode(reading, values)?;
                }
            }
            Ok(input)
        };
        let inputs = self.card.inputs.iter();
        // An error is that of all samples together, whose message names the sample.
        let input = |ModelInput { transform, .. }: &ModelInput| {
            encoded(transform).or_else(|_| transform.apply(&x.to_owned(), name))
        };
        inputs.map(input).collect()
    }

    /// Makes memory for one thread that predicts sample by sample.
    ///
    /// # Errors
    /// A model whose card says that it reads what its inputs cannot be made of.
    pub fn workspace(&self) -> Result<Workspace> {
        let Card { inputs, spec, name, .. } = &self.card;
        let encoders = inputs.iter().map(|input| input.transform.compile(&spec.shape, name));
        let memory = self.method.memory();
        let watch = self.guard.clone().map(Watch::new);
        let encoders = encoders.collect::<Result<_>>()?;
        Ok(Workspace::new(watch, encoders, memory, [self.width, self.outputs], self.summary()))
    }

    /// Probabilities of one raw reading, row-major, of the shape that the card states: those of [`Predictor::predict`],
    /// bit for bit. Nothing is allocated after a workspace's first prediction.
    ///
    /// # Errors
    /// As [`Predictor::read`] and [`Predictor::decide`].
    pub fn predict_one<'w>(&self, workspace: &'w mut Workspace, reading: &[f32]) -> Result<&'w [f32]> {
        self.read(workspace, reading)?;
        self.decide(workspace)
    }

    /// Predicts as [`Predictor::predict_one`] a sample of which the share `seen`, above 0 and at most 1, is there and the rest was
    /// filled up: as sure as such beginnings are right.
    ///
    /// # Errors
    /// As [`Predictor::predict_one`].
    pub fn predict_start<'w>(
        &self,
        workspace: &'w mut Workspace,
        reading: &[f32],
        seen: f64,
    ) -> Result<&'w [f32]> {
        self.read(workspace, reading)?;
        self.decide_at(workspace, seen)
    }

    /// Runs the first half of [`Predictor::predict_one`]: one raw sample to the model's inputs.
    ///
    /// # Errors
    /// A reading of another length, that is not finite or cannot be encoded.
    pub fn read(&self, workspace: &mut Workspace, reading: &[f32]) -> Result<()> {
        let shape = &self.card.spec.shape;
        if reading.len() != shape.iter().product::<usize>() {
            return Err(self.refuse(format!("this one has {} values", reading.len())));
        }
        let Workspace { guard, encoders, inputs, summary, .. } = workspace;
        let reading = match guard {
            Some(guard) => guard.mend(reading),
            None => reading,
        };
        if let Some((summary, range)) = summary {
            summary.of(reading, *range);
        }
        for (encoder, input) in encoders.iter_mut().zip(inputs) {
            encoder.encode(reading, input)?;
        }
        Ok(())
    }

    /// Runs the second half of [`Predictor::predict_one`]: the inputs of the last sample to probabilities.
    ///
    /// # Errors
    /// A workspace of another model.
    pub fn decide<'w>(&self, workspace: &'w mut Workspace) -> Result<&'w [f32]> {
        self.decide_at(workspace, 1.0)
    }

    fn decide_at<'w>(&self, workspace: &'w mut Workspace, seen: f64) -> Result<&'w [f32]> {
        let Workspace { inputs, memory, logits, probabilities, .. } = workspace;
        if logits.len() != self.width || !self.method.decide_one(inputs, memory, logits)? {
            return Err(self.refuse("the workspace is of another model".into()));
        }
        probabilities.copy_from_slice(&logits[..self.outputs]);
        self.method.finish(probabilities);
        self.temper(probabilities, seen);
        Ok(&workspace.probabilities)
    }

    /// Returns the familiarity of the last sample of a workspace, of which the share `seen` was there: the share of held-out
    /// samples that were at least as unlike what the model has learned, 0.01..1. None of a model without a gate. Nothing is
    /// allocated.
    pub fn familiarity(&self, workspace: &mut Workspace, seen: f64) -> Option<f32> {
        let Workspace { logits, scratch, summary, .. } = workspace;
        let logits = (logits.len() == self.outputs).then_some(&**logits);
        let summary = summary.as_ref().map(|(summary, _)| summary.last());
        familiarity(self.card.logits_gate(), self.card.readings_gate(), logits, summary, seen, scratch)
    }

    /// Returns the interval of one quantity of the last sample of a workspace that holds the true value in `share` of samples, 0.8,
    /// 0.9, 0.95 or 0.99. None of classes, and of a model without intervals of that share. Nothing is allocated.
    pub fn interval(&self, workspace: &Workspace, quantity: usize, share: f64) -> Option<[f32; 2]> {
        let at = self.card.intervals.as_ref()?.at(share)?;
        let Workspace { logits, probabilities, .. } = workspace;
        let value = *probabilities.get(quantity).filter(|_| logits.len() == self.width)?;
        let loss = self.card.value_loss();
        let around = loss.map_or([1.0; 2], |loss| around(loss, logits, self.outputs, quantity));
        Some(at.ends(quantity, value, around))
    }

    /// Returns what summarises a sample for the gate of readings, and their range.
    fn summary(&self) -> Option<(Summary, f32)> {
        let readings = self.card.readings_gate()?;
        let spec = &self.card.spec;
        Some((Summary::new(spec.layout, &spec.shape), readings.range))
    }

    /// Selects the channels that the model was trained on, of whole recordings. Checks that samples are of the model's shape
    /// and finite.
    pub(super) fn kept<'x>(&self, x: &'x RawSamples) -> Result<CowArray<'x, f32, IxDyn>> {
        let refuse = |given: String| Err(self.refuse(given));
        let spec = &self.card.spec;
        let kept: CowArray<'x, f32, IxDyn> = match (&spec.channels, x.shape()) {
            (Some(channels), [_, given, ..])
                if *given != spec.shape[0] && channels.iter().all(|channel| channel < given) =>
            {
                x.select(Axis(1), channels).into()
            }
            _ => x.view().into(),
        };
        match kept.shape() {
            [] | [0, ..] => return refuse("there are none".into()),
            [_, shape @ ..] if *shape != spec.shape[..] => return refuse(format!("these have {shape:?}")),
            _ => {}
        }
        let each = (kept.len() / kept.len_of(Axis(0))).max(1);
        match kept.iter().position(|v| !v.is_finite()) {
            Some(at) => {
                refuse(format!("sample {} holds a reading that is not finite (NaN or infinity)", at / each))
            }
            None => Ok(kept),
        }
    }

    fn refuse(&self, given: String) -> Error {
        let spec = &self.card.spec;
        let expected = format!("samples of shape {:?} ({})", spec.shape, spec.layout.axes());
        Error::Samples { model: self.card.name.clone(), expected, given }
    }

    /// Turns encoded samples into probabilities `[n, outputs]`, row-major.
    ///
    /// # Errors
    /// Inputs of another number or shape.
    pub fn predict_encoded(&self, inputs: &[ArrayD<f32>]) -> Result<Vec<f32>> {
        Ok(self.finished(self.logits_encoded(inputs)?))
    }

    /// Turns encoded samples into logits `[n, outputs]`, row-major: decision values of MiniRocket and the SVMs, of values and of
    /// the other baselines what they predict.
    ///
    /// # Errors
    /// As [`Predictor::predict_encoded`].
    pub fn logits_encoded(&self, inputs: &[ArrayD<f32>]) -> Result<Vec<f32>> {
        let n = inputs.first().map_or(0, |x| x.len_of(Axis(0)));
        if let Some(x) = inputs.iter().find(|x| x.len_of(Axis(0)) != n) {
            let expected = "as many samples in every input".to_string();
            let given = format!("there are {n} and {}", x.len_of(Axis(0)));
            return Err(Error::Samples { model: self.card.name.clone(), expected, given });
        }
        let standard: Vec<_> = inputs.iter().map(|x| x.as_standard_layout()).collect();
        #[expect(clippy::expect_used, reason = "standard layout is one slice")]
        let values: Vec<&[f32]> = standard.iter().map(|x| x.as_slice().expect("standard layout")).collect();
        self.method.decide(&values, n)
    }

    /// Turns rows of logits into probabilities as sure as the card says, or into values.
    pub fn finished(&self, mut logits: Vec<f32>) -> Vec<f32> {
        if self.width > self.outputs {
            logits = logits.chunks_exact(self.width).flat_map(|row| &row[..self.outputs]).copied().collect();
        }
        self.method.finish(&mut logits);
        self.temper(&mut logits, 1.0);
        logits
    }

    /// Divides the logits of probabilities by the temperature of the card for samples of which the share `seen` is there, if it
    /// has one.
    fn temper(&self, outputs: &mut [f32], seen: f64) {
        if let Some(temperature) = self.card.certainty.as_ref().and_then(|certainty| certainty.at(seen)) {
            tempered(outputs, &self.sizes, temperature);
        }
    }

    /// Predicts raw samples `[n, ..]`.
    ///
    /// # Errors
    /// As [`Predictor::encode`] and [`Predictor::predict_encoded`].
    pub fn predict(&self, x: &RawSamples) -> Result<Predictions> {
        let mut summary = self.summary();
        let mut numbers = vec![];
        let logits = self.logits_of(x, &mut |sample| {
            if let Some((summary, range)) = &mut summary {
                numbers.extend(summary.of(sample, *range));
            }
        })?;
        let familiarity = self.familiarities(&logits, &numbers);
        let spread = self.card.value_loss().map_or(vec![], |loss| spread(loss, &logits, self.outputs));
        let predictions = Predictions::new(self.card.task.clone(), self.finished(logits), familiarity);
        Ok(predictions.with_intervals(spread, self.card.intervals.clone()))
    }

    /// Computes the logits `[n, outputs]` of raw samples `[n, ..]`, as [`Predictor::logits_encoded`] does.
    ///
    /// # Errors
    /// As [`Predictor::predict`].
    pub fn logits(&self, x: &RawSamples) -> Result<Vec<f32>> {
        self.logits_of(x, &mut |_| {})
    }

    /// Computes the logits, and shows each sample as the guard hands it on.
    fn logits_of(&self, x: &RawSamples, see: &mut dyn FnMut(&[f32])) -> Result<Vec<f32>> {
        let kept = self.kept(x)?;
        let n = kept.len_of(Axis(0));
        let each = (kept.len() / n).max(1);
        // Samples are read where they lie, and only some of them stand encoded at a time.
        let step = (PIECE / each).max(LEAST);
        let mut logits = Vec::with_capacity(n * self.width);
        for first in (0..n).step_by(step) {
            let piece = kept.slice_axis(Axis(0), Slice::from(first..(first + step).min(n)));
            let piece = self.mended(&piece);
            let inputs = match self.encode_mended(&piece) {
                Ok(inputs) => inputs,
                // The message that numbers the samples from the first.
                Err(error) => return Err(self.encode_mended(&self.mended(&kept)).err().unwrap_or(error)),
            };
            piece.as_standard_layout().as_slice().unwrap_or_default().chunks_exact(each).for_each(&mut *see);
            logits.extend(self.logits_encoded(&inputs)?);
        }
        Ok(logits)
    }

    /// Returns the familiarity of each sample by its row of logits and its row of summary numbers; none without a gate.
    fn familiarities(&self, logits: &[f32], numbers: &[f32]) -> Option<Vec<f32>> {
        let (of_logits, of_readings) = (self.card.logits_gate(), self.card.readings_gate());
        let mut scratch = vec![];
        let width = numbers.len() / (logits.len() / self.width.max(1)).max(1);
        let of_row = |(row, logits): (usize, &[f32])| {
            let logits = (self.width == self.outputs).then_some(logits);
            let summary = numbers.get(row * width..(row + 1) * width).filter(|summary| !summary.is_empty());
            familiarity(of_logits, of_readings, logits, summary, 1.0, &mut scratch)
        };
        logits.chunks_exact(self.width).enumerate().map(of_row).collect()
    }

    /// Checks whether classes are decided by logits: not by k-NN and the majority.
    pub fn has_logits(&self) -> bool {
        !self.sizes.is_empty() && self.method.has_logits()
    }
}
