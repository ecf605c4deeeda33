//! Writers of small Parquet files and bags, and what reading them says.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use mcap::records::MessageHeader;
use mcap::write::Writer;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use taxel_data::{ReadOptions, load};

/// A column of a Parquet file.
pub enum Column {
    Text(Vec<String>),
    Int(Vec<i64>),
    Float(Vec<f32>),
    Double(Vec<f64>),
    /// Time stamps, and their unit: `MICROS`.
    Stamp(Vec<i64>, &'static str),
    /// A list in each row.
    List(Vec<Vec<f32>>),
    /// A list of lists in each row.
    Grid(Vec<Vec<Vec<f32>>>),
}

impl Column {
    fn schema(&self, name: &str) -> String {
        let list = |inner: &str| format!("(LIST) {{ repeated group list {{ {inner} }} }}");
        match self {
            Self::Text(_) => format!("optional binary {name} (UTF8);"),
            Self::Int(_) => format!("optional int64 {name};"),
            Self::Float(_) => format!("optional float {name};"),
            Self::Stamp(_, unit) => format!("optional int64 {name} (TIMESTAMP({unit},true));"),
            Self::Double(_) => format!("optional double {name};"),
            Self::List(_) => format!("optional group {name} {}", list("optional float element;")),
            Self::Grid(_) => {
                let inner = format!("optional group element {}", list("optional float element;"));
                format!("optional group {name} {}", list(&inner))
            }
        }
    }

    fn write(&self, writer: &mut ColumnWriter) {
        let one = |rows: usize| vec![1i16; rows];
        match (self, writer) {
            (Self::Text(texts), ColumnWriter::ByteArrayColumnWriter(writer)) => {
                let texts: Vec<ByteArray> = texts.iter().map(|text| text.as_str().into()).collect();
                writer.write_batch(&texts, Some(&one(texts.len())), None).unwrap();
            }
            (Self::Int(values) | Self::Stamp(values, _), ColumnWriter::Int64ColumnWriter(writer)) => {
                writer.write_batch(values, Some(&one(values.len())), None).unwrap();
            }
            (Self::Float(values), ColumnWriter::FloatColumnWriter(writer)) => {
                writer.write_batch(values, Some(&one(values.len())), None).unwrap();
            }
            (Self::Double(values), ColumnWriter::DoubleColumnWriter(writer)) => {
                writer.write_batch(values, Some(&one(values.len())), None).unwrap();
            }
            (Self::List(rows), ColumnWriter::FloatColumnWriter(writer)) => {
                let repeated = rows.iter().flat_map(|row| (0..row.len()).map(|i| i16::from(i > 0)));
                let repeated: Vec<i16> = repeated.collect();
                writer.write_batch(&rows.concat(), Some(&vec![3; repeated.len()]), Some(&repeated)).unwrap();
            }
            (Self::Grid(rows), ColumnWriter::FloatColumnWriter(writer)) => {
                let level = |row: usize, i: usize| if i > 0 { 2 } else { i16::from(row > 0) };
                let repeated: Vec<i16> = rows
                    .iter()
                    .flat_map(|grid| grid.iter().enumerate())
                    .flat_map(|(row, list)| (0..list.len()).map(move |i| level(row, i)))
                    .collect();
                let values = rows.concat().concat();
                writer.write_batch(&values, Some(&vec![5; repeated.len()]), Some(&repeated)).unwrap();
            }
            _ => unreachable!("the schema says the type"),
        }
    }
}

/// Writes a file of Parquet as pyarrow does.
pub fn parquet(path: &Path, columns: &[(&str, Column)]) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let fields: String = columns.iter().map(|(name, column)| column.schema(name)).collect();
    let schema = Arc::new(parse_message_type(&format!("message schema {{ {fields} }}")).unwrap());
    let file = File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::default()).unwrap();
    let mut group = writer.next_row_group().unwrap();
    for (_, values) in columns {
        let mut column = group.next_column().unwrap().unwrap();
        values.write(column.untyped());
        column.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
}

/// Columns that every set of LeRobot has, of an episode of `rows` at 10 Hz.
pub fn episode(index: i64, task: i64, rows: usize) -> Vec<(&'static str, Column)> {
    let count = || 0..rows as i64;
    vec![
        ("timestamp", Column::Float(count().map(|row| row as f32 / 10.0).collect())),
        ("frame_index", Column::Int(count().collect())),
        ("episode_index", Column::Int(vec![index; rows])),
        ("index", Column::Int(count().map(|row| 100 * index + row).collect())),
        ("task_index", Column::Int(vec![task; rows])),
    ]
}

/// Writes `meta/info.json` with these features.
pub fn info(root: &Path, version: &str, features: &str) {
    std::fs::create_dir_all(root.join("meta")).unwrap();
    let text = format!("{{\"codebase_version\": {version:?}, \"fps\": 10, \"features\": {{{features}}}}}");
    std::fs::write(root.join("meta/info.json"), text).unwrap();
}

/// A type of ROS messages: its name and its definition; JSON has neither.
pub type Definition = (&'static str, &'static str);

/// Writes a bag of one topic: messages with their time in milliseconds.
pub fn bag(path: &Path, topic: &str, definition: Option<Definition>, messages: &[(u64, Vec<u8>)]) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    let mut writer = Writer::new(std::io::BufWriter::new(File::create(path).unwrap())).unwrap();
    let schema =
        definition.map_or(0, |(name, text)| writer.add_schema(name, "ros2msg", text.as_bytes()).unwrap());
    let encoding = if definition.is_some() { "cdr" } else { "json" };
    let channel_id = writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
    for (sequence, (time, data)) in (0..).zip(messages) {
        let time = time * 1_000_000;
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
}

/// Bytes of a message in CDR, little endian; the first four say so.
#[derive(Default)]
pub struct Cdr(Vec<u8>);

impl Cdr {
    fn at(mut self, size: usize, bytes: &[u8]) -> Self {
        self.0.resize(self.0.len().next_multiple_of(size), 0);
        self.0.extend(bytes);
        self
    }

    pub fn byte(self, value: u8) -> Self {
        self.at(1, &[value])
    }

    pub fn word(self, value: u32) -> Self {
        self.at(4, &value.to_le_bytes())
    }

    pub fn f64(self, value: f64) -> Self {
        self.at(8, &value.to_le_bytes())
    }

    pub fn text(self, text: &str) -> Self {
        self.word(text.len() as u32 + 1).at(1, text.as_bytes()).byte(0)
    }

    pub fn bytes(self, bytes: &[u8]) -> Self {
        self.word(bytes.len() as u32).at(1, bytes)
    }

    /// A header without a time.
    pub fn header(self) -> Self {
        self.word(0).word(0).text("skin")
    }

    pub fn finish(self) -> Vec<u8> {
        [vec![0, 1, 0, 0], self.0].concat()
    }
}

/// Returns the message for a path, without the path itself.
pub fn refused(path: &Path, options: &ReadOptions) -> String {
    let message = load(path, options).unwrap_err().to_string();
    message.replace(&format!("{}/", path.display()), "").replace(&path.display().to_string(), "FOLDER")
}
