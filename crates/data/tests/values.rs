//! Targets that are values: read, saved, split.

#![allow(clippy::unwrap_used)]

mod common;

use ndarray::ArrayD;
use taxel_data::{Dataset, Layout, Npz, Quantity, ReadOptions, Targets, Task, Values, check, load};

/// Presses of so many newtons.
fn presses(forces: &[f32]) -> Dataset {
    let x = ArrayD::from_shape_fn(vec![forces.len(), 1, 3], |at| forces[at[0]] * (at[2] + 1) as f32);
    let mut dataset = Dataset::new("skin", Layout::Series, x, &vec![0; forces.len()]).unwrap();
    let force = Quantity { name: "force".into(), unit: Some("N".into()) };
    dataset.targets = Targets::Values(Values::new(vec![force], forces.to_vec()));
    dataset
}

#[test]
fn values_are_saved_and_read_back_with_name_and_unit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("skin.npz");
    let saved = presses(&[0.5, 1.25, 2.0, 7.5]);
    saved.save(&path).unwrap();
    let read = load(&path, &ReadOptions::default()).unwrap();
    assert_eq!((&read.targets, &read.x), (&saved.targets, &saved.x));
    assert_eq!(read.output_names(), ["force"]);
    let card = check(&path).unwrap();
    assert!(card.problems.is_empty(), "{:?}", card.problems);
    assert_eq!(card.labels.as_deref(), Some("values: force 0.5 to 7.5 N"));
}

#[test]
fn named_quantities_are_values_whatever_they_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("skin.npz");
    let mut saved = presses(&[1.0, 2.0, 3.0]);
    let fingers = ["left", "right"].map(|name| Quantity { name: name.into(), unit: Some("N".into()) });
    saved.targets = Targets::Values(Values::new(fingers.to_vec(), vec![0.0, 1.0, 1.0, 0.0, 0.0, 1.0]));
    saved.save(&path).unwrap();
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().targets, saved.targets);
}

#[test]
fn floats_are_values_and_never_classes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("skin.npz");
    let write = |y: &[f32], shape: &[usize]| {
        let mut npz = Npz::default();
        npz.add("x", &[4, 3], &[1.0f32; 12]).unwrap();
        npz.add("y", shape, y).unwrap();
        std::fs::write(&path, npz.finish().unwrap()).unwrap();
        load(&path, &ReadOptions::default())
    };
    let whole = write(&[0.0, 1.0, 2.0, 3.0], &[4]).unwrap();
    assert_eq!(whole.task(), Task::Values(vec![Quantity { name: "y".into(), unit: None }]));
    let two = write(&[0.0; 8], &[4, 2]).unwrap();
    assert_eq!(two.output_names(), ["y-0", "y-1"]);
    let equal = write(&[1.0; 4], &[4]).unwrap();
    assert_eq!(equal.output_names(), ["y"], "a column of ones is no one-hot class");
    let error = write(&[0.0, 1.0, f32::NAN, 3.0], &[4]).unwrap_err().to_string();
    assert!(error.contains("skin.npz: y[2]") && error.contains("NaN"), "{error}");
    let mut rows = [0.5; 8];
    rows[5] = f32::NAN;
    let error = write(&rows, &[4, 2]).unwrap_err().to_string();
    assert!(error.contains("skin.npz: y[2]: value at [1] is NaN"), "{error}");
    for (count, said) in [(3, '3'), (5, '5')] {
        let error = write(&vec![0.5; count], &[count]).unwrap_err().to_string();
        assert!(error.contains(said) && error.contains('4'), "{error}");
    }
}
