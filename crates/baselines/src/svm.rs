//! Support vector machines, one against one.
//!
//! # Reference
//! LIBSVM's C-SVC, which scikit-learn's `SVC` wraps: sequential minimal optimisation with working sets of
//! second order (Fan, Chen & Lin, JMLR 2005), one machine per pair of classes, the classes' votes with the
//! machines' confidences between equals (`break_ties=True`). `SvmKernel::Rbf` has width `gamma="scale"`.
//!
//! # Departures
//! The whole kernel matrix of a training part is held, nothing is shrunk; training stops at a violation of
//! 1e-4, not 1e-3.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use taxel_kernels::double;

use crate::{Error, Result, Saved, Series};

/// How alike two recordings are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SvmKernel {
    /// a · b.
    Linear,
    /// exp(−γ |a − b|²), γ = 1 / (features × variance of all training values).
    Rbf,
}

/// The most training samples: their kernel matrix is held in memory.
pub(crate) const MOST: usize = 8000;
/// Violation of the optimality conditions at which training stops.
const TOLERANCE: f64 = 1e-4;
/// Recordings that are decided together.
const TOGETHER: usize = 32;
/// Steps after which the solution is taken as it is.
const STEPS: usize = 2_000_000;

/// Support vectors and one row of coefficients per pair of classes.
#[derive(Debug, Clone, PartialEq)]
pub struct Svm {
    kernel: SvmKernel,
    gamma: f64,
    shape: [usize; 2],
    classes: usize,
    /// `[vectors, features]`.
    vectors: Vec<f32>,
    /// Pairs of classes, the first one positive.
    pairs: Vec<(usize, usize)>,
    /// Per pair its vectors and their coefficients.
    coefficients: Vec<Vec<(usize, f32)>>,
    /// Per pair.
    bias: Vec<f32>,
    /// Of a linear kernel the sum of each pair's vectors times their coefficients, `[pairs, features]`: the products
    /// with those are sums of the products with these. Empty where there are fewer vectors than pairs.
    planes: Vec<f64>,
}

/// Memory for one decision after the other.
#[derive(Debug, Default)]
pub(crate) struct SvmMemory {
    alike: Vec<f64>,
    decisions: Vec<f32>,
    confidence: Vec<f32>,
}

impl Svm {
    pub(crate) fn fit(train: &Series, y: &[u32], classes: usize, kernel: SvmKernel, c: f64) -> Result<Self> {
        if !(c > 0.0 && c.is_finite()) {
            return Err(Error::setting("c", c, "must be positive and finite"));
        }
        let n = train.len();
        if n > MOST {
            return Err(Error::setting("samples", n, "are too many for the kernel matrix; at most 8000"));
        }
        let features = train.sample(0).len();
        // As it is saved.
        let gamma = f64::from((1.0 / (features as f64 * variance(train.values)).max(1e-30)) as f32);
        let gram: Vec<Vec<f64>> = (0..n)
            .into_par_iter()
            .map(|i| (0..n).map(|j| similar(kernel, gamma, train.sample(i), train.sample(j))).collect())
            .collect();
        let of = |class: usize| (0..n).filter(move |&i| y[i] as usize == class);
        let pairs: Vec<(usize, usize)> = (0..classes)
            .flat_map(|a| (a + 1..classes).map(move |b| (a, b)))
            .filter(|&(a, b)| of(a).next().is_some() && of(b).next().is_some())
            .collect();
        let solved: Vec<(Vec<(usize, f64)>, f64)> = pairs
            .par_iter()
            .map(|&(a, b)| {
                let rows: Vec<usize> = of(a).chain(of(b)).collect();
                let signs: Vec<f64> =
                    rows.iter().map(|&i| if y[i] as usize == a { 1.0 } else { -1.0 }).collect();
                let (alpha, bias) = solve(&gram, &rows, &signs, c);
                let coefficients = rows.iter().zip(alpha).zip(signs).filter(|((_, alpha), _)| *alpha > 0.0);
                (coefficients.map(|((&i, alpha), sign)| (i, alpha * sign)).collect(), bias)
            })
            .collect();
        let mut place = vec![usize::MAX; n];
        let mut vectors = vec![];
        let mut coefficients = vec![];
        for (support, _) in &solved {
            let mut row = vec![];
            for &(i, coefficient) in support {
                if place[i] == usize::MAX {
                    place[i] = vectors.len() / features;
                    vectors.extend_from_slice(train.sample(i));
                }
                row.push((place[i], coefficient as f32));
            }
            // As a saved machine is read.
            row.sort_by_key(|&(vector, _)| vector);
            coefficients.push(row);
        }
        let bias = solved.iter().map(|(_, bias)| *bias as f32).collect();
        let planes = vec![];
        let shape = train.shape();
        Ok(Svm { kernel, gamma, shape, classes, vectors, pairs, coefficients, bias, planes }.planed())
    }

    fn planed(mut self) -> Self {
        let features = self.features();
        if self.kernel != SvmKernel::Linear || self.pairs.len() >= self.vectors.len() / features {
            return self;
        }
        self.planes = vec![0.0; self.pairs.len() * features];
        for (plane, coefficients) in self.planes.chunks_exact_mut(features).zip(&self.coefficients) {
            for &(vector, coefficient) in coefficients {
                let vector = &self.vectors[vector * features..][..features];
                let terms = plane.iter_mut().zip(vector);
                terms.for_each(|(sum, v)| *sum += f64::from(coefficient) * f64::from(*v));
            }
        }
        self
    }

    /// Computes the decision values `[n, pairs]` of the pairs (0, 1), (0, 2), … of classes: above 0 for the first.
    ///
    /// # Errors
    /// Series of another shape than those it was fitted to.
    pub fn decide(&self, x: &Series) -> Result<Vec<f32>> {
        x.expect(self.shape)?;
        let mut values = vec![0.0; x.len() * self.pairs.len()];
        let parts = x.values.par_chunks(TOGETHER * self.features());
        let decided = values.par_chunks_mut((TOGETHER * self.pairs.len()).max(1));
        parts
            .zip(decided)
            .for_each_init(SvmMemory::default, |work, (x, values)| self.decide_some(x, work, values));
        Ok(values)
    }

    /// Writes the decision values of neighbouring recordings.
    fn decide_some(&self, x: &[f32], SvmMemory { alike, .. }: &mut SvmMemory, values: &mut [f32]) {
        let (features, vectors) = (self.features(), self.vectors.len() / self.features());
        let n = x.len() / features;
        let width = if self.planes.is_empty() { vectors } else { self.pairs.len() };
        alike.resize(n * width, 0.0);
        match self.kernel {
            SvmKernel::Rbf => {
                double::squares(features, &self.vectors, x, false, alike);
                alike.iter_mut().for_each(|square| *square = (-self.gamma * *square).exp());
            }
            SvmKernel::Linear => {
                for (x, alike) in x.chunks_exact(features).zip(alike.chunks_exact_mut(width.max(1))) {
                    if self.planes.is_empty() {
                        double::dots(&self.vectors, x, alike)
                    } else {
                        double::wide_dots(&self.planes, x, alike)
                    }
                }
            }
        }
        let rows = values.chunks_exact_mut(self.pairs.len().max(1)).zip(alike.chunks_exact(width.max(1)));
        for (values, alike) in rows {
            for (pair, value) in values.iter_mut().enumerate() {
                let machine = || self.coefficients[pair].iter().map(|&(v, c)| f64::from(c) * alike[v]).sum();
                let sum: f64 = if self.planes.is_empty() { machine() } else { alike[pair] };
                *value = (sum + f64::from(self.bias[pair])) as f32;
            }
        }
    }

    /// Computes the votes of the machines plus, between −1/3 and 1/3, their confidence.
    ///
    /// # Errors
    /// As [`Svm::decide`].
    pub fn votes(&self, x: &Series) -> Result<Vec<f32>> {
        let decisions = self.decide(x)?;
        let mut votes = vec![0.0; x.len() * self.classes];
        let mut confidence = vec![0.0; self.classes];
        for (i, votes) in votes.chunks_exact_mut(self.classes).enumerate() {
            let row = &decisions[i * self.pairs.len()..(i + 1) * self.pairs.len()];
            self.vote(row, &mut confidence, votes);
        }
        Ok(votes)
    }

    fn vote(&self, decisions: &[f32], confidence: &mut [f32], votes: &mut [f32]) {
        votes.fill(0.0);
        confidence.fill(0.0);
        for (&(a, b), &value) in self.pairs.iter().zip(decisions) {
            votes[if value >= 0.0 { a } else { b }] += 1.0;
            confidence[a] += value;
            confidence[b] -= value;
        }
        votes.iter_mut().zip(confidence).for_each(|(vote, c)| *vote += *c / (3.0 * (c.abs() + 1.0)));
    }

    /// Writes [`Svm::votes`] of one recording.
    pub(crate) fn predict_one(&self, sample: &[f32], work: &mut SvmMemory, votes: &mut [f32]) {
        let mut decisions = std::mem::take(&mut work.decisions);
        decisions.resize(self.pairs.len(), 0.0);
        self.decide_some(sample, work, &mut decisions);
        work.confidence.resize(self.classes, 0.0);
        self.vote(&decisions, &mut work.confidence, votes);
        work.decisions = decisions;
    }

    fn features(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    pub(crate) fn shape(&self) -> [usize; 2] {
        self.shape
    }

    pub(crate) fn classes(&self) -> usize {
        self.classes
    }

    pub(crate) fn macs(&self) -> u64 {
        self.vectors.len() as u64 + self.coefficients.iter().map(|pair| pair.len() as u64).sum::<u64>()
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let count = self.vectors.len() / self.features();
        let mut dual = vec![0.0; self.pairs.len() * count];
        for (pair, coefficients) in self.coefficients.iter().enumerate() {
            coefficients.iter().for_each(|&(vector, coefficient)| dual[pair * count + vector] = coefficient);
        }
        vec![
            ("svm.vectors", vec![count, self.shape[0], self.shape[1]], self.vectors.clone()),
            ("svm.dual", vec![self.pairs.len(), count], dual),
            ("svm.bias", vec![self.pairs.len()], self.bias.clone()),
            ("svm.gamma", vec![1], vec![self.gamma as f32]),
            (
                "svm.pairs",
                vec![self.pairs.len(), 2],
                self.pairs.iter().flat_map(|&(a, b)| [a as f32, b as f32]).collect(),
            ),
        ]
    }

    /// Reads the tensors that [`Svm::tensors`] gave.
    pub(crate) fn read(kernel: SvmKernel, shape: [usize; 2], classes: usize, saved: &Saved) -> Result<Self> {
        let features = shape[0] * shape[1];
        let (bias, gamma) = (saved.get("svm.bias")?.to_vec(), saved.one("svm.gamma")?);
        let vectors = saved.rows("svm.vectors", features)?;
        let pairs: Vec<(usize, usize)> =
            saved.rows("svm.pairs", 2)?.chunks_exact(2).map(|p| (p[0] as usize, p[1] as usize)).collect();
        let count = vectors.len() / features;
        let dual = saved.sized("svm.dual", pairs.len() * count)?;
        if bias.len() != pairs.len() || pairs.iter().any(|&(a, b)| a >= classes || b >= classes) {
            return Err(Error::Saved { tensor: "svm.pairs".into(), reason: "does not fit the classes" });
        }
        let of_pair = |pair: usize| {
            let row = dual[pair * count..(pair + 1) * count].iter().copied().enumerate();
            row.filter(|(_, coefficient)| *coefficient != 0.0).collect()
        };
        let coefficients = (0..pairs.len()).map(of_pair).collect();
        let (vectors, gamma, planes) = (vectors.to_vec(), f64::from(gamma), vec![]);
        Ok(Svm { kernel, gamma, shape, classes, vectors, pairs, coefficients, bias, planes }.planed())
    }
}

fn variance(values: &[f32]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
    values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n
}

fn similar(kernel: SvmKernel, gamma: f64, a: &[f32], b: &[f32]) -> f64 {
    let pairs = a.iter().zip(b);
    match kernel {
        SvmKernel::Linear => pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum(),
        SvmKernel::Rbf => {
            let square: f64 = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
            (-gamma * square).exp()
        }
    }
}

/// Minimises ½ αᵀQα − Σα with 0 ≤ α ≤ c and Σ sign·α = 0, Q = sign·sign·kernel. Returns α and the bias.
fn solve(gram: &[Vec<f64>], rows: &[usize], signs: &[f64], c: f64) -> (Vec<f64>, f64) {
    let n = rows.len();
    let kernel = |i: usize, j: usize| gram[rows[i]][rows[j]];
    let (mut alpha, mut gradient) = (vec![0.0; n], vec![-1.0; n]);
    // Whether α of i may still grow in the direction of its sign, or against it.
    let up = |alpha: &[f64], i: usize| if signs[i] > 0.0 { alpha[i] < c } else { alpha[i] > 0.0 };
    let down = |alpha: &[f64], i: usize| if signs[i] > 0.0 { alpha[i] > 0.0 } else { alpha[i] < c };
    for _ in 0..STEPS {
        let mut i = None;
        let mut most = f64::NEG_INFINITY;
        for t in (0..n).filter(|&t| up(&alpha, t)) {
            let value = -signs[t] * gradient[t];
            if value >= most {
                (i, most) = (Some(t), value);
            }
        }
        let Some(i) = i else { break };
        let (mut j, mut least, mut best) = (None, f64::INFINITY, f64::INFINITY);
        for t in (0..n).filter(|&t| down(&alpha, t)) {
            let value = -signs[t] * gradient[t];
            least = least.min(value);
            let gap = most - value;
            if gap > 0.0 {
                let curve = (kernel(i, i) + kernel(t, t) - 2.0 * kernel(i, t)).max(1e-12);
                let gain = -gap * gap / curve;
                if gain <= best {
                    (j, best) = (Some(t), gain);
                }
            }
        }
        let Some(j) = j.filter(|_| most - least >= TOLERANCE) else { break };
        let curve = (kernel(i, i) + kernel(j, j) - 2.0 * kernel(i, j)).max(1e-12);
        // Along sign·α both move by the same step, as far as the box allows.
        let room_up = if signs[i] > 0.0 { c - alpha[i] } else { alpha[i] };
        let room_down = if signs[j] > 0.0 { alpha[j] } else { c - alpha[j] };
        let wanted = (signs[j] * gradient[j] - signs[i] * gradient[i]) / curve;
        let step = wanted.min(room_up).min(room_down);
        // A bound is met exactly, or its sample would be chosen again and again.
        let bound = |value: f64| {
            if value < 1e-12 * c {
                0.0
            } else if value > c * (1.0 - 1e-12) {
                c
            } else {
                value
            }
        };
        alpha[i] = bound(alpha[i] + signs[i] * step);
        alpha[j] = bound(alpha[j] - signs[j] * step);
        for t in 0..n {
            gradient[t] += signs[t] * step * (kernel(t, i) - kernel(t, j));
        }
    }
    // The mean over free vectors, or the middle of what the others leave open.
    let (mut sum, mut free) = (0.0, 0usize);
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for t in 0..n {
        let value = -signs[t] * gradient[t];
        match (up(&alpha, t), down(&alpha, t)) {
            (true, true) => (sum, free) = (sum + value, free + 1),
            (true, false) => low = low.max(value),
            (false, true) => high = high.min(value),
            (false, false) => {}
        }
    }
    let bias = if free > 0 { sum / free as f64 } else { (low + high) / 2.0 };
    (alpha, bias)
}
