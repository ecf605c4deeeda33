//! Reads recordings in JSON Lines, a time step per line: an object of columns by name, or an array of numbers.

use crate::check::rates;
use crate::dataset::precision::{Precision, is_rounded_whole};
use crate::formats::clock::Timing;
use crate::formats::json_columns::JsonColumns;
use crate::formats::json_time_step::TimeStep;
use crate::formats::stamps::{Mended, Stamp, StampRule, TOO_MANY};
use crate::formats::text::read_text;
use crate::formats::timed::Timed;
use crate::layout::listing::FoundFiles;
use crate::options::ReadOptions;
use crate::reader::{FileFormat, Format, Recorded};
use crate::{Error, Result};
use std::fmt;
use std::path::Path;
use taxel_base::Layout;

/// Reads files of which each is one recording; all of a folder share the step of their time stamps.
pub(crate) struct JsonLines;

impl FileFormat for JsonLines {
    fn name(&self) -> &'static str {
        "JSON Lines"
    }

    fn format(&self) -> &'static Format {
        &Format {
            name: "JSON Lines",
            endings: &["jsonl", "ndjson"],
            holds: "one recording, a time step per line: `{\"t\": 0.01, \"taxels\": [1, 2]}` or `[1, 2]`; keys are columns, see \
                    [Columns](#columns), texts are passed over",
            becomes: "[C, T] at equal steps, keys in the order of the first line",
        }
    }

    fn layout(&self, _: usize) -> Option<Layout> {
        Some(Layout::Series)
    }

    fn read_together(
        &self,
        root: &Path,
        found: &FoundFiles,
        options: &ReadOptions,
    ) -> Option<Result<Recorded>> {
        Some(read(root, found, options))
    }
}

fn read(root: &Path, found: &FoundFiles, options: &ReadOptions) -> Result<Recorded> {
    let at = root.display().to_string();
    let (mut set, mut origins) = (JsonSet::default(), vec![]);
    for path in &found.files {
        let text = read_text(path, &options.limits)?;
        let file = File { name: path.display().to_string(), text: &text };
        set.add(&file, options)?;
        origins.push(path.strip_prefix(root).unwrap_or(path).display().to_string());
    }
    let JsonSet { columns: Some(columns), timed, precision, mended } = set else {
        return Err(Error::NoSamples { at });
    };
    let channel_names = columns.channel_names();
    if let Some(lossy) = precision.lossy() {
        let name = channel_names.get(lossy.channel).map_or("", String::as_str);
        return Err(Error::file(at, format!("channel {} {name:?} {lossy}", lossy.channel)));
    }
    let timing = Timing::of(&timed.stamps(), options.stamped);
    if timing.is_some_and(|timing| !timing.is_likely()) {
        let why = "its time stamps give no rate; end the key of the time with its unit, such as t_ms";
        return Err(Error::file(at, why));
    }
    let first = found.files.first().map_or(String::new(), |path| path.display().to_string());
    let mut warnings: Vec<String> = columns.doubts.iter().map(|words| format!("{first}: {words}")).collect();
    warnings.extend(rates::doubts(&at, &timed.stamps(), |row| origins[row].clone()));
    let x = timed.into_recordings(timing, &[], &at, options)?;
    let mut read_as = vec![format!("lines of JSON: {}", columns.described())];
    read_as.extend(mended.said());
    read_as.extend(timing.map(|timing| timing.to_string()));
    Ok(Recorded {
        rate: timing.map(|timing| timing.rate()),
        read_as,
        warnings,
        channel_names,
        ignored: columns.left_out,
        ..Recorded::of(x, "json".into(), Some(Layout::Series), origins)
    })
}

/// The recordings that were read so far.
#[derive(Default)]
struct JsonSet {
    columns: Option<JsonColumns>,
    timed: Timed,
    precision: Precision,
    mended: Mended,
}

struct File<'t> {
    name: String,
    text: &'t str,
}

impl File<'_> {
    fn refuse(&self, line: usize, why: impl fmt::Display) -> Error {
        Error::file(&self.name, format!("line {line}: {why}"))
    }

    /// Reads the lines that are not blank, with their numbers.
    fn steps(&self) -> impl Iterator<Item = Result<(usize, TimeStep)>> {
        let lines = self.text.lines().enumerate().map(|(at, text)| (at + 1, text.trim()));
        lines.filter(|(_, text)| !text.is_empty()).map(|(at, text)| match serde_json::from_str(text) {
            Ok(step) => Ok((at, step)),
            Err(e) => Err(self.refuse(at, format!("is no time step ({e})"))),
        })
    }
}

impl JsonSet {
    /// Adds the lines of a file as one recording.
    fn add(&mut self, file: &File, options: &ReadOptions) -> Result<()> {
        let columns = match self.columns.take() {
            Some(columns) => columns,
            None => JsonColumns::of(file.steps(), &options.table, &options.channel_names)?
                .map_err(|why| Error::file(&file.name, why))?,
        };
        let (mut rows, mut rule) = (0, StampRule::default());
        for step in file.steps() {
            let (line, mut step) = step?;
            if columns.width() == 0 {
                return Err(file.refuse(line, "holds no numbers; write one per channel"));
            }
            step.arrange(&columns.names).map_err(|why| file.refuse(line, why))?;
            self.timed.width = columns.width();
            if let Some((stamp, clock)) = columns.stamp(&step) {
                let stamp = stamp.filter(|stamp| stamp.is_finite());
                let stamp = stamp.ok_or_else(|| file.refuse(line, "has no time stamp"))?;
                let pushed =
                    rule.push(stamp).map_err(|why| file.refuse(line, format!("the recording {why}")))?;
                match pushed {
                    Stamp::Later(stamp) => self.timed.stamps.push(stamp / clock.per_second()),
                    Stamp::Repeated => continue,
                }
            }
            for (channel, value) in columns.values(&step).enumerate() {
                if is_rounded_whole(value) {
                    let why = "does not fit f32 (integers to 2^24 = 16777216); subtract an offset, or name a key that is \
                               no channel with table.ignore";
                    let names = columns.channel_names();
                    let name = names.get(channel).map_or("", String::as_str);
                    return Err(file.refuse(line, format!("{name} {value} {why}")));
                }
                self.timed.values.push(self.precision.rounded(channel, value));
            }
            rows += 1;
            options.limits.refuse_values(&file.name, self.timed.values.len())?;
        }
        if rows == 0 {
            return Err(Error::EmptyFile { file: file.name.clone() });
        }
        self.columns = Some(columns);
        self.timed.rows.push(rows);
        let refuse =
            |count| Error::file(&file.name, format!("{count} {TOO_MANY}; write finer stamps, or none"));
        self.mended.add(rule.finish().map_err(refuse)?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::{ReadOptions, load, recordings};

    /// Makes a folder of a class `soft` and a class `hard`, a recording each.
    fn set(text: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for class in ["soft", "hard"] {
            std::fs::create_dir(folder.path().join(class)).unwrap();
            std::fs::write(folder.path().join(class).join("1.jsonl"), text).unwrap();
        }
        folder
    }

    #[test]
    fn keys_are_columns_and_time_gives_the_rate() {
        let folder = set("{\"t\": 0, \"id\": \"a\", \"taxels\": [1, 2], \"force\": 3}\n\n\
                          {\"t\": 0.01, \"id\": \"b\", \"taxels\": [4, 5], \"force\": 6}\n");
        let data = load(folder.path(), &ReadOptions::default()).unwrap();
        assert_eq!((data.x.shape(), data.spec.rate), (&[2, 3, 2][..], Some(100.0)));
        assert_eq!(data.x.as_slice().unwrap()[..6], [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
        let one = recordings(&folder.path().join("soft/1.jsonl"), &ReadOptions::default(), 2).unwrap();
        assert_eq!((one.x.shape(), one.origins.as_slice()), (&[1, 3, 2][..], &["1.jsonl".to_string()][..]));
    }

    #[test]
    fn lines_of_arrays_have_no_time() {
        let data = load(set("[1, 2]\n[3, 4]\n[5, 6]").path(), &ReadOptions::default()).unwrap();
        assert_eq!((data.x.shape(), data.spec.rate), (&[2, 2, 3][..], None));
    }

    #[test]
    fn what_is_no_recording_is_refused_by_line() {
        for (text, why) in [
            ("{\"a\": 1}\n{\"b\": 1}\n", "1.jsonl: line 2: has no number under \"a\""),
            (
                "{\"t\": 1, \"a\": 1}\n{\"t\": 1, \"a\": 1}\n",
                "1.jsonl: 1 of the 2 time steps repeat the stamp",
            ),
            (
                "{\"t\": 1, \"a\": 1}\n{\"t\": 0, \"a\": 1}\n",
                "1.jsonl: line 2: the recording begins again: its time",
            ),
            ("{\"t\": 1}\n", "1.jsonl: line 1: holds no numbers"),
            ("[1, {}]\n", "1.jsonl: line 1: is no time step"),
            ("\n\n", "1.jsonl: is empty"),
        ] {
            let message = load(set(text).path(), &ReadOptions::default()).unwrap_err().to_string();
            assert!(message.contains(why), "{message}");
        }
    }
}
