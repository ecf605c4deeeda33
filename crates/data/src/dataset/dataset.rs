//! The data set in memory.

use crate::check::duplicates::units;
use crate::dataset::digest::{RowHash, digest, hash_rows, with_weights};
use crate::dataset::labels::Labels;
use crate::dataset::sample_spec::SampleSpec;
use crate::dataset::source::Source;
use crate::dataset::targets::{Targets, Task};
use crate::{Error, Result};
use ndarray::{ArrayD, Axis};
use std::borrow::Cow;
use std::collections::BTreeSet;
use taxel_base::Layout;

/// Labelled samples, all of one shape, as read: nothing is scaled.
///
/// Every field is public; whoever fills them keeps as many entries per sample as each says.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// The file or folder name without extension; `data.npz` goes by its folder.
    pub name: String,
    /// Whether samples were simulated or recorded: stands beside every score.
    pub source: Source,
    /// Axes, shape, unit, rate and range of one sample.
    pub spec: SampleSpec,
    /// Samples `[N, ...]` in C order, in the unit of the readings.
    pub x: ArrayD<f32>,
    /// The targets of each sample: a class, levels of several attributes (see
    /// [`learn_attributes`](Self::learn_attributes)), or values.
    pub targets: Targets,
    /// Which samples the data set's authors test on, where they say so.
    pub official: Option<Vec<bool>>,
    /// Group (object, session, block) of each sample.
    pub groups: Option<Vec<u32>>,
    /// Name of the groups, such as `session` or `trial/12`.
    pub group_name: Option<String>,
    /// How much each sample counts in training, above 0; none where all count alike.
    pub weights: Option<Vec<f32>>,
    /// The unit of each sample, which [`stratified_k_fold`](crate::stratified_k_fold) keeps in one fold: the index, as
    /// read, of the first exact copy or, where [frames are samples](Dataset::each_frame), of the first frame of its
    /// recording. None where there can be no copies.
    pub units: Option<Vec<u32>>,
    /// Where each sample comes from: its file, `x[17]`, or `fingertip[17]`.
    pub origins: Vec<String>,
    /// Origins of the rows left out by [`ReadOptions::drop`](crate::ReadOptions::drop), and of recordings shorter than a
    /// window.
    pub dropped: Vec<String>,
    /// Doubts that arose when the files were read, such as pauses in a recording, and how to fix each; no part of the content.
    pub warnings: Vec<String>,
    /// Hash of each sample as it is trained on: of its values in `x`. Empty where there can be no copies.
    pub row_hash: Vec<RowHash>,
    /// Type of the stored values: `<f4`, `|u1`, `csv`, `png/jpeg u8`.
    pub dtype: String,
    /// BLAKE3 of shape, values, labels and groups, in hexadecimal.
    pub digest: String,
}

impl Dataset {
    /// Seeks exact copies among the samples by `read` `[N, ..]`, the part of each that is trained on. Units that are whole
    /// recordings stay.
    pub fn seek_copies_in(&mut self, read: &ArrayD<f32>) {
        let by_copies = self.units.as_ref().is_some_and(|known| *known == units(&self.row_hash));
        self.row_hash = hash_rows(read);
        if by_copies {
            self.units = Some(units(&self.row_hash));
        }
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.targets.len()
    }

    /// Checks whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty()
    }

    /// Returns the shape of one sample: the axes of `x` after the first.
    pub fn sample_shape(&self) -> &[usize] {
        &self.spec.shape
    }

    /// Returns the strata `[N]` that splits keep even; see [`Targets::strata`].
    pub fn strata(&self) -> Cow<'_, [u32]> {
        self.targets.strata()
    }

    /// Returns the task that the targets pose.
    pub fn task(&self) -> Task {
        self.targets.task()
    }

    /// Returns the names of a model's outputs: the classes, `attribute:level`, or quantities.
    pub fn output_names(&self) -> Vec<String> {
        self.task().output_names()
    }

    /// Returns the labels of classes or levels.
    ///
    /// # Errors
    ///
    /// [`Error::NoLabels`] for targets that are values.
    pub fn labels(&self) -> Result<&Labels> {
        self.targets.labels().ok_or_else(|| Error::NoLabels { source_name: self.source.to_string() })
    }

    /// Counts the samples of each class, or of each level, in the order of the outputs; empty for values.
    pub fn class_counts(&self) -> Vec<usize> {
        let Some(labels) = self.targets.labels() else { return vec![] };
        let mut counts = vec![0; labels.sizes().iter().sum()];
        for output in (0..self.len()).flat_map(|row| self.outputs(row)) {
            counts[output] += 1;
        }
        counts
    }

    /// Returns the outputs that some of the samples `rows` stand for: their classes, or levels.
    pub fn outputs_of(&self, rows: &[usize]) -> BTreeSet<usize> {
        rows.iter().flat_map(|row| self.outputs(*row)).collect()
    }

    /// Returns the positions of a sample's labels among the outputs, one per attribute. Only a card meets a label that is
    /// no class: it has none.
    pub(crate) fn outputs(&self, row: usize) -> Vec<usize> {
        let Some(labels) = self.targets.labels() else { return vec![] };
        let mut start = 0;
        let attributes = labels.sizes().into_iter().zip(labels.of(&[row]));
        let places = attributes.map(|(size, label)| {
            start += size;
            ((label as usize) < size).then_some(start - size + label as usize)
        });
        places.flatten().collect()
    }

    /// Returns the samples `rows`, in that order, under a digest of their own. Classes without a sample keep their names.
    ///
    /// # Panics
    ///
    /// For a row that is not there.
    pub fn select(&self, rows: &[usize]) -> Self {
        let mut selected = self.rows(rows);
        selected.update_digest();
        selected
    }

    /// Returns the cluster of each sample, which a bootstrap draws as one: its group, else its exact copies, else itself.
    pub fn clusters(&self) -> Vec<u32> {
        let each = || (0..self.len() as u32).collect();
        self.groups.clone().or_else(|| self.units.clone()).unwrap_or_else(each)
    }

    /// Refuses samples that are all of one class.
    ///
    /// # Errors
    ///
    /// [`Error::OneClass`].
    pub fn refuse_one_class(&self) -> Result<()> {
        match &self.targets {
            Targets::Classes { labels, .. } if labels.sizes() == [1] => {
                let class = labels.attributes()[0].classes[0].clone();
                Err(Error::OneClass { file: self.name.clone(), class })
            }
            _ => Ok(()),
        }
    }

    /// Says what the axes of a sample are, where a file does not.
    ///
    /// # Errors
    ///
    /// [`Error::Layout`] where the shape of a sample does not fit.
    pub fn set_layout(&mut self, layout: Layout) -> Result<()> {
        refuse_layout(&self.name, layout, &self.spec.shape)?;
        self.spec.layout = layout;
        Ok(())
    }

    /// Returns the samples `rows`, under the digest of all samples.
    pub(crate) fn rows(&self, rows: &[usize]) -> Self {
        let take = |values: &Vec<u32>| rows.iter().map(|&row| values[row]).collect::<Vec<_>>();
        Self {
            name: self.name.clone(),
            source: self.source.clone(),
            spec: self.spec.clone(),
            x: self.x.select(Axis(0), rows),
            targets: self.targets.select(rows),
            official: self.official.as_ref().map(|test| rows.iter().map(|&row| test[row]).collect()),
            groups: self.groups.as_ref().map(take),
            group_name: self.group_name.clone(),
            weights: self.weights.as_ref().map(|weights| rows.iter().map(|&row| weights[row]).collect()),
            units: self.units.as_ref().map(take),
            origins: rows.iter().map(|&row| self.origins[row].clone()).collect(),
            dropped: self.dropped.clone(),
            warnings: self.warnings.clone(),
            row_hash: match self.row_hash.as_slice() {
                [] => vec![],
                hashes => rows.iter().map(|&row| hashes[row]).collect(),
            },
            dtype: self.dtype.clone(),
            digest: self.digest.clone(),
        }
    }

    /// Returns the weight of each sample, divided by the mean over `rows`; none where all count alike.
    pub fn weights_over(&self, rows: &[usize]) -> Option<Vec<f32>> {
        let weights = self.weights.as_ref()?;
        let sum: f64 = rows.iter().map(|row| f64::from(weights[*row])).sum();
        let mean = sum / rows.len().max(1) as f64;
        Some(weights.iter().map(|weight| (f64::from(*weight) / mean) as f32).collect())
    }

    /// Brings the digest up to date with samples, labels, groups and weights.
    pub(crate) fn update_digest(&mut self) {
        self.digest = digest(&self.x, Some(&self.targets), self.groups.as_deref());
        if let Some(weights) = &self.weights {
            self.digest = with_weights(&self.digest, weights);
        }
    }
}

/// Refuses a layout that samples of this shape cannot have; `at` says who wants it.
pub(crate) fn refuse_layout(at: &str, layout: Layout, shape: &[usize]) -> Result<()> {
    if layout.fits(shape) {
        return Ok(());
    }
    Err(Error::Layout { at: at.into(), layout, shape: shape.to_vec() })
}
