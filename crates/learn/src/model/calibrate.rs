//! A model whose probabilities, or intervals, are fitted to labelled recordings that it has not learned from.

use ndarray::{ArrayRef, IxDyn};
use taxel_data::{Dataset, Quantity, Task};

use super::file::Model;
use super::marks::known;
use crate::certainty::{Certainty, HeldOut, HeldOutParts, HeldOutValues, Intervals, Place, Seen};
use crate::error::{Error, Result};

impl Model {
    /// Returns the same model with a certainty that was fitted to others of its kind, the models of folds. Its gate learns where this
    /// model has the samples of `dataset`, which it was trained on.
    ///
    /// # Errors
    /// Samples that the model refuses.
    pub fn with_certainty_of(self, certainty: Certainty, dataset: &Dataset) -> Result<Model> {
        let Some(seen) = certainty.seen.clone().filter(|seen| seen.places.is_empty()) else {
            return Ok(self.with_certainty(Some(certainty)));
        };
        let card = self.card();
        let logits = self.predictor(card.batch(), 1)?.logits(&dataset.x)?;
        let labels = dataset.targets.labels().map_or(&[][..], |labels| labels.values());
        let places = Place::of_logits(&logits, labels, &card.levels());
        let seen = places.map(|places| Seen { places, ..seen });
        Ok(self.with_certainty(Some(Certainty { seen, ..certainty })))
    }

    /// Returns the same model with a temperature that is fitted to its answers for raw samples `x` `[n, ..]`, whose labels and
    /// groups are those of `dataset`; of values with intervals. Nothing is trained; what was fitted earlier is forgotten.
    ///
    /// # Errors
    /// A model in front of the samples that it has learned from; classes or quantities that it does not know; fewer than 30
    /// samples; samples as [`Model::predict`] refuses them.
    pub fn calibrated(&self, x: &ArrayRef<f32, IxDyn>, dataset: &Dataset) -> Result<Model> {
        let card = self.card();
        let refuse = |reason: String| Error::Calibration { model: card.name.clone(), reason };
        if dataset.digest == card.trained_on.digest {
            return Err(refuse(
                "was trained on these recordings, and is surer of them than of others; give new ones".into(),
            ));
        }
        let known = known(&card.trained_on.marks, x);
        if known > 0 {
            return Err(refuse(format!(
                "was trained on some of these recordings ({known} of {} samples that it keeps a mark of), and is surer of them \
                 than of others; give new ones",
                card.trained_on.marks.len()
            )));
        }
        if let Task::Values(quantities) = &card.task {
            return self.calibrated_values(quantities, x, dataset);
        }
        let held = HeldOut { truth: card.labels_of(dataset).map_err(refuse)?, ..HeldOut::default() };
        let plain = self.clone().with_certainty(None);
        let predictor = plain.predictor(card.batch(), 1)?;
        let logits = predictor.logits(x)?;
        let probabilities = predictor.finished(logits.clone());
        let logits = if predictor.has_logits() { logits } else { vec![] };
        let n = dataset.len();
        let groups = dataset.groups.clone();
        let rows = (0..n).collect();
        let held = HeldOut { probabilities, logits, parts: vec![0; n], rows, groups, ..held };
        let seed = card.trained_on.seed;
        let fitted = Certainty::fit(&held, &card.levels(), HeldOutParts::Recordings, &dataset.digest, seed)?;
        match fitted {
            Some(certainty) => {
                let (levels, kept) = (card.levels(), predictor.kept(x)?);
                let readings = (card.spec.layout, &*predictor.mended(&kept));
                let certainty = certainty.with_logits(&held, &[], &levels);
                let certainty = certainty.with_readings(&held, readings, &levels);
                Ok(plain.with_certainty(Some(certainty)))
            }
            None => Err(refuse(too_few(n))),
        }
    }

    /// Returns the same model with intervals, and a gate of readings, that are fitted to its answers for raw samples `x`.
    fn calibrated_values(
        &self,
        quantities: &[Quantity],
        x: &ArrayRef<f32, IxDyn>,
        dataset: &Dataset,
    ) -> Result<Model> {
        let card = self.card();
        let refuse = |reason: String| Error::Calibration { model: card.name.clone(), reason };
        let names = quantities.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let values = dataset.targets.values();
        let values =
            values.ok_or_else(|| refuse(format!("answers {names}, and the recordings have classes")))?;
        let values = values
            .of_quantities(quantities)
            .map_err(|here| refuse(format!("answers {names}, and the recordings have {here}")))?;
        let predictor = self.predictor(card.batch(), 1)?;
        let predictions = predictor.predict(x)?;
        let groups = dataset.groups.clone();
        let n = dataset.len();
        let held = HeldOutValues {
            quantities: quantities.len(),
            truth: values.values().to_vec(),
            predicted: predictions.outputs,
            spread: predictions.spread,
            parts: groups.clone().unwrap_or_else(|| vec![0; n]),
            rows: (0..n).collect(),
            groups,
        };
        let intervals = Intervals::fit(&held, HeldOutParts::Recordings, &dataset.digest);
        let intervals = intervals.ok_or_else(|| refuse(too_few(n)))?;
        let kept = predictor.kept(x)?;
        let readings = (card.spec.layout, &*predictor.mended(&kept));
        Ok(self.clone().with_intervals(Some(intervals.with_readings(&held, readings))))
    }
}

fn too_few(samples: usize) -> String {
    format!("cannot be calibrated on {samples} samples; give 30 or more")
}
