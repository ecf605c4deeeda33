//! Scaling: numbers by hand, what it is fitted on, and what it refuses.

use ndarray::{Array1, ArrayD, Axis, IxDyn, arr3};
use taxel_encodings::Scaling;

/// Two samples, two channels, two times; channel 1 is dead.
fn readings() -> ArrayD<f32> {
    arr3(&[[[1.0, 3.0], [9.0, 9.0]], [[5.0, 7.0], [9.0, 9.0]]]).into_dyn()
}

#[test]
fn z_score_by_hand_and_a_dead_channel_becomes_zeros() {
    let mut x = readings();
    let scaling = Scaling::fit_z_score(x.view()).unwrap();
    let sd = 5f32.sqrt();
    assert_eq!(scaling, Scaling::ZScore { mean: vec![4.0, 9.0], sd: vec![sd, 1.0] });
    scaling.apply(&mut x).unwrap();
    let want = [-3.0 / sd, -1.0 / sd, 0.0, 0.0, 1.0 / sd, 3.0 / sd, 0.0, 0.0];
    assert_eq!(x.flatten(), Array1::from_iter(want));
}

#[test]
fn z_score_uses_the_training_numbers_on_other_data() {
    let train = readings().select(Axis(0), &[0]);
    let scaling = Scaling::fit_z_score(train.view()).unwrap();
    let mut test = readings().select(Axis(0), &[1]);
    scaling.apply(&mut test).unwrap();
    assert_eq!(test.flatten(), Array1::from_iter([3.0, 5.0, 0.0, 0.0]));
}

#[test]
fn a_channel_that_varies_by_rounding_is_dead() {
    let next = 1e6f32.next_up();
    let train = arr3(&[[[1e6, next, 1e6, next]]]).into_dyn();
    let Ok(Scaling::ZScore { sd, .. }) = Scaling::fit_z_score(train.view()) else { panic!("no z-score") };
    assert_eq!(sd, [1.0]);
}

#[test]
fn full_scale_divides_and_raw_leaves_alone() {
    let mut x = readings();
    Scaling::Raw.apply(&mut x).unwrap();
    assert_eq!(x, readings());
    Scaling::FullScale { full_scale: 2.0 }.apply(&mut x).unwrap();
    assert_eq!(x, readings() / 2.0);
}

#[test]
fn bad_readings_shapes_and_scales_are_named_and_change_nothing() {
    let mut bad = readings();
    bad[[1, 0, 1]] = f32::NAN;
    let place = "reading 1 of channel 0 of sample 1 is NaN;";
    let before = bad.mapv(f32::to_bits);
    for scaling in [Scaling::Raw, Scaling::FullScale { full_scale: 2.0 }] {
        assert!(scaling.apply(&mut bad).unwrap_err().to_string().starts_with(place));
    }
    assert_eq!(bad.mapv(f32::to_bits), before);
    assert!(Scaling::fit_z_score(bad.view()).unwrap_err().to_string().starts_with(place));

    for full_scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let error = Scaling::FullScale { full_scale }.apply(&mut readings()).unwrap_err();
        assert!(error.to_string().starts_with(&format!("full_scale = {full_scale}: must be")));
    }
    let z_score = |mean: &[f32], sd: &[f32]| {
        let scaling = Scaling::ZScore { mean: mean.to_vec(), sd: sd.to_vec() };
        scaling.apply(&mut readings()).unwrap_err().to_string()
    };
    assert!(z_score(&[0.0, 0.0], &[1.0, 0.0]).starts_with("sd[1] = 0: must be positive"));
    assert!(z_score(&[f32::NAN, 0.0], &[1.0, 1.0]).starts_with("mean[0] = NaN: must be finite"));
    assert!(z_score(&[0.0], &[1.0]).contains("(1 means, 1 deviations), got shape [2, 2, 2]"));
    for shape in [vec![3], vec![0, 2, 5], vec![2, 2, 0]] {
        assert!(Scaling::fit_z_score(ArrayD::zeros(IxDyn(&shape)).view()).is_err(), "{shape:?}");
    }
}
