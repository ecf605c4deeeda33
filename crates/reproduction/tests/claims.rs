//! The claims, tested on a small run.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use taxel::experiment::run;
use taxel::judge::{JudgeOptions, judge};
use taxel::learn::Silent;
use taxel::reporting::open;
use taxel::{Experiment, Overrides, Registry, RunOptions, Source};
use taxel_reproduction::{Papers, Verdict, claims};

const CONFIG: &str = r#"
name = "judged"
seed = 3

[data]
scene = "fingertip"
samples = 60

[protocol]
kind = "k-fold"
folds = 2

[encoding.image]
kind = "gadf"
size = 12
range = "per-sample"

[train]
epochs = 2
batch_size = 8

[[networks]]
name = "resnet8-lite-1d"

[[networks]]
name = "vgg6-lite-2d"
"#;

#[test]
fn a_run_is_asked_about_claims() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("judged.toml");
    std::fs::write(&config, CONFIG).unwrap();
    let registry = Registry::built_in();
    let experiment = Experiment::load(Path::new(&config), &Overrides::default(), &registry).unwrap();
    let out = folder.path().join("run");
    run(&experiment, &registry, Some(&out), &RunOptions::default(), &Silent, &AtomicBool::new(false))
        .unwrap();
    let case = open(&out).unwrap();
    let judgement =
        judge(&case, &JudgeOptions { stress: None, budget: 0.05, ..JudgeOptions::default() }).unwrap();
    let tested = claims(&[(&case, &judgement)], &Papers::default()).unwrap();
    let says = |part: &str| tested.iter().find(|claim| claim.says.contains(part)).unwrap();
    assert_eq!(says("1D beats 2D: ResNet8").outcome(), Verdict::CannotBeTested);
    // Two epochs teach nobody: neither network takes part.
    let effect = says("1D beats 2D: ResNet8").effect();
    assert!(effect.contains("lacks resnet8-lite-1d trained to its end (right on "), "{effect}");
    assert!(effect.ends_with(" % of its training samples), resnet8-lite-2d"), "{effect}");
    let shore = says("commonest error of 2D-Vgg6-Lite");
    assert!(shore.effect().contains("lacks vgg6-lite-2d trained to its end"), "{shore:?}");
    assert_eq!((&shore.source, shore.run.as_str()), (&Source::simulated("fingertip"), "judged"));
}
