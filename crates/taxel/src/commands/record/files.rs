//! The files of recordings: written, and read back as every command will.

use std::fmt::Write;
use std::path::Path;

use clap::ValueEnum;
use taxel::data::{Layout, ReadOptions, whole_recordings};

use super::take::Taken;

/// Kind of the files that recordings are written as.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum FileKind {
    /// Text: a header, then a line for each time step.
    #[default]
    Csv,
    /// A bag, as ROS 2 records them: JSON messages of one topic.
    #[cfg(feature = "lab")]
    Mcap,
}

impl FileKind {
    /// Returns the ending of its files, which is its name in `labels.json`.
    pub fn ending(self) -> &'static str {
        match self {
            FileKind::Csv => "csv",
            #[cfg(feature = "lab")]
            FileKind::Mcap => "mcap",
        }
    }

    /// Returns the kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::value_variants().iter().copied().find(|kind| kind.ending() == name)
    }

    /// Returns the content of a file; `began` is in seconds since 1970.
    pub fn bytes(self, channels: &[String], taken: &Taken, began: f64) -> Result<Vec<u8>, String> {
        match self {
            FileKind::Csv => {
                let _ = began;
                Ok(csv(channels, taken).into_bytes())
            }
            #[cfg(feature = "lab")]
            FileKind::Mcap => {
                let began = (1e3 * began).round() as u64 * 1_000_000;
                taxel::data::bag_bytes(channels, &taken.times, &taken.values, began)
                    .map_err(|error| error.to_string())
            }
        }
    }
}

/// Writes a recording as CSV: time in seconds, then the channels.
fn csv(channels: &[String], taken: &Taken) -> String {
    let quoted = |name: &String| {
        let needs = name.contains([',', '"', ';', '\t']) || name.trim() != name;
        if needs { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.clone() }
    };
    let names: Vec<String> = channels.iter().map(quoted).collect();
    let mut text = format!("time,{}\n", names.join(","));
    for (time, row) in taken.times.iter().zip(taken.values.chunks_exact(channels.len().max(1))) {
        let _ = write!(text, "{time}");
        row.iter().for_each(|value| {
            let _ = write!(text, ",{value}");
        });
        text.push('\n');
    }
    text
}

/// Reads a recording as every command will, and compares it; says why it differs and how to fix it.
pub fn read_back(path: &Path, channels: &[String], taken: &Taken) -> Result<(), String> {
    let options = ReadOptions { layout: Some(Layout::Series), ..ReadOptions::default() };
    let (all, facts) = whole_recordings(path, &options, 2).map_err(|e| e.to_string())?;
    let odd = |what: String| Err(format!("{what}; please report it"));
    let [one] = all.as_slice() else { return odd(format!("{} recordings", all.len())) };
    if let Some(name) = channels.iter().find(|name| !facts.channel_names.contains(name)) {
        return Err(format!(
            "the channel {name:?} is left out, as a column of time or a counter: readers take it for one by its name and its whole \
             numbers; give it another name at the source, such as \"{name}_finger\""
        ));
    }
    if facts.channel_names != channels {
        return odd(format!("its channels are {}", facts.channel_names.join(", ")));
    }
    if one.shape != [channels.len(), taken.times.len()] {
        return odd(format!("its shape is {:?}", one.shape));
    }
    let rows = taken.times.len();
    let is_equal =
        |(i, value): (usize, &f32)| one.values[(i % channels.len()) * rows + i / channels.len()] == *value;
    if taken.values.iter().enumerate().all(is_equal) { Ok(()) } else { odd("its values differ".into()) }
}
