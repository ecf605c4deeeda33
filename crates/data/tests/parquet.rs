//! Tables in Parquet and sets of LeRobot as pyarrow and pandas write them; sound and broken.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::damaged;
use std::path::{Path, PathBuf};
use taxel_data::{Layout, ReadOptions, check, check_with, load, recordings};
use tempfile::tempdir;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn rule() -> ReadOptions {
    ReadOptions { length: Some("crop:5".parse().unwrap()), ..ReadOptions::default() }
}

#[test]
fn a_long_table_is_that_of_its_csv() {
    let [csv, parquet] = ["long.csv", "long.parquet"].map(|name| load(&fixture(name), &rule()).unwrap());
    assert_eq!((&parquet.digest, parquet.dtype.as_str()), (&csv.digest, "parquet"));
    assert_eq!((parquet.origins, parquet.spec.rate), (csv.origins, csv.spec.rate));
    assert_eq!(
        check(&fixture("long.parquet")).unwrap().read_as,
        check(&fixture("long.csv")).unwrap().read_as
    );
}

#[test]
fn lists_are_columns_of_a_wide_table() {
    let data = load(&fixture("wide.parquet"), &ReadOptions::default()).unwrap();
    assert_eq!((data.x.shape(), data.spec.layout), (&[12, 6][..], Layout::Features));
    assert_eq!(data.x.as_slice().unwrap()[6..12], [1.0, 1.5, 2.0, 2.5, 1.0, 0.0], "taxels, count, contact");
    assert_eq!(
        (data.output_names().join(" "), data.strata().to_vec()[..2].to_vec()),
        ("fig pear".into(), vec![1, 0])
    );
    assert_eq!(data.groups.unwrap()[3..5], [0, 1]);
    let card = check(&fixture("wide.parquet")).unwrap();
    assert_eq!(card.other_arrays, ["note"]);
    let unlabelled = recordings(&fixture("wide.parquet"), &ReadOptions::default(), 1).unwrap();
    assert_eq!(unlabelled.truth.unwrap()[1], ["fig"]);
}

#[test]
fn lerobot_episodes_are_recordings() {
    let root = fixture("lerobot");
    let data = load(&root, &rule()).unwrap();
    assert_eq!((data.x.shape(), data.spec.rate), (&[3, 5, 5][..], Some(10.0)));
    assert_eq!(
        (data.output_names().join(", "), data.strata().to_vec().clone()),
        ("press the sponge, press the can".into(), vec![0, 1, 0])
    );
    assert_eq!(data.origins, ["0", "1", "2"]);
    assert_eq!(
        data.x.as_slice().unwrap()[40..45],
        [100.0, 101.0, 102.0, 103.0, 104.0],
        "tactile.0 of episode 1"
    );
    let card = check_with(&root, &rule()).unwrap();
    assert_eq!(card.read_as[0], "a set of LeRobot: recordings are its episodes");
    assert!(
        card.read_as[1].contains("a reading of 5 channels, recordings by \"episode_index\""),
        "{:?}",
        card.read_as
    );
    assert!(card.ignored.contains(&"column \"action.0\"".to_string()), "{:?}", card.ignored);
    let one = recordings(&root, &rule(), 2).unwrap();
    assert_eq!(one.truth.unwrap()[1], ["press the can"]);

    let folder = tempdir().unwrap();
    let copy = folder.path().join("set");
    for name in ["meta/info.json", "data/chunk-000/file-000.parquet", "data/chunk-000/file-001.parquet"] {
        std::fs::create_dir_all(copy.join(name).parent().unwrap()).unwrap();
        std::fs::copy(root.join(name), copy.join(name)).unwrap();
    }
    assert_eq!(load(&copy, &rule()).unwrap().output_names(), ["0", "1"], "tasks without names");
    std::fs::write(copy.join("labels.csv"), "episode,label\n0,soft\n1,soft\n2,stiff\n").unwrap();
    let labelled = load(&copy, &rule()).unwrap();
    assert_eq!(
        (labelled.output_names().join(" "), labelled.strata().to_vec()),
        ("soft stiff".into(), vec![0, 0, 1])
    );
    let refused = |table: &str| {
        std::fs::write(copy.join("labels.csv"), table).unwrap();
        load(&copy, &rule()).unwrap_err().to_string()
    };
    assert!(
        refused("episode,label\n0,soft\n1,stiff\n")
            .ends_with("set: recording \"2\" has no row in labels.csv")
    );
    assert!(
        refused("a,b\n").ends_with("labels.csv: write a first line episode,label and a line per episode")
    );
    assert!(refused("episode,label\n0,a\n0,b\n").ends_with("episode \"0\" has no label or two rows"));
    std::fs::copy(fixture("wide.parquet"), copy.join("data/chunk-000/file-002.parquet")).unwrap();
    assert!(refused("episode,label\n0,a\n").contains("file-002.parquet: has other columns than "));
}

#[test]
fn a_file_that_is_damaged_anywhere_is_read_or_refused_by_name() {
    let folder = tempdir().unwrap();
    for name in ["long.parquet", "wide.parquet"] {
        let whole = std::fs::read(fixture(name)).unwrap();
        let path = folder.path().join(name);
        for bytes in damaged(&whole, 211, 37) {
            std::fs::write(&path, &bytes).unwrap();
            match check(&path) {
                Ok(_) => assert_eq!(bytes.len(), whole.len()),
                Err(error) => assert!(error.to_string().contains(name), "{error}"),
            }
        }
    }
}
