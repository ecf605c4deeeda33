//! Recordings that want an answer, in the forms in which they come.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, npy, npz};
use image::RgbImage;
use std::fs;
use std::path::Path;
use taxel_data::{Layout, Limits, ReadOptions, are_images, load, recordings};
use tempfile::tempdir;

fn refused(path: &Path, options: &ReadOptions, rank: usize) -> String {
    let message = recordings(path, options, rank).unwrap_err().to_string();
    message.replace(&format!("{}/", path.parent().unwrap().display()), "")
}

#[test]
fn a_table_without_labels_may_lie_beside_the_names_of_classes() {
    let folder = tempdir().unwrap();
    let table = "a,b\n1,2\n3,4\n";
    files(folder.path(), &[("new.csv", table), ("labels.json", r#"{"classes": ["soft", "hard"]}"#)]);
    let read = recordings(&folder.path().join("new.csv"), &ReadOptions::default(), 1).unwrap();
    assert_eq!((read.x.shape(), read.truth), (&[2, 2][..], None));
}

#[test]
fn the_first_array_says_which_axis_is_time() {
    // Bytes on two axes are an image, which has no time; floats are a series.
    let bytes = |time: u8| npy("|u1", false, &[2, time.into()], &(0..2 * time).collect::<Vec<u8>>());
    let floats =
        |time: u8| f32s(&[2, time.into()], &(0..2 * time).map(|v| f32::from(v) + 0.5).collect::<Vec<_>>());
    let y = || common::i64s(&[2], &[0, 1]);
    let folder = tempdir().unwrap();
    let series = npz(folder.path(), &[("r1", floats(3)), ("r2", bytes(4)), ("y", y())]);
    let options = ReadOptions { length: Some("crop:3".parse().unwrap()), ..ReadOptions::default() };
    let data = load(&series, &options).unwrap();
    assert_eq!((data.x.shape(), data.dtype.as_str()), (&[2, 2, 3][..], "<f4"));
    assert_eq!(data.x.as_slice().unwrap()[6..], [0., 1., 2., 4., 5., 6.]);
    let images = npz(folder.path(), &[("r1", bytes(3)), ("r2", floats(3)), ("y", y())]);
    let data = load(&images, &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.spec.layout), (&[2, 2, 3][..], Layout::Image));
    let images = npz(folder.path(), &[("r1", bytes(3)), ("r2", floats(4)), ("y", y())]);
    let message = load(&images, &options).unwrap_err().to_string();
    assert!(message.contains("[2, 4]") && message.contains("[2, 3]"), "{message}");
}

#[test]
fn a_batch_keeps_to_the_limits_and_has_no_empty_axis() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("new.npy");
    let write = |shape: &[u64]| {
        let values = vec![1.0; shape.iter().product::<u64>() as usize];
        fs::write(&path, f32s(shape, &values)).unwrap();
    };
    write(&[4, 2, 3]);
    assert_eq!(recordings(&path, &ReadOptions::default(), 2).unwrap().x.shape(), [4, 2, 3]);
    let limits = Limits { max_values: 20, ..Limits::default() };
    let message = refused(&path, &ReadOptions { limits, ..ReadOptions::default() }, 2);
    assert!(message.starts_with("new.npy: ") && message.contains("20"), "{message}");
    let limits = Limits { max_samples: 3, ..Limits::default() };
    let message = refused(&path, &ReadOptions { limits, ..ReadOptions::default() }, 2);
    assert!(message.starts_with("new.npy: ") && message.contains('3'), "{message}");
    let limits = Limits { max_values: 24, max_samples: 4, ..Limits::default() };
    let just = ReadOptions { limits, ..ReadOptions::default() };
    assert_eq!(recordings(&path, &just, 2).unwrap().x.shape(), [4, 2, 3], "a limit allows as many");
    for shape in [[0, 2, 3], [4, 0, 3], [4, 2, 0]] {
        write(&shape);
        let message = refused(&path, &ReadOptions::default(), 2);
        assert!(message.starts_with("new.npy: "), "{message}");
    }
}

#[test]
fn channels_are_not_picked_along_time() {
    let folder = tempdir().unwrap();
    let frames = |time: u64| f32s(&[time, 2, 2], &vec![1.0; time as usize * 4]);
    for (name, time) in [("a.npy", 3), ("b.npy", 5)] {
        fs::write(folder.path().join(name), frames(time)).unwrap();
    }
    let length = Some("crop:2".parse().unwrap());
    let options = ReadOptions {
        layout: Some(Layout::Sequence),
        length,
        channels: Some(vec![0]),
        ..ReadOptions::default()
    };
    let message = refused(folder.path(), &options, 3);
    assert!(
        message.contains("channels: are picked along the first axis of a sample, which is time"),
        "{message}"
    );
}

#[test]
fn a_matlab_file_is_a_set_or_one_recording() {
    let fixture = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let one = recordings(&fixture("recording.mat"), &ReadOptions::default(), 2).unwrap();
    assert_eq!(one.x.shape()[0], 1);
    // The same samples under another name of the ones that stand for x.
    let set = recordings(&fixture("grasps-v7.mat"), &ReadOptions::default(), 2).unwrap();
    let named = recordings(&fixture("data-v7.mat"), &ReadOptions::default(), 2).unwrap();
    assert_eq!(named.x, set.x);
}

#[test]
fn images_are_told_from_what_lies_beside_them() {
    let folder = tempdir().unwrap();
    let root = folder.path();
    files(root, &[("set/.hidden", "x"), ("set/labels.json", "{}"), ("set/labels.csv", "file,label\n")]);
    assert!(!are_images(&root.join("set")));
    fs::create_dir_all(root.join("set/soft/day 1")).unwrap();
    let picture = root.join("set/soft/day 1/1.PNG");
    RgbImage::new(2, 2).save(&picture).unwrap();
    assert!(are_images(&root.join("set")) && are_images(&picture));
    files(root, &[("set/data.npz", "")]);
    assert!(!are_images(&root.join("set")), "a set beside them");
    assert!(!are_images(&root.join("nothing")));
}

#[test]
fn images_are_looked_for_three_folders_deep() {
    let folder = tempdir().unwrap();
    let deep = folder.path().join("1/2/3/4");
    fs::create_dir_all(&deep).unwrap();
    RgbImage::new(2, 2).save(deep.join("5.png")).unwrap();
    let told: Vec<bool> =
        ["", "1", "1/2", "1/2/3/4"].map(|below| are_images(&folder.path().join(below))).into();
    assert_eq!(told, [false, false, true, true]);
}
