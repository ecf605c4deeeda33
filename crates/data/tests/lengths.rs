//! Recordings of unequal length and the rules that bring them to one.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, npz, refused};
use serde_json::Value;
use std::path::{Path, PathBuf};
use taxel_data::{
    CropPart, Dataset, Layout, Length, Limits, Longer, Padding, ReadOptions, check, check_with, group_k_fold,
    load, recordings, stratified_k_fold,
};
use tempfile::{TempDir, tempdir};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn with(rule: &str) -> ReadOptions {
    ReadOptions { length: Some(rule.parse().unwrap()), ..ReadOptions::default() }
}

/// A folder per class of CSV recordings of two channels: reading t of recording n is (n + t, 10 t).
fn folder(lengths: &[usize]) -> TempDir {
    let folder = tempdir().unwrap();
    for (n, length) in lengths.iter().enumerate() {
        let rows: String = (0..*length).map(|t| format!("{},{}\n", n + t, 10 * t)).collect();
        let class = ["a", "b"][n % 2];
        files(folder.path(), &[(&format!("{class}/{n}.csv"), &rows)]);
    }
    folder
}

fn rows(data: &Dataset) -> Vec<Vec<f32>> {
    data.x.outer_iter().map(|row| row.iter().copied().collect()).collect()
}

#[test]
fn resampling_agrees_with_numpy() {
    let twin: Value =
        serde_json::from_str(&std::fs::read_to_string(fixture("lengths.json")).unwrap()).unwrap();
    let floats = |value: &Value| -> Vec<f32> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect()
    };
    let all = twin["recordings"].as_array().unwrap();
    let folder = tempdir().unwrap();
    for (i, case) in all.iter().enumerate() {
        let length = case["length"].as_u64().unwrap() as usize;
        let values = floats(&case["values"]);
        let text: String = (0..length).map(|t| format!("{},{}\n", values[t], values[length + t])).collect();
        files(folder.path(), &[(&format!("c/{i}.csv"), &text)]);
    }
    // A second class.
    files(folder.path(), &[("d/0.csv", "1,2\n3,4\n")]);
    for to in [2, 5, 7, 12] {
        let data = load(folder.path(), &with(&format!("resample:{to}"))).unwrap();
        assert_eq!(data.x.shape(), [all.len() + 1, 2, to]);
        for (recording, got) in all.iter().zip(rows(&data)) {
            let of = |case: &&Value| case["length"] == recording["length"] && case["to"] == to as u64;
            let case = twin["cases"].as_array().unwrap().iter().find(of).unwrap();
            for (got, want) in got.iter().zip(floats(&case["values"])) {
                assert!((got - want).abs() <= 2e-6 * want.abs().max(1.0), "{} to {to}", recording["length"]);
            }
        }
    }
    // The card's quartiles are numpy's lower ones.
    let lengths: Vec<usize> =
        twin["lengths"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap() as usize).collect();
    let lengths_of = check(self::folder(&lengths).path()).unwrap().lengths.unwrap();
    let quartiles: Vec<u64> = lengths_of.quartiles.iter().map(|n| *n as u64).collect();
    assert_eq!(Value::from(quartiles), twin["quartiles"]);
    assert_eq!((lengths_of.range, lengths_of.distinct, lengths_of.recordings), ([4, 30], 6, 7));
}

#[test]
fn a_length_that_a_recording_has_changes_nothing() {
    let folder = folder(&[4, 4, 4, 4]);
    let plain = load(folder.path(), &ReadOptions::default()).unwrap();
    for rule in ["resample:4", "pad:4", "crop:4,end", "window:4"] {
        let ruled = load(folder.path(), &with(rule)).unwrap();
        assert_eq!(ruled.x, plain.x, "{rule}");
        assert_eq!(ruled.spec.length, Some(rule.parse().unwrap()));
    }
    assert_eq!(load(folder.path(), &with("resample:4")).unwrap().digest, plain.digest);
}

#[test]
fn padding_and_cropping_keep_what_they_say() {
    let folder = folder(&[2, 5, 3]);
    let of = |rule: &str| load(folder.path(), &with(rule)).unwrap();
    // Classes are folders: a/0 and a/2, then b/1.
    let first = |rule: &str| rows(&of(rule));
    assert_eq!(first("pad:5")[0], [0., 1., 0., 0., 0., 0., 10., 0., 0., 0.]);
    assert_eq!(first("pad:5,edge")[0], [0., 1., 1., 1., 1., 0., 10., 10., 10., 10.]);
    assert_eq!(first("pad:4,edge,crop")[2], [1., 2., 3., 4., 0., 10., 20., 30.]);
    assert_eq!(first("crop:2")[2], [1., 2., 0., 10.]);
    assert_eq!(first("crop:2,centre")[2], [2., 3., 10., 20.]);
    assert_eq!(first("crop:2,end")[2], [4., 5., 30., 40.]);
    assert_ne!(of("crop:2").digest, of("crop:2,end").digest, "the digest is of the data as used");
    let refused = |rule: &str| refused(folder.path(), &with(rule));
    let name = folder.path().file_name().unwrap().to_str().unwrap().to_string();
    assert_eq!(
        refused("pad:4"),
        format!("{name}/b/1.csv: has 5 readings, length.to is 4; raise to, or set longer = \"crop\"")
    );
    assert_eq!(
        refused("crop:3"),
        format!(
            "{name}/a/0.csv: has 2 readings, length.to is 3; lower to, or take kind = \"pad\" or \"resample\""
        )
    );
    assert!(refused("window:6").contains("b/1.csv: has 5 readings, length.to is 6; lower to: no recording"));
}

#[test]
fn windows_stay_with_their_recording() {
    let folder = folder(&[7, 9, 2, 6, 8, 9]);
    let data = load(folder.path(), &with("window:3,2")).unwrap();
    // a: lengths 7, 2, 8; b: 9, 6, 9.
    assert_eq!(data.x.shape(), [3 + 3 + 4 + 2 + 4, 2, 3]);
    assert_eq!(data.origins[..4], ["a/0.csv[0..]", "a/0.csv[2..]", "a/0.csv[4..]", "a/4.csv[0..]"]);
    assert_eq!(rows(&data)[1], [2., 3., 4., 20., 30., 40.]);
    assert_eq!(data.dropped, ["a/2.csv"]);
    assert_eq!(data.group_name.as_deref(), Some("recording"));
    let groups = data.groups.clone().unwrap();
    assert_eq!(groups, [0, 0, 0, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 5, 5]);
    let units = data.units.clone().unwrap();
    let folds = [
        group_k_fold(&groups, &data.strata(), 3, 0, 0).unwrap(),
        stratified_k_fold(&data.strata(), 2, 0, 0, Some(&units)).unwrap(),
    ];
    for fold in folds.iter().flatten() {
        let torn = fold.test.iter().any(|row| fold.train.iter().any(|other| groups[*row] == groups[*other]));
        assert!(!torn, "windows of one recording are in training and test");
    }
    let card = check_with(folder.path(), &with("window:3,2")).unwrap();
    let lengths = card.lengths.as_ref().unwrap();
    // One reading of 8 and of 6 stays behind the last window, and two readings are no window at all.
    assert_eq!((lengths.unused, lengths.too_short), (4, 1));
    assert!(
        card.to_string().contains("4 readings in no sample, 1 recording shorter than a window"),
        "{card}"
    );
    // Between windows that are far apart readings are left out too.
    let apart = check_with(folder.path(), &with("window:2,5")).unwrap();
    assert_eq!(apart.lengths.unwrap().unused, 7 + 9 + 2 + 6 + 8 + 9 - 2 * (2 + 2 + 1 + 1 + 2 + 2));
    // Groups that are there already hold whole recordings, and stay.
    let data = load(folder.path(), &ReadOptions { group_block: Some(2), ..with("window:3,2") }).unwrap();
    assert_eq!(data.group_name.as_deref(), Some("position/2"));
    assert_eq!(data.groups.unwrap()[..7], [0, 0, 0, 1, 1, 1, 0]);
}

#[test]
fn copies_of_a_recording_keep_their_windows_together() {
    let folder = tempdir().unwrap();
    files(
        folder.path(),
        &[("a/0.csv", "1\n2\n3\n4\n"), ("a/1.csv", "1\n2\n3\n4\n"), ("b/0.csv", "1\n2\n5\n6\n")],
    );
    let data = load(folder.path(), &with("window:2")).unwrap();
    assert_eq!(data.units, Some(vec![0, 0, 0, 0, 4, 4]));
    let card = check_with(folder.path(), &with("window:2")).unwrap();
    assert_eq!(card.duplicates, [[1, 3]]);
    // The window 1, 2 of b/0.csv is one more copy, of another class.
    assert_eq!(card.contradictions[0].rows, [0, 2, 4]);
}

#[test]
fn unequal_lengths_without_a_rule_are_refused_with_the_line_that_helps() {
    let folder = folder(&[4, 9, 5, 5]);
    let line = "data.length = { kind = \"resample\", to = 5 }";
    let name = folder.path().file_name().unwrap().to_str().unwrap().to_string();
    assert_eq!(
        refused(folder.path(), &ReadOptions::default()),
        format!("{name}: recordings have 4 to 9 readings; say what to do, such as {line}")
    );
    let card = check(folder.path()).unwrap();
    assert_eq!(card.problems.len(), 1);
    let text = card.to_string();
    assert!(
        text.contains("proposed    length = { kind = \"resample\", to = 5 } (below: the set under it)\n"),
        "{text}"
    );
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    // What the card shows is the set under the proposed rule.
    assert_eq!(card.digest, load(folder.path(), &with("resample:5")).unwrap().digest);
    let card = check_with(folder.path(), &with("resample:5")).unwrap();
    assert!(card.problems.is_empty());
    assert!(card.to_string().contains("rule        length = { kind = \"resample\", to = 5 }\n"));
}

#[test]
fn steps_of_nan_at_the_end_are_padding() {
    let padded = fixture("padded.npz");
    assert!(load(&padded, &ReadOptions::default()).unwrap_err().to_string().contains("2 to 7 readings"));
    let data = load(&padded, &with("crop:2,end")).unwrap();
    assert_eq!((data.x.shape(), data.output_names().len()), ([3, 2, 2].as_slice(), 2));
    let whole = load(&padded, &with("pad:7")).unwrap();
    // (t * t) mod 11 - 3 of the second channel, and zeros behind the two readings of the last recording.
    assert_eq!(rows(&whole)[1][7..], [-3., -2., 1., 6., 2., 0., 0.]);
    assert_eq!(rows(&whole)[2][7..], [-3., -2., 0., 0., 0., 0., 0.]);
    assert_eq!(rows(&data)[1][2..], [0., 0.]);
    // A NaN among readings, or in one channel, is a fault whatever the rule.
    let folder = tempdir().unwrap();
    let mut values = [1.0; 12];
    values[5] = f32::NAN;
    let path = npz(folder.path(), &[("x", f32s(&[2, 2, 3], &values)), ("y", i64s(&[2], &[0, 1]))]);
    assert!(refused(&path, &with("resample:2")).contains("x[0]: value at [1, 2] is NaN"));
    values = [f32::NAN; 12];
    values[..6].fill(1.0);
    let path = npz(folder.path(), &[("x", f32s(&[2, 2, 3], &values)), ("y", i64s(&[2], &[0, 1]))]);
    assert!(refused(&path, &with("resample:2")).contains("x[1]: value at [0, 0] is NaN"), "all of it");
}

#[test]
fn time_is_where_the_layout_says() {
    let folder = tempdir().unwrap();
    // Two sequences of 1 x 2 taxels, three and two frames; the same numbers as fingers.
    let x = [1., 2., 3., 4., 5., 6., 7., 8., 9., 10., f32::NAN, f32::NAN];
    let sequence = npz(folder.path(), &[("x", f32s(&[2, 3, 1, 2], &x)), ("y", i64s(&[2], &[0, 1]))]);
    let data = load(&sequence, &with("crop:2,end")).unwrap();
    assert_eq!((data.x.shape(), data.spec.layout), ([2, 2, 1, 2].as_slice(), Layout::Sequence));
    assert_eq!(rows(&data), [[3., 4., 5., 6.], [7., 8., 9., 10.]]);
    let options = ReadOptions { channels: Some(vec![0]), ..with("crop:1") };
    assert!(refused(&sequence, &options).contains("channels: are picked along the first axis"));
    let x: Vec<f32> = (0..24).map(|v| v as f32).collect();
    let fingers = npz(folder.path(), &[("x", f32s(&[2, 2, 2, 3], &x)), ("y", i64s(&[2], &[0, 1]))]);
    let options = ReadOptions { layout: Some(Layout::Fingers), ..with("crop:1,end") };
    assert_eq!(rows(&load(&fingers, &options).unwrap())[1], [14., 17., 20., 23.]);
    let options = ReadOptions { layout: Some(Layout::Colour), ..with("crop:1") };
    assert!(refused(&fingers, &options).contains("layout is colour"));
    let images = npz(folder.path(), &[("x", f32s(&[2, 2], &[1., 2., 3., 4.])), ("y", i64s(&[2], &[0, 1]))]);
    assert_eq!(
        refused(&images, &with("crop:1")),
        "grasps.npz: length: a sample is a row of features [F], which has no time; leave it out, or say what the \
         axes are with layout"
    );
}

#[test]
fn resampling_changes_the_rate_where_there_is_one() {
    let rate = |lengths: &[usize], rule: &str| {
        let options = ReadOptions { rate: Some(100.0), ..with(rule) };
        load(folder(lengths).path(), &options).unwrap().spec.rate
    };
    // Eleven readings take a tenth of a second, and so do the six of a sample.
    assert_eq!(rate(&[11, 11], "resample:6"), Some(50.0));
    assert_eq!(rate(&[11, 9], "resample:6"), None);
    assert_eq!((rate(&[11, 9], "crop:5"), rate(&[11, 9], "window:3")), (Some(100.0), Some(100.0)));
}

#[test]
fn channels_are_picked_before_the_rule() {
    let folder = folder(&[3, 5]);
    let data = load(folder.path(), &ReadOptions { channels: Some(vec![1]), ..with("crop:2") }).unwrap();
    assert_eq!((data.x.shape(), rows(&data)[1].clone()), ([2, 1, 2].as_slice(), vec![0., 10.]));
}

#[test]
fn a_model_s_recordings_have_any_length() {
    let folder = folder(&[7, 3]);
    let options = ReadOptions { layout: Some(Layout::Series), ..with("window:3,2") };
    let read = recordings(folder.path(), &options, 2).unwrap();
    assert_eq!(read.origins, ["a/0.csv", "a/0.csv", "a/0.csv", "b/1.csv"]);
    assert_eq!(read.starts, Some(vec![0, 2, 4, 0]));
    assert_eq!(read.truth.unwrap()[3], ["b"]);
    let one = recordings(&folder.path().join("b/1.csv"), &with("resample:5"), 2).unwrap();
    assert_eq!((one.x.shape(), one.starts), ([1, 2, 5].as_slice(), None));
    let short = recordings(folder.path(), &with("window:4"), 2).unwrap_err().to_string();
    assert!(short.contains("b/1.csv: has 3 readings, length.to is 4; it holds no window"), "{short}");
    let none = recordings(folder.path(), &ReadOptions::default(), 2).unwrap_err().to_string();
    assert!(none.contains("3 to 7 readings"), "{none}");
}

#[test]
fn a_rule_is_a_text_and_a_table() {
    for (text, key) in [
        ("resample:300", r#"{"kind":"resample","to":300}"#),
        ("pad:300", r#"{"kind":"pad","to":300}"#),
        ("pad:300,edge,crop", r#"{"kind":"pad","to":300,"value":"edge","longer":"crop"}"#),
        ("crop:300", r#"{"kind":"crop","to":300}"#),
        ("crop:300,centre", r#"{"kind":"crop","to":300,"from":"centre"}"#),
        ("window:300", r#"{"kind":"window","to":300}"#),
        ("window:300,150", r#"{"kind":"window","to":300,"hop":150}"#),
    ] {
        let rule: Length = text.parse().unwrap();
        assert_eq!((rule.to_string().as_str(), serde_json::to_string(&rule).unwrap().as_str()), (text, key));
        assert_eq!(serde_json::from_str::<Length>(key).unwrap(), rule);
    }
    assert_eq!("crop:3,start".parse(), Ok(Length::Crop { to: 3, from: CropPart::Start }));
    let zero = Length::Pad { to: 3, value: Padding::Zero, longer: Longer::Refuse };
    assert_eq!("pad:3,zero,refuse".parse(), Ok(zero));
    for bad in [
        "",
        "300",
        "resample",
        "resample:1",
        "resample:x",
        "pad:0",
        "crop:3,edge",
        "window:3,0",
        "fold:3",
        "window:3,1,1",
        "resample:3,edge",
        "pad:3,",
    ] {
        let message = bad.parse::<Length>().unwrap_err().to_string();
        assert!(message.contains("is no length rule; write resample:300"), "{bad}: {message}");
    }
    for bad in
        [r#"{"kind":"resample"}"#, r#"{"kind":"resample","to":3,"hop":1}"#, r#"{"kind":"fold","to":3}"#]
    {
        assert!(serde_json::from_str::<Length>(bad).is_err(), "{bad}");
    }
}

#[test]
fn a_rule_out_of_range_or_beyond_the_limits_is_refused() {
    let folder = folder(&[3, 5]);
    let ruled = |rule| ReadOptions { length: Some(rule), ..ReadOptions::default() };
    for (rule, why) in [
        (Length::Resample { to: 1 }, "length: is the number of readings, from 2"),
        (Length::Crop { to: 0, from: CropPart::Start }, "length: is the number of readings, from 1"),
        (Length::Window { to: 2, hop: Some(0) }, "from one window to the next, from 1"),
        (Length::Resample { to: usize::MAX }, "values allowed; choose a smaller length"),
        (Length::Resample { to: 1 << 40 }, "values allowed; choose a smaller length"),
    ] {
        let message = refused(folder.path(), &ruled(rule));
        assert!(message.contains(why), "{message}");
    }
    let limits = Limits { max_samples: 3, ..Limits::default() };
    let many = ReadOptions { limits, ..ruled(Length::Window { to: 1, hop: None }) };
    assert!(refused(folder.path(), &many).contains("8 samples are more than the 3 allowed"));
    let limits = Limits { max_values: 15, ..Limits::default() };
    let message = refused(folder.path(), &ReadOptions { limits, ..ReadOptions::default() });
    assert!(message.contains("more than the 15 values allowed; take fewer recordings"), "{message}");
}
