//! Pairs of `_TRAIN` and `_TEST` files.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;
use taxel_data::{ReadOptions, load};

fn write(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).unwrap();
}

#[test]
fn a_ts_pair_is_read_with_its_split() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "Two_TRAIN.ts", "#note\n@problemName Two\n@data\n1,2,3:4,5,6:run\n7,8,9:1,1,2:10\n");
    write(dir.path(), "Two_TEST.ts", "@data\n0.5,-1e1,3:4,5,6:2\n");
    let data = load(&dir.path().join("Two"), &ReadOptions::default()).unwrap();
    assert_eq!(data.x.shape(), [3, 2, 3]);
    assert_eq!(data.x.as_slice().unwrap()[..6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(data.output_names(), ["2", "10", "run"]);
    assert_eq!(data.strata().to_vec(), [2, 1, 0]);
    assert_eq!(data.official, Some(vec![false, false, true]));
    assert_eq!((data.name.as_str(), data.origins[2].as_str()), ("Two", "Two_TEST.ts[0]"));
    let same = load(&dir.path().join("Two_TEST.ts"), &ReadOptions::default()).unwrap();
    assert_eq!((same.name, same.digest), (data.name, data.digest));
}

#[test]
fn labels_json_beside_the_files_is_read() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "Plain_TRAIN.txt", "a 0.5 0.25\nb 2 3\n");
    write(dir.path(), "Plain_TEST.txt", "a,4,5\n");
    write(dir.path(), "labels.json", r#"{"classes": ["b", "a"], "unit": "mV", "rate": 50}"#);
    let data = load(&dir.path().join("Plain"), &ReadOptions::default()).unwrap();
    assert_eq!((data.strata().to_vec(), data.output_names().join(" ")), (vec![1, 0, 1], "b a".to_string()));
    assert_eq!((data.spec.unit.as_deref(), data.spec.rate), (Some("mV"), Some(50.0)));
    write(dir.path(), "Plain.classes.json", r#"["b", "c"]"#);
    let text = load(&dir.path().join("Plain"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(text.contains("Plain.classes.json: names the classes b, c, but they are a, b"), "{text}");
}

#[test]
fn plain_text_has_the_class_first() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "Plain_TRAIN.txt", "  1.0000000e+00  0.5 0.25\n -1 2 3\n\n");
    write(dir.path(), "Plain_TEST.txt", "1,4,5\n");
    let data = load(&dir.path().join("Plain"), &ReadOptions::default()).unwrap();
    assert_eq!(
        (data.x.shape(), data.strata().to_vec().as_slice()),
        ([3, 1, 2].as_slice(), [1, 0, 1].as_slice())
    );
    assert_eq!(data.output_names(), ["-1", "1"]);
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    let dir = tempfile::tempdir().unwrap();
    let message = |train: &str| {
        write(dir.path(), "Bad_TRAIN.ts", train);
        write(dir.path(), "Bad_TEST.ts", "@data\n1,2:a\n");
        load(&dir.path().join("Bad"), &ReadOptions::default()).unwrap_err().to_string()
    };
    let text = message("@data\n1,2:a\n1,x:b\n");
    assert!(text.contains("Bad_TRAIN.ts: line 3, column 2: \"x\" is not a number"), "{text}");
    let text = message("@data\n1,?:a\n");
    assert!(text.contains("missing values are not supported"), "{text}");
    let text = message("@data\n1,2\n");
    assert!(text.contains("line 2 holds no values with a class"), "{text}");
    let text = message("@data\n1,2,3:a\n");
    assert!(text.contains("recordings have 2 to 3 readings; say what to do"), "{text}");
    let text = message("@data\n1,2,3:4,5:a\n");
    assert!(text.contains("Bad_TRAIN.ts[0]: its channels have [3, 2] values"), "{text}");
    let text = message("@data\n1,2:3,4:a\n");
    assert!(text.contains("Bad_TEST.ts[0]: has shape [1, 2], but Bad_TRAIN.ts[0] has [2, 2]"), "{text}");
    let text = message("@data\n");
    assert!(text.contains("Bad_TRAIN.ts: holds no samples"), "{text}");
    write(dir.path(), "Bad_TRAIN.ts", "@data\n1,2:a\n");
    let options = ReadOptions { group: Some("g".into()), ..ReadOptions::default() };
    let text = load(&dir.path().join("Bad"), &options).unwrap_err().to_string();
    assert!(text.contains("group: does not apply"), "{text}");
    let options = ReadOptions { test_above: Some(3), ..ReadOptions::default() };
    let text = load(&dir.path().join("Bad"), &options).unwrap_err().to_string();
    assert!(text.contains("test_above: does not apply"), "{text}");
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn the_shared_sets_have_their_cards_sizes() {
    let folder = Path::new(&std::env::var("TAXEL_DATA").expect("TAXEL_DATA")).join("ucr-small");
    for (name, train, shape, classes) in [
        ("GunPoint", 50, [200, 1, 150], 2),
        ("Coffee", 28, [56, 1, 286], 2),
        ("ItalyPowerDemand", 67, [1096, 1, 24], 2),
        ("BasicMotions", 40, [80, 6, 100], 4),
    ] {
        let data = load(&folder.join(name), &ReadOptions::default()).unwrap();
        assert_eq!(data.x.shape(), shape, "{name}");
        assert_eq!(data.output_names().len(), classes, "{name}");
        let test = data.official.unwrap();
        assert_eq!(test.iter().filter(|t| !**t).count(), train, "{name}");
    }
}
