//! Sound `.npz` archives and what to read from them.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, labels, npy, npz, refused, samples, stored};
use taxel_data::{Drop, ReadOptions, check, check_with, load};
use tempfile::tempdir;

#[test]
fn an_archive_is_read_deflated_and_stored() {
    let folder = tempdir().unwrap();
    let arrays = [("x", samples(4)), ("y", labels()), ("group", i64s(&[4], &[7, 7, 9, 9])), ("t", labels())];
    let deflated = load(&npz(folder.path(), &arrays), &ReadOptions::default()).unwrap();
    assert_eq!(deflated.x.shape(), [4, 2, 3]);
    assert_eq!(deflated.x[[3, 1, 2]], 23.0);
    assert_eq!(deflated.strata().to_vec(), [0, 1, 1, 0]);
    assert_eq!(deflated.output_names(), ["0", "1"]);
    assert_eq!(deflated.groups, Some(vec![7, 7, 9, 9]));
    assert_eq!(deflated.group_name.as_deref(), Some("group"));
    assert_eq!((deflated.name.as_str(), deflated.origins[3].as_str()), ("grasps", "x[3]"));
    std::fs::write(folder.path().join("grasps.npz"), stored(&arrays)).unwrap();
    let plain = load(&folder.path().join("grasps.npz"), &ReadOptions::default()).unwrap();
    assert_eq!(plain, deflated);
    let card = check(&folder.path().join("grasps.npz")).unwrap();
    assert_eq!(card.other_arrays, ["t"]);
    assert!(card.to_string().contains("\nalso holds  t (group"), "{card}");

    // As data.npz it goes by its folder; the content and so the digest are the same.
    std::fs::rename(folder.path().join("grasps.npz"), folder.path().join("data.npz")).unwrap();
    let named = load(folder.path(), &ReadOptions::default()).unwrap();
    assert_eq!(named.name, folder.path().file_name().unwrap().to_string_lossy());
    assert_eq!(named.digest, deflated.digest);
    let group = ReadOptions { group: Some("t".into()), ..ReadOptions::default() };
    assert_ne!(load(folder.path(), &group).unwrap().digest, deflated.digest);
}

#[test]
fn every_type_and_order_of_number_is_read() {
    let integers: Vec<i64> = (0..24).collect();
    macro_rules! bytes {
        ($type:ty, $to:ident) => {
            integers.iter().flat_map(|v| (*v as $type).$to()).collect::<Vec<u8>>()
        };
    }
    let cases = [
        ("|u1", bytes!(u8, to_le_bytes)),
        ("|i1", bytes!(i8, to_le_bytes)),
        ("<u2", bytes!(u16, to_le_bytes)),
        (">i2", bytes!(i16, to_be_bytes)),
        ("<u4", bytes!(u32, to_le_bytes)),
        (">i4", bytes!(i32, to_be_bytes)),
        (">u8", bytes!(u64, to_be_bytes)),
        ("<i8", bytes!(i64, to_le_bytes)),
        (">f4", bytes!(f32, to_be_bytes)),
        ("<f8", bytes!(f64, to_le_bytes)),
        (">f8", bytes!(f64, to_be_bytes)),
    ];
    let folder = tempdir().unwrap();
    let want =
        load(&npz(folder.path(), &[("x", samples(4)), ("y", labels())]), &ReadOptions::default()).unwrap();
    for (descr, data) in cases {
        let path = npz(folder.path(), &[("x", npy(descr, false, &[4, 2, 3], &data)), ("y", labels())]);
        let got = load(&path, &ReadOptions::default()).unwrap();
        assert_eq!(got.x, want.x, "{descr}");
        assert_eq!((&got.row_hash, &got.digest, got.dtype.as_str()), (&want.row_hash, &want.digest, descr));
    }
    // Fortran order: the first index runs fastest.
    let mut fortran = Vec::new();
    for k in 0..3 {
        for j in 0..2 {
            for i in 0..4 {
                fortran.extend(((i * 6 + j * 3 + k) as f32).to_le_bytes());
            }
        }
    }
    let path = npz(folder.path(), &[("x", npy("<f4", true, &[4, 2, 3], &fortran)), ("y", labels())]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().x, want.x);
    let negative = npy("|i1", false, &[2, 2], &[0xFF, 0x80, 0, 1]);
    let path = npz(folder.path(), &[("x", negative), ("y", npy("|b1", false, &[2], &[0, 1]))]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().x.as_slice().unwrap()[..2], [-1.0, -128.0]);
}

#[test]
fn class_names_come_from_the_nearer_file() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    files(folder.path(), &[("labels.json", r#"{"classes": ["apple", "pear"]}"#)]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().output_names(), ["apple", "pear"]);
    files(folder.path(), &[("grasps.classes.json", r#"["soft", "stiff"]"#)]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().output_names(), ["soft", "stiff"]);
}

#[test]
fn the_file_of_names_may_say_how_high_readings_go() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().spec.full_scale, None);
    files(folder.path(), &[("labels.json", r#"{"classes": ["a", "b"], "full_scale": 255}"#)]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().spec.full_scale, Some(255.0));
    files(folder.path(), &[("labels.json", r#"{"classes": ["a", "b"], "full_scale": -1}"#)]);
    let message = refused(&path, &ReadOptions::default());
    assert!(message.starts_with("labels.json: full_scale is -1, not a number above 0"), "{message}");
}

#[test]
fn channels_are_selected_along_axis_1() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    let with =
        |channels: &[usize]| ReadOptions { channels: Some(channels.to_vec()), ..ReadOptions::default() };
    let data = load(&path, &with(&[1])).unwrap();
    assert_eq!(data.x.shape(), [4, 1, 3]);
    assert_eq!(data.x[[3, 0, 2]], 23.0);
    let swapped = load(&path, &with(&[1, 0])).unwrap();
    assert_eq!((swapped.x[[0, 0, 0]], swapped.x.is_standard_layout()), (3.0, true));
    assert_ne!(swapped.row_hash, data.row_hash, "copies are sought in what is trained on");
    assert_eq!(
        refused(&path, &with(&[0, 2])),
        "grasps.npz: channels: 2 is out of range: axis 1 of [4, 2, 3] has 0..1"
    );
    assert_eq!(
        refused(&path, &with(&[1, 1])),
        "grasps.npz: channels: 1 is listed twice; name each channel once"
    );
    assert_eq!(
        refused(&path, &with(&[])),
        "grasps.npz: channels = []: name at least one channel, or leave the key out"
    );
}

#[test]
fn group_values_are_divided_into_blocks() {
    let folder = tempdir().unwrap();
    let trials = i64s(&[6], &[1, 2, 12, 13, 24, 25]);
    let path =
        npz(folder.path(), &[("x", samples(6)), ("y", i64s(&[6], &[0, 0, 0, 1, 1, 1])), ("trial", trials)]);
    let mut options =
        ReadOptions { group: Some("trial".into()), group_block: Some(12), ..ReadOptions::default() };
    let data = load(&path, &options).unwrap();
    assert_eq!(data.groups, Some(vec![0, 0, 0, 1, 1, 2]));
    assert_eq!(data.group_name.as_deref(), Some("trial/12"));
    options.group_block = Some(0);
    let why = "is the number of consecutive values in a block, from 1";
    assert_eq!(refused(&path, &options), format!("grasps.npz: group_block: {why}"));
    let far = i64s(&[6], &[i64::MIN, i64::MAX, 0, 0, 0, 0]);
    let path =
        npz(folder.path(), &[("x", samples(6)), ("y", i64s(&[6], &[0, 0, 0, 1, 1, 1])), ("trial", far)]);
    options.group_block = Some(1);
    let message = refused(&path, &options);
    assert!(message.starts_with("grasps.npz: trial[1] = 9223372036854775807 is not a group"), "{message}");
}

#[test]
fn several_attributes_are_kept_and_one_is_the_label() {
    let folder = tempdir().unwrap();
    let y = i64s(&[4, 2], &[0, 2, 1, 0, 1, 1, 0, 2]);
    let path = npz(folder.path(), &[("x", samples(4)), ("y", y.clone())]);
    let first = ReadOptions { attribute: Some(0), ..ReadOptions::default() };
    let data = load(&path, &first).unwrap();
    assert_eq!(data.strata().to_vec(), [0, 1, 1, 0]);
    let columns = data.targets.columns().unwrap();
    assert_eq!(columns.values(), [0, 2, 1, 0, 1, 1, 0, 2]);
    assert_eq!(columns.attributes()[1].classes, ["0", "1", "2"]);
    assert_eq!((columns.sizes(), columns.len()), (vec![2, 3], 4));
    let names: Vec<&str> = columns.attributes().iter().map(|a| a.name.as_str()).collect();
    assert_eq!(names, ["attribute-0", "attribute-1"]);
    assert_eq!(
        (
            data.targets.labels().unwrap().attributes()[0].name.as_str(),
            data.targets.labels().unwrap().values()
        ),
        ("class", &data.strata().to_vec()[..])
    );
    files(folder.path(), &[("labels.json", r#"{"classes": [["soft", "stiff"], ["a", "b", "c"]]}"#)]);
    let mut options = ReadOptions { attribute: Some(1), ..ReadOptions::default() };
    let data = load(&path, &options).unwrap();
    assert_eq!(
        (data.strata().to_vec(), data.output_names()),
        (vec![2, 0, 1, 2], vec!["a".into(), "b".into(), "c".into()])
    );
    options.attribute = Some(2);
    assert_eq!(refused(&path, &options), "grasps.npz: attribute = 2 is out of range: y has 2 columns (0..1)");
    let y = i64s(&[4, 2], &[0, 2, 1, 0, 1, 3, 0, 1]);
    let path = npz(folder.path(), &[("x", samples(4)), ("y", y)]);
    assert_eq!(
        refused(&path, &ReadOptions::default()),
        "grasps.npz: y[2, 1] = 3 is out of range: labels.json names 3 classes (0..2)"
    );
    // In Fortran order columns follow each other.
    let bytes: Vec<u8> = [0i64, 1, 1, 0, 2, 0, 1, 2].iter().flat_map(|v| v.to_le_bytes()).collect();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", npy("<i8", true, &[4, 2], &bytes))]);
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().targets.columns().unwrap().of(&[2]), [1, 1]);
    let path = npz(folder.path(), &[("x", samples(4)), ("y", i64s(&[4, 1], &[0, 1, 1, 0]))]);
    std::fs::remove_file(folder.path().join("labels.json")).unwrap();
    assert_eq!(load(&path, &ReadOptions::default()).unwrap().targets.columns(), None);
}

#[test]
fn copies_are_dropped_on_request() {
    // Rows 0 and 2 contradict each other, 3 repeats 1, in all channels; 4 only in channel 0.
    let rows = [[1.0, 9.0], [2.0, 9.0], [1.0, 9.0], [2.0, 9.0], [2.0, 0.0], [-0.0, 0.0], [0.0, 0.0]];
    let x = f32s(&[7, 2, 1], rows.as_flattened());
    let y = [0, 1, 1, 1, 0, 1, 1];
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", x.clone()), ("y", i64s(&[7], &y))]);
    let with = |drop: &[Drop]| ReadOptions { drop: drop.to_vec(), ..ReadOptions::default() };
    let all = load(&path, &with(&[])).unwrap();
    assert_eq!(all.units.unwrap(), [0, 1, 0, 1, 4, 5, 5]);
    // What is not trained on makes no difference.
    let first = |drop: &[Drop]| ReadOptions { channels: Some(vec![0]), ..with(drop) };
    assert_eq!(load(&path, &first(&[])).unwrap().units.unwrap(), [0, 1, 0, 1, 1, 5, 5]);
    assert_eq!(check_with(&path, &first(&[Drop::Contradictory])).unwrap().shape[0], 2);
    let kept = |drop: &[Drop]| load(&path, &with(drop)).unwrap().origins.join(" ");
    assert_eq!(kept(&[Drop::Contradictory]), "x[1] x[3] x[4] x[5] x[6]");
    assert_eq!(kept(&[Drop::Duplicates]), "x[0] x[1] x[2] x[4] x[5]");
    let data = load(&path, &with(&[Drop::Duplicates, Drop::Contradictory])).unwrap();
    assert_eq!(data.origins, ["x[1]", "x[4]", "x[5]"]);
    assert_eq!(data.dropped, ["x[0]", "x[2]", "x[3]", "x[6]"]);
    assert_eq!(data.x.as_slice().unwrap(), [2.0, 9.0, 2.0, 0.0, -0.0, 0.0]);
    assert_eq!((data.strata().to_vec().len(), data.row_hash.len()), (3, 3));

    let deny = ReadOptions { deny_contradictory: true, ..ReadOptions::default() };
    assert_eq!(
        refused(&path, &deny),
        "grasps.npz: x[0] (0) and x[2] (1) are the same recording, 2 such rows; set drop = \
         [\"contradictory\"]"
    );
    let fixed = ReadOptions { drop: vec![Drop::Contradictory], ..deny };
    load(&path, &fixed).unwrap();
    let path = npz(folder.path(), &[("x", x), ("y", i64s(&[7], &[0, 1, 2, 1, 0, 1, 1]))]);
    assert_eq!(
        refused(&path, &fixed),
        "grasps.npz: no sample in y has label 2; all of them were dropped: drop less or remove the class"
    );
    let path = npz(folder.path(), &[("x", f32s(&[2, 1], &[1.0; 2])), ("y", i64s(&[2], &[0, 1]))]);
    assert_eq!(refused(&path, &fixed), "grasps.npz: after drop: holds no samples");
}

#[test]
fn samples_above_a_number_are_tested() {
    let folder = tempdir().unwrap();
    let path =
        npz(folder.path(), &[("x", samples(4)), ("y", labels()), ("trial", i64s(&[4], &[1, 15, 16, 60]))]);
    let options = |test: Option<&str>, test_above| ReadOptions {
        test: test.map(String::from),
        test_above,
        ..ReadOptions::default()
    };
    let official = |test_above| load(&path, &options(Some("trial"), test_above)).unwrap().official.unwrap();
    assert_eq!(official(Some(15)), [false, false, true, true]);
    let error = load(&path, &options(Some("trial"), Some(60))).unwrap_err().to_string();
    assert!(error.contains("test_above: leaves no or all samples to test"), "{error}");
    let error = load(&path, &options(None, Some(15))).unwrap_err().to_string();
    assert!(error.contains("test_above: needs the name of an array in test"), "{error}");
}
