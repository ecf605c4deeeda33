//! Pictures: what each effect does, and what tells an object.

#![allow(clippy::unwrap_used)]

use taxel_scenes::{Scene, Vision, vision::VisionClasses};

fn pictures(samples: usize, without: &[&str]) -> Scene {
    let without: Vec<String> = without.iter().map(ToString::to_string).collect();
    Vision { pixels: 24, ..Vision::default() }.simulate(samples, 3, &without).unwrap()
}

/// Mean absolute difference of two samples of a scene.
fn apart(scene: &Scene, a: usize, b: usize) -> f32 {
    let [a, b] = [a, b].map(|at| scene.x.index_axis(ndarray::Axis(0), at));
    (&a - &b).mapv(f32::abs).mean().unwrap()
}

#[test]
fn thirty_objects_or_six_families() {
    let scene = pictures(60, &[]);
    assert_eq!(scene.x.shape(), [60, 3, 24, 24]);
    assert_eq!((scene.class_names.len(), scene.class_names[0].as_str()), (30, "bird-1"));
    assert_eq!(scene.y, (0..60).map(|i| i % 30).collect::<Vec<u32>>());
    assert!(scene.x.iter().all(|value| (0.0..=1.0).contains(value)));
    let families = Vision { pixels: 24, classes: VisionClasses::Family, ..Vision::default() };
    let scene = families.simulate(36, 3, &[]).unwrap();
    assert_eq!(scene.class_names, ["bird", "chair", "hand", "head", "plane", "quadruped"]);
    // The sixth bird is the first object again.
    assert_eq!((scene.group[0], scene.group[6], scene.group[30]), (0, 1, 0));
}

#[test]
fn without_its_effects_a_picture_is_that_of_its_object() {
    let plain = pictures(60, &["light", "texture", "background", "pose"]);
    assert!(apart(&plain, 0, 30) == 0.0, "the same object twice");
    assert!(apart(&plain, 0, 29) > 0.02, "a bird and a quadruped");
    for effect in ["light", "texture", "background", "pose"] {
        let others: Vec<&str> =
            ["light", "texture", "background", "pose"].into_iter().filter(|other| *other != effect).collect();
        assert!(apart(&pictures(60, &others), 0, 30) > 0.002, "{effect} changes nothing");
    }
}

#[test]
fn an_effect_leaves_the_random_numbers_of_the_others_alone() {
    let (all, some) = (pictures(30, &[]), pictures(30, &["texture"]));
    assert_eq!(all.truth, some.truth);
    assert_eq!(
        pictures(7, &[]).x,
        all.x.slice_each_axis(|axis| match axis.axis.index() {
            0 => ndarray::Slice::from(0..7),
            _ => ndarray::Slice::from(..),
        })
    );
}

#[test]
fn what_is_impossible_is_refused() {
    let small = Vision { pixels: 4, ..Vision::default() };
    let text = small.simulate(1, 0, &[]).unwrap_err().to_string();
    assert!(text.contains("pixels") && text.contains("8..=1024"), "{text}");
    let text = Vision::default().simulate(1, 0, &["ligth".into()]).unwrap_err().to_string();
    assert!(text.contains("light"), "{text}");
}
