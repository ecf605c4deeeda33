//! From recordings as long as they are to samples of one length.

use crate::dataset::problems::Faults;
use crate::dataset::raw::Raw;
use crate::dataset::sample_spec::SampleSpec;
use crate::dataset::spec_of::{layout_of, spec_of};
use crate::dataset::validate::not_finite;
use crate::length::cut::cut;
use crate::length::length::Length;
use crate::length::lengths::Lengths;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::{Error, Result};
use ndarray::ArrayD;
use taxel_base::Layout;

/// Samples of one length.
pub(crate) struct Samples {
    pub x: ArrayD<f32>,
    pub spec: SampleSpec,
    /// Position among the recordings, and first reading, of each sample that is a window.
    pub windows: Option<Vec<(usize, usize)>>,
    pub lengths: Option<Lengths>,
    /// Readings of each recording along time, where a rule has made them one length.
    pub readings: Option<Vec<usize>>,
}

/// The `kept` recordings, brought to one length.
pub(crate) fn samples(
    raw: &Raw,
    x: Ragged,
    kept: &[usize],
    channels: Option<&[usize]>,
    options: &ReadOptions,
    faults: &mut Faults,
) -> Result<Samples> {
    let mut shape = x.sample_shape().to_vec();
    if let Some(channels) = channels {
        shape[0] = channels.len();
    }
    let layout = layout_of(raw, options.layout, &shape)?;
    let axis = layout.time_axis();
    let x = match axis {
        Some(axis) => x.without_padding(axis),
        None => x,
    };
    refuse_channels(raw, &x, axis, channels)?;
    let x = x.select(kept, channels);
    let name = |row: usize| raw.sample_name(kept[row]);
    not_finite(&x, channels, faults, name);
    let (Some(axis), true) = (axis, x.is_unequal() || options.length.is_some()) else {
        refuse_rule(raw, options, layout)?;
        let x = x.into_array().ok_or_else(|| Error::NoTime { file: raw.file.clone(), layout })?;
        let spec = spec_of(raw, options, layout, &x.shape()[1..], None, &[])?;
        return Ok(Samples { x, spec, windows: None, lengths: None, readings: None });
    };
    let own = x.lengths(axis);
    let mut lengths = Lengths::of(&own, options.length);
    if options.length.is_none() {
        faults.push(lengths.refused(&raw.file));
    }
    let rule = options.length.unwrap_or(lengths.proposed);
    let cut = cut(&rule, &x, axis, &options.limits, &raw.file, name)?;
    lengths.unused = cut.unused;
    if let Length::Window { to, .. } = rule {
        lengths.too_short = own.iter().filter(|length| **length < to).count();
    }
    let spec = spec_of(raw, options, layout, &cut.x.shape()[1..], Some(rule), &own)?;
    Ok(Samples { x: cut.x, spec, windows: cut.windows, lengths: Some(lengths), readings: Some(own) })
}

/// Refuses channels of samples that differ in length along the axis on which channels are picked.
pub(crate) fn refuse_channels(
    raw: &Raw,
    x: &Ragged,
    time: Option<usize>,
    channels: Option<&[usize]>,
) -> Result<()> {
    if !x.is_unequal() || time != Some(0) || channels.is_none() {
        return Ok(());
    }
    let why = "are picked along the first axis of a sample, which is time here; leave them out";
    Err(Error::Option { file: raw.file.clone(), option: "channels", why })
}

/// A rule for the length of what has no time.
fn refuse_rule(raw: &Raw, options: &ReadOptions, layout: Layout) -> Result<()> {
    match options.length {
        None => Ok(()),
        Some(_) => Err(Error::NoTime { file: raw.file.clone(), layout }),
    }
}
