//! Claims about sensors, times, single classes and levels, tested on synthetic runs.

use super::benchmark::{Benchmark, RunNetwork};
use super::palpation::both_do_well;
use super::questions::{beat, beats, larger_spreads, recognised};
use super::sensors::{channels_alike, frozen_at_chance, optical_first, single_step_at_chance};
use super::tests::{benchmark, is};
use super::times::{predicts_faster, trains_fastest};
use super::transfer::{best_from_checkpoint, changes_least, cheapest_to_freeze};
use super::verdict::Verdict;
use crate::measure::Measure;
use taxel::Source;
use taxel::learn::{Change, FoldKey};
use taxel_judge::synthetic::{Player, Setting, few_samples, player, random_splits};

const GOOD: &[usize] = &[5, 6, 5, 4, 5];
const FAIR: &[usize] = &[10, 12, 10, 9, 11];
const NEAR: &[usize] = &[5, 5, 6, 4, 6];
const HALF: &[usize] = &[50, 52, 49, 51, 50];

fn run(players: Vec<Player>) -> Benchmark<'static> {
    benchmark(&Setting::default(), players)
}

fn of(name: &'static str, zoo: &'static str, wrong: &'static [usize]) -> Player {
    Player { zoo, ..player(name, 1.0, wrong) }
}

/// Changes what the run says of its samples.
fn on(mut run: Benchmark<'static>, source: &str, shape: &[usize]) -> Benchmark<'static> {
    let mut judgement = run.judgement.clone();
    judgement.results.source = Source::simulated(source);
    judgement.results.sample_shape = shape.to_vec();
    run.judgement = Box::leak(Box::new(judgement));
    run.name = source.into();
    run
}

/// Lets networks start from a checkpoint; those whose names contain `frozen` keep their body.
fn from_checkpoints(mut run: Benchmark<'static>) -> Benchmark<'static> {
    for entry in &mut run.entries {
        entry.checkpoint = true;
        if entry.name.contains("frozen") {
            entry.frozen = vec!["features".into()];
        }
    }
    run
}

#[test]
fn each_of_several_has_to_beat_each_other() {
    let of_three = |near| run(vec![player("a", 1.0, GOOD), player("b", 1.0, near), player("c", 1.0, FAIR)]);
    let test = |near| beat(&of_three(near), &["a", "b"], &["c"], Measure::Accuracy).unwrap();
    is(&test(NEAR), Verdict::Holds, "less c, points; nearest of 2");
    is(&test(HALF), Verdict::DoesNotHold, "b less c");
    let lacks = beat(&of_three(NEAR), &["a", "gone"], &["c", "lost"], Measure::Accuracy).unwrap();
    is(&lacks, Verdict::CannotBeTested, "the run lacks gone, lost");
}

#[test]
fn a_class_is_recognised_or_not() {
    let setting = Setting {
        attributes: vec![("class", vec!["shore-00", "shore-10", "shore-20"])],
        ..Setting::default()
    };
    // Wrong on so many of the first samples of class 0, or on all others.
    let misses = |name: &'static str, count: usize, of_others: bool| Player {
        says: Box::new(move |part, row, truth| {
            let is_missed = (truth[0] == 0 && row < count + part) || (truth[0] != 0 && of_others);
            vec![if is_missed { (truth[0] + 1) % 3 } else { truth[0] }]
        }),
        ..player(name, 1.0, &[])
    };
    let test = |count, least| {
        let run = benchmark(&setting, vec![misses("net", count, true), misses("other", 1, false)]);
        recognised(&run, &["net", "other"], "shore-00", least).unwrap()
    };
    is(&test(60, 90.0), Verdict::DoesNotHold, "shore-00 recognised by net, %; holds above 90; nearest of 2");
    is(&test(1, 80.0), Verdict::Holds, "shore-00 recognised by");
    is(&test(1, 99.99), Verdict::DoesNotHold, "");
    let run = benchmark(&setting, vec![player("net", 1.0, GOOD)]);
    is(&recognised(&run, &["net"], "shore-30", 99.0).unwrap(), Verdict::CannotBeTested, "the class shore-30");
}

#[test]
fn hybrids_may_vary_more_than_their_branches() {
    const WIDE: &[usize] = &[5, 25, 8, 30, 12];
    let networks =
        vec![player("hybrid", 1.0, WIDE), player("branch", 1.0, FAIR), player("second", 1.0, WIDE)];
    let run = run(networks);
    is(&larger_spreads(&run, &[["hybrid", "branch"]]).unwrap(), Verdict::Holds, "hybrid more than branch");
    let both = larger_spreads(&run, &[["hybrid", "branch"], ["hybrid", "gone"]]).unwrap();
    is(&both, Verdict::CannotBeTested, "the run lacks gone");
}

#[test]
fn times_of_predictions_are_ordered_where_they_do_not_overlap() {
    let timed = |ms: [f64; 3]| {
        let [mlp, lstm, large] = ms;
        let players = [("mlp", mlp), ("lstm", lstm), ("vgg16", large)];
        run(players.map(|(name, ms)| Player { ms, ..player(name, 1.0, GOOD) }).into())
    };
    let test = |ms, quick: &[&str], slow: &[&str]| predicts_faster(&timed(ms), quick, slow).unwrap();
    is(
        &test([0.1, 0.4, 9.0], &["mlp"], &["lstm", "vgg16"]),
        Verdict::Holds,
        "lstm less mlp, ms; nearest of 2",
    );
    is(&test([0.5, 0.4, 9.0], &["mlp"], &["lstm", "vgg16"]), Verdict::DoesNotHold, "lstm less mlp");
    is(&test([0.1, 0.4, 9.0], &["mlp"], &["resnet18"]), Verdict::CannotBeTested, "the run lacks resnet18");
    let mut slow = timed([0.1, 0.4, 9.0]);
    let speed = slow.entries[0].judged.speed.as_mut().unwrap();
    speed.network.p95_ms = 0.6;
    // Half of one's predictions are quicker, but not nearly all.
    is(&predicts_faster(&slow, &["mlp"], &["lstm"]).unwrap(), Verdict::TooFewData, "lstm less mlp");
}

#[test]
fn trainings_are_timed_training_by_training() {
    let timed = |shallow: [f64; 5]| {
        let mut run = run(vec![player("shallow", 1.0, GOOD), player("deep", 1.0, FAIR)]);
        let key = |network: &str, fold| FoldKey { network: network.into(), repetition: 0, fold };
        for (fold, seconds) in shallow.into_iter().enumerate() {
            run.seconds.push((key("shallow", fold), seconds));
            run.seconds.push((key("deep", fold), 20.0 + fold as f64));
        }
        run
    };
    let test = |shallow| trains_fastest(&timed(shallow), "shallow", &["deep"]).unwrap();
    let finding = test([10.0, 11.0, 11.5, 12.0, 13.0]);
    is(&finding, Verdict::Holds, "training: deep less shallow, s");
    assert!((finding.size().unwrap() - 10.5).abs() < 1e-9, "{finding:?}");
    is(&test([40.0, 41.0, 43.0, 42.0, 44.0]), Verdict::DoesNotHold, "deep less shallow");
    let mut untimed = timed([1.0; 5]);
    untimed.seconds.clear();
    is(&trains_fastest(&untimed, "shallow", &["deep"]).unwrap(), Verdict::CannotBeTested, "measured times");
}

#[test]
fn the_best_network_is_best_tuned_and_frozen() {
    let with = |frozen| {
        from_checkpoints(run(vec![
            of("resnet50-tuned", "resnet50", GOOD),
            of("alexnet-tuned", "alexnet", FAIR),
            of("resnet50-frozen", "resnet50", frozen),
            of("alexnet-frozen", "alexnet", FAIR),
        ]))
    };
    is(&best_from_checkpoint(&with(NEAR), "resnet50").unwrap(), Verdict::Holds, "nearest of 2");
    let frozen = best_from_checkpoint(&with(HALF), "resnet50").unwrap();
    is(&frozen, Verdict::DoesNotHold, "resnet50-frozen less alexnet-frozen");
    is(
        &best_from_checkpoint(&with(NEAR), "vgg16").unwrap(),
        Verdict::CannotBeTested,
        "vgg16 and another network",
    );
}

#[test]
fn weight_changes_are_compared_over_trainings() {
    let mut run =
        from_checkpoints(run(vec![of("resnet50", "resnet50", GOOD), of("alexnet", "alexnet", FAIR)]));
    let layers =
        |size: f64| (0..3).map(|at| Change { layer: format!("{at}"), change: size * at as f64 }).collect();
    let set = |run: &mut Benchmark, sizes: [f64; 2]| {
        for (at, size) in sizes.into_iter().enumerate() {
            run.entries[at].judged.results.changes = layers(size);
            for (part, record) in run.comparison.networks[at].1.iter_mut().enumerate() {
                record.changes = layers(size + 0.01 * (part * at) as f64);
            }
        }
    };
    set(&mut run, [0.1, 0.4]);
    is(
        &changes_least(&run, "resnet50").unwrap(),
        Verdict::Holds,
        "mean weight change: alexnet less resnet50",
    );
    set(&mut run, [0.9, 0.4]);
    is(&changes_least(&run, "resnet50").unwrap(), Verdict::DoesNotHold, "alexnet less resnet50");
    run.comparison.networks[0].1.truncate(1);
    is(&changes_least(&run, "resnet50").unwrap(), Verdict::CannotBeTested, "a second training");
}

#[test]
fn one_range_of_frozen_layers_costs_least() {
    let zoo = "mobilenet-v2";
    let mut run =
        from_checkpoints(run(vec![of("middle", zoo, GOOD), of("early", zoo, FAIR), of("late", zoo, HALF)]));
    let graph = taxel::zoo::find(zoo).unwrap().graph(&taxel::Settings::new()).unwrap();
    for (entry, range) in run.entries.iter_mut().zip(["18:139", "1:144", "1:134"]) {
        entry.frozen = taxel::zoo::matlab::range(&graph, range).unwrap();
    }
    is(
        &cheapest_to_freeze(&run, "18:139", &["1:144", "1:134"]).unwrap(),
        Verdict::Holds,
        "middle less early",
    );
    is(&cheapest_to_freeze(&run, "1:144", &["18:139"]).unwrap(), Verdict::DoesNotHold, "early less middle");
    let lacks = cheapest_to_freeze(&run, "18:139", &["1:144", "1:150"]).unwrap();
    is(&lacks, Verdict::CannotBeTested, "with 1:150 frozen");
}

#[test]
fn sensors_are_compared_by_what_is_above_chance() {
    let with = |scene: &str, chance: f64, wrong| {
        let mut run = on(from_checkpoints(run(vec![of("net-tuned", "resnet50", wrong)])), scene, &[64, 64]);
        run.chance = chance;
        let score = run.entries[0].results().primary().unwrap();
        run.entries[0].judged.results.interval = Some([score - 2.0, score + 2.0]);
        run
    };
    let gel = with("gel without noise", 10.0, GOOD);
    let test = |others: &[&Benchmark]| optical_first(&gel, others).unwrap();
    is(&test(&[&with("imprint", 10.0, HALF)]), Verdict::Holds, "of resnet50: gel without noise less imprint");
    // 85 points above chance against 39.6 and 56.6.
    let far = test(&[&with("imprint", 10.0, HALF), &with("hand", 33.0, FAIR)]);
    is(&far, Verdict::Holds, "less hand, points; nearest of 2");
    assert!((far.size().unwrap() - 28.4).abs() < 1e-6, "{far:?}");
    is(&test(&[&with("hand", 1.0, GOOD)]), Verdict::DoesNotHold, "less hand");
    is(&test(&[]), Verdict::CannotBeTested, "beside it");
    let hand = with("hand", 33.0, GOOD);
    is(&optical_first(&hand, &[&gel]).unwrap(), Verdict::CannotBeTested, "an optical sensor");
}

#[test]
fn what_is_around_chance_is_told_from_what_is_above() {
    let with = |wrong, shape: &[usize]| {
        on(
            from_checkpoints(run(vec![of("net-frozen", "resnet50", wrong), of("tuned", "resnet50", GOOD)])),
            "imprint",
            shape,
        )
    };
    let frozen = |wrong, shape| frozen_at_chance(&with(wrong, shape), 16, 7.62).unwrap();
    is(
        &frozen(HALF, &[16, 16]),
        Verdict::Holds,
        "chance less accuracy of net-frozen, points; holds above -7.62",
    );
    is(&frozen(FAIR, &[16, 16]), Verdict::DoesNotHold, "net-frozen");
    is(&frozen(HALF, &[128, 128]), Verdict::CannotBeTested, "16 × 16 elements");
    let single = |wrong, shape: &[usize], is_trained: bool| {
        let mut run = on(run(vec![player("net", 1.0, wrong)]), "hand", shape);
        if !is_trained {
            let entry: RunNetwork = run.entries.remove(0);
            run.untrained.push((entry, 40.0));
        }
        single_step_at_chance(&run, 7.62).unwrap()
    };
    is(&single(HALF, &[1, 7, 3], true), Verdict::Holds, "chance less accuracy of net");
    // A network that cannot be trained on them is what the claim says.
    is(&single(HALF, &[1, 7, 3], false), Verdict::Holds, "chance less accuracy of net");
    is(&single(GOOD, &[1, 7, 3], true), Verdict::DoesNotHold, "net");
    is(&single(HALF, &[700, 7, 3], true), Verdict::CannotBeTested, "single time steps");
}

#[test]
fn grey_in_one_and_in_three_channels_are_alike_both_ways() {
    let test = |grey| {
        let networks = vec![of("net", "resnet50", GOOD), of("net-grey", "resnet50", grey)];
        channels_alike(&from_checkpoints(run(networks))).unwrap()
    };
    is(&test(GOOD), Verdict::Holds, "holds above -1; nearest of 2");
    is(&test(HALF), Verdict::DoesNotHold, "net-grey less net");
    const BETTER: &[usize] = &[0, 1, 0, 0, 0];
    is(&test(BETTER), Verdict::DoesNotHold, "net less net-grey");
    let none = channels_alike(&from_checkpoints(run(vec![of("net", "resnet50", GOOD)]))).unwrap();
    is(&none, Verdict::CannotBeTested, "grey in three channels");
}

#[test]
fn both_kinds_do_well_with_many_grasps() {
    let setting = Setting { protocol: few_samples(), ..Setting::default() };
    let one = |name, zoo, wrong| Player { per_class: Some(20), ..of(name, zoo, wrong) };
    let test = |two, least| {
        let networks =
            vec![one("tactnet3d-51.n20", "tactnet3d-51", GOOD), one("tactnet6.n20", "tactnet6", two)];
        let mut run = benchmark(&setting, networks);
        run.entries[1].judged.inputs = vec!["image".into()];
        both_do_well(&run, 20, least).unwrap()
    };
    is(&test(FAIR, 80.0), Verdict::Holds, "accuracy of tactnet6.n20, %; holds above 80; nearest of 2");
    is(&test(HALF, 80.0), Verdict::DoesNotHold, "tactnet6.n20");
    let lacks =
        both_do_well(&benchmark(&setting, vec![one("tactnet6.n20", "tactnet6", FAIR)]), 20, 90.0).unwrap();
    is(&lacks, Verdict::CannotBeTested, "trained on 20 samples");
}

#[test]
fn levels_are_compared_by_recall_f1_and_spread() {
    let levels = || vec!["1", "2", "3", "4"];
    let attributes = vec![("elasticity", levels()), ("hardness", levels())];
    let setting = Setting { protocol: random_splits(), tested: 200, attributes, ..Setting::default() };
    // Takes so many samples of level 3 of elasticity for level 4, in each part some more.
    let with = |name: &'static str, missed: usize, more: usize| Player {
        says: Box::new(move |part, row, truth| {
            let is_missed = truth[0] == 2 && row < 4 * (missed + more * part);
            vec![if is_missed { 3 } else { truth[0] }, truth[1]]
        }),
        ..player(name, 1.0, &[])
    };
    let run = benchmark(&setting, vec![with("own", 5, 1), with("other", 25, 2)]);
    let test = |measure| beats(&run, "own", &["other"], measure).unwrap();
    let recall = test(Measure::WorstRecall("elasticity"));
    is(&recall, Verdict::Holds, "recall of the worst level of elasticity: own less other, points");
    // 10 to 18 % are missed against 50 to 66 %.
    assert!((recall.size().unwrap() - 44.0).abs() < 1e-9, "{recall:?}");
    is(&test(Measure::Steadiness("elasticity")), Verdict::Holds, "minus the SD of F1 over the levels");
    // Levels 1 and 2 are never missed by either, nor is any level of hardness.
    assert_eq!(test(Measure::BestF1("elasticity")).size(), Some(0.0));
    assert_eq!(test(Measure::WorstRecall("hardness")).size(), Some(0.0));
    is(&test(Measure::BestF1("stiffness")), Verdict::CannotBeTested, "the attribute stiffness");
    let reverse = beats(&run, "other", &["own"], Measure::WorstRecall("elasticity")).unwrap();
    is(&reverse, Verdict::DoesNotHold, "other less own");
}
