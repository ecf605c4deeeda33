//! k nearest neighbours.

use crate::{Error, Result, Saved, Series};
use rayon::prelude::*;

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
        let rows: Vec<Vec<f32>> = (0..x.len()).into_par_iter().map(|i| self.votes(x.sample(i))).collect();
        Ok(rows.concat())
    }

    fn votes(&self, sample: &[f32]) -> Vec<f32> {
        let far = |(i, own): (usize, &[f32])| {
            let square: f64 = own.iter().zip(sample).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            (square, i)
        };
        let mut order: Vec<(f64, usize)> = self.x.chunks_exact(sample.len()).enumerate().map(far).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut votes = vec![0.0; self.classes];
        let mut total = 0.0;
        for (rank, (_, i)) in order[..self.k].iter().enumerate() {
            // The nearest of equals wins: nearness counts less than any vote.
            let vote = if self.k > 1 { 1.0 + 0.25 * 0.5f32.powi(rank as i32) } else { 1.0 };
            votes[self.y[*i] as usize] += vote;
            total += vote;
        }
        votes.iter_mut().for_each(|vote| *vote /= total);
        votes
    }

    pub(crate) fn macs(&self) -> u64 {
        self.x.len() as u64
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let [channels, length] = self.shape;
        let y = self.y.iter().map(|&label| label as f32).collect();
        vec![("x", vec![self.y.len(), channels, length], self.x.clone()), ("y", vec![self.y.len()], y)]
    }

    /// What [`Nearest::tensors`] has written.
    pub(crate) fn read(k: usize, shape: [usize; 2], classes: usize, saved: &Saved) -> Result<Self> {
        let y: Vec<u32> = saved.get("y")?.iter().map(|&label| label as u32).collect();
        let x = saved.sized("x", y.len() * shape[0] * shape[1])?.to_vec();
        match y.iter().all(|&label| (label as usize) < classes) && !y.is_empty() {
            true => Ok(Nearest { k: k.clamp(1, y.len()), shape, classes, x, y }),
            false => Err(Error::Saved { tensor: "y".into(), reason: "does not fit the classes" }),
        }
    }
}
