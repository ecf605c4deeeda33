//! Bytes at random: a file is read or refused, never a panic.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{files, i64s, npy, npz, samples, stored};
use proptest::prelude::*;
use std::path::Path;
use taxel_data::{Limits, ReadOptions, check, check_with, load};
use tempfile::tempdir;

/// Whether a read came to an end; the message must name the file.
fn ends(path: &Path) -> bool {
    // Sizes that a test machine decodes at once.
    let limits = Limits { max_values: 1 << 16, ..Limits::default() };
    match check_with(path, &ReadOptions { limits, ..ReadOptions::default() }) {
        Ok(card) => card.to_string().contains("shape"),
        Err(error) => error.to_string().contains(&path.display().to_string()),
    }
}

fn arrays() -> Vec<(&'static str, Vec<u8>)> {
    vec![("x", samples(3)), ("y", i64s(&[3], &[0, 1, 1])), ("group", i64s(&[3], &[0, 1, 1]))]
}

/// Overwrites bytes and cuts the rest off.
fn damage(bytes: &mut Vec<u8>, edits: &[(usize, u8)], cut: Option<usize>) {
    for (at, value) in edits {
        let at = at % bytes.len();
        bytes[at] = *value;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut % bytes.len());
    }
}

fn edits() -> impl Strategy<Value = (Vec<(usize, u8)>, Option<usize>)> {
    let byte = prop_oneof![any::<u8>(), Just(0), Just(0xFF)];
    (prop::collection::vec((any::<usize>(), byte), 1..6), prop::option::weighted(0.2, any::<usize>()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn a_damaged_archive((edits, cut) in edits(), deflated: bool) {
        let folder = tempdir().unwrap();
        let path = npz(folder.path(), &arrays());
        let mut bytes = if deflated { std::fs::read(&path).unwrap() } else { stored(&arrays()) };
        damage(&mut bytes, &edits, cut);
        std::fs::write(&path, bytes).unwrap();
        prop_assert!(ends(&path));
    }

    #[test]
    fn a_damaged_matlab_file((edits, cut) in edits(), compressed: bool) {
        let folder = tempdir().unwrap();
        let path = folder.path().join("grasps.mat");
        let fixture = if compressed { "grasps-v7.mat" } else { "grasps-v6.mat" };
        let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(fixture);
        let mut bytes = std::fs::read(fixture).unwrap();
        damage(&mut bytes, &edits, cut);
        std::fs::write(&path, bytes).unwrap();
        prop_assert!(ends(&path));
    }

    #[test]
    fn a_damaged_header(edits in prop::collection::vec((8usize..128, "[ -~]"), 1..4), big: bool) {
        // Repacked, so that no checksum hides the array from the reader.
        let mut x = npy("<f4", big, &[3, 2, 3], &[0; 72]);
        for (at, character) in edits {
            x[at] = character.as_bytes()[0];
        }
        let folder = tempdir().unwrap();
        let path = folder.path().join("grasps.npz");
        std::fs::write(&path, stored(&[("x", x), ("y", i64s(&[3], &[0, 1, 1]))])).unwrap();
        prop_assert!(ends(&path));
    }

    #[test]
    fn any_header(text in "[{}'a-z<>0-9()\\[\\],: ]{0,60}|.{0,20}") {
        let mut x = b"\x93NUMPY\x01\x00".to_vec();
        x.extend((text.len() as u16).to_le_bytes());
        x.extend(text.as_bytes());
        let folder = tempdir().unwrap();
        let path = folder.path().join("grasps.npz");
        std::fs::write(&path, stored(&[("x", x), ("y", i64s(&[1], &[0]))])).unwrap();
        prop_assert!(ends(&path));
    }

    #[test]
    fn any_labels(y in prop::collection::vec(prop_oneof![-1i64..4, any::<i64>()], 3), names in "\\PC{0,30}|\\[[\"a,\\[\\]]{0,9}\\]") {
        let folder = tempdir().unwrap();
        let path = npz(folder.path(), &[("x", samples(3)), ("y", i64s(&[3], &y)), ("group", i64s(&[3], &y))]);
        prop_assert!(ends(&path));
        files(folder.path(), &[("labels.json", &names)]);
        let named = match check(&path) {
            Ok(_) => true,
            Err(error) => error.to_string().contains("labels.json"),
        };
        prop_assert!(named);
    }

    #[test]
    fn a_damaged_file_of_texts((edits, cut) in edits(), matlab: bool) {
        let name = if matlab { "texts.mat" } else { "texts.npz" };
        let mut bytes = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)).unwrap();
        damage(&mut bytes, &edits, cut);
        let folder = tempdir().unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
        prop_assert!(ends(&folder.path().join(name)));
    }

    #[test]
    fn any_series_and_rule(
        text in "(@data\n)?([0-9,:?'\\\\n\n\t a.-]{0,40}|\\PC{0,20})", ending in "ts|arff|tsv|txt",
        rule in "(resample|pad|crop|window):[0-9]{1,20}(,[0-9a-z]{1,6})?",
    ) {
        let folder = tempdir().unwrap();
        let whole = match ending.as_str() { "ts" => "@data\n1,2:a\n", "arff" => "@data\n1,2,a\n", _ => "a 1 2\n" };
        files(folder.path(), &[(&format!("A_TRAIN.{ending}"), &text), (&format!("A_TEST.{ending}"), whole)]);
        prop_assert!(ends(folder.path()));
        if let Ok(rule) = rule.parse() {
            let limits = Limits { max_values: 1 << 16, ..Limits::default() };
            let ruled = load(folder.path(), &ReadOptions { limits, length: Some(rule), ..ReadOptions::default() });
            prop_assert!(ruled.is_err() || ruled.unwrap().x.iter().all(|value| value.is_finite()));
        }
    }

    #[test]
    fn any_table_of_labels(text in "(file,label(,group)?\n)?[1-3./acsv,\"\n -]{0,40}|\\PC{0,20}") {
        let folder = tempdir().unwrap();
        files(folder.path(), &[("labels.csv", &text), ("1.csv", "1,2\n"), ("2.csv", "1,2\n3,4\n")]);
        prop_assert!(ends(folder.path()));
    }

    #[test]
    fn any_table(text in "[0-9a,;\"\n\r.\t -]{0,40}|\\PC{0,20}") {
        let folder = tempdir().unwrap();
        files(folder.path(), &[("a/1.csv", &text), ("b/1.csv", "1,2\n")]);
        prop_assert!(ends(folder.path()));
    }

    #[test]
    fn a_damaged_image((edits, cut) in edits(), jpeg: bool) {
        let folder = tempdir().unwrap();
        let path = folder.path().join(if jpeg { "a/1.jpg" } else { "a/1.png" });
        std::fs::create_dir(folder.path().join("a")).unwrap();
        image::RgbImage::from_fn(9, 7, |x, y| image::Rgb([x as u8, y as u8, 3])).save(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        damage(&mut bytes, &edits, cut);
        std::fs::write(&path, bytes).unwrap();
        prop_assert!(ends(folder.path()));
        let limits = Limits { max_values: 1 << 16, ..Limits::default() };
        let options = ReadOptions { resize: Some([3, 2]), limits, ..ReadOptions::default() };
        let small = load(folder.path(), &options).map(|data| data.x.shape().to_vec());
        prop_assert!(small.is_err() || small == Ok(vec![1, 3, 2]) || small == Ok(vec![1, 3, 3, 2]));
    }
}
