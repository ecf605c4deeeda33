//! A network whose last layers are changed answers in another unit.

#![allow(clippy::unwrap_used)]

use taxel_engine::{EngineOptions, Evaluator};
use taxel_graph::{Conv, Flow, Graph, Network, Scheme, Weights};

fn answers(graph: &Graph, weights: &Weights) -> Vec<f32> {
    let evaluator =
        Evaluator::new(graph, weights, EngineOptions { batch: 3, ..EngineOptions::default() }).unwrap();
    let x: Vec<f32> = (0..3 * 18).map(|i| (i as f32 * 0.7).sin()).collect();
    evaluator.predict(&mut evaluator.workspace(), &[&x], 3).unwrap().to_vec()
}

#[test]
fn every_end_of_a_network_can_be_brought_to_another_unit() {
    type End = (&'static str, fn(&Network, &Flow) -> Flow);
    let ends: [End; 5] = [
        ("linear", |_, x| x.flatten().linear("fc", 2)),
        ("norm", |_, x| x.flatten().linear("fc", 2).batch_norm("norm")),
        ("mean", |_, x| x.conv("conv", Conv::new(2, 3)).global_average_pool()),
        ("dropout", |_, x| x.flatten().linear("fc", 2).dropout(0.5)),
        ("sum", |_, x| x.flatten().linear("one", 2).add(&x.global_average_pool().linear("two", 2))),
    ];
    let (scale, shift) = ([3.0, 0.25], [10.0, -4.0]);
    for (what, end) in ends {
        let net = Network::new(what);
        let x = net.input("x", &[3, 6]);
        let y = end(&net, &x);
        let graph = net.finish(&[("values", y)]).unwrap();
        let weights = Weights::init(&graph, Scheme::Pytorch, 1, "unit");
        let changed = graph.rescaled(&weights, &scale, &shift).unwrap();
        for (at, (before, after)) in
            answers(&graph, &weights).iter().zip(answers(&graph, &changed)).enumerate()
        {
            let want = scale[at % 2] * f64::from(*before) + shift[at % 2];
            assert!((f64::from(after) - want).abs() < 2e-5, "{what}: {after} and {want}");
        }
    }
}

#[test]
fn an_end_that_cannot_be_moved_is_refused_by_name() {
    let refused = |end: fn(&Flow) -> Flow| {
        let net = Network::new("net");
        let values = end(&net.input("x", &[3, 6]));
        let graph = net.finish(&[("values", values)]).unwrap();
        graph.check_rescalable().unwrap_err().to_string()
    };
    assert!(refused(|x| x.flatten().linear("fc", 2).relu()).starts_with("fc/relu: is the last operation"));
    assert!(refused(|x| x.flatten()).contains("is the last operation"));
    // Its values are those of five positions of two channels.
    let spread = refused(|x| x.conv("conv", Conv::new(2, 2)).flatten());
    assert!(spread.starts_with("conv: ") && spread.contains("10"), "{spread}");
}

#[test]
fn a_sum_of_members_that_learn_alone_answers_with_their_mean() {
    let graph = |weights: [f32; 3]| {
        let net = Network::new("members");
        let x = net.input("x", &[3, 6]).flatten();
        let (one, two) = (x.linear("one", 2), x.linear("two", 2));
        let sum = one.add(&two);
        net.finish_weighted(&[("sum", sum), ("one", one), ("two", two)], &weights)
    };
    assert_eq!(graph([0.0, 1.0, 1.0]).unwrap().answering_share(), 0.5);
    assert_eq!(graph([1.0, 1.0, 1.0]).unwrap().answering_share(), 1.0);
    assert_eq!(graph([0.0, 1.0, 0.0]).unwrap().answering_share(), 1.0);
}
