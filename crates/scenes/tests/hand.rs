//! A fingertip on a box, a ball and a cylinder: what each effect does, and what tells them.

#![allow(clippy::unwrap_used)]

use ndarray::{Array3, Axis, Slice};
use taxel_scenes::{Hand, Scene};

const ALL: [&str; 4] = ["placement", "grip", "session", "noise"];

fn grasps(samples: usize, without: &[&str]) -> Scene {
    let without: Vec<String> = without.iter().map(ToString::to_string).collect();
    Hand::default().simulate(samples, 5, &without).unwrap()
}

fn grasp(scene: &Scene, at: usize) -> Array3<f32> {
    scene.x.index_axis(Axis(0), at).to_owned().into_dimensionality().unwrap()
}

/// Returns the loss of each electrode in the hold, rows by columns.
fn lost(scene: &Scene, at: usize) -> Vec<Vec<f32>> {
    let frames = grasp(scene, at);
    (0..7)
        .map(|row| (0..3).map(|column| frames[[0, row, column]] - frames[[290, row, column]]).collect())
        .collect()
}

#[test]
fn seven_hundred_frames_of_seven_by_three() {
    let scene = grasps(33, &[]);
    assert_eq!(scene.x.shape(), [33, 700, 7, 3]);
    assert_eq!(scene.class_names, ["box", "ball", "cylinder"]);
    assert!(scene.x.iter().all(|value| (0.0..=4095.0).contains(value) && value.fract() == 0.0));
    assert_eq!((scene.group[0], scene.group[3], scene.group[30]), (0, 1, 0));
    assert_eq!(grasps(4, &[]).x, scene.x.slice_axis(Axis(0), Slice::from(0..4)));
}

#[test]
fn electrodes_far_from_the_first_touch_tell_the_object() {
    let scene = grasps(3, &ALL);
    let [flat, ball, cylinder] = [0, 1, 2].map(|at| lost(&scene, at));
    // All press the middle alike.
    assert!(flat[3][1] > 100.0 && (flat[3][1] - ball[3][1]).abs() < 1.5);
    // At the tip only the box does; beside the middle the ball presses less than box and cylinder.
    assert!(flat[0][1] > ball[0][1] + 50.0 && (ball[0][1] - cylinder[0][1]).abs() < 1.5);
    assert!(flat[3][0] > ball[3][0] + 20.0 && (flat[3][0] - cylinder[3][0]).abs() < 1.5);
}

#[test]
fn the_depth_of_the_gap_is_that_of_the_formula() {
    let scene = grasps(3, &ALL);
    // A depth of 1.4 mm; the box 5 mm along the finger: 25 / 2 / 60 mm away; the ball 4 mm across: (1/7 + 1/37) 16 / 2.
    let (flat, ball) = (lost(&scene, 0), lost(&scene, 1));
    assert!((flat[3][1] - 280.0).abs() <= 1.0, "{}", flat[3][1]);
    assert!((flat[1][1] - 200.0 * (1.4 - 25.0 / 120.0)).abs() <= 1.0, "{}", flat[1][1]);
    assert!((ball[3][0] - 200.0 * (1.4f32 - 8.0 * (1.0 / 7.0 + 1.0 / 37.0))).abs() <= 1.0, "{}", ball[3][0]);
}

#[test]
fn every_effect_changes_a_grasp_and_leaves_the_random_numbers_of_the_others_alone() {
    let all = grasps(6, &[]);
    let noiseless = grasps(6, &["noise"]);
    for effect in ALL {
        let less = grasps(6, &[effect]);
        let apart = (&grasp(&all, 1) - &grasp(&less, 1)).mapv(f32::abs).mean().unwrap();
        assert!(apart > 0.1, "{effect}: {apart}");
        let changes = |name: &str| match name {
            "depth_mm" | "contact_s" | "hold_s" => "grip",
            _ => "placement",
        };
        for (with, without) in all.truth.iter().zip(&less.truth) {
            assert_eq!(with == without, changes(&with.0) != effect, "{effect}: {}", with.0);
        }
    }
    assert_eq!(all.truth, noiseless.truth);
}

#[test]
fn before_contact_there_is_rest_and_the_hold_holds() {
    let scene = grasps(3, &["noise", "placement"]);
    let frames = grasp(&scene, 0);
    let [contact, hold] = [1, 2].map(|column| (scene.truth[column].1[0] * 100.0) as usize);
    assert!((0..contact).all(|frame| frames.index_axis(Axis(0), frame) == frames.index_axis(Axis(0), 0)));
    assert!(frames[[0, 3, 1]] > frames[[hold, 3, 1]] + 100.0);
    assert!(
        (hold + 1..700).all(|frame| frames.index_axis(Axis(0), frame) == frames.index_axis(Axis(0), 699))
    );
}

#[test]
fn what_is_impossible_is_refused() {
    let text = Hand { sessions: 0, ..Hand::default() }.simulate(1, 0, &[]).unwrap_err().to_string();
    assert!(text.contains("sessions"), "{text}");
    let text = Hand::default().simulate(1, 0, &["gripp".into()]).unwrap_err().to_string();
    assert!(text.contains("grip"), "{text}");
}
