//! Extremely randomised trees for values and classes, on features of a series.
//!
//! # Reference
//! Geurts, Ernst & Wehenkel, Machine Learning 2006; scikit-learn's `ExtraTreesRegressor`: every tree sees all samples; a
//! node draws one threshold for each feature, uniform between its least and its greatest value, and takes the one that
//! leaves the least squared error; the prediction is the mean of the trees.
//!
//! # Departures
//! Several outputs are brought to unit variance before their errors are added, so that units do not decide the splits.
//! Splits that are equally good go by a turn of the features' order instead of a permutation. Thresholds are floats of 32
//! bits, as the features are. Classes are learned as their shares, so a node takes the split of the least Gini impurity; of
//! more than two, rare classes count more.
//!
//! # Why not a crate
//! smartcore's trees have one output, and what is fitted is private: it leaves only by serde, and one prediction takes a
//! matrix and allocates.

use rayon::prelude::*;

use crate::grow::{Ground, LEAF, Node};
use crate::summary::{each_recording, summary, summary_width};
use crate::{Error, Result, Saved, Series};

/// The most samples: a tree has fewer than twice as many nodes, and their numbers are stored as floats.
const MOST: usize = 1 << 23;

/// Extremely randomised trees (Geurts, Ernst & Wehenkel 2006) on features of series: per channel the last step, its
/// differences to 1, 2, 4, 8, 16 and 32 steps before, mean, SD, minimum and maximum over time; of a single step that alone.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraTrees {
    shape: [usize; 2],
    outputs: usize,
    /// The first node of each tree.
    roots: Vec<usize>,
    /// Nodes of all trees; nodes and leaves are numbered through.
    nodes: Vec<Node>,
    /// `[leaves, outputs]`.
    values: Vec<f32>,
}

/// Features of one recording, and sums over the trees.
#[derive(Debug)]
pub(crate) struct TreesMemory(Vec<f32>, Vec<f64>);

impl ExtraTrees {
    /// Fits so many `trees`, with leaves of `min_samples_leaf` samples at least, to values `[n, outputs]`, row-major and finite.
    /// Each tree draws from its own generator, so that threads change nothing.
    ///
    /// # Errors
    /// No trees, leaves without samples, or more nodes than can be numbered: more than 2²³ samples, or 2³¹ samples times trees.
    pub(crate) fn fit(
        train: &Series,
        values: &[f32],
        outputs: usize,
        [trees, min_samples_leaf]: [usize; 2],
        (seed, purpose): (u64, &str),
    ) -> Result<Self> {
        for (name, value) in [("trees", trees), ("min_samples_leaf", min_samples_leaf)] {
            if value == 0 {
                return Err(Error::setting(name, value, "must be at least 1"));
            }
        }
        if train.len() > MOST || trees.saturating_mul(2 * train.len()) > u32::MAX as usize {
            return Err(Error::setting("trees", trees, "have too many nodes on so many samples"));
        }
        let [channels, length] = train.shape();
        let width = summary_width([channels, length]);
        let features = each_recording(train, width, || (), |(), x, row| summary(x, length, row));
        let (targets, scales) = standardised(values, outputs);
        let features = features.values();
        let ground = Ground { features, width, targets: &targets, outputs, min_samples_leaf };
        let rng = |tree| taxel_base::seed::rng(seed, &format!("extra-trees/{purpose}/{tree}"));
        let grown: Vec<_> = (0..trees).into_par_iter().map(|tree| ground.grow(rng(tree))).collect();
        let (mut roots, mut nodes, mut values) = (vec![], vec![], vec![]);
        for tree in grown {
            let (root, leaf) = (nodes.len(), values.len() / outputs);
            roots.push(root);
            nodes.extend(tree.nodes.iter().map(|node| {
                let before = if node.feature == LEAF { leaf } else { root };
                Node { next: node.next + before as u32, ..*node }
            }));
            let unscaled = tree.values.iter().zip(scales.iter().cycle());
            values.extend(unscaled.map(|(value, (mean, sd))| (mean + value * sd) as f32));
        }
        Ok(ExtraTrees { shape: train.shape(), outputs, roots, nodes, values })
    }

    /// Fits trees to classes `y`, each below `classes`: the values of a leaf are the shares of the classes in it.
    ///
    /// # Errors
    /// As [`ExtraTrees::fit`].
    pub(crate) fn fit_classes(
        train: &Series,
        y: &[u32],
        classes: usize,
        sizes: [usize; 2],
        key: (u64, &str),
    ) -> Result<Self> {
        let is_of = |label: &u32| {
            let label = *label as usize;
            (0..classes).map(move |class| f32::from(u8::from(class == label)))
        };
        let shares: Vec<f32> = y.iter().flat_map(is_of).collect();
        let mut trees = Self::fit(train, &shares, classes, sizes, key)?;
        // Scaled back, a share of 0 may lie below it.
        trees.values.iter_mut().for_each(|share| *share = share.clamp(0.0, 1.0));
        Ok(trees)
    }

    pub(crate) fn shape(&self) -> [usize; 2] {
        self.shape
    }

    pub(crate) fn outputs(&self) -> usize {
        self.outputs
    }

    pub(crate) fn memory(&self) -> TreesMemory {
        TreesMemory(vec![0.0; summary_width(self.shape)], vec![0.0; self.outputs])
    }

    /// Predicts values `[n, outputs]`, row-major.
    pub(crate) fn predict(&self, x: &Series) -> Result<Vec<f32>> {
        x.expect(self.shape)?;
        let one = |memory: &mut TreesMemory, x: &[f32], row: &mut [f32]| self.predict_one(x, memory, row);
        Ok(each_recording(x, self.outputs, || self.memory(), one).into_values())
    }

    /// Writes the values of one recording.
    pub(crate) fn predict_one(
        &self,
        recording: &[f32],
        TreesMemory(features, sums): &mut TreesMemory,
        values: &mut [f32],
    ) {
        summary(recording, self.shape[1], features);
        sums.fill(0.0);
        for &root in &self.roots {
            let leaf = &self.values[self.leaf(root, features) * self.outputs..][..self.outputs];
            sums.iter_mut().zip(leaf).for_each(|(sum, value)| *sum += f64::from(*value));
        }
        let trees = self.roots.len() as f64;
        values.iter_mut().zip(sums).for_each(|(value, sum)| *value = (*sum / trees) as f32);
    }

    /// Returns the number of the leaf below `at` in which features end.
    fn leaf(&self, mut at: usize, features: &[f32]) -> usize {
        loop {
            let node = self.nodes[at];
            if node.feature == LEAF {
                return node.next as usize;
            }
            at = if features[node.feature as usize] <= node.threshold { at + 1 } else { node.next as usize };
        }
    }

    /// Checks whether `memory` is that of such trees.
    pub(crate) fn fits(&self, TreesMemory(features, sums): &TreesMemory) -> bool {
        features.len() == summary_width(self.shape) && sums.len() == self.outputs
    }

    /// Counts the comparisons on the longest way down each tree, and the additions of its leaf.
    pub(crate) fn macs(&self) -> u64 {
        let mut depths = vec![0u64; self.nodes.len()];
        let mut total = 0;
        for (tree, &root) in self.roots.iter().enumerate() {
            let end = self.roots.get(tree + 1).copied().unwrap_or(self.nodes.len());
            for at in root..end {
                if self.nodes[at].feature != LEAF {
                    depths[at + 1] = depths[at] + 1;
                    depths[self.nodes[at].next as usize] = depths[at] + 1;
                }
            }
            total += depths[root..end].iter().max().unwrap_or(&0) + self.outputs as u64;
        }
        total
    }

    /// Returns the trees: `trees.sizes` `[trees]` are their nodes; `trees.feature` `[nodes]` is −1 for a leaf; `trees.threshold`
    /// `[nodes]`; `trees.right` `[nodes]` is the number within the tree of the child of greater features, 0 for a leaf (the other
    /// child is the next node); `trees.values` `[leaves, outputs]` in the order of the leaves.
    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let ends = self.roots.iter().skip(1).copied().chain([self.nodes.len()]);
        let sizes: Vec<f32> = self.roots.iter().zip(ends).map(|(root, end)| (end - root) as f32).collect();
        let (mut features, mut right) = (vec![], vec![]);
        for (at, node) in self.nodes.iter().enumerate() {
            let root = self.roots[self.roots.partition_point(|root| *root <= at) - 1];
            let is_leaf = node.feature == LEAF;
            features.push(if is_leaf { -1.0 } else { node.feature as f32 });
            right.push(if is_leaf { 0.0 } else { (node.next as usize - root) as f32 });
        }
        let thresholds = self.nodes.iter().map(|node| node.threshold).collect();
        let (nodes, leaves) = (self.nodes.len(), self.values.len() / self.outputs);
        vec![
            ("trees.sizes", vec![sizes.len()], sizes),
            ("trees.feature", vec![nodes], features),
            ("trees.threshold", vec![nodes], thresholds),
            ("trees.right", vec![nodes], right),
            ("trees.values", vec![leaves, self.outputs], self.values.clone()),
        ]
    }

    /// Reads so many `trees` from what [`ExtraTrees::tensors`] gave. Children come after their parents within a tree, so every
    /// way down ends.
    pub(crate) fn read(shape: [usize; 2], outputs: usize, trees: usize, saved: &Saved) -> Result<Self> {
        let refuse = |tensor: &str, reason| Error::Saved { tensor: tensor.into(), reason };
        let features = saved.get("trees.feature")?;
        if u32::try_from(features.len()).is_err() {
            return Err(refuse("trees.feature", "has too many nodes"));
        }
        let thresholds = saved.sized("trees.threshold", features.len())?;
        let right = saved.sized("trees.right", features.len())?;
        let values = saved.finite_rows("trees.values", outputs)?.to_vec();
        let (width, mut leaves) = (summary_width(shape), 0u32);
        let (mut roots, mut nodes): (Vec<usize>, Vec<Node>) = (vec![], vec![]);
        for size in saved.sized("trees.sizes", trees)? {
            let (root, left) = (nodes.len(), features.len() - nodes.len());
            let size =
                whole(*size, 1..left + 1).ok_or_else(|| refuse("trees.sizes", "does not fit the nodes"))?;
            roots.push(root);
            for at in root..root + size {
                if features[at] == -1.0 {
                    nodes.push(Node { feature: LEAF, threshold: 0.0, next: leaves });
                    leaves += 1;
                    continue;
                }
                let feature = whole(features[at], 0..width)
                    .ok_or_else(|| refuse("trees.feature", "is no feature of the series"))?;
                let next = whole(right[at], at - root + 2..size)
                    .ok_or_else(|| refuse("trees.right", "is no later node of its tree"))?;
                if !thresholds[at].is_finite() {
                    return Err(refuse("trees.threshold", "is not finite"));
                }
                let (feature, next) = (feature as u32, (root + next) as u32);
                nodes.push(Node { feature, threshold: thresholds[at], next });
            }
        }
        if nodes.len() != features.len() || outputs == 0 || leaves as usize != values.len() / outputs {
            return Err(refuse("trees.sizes", "does not fit the nodes"));
        }
        Ok(ExtraTrees { shape, outputs, roots, nodes, values })
    }
}

/// Returns a float as the whole number that it is, if it lies in `range`.
fn whole(value: f32, range: std::ops::Range<usize>) -> Option<usize> {
    let number = value as usize;
    (number as f32 == value && range.contains(&number)).then_some(number)
}

/// Returns values `[n, outputs]` at mean 0 and deviation 1, with mean and deviation of each output; one that is constant stays
/// zero.
fn standardised(values: &[f32], outputs: usize) -> (Vec<f64>, Vec<(f64, f64)>) {
    let n = (values.len() / outputs) as f64;
    let column = |output: usize| values.iter().skip(output).step_by(outputs).map(|value| f64::from(*value));
    let scale = |output: usize| {
        let mean = column(output).sum::<f64>() / n;
        let sd = (column(output).map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt();
        (mean, if sd > 0.0 { sd } else { 1.0 })
    };
    let scales: Vec<(f64, f64)> = (0..outputs).map(scale).collect();
    let scaled = values.iter().zip(scales.iter().cycle());
    (scaled.map(|(value, (mean, sd))| (f64::from(*value) - mean) / sd).collect(), scales)
}
