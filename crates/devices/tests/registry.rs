//! Checks of every registered network, on the engine and on candle: it trains, tells training from evaluation,
//! come back from a file as it was, and refuse what does not fit by name.

#![allow(clippy::unwrap_used, clippy::panic)]

use taxel_checkpoint as checkpoint;
use taxel_devices::{Device, Model};
use taxel_engine::{Engine, EngineOptions, Mode, Sgdm};
use taxel_graph::{Graph, Init, NodeId, Op, Scheme, Tensor, Weights};
use taxel_zoo::{Entry, Settings, built_in};

/// Batch norm over two samples would give ±1, and gradients of zero.
const BATCH: usize = 3;
const STEP: Sgdm = Sgdm { lr: 0.01, momentum: 0.0, weight_decay: 0.0 };

/// The engine takes the published inputs, but where those only take time: images of the three slowest networks, of
/// which 96 rows leave three, and the frames of the longest squeeze. Two wide fully connected layers are narrower:
/// nothing else depends on their width.
fn published(name: &str) -> Settings {
    settings(match name {
        "alexnet" => "hidden=64",
        "vgg16" => "hidden=64 height=96 width=96",
        "resnet50" | "densenet201" => "height=96 width=96",
        "tactnet3d-51" => "frames=23",
        _ => "",
    })
}

fn settings(text: &str) -> Settings {
    let pairs = text.split_whitespace().map(|pair| pair.split_once('=').unwrap());
    pairs.map(|(key, value)| (key.to_string(), value.parse::<u64>().unwrap().into())).collect()
}

/// Numbers in -1..1.
fn random(count: usize, salt: usize) -> impl Iterator<Item = f32> {
    let number = |i: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32 / (1 << 23) as f32 - 1.0;
    (salt as u64 + 1..).take(count).map(number)
}

/// A network with fresh weights and one batch.
struct Case {
    name: String,
    graph: Graph,
    weights: Weights,
    inputs: Vec<Vec<f32>>,
    labels: Vec<u32>,
}

impl Case {
    fn new(entry: &Entry, settings: &Settings) -> Case {
        let graph = entry.graph(settings).unwrap();
        let mut weights = Weights::init(&graph, Scheme::Pytorch, 7, "registry");
        // All channels alike and shifts of zero would leave gradients of zero: a scale before ReLU and the next
        // batch norm has none.
        for (salt, param) in graph.params().enumerate() {
            if let (Init::Constant(value), Some(tensor)) = (param.init, weights.get(&param.name)) {
                let data = random(param.len(), salt).map(|v| value + 0.2 * v).collect();
                weights.insert(&param.name, Tensor { data, ..tensor.clone() });
            }
        }
        let lens = graph.inputs().map(|node| node.shape.iter().product::<usize>());
        let inputs = lens.enumerate().map(|(salt, len)| random(BATCH * len, salt).collect()).collect();
        Case { name: entry.name.clone(), graph, weights, inputs, labels: vec![0, 1, 0] }
    }

    fn xs(&self) -> Vec<&[f32]> {
        self.inputs.iter().map(Vec::as_slice).collect()
    }

    /// Whether evaluation leaves something out that training does.
    fn has_modes(&self) -> bool {
        self.graph.nodes().iter().any(|n| matches!(n.op, Op::BatchNorm { .. } | Op::Dropout { .. }))
    }

    /// Biases that a later batch norm takes away again: no gradient but for rounding. So it is before a batch
    /// norm, and in linear bottlenecks, whose shift passes a 1×1 convolution before it meets the next.
    fn idle(&self, param: &str) -> bool {
        let nodes = self.graph.nodes();
        let node = nodes.iter().position(|n| n.params.get(1).is_some_and(|p| p.name == param));
        node.is_some_and(|id| self.normalised(id))
    }

    /// Whether a shift of a node's channels only ever meets batch norms.
    fn normalised(&self, id: NodeId) -> bool {
        let nodes = self.graph.nodes();
        let mut readers = (0..nodes.len()).filter(|&reader| nodes[reader].inputs.contains(&id)).peekable();
        readers.peek().is_some()
            && readers.all(|reader| match &nodes[reader].op {
                Op::BatchNorm { .. } => true,
                Op::Conv { window, .. } if window.padding.iter().any(|&pad| pad != (0, 0)) => false,
                Op::Conv { .. } | Op::Concat | Op::Add | Op::SwitchScale => self.normalised(reader),
                Op::AveragePool { .. } | Op::MaxPool(_) | Op::ChannelShuffle { .. } | Op::Slice { .. } => {
                    self.normalised(reader)
                }
                _ => false,
            })
    }

    fn check_gradients(&self, loss: f32, gradients: &Weights) {
        assert!(loss.is_finite() && loss > 0.0, "{}: loss {loss}", self.name);
        assert_eq!(
            gradients.iter().map(|(_, t)| t.data.len()).sum::<usize>(),
            self.graph.parameter_count(),
            "{}: gradients",
            self.name
        );
        let norm = |t: &Tensor| t.data.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt();
        let largest = gradients.iter().map(|(_, t)| norm(t)).fold(0.0, f64::max);
        for (param, gradient) in gradients.iter() {
            let norm = norm(gradient);
            assert!(norm.is_finite(), "{}: gradient of {param}: {norm}", self.name);
            if self.idle(param) {
                assert!(norm < 1e-4 * largest, "{}: {param} should be idle: {norm}", self.name);
            } else {
                assert!(norm > 1e-6 * largest, "{}: no gradient for {param}: {norm}", self.name);
            }
        }
    }

    /// Whatever learns has moved, and running statistics too.
    fn check_moved(&self, after: &Weights) {
        for (name, before) in self.weights.iter() {
            let fixed = self.idle(name) || ["mean", "std"].contains(&name);
            assert!(fixed || after.get(name) != Some(before), "{}: {name} has not moved", self.name);
        }
    }

    /// Tensors that are missing, extra or misshaped, and the words that name them.
    fn broken(&self) -> [(Weights, String); 3] {
        let named: Vec<String> = self.weights.iter().map(|(name, _)| name.to_string()).collect();
        let last = named.last().unwrap();
        let mut missing = Weights::new();
        self.weights.iter().filter(|(name, _)| name != last).for_each(|(n, t)| missing.insert(n, t.clone()));
        let mut extra = self.weights.clone();
        extra.insert("head.extra", Tensor { shape: vec![1], data: vec![0.0] });
        let mut misshaped = self.weights.clone();
        let tensor = misshaped.get(&named[0]).unwrap();
        let shape = [&tensor.shape[..], &[1]].concat();
        misshaped.insert(&named[0], Tensor { shape, data: tensor.data.clone() });
        [
            (missing, format!("{}: tensor `{last}` is missing", self.name)),
            (extra, format!("{}: tensor `head.extra` is not part of this network", self.name)),
            (misshaped, format!("{}: tensor `{}` has shape", self.name, named[0])),
        ]
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn engine(case: &Case, weights: &Weights) -> Result<Engine, taxel_engine::Error> {
    Engine::new(&case.graph, weights, EngineOptions { batch: BATCH, threads: 2, ..EngineOptions::default() })
}

#[test]
fn on_the_engine_at_the_published_input() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("w.safetensors");
    for entry in built_in().entries() {
        let case = Case::new(entry, &published(&entry.name));
        let name = &entry.name;
        let mut engine = engine(&case, &case.weights).unwrap();
        let eval = engine.forward(&case.xs(), BATCH, Mode::Eval).unwrap().to_vec();
        assert!(eval.iter().all(|v| v.is_finite()), "{name}");
        assert_eq!(engine.weights(), case.weights, "{name}: evaluation moves nothing");
        let train = engine.forward(&case.xs(), BATCH, Mode::Train).unwrap().to_vec();
        assert_eq!(eval != train, case.has_modes(), "{name}: training and evaluation");
        let loss = engine.backward(&case.labels).unwrap();
        case.check_gradients(loss, &engine.gradients());
        engine.sgdm(&STEP);
        let after = engine.weights();
        case.check_moved(&after);
        // The saved network predicts as the trained one.
        checkpoint::write(&file, &after, "").unwrap();
        let (read, _) = checkpoint::read(&file).unwrap();
        assert!(
            after.iter().all(|(n, t)| read.get(n).is_some_and(|r| bits(&r.data) == bits(&t.data))),
            "{name}"
        );
        let trained = bits(engine.forward(&case.xs(), BATCH, Mode::Eval).unwrap());
        let mut engine = self::engine(&case, &read).unwrap();
        assert_eq!(trained, bits(engine.forward(&case.xs(), BATCH, Mode::Eval).unwrap()), "{name}");
        assert_ne!(trained, bits(&eval), "{name}");
    }
}

#[test]
fn on_candle() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("w.safetensors");
    for entry in built_in().entries() {
        let case = Case::new(entry, &entry.quick);
        let name = &entry.name;
        let model = |weights: &Weights| Model::new(&case.graph, weights, &Device::Cpu).unwrap();
        let net = model(&case.weights);
        let predict = |model: &Model, train| {
            let outputs = model.forward(&case.xs(), BATCH, train).unwrap();
            outputs.into_iter().flat_map(|(_, values)| values).collect::<Vec<f32>>()
        };
        let eval = predict(&net, false);
        assert_eq!(net.weights().unwrap(), case.weights, "{name}: evaluation moves nothing");
        assert_eq!(eval != predict(&net, true), case.has_modes(), "{name}: training and evaluation");
        let (loss, gradients) = net.loss_and_gradients(&case.xs(), &case.labels).unwrap();
        case.check_gradients(loss, &gradients);
        let mut after = net.weights().unwrap();
        for (param, gradient) in gradients.iter() {
            let mut tensor = after.get(param).unwrap().clone();
            tensor.data.iter_mut().zip(&gradient.data).for_each(|(w, g)| *w -= STEP.lr * g);
            after.insert(param, tensor);
        }
        case.check_moved(&after);
        checkpoint::write(&file, &after, "").unwrap();
        let (read, _) = checkpoint::read(&file).unwrap();
        let trained = bits(&predict(&model(&after), false));
        assert_eq!(trained, bits(&predict(&model(&read), false)), "{name}");
        assert_ne!(trained, bits(&eval), "{name}");
        // Both executions of one description.
        let mut engine = engine(&case, &after).unwrap();
        engine.forward(&case.xs(), BATCH, Mode::Eval).unwrap();
        let ours: Vec<f32> = engine.outputs().flat_map(|(_, values)| values.to_vec()).collect();
        let theirs = predict(&model(&after), false);
        let scale = theirs.iter().fold(0.0f32, |a, v| a.max(v.abs()));
        for (a, b) in ours.iter().zip(&theirs) {
            assert!((a - b).abs() <= 1e-4 * scale, "{name}: engine {a}, candle {b}");
        }
        assert_eq!(ours.len(), theirs.len());
    }
}

#[test]
fn tensors_and_batches_that_do_not_fit_are_refused_by_name() {
    for entry in built_in().entries() {
        let case = Case::new(entry, &entry.quick);
        for (weights, words) in case.broken() {
            let refusal = engine(&case, &weights).err().unwrap().to_string();
            assert!(refusal.starts_with(&words), "engine: {refusal}");
            let refusal = Model::new(&case.graph, &weights, &Device::Cpu).err().unwrap().to_string();
            assert!(refusal.starts_with(&words), "candle: {refusal}");
        }
        let mut engine = engine(&case, &case.weights).unwrap();
        let model = Model::new(&case.graph, &case.weights, &Device::Cpu).unwrap();
        for (which, node) in case.graph.inputs().enumerate() {
            // One channel more, and one value less.
            let len: usize = node.shape.iter().product();
            for wrong in [BATCH * (len + node.shape[1..].iter().product::<usize>()), BATCH * len - 1] {
                let x = vec![0.5; wrong];
                let mut xs = case.xs();
                xs[which] = &x;
                let words = format!("{}: input `{}` holds {wrong} values", entry.name, node.name);
                let refusals = [
                    engine.forward(&xs, BATCH, Mode::Train).unwrap_err().to_string(),
                    model.forward(&xs, BATCH, true).unwrap_err().to_string(),
                ];
                assert!(refusals.iter().all(|refusal| refusal.starts_with(&words)), "{refusals:?}");
            }
        }
        assert_eq!(engine.weights(), case.weights, "{}: refusals move nothing", entry.name);
    }
}

/// Other channels make another network, whose first tensor does not fit; no input has a size of zero, and
/// one that the network cannot reduce is refused by the name of its key or node.
#[test]
fn channels_and_sizes_that_do_not_fit_are_refused_by_name() {
    for entry in built_in().entries() {
        let case = Case::new(entry, &entry.quick);
        for input in &entry.inputs {
            let shape = &case.graph.inputs().find(|node| node.name == input.name).unwrap().shape;
            let (key, sizes) = match &input.keys[..] {
                [flat] => (flat, &input.keys[..]),
                keys => (&keys[0], &keys[1..]),
            };
            let mut wider = entry.quick.clone();
            // Two streams share the channels.
            let more = if entry.name == "mobilenet-v2-split" { 2 } else { 1 };
            let channels = if input.keys.len() == 1 { shape.iter().product() } else { shape[0] };
            wider.insert(key.clone(), (channels + more).into());
            let refusal = case.weights.check(&entry.graph(&wider).unwrap()).unwrap_err().to_string();
            assert!(refusal.contains("has shape") && refusal.contains("expected"), "{refusal}");
            for size in sizes {
                for value in [0, 1] {
                    let mut small = entry.quick.clone();
                    small.insert(size.clone(), value.into());
                    let refusal = match entry.graph(&small) {
                        Err(error) => error.to_string(),
                        Ok(_) if value == 1 => continue,
                        Ok(_) => panic!("{}: {size} = 0 was taken", entry.name),
                    };
                    assert!(refusal.starts_with(&format!("{}: ", entry.name)), "{refusal}");
                    let along = ["length", "rows", "columns", "frames"].iter().any(|a| refusal.contains(a));
                    assert!(refusal.contains(&format!("{size} = {value}: must be")) || along, "{refusal}");
                }
            }
        }
    }
}
