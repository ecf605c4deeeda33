//! A few global statistics that tell the classes apart, and that do not.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{f32s, i64s, npz};
use ndarray::{Array3, ArrayD};
use rand::RngExt;
use taxel_data::{ReadOptions, Shortcut, check_with};
use tempfile::tempdir;

const CLASSES: usize = 4;
const EACH: usize = 30;

/// Images 6 × 6 of noise with a bright row: the class says which row, and how much brighter the light is in
/// steps of `light`. A session of ten images has its own light, up to `session`.
fn images(light: f32, session: f32) -> (ArrayD<f32>, Vec<u32>, Vec<u32>) {
    let mut rng = taxel_base::seed::rng(3, "test/shortcut");
    let y: Vec<u32> = (0..CLASSES * EACH).map(|i| (i / EACH) as u32).collect();
    let groups: Vec<u32> = (0..CLASSES * EACH).map(|i| (i / 10) as u32).collect();
    let of_session: Vec<f32> = (0..CLASSES * EACH / 10).map(|_| session * rng.random::<f32>()).collect();
    let x = Array3::from_shape_fn((y.len(), 6, 6), |(i, row, _)| {
        let touch = if row as u32 == y[i] { 2.0 } else { 0.0 };
        touch + rng.random::<f32>() + light * y[i] as f32 + of_session[groups[i] as usize]
    });
    (x.into_dyn(), y, groups)
}

/// Four statistics: the six row means of [`images`] are the touch itself.
fn flat(x: &ArrayD<f32>) -> ArrayD<f32> {
    x.clone().into_shape_with_order(vec![x.shape()[0], 36]).unwrap()
}

#[test]
fn light_that_goes_with_the_class_is_seen() {
    let (x, y, _) = images(1.0, 0.0);
    let confounded = Shortcut::of(&flat(&x), &y, None, None).unwrap();
    assert!(confounded.accuracy > 0.95 && confounded.is_suspicious(), "{confounded}");
    assert_eq!((confounded.chance, confounded.by_group, confounded.statistics.len()), (0.25, false, 4));
    // The same touch under the same light.
    let (x, y, _) = images(0.0, 0.0);
    let fair = Shortcut::of(&flat(&x), &y, None, None).unwrap();
    assert!(fair.accuracy < 0.45 && !fair.is_suspicious(), "{fair}");
    // Channel means are among the numbers where channels are few.
    let rows = Shortcut::of(&x, &y, None, None).unwrap();
    assert!(rows.statistics.len() == 10 && rows.accuracy > 0.95, "{rows}");
}

#[test]
fn channel_means_are_those_of_at_most_eight_channels() {
    let count = |shape: &[usize]| {
        let x = ArrayD::from_shape_fn(shape, |at| (7 * at[0] % 11 + at[1]) as f32);
        let y: Vec<u32> = (0..shape[0] as u32).map(|row| row % 2).collect();
        Shortcut::of(&x, &y, None, None).unwrap().statistics.len()
    };
    // Features are no channels.
    assert_eq!([&[40, 8, 2][..], &[40, 9, 2], &[40, 4]].map(count), [12, 4, 4]);
}

#[test]
fn what_a_session_tells_is_no_reason_where_groups_are_known() {
    let (x, y, groups) = images(0.0, 20.0);
    let x = flat(&x);
    let unaware = Shortcut::of(&x, &y, None, None).unwrap();
    assert!(unaware.is_suspicious() && !unaware.by_group, "{unaware}");
    let aware = Shortcut::of(&x, &y, Some(&groups), None).unwrap();
    assert!(!aware.is_suspicious() && aware.by_group, "{aware}");
}

#[test]
fn copies_do_not_vote_for_each_other() {
    // Every sample six times under one label: only its copies agree with it.
    let mut rng = taxel_base::seed::rng(4, "test/shortcut");
    let base: Vec<[f32; 4]> = (0..60).map(|_| rng.random()).collect();
    let copies: Vec<u32> = (0..360).map(|i| i / 6).collect();
    let x = ndarray::Array2::from_shape_fn((360, 4), |(i, j)| base[i / 6][j]).into_dyn();
    let y: Vec<u32> = copies.iter().map(|unit| unit % 2).collect();
    assert_eq!(Shortcut::of(&x, &y, None, None).unwrap().accuracy, 1.0);
    assert!(!Shortcut::of(&x, &y, None, Some(&copies)).unwrap().is_suspicious());
}

#[test]
fn too_little_to_tell_gives_none() {
    let (x, y, _) = images(1.0, 0.0);
    let few: Vec<usize> = (0..39).map(|i| 3 * i).collect();
    let pick = |rows: &[usize]| rows.iter().map(|&row| y[row]).collect::<Vec<u32>>();
    assert_eq!(Shortcut::of(&x.select(ndarray::Axis(0), &few), &pick(&few), None, None), None);
    assert_eq!(Shortcut::of(&x, &vec![0; y.len()], None, None), None);
    let mut broken = x.clone();
    broken[[7, 1, 2]] = f32::NAN;
    assert_eq!(Shortcut::of(&broken, &y, None, None), None);
}

#[test]
fn the_card_warns_and_says_the_numbers() {
    let folder = tempdir().unwrap();
    for (light, is_raised) in [(1.0, true), (0.0, false)] {
        let (x, y, groups) = images(light, 0.0);
        let values: Vec<f32> = x.iter().copied().collect();
        let of = |values: &[u32]| values.iter().map(|&v| i64::from(v)).collect::<Vec<i64>>();
        let arrays = vec![
            ("x", f32s(&[120, 36], &values)),
            ("y", i64s(&[120], &of(&y))),
            ("session", i64s(&[120], &of(&groups))),
        ];
        let path = npz(folder.path(), &arrays);
        let card =
            check_with(&path, &ReadOptions { group: Some("session".into()), ..ReadOptions::default() })
                .unwrap();
        let raised = card.warnings.iter().any(|warning| warning.contains("confounded?"));
        assert_eq!(raised, is_raised, "{:?}", card.warnings);
        let text = card.to_string().replace(['\n', ' '], "");
        assert!(text.contains("lowestandhighestvalueofasamplealonetell"), "{card}");
        let json = serde_json::to_value(&card).unwrap();
        assert_eq!(
            (json["shortcut"]["chance"].as_f64(), json["shortcut"]["by_group"].as_bool()),
            (Some(0.25), Some(true))
        );
    }
}
