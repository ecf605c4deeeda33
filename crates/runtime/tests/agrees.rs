//! Frozen networks predict as the engine does.
#![allow(clippy::unwrap_used)]

mod common;

use common::{off, weights};
use taxel_graph::{Activation, Conv, Graph, Network, Pool};
use taxel_runtime::Frozen;

#[test]
fn every_network_answers_as_the_engine_does() {
    let only = std::env::var("TAXEL_NETWORK").ok();
    let mut wrong = vec![];
    for entry in taxel_zoo::Registry::built_in().entries() {
        let name = entry.name.as_str();
        if only.as_deref().is_some_and(|only| only != name) {
            continue;
        }
        for (output, off) in off(&entry.graph(&taxel_zoo::Settings::new()).unwrap()) {
            println!("{name} {output}: {off:e}");
            if off > 1e-5 {
                wrong.push(format!("{name} {output}: {off:e}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Graphs of which no network of the zoo has the like.
fn agrees(
    what: &str,
    build: impl FnOnce(&Network, taxel_graph::Flow) -> Vec<(&'static str, taxel_graph::Flow)>,
) {
    agrees_on(&[3, 5, 9], what, build);
}

fn agrees_on(
    input: &[usize],
    what: &str,
    build: impl FnOnce(&Network, taxel_graph::Flow) -> Vec<(&'static str, taxel_graph::Flow)>,
) {
    let net = Network::new("odd");
    let x = net.input("x", input);
    let outputs = build(&net, x);
    let graph: Graph = net.finish(&outputs).unwrap();
    for (output, off) in off(&graph) {
        assert!(off <= 1e-5, "{what}, {output}: {off:e}");
    }
}

#[test]
fn what_others_see_is_left_as_it_is() {
    agrees("a convolution beside its norm", |_, x| {
        let conv = x.conv("conv", Conv::new(7, 3).pad(1));
        vec![("sum", conv.batch_norm("bn").relu().add(&conv).flatten().linear("fc", 4))]
    });
    agrees("a convolution that is an output", |_, x| {
        let conv = x.conv("conv", Conv::new(7, 3).pad(1));
        let rectified = conv.batch_norm("bn").relu();
        vec![("raw", conv), ("logits", rectified.global_average_pool())]
    });
    agrees("a rectified value beside the sum before it", |_, x| {
        let (a, b) = (x.conv("a", Conv::new(6, 3).pad(1)), x.conv("b", Conv::new(6, 1)));
        let sum = a.add(&b);
        vec![("logits", sum.relu().add(&sum).flatten().linear("fc", 3))]
    });
}

#[test]
fn values_that_share_memory_are_not_mixed_up() {
    agrees("a convolution of its neighbour", |net, x| {
        let a = x.conv("a", Conv::new(4, 3).pad(1));
        let b = a.conv("b", Conv::new(5, 3).pad(1));
        let both = net.concat("both", &[&a, &b]);
        let c = both.conv("c", Conv::new(6, 3).pad(1));
        vec![("logits", net.concat("all", &[&both, &c, &a]).flatten().linear("fc", 3))]
    });
    agrees("one value twice, and parts in another order", |net, x| {
        let a = x.conv("a", Conv::new(4, 3).pad(1));
        let twice = net.concat("twice", &[&a, &a]);
        let turned = net.concat("turned", &[&twice.slice(5, 3), &twice.slice(0, 5)]);
        vec![("logits", turned.conv("b", Conv::new(3, 3).pad(1)).flatten().linear("fc", 3))]
    });
    agrees("a slice that is rectified in place of the whole", |_, x| {
        let a = x.conv("a", Conv::new(8, 3).pad(1));
        vec![("logits", a.slice(0, 4).relu().add(&a.slice(4, 4)).flatten().linear("fc", 3))]
    });
}

/// Values between two convolutions that are too many for the cache are computed band by band.
#[test]
fn bands_meet_at_their_edges() {
    let (filters, input) = (64, [3, 161, 75]);
    for (what, depthwise) in [
        ("padded", Conv::new(filters, 3).pad(1)),
        ("every second row", Conv::new(filters, 3).stride(2).pad(1)),
        ("without padding", Conv::new(filters, 3)),
        ("wide, every third", Conv::new(filters, 5).stride(3).pad(2)),
        ("taller than wide", Conv::new(filters, [7, 1]).pad([3, 0])),
        ("dilated", Conv::new(filters, 3).dilation(3).pad(3)),
        ("padded beyond the window", Conv::new(filters, 3).pad(4)),
    ] {
        agrees_on(&input, what, |_, x| {
            let wide = x.conv("expand", Conv::new(filters, 1)).batch_norm("bn").activation(Activation::Relu6);
            let deep = wide.conv("depthwise", depthwise.groups(filters)).batch_norm("bn2").relu();
            vec![("logits", deep.conv("project", Conv::new(4, 1)).flatten().linear("fc", 3))]
        });
    }
    agrees_on(&input, "after another one, in the same scratch", |_, x| {
        let block = |x: &taxel_graph::Flow, name: &str, filters: usize| {
            let wide = x.conv(&format!("{name}.expand"), Conv::new(filters, 1)).relu();
            let deep = wide.conv(&format!("{name}.deep"), Conv::new(filters, 3).pad(1).groups(filters));
            deep.conv(&format!("{name}.project"), Conv::new(4, 1))
        };
        vec![("logits", block(&block(&x, "a", filters), "b", 72).flatten().linear("fc", 3))]
    });
    agrees_on(&[3, 1, 161, 75], "deeper than its image", |_, x| {
        let wide = x.conv("expand", Conv::new(filters, 1)).relu();
        let deep = wide.conv("depthwise", Conv::new(filters, [1, 3, 3]).pad([1, 1, 1]).groups(filters));
        vec![("logits", deep.conv("project", Conv::new(4, 1)).flatten().linear("fc", 3))]
    });
    agrees_on(&input, "read by two", |_, x| {
        let wide = x.conv("expand", Conv::new(filters, 1)).relu();
        let deep = wide.conv("depthwise", Conv::new(filters, 3).pad(1).groups(filters));
        vec![("logits", deep.add(&wide).conv("project", Conv::new(4, 1)).flatten().linear("fc", 3))]
    });
    agrees_on(&input, "read from outside", |_, x| {
        let wide = x.conv("expand", Conv::new(filters, 1));
        let deep = wide.conv("depthwise", Conv::new(filters, 3).pad(1).groups(filters));
        vec![("wide", wide), ("logits", deep.conv("project", Conv::new(4, 1)).flatten().linear("fc", 3))]
    });
    agrees_on(&input, "of a slice, into a concatenation", |net, x| {
        let both = x.conv("both", Conv::new(12, 3).pad(1));
        let wide = both.slice(4, 8).conv("expand", Conv::new(filters, 1)).relu();
        let deep = wide.conv("depthwise", Conv::new(filters, 3).pad(1).groups(filters));
        let all = net.concat("all", &[&deep, &both]);
        vec![("logits", all.conv("last", Conv::new(3, 3).pad(1)).flatten().linear("fc", 3))]
    });
}

#[test]
fn layer_norms_of_whole_values_and_of_slices() {
    agrees("before a rectifier", |_, x| {
        let hidden = x.flatten().linear("fc1", 37).layer_norm("ln").relu();
        vec![("logits", hidden.linear("fc", 3))]
    });
    agrees("of a slice, into a concatenation", |net, x| {
        let hidden = x.flatten().linear("fc1", 12);
        let both = net.concat("both", &[&hidden.slice(3, 8).layer_norm("ln"), &hidden]);
        vec![("logits", both.linear("fc", 3))]
    });
    agrees("a deviation of a slice", |_, x| vec![("logits", x.slice(1, 2).global_standard_deviation(1e-3))]);
}

#[test]
fn recurrent_layers_over_frames_and_beside_others() {
    agrees_on(&[3, 6, 5, 9], "frames of convolutions with margins", |_, x| {
        let x = x.conv("a", Conv::new(7, [3, 3, 1]).same()).relu().max_pool(Pool::new([2, 1, 1]));
        let x = x.conv("b", Conv::new(6, [3, 5, 1])).batch_norm("bn").relu();
        let both = x.gru("gru", 9).concat(&x.lstm("lstm", 5));
        vec![("logits", both.linear("fc", 3))]
    });
    agrees_on(&[4, 11], "a slice of channels, into a concatenation", |net, x| {
        let x = x.conv("a", Conv::new(8, 3).same()).relu();
        let parts = [&x.slice(2, 5).gru("gru", 37), &x.global_average_pool()];
        vec![("logits", net.concat("both", &parts).linear("fc", 3))]
    });
}

#[test]
fn means_count_what_they_should() {
    for (what, pool) in [
        ("with padding", Pool::new(3).stride(2).pad(1)),
        ("without padding", Pool::new(3).stride(2).pad(1).ignore_padding()),
        ("rounded up", Pool::new(2).stride(2).round_up()),
    ] {
        agrees(what, |_, x| vec![("logits", x.average_pool(pool).flatten().linear("fc", 3))]);
    }
}

/// Samples that are predicted together share what is read of the weights, and nothing else.
#[test]
fn an_answer_does_not_depend_on_its_neighbours() {
    for name in ["mlp", "lstm", "hybrid-resvgg", "multiscale-cnn", "shufflenet-v2", "alexnet"] {
        let graph = taxel_zoo::find(name).unwrap().graph(&taxel_zoo::Settings::new()).unwrap();
        let frozen = Frozen::new(&graph, &weights(&graph)).unwrap();
        let n = 5;
        let value = |i: usize| ((i * 37 % 101) as f32 - 50.0) / 50.0;
        let lens: Vec<usize> = graph.inputs().map(|node| node.shape.iter().product()).collect();
        let inputs: Vec<Vec<f32>> = lens.iter().map(|len| (0..n * len).map(value).collect()).collect();
        let all: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
        let mut logits = vec![0.0; n * frozen.logits()];
        let mut single = frozen.workspace();
        for batch in [1, 3, 64] {
            logits.fill(f32::NAN);
            frozen.predict_many(&mut frozen.workspace_for(batch), &all, &mut logits).unwrap();
            for (sample, got) in logits.chunks(frozen.logits()).enumerate() {
                let one = inputs.iter().zip(&lens).map(|(x, len)| &x[sample * len..(sample + 1) * len]);
                let want = frozen.predict(&mut single, &one.collect::<Vec<_>>()).unwrap();
                let bits = |x: &[f32]| x.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(got), bits(want), "{name}, sample {sample} in batches of {batch}");
            }
        }
        let error = frozen.predict_many(&mut single, &[], &mut logits).unwrap_err().to_string();
        assert!(error.contains("inputs given"), "{error}");
    }
}
