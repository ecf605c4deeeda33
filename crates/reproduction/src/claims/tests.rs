//! Claims tested on synthetic runs.

use super::benchmark::{Benchmark, RunNetwork};
use super::claim::Claim;
use super::finding::Finding;
use super::palpation::{
    few_beat_many, margin_shrinks, three_beats_two, twins_told_apart, within_look_alikes,
};
use super::papers::CLAIMS;
use super::questions::{beats, close, commonest_error, larger_spreads, smallest_spread};
use super::settle;
use super::transfer::{
    early_layers_change_most, freezing_costs, resolution_matters, tuned_beats_frozen, tuned_close,
};
use super::verdict::Verdict;
use crate::measure::Measure;
use crate::printed::Papers;
use taxel::judge::Judged;
use taxel_judge::synthetic::{Player, Setting, few_samples, player, random_splits, synthetic};

pub(super) fn benchmark(setting: &Setting, players: Vec<Player>) -> Benchmark<'static> {
    let (comparison, judgement) = synthetic(setting, players);
    let judgement = Box::leak(Box::new(judgement));
    let entry = |judged: &Judged| RunNetwork {
        name: judged.results.network.clone(),
        judged: judged.clone(),
        checkpoint: false,
        frozen: vec![],
    };
    let entries = judgement.networks.iter().map(entry).collect();
    Benchmark {
        name: "synthetic".into(),
        judgement,
        comparison,
        entries,
        untrained: vec![],
        chance: 50.0,
        seconds: vec![],
        look_alikes: vec![],
        confidence: 0.95,
        printed: &NOTHING_PRINTED,
    }
}

static NOTHING_PRINTED: Papers = Papers { tables: vec![] };

impl Finding {
    fn claim(&self) -> Claim {
        Claim {
            paper: String::new(),
            place: String::new(),
            says: String::new(),
            run: String::new(),
            source: taxel::Source::simulated("fingertip"),
            fresh: false,
            least: self.least,
            contrasts: self.contrasts.clone(),
            lacks: self.lacks.clone(),
        }
    }

    fn outcome(&self) -> Verdict {
        self.claim().outcome()
    }

    pub(super) fn size(&self) -> Option<f64> {
        self.claim().weakest().map(|contrast| contrast.size)
    }

    fn interval(&self) -> Option<[f64; 2]> {
        self.claim().weakest().and_then(|contrast| contrast.interval)
    }
}

pub(super) fn is(finding: &Finding, outcome: Verdict, part: &str) {
    let claim = finding.claim();
    assert!(claim.outcome() == outcome && claim.effect().contains(part), "{}: {finding:?}", claim.effect());
}

const GOOD: &[usize] = &[5, 6, 5, 4, 5];
const FAIR: &[usize] = &[10, 12, 10, 9, 11];
const NEAR: &[usize] = &[5, 5, 6, 4, 6];

#[test]
fn a_claim_holds_against_each_or_not_at_all() {
    let run = benchmark(
        &Setting::default(),
        vec![player("good", 1.0, GOOD), player("fair", 1.0, FAIR), player("near", 1.0, NEAR)],
    );
    let finding = beats(&run, "good", &["fair"], Measure::Accuracy).unwrap();
    is(&finding, Verdict::Holds, "good less fair");
    assert!((finding.size().unwrap() - 5.4).abs() < 1e-9 && finding.interval().unwrap()[0] > 0.0);
    is(&beats(&run, "fair", &["good"], Measure::Accuracy).unwrap(), Verdict::DoesNotHold, "fair less good");
    // Beating one of two is not being the best: the nearer one is shown.
    let best = beats(&run, "good", &["fair", "near"], Measure::Accuracy).unwrap();
    is(&best, Verdict::TooFewData, "good less near, points; nearest of 2");
    // One that refutes a claim is shown before one that only leaves it open, however wide that one's interval.
    let open = beats(&run, "near", &["good", "fair"], Measure::Accuracy).unwrap();
    is(&open, Verdict::TooFewData, "near less good");
    let refuted = beats(&run, "fair", &["good", "near"], Measure::Accuracy).unwrap();
    is(&refuted, Verdict::DoesNotHold, "fair less");
    // Of two of one kind the one that bears its name takes part.
    let zoo = |name, wrong| Player { zoo: "good", ..player(name, 1.0, wrong) };
    let players =
        vec![zoo("good-twice", FAIR), zoo("good", GOOD), zoo("good-last", FAIR), player("fair", 1.0, FAIR)];
    let named =
        beats(&benchmark(&Setting::default(), players), "good", &["fair"], Measure::Accuracy).unwrap();
    is(&named, Verdict::Holds, "good less fair");
    // What cannot be measured against one does not hide what another refutes, and is not passed over.
    const ALIKE: &[usize] = &[6, 7, 6, 5, 6];
    let three =
        |third| vec![player("good", 1.0, GOOD), player("alike", 1.0, ALIKE), player("third", 1.0, third)];
    let test = |third| {
        let run = benchmark(&Setting::default(), three(third));
        beats(&run, "good", &["alike", "third"], Measure::Accuracy).unwrap()
    };
    is(&test(NEAR), Verdict::TooFewData, "good less third");
    is(&test(FAIR), Verdict::CannotBeTested, "good less alike");
    let lacks = beats(&run, "good", &["fair", "gone", "lost"], Measure::Accuracy).unwrap();
    is(&lacks, Verdict::CannotBeTested, "the run lacks gone, lost");
    assert_eq!((lacks.size(), lacks.interval()), (None, None));
}

#[test]
fn a_cost_below_a_margin_is_told_from_one_above() {
    let run = benchmark(&Setting::default(), vec![player("good", 1.0, GOOD), player("near", 1.0, NEAR)]);
    let at = |margin| close(&run, &["gone", "near"], &["good"], margin).unwrap();
    let [low, high] = at(1.0).interval().unwrap();
    assert!(low < 0.0 && high > 0.0);
    is(&at(-low + 0.01), Verdict::Holds, "near less good");
    is(&at(-low - 0.01), Verdict::TooFewData, "near less good");
    is(&at(-high - 0.01), Verdict::DoesNotHold, "near less good");
    is(&close(&run, &["gone"], &["good"], 1.0).unwrap(), Verdict::CannotBeTested, "lacks gone");
}

/// Makes a network of single labels: `say` maps the label of the first `wrong[part]` rows of each part.
fn confused(name: &'static str, zoo: &'static str, wrong: &'static [usize], say: fn(u32) -> u32) -> Player {
    let says = move |part: usize, row: usize, truth: &[u32]| {
        vec![if row < wrong[part] { say(truth[0]) } else { truth[0] }]
    };
    Player { name, zoo, per_class: None, ms: 1.0, says: Box::new(says) }
}

#[test]
fn the_commonest_error_is_that_of_the_counts() {
    let attributes = vec![("class", vec!["shore-00", "shore-10", "shore-20"])];
    let setting = Setting { attributes, ..Setting::default() };
    const WRONG: &[usize] = &[30, 36, 33, 30, 36];
    let test = |say| {
        let run = benchmark(&setting, vec![confused("resnet8-lite-1d", "resnet8-lite-1d", WRONG, say)]);
        commonest_error(&run, "resnet8-lite-1d", ["shore-20", "shore-10"]).unwrap()
    };
    let finding = test(|label| if label == 2 { 1 } else { label });
    is(&finding, Verdict::Holds, "shore-20 taken for shore-10 less");
    assert!((finding.size().unwrap() - 11.0).abs() < 1e-9, "{finding:?}");
    // The other way round, and both ways.
    is(&test(|label| if label == 1 { 2 } else { label }), Verdict::DoesNotHold, "less shore-10 for shore-20");
    is(&test(|label| [0, 2, 1][label as usize]), Verdict::DoesNotHold, "less shore-10 for shore-20");
    let plain = benchmark(&Setting::default(), vec![player("resnet8-lite-1d", 1.0, GOOD)]);
    let lacks = commonest_error(&plain, "resnet8-lite-1d", ["shore-20", "shore-10"]).unwrap();
    is(&lacks, Verdict::CannotBeTested, "the classes shore-20 and shore-10");
}

#[test]
fn spreads_are_compared_over_the_folds() {
    const WIDE: &[usize] = &[5, 25, 8, 30, 12];
    const NARROW: &[usize] = &[10, 11, 10, 12, 11];
    let run = benchmark(&Setting::default(), vec![player("wide", 1.0, WIDE), player("narrow", 1.0, NARROW)]);
    let larger = |run: &Benchmark, one, other| larger_spreads(run, &[[one, other]]).unwrap();
    is(&larger(&run, "wide", "narrow"), Verdict::Holds, "wide more than narrow");
    is(&larger(&run, "narrow", "wide"), Verdict::DoesNotHold, "narrow more than wide");
    is(&larger(&run, "wide", "gone"), Verdict::CannotBeTested, "the run lacks gone");
    is(
        &larger_spreads(&run, &[["wide", "narrow"], ["narrow", "wide"]]).unwrap(),
        Verdict::DoesNotHold,
        "nearest of 2",
    );
    is(&smallest_spread(&run, "narrow", &["wide"]).unwrap(), Verdict::Holds, "wide more than narrow");
    is(&smallest_spread(&run, "wide", &["narrow"]).unwrap(), Verdict::DoesNotHold, "narrow more than wide");
    let same = benchmark(&Setting::default(), vec![player("a", 1.0, &[5; 5]), player("b", 1.0, &[6; 5])]);
    is(&larger(&same, "a", "b"), Verdict::CannotBeTested, "folds that differ");
}

#[test]
fn tuned_and_frozen_are_told_apart() {
    const FROZEN: &[usize] = &[40, 44, 41, 40, 43];
    let with = |name, zoo, wrong| Player { zoo, ..player(name, 1.0, wrong) };
    let mut run = benchmark(
        &Setting::default(),
        vec![
            with("scratch", "mobilenet-v2", FROZEN),
            with("tuned", "mobilenet-v2", GOOD),
            with("frozen", "mobilenet-v2", FROZEN),
            with("middle", "mobilenet-v2", NEAR),
            with("resnet50", "resnet50", NEAR),
        ],
    );
    run.entries[2].frozen = vec!["features".into()];
    run.entries[1].checkpoint = true;
    // Frozen at random is no frozen checkpoint.
    let none = tuned_beats_frozen(&run).unwrap();
    is(&none, Verdict::CannotBeTested, "both tuned and frozen");
    is(&tuned_close(&run, "mobilenet-v2", "resnet50", 3.0).unwrap(), Verdict::CannotBeTested, "checkpoint");
    for at in 2..5 {
        run.entries[at].checkpoint = true;
    }
    // Runs record the names of the layers, in an order of their own.
    let graph = taxel::zoo::find("mobilenet-v2").unwrap().graph(&taxel::Settings::new()).unwrap();
    run.entries[3].frozen = taxel::zoo::matlab::range(&graph, "18:139").unwrap();
    run.entries[3].frozen.reverse();
    is(&tuned_beats_frozen(&run).unwrap(), Verdict::Holds, "mobilenet-v2: tuned less frozen");
    // Whatever a network's parts are called: none of its convolutions has changed.
    let layer = |change| taxel::learn::Change { layer: "conv".into(), change };
    run.entries[2].frozen = vec!["conv1".into(), "layer1".into()];
    is(&tuned_beats_frozen(&run).unwrap(), Verdict::CannotBeTested, "both tuned and frozen");
    run.entries[2].judged.results.changes = vec![layer(0.0), layer(0.0)];
    is(&tuned_beats_frozen(&run).unwrap(), Verdict::Holds, "mobilenet-v2: tuned less frozen");
    run.entries[2].judged.results.changes = vec![layer(0.0), layer(0.1)];
    is(&tuned_beats_frozen(&run).unwrap(), Verdict::CannotBeTested, "both tuned and frozen");
    is(&tuned_close(&run, "mobilenet-v2", "resnet50", 3.0).unwrap(), Verdict::Holds, "tuned less resnet50");
    let finding = freezing_costs(&run, "18:139", 3.0).unwrap();
    is(&finding, Verdict::Holds, "middle less tuned");
    is(&freezing_costs(&run, "18:139", 0.1).unwrap(), Verdict::TooFewData, "above -0.1");
    let lacks = freezing_costs(&run, "1:150", 3.0).unwrap();
    is(&lacks, Verdict::CannotBeTested, "1:150 frozen");
    // Weight changes that fall with depth, rise with it, and do neither, a little otherwise in each training.
    let mut test = |change: fn(usize) -> f64| {
        let layer = |at: usize| taxel::learn::Change { layer: at.to_string(), change: change(at) };
        run.entries[1].judged.results.changes = (0..20).map(layer).collect();
        for (part, record) in run.comparison.networks[1].1.iter_mut().enumerate() {
            record.changes = (0..20).map(layer).collect();
            record.changes.swap(part, 2 * part + 3);
        }
        early_layers_change_most(&run, "mobilenet-v2").unwrap()
    };
    is(&test(|at| 1.0 / (at + 1) as f64), Verdict::Holds, "5 trainings of tuned");
    is(&test(|at| at as f64), Verdict::DoesNotHold, "5 trainings");
    // One training is one case, however many layers it has.
    run.comparison.networks[1].1.truncate(1);
    let one = early_layers_change_most(&run, "mobilenet-v2").unwrap();
    is(&one, Verdict::CannotBeTested, "a second training of mobilenet-v2");
}

/// Makes a run on so many fresh worlds, of networks that are wrong on so many of 100 test samples of each.
fn fresh(worlds: usize, planned: usize, players: Vec<Player>) -> Benchmark<'static> {
    let per_class = vec![];
    let protocol = taxel::learn::Protocol::Fresh { train: 400, test: 100, repetitions: planned, per_class };
    benchmark(&Setting { protocol, parts: worlds, ..Setting::default() }, players)
}

#[test]
fn a_run_on_fresh_worlds_is_looked_at_three_times() {
    const WRONG: &[usize] = &[5, 9, 5, 6, 8, 7, 5, 8, 6, 5, 9, 7, 5, 6, 8, 5, 7, 9, 6, 5];
    const FAR: &[usize] = &[44, 41, 40, 43, 41, 42, 40, 41, 43, 44, 40, 41, 42, 40, 43, 44, 41, 40, 42, 43];
    const SAME: &[usize] = &[6, 8, 6, 5, 9, 6, 6, 7, 7, 5, 8, 8, 5, 5, 9, 5, 8, 8, 6, 5];
    let of = |worlds, other| {
        let names = vec![player("vgg6-lite-1d", 1.0, WRONG), player("vgg6-lite-2d", 1.0, other)];
        let claims = settle(vec![fresh(worlds, 20, names)]).unwrap();
        claims.into_iter().find(|claim| claim.says == CLAIMS[0].says).unwrap()
    };
    let width = |claim: &Claim| claim.weakest().unwrap().interval.map(|[low, high]| high - low).unwrap();
    assert_eq!(of(4, FAR).effect(), "the run lacks a quarter of its worlds");
    // A large difference is clear after five worlds, at the price of a very wide interval.
    let (early, late) = (of(5, FAR), of(20, FAR));
    assert_eq!((early.outcome(), late.outcome(), early.fresh), (Verdict::Holds, Verdict::Holds, true));
    assert_eq!(early.contrasts, late.contrasts, "the first look that decides stands");
    assert!(width(&early) > 10.0, "{early:?}");
    // None is one after twenty.
    let none = of(20, SAME);
    assert_eq!(none.outcome(), Verdict::NoDifference, "{none:?}");
    assert!(none.effect().ends_with("points; within ± 1.00"), "{}", none.effect());
    assert_eq!(of(5, SAME).outcome(), Verdict::TooFewData);
}

#[test]
fn one_of_several_contrasts_refutes_at_a_higher_price() {
    const ONE: &[usize] = &[12, 10, 11, 9, 12];
    const OTHER: &[usize] = &[7, 8, 7, 8, 7];
    let run = benchmark(
        &Setting::default(),
        vec![player("one", 1.0, ONE), player("other", 1.0, OTHER), player("third", 1.0, ONE)],
    );
    let alone = beats(&run, "one", &["other"], Measure::Accuracy).unwrap();
    let both = beats(&run, "one", &["other", "third"], Measure::Accuracy).unwrap();
    let widths = |finding: &Finding| {
        let contrast = finding.contrasts[0].clone();
        [contrast.interval, contrast.refuting].map(|ends| ends.map(|[low, high]| high - low).unwrap())
    };
    let ([narrow, same], [interval, refuting]) = (widths(&alone), widths(&both));
    assert!(narrow == same && interval == narrow && refuting > 1.1 * interval);
}

#[test]
fn resolution_needs_two_runs_of_one_scene() {
    let run = |size: usize, wrong, mean: f64| {
        let mut run = benchmark(&Setting::default(), vec![player("net", 1.0, wrong)]);
        let mut judgement = run.judgement.clone();
        judgement.results.sample_shape = vec![size, size];
        run.judgement = Box::leak(Box::new(judgement));
        run.entries[0].judged.results.interval = Some([mean - 3.0, mean + 3.0]);
        run
    };
    let (fine, coarse) = (run(128, GOOD, 95.0), run(16, &[50; 5], 50.0));
    let test = |run, others: &[&Benchmark]| resolution_matters(run, others, [16, 128], 10.0).unwrap();
    let finding = test(&fine, &[&coarse]);
    is(&finding, Verdict::Holds, "128 less 16 elements");
    let [low, high] = finding.interval().unwrap();
    assert!(
        (finding.size().unwrap() - 45.0).abs() < 1e-9
            && (low - 40.757).abs() < 1e-3
            && (high - 49.243).abs() < 1e-3
    );
    is(&test(&fine, &[&run(16, FAIR, 89.6)]), Verdict::DoesNotHold, "holds above 10");
    is(&test(&fine, &[]), Verdict::CannotBeTested, "second run");
    is(&test(&coarse, &[&fine]), Verdict::CannotBeTested, "128 × 128 elements");
}

/// Runs a learning curve of rows: name, network, training samples per class; wrong on the first so many of 100.
fn curve(rows: &[(&'static str, &'static str, usize, &'static [usize])]) -> Benchmark<'static> {
    let setting = Setting { protocol: few_samples(), ..Setting::default() };
    let one = |&(name, zoo, count, wrong): &(_, _, _, _)| Player {
        zoo,
        per_class: Some(count),
        ..player(name, 1.0, wrong)
    };
    let mut run = benchmark(&setting, rows.iter().map(one).collect());
    for entry in &mut run.entries {
        let three = entry.results().zoo.starts_with("tactnet3d");
        entry.judged.inputs = vec![if three { "tensor" } else { "image" }.into()];
    }
    run
}

#[test]
fn a_learning_curve_answers_for_few_grasps() {
    const FEW_3D: &[usize] = &[10, 12, 9, 11, 10];
    const FEW_2D: &[usize] = &[45, 44, 46, 43, 45];
    const MANY_2D: &[usize] = &[20, 21, 19, 22, 20];
    let run = curve(&[
        ("tactnet3d-51-pool.n1", "tactnet3d-51", 1, &[50; 5]),
        ("tactnet3d-51.n1", "tactnet3d-51", 1, FEW_3D),
        ("tactnet6.n1", "tactnet6", 1, FEW_2D),
        ("tactnet3d-51.n10", "tactnet3d-51", 10, GOOD),
        ("tactnet6.n10", "tactnet6", 10, MANY_2D),
    ]);
    let finding = three_beats_two(&run, 1).unwrap();
    is(&finding, Verdict::Holds, "tactnet3d-51.n1 less tactnet6.n1");
    is(&three_beats_two(&run, 2).unwrap(), Verdict::CannotBeTested, "trained on 2 samples");
    let margin = margin_shrinks(&run).unwrap();
    is(&margin, Verdict::Holds, "with 1 less with 10");
    assert!((margin.size().unwrap() - (34.2 - 15.4)).abs() < 1e-9, "{margin:?}");
    let few = few_beat_many(&run, &[1, 2], &[5, 10]).unwrap();
    is(&few, Verdict::Holds, "tactnet3d-51.n1 less tactnet6.n10, points; best of 1 cases");
    // The better of two cases, its interval wider for the choice between them.
    let both = few_beat_many(&run, &[1, 10], &[10]).unwrap();
    is(&both, Verdict::Holds, "tactnet3d-51.n10 less tactnet6.n10, points; best of 2 cases");
    let [low, high] = both.interval().unwrap();
    let [alone_low, alone_high] = few_beat_many(&run, &[10], &[10]).unwrap().interval().unwrap();
    assert!(low < alone_low - 0.1 && high > alone_high + 0.1, "{low} {alone_low}");
    let other = curve(&[
        ("tactnet3d-51.n1", "tactnet3d-51", 1, FEW_2D),
        ("tactnet6.n1", "tactnet6", 1, FEW_3D),
        ("tactnet3d-51.n10", "tactnet3d-51", 10, GOOD),
        ("tactnet6.n10", "tactnet6", 10, MANY_2D),
    ]);
    is(&three_beats_two(&other, 1).unwrap(), Verdict::DoesNotHold, "less");
    is(&margin_shrinks(&other).unwrap(), Verdict::DoesNotHold, "less");
    is(&few_beat_many(&other, &[1], &[10]).unwrap(), Verdict::DoesNotHold, "less");
    // Of an unfinished run the margin is that of the network that has both counts.
    let unfinished = curve(&[
        ("tactnet3d-51.n1", "tactnet3d-51", 1, &[50; 5]),
        ("tactnet3d-51-pool.n1", "tactnet3d-51", 1, FEW_3D),
        ("tactnet6.n1", "tactnet6", 1, FEW_2D),
        ("tactnet3d-51-pool.n10", "tactnet3d-51", 10, GOOD),
        ("tactnet6.n10", "tactnet6", 10, MANY_2D),
    ]);
    assert_eq!(margin_shrinks(&unfinished).unwrap().size(), margin.size());
    let plain = benchmark(&Setting::default(), vec![player("tactnet3d", 1.0, GOOD)]);
    is(&margin_shrinks(&plain).unwrap(), Verdict::CannotBeTested, "a learning curve");
}

#[test]
fn where_mistakes_go_is_counted() {
    let attributes = vec![("class", vec!["ball", "ball_inclusions", "can", "can_inclusions"])];
    let setting = Setting { attributes, ..Setting::default() };
    const WRONG: &[usize] = &[20, 24, 20, 22, 26];
    let run = |three: fn(u32) -> u32, two: fn(u32) -> u32| {
        let players = vec![
            confused("tactnet3d", "tactnet3d", WRONG, three),
            confused("tactnet6", "tactnet6", WRONG, two),
        ];
        let mut run = benchmark(&setting, players);
        run.entries[1].judged.inputs = vec!["image".into()];
        run.look_alikes = vec![vec![0, 1], vec![2, 3]];
        run
    };
    let twin = |label| label ^ 1;
    let other = |label| (label + 2) % 4;
    let inside = within_look_alikes(&run(twin, other), 2).unwrap();
    // Without spread there is no interval: 100 less 0 in every fold.
    assert_eq!((inside.outcome(), inside.size()), (Verdict::CannotBeTested, Some(100.0)), "{inside:?}");
    let mixed = |label| if label < 2 { label ^ 1 } else { (label + 2) % 4 };
    is(&within_look_alikes(&run(twin, mixed), 2).unwrap(), Verdict::Holds, "% of errors");
    is(&within_look_alikes(&run(mixed, twin), 2).unwrap(), Verdict::DoesNotHold, "% of errors");
    is(
        &twins_told_apart(&run(other, twin), "_inclusions").unwrap(),
        Verdict::Holds,
        "tactnet3d less tactnet6",
    );
    is(&twins_told_apart(&run(twin, other), "_inclusions").unwrap(), Verdict::DoesNotHold, "less");
    is(&twins_told_apart(&run(twin, other), "_gone").unwrap(), Verdict::CannotBeTested, "twins");
    let mut bare = run(twin, other);
    bare.look_alikes.clear();
    is(&within_look_alikes(&bare, 2).unwrap(), Verdict::CannotBeTested, "data.look_alikes");
}

#[test]
fn attributes_and_their_worst_levels_have_their_own_claims() {
    let levels = || vec!["1", "2", "3", "4"];
    let attributes = vec![("elasticity", levels()), ("hardness", levels())];
    let setting =
        Setting { protocol: random_splits(), parts: 1, tested: 200, attributes, ..Setting::default() };
    // Wrong by one level on one attribute: of the first 60 samples, or of every sample of one level.
    let with = |name, says: fn(usize, &[u32]) -> Vec<u32>| Player {
        says: Box::new(move |_, row, truth| says(row, truth)),
        ..player(name, 1.0, &[])
    };
    let run = benchmark(
        &setting,
        vec![
            with("own", |row, truth| vec![truth[0], if row < 60 { truth[1] ^ 1 } else { truth[1] }]),
            with("level", |row, truth| {
                let miss = truth[0] == 2 && row % 8 == 2;
                vec![if miss { 3 } else { truth[0] }, truth[1]]
            }),
        ],
    );
    let test = |measure| beats(&run, "own", &["level"], measure).unwrap();
    let elasticity = test(Measure::Attribute("elasticity"));
    is(&elasticity, Verdict::Holds, "accuracy of elasticity: own less level");
    assert_eq!(elasticity.size(), Some(12.5));
    is(&test(Measure::Attribute("hardness")), Verdict::DoesNotHold, "accuracy of hardness");
    // Level 4 is said 50 + 25 times and is right 50 times: precision 2/3 against 1.
    let worst = test(Measure::WorstPrecision("elasticity"));
    is(&worst, Verdict::Holds, "precision of the worst level of elasticity");
    assert!((worst.size().unwrap() - 100.0 / 3.0).abs() < 1e-9, "{worst:?}");
    is(&test(Measure::Attribute("stiffness")), Verdict::CannotBeTested, "the attribute stiffness");
    // One session: nothing tells how much it varies, and the finding says so.
    let one = benchmark(
        &Setting { cluster: 1000, ..setting },
        vec![player("a", 1.0, &[9]), player("b", 1.0, &[1])],
    );
    let none = beats(&one, "a", &["b"], Measure::Attribute("hardness")).unwrap();
    is(&none, Verdict::CannotBeTested, "lacks test parts or groups");
    assert!(none.size().is_some());
}

#[test]
fn runs_on_the_same_samples_are_one() {
    let named = |name: &str, digest: &str, players| {
        let mut run = benchmark(&Setting::default(), players);
        let mut judgement = run.judgement.clone();
        judgement.results.data_digest = digest.into();
        run.judgement = Box::leak(Box::new(judgement));
        run.name = name.into();
        run
    };
    let small = || vec![player("vgg6-lite-1d", 1.0, GOOD), player("k-nn", 1.0, FAIR)];
    let large = || vec![player("vgg6-lite-2d", 1.0, FAIR), player("k-nn", 1.0, GOOD)];
    let first = &CLAIMS[0];
    let all =
        Benchmark::join(vec![named("a", "1", small()), named("b", "1", large()), named("c", "2", large())]);
    assert_eq!(all.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(), ["a + b", "c"]);
    assert_eq!(all[0].entries.len(), 3);
    let claims = settle(all).unwrap();
    assert_eq!(claims.len(), 2 * CLAIMS.len());
    assert_eq!((claims[0].says.as_str(), claims[0].run.as_str()), (first.says, "a + b"));
    assert_eq!(claims[0].outcome(), Verdict::Holds);
    assert_eq!(claims[1].outcome(), Verdict::CannotBeTested);
    for claim in &claims {
        let lacks = claim.effect().contains("lacks");
        assert_eq!(claim.outcome() == Verdict::CannotBeTested, lacks, "{claim:?}");
        assert!(claim.contrasts.iter().all(|contrast| contrast.size.is_finite()), "{claim:?}");
    }
}

/// Counts the claims that the project's pages list, per paper.
#[test]
fn every_paper_has_its_claims() {
    let count = |paper| CLAIMS.iter().filter(|claim| claim.paper == paper).count();
    assert_eq!(["000", "001", "002", "003", "004"].map(count), [23, 13, 4, 9, 10]);
    for claim in CLAIMS {
        assert!(claim.place.contains("section") || claim.place.contains("Table"), "{}", claim.says);
    }
}
