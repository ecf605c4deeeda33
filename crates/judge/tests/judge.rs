//! A small run judged: models predict as they did, faults break what they must, speed is measured.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use taxel_baselines::Method;
use taxel_data::{Dataset, Labels, Source, SourceKind, Targets};
use taxel_faults::Fault;
use taxel_judge::{
    Case, CostKind, Criteria, EarlyOptions, JudgeOptions, Judgement, StressOptions, Test, across, choose,
    judge, stress,
};
use taxel_learn::{
    Candidate, CrossValidation, Encoding, Protocol, Recipe, RunFolder, RunOptions, Silent, Split,
};

/// Sixty samples of a scene, with these of its attributes.
fn simulated(scene: &str, seed: u64, attributes: &[&str]) -> Dataset {
    let recordings = taxel_scenes::simulate(scene, 60, seed, &[]).unwrap();
    let names: Vec<&String> = recordings.y.iter().map(|&y| &recordings.class_names[y as usize]).collect();
    let dataset = Dataset::new(scene, recordings.layout, recordings.x, &names).unwrap();
    let dataset = dataset.with_full_scale(recordings.full_scale).unwrap().with_rest(recordings.rest);
    let mut dataset = dataset.with_groups(&recordings.group).unwrap();
    dataset.source = Source::simulated(scene);
    dataset.units = None;
    if let Some(columns) = recordings.attributes {
        let values = columns.y.iter().copied().collect();
        let Targets::Classes { columns: all, .. } = &mut dataset.targets else { unreachable!("classes") };
        *all = Some(Labels::numbered(columns.class_names, values));
        dataset.learn_attributes(&attributes.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap();
    }
    dataset
}

/// Networks of the zoo and baselines, trained on `dataset` into `folder`.
fn run(
    mut cv: CrossValidation,
    folder: &Path,
    encoding: Value,
    networks: &[&str],
    recipe: Value,
    baselines: &[Method],
) {
    cv = cv.encoding(serde_json::from_value::<Encoding>(encoding).unwrap());
    let recipe: Recipe = serde_json::from_value(recipe).unwrap();
    for name in networks {
        let entry = taxel_zoo::find(name).unwrap();
        let inputs: Vec<&str> = entry.inputs.iter().map(|input| input.name.as_str()).collect();
        cv.encoder().prepare(&inputs).unwrap();
        let classes = cv.encoder().dataset().output_names().len();
        let encoder = &*cv.encoder();
        let settings = entry.fit(classes, |input| encoder.shape(input)).unwrap();
        cv = cv.candidate(Candidate::network(entry.graph(&settings).unwrap(), recipe.clone()));
    }
    for &method in baselines {
        cv = cv.candidate(Candidate::baseline(method));
    }
    cv.run_in(folder, &RunOptions::default(), &Silent, &AtomicBool::new(false)).unwrap();
}

fn fingertip(folder: &Path) -> Case {
    let dataset = simulated("fingertip", 3, &[]);
    let mut cv = CrossValidation::new(&dataset).protocol(Protocol::k_fold(2)).seed(3);
    cv.name = "judged".into();
    let baselines = [
        Method::Majority,
        Method::NearestNeighbours { k: 1 },
        Method::MiniRocket { features: 10_000 },
        Method::SvmLinear { c: 1.0 },
        Method::SvmRbf { c: 1.0 },
    ];
    let encoding = json!({"image": {"kind": "gadf", "size": 12, "range": "per-sample"}});
    let recipe = json!({"epochs": 6, "batch_size": 8, "optimizer": {"name": "adam", "lr": 3e-3}});
    run(cv, folder, encoding, &["resnet8-lite-1d", "vgg6-lite-2d"], recipe, &baselines);
    Case::new(RunFolder::open(folder).unwrap(), dataset).unwrap()
}

fn gripper(folder: &Path) -> Case {
    let dataset = simulated("gripper", 1, &["elasticity", "hardness"]);
    let protocol =
        Protocol::RandomSplits { split: Split::Stratified, repetitions: 1, test: 0.5, validation: 0.0 };
    let mut cv = CrossValidation::new(&dataset).protocol(protocol).seed(1);
    cv.name = "gripped".into();
    let recipe = json!({
        "epochs": 1, "batch_size": 8, "loss": "multi-label-soft-margin",
        "optimizer": {"name": "adam", "lr": 1e-3},
    });
    let encoding = json!({"image": {"kind": "numatac"}});
    run(cv, folder, encoding, &["multiscale-cnn"], recipe, &[Method::NearestNeighbours { k: 1 }]);
    Case::new(RunFolder::open(folder).unwrap(), dataset).unwrap()
}

#[test]
fn a_folder_is_opened_with_its_own_data_only() {
    let folder = tempfile::tempdir().unwrap();
    let case = fingertip(folder.path());
    assert_eq!(case.compared().len(), 7);
    let open = |dataset| Case::new(RunFolder::open(folder.path()).unwrap(), dataset);
    let error = open(simulated("fingertip", 4, &[])).err().unwrap().to_string();
    assert!(error.contains("was run on other data than simulated: fingertip"), "{error}");
    // A record about samples that there are not.
    let path = folder.path().join("folds/k-nn.r0.f1.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut record: Value = serde_json::from_str(&text).unwrap();
    record["index"][0] = json!(60);
    std::fs::write(&path, record.to_string()).unwrap();
    let error = open(simulated("fingertip", 3, &[])).err().unwrap().to_string();
    assert!(error.contains("folds/k-nn.r0.f1.json: tests samples that the data do not have"), "{error}");
}

#[test]
fn saved_models_answer_as_in_their_own_test() {
    for make in [fingertip, gripper] {
        let folder = tempfile::tempdir().unwrap();
        let case = make(folder.path());
        for network in case.compared() {
            for record in case.records(network) {
                let model = case.model(&record.key).unwrap().predictor(7, 1).unwrap();
                let got = model.predict(&case.dataset.x.select(ndarray::Axis(0), &record.index)).unwrap();
                assert_eq!(got.outputs.len(), record.outcome.outputs().len(), "{}", record.key);
                for (got, want) in got.outputs.iter().zip(record.outcome.outputs()) {
                    assert_eq!(got.to_bits(), want.to_bits(), "{}: {got} and {want}", record.key);
                }
                assert_eq!(got.labels, record.outcome.labels().1, "{}", record.key);
            }
        }
    }
}

#[test]
fn faults_are_scored_on_every_network() {
    let folder = tempfile::tempdir().unwrap();
    let case = fingertip(folder.path());
    let quiet = |options: &StressOptions| stress(&case, options, &|_| {}, &|| {}).unwrap();
    let options = StressOptions {
        faults: vec![Fault::Noise, Fault::Saturation],
        threads: 2,
        ..StressOptions::default()
    };
    let outcome = quiet(&options);
    assert_eq!((outcome.samples, outcome.of), (60, 60));
    assert_eq!(outcome, quiet(&StressOptions { threads: 1, ..options.clone() }), "threads do not matter");
    assert_eq!(outcome.reference.as_deref(), Some("k-nn"));
    for (network, row) in outcome.networks.iter().zip(&case.results.networks) {
        // The clean accuracy is the run's own.
        let accuracy = row.score("accuracy").unwrap();
        assert!((network.clean.score - accuracy).abs() < 1e-9, "{}: {accuracy}", network.network);
        assert_eq!(network.curves.len(), 2);
        let error: f64 = network.corruption_error.unwrap();
        if network.network == "k-nn" {
            assert!((error - 100.0).abs() < 1e-9);
            assert!((network.relative_corruption_error.unwrap() - 100.0).abs() < 1e-9);
        }
        if network.network == "majority" {
            assert_eq!(network.mean_loss, 0.0, "it reads nothing");
            assert!(network.verdict.contains("nothing to break"), "{}", network.verdict);
        }
    }
    // Readings cut at 30 % of full scale hold little of a grasp.
    let rocket = outcome.networks.iter().find(|n| n.network == "mini-rocket").unwrap();
    assert!(rocket.curves[1].points[4].1.score < rocket.clean.score, "{rocket:?}");
    // One severity alone gives the same number.
    let one = StressOptions { faults: vec![Fault::Saturation], severity: Some(5), ..options };
    assert_eq!(quiet(&one).networks[4].curves[0].points[0], outcome.networks[4].curves[1].points[4]);
    let guarded = StressOptions { guard: true, ..one.clone() };
    let both = quiet(&StressOptions { faults: vec![Fault::Stuck], ..guarded.clone() });
    assert_eq!(both, quiet(&StressOptions { faults: vec![Fault::Stuck], threads: 1, ..guarded }), "nor here");
    let alarms = both.alarms.unwrap();
    assert_eq!((alarms.samples, alarms.elements), (60, 5));
    assert!(alarms.alarmed <= 6, "{alarms:?}");
    for network in &both.networks {
        let other = network.other.as_ref().unwrap();
        assert!(other.is_guarded, "no model of the run has a guard");
        if alarms.alarmed == 0 {
            assert_eq!(other.clean, network.clean);
        }
        let [off, on] = [&network.curves, &other.curves].map(|curves| curves[0].points[0].1.score);
        assert!(on >= off, "{}: {off} % without, {on} % with a guard", network.network);
    }
    let lost = |name: &str| {
        both.networks
            .iter()
            .find(|network| network.network == name)
            .unwrap()
            .sides()
            .unwrap()
            .map(|side| side.2)
    };
    let [off, on] = lost("mini-rocket");
    assert!(on < off / 2.0, "{off} points without, {on} with a guard");
    let shift = StressOptions { faults: vec![Fault::Shift], ..StressOptions::default() };
    let error = stress(&case, &shift, &|_| {}, &|| {}).unwrap_err().to_string();
    assert!(error.contains("shift") && error.contains("channels have no place"), "{error}");
}

#[test]
fn a_judgement_holds_what_a_report_needs() {
    let folder = tempfile::tempdir().unwrap();
    let case = gripper(folder.path());
    let faults = vec![Fault::Dead, Fault::Onset];
    let wanted = StressOptions { faults, samples: 10, ..StressOptions::default() };
    let options = JudgeOptions { stress: Some(wanted), budget: 0.1, ..JudgeOptions::default() };
    let judgement = judge(&case, &options).unwrap();
    assert_eq!(judgement.kind(), SourceKind::Simulated);
    assert_eq!(judgement.networks.len(), 2);
    assert_eq!(judgement.networks[0].inputs, ["image"]);
    assert!(judgement.networks[1].baseline && judgement.networks[1].training.is_empty());
    assert_eq!(judgement.networks[0].training.len(), 1);
    for network in &judgement.networks {
        let speed = network.speed.unwrap();
        assert!(speed.whole.runs >= 5 && speed.whole.p50_ms >= speed.network.p50_ms, "{speed:?}");
        assert!(speed.samples_per_second > 0.0);
    }
    assert!(judgement.networks.iter().any(|n| n.on_front));
    let stress = judgement.stress.as_ref().unwrap();
    assert!(stress.samples <= 10 && stress.of == 30, "{} of {}", stress.samples, stress.of);
    let early = judgement.early.as_ref().unwrap();
    assert!(early.samples <= 30 && early.ticks == 450, "{early:?}");
    for (of_starts, whole) in early.networks.iter().zip(&judgement.networks) {
        assert_eq!(
            (of_starts.network.as_str(), of_starts.points.len()),
            (whole.results.network.as_str(), 10)
        );
        assert!(of_starts.points[9].refused == 0, "{of_starts:?}");
    }
    assert!(!judgement.examples.is_empty());
    let example = &judgement.examples[0];
    assert_eq!(example.pictures[0].name, "reading");
    assert!(example.truth.starts_with("elasticity:"), "{}", example.truth);
    assert_eq!(example.verdicts.len(), 2);
    judgement.write(&case.folder).unwrap();
    assert_eq!(Judgement::read(&case).unwrap().unwrap(), judgement);
}

/// Opens a folder whose files have the bootstrap intervals of older versions, and no count of groups.
#[test]
fn intervals_of_older_folders_are_computed_anew() {
    let folder = tempfile::tempdir().unwrap();
    let case = gripper(folder.path());
    let judgement =
        judge(&case, &JudgeOptions { stress: None, budget: 0.05, ..JudgeOptions::default() }).unwrap();
    let (first, path) = (&judgement.networks[0].results, folder.path().join("results.json"));
    assert!(first.interval.is_some() && first.interval_groups.is_some_and(|groups| groups > 1), "{first:?}");
    let mut older = judgement.clone();
    let mut results: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    for row in 0..older.networks.len() {
        older.networks[row].results.interval = Some([100.0, 100.0]);
        older.networks[row].results.interval_groups = None;
        results["networks"][row]["interval"] = json!([100.0, 100.0]);
        results["networks"][row].as_object_mut().unwrap().remove("interval_groups");
    }
    older.write(&case.folder).unwrap();
    std::fs::write(&path, results.to_string()).unwrap();
    let opened = Case::new(RunFolder::open(folder.path()).unwrap(), case.dataset.clone()).unwrap();
    assert_eq!(opened.results, case.results);
    assert_eq!(Judgement::read(&opened).unwrap().unwrap(), judgement);
}

#[test]
fn a_run_is_chosen_from() {
    let folder = tempfile::tempdir().unwrap();
    let case = fingertip(folder.path());
    let options = JudgeOptions { stress: None, budget: 0.05, ..JudgeOptions::default() };
    let judgement = judge(&case, &options).unwrap();
    let choice = choose(&case, &judgement, &Criteria::default()).unwrap();
    // The fingertip's groups are its sessions.
    assert_eq!((choice.test, choice.evidence.len()), (Test::GroupedPairs, 7));
    let best = choice.evidence.iter().map(|evidence| evidence.score).fold(0.0, f64::max);
    for evidence in &choice.evidence {
        assert_eq!(Some(evidence.score), judgement.network(&evidence.network).unwrap().score());
        assert!((evidence.difference - (evidence.score - best)).abs() < 1e-9, "{evidence:?}");
        assert_eq!(evidence.p.is_none(), evidence.network == choice.best);
        assert_eq!(evidence.test.is_none(), evidence.network == choice.best);
    }
    // Two folds of thirty tell little, and the words say so.
    assert!(!choice.enough_data, "{choice:#?}");
    assert!(choice.words.iter().any(|words| words.starts_with("Too few data")), "{:#?}", choice.words);
    assert!(choice.chosen.as_deref().is_some_and(|name| name != "majority"));
    assert_eq!(choice, choose(&case, &judgement, &Criteria::default()).unwrap());
    let text = serde_json::to_string(&choice).unwrap();
    assert_eq!(serde_json::from_str::<taxel_judge::Choice>(&text).unwrap(), choice);
    let limited = Criteria { max_loss: Some(10.0), cost: CostKind::Size, ..Criteria::default() };
    let error = choose(&case, &judgement, &limited).unwrap_err().to_string();
    assert!(error.contains("stress test"), "{error}");
    assert_eq!(across(&[&judgement; 5], 0.05).unwrap(), None, "one data set five times is one");
}

#[test]
fn whole_samples_answered_early_are_the_runs_own_answers() {
    let folder = tempfile::tempdir().unwrap();
    let case = fingertip(folder.path());
    let early = |threads| {
        let wanted = EarlyOptions { threads, ..EarlyOptions::default() };
        let options =
            JudgeOptions { stress: None, early: Some(wanted), budget: 0.05, ..JudgeOptions::default() };
        judge(&case, &options).unwrap()
    };
    let judgement = early(2);
    let starts = judgement.early.as_ref().unwrap();
    assert_eq!((starts.samples, starts.of, starts.ticks), (60, 60, 50));
    assert_eq!(early(1).early, judgement.early, "whatever the threads");
    for (network, judged) in starts.networks.iter().zip(&judgement.networks) {
        let folds = &judged.results.folds;
        let tested =
            |fold: &taxel_learn::FoldScores| fold.scores.get("accuracy").unwrap() * fold.test_samples as f64;
        let all = folds.iter().map(tested).sum::<f64>() / 60.0;
        let whole = network.points[9];
        assert_eq!((whole.seen, whole.refused), (100, 0));
        assert!((whole.score - all).abs() < 1e-9, "{network:?}");
        for decision in &network.decisions {
            assert!((10.0..=100.0).contains(&decision.seen) && decision.early <= 100.0, "{decision:?}");
        }
        let seen: Vec<f64> = network.decisions.iter().map(|decision| decision.seen).collect();
        assert!(seen.is_sorted(), "who wants to be surer waits longer: {network:?}");
        // Of grasps that have hardly begun nobody knows the class; the baseline that reads nothing never learns more.
        let first = network.points[0].score;
        assert!(network.network != "majority" || first == whole.score, "{network:?}");
        assert!(network.network != "mini-rocket" || first < whole.score, "{network:?}");
    }
    let none = JudgeOptions { stress: None, early: None, budget: 0.05, ..JudgeOptions::default() };
    assert_eq!(judge(&case, &none).unwrap().early, None);
}

#[test]
fn one_random_split_is_tested_by_its_groups() {
    let folder = tempfile::tempdir().unwrap();
    let case = gripper(folder.path());
    let judgement =
        judge(&case, &JudgeOptions { stress: None, budget: 0.05, ..JudgeOptions::default() }).unwrap();
    let choice =
        choose(&case, &judgement, &Criteria { cost: CostKind::Macs, ..Criteria::default() }).unwrap();
    // The gripper's groups are its objects.
    assert_eq!(choice.test, Test::GroupedPairs);
    let other = choice.evidence.iter().find(|evidence| evidence.network != choice.best).unwrap();
    let [low, high] = other.interval.unwrap();
    assert!(low <= other.difference && other.difference <= high && low < high, "{other:?}");
    assert!(choice.words.iter().any(|words| words.contains("elasticity and hardness")));
}
