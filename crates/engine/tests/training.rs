//! Optimisers, their state, frozen nodes, dropout and threads, on a network with every kind of layer.

#![allow(clippy::unwrap_used, clippy::panic)]

mod common;
#[path = "../../../tests/support/twin.rs"]
mod twin;

use common::{batch, engine, mixed, pass, weights};
use taxel_engine::{Adam, Decay, Engine, EngineOptions, FrozenStatistics, Mode, OptimizerState, Sgdm};
use taxel_graph::{Graph, Loss, Targets, TensorKind, Weights};
use taxel_kernels::optim;
use twin::Twin;

const SGDM: Sgdm = Sgdm { lr: 0.05, momentum: 0.9, weight_decay: 0.01 };
const ADAM: Adam = Adam { lr: 0.01, betas: (0.9, 0.999), eps: 1e-8, weight_decay: 0.05 };

type OptimizerStep = fn(&mut Engine);
const OPTIMISERS: [(&str, OptimizerStep); 3] =
    [("sgdm", |e| e.sgdm(&SGDM)), ("adam", |e| e.adam(&ADAM)), ("adamw", |e| e.adamw(&ADAM))];

/// Every bit of all that training leaves behind.
fn left(engine: &Engine) -> (Weights, OptimizerState, (u64, u64)) {
    (engine.weights(), engine.optimizer_state(), engine.dropout())
}

#[test]
fn optimisers_are_the_kernels_tensor_by_tensor() {
    for (name, optimiser) in OPTIMISERS {
        let mut engine = engine(5, 1, &[]);
        let mut state = OptimizerState::default();
        for step in 1..4 {
            let before = engine.weights();
            pass(&mut engine, 5, step);
            optimiser(&mut engine);
            let (after, gradients, now) = (engine.weights(), engine.gradients(), engine.optimizer_state());
            assert_eq!(now.step, if name == "sgdm" { 0 } else { step });
            for (param, gradient) in gradients.iter() {
                let g = &gradient.data;
                let old = |group: &Weights| group.get(param).map_or(vec![0.0; g.len()], |t| t.data.clone());
                let mut w = before.get(param).unwrap().data.clone();
                let (mut v, mut m, mut s) =
                    (old(&state.momentum_buffer), old(&state.exp_avg), old(&state.exp_avg_sq));
                match name {
                    "sgdm" => optim::sgdm(&mut w, g, &mut v, SGDM.lr, SGDM.momentum, SGDM.weight_decay),
                    "adam" => optim::adam(&mut w, g, &mut m, &mut s, &ADAM, step),
                    _ => optim::adamw(&mut w, g, &mut m, &mut s, &ADAM, step),
                }
                assert_eq!(after.get(param).unwrap().data, w, "{name}: {param} in step {step}");
                if name == "sgdm" {
                    assert_eq!(now.momentum_buffer.get(param).unwrap().data, v);
                } else {
                    assert_eq!(now.exp_avg.get(param).unwrap().data, m);
                    assert_eq!(now.exp_avg_sq.get(param).unwrap().data, s);
                }
            }
            state = now;
        }
        assert_eq!(state.momentum_buffer.is_empty(), name != "sgdm");
        assert_eq!(state.exp_avg.is_empty(), name == "sgdm");
    }
}

/// PyTorch's two groups of parameters: matrices with weight decay, biases and batch norms without.
#[test]
fn decay_of_matrices_alone_is_no_decay_of_the_rest() {
    let bare = Sgdm { weight_decay: 0.0, ..SGDM };
    let without = Adam { weight_decay: 0.0, ..ADAM };
    let plain: [OptimizerStep; 3] = [|e| e.sgdm(&SGDM), |e| e.adam(&ADAM), |e| e.adamw(&ADAM)];
    let spared: [&dyn Fn(&mut Engine); 3] =
        [&|e| e.sgdm(&bare), &|e| e.adam(&without), &|e| e.adamw(&without)];
    for ((name, optimiser), (all, none)) in OPTIMISERS.iter().zip(plain.iter().zip(spared)) {
        let graph = mixed();
        let options = EngineOptions { batch: 5, decay: Decay::Matrices, ..EngineOptions::default() };
        let mut whole = Engine::new(&graph, &weights(&graph), options).unwrap();
        let [mut decayed, mut bare] = [(); 2].map(|()| engine(5, 1, &[]));
        for engine in [&mut whole, &mut decayed, &mut bare] {
            pass(engine, 5, 1);
        }
        optimiser(&mut whole);
        all(&mut decayed);
        none(&mut bare);
        let [whole, decayed, bare] = [whole, decayed, bare].map(|engine| engine.weights());
        assert_ne!(decayed, bare);
        for (param, tensor) in whole.iter() {
            let want = if tensor.shape.len() > 1 { &decayed } else { &bare };
            assert_eq!(Some(tensor), want.get(param), "{name}: {param}");
        }
    }
}

#[test]
fn what_was_exported_goes_on_bit_for_bit() {
    for (name, optimiser) in OPTIMISERS {
        let run = |engine: &mut Engine, steps: std::ops::Range<u64>| {
            for step in steps {
                pass(engine, 7, step);
                optimiser(engine);
            }
        };
        let mut whole = engine(7, 1, &["left.bn"]);
        whole.set_dropout(11, 0);
        run(&mut whole, 0..3);
        let (weights, state, (seed, step)) = left(&whole);
        run(&mut whole, 3..6);
        let mut second = engine(7, 1, &["left.bn"]);
        second.set_weights(&weights).unwrap();
        second.set_optimizer_state(&state).unwrap();
        second.set_dropout(seed, step);
        run(&mut second, 3..6);
        assert_eq!(left(&second), left(&whole), "{name}");
        assert_eq!(second.dropout(), (11, 6));
        // Each piece of the state matters.
        let mut forgetful = engine(7, 1, &["left.bn"]);
        forgetful.set_weights(&weights).unwrap();
        forgetful.set_dropout(seed, step);
        run(&mut forgetful, 3..6);
        assert_ne!(forgetful.weights(), whole.weights(), "{name}: state without effect");
    }
}

#[test]
fn new_weights_start_the_optimisers_anew() {
    for (name, optimiser) in OPTIMISERS {
        let mut engine = engine(2, 1, &[]);
        pass(&mut engine, 2, 0);
        optimiser(&mut engine);
        assert_ne!(engine.optimizer_state(), OptimizerState::default(), "{name}");
        engine.set_weights(&weights(&mixed())).unwrap();
        assert_eq!(engine.optimizer_state(), OptimizerState::default(), "{name}");
    }
}

#[test]
fn state_that_does_not_fit_is_refused_by_name() {
    let mut engine = engine(2, 1, &["stem"]);
    pass(&mut engine, 2, 0);
    engine.sgdm(&SGDM);
    let state = engine.optimizer_state();
    let mut misshaped = state.clone();
    misshaped.momentum_buffer.insert("fc1.bias", weights(&mixed()).get("fc2.bias").unwrap().clone());
    let mut partial = OptimizerState::default();
    partial.exp_avg.insert("fc1.bias", weights(&mixed()).get("fc1.bias").unwrap().clone());
    let mut frozen = state.clone();
    frozen.momentum_buffer.insert("stem.conv.bias", weights(&mixed()).get("stem.conv.bias").unwrap().clone());
    for (wrong, message) in [
        (misshaped, "mixed: tensor `fc1.bias` has shape [3], expected [6]"),
        (partial, "mixed: tensor `left.conv.weight` is missing; expected shape [4, 3, 3, 3]"),
        (frozen, "mixed: tensor `stem.conv.bias` is not part of this network"),
    ] {
        assert_eq!(engine.set_optimizer_state(&wrong).unwrap_err().to_string(), message);
        assert_eq!(engine.optimizer_state(), state, "nothing is replaced");
    }
}

#[test]
fn gradients_are_clipped_together() {
    let mut engine = engine(4, 1, &[]);
    pass(&mut engine, 4, 0);
    let norm = |weights: &Weights| {
        weights.iter().flat_map(|(_, t)| &t.data).map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt()
    };
    let before = engine.gradients();
    let returned = engine.clip_gradients(0.25);
    assert!((f64::from(returned) - norm(&before)).abs() < 1e-5 * norm(&before));
    assert!(norm(&before) > 0.26 && (norm(&engine.gradients()) - 0.25).abs() < 1e-5);
}

/// Without a batch norm among them, frozen nodes change nothing but that they stay.
#[test]
fn frozen_nodes_stay_and_the_others_have_the_same_gradients() {
    for names in
        [&["left.conv"][..], &["fc2"], &["lstm", "gru", "right"], &["right.scale"], &["stem.conv", "fc1"]]
    {
        for (name, optimiser) in OPTIMISERS {
            let (mut all, mut some) = (engine(5, 1, &[]), engine(5, 1, names));
            assert_eq!(pass(&mut all, 5, 0), pass(&mut some, 5, 0));
            let covered =
                |param: &str| names.iter().any(|n| param == *n || param.starts_with(&format!("{n}.")));
            let (gradients, fewer) = (all.gradients(), some.gradients());
            for (param, gradient) in gradients.iter() {
                let want = if covered(param) { None } else { Some(gradient) };
                assert_eq!(fewer.get(param), want, "{names:?}: {param}");
            }
            let before = some.weights();
            optimiser(&mut some);
            for _ in 0..2 {
                pass(&mut some, 5, 1);
                optimiser(&mut some);
            }
            for (param, tensor) in some.weights().iter() {
                // A bias before a batch norm has no gradient but for rounding.
                if param != "stem.conv.bias" {
                    let moved = Some(tensor) != before.get(param);
                    assert_eq!(moved, !covered(param), "{name}, {names:?}: {param}");
                }
            }
            let state = some.optimizer_state();
            for group in [&state.momentum_buffer, &state.exp_avg, &state.exp_avg_sq] {
                assert!(group.iter().all(|(param, _)| !covered(param)), "{names:?}");
            }
        }
    }
}

/// With renewed statistics frozen nodes, batch norms among them, change nothing but that they stay.
#[test]
fn frozen_batch_norms_with_renewed_statistics_are_as_all_others() {
    let graph = mixed();
    for names in [&["left.bn"][..], &["stem.bn"], &["stem", "left"], &["left.conv", "left.bn", "fc1"]] {
        let renewed = || EngineOptions {
            batch: 5,
            threads: 2,
            frozen: names.iter().map(ToString::to_string).collect(),
            frozen_statistics: FrozenStatistics::Renewed,
            ..EngineOptions::default()
        };
        let mut all = engine(5, 1, &[]);
        let mut some = Engine::new(&graph, &weights(&graph), renewed()).unwrap();
        let covered = |name: &str| names.iter().any(|n| name.starts_with(&format!("{n}.")));
        let learned =
            |param: &str| graph.params().any(|p| p.name == param && p.kind == TensorKind::Parameter);
        assert_eq!(pass(&mut all, 5, 0), pass(&mut some, 5, 0), "{names:?}");
        let (gradients, fewer) = (all.gradients(), some.gradients());
        for (param, gradient) in gradients.iter() {
            let want = if covered(param) { None } else { Some(gradient) };
            assert_eq!(fewer.get(param), want, "{names:?}: {param}");
        }
        for begins in [false, true] {
            if begins {
                all.begin_recomputing();
                some.begin_recomputing();
                pass(&mut all, 5, 1);
                pass(&mut some, 5, 1);
                all.end_recomputing();
                some.end_recomputing();
            }
            // Running averages first, then the whole training set.
            assert_eq!(all.weights(), some.weights(), "{names:?}");
        }
        assert!(some.weights().get("left.bn.running_mean") != weights(&graph).get("left.bn.running_mean"));
        some.sgdm(&SGDM);
        for (name, tensor) in all.weights().iter().filter(|(name, _)| *name != "stem.conv.bias") {
            let stays = covered(name) || !learned(name);
            assert_eq!(some.weights().get(name) == Some(tensor), stays, "{names:?}: {name}");
        }
    }
}

/// A frozen batch norm is the affine map of its running statistics: it sees no batch, and keeps them.
#[test]
fn frozen_batch_norms_use_and_keep_running_statistics() {
    let twin = Twin::all().into_iter().find(|t| t.name == "resnet8-lite-1d").unwrap();
    let graph = taxel_zoo::find(&twin.network).unwrap().graph(&twin.settings).unwrap();
    let norms: Vec<String> =
        graph.nodes().iter().filter(|n| n.op.kind() == "batch_norm").map(|n| n.name.clone()).collect();
    let inputs = twin.inputs(&graph, 500);
    let xs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let options = EngineOptions { batch: twin.batch, frozen: norms.clone(), ..EngineOptions::default() };
    let mut engine = Engine::new(&graph, &twin.weights(), options).unwrap();
    let eval = engine.forward(&xs, twin.batch, Mode::Eval).unwrap().to_vec();
    engine.begin_recomputing();
    assert_eq!(engine.forward(&xs, twin.batch, Mode::Train).unwrap(), eval);
    engine.end_recomputing();
    engine.forward(&xs, twin.batch, Mode::Train).unwrap();
    engine.backward(&twin.labels()).unwrap();
    let gradients = engine.gradients();
    engine.sgdm(&SGDM);
    for (name, tensor) in engine.weights().iter() {
        let kept = norms.iter().any(|norm| name.starts_with(norm.as_str()));
        assert_eq!(kept, Some(tensor) == twin.weights().get(name), "{name}");
    }
    // Slopes along a direction of all parameters that learn.
    let mut loss = |step: f64| {
        let mut moved = twin.weights();
        for (salt, (name, _)) in gradients.iter().enumerate() {
            let mut tensor = twin.weights().get(name).unwrap().clone();
            let direction = twin::hashed(tensor.data.len(), 4000 + salt as u64);
            tensor.data.iter_mut().zip(direction).for_each(|(w, d)| *w += (step * d) as f32);
            moved.insert(name, tensor);
        }
        engine.set_weights(&moved).unwrap();
        engine.forward(&xs, twin.batch, Mode::Train).unwrap();
        f64::from(engine.backward(&twin.labels()).unwrap())
    };
    let step = 1e-4;
    let slope = (loss(step) - loss(-step)) / (2.0 * step);
    let projected: f64 = gradients
        .iter()
        .enumerate()
        .map(|(salt, (_, g))| {
            let direction = twin::hashed(g.data.len(), 4000 + salt as u64);
            g.data.iter().zip(direction).map(|(&g, d)| f64::from(g) * d).sum::<f64>()
        })
        .sum();
    assert!((slope - projected).abs() < 0.02 * projected.abs(), "{slope} and {projected}");
}

#[test]
fn everything_frozen_moves_nothing() {
    let graph = mixed();
    let names: Vec<&str> = vec!["stem", "left", "right", "wide", "lstm", "gru", "fc1", "ln", "fc2"];
    let mut engine = engine(3, 1, &names);
    let before = engine.weights();
    assert!(pass(&mut engine, 3, 0).is_finite());
    engine.adamw(&ADAM);
    engine.sgdm(&SGDM);
    assert_eq!(engine.weights(), before);
    assert!(engine.gradients().is_empty() && graph.parameter_count() > 0);
}

#[test]
fn unknown_names_cannot_be_frozen() {
    let graph = mixed();
    for name in ["stemm", "ste", "dropout", "stem.", "", "stem.conv.weight"] {
        let options = EngineOptions { frozen: vec!["fc1".into(), name.into()], ..EngineOptions::default() };
        let refusal = Engine::new(&graph, &weights(&graph), options).err().unwrap().to_string();
        assert_eq!(refusal, format!("mixed: cannot freeze `{name}`: no node with tensors has that name"));
    }
}

#[test]
fn dropout_counts_training_passes_and_rests_in_evaluation() {
    let mut engine = engine(4, 1, &[]);
    let ([image, signal], _) = batch(4, 0);
    let mut run = |set: Option<(u64, u64)>, mode| {
        if let Some((seed, step)) = set {
            engine.set_dropout(seed, step);
        }
        (engine.forward(&[&image, &signal], 4, mode).unwrap().to_vec(), engine.dropout())
    };
    let (first, next) = run(Some((1, 0)), Mode::Train);
    assert_eq!(next, (1, 1));
    let (second, next) = run(None, Mode::Train);
    assert_eq!(next, (1, 2));
    assert_ne!(first, second, "another step drops other values");
    assert_ne!(first, run(Some((2, 0)), Mode::Train).0, "another seed too");
    assert_eq!(second, run(Some((1, 1)), Mode::Train).0);
    let (evaluated, next) = run(Some((1, 7)), Mode::Eval);
    assert_eq!(next, (1, 7), "evaluation counts nothing");
    assert_eq!(evaluated, run(Some((5, 0)), Mode::Eval).0);
}

#[test]
fn threads_do_not_change_a_bit_of_any_layer() {
    for (name, optimiser) in OPTIMISERS {
        let run = |threads| {
            let mut engine = engine(19, threads, &["left.bn"]);
            // The last batch is smaller.
            let losses: Vec<u32> = [19, 19, 7, 1]
                .iter()
                .enumerate()
                .map(|(number, &n)| {
                    let loss = pass(&mut engine, n, number as u64).to_bits();
                    engine.clip_gradients(0.5);
                    optimiser(&mut engine);
                    loss
                })
                .collect();
            (losses, left(&engine))
        };
        assert_eq!(run(1), run(2), "{name}");
        assert_eq!(run(1), run(3), "{name}");
    }
}

/// Inputs of an operation's case, `n` samples.
fn inputs(twin: &Twin, graph: &Graph, n: usize) -> Vec<f32> {
    let len = twin.inputs(graph, 500)[0].len() / twin.batch;
    twin::hashed(n * len, 500).into_iter().map(|v| v as f32).collect()
}

fn loss_of(twin: &Twin, engine: &mut Engine, n: usize) -> f32 {
    match twin.objective() {
        Loss::SoftmaxCrossEntropy => {
            let labels: Vec<u32> = (0..n).map(|i| (i % 3) as u32).collect();
            engine.backward(&labels).unwrap()
        }
        loss => {
            let values: Vec<f32> = twin::hashed(3 * n, 700).into_iter().map(|v| v.abs() as f32).collect();
            engine.backward_with(loss, Targets::Values(&values)).unwrap()
        }
    }
}

#[test]
fn operations_on_many_threads_and_in_smaller_batches() {
    for (twin, graph) in Twin::operations() {
        let run = |batch, threads, sizes: &[usize]| {
            let options = EngineOptions { batch, threads, ..EngineOptions::default() };
            let mut engine = Engine::new(&graph, &twin.weights(), options).unwrap();
            let mut losses = vec![];
            for &n in sizes {
                engine.set_dropout(0, 0);
                engine.forward(&[&inputs(&twin, &graph, n)], n, Mode::Train).unwrap();
                losses.push(loss_of(&twin, &mut engine, n));
            }
            (losses, engine.gradients())
        };
        let one = run(17, 1, &[17, 5]);
        assert_eq!(one, run(17, 2, &[17, 5]), "{}", twin.name);
        // What an earlier, larger batch left does not matter.
        let fresh = run(5, 1, &[5]);
        assert!((one.0[1] - fresh.0[0]).abs() <= 1e-5 * fresh.0[0].abs(), "{}", twin.name);
        let largest = fresh.1.iter().flat_map(|(_, t)| &t.data).fold(0.0f32, |a, v| a.max(v.abs()));
        for ((name, a), (_, b)) in one.1.iter().zip(fresh.1.iter()) {
            let gap = a.data.iter().zip(&b.data).fold(0.0f32, |gap, (a, b)| gap.max((a - b).abs()));
            assert!(gap <= 1e-5 * largest, "{}: {name}: {gap}", twin.name);
        }
    }
}

#[test]
fn nan_gives_a_nan_loss_through_every_operation() {
    for (twin, graph) in Twin::operations() {
        let mut engine =
            Engine::new(&graph, &twin.weights(), EngineOptions { batch: 3, ..EngineOptions::default() })
                .unwrap();
        let mut x = inputs(&twin, &graph, 3);
        let len = x.len() / 3;
        x[..len].fill(f32::NAN);
        engine.forward(&[&x], 3, Mode::Train).unwrap();
        assert!(loss_of(&twin, &mut engine, 3).is_nan(), "{}", twin.name);
    }
}

#[test]
fn targets_that_do_not_fit_are_refused_and_the_pass_stays_usable() {
    let mut engine = engine(3, 1, &[]);
    let ([image, signal], labels) = batch(3, 0);
    engine.forward(&[&image, &signal], 3, Mode::Train).unwrap();
    for (loss, targets, message) in [
        (Loss::SoftmaxCrossEntropy, Targets::Labels(&[0, 1]), "mixed: 2 labels for a batch of 3 samples"),
        (
            Loss::SoftmaxCrossEntropy,
            Targets::Values(&[0.0; 8]),
            "mixed: 8 target values for 3 samples of 3 outputs",
        ),
        (
            Loss::MeanSquaredError,
            Targets::Values(&[0.0; 8]),
            "mixed: 8 target values for 3 samples of 3 outputs",
        ),
        (
            Loss::MultiLabelSoftMargin,
            Targets::Labels(&[0, 1, 2]),
            "mixed: this loss needs target values, not labels",
        ),
    ] {
        assert_eq!(engine.backward_with(loss, targets).unwrap_err().to_string(), message);
    }
    engine.backward(&labels).unwrap();
    let refusal = engine.backward(&labels).unwrap_err().to_string();
    assert_eq!(refusal, "mixed: backward needs a forward pass in training", "once per pass");
}
