//! A network's model in eight bits, made from one in floats.

use ndarray::{ArrayD, Axis};
use taxel_engine::Precision;
use taxel_runtime::Observer;

use super::card::{Card, Quantized};
use super::file::Model;
use super::multiplied::multiplied;
use super::predictions::Predictions;
use crate::error::{Error, Result};

/// Samples that are looked at at most: the ranges of more hardly differ.
const MOST: usize = 512;
/// Samples that are encoded at a time.
const TOGETHER: usize = 32;

impl Model {
    /// Returns the same network in eight bits. `x` are raw samples `[n, ..]` like those that it will predict, best
    /// some that it has learned from; at most 512 are looked at, evenly thinned out. `digest` says which they are.
    ///
    /// A calibrated model stays so: the temperature is fitted again, to what the model in floats says of these samples.
    ///
    /// A value reaches from the least to the largest that was seen: clipping at a percentile saves steps, but cuts off
    /// the strongest contacts, which are rare in tactile recordings.
    ///
    /// # Errors
    /// A baseline, or a model in eight bits or bf16; samples as [`Model::predict`] refuses them.
    pub fn quantized(&self, x: &ArrayD<f32>, digest: &str) -> Result<Model> {
        let card = self.card();
        let refuse = |reason: &str| Err(Error::EightBits { model: card.name.clone(), reason: reason.into() });
        let Some(graph) = card.graph() else {
            return refuse("is a baseline: only networks have eight bits");
        };
        if card.quantized.is_some() {
            return refuse("is in eight bits already");
        }
        if card.precision == Precision::Bf16 {
            return refuse("is in bf16; quantize the model in floats that it was made of");
        }
        let mut weights = self.weights().clone();
        for name in multiplied(graph) {
            if let Some(rounded) = weights.get(name).map(taxel_checkpoint::rounded) {
                weights.insert(name, rounded);
            }
        }
        let mut observer = Observer::new(graph, &weights)?;
        let predictor = self.predictor(TOGETHER, 1)?;
        let n = x.shape().first().copied().unwrap_or(0);
        let rows: Vec<usize> = (0..n).step_by(n.div_ceil(MOST).max(1)).collect();
        if rows.is_empty() {
            return refuse("there are no samples to calibrate it on");
        }
        for rows in rows.chunks(TOGETHER) {
            let inputs = predictor.encode(&x.select(Axis(0), rows))?;
            let inputs: Vec<_> = inputs.iter().map(|input| input.as_standard_layout()).collect();
            for sample in 0..rows.len() {
                let one = |input: &ndarray::CowArray<f32, ndarray::IxDyn>| {
                    input.index_axis(Axis(0), sample).iter().copied().collect::<Vec<f32>>()
                };
                let one: Vec<Vec<f32>> = inputs.iter().map(one).collect();
                observer.see(&one.iter().map(Vec::as_slice).collect::<Vec<_>>())?;
            }
        }
        let quantized =
            Quantized { bits: 8, digest: digest.into(), samples: rows.len(), ranges: observer.ranges() };
        // What was measured, was measured in floats.
        let card = Card { quantized: Some(quantized), score: None, certainty: None, ..card.clone() };
        let plain = Model::new(card, weights);
        let seen = x.select(Axis(0), &rows);
        if let Some(intervals) = self.card().intervals.clone() {
            let (own, wanted) = (plain.predict(&seen)?, self.predict(&seen)?);
            return Ok(plain.with_intervals(Some(intervals.widened(&largest_changes(&own, &wanted)))));
        }
        let Some(certainty) = self.card().certainty.clone() else { return Ok(plain) };
        let (own, wanted) = (plain.predict(&seen)?.outputs, self.predict(&seen)?.outputs);
        let certainty = certainty.matched(&own, &wanted, self.card().levels().sizes());
        Ok(plain.with_certainty(Some(certainty)))
    }

    /// Returns the same model under another name.
    pub(crate) fn renamed(self, name: &str) -> Model {
        Model::new(Card { name: name.into(), ..self.card().clone() }, self.weights().clone())
    }

    /// Checks whether a tensor is in eight bits.
    pub(crate) fn is_rounded(&self, name: &str) -> bool {
        let names = self.card().graph().filter(|_| self.card().quantized.is_some()).map(multiplied);
        names.is_some_and(|names| names.contains(&name))
    }
}

/// Returns the largest change of each quantity by rounding, in its unit; of a model that says how far off it may be, in that.
fn largest_changes(rounded: &Predictions, answers: &Predictions) -> Vec<f64> {
    let width = answers.width();
    let largest = |quantity: usize| {
        let of_row = |row: usize| {
            let [below, above] = rounded.around(row, quantity);
            f64::from((rounded.row(row)[quantity] - answers.row(row)[quantity]).abs() / below.min(above))
        };
        (0..answers.len()).map(of_row).fold(0.0, f64::max)
    };
    (0..width).map(largest).collect()
}
