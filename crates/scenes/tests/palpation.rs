//! The palpation scene: its physics, its reproducibility and what each effect does.

#![allow(clippy::unwrap_used)]

mod common;

use common::{all_but, removable, truth};
use ndarray::{Array1, Array2, Axis};
use taxel_scenes::palpation::{Paper, Subset};
use taxel_scenes::{Error, Palpation, Scene, Settings, explain, simulate};

const PALPATION: &str = "palpation";

fn paper_002() -> Palpation {
    Palpation { paper: Paper::Manual, ..Palpation::default() }
}

fn frame(scene: &Scene, sample: usize, frame: usize) -> Array2<f32> {
    let frame = scene.x.view().index_axis_move(Axis(0), sample).index_axis_move(Axis(0), frame);
    frame.into_dimensionality().unwrap().to_owned()
}

/// Sum of each frame of one sample, counts.
fn sums(scene: &Scene, sample: usize) -> Vec<f32> {
    let frames = scene.x.len_of(Axis(1));
    (0..frames).map(|t| frame(scene, sample, t).sum()).collect()
}

fn class(scene: &Scene, name: &str) -> usize {
    scene.class_names.iter().position(|n| n == name).unwrap()
}

#[test]
fn shapes_units_and_names_are_those_of_the_papers() {
    let scene = simulate(PALPATION, 48, 1, &[]).unwrap();
    assert_eq!(scene.x.shape(), [48, 51, 28, 50]);
    assert_eq!((scene.class_names.len(), scene.full_scale), (24, 255.0));
    assert_eq!(scene.class_names[0], "bottle of coke");
    assert_eq!(scene.class_names[23], "rubber pipes");
    assert!(
        scene.x.iter().all(|v| (0.0..=255.0).contains(v) && v.fract() == 0.0 && (*v == 0.0 || *v >= 4.0))
    );
    assert!(scene.x.iter().any(|&v| v == 255.0), "nothing saturates");
    assert!(scene.y.iter().enumerate().all(|(i, &y)| y as usize == i % 24));
    assert_eq!((scene.group[23], scene.group[24]), (0, 1));

    let scene = paper_002().simulate(18, 1, &[]).unwrap();
    assert_eq!(scene.x.shape(), [18, 10, 28, 50]);
    assert_eq!(scene.class_names[5], "sponge_smooth_inclusions");
    for (name, values) in &scene.truth {
        assert_eq!(values.len(), 18, "{name}");
        assert!(values.iter().all(|v| v.is_finite()), "{name}");
    }
}

#[test]
fn subsets_are_eight_objects_each_and_frames_are_a_setting() {
    for (subset, first) in
        [(Subset::Rigid, "bottle of coke"), (Subset::Deformable, "ball 1"), (Subset::InBag, "gears")]
    {
        let scene =
            Palpation { subset, frames: Some(21), ..Palpation::default() }.simulate(9, 1, &[]).unwrap();
        assert_eq!(scene.class_names.len(), 8);
        assert_eq!(scene.class_names[0], first);
        assert_eq!(scene.x.shape(), [9, 21, 28, 50]);
    }
}

#[test]
fn a_sample_depends_on_seed_and_index_and_not_on_how_many_there_are() {
    let few = simulate(PALPATION, 24, 5, &[]).unwrap();
    let many = simulate(PALPATION, 40, 5, &[]).unwrap();
    assert_eq!(few, simulate(PALPATION, 24, 5, &[]).unwrap());
    assert_eq!(few.x, many.x.select(Axis(0), &(0..24).collect::<Vec<_>>()));
    assert_eq!(truth(&few, "peak_force_n"), &truth(&many, "peak_force_n")[..24]);
    assert_ne!(few.x, simulate(PALPATION, 24, 6, &[]).unwrap().x);
}

#[test]
fn readings_rise_with_the_squeeze_and_fall_with_the_release() {
    let scene = simulate(
        PALPATION,
        24,
        3,
        &all_but(PALPATION, &["placement", "force-steps", "inclusions", "texture", "blur"]),
    )
    .unwrap();
    for sample in 0..24 {
        let sums = sums(&scene, sample);
        assert!(sums[..26].is_sorted(), "{}: {sums:?}", scene.class_names[sample]);
        assert!(sums[25..].is_sorted_by(|a, b| a >= b), "{}: {sums:?}", scene.class_names[sample]);
        assert!(sums[25] > 1.2 * sums[0], "{}: {sums:?}", scene.class_names[sample]);
    }
}

#[test]
fn manual_force_is_the_force_on_the_taxels() {
    // Without losses, blur and saturation the counts add up to the force, to half a count a taxel.
    let scene = paper_002().simulate(9, 3, &all_but(PALPATION, &["force-steps"])).unwrap();
    let taxel = 34.0 / 255.0 * (53.3 / 28.0) * (95.3 / 50.0) * 1e-3;
    let mut compared = 0;
    for sample in 0..9 {
        let peak = frame(&scene, sample, 4);
        let active = peak.iter().filter(|&&v| v > 0.0).count() as f32;
        let (force, want) = (taxel * peak.sum(), truth(&scene, "peak_force_n")[sample]);
        assert!((20.0..=40.0).contains(&want), "{want} N");
        if peak.iter().all(|&v| v < 255.0) {
            // What is below 4 counts is not seen.
            let unseen = 1400.0 - active;
            assert!((force - want).abs() <= taxel * (0.5 * active + 3.5 * unseen), "{force} N, {want} N");
            compared += 1;
        }
    }
    assert!(compared >= 3, "{compared}");
}

#[test]
fn an_inclusion_is_invisible_at_light_force_and_shows_at_full_force() {
    let gripper = Palpation { subset: Subset::Deformable, ..Palpation::default() };
    let with = gripper.simulate(64, 7, &[]).unwrap();
    let without = gripper.simulate(64, 7, &["inclusions".into()]).unwrap();
    let manual_with = paper_002().simulate(90, 7, &[]).unwrap();
    let manual_without = paper_002().simulate(90, 7, &["inclusions".into()]).unwrap();
    for (with, without, peak) in [(&with, &without, 25), (&manual_with, &manual_without, 4)] {
        let (objects, last) = (with.class_names.len(), with.x.len_of(Axis(1)) - 1);
        for sample in 0..with.y.len() {
            let name = &with.class_names[sample % objects];
            let gap = |t: usize| (&frame(with, sample, t) - &frame(without, sample, t)).mapv(f32::abs).sum();
            if name.contains("inclusions") {
                assert_eq!((gap(0), gap(last)), (0.0, 0.0), "{name}, sample {sample}: seen at light force");
                assert!(gap(peak) > 0.0, "{name}, sample {sample}: never seen");
            } else {
                assert!((0..=last).all(|t| gap(t) == 0.0), "{name} has no inclusions");
            }
        }
    }
}

#[test]
fn twins_are_the_same_but_for_their_inclusions() {
    let all = all_but(PALPATION, &["texture"]);
    for (paper, plain, lumpy) in [
        (Paper::Manual, "ball", "ball_inclusions"),
        (Paper::Manual, "sponge_smooth", "sponge_smooth_inclusions"),
        (Paper::Manual, "sponge_rough", "sponge_rough_inclusions"),
        (Paper::Gripper, "sponge soft", "sponge soft with inclusions"),
        (Paper::Gripper, "sponge rough", "sponge rough with inclusions"),
    ] {
        let scene = Palpation { paper, ..Palpation::default() }.simulate(24, 0, &all).unwrap();
        let (a, b) = (class(&scene, plain), class(&scene, lumpy));
        assert_eq!(scene.x.index_axis(Axis(0), a), scene.x.index_axis(Axis(0), b), "{plain}");
    }
}

#[test]
fn rougher_is_seen_at_light_force_and_stiffer_is_smaller() {
    let scene = paper_002().simulate(9, 0, &all_but(PALPATION, &["texture"])).unwrap();
    // Bumps carry the load alone while it is light, and give way under more.
    let highest =
        |name: &str, t: usize| frame(&scene, class(&scene, name), t).iter().copied().fold(0.0, f32::max);
    let ratio = |t: usize| highest("ball_rough", t) / highest("ball", t);
    assert!(ratio(0) > 1.1 && ratio(4) < ratio(0), "{} {}", ratio(0), ratio(4));
    // A stiff mouse, a softer ball, a sponge: the same force on ever more taxels.
    let scene = simulate(PALPATION, 24, 0, &all_but(PALPATION, &[])).unwrap();
    let share = |name: &str| {
        let peak = frame(&scene, class(&scene, name), 25);
        peak.iter().filter(|&&v| v > 0.0).count()
    };
    assert!(share("mouse 1") < share("ball 1") && share("ball 1") < share("sponge scrunchy"));
}

#[test]
fn bags_are_packed_anew_and_shift_while_squeezed() {
    let bags = Palpation { subset: Subset::InBag, ..Palpation::default() };
    // Sample 3 and 11 are M6 nuts.
    let packed = |effects: &[&str]| bags.simulate(16, 2, &all_but(PALPATION, effects)).unwrap();
    let same = packed(&[]);
    assert_eq!(frame(&same, 3, 25), frame(&same, 11, 25));
    let anew = packed(&["packing"]);
    assert_ne!(frame(&anew, 3, 25), frame(&anew, 11, 25));
    // Without a shift, release retraces the squeeze when steps are even.
    for t in 0..25 {
        let gap = (&frame(&anew, 3, t) - &frame(&anew, 3, 50 - t)).mapv(f32::abs);
        assert!(gap.iter().all(|&v| v <= 1.0), "frame {t}");
    }
    let shifting = packed(&["bag-shift"]);
    let moved = (0..16).filter(|&i| {
        (0..25).any(|t| (&frame(&shifting, i, t) - &frame(&shifting, i, 50 - t)).mapv(f32::abs).sum() > 50.0)
    });
    assert!(moved.count() > 10);
    // Nothing else shifts.
    let rigid = Palpation { subset: Subset::Rigid, ..Palpation::default() };
    let with = rigid.simulate(8, 2, &[]).unwrap();
    let without = rigid.simulate(8, 2, &["bag-shift".into(), "packing".into()]).unwrap();
    assert_eq!(with.x, without.x);
}

#[test]
fn every_removable_effect_changes_the_readings_of_the_objects_it_is_about() {
    let short = Palpation { frames: Some(11), ..Palpation::default() };
    let whole = short.simulate(24, 9, &[]).unwrap();
    assert_eq!(removable(PALPATION).len(), 13);
    for effect in removable(PALPATION) {
        let without = short.simulate(24, 9, std::slice::from_ref(&effect)).unwrap();
        let gap: Array1<f32> = (0..24)
            .map(|i| {
                (&whole.x.index_axis(Axis(0), i) - &without.x.index_axis(Axis(0), i)).mapv(f32::abs).sum()
            })
            .collect();
        let touched = |name: &str| match effect.as_str() {
            "packing" | "bag-shift" => class(&whole, name) >= 16,
            "inclusions" => name.contains("inclusions"),
            "texture" => name.contains("rough") || ["ball 2", "sponge scrunchy"].contains(&name),
            _ => true,
        };
        for (i, name) in whole.class_names.iter().enumerate() {
            let lucky = effect == "bag-shift";
            assert!(
                gap[i] > 0.0 && touched(name) || gap[i] == 0.0 && (!touched(name) || lucky),
                "{effect}, {name}: {}",
                gap[i]
            );
        }
    }
    let all = removable(PALPATION);
    let bare = short.simulate(48, 9, &all).unwrap();
    assert_eq!(bare.x.index_axis(Axis(0), 19), bare.x.index_axis(Axis(0), 43), "something is still random");
}

#[test]
fn every_random_effect_is_another_in_every_grasp() {
    for effect in removable(PALPATION) {
        // Samples 5 and 13 are bags of M10 nuts in the sessions 0 and 1.
        let bags = Palpation { subset: Subset::InBag, ..Palpation::default() };
        let scene = bags.simulate(14, 9, &all_but(PALPATION, &[effect.as_str()])).unwrap();
        let same = scene.x.index_axis(Axis(0), 5) == scene.x.index_axis(Axis(0), 13);
        let fixed = ["blur", "texture", "inclusions"].contains(&effect.as_str());
        assert_eq!(same, fixed, "{effect}");
    }
}

#[test]
fn removing_an_effect_leaves_the_random_numbers_of_the_others_alone() {
    let whole = simulate(PALPATION, 24, 2, &[]).unwrap();
    let without = simulate(PALPATION, 24, 2, &["tilt".into()]).unwrap();
    for ((name, a), (_, b)) in whole.truth.iter().zip(&without.truth) {
        let tilted = ["tilt_deg", "peak_depth_mm", "peak_force_n"].contains(&name.as_str());
        assert!(a == b || tilted, "{name}");
    }
}

#[test]
fn impossible_requests_are_refused_by_name() {
    let message = |scene: Palpation| scene.simulate(3, 0, &[]).unwrap_err().to_string();
    let standard = Palpation::default();
    assert!(message(Palpation { sessions: 0, ..standard.clone() }).starts_with("sessions = 0:"));
    for frames in [0, 2, 1001] {
        let text = message(Palpation { frames: Some(frames), ..standard.clone() });
        assert!(text.starts_with(&format!("frames = {frames}: must be 3 to 1000")), "{text}");
    }
    let rigid = message(Palpation { paper: Paper::Manual, subset: Subset::Rigid, ..standard.clone() });
    assert!(rigid.starts_with("subset = rigid: paper = 002 has deformable objects only"), "{rigid}");
    assert!(standard.simulate(0, 0, &[]).unwrap_err().to_string().starts_with("samples = 0:"));
    let unknown = simulate(PALPATION, 3, 0, &["gripper".into()]).unwrap_err();
    assert!(matches!(unknown, Error::UnknownEffect { .. }), "{unknown}");
}

#[test]
fn settings_are_tables() {
    let parse = |text: &str| {
        let table: serde_json::Value = serde_json::from_str(text).unwrap();
        Settings::read(PALPATION, table).map_err(|e| e.to_string())
    };
    let scene = parse(r#"{"paper": "002", "frames": 21}"#).unwrap();
    assert_eq!(scene.simulate(2, 0, &[]).unwrap().x.shape(), [2, 21, 28, 50]);
    for (bad, says) in [
        (r#"{"papr": "002"}"#, "papr"),
        (r#"{"paper": "004"}"#, "expected `002` or `003`"),
        (r#"{"subset": "soft"}"#, "in-bag"),
    ] {
        let text = parse(bad).unwrap_err();
        assert!(text.contains(says), "{text}");
    }
}

#[test]
fn every_parameter_has_a_source_and_a_reason() {
    let effects = explain(PALPATION).unwrap();
    for effect in &effects {
        let texts = [&effect.name, &effect.parameter, &effect.value, &effect.source, &effect.why];
        assert!(texts.iter().all(|text| !text.is_empty()), "{effect:?}");
    }
    assert_eq!(effects.iter().filter(|e| e.name == "object").count(), 33);
}

/// Share of samples whose nearest neighbour in another session is of the same class; rows are samples.
fn nearest(rows: &Array2<f32>, scene: &Scene) -> f64 {
    let n = scene.y.len();
    let hits = (0..n).filter(|&i| {
        let others = (0..n).filter(|&j| scene.group[j] != scene.group[i]);
        let gap = |j: usize| (&rows.row(i) - &rows.row(j)).mapv(|v| v * v).sum();
        let best = others.min_by(|&a, &b| gap(a).total_cmp(&gap(b))).unwrap();
        scene.y[best] == scene.y[i]
    });
    hits.count() as f64 / n as f64
}

#[test]
fn a_light_frame_cannot_tell_the_twins_and_the_peak_can() {
    let scene =
        Palpation { subset: Subset::Deformable, ..Palpation::default() }.simulate(400, 11, &[]).unwrap();
    // Sums over the frame, sorted: what does not depend on where the object lies.
    let feature = |t: usize| {
        let mut rows = Array2::zeros((400, 40));
        for (i, mut row) in rows.outer_iter_mut().enumerate() {
            let mut values: Vec<f32> = frame(&scene, i, t).iter().copied().collect();
            values.sort_by(|a, b| b.total_cmp(a));
            row.assign(&Array1::from_vec(values[..40].to_vec()));
        }
        rows
    };
    let twins: Vec<usize> = (0..400)
        .filter(|i| {
            ["sponge soft", "sponge soft with inclusions"].contains(&scene.class_names[i % 8].as_str())
        })
        .collect();
    let of = |t: usize| {
        let rows = feature(t).select(Axis(0), &twins);
        let part = Scene {
            y: twins.iter().map(|&i| scene.y[i]).collect(),
            group: twins.iter().map(|&i| scene.group[i]).collect(),
            ..scene.clone()
        };
        nearest(&rows, &part)
    };
    let (light, full) = (of(0), of(25));
    println!("twins told apart: {light:.2} at the first frame, {full:.2} at the peak");
    assert!((0.3..0.7).contains(&light), "{light}");
    assert!(full > 0.9, "{full}");
}
