//! Choices from synthetic records.

use super::choice::decide;
use super::comparison::Comparison;
use super::hardening::hardening;
use crate::synthetic::{Player, Setting, few_samples, official, player, random_splits, stress, synthetic};
use crate::values::{Choice, CostKind, Criteria, FoldLoss, Judgement, Test};
use taxel_learn::Leak;

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
    assert!(says(&choice, "Not known: what faults do"));
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
    assert_eq!(choice.evidence[0].interval, Some([0.0, 0.0]));
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
    assert!(says(&choice, "(up to 100.0)") && says(&choice, "Not even majority"), "{:#?}", choice.words);
    // Two folds that agree to the sample prove nothing either.
    const ALIKE: &[usize] = &[3, 8];
    let players = vec![player("large", 10.0, A), player("small", 1.0, ALIKE)];
    let choice = chosen(&setting, players, &Criteria::default());
    let small = &choice.evidence[1];
    assert_eq!((small.interval, small.p, small.worse), (None, Some(0.5), false));
    assert!(!choice.enough_data && says(&choice, "no interval"), "{:#?}", choice.words);
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
    assert!(!choice.evidence[1].worse && choice.chosen.as_deref() == Some("large"), "{choice:#?}");
    assert!(choice.evidence[1].refused.as_deref().unwrap().contains("commonest class"));
}

#[test]
fn what_seems_to_lose_much_is_not_chosen_unless_that_is_little() {
    let setting = Setting { parts: 2, tested: 20, trained: 20, ..Setting::default() };
    let players = || vec![player("large", 10.0, &[1, 2]), player("cheap", 1.0, &[9, 5])];
    let choice = chosen(&setting, players(), &Criteria::default());
    assert!(!choice.evidence[1].worse && choice.chosen.as_deref() == Some("large"), "{choice:#?}");
    assert!(choice.evidence[1].refused.as_deref().unwrap().contains("seems to lose 27.5 points"));
    assert!(!choice.enough_data && says(&choice, "unseen for cheap"), "{:#?}", choice.words);
    let free = chosen(&setting, players(), &Criteria { margin: Some(30.0), ..Criteria::default() });
    assert_eq!(free.chosen.as_deref(), Some("cheap"));
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
    let names = ["large", "large.hardened", "poor"];
    let choice = decide(&comparison, &judgement, &names, &Criteria::default()).unwrap();
    // Twins cost the same: the clocks' tenth does not choose between them.
    assert_eq!(choice.evidence[0].cost, choice.evidence[1].cost);
    assert!(
        says(
            &choice,
            "Trained under faults (large.hardened) it loses 10.0 points to them on average instead of 20.0"
        ),
        "{:#?}",
        choice.words
    );
    assert!(says(&choice, "that gains 1.0 points on unbroken samples (95 % interval"), "{:#?}", choice.words);
    let robust = Criteria { max_loss: Some(15.0), ..Criteria::default() };
    let choice = decide(&comparison, &judgement, &names, &robust).unwrap();
    assert_eq!(choice.chosen.as_deref(), Some("large.hardened"));
    assert!(says(&choice, "It was trained under faults, which cost it 10.0 points"), "{:#?}", choice.words);
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
    assert!((low + high + 20.0).abs() < 1e-9 && high - low > 4.0, "{low} {high}");
    // A twin that was not broken leaves nothing to compare.
    let mut single = judgement;
    single.stress.as_mut().unwrap().networks.remove(0);
    assert_eq!(hardening(&single).unwrap(), []);
}
