//! Reads CSV recordings: rows are time, columns channels.

use crate::check::rates;
use crate::dataset::precision::Precision;
use crate::formats::clock::Timing;
use crate::formats::stamps::{Mended, Stamp, StampRule, TOO_MANY};
use crate::formats::table::column_kind::numbers_columns;
use crate::formats::table::file_doubts::FileDoubts;
use crate::formats::table::filled_in::NoNumbers;
use crate::formats::table::options::Clock;
use crate::formats::table::recording_columns::RecordingColumns;
use crate::formats::table::text_columns::{TableRow, TableText};
use crate::formats::timed::Timed;
use crate::layout::listing::FoundFiles;
use crate::options::ReadOptions;
use crate::reader::{FileFormat, Format, Recorded};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// Reads files of CSV of which each is one recording; all of a folder share the step of their time stamps.
pub(crate) struct Csv;

impl FileFormat for Csv {
    fn name(&self) -> &'static str {
        "CSV"
    }

    fn format(&self) -> &'static Format {
        &Format {
            name: "CSV recording",
            endings: &["csv"],
            holds: "one recording: rows are time, columns channels, under a header or none; time and indices are no \
                    channels, see [Columns](#columns)",
            becomes: "[C, T], at equal steps where there are time stamps; columns by their names",
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
    // A first line 0,1 numbers the columns if all files have it. If some have not, it is a reading.
    let set = match CsvSet::of(found, options, true)? {
        Some(set) => Some(set),
        None => CsvSet::of(found, options, false)?,
    };
    let set = set.ok_or_else(|| Error::NoSamples { at: at.clone() })?;
    let name = |path: &PathBuf| path.strip_prefix(root).unwrap_or(path).display().to_string();
    let origins = found.files.iter().map(name).collect();
    let Some(first) = set.first else { return Err(Error::NoSamples { at }) };
    if let Some(lossy) = set.precision.lossy() {
        let name = first.names.get(lossy.channel).map_or(String::new(), |name| format!(" {name:?}"));
        return Err(Error::file(at, format!("channel {}{name} {lossy} with table.ignore", lossy.channel)));
    }
    let timing = Timing::of(&set.timed.stamps(), options.stamped);
    if let Some(timing) = timing.filter(|timing| !timing.is_likely()) {
        let how = "say their unit with table.clock, or leave the column out with table.ignore";
        return Err(Error::file(
            at,
            format!("time stamps are {:e} s apart and give no rate; {how}", timing.step),
        ));
    }
    let mut warnings = set.doubts.said();
    warnings.extend(rates::doubts(&at, &set.timed.stamps(), |row| name(&found.files[row])));
    let x = set.timed.into_recordings(timing, &[], &at, options)?;
    let mut read_as = set.read_as;
    read_as.extend(set.mended.said());
    read_as.extend(timing.map(|timing| timing.to_string()));
    Ok(Recorded {
        rate: timing.map(|timing| timing.rate()),
        read_as,
        warnings,
        ignored: set.left_out,
        channel_names: first.names,
        ..Recorded::of(x, "csv".into(), Some(Layout::Series), origins)
    })
}

/// The recordings that were read so far.
#[derive(Default)]
struct CsvSet {
    first: Option<FirstFile>,
    timed: Timed,
    precision: Precision,
    mended: Mended,
    /// How files were read, for the card.
    read_as: Vec<String>,
    /// Columns that are no channels, and why.
    left_out: Vec<String>,
    doubts: FileDoubts,
    /// A file without a header, and one whose first line numbers the columns, were there.
    has_unnamed: bool,
    has_numbered: bool,
}

/// The first file, with which all others have this in common.
struct FirstFile {
    file: String,
    /// Names of the channels; empty without a header.
    names: Vec<String>,
    shape: Vec<usize>,
    has_time: bool,
}

impl CsvSet {
    /// Reads all files. None where the first line of some numbers the columns, which it `may`, and others have no header.
    fn of(found: &FoundFiles, options: &ReadOptions, may: bool) -> Result<Option<Self>> {
        let mut set = Self::default();
        for path in &found.files {
            let table = TableText::of_recording(path, &options.limits, may)?.with_different_names()?;
            set.has_unnamed |= !table.is_named;
            set.has_numbered |= may && is_numbered(&table);
            if set.has_unnamed && set.has_numbered {
                return Ok(None);
            }
            set.add(&table, options)?;
        }
        Ok(Some(set))
    }

    /// Adds the rows of a file as one recording.
    fn add(&mut self, table: &TableText, options: &ReadOptions) -> Result<()> {
        let mut columns = RecordingColumns::of(table, options)?;
        if let Some(first) = &self.first {
            if table.is_named && !first.names.is_empty() {
                columns.arrange(table, &first.names, &first.file)?;
            }
            if columns.time.is_some() != first.has_time {
                let (this, other) = if first.has_time { ("no", "some") } else { ("a", "none") };
                let (file, how) = (&first.file, "use the same columns in all files");
                return Err(
                    table.refuse(format!("has {this} column of time stamps, and {file} has {other}; {how}"))
                );
            }
        }
        self.say(table, &columns);
        let rows = self.rows(table, &columns, options)?;
        let shape = vec![columns.channels.len(), rows];
        let Some(first) = &self.first else {
            let name = |at: &usize| table.header[*at].clone();
            let names = if table.is_named { columns.channels.iter().map(name).collect() } else { vec![] };
            let (file, has_time) = (table.file.clone(), columns.time.is_some());
            self.first = Some(FirstFile { file, names, shape, has_time });
            return Ok(());
        };
        if shape[0] != first.shape[0] {
            let (file, first_shape) = (table.file.clone(), first.shape.clone());
            let hint = " but for time (channels, time): use the same channels throughout";
            return Err(Error::SampleShape { file, shape, first: first.file.clone(), first_shape, hint });
        }
        Ok(())
    }

    /// Says once what is no channel, and what could be read otherwise.
    fn say(&mut self, table: &TableText, columns: &RecordingColumns) {
        let mut said = vec![];
        if let Some((at, clock)) = columns.time {
            said.push(format!("time by {:?} in {}", table.header[at], clock.name()));
        }
        if is_numbered(table) {
            said.push("the first line numbers the columns".into());
        }
        if table.has_decimal_commas() {
            said.push("decimals have commas".into());
        }
        let add = |all: &mut Vec<String>, said: &String| {
            if !all.contains(said) {
                all.push(said.clone());
            }
        };
        said.iter().for_each(|said| add(&mut self.read_as, said));
        columns.left_out.iter().for_each(|said| add(&mut self.left_out, said));
        table.left_out.iter().for_each(|words| self.doubts.add("lines", words.clone()));
        for (number, words) in columns.doubts.iter().enumerate() {
            self.doubts.add(&format!("text {number}"), words.clone());
        }
    }

    /// Reads the rows of a file, and counts them.
    fn rows(
        &mut self,
        table: &TableText,
        columns: &RecordingColumns,
        options: &ReadOptions,
    ) -> Result<usize> {
        let (mut rows, mut rule, mut missing) = (0, StampRule::default(), NoNumbers::default());
        self.timed.width = columns.channels.len();
        table.rows(|row: TableRow| {
            if let Some((at, clock)) = columns.time {
                match rule.push(row.stamp(at)?).map_err(|why| refused_time(&row, at, &why, clock))? {
                    Stamp::Later(stamp) => self.timed.stamps.push(stamp / clock.per_second()),
                    Stamp::Repeated => return Ok(true),
                }
            }
            for (channel, at) in columns.channels.iter().enumerate() {
                let value = row.number(*at)?;
                missing.add(value, || row.place());
                self.precision.see(channel, row.long_number(*at)?, value);
                self.timed.values.push(value);
            }
            rows += 1;
            options.limits.refuse_values(&table.file, self.timed.values.len())?;
            Ok(true)
        })?;
        if rows == 0 {
            return Err(table.refuse("holds a header but no rows; one row per time step".into()));
        }
        if let Some((at, _)) = columns.time {
            let how = format!(
                "write finer stamps, or leave the column out with table.ignore = [{:?}]",
                table.header[at]
            );
            let mended = rule.finish().map_err(|count| table.refuse(format!("{count} {TOO_MANY}; {how}")))?;
            self.mended.add(mended);
        }
        missing.said().iter().for_each(|words| self.doubts.add("NaN", format!("{}: {words}", table.file)));
        self.timed.rows.push(rows);
        Ok(rows)
    }
}

/// Checks whether the first line of a recording numbers its columns.
fn is_numbered(table: &TableText) -> bool {
    table.is_named && numbers_columns(table.header.iter().map(String::as_str))
}

/// Refuses a row whose time is not later than that before.
fn refused_time(row: &TableRow, at: usize, why: &str, clock: Clock) -> Error {
    let (line, table) = (row.line, row.table());
    let (name, unit) = (&table.header[at], clock.name());
    table.refuse(format!(
        "line {line}: the recording {why} (time in {unit}); or leave the column out with table.ignore = [{name:?}]"
    ))
}

#[cfg(test)]
mod tests {
    use crate::options::{Limits, ReadOptions};
    use crate::recordings::recordings;

    fn read(text: &str) -> crate::Result<(Vec<usize>, Vec<f32>)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        std::fs::write(&path, text).unwrap();
        let limits = Limits { max_values: 100, ..Limits::default() };
        let x = recordings(&path, &ReadOptions { limits, ..ReadOptions::default() }, 2)?.x;
        Ok((x.shape()[1..].to_vec(), x.iter().copied().collect()))
    }

    fn refused(text: &str) -> String {
        let message = read(text).err().unwrap().to_string();
        message[message.find("a.csv").unwrap()..].into()
    }

    #[test]
    fn rows_are_time_and_columns_are_channels() {
        let want = (vec![2, 3], vec![1.0, 3.0, 5.0, 2.0, 4.0, 6.5]);
        for text in [
            "1,2\n3,4\n5,6.5\n",
            "1 , 2\r\n3,4\r\n\r\n5,6.5",
            "thumb,index\n1,2\n3,4\n5,6.5",
            "sep=;\n1;2\n3;4\n5;0.65e1",
            "thumb,index,\n1,2,\n3,4,\n5,6.5,\n",
            "\"t,0\",i\n1,2\n3,4\n5,6.5",
            "1;2\n3;4\n5;6.5\n",
            "1\t2\n3\t4\n5\t6.5\n",
            "1;2\n3;4\n5;6,5\n",
            "5V,3V3\n1,2\n3,4\n5,6.5",
            "0,1\n1,2\n3,4\n5,6.5",
            ",0,1\n0,1,2\n1,3,4\n2,5,6.5",
        ] {
            assert_eq!(read(text).unwrap(), want, "{text:?}");
        }
    }

    #[test]
    fn a_broken_table_is_refused_by_line_and_column() {
        assert_eq!(refused("1,2\n3\n"), "a.csv: line 2 has 1 columns, line 1 has 2");
        assert_eq!(refused("a,b\n1,2\n\n3,4,5\n"), "a.csv: line 4 has 3 columns, line 1 has 2");
        assert_eq!(refused("a,b\n1,2\n3,x\n"), "a.csv: line 3, column 2: \"x\" is not a number");
        assert_eq!(refused("1,\n3,4\n"), "a.csv: line 1, column 2: \"\" is not a number");
        for (text, hint) in [
            ("1 2\n3 4\n", "\"1 2\" is a list of numbers; write a column for each"),
            ("a\n\"1,5\"\n\"2,5\"\n", "line 2, column a: \"1,5\" is a number with a decimal comma"),
            ("a,b\n1,2\n1,3 N\n", "\"3 N\" is not a number; write the unit into the name of the column"),
            ("1,a\n2,b\n", "line 1, column 2: \"a\" is not a number"),
        ] {
            let message = refused(text);
            assert!(message.contains(hint), "{message}");
        }
        assert_eq!(refused("a,b\n"), "a.csv: holds a header but no rows; one row per time step");
        assert_eq!(refused("\n\n"), "a.csv: is empty (0 bytes); copy or record it again");
        assert!(refused(&"1,2\n".repeat(51)).contains("more than the 100 values allowed"));
    }
}
