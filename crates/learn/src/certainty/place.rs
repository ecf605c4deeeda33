//! Where the logits of the classes lie.

use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use serde::{Deserialize, Serialize};

use crate::metrics::Levels;

/// The part of the mean variance that is added to every variance, so that logits that depend on each other can be used.
const RIDGE: f64 = 1e-3;

/// Where the logits of the classes of one attribute lie.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Mean logits of all samples `[classes]`.
    pub center: Vec<f32>,
    /// Lower triangle of the matrix that brings deviations from a class to variance 1, row by row.
    pub within: Vec<f32>,
    /// The same for deviations from the center.
    pub around: Vec<f32>,
    /// Means of the classes that have samples, less the center, times `within`: `[classes with samples, classes]`.
    pub means: Vec<f32>,
}

/// Returns the distance of a row of logits, summed over the attributes. Nothing is allocated once `scratch` has room.
pub(super) fn distance(places: &[Place], logits: &[f32], scratch: &mut Vec<f64>) -> f64 {
    let (mut rest, mut sum) = (logits, 0.0);
    for place in places {
        let (own, others) = rest.split_at(place.center.len());
        sum += place.distance(own, scratch);
        rest = others;
    }
    sum
}

impl Place {
    /// Finds where logits `[n, outputs]` of samples with labels `[n, attributes]` lie; none where they have no variance.
    pub fn of_logits(logits: &[f32], truth: &[u32], levels: &Levels) -> Option<Vec<Self>> {
        let of_attribute = |(logits, labels, size): (Vec<f32>, Vec<u32>, usize)| {
            let rows: Vec<&[f32]> = logits.chunks_exact(size.max(1)).collect();
            Place::fit(&rows, &labels)
        };
        levels.of_each(logits, truth).into_iter().map(of_attribute).collect()
    }

    fn fit(rows: &[&[f32]], labels: &[u32]) -> Option<Self> {
        let size = rows.first()?.len();
        let mut sums = vec![vec![0.0; size]; size];
        let mut counts = vec![0usize; size];
        for (row, label) in rows.iter().zip(labels) {
            counts[*label as usize] += 1;
            sums[*label as usize].iter_mut().zip(*row).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        let n = rows.len() as f64;
        let center: Vec<f64> = (0..size).map(|k| sums.iter().map(|sum| sum[k]).sum::<f64>() / n).collect();
        for (sum, count) in sums.iter_mut().zip(&counts) {
            sum.iter_mut().for_each(|sum| *sum /= (*count).max(1) as f64);
        }
        let deviations = |mean: &dyn Fn(usize) -> Vec<f64>| {
            let off = rows.iter().zip(labels).map(|(row, label)| -> Vec<f64> {
                let mean = mean(*label as usize);
                row.iter().zip(&mean).map(|(value, mean)| f64::from(*value) - mean).collect()
            });
            whitening(size, off, RIDGE)
        };
        let within = deviations(&|label| sums[label].clone())?;
        let around = deviations(&|_| center.clone())?;
        let mut means = vec![];
        for (mean, _) in sums.iter().zip(&counts).filter(|(_, count)| **count > 0) {
            let off: Vec<f64> = mean.iter().zip(&center).map(|(mean, center)| mean - center).collect();
            means.extend((0..size).map(|i| row_product(&within, i, &off) as f32));
        }
        let single = |values: &[f64]| values.iter().map(|value| *value as f32).collect();
        Some(Place { center: single(&center), within: single(&within), around: single(&around), means })
    }

    fn distance(&self, logits: &[f32], scratch: &mut Vec<f64>) -> f64 {
        let size = self.center.len();
        scratch.clear();
        scratch.extend(logits.iter().zip(&self.center).map(|(value, center)| f64::from(value - center)));
        let mut to_all = 0.0;
        for i in 0..size {
            let (off, _) = scratch.split_at(size);
            let [within, around] = [&self.within, &self.around].map(|triangle| row_product(triangle, i, off));
            to_all += around * around;
            scratch.push(within);
        }
        let own = &scratch[size..];
        let to_mean = |mean: &[f32]| -> f64 {
            mean.iter().zip(own).map(|(mean, own)| (own - f64::from(*mean)).powi(2)).sum()
        };
        self.means.chunks_exact(size).map(to_mean).fold(f64::INFINITY, f64::min) - to_all
    }
}

/// Returns the product of row `i` of a lower triangle with `values`.
pub(super) fn row_product<T: Copy + Into<f64>>(triangle: &[T], i: usize, values: &[f64]) -> f64 {
    let row = &triangle[i * (i + 1) / 2..][..=i];
    row.iter().zip(values).map(|(weight, value)| (*weight).into() * value).sum()
}

/// Returns the inverse of the Cholesky factor of the covariance of `deviations`, `size` numbers each: its lower triangle row by row. The part
/// `ridge` of the mean variance is added to every variance.
pub(super) fn whitening(
    size: usize,
    deviations: impl ExactSizeIterator<Item = Vec<f64>>,
    ridge: f64,
) -> Option<Vec<f64>> {
    let n = deviations.len() as f64;
    let mut covariance = Mat::<f64>::zeros(size, size);
    for off in deviations {
        for i in 0..size {
            for j in 0..=i {
                covariance[(i, j)] += off[i] * off[j] / n;
            }
        }
    }
    let mean = (0..size).map(|i| covariance[(i, i)]).sum::<f64>() / size as f64;
    if !(mean.is_finite() && mean > 0.0) {
        return None;
    }
    (0..size).for_each(|i| covariance[(i, i)] += ridge * mean);
    let factor = Llt::new(covariance.as_ref(), Side::Lower).ok()?;
    let mut inverse = Mat::<f64>::identity(size, size);
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(
        factor.L(),
        inverse.as_mut(),
        faer::Par::Seq,
    );
    let triangle: Vec<f64> =
        (0..size).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|at| inverse[at]).collect();
    triangle.iter().all(|value| value.is_finite()).then_some(triangle)
}
