//! MATLAB files: written by scipy (`scripts/fixtures/matlab.py`), and byte by byte.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::refused;
use std::path::{Path, PathBuf};
use taxel_data::{Dataset, ReadOptions, TaskKind, check, load};
use tempfile::tempdir;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn with(options: ReadOptions) -> Dataset {
    load(&fixture("grasps-v7.mat"), &options).unwrap()
}

/// 100 n + 10 c + t, as the script has it.
fn is_counted(dataset: &Dataset) {
    assert_eq!(dataset.x.shape(), [4, 2, 3]);
    for ((index, value), _) in dataset.x.indexed_iter().zip(0..) {
        assert_eq!(*value, (100 * index[0] + 10 * index[1] + index[2]) as f32, "{index:?}");
    }
}

#[test]
fn versions_6_and_7_are_read_alike() {
    let [old, new] =
        ["grasps-v6.mat", "grasps-v7.mat"].map(|f| load(&fixture(f), &ReadOptions::default()).unwrap());
    is_counted(&new);
    assert_eq!(
        (&old.x, &old.strata().to_vec(), &old.output_names()),
        (&new.x, &new.strata().to_vec(), &new.output_names())
    );
    assert_eq!(new.strata().to_vec(), [0, 1, 1, 0]);
    assert_eq!(new.output_names(), ["1", "2"]);
    let card = check(&fixture("grasps-v7.mat")).unwrap();
    assert!(card.problems.is_empty(), "{:?}", card.problems);
    assert!(card.other_arrays.contains(&"session".to_string()), "{:?}", card.other_arrays);
}

#[test]
fn every_role_may_be_a_row_or_a_column_of_any_class() {
    let named = ReadOptions {
        group: Some("session".into()),
        test: Some("held_out".into()),
        ..ReadOptions::default()
    };
    let dataset = with(named);
    assert_eq!(dataset.groups, Some(vec![7, 7, 8, 8]));
    assert_eq!(dataset.official, Some(vec![false, false, true, true]));
    let levels = with(ReadOptions { y: Some("levels".into()), attribute: Some(1), ..ReadOptions::default() });
    assert_eq!(levels.strata().to_vec(), [2, 1, 0, 2]);
    let table = levels.targets.columns().unwrap();
    assert_eq!(table.of(&[1]), [1, 1]);
    assert_eq!(table.attributes()[1].classes, ["1", "2", "3"]);
    // 300 + 2 as a byte.
    let counts = with(ReadOptions { x: Some("counts".into()), ..ReadOptions::default() });
    assert_eq!((counts.x.shape(), counts.x[[3, 2]]), (&[4, 3][..], 46.0));
}

#[test]
fn whole_numbers_are_values_where_the_task_says_so() {
    let values = ReadOptions {
        task: Some(TaskKind::Values),
        y: Some("levels,session".into()),
        ..ReadOptions::default()
    };
    let data = with(values);
    assert_eq!(data.output_names(), ["levels-0", "levels-1", "session"]);
    let rows = data.targets.values().unwrap();
    assert_eq!((rows.of(&[0])[2], rows.of(&[1])[1]), (7.0, 2.0));
    // A fraction says so too.
    let half = load(&fixture("half.mat"), &ReadOptions::default()).unwrap();
    assert_eq!(half.targets.values().unwrap().values(), [0.0, 1.0, 1.5, 0.0]);
}

#[test]
fn one_hot_labels_are_class_numbers() {
    let data = load(&fixture("one-hot.mat"), &ReadOptions::default()).unwrap();
    assert_eq!((data.strata().to_vec(), data.targets.columns()), (vec![0, 2, 1, 0], None));
    let card = check(&fixture("one-hot.mat")).unwrap();
    assert_eq!(card.labels.as_deref(), Some("labels are one-hot: 3 classes"));
    // Levels that count from 1 are not named by anybody.
    let options = ReadOptions { y: Some("levels".into()), ..ReadOptions::default() };
    let message = load(&fixture("grasps-v7.mat"), &options).unwrap_err().to_string();
    assert!(message.contains("levels has 2 columns that are not one-hot; choose one"), "{message}");
}

#[test]
fn names_beside_it_count_from_1_as_well() {
    let folder = tempdir().unwrap();
    std::fs::copy(fixture("grasps-v7.mat"), folder.path().join("grasps.mat")).unwrap();
    std::fs::write(folder.path().join("labels.json"), r#"["sponge", "can"]"#).unwrap();
    let dataset = load(&folder.path().join("grasps.mat"), &ReadOptions::default()).unwrap();
    assert_eq!(
        (dataset.output_names(), dataset.strata().to_vec()),
        (vec!["sponge".into(), "can".into()], vec![0, 1, 1, 0])
    );
}

#[test]
fn a_folder_per_class_holds_one_array_per_file() {
    let folder = tempdir().unwrap();
    for class in ["sponge", "can"] {
        std::fs::create_dir(folder.path().join(class)).unwrap();
        for take in ["take2.mat", "take10.mat"] {
            std::fs::copy(fixture("recording.mat"), folder.path().join(class).join(take)).unwrap();
        }
    }
    let dataset = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!((dataset.x.shape(), dataset.x[[3, 1, 2]]), (&[4, 2, 3][..], 112.0));
    assert_eq!(dataset.output_names(), ["can", "sponge"]);

    let several = folder.path().join("can/take3.mat");
    std::fs::copy(fixture("grasps-v7.mat"), &several).unwrap();
    let message = load(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("take3.mat: has shape [4, 2, 3]"), "{message}");
    let message = load(folder.path(), &ReadOptions { x: Some("z".into()), ..ReadOptions::default() })
        .unwrap_err()
        .to_string();
    let held = "no array z: it holds counts |u1 [4, 3], held_out |u1 [1, 4], impedance complex <f8 [1, 1], levels <f8 [4, 2]";
    assert!(message.contains(held), "{message}");
}

#[test]
fn what_cannot_be_read_is_named() {
    let role =
        |x: &str, y: &str| ReadOptions { x: Some(x.into()), y: Some(y.into()), ..ReadOptions::default() };
    let data = |file: &str, options: &ReadOptions| refused(&fixture(file), options);
    for (x, y, said) in [
        (
            "z",
            "y",
            "no array z: it holds counts |u1 [4, 3], held_out |u1 [1, 4], impedance complex <f8 [1, 1], levels",
        ),
        ("names", "y", "names: has dtype cell; samples are booleans"),
        ("sensor", "y", "sensor: has dtype struct"),
        ("impedance", "y", "impedance: has dtype complex <f8"),
        ("x", "sensor", "sensor: has dtype struct; labels are whole numbers"),
        ("x", "note", "note has 1 entries but x has 4 samples"),
    ] {
        let message = data("grasps-v7.mat", &role(x, y));
        assert!(message.contains(said), "{message}");
    }
    let half = data("half.mat", &ReadOptions { task: Some(TaskKind::Classes), ..ReadOptions::default() });
    assert!(half.contains("half.mat: y: holds floats, which are values, and task = \"classes\""), "{half}");
    let four = data("grasps-v4.mat", &ReadOptions::default());
    assert!(four.contains("is not a MATLAB file of version 5 to 7"), "{four}");

    let folder = tempdir().unwrap();
    let path = folder.path().join("grasps.mat");
    let says = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        refused(&path, &ReadOptions::default())
    };
    let whole = std::fs::read(fixture("grasps-v6.mat")).unwrap();
    assert_eq!(says(b""), "grasps.mat: is empty (0 bytes); copy or record it again");
    assert!(says(&whole[..300]).contains("is cut short"), "{}", says(&whole[..300]));
    assert!(says(&whole[..90]).contains("ends before its header"), "{}", says(&whole[..90]));
    let mut hdf = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".to_vec();
    hdf.resize(600, b' ');
    assert!(says(&hdf).contains("is not readable as HDF5"), "{}", says(&hdf));
}

/// Big-endian, with values inside a tag; scipy writes neither.
#[test]
fn another_order_of_bytes() {
    let part = |kind: u32, bytes: &[u8]| {
        let mut out = [kind.to_be_bytes(), (bytes.len() as u32).to_be_bytes()].concat();
        out.extend(bytes);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    };
    let variable = |name: &str, shape: [u32; 2], values: Vec<u8>| {
        let flags = [6u32.to_be_bytes(), [0; 4]].concat();
        let axes = shape.map(u32::to_be_bytes).concat();
        let inner = [part(6, &flags), part(5, &axes), part(1, name.as_bytes()), values].concat();
        part(14, &inner)
    };
    let mut file = vec![b' '; 124];
    file.extend([1, 0, b'M', b'I']);
    let x: Vec<u8> = [0.5f64, 1.5, 2.5, 3.5, 4.5, 5.5].iter().flat_map(|v| v.to_be_bytes()).collect();
    file.extend(variable("x", [3, 2], part(9, &x)));
    file.extend(variable("y", [1, 3], vec![0, 3, 0, 2, 0, 1, 0, 0]));
    let folder = tempdir().unwrap();
    let path = folder.path().join("grasps.mat");
    std::fs::write(&path, file).unwrap();
    let dataset = load(&path, &ReadOptions::default()).unwrap();
    assert_eq!(dataset.x.iter().copied().collect::<Vec<_>>(), [0.5, 3.5, 1.5, 4.5, 2.5, 5.5]);
    assert_eq!(dataset.strata().to_vec(), [0, 1, 0]);
}
