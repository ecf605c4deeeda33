//! Factors: how much of an effect a scene has.

#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use common::{all_but, removable, truth};
use serde_json::{Value, json};
use taxel_scenes::{Scene, Settings, names};
use tempfile::TempDir;

/// Two objects: the built-in ones take seconds to build.
static TETRAHEDRA: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    for (name, z) in [("flat", 0.4), ("steep", 1.5)] {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.3 {z}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
        std::fs::write(folder.path().join(format!("{name}.obj")), text).unwrap();
    }
    folder
});

/// Few and small samples of a scene, all objects of a small subset.
fn scene(name: &str, factors: Value, without: &[String]) -> taxel_scenes::Result<Scene> {
    let mut set = match name {
        "palpation" => json!({ "subset": "in-bag", "frames": 5 }),
        "imprint" => json!({ "elements": 8, "meshes": TETRAHEDRA.path() }),
        "gel" => json!({ "pixels": 24 }),
        "vision" => json!({ "pixels": 16, "meshes": TETRAHEDRA.path() }),
        _ => json!({}),
    };
    set["factors"] = factors;
    Settings::read(name, set)?.simulate(8, 3, without)
}

/// Effects that are there or not.
const SWITCHED: [&str; 10] = [
    "blur",
    "packing",
    "bag-shift",
    "texture",
    "inclusions",
    "membrane",
    "light",
    "texture",
    "background",
    "pose",
];

#[test]
fn a_factor_reaches_from_no_effect_to_the_whole() {
    for name in names() {
        let plain = scene(name, json!({}), &[]).unwrap();
        for effect in removable(name) {
            let at = |factor: f64| scene(name, json!({ (effect.as_str()): factor }), &[]);
            assert_eq!(at(1.0).unwrap(), plain, "{name}: all of {effect}");
            let without = scene(name, json!({}), std::slice::from_ref(&effect)).unwrap();
            assert_eq!(at(0.0).unwrap(), without, "{name}: nothing of {effect}");
            if SWITCHED.contains(&effect.as_str()) {
                let error = at(0.5).unwrap_err().to_string();
                assert!(error.contains(&format!("{{ {effect} = 0.5 }}: must be 0 or 1")), "{error}");
                continue;
            }
            let half = at(0.5).unwrap();
            assert!(half != plain && half != without, "{name}: half of {effect} is neither");
        }
    }
}

#[test]
fn half_a_placement_is_half_the_shift_and_a_fourth_of_an_exponent_its_fourth() {
    let values = |factors: Value, effect: &str, of: &str| {
        let scene = scene("palpation", factors, &all_but("palpation", &[effect])).unwrap();
        truth(&scene, of).to_vec()
    };
    let whole = values(json!({}), "placement", "shift_along_mm");
    let half = values(json!({ "placement": 0.5 }), "placement", "shift_along_mm");
    assert!(whole.iter().zip(&half).all(|(a, b)| (a / 2.0 - b).abs() < 1e-5), "{whole:?} {half:?}");
    // A sensitivity multiplies: its logarithm is what has an SD.
    let whole = values(json!({}), "session", "sensitivity");
    let part = values(json!({ "session": 0.25 }), "session", "sensitivity");
    assert!(whole.iter().zip(&part).all(|(a, b)| (a.ln() / 4.0 - b.ln()).abs() < 1e-5), "{whole:?} {part:?}");
}

#[test]
fn factors_that_no_effect_can_have_are_refused() {
    let refused = |factors: Value, without: &[&str]| {
        let without: Vec<String> = without.iter().map(ToString::to_string).collect();
        scene("palpation", factors, &without).unwrap_err().to_string()
    };
    for factor in [-0.1, 1.1, 1e300] {
        let error = refused(json!({ "placement": factor }), &[]);
        assert!(error.starts_with("factors = { placement = ") && error.contains("from 0"), "{error}");
    }
    let both = refused(json!({ "placement": 0.5 }), &["placement"]);
    assert!(both.contains("`without` leaves out; keep one"), "{both}");
    let unknown = refused(json!({ "placment": 0.5 }), &[]);
    assert!(unknown.contains("no removable effect `placment`") && unknown.contains("placement"), "{unknown}");
    let nan = BTreeMap::from([("placement".to_string(), f64::NAN)]);
    let settings = taxel_scenes::Palpation { factors: nan, ..Default::default() };
    assert!(settings.simulate(1, 0, &[]).unwrap_err().to_string().contains("from 0"));
}
