//! Properties of folds.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use taxel_data::{
    Fold, Shares, few_per_class, group_k_fold, hold_back, random_group_split, random_split, stratified_k_fold,
};

fn is_partition(folds: &[Fold], n: usize) -> bool {
    let mut tested: Vec<usize> = folds.iter().flat_map(|fold| fold.test.clone()).collect();
    tested.sort_unstable();
    let complete = |fold: &Fold| {
        let both: BTreeSet<usize> = fold.train.iter().chain(&fold.test).copied().collect();
        fold.train.is_sorted()
            && fold.test.is_sorted()
            && !fold.test.is_empty()
            && both.len() == n
            && fold.train.len() + fold.test.len() == n
    };
    tested == (0..n).collect::<Vec<_>>() && folds.iter().all(complete)
}

/// Whether every unit is tested in one fold.
fn is_whole(folds: &[Fold], units: &[u32]) -> bool {
    let mut fold_of = BTreeMap::new();
    folds
        .iter()
        .enumerate()
        .all(|(i, fold)| fold.test.iter().all(|sample| *fold_of.entry(units[*sample]).or_insert(i) == i))
}

fn class_counts(fold: &Fold, y: &[u32]) -> BTreeMap<u32, usize> {
    let mut counts = BTreeMap::new();
    fold.test.iter().for_each(|sample| *counts.entry(y[*sample]).or_default() += 1);
    counts
}

/// Most minus fewest.
fn spread(counts: impl Iterator<Item = usize> + Clone) -> usize {
    counts.clone().max().unwrap() - counts.min().unwrap()
}

/// Labels of 2 to 6 classes of 5 to 20 samples, shuffled.
fn labels() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(5usize..20, 2..6)
        .prop_map(|sizes| {
            sizes.iter().enumerate().flat_map(|(label, n)| vec![label as u32; *n]).collect::<Vec<_>>()
        })
        .prop_shuffle()
}

/// Groups of 2 to 9, at least `k` of them; a label per sample.
fn grouped() -> impl Strategy<Value = (Vec<u32>, Vec<u32>)> {
    prop::collection::vec(2usize..9, 6..20).prop_flat_map(|sizes| {
        let groups: Vec<u32> =
            sizes.iter().enumerate().flat_map(|(group, n)| vec![3 * group as u32; *n]).collect();
        let n = groups.len();
        (Just(groups).prop_shuffle(), prop::collection::vec(0u32..4, n))
    })
}

proptest! {
    #[test]
    fn stratified_folds_are_even(y in labels(), k in 2usize..=5, seed: u64, repetition in 0u32..9) {
        let folds = stratified_k_fold(&y, k, seed, repetition, None).unwrap();
        prop_assert_eq!(folds.len(), k);
        prop_assert!(is_partition(&folds, y.len()));
        prop_assert!(spread(folds.iter().map(|fold| fold.test.len())) <= 1);
        let counts: Vec<_> = folds.iter().map(|fold| class_counts(fold, &y)).collect();
        for label in y.iter().collect::<BTreeSet<_>>() {
            prop_assert!(spread(counts.iter().map(|c| c.get(label).copied().unwrap_or(0))) <= 1);
        }
        prop_assert_eq!(stratified_k_fold(&y, k, seed, repetition, None).unwrap(), folds);
    }

    #[test]
    fn copies_stay_together(y in labels(), k in 2usize..=4, seed: u64, copies in prop::collection::vec((0usize..999, 0usize..999), 0..8)) {
        let mut units: Vec<u32> = (0..y.len() as u32).collect();
        for (a, b) in copies {
            let (a, b) = (a % y.len(), b % y.len());
            units[b] = units[a];
        }
        match stratified_k_fold(&y, k, seed, 0, Some(&units)) {
            Ok(folds) => {
                let n = y.len();
                let mut tested: Vec<usize> = folds.iter().flat_map(|fold| fold.test.clone()).collect();
                tested.sort_unstable();
                prop_assert_eq!(tested, (0..n).collect::<Vec<_>>());
                prop_assert!(is_whole(&folds, &units));
                prop_assert!(folds.iter().all(|fold| fold.train.len() + fold.test.len() == n));
            }
            Err(error) => prop_assert!(error.to_string().contains("distinct samples, too few")),
        }
    }

    #[test]
    fn groups_stay_whole((groups, y) in grouped(), k in 2usize..=6, seed: u64, repetition in 0u32..9) {
        let folds = group_k_fold(&groups, &y, k, seed, repetition).unwrap();
        prop_assert_eq!(folds.len(), k);
        prop_assert!(is_partition(&folds, y.len()));
        prop_assert!(is_whole(&folds, &groups));
        // Dealt evenly: no fold is a whole largest group and more above another, twice over.
        prop_assert!(spread(folds.iter().map(|fold| fold.test.len())) <= 16);
        prop_assert_eq!(group_k_fold(&groups, &y, k, seed, repetition).unwrap(), folds);
    }
}

#[test]
fn as_many_groups_as_folds_leave_one_out_in_order() {
    let groups = [7, 3, 7, 9, 3];
    let y = [0, 0, 1, 1, 1];
    let folds = group_k_fold(&groups, &y, 3, 1, 0).unwrap();
    assert_eq!(folds, group_k_fold(&groups, &y, 3, 2, 5).unwrap());
    let tests: Vec<_> = folds.iter().map(|fold| fold.test.clone()).collect();
    assert_eq!(tests, [vec![1, 4], vec![0, 2], vec![3]]);
}

#[test]
fn copies_are_spread_class_by_class() {
    // Four pairs of copies in each of three classes: each of two folds gets two of each.
    let y: Vec<u32> = (0..24).map(|i| i / 8).collect();
    let pairs: Vec<u32> = (0..24).map(|i| i / 2).collect();
    for seed in 0..20 {
        for fold in stratified_k_fold(&y, 2, seed, 0, Some(&pairs)).unwrap() {
            assert_eq!(class_counts(&fold, &y).into_values().collect::<Vec<_>>(), [4; 3]);
        }
    }
}

#[test]
fn groups_of_each_class_are_spread() {
    // Twelve objects, two of each of six classes: each of two folds gets one of each.
    let groups: Vec<u32> = (0..120).map(|i| i / 10).collect();
    let y: Vec<u32> = groups.iter().map(|group| group / 2).collect();
    for seed in 0..20 {
        for fold in group_k_fold(&groups, &y, 2, seed, 0).unwrap() {
            assert_eq!(class_counts(&fold, &y).into_values().collect::<Vec<_>>(), [10; 6]);
        }
    }
}

/// Labels and groups of recordings: of each group its labels with how many samples have them.
fn recordings(groups: &[&[(u32, usize)]]) -> (Vec<u32>, Vec<u32>) {
    let samples = groups.iter().enumerate().flat_map(|(group, labels)| {
        labels.iter().flat_map(move |&(label, n)| std::iter::repeat_n((group as u32, label), n))
    });
    samples.unzip()
}

/// The groups that rows belong to, ascending.
fn groups_of(rows: &[usize], groups: &[u32]) -> Vec<u32> {
    rows.iter().map(|&row| groups[row]).collect::<BTreeSet<_>>().into_iter().collect()
}

#[test]
fn a_group_goes_where_the_shares_of_its_classes_grow_least() {
    // Group 2 joins 0 or 1; `group_k_fold` says by which cost, worked out by hand below.
    let cases: [[&[(u32, usize)]; 3]; 3] = [
        // A rare class weighs as much as a common one: 300/3600 against 200/3600 + 2/9.
        [&[(0, 30)], &[(0, 20), (1, 2)], &[(0, 10), (1, 1)]],
        // A class weighs by its samples in the group: 20/576 against 90/361 + 3/576.
        [&[(1, 20)], &[(0, 10), (1, 3)], &[(0, 9), (1, 1)]],
        // Size counts beside the classes: 6/121 + 140/2116 against 4/121 + 220/2116.
        [&[(0, 6), (2, 8)], &[(0, 4), (3, 18)], &[(0, 1), (1, 9)]],
    ];
    for case in cases {
        let (groups, y) = recordings(&case);
        for seed in 0..8 {
            let folds = group_k_fold(&groups, &y, 2, seed, 0).unwrap();
            let mut tested = folds.iter().map(|fold| groups_of(&fold.test, &groups)).collect::<Vec<_>>();
            tested.sort();
            assert_eq!(tested, [vec![0, 2], vec![1]], "{case:?}");
        }
    }
}

#[test]
fn a_group_goes_to_the_part_that_lacks_most_of_its_samples() {
    // Group 2 lacks four samples of class 0 in the test part and one of class 1 in the training part.
    let (groups, y) = recordings(&[&[(0, 8)], &[(0, 1), (1, 6)], &[(0, 4), (1, 1)]]);
    let fold = random_group_split(&groups, &y, Shares { test: 0.5, validation: 0.0 }, 0, 0).unwrap();
    assert_eq!(groups_of(&fold.train, &groups), [0]);
    assert_eq!(groups_of(&fold.test, &groups), [1, 2]);
}

#[test]
fn a_part_that_was_asked_for_is_never_empty() {
    let (groups, y) = recordings(&[&[(0, 5)], &[(0, 4)]]);
    let shares = Shares { test: 0.35, validation: 0.25 };
    let error = random_group_split(&groups, &y, shares, 0, 0).unwrap_err().to_string();
    assert!(error.starts_with("there are too few groups to fill the validation part"), "{error}");
}

#[test]
fn seed_and_repetition_choose_the_folds() {
    let y: Vec<u32> = (0..60).map(|i| i % 3).collect();
    let groups: Vec<u32> = (0..60).map(|i| i / 3).collect();
    let stratified = |seed, repetition| stratified_k_fold(&y, 5, seed, repetition, None).unwrap();
    let grouped = |seed, repetition| group_k_fold(&groups, &y, 5, seed, repetition).unwrap();
    assert_ne!(stratified(0, 0), stratified(1, 0));
    assert_ne!(stratified(0, 0), stratified(0, 1));
    assert_ne!(grouped(0, 0), grouped(1, 0));
    assert_ne!(grouped(0, 0), grouped(0, 1));
}

#[test]
fn impossible_splits_are_refused() {
    let message = |result: taxel_data::Result<Vec<Fold>>| result.unwrap_err().to_string();
    let y = [0, 0, 1, 1, 1];
    assert_eq!(
        message(stratified_k_fold(&y, 3, 0, 0, None)),
        "class 0 has 2 distinct samples, too few for 3 folds; use at most 2 folds or record more"
    );
    assert_eq!(
        message(stratified_k_fold(&y, 2, 0, 0, Some(&[5, 5, 1, 2, 3]))),
        "class 0 has 1 distinct sample, too few for 2 folds; record more, or leave the class out"
    );
    for k in [0, 1] {
        let want = format!("folds = {k}: at least 2 are needed, one to test on and one to train on");
        assert_eq!(message(stratified_k_fold(&y, k, 0, 0, None)), want);
        assert_eq!(message(group_k_fold(&[0; 5], &y, k, 0, 0)), want);
    }
    assert_eq!(
        message(group_k_fold(&[0, 0, 1, 1, 2], &y, 4, 0, 0)),
        "3 groups cannot fill 4 folds; use at most 3 folds"
    );
    assert_eq!(
        message(group_k_fold(&[4; 5], &y, 2, 0, 0)),
        "1 group cannot fill 2 folds; split by samples instead"
    );
    assert!(message(stratified_k_fold(&y, usize::MAX, 0, 0, None)).starts_with("class 0 has 2"));
    assert_eq!(message(stratified_k_fold(&[], 2, 0, 0, None)), "there are no samples to split");
    assert_eq!(
        message(group_k_fold(&[0, 1], &y, 2, 0, 0)),
        "groups has 2 entries for 5 labels; one per sample"
    );
    assert_eq!(
        message(stratified_k_fold(&y, 2, 0, 0, Some(&[0]))),
        "units has 1 entries for 5 labels; one per sample"
    );
}

/// 4 classes of 60, 30, 30 and 12.
fn uneven() -> Vec<u32> {
    [60, 30, 30, 12].iter().enumerate().flat_map(|(class, n)| vec![class as u32; *n]).collect()
}

fn of_class(rows: &[usize], y: &[u32], class: u32) -> usize {
    rows.iter().filter(|&&row| y[row] == class).count()
}

#[test]
fn random_splits_hold_the_share_of_every_class() {
    let y = uneven();
    let shares = Shares { test: 0.1, validation: 0.1 };
    let fold = random_split(&y, shares, 3, 0, None).unwrap();
    assert!([&fold.train, &fold.validation, &fold.test].iter().all(|part| part.is_sorted()));
    let mut all = [fold.train.clone(), fold.validation.clone(), fold.test.clone()].concat();
    all.sort_unstable();
    assert_eq!(all, (0..y.len()).collect::<Vec<_>>());
    for (class, [train, validation, test]) in [(0, [48, 6, 6]), (1, [24, 3, 3]), (2, [24, 3, 3])] {
        let got = [&fold.train, &fold.validation, &fold.test].map(|part| of_class(part, &y, class));
        assert_eq!(got, [train, validation, test], "class {class}");
    }
    assert_eq!(random_split(&y, shares, 3, 0, None).unwrap(), fold);
    assert_ne!(random_split(&y, shares, 3, 1, None).unwrap(), fold);
    assert_ne!(random_split(&y, shares, 4, 0, None).unwrap(), fold);
    let no_validation = random_split(&y, Shares { test: 0.25, validation: 0.0 }, 3, 0, None).unwrap();
    // 15, 7, 7 and 3: halves are rounded.
    assert_eq!((no_validation.test.len(), no_validation.validation.len()), (32, 0));
    // 3 samples cannot be in three parts of 80, 10 and 10 %.
    let tiny = [vec![0; 20], vec![1; 3]].concat();
    let error = random_split(&tiny, shares, 0, 0, None).unwrap_err().to_string();
    assert!(error.starts_with("class 1 has too few samples to be in the "), "{error}");
}

#[test]
fn random_splits_tear_no_unit_and_no_group() {
    let y = uneven();
    let groups: Vec<u32> = (0..y.len() as u32).map(|i| i % 11).collect();
    for repetition in 0..5 {
        let shares = Shares { test: 0.2, validation: 0.2 };
        let fold = random_group_split(&groups, &y, shares, 0, repetition).unwrap();
        for group in 0..11 {
            let parts = [&fold.train, &fold.validation, &fold.test];
            let holds = parts.iter().filter(|part| part.iter().any(|&row| groups[row] == group)).count();
            assert_eq!(holds, 1, "group {group}");
        }
        assert!(fold.test.len().abs_diff(26) <= 12, "{}", fold.test.len());
        let copies: Vec<u32> = (0..y.len() as u32).map(|i| i / 2).collect();
        let fold = random_split(&y, shares, 0, repetition, Some(&copies)).unwrap();
        assert!(fold.test.iter().all(|&row| fold.test.contains(&(row ^ 1))));
    }
    let shares = Shares { test: 0.3, validation: 0.3 };
    let error = random_group_split(&[0; 132], &y, shares, 0, 0).unwrap_err().to_string();
    assert!(error.contains("too few groups"), "{error}");
}

#[test]
fn what_is_held_back_is_even_and_apart() {
    let y = uneven();
    let rows: Vec<usize> = (0..y.len()).filter(|row| row % 3 != 0).collect();
    let (left, taken) = hold_back(&rows, &y, None, 0.25, 1, "inner").unwrap();
    let mut both = [left.clone(), taken.clone()].concat();
    both.sort_unstable();
    assert_eq!(both, rows);
    assert_eq!([0, 1, 3].map(|class| of_class(&taken, &y, class)), [10, 5, 2]);
    let groups: Vec<u32> = (0..y.len() as u32).map(|i| i / 4).collect();
    let (left, taken) = hold_back(&rows, &y, Some(&groups), 0.25, 1, "inner").unwrap();
    assert!(taken.iter().all(|&a| left.iter().all(|&b| groups[a] != groups[b])));
    assert!(hold_back(&[5], &y, None, 0.25, 1, "inner").is_err());
}

#[test]
fn few_samples_grow_by_adding() {
    let y = uneven();
    let pool: Vec<usize> = (0..y.len()).filter(|row| row % 2 == 0).collect();
    let few = |count, repetition| few_per_class(&pool, &y, count, 0, repetition, None).unwrap();
    for (small, large) in [(1, 2), (2, 5)] {
        let (small, large) = (few(small, 0), few(large, 0));
        assert!(small.iter().all(|row| large.contains(row) && pool.contains(row)));
    }
    assert!((0..4).all(|class| of_class(&few(5, 0), &y, class) == 5));
    assert_ne!(few(5, 0), few(5, 1));
    let error = few_per_class(&pool, &y, 7, 0, 0, None).unwrap_err().to_string();
    assert_eq!(error, "class 3 has 6 samples to train on, fewer than the 7 asked for");
}

#[test]
fn few_units_are_taken_whole() {
    // Recordings of three frames each, in two classes by turns.
    let recordings: Vec<u32> = (0..36).map(|row| row / 3).collect();
    let units: Vec<u32> = recordings.iter().map(|recording| recording * 3).collect();
    let y: Vec<u32> = recordings.iter().map(|recording| recording % 2).collect();
    let pool: Vec<usize> = (6..36).collect();
    let few = |count| few_per_class(&pool, &y, count, 0, 0, Some(&units));
    let taken = few(2).unwrap();
    assert_eq!(taken.len(), 2 * 2 * 3);
    for &row in &taken {
        let of_unit = pool.iter().filter(|&&other| units[other] == units[row]);
        assert!(of_unit.clone().count() == 3 && of_unit.clone().all(|other| taken.contains(other)));
    }
    assert!(taken.iter().all(|row| few(4).unwrap().contains(row)));
    let error = few(6).unwrap_err().to_string();
    assert_eq!(error, "class 0 has 5 samples to train on, fewer than the 6 asked for");
}
