//! A small run on fresh worlds for each of three papers, from scene to verdict, whose verdict is pinned. Sizes, epochs and effects are
//! chosen so that a run takes seconds and its networks learn: a verdict here is one on this small world, and no paper's.
//!
//! Zhang et al. 2022 has none: each of its claims compares five networks, of which the smallest takes minutes to learn
//! its levels. Its statistics are tested on synthetic runs (`src/claims/tests.rs`, `tests_of_tables.rs`).

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

fn pinned(name: &str, set: &[String], says: &str, verdict: Verdict) {
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
}

#[test]
fn kaewrakmuk_2026_one_dimension_against_two() {
    pinned("paper-000", &[], "1D beats 2D: ResNet8-Lite", Verdict::Holds);
}

/// Body frozen as two epochs of pictures left it: what a new classifier makes of that is no more than chance.
#[test]
fn rouhafzay_2021_frozen_on_few_elements() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = folder.path().join("pictures");
    ran("paper-001-pictures", &[], &pictures);
    let weights = pictures.join("models/mobilenet-v2.r0.f0.safetensors");
    let set = [format!("networks.0.weights={:?}", weights.display().to_string())];
    pinned("paper-001", &set, "Frozen networks are around chance on 16 × 16 elements", Verdict::Holds);
}

#[test]
fn gandarias_2019b_a_sequence_against_a_frame() {
    let says = "A sequence tells an object from its twin with inclusions, a frame does not";
    pinned("paper-002", &[], says, Verdict::TooFewData);
}

#[test]
fn pastor_2019_two_grasps_of_each_object() {
    pinned(
        "paper-003",
        &[],
        "TactNet3D beats every 2D network with 2 grasps per object",
        Verdict::DoesNotHold,
    );
}
