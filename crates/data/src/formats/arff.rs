//! Reads the ARFF files of the UCR and UEA archives: flat ones of one channel, relational ones of several.
//!
//! No crate for ARFF reads relational attributes, and the rest is a line of numbers.

use crate::formats::case::{Case, number};
use crate::{Error, Result};

/// Hands every case to `take`.
///
/// After `@data` a line is a case: `1.5,2.5,class`, or `'1,2\n3,4',class` with the channels in quotes, parted by
/// a backslash and an n. `?` at the end of a channel fills up a shorter series; it is read as NaN.
pub(crate) fn read(text: &str, file: &str, take: &mut dyn FnMut(Case) -> Result<()>) -> Result<()> {
    let mut is_data = false;
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        if line.is_empty() || line.starts_with('%') {
            continue;
        }
        if !is_data {
            is_data = line.eq_ignore_ascii_case("@data");
            continue;
        }
        let no_class = || Error::NoClass { file: file.into(), line: i as u64 };
        let (channels, class) = match line.chars().next().filter(|c| matches!(c, '\'' | '"')) {
            Some(quote) => {
                let (inside, rest) = line[1..].split_once(quote).ok_or_else(no_class)?;
                (inside.split("\\n").collect(), rest.trim_start().strip_prefix(',').ok_or_else(no_class)?)
            }
            None => {
                let (values, class) = line.rsplit_once(',').ok_or_else(no_class)?;
                (vec![values], class)
            }
        };
        let class = class.trim().trim_matches(['\'', '"']).to_string();
        if class.is_empty() || class.contains(',') {
            return Err(no_class());
        }
        let mut column = 0;
        let mut value = |text: &str| {
            column += 1;
            match text.trim() {
                "?" => Ok(f32::NAN),
                text => number(text, file, i, column),
            }
        };
        let channel = |channel: &str| channel.split(',').map(&mut value).collect::<Result<Vec<f32>>>();
        take(Case { class, channels: channels.into_iter().map(channel).collect::<Result<_>>()? })?;
    }
    Ok(())
}
