//! Raw samples changed and encoded again, as training meets them.

use ndarray::{ArrayD, Axis};
use taxel_data::{Augment, Dataset, Layout};
use taxel_faults::{FaultPlan, Sensor, TrainingFaults};
use taxel_guard::Watch;

use crate::encoding::{Compiled, Input};
use crate::error::Result;
use crate::problem::fault_problem;
use crate::sensor::sensor;
use crate::training::part::TrainingKey;
use crate::training::pass::TrainingPass;

/// Changes the raw samples of one training, at random and by faults, and encodes them.
pub(crate) struct RawChanges<'a> {
    faults: Option<FaultPlan>,
    sensor: Sensor,
    dataset: &'a Dataset,
    part: TrainingKey,
    encoders: Vec<Compiled>,
    /// The guard, which stands before the network in training as in prediction.
    guard: Option<Watch>,
    /// Room for one raw sample.
    sample: ArrayD<f32>,
}

impl<'a> RawChanges<'a> {
    /// Makes the changes of samples of `dataset` that become `inputs`; what levels are relative to is fitted on
    /// `rows`. `None` where nothing is ever changed.
    ///
    /// # Errors
    /// Faults without a meaning for these samples.
    pub fn new(
        faults: Option<&TrainingFaults>,
        augment: Option<&Augment>,
        (dataset, rows): (&'a Dataset, &[usize]),
        inputs: &[&Input],
        part: TrainingKey,
    ) -> Result<Option<Self>> {
        let faults = faults.filter(|faults| !faults.is_clean());
        if faults.is_none() && !augment.is_some_and(Augment::changes_readings) {
            return Ok(None);
        }
        let (shape, source) = (&dataset.spec.shape, dataset.source.to_string());
        let plan = |faults: &TrainingFaults| faults.plan(dataset.spec.layout, shape).map_err(fault_problem);
        let faults = faults.map(plan).transpose()?;
        let encoders =
            inputs.iter().map(|input| input.transform.compile(shape, &source)).collect::<Result<Vec<_>>>()?;
        let sensor = sensor(dataset, rows).sensor;
        let guard = inputs.first().and_then(|input| input.guard.clone()).map(Watch::new);
        let sample = ArrayD::zeros(shape.as_slice());
        Ok(Some(RawChanges { faults, sensor, dataset, part, encoders, guard, sample }))
    }

    /// Puts `rows`, drawn anew for `pass`, into `batches`, one for each input, which hold them unchanged.
    ///
    /// A sample that cannot be encoded once it is changed (no contact is found, for example) stays as it is.
    ///
    /// # Errors
    /// Readings that are not finite.
    pub fn fill(&mut self, rows: &[usize], pass: &TrainingPass, batches: &mut [Vec<f32>]) -> Result<()> {
        for (position, &row) in rows.iter().enumerate() {
            self.sample.assign(&self.dataset.x.index_axis(Axis(0), row));
            let augmented = self.augment(pass, row);
            let broken = self.break_sample(pass.occasion, row)?;
            if !(augmented || broken) {
                continue;
            }
            if let (Some(guard), Some(sample)) = (&mut self.guard, self.sample.as_slice_mut()) {
                guard.mend(sample);
            }
            let mut kept = vec![];
            for (encoder, batch) in self.encoders.iter_mut().zip(batches.iter_mut()) {
                let len = encoder.shape().iter().product::<usize>();
                let input = &mut batch[position * len..(position + 1) * len];
                kept.push(input.to_vec());
                #[expect(clippy::expect_used, reason = "a fresh array is contiguous")]
                let sample = self.sample.as_slice().expect("a contiguous sample");
                if encoder.encode(sample, input).is_err() {
                    // Inputs belong together: all of them stay as they were.
                    for (kept, batch) in kept.iter().zip(batches.iter_mut()) {
                        batch[position * kept.len()..(position + 1) * kept.len()].copy_from_slice(kept);
                    }
                    break;
                }
            }
        }
        Ok(())
    }

    /// Changes the readings of the sample at random; false if the pass does not.
    fn augment(&mut self, pass: &TrainingPass, sample: usize) -> bool {
        let Some((augment, key)) = pass.augment.filter(|(augment, _)| augment.changes_readings()) else {
            return false;
        };
        let (layout, shape) = (self.sensor.layout, &self.dataset.spec.shape);
        // Taxels lie side by side, frame after frame; readings of a channel follow each other.
        let steps = match layout {
            Layout::Series | Layout::Fingers => shape.last().copied().unwrap_or(1),
            _ => 1,
        };
        // A row of features has no first reading, at which nothing is touched.
        let is_known = layout != Layout::Features || self.dataset.spec.rest.is_some();
        let rest = if is_known { self.sensor.rest.as_slice() } else { &[0.0] };
        let span = self.sensor.high - self.sensor.low;
        let Some(readings) = self.sample.as_slice_mut() else { return false };
        augment.draw_readings(&taxel_data::Key { sample, ..key }).apply(readings, steps, rest, span);
        true
    }

    /// Breaks the sample by faults; false if none was drawn.
    ///
    /// # Errors
    /// Readings that are not finite.
    fn break_sample(&mut self, occasion: &str, sample: usize) -> Result<bool> {
        let Some(faults) = &self.faults else { return Ok(false) };
        let purpose = self.part.purpose(&format!("faults/{occasion}/{sample}"));
        let count = faults.apply(self.sample.view_mut(), &self.sensor, self.part.seed, &purpose, sample);
        Ok(count.map_err(fault_problem)? > 0)
    }
}
