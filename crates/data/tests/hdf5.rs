//! HDF5 as h5py writes it and MATLAB 7.3; sound and broken.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::damaged;
use std::path::{Path, PathBuf};
use taxel_data::{Dataset, ReadOptions, TaskKind, check_with, load, recordings};
use tempfile::tempdir;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn arrays(x: &str, y: &str) -> ReadOptions {
    ReadOptions { x: Some(x.into()), y: Some(y.into()), ..ReadOptions::default() }
}

/// x[n, c, t] is 100 n + 10 c + t.
fn is_whole(data: &Dataset, what: &str) {
    assert_eq!(data.x.shape(), [4, 2, 3], "{what}");
    for ((n, c, t), value) in data.x.clone().into_dimensionality::<ndarray::Ix3>().unwrap().indexed_iter() {
        assert_eq!(*value, (100 * n + 10 * c + t) as f32, "{what} [{n}, {c}, {t}]");
    }
}

#[test]
fn every_way_to_store_an_array_gives_the_same() {
    let plain = load(&fixture("plain.h5"), &ReadOptions::default()).unwrap();
    is_whole(&plain, "plain");
    assert_eq!((plain.strata().to_vec(), plain.groups), (vec![0, 1, 0, 2], Some(vec![7, 7, 8, 8])));
    let values = ReadOptions { task: Some(TaskKind::Values), ..arrays("x", "group,y") };
    let values = load(&fixture("plain.h5"), &values).unwrap();
    assert_eq!(values.output_names(), ["group", "y"]);
    assert_eq!(values.targets.values().unwrap().of(&[0, 3]), [7.0, 0.0, 8.0, 2.0]);
    for x in ["x", "grows", "both", "whole"] {
        let data = load(&fixture("packed.h5"), &arrays(x, "y")).unwrap();
        is_whole(&data, x);
        assert_eq!(
            (data.output_names().join(" "), data.strata().to_vec()),
            ("fig pear äpfel".into(), vec![1, 2, 1, 0])
        );
        assert_eq!(data.groups, Some(vec![0, 0, 2, 1]));
    }
    let fixed = load(&fixture("packed.h5"), &arrays("contact", "fixed")).unwrap();
    assert_eq!((fixed.dtype.as_str(), fixed.strata().to_vec().as_slice()), ("|b1", &[1, 2, 1, 0][..]));
    assert_eq!(fixed.x.iter().sum::<f32>(), 15.0);
}

#[test]
fn matlab_7_3_has_its_axes_and_texts_as_matlab_says_them() {
    let path = fixture("grasps-v73.mat");
    let data = load(&path, &ReadOptions::default()).unwrap();
    is_whole(&data, "double");
    assert_eq!((data.output_names().join(" "), data.strata().to_vec()), ("1 2 3".into(), vec![0, 1, 0, 2]));
    for y in ["names", "rows"] {
        let data = load(&path, &arrays("contact", y)).unwrap();
        assert_eq!(
            (data.output_names().join(" "), data.strata().to_vec()),
            ("fig pear äpfel".into(), vec![1, 2, 1, 0]),
            "{y}"
        );
        assert_eq!(data.x.iter().sum::<f32>(), 15.0, "{y}");
    }
    let message = load(&path, &arrays("x", "z")).unwrap_err().to_string();
    let held = "contact |u1 [4, 2, 3], names cell [4, 1], rows char [4, 5], x <f8 [4, 2, 3], y <f8 [4, 1]";
    assert!(message.contains(held), "{message}");
}

#[test]
fn a_file_may_be_one_recording_or_hold_one_per_array() {
    let options = ReadOptions { length: Some("crop:3".parse().unwrap()), ..ReadOptions::default() };
    let each = load(&fixture("each.h5"), &options).unwrap();
    assert_eq!(
        (each.origins.join(" "), each.strata().to_vec()),
        ("grasp1 grasp2 grasp10".into(), vec![1, 0, 1])
    );
    assert_eq!(each.x.iter().step_by(6).copied().collect::<Vec<_>>(), [1000.0, 2000.0, 10000.0]);

    let root = tempdir().unwrap();
    for class in ["soft", "stiff"] {
        std::fs::create_dir(root.path().join(class)).unwrap();
        std::fs::copy(fixture("one.h5"), root.path().join(class).join("1.h5")).unwrap();
    }
    let data = load(root.path(), &ReadOptions::default()).unwrap();
    assert_eq!(
        (data.x.shape(), data.strata().to_vec(), data.output_names().join(" ")),
        (&[2, 2, 3][..], vec![0, 1], "soft stiff".into())
    );
    let one = recordings(&fixture("one.h5"), &ReadOptions::default(), 2).unwrap();
    assert_eq!(one.x.as_slice().unwrap(), [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
    let named = load(root.path(), &arrays("rate", "y")).unwrap();
    assert_eq!(named.x, data.x, "a name that no file needs changes nothing");
}

#[test]
fn what_is_no_array_of_numbers_is_refused_by_name() {
    let refused = |x: &str, y: &str| load(&fixture("packed.h5"), &arrays(x, y)).unwrap_err().to_string();
    assert!(refused("pairs", "y").contains("packed.h5: pairs"), "{}", refused("pairs", "y"));
    assert!(refused("fixed", "y").contains("packed.h5: fixed"), "{}", refused("fixed", "y"));
    assert!(refused("x", "x").contains("packed.h5: x"), "{}", refused("x", "x"));
    let message = refused("z", "y");
    assert!(message.contains("day1/x <f8 [2, 2, 3], fixed text [4]"), "{message}");
    let root = tempdir().unwrap();
    let path = root.path().join("data.h5");
    for (bytes, why) in [(&b""[..], "is empty"), (b"no such file", "is not readable as HDF5")] {
        std::fs::write(&path, bytes).unwrap();
        let message = load(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains("data.h5: ") && message.contains(why), "{message}");
    }
}

#[test]
fn a_file_that_is_damaged_anywhere_is_read_or_refused_by_name() {
    let folder = tempdir().unwrap();
    for name in ["plain.h5", "packed.h5", "one.h5", "grasps-v73.mat"] {
        let whole = std::fs::read(fixture(name)).unwrap();
        let path = folder.path().join(name);
        for bytes in damaged(&whole, 211, 41) {
            std::fs::write(&path, &bytes).unwrap();
            for options in [ReadOptions::default(), arrays("both", "fixed"), arrays("contact", "names")] {
                if let Err(error) = check_with(&path, &options) {
                    assert!(error.to_string().contains(name), "{error}");
                }
            }
        }
    }
}
