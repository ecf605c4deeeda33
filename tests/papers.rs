//! One small, seeded experiment per paper on its simulated scene, through encoding, network, protocol and
//! metrics. The first epoch's loss is pinned (it moves when encoding, network, initialisation, order of
//! batches or loss change), and so is where the scores end up. These are regression values of this
//! repository on simulated data: no paper's numbers.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::sync::atomic::AtomicBool;

use taxel::experiment::run;
use taxel::learn::{FoldKey, NetworkResults, Silent};
use taxel::{Experiment, Overrides, Registry, RunOptions};

/// Runs `config`; of each network the loss of the first epoch of the first fold, and its results.
fn scores(config: &str) -> Vec<(f64, NetworkResults)> {
    let dir = tempfile::tempdir().unwrap();
    let registry = Registry::built_in();
    let experiment = Experiment::parse(config, "paper.toml", &Overrides::default(), &registry).unwrap();
    let (out, options) = (dir.path().join("run"), RunOptions::default());
    let folder = run(&experiment, &registry, Some(&out), &options, &Silent, &AtomicBool::new(false)).unwrap();
    let results = folder.results().unwrap();
    let first = |network: &NetworkResults| {
        let key = FoldKey { network: network.network.clone(), repetition: 0, fold: 0 };
        folder.record(&key).unwrap().unwrap().epochs.first().map_or(0.0, |epoch| epoch.train_loss)
    };
    results.networks.iter().map(|network| (first(network), network.clone())).collect()
}

/// Loss to a thousandth of itself, accuracy to `points`.
fn pinned((loss, network): &(f64, NetworkResults), want: (f64, f64), points: f64) {
    let accuracy = network.mean.unwrap().accuracy;
    println!("{}: ({loss:.6}, {accuracy:.2}), f1 {:.2}", network.network, network.mean.unwrap().f1);
    assert!((loss - want.0).abs() <= 1e-3 * want.0, "{}: first loss {loss}, was {}", network.network, want.0);
    assert!((accuracy - want.1).abs() <= points, "{}: {accuracy} %, was {}", network.network, want.1);
}

#[test]
fn paper_000_hardness_from_fingertips() {
    let found = scores(
        r#"
name = "paper-000"
seed = 1
baselines = ["majority", "mini-rocket"]
[data]
scene = "fingertip"
samples = 150
[encoding]
image = { kind = "gadf", size = 50, range = "per-sample", colormap = "jet" }
[protocol]
kind = "k-fold"
folds = 3
[train]
epochs = 12
batch_size = 16
optimizer = { lr = 0.01, momentum = 0.9 }
[[networks]]
name = "resnet8-lite-1d"
[[networks]]
name = "hybrid-resvgg"
train = { epochs = 4 }
"#,
    );
    pinned(&found[0], (1.176429, 80.00), 6.0);
    pinned(&found[1], (1.092827, 72.00), 8.0);
    // Of equals the first class; the class that a fold trains on most is the one that it tests least.
    assert!((found[2].1.mean.unwrap().accuracy - 100.0 / 3.0).abs() <= 2.0);
    // Paper 000, Fig. 6: hardness 20 is taken for 10 more often than for 00.
    let confusion = found[0].1.confusion.as_ref().unwrap().counts().to_vec();
    assert!(confusion[2][1] >= confusion[2][0], "{confusion:?}");
    assert_eq!(confusion.iter().flatten().sum::<u64>(), 150);
}

#[test]
fn paper_001_touch_on_virtual_arrays() {
    let found = scores(
        r#"
name = "paper-001"
seed = 1
baselines = []
[data]
scene = "imprint"
samples = 240
set = { elements = 32 }
[encoding]
image = { kind = "raw", red = true }
[protocol]
kind = "random-splits"
test = 0.25
[choose]
grid = { "optimizer.lr" = [3e-2, 1e-6] }
validation = 0.25
by = "accuracy"
[train]
epochs = 30
batch_size = 16
augment = { flip_columns = true, shift = 1.0, scale = [0.9, 1.1] }
[[networks]]
name = "vgg6-lite-2d"
"#,
    );
    pinned(&found[0], (1.845909, 35.00), 8.0);
    assert_eq!(found[0].1.folds[0].test_samples, 60);
}

#[test]
fn papers_002_and_003_squeezes() {
    let found = scores(
        r#"
name = "paper-002"
seed = 1
baselines = []
[data]
scene = "palpation"
samples = 90
set = { paper = "002", subset = "deformable" }
[encoding]
tensor = { scale = "full-scale" }
image = { kind = "frame", frame = "peak" }
[protocol]
kind = "few-samples"
per_class = [2, 6]
test = 0.3
[train]
epochs = 30
batch_size = 9
optimizer = { lr = 0.01, momentum = 0.9 }
[[networks]]
name = "tactnet3d-4-8"
set = { pool = 2 }
[[networks]]
name = "tactnet4"
"#,
    );
    for (row, want) in
        found.iter().zip([(2.328482, 40.74), (2.283739, 51.85), (2.400936, 37.04), (2.599461, 44.44)])
    {
        pinned(row, want, 12.0);
    }
    assert_eq!(found[1].1.network, "tactnet3d-4-8.n6");
    assert_eq!(found[1].1.folds[0].train_samples, 54);
}

#[test]
fn paper_004_levels_of_elasticity_and_hardness() {
    let found = scores(
        r#"
name = "paper-004"
seed = 1
baselines = ["majority"]
[data]
scene = "gripper"
samples = 240
attributes = ["elasticity", "hardness"]
[encoding]
image = { kind = "numatac" }
[protocol]
kind = "random-splits"
test = 0.25
[train]
epochs = 10
batch_size = 16
loss = "multi-label-soft-margin"
optimizer = { name = "adam", lr = 1e-3 }
batch_norm = "moving"
[[networks]]
name = "multiscale-cnn"
"#,
    );
    pinned(&found[0], (0.796978, 47.50), 12.0);
    let [elasticity, hardness] = found[0].1.attributes.as_slice() else { panic!("two attributes") };
    assert_eq!((elasticity.per_level.len(), hardness.per_level.len()), (10, 10));
    let mean = (elasticity.scores.accuracy + hardness.scores.accuracy) / 2.0;
    assert!((100.0 * mean - found[0].1.mean.unwrap().accuracy).abs() <= 1e-9);
}
