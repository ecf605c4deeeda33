//! From one network to the next: frozen layers, parts, other heads, stitching, and what training changed.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../../../tests/support/twin.rs"]
mod twin;

use taxel_devices::{Device, Model};
use taxel_engine::{Engine, EngineOptions, Mode, Sgdm};
use taxel_graph::{Graph, Scheme, Tensor, TensorKind, Weights};
use taxel_zoo::{Settings, built_in, matlab};
use twin::Twin;

fn graph(name: &str, settings: &str) -> Graph {
    let pairs = settings.split_whitespace().map(|pair| pair.split_once('=').unwrap());
    let settings: Settings = pairs.map(|(k, v)| (k.into(), serde_json::from_str(v).unwrap())).collect();
    taxel_zoo::find(name).unwrap().graph(&settings).unwrap()
}

fn fresh(graph: &Graph, seed: u64) -> Weights {
    Weights::init(graph, Scheme::Pytorch, seed, "transfer")
}

fn values(count: usize, salt: u64) -> Vec<f32> {
    twin::hashed(count, salt).into_iter().map(|v| v as f32).collect()
}

fn predict(graph: &Graph, weights: &Weights, xs: &[&[f32]], n: usize) -> Vec<(String, Vec<f32>)> {
    let mut engine =
        Engine::new(graph, weights, EngineOptions { batch: n, ..EngineOptions::default() }).unwrap();
    engine.forward(xs, n, Mode::Eval).unwrap();
    engine.outputs().map(|(name, values)| (name.into(), values.to_vec())).collect()
}

/// Rouhafzay et al. 2021, Table 6, against PyTorch; ranges cut blocks, and between a convolution and its batch norm.
#[test]
fn frozen_layers_learn_nothing_and_keep_their_statistics() {
    let twins = Twin::frozen();
    assert_eq!(twins.len(), 7, "run scripts/fixtures/frozen.py");
    for twin in twins {
        let graph = taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap();
        let before = twin.weights();
        let frozen = matlab::range(&graph, &twin.range()).unwrap();
        let options = EngineOptions { batch: twin.batch, frozen: frozen.clone(), ..EngineOptions::default() };
        let mut engine = Engine::new(&graph, &before, options).unwrap();
        let inputs = twin.inputs(&graph, 500);
        let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        engine.forward(&xs, twin.batch, Mode::Train).unwrap();
        let loss = engine.backward(&twin.labels()).unwrap();
        let tolerance = twin.tolerance();
        twin.assert_loss(loss, tolerance.values);
        let gradients = engine.gradients();
        assert_eq!(gradients.len(), twin.count("gradients"), "{}", twin.range());
        let gradient = |name: &str| gradients.get(name).map(|t| t.data.clone());
        twin.assert_digests("gradients", gradient, tolerance.gradients);
        engine.sgdm(&Sgdm { lr: 0.01, momentum: 0.9, weight_decay: 0.1 });
        let after = engine.weights();
        twin.assert_digests("running", |name| after.get(name).map(|t| t.data.clone()), tolerance.values);
        let covered = graph.covered(&frozen).unwrap();
        for (node, covered) in graph.nodes().iter().zip(covered) {
            for param in &node.params {
                let kept = before.get(&param.name) == after.get(&param.name);
                assert_eq!(kept, covered, "{}: {}", twin.range(), param.name);
            }
        }
    }
}

#[test]
fn blocks_and_ranges_name_nodes() {
    let graph = graph("mobilenet-v2", "");
    let names = |what: &[&str]| -> Vec<String> {
        let what: Vec<String> = what.iter().map(|name| name.to_string()).collect();
        let covered = graph.covered(&matlab::resolve(&graph, &what).unwrap()).unwrap();
        let nodes = graph.nodes().iter().zip(covered).filter(|(_, covered)| *covered);
        nodes.map(|(node, _)| node.name.clone()).collect()
    };
    let block = ["features.2.conv.0.0", "features.2.conv.0.1", "features.2.conv.1.0", "features.2.conv.1.1"];
    let block = [&block[..], &["features.2.conv.2", "features.2.conv.3"]].concat();
    assert_eq!(names(&["features.2"]), block);
    assert_eq!(names(&["10:17"]), block);
    assert_eq!(
        names(&["1:5", "2:2", "150:152"]),
        ["features.0.0", "features.0.1", "features.1.conv.0.0", "classifier.1"]
    );
    assert_eq!(names(&["features", "classifier"]), names(&["1:154"]));
    for (name, words) in [
        ("features.20", "no node with tensors has that name"),
        ("153:154", "no node with tensors is among them"),
        ("0:3", "expected first:last within layers 1 to 154"),
        ("9:8", "expected first:last within layers 1 to 154"),
        ("1:155", "expected first:last within layers 1 to 154"),
        ("1:x", "expected first:last within layers 1 to 154"),
    ] {
        let names = matlab::resolve(&graph, &[name.into()]);
        let refusal = names.and_then(|names| graph.covered(&names)).unwrap_err().to_string();
        assert_eq!(refusal, format!("mobilenet-v2: cannot freeze `{name}`: {words}"));
    }
}

/// VGG16_SVM and ResNet50_NN of Pastor et al. 2019 read features at a layer.
#[test]
fn a_part_computes_what_the_whole_does_there() {
    for (name, settings, node, head) in [
        ("mobilenet-v2", "height=64 width=47", "features.18.1/relu6/global_average_pool", "classifier.1"),
        ("resnet50", "height=33 width=40 classes=5", "layer4.2.bn3/add/relu/global_average_pool", "fc"),
        ("vgg16", "height=40 width=33 hidden=20", "classifier.3/relu/dropout", "classifier.6"),
        ("hybrid-resvgg", "", "fuse/relu", "fc"),
        ("googlenet", "height=40 width=33 aux=true", "inception5b/global_average_pool/dropout", "fc"),
    ] {
        let whole = graph(name, settings);
        let weights = fresh(&whole, 1);
        let part = whole.cut(node).unwrap();
        let lens: Vec<usize> = whole.inputs().map(|node| node.shape.iter().product()).collect();
        let inputs: Vec<Vec<f32>> = lens.iter().zip(1..).map(|(len, salt)| values(2 * len, salt)).collect();
        let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let kept = weights.only(&part);
        kept.check(&part).unwrap();
        let features = predict(&part, &kept, &xs, 2).remove(0);
        assert_eq!(features.0, node);
        let logits = predict(&whole, &weights, &xs, 2).remove(0).1;
        let tensor = |suffix: &str| weights.get(&format!("{head}.{suffix}")).unwrap();
        let (weight, bias) = (tensor("weight"), tensor("bias"));
        let width = weight.shape[1];
        assert_eq!(features.1.len(), 2 * width, "{name}");
        let scale = logits.iter().fold(0.0f32, |a, v| a.max(v.abs()));
        for (i, got) in logits.iter().enumerate() {
            let (sample, class) = (i / bias.data.len(), i % bias.data.len());
            let row = &weight.data[class * width..][..width];
            let x = &features.1[sample * width..][..width];
            let want = row.iter().zip(x).map(|(w, x)| w * x).sum::<f32>() + bias.data[class];
            assert!((got - want).abs() <= 1e-5 * scale, "{name}: {got} and {want}");
        }
    }
}

/// Channels first, whatever the order inside; a block's name is its last node.
#[test]
fn spatial_features_come_out_in_pytorchs_order() {
    for (name, settings, block, node, shape) in [
        ("mobilenet-v2", "height=64 width=47", "features.3", "features.3.conv.3/add", &[24, 16, 12][..]),
        ("resnet50", "height=33 width=40", "layer2", "layer2.3.bn3/add/relu", &[512, 5, 5]),
        ("resnet18", "height=40 width=33", "layer4", "layer4.1.bn2/add/relu", &[512, 2, 2]),
        ("vgg16", "height=64 width=33 hidden=20", "features", "features.28/relu/max_pool", &[512, 2, 1]),
        ("googlenet", "height=40 width=33", "inception4a", "inception4a", &[512, 2, 2]),
        ("tactnet3d", "height=12 width=11 frames=7", "bns.0", "bns.0", &[8, 8, 7, 5]),
        ("lstm", "", "signal", "signal", &[5, 50]),
    ] {
        let whole = graph(name, settings);
        let part = whole.cut(block).unwrap();
        let (out, id) = &part.outputs()[0];
        assert_eq!((out.as_str(), part.nodes()[*id].shape.as_slice()), (node, shape), "{name}");
        let weights = fresh(&whole, 1).only(&part);
        let x = values(2 * whole.inputs().next().unwrap().shape.iter().product::<usize>(), 1);
        let ours = predict(&part, &weights, &[&x], 2).remove(0).1;
        let model = Model::new(&part, &weights, &Device::Cpu).unwrap();
        let theirs = model.forward(&[&x], 2, false).unwrap().remove(0).1;
        assert_eq!(ours.len(), 2 * shape.iter().product::<usize>());
        let scale = theirs.iter().fold(0.0f32, |a, v| a.max(v.abs()));
        for (i, (a, b)) in ours.iter().zip(&theirs).enumerate() {
            assert!((a - b).abs() <= 1e-5 * scale, "{name}: value {i}: {a} and {b}");
        }
        let mut engine =
            Engine::new(&part, &weights, EngineOptions { batch: 2, ..EngineOptions::default() }).unwrap();
        engine.forward(&[&x], 2, Mode::Train).unwrap();
        let refusal = engine.backward(&[0, 0]).unwrap_err().to_string();
        assert!(refusal.contains(&format!("output `{node}` has spatial axes")), "{refusal}");
    }
    let refusal = graph("mlp", "").cut("fc9").unwrap_err().to_string();
    assert_eq!(refusal, "mlp: has no node `fc9`; did you mean `fc1` or `fc2`?");
}

#[test]
fn another_number_of_classes_replaces_the_head_alone_and_says_so() {
    for entry in built_in().entries() {
        let mut more = entry.quick.clone();
        let trained = entry.graph(&more).unwrap();
        more.insert("classes".into(), 31.into());
        let wanted = entry.graph(&more).unwrap();
        let (checkpoint, drawn) = (fresh(&trained, 1), fresh(&wanted, 2));
        let mut weights = drawn.clone();
        let replaced = weights.start_from(&wanted, &checkpoint, false).unwrap();
        assert!(!replaced.is_empty(), "{}", entry.name);
        for param in wanted.params() {
            let fresh = replaced.contains(&param.name);
            let from = if fresh { drawn.get(&param.name) } else { checkpoint.get(&param.name) };
            assert_eq!(weights.get(&param.name), from, "{}: {}", entry.name, param.name);
            let another = trained.params().find(|p| p.name == param.name).unwrap().shape != param.shape;
            // A scale or shift of the head has as many values as there are classes.
            assert_eq!(another, fresh, "{}: {}", entry.name, param.name);
        }
        let mut weights = fresh(&trained, 2);
        assert!(weights.start_from(&trained, &checkpoint, false).unwrap().is_empty());
        assert_eq!(weights, checkpoint, "{}", entry.name);
    }
    let googlenet = graph("googlenet", "aux=true classes=9");
    let mut weights = fresh(&googlenet, 2);
    let checkpoint = fresh(&graph("googlenet", "aux=true"), 1);
    let replaced = weights.start_from(&googlenet, &checkpoint, false).unwrap();
    let heads =
        ["aux1.fc2.weight", "aux1.fc2.bias", "aux2.fc2.weight", "aux2.fc2.bias", "fc.weight", "fc.bias"];
    assert_eq!(replaced, heads);
}

#[test]
fn a_new_head_is_fresh_and_all_else_must_fit() {
    let net = graph("resnet8-lite-1d", "");
    let (checkpoint, drawn) = (fresh(&net, 1), fresh(&net, 2));
    let mut weights = drawn.clone();
    assert_eq!(weights.start_from(&net, &checkpoint, true).unwrap(), ["fc.weight", "fc.bias"]);
    assert_eq!(weights.get("fc.weight"), drawn.get("fc.weight"));
    assert_eq!(weights.get("stem.conv.weight"), checkpoint.get("stem.conv.weight"));
    // A body without a head is enough for a new one.
    let mut body = Weights::new();
    checkpoint.iter().filter(|(n, _)| !n.starts_with("fc.")).for_each(|(n, t)| body.insert(n, t.clone()));
    weights = drawn.clone();
    assert_eq!(weights.start_from(&net, &body, true).unwrap().len(), 2);
    let refuse = |checkpoint: &Weights| {
        let mut weights = drawn.clone();
        let refusal = weights.start_from(&net, checkpoint, false).unwrap_err().to_string();
        assert_eq!(weights, drawn, "nothing is replaced");
        refusal
    };
    assert!(refuse(&body).contains("tensor `fc.weight` is missing"));
    let mut wrong = checkpoint.clone();
    wrong.insert("stem.conv.bias", Tensor { shape: vec![3], data: vec![0.0; 3] });
    assert!(refuse(&wrong).contains("tensor `stem.conv.bias` has shape [3], expected [16]"));
    wrong = checkpoint.clone();
    // Other features in front of the head are no other number of classes.
    wrong.insert("fc.weight", Tensor { shape: vec![3, 31], data: vec![0.0; 93] });
    assert!(refuse(&wrong).contains("tensor `fc.weight` has shape [3, 31], expected [3, 32]"));
    wrong = checkpoint.clone();
    wrong.insert("head.bias", Tensor { shape: vec![3], data: vec![0.0; 3] });
    assert!(refuse(&wrong).contains("tensor `head.bias` is not part of this network"));
}

/// Rouhafzay et al. 2021, section 7: the stitched network loses nothing against its parents.
#[test]
fn stitched_streams_answer_as_their_parents_bit_for_bit() {
    let sizes = "height=64 width=47 classes=5";
    let (parent, split) = (graph("mobilenet-v2", sizes), graph("mobilenet-v2-split", sizes));
    let trained = |seed| {
        let mut weights = fresh(&parent, seed);
        for (salt, param) in parent.params().enumerate().filter(|(_, p)| p.kind == TensorKind::Buffer) {
            let data = values(param.len(), seed + salt as u64).iter().map(|v| 1.0 + 0.3 * v).collect();
            weights.insert(&param.name, Tensor { shape: param.shape.clone(), data });
        }
        weights
    };
    let (visual, mut tactile) = (trained(1), trained(2));
    let covered = parent.covered(&matlab::range(&parent, "18:139").unwrap()).unwrap();
    for (node, _) in parent.nodes().iter().zip(covered).filter(|(_, covered)| *covered) {
        node.params.iter().for_each(|p| tactile.insert(&p.name, visual.get(&p.name).unwrap().clone()));
    }
    let mut others = Weights::new();
    others.insert("mean", Tensor { shape: vec![6], data: vec![0.1, 0.2, -0.1, 0.3, 0.0, 0.5] });
    others.insert("std", Tensor { shape: vec![6], data: vec![0.5, 2.0, 0.7, 1.1, 0.9, 0.3] });
    let parents = [("visual", &visual), ("tactile", &tactile)];
    let stitched = Weights::stitched(&split, &parents, "shared", &others).unwrap();
    let plane = 64 * 47;
    let image = values(3 * plane, 9);
    for (stream, (name, weights)) in parents.into_iter().enumerate() {
        let mut both = vec![0.0; 6 * plane];
        both[3 * stream * plane..][..3 * plane].copy_from_slice(&image);
        let outputs = predict(&split, &stitched, &[&both], 1);
        let standardised: Vec<f32> = (0..3 * plane)
            .map(|i| {
                let channel = 3 * stream + i / plane;
                (image[i] - others.get("mean").unwrap().data[channel])
                    / others.get("std").unwrap().data[channel]
            })
            .collect();
        let by_parent = predict(&parent, weights, &[&standardised], 1).remove(0).1;
        let here = &outputs.iter().find(|(output, _)| output == name).unwrap().1;
        assert_eq!(here, &by_parent, "{name}");
    }
    let other = "features.9.conv.2.weight";
    tactile.insert(other, fresh(&parent, 3).get(other).unwrap().clone());
    let parents = [("visual", &visual), ("tactile", &tactile)];
    let refusal = Weights::stitched(&split, &parents, "shared", &others).unwrap_err().to_string();
    let words = "mobilenet-v2-split: shared tensor `features.9.conv.2.weight` is another in `visual` than in `tactile`";
    assert!(refusal.starts_with(words), "{refusal}");
    let refusal = Weights::stitched(&split, &parents[..1], "shared", &others).unwrap_err().to_string();
    assert!(refusal.contains("tensor `tactile.features.0.0.weight` is missing"), "{refusal}");
}

/// By hand in `crates/graph/tests/parts.rs`.
#[test]
fn every_convolution_has_a_change() {
    let mobile = graph("mobilenet-v2", "");
    let (a, b) = (fresh(&mobile, 1), fresh(&mobile, 2));
    assert_eq!(a.changes(&b, &mobile).unwrap().len(), 52);
}
