//! Ridge regression on one-against-the-rest targets, its penalty chosen by leaving one out.
//!
//! # Reference
//! scikit-learn's `RidgeClassifierCV` (Rifkin & Lippert 2007): targets −1 and 1, columns scaled to unit
//! deviation and centred, all leave-one-out errors from one eigendecomposition of the Gram matrix. Here
//! the Gram matrix of samples is used whatever the number of features: baselines see thousands of samples
//! at most.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;
use taxel_kernels::double;

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
pub struct Features {
    pub(crate) values: Vec<f32>,
    pub(crate) width: usize,
}

impl Features {
    /// Rows of `width` features.
    pub fn new(values: Vec<f32>, width: usize) -> Self {
        Features { values, width }
    }

    /// The features, row after row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}

/// A linear classifier on features.
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
    pub fn fit(x: &Features, y: &[u32], classes: usize, alphas: &[f64]) -> Result<Self> {
        if alphas.is_empty() || alphas.iter().any(|alpha| !(*alpha > 0.0 && alpha.is_finite())) {
            return Err(Error::setting("alphas", format!("{alphas:?}"), "must be positive numbers"));
        }
        let (n, width) = (y.len(), x.width);
        let mut rows = DMatrix::from_row_iterator(n, width, x.values.iter().map(|&v| f64::from(v)));
        let (mut mean, mut sd) = (vec![0.0; width], vec![1.0; width]);
        for (j, mut column) in rows.column_iter_mut().enumerate() {
            mean[j] = column.mean();
            column.add_scalar_mut(-mean[j]);
            let deviation = (column.norm_squared() / n as f64).sqrt();
            // A constant column stays zero; as scikit-learn, smaller than its own rounding is constant.
            if deviation > 10.0 * f64::EPSILON * mean[j].abs() && deviation > 0.0 {
                sd[j] = deviation;
                column /= deviation;
            }
        }
        let mut targets = DMatrix::from_fn(n, classes, |i, c| if y[i] as usize == c { 1.0 } else { -1.0 });
        let offsets: Vec<f64> = targets.column_iter().map(|column| column.mean()).collect();
        for (mut column, offset) in targets.column_iter_mut().zip(&offsets) {
            column.add_scalar_mut(-offset);
        }
        // The intercept is a constant feature without penalty; its eigenvector is the constant one.
        let gram = &rows * rows.transpose() + DMatrix::from_element(n, n, 1.0);
        let SymmetricEigen { eigenvectors: q, eigenvalues } = gram.symmetric_eigen();
        let sums: DVector<f64> = q.row_sum().transpose().abs();
        let intercept = sums.imax();
        let projected = q.transpose() * &targets;
        let squares = q.component_mul(&q);
        let dual = |alpha: f64| {
            let mut inverse = eigenvalues.map(|value| 1.0 / (value.max(0.0) + alpha));
            inverse[intercept] = 0.0;
            let mut shrunk = projected.clone();
            shrunk.row_iter_mut().zip(inverse.iter()).for_each(|(mut row, w)| row *= *w);
            (&q * shrunk, &squares * inverse)
        };
        let mut best: Option<(f64, f64, DMatrix<f64>)> = None;
        for &alpha in alphas {
            let (dual, diagonal) = dual(alpha);
            let off = |column: nalgebra::DVectorView<f64>| column.component_div(&diagonal).norm_squared();
            let error: f64 = dual.column_iter().map(off).sum();
            if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                best = Some((error, alpha, dual));
            }
        }
        let Some((error, alpha, dual)) = best else {
            return Err(Error::setting("alphas", "none", "leave-one-out errors are not finite"));
        };
        let coefficients = rows.transpose() * dual;
        let (mut weights, mut bias) = (Vec::with_capacity(classes * width), vec![]);
        for (column, offset) in coefficients.column_iter().zip(offsets) {
            let unscaled: Vec<f64> = column.iter().zip(&sd).map(|(w, sd)| w / sd).collect();
            let shift: f64 = unscaled.iter().zip(&mean).map(|(w, mean)| w * mean).sum();
            bias.push((offset - shift) as f32);
            weights.extend(unscaled.iter().map(|w| *w as f32));
        }
        Ok(Ridge { alpha, error: error / (n * classes) as f64, width, weights, bias })
    }

    /// The penalty that was chosen.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Mean squared leave-one-out error of that penalty, over samples and classes.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Decision values `[n, classes]`, about 1 for the true class and −1 for others.
    pub fn decide(&self, x: &Features) -> Vec<f32> {
        let classes = self.bias.len();
        let mut values = vec![0.0; x.values.len() / self.width * classes];
        values.par_chunks_exact_mut(classes).zip(x.values.par_chunks_exact(self.width)).for_each_init(
            || vec![0.0; classes],
            |products, (values, features)| self.decide_one(features, products, values),
        );
        values
    }

    /// Decision values of one row of features; `products` has as much room.
    pub(crate) fn decide_one(&self, features: &[f32], products: &mut [f64], values: &mut [f32]) {
        double::dots(&self.weights, features, products);
        for ((value, product), bias) in values.iter_mut().zip(products).zip(&self.bias) {
            *value = (*product + f64::from(*bias)) as f32;
        }
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

    /// What [`Ridge::tensors`] has written, for features of `width`.
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
