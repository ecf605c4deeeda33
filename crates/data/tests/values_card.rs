//! The card of targets that are values.

#![allow(clippy::unwrap_used)]

mod common;

use common::{f32s, files, i64s, npz};
use taxel_data::{Card, ReadOptions, check_with};
use tempfile::tempdir;

fn card(arrays: &[(&str, Vec<u8>)], options: &ReadOptions) -> Card {
    let folder = tempdir().unwrap();
    check_with(&npz(folder.path(), arrays), options).unwrap()
}

/// Samples `[n, 1, 2]`, every value its own and in no order.
fn mixed(n: u64) -> Vec<u8> {
    f32s(&[n, 1, 2], &(0..2 * n).map(|i| (i * 577 % 1009) as f32).collect::<Vec<_>>())
}

#[test]
fn a_card_shows_where_values_lie() {
    let mut force: Vec<f32> = (0..50u16).map(|i| f32::from(i * 37 % 50) / 10.0).collect();
    force[7] = 100.0;
    let options = ReadOptions { y: Some("force_N".into()), ..ReadOptions::default() };
    let card = card(&[("x", mixed(50)), ("force_N", f32s(&[50], &force))], &options);
    let summary = &card.quantities[0];
    assert_eq!((summary.name.as_str(), summary.unit.as_deref()), ("force", Some("N")));
    assert_eq!((summary.range, summary.bins[0], summary.bins[9]), ([0.0, 100.0], 49, 1));
    assert_eq!((summary.outliers, summary.worst.as_slice()), (1, &["x[7] 100".to_string()][..]));
    let text = card.to_string();
    for part in
        ["targets     values: force 0 to 100 N", "force |█        ▁| mean", "scores MAE", "farthest x[7] 100"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(!text.contains("classes each"), "{text}");
}

#[test]
fn a_card_warns_of_groups_and_neighbours_that_tell_a_value() {
    let groups: Vec<i64> = (0..60).map(|i| i % 6).collect();
    let weight: Vec<f32> = groups.iter().map(|group| 50.5 + 5.0 * (*group as f32)).collect();
    let arrays = [("x", mixed(60)), ("y", f32s(&[60], &weight)), ("group", i64s(&[60], &groups))];
    let warned = card(&arrays, &ReadOptions::default()).warnings.join("\n");
    assert!(warned.contains("the group alone tells y: its mean reaches R² 1; split by group"), "{warned}");
    assert!(!warned.contains("neighbours in the file"), "{warned}");
    let slow: Vec<f32> = (0..60).map(|i| (i as f32 / 12.0).sin()).collect();
    let warned =
        card(&[("x", mixed(60)), ("y", f32s(&[60], &slow))], &ReadOptions::default()).warnings.join("\n");
    assert!(warned.contains("neighbours in the file alone tell y: their mean reaches R² 0.99"), "{warned}");
    // Windows of a recording are kept together.
    let run: Vec<i64> = (0..60).map(|i| i / 20).collect();
    let arrays = [("x", f32s(&[60, 1], &slow)), ("y", f32s(&[60], &slow)), ("run", i64s(&[60], &run))];
    let options = ReadOptions {
        recording: Some("run".into()),
        length: Some("window:3,1".parse().unwrap()),
        ..ReadOptions::default()
    };
    let warned = card(&arrays, &options).warnings.join("\n");
    assert!(!warned.contains("neighbours in the file"), "{warned}");
}

#[test]
fn copies_with_other_values_are_named() {
    let x = f32s(&[3, 1, 2], &[1.0, 2.0, 3.0, 4.0, 1.0, 2.0]);
    let force = f32s(&[3], &[0.5, 1.5, 0.75]);
    let card = card(&[("x", x), ("y", force)], &ReadOptions::default());
    assert_eq!(card.contradictions[0].rows, [0, 2]);
    let warned = card.warnings.join("\n");
    assert!(
        warned.contains("2 rows are copies of a row with another value, such as x[0] (0.5) = x[2] (0.75)"),
        "{warned}"
    );
}

#[test]
fn a_folder_of_files_has_a_card_of_its_values() {
    let folder = tempdir().unwrap();
    let labels = "file,label,session\na.csv,0.5,m\nb.csv,1,n\nc.csv,2,n\n";
    files(folder.path(), &[("labels.csv", labels), ("a.csv", "1,2\n3,4\n"), ("b.csv", "1,2\n3,5\n")]);
    files(folder.path(), &[("c.csv", "1,2\n3,6\n")]);
    let card = check_with(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!((card.problems.len(), card.quantities[0].quartiles), (0, [0.75, 1.0, 1.5]));
}
