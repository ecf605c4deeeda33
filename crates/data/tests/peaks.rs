//! How much memory reading takes: less than twice the samples and their time stamps. One test alone: others would
//! allocate meanwhile.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use mcap::records::MessageHeader;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use peak_alloc::PeakAlloc;
use std::fmt::Write as _;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use taxel_data::{ReadOptions, load};
use tempfile::tempdir;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const CHANNELS: usize = 24;
/// Memory that a reader holds at once beside the samples: pages, chunks, lines.
const BESIDE: usize = 2 << 20;

/// Reads a set of `recordings` of so many `readings`: bytes of its samples and stamps, and the most held meanwhile.
fn peak(path: &Path, recordings: usize, readings: usize, options: &ReadOptions) -> (usize, usize) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let data = load(path, options).unwrap();
    let peak = MEMORY.peak_usage() - before;
    assert_eq!(data.x.shape(), [recordings, CHANNELS, readings], "{}", path.display());
    (recordings * readings * (4 * CHANNELS + 8), peak)
}

fn value(row: usize, channel: usize) -> f32 {
    (row as f32 * 0.37 + channel as f32 * 1.7).sin()
}

/// Recording, label, time in seconds, channels.
fn parquet(path: &Path, recordings: usize, readings: usize) {
    let channels: String = (0..CHANNELS).fold(String::new(), |mut text, c| {
        write!(text, "required float c{c}; ").unwrap();
        text
    });
    let text = format!(
        "message rows {{ required binary recording (UTF8); required binary label (UTF8); required double time; {channels}}}"
    );
    let schema = Arc::new(parse_message_type(&text).unwrap());
    // Small pages: a reader holds one of each column.
    let pages = WriterProperties::builder().set_dictionary_enabled(false).set_data_page_size_limit(1 << 14);
    let file = File::create(path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(pages.build())).unwrap();
    for recording in 0..recordings {
        let mut group = writer.next_row_group().unwrap();
        for name in [format!("r{recording}"), format!("class{}", recording % 2)] {
            let mut column = group.next_column().unwrap().unwrap();
            let texts = vec![ByteArray::from(name.as_str()); readings];
            column.typed::<ByteArrayType>().write_batch(&texts, None, None).unwrap();
            column.close().unwrap();
        }
        let mut column = group.next_column().unwrap().unwrap();
        let times: Vec<f64> = (0..readings).map(|i| i as f64 * 0.01).collect();
        column.typed::<DoubleType>().write_batch(&times, None, None).unwrap();
        column.close().unwrap();
        for channel in 0..CHANNELS {
            let mut column = group.next_column().unwrap().unwrap();
            let values: Vec<f32> = (0..readings).map(|i| value(recording * readings + i, channel)).collect();
            column.typed::<FloatType>().write_batch(&values, None, None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
}

/// One bag of messages of floats in CDR.
fn bag(path: &Path, readings: usize) {
    let mut writer = mcap::Writer::new(File::create(path).unwrap()).unwrap();
    let schema = writer.add_schema("own_msgs/msg/Taxels", "ros2msg", b"float32[] data\n").unwrap();
    let channel_id = writer.add_channel(schema, "/taxels", "cdr", &Default::default()).unwrap();
    for row in 0..readings {
        let mut data = vec![0, 1, 0, 0];
        data.extend((CHANNELS as u32).to_le_bytes());
        (0..CHANNELS).for_each(|channel| data.extend(value(row, channel).to_le_bytes()));
        let time = row as u64 * 10_000_000;
        let header = MessageHeader { channel_id, sequence: row as u32, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn reading_takes_less_than_twice_the_samples() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut all = vec![];
    let options = ReadOptions { y: Some("label".into()), ..ReadOptions::default() };
    for (recordings, readings) in [(100, 1000), (2, 50_000)] {
        let path = at(&format!("{recordings}.parquet"));
        parquet(&path, recordings, readings);
        all.push((
            format!("{recordings} recordings of a table"),
            peak(&path, recordings, readings, &options),
        ));
    }
    for (bags, readings) in [(2, 50_000), (40, 2000)] {
        let root = at(&format!("{bags} bags"));
        std::fs::create_dir(&root).unwrap();
        for i in 0..bags {
            bag(&root.join(format!("{}_{i}.mcap", ["cup", "ball"][i % 2])), readings);
        }
        all.push((format!("{bags} bags"), peak(&root, bags, readings, &ReadOptions::default())));
    }
    for (what, (samples, peak)) in all {
        println!("{what}: {peak} for {samples}");
        assert!(peak < 2 * samples + BESIDE, "{what}: {peak} bytes for {samples}");
    }
}
