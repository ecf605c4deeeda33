//! k nearest neighbours.

use rayon::prelude::*;
use taxel_kernels::double;

use crate::{Error, Result, Saved, Series};

/// The training part and how many neighbours vote. Of equally far neighbours the first in the training
/// part counts, of equally many votes the class whose nearest neighbour is nearest.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    k: usize,
    shape: [usize; 2],
    classes: usize,
    x: Vec<f32>,
    y: Vec<u32>,
}

/// Recordings that are predicted together.
const TOGETHER: usize = 32;

/// The nearest neighbours so far, the nearest first: squared distance and number.
#[derive(Debug)]
pub(crate) struct Best(Vec<(f64, usize)>);

impl Nearest {
    pub(crate) fn fit(train: &Series, y: &[u32], classes: usize, k: usize) -> Result<Self> {
        if k == 0 {
            return Err(Error::setting("k", k, "must be at least 1"));
        }
        let k = k.min(train.len());
        Ok(Nearest { k, shape: train.shape(), classes, x: train.values.to_vec(), y: y.to_vec() })
    }

    pub(crate) fn scores(&self, x: &Series) -> Result<Vec<f32>> {
        x.expect(self.shape)?;
        let each = self.shape[0] * self.shape[1];
        let mut votes = vec![0.0; x.len() * self.classes];
        let parts = x.values.par_chunks(TOGETHER * each).zip(votes.par_chunks_mut(TOGETHER * self.classes));
        parts.for_each(|(samples, votes)| self.votes(samples, each, votes));
        Ok(votes)
    }

    pub(crate) fn shape(&self) -> [usize; 2] {
        self.shape
    }

    pub(crate) fn classes(&self) -> usize {
        self.classes
    }

    /// Writes the votes of one recording, a share per class. `distances` has room for one per training sample.
    pub(crate) fn predict_one(
        &self,
        sample: &[f32],
        distances: &mut [f64],
        best: &mut Best,
        votes: &mut [f32],
    ) {
        // Differences of floats, as they were before they were squared.
        double::squares(sample.len(), &self.x, sample, true, distances);
        self.vote(distances, best, votes);
    }

    /// Does [`Nearest::predict_one`] for neighbouring recordings.
    fn votes(&self, samples: &[f32], each: usize, votes: &mut [f32]) {
        let n = self.y.len();
        let mut distances = vec![0.0; samples.len() / each * n];
        double::squares(each, &self.x, samples, true, &mut distances);
        let mut best = self.best();
        for (distances, votes) in distances.chunks_exact(n).zip(votes.chunks_exact_mut(self.classes)) {
            self.vote(distances, &mut best, votes);
        }
    }

    /// Makes room for the nearest.
    pub(crate) fn best(&self) -> Best {
        Best(Vec::with_capacity(self.k + 1))
    }

    pub(crate) fn len(&self) -> usize {
        self.y.len()
    }

    fn vote(&self, distances: &[f64], Best(best): &mut Best, votes: &mut [f32]) {
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
        votes.fill(0.0);
        let mut total = 0.0;
        for (rank, (_, i)) in best.iter().enumerate() {
            // The nearest of equals wins: nearness counts less than any vote.
            let vote = if self.k > 1 { 1.0 + 0.25 * 0.5f32.powi(rank as i32) } else { 1.0 };
            votes[self.y[*i] as usize] += vote;
            total += vote;
        }
        votes.iter_mut().for_each(|vote| *vote /= total);
    }

    pub(crate) fn macs(&self) -> u64 {
        self.x.len() as u64
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let [channels, length] = self.shape;
        let y = self.y.iter().map(|&label| label as f32).collect();
        vec![("x", vec![self.y.len(), channels, length], self.x.clone()), ("y", vec![self.y.len()], y)]
    }

    /// Reads the tensors that [`Nearest::tensors`] gave.
    pub(crate) fn read(k: usize, shape: [usize; 2], classes: usize, saved: &Saved) -> Result<Self> {
        let y: Vec<u32> = saved.get("y")?.iter().map(|&label| label as u32).collect();
        let x = saved.sized("x", y.len() * shape[0] * shape[1])?.to_vec();
        if y.iter().all(|&label| (label as usize) < classes) && !y.is_empty() {
            Ok(Nearest { k: k.clamp(1, y.len()), shape, classes, x, y })
        } else {
            Err(Error::Saved { tensor: "y".into(), reason: "does not fit the classes" })
        }
    }
}
