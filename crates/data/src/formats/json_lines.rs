//! Reads recordings in JSON Lines, a time step per line: an object of columns by name, or an array of numbers.

use crate::dataset::channel_names::numbered;
use crate::dataset::precision::Precision;
use crate::formats::clock::Timing;
use crate::formats::json_numbers::JsonNumbers;
use crate::formats::stamps::{Mended, Stamp, StampRule, TOO_MANY};
use crate::formats::table::options::Clock;
use crate::formats::text::read_text;
use crate::formats::timed::Timed;
use crate::layout::listing::FoundFiles;
use crate::options::ReadOptions;
use crate::reader::{FileFormat, Format, Recorded};
use crate::{Error, Result};
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::path::Path;
use taxel_base::Layout;

/// Most numbers of a line of a file that is not damaged.
const MAX_NUMBERS: usize = 1 << 16;

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
            holds: "one recording, a time step per line: `{\"t\": 0.01, \"taxels\": [1, 2]}` or `[1, 2]`; a key `time`, \
                    `timestamp` or `t` as in [Tables](#tables), texts are passed over",
            becomes: "[C, T] at equal steps, columns in the order of the first line",
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
    let (mut timed, mut columns, mut origins) = (Timed::default(), None, vec![]);
    let (mut mended, mut precision) = (Mended::default(), Precision::default());
    for path in &found.files {
        let text = read_text(path, &options.limits)?;
        let file = File { name: path.display().to_string(), text: &text };
        mended.add(file.add(&mut columns, &mut timed, &mut precision, options)?);
        origins.push(path.strip_prefix(root).unwrap_or(path).display().to_string());
    }
    let Some(columns) = columns else { return Err(Error::NoSamples { at }) };
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
    let x = timed.into_recordings(timing, &[], &at, options)?;
    let mut read_as = vec![format!("lines of JSON: {}", columns.described())];
    read_as.extend(mended.said());
    read_as.extend(timing.map(|timing| timing.to_string()));
    Ok(Recorded {
        rate: timing.map(|timing| timing.rate()),
        read_as,
        channel_names,
        ..Recorded::of(x, "json".into(), Some(Layout::Series), origins)
    })
}

/// The columns of a line: names and number of values of each; an array is one column without a name.
#[derive(PartialEq)]
struct LineColumns {
    names: Vec<(String, usize)>,
    /// The column of time stamps, and their unit.
    time: Option<(usize, Clock)>,
}

impl LineColumns {
    fn of(line: &TimeStep) -> Self {
        let time = line.names.iter().enumerate().filter(|(_, (_, count))| *count == 1);
        let time = time.filter_map(|(at, (name, _))| Some((at, Clock::of_column(name)?))).next();
        Self { names: line.names.clone(), time }
    }

    /// Counts the numbers before a column.
    fn start(&self, column: usize) -> usize {
        self.names[..column].iter().map(|(_, count)| count).sum()
    }

    fn width(&self) -> usize {
        self.start(self.names.len()) - usize::from(self.time.is_some())
    }

    /// Returns the names of the channels; empty where a line is an array.
    fn channel_names(&self) -> Vec<String> {
        let is_time = |at: usize| self.time.is_some_and(|(time, _)| time == at);
        let columns = self.names.iter().enumerate().filter(|(at, _)| !is_time(*at));
        numbered(columns.map(|(_, (name, count))| (name.as_str(), *count)))
    }

    fn described(&self) -> String {
        let time = self.time.map_or(String::new(), |(at, clock)| {
            format!(", time by {:?} in {}", self.names[at].0, clock.name())
        });
        format!("{}{time}", crate::error::plural(self.width(), "channel"))
    }
}

struct File<'t> {
    name: String,
    text: &'t str,
}

impl File<'_> {
    fn refuse(&self, line: usize, why: impl fmt::Display) -> Error {
        Error::file(&self.name, format!("line {line}: {why}"))
    }

    /// Adds the lines of the file as one recording. Returns what was done about its stamps.
    fn add(
        &self,
        columns: &mut Option<LineColumns>,
        timed: &mut Timed,
        precision: &mut Precision,
        options: &ReadOptions,
    ) -> Result<Mended> {
        let (mut rows, mut rule) = (0, StampRule::default());
        let lines = self.text.lines().enumerate().map(|(at, text)| (at + 1, text.trim()));
        for (at, text) in lines.filter(|(_, text)| !text.is_empty()) {
            let line: TimeStep =
                serde_json::from_str(text).map_err(|e| self.refuse(at, format!("is no time step ({e})")))?;
            let columns = columns.get_or_insert_with(|| LineColumns::of(&line));
            if columns.width() == 0 {
                return Err(self.refuse(at, "holds no numbers; write one per channel"));
            }
            if line.names != columns.names {
                let why =
                    "has other keys, or other counts of numbers, than the first line; write the same in each";
                return Err(self.refuse(at, why));
            }
            timed.width = columns.width();
            let time = columns.time.map(|(column, clock)| (columns.start(column), clock));
            if let Some((place, clock)) = time {
                let stamp = line.numbers[place];
                if !stamp.is_finite() {
                    return Err(self.refuse(at, "has no time stamp"));
                }
                let pushed =
                    rule.push(stamp).map_err(|why| self.refuse(at, format!("the recording {why}")))?;
                match pushed {
                    Stamp::Later(stamp) => timed.stamps.push(stamp / clock.per_second()),
                    Stamp::Repeated => continue,
                }
            }
            let others =
                line.numbers.iter().enumerate().filter(|(at, _)| time.is_none_or(|(time, _)| *at != time));
            timed
                .values
                .extend(others.enumerate().map(|(channel, (_, value))| precision.rounded(channel, *value)));
            rows += 1;
            options.limits.refuse_values(&self.name, timed.values.len())?;
        }
        if rows == 0 {
            return Err(Error::EmptyFile { file: self.name.clone() });
        }
        timed.rows.push(rows);
        let refuse =
            |count| Error::file(&self.name, format!("{count} {TOO_MANY}; write finer stamps, or none"));
        rule.finish().map_err(refuse)
    }
}

/// The numbers of one line, column after column.
#[derive(Default)]
struct TimeStep {
    names: Vec<(String, usize)>,
    numbers: Vec<f64>,
}

impl TimeStep {
    fn reader(&mut self) -> JsonNumbers<'_> {
        JsonNumbers { out: &mut self.numbers, most: MAX_NUMBERS }
    }
}

impl<'de> Deserialize<'de> for TimeStep {
    fn deserialize<D: Deserializer<'de>>(reader: D) -> Result<Self, D::Error> {
        reader.deserialize_any(LineVisitor)
    }
}

struct LineVisitor;

impl<'de> Visitor<'de> for LineVisitor {
    type Value = TimeStep;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object of numbers or an array of numbers")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TimeStep, A::Error> {
        let mut line = TimeStep::default();
        while let Some(name) = map.next_key::<String>()? {
            let before = line.numbers.len();
            map.next_value_seed(line.reader())?;
            // Texts are for people.
            let count = line.numbers.len() - before;
            line.names.extend((count > 0).then_some((name, count)));
        }
        Ok(line)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<TimeStep, A::Error> {
        let mut line = TimeStep::default();
        while list.next_element_seed(line.reader())?.is_some() {}
        line.names = vec![(String::new(), line.numbers.len())];
        Ok(line)
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
            ("{\"a\": 1}\n{\"b\": 1}\n", "1.jsonl: line 2: has other keys"),
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
