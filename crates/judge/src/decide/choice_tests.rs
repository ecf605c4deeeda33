//! Choices from synthetic records.

use std::collections::BTreeMap;

use super::choice::decide;
use super::comparison::Comparison;
use super::hardening::hardening;
use crate::synthetic::{Player, Setting, few_samples, official, player, random_splits, stress, synthetic};
use crate::values::{
    Choice, CostKind, Criteria, FaultCurve, FaultInfo, FoldLoss, Judgement, Need, Room, Test, named_scores,
};
use serde_json::json;
use taxel_faults::Fault;
use taxel_learn::{Leak, Protocol};

fn run(comparison: &Comparison, judgement: &Judgement, criteria: &Criteria) -> Choice {
    let names: Vec<&str> = comparison.networks.iter().map(|(name, _)| name.as_str()).collect();
    decide(comparison, judgement, &names, criteria).unwrap()
}

fn chosen(setting: &Setting, players: Vec<Player>, criteria: &Criteria) -> Choice {
    let (comparison, judgement) = synthetic(setting, players);
    run(&comparison, &judgement, criteria)
}

fn says(choice: &Choice, part: &str) -> bool {
    choice.words.iter().any(|words| words.contains(part))
}

const LARGE: &[usize] = &[5, 6, 5, 4, 5];
const SMALL: &[usize] = &[6, 6, 5, 5, 5];
const POOR: &[usize] = &[30, 33, 31, 30, 32];
const HALF: &[usize] = &[50; 5];

#[test]
fn the_cheapest_that_is_not_worse_is_chosen() {
    let players = vec![
        player("large", 10.0, LARGE),
        player("small", 1.0, SMALL),
        player("poor", 0.1, POOR),
        player("majority", 0.001, HALF),
    ];
    let choice = chosen(&Setting::default(), players, &Criteria::default());
    assert_eq!((choice.best.as_str(), choice.chosen.as_deref()), ("large", Some("small")));
    assert_eq!(choice.test, Test::NadeauBengio);
    assert!(choice.enough_data, "{choice:#?}");
    let worse: Vec<bool> = choice.evidence.iter().map(|network| network.worse).collect();
    assert_eq!(worse, [false, false, true, true]);
    let small = &choice.evidence[1];
    assert!((small.difference + 0.4).abs() < 1e-9, "{small:?}");
    let [low, high] = small.interval.unwrap();
    assert!(low < -0.4 && high > -0.4 && small.p.unwrap() <= small.p_holm.unwrap());
    let best = &choice.evidence[0];
    assert_eq!((best.difference, best.interval, best.p), (0.0, None, None));
    assert!(says(&choice, "gives up 0.4 points") && says(&choice, "10 times faster"), "{:#?}", choice.words);
    assert!(says(&choice, "Not tested under faults: run taxel stress"));
}

#[test]
fn fresh_worlds_are_compared_by_a_plain_paired_t() {
    let players = || vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
    let fresh = Protocol::Fresh { train: 400, test: 100, repetitions: 5, per_class: vec![] };
    let choice = chosen(&Setting { protocol: fresh, ..Setting::default() }, players(), &Criteria::default());
    assert_eq!(choice.test, Test::FreshWorlds);
    // scipy.stats.ttest_rel([95, 94, 95, 96, 95], [94, 94, 95, 95, 95]).confidence_interval(0.95), the other way round
    let [low, high] = choice.evidence[1].interval.unwrap();
    assert!((low + 1.0800875).abs() < 1e-6 && (high - 0.2800875).abs() < 1e-6, "{low} {high}");
    // Folds of one data set say less.
    let folds = chosen(&Setting::default(), players(), &Criteria::default());
    let [wider, _] = folds.evidence[1].interval.unwrap();
    assert!(wider < low - 0.2, "{wider}");
}

#[test]
fn a_cheap_one_that_is_worse_is_not_chosen() {
    let players = vec![player("large", 10.0, LARGE), player("poor", 0.1, POOR)];
    let choice = chosen(&Setting::default(), players, &Criteria::default());
    assert_eq!(choice.chosen.as_deref(), Some("large"));
    assert!(says(&choice, "cheaper ones do not suffice: poor"), "{:#?}", choice.words);
    assert!(choice.evidence[1].difference < -20.0 && choice.evidence[1].p_holm.unwrap() < 0.001);
}

#[test]
fn a_baseline_that_suffices_is_called_one() {
    let players = vec![player("large", 10.0, LARGE), player("k-nn", 1.0, LARGE)];
    let choice = chosen(&Setting::default(), players, &Criteria::default());
    assert_eq!(choice.chosen.as_deref(), Some("k-nn"));
    // Equal accuracies: the cheaper is called the best, and there is no test of it with itself.
    assert_eq!(choice.best, "k-nn");
    assert!(says(&choice, "baseline and no network"), "{:#?}", choice.words);
    assert_eq!(choice.evidence[0].p, Some(1.0));
    // Five folds without a difference: the 500 samples say how sure that is.
    let [low, high] = choice.evidence[0].interval.unwrap();
    assert!((-0.5..-0.3).contains(&low) && (low + high).abs() < 1e-9, "{low} {high}");
}

#[test]
fn too_few_data_are_called_so() {
    const A: &[usize] = &[1, 6];
    const B: &[usize] = &[6, 3];
    const HALF: &[usize] = &[10, 10];
    let setting = Setting { parts: 2, tested: 20, trained: 20, ..Setting::default() };
    let players = || vec![player("large", 10.0, A), player("small", 1.0, B), player("majority", 0.001, HALF)];
    let choice = chosen(&setting, players(), &Criteria::default());
    assert!(!choice.enough_data);
    assert_eq!(choice.chosen.as_deref(), Some("small"), "majority is never chosen");
    assert!(says(&choice, "could have stayed unseen for small (up to 19."), "{:#?}", choice.words);
    // One group only: no interval.
    let setting = Setting { cluster: 1000, ..setting };
    let choice = chosen(&setting, players(), &Criteria::default());
    assert!(!choice.enough_data && says(&choice, "no interval"), "{:#?}", choice.words);
}

#[test]
fn two_folds_are_told_apart_by_their_samples() {
    // 88.3 % against 33.3 % of 120 samples: the t-test of two equal differences says p 0.5.
    let setting = Setting { parts: 2, tested: 60, trained: 60, ..Setting::default() };
    let players = || vec![player("large", 10.0, &[7, 7]), player("majority", 0.001, &[40, 40])];
    let choice = chosen(&setting, players(), &Criteria::default());
    let majority = &choice.evidence[1];
    assert_eq!((choice.test, majority.test), (Test::McNemar, Some(Test::McNemar)));
    assert!(majority.worse && majority.p.unwrap() < 1e-15, "{majority:?}");
    assert!(choice.enough_data && !says(&choice, "Not even majority"), "{:#?}", choice.words);
    // In 12 sessions it is as sure, in two it is not.
    let grouped = |cluster| chosen(&Setting { cluster, ..setting_of(60) }, players(), &Criteria::default());
    let twelve = grouped(10);
    assert_eq!((twelve.test, twelve.evidence[1].test), (Test::GroupedPairs, Some(Test::GroupedPairs)));
    assert!(twelve.evidence[1].worse && twelve.evidence[1].p > majority.p, "{:?}", twelve.evidence[1]);
    let one = grouped(1000);
    assert_eq!((one.evidence[1].test, one.evidence[1].interval), (Some(Test::McNemar), None));
}

fn setting_of(tested: usize) -> Setting {
    Setting { parts: 2, tested, trained: tested, ..Setting::default() }
}

#[test]
fn a_sample_that_is_tested_twice_counts_once() {
    // Two repetitions of one cut: the small one misses the same 3 samples in both.
    let setting = Setting { protocol: official(), parts: 2, ..Setting::default() };
    let players = vec![player("large", 10.0, &[0, 0]), player("small", 1.0, &[3, 3])];
    let choice = chosen(&setting, players, &Criteria::default());
    assert!((choice.evidence[1].p.unwrap() - 0.25).abs() < 1e-12, "{:?}", choice.evidence[1]);
}

#[test]
fn folds_that_differ_alike_are_told_apart_by_their_samples() {
    // Three more in each of five folds: the sign test of folds says 1 / 16.
    let players = vec![player("large", 10.0, LARGE), player("small", 1.0, &[8, 9, 8, 7, 8])];
    let choice = chosen(&Setting::default(), players, &Criteria::default());
    let small = &choice.evidence[1];
    assert_eq!((choice.test, small.test), (Test::NadeauBengio, Some(Test::McNemar)));
    assert!(small.worse && (small.p.unwrap() / 2f64.powi(-14) - 1.0).abs() < 1e-9, "{small:?}");
    let [low, high] = small.interval.unwrap();
    assert!(low < -3.0 && high < 0.0, "{low} {high}");
    assert_eq!(choice.chosen.as_deref(), Some("large"));
}

#[test]
fn majority_alone_can_show_that_data_are_few() {
    const WRONG: &[usize] = &[12, 7, 13, 8, 10];
    let setting = Setting { tested: 20, trained: 80, ..Setting::default() };
    let players = vec![player("large", 10.0, &[8, 9, 8, 7, 9]), player("majority", 0.001, WRONG)];
    let choice = chosen(&setting, players, &Criteria::default());
    assert!(!choice.enough_data && choice.chosen.as_deref() == Some("large"));
    assert!(says(&choice, "Not even majority"), "{:#?}", choice.words);
}

#[test]
fn what_is_no_better_than_chance_is_not_chosen() {
    let setting = Setting { parts: 2, tested: 20, trained: 20, ..Setting::default() };
    let players = vec![player("large", 10.0, &[1, 6]), player("cheap", 1.0, &[12, 8])];
    let choice = chosen(&setting, players, &Criteria::default());
    assert_eq!(choice.chosen.as_deref(), Some("large"), "{choice:#?}");
    assert!(choice.evidence[1].refused.as_deref().unwrap().contains("commonest class"));
    // Four samples of 1000 better is better, however little.
    let players = vec![player("large", 10.0, LARGE), player("little", 1.0, &[50, 49, 50, 49, 50])];
    let choice = chosen(&Setting::default(), players, &Criteria::default());
    assert!(choice.evidence[1].worse && choice.evidence[1].refused.is_none(), "{:?}", choice.evidence[1]);
}

#[test]
fn what_is_better_on_shared_folds_is_not_worse() {
    // Over its ten folds the other one loses; only the first five are shared.
    let setting = Setting { parts: 10, ..Setting::default() };
    let best: &[usize] = &[40, 41, 40, 42, 40, 0, 0, 0, 0, 0];
    let other: &[usize] = &[10, 12, 10, 11, 10, 50, 50, 50, 50, 50];
    let (mut comparison, judgement) =
        synthetic(&setting, vec![player("best", 10.0, best), player("other", 1.0, other)]);
    comparison.networks[1].1.truncate(5);
    let choice = run(&comparison, &judgement, &Criteria::default());
    let other = &choice.evidence[1];
    assert!(
        choice.best == "best" && (other.difference - 30.0).abs() < 1e-9 && other.p_holm.unwrap() < 0.001,
        "{other:?}"
    );
    assert!(!other.worse && choice.chosen.as_deref() == Some("other"), "{other:?}");
}

#[test]
fn what_seems_to_lose_much_is_not_chosen_unless_that_is_little() {
    let setting = Setting { parts: 3, tested: 20, trained: 40, ..Setting::default() };
    let players = || vec![player("large", 10.0, &[1, 2, 1]), player("cheap", 1.0, &[9, 5, 2])];
    let choice = chosen(&setting, players(), &Criteria::default());
    assert!(!choice.evidence[1].worse && choice.chosen.as_deref() == Some("large"), "{choice:#?}");
    assert!(choice.evidence[1].refused.as_deref().unwrap().contains("seems to lose 20.0 points"));
    assert!(!choice.enough_data && says(&choice, "unseen for cheap"), "{:#?}", choice.words);
    let free = chosen(&setting, players(), &Criteria { margin: Some(30.0), ..Criteria::default() });
    assert_eq!(free.chosen.as_deref(), Some("cheap"));
}

#[test]
fn a_loss_of_just_the_margin_is_no_reason() {
    // One sample of 50 in each of five folds: 2.0 points, and too few samples to be sure.
    let setting = Setting { tested: 50, trained: 200, ..Setting::default() };
    let players = || vec![player("large", 10.0, &[5; 5]), player("small", 1.0, &[6; 5])];
    let with =
        |margin| chosen(&setting, players(), &Criteria { margin: Some(margin), ..Criteria::default() });
    assert_eq!(with(2.0).evidence[1].difference, -2.0);
    assert_eq!(with(2.0).chosen.as_deref(), Some("small"), "{:#?}", with(2.0).evidence);
    assert_eq!(with(1.99).chosen.as_deref(), Some("large"));
}

#[test]
fn of_equally_cheap_ones_the_more_accurate_is_chosen() {
    let players =
        vec![player("large", 10.0, LARGE), player("worse", 1.0, SMALL), player("better", 1.0, LARGE)];
    let choice = chosen(&Setting::default(), players, &Criteria::default());
    assert_eq!((choice.best.as_str(), choice.chosen.as_deref()), ("better", Some("better")));
    let players = vec![
        player("best", 10.0, LARGE),
        player("worse", 1.0, &[6, 7, 5, 5, 5]),
        player("better", 1.0, SMALL),
    ];
    let choice = chosen(&Setting::default(), players, &Criteria::default());
    assert_eq!((choice.best.as_str(), choice.chosen.as_deref()), ("best", Some("better")));
}

#[test]
fn alpha_is_asked_for() {
    let players = || vec![player("large", 10.0, LARGE), player("poor", 0.1, POOR)];
    let p = chosen(&Setting::default(), players(), &Criteria::default()).evidence[1].p_holm.unwrap();
    let with = |alpha| {
        chosen(
            &Setting::default(),
            players(),
            &Criteria { alpha, margin: Some(100.0), ..Criteria::default() },
        )
    };
    assert_eq!(with(1.01 * p).chosen.as_deref(), Some("large"));
    assert_eq!(with(p).chosen.as_deref(), Some("poor"));
    assert_eq!(with(0.99 * p).chosen.as_deref(), Some("poor"));
}

#[test]
fn only_the_same_test_samples_are_compared() {
    let players = vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
    let (mut comparison, judgement) = synthetic(&Setting::default(), players);
    comparison.networks[1].1[0].index[0] = 499;
    let four = run(&comparison, &judgement, &Criteria::default());
    assert!((four.evidence[1].difference + 0.25).abs() < 1e-9, "{:?}", four.evidence[1]);
    comparison.networks[1].1.clear();
    let none = run(&comparison, &judgement, &Criteria::default());
    assert_eq!(none.chosen.as_deref(), Some("large"));
    assert!(none.evidence[1].refused.as_deref().unwrap().contains("no finished fold in common"));
    // Accuracies over other samples are all that is left to be told apart by.
    assert!((none.evidence[1].difference + 0.4).abs() < 1e-9, "{:?}", none.evidence[1]);
}

#[test]
fn what_diverged_is_the_best_only_where_all_did() {
    let players = vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
    let (comparison, mut judgement) = synthetic(&Setting::default(), players);
    judgement.networks[0].results.diverged = 2;
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert_eq!((choice.best.as_str(), choice.chosen.as_deref()), ("small", Some("small")));
    assert!(choice.evidence[0].refused.as_deref().unwrap().starts_with("diverged in training"));
    judgement.networks[1].results.diverged = 1;
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert_eq!((choice.best.as_str(), choice.chosen.as_deref()), ("large", None));
}

#[test]
fn leaks_are_said_whether_or_not_one_is_chosen() {
    for diverged in [0, 1] {
        let (comparison, mut judgement) =
            synthetic(&Setting::default(), vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)]);
        judgement.networks.iter_mut().for_each(|network| network.results.diverged = diverged);
        judgement.results.leaks = vec![Leak::Untrained { classes: vec!["wet".into()], folds: 1, of: 5 }];
        let choice = run(&comparison, &judgement, &Criteria::default());
        assert_eq!(choice.chosen.is_none(), diverged > 0);
        assert!(says(&choice, "Mind: wet is tested but not trained in 1 of 5 folds"), "{:#?}", choice.words);
    }
}

#[test]
fn the_margin_decides_what_few_data_are() {
    let players = || vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
    let criteria = |margin| Criteria { margin: Some(margin), ..Criteria::default() };
    let choice = chosen(&Setting::default(), players(), &criteria(5.0));
    let [low, _] = choice.evidence[1].interval.unwrap();
    assert!(choice.enough_data && low > -5.0);
    assert!(!chosen(&Setting::default(), players(), &criteria(-low - 0.01)).enough_data);
    assert!(chosen(&Setting::default(), players(), &criteria(-low + 0.01)).enough_data);
}

#[test]
fn what_does_not_fit_a_microcontroller_is_refused() {
    let players =
        || vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL), player("poor", 0.1, POOR)];
    let needs = [
        ("large", Need::Bytes { flash: 60_000, ram: 9_000 }),
        ("small", Need::Impossible { reason: "is in 32-bit floats".into() }),
        ("poor", Need::Bytes { flash: 1_000, ram: 100 }),
    ];
    let needs: BTreeMap<String, Need> = needs.map(|(name, need)| (name.to_string(), need)).into();
    let with = |max_flash, max_ram| {
        let room = Some(Room { max_flash, max_ram, needs: needs.clone() });
        chosen(&Setting::default(), players(), &Criteria { room, ..Criteria::default() })
    };
    let roomy = with(Some(65_536), None);
    assert_eq!(roomy.chosen.as_deref(), Some("large"));
    assert_eq!(roomy.evidence[1].refused.as_deref(), Some("has no C: is in 32-bit floats"));
    assert!(says(&roomy, "about 60,000 of 65,536 bytes of flash and 9,000 of RAM"), "{:#?}", roomy.words);
    // What fits and is worse beyond doubt is not chosen either.
    let tight = with(None, Some(8_192));
    assert_eq!(tight.chosen, None);
    assert!(says(&tight, "large needs 9,000 bytes of RAM, and 8,192 are there"), "{:#?}", tight.words);
}

#[test]
fn what_faults_cost_can_refuse() {
    let players = vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL), player("poor", 0.1, POOR)];
    let (comparison, mut judgement) = synthetic(&Setting::default(), players);
    let criteria = |most| Criteria { max_loss: Some(most), ..Criteria::default() };
    let names = ["large", "small", "poor"];
    let error = decide(&comparison, &judgement, &names, &criteria(10.0)).unwrap_err().to_string();
    assert!(error.contains("max_loss") && error.contains("stress test"), "{error}");
    judgement.stress = Some(stress(&[("large", 8.0), ("small", 20.0), ("poor", 1.0)]));
    let choice = run(&comparison, &judgement, &criteria(10.0));
    assert_eq!(choice.chosen.as_deref(), Some("large"));
    assert!(choice.evidence[1].refused.as_deref().unwrap().contains("20.0 points"), "{choice:#?}");
    let none = run(&comparison, &judgement, &criteria(5.0));
    assert_eq!(none.chosen, None);
    assert!(says(&none, "Nothing suffices: large loses 8.0"), "{:#?}", none.words);
    assert_eq!(run(&comparison, &judgement, &criteria(8.0)).chosen.as_deref(), Some("large"));
    // Without a limit faults are named, not judged.
    let free = run(&comparison, &judgement, &Criteria::default());
    assert_eq!(free.chosen.as_deref(), Some("small"));
    assert!(says(&free, "Faults speak against it: they cost it 20.0"), "{:#?}", free.words);
    judgement.stress = Some(stress(&[("large", 8.0)]));
    let one = run(&comparison, &judgement, &criteria(10.0));
    assert_eq!(one.chosen.as_deref(), Some("large"));
    assert_eq!(one.evidence[1].refused.as_deref(), Some("was not tested under faults"));
}

#[test]
fn one_shared_test_part_is_mcnemars() {
    // The small one misses 4 samples that the large one gets, and gets 1 that it misses: p = 2 · 6 / 32.
    let only = |wrong: &'static [usize]| {
        move |_: usize, row: usize, truth: &[u32]| vec![(truth[0] + u32::from(wrong.contains(&row))) % 2]
    };
    let with = |name, ms, wrong| Player { says: Box::new(only(wrong)), ..player(name, ms, &[]) };
    let setting = Setting { protocol: official(), parts: 1, ..Setting::default() };
    let players = || vec![with("large", 10.0, &[0, 1]), with("small", 1.0, &[1, 2, 3, 4, 5])];
    let choice = chosen(&setting, players(), &Criteria::default());
    assert_eq!(choice.test, Test::McNemar);
    let small = &choice.evidence[1];
    assert!((small.p.unwrap() - 12.0 / 32.0).abs() < 1e-12, "{small:?}");
    assert!((small.difference + 3.0).abs() < 1e-9);
    let [low, high] = small.interval.unwrap();
    assert!((-9.0..-5.0).contains(&low) && (0.0..4.0).contains(&high), "{low} {high}");
    assert_eq!(choice.chosen.as_deref(), Some("small"));
    assert!(!choice.enough_data && says(&choice, "McNemar"), "{:#?}", choice.words);
    // Whole sessions are drawn where there are some: a single one has no interval.
    let setting = Setting { cluster: 1000, ..setting };
    assert_eq!(chosen(&setting, players(), &Criteria::default()).evidence[1].interval, None);
}

#[test]
fn several_attributes_are_compared_by_their_mean() {
    let attributes = vec![("elasticity", vec!["0", "1"]), ("hardness", vec!["0", "1"])];
    let setting = Setting { protocol: random_splits(), parts: 1, attributes, ..Setting::default() };
    let says_of = |wrong: [usize; 2]| {
        move |_: usize, row: usize, truth: &[u32]| {
            truth.iter().zip(wrong).map(|(label, wrong)| (label + u32::from(row < wrong)) % 2).collect()
        }
    };
    let with = |name, ms, wrong| Player { says: Box::new(says_of(wrong)), ..player(name, ms, &[]) };
    // Samples 0 to 9: one attribute wrong against none; 10 to 29 the same but for the other attribute.
    let players = vec![with("large", 10.0, [0, 0]), with("small", 1.0, [10, 30])];
    let choice = chosen(&setting, players, &Criteria::default());
    assert_eq!(choice.evidence[1].score, 80.0);
    assert!((choice.evidence[1].difference + 20.0).abs() < 1e-9);
    // Thirty samples speak for the large one, however many attributes each.
    assert!((choice.evidence[1].p.unwrap() / 2f64.powi(-29) - 1.0).abs() < 1e-9);
    assert_eq!(choice.chosen.as_deref(), Some("large"));
    assert!(says(&choice, "mean over elasticity and hardness"), "{:#?}", choice.words);
}

#[test]
fn holm_counts_every_comparison() {
    // Alone the small one would be worse at 5 %; beside two others it is not.
    const BETTER: &[usize] = &[5, 5, 5, 5, 5, 5, 5, 5, 5, 5];
    const WORSE: &[usize] = &[7, 9, 6, 8, 6, 9, 7, 7, 9, 5];
    let setting = Setting { parts: 10, tested: 50, trained: 450, ..Setting::default() };
    let two = || vec![player("large", 10.0, BETTER), player("small", 1.0, WORSE)];
    let single = chosen(&setting, two(), &Criteria::default());
    assert!(single.evidence[1].worse, "{:#?}", single.evidence);
    let crowd = two().into_iter().chain((0..40).map(|_| player("same", 20.0, BETTER))).collect();
    let (comparison, judgement) = synthetic(&setting, crowd);
    let together = run(&comparison, &judgement, &Criteria::default());
    assert!(!together.evidence[1].worse && together.evidence[1].p == single.evidence[1].p);
    assert_eq!(together.chosen.as_deref(), Some("small"));
}

#[test]
fn the_correction_uses_the_samples_of_a_fold() {
    // Nearly twice the test samples for each training sample: a wider interval of the same differences.
    let players = || vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
    let width = |trained| {
        let choice = chosen(&Setting { trained, ..Setting::default() }, players(), &Criteria::default());
        let [low, high] = choice.evidence[1].interval.unwrap();
        high - low
    };
    let ratio = width(200) / width(400);
    assert!((ratio - (0.7f64 / 0.45).sqrt()).abs() < 1e-9, "{ratio}");
    // A learning curve: 100 tested of 500, whatever number is trained on.
    let curve = |trained| Setting { protocol: few_samples(), trained, ..Setting::default() };
    let (comparison, judgement) = synthetic(&curve(400), players());
    let whole = run(&comparison, &judgement, &Criteria::default()).evidence[1].interval.unwrap();
    let (mut comparison, judgement) = synthetic(&curve(10), players());
    comparison.clusters = (0..500).collect();
    let few = run(&comparison, &judgement, &Criteria::default()).evidence[1].interval.unwrap();
    assert!((few[0] - whole[0]).abs() < 1e-9, "{few:?} {whole:?}");
}

#[test]
fn what_is_to_be_small_is_asked_for() {
    let players = vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
    let (comparison, mut judgement) = synthetic(&Setting::default(), players);
    judgement.networks[0].results.costs.bytes = 10;
    judgement.networks[0].results.costs.macs = 1_000_000;
    for (cost, wanted) in [(CostKind::Latency, "small"), (CostKind::Size, "large"), (CostKind::Macs, "small")]
    {
        let choice = run(&comparison, &judgement, &Criteria { cost, ..Criteria::default() });
        assert_eq!(choice.chosen.as_deref(), Some(wanted), "{cost:?}");
    }
    judgement.networks[1].speed = None;
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert_eq!(choice.chosen.as_deref(), Some("large"));
    assert!(choice.evidence[1].refused.as_deref().unwrap().contains("not timed"));
}

#[test]
fn a_wish_outside_its_range_is_refused() {
    let (comparison, judgement) = synthetic(&Setting::default(), vec![player("large", 10.0, LARGE)]);
    for (criteria, name) in [
        (Criteria { alpha: 0.0, ..Criteria::default() }, "alpha"),
        (Criteria { alpha: f64::NAN, ..Criteria::default() }, "alpha"),
        (Criteria { margin: Some(0.0), ..Criteria::default() }, "margin"),
        (Criteria { max_loss: Some(-1.0), ..Criteria::default() }, "max_loss"),
    ] {
        let error = decide(&comparison, &judgement, &["large"], &criteria).unwrap_err().to_string();
        assert!(error.starts_with(name), "{error}");
    }
    assert!(decide(&comparison, &judgement, &[], &Criteria::default()).is_err());
    let single = run(&comparison, &judgement, &Criteria::default());
    assert!(
        single.enough_data && says(&single, "nothing in the table that beats chance is cheaper"),
        "{:#?}",
        single.words
    );
}

/// Makes `large` trained clean and under faults, on five folds; hardening costs a point and saves ten.
fn hardened() -> (Comparison, Judgement) {
    let players =
        vec![player("large", 10.0, LARGE), player("large.hardened", 9.0, LARGE), player("poor", 0.1, POOR)];
    let (comparison, mut judgement) = synthetic(&Setting::default(), players);
    judgement.networks[1].results.hardening =
        Some(taxel_learn::Hardening { faults: Default::default(), clean: Some("large".into()), unmet: None });
    let mut stress = stress(&[("large", 20.0), ("large.hardened", 10.0), ("poor", 1.0)]);
    for (network, losses) in stress.networks.iter_mut().zip([[19.0, 20.0, 21.0], [9.0, 11.0, 10.0]]) {
        let fold = |(fold, loss)| FoldLoss { fold, score: 90.0 - loss / 10.0, loss };
        network.folds = losses.into_iter().enumerate().map(fold).collect();
    }
    judgement.stress = Some(stress);
    (comparison, judgement)
}

#[test]
fn what_hardening_costs_is_said_with_its_interval() {
    let (comparison, judgement) = hardened();
    let clean = Criteria { clean_only: true, ..Criteria::default() };
    let choice = run(&comparison, &judgement, &clean);
    // Twins cost the same: the clocks' tenth does not choose between them.
    assert_eq!(choice.evidence[0].cost, choice.evidence[1].cost);
    assert_eq!(choice.chosen.as_deref(), Some("large"));
    assert!(
        says(
            &choice,
            "Trained under faults (large.hardened) it loses 10.0 points to them on average instead of 20.0"
        ),
        "{:#?}",
        choice.words
    );
    assert!(says(&choice, "that gains 1.0 points on unbroken samples (95 % interval"), "{:#?}", choice.words);
    let robust = Criteria { max_loss: Some(15.0), ..clean };
    let choice = run(&comparison, &judgement, &robust);
    assert_eq!(choice.chosen.as_deref(), Some("large.hardened"));
    assert!(says(&choice, "It was trained under faults, which cost it 10.0 points"), "{:#?}", choice.words);
}

#[test]
fn of_twins_that_clean_samples_do_not_tell_apart_the_one_trained_under_faults_is_chosen() {
    let (comparison, mut judgement) = hardened();
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert_eq!(choice.chosen.as_deref(), Some("large.hardened"));
    assert!(says(&choice, "It was trained under faults, which cost it 10.0 points"), "{:#?}", choice.words);
    // Faults that cost it more speak against it.
    judgement.stress.as_mut().unwrap().networks[1].mean_loss = 20.5;
    assert_eq!(run(&comparison, &judgement, &Criteria::default()).chosen.as_deref(), Some("large"));
    judgement.stress.as_mut().unwrap().networks[1].mean_loss = 20.0;
    assert_eq!(run(&comparison, &judgement, &Criteria::default()).chosen.as_deref(), Some("large.hardened"));
    // Without a stress test its training speaks for it.
    judgement.stress = None;
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert_eq!(choice.chosen.as_deref(), Some("large.hardened"));
    assert!(says(&choice, "large.hardened was trained under faults"), "{:#?}", choice.words);
    // One that is worse on clean samples is not chosen: four points in every fold, two more or fewer.
    let players = vec![player("large", 10.0, LARGE), player("large.hardened", 9.0, &[9, 10, 8, 9, 9])];
    let (comparison, mut judgement) = synthetic(&Setting::default(), players);
    judgement.networks[1].results.hardening =
        Some(taxel_learn::Hardening { faults: Default::default(), clean: Some("large".into()), unmet: None });
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert!(choice.evidence[1].worse && choice.chosen.as_deref() == Some("large"), "{:#?}", choice.evidence);
}

#[test]
fn a_twin_that_is_worse_than_its_own_is_not_chosen_however_many_are_compared() {
    const BETTER: &[usize] = &[5; 10];
    const WORSE: &[usize] = &[7, 9, 6, 8, 6, 9, 7, 7, 9, 5];
    let setting = Setting { parts: 10, tested: 50, trained: 450, ..Setting::default() };
    let two = [player("large", 10.0, BETTER), player("large.hardened", 10.0, WORSE)];
    let crowd = two.into_iter().chain((0..40).map(|_| player("same", 20.0, BETTER))).collect();
    let (comparison, mut judgement) = synthetic(&setting, crowd);
    judgement.networks[1].results.hardening =
        Some(taxel_learn::Hardening { faults: Default::default(), clean: Some("large".into()), unmet: None });
    let choice = run(&comparison, &judgement, &Criteria { margin: Some(100.0), ..Criteria::default() });
    let twin = &choice.evidence[1];
    assert!(!twin.worse && twin.refused.is_none() && twin.p.unwrap() < 0.05, "{twin:?}");
    assert_eq!(choice.chosen.as_deref(), Some("large"));
}

/// Breaks `small` at severity 1 of `fault`, and `large` too where `both`.
fn broken(fault: Fault, severity: u8, both: bool) -> (Comparison, Judgement) {
    let players = vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL), player("poor", 0.1, POOR)];
    let (comparison, mut judgement) = synthetic(&Setting::default(), players);
    let mut stress = stress(&[("large", 9.5), ("small", 35.5), ("poor", 1.0)]);
    stress.faults = vec![FaultInfo::of(fault)];
    for (at, network) in stress.networks.iter_mut().enumerate() {
        let breaks_at = (at == 1 || both && at == 0).then_some(severity);
        network.curves = vec![FaultCurve { fault, points: vec![], breaks_at }];
    }
    judgement.stress = Some(stress);
    (comparison, judgement)
}

#[test]
fn what_a_common_fault_breaks_is_passed_over_for_the_cheapest_that_stands_it() {
    let (comparison, judgement) = broken(Fault::Noise, 1, false);
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert_eq!((choice.chosen.as_deref(), choice.passed_over.as_deref()), (Some("large"), Some("small")));
    assert_eq!(
        (choice.evidence[1].breaks_at_1.as_slice(), &choice.steadier),
        ([Fault::Noise].as_slice(), &None)
    );
    let why = "small is cheaper and suffices on clean samples (94.6 %), but loses half of its margin at severity 1 of \
               noise (1 % of full scale, SD). Faults cost it 35.5 points on average, large 9.5.";
    assert!(says(&choice, why), "{:#?}", choice.words);
    assert!(says(&choice, "small does not stand faults; poor"), "{:#?}", choice.words);
    // By clean samples alone the small one is chosen, with the sentence.
    let clean = run(&comparison, &judgement, &Criteria { clean_only: true, ..Criteria::default() });
    assert_eq!((clean.chosen.as_deref(), &clean.passed_over), (Some("small"), &None));
    assert!(says(&clean, "Mind: it loses half of its margin at severity 1 of noise"), "{:#?}", clean.words);
}

#[test]
fn only_common_faults_at_severity_1_count() {
    for (fault, severity) in [(Fault::Noise, 2), (Fault::Swap, 1)] {
        let (comparison, judgement) = broken(fault, severity, false);
        let choice = run(&comparison, &judgement, &Criteria::default());
        assert_eq!((choice.chosen.as_deref(), &choice.passed_over), (Some("small"), &None), "{fault}");
        assert!(!says(&choice, "half of its margin"), "{:#?}", choice.words);
    }
}

#[test]
fn where_faults_break_all_the_steadier_one_is_named() {
    let (comparison, mut judgement) = broken(Fault::Gain, 1, true);
    let choice = run(&comparison, &judgement, &Criteria::default());
    assert_eq!((choice.chosen.as_deref(), choice.steadier.as_deref()), (Some("small"), Some("large")));
    let beside =
        "Steadier: large (95.0 % on clean samples) loses 9.5 points to faults on average, small 35.5.";
    assert!(says(&choice, "Mind: it loses half") && says(&choice, beside), "{:#?}", choice.words);
    judgement.stress.as_mut().unwrap().networks[0].mean_loss = 34.0;
    let alike = run(&comparison, &judgement, &Criteria::default());
    assert_eq!(alike.steadier, None);
    assert!(says(&alike, "Nothing that suffices is steadier."), "{:#?}", alike.words);
}

#[test]
fn a_choice_has_these_keys() {
    let (comparison, judgement) = broken(Fault::Noise, 1, false);
    let choice = run(&comparison, &judgement, &Criteria::default());
    let json = named_scores(&choice).unwrap();
    assert_eq!((&json["chosen"], &json["passed_over"]), (&json!("large"), &json!("small")));
    let small = &json["evidence"][1];
    assert_eq!((&small["breaks_at_1"], &small["test"]), (&json!(["noise"]), &json!("nadeau-bengio")));
    assert_eq!(json["criteria"]["clean_only"], json!(false));
    // Nothing is said of what is not there, and older choices have none of it.
    assert!(json.get("steadier").is_none() && json["evidence"][0].get("breaks_at_1").is_none(), "{json:#}");
    let mut older = json;
    older["criteria"].as_object_mut().unwrap().remove("clean_only");
    older.as_object_mut().unwrap().remove("passed_over");
    for evidence in older["evidence"].as_array_mut().unwrap() {
        evidence.as_object_mut().unwrap().retain(|key, _| key != "test" && key != "breaks_at_1");
    }
    let older: Choice = serde_json::from_value(older).unwrap();
    assert_eq!(
        (older.chosen.as_deref(), older.passed_over, older.evidence[1].test),
        (Some("large"), None, None)
    );
}

#[test]
fn too_few_groups_are_said() {
    let players = || vec![player("large", 10.0, LARGE), player("small", 1.0, SMALL)];
    for (groups, few) in [(4, true), (5, false)] {
        let (comparison, mut judgement) = synthetic(&Setting::default(), players());
        judgement.networks.iter_mut().for_each(|network| network.results.interval_groups = Some(groups));
        let choice = run(&comparison, &judgement, &Criteria::default());
        assert_eq!(says(&choice, "Too few groups (4)"), few, "{:#?}", choice.words);
    }
}

#[test]
fn paired_changes_are_those_of_the_folds() {
    let (_, judgement) = hardened();
    let found = hardening(&judgement).unwrap();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].clean.as_str(), found[0].loss), ("large", [20.0, 10.0]));
    let change = found[0].loss_change;
    // Differences -10, -9, -11: mean -10, SD 1.
    assert!((change.mean + 10.0).abs() < 1e-12);
    let [low, high] = change.interval.unwrap();
    // Student's 4.302653 with 2 degrees of freedom, and folds of 100 tested samples for 400 in training.
    let half = 4.302653 * (1.0f64 / 3.0 + 0.25).sqrt();
    assert!((low + high + 20.0).abs() < 1e-9 && ((high - low) / 2.0 - half).abs() < 1e-5, "{low} {high}");
    // A twin that was not broken leaves nothing to compare.
    let mut single = judgement;
    single.stress.as_mut().unwrap().networks.remove(0);
    assert_eq!(hardening(&single).unwrap(), []);
}
