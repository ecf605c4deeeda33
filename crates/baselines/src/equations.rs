//! The penalised equations of a ridge, over its samples or over its features, whichever are fewer.

use faer::linalg::matmul::{matmul, triangular};
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::prelude::Solve;
use faer::{Accum, ColRef, Mat, MatRef, Par, Side};

/// Standardised features and their products.
///
/// Of n samples X `[n, width]` the leave-one-out errors need M = α (X Xᵀ + α)⁻¹. With as few samples as features M comes from
/// that matrix; else from the smaller one of features, as M = 1 − X (Xᵀ X + α)⁻¹ Xᵀ. A constant feature without penalty, the
/// intercept, takes 1/n off every value of M. With weights w rows are multiplied by r = √w, and it takes rᵢ rⱼ / Σw off Mᵢⱼ.
pub(crate) struct Equations {
    /// `[n, width]`, each column with mean 0.
    rows: Mat<f64>,
    /// Products of all pairs of samples, and of their roots for the intercept, `[n, n]`; or of features, `[width, width]`. The
    /// lower half.
    products: Mat<f64>,
    /// Roots of the weights of the samples.
    roots: Vec<f64>,
    is_of_samples: bool,
}

/// The equations with one penalty.
pub(crate) struct Penalised<'a> {
    rows: &'a Mat<f64>,
    roots: &'a [f64],
    /// Sum of the weights.
    whole: f64,
    alpha: f64,
    /// The inverse of the Cholesky factor.
    inverse: Mat<f64>,
    /// Its product with the features, `[width, n]`; none where the equations are of samples.
    of_features: Option<Mat<f64>>,
}

/// The regression of targets on all samples.
pub(crate) struct Solved {
    /// M times the targets, `[n, outputs]`; of samples without the factor α.
    left: Mat<f64>,
    /// The weights of the samples `[n, outputs]`, or of the features `[width, outputs]`.
    solution: Mat<f64>,
}

impl Equations {
    /// Makes the equations of standardised features `[n, width]`, whose rows are multiplied by the `roots` of their weights.
    pub fn new(rows: Mat<f64>, roots: Vec<f64>) -> Self {
        let is_of_samples = rows.nrows() <= rows.ncols();
        let mut products = if is_of_samples {
            Mat::from_fn(rows.nrows(), rows.nrows(), |i, j| roots[i] * roots[j])
        } else {
            Mat::zeros(rows.ncols(), rows.ncols())
        };
        let (whole, lower) =
            (triangular::BlockStructure::Rectangular, triangular::BlockStructure::TriangularLower);
        let (left, right) =
            if is_of_samples { (rows.as_ref(), rows.transpose()) } else { (rows.transpose(), rows.as_ref()) };
        triangular::matmul(&mut products, lower, Accum::Add, left, whole, right, whole, 1.0, Par::Seq);
        Equations { rows, products, roots, is_of_samples }
    }

    /// Adds a penalty. None if the products with it are not positive definite.
    pub fn penalised(&self, alpha: f64) -> Option<Penalised<'_>> {
        let mut penalised = self.products.clone();
        (0..penalised.nrows()).for_each(|i| penalised[(i, i)] += alpha);
        let factor = Llt::new(penalised.as_ref(), Side::Lower).ok()?;
        let mut inverse = penalised;
        inverse.fill(0.0);
        invert_lower_triangular(inverse.as_mut(), factor.L(), Par::Seq);
        drop(factor);
        let of_features = (!self.is_of_samples).then(|| product(inverse.as_ref(), self.rows.transpose()));
        let whole = self.roots.iter().map(|root| root * root).sum();
        Some(Penalised { rows: &self.rows, roots: &self.roots, whole, alpha, inverse, of_features })
    }
}

impl Penalised<'_> {
    /// Solves for targets `[n, outputs]` of mean 0.
    pub fn solve(&self, targets: &Mat<f64>) -> Solved {
        let half = self.half();
        let inner = product(half.as_ref(), targets.as_ref());
        let smooth = product(half.transpose(), inner.as_ref());
        match &self.of_features {
            None => Solved { left: smooth.clone(), solution: smooth },
            Some(_) => {
                let solution = product(self.inverse.transpose(), inner.as_ref());
                Solved { left: targets - smooth, solution }
            }
        }
    }

    /// Returns the squared errors of each sample by the regression on all others, summed.
    ///
    /// The error of sample i is (M targets)ᵢ / Mᵢᵢ.
    pub fn leave_one_out(&self, solved: &Solved) -> f64 {
        let squares = self.half().col_iter().map(|column| column.squared_norm_l2());
        let pivots: Vec<f64> = squares.enumerate().map(|(i, square)| self.pivot(square, i, i)).collect();
        let of_output = |column: ColRef<f64>| {
            column.iter().zip(&pivots).map(|(value, pivot)| (value / pivot).powi(2)).sum::<f64>()
        };
        solved.left.col_iter().map(of_output).sum()
    }

    /// Returns the errors `[rows, outputs]` of samples that are left out together: the inverse of their block of M times their
    /// block of M times the targets.
    pub fn left_out(&self, solved: &Solved, rows: &[usize]) -> Mat<f64> {
        let half = self.half();
        let columns = Mat::from_fn(half.nrows(), rows.len(), |i, j| half[(i, rows[j])]);
        let products = product(columns.transpose(), columns.as_ref());
        let block =
            Mat::from_fn(rows.len(), rows.len(), |i, j| self.pivot(products[(i, j)], rows[i], rows[j]));
        let left = Mat::from_fn(rows.len(), solved.left.ncols(), |i, c| solved.left[(rows[i], c)]);
        block.partial_piv_lu().solve(left)
    }

    /// Returns the weights of the features, `[width, outputs]`.
    pub fn weights(&self, solved: Solved) -> Mat<f64> {
        match self.of_features {
            None => product(self.rows.transpose(), solved.solution.as_ref()),
            Some(_) => solved.solution,
        }
    }

    /// Returns the matrix whose products of columns are M but for the intercept: of samples M/α, of features 1 − M.
    fn half(&self) -> &Mat<f64> {
        self.of_features.as_ref().unwrap_or(&self.inverse)
    }

    /// Returns a value of M, of samples M/α, from the product of the columns `i` and `j` of [`Penalised::half`].
    fn pivot(&self, product: f64, i: usize, j: usize) -> f64 {
        let intercept = self.roots[i] * self.roots[j];
        match self.of_features {
            None => product - intercept / (self.whole * (self.whole + self.alpha)),
            Some(_) => f64::from(u8::from(i == j)) - product - intercept / self.whole,
        }
    }
}

/// Multiplies on one thread, since penalties are tried side by side.
fn product(left: MatRef<'_, f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    let mut result = Mat::zeros(left.nrows(), right.ncols());
    matmul(&mut result, Accum::Replace, left, right, 1.0, Par::Seq);
    result
}
