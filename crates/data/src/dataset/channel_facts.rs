//! Names the channels as the file of names beside the data says.

use crate::dataset::channel_names::listed;
use crate::dataset::raw::Raw;
use crate::dataset::spec_of::likeliest_layout;
use crate::error::plural;
use crate::options::ReadOptions;
use crate::{Error, Result};

/// Takes the names of the channels from the file of names, where the data have none. They are as many as the first axis of a
/// sample is long, or as a time step has values.
pub(crate) fn name_channels(raw: &mut Raw, options: &ReadOptions) -> Result<()> {
    let Some(names) = raw.facts.channels.take().filter(|names| !names.is_empty()) else { return Ok(()) };
    let refuse = |value: String, wanted: String| {
        Err(Error::Fact { at: raw.facts.file.clone(), key: "channels", value, wanted })
    };
    if let Some(twice) =
        names.iter().enumerate().find(|(at, name)| names[..*at].contains(name)).map(|(_, name)| name)
    {
        return refuse(format!("{twice:?} twice"), "and a name is of one channel".into());
    }
    if !raw.channel_names.is_empty() {
        if raw.channel_names == names {
            return Ok(());
        }
        return refuse(listed(&names), format!("and the data name them {}", listed(&raw.channel_names)));
    }
    let shape = raw.x.sample_shape();
    let time =
        likeliest_layout([options.layout, raw.facts.layout, raw.format], &raw.dtype, shape).time_axis();
    let others = shape.iter().enumerate().filter(|(axis, _)| Some(*axis) != time).map(|(_, length)| *length);
    let each: usize = others.product();
    let first = shape.first().copied().filter(|_| time != Some(0)).unwrap_or(each);
    if names.len() != first && names.len() != each {
        // Of several fingers with the same channels each name would be of many.
        if shape.iter().enumerate().any(|(axis, length)| Some(axis) != time && *length == names.len()) {
            return Ok(());
        }
        return refuse(plural(names.len(), "name"), format!("and samples have {}", plural(first, "channel")));
    }
    raw.channel_names = names;
    Ok(())
}
