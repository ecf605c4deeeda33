//! Fixtures of the PyTorch twins, and the formula that both sides fill their tensors with.
//!
//! `scripts/fixtures/network_twins.py` and `operations.py` write the fixtures; `formula.py` beside them is
//! the other half of [`hashed`], [`tensor`] and [`digest`].

#![allow(dead_code)]

use std::path::{Path, PathBuf};

use serde_json::Value;
use taxel_graph::{Activation, Conv, Extent, Graph, Loss, Network, Pool, Tensor, Weights};

/// Numbers in [-1, 1) from integers alone.
pub fn hashed(count: usize, salt: u64) -> Vec<f64> {
    let mask = 0xFFFF_FFFFu64;
    (0..count as u64)
        .map(|i| {
            let mut h = (i.wrapping_mul(2_654_435_761) + salt * 40_503 + 12_345) & mask;
            for (shift, factor) in [(15, 2_246_822_519u64), (13, 3_266_489_917)] {
                h ^= h >> shift;
                h = h.wrapping_mul(factor) & mask;
            }
            h ^= h >> 16;
            h as f64 / 2_147_483_648.0 - 1.0
        })
        .collect()
}

fn tensor(name: &str, shape: &[usize], salt: u64) -> Tensor {
    let values = hashed(shape.iter().product(), salt);
    let fan_in: usize = shape[1..].iter().product();
    let scaled = |v: f64| {
        if name.ends_with("running_var") || name.ends_with("std") {
            1.0 + 0.4 * v
        } else if name.ends_with("running_mean") {
            0.3 * v
        } else if shape.len() > 1 {
            v * (6.0 / fan_in as f64).sqrt()
        } else if name.ends_with("weight") {
            1.0 + 0.3 * v
        } else {
            0.2 * v
        }
    };
    Tensor { shape: shape.to_vec(), data: values.into_iter().map(|v| scaled(v) as f32).collect() }
}

fn digest(values: &[f32], salt: u64) -> Vec<f64> {
    let flat: Vec<f64> = values.iter().map(|&v| f64::from(v)).collect();
    let dot = |salt| flat.iter().zip(hashed(flat.len(), salt)).map(|(a, b)| a * b).sum::<f64>();
    let norm = flat.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut digest = vec![norm, dot(1000 + salt), dot(2000 + salt)];
    digest.extend((0..6).map(|i| flat[i * flat.len() / 6]));
    digest
}

/// How far float32 may be from the fixture's float64, relative.
#[derive(Debug, Clone, Copy)]
pub struct Tolerance {
    /// Logits, loss, running statistics.
    pub values: f64,
    /// Digests of gradients.
    pub gradients: f64,
}

/// One fixture.
pub struct Twin {
    pub name: String,
    pub network: String,
    pub settings: serde_json::Map<String, Value>,
    pub batch: usize,
    json: Value,
}

impl Twin {
    /// Every network, in order of their names.
    pub fn all() -> Vec<Twin> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/networks");
        let mut paths: Vec<PathBuf> =
            std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        assert!(paths.len() >= 45, "run scripts/fixtures/network_twins.py: only {} fixtures", paths.len());
        paths.iter().map(|path| Twin::read(path)).collect()
    }

    /// Every single operation on awkward shapes and every loss, with its graph.
    pub fn operations() -> Vec<(Twin, Graph)> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/operations.json");
        let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        assert!(cases.len() >= 57, "run scripts/fixtures/operations.py: only {} cases", cases.len());
        let pair = |json: Value| {
            let graph = operation(&json["operation"]);
            (Twin::new(json["network"].as_str().unwrap().to_string(), json), graph)
        };
        cases.into_iter().map(pair).collect()
    }

    /// Networks with several outputs.
    pub fn several_outputs() -> Vec<Twin> {
        Twin::list("outputs.json")
    }

    /// MobileNetV2 with ranges of layers frozen.
    pub fn frozen() -> Vec<Twin> {
        Twin::list("frozen.json")
    }

    fn list(file: &str) -> Vec<Twin> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures").join(file);
        let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        cases.into_iter().map(|json| Twin::new(json["network"].as_str().unwrap().to_string(), json)).collect()
    }

    fn read(path: &Path) -> Twin {
        let json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        Twin::new(path.file_stem().unwrap().to_str().unwrap().into(), json)
    }

    fn new(name: String, json: Value) -> Twin {
        Twin {
            name,
            network: json["network"].as_str().unwrap().into(),
            settings: json["settings"].as_object().unwrap().clone(),
            batch: json["batch"].as_u64().unwrap() as usize,
            json,
        }
    }

    /// The formula's weights under the twin's own `state_dict` names.
    pub fn weights(&self) -> Weights {
        let mut weights = Weights::new();
        for (salt, entry) in self.json["tensors"].as_array().unwrap().iter().enumerate() {
            let name = entry[0].as_str().unwrap();
            let shape: Vec<usize> =
                entry[1].as_array().unwrap().iter().map(|s| s.as_u64().unwrap() as usize).collect();
            weights.insert(name, tensor(name, &shape, salt as u64));
        }
        weights
    }

    /// The formula's inputs for one batch; `salt` is 500 or 600.
    pub fn inputs(&self, graph: &Graph, salt: u64) -> Vec<Vec<f32>> {
        let sizes = graph.inputs().map(|node| node.shape.iter().product::<usize>());
        let values = |(i, size): (usize, usize)| hashed(self.batch * size, salt + i as u64);
        let mut inputs: Vec<Vec<f32>> =
            sizes.enumerate().map(values).map(|v| v.into_iter().map(|v| v as f32).collect()).collect();
        // Channels `start..end` of a sample of the first input may be dark.
        for part in self.json["dark"].as_array().into_iter().flatten() {
            let [sample, start, end] = [0, 1, 2].map(|i| part[i].as_u64().unwrap() as usize);
            let first = &graph.inputs().next().unwrap().shape;
            let plane: usize = first[1..].iter().product();
            let at = (sample * first[0] + start) * plane;
            inputs[0][at..at + (end - start) * plane].fill(0.0);
        }
        inputs
    }

    /// The range of layers that is frozen.
    pub fn range(&self) -> String {
        self.json["frozen"].as_str().unwrap().into()
    }

    /// Names of the outputs, where there are several.
    pub fn outputs(&self) -> Vec<String> {
        self.json["outputs"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().into()).collect()
    }

    pub fn labels(&self) -> Vec<u32> {
        let classes = self.settings.get("classes").map_or(3, |c| c.as_u64().unwrap()) as usize;
        (0..self.batch).map(|i| (i % classes) as u32).collect()
    }

    /// The loss that the fixture was computed with.
    pub fn objective(&self) -> Loss {
        match self.json["operation"].get("objective") {
            Some(loss) => serde_json::from_value(loss.clone()).unwrap(),
            None => Loss::SoftmaxCrossEntropy,
        }
    }

    /// The fixture's own for deep networks, 1e-5 and 1e-4 for all others.
    pub fn tolerance(&self) -> Tolerance {
        let number = |key: &str, default| self.json["tolerance"][key].as_f64().unwrap_or(default);
        Tolerance { values: number("values", 1e-5), gradients: number("gradients", 1e-4) }
    }

    /// Learning rate of the fixture's SGDM steps.
    pub fn rate(&self) -> f32 {
        self.json["lr"].as_f64().unwrap_or(0.01) as f32
    }

    /// Target values [batch, 3] for the losses that take them.
    pub fn target_values(&self) -> Vec<f32> {
        let one_hot = self.objective() == Loss::MultiLabelSoftMargin;
        let value = |v: f64| if one_hot { f32::from(v > 0.0) } else { v as f32 };
        hashed(self.batch * 3, 700).into_iter().map(value).collect()
    }

    /// Compares values with a list of the fixture, relative to its largest value.
    pub fn assert_values(&self, key: &str, got: &[f32], relative: f64) {
        let want: Vec<f64> = self.json[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        assert_eq!(got.len(), want.len(), "{}: {key}", self.name);
        let scale = want.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        for (i, (&got, want)) in got.iter().zip(&want).enumerate() {
            let gap = (f64::from(got) - want).abs();
            let bound = relative * scale;
            assert!(
                gap <= bound,
                "{}: {key}[{i}]: got {got}, want {want}, gap {gap:e} > {bound:e}",
                self.name
            );
        }
    }

    /// Compares the losses of SGDM steps. Rounding grows from step to step where maxima lie close:
    /// PyTorch's own float32 was 1.7e-4 from float64 at the fifth step of `tactresnet-50-28` with an average
    /// pool before the classifier, and 3e-7 at the third. Of deep networks only the first loss counts: at the second PyTorch's float32 is 2e-2 from
    /// float64 in `resnet50-64-64`, at the third 9e-2 in `mobilenet-v2-1-47-70-0.35-4`.
    pub fn assert_steps(&self, got: &[f32]) {
        let want = self.json["steps"].as_array().unwrap();
        assert_eq!(got.len(), want.len(), "{}: steps", self.name);
        let scale = want.iter().fold(0.0f64, |a, v| a.max(v.as_f64().unwrap()));
        let deep = self.json.get("tolerance").is_some();
        let count = if deep { 1 } else { got.len() };
        for (step, (&got, want)) in got.iter().zip(want).enumerate().take(count) {
            let bound = if step < 3 { 1.0 } else { 50.0 } * self.tolerance().values * scale;
            let gap = (f64::from(got) - want.as_f64().unwrap()).abs();
            assert!(
                gap <= bound,
                "{}: step {step}: got {got}, want {want}, gap {gap:e} > {bound:e}",
                self.name
            );
        }
    }

    pub fn assert_loss(&self, got: f32, relative: f64) {
        let want = self.json["loss"].as_f64().unwrap();
        let gap = (f64::from(got) - want).abs();
        assert!(gap <= relative * want.abs(), "{}: loss: got {got}, want {want}", self.name);
    }

    /// Compares every tensor of a group (`gradients`, `running`, `population`) by its digest. A tensor
    /// that is zero but for rounding is held against the group's largest.
    pub fn assert_digests(&self, key: &str, get: impl Fn(&str) -> Option<Vec<f32>>, relative: f64) {
        let group = self.json[key].as_object().unwrap();
        let numbers =
            |v: &Value| v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<f64>>();
        let largest = group.values().map(|v| numbers(v)[0]).fold(0.0f64, f64::max);
        // Salts count the tensors in the twin's order; population pairs share one.
        for (i, (name, want)) in group.iter().enumerate() {
            let salt = if key == "population" { i / 2 } else { i };
            let got = get(name).unwrap_or_else(|| panic!("{}: no {key} for {name}", self.name));
            let (got, want) = (digest(&got, salt as u64), numbers(want));
            // A bias before a batch norm has gradient zero: many terms that cancel, each rounded.
            let share = if want[0] < 1e-12 * largest { 1.0 } else { 0.01 };
            let bound = relative * (want[0] + share * largest);
            for (part, (got, want)) in got.iter().zip(&want).enumerate() {
                let gap = (got - want).abs();
                assert!(
                    gap <= bound,
                    "{}: {key} {name}, part {part}: got {got}, want {want}, gap {gap:e} > {bound:e}",
                    self.name
                );
            }
        }
    }

    /// Whether a parameter's gradient is zero but for rounding.
    pub fn is_idle(&self, name: &str) -> bool {
        let group = self.json["gradients"].as_object().unwrap();
        let norm = |v: &Value| v[0].as_f64().unwrap();
        let largest = group.values().map(norm).fold(0.0f64, f64::max);
        group.get(name).is_some_and(|v| norm(v) < 1e-12 * largest)
    }

    /// Number of entries of a group.
    pub fn count(&self, key: &str) -> usize {
        self.json[key].as_object().unwrap().len()
    }
}

/// Input → 1×1 convolution `pre` → the operation `op` → flatten → linear `head`.
fn operation(case: &Value) -> Graph {
    let number = |key: &str| case[key].as_u64().unwrap() as usize;
    let real = |key: &str| case[key].as_f64().unwrap() as f32;
    let extent = |key: &str| match &case[key] {
        Value::Array(sizes) => Extent::Each(sizes.iter().map(|s| s.as_u64().unwrap() as usize).collect()),
        size => Extent::All(size.as_u64().unwrap() as usize),
    };
    let pool = || {
        let pool = Pool::new(extent("kernel")).stride(extent("stride")).pad(extent("pad"));
        let pool = if case["ceil"] == true { pool.round_up() } else { pool };
        if case["count"] == true { pool } else { pool.ignore_padding() }
    };
    let shape: Vec<usize> =
        case["shape"].as_array().unwrap().iter().map(|s| s.as_u64().unwrap() as usize).collect();
    let net = Network::new(&case.to_string());
    let x = net.input("x", &shape).conv("pre", Conv::new(shape[0], 1));
    let y = match case["kind"].as_str().unwrap() {
        "conv" => {
            let conv = Conv::new(number("filters"), extent("kernel")).stride(extent("stride"));
            let conv = conv.pad(extent("pad")).groups(number("groups"));
            let conv = if case["dilation"].is_null() { conv } else { conv.dilation(extent("dilation")) };
            x.conv("op", if case["bias"] == true { conv } else { conv.no_bias() })
        }
        "max" => x.max_pool(pool()),
        "mean" => x.average_pool(pool()),
        "norm" => x.batch_norm("op"),
        "global" => x.global_average_pool(),
        "deviation" => x.global_standard_deviation(real("eps")),
        "relu6" => x.activation(Activation::Relu6),
        "leaky_relu" => x.activation(Activation::LeakyRelu { slope: real("slope") }),
        "sigmoid" => x.activation(Activation::Sigmoid),
        "tanh" => x.activation(Activation::Tanh),
        "hard_swish" => x.activation(Activation::HardSwish),
        "dropout" => x.dropout(real("probability")),
        "lstm" => x.lstm("op", number("hidden")),
        "gru" => x.gru("op", number("hidden")),
        "adaptive" => x.adaptive_average_pool(extent("output")),
        "scale" => x.scale("op", 1.0),
        "shuffle" => x.channel_shuffle(number("groups")),
        "slice" => x.slice(number("start"), number("len")),
        "swap" => {
            let start = number("start");
            x.slice(start, shape[0] - start).concat(&x.slice(0, start))
        }
        "norm_with" => x.batch_norm_with("op", real("eps"), real("momentum")),
        "feature_norm" => x.flatten().batch_norm("op"),
        "layer_norm" => x.flatten().layer_norm_with("op", real("eps")),
        "linear" => x.flatten().linear_no_bias("op", number("outputs")),
        "none" => x,
        other => panic!("unknown operation {other}"),
    };
    net.finish(&[("logits", y.flatten().linear("head", 3))]).unwrap()
}
