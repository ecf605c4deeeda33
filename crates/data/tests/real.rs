//! Real recordings, reached through `TAXEL_DATA`.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use ndarray::Axis;
use std::path::PathBuf;
use std::time::Instant;
use taxel_data::{Drop, Layout, ReadOptions, check, check_with, group_k_fold, load, stratified_k_fold};

fn path(name: &str) -> PathBuf {
    PathBuf::from(std::env::var_os("TAXEL_DATA").expect("TAXEL_DATA names the data folder")).join(name)
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn fsr_glove28() {
    let path = path("fsr-glove28");
    let start = Instant::now();
    let all = load(&path, &ReadOptions::default()).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    assert!(cfg!(debug_assertions) || seconds < 0.5, "{seconds} s");
    assert_eq!(all.x.shape(), [1467, 35, 50]);
    assert_eq!(all.output_names().len(), 28);
    assert_eq!(all.output_names()[27], "keyboard");
    assert_eq!(all.class_counts()[0], 59);
    assert_eq!(all.groups, None);
    assert_eq!(all.name, "fsr-glove28");

    let fsr = ReadOptions {
        group: Some("block".into()),
        channels: Some((30..35).collect()),
        drop: vec![Drop::Contradictory],
        ..ReadOptions::default()
    };
    let data = load(&path, &fsr).unwrap();
    assert_eq!(data.x.shape(), [1449, 5, 50]);
    assert!(data.x.iter().all(|v| (0.0..=5.01).contains(v)));
    assert_eq!(data.dropped.len(), 18);
    assert_eq!(data.dropped[..3], ["x[56]", "x[57]", "x[58]"]);
    // 168 and 169 are one recording, six dropped rows before them.
    assert_eq!(data.units.as_ref().unwrap()[163], 162);
    let groups = data.groups.as_ref().unwrap();
    let folds = group_k_fold(groups, &data.strata(), 5, 0, 0).unwrap();
    assert!(folds.iter().all(|fold| fold.test.iter().all(|i| groups[*i] == groups[fold.test[0]])));
    let folds = stratified_k_fold(&data.strata(), 5, 0, 0, data.units.as_deref()).unwrap();
    assert!(folds.iter().all(|fold| fold.test.contains(&162) == fold.test.contains(&163)));

    let both = ReadOptions { drop: vec![Drop::Contradictory, Drop::Duplicates], ..fsr };
    assert_eq!(load(&path, &both).unwrap().x.shape(), [1448, 5, 50]);
    let deny = ReadOptions { deny_contradictory: true, ..ReadOptions::default() };
    let message = load(&path, &deny).unwrap_err().to_string();
    assert!(message.contains("x[56] (Agrapheuse Comb) and x[113] (Battery)"), "{message}");
    assert!(message.contains("18 such rows"), "{message}");
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn fsr_glove28_card() {
    let options = ReadOptions { group: Some("block".into()), ..ReadOptions::default() };
    let card = check_with(&path("fsr-glove28"), &options).unwrap();
    println!("{card}");
    assert_eq!(card.problems, [""; 0]);
    assert_eq!(card.layout, Layout::Series);
    assert_eq!((card.contradictions.len(), card.duplicates.len()), (9, 1));
    assert_eq!(card.duplicates[0], [168, 169]);
    assert_eq!(card.contradictions[8].rows, [882, 935]);
    assert_eq!(card.contradictions[8].labels, ["Pepsi", "Phone Comb"]);
    let groups = card.groups.unwrap();
    assert_eq!((groups.groups, groups.classes), (5, [28, 28]));
    assert_eq!(card.channels.len(), 35);
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn tekscan22_images() {
    let data = load(&path("tekscan22-images"), &ReadOptions::default()).unwrap();
    assert_eq!(data.x.shape(), [1100, 28, 50]);
    assert_eq!(data.output_names().len(), 22);
    assert_eq!(data.class_counts(), [50; 22]);
    let card = check(&path("tekscan22-images")).unwrap();
    println!("{card}");
    assert_eq!(card.layout, Layout::Image);
    assert_eq!((card.contradictions.len(), card.duplicates.len()), (0, 5));
    let names = data.output_names();
    let class = |set: &Vec<usize>| names[data.strata()[set[0]] as usize].as_str();
    let classes: Vec<_> = card.duplicates.iter().map(class).collect();
    assert_eq!(classes, ["bottle", "bottle", "bottle", "bottle", "caliper"]);

    // The same images as files: grey JPEGs, one folder per class.
    let files = load(&path("tekscan22-images/Images"), &ReadOptions::default()).unwrap();
    assert_eq!(files.x.shape(), [1100, 28, 50]);
    assert_eq!(files.output_names(), data.output_names());
    assert_eq!(files.origins[1], "adhesive/adhesive2.jpg");
    // The archive has them in plain text order; decoders may round differently.
    let mut order: Vec<usize> = (0..1100).collect();
    order.sort_by_key(|i| &files.origins[*i]);
    for (row, file) in order.iter().enumerate() {
        let pair = data.x.index_axis(Axis(0), row).into_iter().zip(files.x.index_axis(Axis(0), *file));
        let worst = pair.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst <= 4.0, "{}: {worst}", files.origins[*file]);
    }
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn gelsight_materials10() {
    let path = path("gelsight-materials10");
    let message = load(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("[1000, 3, 400, 300]"), "{message}");
    assert!(message.contains("resize = [height, width]"), "{message}");
    let options = ReadOptions { resize: Some([32, 24]), group_block: Some(20), ..ReadOptions::default() };
    let data = load(&path, &options).unwrap();
    assert_eq!(data.x.shape(), [1000, 3, 32, 24]);
    assert_eq!(data.spec.layout, Layout::Colour);
    let mean = data.x.mean().unwrap();
    assert!((60.0..200.0).contains(&mean), "{mean}");
    assert_eq!(data.output_names()[9], "material_10");
    assert_eq!(data.class_counts(), [100; 10]);
    let groups = data.groups.as_ref().unwrap();
    assert_eq!((groups[19], groups[20], groups[99], groups[100]), (0, 1, 4, 0));
    assert_eq!(data.units.unwrap(), (0..1000).collect::<Vec<u32>>());
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn neutouch_softness() {
    let options = ReadOptions { group: Some("session".into()), ..ReadOptions::default() };
    let data = load(&path("neutouch-softness/class_test.npz"), &options).unwrap();
    assert_eq!(data.x.shape(), [160, 2, 80, 50]);
    assert_eq!(data.output_names(), ["carton_box", "soft_block", "sponge", "stiff_block"]);
    let folds = group_k_fold(data.groups.as_ref().unwrap(), &data.strata(), 2, 0, 0).unwrap();
    assert_eq!(folds[0].test.len(), 80);
    let message = load(&path("neutouch-softness"), &options).unwrap_err().to_string();
    assert!(message.ends_with("class_test.npz, softness_test.npz, softness_test_bare.npz"), "{message}");
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn every_other_set_loads() {
    let blocks = ReadOptions { group: Some("trial".into()), group_block: Some(12), ..ReadOptions::default() };
    let data = load(&path("kinesthetic-gripper36"), &blocks).unwrap();
    assert_eq!(data.x.shape(), [2160, 4, 41]);
    assert_eq!(data.group_name.as_deref(), Some("trial/12"));
    let groups = data.groups.as_ref().unwrap();
    assert_eq!(groups.iter().max(), Some(&4));
    for name in ["biotac-pr2-hold6", "biotac-slide20", "tekscan3d-fixtures24"] {
        let card = check(&path(name)).unwrap();
        assert_eq!(card.problems, [""; 0], "{name}");
    }
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn values_of_real_skins() {
    let named = |set: &str, options: ReadOptions| {
        let start = Instant::now();
        let data = load(&path(set), &options).unwrap_or_else(|e| panic!("{set}: {e}"));
        let card = check_with(&path(set), &options).unwrap();
        println!("{card}\n{:.1} s\n", start.elapsed().as_secs_f64());
        data
    };
    let window = Some(taxel_data::Length::Window { to: 33, hop: Some(1) });
    let y = |name: &str| ReadOptions { y: Some(name.into()), ..ReadOptions::default() };
    let sessions = ReadOptions { recording: Some("group".into()), length: window, ..y("y") };
    let data = named("eflesh-normal", sessions);
    assert_eq!((data.x.shape(), data.group_name.as_deref()), (&[5580 - 3 * 32, 15, 33][..], Some("group")));
    let raw = load(&path("eflesh-normal"), &ReadOptions::default()).unwrap();
    // The first window ends at the 33rd row.
    assert_eq!(data.targets.values().unwrap().of(&[0]), raw.targets.values().unwrap().of(&[32]));
    let both = ReadOptions { drop: vec![Drop::NoTarget], ..y("y,depth_mm") };
    assert_eq!(named("fsi-tube1d", both).output_names(), ["y-0", "y-1", "depth"]);
}

#[test]
#[ignore = "needs TAXEL_DATA"]
fn several_values_of_real_skins() {
    let y = |name: &str| ReadOptions { y: Some(name.into()), ..ReadOptions::default() };
    let data = load(&path("fsi-tube1d"), &y("y")).unwrap();
    assert_eq!((data.output_names(), data.len()), (vec!["y-0".to_string(), "y-1".into()], 6930));
    let message = load(&path("fsi-tube1d"), &y("depth_mm")).unwrap_err().to_string();
    assert!(message.contains("of 6930 samples have no target") && message.contains("no-target"), "{message}");
    let left = ReadOptions { drop: vec![Drop::NoTarget], ..y("depth_mm") };
    let card = check_with(&path("fsi-tube1d"), &left).unwrap();
    println!("{card}\n");
    assert_eq!((card.problems.len(), card.shape[0] + card.without_target), (0, 6930));
    for (set, y, samples, shape) in [
        ("eflesh-location", "y", 9610, vec![15]),
        ("hydrogel-force16", "y", 5957, vec![16, 40]),
        ("pmd-posture17", "weight_kg", 2210, vec![64, 32]),
    ] {
        let options = ReadOptions { y: Some(y.into()), ..ReadOptions::default() };
        let data = load(&path(set), &options).unwrap_or_else(|e| panic!("{set}: {e}"));
        assert_eq!((data.len(), data.sample_shape()), (samples, shape.as_slice()), "{set}");
        println!("{}\n", check_with(&path(set), &options).unwrap());
    }
}
