//! A model ready to answer: raw samples in, probabilities out.

use std::borrow::Cow;

use ndarray::{ArrayD, Axis};
use taxel_engine::{Evaluator, Options, Workspace};
use taxel_graph::{Loss, Weights};

use super::card::{Anatomy, Card};
use super::predictions::Predictions;
use crate::baseline::FittedBaseline;
use crate::error::{Error, Result};
use crate::objective::probabilities;

/// A model with what it needs to answer many samples.
///
/// [`Predictor::encode`] and [`Predictor::answer`] are the two halves of [`Predictor::predict`].
pub struct Predictor {
    card: Card,
    outputs: usize,
    method: Method,
}

enum Method {
    Network { evaluator: Box<Evaluator>, workspace: Box<Workspace>, loss: Loss, batch: usize },
    Baseline(FittedBaseline),
}

impl Predictor {
    pub(super) fn new(card: &Card, weights: &Weights, batch: usize, threads: usize) -> Result<Self> {
        let batch = batch.max(1);
        let method = match &card.anatomy {
            Anatomy::Network { graph, loss, .. } => {
                let options = Options { batch, threads, ..Options::default() };
                let evaluator = Box::new(Evaluator::new(graph, weights, options)?);
                let workspace = Box::new(evaluator.workspace());
                Method::Network { evaluator, workspace, loss: *loss, batch }
            }
            Anatomy::Baseline { method, series } => {
                let read = FittedBaseline::read(*method, *series, &card.attributes, weights);
                let refuse = |source| Error::Baseline { baseline: card.name.clone(), source };
                Method::Baseline(read.map_err(refuse)?)
            }
        };
        Ok(Predictor { outputs: card.levels().outputs(), card: card.clone(), method })
    }

    /// What the model says about itself.
    pub fn card(&self) -> &Card {
        &self.card
    }

    /// Raw samples `[n, ..]` to the model's inputs.
    ///
    /// # Errors
    /// Samples of another shape than the model reads, or readings that are not finite or cannot be encoded.
    pub fn encode(&self, x: &ArrayD<f32>) -> Result<Vec<ArrayD<f32>>> {
        let x = &*self.kept(x);
        self.check(x)?;
        let inputs = self.card.inputs.iter();
        inputs.map(|input| input.transform.apply(x, &self.card.name)).collect()
    }

    /// Of whole recordings the channels that the model was trained on.
    fn kept<'x>(&self, x: &'x ArrayD<f32>) -> Cow<'x, ArrayD<f32>> {
        let reading = &self.card.reading;
        match (&reading.channels, x.shape()) {
            (Some(channels), [_, given, ..])
                if *given != reading.shape[0] && channels.iter().all(|channel| channel < given) =>
            {
                Cow::Owned(x.select(Axis(1), channels))
            }
            _ => Cow::Borrowed(x),
        }
    }

    fn check(&self, x: &ArrayD<f32>) -> Result<()> {
        let refuse = |given: String| {
            let reading = &self.card.reading;
            let expected = format!("samples of shape {:?} ({})", reading.shape, reading.layout.axes());
            Err(Error::Samples { model: self.card.name.clone(), expected, given })
        };
        match x.shape() {
            [] | [0, ..] => return refuse("there are none".into()),
            [_, shape @ ..] if *shape != self.card.reading.shape[..] => {
                return refuse(format!("these have {shape:?}"));
            }
            _ => {}
        }
        let each = (x.len() / x.len_of(Axis(0))).max(1);
        match x.iter().position(|v| !v.is_finite()) {
            Some(at) => refuse(format!("sample {} holds a reading that is not finite", at / each)),
            None => Ok(()),
        }
    }

    /// Encoded samples to probabilities `[n, outputs]`, row-major.
    ///
    /// # Errors
    /// Inputs of another shape, or what the engine refuses.
    pub fn answer(&mut self, inputs: &[ArrayD<f32>]) -> Result<Vec<f32>> {
        let n = inputs.first().map_or(0, |x| x.len_of(Axis(0)));
        let standard: Vec<_> = inputs.iter().map(|x| x.as_standard_layout()).collect();
        #[expect(clippy::expect_used, reason = "standard layout is one slice")]
        let values: Vec<&[f32]> = standard.iter().map(|x| x.as_slice().expect("standard layout")).collect();
        match &mut self.method {
            Method::Network { evaluator, workspace, loss, batch } => {
                let mut outputs = vec![];
                for start in (0..n).step_by(*batch) {
                    let count = (*batch).min(n - start);
                    let each = |x: &[f32]| x.len() / n;
                    let rows = |x: &[f32]| start * each(x)..(start + count) * each(x);
                    let parts: Vec<&[f32]> = values.iter().map(|x| &x[rows(x)]).collect();
                    outputs.extend_from_slice(evaluator.answer(workspace, &parts, count)?);
                }
                probabilities(*loss, self.outputs, &mut outputs);
                Ok(outputs)
            }
            Method::Baseline(baseline) => match values[..] {
                [series] => baseline.scores(series),
                _ => {
                    let (model, expected) = (self.card.name.clone(), "one input".to_string());
                    Err(Error::Samples { model, expected, given: format!("{} are given", values.len()) })
                }
            },
        }
    }

    /// What the model says about raw samples `[n, ..]`.
    ///
    /// # Errors
    /// As [`Predictor::encode`] and [`Predictor::answer`].
    pub fn predict(&mut self, x: &ArrayD<f32>) -> Result<Predictions> {
        let inputs = self.encode(x)?;
        let probabilities = self.answer(&inputs)?;
        Ok(Predictions::new(self.card.attributes.clone(), probabilities))
    }
}
