//! Networks in eight bits predict nearly as those in floats, and the same in batches of any size.
#![allow(clippy::unwrap_used)]

mod common;

use common::weights;
use taxel_graph::{Conv, Flow, Graph, Network, Pool};
use taxel_runtime::{Frozen, Observer, Ranges};

/// Samples of a network's inputs, one after the other.
fn samples(graph: &Graph, n: usize) -> Vec<Vec<f32>> {
    let value = |i: usize| ((i * 37 % 101) as f32 - 50.0) / 50.0;
    graph.inputs().map(|node| (0..n * node.shape.iter().product::<usize>()).map(value).collect()).collect()
}

fn one(graph: &Graph, all: &[Vec<f32>], sample: usize) -> Vec<Vec<f32>> {
    let lens = graph.inputs().map(|node| node.shape.iter().product::<usize>());
    all.iter().zip(lens).map(|(x, len)| x[sample * len..(sample + 1) * len].to_vec()).collect()
}

fn slices(inputs: &[Vec<f32>]) -> Vec<&[f32]> {
    inputs.iter().map(Vec::as_slice).collect()
}

fn ranges(graph: &Graph, n: usize) -> Ranges {
    let mut observer = Observer::new(graph, &weights(graph)).unwrap();
    let all = samples(graph, n);
    (0..n).for_each(|i| observer.see(&slices(&one(graph, &all, i))).unwrap());
    observer.ranges()
}

/// How far the first output is off, as a share of its largest value; in bytes, and in floats without a range.
fn off(graph: &Graph) -> [f32; 2] {
    let weights = weights(graph);
    let inputs = samples(graph, 1);
    let ranges = ranges(graph, 1);
    let predict =
        |frozen: Frozen| frozen.predict(&mut frozen.workspace(), &slices(&inputs)).unwrap().to_vec();
    let want = predict(Frozen::new(graph, &weights).unwrap());
    let largest = want.iter().fold(1e-3f32, |most, v| most.max(v.abs()));
    [ranges, Ranges::new()].map(|ranges| {
        let got = predict(Frozen::quantized(graph, &weights, &ranges).unwrap());
        want.iter().zip(&got).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f32::max)
    })
}

#[test]
fn every_network_answers_nearly_as_in_floats() {
    let only = std::env::var("TAXEL_NETWORK").ok();
    let mut wrong = vec![];
    for entry in taxel_zoo::Registry::built_in().entries() {
        let name = entry.name.as_str();
        // The largest are left out of a test in debug mode: they hold nothing that others do not.
        if only.as_deref().is_some_and(|only| only != name) || name.starts_with("vgg1") {
            continue;
        }
        let [bytes, floats] = off(&entry.graph(&taxel_zoo::Settings::new()).unwrap());
        println!("{name}: {bytes:.4} in bytes, {floats:e} without ranges");
        // Fresh weights of multiscale-cnn drive its sigmoids to their ends, where one step decides.
        let most = if name == "multiscale-cnn" { 0.4 } else { 0.05 };
        if bytes > most || floats > 1e-4 || bytes == 0.0 {
            wrong.push(format!("{name}: {bytes} and {floats}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Graphs of which no network of the zoo has the like.
fn near(what: &str, build: impl FnOnce(&Network, Flow) -> Flow) {
    let net = Network::new("odd");
    let x = net.input("x", &[3, 8, 9]);
    let logits = build(&net, x);
    let graph: Graph = net.finish(&[("logits", logits)]).unwrap();
    let [bytes, floats] = off(&graph);
    assert!(bytes > 0.0 && bytes < 0.05 && floats < 1e-5, "{what}: {bytes} and {floats}");
}

#[test]
fn values_meet_in_both_forms() {
    near("a sum of a convolution and its input", |_, x| {
        let a = x.conv("a", Conv::new(6, 3).pad(1)).relu();
        a.conv("b", Conv::new(6, 3).pad(1)).add(&a).relu().flatten().linear("fc", 4)
    });
    near("parts of another scale side by side", |net, x| {
        let a = x.conv("a", Conv::new(4, 3).pad(1));
        let b = a.conv("b", Conv::new(5, 3).pad(1)).relu();
        let both = net.concat("both", &[&a, &b]);
        let c = both.conv("c", Conv::new(6, 3).pad(1));
        net.concat("all", &[&both, &c, &a]).flatten().linear("fc", 3)
    });
    near("a norm before its convolution", |_, x| {
        let a = x.conv("a", Conv::new(6, 3).pad(1));
        a.batch_norm("bn").relu().conv("b", Conv::new(5, 3).pad(1)).flatten().linear("fc", 4)
    });
    near("pools and a slice", |_, x| {
        let a = x.conv("a", Conv::new(8, 3).pad(1)).max_pool(Pool::new(2).stride(2));
        let b = a.slice(0, 4).conv("b", Conv::new(4, 3).pad(1));
        b.add(&a.slice(4, 4)).average_pool(Pool::new(2).stride(2).pad(1)).flatten().linear("fc", 3)
    });
    near("a value that is rectified for one reader only", |_, x| {
        let a = x.conv("a", Conv::new(6, 3).pad(1));
        a.relu().add(&a).conv("b", Conv::new(4, 1)).global_average_pool().linear("fc", 3)
    });
}

#[test]
fn an_answer_does_not_depend_on_its_neighbours() {
    for name in ["mlp", "hybrid-resvgg", "multiscale-cnn", "shufflenet-v2", "mobilenet-v2"] {
        let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
        let n = 3;
        let frozen = Frozen::quantized(&graph, &weights(&graph), &ranges(&graph, 1)).unwrap();
        let all = samples(&graph, n);
        let mut logits = vec![f32::NAN; n * frozen.logits()];
        frozen.predict_many(&mut frozen.workspace_for(64), &slices(&all), &mut logits).unwrap();
        let mut single = frozen.workspace();
        for (sample, got) in logits.chunks(frozen.logits()).enumerate() {
            let want = frozen.predict(&mut single, &slices(&one(&graph, &all, sample))).unwrap();
            let bits = |x: &[f32]| x.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(got), bits(want), "{name}, sample {sample}");
        }
    }
}
