//! Runs without training: records, results and judgements as tests want them.

use taxel_data::{Attribute, Source, Task};
use taxel_learn::metrics::{Outcome, Scores};
use taxel_learn::{
    Costs, Environment, FoldKey, FoldRecord, FoldScores, Latency, NetworkResults, Protocol, Results, Split,
};

use crate::decide::Comparison;
use crate::values::{Judged, Judgement, NetworkStress, Score, SensorRange, Speed, Stress};

/// Labels that a network says to a sample: part, row, true labels.
pub type Says = Box<dyn Fn(usize, usize, &[u32]) -> Vec<u32>>;

/// A network of a synthetic run.
pub struct Player {
    pub name: &'static str,
    pub zoo: &'static str,
    pub per_class: Option<usize>,
    pub ms: f64,
    pub says: Says,
}

/// Samples of a synthetic run, and how they are divided.
pub struct Setting {
    pub protocol: Protocol,
    pub parts: usize,
    /// Test samples of a part.
    pub tested: usize,
    /// Training samples of a part.
    pub trained: usize,
    /// Attributes and their classes.
    pub attributes: Vec<(&'static str, Vec<&'static str>)>,
    /// Samples that are drawn as one.
    pub cluster: usize,
}

impl Default for Setting {
    fn default() -> Self {
        let attributes = vec![("class", vec!["a", "b"])];
        let protocol = Protocol::k_fold(5);
        Setting { protocol, parts: 5, tested: 100, trained: 400, attributes, cluster: 1 }
    }
}

/// Returns a random cut.
pub fn random_splits() -> Protocol {
    Protocol::RandomSplits { split: Split::Stratified, repetitions: 1, test: 0.2, validation: 0.0 }
}

/// Returns a learning curve.
pub fn few_samples() -> Protocol {
    Protocol::FewSamples { split: Split::Stratified, repetitions: 1, test: 0.2, per_class: vec![1] }
}

/// Returns the cut of the data set's authors.
pub fn official() -> Protocol {
    Protocol::Official { split: Split::Stratified, repetitions: 1 }
}

/// Makes a network that is wrong on the first `wrong[part]` samples of each part; costs grow with `ms`.
pub fn player(name: &'static str, ms: f64, wrong: &'static [usize]) -> Player {
    let says = move |part: usize, row: usize, truth: &[u32]| {
        truth.iter().map(|label| if row < wrong[part] { (label + 1) % 2 } else { *label }).collect()
    };
    Player { name, zoo: name, per_class: None, ms, says: Box::new(says) }
}

/// Runs it.
pub fn synthetic(setting: &Setting, players: Vec<Player>) -> (Comparison, Judgement) {
    let sizes: Vec<usize> = setting.attributes.iter().map(|(_, classes)| classes.len()).collect();
    let outputs: usize = sizes.iter().sum();
    let k_fold = matches!(setting.protocol, Protocol::KFold { .. });
    let total = if k_fold { setting.parts * setting.tested } else { setting.tested + setting.trained };
    let label = |row: usize| sizes.iter().map(|&size| (row % size) as u32).collect::<Vec<_>>();
    let (mut networks, mut judged) = (vec![], vec![]);
    for player in players {
        let record = |part: usize| {
            let start = if k_fold { part * setting.tested } else { 0 };
            let truth: Vec<u32> = (0..setting.tested).flat_map(label).collect();
            let predicted = (0..setting.tested).flat_map(|row| (player.says)(part, row, &label(row)));
            let (repetition, fold) = if k_fold { (0, part) } else { (part, 0) };
            let key = FoldKey { network: player.name.into(), repetition, fold };
            let outcome = Outcome::Labels {
                probabilities: vec![1.0; setting.tested * outputs],
                predicted: predicted.collect(),
                truth,
                untrained: vec![],
                steps: None,
            };
            let index = (start..start + setting.tested).collect();
            FoldRecord::of_predictions(key, setting.trained, index, outcome)
        };
        let records: Vec<FoldRecord> = (0..setting.parts).map(record).collect();
        judged.push(judge(&player, &records, &task(setting)));
        networks.push((player.name.to_string(), records));
    }
    let clusters = (0..total).map(|row| (row / setting.cluster) as u32).collect();
    let comparison = Comparison {
        networks,
        clusters,
        is_grouped: setting.cluster > 1,
        task: task(setting),
        protocol: setting.protocol.clone(),
        seed: 0,
    };
    (comparison, judgement(setting, judged))
}

fn judge(player: &Player, records: &[FoldRecord], task: &Task) -> Judged {
    let scores: Vec<Scores> = records.iter().map(|r| r.scores(task).unwrap()).collect();
    let folds = records.iter().zip(&scores).map(|(record, scores)| FoldScores {
        repetition: record.key.repetition,
        fold: record.key.fold,
        train_samples: record.train_samples,
        test_samples: record.index.len(),
        scores: scores.clone(),
        test_loss: 0.0,
        diverged: false,
    });
    let bytes = (1000.0 * player.ms) as u64;
    let latency = |p50_ms: f64| Latency { p50_ms, p95_ms: p50_ms, runs: 1000 };
    Judged {
        results: NetworkResults {
            network: player.name.into(),
            candidate: player.name.into(),
            zoo: player.zoo.into(),
            per_class: player.per_class,
            paper: String::new(),
            settings: Default::default(),
            drawn: vec![],
            changes: vec![],
            other_statistics: None,
            diverged: 0,
            costs: Costs { parameters: bytes / 4, bytes, macs: bytes, flops: 2 * bytes },
            folds: folds.collect(),
            mean: Scores::mean_sd(&scores.iter().collect::<Vec<_>>()).0,
            sd: None,
            interval: None,
            interval_groups: None,
            confusion: None,
            look_alikes: None,
            attributes: vec![],
            published: None,
            hardening: None,
            quantized: None,
        },
        baseline: ["majority", "k-nn"].contains(&player.zoo),
        inputs: vec![],
        frozen: vec![],
        speed: Some(Speed {
            encoding: latency(0.0),
            network: latency(player.ms),
            whole: latency(player.ms),
            samples_per_second: 1e3 / player.ms,
            batch: 1,
        }),
        train_seconds: 1.0,
        epoch_seconds: None,
        calibration_error: Some(0.0),
        on_front: false,
        training: vec![],
    }
}

fn task(setting: &Setting) -> Task {
    let attribute = |(name, classes): &(&str, Vec<&str>)| Attribute {
        name: (*name).into(),
        classes: classes.iter().map(ToString::to_string).collect(),
    };
    match setting.attributes.iter().map(attribute).collect::<Vec<_>>() {
        attributes if attributes.len() > 1 => Task::Levels(attributes),
        attributes => Task::Classes(attributes[0].classes.clone()),
    }
}

fn judgement(setting: &Setting, networks: Vec<Judged>) -> Judgement {
    let source = Source::simulated("nothing");
    let environment = Environment::now(1, 0, &source, "0");
    Judgement {
        results: Results {
            name: "synthetic".into(),
            title: None,
            complete: true,
            missing: vec![],
            source,
            data_digest: "0".into(),
            data_facts: None,
            samples: setting.tested + setting.trained,
            sample_shape: vec![1],
            task: task(setting),
            look_alikes: Default::default(),
            protocol: setting.protocol.clone(),
            folds: setting.parts,
            left_out: Default::default(),
            shortcut: None,
            leaks: vec![],
            seed: 0,
            unit: "percent".into(),
            networks: vec![],
        },
        protocol: "synthetic".into(),
        judged_on: environment.clone(),
        environment,
        chance: 50.0,
        networks,
        probes: vec![],
        changed: vec![],
        stress: None,
        early: None,
        certainty: vec![],
        errors: vec![],
        importance: None,
        learning_curve: None,
        examples: vec![],
    }
}

/// Makes a stress test in which faults cost each network that much on average.
pub fn stress(losses: &[(&str, f64)]) -> Stress {
    let network = |(name, loss): &(&str, f64)| NetworkStress {
        network: (*name).into(),
        clean: Score { score: 90.0, calibration_error: Some(0.0), refused: 0, unknown: None },
        curves: vec![],
        mean_loss: *loss,
        worst_loss: *loss,
        corruption_error: None,
        relative_corruption_error: None,
        calibration_error: Some(0.0),
        sure: None,
        sure_when_broken: None,
        verdict: "breaks first under gain".into(),
        folds: vec![],
        other: None,
    };
    Stress {
        seed: 0,
        primary: Default::default(),
        samples: 100,
        of: 100,
        range: SensorRange { low: 0.0, high: 1.0, from_samples: true },
        chance: 50.0,
        reference: None,
        faults: vec![],
        left_out: Default::default(),
        networks: losses.iter().map(network).collect(),
        unseen: vec![],
        alarms: None,
    }
}
