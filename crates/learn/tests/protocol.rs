//! How samples are divided, in which order they are trained on, and the rows of a learning curve.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod support;

use std::collections::BTreeSet;

use proptest::prelude::*;
use serde_json::json;
use support::{key, mlp, model, presses, recipe, record, run, three_folds, trainable, two_attributes};
use taxel_baselines::Method;
use taxel_data::{Dataset, Fold, Length};
use taxel_learn::{Candidate, ModelKind, Protocol, ResultsTable, Split, shuffled};

/// The folds of repetition 0 under seed 3.
fn folds(protocol: &Protocol, dataset: &Dataset) -> Vec<Fold> {
    protocol.check().unwrap();
    protocol.folds(dataset, 3, 0).unwrap()
}

fn few(per_class: &[usize], repetitions: usize) -> Protocol {
    Protocol::FewSamples { split: Split::Stratified, repetitions, test: 0.4, per_class: per_class.to_vec() }
}

#[test]
fn grouped_folds_cut_no_group_and_need_groups() {
    let dataset = presses(8, 6).with_groups(&[0, 0, 0, 0, 1, 1, 1, 1]).unwrap();
    let grouped = Protocol::group_k_fold(2);
    for fold in folds(&grouped, &dataset) {
        let groups = dataset.groups.as_ref().unwrap();
        let inside = |rows: &[usize]| rows.iter().map(|&i| groups[i]).collect::<BTreeSet<_>>();
        assert!(inside(&fold.train).is_disjoint(&inside(&fold.test)));
    }
    let without = presses(8, 6);
    let error = grouped.folds(&without, 3, 0).unwrap_err().to_string();
    assert!(error.starts_with("protocol.split = \"group\": real: presses has no groups"), "{error}");
    let leave_group_out = Protocol::LeaveGroupOut { split: Split::Stratified, repetitions: 1 };
    let error = leave_group_out.folds(&without, 3, 0).unwrap_err().to_string();
    assert!(error.starts_with("protocol.kind = \"leave-group-out\": real: presses has no groups"), "{error}");
    let official = Protocol::Official { split: Split::Stratified, repetitions: 1 };
    let error = official.folds(&without, 3, 0).unwrap_err().to_string();
    assert!(error.starts_with("protocol.kind = \"official\": real: presses has no split"), "{error}");
}

#[test]
fn the_end_of_each_group_is_tested_and_windows_across_the_cut_are_left_out() {
    let protocol = Protocol::Chronological { test: 0.25, repetitions: 1 };
    let mixed = presses(12, 6).with_groups(&[0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1]).unwrap();
    let fold = &folds(&protocol, &mixed)[0];
    // A quarter of six samples, rounded.
    assert_eq!(
        (fold.test.as_slice(), fold.train.as_slice()),
        ([8, 9, 10, 11].as_slice(), [0, 1, 2, 3, 4, 5, 6, 7].as_slice())
    );
    let mut windows = presses(12, 6);
    windows.spec.length = Some(Length::Window { to: 6, hop: Some(2) });
    let fold = &folds(&protocol, &windows)[0];
    // The two windows before the cut share time steps with the first that is tested.
    assert_eq!(
        (fold.test.as_slice(), fold.train.as_slice()),
        ([9, 10, 11].as_slice(), [0, 1, 2, 3, 4, 5, 6].as_slice())
    );
    assert_eq!(protocol.words(&windows.task()), "the last 25 % of each group");
    let one_each = presses(4, 6).with_groups(&[0, 1, 2, 3]).unwrap();
    assert!(protocol.folds(&one_each, 3, 0).unwrap_err().to_string().contains("split"));
}

#[test]
fn protocols_cut_as_they_say() {
    let mut dataset = two_attributes();
    dataset.learn_attributes(&["elasticity".to_string(), "hardness".to_string()]).unwrap();
    // Of 20 samples of a class, or of 5 of a combination of levels.
    for (dataset, sizes) in [(&two_attributes(), [42, 6, 12]), (&dataset, [36, 12, 12])] {
        let (split, repetitions) = (Split::Stratified, 1);
        let random =
            |split, test, validation| Protocol::RandomSplits { split, repetitions, test, validation };
        let cut = &folds(&random(split, 0.2, 0.1), dataset)[0];
        assert_eq!([cut.train.len(), cut.validation.len(), cut.test.len()], sizes);
        let left = folds(&Protocol::LeaveGroupOut { split, repetitions }, dataset);
        assert_eq!(left.len(), 5);
        let groups = dataset.groups.as_ref().unwrap();
        for (group, fold) in left.iter().enumerate() {
            assert!(fold.test.iter().all(|&row| groups[row] == group as u32));
        }
        let official = folds(&Protocol::Official { split, repetitions }, dataset);
        assert!(official[0].test.iter().all(|row| row % 4 == 0) && official[0].test.len() == 15);
        let grouped = &folds(&random(Split::Group, 0.4, 0.0), dataset)[0];
        assert!(grouped.test.iter().all(|&a| grouped.train.iter().all(|&b| groups[a] != groups[b])));
    }
}

#[test]
fn a_class_with_too_few_samples_goes_by_its_name() {
    let dataset = presses(45, 6);
    let few = dataset.select(&[0, 1, 2, 3, 4, 5, 6]);
    let (repetitions, split) = (1, Split::Stratified);
    for protocol in [
        Protocol::k_fold(5),
        Protocol::RandomSplits { split, repetitions, test: 0.2, validation: 0.4 },
        Protocol::FewSamples { split, repetitions, test: 0.2, per_class: vec![30] },
    ] {
        let error = protocol.folds(&few, 0, 0).unwrap_err().to_string();
        let is_named = |class: &String| error.starts_with(&format!("class {class} has "));
        assert!(few.output_names().iter().any(is_named), "{error}");
    }
}

#[test]
fn repetitions_cut_otherwise_and_the_same_again() {
    let dataset = presses(45, 6);
    let repeated = Protocol::KFold { folds: 3, split: Split::Stratified, repetitions: 2 };
    let cut = |repetition| repeated.folds(&dataset, 3, repetition).unwrap();
    assert_eq!(cut(0), cut(0));
    assert_ne!(cut(0), cut(1));
    assert_ne!(cut(0), repeated.folds(&dataset, 4, 0).unwrap());
    let candidate = Candidate::baseline(Method::Majority);
    let results = three_folds(&dataset, vec![candidate]).protocol(repeated).run().unwrap();
    let parts: Vec<_> = results.networks[0].folds.iter().map(|f| (f.repetition, f.fold)).collect();
    assert_eq!(parts, [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]);
}

#[test]
fn settings_out_of_range_are_named() {
    let (split, repetitions) = (Split::Stratified, 1);
    for (protocol, key) in [
        (Protocol::k_fold(1), "folds"),
        (Protocol::KFold { folds: 5, split, repetitions: 0 }, "repetitions"),
        (Protocol::RandomSplits { split, repetitions, test: 1.0, validation: 0.0 }, "test"),
        (Protocol::RandomSplits { split, repetitions, test: 0.2, validation: f64::NAN }, "validation"),
        (Protocol::RandomSplits { split, repetitions, test: 0.6, validation: 0.4 }, "validation"),
        (few(&[], 1), "per_class"),
        (few(&[0, 1], 1), "per_class"),
        (few(&[2, 2], 1), "per_class"),
        (Protocol::Official { split, repetitions: 2 }, "repetitions"),
        (Protocol::LeaveGroupOut { split, repetitions: 2 }, "repetitions"),
        (Protocol::Chronological { test: 0.2, repetitions: 2 }, "repetitions"),
        (Protocol::Chronological { test: 1.0, repetitions: 1 }, "test"),
    ] {
        assert_eq!(protocol.check().unwrap_err().key, key, "{protocol:?}");
        let error = three_folds(&presses(45, 6), vec![]).protocol(protocol).run().unwrap_err().to_string();
        assert!(error.starts_with(&format!("protocol.{key} = ")), "{error}");
    }
}

#[test]
fn a_learning_curve_has_a_row_per_number_of_samples() {
    let dataset = presses(45, 20);
    let candidates =
        vec![mlp(&dataset, recipe(json!({}))), Candidate::baseline(Method::NearestNeighbours { k: 1 })];
    let (_keep, folder) = run(three_folds(&dataset, candidates).protocol(few(&[1, 3], 2)));
    let results = folder.results().unwrap();
    let rows: Vec<(&str, Option<usize>)> =
        results.networks.iter().map(|n| (n.network.as_str(), n.per_class)).collect();
    assert_eq!(rows, [("mlp.n1", Some(1)), ("mlp.n3", Some(3)), ("k-nn.n1", Some(1)), ("k-nn.n3", Some(3))]);
    assert!(results.complete && results.networks.iter().all(|n| n.folds.len() == 2));
    let (one, three) = (record(&folder, &key("mlp.n1", 1, 0)), record(&folder, &key("mlp.n3", 1, 0)));
    assert_eq!((one.train_samples, three.train_samples), (3, 9));
    assert_eq!(one.index, three.index);
    assert!(ResultsTable::of(&folder).unwrap().to_string().contains("few samples per class"));
    // A model bears the name of its network, and says how many samples it has seen.
    let card = model(&folder, &key("mlp.n3", 1, 0)).card().clone();
    assert_eq!((card.name.as_str(), card.trained_on.samples), ("mlp", 9));
}

/// A network keeps its own recipe whatever others are called: `mlp.nobn` is no `mlp` with `obn` samples, nor
/// is `mlp.n5` one with five.
#[test]
fn a_name_that_looks_like_a_row_keeps_its_own_recipe() {
    let dataset = presses(45, 20);
    let named = |name: &str, changes| Candidate { name: name.into(), ..mlp(&dataset, recipe(changes)) };
    let candidates = vec![
        named("mlp", json!({ "epochs": 1 })),
        named("mlp.nobn", json!({ "epochs": 2, "loss": "mean-squared-error" })),
        named("mlp.n5", json!({ "epochs": 3, "loss": "multi-label-soft-margin" })),
    ];
    for (protocol, suffix) in [(few(&[5], 1), ".n5"), (Protocol::k_fold(2), "")] {
        let (_keep, folder) = run(three_folds(&dataset, candidates.clone()).protocol(protocol));
        for candidate in candidates.clone() {
            let row = key(&format!("{}{suffix}", candidate.name), 0, 0);
            let wanted = trainable(&candidate).recipe.for_task(&dataset.task());
            assert_eq!(record(&folder, &row).epochs.len(), wanted.epochs, "{row}");
            let card = model(&folder, &row).card().clone();
            assert_eq!(card.name, candidate.name);
            let ModelKind::Network { loss, recipe, .. } = card.kind else { panic!("a network") };
            assert_eq!((Some(loss), *recipe), (wanted.loss, wanted), "{row}");
        }
    }
    assert_eq!(recipe(json!({})).loss, None, "else all three agree");
}

#[test]
fn two_candidates_of_one_name_are_refused() {
    let dataset = presses(45, 20);
    let twice = vec![mlp(&dataset, recipe(json!({}))); 2];
    let error = three_folds(&dataset, twice).run().unwrap_err().to_string();
    assert_eq!(error, "name = \"mlp\": two candidates go by this name; give one of them another");
    let bad = Candidate { name: "../mlp".into(), ..mlp(&dataset, recipe(json!({}))) };
    let error = three_folds(&dataset, vec![bad]).run().unwrap_err().to_string();
    assert!(error.starts_with("name = \"../mlp\": must be 1 to 100 letters"), "{error}");
}

/// The order of samples is a pure function: what other epochs or folds did does not matter.
#[test]
fn batches_follow_seed_repetition_fold_and_epoch_alone() {
    let rows: Vec<usize> = (0..50).map(|i| 2 * i).collect();
    let order = |seed, repetition, fold, epoch| shuffled(&rows, seed, repetition, fold, epoch);
    assert_eq!(order(1, 2, 3, 4), order(1, 2, 3, 4));
    for other in [order(2, 2, 3, 4), order(1, 1, 3, 4), order(1, 2, 2, 4), order(1, 2, 3, 5)] {
        assert_ne!(order(1, 2, 3, 4), other);
    }
}

proptest! {
    #[test]
    fn batches_partition_the_training_set(
        count in 1usize..200, batch in 1usize..70, seed: u64, epoch in 0usize..1000,
    ) {
        let train: Vec<usize> = (0..count).map(|i| 3 * i + 1).collect();
        let order = shuffled(&train, seed, 0, 0, epoch);
        let batches: Vec<&[usize]> = order.chunks(batch).collect();
        prop_assert_eq!(batches.len(), count.div_ceil(batch));
        let mut seen = batches.concat();
        seen.sort_unstable();
        prop_assert_eq!(seen, train);
    }
}
