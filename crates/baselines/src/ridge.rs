//! Ridge regression on one-against-the-rest targets, its penalty chosen by leaving one out.
//!
//! # Reference
//! scikit-learn's `RidgeClassifierCV` (Rifkin & Lippert 2007): targets −1 and 1, columns scaled to unit
//! deviation and centred, all leave-one-out errors without leaving one out. There they come from one
//! eigendecomposition, here from a Cholesky factor for each penalty, which takes a tenth of the time at some
//! thousand samples.

use std::collections::BTreeMap;

use faer::Mat;
use rayon::prelude::*;
use taxel_kernels::double;

use crate::equations::Equations;
use crate::{Error, Result, Saved};

/// The penalties that MiniRocket's authors choose from: 10⁻³ to 10³ in ten equal steps of the exponent.
pub const ALPHAS: [f64; 10] = [
    1e-3,
    4.641588833612779e-3,
    2.154434690031884e-2,
    0.1,
    0.46415888336127786,
    2.154434690031884,
    10.0,
    46.41588833612779,
    215.44346900318845,
    1e3,
];

/// Features `[n, width]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureMatrix {
    pub(crate) values: Vec<f32>,
    pub(crate) width: usize,
    /// How much each row counts in a regression; none where all count alike.
    weights: Option<Vec<f64>>,
}

impl FeatureMatrix {
    /// Makes a matrix of rows of `width` features.
    pub fn new(values: Vec<f32>, width: usize) -> Self {
        FeatureMatrix { values, width, weights: None }
    }

    /// Returns the same features with weights for a regression, above 0: a row of weight 2 counts as much as two.
    pub fn weighted(self, weights: Option<&[f32]>) -> Self {
        let weights = weights.map(|weights| weights.iter().map(|weight| f64::from(*weight)).collect());
        FeatureMatrix { weights, ..self }
    }

    /// Returns the weights of `n` rows.
    fn weights(&self, n: usize) -> Vec<f64> {
        self.weights.clone().unwrap_or_else(|| vec![1.0; n])
    }

    /// Returns the features, row after row.
    pub fn into_values(self) -> Vec<f32> {
        self.values
    }

    /// Returns the features, row after row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

/// A linear classifier on features, or a linear regression of values.
#[derive(Debug, Clone, PartialEq)]
pub struct Ridge {
    /// The penalty that was chosen.
    alpha: f64,
    /// Its mean squared leave-one-out error.
    error: f64,
    width: usize,
    /// `[classes, width]` on unscaled features.
    weights: Vec<f32>,
    /// `[classes]`.
    bias: Vec<f32>,
}

impl Ridge {
    /// Fits features of samples with classes `y`; of `alphas` the one with the least squared
    /// leave-one-out error over all classes is taken, of equals the first.
    ///
    /// # Errors
    /// No penalties, or one that is not positive.
    pub fn fit(x: &FeatureMatrix, y: &[u32], classes: usize, alphas: &[f64]) -> Result<Self> {
        Self::fit_targets(x, one_against_the_rest(y, classes), alphas)
    }

    /// Fits values `[n, outputs]`, row-major, of samples (scikit-learn's `RidgeCV` on standardised features).
    ///
    /// # Errors
    /// As [`Ridge::fit`].
    pub fn fit_values(x: &FeatureMatrix, values: &[f32], outputs: usize, alphas: &[f64]) -> Result<Self> {
        Self::fit_targets(x, rows_of(values, outputs), alphas)
    }

    fn fit_targets(x: &FeatureMatrix, mut targets: Mat<f64>, alphas: &[f64]) -> Result<Self> {
        if alphas.is_empty() || alphas.iter().any(|alpha| !(*alpha > 0.0 && alpha.is_finite())) {
            return Err(Error::setting("alphas", format!("{alphas:?}"), "must be positive numbers"));
        }
        let (n, classes, width) = (targets.nrows(), targets.ncols(), x.width);
        let weights = x.weights(n);
        let whole: f64 = weights.iter().sum();
        let roots: Vec<f64> = weights.iter().map(|weight| weight.sqrt()).collect();
        let (rows, mean, sd) = standardised(x, &weights);
        let offsets = means(&targets, &weights);
        for (c, offset) in offsets.iter().enumerate() {
            let column = targets.col_as_slice_mut(c).iter_mut().zip(&roots);
            column.for_each(|(target, root)| *target = (*target - offset) * root);
        }
        let equations = Equations::new(rows, roots);
        // So many factors are in memory at once, whatever the number of threads.
        let together = alphas.chunks(4).flat_map(|alphas| {
            let found = alphas.par_iter().map(|&alpha| {
                let penalised = equations.penalised(alpha)?;
                let solved = penalised.solve(&targets);
                let error = penalised.leave_one_out(&solved);
                error.is_finite().then(|| (error, penalised.weights(solved)))
            });
            found.collect::<Vec<_>>()
        });
        let mut best: Option<(f64, f64, Mat<f64>)> = None;
        for (&alpha, found) in alphas.iter().zip(together) {
            let Some((error, coefficients)) = found else { continue };
            if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                best = Some((error, alpha, coefficients));
            }
        }
        let Some((error, alpha, coefficients)) = best else {
            return Err(Error::setting("alphas", "none", "leave-one-out errors are not finite"));
        };
        let (mut weights, mut bias) = (Vec::with_capacity(classes * width), vec![]);
        for (column, offset) in coefficients.col_iter().zip(offsets) {
            let unscaled: Vec<f64> = column.iter().zip(&sd).map(|(w, sd)| w / sd).collect();
            let shift: f64 = unscaled.iter().zip(&mean).map(|(w, mean)| w * mean).sum();
            bias.push((offset - shift) as f32);
            weights.extend(unscaled.iter().map(|w| *w as f32));
        }
        Ok(Ridge { alpha, error: error / (whole * classes as f64), width, weights, bias })
    }

    /// Computes decision values `[n, classes]` of the samples that it was fitted to, each by a ridge of the same penalty that has
    /// not seen its unit: samples of one number in `units` are left out together. Nothing is fitted anew. The scale of the features
    /// stays that of all samples.
    ///
    /// # Errors
    /// Features, classes or units of other samples than it was fitted to.
    pub fn left_out(&self, x: &FeatureMatrix, y: &[u32], units: &[u32]) -> Result<Vec<f32>> {
        self.left_out_targets(x, &one_against_the_rest(y, self.bias.len()), units)
    }

    /// Computes values `[n, outputs]`, row-major, in the targets' units, as [`Ridge::left_out`] does decision values; `values`
    /// are the targets that it was fitted to.
    ///
    /// # Errors
    /// As [`Ridge::left_out`].
    pub fn left_out_values(&self, x: &FeatureMatrix, values: &[f32], units: &[u32]) -> Result<Vec<f32>> {
        let outputs = self.bias.len();
        if values.len() != units.len() * outputs {
            return Err(Error::Labels { labels: values.len() / outputs.max(1), samples: units.len() });
        }
        self.left_out_targets(x, &rows_of(values, outputs), units)
    }

    fn left_out_targets(&self, x: &FeatureMatrix, targets: &Mat<f64>, units: &[u32]) -> Result<Vec<f32>> {
        let (n, classes) = (targets.nrows(), self.bias.len());
        let refuse = || Error::Labels { labels: units.len(), samples: n };
        if x.width != self.width || x.values.len() != n * self.width || units.len() != n {
            return Err(refuse());
        }
        let weights = x.weights(n);
        if weights.len() != n {
            return Err(refuse());
        }
        let roots: Vec<f64> = weights.iter().map(|weight| weight.sqrt()).collect();
        let (rows, ..) = standardised(x, &weights);
        let equations = Equations::new(rows, roots.clone());
        let penalised = equations.penalised(self.alpha).ok_or_else(refuse)?;
        let mean = means(targets, &weights);
        let centred = Mat::from_fn(n, classes, |i, c| (targets[(i, c)] - mean[c]) * roots[i]);
        let solved = penalised.solve(&centred);
        let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        units.iter().enumerate().for_each(|(row, unit)| members.entry(*unit).or_default().push(row));
        let blocks: Vec<&Vec<usize>> = members.values().collect();
        let errors = blocks.par_iter().map(|rows| penalised.left_out(&solved, rows));
        let mut values = vec![0.0; n * classes];
        for (rows, errors) in blocks.iter().zip(errors.collect::<Vec<_>>()) {
            for (at, row) in rows.iter().enumerate() {
                for c in 0..classes {
                    values[row * classes + c] = (targets[(*row, c)] - errors[(at, c)] / roots[*row]) as f32;
                }
            }
        }
        Ok(values)
    }

    /// Returns the penalty that was chosen.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Returns the mean squared leave-one-out error of that penalty, over samples and classes.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Computes the decision values `[n, classes]`, about 1 for the true class and −1 for others.
    pub fn decide(&self, x: &FeatureMatrix) -> Vec<f32> {
        let classes = self.bias.len();
        let mut values = vec![0.0; x.values.len() / self.width * classes];
        values.par_chunks_exact_mut(classes).zip(x.values.par_chunks_exact(self.width)).for_each_init(
            || vec![0.0; classes],
            |products, (values, features)| self.decide_one(features, products, values),
        );
        values
    }

    /// Writes the decision values of one row of features; `products` has as much room.
    pub(crate) fn decide_one(&self, features: &[f32], products: &mut [f64], values: &mut [f32]) {
        double::dots(&self.weights, features, products);
        for ((value, product), bias) in values.iter_mut().zip(products).zip(&self.bias) {
            *value = (*product + f64::from(*bias)) as f32;
        }
    }

    /// Returns weights `[outputs, width]` and what is added to each output.
    pub(crate) fn numbers(&self) -> (&[f32], &[f32]) {
        (&self.weights, &self.bias)
    }

    pub(crate) fn classes(&self) -> usize {
        self.bias.len()
    }

    pub(crate) fn macs(&self) -> u64 {
        self.weights.len() as u64
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let classes = self.bias.len();
        vec![
            ("ridge.weight", vec![classes, self.width], self.weights.clone()),
            ("ridge.bias", vec![classes], self.bias.clone()),
            ("ridge.alpha", vec![1], vec![self.alpha as f32]),
            ("ridge.error", vec![1], vec![self.error as f32]),
        ]
    }

    /// Reads the tensors that [`Ridge::tensors`] gave, for features of `width`.
    pub(crate) fn read(width: usize, classes: usize, saved: &Saved) -> Result<Self> {
        Ok(Ridge {
            alpha: f64::from(saved.one("ridge.alpha")?),
            error: f64::from(saved.one("ridge.error")?),
            width,
            weights: saved.sized("ridge.weight", classes * width)?.to_vec(),
            bias: saved.sized("ridge.bias", classes)?.to_vec(),
        })
    }
}

/// Returns 1 for the class of each sample and −1 for the others, `[n, classes]`.
fn one_against_the_rest(y: &[u32], classes: usize) -> Mat<f64> {
    Mat::from_fn(y.len(), classes, |i, c| if y[i] as usize == c { 1.0 } else { -1.0 })
}

/// Returns values that lie row after row as a matrix `[n, outputs]`.
fn rows_of(values: &[f32], outputs: usize) -> Mat<f64> {
    Mat::from_fn(values.len() / outputs.max(1), outputs, |i, c| f64::from(values[i * outputs + c]))
}

/// Returns the weighted mean of each column.
fn means(targets: &Mat<f64>, weights: &[f64]) -> Vec<f64> {
    let whole: f64 = weights.iter().sum();
    let mean = |column: faer::ColRef<f64>| {
        column.iter().zip(weights).map(|(target, weight)| weight * target).sum::<f64>() / whole
    };
    targets.col_iter().map(mean).collect()
}

/// Returns the columns at mean 0 and deviation 1 `[n, width]`, and what was taken off and divided by. A constant column
/// stays zero; as scikit-learn, one that varies less than its own rounding is constant. Means and deviations are weighted, and
/// rows are multiplied by the roots of their weights.
fn standardised(x: &FeatureMatrix, weights: &[f64]) -> (Mat<f64>, Vec<f64>, Vec<f64>) {
    let (width, n, whole) = (x.width, weights.len(), weights.iter().sum::<f64>());
    let product = |(value, weight): (&f64, &f64)| weight * value;
    let mut rows = Mat::from_fn(n, width, |i, j| f64::from(x.values[i * width + j]));
    let (mut mean, mut sd) = (vec![0.0; width], vec![1.0; width]);
    for (j, (mean, sd)) in mean.iter_mut().zip(&mut sd).enumerate() {
        let column = rows.col_as_slice_mut(j);
        *mean = column.iter().zip(weights).map(product).sum::<f64>() / whole;
        column.iter_mut().for_each(|value| *value -= *mean);
        let squares = column.iter().zip(weights).map(|(value, weight)| weight * (value * value));
        let deviation = (squares.sum::<f64>() / whole).sqrt();
        if deviation > 10.0 * f64::EPSILON * mean.abs() && deviation > 0.0 {
            *sd = deviation;
            column.iter_mut().for_each(|value| *value /= deviation);
        }
        column.iter_mut().zip(weights).for_each(|(value, weight)| *value *= weight.sqrt());
    }
    (rows, mean, sd)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use faer::prelude::Solve;

    use super::*;

    /// Computes what a ridge on all other rows says of the rows `out`, features scaled as they are.
    fn fitted_without(rows: &Mat<f64>, targets: &Mat<f64>, alpha: f64, out: &[usize]) -> Mat<f64> {
        let kept: Vec<usize> = (0..rows.nrows()).filter(|row| !out.contains(row)).collect();
        let (n, width, outputs) = (kept.len(), rows.ncols(), targets.ncols());
        let mean: Vec<f64> =
            (0..width).map(|j| kept.iter().map(|i| rows[(*i, j)]).sum::<f64>() / n as f64).collect();
        let x = Mat::from_fn(n, width, |i, j| rows[(kept[i], j)] - mean[j]);
        let offset: Vec<f64> =
            (0..outputs).map(|c| kept.iter().map(|i| targets[(*i, c)]).sum::<f64>() / n as f64).collect();
        let centred = Mat::from_fn(n, outputs, |i, c| targets[(kept[i], c)] - offset[c]);
        let mut normal = x.transpose() * &x;
        (0..width).for_each(|j| normal[(j, j)] += alpha);
        let weights = normal.partial_piv_lu().solve(x.transpose() * centred);
        Mat::from_fn(out.len(), outputs, |i, c| {
            offset[c] + (0..width).map(|j| (rows[(out[i], j)] - mean[j]) * weights[(j, c)]).sum::<f64>()
        })
    }

    /// Compares values of samples that were left out by their unit with those of ridges that are fitted anew.
    fn are_those_without(own: &[f32], rows: &Mat<f64>, targets: &Mat<f64>, units: &[u32], tolerance: f64) {
        for unit in 0..=units[units.len() - 1] {
            let out: Vec<usize> = (0..units.len()).filter(|i| units[*i] == unit).collect();
            let wanted = fitted_without(rows, targets, 0.1, &out);
            for (at, row) in out.iter().enumerate() {
                for c in 0..targets.ncols() {
                    let (own, wanted) = (own[row * targets.ncols() + c], wanted[(at, c)]);
                    let off = (f64::from(own) - wanted).abs();
                    assert!(off < tolerance, "unit {unit}, output {c}: {own} and {wanted}");
                }
            }
        }
    }

    #[test]
    fn left_out_values_are_those_of_ridges_that_are_fitted_without_the_unit() {
        for width in [5, 40] {
            let (n, classes) = (24, 3);
            let values: Vec<f32> =
                (0..n * width).map(|i| (i as f32 * 1.7).sin() + (i % 7) as f32 * 0.2).collect();
            let x = FeatureMatrix::new(values, width);
            let y: Vec<u32> = (0..n as u32).map(|i| (i * i) % 7 % 3).collect();
            let forces: Vec<f32> =
                (0..2 * n).map(|i| 5.0 + (i as f32 * 0.9).cos() * (i % 5) as f32).collect();
            let ridge = Ridge::fit(&x, &y, classes, &[0.1]).unwrap();
            let of_values = Ridge::fit_values(&x, &forces, 2, &[0.1]).unwrap();
            let (rows, ..) = standardised(&x, &vec![1.0; n]);
            for units in [(0..n as u32).collect::<Vec<_>>(), (0..n as u32).map(|i| i / 5).collect()] {
                let left_out = ridge.left_out(&x, &y, &units).unwrap();
                are_those_without(&left_out, &rows, &one_against_the_rest(&y, classes), &units, 1e-5);
                let left_out = of_values.left_out_values(&x, &forces, &units).unwrap();
                are_those_without(&left_out, &rows, &rows_of(&forces, 2), &units, 1e-5);
            }
            assert!(ridge.left_out(&x, &y, &[0; 3]).is_err());
            assert!(of_values.left_out_values(&x, &forces, &[0; 3]).is_err());
        }
    }
}
