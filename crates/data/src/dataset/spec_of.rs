//! What one sample of a file is: by the options, the file's own words, the format, or a guess.

use crate::dataset::dataset::refuse_layout;
use crate::dataset::raw::Raw;
use crate::dataset::sample_spec::SampleSpec;
use crate::length::length::Length;
use crate::options::ReadOptions;
use crate::{Error, Result};
use taxel_base::Layout;

/// What the axes of a sample of `shape` are, the channels that are used. Of two words the first of these
/// counts:
///
/// 1. [`ReadOptions::layout`];
/// 2. the file of class names: `layout`;
/// 3. the format: a CSV file and a file of the UCR archive hold a series, an image file an image, grey or in
///    colour, as long as all its planes are used;
/// 4. a guess from rank and type, since arrays do not say what their axes are: [`guess`].
pub(crate) fn layout_of(raw: &Raw, told: Option<Layout>, shape: &[usize]) -> Result<Layout> {
    if let Some(layout) = told {
        refuse_layout(&raw.file, layout, shape)?;
    } else if let Some(layout) = raw.facts.layout {
        refuse_layout(&raw.facts.file, layout, shape)?;
    }
    Ok(likeliest(told, raw.facts.layout, raw.format, &raw.dtype, shape))
}

/// The axis along which samples may differ in length: time, whatever says what the axes are.
pub(crate) fn time_axis(
    told: Option<Layout>,
    fact: Option<Layout>,
    format: Option<Layout>,
    dtype: &str,
    shape: &[usize],
) -> Option<usize> {
    likeliest(told, fact, format, dtype, shape).time_axis()
}

/// The first of these that fits, or else a guess.
fn likeliest(
    told: Option<Layout>,
    fact: Option<Layout>,
    format: Option<Layout>,
    dtype: &str,
    shape: &[usize],
) -> Layout {
    let said = [told, fact, format].into_iter().flatten().find(|layout| layout.fits(shape));
    said.unwrap_or_else(|| guess(shape.len(), dtype))
}

/// What a sample of `shape` is, whose recordings had these `lengths` before the rule.
///
/// Resampling changes the rate: `to` readings take the time of the recording. It is known where all recordings
/// are equally long, and no one number otherwise.
pub(crate) fn spec_of(
    raw: &Raw,
    options: &ReadOptions,
    layout: Layout,
    shape: &[usize],
    rule: Option<Length>,
    lengths: &[usize],
) -> Result<SampleSpec> {
    if options.rate.is_some_and(|rate| !(rate > 0.0 && rate.is_finite())) {
        let (file, why) = (raw.file.clone(), "is in readings per second (Hz), above 0");
        return Err(Error::Option { file, option: "rate", why });
    }
    let recorded = options.rate.or(raw.facts.rate);
    let rate = match (rule, lengths) {
        (Some(Length::Resample { to }), [length, ..]) => {
            let is_one = *length > 1 && lengths.iter().all(|own| own == length);
            recorded.filter(|_| is_one).map(|rate| rate * (to - 1) as f64 / (*length - 1) as f64)
        }
        _ => recorded,
    };
    Ok(SampleSpec {
        channels: options.channels.clone(),
        length: rule,
        topics: raw.topics.clone(),
        table: raw.table.clone(),
        unit: raw.facts.unit.clone(),
        rate,
        stamped: raw.facts.stamped,
        full_scale: raw.facts.full_scale,
        ..SampleSpec::new(layout, shape)
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
