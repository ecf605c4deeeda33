//! Answers of one evaluator that threads share: bit for bit those of an engine.

#![allow(clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "../../../tests/support/twin.rs"]
mod twin;

use std::thread;

use taxel_engine::{Adam, Engine, EngineOptions, Evaluator, Mode, Sgdm, Workspace};
use taxel_graph::{Conv, Graph, Network, Weights};
use twin::Twin;

/// All outputs of a batch, by name, as bits.
type Outputs = Vec<(String, Vec<u32>)>;

fn bits<'a>(outputs: impl Iterator<Item = (&'a str, &'a [f32])>) -> Outputs {
    outputs.map(|(name, values)| (name.into(), values.iter().map(|v| v.to_bits()).collect())).collect()
}

type OptimizerStep = fn(&mut Engine);
const SGDM: Sgdm = Sgdm { lr: 0.1, momentum: 0.9, weight_decay: 0.0 };
const OPTIMISERS: [(&str, OptimizerStep); 3] = [
    ("sgdm", |e| e.sgdm(&SGDM)),
    ("adam", |e| e.adam(&Adam::default())),
    ("adamw", |e| e.adamw(&Adam::default())),
];

/// Inputs of `n` samples; another `salt` gives others.
fn inputs(graph: &Graph, n: usize, salt: u64) -> Vec<Vec<f32>> {
    let values = |len: usize, salt: u64| twin::hashed(n * len, salt).into_iter().map(|v| v as f32).collect();
    let lens = graph.inputs().map(|node| node.shape.iter().product());
    lens.zip(10 * salt..).map(|(len, salt)| values(len, salt)).collect()
}

fn slices(inputs: &[Vec<f32>]) -> Vec<&[f32]> {
    inputs.iter().map(Vec::as_slice).collect()
}

fn predict(evaluator: &Evaluator, workspace: &mut Workspace, n: usize, salt: u64) -> Outputs {
    let inputs = inputs(evaluator.graph(), n, salt);
    let logits = evaluator.predict(workspace, &slices(&inputs), n).unwrap().to_vec();
    assert_eq!(workspace.outputs().next().unwrap().1, logits, "logits are the first output");
    bits(workspace.outputs())
}

fn options(batch: usize, threads: usize) -> EngineOptions {
    EngineOptions { batch, threads, ..EngineOptions::default() }
}

/// Two threads, one evaluator, batches of one sample and full ones in another order each.
fn assert_shared(graph: &Graph, weights: &Weights, pool: usize) {
    const BATCH: usize = 5;
    let mut engine = Engine::new(graph, weights, options(BATCH, pool)).unwrap();
    let mut expected = |n: usize, salt: u64| {
        engine.forward(&slices(&inputs(graph, n, salt)), n, Mode::Eval).unwrap();
        bits(engine.outputs())
    };
    let orders = [[(BATCH, 1), (1, 2), (BATCH, 3), (2, 4)], [(1, 2), (BATCH, 3), (2, 4), (BATCH, 1)]];
    let wanted = orders.map(|order| order.map(|(n, salt)| expected(n, salt)));
    assert_ne!(wanted[0][0], wanted[0][2], "{}: other samples, other predictions", graph.name());
    let evaluator = Evaluator::new(graph, weights, options(BATCH, pool)).unwrap();
    let predictions = thread::scope(|scope| {
        let caller = |order: [(usize, u64); 4]| {
            let evaluator = &evaluator;
            scope.spawn(move || {
                let mut workspace = evaluator.workspace();
                order.map(|(n, salt)| predict(evaluator, &mut workspace, n, salt))
            })
        };
        orders.map(caller).map(|thread| thread.join().unwrap())
    });
    assert_eq!(predictions, wanted, "{}", graph.name());
}

#[test]
fn threads_share_an_evaluator_and_answer_as_the_engine_does() {
    for twin in Twin::all() {
        let graph = taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap();
        // The large ones take long and have no operation of their own.
        if graph.parameter_count() < 4_000_000 {
            assert_shared(&graph, &twin.weights(), 1);
        }
    }
}

#[test]
fn every_operation_is_shared() {
    for (twin, graph) in Twin::operations() {
        assert_shared(&graph, &twin.weights(), 1);
    }
    let net = Network::new("wide");
    let x = net.input("x", &[600]).linear("fc1", 512).relu();
    let wide = net.finish(&[("logits", x.linear("fc2", 3)), ("features", x)]).unwrap();
    for graph in [common::mixed(), wide] {
        assert_shared(&graph, &common::weights(&graph), 1);
    }
}

#[test]
fn callers_share_a_pool() {
    for name in ["resnet8-lite-2d", "hybrid-resvgg", "lstm"] {
        let twin = Twin::all().into_iter().find(|t| t.name == name).unwrap();
        let graph = taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap();
        assert_shared(&graph, &twin.weights(), 3);
    }
}

/// Weights and running statistics that training has moved; convolutions pack theirs anew.
#[test]
fn a_trained_network_answers_as_its_engine() {
    let twin = Twin::all().into_iter().find(|t| t.name == "resnet8-lite-2d").unwrap();
    let graph = taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap();
    let xs = inputs(&graph, 3, 1);
    for (name, optimiser) in OPTIMISERS {
        let mut engine = Engine::new(&graph, &twin.weights(), options(3, 1)).unwrap();
        engine.forward(&slices(&xs), 3, Mode::Train).unwrap();
        engine.backward(&[0, 1, 2]).unwrap();
        optimiser(&mut engine);
        let evaluator = Evaluator::new(&graph, &engine.weights(), options(3, 1)).unwrap();
        engine.forward(&slices(&xs), 3, Mode::Eval).unwrap();
        assert_eq!(predict(&evaluator, &mut evaluator.workspace(), 3, 1), bits(engine.outputs()), "{name}");
    }
}

/// The same values as features, which are channels first, and as maps.
#[test]
fn outputs_with_spatial_axes_have_the_order_of_pytorch() {
    let net = Network::new("maps");
    let x = net.input("x", &[3, 7, 5]).conv("conv", Conv::new(4, 3)).batch_norm("bn").relu();
    let graph = net.finish(&[("features", x.flatten()), ("maps", x)]).unwrap();
    for (batch, n) in [(1, 1), (9, 9), (9, 4)] {
        let evaluator = Evaluator::new(&graph, &common::weights(&graph), options(batch, 1)).unwrap();
        let outputs = predict(&evaluator, &mut evaluator.workspace(), n, 1);
        let [(first, features), (second, maps)] = outputs.as_slice() else { panic!("{outputs:?}") };
        assert_eq!([first, second], ["features", "maps"]);
        assert!(maps.len() == n * 4 * 5 * 3 && maps == features, "{n} of {batch}");
    }
}

#[test]
fn an_evaluator_may_cross_threads() {
    fn shared<T: Send + Sync>() {}
    fn sent<T: Send>() {}
    shared::<Evaluator>();
    sent::<Workspace>();
}

#[test]
fn what_does_not_fit_is_refused_and_the_workspace_stays_usable() {
    let graph = common::mixed();
    let new = |batch| Evaluator::new(&graph, &common::weights(&graph), options(batch, 1));
    let (evaluator, other) = (new(3).unwrap(), new(4).unwrap());
    assert_eq!(new(0).err().unwrap().to_string(), "mixed: a batch must hold at least one sample");
    let mut workspace = evaluator.workspace();
    assert!(workspace.outputs().all(|(_, values)| values.is_empty()), "nothing before the first prediction");
    let before = predict(&evaluator, &mut workspace, 3, 1);
    let inputs = inputs(&graph, 4, 1);
    let xs = slices(&inputs);
    let mut refusal = |evaluator: &Evaluator, xs: &[&[f32]], n| {
        evaluator.predict(&mut workspace, xs, n).unwrap_err().to_string()
    };
    assert_eq!(
        refusal(&other, &xs, 4),
        "mixed: the workspace belongs to another evaluator; make one with this evaluator's `workspace`"
    );
    assert_eq!(refusal(&evaluator, &xs, 4), "mixed: a batch of 4 samples; compiled for 1 to 3");
    assert_eq!(refusal(&evaluator, &xs, 0), "mixed: a batch of 0 samples; compiled for 1 to 3");
    assert_eq!(refusal(&evaluator, &xs[..1], 3), "mixed: 1 inputs given, 2 expected");
    assert_eq!(
        refusal(&evaluator, &xs, 3),
        "mixed: input `image` holds 864 values; 3 samples of channels 3 × rows 9 × columns 8 have 648"
    );
    assert_eq!(bits(workspace.outputs()), before, "a refusal leaves the last prediction");
    assert_eq!(predict(&evaluator, &mut workspace, 3, 1), before);
}
