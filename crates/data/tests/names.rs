//! Names in words: labels, groups and marks as texts, arrays under other names, other types of samples. Files are
//! NumPy's and scipy's own (`scripts/fixtures/lengths.py`).
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, npy, npz, refused, refused_arrays, samples};
use std::path::{Path, PathBuf};
use taxel_data::{Dataset, ReadOptions, load, recordings};
use tempfile::tempdir;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn texts(options: ReadOptions) -> Dataset {
    load(&fixture("texts.npz"), &options).unwrap()
}

fn y(name: &str) -> ReadOptions {
    ReadOptions { y: Some(name.into()), ..ReadOptions::default() }
}

/// `<U3` or `|S3` of an array.
fn words(wide: bool, words: &[&str]) -> Vec<u8> {
    let mut bytes = vec![];
    for word in words {
        let mut text: Vec<u8> = if wide {
            word.chars().flat_map(|c| (c as u32).to_le_bytes()).collect()
        } else {
            word.bytes().collect()
        };
        text.resize(if wide { 12 } else { 3 }, 0);
        bytes.extend(text);
    }
    npy(if wide { "<U3" } else { "|S3" }, false, &[words.len() as u64], &bytes)
}

#[test]
fn labels_groups_and_marks_are_texts() {
    let data = texts(ReadOptions {
        group: Some("session".into()),
        test: Some("held".into()),
        ..ReadOptions::default()
    });
    assert_eq!(
        (data.output_names().as_slice(), data.strata().to_vec().as_slice()),
        (&["fig", "pear", "äpfel"].map(String::from)[..], &[1, 2, 1, 0][..])
    );
    // In the order of the alphabet, as class names are.
    assert_eq!(
        (data.groups.as_deref(), data.group_name.as_deref()),
        (Some(&[0, 0, 2, 1][..]), Some("session"))
    );
    assert_eq!(data.official, Some(vec![false, true, false, true]));
    let bytes = texts(y("raw"));
    assert_eq!(
        (bytes.output_names(), bytes.strata().to_vec()),
        (["9", "10", "word"].map(String::from).to_vec(), vec![1, 0, 1, 2])
    );
    let unsaid = load(&fixture("texts.npz"), &y("two")).unwrap_err().to_string();
    assert!(unsaid.contains("two has 2 columns that are not one-hot; choose one with attribute"), "{unsaid}");
    let named = ["hand", "thing"].map(String::from).to_vec();
    assert_eq!(texts(ReadOptions { attributes: named, ..y("two") }).output_names().len(), 5);
    let two = texts(ReadOptions { attribute: Some(0), ..y("two") });
    let two = two.targets.columns().unwrap();
    assert_eq!(two.attributes()[1].classes, ["a", "b", "c"]);
    assert_eq!(two.values(), [1, 0, 0, 1, 1, 2, 0, 1]);
    // A file beside gives the order.
    let folder = tempdir().unwrap();
    std::fs::copy(fixture("texts.npz"), folder.path().join("t.npz")).unwrap();
    files(folder.path(), &[("labels.json", r#"{"classes": ["pear", "fig", "äpfel"], "rate": 5}"#)]);
    let data = load(&folder.path().join("t.npz"), &ReadOptions::default()).unwrap();
    assert_eq!((data.strata().to_vec(), data.spec.rate), (vec![0, 2, 0, 1], Some(5.0)));
    files(folder.path(), &[("labels.json", r#"["pear", "fig"]"#)]);
    let message = load(&folder.path().join("t.npz"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("labels.json: does not name \"äpfel\", which"), "{message}");
    assert!(message.contains("t.npz: y[1] is"), "{message}");
}

#[test]
fn half_floats_and_booleans_are_samples() {
    let half = texts(ReadOptions::default());
    assert_eq!((half.dtype.as_str(), half.x.shape(), half.x[[3, 1, 2]]), ("<f2", &[4, 2, 3][..], 39.0));
    let contact = texts(ReadOptions { x: Some("contact".into()), ..ReadOptions::default() });
    assert_eq!((contact.dtype.as_str(), contact.x.sum(), contact.x[[1, 0, 0]]), ("|b1", 15.0, 0.0));
    let folder = tempdir().unwrap();
    let big = npy(">f2", false, &[2, 1], &[0x3c, 0x00, 0xc0, 0x00]);
    let path = npz(folder.path(), &[("x", big), ("y", i64s(&[2], &[0, 1]))]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().x.into_iter().collect::<Vec<_>>(), [1.0, -2.0]);
}

#[test]
fn texts_of_matlab_are_cells_and_characters() {
    let data =
        load(&fixture("texts.mat"), &ReadOptions { group: Some("session".into()), ..ReadOptions::default() })
            .unwrap();
    assert_eq!(
        (data.output_names(), data.strata().to_vec()),
        (["fig", "pear", "äpfel"].map(String::from).to_vec(), vec![1, 2, 1, 0])
    );
    assert_eq!(data.groups, Some(vec![0, 0, 1, 1]));
    let rows = load(&fixture("texts.mat"), &y("char_y")).unwrap();
    assert_eq!(
        (rows.output_names(), rows.strata().to_vec()),
        (["soft", "stiff"].map(String::from).to_vec(), vec![1, 0, 1, 0])
    );
    let message = load(&fixture("texts.mat"), &y("mixed")).unwrap_err().to_string();
    assert!(message.contains("mixed: has dtype cell; labels are"), "{message}");
}

#[test]
fn a_split_of_arrays_is_the_official_one() {
    let data = load(&fixture("split.npz"), &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.x[[3, 1, 2]]), (&[4, 2, 3][..], 312.0));
    assert_eq!(
        (data.strata().to_vec().as_slice(), data.official.as_deref()),
        (&[1, 2, 1, 0][..], Some(&[false, false, false, true][..]))
    );
    assert_eq!(data.origins[2..], ["X_train[2]", "X_test[0]"]);
    let options = ReadOptions { test: Some("y_test".into()), ..ReadOptions::default() };
    assert!(
        refused(&fixture("split.npz"), &options).contains("test: names a split, but the file has its own")
    );
    let unlike = refused_arrays(&[
        ("X_train", samples(2)),
        ("X_test", f32s(&[1, 2, 4], &[0.0; 8])),
        ("y_train", i64s(&[2], &[0, 1])),
        ("y_test", i64s(&[1], &[0])),
    ]);
    assert!(
        unlike.contains("X_test: has shape [2, 4], but X_train has [2, 3]; all must be equal; training"),
        "{unlike}"
    );
    let unlike = refused_arrays(&[
        ("X_train", samples(2)),
        ("X_test", samples(1)),
        ("y_train", i64s(&[2], &[0, 1])),
        ("y_test", words(true, &["a"])),
    ]);
    assert_eq!(
        unlike,
        "grasps.npz: y_train and y_test are not alike; give both the same type and number of columns"
    );
    let missing =
        refused_arrays(&[("X_train", samples(2)), ("X_test", samples(1)), ("y_train", i64s(&[2], &[0, 1]))]);
    assert!(missing.contains("no array y_train: it holds X_test <f4 [1, 2, 3], X_train"), "{missing}");
}

#[test]
fn other_names_are_found_where_they_are_the_only_ones() {
    let folder = tempdir().unwrap();
    for (x, y) in [("X", "Y"), ("data", "labels"), ("X", "labels"), ("data", "y")] {
        let path = npz(folder.path(), &[(x, samples(4)), (y, common::labels())]);
        let data = load(&path, &ReadOptions::default()).unwrap();
        assert_eq!((data.len(), data.origins[1].clone()), (4, format!("{x}[1]")));
    }
    assert_eq!(
        refused_arrays(&[("X", samples(4)), ("data", samples(4)), ("y", common::labels())]),
        "grasps.npz: X, data could each be x; name yours with x = \"...\": it holds X <f4 [4, 2, 3], data <f4 [4, 2, 3], \
         y <i8 [4]"
    );
    let both = refused_arrays(&[("x", samples(4)), ("Y", common::labels()), ("labels", common::labels())]);
    assert!(both.contains("Y, labels could each be y; name yours with y"), "{both}");
    let both = refused_arrays(&[
        ("data", samples(4)),
        ("X_train", samples(2)),
        ("X_test", samples(2)),
        ("y", common::labels()),
    ]);
    assert!(both.contains("data, X_train, X_test could each be x"), "{both}");
    // Whoever names an array gets that one.
    let path = npz(folder.path(), &[("X", samples(4)), ("data", samples(4)), ("y", common::labels())]);
    assert!(load(&path, &ReadOptions { x: Some("data".into()), ..ReadOptions::default() }).is_ok());
}

#[test]
fn one_array_per_recording_beside_labels() {
    let path = fixture("each.npz");
    assert!(refused(&path, &ReadOptions::default()).contains("recordings have 5 to 12 readings"));
    let options = ReadOptions { length: Some("crop:5".parse().unwrap()), ..ReadOptions::default() };
    let data = load(&path, &options).unwrap();
    assert_eq!((data.x.shape(), data.strata().to_vec().as_slice()), (&[3, 2, 5][..], &[1, 0, 1][..]));
    assert_eq!(data.origins, ["grasp5", "grasp12", "grasp7"], "in the order in which they were saved");
    let read = recordings(&path, &options, 2).unwrap();
    assert_eq!((read.x, read.truth.unwrap()[1].clone()), (data.x, vec!["0".to_string()]));
    // Another number of labels than arrays is no such set.
    let one = || f32s(&[2, 3], &[0.0; 6]);
    let message = refused_arrays(&[("a", one()), ("b", one()), ("y", i64s(&[3], &[0, 1, 1]))]);
    assert!(message.contains("no array x: it holds a <f4 [2, 3], b <f4 [2, 3], y"), "{message}");
    let message =
        refused_arrays(&[("a", one()), ("b", f32s(&[3, 3], &[0.0; 9])), ("y", i64s(&[2], &[0, 1]))]);
    assert!(message.contains("b: has shape [3, 3], but") && message.contains("but for time"), "{message}");
}

#[test]
fn what_texts_cannot_be_is_refused() {
    let objects = refused(&fixture("objects.npz"), &ReadOptions::default());
    assert!(objects.contains("x: has dtype |O; Python objects are pickled and not read"), "{objects}");
    assert!(objects.contains("padded with NaN at the end"), "{objects}");
    let labels = ("y", common::labels());
    let days = ("group", words(false, &["d1", "d1", "d2", "d2"]));
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), labels.clone(), days]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().groups, Some(vec![0, 0, 1, 1]));
    let blocks = ReadOptions { group_block: Some(2), ..ReadOptions::default() };
    assert!(
        refused(&path, &blocks)
            .contains("group_block: divides consecutive numbers, but the groups are texts")
    );
    let path =
        npz(folder.path(), &[("x", samples(4)), labels.clone(), ("part", words(true, &["tst", "", "", ""]))]);
    let message = refused(&path, &ReadOptions { test: Some("part".into()), ..ReadOptions::default() });
    assert_eq!(message, "grasps.npz: part[0]: is \"tst\"; marks are train and test, or 0 and 1");
    let marks = |marks: &[i64]| {
        let path =
            npz(folder.path(), &[("x", samples(4)), labels.clone(), ("part", common::i64s(&[4], marks))]);
        (refused(&path, &ReadOptions { test: Some("part".into()), ..ReadOptions::default() }), path)
    };
    let (message, path) = marks(&[0, 1, 2, 0]);
    assert_eq!(
        message,
        "grasps.npz: part holds 0, 1, 2: marks are two numbers, 0 for training; say which are tested with test_above = 1"
    );
    let above = ReadOptions { test: Some("part".into()), test_above: Some(1), ..ReadOptions::default() };
    assert_eq!(load(&path, &above).unwrap().official, Some(vec![false, false, true, false]));
    assert!(marks(&[1, 2, 2, 1]).0.contains("part marks no or all samples for testing"));
    let y = |bytes: Vec<u8>| refused_arrays(&[("x", samples(4)), ("y", bytes)]);
    let whole = words(true, &["a", "b", "a", "b"]);
    assert!(y(whole[..whole.len() - 1].to_vec()).contains("y: data end after 47 of 48 bytes"));
    assert!(y([whole, vec![0]].concat()).contains("y: holds more than the 48 bytes"));
    assert!(y(words(true, &["a", "b"])).contains("y has 2 entries but x has 4 samples"));
    let endless = y(npy("<U99999999", false, &[4], &[0; 16]));
    assert!(endless.contains("y: has dtype <U99999999; labels are"), "{endless}");
}
