//! What one sample of a file is: by the options, the file's own words, the format, or a guess.

use crate::dataset::refuse_layout;
use crate::options::Options;
use crate::raw::Raw;
use crate::reading::Reading;
use crate::{Error, Result};
use taxel_encodings::Layout;

/// What a sample of `shape` is, the channels that are used. Of two words the first of these counts:
///
/// 1. [`Options::layout`] and [`Options::rate`];
/// 2. the file of class names: `layout`, `rate`, `unit`, `full_scale`;
/// 3. the format: a CSV file and a file of the UCR archive hold a series, an image file an image, grey or in
///    colour, as long as all its planes are used;
/// 4. a guess from rank and type, since arrays do not say what their axes are: [`guess`].
pub(crate) fn reading(raw: &Raw, options: &Options, shape: &[usize]) -> Result<Reading> {
    let layout = if let Some(layout) = options.layout {
        refuse_layout(&raw.file, layout, shape)?;
        layout
    } else if let Some(layout) = raw.facts.layout {
        refuse_layout(&raw.facts.file, layout, shape)?;
        layout
    } else {
        raw.format.filter(|layout| layout.fits(shape)).unwrap_or_else(|| guess(shape.len(), &raw.dtype))
    };
    if options.rate.is_some_and(|rate| !(rate > 0.0 && rate.is_finite())) {
        let (file, why) = (raw.file.clone(), "is in readings per second (Hz), above 0");
        return Err(Error::Option { file, option: "rate", why });
    }
    Ok(Reading {
        channels: options.channels.clone(),
        unit: raw.facts.unit.clone(),
        rate: options.rate.or(raw.facts.rate),
        full_scale: raw.facts.full_scale,
        ..Reading::new(layout, shape)
    })
}

/// The usual axes of so many: features, channels over time, an array of taxels over time; bytes on two axes
/// are an image.
fn guess(rank: usize, dtype: &str) -> Layout {
    match rank {
        1 => Layout::Features,
        2 if dtype.ends_with("u1") => Layout::Image,
        2 => Layout::Series,
        _ => Layout::Sequence,
    }
}
