//! Raw samples broken and encoded again, as training meets them.

use ndarray::{ArrayD, Axis};
use taxel_data::Dataset;
use taxel_faults::{FaultPlan, Sensor, TrainingFaults};
use taxel_guard::Watch;

use crate::encoding::{Compiled, Input};
use crate::error::Result;
use crate::problem::fault_problem;
use crate::sensor::sensor;
use crate::training::part::TrainingKey;

/// Breaks the samples of one training and encodes them.
pub(crate) struct Breaker<'a> {
    plan: FaultPlan,
    sensor: Sensor,
    dataset: &'a Dataset,
    part: TrainingKey,
    encoders: Vec<Compiled>,
    /// The guard, which stands before the network in training as in prediction.
    guard: Option<Watch>,
    /// Room for one raw sample.
    sample: ArrayD<f32>,
}

impl<'a> Breaker<'a> {
    /// Makes a breaker for samples of `dataset` that become `inputs`; what levels are relative to is fitted on
    /// `rows`. `None` where nothing is ever drawn.
    ///
    /// # Errors
    /// Faults without a meaning for these samples.
    pub fn new(
        faults: &TrainingFaults,
        dataset: &'a Dataset,
        rows: &[usize],
        inputs: &[&Input],
        part: TrainingKey,
    ) -> Result<Option<Self>> {
        if faults.is_clean() {
            return Ok(None);
        }
        let plan = faults.plan(dataset.spec.layout, &dataset.spec.shape).map_err(fault_problem)?;
        let (shape, source) = (&dataset.spec.shape, dataset.source.to_string());
        let encoders =
            inputs.iter().map(|input| input.transform.compile(shape, &source)).collect::<Result<Vec<_>>>()?;
        let sensor = sensor(dataset, rows).sensor;
        let guard = inputs.first().and_then(|input| input.guard.clone()).map(Watch::new);
        Ok(Some(Breaker {
            plan,
            sensor,
            dataset,
            part,
            encoders,
            guard,
            sample: ArrayD::zeros(shape.as_slice()),
        }))
    }

    /// Puts `rows`, drawn anew for `occasion`, into `batches`, one for each input, which hold them unbroken.
    ///
    /// A sample that cannot be encoded once it is broken (no contact is found, for example) stays as it is.
    ///
    /// # Errors
    /// Readings that are not finite.
    pub fn fill(&mut self, rows: &[usize], occasion: &str, batches: &mut [Vec<f32>]) -> Result<()> {
        for (position, &row) in rows.iter().enumerate() {
            self.sample.assign(&self.dataset.x.index_axis(Axis(0), row));
            let purpose = self.part.purpose(&format!("faults/{occasion}/{row}"));
            let broken = self.plan.apply(self.sample.view_mut(), &self.sensor, self.part.seed, &purpose, row);
            if broken.map_err(fault_problem)? == 0 {
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
}
