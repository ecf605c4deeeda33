//! Applies a rule for the length: recordings of any length become samples of one length.

use crate::length::length::{CropPart, Length, Longer, Padding};
use crate::length::ragged::Ragged;
use crate::options::Limits;
use crate::{Error, Result};
use ndarray::ArrayD;

/// Samples of one length.
pub(crate) struct Cut {
    /// `[N, ...]`.
    pub x: ArrayD<f32>,
    /// Recording and first time step of each sample; none where recordings are samples.
    pub windows: Option<Vec<(usize, usize)>>,
    /// Number of time steps that are in no sample.
    pub unused: usize,
}

/// Brings every recording of `ragged` to the rule's length along `axis`.
///
/// `name` names recordings in messages.
///
/// # Errors
///
/// A rule out of its range, a recording that is too long or too short for it, more values than `limits` allow,
/// recordings of which none is as long as a window.
pub(crate) fn cut(
    rule: &Length,
    ragged: &Ragged,
    axis: usize,
    limits: &Limits,
    file: &str,
    name: impl Fn(usize) -> String,
) -> Result<Cut> {
    if let Some((_, _, why)) = rule.problem() {
        return Err(Error::Option { file: file.into(), option: "length", why });
    }
    let (lengths, to) = (ragged.lengths(axis), rule.to());
    if let Some((sample, why)) = unfit(rule, &lengths) {
        return Err(Error::RecordingLength { sample: name(sample), length: lengths[sample], to, why });
    }
    let windows: Option<Vec<(usize, usize)>> = match rule {
        Length::Window { hop, .. } => Some(starts(&lengths, to, hop.unwrap_or(to), limits, file)?),
        _ => None,
    };
    let samples = windows.as_ref().map_or(lengths.len(), Vec::len);
    let mut shape = ragged.shape();
    (shape[0], shape[axis + 1]) = (samples, to);
    let values = shape.iter().try_fold(1usize, |product, axis| product.checked_mul(*axis));
    let Some(values) = values.filter(|values| *values as u64 <= limits.max_values) else {
        return Err(limits.too_large(file, &shape, "choose a smaller length or raise limits.max_values"));
    };
    let mut out = Vec::with_capacity(values);
    let mut starts = windows.iter().flatten().peekable();
    for (recording, values) in ragged.each().enumerate() {
        let piece = OneRecording { values, length: lengths[recording], around: ragged.around(axis), to };
        match *rule {
            Length::Resample { .. } => piece.resample(&mut out),
            Length::Pad { value, .. } => piece.pad(value, &mut out),
            Length::Crop { from, .. } => piece.copy(from.start(lengths[recording] - to), &mut out),
            Length::Window { .. } => {
                while let Some((_, start)) = starts.next_if(|(at, _)| *at == recording) {
                    piece.copy(*start, &mut out);
                }
            }
        }
    }
    let x = ArrayD::from_shape_vec(shape, out)
        .map_err(|e| Error::NotAnArray { at: file.into(), why: e.to_string() })?;
    let unused = match *rule {
        Length::Window { hop, .. } => unused(&lengths, to, hop.unwrap_or(to)),
        Length::Resample { .. } => 0,
        _ => lengths.iter().map(|length| length.saturating_sub(to)).sum(),
    };
    Ok(Cut { x, windows, unused })
}

/// Finds the first recording that the rule refuses, and says why.
fn unfit(rule: &Length, lengths: &[usize]) -> Option<(usize, &'static str)> {
    let to = rule.to();
    match rule {
        Length::Pad { longer: Longer::Refuse, .. } => {
            let long = lengths.iter().position(|length| *length > to)?;
            Some((long, "raise to, or set longer = \"crop\""))
        }
        Length::Crop { .. } => {
            let short = lengths.iter().position(|length| *length < to)?;
            Some((short, "lower to, or take kind = \"pad\" or \"resample\""))
        }
        Length::Window { .. } => {
            let (longest, sample) = lengths.iter().zip(0..).max()?;
            (*longest < to)
                .then_some((sample, "lower to: no recording holds a window, and this is the longest"))
        }
        Length::Resample { .. } | Length::Pad { .. } => None,
    }
}

/// Lists recording and first time step of every whole window.
fn starts(
    lengths: &[usize],
    to: usize,
    hop: usize,
    limits: &Limits,
    file: &str,
) -> Result<Vec<(usize, usize)>> {
    let count: usize = lengths.iter().map(|length| whole(*length, to, hop)).sum();
    limits.refuse_samples(file, count as u64)?;
    let of = |(recording, length): (usize, &usize)| {
        (0..whole(*length, to, hop)).map(move |i| (recording, i * hop))
    };
    Ok(lengths.iter().enumerate().flat_map(of).collect())
}

/// Counts the whole windows in a recording.
fn whole(length: usize, to: usize, hop: usize) -> usize {
    if length < to { 0 } else { (length - to) / hop + 1 }
}

/// Counts the time steps that are in no window: after the last one, and between windows that leave gaps.
fn unused(lengths: &[usize], to: usize, hop: usize) -> usize {
    let used = |length: usize| match whole(length, to, hop) {
        0 => 0,
        windows => (windows - 1) * hop.min(to) + to,
    };
    lengths.iter().map(|length| length - used(*length)).sum()
}

impl CropPart {
    /// Returns the start of the part in a recording that is `rest` longer.
    fn start(self, rest: usize) -> usize {
        match self {
            Self::Start => 0,
            Self::Centre => rest / 2,
            Self::End => rest,
        }
    }
}

/// One recording that is brought to a length.
struct OneRecording<'r> {
    values: &'r [f32],
    length: usize,
    /// Values before and after the time axis.
    around: (usize, usize),
    to: usize,
}

impl OneRecording<'_> {
    /// Adds the time steps from `start` on.
    fn copy(&self, start: usize, out: &mut Vec<f32>) {
        let (outer, inner) = self.around;
        for o in 0..outer {
            let at = (o * self.length + start) * inner;
            out.extend_from_slice(&self.values[at..at + self.to * inner]);
        }
    }

    /// Adds the recording, cut off or filled up at its end.
    fn pad(&self, value: Padding, out: &mut Vec<f32>) {
        let (outer, inner) = self.around;
        let (kept, first) = (self.length.min(self.to), out.len());
        for o in 0..outer {
            out.extend_from_slice(&self.values[o * self.length * inner..][..kept * inner]);
            out.resize(first + (o + 1) * self.to * inner, 0.0);
        }
        value.fill(&mut out[first..], self.around, kept);
    }

    /// Adds the recording at equally spaced times: time `j` lies at time step `j · step`. Each time step counts by its
    /// distance, from 1 at none to 0 at `step` (or at one time step, if that is more).
    fn resample(&self, out: &mut Vec<f32>) {
        let (outer, inner) = self.around;
        let last = self.length - 1;
        let step = last as f64 / (self.to - 1) as f64;
        let reach = step.max(1.0);
        let mut sums = vec![0.0f64; inner];
        for o in 0..outer {
            for j in 0..self.to {
                let at = j as f64 * step;
                let first = (at - reach).ceil().max(0.0) as usize;
                let end = ((at + reach).floor() as usize).min(last);
                let mut all = 0.0;
                sums.fill(0.0);
                for t in first..=end {
                    let weight = (1.0 - (t as f64 - at).abs() / reach).max(0.0);
                    all += weight;
                    let row = &self.values[(o * self.length + t) * inner..][..inner];
                    sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * f64::from(*value));
                }
                out.extend(sums.iter().map(|sum| (sum / all) as f32));
            }
        }
    }
}
