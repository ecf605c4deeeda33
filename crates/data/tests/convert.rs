//! Every layout as one `.npz`, and back with the same digest and all that is known.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, npz, samples};
use std::fs;
use std::path::{Path, PathBuf};
use taxel_data::{Dataset, Error, ReadOptions, check, convert, load};
use tempfile::{TempDir, tempdir};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// The set before and after.
fn round(path: &Path, options: &ReadOptions) -> [Dataset; 2] {
    let folder = tempdir().unwrap();
    let output = folder.path().join("set.npz");
    convert(path, options, &output).unwrap();
    // What was read under other names has the plain ones now; rules still hold.
    let attributes = options.attributes.clone();
    let plain = ReadOptions { attributes, ..ReadOptions::default() };
    [load(path, options).unwrap(), load(&output, &plain).unwrap()]
}

fn assert_same([before, after]: [Dataset; 2]) {
    assert_eq!(before.digest, after.digest);
    assert_eq!(before.x, after.x);
    assert_eq!(
        (&before.output_names(), &before.strata().to_vec()),
        (&after.output_names(), &after.strata().to_vec())
    );
    assert_eq!((&before.groups, &before.group_name), (&after.groups, &after.group_name));
    assert_eq!((&before.official, &before.origins), (&after.official, &after.origins));
    assert_eq!(
        (&before.targets.labels().unwrap(), &before.units),
        (&after.targets.labels().unwrap(), &after.units)
    );
    let facts = |data: &Dataset| {
        let spec = data.spec.clone();
        (spec.layout, spec.shape, spec.unit, spec.rate, spec.full_scale, data.source.is_simulated())
    };
    assert_eq!(facts(&before), facts(&after));
}

fn named(y: &str) -> ReadOptions {
    ReadOptions { y: Some(y.into()), ..ReadOptions::default() }
}

#[test]
fn arrays_come_back() {
    let folder = tempdir().unwrap();
    let arrays = [("x", samples(4)), ("y", i64s(&[4], &[0, 1, 1, 0])), ("trial", i64s(&[4], &[3, 3, 5, 9]))];
    let path = npz(folder.path(), &arrays);
    let facts = r#"{"classes": ["soft", "hard"], "source": "simulated: pad", "layout": "image", "unit": "N", "rate": 99.5,
                    "full_scale": 100.1}"#;
    files(folder.path(), &[("labels.json", facts)]);
    let options = ReadOptions { group: Some("trial".into()), ..ReadOptions::default() };
    let blocks = ReadOptions { group_block: Some(2), ..options.clone() };
    assert_same(round(&path, &options));
    assert_same(round(&path, &blocks));
    assert_same(round(&path, &ReadOptions { channels: Some(vec![1]), ..ReadOptions::default() }));

    let texts = fixture("texts.npz");
    assert_same(round(
        &texts,
        &ReadOptions { group: Some("session".into()), test: Some("held".into()), ..ReadOptions::default() },
    ));
    assert_same(round(
        &texts,
        &ReadOptions { attributes: ["hand", "thing"].map(String::from).to_vec(), ..named("two") },
    ));
    assert_same(round(&fixture("split.npz"), &ReadOptions::default()));
    for name in ["grasps-v6.mat", "grasps-v7.mat", "texts.mat"] {
        assert_same(round(&fixture(name), &ReadOptions::default()));
    }
    assert_same(round(&fixture("one-hot.mat"), &ReadOptions::default()));
}

#[test]
fn folders_and_archives_come_back() {
    let folder = tempdir().unwrap();
    let (one, two) = ("1,2\n3,4\n", "5,6\n7,-0.0\n");
    files(
        folder.path(),
        &[
            ("nested/b/day1/1.csv", one),
            ("nested/a/day1/1.csv", two),
            ("nested/a/day2/1.csv", one),
            ("listed/1.csv", one),
            ("listed/2.csv", two),
            ("listed/labels.csv", "file,label,group\n2.csv,x,g\n1.csv,y,h\n"),
            ("Two/Two_TRAIN.ts", "@data\n1,2:3,4:run\n5,6:7,8:10\n"),
            ("Two/Two_TEST.ts", "@data\n0.5,-1e1:2,2:2\n"),
            ("wide.csv", "object,f,g,label\ncan,1,2,0\nmug,3,4,1\n"),
        ],
    );
    for name in ["nested", "listed", "Two", "wide.csv"] {
        assert_same(round(&folder.path().join(name), &ReadOptions::default()));
    }
    assert_same(round(
        &folder.path().join("wide.csv"),
        &ReadOptions { group: Some("object".into()), ..ReadOptions::default() },
    ));
    let image = |name: &str, value: u8| {
        fs::create_dir_all(folder.path().join("images").join(name)).unwrap();
        let pixels = image::GrayImage::from_fn(3, 2, |x, y| image::Luma([value + (x + 2 * y) as u8]));
        pixels.save(folder.path().join("images").join(name).join("1.png")).unwrap();
    };
    image("dark", 3);
    image("light", 200);
    assert_same(round(&folder.path().join("images"), &ReadOptions::default()));
}

/// Recordings of one to four readings.
fn unequal() -> TempDir {
    let folder = tempdir().unwrap();
    let rows = ["1,10\n", "2,20\n", "3,30\n", "4,40\n"];
    for n in 1..=4 {
        files(folder.path(), &[(&format!("set/{}/{n}.csv", n % 2), &rows[..n].concat())]);
    }
    folder
}

#[test]
fn unequal_recordings_end_in_nan_and_come_back_unequal() {
    let folder = unequal();
    let (set, output) = (folder.path().join("set"), folder.path().join("set.npz"));
    let written = convert(&set, &ReadOptions::default(), &output).unwrap();
    assert_eq!((written.shape, written.padded), (vec![4, 2, 4], Some([1, 4])));
    assert_eq!(check(&output).unwrap().lengths, check(&set).unwrap().lengths);
    for rule in ["resample:3", "pad:5,edge", "crop:1,end", "window:2,1"] {
        let options = ReadOptions { length: Some(rule.parse().unwrap()), ..ReadOptions::default() };
        let [before, after] = [&set, &output].map(|path| load(path, &options).unwrap());
        assert_same([before, after]);
        // Or under the rule at once.
        let ruled = folder.path().join("ruled.npz");
        assert_eq!(convert(&set, &options, &ruled).unwrap().padded, None);
        assert_eq!(
            load(&ruled, &ReadOptions::default()).unwrap().digest,
            load(&set, &options).unwrap().digest
        );
    }
    // One array per recording; irregular stamps of a long table; time first.
    let options = ReadOptions { length: Some("resample:8".parse().unwrap()), ..ReadOptions::default() };
    for name in ["each.npz", "padded.npz", "long.csv"] {
        let plain = folder.path().join("plain.npz");
        convert(&fixture(name), &ReadOptions::default(), &plain).unwrap();
        assert_same([fixture(name), plain].map(|path| load(&path, &options).unwrap()));
    }
    let frames: Vec<f32> = (0..24).map(|v| if (8..12).contains(&v) { f32::NAN } else { v as f32 }).collect();
    let path = npz(folder.path(), &[("x", f32s(&[2, 3, 2, 2], &frames)), ("y", i64s(&[2], &[0, 1]))]);
    convert(&path, &ReadOptions::default(), &output).unwrap();
    assert_same([path, output].map(|path| load(&path, &options).unwrap()));
}

#[test]
fn what_cannot_be_converted_leaves_nothing() {
    let folder = unequal();
    let at = |name: &str| folder.path().join(name);
    let error = convert(&at("set"), &ReadOptions::default(), &at("set.csv")).unwrap_err().to_string();
    assert!(error.ends_with("set.csv: output: is the name of a .npz file to write"), "{error}");
    files(folder.path(), &[("bad/a/1.csv", "1,2\n"), ("bad/b/1.csv", "1,inf\n")]);
    let error = convert(&at("bad"), &ReadOptions::default(), &at("bad.npz")).unwrap_err();
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
    assert!(!at("bad.npz").exists() && !at("bad.classes.json").exists());
    let error = convert(&at("set"), &ReadOptions::default(), &at("none/set.npz")).unwrap_err().to_string();
    assert!(error.contains("none/set.classes.json: cannot be written"), "{error}");
    // Origins of another number of samples.
    convert(&at("set"), &ReadOptions::default(), &at("set.npz")).unwrap();
    let names = fs::read_to_string(at("set.classes.json")).unwrap();
    fs::write(at("set.classes.json"), names.replacen("\"0/2.csv\",", "", 1)).unwrap();
    let error = check(&at("set.npz")).unwrap_err().to_string();
    assert!(error.contains("has 3 entries but x has 4 samples"), "{error}");
}
