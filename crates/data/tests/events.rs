//! Classes that a threshold makes of values.

#![allow(clippy::unwrap_used)]

mod common;

use common::{f32s, files, i64s, npz, refused};
use taxel_data::{
    Drop, Layout, Length, ReadOptions, TargetOf, TargetSteps, Task, TaskKind, load, recordings,
};
use tempfile::tempdir;

fn event(text: &str) -> ReadOptions {
    ReadOptions { event: Some(text.parse().unwrap()), ..ReadOptions::default() }
}

/// Four samples of one channel with three readings each.
fn x() -> Vec<u8> {
    let readings: Vec<f32> = (0..12).map(|i| i as f32).collect();
    f32s(&[4, 1, 3], &readings)
}

#[test]
fn a_threshold_makes_rest_and_an_event_of_an_array() {
    let folder = tempdir().unwrap();
    let speed = f32s(&[4], &[0.2, 1.0, 1.5, 3.0]);
    let path = npz(folder.path(), &[("x", x()), ("y", i64s(&[4], &[0, 1, 2, 3])), ("speed_cm_s", speed)]);
    let data = load(&path, &event("speed_cm_s > 1")).unwrap();
    assert_eq!(data.task(), Task::Classes(vec!["rest".into(), "speed_cm_s > 1".into()]));
    assert_eq!(*data.strata(), [0, 0, 1, 1]);
    assert_eq!(*load(&path, &event("speed_cm_s<1")).unwrap().strata(), [1, 0, 0, 0]);
    // Whole numbers have thresholds too, and predictions are compared with the same classes.
    assert_eq!(*load(&path, &event("y > 2.5")).unwrap().strata(), [0, 0, 0, 1]);
    let truth = recordings(&path, &event("speed_cm_s > 1"), 2).unwrap().truth.unwrap().concat();
    assert_eq!(truth, ["rest", "rest", "speed_cm_s > 1", "speed_cm_s > 1"]);
}

#[test]
fn events_of_tables_and_of_time_steps() {
    let folder = tempdir().unwrap();
    let long = "recording,a,speed,note\np,1,0.1,\np,2,2.5,\np,3,0.5,\nq,5,0.4,\nq,6,1.2,\n";
    files(folder.path(), &[("t.csv", long)]);
    let options = ReadOptions { length: Some(Length::Window { to: 2, hop: Some(1) }), ..event("speed > 1") };
    let data = load(&folder.path().join("t.csv"), &options).unwrap();
    assert_eq!((data.strata().to_vec(), data.x.shape()), (vec![1, 0, 1], &[3, 1, 2][..]));
    let speed = f32s(&[4, 3], &[0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0]);
    let path = npz(folder.path(), &[("x", x()), ("speed", speed)]);
    let step = ReadOptions { target: Some(TargetOf::Step), ..options };
    assert_eq!(*load(&path, &step).unwrap().strata(), [1, 0, 0, 1, 1, 1, 0, 0]);
    files(folder.path(), &[("w.csv", "a,force [N]\n1,0.1\n2,0.4\n3,0.9\n")]);
    let data = load(&folder.path().join("w.csv"), &event("force [N] > 0.3")).unwrap();
    assert_eq!((data.strata().to_vec(), data.x.shape()), (vec![0, 1, 1], &[3, 1][..]));
}

#[test]
fn copies_contradict_each_other_only_across_the_threshold() {
    let folder = tempdir().unwrap();
    let x = f32s(&[4, 1], &[1.0, 1.0, 2.0, 2.0]);
    let speed = f32s(&[4], &[2.0, 3.0, 0.5, 1.5]);
    let path = npz(folder.path(), &[("x", x), ("speed", speed)]);
    let options = ReadOptions { drop: vec![Drop::Contradictory], ..event("speed > 1") };
    let message = refused(&path, &options);
    assert!(message.contains("is true of all of 2 samples"), "{message}");
    assert_eq!(load(&path, &event("speed > 1")).unwrap().len(), 4);
}

#[test]
fn what_makes_no_event_is_refused() {
    let folder = tempdir().unwrap();
    let speed = f32s(&[4], &[0.2, 1.0, f32::NAN, 3.0]);
    let both = f32s(&[4, 2], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let path = npz(folder.path(), &[("x", x()), ("speed", speed), ("both", both)]);
    for (text, said) in [
        ("sped > 1", "no array sped: it holds"),
        ("speed > 1", "speed[2] is NaN"),
        ("both > 1", "event = \"both > 1\" takes one number for each sample, and both holds 2"),
    ] {
        let message = refused(&path, &event(text));
        assert!(message.contains(said), "{text}: {message}");
    }
    assert!(refused(&path, &event("sped > 1")).contains("name yours with event = "));
    let kept = ReadOptions { drop: vec![Drop::NoTarget], ..event("speed > 1") };
    assert_eq!(*load(&path, &kept).unwrap().strata(), [0, 0, 1]);
    let high = ReadOptions { drop: vec![Drop::NoTarget], ..event("speed > 5") };
    let message = refused(&path, &high);
    assert!(
        message
            .contains("is true of none of 3 samples: speed lies between 0.2 and 3; choose a number between")
    );
    for options in [
        ReadOptions { y: Some("speed".into()), ..event("speed > 1") },
        ReadOptions { task: Some(TaskKind::Values), ..event("speed > 1") },
        ReadOptions { quantities: Some("v".into()), ..event("speed > 1") },
        ReadOptions { attribute: Some(0), ..event("speed > 1") },
    ] {
        let message = refused(&path, &options);
        assert!(message.contains("speaks of other targets than event"), "{message}");
    }
}

#[test]
fn rows_of_several_readings_are_pieces_of_a_recording() {
    let folder = tempdir().unwrap();
    let readings: Vec<f32> = (0..20).map(|i| i as f32).collect();
    let speed = f32s(&[5], &[0.0, 2.0, 2.0, 0.0, 2.0]);
    let arrays =
        [("x", f32s(&[5, 2, 2], &readings)), ("speed", speed), ("trial", i64s(&[5], &[7, 7, 9, 7, 9]))];
    let path = npz(folder.path(), &arrays);
    let options = ReadOptions {
        recording: Some("trial".into()),
        layout: Some(Layout::Series),
        rate: Some(10.0),
        length: Some(Length::Window { to: 4, hop: Some(2) }),
        ..event("speed > 1")
    };
    let data = load(&path, &options).unwrap();
    // Trial 7 has rows 0, 1 and 3, of which a window takes two; its target is that of its last row.
    assert_eq!(data.x.shape(), [3, 2, 4]);
    let first: Vec<f32> = data.x.iter().take(8).copied().collect();
    assert_eq!(first, [0.0, 1.0, 4.0, 5.0, 2.0, 3.0, 6.0, 7.0]);
    assert_eq!(*data.strata(), [1, 0, 1]);
    let steps = TargetSteps { recordings: vec![0, 0, 1], steps: vec![3, 5, 3], hop: 2, rate: Some(10.0) };
    assert_eq!(data.targets.steps(), Some(&steps));
    let one = data.select(&[1]);
    assert_eq!(one.targets.steps().unwrap().steps, [5]);
    // Without that layout rows are frames.
    let frames = ReadOptions { layout: None, length: Some("window:2,1".parse().unwrap()), ..options };
    assert_eq!(load(&path, &frames).unwrap().x.shape()[1..], [2, 2, 2]);
}

#[test]
fn classes_of_whole_recordings_have_no_steps() {
    let folder = tempdir().unwrap();
    let path = npz(folder.path(), &[("x", x()), ("y", i64s(&[4], &[0, 1, 1, 0]))]);
    let cut = ReadOptions { length: Some("window:2,1".parse().unwrap()), ..ReadOptions::default() };
    assert_eq!(load(&path, &cut).unwrap().targets.steps(), None);
    let labels = i64s(&[4, 3], &[0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 1, 1]);
    let path = npz(folder.path(), &[("x", x()), ("y", labels)]);
    let step = ReadOptions { target: Some(TargetOf::Step), ..cut };
    let steps = load(&path, &step).unwrap().targets.steps().unwrap().clone();
    assert_eq!((steps.steps, steps.rate), (vec![1, 2, 1, 2, 1, 2, 1, 2], None));
}
