//! Reads one CSV recording: rows are time, columns channels.

use crate::formats::csv_text::CsvText;
use crate::formats::text::csv_reader;
use crate::options::ReadOptions;
use crate::reader::{FileFormat, Format, Sample};
use crate::{Error, Result};
use std::path::Path;
use taxel_base::Layout;

/// Reads files of CSV of which each is one recording.
pub(crate) struct Csv;

impl FileFormat for Csv {
    fn name(&self) -> &'static str {
        "CSV"
    }

    fn format(&self) -> &'static Format {
        &Format {
            name: "CSV recording",
            endings: &["csv"],
            holds: "one recording: rows are time, columns channels, under a header or none",
            becomes: "[C, T]",
        }
    }

    fn layout(&self, _: usize) -> Option<Layout> {
        Some(Layout::Series)
    }

    fn hint(&self) -> &'static str {
        " but for time (channels, time): use the same channels throughout"
    }

    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Sample> {
        let table = CsvText::read(path, &options.limits)?;
        read(&table, &path.display().to_string(), options.limits.max_values)
    }
}

/// Reads a `table` as one sample `[channels, time]`.
///
/// Columns are separated by commas, or as the file says (`sep=;`). A first row without any number is a header. `file` is for
/// messages, `limit` the most values allowed.
fn read(table: &CsvText, file: &str, limit: u64) -> Result<Sample> {
    let text = &table.text;
    let mut reader = csv_reader(text, table.said.unwrap_or(b','), false);
    let (mut first_line, mut width, mut rows) = (0, None, 0);
    let mut channel_names = vec![];
    // Row after row as read; turned to one channel after the other below.
    let mut values: Vec<f32> = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(Error::csv(file))? {
        #[expect(clippy::expect_used, reason = "a reader notes where a record starts")]
        let line = line_of(text, record.position().expect("a record that was read"));
        let want = *width.get_or_insert_with(|| {
            first_line = line;
            record.len()
        });
        if record.len() != want {
            return Err(Error::RaggedCsv { file: file.into(), line, got: record.len(), first_line, want });
        }
        let is_header = line == first_line && record.iter().all(|f| f.parse::<f32>().is_err());
        if is_header && !is_other_separator(&record) {
            channel_names = record.iter().map(String::from).collect();
            continue;
        }
        for (column, field) in record.iter().enumerate() {
            values.push(field.parse().map_err(|_| no_number(&record, field, file, line, column))?);
        }
        rows += 1;
        if values.len() as u64 > limit {
            return Err(Error::TooLarge {
                at: file.into(),
                shape: vec![want as u64, rows as u64],
                limit,
                hint: "cut the recording or raise limits.max_values",
            });
        }
    }
    let channels = match width {
        None => return Err(Error::EmptyFile { file: file.into() }),
        Some(_) if rows == 0 => {
            return Err(Error::file(file, "holds a header but no rows; one row per time step"));
        }
        Some(channels) => channels,
    };
    let mut sample = Vec::with_capacity(values.len());
    for channel in 0..channels {
        sample.extend(values.iter().skip(channel).step_by(channels));
    }
    let shape = vec![channels, rows];
    Ok(Sample { shape, values: sample, dtype: "csv".into(), channel_names })
}

fn no_number(record: &csv::StringRecord, field: &str, file: &str, line: u64, column: usize) -> Error {
    Error::CsvNumber {
        file: file.into(),
        line,
        column: column + 1,
        text: field.chars().take(40).collect(),
        hint: if is_other_separator(record) {
            "; separate columns with commas, decimals with points"
        } else {
            ""
        },
    }
}

/// Returns the line of a record, whose position is that of the blank lines before it.
pub(crate) fn line_of(text: &str, start: &csv::Position) -> u64 {
    let rest = &text.as_bytes()[start.byte() as usize..];
    let blank = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    start.line() + blank.filter(|byte| **byte == b'\n').count() as u64
}

/// Checks for numbers separated by semicolons, tabs or spaces, which are one unreadable field.
fn is_other_separator(record: &csv::StringRecord) -> bool {
    let numbers = |separator| {
        let mut fields = record.iter().flat_map(|field| field.split(separator));
        fields.clone().count() > record.len() && fields.all(|f| f.trim().parse::<f32>().is_ok())
    };
    numbers(';') || numbers('\t') || numbers(' ')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        read(&CsvText::of(text.into()).unwrap(), "a.csv", 100).err().unwrap().to_string()
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
        ] {
            let sample = read(&CsvText::of(text.into()).unwrap(), "a.csv", 6).unwrap();
            assert_eq!((sample.shape, sample.values), want, "{text:?}");
        }
    }

    #[test]
    fn a_broken_table_is_refused_by_line_and_column() {
        assert_eq!(refused("1,2\n3\n"), "a.csv: line 2 has 1 columns, line 1 has 2");
        assert_eq!(refused("a,b\n1,2\n\n3,4,5\n"), "a.csv: line 4 has 3 columns, line 1 has 2");
        assert_eq!(refused("a,b\n1,2\n3,x\n"), "a.csv: line 3, column 2: \"x\" is not a number");
        assert_eq!(refused("1,\n3,4\n"), "a.csv: line 1, column 2: \"\" is not a number");
        for text in ["1;2\n3;4\n", "1,5;2,5\n", "1\t2\n", "1 2\n3 4\n"] {
            let message = refused(text);
            assert!(message.ends_with("commas, decimals with points"), "{message}");
        }
        assert_eq!(refused("a,b\n"), "a.csv: holds a header but no rows; one row per time step");
        assert_eq!(refused("\n\n"), "a.csv: is empty (0 bytes); copy or record it again");
        assert!(refused(&"1,2\n".repeat(51)).contains("more than the 100 values allowed"));
    }
}
