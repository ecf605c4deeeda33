//! A small run on fresh worlds for each of three papers, from scene to verdict, whose verdict is pinned. Sizes, epochs and effects are
//! chosen so that a run takes seconds and its networks learn: a verdict here is one on this small world, and no paper's.
//!
//! Pastor et al. 2019 and Zhang et al. 2022 have none. Each claim of the first needs TactNet3D: 28 s of one core bring it to 70 % of
//! its training squeezes, and claims want 78 %. Each claim of the second compares five networks, the smallest of which takes
//! minutes to learn its levels. Their statistics are tested on synthetic runs (`src/claims/tests.rs`, `tests_of_tables.rs`). Tuned
//! MobileNetV2 does not learn in seconds either, so its claim here is one about frozen layers; the split network is in no claim
//! that a run decides.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use taxel::experiment::run;
use taxel::judge::{JudgeOptions, judge};
use taxel::learn::Silent;
use taxel::reporting::open;
use taxel::{Experiment, Overrides, Registry, RunOptions};
use taxel_reproduction::{Claim, Papers, Verdict, claims};

/// Runs a config of `tests/pinned` into a folder, with some values set.
fn ran(name: &str, set: &[String], out: &Path) {
    let registry = Registry::built_in();
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/pinned/{name}.toml"));
    let overrides = Overrides { set: set.to_vec(), ..Overrides::default() };
    let experiment = Experiment::load(&config, &overrides, &registry).unwrap();
    let stop = AtomicBool::new(false);
    run(&experiment, &registry, Some(out), &RunOptions::default(), &Silent, &stop).unwrap();
}

/// Returns what a run says of the claim that reads so.
fn claim(out: &Path, says: &str) -> Claim {
    let case = open(out).unwrap();
    let options = JudgeOptions { stress: None, budget: 0.02, ..JudgeOptions::default() };
    let judgement = judge(&case, &options).unwrap();
    let tested = claims(&[(&case, &judgement)], &Papers::default()).unwrap();
    tested.into_iter().find(|claim| claim.says == says).unwrap()
}

/// Checks the verdict of a run on the claim that reads so.
fn pinned(name: &str, set: &[String], says: &str, verdict: Verdict) -> Claim {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    ran(name, set, &out);
    let found = claim(&out, says);
    let interval = found.weakest().and_then(|contrast| contrast.interval);
    assert!(
        found.fresh && found.outcome() == verdict,
        "{}: {interval:?}: {found:?}",
        found.outcome().words()
    );
    found
}

#[test]
fn kaewrakmuk_2026_one_dimension_against_two() {
    pinned("paper-000", &[], "1D beats 2D: ResNet8-Lite", Verdict::Holds);
}

/// Writes six boxes as OBJ files, one of each class: the built-in objects take seconds to build for each world.
fn boxes(folder: &Path) {
    std::fs::create_dir(folder).unwrap();
    let sides: [[f64; 3]; 6] = [
        [1.0, 1.0, 1.0],
        [1.0, 1.0, 0.2],
        [1.0, 0.2, 0.2],
        [1.0, 0.6, 0.3],
        [0.5, 1.0, 0.9],
        [0.3, 0.4, 1.0],
    ];
    for (at, [x, y, z]) in sides.into_iter().enumerate() {
        let mut text = String::new();
        for corner in 0..8 {
            let of = |bit: usize, side: f64| if corner >> bit & 1 == 1 { side } else { 0.0 };
            text += &format!("v {} {} {}\n", of(0, x), of(1, y), of(2, z));
        }
        for [a, b, c, d] in
            [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]]
        {
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
        std::fs::write(folder.join(format!("box-{at}.obj")), text).unwrap();
    }
}

/// Body frozen as two epochs of pictures left it: what a new classifier makes of that is no more than chance.
#[test]
fn rouhafzay_2021_frozen_on_few_elements() {
    let folder = tempfile::tempdir().unwrap();
    let (pictures, meshes) = (folder.path().join("pictures"), folder.path().join("boxes"));
    boxes(&meshes);
    let meshes = format!("data.set.meshes={:?}", meshes.display().to_string());
    ran("paper-001-pictures", std::slice::from_ref(&meshes), &pictures);
    let weights = pictures.join("models/mobilenet-v2.r0.f0.safetensors");
    let set = [meshes, format!("networks.0.weights={:?}", weights.display().to_string())];
    pinned("paper-001", &set, "Frozen networks are around chance on 16 × 16 elements", Verdict::Holds);
}

/// Four worlds leave a difference of two points open; a difference that were clear here, or an interval twice as wide, would be
/// news.
#[test]
fn gandarias_2019b_a_sequence_against_a_frame() {
    let says = "A sequence tells an object from its twin with inclusions, a frame does not";
    let found = pinned("paper-002", &[], says, Verdict::TooFewData);
    let [low, high] = found.weakest().and_then(|contrast| contrast.interval).unwrap();
    assert!(-20.0 < low && high < 15.0, "{found:?}");
}
