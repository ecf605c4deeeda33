//! Makes samples of one length of recordings as long as they are.

use crate::dataset::problems::Problems;
use crate::dataset::raw::Raw;
use crate::dataset::sample_spec::SampleSpec;
use crate::dataset::spec_of::{layout_of, spec_of};
use crate::dataset::validate::not_finite;
use crate::length::cut::cut;
use crate::length::length::Length;
use crate::length::lengths::Lengths;
use crate::length::ragged::Ragged;
use crate::options::{ReadOptions, refuse_set};
use crate::{Error, Result};
use ndarray::ArrayD;

/// EqualSamples of one length.
pub(crate) struct EqualSamples {
    pub x: ArrayD<f32>,
    pub spec: SampleSpec,
    /// Position among the recordings, and first time step, of each sample that is a window.
    pub windows: Option<Vec<(usize, usize)>>,
    pub lengths: Option<Lengths>,
    /// Time steps of each recording, where a rule has made them one length.
    pub readings: Option<Vec<usize>>,
}

/// Brings the `kept` recordings to one length.
pub(crate) fn samples(
    raw: &Raw,
    x: Ragged,
    kept: &[usize],
    channels: Option<&[usize]>,
    options: &ReadOptions,
    faults: &mut Problems,
) -> Result<EqualSamples> {
    let mut shape = x.sample_shape().to_vec();
    if let Some(channels) = channels {
        shape[0] = channels.len();
    }
    let layout = layout_of(raw, options.layout, &shape)?;
    let axis = layout.time_axis();
    let x = x.without_padding(axis);
    refuse_channels(raw, &x, axis, channels)?;
    let x = x.select(kept, channels);
    let name = |row: usize| raw.sample_name(kept[row]);
    not_finite(&x, channels, faults, name);
    let (Some(axis), true) = (axis, x.is_unequal() || options.length.is_some()) else {
        // A rule for the length of samples without time is refused too.
        let x = x.into_array().filter(|_| options.length.is_none());
        let x = x.ok_or_else(|| Error::NoTime { file: raw.file.clone(), layout })?;
        let spec = spec_of(raw, options, layout, &x.shape()[1..], None, &[])?;
        return Ok(EqualSamples { x, spec, windows: None, lengths: None, readings: None });
    };
    let readings = x.lengths(axis);
    let mut lengths = Lengths::of(&readings, options.length);
    if options.length.is_none() {
        faults.push(lengths.refused(&raw.file));
    }
    let rule = options.length.unwrap_or(lengths.proposed);
    let cut = cut(&rule, &x, axis, &options.limits, &raw.file, name)?;
    lengths.unused = cut.unused;
    if let Length::Window { to, .. } = rule {
        lengths.too_short = readings.iter().filter(|length| **length < to).count();
    }
    let spec = spec_of(raw, options, layout, &cut.x.shape()[1..], Some(rule), &readings)?;
    let (windows, readings) = (cut.windows, Some(readings));
    Ok(EqualSamples { x: cut.x, spec, windows, lengths: Some(lengths), readings })
}

/// Refuses channels of samples that differ in length along the axis on which channels are picked.
pub(crate) fn refuse_channels(
    raw: &Raw,
    x: &Ragged,
    time: Option<usize>,
    channels: Option<&[usize]>,
) -> Result<()> {
    let why = "are picked along the first axis of a sample, which is time here; leave them out";
    let is_set = x.is_unequal() && time == Some(0) && channels.is_some();
    refuse_set(&raw.file, &[("channels", is_set)], why)
}
