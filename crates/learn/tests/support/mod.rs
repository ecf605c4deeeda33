//! Small data sets, networks for them, and runs in folders.

#![allow(dead_code, clippy::unwrap_used)]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ndarray::ArrayD;
use serde_json::{Value, json};
use taxel_base::Layout;
use taxel_baselines::Method;
use taxel_data::{Dataset, Labels, Targets};
use taxel_learn::{
    Candidate, CrossValidation, Encoder, Encoding, Error, FoldKey, FoldRecord, Model, Protocol, Recipe,
    RunFolder, RunOptions, Silent, Trainable,
};

/// A number in [-1, 1) that looks random.
fn noise(i: usize) -> f32 {
    let mut h = (i as u32).wrapping_mul(2_654_435_761).wrapping_add(12_345);
    for (shift, factor) in [(15, 2_246_822_519u32), (13, 3_266_489_917)] {
        h ^= h >> shift;
        h = h.wrapping_mul(factor);
    }
    (h >> 8) as f32 / 8_388_608.0 - 1.0
}

/// Presses of three classes, two channels of `length` readings each: a noisy ramp of 10, 12 or 14, and noise.
pub fn presses(samples: usize, length: usize) -> Dataset {
    let x = ArrayD::from_shape_fn(vec![samples, 2, length], |at| {
        let (sample, channel, tick) = (at[0], at[1], at[2]);
        let height = [10.0 + 2.0 * (sample % 3) as f32, 5.0][channel];
        height * tick as f32 / length as f32 + 2.0 * noise((sample * 2 + channel) * length + tick)
    });
    let labels: Vec<&str> = (0..samples).map(|i| ["soft", "medium", "stiff"][i % 3]).collect();
    Dataset::new("presses", Layout::Series, x, &labels).unwrap()
}

/// Images of three classes: a bright square of another size somewhere on a noisy ground.
pub fn imprints(samples: usize, side: usize) -> Dataset {
    let x = ArrayD::from_shape_fn(vec![samples, side, side], |at| {
        let (sample, row, column) = (at[0], at[1], at[2]);
        let (size, corner) = (2 + 2 * (sample % 3), sample % 4);
        let inside = (corner..corner + size).contains(&row) && (corner..corner + size).contains(&column);
        f32::from(u8::from(inside)) * 200.0 + 20.0 * (1.0 + noise((sample * side + row) * side + column))
    });
    let labels: Vec<&str> = (0..samples).map(|i| ["ball", "egg", "box"][i % 3]).collect();
    Dataset::new("imprints", Layout::Image, x, &labels).unwrap().with_full_scale(255.0).unwrap()
}

/// Squeezes of three classes `[time, rows, columns]`: pressure grows with time and class.
pub fn squeezes(samples: usize, [frames, rows, columns]: [usize; 3]) -> Dataset {
    let x = ArrayD::from_shape_fn(vec![samples, frames, rows, columns], |at| {
        let place = ((at[0] * frames + at[1]) * rows + at[2]) * columns + at[3];
        (1 + at[0] % 3) as f32 * at[1] as f32 * 5.0 + 10.0 * (1.0 + noise(place))
    });
    let labels: Vec<&str> = (0..samples).map(|i| ["hand", "cable", "rock"][i % 3]).collect();
    Dataset::new("squeezes", Layout::Sequence, x, &labels).unwrap().with_full_scale(255.0).unwrap()
}

/// 60 samples of two attributes that channel 0 and channel 1 show: level = height.
pub fn two_attributes() -> Dataset {
    let levels = |i: usize| [i % 3, (i / 3) % 4];
    let x = ArrayD::from_shape_fn(vec![60, 2, 12], |at| {
        levels(at[0])[at[1]] as f32 + 0.2 * ((at[0] * 7 + at[2] * 3) as f32).sin()
    });
    let groups: Vec<usize> = (0..60).map(|i| i / 12).collect();
    let firsts: Vec<usize> = (0..60).map(|i| levels(i)[0]).collect();
    let mut dataset = Dataset::new("levels", Layout::Series, x, &firsts).unwrap();
    dataset = dataset.with_groups(&groups).unwrap();
    dataset = dataset.with_official((0..60).map(|i| i % 4 == 0).collect()).unwrap();
    let names = |count: usize| (0..count).map(|level| level.to_string()).collect();
    let values = (0..60).flat_map(|i| levels(i).map(|level| level as u32)).collect();
    let Targets::Classes { columns, .. } = &mut dataset.targets else { unreachable!("classes were given") };
    *columns = Some(Labels::numbered(vec![names(3), names(4)], values));
    dataset
}

/// A recipe as a config writes it: 4 epochs in batches of 8, and `changes`.
pub fn recipe(changes: Value) -> Recipe {
    let mut recipe = json!({ "epochs": 4, "batch_size": 8 });
    recipe.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
    serde_json::from_value(recipe).unwrap()
}

/// The zoo's network `name`, sized by the samples.
pub fn network(name: &str, settings: Value, recipe: Recipe, encoder: &mut Encoder) -> Candidate {
    let entry = taxel_zoo::find(name).unwrap();
    let inputs: Vec<&str> = entry.inputs.iter().map(|input| input.name.as_str()).collect();
    encoder.prepare(&inputs).unwrap();
    let mut sized = entry.fit(encoder.dataset().output_names().len(), |input| encoder.shape(input)).unwrap();
    sized.extend(settings.as_object().unwrap().clone());
    let graph = entry.graph(&sized).unwrap();
    Candidate { name: name.into(), settings: sized, ..Candidate::network(graph, recipe) }
}

/// A small MLP for a data set.
pub fn mlp(dataset: &Dataset, recipe: Recipe) -> Candidate {
    let mut encoder = Encoder::new(&Encoding::default(), dataset);
    network("mlp", json!({ "hidden": 8 }), recipe, &mut encoder)
}

/// The network of a candidate.
pub fn trainable(candidate: &Candidate) -> &Trainable {
    candidate.estimator.as_network().unwrap()
}

/// Changes the network of a candidate.
pub fn change(candidate: &mut Candidate, change: impl FnOnce(&mut Trainable)) {
    let mut network = trainable(candidate).clone();
    change(&mut network);
    candidate.estimator = Arc::new(network);
}

/// 3 folds of `candidates` with seed 3.
pub fn three_folds<'d>(dataset: &'d Dataset, candidates: Vec<Candidate>) -> CrossValidation<'d> {
    let validation = CrossValidation::new(dataset).protocol(Protocol::k_fold(3)).seed(3);
    candidates.into_iter().fold(validation, CrossValidation::candidate)
}

/// Runs into a fresh folder at `out` on one thread.
pub fn run_at(validation: CrossValidation, out: &Path) -> Result<RunFolder, Error> {
    let options = RunOptions { threads: Some(1), ..RunOptions::default() };
    validation.run_in(out, &options, &Silent, &AtomicBool::new(false))
}

/// Runs into a folder that lives as long as the first of the two.
pub fn run(validation: CrossValidation) -> (tempfile::TempDir, RunFolder) {
    let dir = tempfile::tempdir().unwrap();
    let folder = run_at(validation, &dir.path().join("run")).unwrap();
    (dir, folder)
}

pub fn key(network: &str, repetition: usize, fold: usize) -> FoldKey {
    FoldKey { network: network.into(), repetition, fold }
}

pub fn record(folder: &RunFolder, key: &FoldKey) -> FoldRecord {
    folder.record(key).unwrap().unwrap()
}

pub fn model(folder: &RunFolder, key: &FoldKey) -> Model {
    Model::open(&folder.model_path(key)).unwrap()
}

/// Bits, so that -0 and 0 differ and NaN equals itself.
pub fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Light networks and all baselines, with what they learn from.
pub fn candidates() -> (Dataset, Encoding, Vec<Candidate>) {
    let dataset = presses(24, 40);
    let encoding: Encoding = serde_json::from_value(
        json!({ "image": { "kind": "gadf", "size": 24 }, "rocket": { "features": 84 } }),
    )
    .unwrap();
    let mut validation = CrossValidation::new(&dataset).encoding(encoding.clone());
    let encoder = validation.encoder();
    let once = || recipe(json!({ "epochs": 1 }));
    let mut candidates = vec![mlp(&dataset, once())];
    for name in ["resnet8-lite-1d", "vgg6-lite-2d", "hybrid-resvgg", "dilated-resnet-rocket-1d"] {
        candidates.push(network(name, json!({}), once(), encoder));
    }
    candidates.extend(Method::all().map(Candidate::baseline));
    (presses(24, 40), encoding, candidates)
}
