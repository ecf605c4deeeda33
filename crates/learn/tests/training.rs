//! Training besides its steps: choosing, stopping, freezing, several attributes, augmentation.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::collections::BTreeMap;

use ndarray::Axis;
use serde_json::{Value, json};
use support::{
    bits, change, imprints, key, mlp, model, network, presses, recipe, record, run, run_at, three_folds,
    trainable, two_attributes,
};
use taxel_baselines::Method;
use taxel_data::Dataset;
use taxel_graph::Weights;
use taxel_learn::{
    Candidate, Combination, Criterion, CrossValidation, Encoding, Problem, Protocol, Recipe, ResultsTable,
    RunFolder, Search,
};

/// Three folds of an MLP with `changes` to its recipe, on 45 presses.
fn run_tiny(changes: Value) -> (tempfile::TempDir, RunFolder) {
    let dataset = presses(45, 20);
    run(three_folds(&dataset, vec![mlp(&dataset, recipe(changes))]))
}

fn weights(folder: &RunFolder, fold: usize) -> Weights {
    model(folder, &key("mlp", 0, fold)).weights().clone()
}

#[test]
fn every_option_changes_the_training_and_nothing_is_left_unread() {
    let (_keep, plain) = run_tiny(json!({}));
    let plain = weights(&plain, 0);
    for changes in [
        json!({ "optimizer": { "name": "adam", "lr": 1e-3 } }),
        json!({ "optimizer": { "name": "adamw", "lr": 1e-3, "weight_decay": 0.1 } }),
        json!({ "optimizer": { "name": "sgdm", "weight_decay": 0.1 } }),
        json!({ "optimizer": { "name": "sgdm", "momentum": 0.5 } }),
        json!({ "schedule": { "kind": "cosine" } }),
        json!({ "schedule": { "kind": "steps", "at": [0.5] } }),
        json!({ "clip": 0.01 }),
        json!({ "label_smoothing": 0.2 }),
        json!({ "early_stopping": { "patience": 2 } }),
        json!({ "loss": "mean-squared-error" }),
        json!({ "loss": "hinge" }),
        json!({ "init": "he" }),
        json!({ "frozen": ["fc1"] }),
    ] {
        let (_keep, other) = run_tiny(changes.clone());
        assert_ne!(plain, weights(&other, 0), "{changes}");
    }
    // Adam and AdamW part where there is a penalty.
    let adam = |name: &str| {
        let optimizer = json!({ "name": name, "lr": 1e-3, "weight_decay": 0.1, "betas": [0.8, 0.9] });
        run_tiny(json!({ "optimizer": optimizer }))
    };
    let ((_a, coupled), (_b, decoupled)) = (adam("adam"), adam("adamw"));
    assert_ne!(weights(&coupled, 0), weights(&decoupled, 0));
}

#[test]
fn frozen_layers_stay_and_unknown_ones_are_named() {
    let (_a, short) = run_tiny(json!({ "frozen": ["fc1"], "epochs": 1 }));
    let (_b, long) = run_tiny(json!({ "frozen": ["fc1"] }));
    let (short, long) = (weights(&short, 0), weights(&long, 0));
    assert_eq!(short.get("fc1.weight"), long.get("fc1.weight"));
    assert_ne!(short.get("fc2.weight"), long.get("fc2.weight"));
    let dir = tempfile::tempdir().unwrap();
    let dataset = presses(45, 20);
    let frozen = mlp(&dataset, recipe(json!({ "frozen": ["fc9"] })));
    let error = run_at(three_folds(&dataset, vec![frozen]), &dir.path().join("run")).unwrap_err();
    assert!(error.to_string().starts_with("frozen = [\"fc9\"]: "), "{error}");
    assert!(error.to_string().contains("mlp: cannot freeze `fc9`"), "{error}");
    assert!(!dir.path().join("run").exists());
}

#[test]
fn too_few_samples_to_hold_some_back_name_the_key() {
    let dataset = presses(9, 20);
    let dir = tempfile::tempdir().unwrap();
    let stopping = json!({ "early_stopping": { "validation": 0.01 } });
    let error = run_at(three_folds(&dataset, vec![mlp(&dataset, recipe(stopping))]), &dir.path().join("run"));
    assert_eq!(
        error.unwrap_err().to_string(),
        "train.early_stopping.validation = 0.01: 6 training samples cannot be cut in two to hold some back; give \
         another share, record more samples or leave the table out"
    );
}

#[test]
fn samples_of_one_class_are_refused() {
    let x = ndarray::ArrayD::from_shape_fn(vec![9, 1, 5], |at| (at[0] * at[2]) as f32);
    let dataset = Dataset::new("cans", taxel_data::Layout::Series, x, &["can"; 9]).unwrap();
    let baseline = Candidate::baseline(Method::all()[0]);
    let error = three_folds(&dataset, vec![baseline]).run().unwrap_err().to_string();
    assert_eq!(error, "cans: all samples are of one class, can: nothing to tell apart");
}

#[test]
fn early_stopping_keeps_the_best_epoch_and_ends() {
    let stopping = |epochs: usize| {
        json!({
            "epochs": epochs, "optimizer": { "name": "sgdm", "lr": 0.2 },
            "early_stopping": { "patience": 3, "validation": 0.2 },
        })
    };
    let (_keep, folder) = run_tiny(stopping(60));
    let records = [0, 1, 2].map(|fold| record(&folder, &key("mlp", 0, fold)));
    for record in &records {
        let best = record.best_epoch.unwrap();
        let losses: Vec<f64> = record.epochs.iter().map(|e| e.validation_loss.unwrap()).collect();
        assert!(losses.iter().all(|loss| losses[best] <= *loss), "{losses:?}");
        assert!(record.epochs.len() == 60 || record.epochs.len() == best + 1 + 3, "{} {best}", losses.len());
        assert_eq!(record.train_samples, 30);
    }
    assert!(records.iter().any(|record| record.epochs.len() < 60));
    // The weights are the best epoch's: a run that ends there has the same ones.
    let (_keep, short) = run_tiny(stopping(records[0].best_epoch.unwrap() + 1));
    assert_eq!(weights(&folder, 0), weights(&short, 0));
}

#[test]
fn the_validation_score_of_an_epoch_is_the_primary_metric_whatever_it_stops_by() {
    let by = |name: &str| json!({ "epochs": 4, "early_stopping": { "patience": 9, "validation": 0.4, "by": name } });
    let scores = |name: &str| -> Vec<f64> {
        let (_keep, folder) = run_tiny(by(name));
        record(&folder, &key("mlp", 0, 0)).epochs.iter().map(|e| e.validation_score.unwrap()).collect()
    };
    assert_eq!(scores("brier"), scores("accuracy"));
}

/// An MLP whose folds choose among recipes that set `key` to each of `values`.
fn choosing(dataset: &Dataset, rates: &[f64], batches: &[usize]) -> Candidate {
    let mut candidate = mlp(dataset, recipe(json!({})));
    let mut grid = vec![];
    for &batch in batches {
        for &lr in rates {
            let set = [("batch_size", json!(batch)), ("optimizer.lr", json!(lr))];
            let changes = json!({ "batch_size": batch, "optimizer": { "name": "sgdm", "lr": lr } });
            let set = set.map(|(key, value)| (key.to_string(), value));
            grid.push(Combination { set: BTreeMap::from(set), recipe: recipe(changes) });
        }
    }
    change(&mut candidate, |network| {
        network.search = Some(Search { grid, validation: 0.3, by: Criterion::Loss })
    });
    candidate
}

#[test]
fn settings_are_chosen_per_fold_and_never_by_test_data() {
    let dataset = presses(45, 20);
    let candidate = choosing(&dataset, &[1e-6, 0.05], &[4, 8]);
    let grid = trainable(&candidate).search.clone().unwrap().grid;
    let (_a, folder) = run(three_folds(&dataset, vec![candidate.clone()]));
    for fold in 0..3 {
        let chosen = record(&folder, &key("mlp", 0, fold)).chosen.unwrap();
        assert_eq!(chosen.trials.len(), 4);
        let least = chosen.trials.iter().map(|t| t.loss.unwrap()).fold(f64::INFINITY, f64::min);
        let best = chosen.trials.iter().find(|t| t.loss == Some(least)).unwrap();
        assert_eq!(best.set, chosen.set);
    }
    // Spoil the test samples of fold 0: what fold 0 has chosen and trained stays the same.
    let test = Protocol::k_fold(3).folds(&dataset, 3, 0).unwrap()[0].test.clone();
    let mut spoilt = dataset.clone();
    for &row in &test {
        spoilt.x.index_axis_mut(Axis(0), row).mapv_inplace(|v| 20.0 - v);
    }
    let (_b, other) = run(three_folds(&spoilt, vec![candidate]));
    let first = key("mlp", 0, 0);
    let bytes = |folder: &RunFolder| std::fs::read(folder.model_path(&first)).unwrap();
    assert!(bytes(&folder) == bytes(&other));
    assert_eq!(record(&folder, &first).chosen, record(&other, &first).chosen);
    assert_ne!(record(&folder, &first).outcome.outputs(), record(&other, &first).outcome.outputs());
    // The chosen training is the one with its values written down, on the whole training part; the model says
    // which recipe that was.
    let chosen = record(&folder, &first).chosen.unwrap().set;
    let best = grid.iter().find(|combination| combination.set == chosen).unwrap().recipe.clone();
    let (_c, fixed) = run(three_folds(&dataset, vec![mlp(&dataset, best)]));
    assert!(bytes(&folder) == bytes(&fixed));
}

#[test]
fn a_rate_that_diverges_is_not_chosen_and_all_of_them_are_an_error() {
    let dataset = presses(45, 20);
    let (_keep, folder) = run(three_folds(&dataset, vec![choosing(&dataset, &[1e30, 0.01], &[8])]));
    let chosen = record(&folder, &key("mlp", 0, 0)).chosen.unwrap();
    assert_eq!(chosen.trials[0].loss, None);
    assert_eq!(chosen.set["optimizer.lr"].as_f64(), Some(0.01));
    let dir = tempfile::tempdir().unwrap();
    let all = three_folds(&dataset, vec![choosing(&dataset, &[1e30, 1e31], &[8])]);
    let error = run_at(all, &dir.path().join("run")).unwrap_err().to_string();
    assert!(error.starts_with("3 of 3 folds did not finish: their training diverged"), "{error}");
    assert!(error.contains("\nmlp, repetition 0, fold 0: training diverged with all 2"), "{error}");
}

/// A network that learns two attributes.
fn levels_mlp(dataset: &Dataset) -> Candidate {
    let changes = json!({
        "loss": "multi-label-soft-margin", "epochs": 60, "optimizer": { "name": "adam", "lr": 0.02 },
    });
    mlp(dataset, recipe(changes))
}

#[test]
fn several_attributes_are_learned_and_scored_level_by_level() {
    let mut dataset = two_attributes();
    dataset.learn_attributes(&["elasticity".to_string(), "hardness".to_string()]).unwrap();
    assert_eq!((dataset.output_names().len(), dataset.output_names()[4].as_str()), (7, "hardness:1"));
    let baselines = [Method::Majority, Method::SvmLinear { c: 1.0 }].map(Candidate::baseline);
    let candidates = [vec![levels_mlp(&dataset)], baselines.to_vec()].concat();
    let (_keep, folder) = run(three_folds(&dataset, candidates));
    let results = folder.results().unwrap();
    assert_eq!(results.task.attributes()[1].name, "hardness");
    let mlp = &results.networks[0];
    assert!(mlp.score("accuracy").unwrap() > 90.0, "{:?}", mlp.mean);
    assert_eq!((mlp.attributes.len(), mlp.attributes[1].per_level.len()), (2, 4));
    assert!(mlp.attributes[0].mean_absolute_error < 0.2 && mlp.confusion.is_none());
    let majority = &results.networks[1];
    assert!(majority.score("accuracy").unwrap() < 50.0 && majority.attributes[0].mean_absolute_error > 0.5);
    assert!(results.networks[2].score("accuracy").unwrap() > 90.0);
    let record = record(&folder, &key("mlp", 0, 0));
    assert_eq!(
        (record.outcome.labels().0.len(), record.outcome.outputs().len()),
        (2 * record.index.len(), 7 * record.index.len())
    );
    let text = ResultsTable::of(&folder).unwrap().to_string();
    assert!(text.contains("hardness off by"), "{text}");
    // Splits are even over the combinations of levels.
    for fold in Protocol::k_fold(3).folds(&dataset, 3, 0).unwrap() {
        let mut seen: Vec<u32> = fold.test.iter().map(|&row| dataset.strata().to_vec()[row]).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 12);
    }
}

/// Levels that are learned by cumulative logits: as right, and never an answer whose probabilities do not add up to 1.
#[test]
fn ordered_levels_are_learned_by_cumulative_logits() {
    let mut dataset = two_attributes();
    dataset.learn_attributes(&["elasticity".to_string(), "hardness".to_string()]).unwrap();
    let ordered =
        json!({ "loss": "cumulative-logits", "epochs": 60, "optimizer": { "name": "adam", "lr": 0.02 } });
    let (_keep, folder) = run(three_folds(&dataset, vec![mlp(&dataset, recipe(ordered))]));
    let results = folder.results().unwrap();
    let score = |name: &str| results.networks[0].score(name).unwrap();
    assert!(score("accuracy") > 90.0 && score("within_one_level") > 95.0 && score("level_error") < 0.2);
    let last = record(&folder, &key("mlp", 0, 1));
    let train_score = last.epochs.last().unwrap().train_score;
    assert!(train_score > 90.0, "{train_score}: the score of the training samples is that of their levels");
    for row in last.outcome.outputs().chunks(7) {
        let sums = [row[..3].iter().sum::<f32>(), row[3..].iter().sum()];
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-5), "{sums:?}");
    }
    let predictions =
        model(&folder, &key("mlp", 0, 1)).predict(&dataset.x.select(Axis(0), &last.index)).unwrap();
    assert_eq!(bits(&predictions.outputs), bits(last.outcome.outputs()));
}

#[test]
fn cumulative_logits_need_classes_in_an_order() {
    let refusal = |dataset: &Dataset| {
        let candidate = mlp(dataset, recipe(json!({ "loss": "cumulative-logits", "epochs": 1 })));
        let dir = tempfile::tempdir().unwrap();
        let run = run_at(three_folds(dataset, vec![candidate]), &dir.path().join("run"));
        run.err().map(|error| error.to_string())
    };
    let mut presses = presses(45, 20);
    let error = refusal(&presses).unwrap();
    assert!(error.contains("needs classes in an order") && error.contains("medium, soft, stiff"), "{error}");
    presses.keep_classes(&["stiff".to_string(), "medium".to_string(), "soft".to_string()]).unwrap();
    assert_eq!(refusal(&presses), None, "an order that was asked for");
}

/// Both attributes of new samples, from the file alone: of the network and of a baseline.
#[test]
fn a_model_of_several_attributes_answers_each() {
    let mut dataset = two_attributes();
    dataset.learn_attributes(&["elasticity".to_string(), "hardness".to_string()]).unwrap();
    let svm = Candidate::baseline(Method::SvmLinear { c: 1.0 });
    let (_keep, folder) = run(three_folds(&dataset, vec![levels_mlp(&dataset), svm]));
    for name in ["mlp", "svm-linear"] {
        let record = record(&folder, &key(name, 0, 1));
        let predictions = model(&folder, &key(name, 0, 1)).predict(&dataset.x.select(Axis(0), &record.index));
        let predictions = predictions.unwrap();
        assert_eq!(bits(&predictions.outputs), bits(record.outcome.outputs()), "{name}");
        assert_eq!((predictions.len(), predictions.width()), (20, 7));
        assert_eq!(predictions.labels, record.outcome.labels().1, "{name}");
        let mut right = 0;
        for (i, truth) in record.outcome.labels().0.chunks(2).enumerate() {
            let [elasticity, hardness] = predictions.predicted(i)[..] else { panic!("two predictions") };
            assert_eq!((elasticity.attribute, hardness.attribute), ("elasticity", "hardness"));
            right += usize::from(elasticity.class == truth[0].to_string());
            right += usize::from(hardness.class == truth[1].to_string());
            let at = 7 * i + 3 + record.outcome.labels().1[2 * i + 1] as usize;
            assert_eq!(hardness.probability.to_bits(), record.outcome.outputs()[at].to_bits());
        }
        assert!(right > 36, "{name}: {right} of 40");
    }
}

/// A recipe out of place is refused before anything is trained, not trained on something else.
#[test]
fn recipes_that_do_not_fit_the_samples_are_refused() {
    let refusal = |dataset: &Dataset, candidate: Candidate| {
        let dir = tempfile::tempdir().unwrap();
        let error = run_at(three_folds(dataset, vec![candidate]), &dir.path().join("run")).unwrap_err();
        assert!(!dir.path().join("run").exists());
        error.to_string()
    };
    let mut levels = two_attributes();
    levels.learn_attributes(&["elasticity".to_string(), "hardness".to_string()]).unwrap();
    let error = refusal(&levels, mlp(&levels, recipe(json!({ "loss": "softmax-cross-entropy" }))));
    assert!(error.starts_with("loss = \"softmax-cross-entropy\": several attributes need"), "{error}");
    let dataset = presses(45, 20);
    let error = refusal(&dataset, mlp(&dataset, recipe(json!({ "augment": { "flip_rows": true } }))));
    assert!(error.starts_with("augment = ") && error.contains("moves pixels"), "{error}");
    let error = refusal(&dataset, mlp(&two_attributes(), recipe(json!({}))));
    assert!(error.starts_with("mlp reads `signal`: it takes "), "{error}");
    let mut two = presses(45, 20);
    two.keep_classes(&["soft".to_string(), "stiff".to_string()]).unwrap();
    let error = refusal(&dataset, mlp(&two, recipe(json!({}))));
    assert_eq!(error, "mlp answers with 2 numbers; the targets and the loss need 3");
    let error = refusal(&dataset, mlp(&dataset, recipe(json!({ "epochs": 0 }))));
    assert_eq!(error, "epochs = 0: must be in 1..=100000");
}

#[test]
fn augmentation_moves_training_images_alone() {
    let dataset = imprints(36, 14);
    let encoding: Encoding = serde_json::from_value(json!({ "image": { "kind": "raw" } })).unwrap();
    let go = |changes: Value| {
        let mut settings = json!({ "epochs": 2, "optimizer": { "name": "sgdm", "lr": 1e-3 } });
        settings.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        let mut validation =
            CrossValidation::new(&dataset).protocol(Protocol::k_fold(2)).encoding(encoding.clone());
        let candidate = network("resnet8-lite-2d", json!({}), recipe(settings), validation.encoder());
        let (_keep, folder) = run(validation.candidate(candidate));
        record(&folder, &key("resnet8-lite-2d", 0, 0))
    };
    let augment = json!({ "flip_rows": true, "flip_columns": true, "shift": 3.0, "rotate": 10.0 });
    let moves = || json!({ "augment": augment });
    let (plain, moved, again) = (go(json!({})), go(moves()), go(moves()));
    assert_ne!(plain.epochs[0].train_loss, moved.epochs[0].train_loss);
    assert_eq!(moved.epochs, again.epochs);
    // Without training the test images are the same ones: a rate of almost 0 leaves the same predictions.
    let tiny_steps = json!({ "name": "sgdm", "lr": 1e-30 });
    let turned = go(json!({ "optimizer": tiny_steps, "augment": augment, "batch_norm": "population" }));
    let unturned = go(json!({ "optimizer": tiny_steps }));
    assert_ne!(unturned.epochs[1].train_loss, turned.epochs[1].train_loss);
    assert_eq!(unturned.outcome.outputs(), turned.outcome.outputs());
}

/// Every key changes the training and no test sample; raw samples are encoded again.
#[test]
fn augmentation_changes_training_readings_alone() {
    let dataset = presses(36, 20);
    let go = |changes: Value| {
        let mut settings = json!({ "epochs": 2, "optimizer": { "name": "sgdm", "lr": 1e-30 } });
        settings.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        let validation = CrossValidation::new(&dataset).protocol(Protocol::k_fold(2));
        let (_keep, folder) = run(validation.candidate(mlp(&dataset, recipe(settings))));
        record(&folder, &key("mlp", 0, 0))
    };
    let plain = go(json!({}));
    let changes = [
        json!({ "gain": [0.5, 2.0] }),
        json!({ "jitter": 0.1 }),
        json!({ "time_shift": 0.3 }),
        json!({ "time_warp": [0.5, 2.0] }),
    ];
    for change in changes {
        let (changed, again) = (go(json!({ "augment": change })), go(json!({ "augment": change })));
        assert_ne!(plain.epochs[1].train_loss, changed.epochs[1].train_loss, "{change}");
        assert_eq!(changed.epochs, again.epochs, "{change}");
        assert_eq!(plain.outcome.outputs(), changed.outcome.outputs(), "{change}");
    }
}

/// Kept or renewed as the recipe says; weight and bias of frozen batch norms stay either way.
#[test]
fn frozen_statistics_are_kept_or_renewed() {
    let dataset = imprints(36, 14);
    let encoding: Encoding = serde_json::from_value(json!({ "image": { "kind": "raw" } })).unwrap();
    let stem = |changes: Value| {
        let mut settings = json!({ "epochs": 2, "frozen": ["stem"] });
        settings.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        let mut validation =
            CrossValidation::new(&dataset).protocol(Protocol::k_fold(2)).encoding(encoding.clone());
        let candidate = network("resnet8-lite-2d", json!({}), recipe(settings), validation.encoder());
        let (_keep, folder) = run(validation.candidate(candidate));
        let model = model(&folder, &key("resnet8-lite-2d", 0, 0));
        ["weight", "bias", "running_mean", "running_var"]
            .map(|name| model.weights().get(&format!("stem.bn.{name}")).unwrap().data.clone())
    };
    let [weight, bias, mean, var] = stem(json!({}));
    assert!(mean.iter().all(|&v| v == 0.0) && var.iter().all(|&v| v == 1.0), "as at the start");
    let renewed = ["population", "moving"].map(|kind| {
        let tensors = stem(json!({ "frozen_statistics": "renewed", "batch_norm": kind }));
        assert_eq!([&tensors[0], &tensors[1]], [&weight, &bias]);
        tensors[2].clone()
    });
    assert!(renewed[0] != mean && renewed[1] != mean && renewed[0] != renewed[1], "{renewed:?}");
}

/// Features of a frozen body are made once; an augmentation that moves nothing has every pass make them anew.
#[test]
fn a_frozen_body_is_asked_once_and_nothing_else_changes() {
    let encoding: Encoding = serde_json::from_value(json!({ "image": { "kind": "raw" } })).unwrap();
    for (name, set, frozen) in [
        ("resnet8-lite-2d", json!({}), json!(["stem", "identity1"])),
        ("resnet8-lite-2d", json!({}), json!(["stem", "identity1", "downsample", "identity2"])),
        ("tactnet6", json!({}), json!(["convs"])),
        ("mobilenet-v2", json!({ "width_mult": 0.25 }), json!(["features"])),
        ("alexnet", json!({ "hidden": 8, "dropout": 0.0 }), json!(["features", "classifier.1"])),
    ] {
        let dataset = imprints(36, if name == "alexnet" { 63 } else { 33 });
        let go = |changes: Value| {
            let mut settings = json!({ "epochs": 2, "batch_size": 5, "frozen": frozen });
            settings.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
            let mut validation =
                CrossValidation::new(&dataset).protocol(Protocol::k_fold(2)).encoding(encoding.clone());
            let candidate = network(name, set.clone(), recipe(settings), validation.encoder());
            let (_keep, folder) = run(validation.candidate(candidate));
            let models: Vec<Weights> =
                (0..2).map(|fold| model(&folder, &key(name, 0, fold)).weights().clone()).collect();
            let records: Vec<_> = (0..2).map(|fold| record(&folder, &key(name, 0, fold))).collect();
            (models, records)
        };
        for stopping in [json!({}), json!({ "early_stopping": { "patience": 1 } })] {
            let whole = {
                let mut stopping = stopping.clone();
                stopping["augment"] = json!({ "shift": 0.0 });
                go(stopping)
            };
            let (models, records) = go(stopping);
            assert!(models == whole.0, "{name}: {frozen}");
            for (one, other) in records.iter().zip(&whole.1) {
                assert_eq!(one.epochs, other.epochs, "{name}: {frozen}");
                assert_eq!(one.outcome.outputs(), other.outcome.outputs());
                assert_eq!(one.other_statistics, other.other_statistics);
            }
        }
    }
}

#[test]
fn baselines_follow_the_seed_and_say_what_they_cost() {
    let dataset = presses(45, 20);
    let methods = [
        Method::Majority,
        Method::NearestNeighbours { k: 3 },
        Method::MiniRocket { features: 168 },
        Method::SvmLinear { c: 1.0 },
        Method::SvmRbf { c: 1.0 },
    ];
    let go = || run(three_folds(&dataset, methods.map(Candidate::baseline).to_vec()));
    let ((_a, folder), (_b, again)) = (go(), go());
    let results = folder.results().unwrap();
    let of = |name: &str| results.networks.iter().find(|n| n.network == name).unwrap();
    let score = |name: &str| of(name).score("accuracy").unwrap();
    assert!((score("majority") - 100.0 / 3.0).abs() <= 1e-9);
    for name in ["k-nn", "mini-rocket", "svm-linear", "svm-rbf"] {
        assert!(score(name) > 50.0, "{name}: {}", score(name));
    }
    let rocket = of("mini-rocket");
    assert!(rocket.costs.parameters > 168 && rocket.costs.macs > 0 && rocket.interval.is_some());
    let nearest = key("k-nn", 0, 0);
    assert!(folder.model_path(&nearest).is_file());
    assert!(folder.timing(&nearest).unwrap().unwrap().latency.is_some());
    let bytes = |folder: &RunFolder| std::fs::read(folder.file("results.json")).unwrap();
    assert!(bytes(&folder) == bytes(&again));
}

#[test]
fn look_alikes_need_every_class_once() {
    let dataset = presses(45, 20);
    let with = |groups: &[(&str, &[&str])]| {
        let look_alikes = groups.iter().map(|(name, classes)| {
            (name.to_string(), classes.iter().map(|class| class.to_string()).collect())
        });
        let mut validation = three_folds(&dataset, vec![Candidate::baseline(Method::Majority)]);
        validation.look_alikes = look_alikes.collect();
        validation.run()
    };
    let results = with(&[("give", &["soft", "medium"]), ("rigid", &["stiff"])]).unwrap();
    let alikes = results.networks[0].look_alikes.clone().unwrap();
    assert_eq!(alikes.groups, ["give", "rigid"]);
    assert_eq!(alikes.confusion.counts().iter().flatten().sum::<u64>(), 45);
    let error = with(&[("give", &["soft"])]).unwrap_err().to_string();
    assert!(error.contains("\"medium\": must be in exactly one group"), "{error}");
    let error = with(&[("give", &["soft", "medium", "stiff"]), ("rigid", &["stiff"])]).unwrap_err();
    assert!(error.to_string().contains("\"stiff\": must be in exactly one group"), "{error}");
}

#[test]
fn few_samples_get_smaller_batches_and_more_epochs() {
    let short = recipe(json!({ "epochs": 80, "batch_size": 64, "least_steps": 800, "least_batches": 4 }));
    let of = |samples: usize| {
        let recipe = short.for_samples(samples);
        (recipe.batch_size, recipe.epochs)
    };
    // min(64, max(8, n div 4)); at least 800 steps.
    assert_eq!(of(10_000), (64, 80));
    assert_eq!(of(640), (64, 80));
    assert_eq!(of(639), (64, 80));
    assert_eq!(of(576), (64, 89));
    assert_eq!(of(100), (25, 200));
    assert_eq!(of(9), (8, 400));
    assert_eq!(of(1), (8, 800));
    let plain = recipe(json!({}));
    assert_eq!(plain.for_samples(5), plain);
}

#[test]
fn a_training_takes_the_least_steps_and_warms_up() {
    let dataset = presses(12, 6);
    let short = recipe(json!({ "batch_size": 64, "least_steps": 24, "least_batches": 4, "warm_up": 0.5,
        "optimizer": { "name": "adamw", "lr": 0.01, "weight_decay": 0.05, "decay": "matrices" } }));
    let run = run(three_folds(&dataset, vec![mlp(&dataset, short)]));
    let epochs = record(&run.1, &key("mlp", 0, 0)).epochs;
    // Eight samples in one batch of eight: an epoch per step.
    assert_eq!(epochs.len(), 24);
    let rates: Vec<f64> = epochs.iter().map(|epoch| epoch.lr).collect();
    assert!((rates[0] - 0.01 / 12.0).abs() <= 1e-12 && rates[11] == 0.01 && rates[23] == 0.01, "{rates:?}");
}

/// Files say what they said before there were these settings.
#[test]
fn what_is_not_set_is_not_written() {
    let written = serde_json::to_value(Recipe::default()).unwrap();
    for key in ["least_steps", "least_batches", "warm_up"] {
        assert!(written.get(key).is_none(), "{key}");
    }
    assert!(written["optimizer"].get("decay").is_none());
}

#[test]
fn settings_out_of_range_are_named() {
    let refusal = |changes: Value| recipe(changes).check().unwrap_err();
    let problem = |key: &str, value: &str, reason: &str| Problem::new(key, value, reason);
    assert_eq!(refusal(json!({ "epochs": 0 })), problem("epochs", "0", "must be in 1..=100000"));
    for (changes, key) in [
        (json!({ "batch_size": 0 }), "batch_size"),
        (json!({ "optimizer": { "name": "adam", "betas": [0.9, 1.0] } }), "optimizer.betas"),
        (json!({ "optimizer": { "name": "adamw", "eps": 0.0 } }), "optimizer.eps"),
        (json!({ "optimizer": { "name": "sgdm", "momentum": 1.0 } }), "optimizer.momentum"),
        (json!({ "schedule": { "kind": "steps", "at": [0.6, 0.5] } }), "schedule.at"),
        (json!({ "schedule": { "kind": "steps", "at": [0.5], "factor": 2.0 } }), "schedule.factor"),
        (json!({ "schedule": { "kind": "cosine", "floor": 1.0 } }), "schedule.floor"),
        (json!({ "least_steps": 0 }), "least_steps"),
        (json!({ "least_batches": 0 }), "least_batches"),
        (json!({ "warm_up": 1.0 }), "warm_up"),
        (json!({ "clip": 0.0 }), "clip"),
        (json!({ "label_smoothing": 1.0 }), "label_smoothing"),
        (json!({ "early_stopping": { "patience": 0 } }), "early_stopping.patience"),
        (json!({ "early_stopping": { "validation": 1.0 } }), "early_stopping.validation"),
        (json!({ "early_stopping": { "by": "acuracy" } }), "early_stopping.by"),
        (json!({ "augment": { "shift": -1.0 } }), "augment.shift"),
        (json!({ "loss": "mean-squared-error", "label_smoothing": 0.1 }), "label_smoothing"),
        (json!({ "loss": "mean-squared-error", "class_weights": "balanced" }), "class_weights"),
    ] {
        assert_eq!(refusal(changes.clone()).key, key, "{changes}");
    }
    // NaN is in no range, and nothing of JSON is NaN.
    let nan = |recipe: Recipe| recipe.check().unwrap_err().key;
    assert_eq!(nan(Recipe { clip: Some(f64::NAN), ..Recipe::default() }), "clip");
    assert_eq!(nan(Recipe { label_smoothing: f64::NAN, ..Recipe::default() }), "label_smoothing");
}
