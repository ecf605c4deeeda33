//! `taxel record` from a bag, and into bags; and from a source that names no channels.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use assert_cmd::Command;
use mcap::records::MessageHeader;
use mcap::write::Writer;
use taxel::data::Tare;
use taxel::{Dataset, ReadOptions};

/// Runs a command in a folder; returns its exit code and all that it said.
fn run(folder: &Path, command: &str) -> (i32, String) {
    let mut taxel = Command::cargo_bin("taxel").unwrap();
    let output = taxel.current_dir(folder).args(command.split(' ')).output().unwrap();
    let text = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
    (output.status.code().unwrap(), text)
}

/// Two channels at 100 Hz; no two seconds are alike.
fn reading(step: u64) -> [f32; 2] {
    let time = step as f32 * 0.01;
    [time * time, (1.0 + time).sin() / 3.0]
}

/// Writes a bag of readings on `/skin` at steps that `keep` keeps, and of a joint at a fifth of the rate.
fn bag(path: &Path, steps: u64, keep: impl Fn(u64) -> bool) {
    let mut writer = Writer::new(std::io::BufWriter::new(File::create(path).unwrap())).unwrap();
    let skin = writer.add_channel(0, "/skin", "json", &BTreeMap::new()).unwrap();
    let joint = writer.add_channel(0, "/joint", "json", &BTreeMap::new()).unwrap();
    let mut sequence = 0;
    let mut write = |channel_id, time: u64, text: String| {
        let time = 1_700_000_000_000_000_000 + time;
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
        sequence += 1;
    };
    for step in (0..steps).filter(|step| keep(*step)) {
        let [thumb, index] = reading(step);
        write(skin, step * 10_000_000, format!("{{\"thumb\": {thumb}, \"index\": {index}}}"));
        if step % 5 == 0 {
            write(joint, step * 10_000_000 + 1, format!("{{\"angle\": {step}}}"));
        }
    }
    writer.finish().unwrap();
}

const CUP_AND_POT: &str = "--label cup --label pot --seconds 0.5 --count 3 --seed 1";

fn load(path: &Path) -> Dataset {
    taxel::load(path, &ReadOptions::default()).unwrap()
}

#[test]
fn a_topic_becomes_the_same_set_in_text_and_in_bags() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    bag(&at.join("drive.mcap"), 1000, |_| true);
    for kind in ["csv", "mcap"] {
        let command =
            format!("record --input drive.mcap --topic /skin {CUP_AND_POT} --output {kind} --files {kind}");
        let (code, said) = run(at, &command);
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("2 channels (thumb, index) at 100 Hz, by its time stamps"), "{said}");
        assert!(at.join(kind).join(format!("pot/session-1/003.{kind}")).is_file(), "{said}");
    }
    let [text, bags] = ["csv", "mcap"].map(|kind| load(&at.join(kind)));
    for dataset in [&text, &bags] {
        // A quarter of a second at rest, and half a second.
        assert_eq!(dataset.x.shape(), [6, 2, 75]);
        assert_eq!(dataset.spec.channel_names, ["thumb", "index"]);
        assert_eq!(dataset.spec.rate, Some(100.0));
        assert_eq!(dataset.spec.tare, Some(Tare::Recording { steps: 25 }));
    }
    assert_eq!((&text.x, text.strata()), (&bags.x, bags.strata()));
    // The first of all recordings holds the first readings of the bag, less the mean of those at rest.
    let (thumb, rest) =
        (|step: u64| reading(step)[0], (0..25).map(|step| reading(step)[0]).sum::<f32>() / 25.0);
    let first: Vec<f32> = (0..75).map(|step| thumb(step) - rest).collect();
    let is_first = |row: usize| {
        let row = text.x.index_axis(ndarray::Axis(0), row);
        (0..75).all(|step| (row[[0, step]] - first[step]).abs() < 1e-4)
    };
    assert_eq!((0..6).filter(|row| is_first(*row)).count(), 1);
    let (code, said) = run(at, "data check mcap");
    assert!(code <= 1 && said.contains("6×2×75"), "{said}");
    // Another session goes on in files of the same kind without being told.
    let more = "record --input drive.mcap --topic /skin --seconds 0.5 --count 4 --output mcap";
    let (code, said) = run(at, more);
    assert!(code == 0 && at.join("mcap/cup/session-2/001.mcap").is_file(), "{said}");
    assert_eq!(load(&at.join("mcap")).len(), 8);
    let (code, said) = run(at, &format!("{more} --files csv"));
    assert!(code == 2 && said.contains("the kind of files is mcap, and csv here"), "{said}");
}

#[test]
fn readings_that_a_bag_lacks_are_not_made_up() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // The second recording lacks a tenth of a second.
    bag(&at.join("drive.mcap"), 600, |step| !(100..110).contains(&step));
    let (code, said) =
        run(at, &format!("record --input drive.mcap --topic /skin {CUP_AND_POT} --output skin"));
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("of 75 readings are missing"), "{said}");
    assert_eq!(load(&at.join("skin")).len(), 6);
}

#[test]
fn a_source_without_names_says_what_its_channels_are_called() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let lines =
        |head: &str| format!("{head}{}", (0..400).map(|i| format!("{i}.5,{}\n", i % 7)).collect::<String>());
    let command = |file: &str| {
        format!(
            "record --input {file} --rate 100 {CUP_AND_POT} --count 2 --output {}",
            file.replace(".csv", "")
        )
    };
    for (file, head) in [("named.csv", "thumb,ring\n"), ("bare.csv", "")] {
        fs::write(at.join(file), lines(head)).unwrap();
        let (code, said) = run(at, &command(file).replace("--count 3 ", ""));
        assert_eq!(code, 0, "{said}");
        assert_eq!(
            said.contains("channel-0 to channel-1") && said.contains("a header"),
            head.is_empty(),
            "{said}"
        );
    }
}

#[test]
fn a_channel_that_readers_take_for_a_counter_is_refused_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let lines: String = (0..300).map(|i| format!("{}.5,{}\n", i % 11, i % 7)).collect();
    fs::write(at.join("press.csv"), format!("thumb,index\n{lines}")).unwrap();
    let (code, said) = run(at, &format!("record --input press.csv --rate 100 {CUP_AND_POT} --output skin"));
    assert!(code == 2 && said.contains("index_finger") && said.contains("\"index\" is left out"), "{said}");
}

#[test]
fn what_does_not_suit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    bag(&at.join("drive.mcap"), 300, |_| true);
    fs::write(at.join("lines.csv"), "time,a\n0,1\n1,2\n").unwrap();
    fs::write(at.join("broken.mcap"), "no bag at all".repeat(20)).unwrap();
    for (source, words) in [
        ("--input drive.mcap", &["several topics", "/skin", "/joint"][..]),
        ("--input drive.mcap --topic /arm", &["no messages of topic /arm", "/skin"]),
        ("--input drive.mcap --topic /skin --time thumb", &["--time", "bear their time"]),
        ("--input lines.csv --topic /skin", &["--topic /skin", "is of a bag"]),
        ("--input broken.mcap", &["broken.mcap", "is no MCAP file"]),
        ("--input none.mcap", &["none.mcap"]),
    ] {
        let (code, said) = run(at, &format!("record {source} {CUP_AND_POT} --output skin"));
        assert_eq!(code, 2, "{source}: {said}");
        words.iter().for_each(|word| assert!(said.contains(word), "{source}: {word}: {said}"));
        assert!(!at.join("skin").exists(), "{source}");
    }
}
