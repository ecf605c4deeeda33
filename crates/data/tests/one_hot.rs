//! Labels with several columns: one-hot, attributes, or nobody says.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, labels, npy, npz, refused, samples};
use taxel_data::{Error, ReadOptions, check, check_with, load, recordings};
use tempfile::tempdir;

const ONE_HOT: [i64; 12] = [0, 0, 1, 1, 0, 0, 0, 1, 0, 1, 0, 0];

#[test]
fn one_hot_rows_become_class_numbers_of_the_same_digest() {
    let folder = tempdir().unwrap();
    let numbers = npz(folder.path(), &[("x", samples(4)), ("y", i64s(&[4], &[2, 0, 1, 0]))]);
    let wanted = load(&numbers, &ReadOptions::default()).unwrap();
    let floats = ONE_HOT.map(|value| value as f32);
    for y in [i64s(&[4, 3], &ONE_HOT), f32s(&[4, 3], &floats)] {
        let path = npz(folder.path(), &[("x", samples(4)), ("y", y)]);
        let data = load(&path, &ReadOptions::default()).unwrap();
        assert_eq!(
            (&data.strata().to_vec(), &data.output_names()),
            (&wanted.strata().to_vec(), &wanted.output_names())
        );
        assert_eq!((data.targets.columns(), &data.digest), (None, &wanted.digest));
        let card = check(&path).unwrap();
        assert_eq!((card.labels.as_deref(), card.problems.len()), (Some("labels are one-hot: 3 classes"), 0));
        assert!(card.to_string().contains("\n            labels are one-hot: 3 classes\n"), "{card}");
        let truth = recordings(&path, &ReadOptions::default(), 2).unwrap().truth.unwrap();
        assert_eq!(truth, [["2"], ["0"], ["1"], ["0"]]);
    }
}

#[test]
fn unequal_recordings_have_one_hot_labels_or_attributes() {
    let folder = tempdir().unwrap();
    let recording = |length: u64| f32s(&[2, length], &vec![1.0; 2 * length as usize]);
    let all = |y| {
        npz(
            folder.path(),
            &[("a", recording(5)), ("b", recording(3)), ("c", recording(4)), ("d", recording(6)), ("y", y)],
        )
    };
    let length = Some("crop:3".parse().unwrap());
    let path = all(i64s(&[4, 3], &ONE_HOT));
    let options = ReadOptions { length, ..ReadOptions::default() };
    let data = load(&path, &options).unwrap();
    assert_eq!((data.x.shape(), data.strata().to_vec()), (&[4, 2, 3][..], vec![2, 0, 1, 0]));
    let truth = recordings(&path, &options, 2).unwrap().truth.unwrap();
    assert_eq!(truth, [["2"], ["0"], ["1"], ["0"]]);
    let cut = ReadOptions { length: Some("window:2,1".parse().unwrap()), ..ReadOptions::default() };
    assert_eq!(load(&path, &cut).unwrap().strata().to_vec(), [2, 2, 2, 2, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0]);
    let path = all(i64s(&[4, 2], &[0, 2, 1, 0, 1, 1, 0, 2]));
    assert!(refused(&path, &options).contains("y has 2 columns that are not one-hot"));
    let named = ReadOptions { attributes: vec!["wet".into(), "hot".into()], ..cut };
    let data = load(&path, &named).unwrap();
    let values = data.targets.columns().unwrap().values().to_vec();
    assert_eq!(
        (data.strata().to_vec().len(), values[..4].to_vec(), values[26..].to_vec()),
        (14, vec![0, 2, 0, 2], vec![0, 2])
    );
}

#[test]
fn texts_and_numbers_from_one_are_never_one_hot() {
    let folder = tempdir().unwrap();
    let words = |wanted: [&str; 4]| {
        let bytes: Vec<u8> = wanted.iter().flat_map(|word| word.bytes()).collect();
        npy("|S1", false, &[2, 2], &bytes)
    };
    let path = npz(folder.path(), &[("x", samples(2)), ("y", words(["b", "a", "a", "b"]))]);
    let message = refused(&path, &ReadOptions::default());
    assert!(message.starts_with("grasps.npz: y has 2 columns that are not one-hot"), "{message}");
    let first = ReadOptions { attribute: Some(0), ..ReadOptions::default() };
    assert_eq!(load(&path, &first).unwrap().output_names(), ["a", "b"]);
}

#[test]
fn one_list_of_names_is_that_of_the_columns() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", i64s(&[4, 3], &ONE_HOT))]);
    files(folder.path(), &[("labels.json", r#"["can", "rope", "ball"]"#)]);
    let data = load(&path, &ReadOptions::default()).unwrap();
    assert_eq!(
        (data.strata().to_vec(), data.output_names().join(" ")),
        (vec![2, 0, 1, 0], "can rope ball".to_string())
    );
    let path = npz(folder.path(), &[("x", samples(2)), ("y", i64s(&[2, 3], &ONE_HOT[..6]))]);
    let message = refused(&path, &ReadOptions::default());
    assert_eq!(message, "grasps.npz: no sample in y has label 1 (rope); record some or remove its name");
}

#[test]
fn attributes_are_learned_only_where_somebody_asks() {
    let folder = tempdir().unwrap();
    let y = i64s(&[4, 2], &[0, 2, 1, 0, 1, 1, 0, 2]);
    let path = npz(folder.path(), &[("x", samples(4)), ("y", y)]);
    let wanted = "grasps.npz: y has 2 columns that are not one-hot; choose one with attribute = N (0..1), or name \
                  them all to learn several attributes: attributes = [\"...\", \"...\"]; if they are measured, say task = \
                  \"values\"";
    assert_eq!(refused(&path, &ReadOptions::default()), wanted);
    assert_eq!(check(&path).unwrap().problems.len(), 1, "a card all the same");
    // Rows that could be one-hot are what their reader says they are.
    let y = i64s(&[4, 2], &[0, 1, 1, 0, 1, 0, 0, 1]);
    let path = npz(folder.path(), &[("x", samples(4)), ("y", y)]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().strata().to_vec(), [1, 0, 0, 1]);
    let names = ["wet".to_string(), "hot".to_string()];
    let named = ReadOptions { attributes: names.to_vec(), ..ReadOptions::default() };
    let data = load(&path, &named).unwrap();
    assert_eq!(data.output_names(), ["wet:0", "wet:1", "hot:0", "hot:1"]);
    assert_eq!(check_with(&path, &named).unwrap().labels.as_deref(), Some("labels are 2 attributes"));
    let three =
        ReadOptions { attributes: ["a", "b", "c"].map(String::from).to_vec(), ..ReadOptions::default() };
    assert!(matches!(load(&path, &three), Err(Error::LearnAttributes { .. })));
    let first = ReadOptions { attribute: Some(0), ..ReadOptions::default() };
    assert_eq!(load(&path, &first).unwrap().strata().to_vec(), [0, 1, 1, 0]);
    files(folder.path(), &[("labels.json", r#"{"classes": [["dry", "wet"], ["cold", "hot"]]}"#)]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().output_names(), ["dry", "wet"]);
    let labels = check(&path).unwrap().labels;
    assert_eq!(labels.as_deref(), Some("labels are 2 attributes, of which column 0 is the class"));
}

#[test]
fn one_class_is_nothing_to_tell_apart() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", i64s(&[4], &[0; 4]))]);
    files(folder.path(), &[("labels.json", r#"["can"]"#)]);
    let wanted = "grasps.npz: all samples are of one class, can: nothing to tell apart";
    assert_eq!(refused(&path, &ReadOptions::default()), wanted);
    let problems = check(&path).unwrap().problems;
    assert!(problems.len() == 1 && problems[0].ends_with(wanted), "{problems:?}");
}

#[test]
fn attributes_of_several_arrays_are_a_whole_number_for_each_sample() {
    let folder = tempdir().unwrap();
    let names = ["wet", "hot"].map(String::from).to_vec();
    let options = ReadOptions { y: Some(names.clone().into()), attributes: names, ..ReadOptions::default() };
    let with = |hot| npz(folder.path(), &[("x", samples(4)), ("wet", labels()), ("hot", hot)]);
    let data = load(&with(i64s(&[4], &[0, 2, 1, 0])), &options).unwrap();
    assert_eq!(data.targets.columns().unwrap().values(), [0, 0, 1, 2, 1, 1, 0, 0]);
    // Two of each for half the samples, two of each, too few, texts.
    let text: Vec<u8> = "abab".bytes().collect();
    for hot in [
        i64s(&[2, 2], &[0, 1, 1, 0]),
        i64s(&[4, 2], &[0, 1, 1, 0, 0, 1, 1, 0]),
        i64s(&[3], &[0, 1, 1]),
        npy("|S1", false, &[4], &text),
    ] {
        let message = refused(&with(hot), &options);
        assert!(message.contains("is no [N] of whole numbers from 0"), "{message}");
    }
}
