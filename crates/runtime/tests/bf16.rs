//! Networks with products of bf16. What needs the processor's products is ignored where `scripts/check` finds none.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::weights;
use taxel_graph::{Conv, Flow, Graph, Network, Weights};
use taxel_runtime::{Error, Frozen};

/// Inputs of `n` samples with all bits of a mantissa in use, one after the other.
fn samples(graph: &Graph, n: usize) -> Vec<Vec<f32>> {
    let value = |i: usize| ((i * 37 % 101) as f32 - 50.0) / 51.3;
    graph.inputs().map(|node| (0..n * node.shape.iter().product::<usize>()).map(value).collect()).collect()
}

fn slices(inputs: &[Vec<f32>]) -> Vec<&[f32]> {
    inputs.iter().map(Vec::as_slice).collect()
}

fn predict(frozen: &Frozen, inputs: &[&[f32]]) -> Vec<f32> {
    frozen.predict(&mut frozen.workspace(), inputs).unwrap().to_vec()
}

fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn is_refused_with_the_reason_where_the_processor_lacks_it() {
    let net = Network::new("small");
    let graph = net.input("x", &[4]).linear("fc", 2);
    let graph = net.finish(&[("logits", graph)]).unwrap();
    match Frozen::half(&graph, &weights(&graph)) {
        Ok(_) => {}
        Err(error @ Error::Half { .. }) => {
            let text = error.to_string();
            assert!(
                text.starts_with("small: ") && text.contains("bf16") && text.contains("in floats"),
                "{text}"
            );
        }
        Err(error) => panic!("{error}"),
    }
}

/// Returns the nearest bf16 (even among equals) by the definition: the sum with half a unit of the last place, cut off.
fn nearest(value: f32) -> f64 {
    let unit = f32::from_bits((value.to_bits() & 0x7f80_0000).max(0x0100_0000)) / 128.0;
    (f64::from(value) / f64::from(unit)).round_ties_even() * f64::from(unit)
}

/// One layer's outputs and, of each, the sum of the sizes of its terms and their number.
type Expected = Vec<(f64, f64, usize)>;

/// Checks a network of one layer: a sum of `n` fused products is off by at most `n` roundings of what its terms add up to.
fn is_off_by_roundings_alone(
    what: &str,
    input: &[usize],
    build: impl FnOnce(&Flow) -> Flow,
    expected: impl FnOnce(&Weights, &[f32]) -> Expected,
) {
    let net = Network::new("layer");
    let x = net.input("x", input);
    let graph = net.finish(&[("logits", build(&x))]).unwrap();
    let (weights, inputs) = (weights(&graph), samples(&graph, 1));
    let got = predict(&Frozen::half(&graph, &weights).unwrap(), &slices(&inputs));
    let want = expected(&weights, &inputs[0]);
    assert_eq!(got.len(), want.len(), "{what}");
    for (i, (got, (want, terms, count))) in got.iter().zip(&want).enumerate() {
        let bound = (count + 10) as f64 * f64::from(f32::EPSILON / 2.0) * terms;
        let off = (f64::from(*got) - want).abs();
        assert!(off <= bound, "{what}[{i}]: {got} is {off} off, at most {bound}");
    }
}

/// The definition of a convolution over an image, channels first.
fn image(
    weights: &Weights,
    x: &[f32],
    [channels, rows, columns]: [usize; 3],
    [stride, pad, groups]: [usize; 3],
) -> Expected {
    let (weight, bias) = (weights.get("conv.weight").unwrap(), weights.get("conv.bias"));
    let [filters, inner, high, wide] = weight.shape[..] else { panic!("{:?}", weight.shape) };
    assert_eq!(inner * groups, channels);
    let out = |size: usize, kernel: usize| (size + 2 * pad - kernel) / stride + 1;
    let mut expected = vec![];
    for filter in 0..filters {
        for (row, column) in (0..out(rows, high)).flat_map(|r| (0..out(columns, wide)).map(move |c| (r, c))) {
            let start = f64::from(bias.map_or(0.0, |bias| bias.data[filter]));
            let (mut sum, mut terms, mut count) = (start, start.abs(), 1);
            for at in 0..inner * high * wide {
                let (channel, kr, kc) = (at / (high * wide), at / wide % high, at % wide);
                let (r, c) =
                    ((row * stride + kr).wrapping_sub(pad), (column * stride + kc).wrapping_sub(pad));
                if r >= rows || c >= columns {
                    continue;
                }
                let channel = filter / (filters / groups) * inner + channel;
                let x = x[(channel * rows + r) * columns + c];
                let product = nearest(x) * nearest(weight.data[filter * inner * high * wide + at]);
                (sum, terms, count) = (sum + product, terms + product.abs(), count + 1);
            }
            expected.push((sum, terms, count));
        }
    }
    expected
}

#[test]
#[ignore = "needs avx512_bf16"]
fn layers_are_off_by_the_rounding_of_sums_alone_needs_bf16() {
    for (what, shape, conv, sizes) in [
        ("3x3 with a stride", [5, 9, 11], Conv::new(40, 3).stride(2).pad(1), [2, 1, 1]),
        ("7x7 of three channels", [3, 30, 29], Conv::new(33, 7).stride(2).pad(3), [2, 3, 1]),
        ("1x1", [24, 6, 7], Conv::new(44, 1), [1, 0, 1]),
        ("1x1 with a stride", [8, 7, 7], Conv::new(16, 1).stride(2), [2, 0, 1]),
        ("groups", [12, 6, 5], Conv::new(10, 3).pad(1).groups(2), [1, 1, 2]),
    ] {
        is_off_by_roundings_alone(
            what,
            &shape,
            |x| x.conv("conv", conv),
            |weights, x| image(weights, x, shape, sizes),
        );
    }
    is_off_by_roundings_alone(
        "linear",
        &[301],
        |x| x.linear("fc", 45),
        |weights, x| {
            let (weight, bias) =
                (&weights.get("fc.weight").unwrap().data, &weights.get("fc.bias").unwrap().data);
            let output = |(row, bias): (&[f32], &f32)| {
                let products = || row.iter().zip(x).map(|(weight, x)| nearest(*weight) * nearest(*x));
                let bias = f64::from(*bias);
                (products().sum::<f64>() + bias, products().map(f64::abs).sum::<f64>() + bias.abs(), x.len())
            };
            weight.chunks(x.len()).zip(bias).map(output).collect()
        },
    );
}

/// Both factors are off by up to 2⁻⁸ of themselves (products by 2⁻⁷), and what many products are off by nearly cancels.
#[test]
#[ignore = "needs avx512_bf16"]
fn every_network_answers_nearly_as_in_floats_needs_bf16() {
    let only = std::env::var("TAXEL_NETWORK").ok();
    let mut wrong = vec![];
    for entry in taxel_zoo::Registry::built_in().entries() {
        let name = entry.name.as_str();
        if only.as_deref().is_some_and(|only| only != name) {
            continue;
        }
        let graph = entry.graph(&taxel_zoo::Settings::new()).unwrap();
        let (weights, inputs) = (weights(&graph), samples(&graph, 1));
        let want = predict(&Frozen::new(&graph, &weights).unwrap(), &slices(&inputs));
        let got = predict(&Frozen::half(&graph, &weights).unwrap(), &slices(&inputs));
        let largest = want.iter().fold(1e-3f32, |most, v| most.max(v.abs()));
        let off = want.iter().zip(&got).map(|(a, b)| (a - b).abs() / largest);
        // NaN counts as far off.
        let off = off.map(|off| if off.is_nan() { f32::INFINITY } else { off }).fold(0.0, f32::max);
        println!("{name}: {off:e}");
        if off > 1.0 / 128.0 || off == 0.0 {
            wrong.push(format!("{name}: {off:e}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
#[ignore = "needs avx512_bf16"]
fn an_answer_does_not_depend_on_its_neighbours_needs_bf16() {
    for name in ["mlp", "lstm", "hybrid-resvgg", "tactnet3d", "shufflenet-v2", "mobilenet-v2", "alexnet"] {
        let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
        let frozen = Frozen::half(&graph, &weights(&graph)).unwrap();
        let n = 3;
        let lens: Vec<usize> = graph.inputs().map(|node| node.shape.iter().product()).collect();
        let all = samples(&graph, n);
        let mut logits = vec![f32::NAN; n * frozen.logits()];
        frozen.predict_many(&mut frozen.workspace_for(64), &slices(&all), &mut logits).unwrap();
        let mut single = frozen.workspace();
        for (sample, got) in logits.chunks(frozen.logits()).enumerate() {
            let one = all.iter().zip(&lens).map(|(x, len)| &x[sample * len..(sample + 1) * len]);
            let want = frozen.predict(&mut single, &one.collect::<Vec<_>>()).unwrap();
            assert_eq!(bits(got), bits(want), "{name}, sample {sample}");
        }
    }
}
