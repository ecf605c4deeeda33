//! Finds the description of the samples of a file: from the options, the file of names, the format, or by a guess.

use crate::Result;
use crate::dataset::dataset::refuse_layout;
use crate::dataset::raw::Raw;
use crate::dataset::sample_spec::SampleSpec;
use crate::dataset::validate::is_by_name;
use crate::length::length::Length;
use crate::options::{ReadOptions, refuse_set};
use taxel_base::Layout;

/// Returns the axes of a sample of `shape`, with the channels that are used. The first of these counts:
///
/// 1. [`ReadOptions::layout`];
/// 2. the file of class names: `layout`;
/// 3. the format: a CSV file and a file of the UCR archive hold a series, an image file an image, grey or in
///    colour, as long as all its planes are used;
/// 4. a guess from rank and type, since arrays do not say what their axes are: [`guess`].
pub(crate) fn layout_of(raw: &Raw, given: Option<Layout>, shape: &[usize]) -> Result<Layout> {
    if let Some(layout) = given {
        refuse_layout(&raw.file, layout, shape)?;
    } else if let Some(layout) = raw.facts.layout {
        refuse_layout(&raw.facts.file, layout, shape)?;
    }
    Ok(likeliest_layout([given, raw.facts.layout, raw.format], &raw.dtype, shape))
}

/// Returns the first layout of options, file of names and format that fits the shape, or else a guess.
pub(crate) fn likeliest_layout(given: [Option<Layout>; 3], dtype: &str, shape: &[usize]) -> Layout {
    let fitting = given.into_iter().flatten().find(|layout| layout.fits(shape));
    fitting.unwrap_or_else(|| guess(shape.len(), dtype))
}

/// Describes a sample of `shape` whose recordings had these `lengths` before the rule.
///
/// Resampling changes the rate: `to` time steps take the time of the recording. The new rate is known only where all
/// recordings are equally long.
pub(crate) fn spec_of(
    raw: &Raw,
    options: &ReadOptions,
    layout: Layout,
    shape: &[usize],
    rule: Option<Length>,
    lengths: &[usize],
) -> Result<SampleSpec> {
    let is_no_rate = options.rate.is_some_and(|rate| !(rate > 0.0 && rate.is_finite()));
    refuse_set(&raw.file, &[("rate", is_no_rate)], "is in readings per second (Hz), above 0")?;
    let recorded = options.rate.or(raw.facts.rate);
    let rate = match (rule, lengths) {
        (Some(Length::Resample { to }), [length, ..]) => {
            let is_equal = *length > 1 && lengths.iter().all(|other| other == length);
            recorded.filter(|_| is_equal).map(|rate| rate * (to - 1) as f64 / (*length - 1) as f64)
        }
        _ => recorded,
    };
    let channel_names = match &options.channels {
        _ if is_by_name(raw, options) => options.channel_names.clone(),
        Some(kept) => kept.iter().filter_map(|channel| raw.channel_names.get(*channel).cloned()).collect(),
        None => raw.channel_names.clone(),
    };
    Ok(SampleSpec {
        channel_names,
        channels: options.channels.clone(),
        length: rule,
        topics: raw.topics.clone(),
        table: raw.table.clone(),
        recording: raw.recording.clone(),
        tare: raw.tared.clone(),
        unit: raw.facts.unit.clone(),
        rate,
        stamped: raw.facts.stamped,
        full_scale: raw.facts.full_scale,
        depth: raw.facts.depth,
        overruled: overruled(raw, options, layout),
        ..SampleSpec::new(layout, shape)
    })
}

/// Lists the facts that the options said against the files.
fn overruled(raw: &Raw, options: &ReadOptions, layout: Layout) -> Vec<String> {
    let rate = options.rate.zip(raw.facts.rate).is_some_and(|(said, known)| said != known);
    let axes = raw.facts.layout.is_some_and(|known| known != layout);
    let named = [(rate, "rate"), (axes, "layout")];
    named.into_iter().filter(|(is_said, _)| *is_said).map(|(_, name)| name.into()).collect()
}

/// Guesses the axes of a sample: features, channels over time, an array of taxels over time; bytes on two axes are an
/// image.
fn guess(rank: usize, dtype: &str) -> Layout {
    match rank {
        1 => Layout::Features,
        2 if dtype.ends_with("u1") => Layout::Image,
        2 => Layout::Series,
        _ => Layout::Sequence,
    }
}
