//! Takes the values at rest off recordings.

use crate::dataset::raw::Raw;
use crate::dataset::spec_of::likeliest_layout;
use crate::error::plural;
use crate::formats::archive::Archive;
use crate::formats::npy::Cap;
use crate::length::ragged::Ragged;
use crate::options::ReadOptions;
use crate::tare::Tare;
use crate::{Error, Result};
use taxel_base::Layout;

/// Takes the mean of its first `steps` readings off each recording; `given` are the axes of a sample as the options say them.
pub(crate) fn tare_by_readings(raw: &mut Raw, steps: usize, given: Option<Layout>) -> Result<()> {
    let layout = likeliest_layout([given, raw.facts.layout, raw.format], &raw.dtype, raw.x.sample_shape());
    let Some(axis) = layout.time_axis() else {
        let why = "is the mean of the first readings of a recording, and these samples have no time; name an array of resting \
                   values with array:NAME, or the recording of each row with recording = \"...\"";
        return Err(Error::Option { file: raw.file.clone(), option: "tare", why });
    };
    let lengths = raw.x.lengths(axis);
    if let Some(short) = lengths.iter().position(|length| *length < steps) {
        let held = plural(lengths[short], "reading");
        let why = format!("has {held}, and tare is the mean of the first {steps}; lower it");
        return Err(Error::file(raw.sample_name(short), why));
    }
    let levels = raw.x.first_means(axis, steps);
    raw.x = std::mem::take(&mut raw.x).less(&levels, Some(axis));
    raw.tared = Some(Tare::Recording { steps });
    Ok(())
}

/// Takes the resting values of an array off samples: `[N, C]` off `[N, C, T]`, `[N, H, W]` off `[N, T, H, W]`, and those of the
/// samples' shape off each value; `layout` is that of the file of names.
pub(crate) fn tare_by_array(
    x: Ragged,
    name: &str,
    layout: Option<Layout>,
    dtype: &str,
    archive: &mut Archive,
    options: &ReadOptions,
) -> Result<Ragged> {
    let rest = archive.with(name, "tare", |header, reader, at| {
        header.read_f32(reader, at, Cap::of_samples(&options.limits), 1)
    })?;
    let layout = likeliest_layout([options.layout, layout, None], dtype, x.sample_shape());
    let time = layout.time_axis().filter(|_| rest.shape() != x.shape());
    let mut shape = x.shape();
    if let Some(axis) = time {
        shape.remove(axis + 1);
    }
    if rest.shape() != shape {
        let (at, shape) = (archive.at(name), archive.shape(name));
        let wanted = "resting values have the shape of x, or that without time: [N, C] beside [N, C, T]";
        return Err(Error::Shape { at, shape, wanted });
    }
    let levels: Vec<f64> = rest.iter().map(|level| f64::from(*level)).collect();
    Ok(x.less(&levels, time))
}
