//! A gel: what each effect does, and that it is the touches of `imprint` by another sensor.

#![allow(clippy::unwrap_used)]

use ndarray::{Array3, Axis};
use taxel_scenes::{Gel, Scene, gel::Touches};

fn touched(touches: Touches, samples: usize, without: &[&str]) -> Scene {
    let without: Vec<String> = without.iter().map(ToString::to_string).collect();
    Gel { touches, pixels: 24, ..Gel::default() }.simulate(samples, 3, &without).unwrap()
}

fn picture(scene: &Scene, at: usize) -> Array3<f32> {
    scene.x.index_axis(Axis(0), at).to_owned().into_dimensionality().unwrap()
}

fn apart(a: &Array3<f32>, b: &Array3<f32>) -> f32 {
    (a - b).mapv(f32::abs).mean().unwrap()
}

#[test]
fn twelve_cloths_in_pieces_or_six_families_of_objects() {
    let cloths = touched(Touches::Cloths, 120, &[]);
    assert_eq!(cloths.x.shape(), [120, 3, 24, 24]);
    assert_eq!((cloths.class_names.len(), cloths.class_names[0].as_str()), (12, "plain"));
    assert!(cloths.x.iter().all(|value| (0.0..=255.0).contains(value) && value.fract() == 0.0));
    // Eight pieces of a cloth take turns.
    assert_eq!((cloths.group[0], cloths.group[12], cloths.group[96]), (0, 1, 0));
    assert_eq!(cloths.truth[2].1[0], cloths.truth[2].1[96], "a piece keeps its pitch");
    assert_ne!(cloths.truth[2].1[0], cloths.truth[2].1[12]);
    let objects = touched(Touches::Objects, 36, &[]);
    assert_eq!(objects.class_names, ["bird", "chair", "hand", "head", "plane", "quadruped"]);
    assert_eq!((objects.group[0], objects.group[6], objects.group[30]), (0, 1, 0));
}

#[test]
fn where_nothing_touches_a_pixel_reads_its_rest() {
    // Without noise, most of a picture of objects is the flat gel.
    let scene = touched(Touches::Objects, 12, &["noise"]);
    let flat = scene.x.iter().filter(|value| **value == scene.rest[0]).count();
    assert!(flat > scene.x.len() / 4, "{flat} of {}", scene.x.len());
}

#[test]
fn a_firmer_touch_shows_more() {
    let scene = touched(Touches::Objects, 60, &["noise"]);
    let active =
        |at: usize| picture(&scene, at).iter().filter(|value| **value != scene.rest[0]).count() as f32;
    let depth = &scene.truth[0].1;
    let (mut firm, mut light) = (vec![], vec![]);
    (0..60).for_each(|at| if depth[at] > 1.0 { firm.push(active(at)) } else { light.push(active(at)) });
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    assert!(mean(&firm) > mean(&light), "{} {}", mean(&firm), mean(&light));
}

#[test]
fn every_effect_changes_the_picture_and_leaves_the_random_numbers_of_the_others_alone() {
    let all = touched(Touches::Cloths, 24, &[]);
    for effect in ["depth", "membrane", "noise", "spin", "piece"] {
        let less = touched(Touches::Cloths, 24, &[effect]);
        // A cloth that is pressed in to its ground shows no more when it goes deeper: not every picture changes.
        let changed = (0..24).map(|at| apart(&picture(&all, at), &picture(&less, at))).fold(0.0, f32::max);
        assert!(changed > 0.3, "{effect} changes nothing: {changed}");
        for (at, quantity) in [(0, "depth"), (1, "spin"), (2, "piece")] {
            assert_eq!(all.truth[at] == less.truth[at], quantity != effect, "{effect}: {}", all.truth[at].0);
        }
    }
    assert_eq!(touched(Touches::Cloths, 7, &[]).x, all.x.slice_axis(Axis(0), ndarray::Slice::from(0..7)));
}

#[test]
fn a_turn_of_the_gel_turns_the_colours() {
    // The lamps stand still: the same object under another turn is another picture, not a turned one.
    let (spun, unturned) =
        (touched(Touches::Objects, 6, &["noise"]), touched(Touches::Objects, 6, &["noise", "spin"]));
    assert!(spun.truth[1].1.iter().all(|degrees| (0.0..360.0).contains(degrees)));
    assert!(unturned.truth[1].1.iter().all(|degrees| *degrees == 0.0));
    assert!((0..6).any(|at| apart(&picture(&spun, at), &picture(&unturned, at)) > 1.0));
}

#[test]
fn what_is_impossible_is_refused() {
    let refused = |gel: Gel| gel.simulate(1, 0, &[]).unwrap_err().to_string();
    let text = refused(Gel { pixels: 4, ..Gel::default() });
    assert!(text.contains("pixels") && text.contains("8..=512"), "{text}");
    let text = refused(Gel { meshes: Some("here".into()), ..Gel::default() });
    assert!(text.contains("objects"), "{text}");
    let text = Gel::default().simulate(1, 0, &["dept".into()]).unwrap_err().to_string();
    assert!(text.contains("depth"), "{text}");
}
