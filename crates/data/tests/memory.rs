//! Data sets from arrays in memory, and parts of data sets.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{f32s, files, i64s, npz};
use ndarray::{Array3, ArrayD, IxDyn};
use taxel_data::{Card, Dataset, Layout, ReadOptions, Source, load};
use tempfile::tempdir;

/// Six series `[2, 3]`; row 4 is a copy of row 1.
fn grasps() -> ArrayD<f32> {
    Array3::from_shape_fn((6, 2, 3), |(i, c, t)| (100 * if i == 4 { 1 } else { i } + 10 * c + t) as f32)
        .into_dyn()
}

const CLASSES: [&str; 6] = ["pear", "apple", "10", "9", "apple", "pear"];

fn set() -> Dataset {
    Dataset::new("glove", Layout::Series, grasps(), &CLASSES).unwrap()
}

#[test]
fn arrays_in_memory_become_a_data_set() {
    let data = set();
    assert_eq!(data.output_names(), ["9", "10", "apple", "pear"], "numbers by value, then words");
    assert_eq!(data.strata().to_vec(), [3, 2, 1, 0, 2, 3]);
    assert_eq!((data.len(), data.is_empty(), data.class_counts()), (6, false, vec![1, 1, 2, 2]));
    assert_eq!((data.name.as_str(), data.source.clone()), ("glove", Source::real("glove")));
    assert_eq!((data.sample_shape(), data.spec.layout), ([2, 3].as_slice(), Layout::Series));
    assert_eq!(
        (
            data.targets.labels().unwrap().attributes()[0].name.as_str(),
            data.targets.labels().unwrap().values()
        ),
        ("class", &data.strata().to_vec()[..])
    );
    assert_eq!((data.units.as_deref(), data.origins[5].as_str()), (Some(&[0, 1, 2, 3, 1, 5][..]), "x[5]"));
    assert_eq!(
        (data.targets.columns().as_ref(), data.groups.as_ref(), data.official.as_ref()),
        (None, None, None)
    );
    let numbers = Dataset::new("glove", Layout::Series, grasps(), &[1, 0, 1, 0, 1, 0]).unwrap();
    assert_eq!(
        (numbers.output_names().as_slice(), numbers.strata().to_vec()),
        (["0".into(), "1".into()].as_slice(), vec![1, 0, 1, 0, 1, 0])
    );
    assert!(Card::new(&data).warnings.iter().any(|w| w.contains("x[1] = x[4]")));
}

#[test]
fn a_file_and_memory_give_the_same_digest_hashes_and_units() {
    let folder = tempdir().unwrap();
    let x = grasps();
    let y: Vec<i64> = set().strata().to_vec().iter().map(|label| i64::from(*label)).collect();
    let arrays = [
        ("x", f32s(&[6, 2, 3], x.as_slice().unwrap())),
        ("y", i64s(&[6], &y)),
        ("group", i64s(&[6], &[7, 7, 8, 8, 9, 9])),
    ];
    files(folder.path(), &[("labels.json", r#"["9", "10", "apple", "pear"]"#)]);
    let stored = load(&npz(folder.path(), &arrays), &ReadOptions::default()).unwrap();
    let held = Dataset::new("grasps", Layout::Series, x, &CLASSES).unwrap();
    let held = held.with_groups(&[7, 7, 8, 8, 9, 9]).unwrap();
    assert_eq!(held, stored);
}

#[test]
fn the_digest_is_blake3_of_shape_values_labels_and_groups() {
    let word = |n: usize| (n as u64).to_le_bytes().to_vec();
    let labels = |values: &[u32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let values: Vec<u8> = grasps().iter().flat_map(|v| v.to_le_bytes()).collect();
    let head = [word(3), word(6), word(2), word(3), values, word(6), labels(&[3, 2, 1, 0, 2, 3])].concat();
    let digest =
        |tail: &[Vec<u8>]| blake3::hash(&[head.clone(), tail.concat()].concat()).to_hex().to_string();
    assert_eq!(set().digest, digest(&[word(0)]));
    let grouped = set().with_groups(&["b", "a", "b", "a", "c", "c"]).unwrap();
    assert_eq!(
        (grouped.group_name.as_deref(), grouped.groups.as_deref()),
        (Some("group"), Some(&[1, 0, 1, 0, 2, 2][..]))
    );
    assert_eq!(grouped.digest, digest(&[word(6), labels(&[1, 0, 1, 0, 2, 2])]));

    let folder = tempdir().unwrap();
    let table = [0, 1, 1, 0, 0, 1, 1, 0, 1, 1, 0, 0];
    let y = i64s(&[6, 2], &table);
    let two = load(
        &npz(folder.path(), &[("x", f32s(&[6, 2, 3], grasps().as_slice().unwrap())), ("y", y)]),
        &ReadOptions { attribute: Some(0), ..ReadOptions::default() },
    );
    let values: Vec<u8> = grasps().iter().flat_map(|v| v.to_le_bytes()).collect();
    let all: Vec<u32> = table.iter().map(|v| *v as u32).collect();
    let first: Vec<u32> = all.iter().step_by(2).copied().collect();
    let bytes =
        [word(3), word(6), word(2), word(3), values, word(6), labels(&first), word(0), word(2), labels(&all)];
    assert_eq!(two.unwrap().digest, blake3::hash(&bytes.concat()).to_hex().to_string());
}

#[test]
fn the_memory_order_of_an_array_changes_nothing() {
    let reversed = grasps().t().as_standard_layout().into_owned().reversed_axes();
    assert!(!reversed.is_standard_layout());
    assert_eq!(Dataset::new("glove", Layout::Series, reversed, &CLASSES).unwrap(), set());
}

#[test]
fn facts_are_added_one_by_one() {
    let data = set().with_unit("N").with_rate(62.5).unwrap().with_full_scale(600.0).unwrap();
    let data = data.with_rest(vec![0.5]).with_official(vec![false, false, false, true, true, true]).unwrap();
    let spec = &data.spec;
    assert_eq!((spec.unit.as_deref(), spec.rate, spec.full_scale), (Some("N"), Some(62.5), Some(600.0)));
    assert_eq!((spec.rest.as_deref(), data.digest.clone()), (Some(&[0.5][..]), set().digest));
    assert_eq!(data.official.unwrap().iter().filter(|test| **test).count(), 3);
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let refuse = |layout, x: ArrayD<f32>, labels: &[&str]| {
        Dataset::new("glove", layout, x, labels).unwrap_err().to_string()
    };
    let zeros = |shape: &[usize]| ArrayD::<f32>::zeros(IxDyn(shape));
    assert_eq!(
        refuse(Layout::Sequence, grasps(), &CLASSES),
        "glove: x: layout is sequence, but a sample of shape [2, 3] is not a sequence of images [T, H, W]"
    );
    assert_eq!(
        refuse(Layout::Colour, zeros(&[6, 4, 2, 2]), &CLASSES),
        "glove: x: layout is colour, but a sample of shape [4, 2, 2] is not a colour image [3, H, W]"
    );
    assert!(refuse(Layout::Features, zeros(&[]), &[]).starts_with("glove: x: layout is features, but"));
    assert_eq!(refuse(Layout::Series, zeros(&[0, 2, 3]), &[]), "glove: x: holds no samples");
    assert_eq!(
        refuse(Layout::Series, zeros(&[6, 0, 3]), &CLASSES),
        "glove: x: has shape [6, 0, 3]: axis 1 is empty; there is nothing to learn from"
    );
    assert_eq!(
        refuse(Layout::Series, grasps(), &CLASSES[1..]),
        "glove: labels has 5 entries but x has 6 samples; one per sample"
    );
    let mut broken = grasps();
    broken[[3, 1, 2]] = f32::NAN;
    assert_eq!(
        refuse(Layout::Series, broken, &CLASSES),
        "glove: x[3]: value at [1, 2] is NaN; repair the recording or leave it out"
    );
    let message = |data: taxel_data::Result<Dataset>| data.unwrap_err().to_string();
    assert_eq!(
        message(set().with_groups(&[1, 2])),
        "glove: groups has 2 entries but x has 6 samples; one per sample"
    );
    assert_eq!(message(set().with_rate(0.0)), "glove: rate is 0, not a number above 0");
    assert_eq!(message(set().with_rate(f64::INFINITY)), "glove: rate is inf, not a number above 0");
    assert_eq!(message(set().with_full_scale(f32::NAN)), "glove: full_scale is NaN, not a number above 0");
    assert!(
        message(set().with_official(vec![true])).starts_with("glove: official has 1 entries but x has 6")
    );
    assert!(
        message(set().with_official(vec![true; 6])).starts_with("glove: official marks no or all samples")
    );
}

#[test]
fn another_layout_is_taken_where_the_shape_fits() {
    let mut data = set();
    data.set_layout(Layout::Image).unwrap();
    assert_eq!(data.spec.layout, Layout::Image);
    let message = data.set_layout(Layout::Fingers).unwrap_err().to_string();
    assert_eq!(
        message,
        "glove: layout is fingers, but a sample of shape [2, 3] is not a series of several fingers [F, C, T]"
    );
    assert_eq!(data.spec.layout, Layout::Image, "unchanged");
}

#[test]
fn selected_rows_bring_everything_along() {
    let data = set().with_groups(&[5, 6, 5, 6, 5, 6]).unwrap().with_unit("N");
    let data = data.with_official(vec![true, false, false, false, true, false]).unwrap();
    let part = data.select(&[4, 0, 1]);
    assert_eq!(part.x.as_slice().unwrap()[..7], [100., 101., 102., 110., 111., 112., 0.]);
    assert_eq!(
        (part.strata().to_vec().as_slice(), part.targets.labels().unwrap().values()),
        ([2, 3, 2].as_slice(), [2, 3, 2].as_slice())
    );
    assert_eq!((part.groups.as_deref(), part.units.as_deref()), (Some(&[5, 5, 6][..]), Some(&[1, 0, 1][..])));
    assert_eq!((part.official.as_deref(), part.len()), (Some(&[true, true, false][..]), 3));
    assert_eq!(part.origins, ["x[4]", "x[0]", "x[1]"]);
    assert_eq!((part.row_hash[0], part.row_hash[2]), (data.row_hash[1], data.row_hash[1]));
    assert_eq!(
        (&part.output_names(), &part.spec, part.class_counts()),
        (&data.output_names(), &data.spec, vec![0, 0, 2, 1])
    );
    let anew = Dataset::new("glove", Layout::Series, part.x.clone(), &[2, 3, 2]).unwrap();
    assert_ne!(part.digest, data.digest);
    assert_eq!(data.select(&[0, 1, 2, 3, 4, 5]), data, "all rows are the set itself");
    assert_eq!(anew.x, part.x);
    // A simulated set has no copies to speak of.
    let simulated = Dataset { units: None, row_hash: vec![], ..data };
    assert_eq!((simulated.select(&[1]).units, simulated.select(&[1]).row_hash), (None, vec![]));
}

#[test]
fn a_card_of_fingers_counts_channels_of_each_finger() {
    let x = ArrayD::from_shape_fn(IxDyn(&[4, 2, 3, 5]), |at| match (at[1], at[2]) {
        (1, 0) => 7.0,
        _ => (at[0] * at[3] + at[1]) as f32,
    });
    let card = Card::new(&Dataset::new("hand", Layout::Fingers, x, &["a", "b", "a", "b"]).unwrap());
    assert_eq!((card.taxels, card.channels.len()), (6, 6));
    assert_eq!(card.constant_taxels, [[1, 0]]);
    assert!(card.to_string().contains("4×2×3×5 (N×F×C×T, stored as <f4)"));
    assert_eq!(serde_json::to_value(&card).unwrap()["axes"], "N×F×C×T");
}

#[test]
fn a_saved_data_set_is_read_back_equal() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("glove.npz");
    let data = set().with_groups(&[7, 7, 8, 8, 9, 9]).unwrap().with_unit("N").with_rate(12.5).unwrap();
    let data = data.with_full_scale(1023.0).unwrap();
    data.save(&path).unwrap();
    assert_eq!(load(&path, &ReadOptions::default()).unwrap(), data);
    // Axes and marks of test samples are saved too.
    let marked = data.with_official(vec![true, false, false, true, false, false]).unwrap();
    let image =
        Dataset { spec: taxel_data::SampleSpec { layout: Layout::Image, ..marked.spec.clone() }, ..marked };
    image.save(&path).unwrap();
    let read = load(&path, &ReadOptions::default()).unwrap();
    assert_eq!((&read.official, read.spec.layout), (&image.official, Layout::Image));
    assert!(own_folder_is_missing(&image, folder.path()));
}

fn own_folder_is_missing(data: &Dataset, folder: &std::path::Path) -> bool {
    data.save(&folder.join("nowhere/glove.npz")).is_err()
}

#[test]
fn a_data_set_of_several_attributes_is_read_back_with_all_of_them() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("levels.npz");
    files(folder.path(), &[("levels.classes.json", r#"[["soft", "hard"], ["low", "mid", "high"]]"#)]);
    let arrays = [
        ("x", f32s(&[6, 2, 3], grasps().as_slice().unwrap())),
        ("y", i64s(&[6, 2], &[0, 0, 1, 1, 0, 2, 1, 0, 0, 1, 1, 2])),
    ];
    let stored = npz(folder.path(), &arrays);
    std::fs::rename(stored, &path).unwrap();
    let several =
        ReadOptions { attributes: vec!["hardness".into(), "height".into()], ..ReadOptions::default() };
    let data = load(&path, &several).unwrap();
    let again = folder.path().join("again/levels.npz");
    std::fs::create_dir(again.parent().unwrap()).unwrap();
    data.save(&again).unwrap();
    let read = load(&again, &several).unwrap();
    assert_eq!(
        (&read.targets.labels().unwrap(), &read.strata().to_vec(), &read.digest),
        (&data.targets.labels().unwrap(), &data.strata().to_vec(), &data.digest)
    );
}

#[test]
fn names_of_channels_fit_the_samples() {
    let data = || Dataset::new("glove", Layout::Series, ArrayD::zeros(vec![2, 2, 3]), &["a", "b"]).unwrap();
    let named = data().with_channel_names(&["thumb", "index"]).unwrap();
    assert_eq!(named.spec.channel_names, ["thumb", "index"]);
    assert_eq!(named.digest, data().digest);
    let message = data().with_channel_names(&["thumb"]).unwrap_err().to_string();
    assert_eq!(message, "glove: channels is 1 name, and samples have 2 channels");
    let message = data().with_channel_names(&["thumb", "thumb"]).unwrap_err().to_string();
    assert_eq!(message, "glove: channels is \"thumb\" twice, and a name is of one channel");
}
