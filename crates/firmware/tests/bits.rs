//! Compiles exported networks on this computer and compares bits: of 200 samples, and of every threshold of every layer.
//! The tests of the workspace need a C compiler anyway (zstd is C).
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::process::Command;

use taxel_base::exponential;
use taxel_encodings::Scaling;
use taxel_firmware::{Expected, Library, Samples, write_folder};
use taxel_graph::{Graph, Scheme, Tensor, Weights};
use taxel_runtime::{Blueprint, Frozen, Observer, Ranges};

const SAMPLE: [usize; 2] = [5, 50];
const CLASSES: usize = 3;

/// Warnings that a strict project turns on.
const WARNINGS: [&str; 8] = [
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wsign-conversion",
    "-Wshadow",
    "-Wdouble-promotion",
    "-Werror",
];

/// A network of the zoo for samples of 5 channels × 50 time steps.
fn graph(name: &str) -> Graph {
    let entry = taxel_zoo::find(name).unwrap();
    let settings = entry.fit(CLASSES, |input| match input {
        "signal" => Some(SAMPLE.to_vec()),
        _ => None,
    });
    entry.graph(&settings.unwrap()).unwrap()
}

/// Fresh weights, with batch norms and biases that have seen something.
fn weights(graph: &Graph) -> Weights {
    let fresh = Weights::init(graph, Scheme::Pytorch, 7, "firmware");
    let mut weights = Weights::new();
    for (number, (name, tensor)) in fresh.iter().enumerate() {
        let wave = |i: usize| ((i * 37 + number * 11) as f32 * 0.7).sin();
        let mut data = tensor.data.clone();
        if name.ends_with("running_mean") || name.ends_with("bias") {
            data.iter_mut().enumerate().for_each(|(i, v)| *v += 0.2 * wave(i));
        } else if name.ends_with("running_var") {
            data.iter_mut().enumerate().for_each(|(i, v)| *v *= 1.0 + 0.5 * wave(i));
        }
        weights.insert(name, Tensor { shape: tensor.shape.clone(), data });
    }
    weights
}

fn scaled(scaling: &Scaling, sample: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; sample.len()];
    scaling.encode(SAMPLE[0], sample, &mut out).unwrap();
    out
}

/// A network with samples and what the runtime predicts for them.
struct Case {
    blueprint: Blueprint,
    samples: Samples,
    scaling: Scaling,
    temperature: Option<f64>,
    expected: Expected,
}

impl Case {
    fn new(name: &str, scaling: Scaling, temperature: Option<f64>) -> Self {
        let (graph, ranges) =
            (graph(name), [[0.0, 1023.0], [100.0, 900.0], [-3.0, 5.0], [0.0, 0.7], [40.0, 41.0]]);
        let weights = weights(&graph);
        let samples = Samples::new(200, &ranges, SAMPLE[1]);
        let inputs: Vec<Vec<f32>> =
            samples.values().chunks(SAMPLE[0] * SAMPLE[1]).map(|sample| scaled(&scaling, sample)).collect();
        let mut observer = Observer::new(&graph, &weights).unwrap();
        inputs[..50].iter().for_each(|input| observer.see(&[input]).unwrap());
        let ranges: Ranges = observer.ranges();
        let frozen = Frozen::quantized(&graph, &weights, &ranges).unwrap();
        let mut workspace = frozen.workspace();
        let mut expected = Expected::default();
        for input in &inputs {
            let logits = frozen.predict(&mut workspace, &[input]).unwrap().to_vec();
            expected.logits.extend(&logits);
            expected.probabilities.extend(probabilities(logits, temperature));
        }
        let differ =
            expected.logits.chunks(CLASSES).filter(|row| **row != expected.logits[..CLASSES]).count();
        assert!(differ > 100, "{name}: samples hardly differ");
        let blueprint = Blueprint::new(&graph, &weights, &ranges).unwrap();
        Case { blueprint, samples, scaling, temperature, expected }
    }

    fn export(&self, name: &str, folder: &Path) {
        let library = Library {
            classes: vec!["soft".into(), "\"hard\"?".into(), "größer".into()],
            temperature: self.temperature,
            ..Library::new(
                name,
                &self.blueprint,
                &self.scaling,
                SAMPLE,
                self.samples.clone(),
                self.expected.clone(),
            )
        };
        let files = library.files().unwrap();
        assert!(files == library.files().unwrap(), "{name}: equal libraries give equal files");
        write_folder(folder, &files).unwrap();
        println!("{name}: {:?}", library.size().unwrap());
    }
}

fn probabilities(mut row: Vec<f32>, temperature: Option<f64>) -> Vec<f32> {
    exponential::softmax(&mut row);
    if let Some(temperature) = temperature {
        let inverse = (1.0 / temperature) as f32;
        let highest = exponential::ln(row.iter().copied().fold(f32::MIN_POSITIVE, f32::max));
        let warm = |p: &mut f32| {
            *p = exponential::exp((exponential::ln(p.max(f32::MIN_POSITIVE)) - highest) * inverse)
        };
        row.iter_mut().for_each(warm);
        exponential::shares(&mut row);
    }
    row
}

fn z_score() -> Scaling {
    Scaling::ZScore { mean: vec![511.3, 480.0, 1.1, 0.31, 40.5], sd: vec![211.7, 190.2, 2.3, 0.21, 0.3] }
}

/// Compiles and runs the test of a folder; says what went wrong.
fn check(compiler: &str, flags: &[&str], folder: &Path) -> Result<(), String> {
    let program = folder.join("check");
    let mut command = Command::new(compiler);
    command.args(WARNINGS).args(flags).arg(folder.join("test/check.c")).arg("-o").arg(&program);
    let compiled = command.output().map_err(|error| format!("{compiler}: {error}"))?;
    if !compiled.status.success() {
        return Err(format!("{flags:?}: {}", String::from_utf8_lossy(&compiled.stderr)));
    }
    let ran = Command::new(&program).output().map_err(|error| error.to_string())?;
    std::fs::remove_file(&program).unwrap();
    let said = String::from_utf8_lossy(&ran.stdout).into_owned();
    println!("{flags:?}: {said}");
    if ran.status.success() { Ok(()) } else { Err(format!("{flags:?}: {said}")) }
}

fn same_bits(compiler: &str, cases: &[(&str, Scaling, Option<f64>)], flags: &[&[&str]]) {
    for (name, scaling, temperature) in cases {
        let home = tempfile::tempdir().unwrap();
        let folder = std::env::var("TAXEL_FIRMWARE")
            .map_or(home.path().join("firmware"), |kept| Path::new(&kept).join(name));
        Case::new(name, scaling.clone(), *temperature).export(name, &folder);
        for flags in flags {
            check(compiler, flags, &folder).unwrap_or_else(|reason| panic!("{name} {scaling:?}: {reason}"));
        }
    }
}

const C99: [&[&str]; 5] = [
    &["-std=c99", "-Os"],
    &["-std=c99", "-O2"],
    // Compilers fuse products and sums in this mode, where the processor can.
    &["-std=gnu99", "-O3", "-march=native"],
    &["-std=c99", "-O2", "-ffast-math"],
    // As processors without floats in hardware compute, for every sum.
    &["-std=c99", "-O2", "-DWHOLE_ENDINGS=1", "-DCHECK_ALL_SUMS"],
];

#[test]
fn small_networks_have_the_same_bits() {
    let full = Scaling::FullScale { full_scale: 1023.0 };
    same_bits(
        "cc",
        &[
            ("mlp", z_score(), None),
            ("mlp", full.clone(), Some(0.6)),
            ("resnet8-lite-1d", z_score(), Some(1.7)),
            ("resnet8-lite-1d", Scaling::Raw, None),
            ("ds-cnn-1d", full, None),
        ],
        &C99,
    );
}

#[test]
fn wide_networks_have_the_same_bits() {
    same_bits(
        "cc",
        &[
            ("vgg6-lite-1d", z_score(), None),
            ("densenet6-lite-1d", z_score(), None),
            ("dilated-resnet-1d", z_score(), Some(2.1)),
            ("fcn-1d", z_score(), None),
        ],
        &C99,
    );
}

#[test]
#[ignore = "needs a C++ compiler"]
fn the_code_is_cpp_as_well() {
    let flags: [&[&str]; 1] = [&["-x", "c++", "-std=c++17", "-O2"]];
    same_bits(
        "c++",
        &[("resnet8-lite-1d", z_score(), Some(1.7)), ("densenet6-lite-1d", z_score(), None)],
        &flags,
    );
}

#[test]
fn what_has_no_c_is_refused_with_the_layer() {
    let refused = |name: &str| {
        let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
        let blueprint = Blueprint::new(&graph, &weights(&graph), &Ranges::new()).unwrap();
        let samples = Samples::new(1, &[[0.0, 1.0]; 5], 50);
        let library = Library::new(name, &blueprint, &Scaling::Raw, SAMPLE, samples, Expected::default());
        library.files().unwrap_err().to_string()
    };
    let floats = refused("resnet8-lite-1d");
    assert!(floats.contains("`stem.bn/relu`") && floats.contains("a convolution of floats"), "{floats}");
    let image = refused("resnet8-lite-2d");
    assert!(image.contains("only networks on series"), "{image}");
}
