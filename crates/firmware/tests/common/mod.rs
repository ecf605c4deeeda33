//! Networks of the zoo in eight bits, what the runtime predicts with them, and their C, compiled and run.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

pub mod attributes;
pub mod images;
pub mod linear;

use std::path::Path;
use std::process::Command;

use ndarray::Array3;
use taxel_base::exponential;
use taxel_encodings::{History, QuantileCode, Scaling};
use taxel_firmware::{
    Answers, Encoding, Expected, Gate, Library, Method, Quantity, ReadingsGate, Samples, Spread, write_folder,
};
use taxel_graph::{Graph, Scheme, Tensor, Weights};
use taxel_runtime::{Blueprint, Frozen, Observer, Ranges};

/// Channels and time steps of a sample.
pub const SAMPLE: [usize; 2] = [5, 50];
/// Classes.
pub const OUTPUTS: usize = 3;
/// Samples of a test.
const COUNT: usize = 200;

/// Warnings that a strict project turns on.
pub const WARNINGS: [&str; 8] = [
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wsign-conversion",
    "-Wshadow",
    "-Wdouble-promotion",
    "-Werror",
];

/// Ways to compile C on this computer.
pub const C99: [&[&str]; 5] = [
    &["-std=c99", "-Os"],
    &["-std=c99", "-O2"],
    // Compilers fuse products and sums in this mode, where the processor can.
    &["-std=gnu99", "-O3", "-march=native"],
    &["-std=c99", "-O2", "-ffast-math"],
    // As processors without floats in hardware compute, for every sum.
    &["-std=c99", "-O2", "-DWHOLE_ENDINGS=1", "-DCHECK_ALL_SUMS"],
];

/// An encoding that owns what is fitted.
#[derive(Debug, Clone)]
pub enum Own {
    Scaled(Scaling),
    Code(QuantileCode),
    History(History, Scaling),
}

impl Own {
    pub fn lent(&self) -> Encoding<'_> {
        match self {
            Own::Scaled(scaling) => Encoding::Scaled(scaling),
            Own::Code(code) => Encoding::Code(code),
            Own::History(history, scaling) => Encoding::History { history, scaling },
        }
    }

    /// Returns the shape of what comes out of a series.
    fn shape(&self) -> Vec<usize> {
        match self {
            Own::Scaled(_) => SAMPLE.to_vec(),
            Own::Code(code) => code.shape(SAMPLE[0], SAMPLE[1]).to_vec(),
            Own::History(history, _) => history.shape(SAMPLE[0]).to_vec(),
        }
    }

    fn encode(&self, [channels, _]: [usize; 2], sample: &[f32]) -> Vec<f32> {
        if let Own::Scaled(scaling) = self {
            let mut out = vec![0.0; sample.len()];
            scaling.encode(channels, sample, &mut out).unwrap();
            return out;
        }
        let mut out = vec![0.0; self.shape().iter().product()];
        match self {
            Own::Scaled(_) => {}
            Own::Code(code) => code.plan(SAMPLE[0], SAMPLE[1]).unwrap().encode(sample, &mut out).unwrap(),
            Own::History(history, scaling) => {
                let mut rows = out.clone();
                history.encode(SAMPLE, sample, &mut rows).unwrap();
                scaling.encode(rows.len(), &rows, &mut out).unwrap();
            }
        }
        out
    }
}

/// A quantile code that is fitted to the first samples of the test.
pub fn code(ramps: usize, steps: usize) -> Own {
    let [channels, length] = SAMPLE;
    let seen: Vec<f32> = samples().values()[..60 * channels * length].to_vec();
    let seen = Array3::from_shape_vec((60, channels, length), seen).unwrap();
    Own::Code(QuantileCode::new(ramps, steps).fit(seen.view()).unwrap())
}

/// Returns the samples of a test.
pub fn samples() -> Samples {
    Samples::new(COUNT, &[[0.0, 1023.0], [100.0, 900.0], [-3.0, 5.0], [0.0, 0.7], [40.0, 41.0]], SAMPLE[1])
}

/// A network of the zoo for an input of this shape.
pub fn graph(name: &str, shape: &[usize], outputs: usize) -> Graph {
    let entry = taxel_zoo::find(name).unwrap();
    let settings = entry.fit(outputs, |input| match input {
        "signal" => Some(shape.to_vec()),
        _ => None,
    });
    entry.graph(&settings.unwrap()).unwrap()
}

/// Fresh weights, with batch norms and biases that have seen something.
pub fn weights(graph: &Graph) -> Weights {
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

/// A network with samples and what the runtime predicts for them.
pub struct Case {
    pub name: String,
    pub blueprint: Blueprint,
    /// Channels, and time steps or pixels; rows and columns of an image.
    pub sample: [usize; 2],
    pub image: Option<[usize; 2]>,
    pub samples: Samples,
    pub encoding: Own,
    pub answers: Answers,
    pub expected: Expected,
}

impl Case {
    /// Makes a network in 32-bit floats, whose name ends with `-f32`.
    pub fn floats(name: &str, encoding: Own, answers: Answers) -> Self {
        let graph = graph(name, &encoding.shape(), answers.outputs());
        let (weights, samples) = (weights(&graph), samples());
        let frozen = Frozen::new(&graph, &weights).unwrap();
        let expected = predicted(name, &frozen, (&samples, SAMPLE), (&encoding, &answers));
        let blueprint = Blueprint::floats(&graph, &weights).unwrap();
        let name = format!("{name}-f32");
        Case { name, blueprint, sample: SAMPLE, image: None, samples, encoding, answers, expected }
    }

    pub fn new(name: &str, encoding: Own, answers: Answers) -> Self {
        let graph = graph(name, &encoding.shape(), answers.outputs());
        Case::of(&graph, (samples(), SAMPLE), encoding, answers)
    }

    /// Makes the case of a network in eight bits on these samples, of channels × steps.
    pub fn of(
        graph: &Graph,
        (samples, sample): (Samples, [usize; 2]),
        encoding: Own,
        answers: Answers,
    ) -> Self {
        let (name, weights) = (graph.name(), weights(graph));
        let values = samples.values();
        let encoded = values.chunks(sample[0] * sample[1]).map(|one| encoding.encode(sample, one));
        let inputs: Vec<Vec<f32>> = encoded.collect();
        let mut observer = Observer::new(graph, &weights).unwrap();
        inputs[..50].iter().for_each(|input| observer.see(&[input]).unwrap());
        let ranges: Ranges = observer.ranges();
        let frozen = Frozen::quantized(graph, &weights, &ranges).unwrap();
        let expected = predicted(name, &frozen, (&samples, sample), (&encoding, &answers));
        let blueprint = Blueprint::new(graph, &weights, &ranges).unwrap();
        Case { name: name.into(), blueprint, sample, image: None, samples, encoding, answers, expected }
    }

    pub fn library(&self) -> Library<'_> {
        let (encoding, samples, expected) =
            (self.encoding.lent(), self.samples.clone(), self.expected.clone());
        let library = Library::new(
            &self.name,
            Method::Network(&self.blueprint),
            (encoding, self.sample),
            self.answers.clone(),
            samples,
            expected,
        );
        Library { image: self.image, ..library }
    }

    /// Writes the folder, compiles it in each of these ways and runs its test.
    pub fn has_the_same_bits(&self, compiler: &str, flags: &[&[&str]]) {
        let home = tempfile::tempdir().unwrap();
        let folder = std::env::var("TAXEL_FIRMWARE")
            .map_or(home.path().join("firmware"), |kept| Path::new(&kept).join(&self.name));
        println!("{} {:?}", self.name, self.encoding);
        has_the_same_bits(&self.library(), &folder, compiler, flags);
    }
}

/// Writes a folder, compiles it in each of these ways and runs its test.
pub fn has_the_same_bits(library: &Library, folder: &Path, compiler: &str, flags: &[&[&str]]) {
    let files = library.files().unwrap();
    assert!(files == library.files().unwrap(), "{}: equal libraries give equal files", library.name);
    write_folder(folder, &files).unwrap();
    println!("{}: {:?}", library.name, library.size().unwrap());
    for flags in flags {
        check(compiler, flags, folder).unwrap_or_else(|reason| panic!("{}: {reason}", library.name));
    }
}

/// Returns what the runtime predicts for samples.
fn predicted(
    name: &str,
    frozen: &Frozen,
    (samples, sample): (&Samples, [usize; 2]),
    (encoding, answers): (&Own, &Answers),
) -> Expected {
    let (mut workspace, mut expected) = (frozen.workspace(), Expected::default());
    for one in samples.values().chunks(sample[0] * sample[1]) {
        let row = frozen.predict(&mut workspace, &[&encoding.encode(sample, one)]).unwrap().to_vec();
        answered(&row, answers, &mut expected);
    }
    let rows = expected.outputs.chunks(answers.outputs());
    let differ = rows.filter(|row| **row != expected.outputs[..answers.outputs()]).count();
    assert!(differ > 100, "{name}: samples hardly differ");
    expected
}

/// Adds what has to come of a row of outputs.
pub fn answered(row: &[f32], answers: &Answers, expected: &mut Expected) {
    expected.outputs.extend(row);
    match answers {
        Answers::Classes { temperature, gate, .. } => {
            expected.gate.extend(gate.as_ref().map(|gate| distance(gate, row)));
            expected.answers.extend(probabilities(row.to_vec(), *temperature));
        }
        Answers::Attributes { attributes, shares, temperature } => {
            let mut rest = row;
            for attribute in attributes {
                let (of_attribute, others) = rest.split_at(attribute.classes.len());
                let mut row = of_attribute.to_vec();
                attributes::of_shares(&mut row, *shares);
                temperature.iter().for_each(|temperature| warm(&mut row, *temperature));
                expected.answers.extend(row);
                rest = others;
            }
        }
        Answers::Values { quantities, spread, half } => {
            let count = quantities.len();
            expected.answers.extend(&row[..count]);
            let around = |i: usize| -> [f32; 2] {
                match spread {
                    Spread::Alike => [1.0; 2],
                    Spread::LogVariance => [exponential::exp(0.5 * row[count + i]).max(1e-12); 2],
                    Spread::Quantiles => {
                        let (low, high) = (row[count + i], row[2 * count + i]);
                        [(row[i] - low).max(1e-12), (high - row[i]).max(1e-12)]
                    }
                }
            };
            for (i, half) in half.iter().flatten().enumerate() {
                let [below, above] = around(i).map(|distance| half * f64::from(distance));
                expected.ends[0].push((f64::from(row[i]) - below) as f32);
                expected.ends[1].push((f64::from(row[i]) + above) as f32);
            }
        }
    }
}

fn probabilities(mut row: Vec<f32>, temperature: Option<f64>) -> Vec<f32> {
    exponential::softmax(&mut row);
    temperature.iter().for_each(|temperature| warm(&mut row, *temperature));
    row
}

/// Divides the logits of probabilities by a temperature.
fn warm(row: &mut [f32], temperature: f64) {
    let inverse = (1.0 / temperature) as f32;
    let highest = exponential::ln(row.iter().copied().fold(f32::MIN_POSITIVE, f32::max));
    let warm =
        |p: &mut f32| *p = exponential::exp((exponential::ln(p.max(f32::MIN_POSITIVE)) - highest) * inverse);
    row.iter_mut().for_each(warm);
    exponential::shares(row);
}

/// Three classes with awkward names.
pub fn classes(temperature: Option<f64>) -> Answers {
    let names = ["soft", "\"hard\"?", "größer"].map(String::from).to_vec();
    Answers::Classes { names, temperature, gate: None }
}

/// Beyond this about half of the samples of `resnet8-lite-1d` are unknown.
const LIMIT: f32 = 4.2;

/// The same with a gate.
pub fn gated() -> Answers {
    let Answers::Classes { names, temperature, .. } = classes(Some(1.2)) else { panic!("classes") };
    let gate = Gate {
        center: vec![0.11, -0.37, 0.2],
        within: vec![7.3, -1.9, 5.1, 0.77, -2.3, 6.7],
        around: vec![4.9, 0.31, 3.7, -0.83, 1.1, 4.1],
        means: vec![0.7, -0.9, 0.13, -1.7, 0.51, 0.9],
        limit: LIMIT,
    };
    Answers::Classes { names, temperature, gate: Some(gate) }
}

/// A gate of readings of samples with so many channels and steps, of awkward numbers.
pub fn readings_gate([channels, steps]: [usize; 2], has_time: bool) -> ReadingsGate {
    let size = if has_time { 12 + channels } else { 8 };
    let center = (0..size).map(|k| 0.37 * k as f32 - 1.9).collect();
    let around = (0..size * (size + 1) / 2).map(|k| 0.61 + (k * 7 % 11) as f32 / 9.0).collect();
    ReadingsGate { channels, steps, by_step: 1, has_time, floor: 0.017, center, around, limit: 2.3 }
}

/// Computes a distance as `taxel_learn` does, and whether it is too far.
fn distance(gate: &Gate, logits: &[f32]) -> (f32, bool) {
    let off: Vec<f64> = logits.iter().zip(&gate.center).map(|(v, center)| f64::from(v - center)).collect();
    let product = |triangle: &[f32], i: usize| -> f64 {
        triangle[i * (i + 1) / 2..][..=i].iter().zip(&off).map(|(w, v)| f64::from(*w) * v).sum()
    };
    let own: Vec<f64> = (0..off.len()).map(|i| product(&gate.within, i)).collect();
    let to_all: f64 = (0..off.len()).map(|i| product(&gate.around, i)).map(|v| v * v).sum();
    let to_mean = |mean: &[f32]| -> f64 {
        mean.iter().zip(&own).map(|(mean, own)| (own - f64::from(*mean)).powi(2)).sum()
    };
    let nearest = gate.means.chunks_exact(off.len()).map(to_mean).fold(f64::INFINITY, f64::min);
    let distance = nearest - to_all;
    (distance as f32, distance > f64::from(gate.limit))
}

/// Three values, or one with what is said of its error.
pub fn values(spread: Spread, half: Option<f64>) -> Answers {
    let count = match spread {
        Spread::Alike => 3,
        Spread::LogVariance | Spread::Quantiles => 1,
    };
    let named = |i: usize| Quantity { name: format!("\"force\" {i}"), unit: (i != 1).then(|| "µN".into()) };
    let half = half.map(|half| (0..count).map(|i| half / (1.0 + i as f64)).collect());
    Answers::Values { quantities: (0..count).map(named).collect(), spread, half }
}

pub fn z_score() -> Own {
    Own::Scaled(Scaling::ZScore {
        mean: vec![511.3, 480.0, 1.1, 0.31, 40.5],
        sd: vec![211.7, 190.2, 2.3, 0.21, 0.3],
    })
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
