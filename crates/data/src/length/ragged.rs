//! Samples as recorded: they may differ in length along one axis, which is time.

use crate::dataset::digest::{RowHash, hash_row};
use crate::options::Limits;
use crate::{Error, Result};
use ndarray::ArrayD;
use std::ops::Range;

/// Samples that agree in all axes but one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ragged {
    /// Sample after sample, each in C order.
    values: Vec<f32>,
    /// Shape of a sample, of the longest where they are unequal.
    shape: Vec<usize>,
    samples: usize,
    /// The axis in which samples differ, and the length of each along it; none where they are equal.
    unequal: Option<(usize, Vec<usize>)>,
}

impl From<ArrayD<f32>> for Ragged {
    /// Takes samples `[N, ...]` of one shape, in C order.
    fn from(x: ArrayD<f32>) -> Self {
        let (samples, shape) = (x.shape()[0], x.shape()[1..].to_vec());
        let size = x.len();
        let (mut values, offset) = x.into_raw_vec_and_offset();
        values.drain(..offset.unwrap_or(0));
        values.truncate(size);
        Self { values, shape, samples, unequal: None }
    }
}

impl Ragged {
    /// Takes samples one after the other that have the `shape` but for their `lengths` along `axis`.
    pub fn of_lengths(values: Vec<f32>, shape: Vec<usize>, axis: usize, lengths: Vec<usize>) -> Self {
        Self { values, shape, samples: lengths.len(), unequal: Some((axis, lengths)) }.settled()
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Returns `[N, ...]`, of the longest where samples are unequal.
    pub fn shape(&self) -> Vec<usize> {
        [&[self.samples], self.shape.as_slice()].concat()
    }

    /// Returns the shape of a sample, of the longest where they are unequal.
    pub fn sample_shape(&self) -> &[usize] {
        &self.shape
    }

    /// Checks whether samples differ in length.
    pub fn is_unequal(&self) -> bool {
        self.unequal.is_some()
    }

    /// Returns the length of each sample along `axis`.
    pub fn lengths(&self, axis: usize) -> Vec<usize> {
        match &self.unequal {
            Some((time, lengths)) if *time == axis => lengths.clone(),
            _ => vec![self.shape[axis]; self.samples],
        }
    }

    /// Returns the shape of one sample.
    pub fn shape_of(&self, sample: usize) -> Vec<usize> {
        let mut shape = self.shape.clone();
        if let Some((axis, lengths)) = &self.unequal {
            shape[*axis] = lengths[sample];
        }
        shape
    }

    /// Iterates over the values of each sample.
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
        match &self.unequal {
            None => size,
            Some((axis, lengths)) => size / self.shape[*axis] * lengths[sample],
        }
    }

    /// Appends samples of the same shape; returns both shapes where they differ.
    pub fn joined(mut self, next: Self) -> Result<Self, [Vec<usize>; 2]> {
        if self.shape != next.shape || self.is_unequal() || next.is_unequal() {
            return Err([self.shape, next.shape]);
        }
        self.values.extend(next.values);
        self.samples += next.samples;
        Ok(self)
    }

    /// Returns all samples as one array; none where their lengths are unequal.
    pub fn into_array(self) -> Option<ArrayD<f32>> {
        let shape = self.shape();
        match self.unequal {
            Some(_) => None,
            None => ArrayD::from_shape_vec(shape, self.values).ok(),
        }
    }

    /// Hashes each sample, all of it or only `channels` along its first axis.
    pub fn hashes(&self, channels: Option<&[usize]>) -> Vec<RowHash> {
        let Some(channels) = channels else { return self.each().map(hash_row).collect() };
        let first = self.shape.first().map_or(1, |axis| *axis);
        let of = |sample: &[f32]| {
            let each = sample.len() / first;
            hash_row(channels.iter().flat_map(|c| &sample[c * each..(c + 1) * each]))
        };
        self.each().map(of).collect()
    }

    /// Selects the samples `kept` and `channels` along their first axis, which is not the one in which they differ.
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
            let sample = &self.values[starts[sample].clone()];
            match channels {
                None => values.extend_from_slice(sample),
                Some(channels) => {
                    let each = sample.len() / first;
                    channels.iter().for_each(|c| values.extend_from_slice(&sample[c * each..(c + 1) * each]));
                }
            }
        }
        if let Some(channels) = channels {
            self.shape[0] = channels.len();
        }
        let unequal = self.unequal.map(|(axis, all)| (axis, kept.iter().map(|row| all[*row]).collect()));
        Self { values, samples: kept.len(), shape: self.shape, unequal }.settled()
    }

    /// Cuts off time steps at the end of a sample in which every value is NaN; a sample of nothing else stays. `axis` is
    /// the time axis; samples without one stay as they are.
    pub fn without_padding(mut self, axis: Option<usize>) -> Self {
        let Some(axis) = axis else { return self };
        let (outer, inner) = self.around(axis);
        let mut lengths = self.lengths(axis);
        for (values, length) in self.each().zip(&mut lengths) {
            let all = *length;
            let is_blank = |t: &usize| {
                (0..outer).all(|o| values[(o * all + t) * inner..][..inner].iter().all(|v| v.is_nan()))
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
        self.unequal = Some((axis, lengths));
        self.settled()
    }

    /// Returns the mean of the first `steps` readings along `axis` of each sample, which is at least as long: its values without
    /// that axis.
    pub fn first_means(&self, axis: usize, steps: usize) -> Vec<f64> {
        let (outer, inner) = self.around(axis);
        let mut means = Vec::with_capacity(self.samples * outer * inner);
        for (sample, length) in self.each().zip(self.lengths(axis)) {
            for block in sample.chunks_exact(length * inner).take(outer) {
                let first = |at: usize| block[at..].iter().step_by(inner).take(steps);
                means.extend(
                    (0..inner).map(|at| first(at).map(|v| f64::from(*v)).sum::<f64>() / steps as f64),
                );
            }
        }
        means
    }

    /// Takes off each sample its values of `levels`, which have no axis `time`; of samples without one all values.
    pub fn less(mut self, levels: &[f64], time: Option<usize>) -> Self {
        let (outer, inner) = time.map_or((1, self.shape.iter().product()), |axis| self.around(axis));
        let lengths = time.map_or(vec![1; self.samples], |axis| self.lengths(axis));
        let lengths = lengths.into_iter().flat_map(|length| std::iter::repeat_n(length, outer));
        let mut rest = self.values.as_mut_slice();
        for (level, length) in levels.chunks_exact(inner.max(1)).zip(lengths) {
            let (block, others) = rest.split_at_mut(length * inner);
            rest = others;
            for reading in block.chunks_exact_mut(inner) {
                let pairs = reading.iter_mut().zip(level);
                pairs.for_each(|(value, level)| *value = (f64::from(*value) - level) as f32);
            }
        }
        self
    }

    /// Returns the number of values before and after an axis in memory: a sample has `before · length · after`.
    pub fn around(&self, axis: usize) -> (usize, usize) {
        (self.shape[..axis].iter().product(), self.shape[axis + 1..].iter().product())
    }

    /// Sets the shape to the longest, and drops lengths that are all equal.
    fn settled(mut self) -> Self {
        if let Some((axis, lengths)) = &self.unequal {
            let longest = lengths.iter().max().map_or(0, |length| *length);
            self.shape[*axis] = longest;
            if lengths.iter().all(|length| *length == longest) {
                self.unequal = None;
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
    /// Number of samples that will come, where it is known; 0 otherwise.
    expected: usize,
    limits: Limits,
}

impl Collected {
    pub fn new(file: &str, limits: Limits) -> Self {
        Self {
            file: file.into(),
            ragged: Ragged::default(),
            first: None,
            lengths: vec![],
            expected: 0,
            limits,
        }
    }

    /// Reserves memory for `expected` samples of the size of the first: growing step by step would take twice the memory
    /// in the end.
    pub fn of_about(self, expected: usize) -> Self {
        Self { expected, ..self }
    }

    /// Adds a sample, which may differ from the first along time only: the axis `time` of the first, whatever is given
    /// for later ones. `hint` says how to fix one that differs elsewhere.
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
        let fits = |(axis, (length, first)): (usize, (&usize, &usize))| Some(axis) == time || length == first;
        let mut all = shape.iter().zip(first_shape.iter()).enumerate();
        if shape.len() != first_shape.len() || !all.all(fits) {
            let (first, first_shape) = (first.clone(), first_shape.clone());
            let (file, shape) = (name.into(), shape.to_vec());
            return Err(Error::SampleShape { file, shape, first, first_shape, hint });
        }
        if (self.ragged.values.len() + values.len()) as u64 > self.limits.max_values {
            let shape = [&[self.lengths.len() + 1], shape].concat();
            let hint = "take fewer recordings or raise limits.max_values";
            return Err(self.limits.too_large(&self.file, &shape, hint));
        }
        if self.lengths.is_empty() {
            let size = self.expected.saturating_mul(values.len()).min(self.limits.max_values as usize);
            // Where this fails, memory grows step by step.
            let _ = self.ragged.values.try_reserve_exact(size);
        }
        self.lengths.push(time.map_or(0, |axis| shape[axis]));
        self.ragged.values.extend_from_slice(values);
        if self.lengths.len() == 1 {
            self.ragged.shape = shape.to_vec();
            self.ragged.unequal = time.map(|axis| (axis, vec![]));
        }
        Ok(())
    }

    /// Returns all samples; none where there are none.
    pub fn finish(self) -> Option<Ragged> {
        let Self { mut ragged, lengths, .. } = self;
        ragged.samples = lengths.len();
        ragged.unequal = ragged.unequal.map(|(axis, _)| (axis, lengths));
        (ragged.samples > 0).then(|| ragged.settled())
    }
}
