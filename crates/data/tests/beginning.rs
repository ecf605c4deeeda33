//! The first time steps of recordings, and how far they tell the classes.

#![allow(clippy::unwrap_used)]

use ndarray::{ArrayD, Axis};
use rand::RngExt;
use taxel_data::{Beginning, Dataset, EarlyClass, Layout};

/// 120 recordings of noise in 2 channels, to which `offset(recording)` is added in channel 1.
fn noise(offset: impl Fn(usize) -> f32) -> Dataset {
    let mut rng = taxel_base::seed::rng(5, "test/beginning");
    let x = ArrayD::from_shape_fn(vec![120, 2, 30], |at| {
        rng.random_range(-1.0f32..1.0) + if at[1] == 1 { offset(at[0]) } else { 0.0 }
    });
    let labels: Vec<&str> = (0..120).map(|i| ["soft", "hard"][i % 2]).collect();
    Dataset::new("presses", Layout::Series, x, &labels).unwrap()
}

#[test]
fn an_offset_of_a_class_shows_in_the_first_time_step() {
    let found = EarlyClass::of(&noise(|i| 3.0 * (i % 2) as f32));
    assert_eq!(
        found.iter().map(|early| early.part).collect::<Vec<_>>(),
        [Beginning::FirstStep, Beginning::FirstTenth]
    );
    for early in found {
        assert!(early.is_suspicious() && early.accuracy > 0.95, "{early}");
        assert_eq!(early.channel.as_ref().unwrap().0, "1", "{early}");
    }
}

#[test]
fn noise_tells_nothing() {
    for early in EarlyClass::of(&noise(|_| 0.0)) {
        assert!(!early.is_suspicious() && early.channel.is_none(), "{early}");
    }
}

#[test]
fn recordings_of_one_group_do_not_vote_for_each_other() {
    // An offset of each session, which tells the class only within it: one class per session.
    let session = |i: usize| i / 2 % 10;
    let mut dataset = noise(|i| session(i) as f32 * 5.0 + 2.5 * (i % 2) as f32);
    // The noise of the other channel would hide it.
    dataset.x.index_axis_mut(Axis(1), 0).fill(0.0);
    assert!(EarlyClass::of(&dataset).iter().all(EarlyClass::is_suspicious));
    let groups: Vec<usize> = (0..120).map(|i| 2 * session(i) + i % 2).collect();
    let dataset = dataset.with_groups(&groups).unwrap();
    for early in EarlyClass::of(&dataset) {
        assert!(early.by_group && !early.is_suspicious(), "{early}");
    }
}
