//! The content of a card.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, npy, npz};
use taxel_data::{Card, Layout, ReadOptions, check, check_with};
use tempfile::tempdir;

/// Eight samples `[2, 2]`; channel 1 is dead, row 5 copies row 1 under another label, row 6
/// repeats row 2, row 7 is flat but for channel 1.
fn arrays() -> Vec<(&'static str, Vec<u8>)> {
    let rows = [[1., 2.], [3., 4.], [5., 6.], [7., 9.], [9., 8.], [3., 4.], [5., 6.], [0., 0.]];
    let x: Vec<f32> = rows.iter().flat_map(|row| [row[0], row[1], 0.0, 0.0]).collect();
    vec![
        ("x", f32s(&[8, 2, 2], &x)),
        ("y", i64s(&[8], &[0, 0, 0, 0, 0, 1, 0, 0])),
        ("object", i64s(&[8], &[4, 4, 4, 4, 4, 9, 9, 9])),
    ]
}

#[test]
fn a_card_counts_what_distorts_a_score() {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("labels.json", r#"["stable", "slip"]"#)]);
    let path = npz(folder.path(), &arrays());
    let options = ReadOptions { group: Some("object".into()), ..ReadOptions::default() };
    let card = check_with(&path, &options).unwrap();
    assert_eq!((card.shape.as_slice(), card.layout), ([8, 2, 2].as_slice(), Layout::Series));
    assert_eq!((card.classes[1].name.as_str(), card.classes[1].samples), ("slip", 1));
    assert_eq!(card.majority_share, 7.0 / 8.0);
    assert_eq!((card.range, card.saturation), (Some([0.0, 9.0]), [18.0 / 32.0, 2.0 / 32.0]));
    assert_eq!((card.channels[0].min, card.channels[0].max), (Some(0.0), Some(9.0)));
    assert_eq!((card.channels[0].at_min, card.channels[0].at_max), (0.125, 0.125));
    assert_eq!((card.taxels, &card.constant_taxels), (2, &vec![vec![1]]));
    assert_eq!(card.constant_samples, [7]);
    assert_eq!(card.duplicates, [[2, 6]]);
    assert_eq!(card.contradictions[0].rows, [1, 5]);
    let groups = card.groups.as_ref().unwrap();
    assert_eq!((groups.groups, groups.samples, groups.classes), (2, [3, 5], [1, 2]));
    assert_eq!(groups.classes_in_one_group, ["slip"]);
    assert_eq!(
        card.warnings,
        [
            "2 rows are copies of a row with another label, such as x[1] (stable) = x[5] (slip): set \
             drop = [\"contradictory\"]",
            "1 set of exact copies within a class, such as x[2] = x[6]: keep each set in one fold, or \
             set drop = [\"duplicates\"]",
            "2 sets of exact copies across groups: a test group may hold what was trained on",
            "1 of 2 taxels never change, the first is [1]: dead, or always saturated",
            "1 sample with one value throughout, the first is x[7]: no contact?",
            "class slip has 1 sample: too few for 5 folds",
            "classes are uneven: stable has 7 samples, slip has 1; read balanced accuracy",
            "classes in one object only: 1 of 2, such as slip: left out, they are never trained, so \
             leave-group-out is impossible",
        ]
    );
    assert_eq!(card.problems, [""; 0]);

    let text = card.to_string();
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    for part in [
        "8×2×2 (N×C×T, stored as <f4)",
        "stable 7, slip 1",
        "87.5 %",
        "constant",
        "2 of object",
        "0..9; 56.2 % at lowest, 6.2 % at highest",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    assert!(!text.contains("also holds"), "{text}");
    let json = serde_json::to_value(&card).unwrap();
    assert_eq!(json["axes"], "N×C×T");
    assert_eq!(json["groups"]["classes_in_one_group"][0], "slip");
    assert_eq!(json["channels"][1]["max"], 0.0);
}

#[test]
fn dead_taxels_of_images_are_named_by_row_and_column() {
    // Bytes in three axes are images; in four, images over time.
    let mut values: Vec<u8> = (0..36).collect();
    (0..6).for_each(|i| values[6 * i + 2] = 7);
    let folder = tempdir().unwrap();
    let y = || ("y", i64s(&[6], &[0, 1, 0, 1, 0, 1]));
    let card = check(&npz(folder.path(), &[("x", npy("|u1", false, &[6, 2, 3], &values)), y()])).unwrap();
    assert_eq!((card.layout, card.taxels, card.channels.len()), (Layout::Image, 6, 0));
    assert_eq!(card.constant_taxels, [[0, 2]]);
    let y = ("y", i64s(&[3], &[0, 1, 0]));
    let card = check(&npz(folder.path(), &[("x", npy("|u1", false, &[3, 2, 2, 3], &values)), y])).unwrap();
    assert_eq!((card.layout, card.taxels), (Layout::Sequence, 6));
    assert_eq!(card.constant_taxels, [[0, 2]]);
    // A feature per column.
    let (x, y) = (npy("|u1", false, &[6, 6], &values), ("y", i64s(&[6], &[0, 1, 0, 1, 0, 1])));
    let card = check(&npz(folder.path(), &[("x", x), y])).unwrap();
    assert_eq!((card.layout, card.constant_taxels.as_slice()), (Layout::Features, [vec![2]].as_slice()));
}

#[test]
fn single_class_groups_are_pointed_out() {
    let folder = tempdir().unwrap();
    let path = npz(
        folder.path(),
        &[
            ("x", f32s(&[4, 2], &[1., 2., 3., 4., 5., 6., 7., 8.])),
            ("y", i64s(&[4], &[0, 0, 1, 1])),
            ("group", i64s(&[4], &[0, 1, 2, 3])),
        ],
    );
    let warnings = check(&path).unwrap().warnings;
    let want = "every group holds one class only: leaving one out tests on a single class";
    assert!(warnings.iter().any(|w| w == want), "{warnings:?}");
    assert!(!warnings.iter().any(|w| w.contains("leave-group-out")), "{warnings:?}");
}

#[test]
fn a_card_lists_every_problem() {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("labels.json", r#"["a", "b", "c"]"#)]);
    let x = f32s(&[4, 1, 2], &[f32::NAN, 1., f32::NAN, 2., 3., 4., 5., 6.]);
    let path =
        npz(folder.path(), &[("x", x), ("y", i64s(&[5], &[0, 1, -1, 7, 8])), ("group", i64s(&[2], &[0, 1]))]);
    let card = check(&path).unwrap();
    let file = path.display();
    assert_eq!(
        card.problems,
        [
            format!("{file}: y has 5 entries but x has 4 samples; one per sample"),
            format!("{file}: y[2] = -1 is negative; number the classes from 0"),
            format!("{file}: y[3] = 7 is out of range: labels.json names 3 classes (0..2)"),
            format!("{file}: group has 2 entries but x has 4 samples; one per sample"),
            format!("{file}: no sample in y has label 2 (c); record some or remove its name"),
            format!(
                "{file}: x[0]: value at [0, 0] is NaN; repair the recording or leave it out (and 1 more \
                 like it)"
            ),
        ]
    );
    assert_eq!((card.nan, card.range), (2, Some([1.0, 6.0])));
    assert!(card.to_string().contains("WRONG"));
    assert!(serde_json::to_string(&card).unwrap().contains("\"problems\":["));
}

#[test]
fn a_card_fits_on_a_screen() {
    // 120 recordings of 60 channels, a class each two: channel 3 is dead, 7 clipped, 9 a thousand times as large.
    let value = |i: usize| {
        let (sample, channel, t) = (i / 1200, i / 20 % 60, i % 20);
        match (channel, ((sample * 31 + channel * 17 + t * 7) % 101) as f32) {
            (3, _) => 5.0,
            (7, value) => value.min(60.0),
            (9, value) => value * 1000.0,
            (_, value) => value,
        }
    };
    let values: Vec<f32> = (0..120 * 1200).map(value).collect();
    let y: Vec<i64> = (0..120).map(|i| i / 2).collect();
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", f32s(&[120, 60, 20], &values)), ("y", i64s(&[120], &y))]);
    let names: Vec<String> = (0..60).map(|i| format!("\"a long name of a thing {i}\"")).collect();
    files(folder.path(), &[("labels.json", &format!("[{}]", names.join(",")))]);
    let text = check(&path).unwrap().to_string();
    assert!(text.lines().count() <= 24, "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert!(text.contains("60; lowest values 0 to 5, highest 5 to 100000\n"), "{text}");
    let listed = |start: &str| text.lines().any(|line| line.trim_start().starts_with(start));
    assert!(listed("3  5..5                  constant"), "{text}");
    assert!(listed("7  0..60") && listed("9  0..100000"), "{text}");
    assert!(!listed("8  0..100") && text.contains("more, listed in JSON"), "{text}");
}

#[test]
fn a_copy_is_named_with_the_one_of_another_label() {
    let folder = tempdir().unwrap();
    let same = [5.0; 4];
    let arrays = [
        ("x", f32s(&[4, 2, 2], &[&same[..], &same, &same, &[1.0, 2.0, 3.0, 4.0]].concat())),
        ("y", i64s(&[4], &[0, 0, 1, 1])),
    ];
    let card = check_with(&npz(folder.path(), &arrays), &ReadOptions::default()).unwrap();
    let copies = card.warnings.iter().find(|warning| warning.contains("another label")).unwrap();
    assert!(copies.contains("x[0] (0) = x[2] (1)"), "{copies}");
}

#[test]
fn a_card_says_how_often_a_channel_stands_still() {
    let folder = tempdir().unwrap();
    // The first channel stands still in two samples of four, the second in none.
    let x: Vec<f32> = (0..4u8)
        .flat_map(|i| [f32::from(i), if i < 2 { f32::from(i) } else { 9.0 }, 1.0, 2.0 + f32::from(i)])
        .collect();
    let arrays = [("x", f32s(&[4, 2, 2], &x)), ("y", i64s(&[4], &[0, 0, 1, 1]))];
    let card = check_with(&npz(folder.path(), &arrays), &ReadOptions::default()).unwrap();
    assert_eq!((card.channels[0].stuck, card.channels[1].stuck), (0.5, 0.0));
}

#[test]
fn a_class_of_five_samples_is_enough_for_five_folds() {
    let folder = tempdir().unwrap();
    let card = |rows: u64, name: &str| {
        let x: Vec<f32> = (0..4 * rows).map(|i| (i * 7 % 41) as f32).collect();
        let y: Vec<i64> = (0..rows as i64).map(|i| i % 2).collect();
        std::fs::create_dir(folder.path().join(name)).unwrap();
        let arrays = [("x", f32s(&[rows, 2, 2], &x)), ("y", i64s(&[rows], &y))];
        check_with(&npz(&folder.path().join(name), &arrays), &ReadOptions::default()).unwrap()
    };
    let is_few = |card: Card| card.warnings.iter().any(|warning| warning.contains("too few for 5 folds"));
    assert!(!is_few(card(10, "five")));
    assert!(is_few(card(8, "four")));
}
