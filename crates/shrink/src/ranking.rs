//! Importance of sensors: the loss of a trained network while some sensors read their mean.

use ndarray::{ArrayD, Axis};
use taxel_data::{Dataset, Fold, Targets};
use taxel_learn::metrics::Outcome;
use taxel_learn::{Model, Predictor};

use crate::error::Result;
use crate::sensors::{Sensor, places};

/// Test samples that a network predicts at most.
const ASKED: usize = 200;
/// Of so many sensors that are left, one goes at a time.
const AT_ONCE: usize = 8;

/// A network with the samples that it predicts.
struct Witness {
    predictor: Predictor,
    x: ArrayD<f32>,
    rows: Vec<usize>,
    /// The mean training sample.
    mean: Vec<f32>,
}

/// Returns the positions of `sensors`, the most important first. Those go first whose readings, replaced by their mean over
/// the training samples, cost the least log-loss on the inner test parts, beside those that are gone already; of more
/// than eight that are left an eighth goes at a time. Each of `models` was trained on the fold beside it.
///
/// # Errors
/// Samples that a model refuses.
pub fn ranking(
    models: &[(Model, &Fold)],
    dataset: &Dataset,
    sensors: &[Sensor],
    threads: usize,
) -> Result<Vec<usize>> {
    let spec = &dataset.spec;
    let places: Vec<Vec<usize>> =
        sensors.iter().map(|sensor| places(spec.layout, &spec.shape, *sensor)).collect();
    let witnesses: Vec<Witness> = models
        .iter()
        .map(|(model, fold)| Witness::new(model, fold, dataset, threads))
        .collect::<Result<_>>()?;
    let (mut left, mut gone): (Vec<usize>, Vec<usize>) = ((0..sensors.len()).collect(), vec![]);
    while left.len() > 1 {
        let mut losses = vec![];
        for &sensor in &left {
            let masked =
                gone.iter().chain([&sensor]).flat_map(|&at| &places[at]).copied().collect::<Vec<_>>();
            let mut sum = 0.0;
            for witness in &witnesses {
                sum += witness.loss(&masked, &dataset.targets)?;
            }
            losses.push((sensor, sum));
        }
        // Of equals the last one goes.
        losses.sort_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        let some = left.len().div_ceil(AT_ONCE);
        gone.extend(losses[..some].iter().map(|(sensor, _)| *sensor));
        left.retain(|sensor| !gone.contains(sensor));
    }
    gone.extend(left);
    gone.reverse();
    Ok(gone)
}

impl Witness {
    fn new(model: &Model, fold: &Fold, dataset: &Dataset, threads: usize) -> Result<Self> {
        let step = fold.test.len().div_ceil(ASKED).max(1);
        let rows: Vec<usize> = fold.test.iter().copied().step_by(step).collect();
        let mut sums = vec![0.0f64; dataset.spec.shape.iter().product()];
        for &row in &fold.train {
            let sample = dataset.x.index_axis(Axis(0), row);
            sums.iter_mut().zip(sample.iter()).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        let count = fold.train.len().max(1) as f64;
        Ok(Witness {
            predictor: model.predictor(model.card().batch(), threads)?,
            x: dataset.x.select(Axis(0), &rows),
            rows,
            mean: sums.into_iter().map(|sum| (sum / count) as f32).collect(),
        })
    }

    /// Returns the mean loss with the readings at `masked` replaced by their mean.
    fn loss(&self, masked: &[usize], targets: &Targets) -> Result<f64> {
        let mut x = self.x.clone();
        for mut sample in x.outer_iter_mut() {
            if let Some(sample) = sample.as_slice_mut() {
                masked.iter().for_each(|&at| sample[at] = self.mean[at]);
            }
        }
        let outputs = self.predictor.predict(&x)?.outputs;
        Ok(Outcome::new(targets, &self.rows, outputs).loss(&targets.task())?)
    }
}

/// Joins several rankings to one: by mean position, of equals the first sensor.
pub fn together(rankings: &[Vec<usize>]) -> Vec<usize> {
    let count = rankings.first().map_or(0, Vec::len);
    let mut sums = vec![0; count];
    for ranking in rankings {
        ranking.iter().enumerate().for_each(|(place, &sensor)| sums[sensor] += place);
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&sensor| (sums[sensor], sensor));
    order
}

#[cfg(test)]
mod tests {
    use super::together;

    #[test]
    fn rankings_meet_in_the_middle() {
        assert_eq!(together(&[vec![2, 0, 1], vec![2, 1, 0], vec![0, 2, 1]]), [2, 0, 1]);
        assert_eq!(together(&[]), Vec::<usize>::new());
    }
}
