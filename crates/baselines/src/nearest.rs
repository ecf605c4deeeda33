//! k nearest neighbours (Euclidean): votes for classes, the mean of values.

use rayon::prelude::*;
use taxel_kernels::double;

use crate::{Error, Result, Saved, Series};

/// The training part, and how many of its samples are near. Of equally far ones the first in the training part counts.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Neighbours {
    k: usize,
    shape: [usize; 2],
    x: Vec<f32>,
}

/// Recordings that are predicted together.
const TOGETHER: usize = 32;

/// The nearest neighbours so far, the nearest first: squared distance and number.
#[derive(Debug)]
pub(crate) struct Best(Vec<(f64, usize)>);

/// Memory for one recording after the other.
#[derive(Debug)]
pub(crate) struct NearestMemory {
    distances: Vec<f64>,
    best: Best,
}

impl Neighbours {
    pub(crate) fn new(train: &Series, k: usize) -> Result<Self> {
        if k == 0 {
            return Err(Error::setting("k", k, "must be at least 1"));
        }
        Ok(Neighbours { k: k.min(train.len()), shape: train.shape(), x: train.values.to_vec() })
    }

    /// Reads the training part `[n, channels, length]`.
    pub(crate) fn read(k: usize, shape: [usize; 2], n: usize, saved: &Saved) -> Result<Self> {
        let x = saved.sized("x", n * shape[0] * shape[1])?.to_vec();
        Ok(Neighbours { k: k.clamp(1, n.max(1)), shape, x })
    }

    pub(crate) fn shape(&self) -> [usize; 2] {
        self.shape
    }

    fn each(&self) -> usize {
        self.shape[0] * self.shape[1]
    }

    pub(crate) fn len(&self) -> usize {
        self.x.len() / self.each()
    }

    pub(crate) fn macs(&self) -> u64 {
        self.x.len() as u64
    }

    pub(crate) fn tensor(&self) -> (&'static str, Vec<usize>, Vec<f32>) {
        let [channels, length] = self.shape;
        ("x", vec![self.len(), channels, length], self.x.clone())
    }

    pub(crate) fn memory(&self) -> NearestMemory {
        NearestMemory { distances: vec![0.0; self.len()], best: self.best() }
    }

    fn best(&self) -> Best {
        Best(Vec::with_capacity(self.k + 1))
    }

    /// Computes `[n, width]`: what `say` makes of the nearest of each recording, as of [`Neighbours::nearest`].
    pub(crate) fn each_row(
        &self,
        x: &Series,
        width: usize,
        say: impl Fn(&[(f64, usize)], &mut [f32]) + Sync,
    ) -> Result<Vec<f32>> {
        x.expect(self.shape)?;
        let (n, each) = (self.len(), self.each());
        let mut rows = vec![0.0; x.len() * width];
        let parts = x.values.par_chunks(TOGETHER * each).zip(rows.par_chunks_mut(TOGETHER * width));
        parts.for_each(|(samples, rows)| {
            let mut distances = vec![0.0; samples.len() / each * n];
            double::squares(each, &self.x, samples, true, &mut distances);
            let mut best = self.best();
            for (distances, row) in distances.chunks_exact(n).zip(rows.chunks_exact_mut(width)) {
                say(self.nearest(distances, &mut best), row);
            }
        });
        Ok(rows)
    }

    /// Finds the nearest of one recording, as [`Neighbours::nearest`] does.
    pub(crate) fn of_one<'m>(
        &self,
        sample: &[f32],
        NearestMemory { distances, best }: &'m mut NearestMemory,
    ) -> &'m [(f64, usize)] {
        // Differences of floats, as they were before they were squared.
        double::squares(sample.len(), &self.x, sample, true, distances);
        self.nearest(distances, best)
    }

    /// Finds squared distance and number of the nearest, the nearest first.
    fn nearest<'b>(&self, distances: &[f64], Best(best): &'b mut Best) -> &'b [(f64, usize)] {
        best.clear();
        for (i, &square) in distances.iter().enumerate() {
            if best.len() == self.k && best.last().is_some_and(|(most, _)| square >= *most) {
                continue;
            }
            // Behind all that are as near: those come first in the training part.
            let place = best.partition_point(|(other, _)| *other <= square);
            best.insert(place, (square, i));
            best.truncate(self.k);
        }
        best
    }
}

impl NearestMemory {
    /// Checks whether it was made for so many training samples.
    pub(crate) fn fits(&self, n: usize) -> bool {
        self.distances.len() == n
    }
}

/// Votes of the nearest for their class. Of equally many votes the class whose nearest neighbour is nearest has most.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    neighbours: Neighbours,
    classes: usize,
    y: Vec<u32>,
}

impl Nearest {
    pub(crate) fn fit(train: &Series, y: &[u32], classes: usize, k: usize) -> Result<Self> {
        Ok(Nearest { neighbours: Neighbours::new(train, k)?, classes, y: y.to_vec() })
    }

    pub(crate) fn scores(&self, x: &Series) -> Result<Vec<f32>> {
        self.neighbours.each_row(x, self.classes, |nearest, votes| self.vote(nearest, votes))
    }

    /// Writes the votes of one recording, a share per class.
    pub(crate) fn predict_one(&self, sample: &[f32], memory: &mut NearestMemory, votes: &mut [f32]) {
        self.vote(self.neighbours.of_one(sample, memory), votes);
    }

    pub(crate) fn neighbours(&self) -> &Neighbours {
        &self.neighbours
    }

    pub(crate) fn classes(&self) -> usize {
        self.classes
    }

    fn vote(&self, nearest: &[(f64, usize)], votes: &mut [f32]) {
        let is_one = self.neighbours.k == 1;
        votes.fill(0.0);
        let mut total = 0.0;
        for (rank, (_, i)) in nearest.iter().enumerate() {
            // The nearest of equals wins: nearness counts less than any vote.
            let vote = if is_one { 1.0 } else { 1.0 + 0.25 * 0.5f32.powi(rank as i32) };
            votes[self.y[*i] as usize] += vote;
            total += vote;
        }
        votes.iter_mut().for_each(|vote| *vote /= total);
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let y = self.y.iter().map(|&label| label as f32).collect();
        vec![self.neighbours.tensor(), ("y", vec![self.y.len()], y)]
    }

    /// Reads the tensors that [`Nearest::tensors`] gave.
    pub(crate) fn read(k: usize, shape: [usize; 2], classes: usize, saved: &Saved) -> Result<Self> {
        let y: Vec<u32> = saved.get("y")?.iter().map(|&label| label as u32).collect();
        let neighbours = Neighbours::read(k, shape, y.len(), saved)?;
        if y.iter().all(|&label| (label as usize) < classes) && !y.is_empty() {
            Ok(Nearest { neighbours, classes, y })
        } else {
            Err(Error::Saved { tensor: "y".into(), reason: "does not fit the classes" })
        }
    }
}

/// The mean target of the nearest, each counting alike (scikit-learn's `KNeighborsRegressor` with uniform weights).
#[derive(Debug, Clone, PartialEq)]
pub struct NearestValues {
    neighbours: Neighbours,
    outputs: usize,
    /// `[n, outputs]`.
    y: Vec<f32>,
}

impl NearestValues {
    pub(crate) fn fit(train: &Series, values: &[f32], outputs: usize, k: usize) -> Result<Self> {
        Ok(NearestValues { neighbours: Neighbours::new(train, k)?, outputs, y: values.to_vec() })
    }

    pub(crate) fn predict(&self, x: &Series) -> Result<Vec<f32>> {
        self.neighbours.each_row(x, self.outputs, |nearest, values| self.mean(nearest, values))
    }

    /// Writes the values of one recording, one per output.
    pub(crate) fn predict_one(&self, sample: &[f32], memory: &mut NearestMemory, values: &mut [f32]) {
        self.mean(self.neighbours.of_one(sample, memory), values);
    }

    pub(crate) fn neighbours(&self) -> &Neighbours {
        &self.neighbours
    }

    pub(crate) fn outputs(&self) -> usize {
        self.outputs
    }

    fn mean(&self, nearest: &[(f64, usize)], values: &mut [f32]) {
        for (output, value) in values.iter_mut().enumerate() {
            let targets = nearest.iter().map(|(_, i)| f64::from(self.y[i * self.outputs + output]));
            *value = (targets.sum::<f64>() / nearest.len() as f64) as f32;
        }
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        vec![self.neighbours.tensor(), ("y", vec![self.neighbours.len(), self.outputs], self.y.clone())]
    }

    /// Reads the tensors that [`NearestValues::tensors`] gave.
    pub(crate) fn read(k: usize, shape: [usize; 2], outputs: usize, saved: &Saved) -> Result<Self> {
        let y = saved.finite_rows("y", outputs)?.to_vec();
        let neighbours = Neighbours::read(k, shape, y.len() / outputs.max(1), saved)?;
        if y.is_empty() {
            return Err(Error::Saved { tensor: "y".into(), reason: "is empty" });
        }
        Ok(NearestValues { neighbours, outputs, y })
    }
}
