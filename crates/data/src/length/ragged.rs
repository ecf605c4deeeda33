//! Samples as recorded: each may have a length of its own along one axis, which is time.

use crate::dataset::digest::{RowHash, hash_row};
use crate::formats::npy::c_order;
use crate::options::Limits;
use crate::{Error, Result};
use ndarray::ArrayD;
use std::ops::Range;

/// Samples that agree in all axes but one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ragged {
    /// Sample after sample, each in C order.
    values: Vec<f32>,
    /// Shape of a sample; of unequal ones that of the longest.
    shape: Vec<usize>,
    samples: usize,
    /// Of unequal samples the axis in which they differ, and the length of each along it.
    own: Option<(usize, Vec<usize>)>,
}

impl From<ArrayD<f32>> for Ragged {
    /// Samples `[N, ...]` of one shape.
    fn from(x: ArrayD<f32>) -> Self {
        let (samples, shape) = (x.shape()[0], x.shape()[1..].to_vec());
        let x = c_order(x);
        let size = x.len();
        let (mut values, offset) = x.into_raw_vec_and_offset();
        values.drain(..offset.unwrap_or(0));
        values.truncate(size);
        Self { values, shape, samples, own: None }
    }
}

impl Ragged {
    /// Samples one after the other that have the `shape` but for their `lengths` along `axis`.
    pub fn of_lengths(values: Vec<f32>, shape: Vec<usize>, axis: usize, lengths: Vec<usize>) -> Self {
        Self { values, shape, samples: lengths.len(), own: Some((axis, lengths)) }.settled()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples
    }

    /// `[N, ...]`; the longest where samples are unequal.
    pub fn shape(&self) -> Vec<usize> {
        [&[self.samples], self.shape.as_slice()].concat()
    }

    /// Shape of a sample; of unequal ones that of the longest.
    pub fn sample_shape(&self) -> &[usize] {
        &self.shape
    }

    /// Whether samples differ in length.
    pub fn is_unequal(&self) -> bool {
        self.own.is_some()
    }

    /// Lengths along `axis`.
    pub fn lengths(&self, axis: usize) -> Vec<usize> {
        match &self.own {
            Some((own, lengths)) if *own == axis => lengths.clone(),
            _ => vec![self.shape[axis]; self.samples],
        }
    }

    /// Shape of one sample.
    pub fn shape_of(&self, sample: usize) -> Vec<usize> {
        let mut shape = self.shape.clone();
        if let Some((axis, lengths)) = &self.own {
            shape[*axis] = lengths[sample];
        }
        shape
    }

    /// Values of each sample.
    pub fn each(&self) -> impl Iterator<Item = &[f32]> {
        let mut start = 0;
        (0..self.samples).map(move |sample| {
            let range = start..start + self.size_of(sample);
            start = range.end;
            &self.values[range]
        })
    }

    fn size_of(&self, sample: usize) -> usize {
        let size: usize = self.shape.iter().product();
        match &self.own {
            None => size,
            Some((axis, lengths)) => size / self.shape[*axis] * lengths[sample],
        }
    }

    /// These samples and then others of the same shape; both shapes where they are not.
    pub fn joined(mut self, next: Self) -> Result<Self, [Vec<usize>; 2]> {
        if self.shape != next.shape || self.is_unequal() || next.is_unequal() {
            return Err([self.shape, next.shape]);
        }
        self.values.extend(next.values);
        self.samples += next.samples;
        Ok(self)
    }

    /// Fingerprint of each sample.
    pub fn hashes(&self) -> Vec<RowHash> {
        self.each().map(hash_row).collect()
    }

    /// All samples as one array; those of unequal length are no array.
    pub fn into_array(self) -> Option<ArrayD<f32>> {
        let shape = self.shape();
        match self.own {
            Some(_) => None,
            None => ArrayD::from_shape_vec(shape, self.values).ok(),
        }
    }

    /// The samples `kept` and `channels` along their first axis, which is not the one in which they differ.
    pub fn select(mut self, kept: &[usize], channels: Option<&[usize]>) -> Self {
        if kept.len() == self.samples && channels.is_none() {
            return self;
        }
        let first = self.shape.first().map_or(1, |axis| *axis);
        let starts: Vec<Range<usize>> = {
            let mut at = 0;
            let next = |sample| {
                let range = at..at + self.size_of(sample);
                at = range.end;
                range
            };
            (0..self.samples).map(next).collect()
        };
        let rows: usize = kept.iter().map(|row| starts[*row].len()).sum();
        let mut values = Vec::with_capacity(rows / first * channels.map_or(first, <[usize]>::len));
        for &sample in kept {
            let own = &self.values[starts[sample].clone()];
            match channels {
                None => values.extend_from_slice(own),
                Some(channels) => {
                    let each = own.len() / first;
                    channels.iter().for_each(|c| values.extend_from_slice(&own[c * each..(c + 1) * each]));
                }
            }
        }
        if let Some(channels) = channels {
            self.shape[0] = channels.len();
        }
        let own = self.own.map(|(axis, lengths)| (axis, kept.iter().map(|row| lengths[*row]).collect()));
        Self { values, samples: kept.len(), shape: self.shape, own }.settled()
    }

    /// Takes steps at the end of a sample in which every value is NaN for the padding that it is; a sample of
    /// nothing else stays.
    pub fn without_padding(mut self, axis: usize) -> Self {
        let (outer, inner) = self.around(axis);
        let mut lengths = self.lengths(axis);
        for (own, length) in self.each().zip(&mut lengths) {
            let all = *length;
            let is_blank = |t: &usize| {
                (0..outer).all(|o| own[(o * all + t) * inner..][..inner].iter().all(|v| v.is_nan()))
            };
            let blank = (0..all).rev().take_while(is_blank).count();
            *length = if blank == all { all } else { all - blank };
        }
        let before = self.lengths(axis);
        if before == lengths {
            return self;
        }
        // Forward within the same memory: a sample only moves towards the start.
        let (mut from, mut to) = (0, 0);
        for (old, new) in before.iter().zip(&lengths) {
            for o in 0..outer {
                let at = from + o * old * inner;
                self.values.copy_within(at..at + new * inner, to);
                to += new * inner;
            }
            from += outer * old * inner;
        }
        self.values.truncate(to);
        self.own = Some((axis, lengths));
        self.settled()
    }

    /// Values before and after an axis in a sample's memory order: `outer · length · inner` are all.
    pub fn around(&self, axis: usize) -> (usize, usize) {
        (self.shape[..axis].iter().product(), self.shape[axis + 1..].iter().product())
    }

    /// Sets the shape to the longest, and forgets lengths that are all equal.
    fn settled(mut self) -> Self {
        if let Some((axis, lengths)) = &self.own {
            let longest = lengths.iter().max().map_or(0, |length| *length);
            self.shape[*axis] = longest;
            if lengths.iter().all(|length| *length == longest) {
                self.own = None;
            }
        }
        self
    }
}

/// Collects samples one by one.
pub(crate) struct Collected {
    /// For messages.
    file: String,
    ragged: Ragged,
    /// Name and shape of the first sample, and the axis along which others may differ from it.
    first: Option<(String, Vec<usize>, Option<usize>)>,
    lengths: Vec<usize>,
    /// How many samples there will be, where that is known; 0 otherwise.
    expected: usize,
    most: Limits,
}

impl Collected {
    pub fn new(file: &str, most: Limits) -> Self {
        Self { file: file.into(), ragged: Ragged::default(), first: None, lengths: vec![], expected: 0, most }
    }

    /// Keeps room for so many samples of the size of the first: growing step by step would take twice the memory
    /// in the end.
    pub fn of_about(self, expected: usize) -> Self {
        Self { expected, ..self }
    }

    /// Adds a sample, which may differ from the first along time only: the axis `time` of the first, whatever is
    /// said of later ones. `hint` says what to do about one that differs elsewhere.
    pub fn push(
        &mut self,
        name: &str,
        shape: &[usize],
        values: &[f32],
        time: Option<usize>,
        hint: &'static str,
    ) -> Result<()> {
        let of_first = || (name.to_string(), shape.to_vec(), time);
        let (first, first_shape, time) = self.first.get_or_insert_with(of_first);
        let time = *time;
        let fits = |(axis, (own, first)): (usize, (&usize, &usize))| Some(axis) == time || own == first;
        let mut all = shape.iter().zip(first_shape.iter()).enumerate();
        if shape.len() != first_shape.len() || !all.all(fits) {
            let (first, first_shape) = (first.clone(), first_shape.clone());
            return Err(Error::SampleShape {
                file: name.into(),
                shape: shape.to_vec(),
                first,
                first_shape,
                hint,
            });
        }
        if (self.ragged.values.len() + values.len()) as u64 > self.most.max_values {
            let shape = [&[self.lengths.len() + 1], shape].concat();
            return Err(Error::TooLarge {
                at: self.file.clone(),
                shape: shape.iter().map(|n| *n as u64).collect(),
                limit: self.most.max_values,
                hint: "take fewer recordings or raise limits.max_values",
            });
        }
        if self.lengths.is_empty() {
            let size = self.expected.saturating_mul(values.len()).min(self.most.max_values as usize);
            // Without the room it grows step by step after all.
            let _ = self.ragged.values.try_reserve_exact(size);
        }
        self.lengths.push(time.map_or(0, |axis| shape[axis]));
        self.ragged.values.extend_from_slice(values);
        if self.lengths.len() == 1 {
            self.ragged.shape = shape.to_vec();
            self.ragged.own = time.map(|axis| (axis, vec![]));
        }
        Ok(())
    }

    /// All samples; none where there are none.
    pub fn finish(self) -> Option<Ragged> {
        let Self { mut ragged, lengths, .. } = self;
        ragged.samples = lengths.len();
        ragged.own = ragged.own.map(|(axis, _)| (axis, lengths));
        (ragged.samples > 0).then(|| ragged.settled())
    }
}
