//! Takes the values at rest off recordings.

use crate::dataset::raw::Raw;
use crate::dataset::spec_of::likeliest_layout;
use crate::error::plural;
use crate::formats::archive::Archive;
use crate::formats::npy::Cap;
use crate::length::ragged::Ragged;
use crate::options::{ReadOptions, refuse_set};
use crate::tare::Tare;
use crate::{Error, Result};
use taxel_base::Layout;

/// Takes the resting values off recordings that were read; those of an array have been taken off already.
pub(crate) fn tare(raw: &mut Raw, options: &ReadOptions) -> Result<()> {
    let steps = match &options.tare {
        None => return Ok(()),
        Some(Tare::Array(_)) => {
            let why = "names an array beside samples of a file of arrays, of which there are none; write recording:N for the \
                       mean of the first N readings";
            return refuse_set(&raw.file, &[("tare", raw.tared.is_none())], why);
        }
        Some(Tare::Recording { steps }) => *steps,
    };
    let layout =
        likeliest_layout([options.layout, raw.facts.layout, raw.format], &raw.dtype, raw.x.sample_shape());
    let why = "is the mean of the first readings of a recording, and these samples have no time; name an array of resting \
               values with array:NAME, or the recording of each row with recording = \"...\"";
    refuse_set(&raw.file, &[("tare", layout.time_axis().is_none())], why)?;
    let Some(axis) = layout.time_axis() else { return Ok(()) };
    if let Some(short) = raw.x.lengths(axis).iter().position(|length| *length < steps) {
        let (sample, length) = (raw.sample_name(short), raw.x.lengths(axis)[short]);
        let why =
            format!("has {}, and tare is the mean of the first {steps}; lower it", plural(length, "reading"));
        return Err(Error::file(sample, why));
    }
    raw.x = std::mem::take(&mut raw.x).tared(axis, steps);
    raw.tared = options.tare.clone();
    Ok(())
}

/// Takes the resting values of an array off samples: `[N, C]` off `[N, C, T]`, `[N, H, W]` off `[N, T, H, W]`, and those of the
/// samples' shape off each value. Also returns what was taken off.
pub(crate) fn tare_by_array(
    x: Ragged,
    [option, file]: [Option<Layout>; 2],
    dtype: &str,
    archive: &mut Archive,
    options: &ReadOptions,
) -> Result<(Ragged, Option<Tare>)> {
    let Some(Tare::Array(name)) = &options.tare else { return Ok((x, None)) };
    let rest = archive.with(name, "tare", |header, reader, at| {
        header.read_f32(reader, at, Cap::of_samples(&options.limits))
    })?;
    let layout = likeliest_layout([option, file, None], dtype, x.sample_shape());
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
    let rest: Vec<f32> = rest.iter().copied().collect();
    Ok((x.less(&rest, time), options.tare.clone()))
}
