//! The gripper scene: its physics, its reproducibility and what each effect does.

#![allow(clippy::unwrap_used)]

mod common;

use common::{all_but, removable, truth};
use ndarray::{Array1, Array2, Axis};
use taxel_scenes::{Error, Gripper, Scene, explain, simulate};

const GRIPPER: &str = "gripper";

/// `[1 DC + 22 AC, ticks]` of one finger.
fn finger(scene: &Scene, sample: usize, finger: usize) -> Array2<f32> {
    let finger = scene.x.view().index_axis_move(Axis(0), sample).index_axis_move(Axis(0), finger);
    finger.into_dimensionality().unwrap().to_owned()
}

fn dc(scene: &Scene, sample: usize, side: usize) -> Array1<f32> {
    finger(scene, sample, side).row(0).to_owned()
}

/// Tick of the first AC value that is more than 1.1 or less than 0.9 of the one before.
fn judged(scene: &Scene, sample: usize) -> usize {
    let first = |side: usize| {
        let readings = finger(scene, sample, side);
        let ac: Vec<f32> =
            readings.columns().into_iter().flat_map(|tick| tick.to_vec().split_off(1)).collect();
        ac.windows(2)
            .position(|pair| !(0.9..=1.1).contains(&(pair[1] / pair[0])))
            .map_or(9999, |at| (at + 1) / 22)
    };
    first(0).min(first(1))
}

#[test]
fn shapes_units_and_labels_are_those_of_the_paper() {
    let scene = simulate(GRIPPER, 60, 1, &[]).unwrap();
    assert_eq!(scene.x.shape(), [60, 2, 23, 450]);
    assert!(scene.x.iter().all(|v| (0.0..=4095.0).contains(v) && v.fract() == 0.0));
    let attributes = scene.attributes.as_ref().unwrap();
    assert_eq!(attributes.y.dim(), (60, 2));
    assert_eq!(attributes.class_names[0][9], "elasticity-10");
    assert_eq!(attributes.class_names[1][0], "hardness-1");
    for column in attributes.y.columns() {
        // Three of the 30 objects on each level.
        assert!((0..10).all(|level| column.iter().filter(|&&l| l == level).count() == 6));
    }
    // The one label that the paper prints: the mineral water bottle, 9 and 3.
    assert_eq!(attributes.y.row(6).to_vec(), [8, 2]);
    assert_eq!((scene.y[6], scene.group[6], scene.group[36]), (8, 6, 6));
    assert!(truth(&scene, "session").iter().enumerate().all(|(i, &s)| s == (i / 30) as f32));
}

#[test]
fn a_sample_depends_on_seed_and_index_and_not_on_how_many_there_are() {
    let few = simulate(GRIPPER, 10, 5, &[]).unwrap();
    let many = simulate(GRIPPER, 50, 5, &[]).unwrap();
    assert_eq!(few, simulate(GRIPPER, 10, 5, &[]).unwrap());
    assert_eq!(few.x, many.x.select(Axis(0), &(0..10).collect::<Vec<_>>()));
    assert_ne!(few.x, simulate(GRIPPER, 10, 6, &[]).unwrap().x);
}

#[test]
fn the_contact_judge_finds_the_first_touch() {
    let scene = simulate(GRIPPER, 300, 3, &[]).unwrap();
    for sample in 0..300 {
        let (tick, contact) = (judged(&scene, sample) as f32, truth(&scene, "contact_s")[sample] / 0.01);
        assert!(
            (contact - 1.0..contact + 6.0).contains(&tick),
            "sample {sample}: {tick}, touch at {contact}"
        );
        // The window of 300 ticks fits.
        assert!(tick + 300.0 <= 450.0);
    }
}

#[test]
fn pressure_rises_at_the_rate_of_object_and_foam_in_series() {
    let scene = simulate(GRIPPER, 30, 3, &all_but(GRIPPER, &[])).unwrap();
    for sample in 0..30 {
        let (k, contact) = (truth(&scene, "stiffness_n_per_mm")[sample], truth(&scene, "contact_s")[sample]);
        let stop = truth(&scene, "stop_s")[sample];
        let series = k * 5.0 / (k + 5.0);
        // The last tick before the stop, by hand; DC is read at the last of 22 instants of a tick.
        let tick = (stop / 0.01).round() as usize - 1;
        let time = (tick as f32 + 21.0 / 22.0) * 0.01;
        let want = 238.0 + series * 10.0 * (time - contact) * 150.0 / 12.94;
        let got = dc(&scene, sample, 0)[tick];
        assert!((got - want).abs() <= 1.0, "sample {sample}: {got} bit, by hand {want}");
        assert!(got >= 270.0 && dc(&scene, sample, 0)[tick - 1] < 270.0);
        assert_eq!(dc(&scene, sample, 0), dc(&scene, sample, 1), "both fingers touch alike");
    }
}

#[test]
fn harder_rises_faster_and_overshoots_more_and_duller_lets_go() {
    let scene = simulate(GRIPPER, 30, 3, &all_but(GRIPPER, &["delay", "relaxation"])).unwrap();
    let order = |name: &str| {
        let values = truth(&scene, name);
        let mut order: Vec<usize> = (0..30).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        order
    };
    let squeeze = |i: usize| truth(&scene, "stop_s")[i] - truth(&scene, "contact_s")[i];
    let hard = order("stiffness_n_per_mm");
    assert!(squeeze(hard[0]) > 2.0 * squeeze(hard[15]) && squeeze(hard[15]) > squeeze(hard[29]));
    assert!(truth(&scene, "peak_force_left_n")[hard[29]] > 1.2 * truth(&scene, "peak_force_left_n")[hard[0]]);
    // Share of the pressure at the stop that is left at the end of the hold.
    let kept = |name: &str| {
        let i =
            ["garbage bag", "square sponge", "mask", "metal column"].iter().position(|n| *n == name).unwrap();
        let i = [1, 8, 11, 18][i];
        let stop = (truth(&scene, "stop_s")[i] / 0.01).ceil() as usize;
        let series = dc(&scene, i, 0);
        (series[stop + 95] - 238.0) / (series[stop] - 238.0)
    };
    assert!(kept("square sponge") > 0.95, "elasticity 10: {}", kept("square sponge"));
    assert!(
        kept("mask") < 0.9 && kept("garbage bag") < kept("mask"),
        "{} {}",
        kept("mask"),
        kept("garbage bag")
    );
    // The foam hides what a hard object does.
    assert!(kept("metal column") > kept("garbage bag"));
}

#[test]
fn ac_rests_at_its_offset_and_rings_longer_on_elastic_objects() {
    let scene = simulate(GRIPPER, 30, 3, &all_but(GRIPPER, &[])).unwrap();
    let power = |sample: usize, from: usize, to: usize| {
        let readings = finger(&scene, sample, 0);
        let ac: Vec<f32> = (from..to).flat_map(|t| readings.column(t).to_vec().split_off(1)).collect();
        // The ring alone: differences from value to value.
        ac.windows(2).map(|p| (p[1] - p[0]).powi(2)).sum::<f32>()
    };
    for sample in 0..30 {
        assert!(finger(&scene, sample, 0).column(10).iter().skip(1).all(|&v| v == 2048.0));
    }
    let contact = |sample: usize| (truth(&scene, "contact_s")[sample] / 0.01) as usize;
    // Both of hardness 2: bubble wrap is of elasticity 8, the towel of 3.
    let late = |i: usize| power(i, contact(i) + 3, contact(i) + 6) / power(i, contact(i), contact(i) + 6);
    assert!(late(5) > 2.0 * late(0), "{} {}", late(5), late(0));
}

#[test]
fn every_removable_effect_changes_the_readings() {
    let whole = simulate(GRIPPER, 30, 9, &[]).unwrap();
    assert_eq!(removable(GRIPPER).len(), 5);
    for effect in removable(GRIPPER) {
        let without = simulate(GRIPPER, 30, 9, std::slice::from_ref(&effect)).unwrap();
        assert_ne!(whole.x, without.x, "{effect}");
        assert_eq!(whole.attributes, without.attributes);
        assert_eq!(
            truth(&whole, "contact_s"),
            truth(&without, "contact_s"),
            "{effect} shifts other random numbers"
        );
    }
    let bare = simulate(GRIPPER, 60, 9, &removable(GRIPPER)).unwrap();
    let squeeze = |i: usize| truth(&bare, "stop_s")[i] - truth(&bare, "contact_s")[i];
    // Time of contact is all that differs, to one tick.
    assert!((0..30).all(|i| (squeeze(i) - squeeze(i + 30)).abs() <= 0.0101));
}

#[test]
fn every_random_effect_is_another_in_every_grasp() {
    for effect in ["delay", "placement", "offset", "noise"] {
        let scene = simulate(GRIPPER, 34, 9, &all_but(GRIPPER, &[effect])).unwrap();
        // The first 0.4 s are before contact, the hold is after it: the same object, sessions 0 and 1.
        let differs = |from: usize, to: usize| {
            let (a, b) = (finger(&scene, 3, 0), finger(&scene, 33, 0));
            (from..to).any(|t| a.column(t) != b.column(t))
        };
        let after = truth(&scene, "peak_force_left_n")[3] != truth(&scene, "peak_force_left_n")[33];
        let at_rest = ["offset", "noise"].contains(&effect);
        assert_eq!((differs(0, 39), after || at_rest), (at_rest, true), "{effect}");
    }
}

#[test]
fn chosen_objects_have_the_levels_that_they_have() {
    let objects = ["tennis", "mask", "metal column", "rubber"].map(String::from).to_vec();
    let scene =
        Gripper { objects: Some(objects), sessions: 2, ..Gripper::default() }.simulate(8, 0, &[]).unwrap();
    let attributes = scene.attributes.unwrap();
    assert_eq!(attributes.class_names[0], ["elasticity-1", "elasticity-4", "elasticity-8", "elasticity-10"]);
    assert_eq!(attributes.class_names[1], ["hardness-1", "hardness-7", "hardness-8", "hardness-10"]);
    assert_eq!(attributes.y.row(4).to_vec(), [3, 1]);
    assert_eq!(scene.group, [0, 1, 2, 3, 0, 1, 2, 3]);
}

#[test]
fn impossible_requests_are_refused_by_name() {
    let message = |objects: &[&str]| {
        let objects = Some(objects.iter().map(|name| String::from(*name)).collect());
        Gripper { objects, ..Gripper::default() }.simulate(3, 0, &[]).unwrap_err().to_string()
    };
    assert!(message(&[]).starts_with("objects = []: name at least one"));
    assert!(message(&["tennis", "tenis"]).starts_with("objects = tenis: is none of the 30"));
    assert!(message(&["tennis", "tennis"]).starts_with("objects = tennis: each object is named once"));
    let none = Gripper { sessions: 0, ..Gripper::default() }.simulate(3, 0, &[]).unwrap_err();
    assert!(none.to_string().starts_with("sessions = 0:"));
    assert!(simulate(GRIPPER, 0, 0, &[]).unwrap_err().to_string().starts_with("samples = 0:"));
    assert!(matches!(simulate(GRIPPER, 3, 0, &["tap".into()]), Err(Error::UnknownEffect { .. })));
}

#[test]
fn every_parameter_has_a_source_and_a_reason() {
    let effects = explain(GRIPPER).unwrap();
    for effect in &effects {
        let texts = [&effect.name, &effect.parameter, &effect.value, &effect.source, &effect.why];
        assert!(texts.iter().all(|text| !text.is_empty()), "{effect:?}");
    }
    assert_eq!(effects.iter().filter(|e| e.unit == "levels").count(), 30);
}
