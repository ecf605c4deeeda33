//! Broken `.npz` archives: each has its message.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, labels, npy, npz, refused, refused_arrays, samples, stored};
use taxel_data::{Limits, ReadOptions, check, formats};
use tempfile::tempdir;

#[test]
fn a_broken_path_or_archive_is_refused() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let default = ReadOptions::default();
    let message = refused(&at("none.npz"), &default);
    assert!(
        message.starts_with("none.npz: no such file or folder; give a .ts, .tsv, .txt, .arff, .npz,"),
        "{message}"
    );
    let end = "or .jpeg, a folder with data.npz, or a folder with one sub-folder per class";
    assert!(message.ends_with(end), "{message}");
    // Each format that is read is named.
    for ending in formats().flat_map(|format| format.endings) {
        assert!(message.contains(&format!(".{ending}")), "{ending}: {message}");
    }
    std::fs::write(at("x.npy"), samples(4)).unwrap();
    assert_eq!(
        refused(&at("x.npy"), &default),
        "x.npy: not a data set; give a .ts, .tsv, .txt, .arff, .npz, .csv, .parquet, .pq, .mat, .h5 or .hdf5 with labels, \
         or a folder with one sub-folder per class"
    );
    std::fs::write(at("empty.npz"), "").unwrap();
    assert_eq!(refused(&at("empty.npz"), &default), "empty.npz: is empty (0 bytes); copy or record it again");
    std::fs::write(at("text.npz"), "x,y\n1,2\n").unwrap();
    let message = refused(&at("text.npz"), &default);
    assert!(message.starts_with("text.npz: is not a .npz archive (invalid zip archive"), "{message}");
    std::fs::create_dir(at("folder.npz")).unwrap();
    let message = refused(&at("folder.npz"), &default);
    assert_eq!(message, "folder.npz: holds neither data.npz nor class folders");

    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    let whole = std::fs::read(&path).unwrap();
    for len in [whole.len() - 1, whole.len() / 2, 5] {
        std::fs::write(&path, &whole[..len]).unwrap();
        let message = refused(&path, &default);
        assert!(message.starts_with("grasps.npz: is cut short or damaged ("), "{message}");
        assert!(message.ends_with("; copy it again"), "{message}");
    }
    // One bit of the values: only the archive's checksum can tell.
    let mut bytes = stored(&[("x", samples(4)), ("y", labels())]);
    bytes[250] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let message = refused(&path, &default);
    assert_eq!(message, "grasps.npz: x: data are damaged (invalid checksum); copy the file again");
}

#[test]
fn a_missing_array_is_named() {
    assert_eq!(
        refused_arrays(&[("y", labels()), ("images", samples(4))]),
        "grasps.npz: no array x: it holds images <f4 [4, 2, 3], y <i8 [4]; name yours with x = \"...\""
    );
    assert_eq!(
        refused_arrays(&[("x", samples(4))]),
        "grasps.npz: no array y: it holds x <f4 [4, 2, 3]; name yours with y = \"...\""
    );
    assert_eq!(
        refused_arrays(&[]),
        "grasps.npz: no array x: it holds no arrays; name yours with x = \"...\""
    );
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    let options = ReadOptions { group: Some("session".into()), ..ReadOptions::default() };
    assert_eq!(
        refused(&path, &options),
        "grasps.npz: no array session: it holds x <f4 [4, 2, 3], y <i8 [4]; name yours with group = \"...\""
    );
    let options = ReadOptions { group_block: Some(12), ..ReadOptions::default() };
    assert_eq!(
        refused(&path, &options),
        "grasps.npz: group_block: needs an array to divide into blocks; name it with group = \"trial\""
    );
    let options = ReadOptions { resize: Some([2, 2]), ..ReadOptions::default() };
    assert!(refused(&path, &options).starts_with("grasps.npz: resize: applies to a folder of PNG or JPEG"));
}

#[test]
fn a_wrong_type_is_refused() {
    let x = "samples are booleans, u8..u64, i8..i64, f16, f32 or f64: convert it, one array for all samples";
    for descr in ["<U3", "|S4", "<c8", "<f16", "<M8[ns]", "[('a', '<f4'), ('b', '<i4')]"] {
        assert_eq!(
            refused_arrays(&[("x", npy(descr, false, &[4, 2, 3], &[0; 96])), ("y", labels())]),
            format!("grasps.npz: x: has dtype {descr}; {x}")
        );
    }
    let y = npy("<M8[ns]", false, &[4], &[0; 32]);
    assert_eq!(
        refused_arrays(&[("x", samples(4)), ("y", y)]),
        "grasps.npz: y: has dtype <M8[ns]; labels are whole numbers from 0: save y as an integer array, or \
         say task = \"values\" (--task values) if it is measured"
    );
    let y = npy("<f8", false, &[4], &[0; 32]);
    assert_eq!(
        refused_arrays(&[("x", samples(4)), ("y", labels()), ("group", y)]),
        "grasps.npz: group: has dtype <f8; groups are whole numbers: save them as an integer array"
    );
    let huge = npy("<u8", false, &[1], &[0xFF; 8]);
    assert_eq!(
        refused_arrays(&[("x", samples(1)), ("y", huge)]),
        "grasps.npz: y[0] = 18446744073709551615 does not fit a signed 64-bit integer"
    );
}

#[test]
fn a_value_that_f32_cannot_hold_is_refused() {
    let fits =
        "does not fit f32 (integers to 2^24 = 16777216, floats to 3.4e38); rescale it or save it as f32";
    let mut values = vec![1 << 24; 24];
    values[22] = -(1 << 24) - 1;
    assert_eq!(
        refused_arrays(&[("x", i64s(&[4, 2, 3], &values)), ("y", labels())]),
        format!("grasps.npz: x[3, 1, 1] = -16777217 {fits}")
    );
    let mut data: Vec<u8> = 1e39f64.to_le_bytes().repeat(2);
    data[..8].copy_from_slice(&3.4e38f64.to_le_bytes());
    assert_eq!(
        refused_arrays(&[("x", npy("<f8", false, &[1, 2], &data)), ("y", i64s(&[1], &[0]))]),
        format!("grasps.npz: x[0, 1] = 1e39 {fits}")
    );
}

#[test]
fn a_wrong_shape_or_length_is_refused() {
    let y = || ("y", labels());
    let rank = "samples are [N, C, T], [N, H, W] or [N, T, H, W], samples first";
    assert_eq!(
        refused_arrays(&[("x", f32s(&[4], &[0.0; 4])), y()]),
        format!("grasps.npz: x: has shape [4]; {rank}")
    );
    assert_eq!(
        refused_arrays(&[("x", f32s(&[1; 5], &[0.0])), y()]),
        format!("grasps.npz: x: has shape [1, 1, 1, 1, 1]; {rank}")
    );
    assert_eq!(refused_arrays(&[("x", f32s(&[0, 2], &[])), y()]), "grasps.npz: x: holds no samples");
    assert_eq!(
        refused_arrays(&[("x", f32s(&[4, 0, 3], &[])), y()]),
        "grasps.npz: x: has shape [4, 0, 3]: axis 1 is empty; there is nothing to learn from"
    );
    assert_eq!(
        refused_arrays(&[("x", samples(4)), ("y", i64s(&[], &[1]))]),
        "grasps.npz: y: has shape []; labels are [N], or [N, k] for k attributes"
    );
    assert_eq!(
        refused_arrays(&[("x", samples(5)), y()]),
        "grasps.npz: y has 4 entries but x has 5 samples; one per sample"
    );
    assert_eq!(
        refused_arrays(&[("x", samples(4)), y(), ("group", i64s(&[3], &[0; 3]))]),
        "grasps.npz: group has 3 entries but x has 4 samples; one per sample"
    );
    assert_eq!(
        refused_arrays(&[("x", samples(4)), y(), ("group", i64s(&[4, 1], &[0; 4]))]),
        "grasps.npz: group: has shape [4, 1]; groups are [N], one whole number per sample"
    );
    assert_eq!(
        refused_arrays(&[("x", samples(4)), y(), ("group", i64s(&[4], &[0, 1, -1, 2]))]),
        "grasps.npz: group[2] = -1 is not a group number (0..4294967295); use group_block"
    );
}

#[test]
fn a_header_that_promises_what_is_not_there_is_refused() {
    let y = || ("y", labels());
    let all = "save fewer or smaller samples or raise limits.max_values";
    assert_eq!(
        refused_arrays(&[("x", f32s(&[4, 1 << 40, 1 << 40], &[0.0])), y()]),
        format!(
            "grasps.npz: x: shape [4, 1099511627776, 1099511627776] is more than the 268435456 values \
             allowed; {all}"
        )
    );
    assert_eq!(
        refused_arrays(&[("x", f32s(&[4, 2, 3], &[0.0; 23])), y()]),
        "grasps.npz: x: data end after 92 of 96 bytes; the file is cut short, copy it again"
    );
    assert_eq!(
        refused_arrays(&[("x", f32s(&[2, 1 << 26], &[0.0; 23])), y()]),
        "grasps.npz: x: data end after 92 of 536870912 bytes; the file is cut short, copy it again"
    );
    assert_eq!(
        refused_arrays(&[("x", f32s(&[4, 2, 3], &[0.0; 25])), y()]),
        "grasps.npz: x: holds more than the 96 bytes that its shape [4, 2, 3] takes; save it again"
    );
    let way_out = "write it with numpy.save or numpy.savez";
    let cases: [(&[u8], &str); 5] = [
        (b"", "its header is cut short"),
        (b"not a numpy array", "it does not start with \\x93NUMPY"),
        (b"\x93NUMPY\x09\x00\x00\x00", "its format version is not 1, 2 or 3"),
        (b"\x93NUMPY\x02\x00\xff\xff\xff\xff", "its header claims more than a megabyte"),
        (b"\x93NUMPY\x01\x00\x02\x00{}", "its header is not {'descr', 'fortran_order', 'shape'}"),
    ];
    for (bytes, why) in cases {
        assert_eq!(
            refused_arrays(&[("x", bytes.to_vec()), y()]),
            format!("grasps.npz: x: is not a NumPy array ({why}); {way_out}")
        );
    }
    let folder = tempdir().unwrap();
    let options =
        ReadOptions { limits: Limits { max_values: 23, ..Limits::default() }, ..ReadOptions::default() };
    let message = refused(&npz(folder.path(), &[("x", samples(4)), y()]), &options);
    assert_eq!(message, format!("grasps.npz: x: shape [4, 2, 3] is more than the 23 values allowed; {all}"));
    let few = |max_samples| ReadOptions {
        limits: Limits { max_samples, ..Limits::default() },
        ..ReadOptions::default()
    };
    let message = refused(&npz(folder.path(), &[("x", samples(4)), y()]), &few(3));
    assert_eq!(message, "grasps.npz: x: 4 samples are more than the 3 allowed; raise limits.max_samples");
    let more = "save fewer samples or raise limits.max_samples";
    let y = ("y", i64s(&[5], &[0; 5]));
    let message = refused(&npz(folder.path(), &[("x", samples(4)), y]), &few(4));
    assert_eq!(message, format!("grasps.npz: y: shape [5] is more than the 4 values allowed; {more}"));
    let y = ("y", i64s(&[1, 3], &[0; 3]));
    let message = refused(&npz(folder.path(), &[("x", samples(4)), y]), &few(4));
    assert_eq!(message, "grasps.npz: y has 1 entries but x has 4 samples; one per sample");
}

#[test]
fn a_value_that_is_not_finite_is_refused_by_sample_and_place() {
    let mut values = [0.5; 24];
    values[20] = f32::NAN;
    values[23] = f32::NEG_INFINITY;
    let arrays = [("x", f32s(&[4, 2, 3], &values)), ("y", labels())];
    let out = "repair the recording or leave it out";
    assert_eq!(refused_arrays(&arrays), format!("grasps.npz: x[3]: value at [0, 2] is NaN; {out}"));
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &arrays);
    let second = ReadOptions { channels: Some(vec![1]), ..ReadOptions::default() };
    assert_eq!(refused(&path, &second), format!("grasps.npz: x[3]: value at [1, 2] is -inf; {out}"));
    let card = check(&path).unwrap();
    assert_eq!((card.nan, card.infinite), (1, 1));
    assert!(card.problems[0].ends_with("leave it out (and 1 more like it)"), "{:?}", card.problems);
}

#[test]
fn labels_out_of_range_are_refused() {
    let folder = tempdir().unwrap();
    files(folder.path(), &[("labels.json", r#"{"classes": ["apple", "pear"], "counts": [2, 2]}"#)]);
    let message = |y: &[i64]| {
        let path = npz(folder.path(), &[("x", samples(4)), ("y", i64s(&[4], y))]);
        refused(&path, &ReadOptions::default())
    };
    assert_eq!(
        message(&[0, 1, 31, 0]),
        "grasps.npz: y[2] = 31 is out of range: labels.json names 2 classes (0..1)"
    );
    assert_eq!(message(&[0, 1, 1, -2]), "grasps.npz: y[3] = -2 is negative; number the classes from 0");
    assert_eq!(
        message(&[0; 4]),
        "grasps.npz: no sample in y has label 1 (pear); record some or remove its name"
    );
    std::fs::remove_file(folder.path().join("labels.json")).unwrap();
    let gap = "number the classes from 0 without gaps";
    assert_eq!(message(&[0, 3, 3, 1]), format!("grasps.npz: no sample in y has label 2; {gap}"));
    assert_eq!(message(&[1, 1, 1, i64::MAX]), format!("grasps.npz: no sample in y has label 0; {gap}"));
}

#[test]
fn a_broken_file_of_names_is_refused() {
    let write = "write {\"classes\": [\"name of 0\", ...]}";
    let cases = [
        (
            r#"{"classes": ["a""#,
            "labels.json: is not valid JSON (eof while parsing a list at line 1 column 16)",
        ),
        (r#"{"names": ["a"]}"#, "labels.json: has no key \"classes\""),
        ("7", "labels.json: classes is a number, not a list"),
        (r#"{"classes": {"a": 0}}"#, "labels.json: classes is an object, not a list"),
        ("[]", "labels.json: classes is empty"),
        (r#"["a", null]"#, "labels.json: classes[1] is null, not a text"),
        (r#"[["a", "b"], []]"#, "labels.json: classes[1] is empty"),
        (r#"[["a", "b"], ["c"]]"#, "labels.json: names 2 columns of labels, but y has 1"),
    ];
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", samples(4)), ("y", labels())]);
    for (text, want) in cases {
        files(folder.path(), &[("labels.json", text)]);
        assert_eq!(refused(&path, &ReadOptions::default()), format!("{want}; {write}"));
    }
    files(folder.path(), &[("labels.json", r#"["a", "b", "a"]"#)]);
    assert_eq!(
        refused(&path, &ReadOptions::default()),
        "labels.json: classes 0 and 2 are both named \"a\"; give each its own name"
    );
    std::fs::write(folder.path().join("labels.json"), [b'[', 0xFF]).unwrap();
    let message = refused(&path, &ReadOptions::default());
    assert!(
        message.starts_with("labels.json: line 1 holds the byte 0xFF, which is not UTF-8; save it as UTF-8"),
        "{message}"
    );
    let options =
        ReadOptions { limits: Limits { max_file_bytes: 1, ..Limits::default() }, ..ReadOptions::default() };
    assert_eq!(
        refused(&path, &options),
        "labels.json: has 2 bytes, more than the 1 allowed; raise limits.max-file-bytes"
    );
    files(folder.path(), &[("labels.json", "")]);
    let message = refused(&path, &ReadOptions::default());
    assert_eq!(message, "labels.json: is empty (0 bytes); copy or record it again");
}
