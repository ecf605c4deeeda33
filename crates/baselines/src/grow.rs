//! Growth of one extremely randomised tree.

use std::ops::Range;

use rand::RngExt;
use taxel_base::seed::Rng;

/// Stands for the feature of a leaf.
pub(crate) const LEAF: u32 = u32::MAX;

/// The samples that a tree grows on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ground<'a> {
    /// `[n, width]`, row-major.
    pub features: &'a [f32],
    pub width: usize,
    /// `[n, outputs]`, row-major. What is gained in them adds up, so they are of one scale.
    pub targets: &'a [f64],
    pub outputs: usize,
    /// The least samples of a leaf, at least 1.
    pub min_samples_leaf: usize,
}

/// A place where samples part, or a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    /// The feature that is asked, or [`LEAF`].
    pub feature: u32,
    /// Samples of no greater feature go left: to the next node.
    pub threshold: f32,
    /// The node of the others; of a leaf its number among the leaves.
    pub next: u32,
}

/// Nodes, each before the nodes to its left and these before those to its right, and the mean targets of the leaves.
#[derive(Debug, Default)]
pub(crate) struct Tree {
    pub nodes: Vec<Node>,
    /// `[leaves, outputs]`.
    pub values: Vec<f64>,
}

/// A tree that grows, with memory for one node after the other.
///
/// Features of a sample lie side by side, and a node asks all of them, so each sample is read once for the bounds of all
/// features and once for what all thresholds would part.
struct Growth<'a> {
    ground: Ground<'a>,
    rng: Rng,
    /// Samples; those of a node are neighbours.
    order: Vec<u32>,
    low: Vec<f32>,
    high: Vec<f32>,
    thresholds: Vec<f32>,
    /// Samples left of each threshold.
    counts: Vec<u32>,
    /// Sum of their targets, `[outputs, width]`.
    sums: Vec<f64>,
    /// Sum of all targets of the node.
    totals: Vec<f64>,
}

impl Ground<'_> {
    fn row(&self, sample: u32) -> &[f32] {
        &self.features[sample as usize * self.width..][..self.width]
    }

    fn target(&self, sample: u32) -> &[f64] {
        &self.targets[sample as usize * self.outputs..][..self.outputs]
    }

    /// Grows a tree; all that is random comes from `rng`.
    pub(crate) fn grow(&self, rng: Rng) -> Tree {
        let (n, width) = (self.features.len() / self.width, self.width);
        let mut growth = Growth {
            ground: *self,
            rng,
            order: (0..n as u32).collect(),
            low: vec![0.0; width],
            high: vec![0.0; width],
            thresholds: vec![0.0; width],
            counts: vec![0; width],
            sums: vec![0.0; width * self.outputs],
            totals: vec![0.0; self.outputs],
        };
        let mut tree = Tree::default();
        // Nodes to come, the next one last, and whose right child they are. A list instead of calls of itself: a tree
        // may be as deep as there are samples.
        let mut open: Vec<(Range<usize>, Option<usize>)> = vec![(0..n, None)];
        while let Some((members, parent)) = open.pop() {
            let at = tree.nodes.len();
            if let Some(parent) = parent {
                tree.nodes[parent].next = at as u32;
            }
            if let Some((feature, threshold)) = growth.split(members.clone()) {
                let middle = growth.part(members.clone(), feature, threshold);
                tree.nodes.push(Node { feature: feature as u32, threshold, next: 0 });
                open.push((middle..members.end, Some(at)));
                open.push((members.start..middle, None));
            } else {
                let next = (tree.values.len() / self.outputs) as u32;
                tree.nodes.push(Node { feature: LEAF, threshold: 0.0, next });
                growth.sum(members.clone());
                tree.values.extend(growth.totals.iter().map(|total| total / members.len() as f64));
            }
        }
        tree
    }
}

impl Growth<'_> {
    /// Returns the feature and the threshold that part the samples best, if any does.
    fn split(&mut self, members: Range<usize>) -> Option<(usize, f32)> {
        let samples = &self.order[members.clone()];
        let first = self.ground.target(samples[0]);
        let is_pure = samples.iter().all(|sample| self.ground.target(*sample) == first);
        if is_pure || samples.len() < 2 * self.ground.min_samples_leaf {
            return None;
        }
        self.draw(members.clone());
        self.count(members.clone());
        self.sum(members.clone());
        self.best(members.len())
    }

    /// Draws a threshold of each feature between its least and its greatest value.
    fn draw(&mut self, members: Range<usize>) {
        self.low.fill(f32::INFINITY);
        self.high.fill(f32::NEG_INFINITY);
        for sample in &self.order[members] {
            let row = self.ground.row(*sample);
            for ((low, high), &value) in self.low.iter_mut().zip(&mut self.high).zip(row) {
                // Spelled out, it is one instruction; `min` also minds NaN.
                *low = if value < *low { value } else { *low };
                *high = if value > *high { value } else { *high };
            }
        }
        for ((threshold, &low), &high) in self.thresholds.iter_mut().zip(&self.low).zip(&self.high) {
            let drawn = low + self.rng.random::<f32>() * (high - low);
            // Rounded up to the greatest value it would part nothing.
            *threshold = if drawn < high { drawn } else { low };
        }
    }

    /// Counts the samples left of each threshold, and adds up their targets.
    fn count(&mut self, members: Range<usize>) {
        self.counts.fill(0);
        self.sums.fill(0.0);
        for sample in &self.order[members] {
            let row = self.ground.row(*sample);
            for ((count, threshold), value) in self.counts.iter_mut().zip(&self.thresholds).zip(row) {
                *count += u32::from(value <= threshold);
            }
            let targets = self.ground.target(*sample);
            for (sums, &target) in self.sums.chunks_exact_mut(row.len()).zip(targets) {
                for ((sum, threshold), value) in sums.iter_mut().zip(&self.thresholds).zip(row) {
                    *sum += if value <= threshold { target } else { 0.0 };
                }
            }
        }
    }

    /// Adds up the targets.
    fn sum(&mut self, members: Range<usize>) {
        self.totals.fill(0.0);
        for sample in &self.order[members] {
            let targets = self.ground.target(*sample);
            self.totals.iter_mut().zip(targets).for_each(|(total, target)| *total += target);
        }
    }

    /// Returns the feature and the threshold that leave the least squared error, among those with enough samples on both
    /// sides. Of equals the first from a feature that is drawn: in small nodes many part alike.
    fn best(&mut self, n: usize) -> Option<(usize, f32)> {
        let (width, least) = (self.ground.width, self.ground.min_samples_leaf);
        let start = self.rng.random_range(0..width);
        let mut best: Option<(f64, usize)> = None;
        for feature in (start..width).chain(0..start) {
            let left = self.counts[feature] as usize;
            if left < least || n - left < least {
                continue;
            }
            // The squared error is that of all targets less this.
            let mut gain = 0.0;
            for (output, total) in self.totals.iter().enumerate() {
                let sum = self.sums[output * width + feature];
                gain += sum * sum / left as f64 + (total - sum) * (total - sum) / (n - left) as f64;
            }
            if best.is_none_or(|(most, _)| gain > most) {
                best = Some((gain, feature));
            }
        }
        best.map(|(_, feature)| (feature, self.thresholds[feature]))
    }

    /// Brings the samples that go left before the others, and returns where the others begin.
    fn part(&mut self, members: Range<usize>, feature: usize, threshold: f32) -> usize {
        let mut middle = members.start;
        for at in members {
            if self.ground.row(self.order[at])[feature] <= threshold {
                self.order.swap(at, middle);
                middle += 1;
            }
        }
        middle
    }
}
