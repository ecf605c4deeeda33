//! A run on values judged: errors go up under faults, the better network has the lower error, losses are above 0.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;
use std::sync::atomic::AtomicBool;

use taxel_baselines::Method;
use taxel_data::{Dataset, Layout, Quantity, Targets, Values};
use taxel_faults::{Fault, TrainingFaults};
use taxel_judge::{
    Case, Criteria, JudgeOptions, Judgement, StressOptions, Test, choose, contrasts, judge, report,
};
use taxel_learn::metrics::Outcome as Predictions;
use taxel_learn::{
    Candidate, CrossValidation, Encoding, FoldRecord, Protocol, Reduction, RunFolder, RunOptions, Silent,
    Split,
};

const RIDGE: &str = "ridge";
/// Ridge that is trained under a fault: steadier under it, worse on clean samples.
const HARDENED: &str = "ridge.hardened";

/// A number in (-1, 1) that looks drawn.
fn jitter(at: usize) -> f32 {
    ((at as f32 * 12.9898).sin() * 43_758.547).fract()
}

/// A hundred and twenty presses with the force that was pressed with: pressure rises to it over twelve readings, and the
/// noise is as large at the start, where there is little pressure, as at the end.
fn presses() -> Dataset {
    let forces: Vec<f32> = (0..120).map(|press| 5.0 + 4.0 * jitter(press)).collect();
    let reading = |press: usize, time: usize| {
        forces[press] * (time + 1) as f32 / 12.0 + 0.3 * jitter(1000 + 12 * press + time)
    };
    let x = ndarray::ArrayD::from_shape_fn(vec![forces.len(), 1, 12], |at| reading(at[0], at[2]));
    let mut dataset = Dataset::new("presses", Layout::Series, x, &vec!["any"; forces.len()]).unwrap();
    let force = Quantity { name: "force".into(), unit: Some("N".into()) };
    dataset.targets = Targets::Values(Values::new(vec![force], forces));
    dataset
}

/// Ridge and ridge under faults, on what an encoding leaves of the readings.
fn run(dataset: &Dataset, protocol: Protocol, encoding: Encoding, folder: &Path) -> Case {
    let faults = TrainingFaults { kinds: vec![Fault::Gain], ..TrainingFaults::default() };
    let ridge = Candidate::baseline(Method::Ridge);
    let hardened = ridge.hardened(&faults, None);
    let cv = CrossValidation::new(dataset).protocol(protocol).encoding(encoding);
    cv.candidate(ridge)
        .candidate(hardened)
        .run_in(folder, &RunOptions::default(), &Silent, &AtomicBool::new(false))
        .unwrap();
    Case::new(RunFolder::open(folder).unwrap(), dataset.clone()).unwrap()
}

fn one_part() -> Protocol {
    Protocol::RandomSplits { split: Split::Stratified, repetitions: 1, test: 0.3, validation: 0.0 }
}

fn judged(case: &Case) -> Judgement {
    let faults = vec![Fault::Noise, Fault::Gain];
    let stress = StressOptions { faults, guard: true, ..StressOptions::default() };
    judge(case, &JudgeOptions { stress: Some(stress), budget: 0.01, ..JudgeOptions::default() }).unwrap()
}

/// Mean absolute error of records of one quantity.
fn mae<'r>(records: impl Iterator<Item = &'r FoldRecord>) -> f64 {
    let each: Vec<f64> = records
        .flat_map(|record| match &record.outcome {
            Predictions::Values { truth, predicted, .. } => {
                truth.iter().zip(predicted).map(|(a, b)| f64::from((a - b).abs())).collect::<Vec<_>>()
            }
            Predictions::Labels { .. } => panic!("labels"),
        })
        .collect();
    each.iter().sum::<f64>() / each.len() as f64
}

#[test]
fn values_are_stressed_chosen_and_reported_by_their_error() {
    let (dataset, folder) = (presses(), tempfile::tempdir().unwrap());
    for (protocol, test) in [(Protocol::k_fold(3), Test::NadeauBengio), (one_part(), Test::Wilcoxon)] {
        let place = folder.path().join(format!("{test:?}"));
        let case = run(&dataset, protocol, Encoding::default(), &place);
        let judgement = judged(&case);
        assert_eq!(judgement.primary().head(), "MAE N");
        let best = judgement.network(RIDGE).unwrap().score().unwrap();
        let other = judgement.network(HARDENED).unwrap().score().unwrap();
        assert!(best < other && other < judgement.chance, "{best} {other} {}", judgement.chance);
        is_worse_under_faults(&case, &judgement);

        let choice = choose(&case, &judgement, &Criteria::default()).unwrap();
        assert_eq!((choice.best.as_str(), choice.test), (RIDGE, test));
        assert!((choice.margin() - 0.05 * judgement.chance).abs() < 1e-12, "{:?}", choice.criteria);
        let evidence = choice.evidence.iter().find(|evidence| evidence.network == HARDENED).unwrap();
        assert!((evidence.difference - (other - best)).abs() < 1e-9, "{evidence:?}");
        assert!(evidence.p_holm.unwrap() < 0.05 && evidence.worse, "{evidence:?}");
        let [low, high] = evidence.interval.unwrap();
        assert!(0.0 < low && low < evidence.difference && evidence.difference < high, "{evidence:?}");
        // Where faults may cost little the one that was trained under them remains, if it may be so much worse.
        let most = judgement.stress.as_ref().unwrap().mean_loss(RIDGE).unwrap() * 0.99;
        let criteria = Criteria { max_loss: Some(most), margin: Some(other), ..Criteria::default() };
        let steady = choose(&case, &judgement, &criteria).unwrap();
        let refused = steady
            .evidence
            .iter()
            .find(|evidence| evidence.network == RIDGE)
            .unwrap()
            .refused
            .clone()
            .unwrap();
        assert!(refused.starts_with("loses ") && refused.contains(" N to faults on average"), "{refused}");

        judgement.write(&case.folder).unwrap();
        assert_eq!(Judgement::read(&case).unwrap().unwrap(), judgement);
        speaks_of_errors(&report(&judgement, Some(&choice)).unwrap());
    }
}

fn is_worse_under_faults(case: &Case, judgement: &Judgement) {
    let stress = judgement.stress.as_ref().unwrap();
    for network in &stress.networks {
        let clean = mae(case.records(&network.network));
        assert!((network.clean.score - clean).abs() < 1e-6, "{network:?}");
        assert_eq!(network.clean.calibration_error, None);
        for curve in &network.curves {
            let (mildest, worst) = (curve.points[0].1.score, curve.points[4].1.score);
            assert!(clean < worst && mildest < worst, "{network:?}");
            assert!(curve.loss(network.clean, &stress.primary) > 0.0, "{network:?}");
        }
        assert!(network.mean_loss > 0.0 && network.folds.iter().all(|fold| fold.loss > 0.0), "{network:?}");
    }
    let gain = |at: usize| {
        let network = &stress.networks[at];
        network.curves[1].loss(network.clean, &stress.primary)
    };
    assert!(gain(1) < gain(0), "training under gain makes it steadier");
    // Noise of a fifth of full scale leaves less than half of what is better than the mean.
    assert!(
        stress.networks[0].curves[0].breaks_at.is_some() || stress.networks[0].mean_loss < judgement.chance
    );

    let early = judgement.early.as_ref().unwrap();
    for network in &early.networks {
        let (first, whole) = (network.points[0].score, network.points.last().unwrap().score);
        assert!(whole < first && network.decisions.is_empty(), "{network:?}");
    }
    let example = judgement.examples.first().unwrap();
    assert!(example.truth.ends_with(" N") && example.verdicts[0].right.is_none(), "{example:?}");
}

/// Page and tables have the metric with its unit, and nothing of classes.
fn speaks_of_errors(report: &taxel_judge::Report) {
    let file = |name: &str| {
        let (_, bytes) = report.files().iter().find(|(known, _)| known == name).unwrap();
        std::str::from_utf8(bytes).unwrap()
    };
    let page = file("report.html");
    for words in ["MAE (N)", "MAE N [95 % interval]", "always giving the mean", "RMSE N", "1 quantity"] {
        assert!(page.contains(words), "{words}");
    }
    for words in ["ccuracy", "percentage points", " pp", "commonest class", "NaN"] {
        assert!(!page.contains(words), "{words}: {:?}", page.find(words).map(|at| &page[at - 200..at + 50]));
    }
    let heads = file("tables/networks.csv").lines().next().unwrap();
    assert!(heads.contains(",mae,mae_low,mae_high,mae_sd,rmse,r2,"), "{heads}");
    let names: Vec<&str> = report.files().iter().map(|(name, _)| name.as_str()).collect();
    assert!(
        names.iter().all(|name| !name.contains("confusion") && !name.contains("calibration")),
        "{names:?}"
    );
}

#[test]
fn a_setting_that_reads_less_has_the_higher_error() {
    let (dataset, folder) = (presses(), tempfile::tempdir().unwrap());
    let reduce = Reduction { window: Some(2), ..Reduction::default() };
    let less = Encoding { reduce, ..Encoding::default() };
    for (name, protocol) in [("folds", Protocol::k_fold(3)), ("one", one_part())] {
        let of = |encoding: Encoding, what: &str| {
            let place = folder.path().join(format!("{name}-{what}"));
            run(&dataset, protocol.clone(), encoding, &place).records(RIDGE).cloned().collect::<Vec<_>>()
        };
        let (whole, less) = (of(Encoding::default(), "whole"), of(less.clone(), "less"));
        let settings = [less.clone(), whole.clone()];
        let contrasts = contrasts(&whole, &settings, &dataset, &protocol, 0, 0.05).unwrap();
        let primary = taxel_judge::Primary::of(&dataset.task());
        let (worse, same) = (contrasts[0].unwrap(), contrasts[1].unwrap());
        assert!((worse.difference - (mae(less.iter()) - mae(whole.iter()))).abs() < 1e-6, "{worse:?}");
        assert!(worse.worse && primary.loss(worse.difference) > 0.0, "{worse:?}");
        assert!(!worse.suffices(0.05, &primary) && same.suffices(0.05, &primary), "{worse:?} {same:?}");
    }
}
