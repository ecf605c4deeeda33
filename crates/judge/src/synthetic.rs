//! Runs without training: records, results and judgements as tests want them.

use taxel_trainer::config::{Protocol, ProtocolKind};
use taxel_trainer::metrics::{Levels, Scores};
use taxel_trainer::{
    Attribute, Costs, Environment, FoldKey, FoldRecord, FoldScores, NetworkResults, Results,
};

use crate::contest::Contest;
use crate::judgement::{Judged, Judgement, Kind};
use crate::speed::Speed;
use crate::stress::{NetworkStress, Range, Score, Stress};

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

/// What is divided, and how.
pub struct Setting {
    pub kind: ProtocolKind,
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
        Setting { kind: ProtocolKind::KFold, parts: 5, tested: 100, trained: 400, attributes, cluster: 1 }
    }
}

/// A network that is wrong on the first `wrong[part]` samples of each part; costs grow with `ms`.
pub fn player(name: &'static str, ms: f64, wrong: &'static [usize]) -> Player {
    let says = move |part: usize, row: usize, truth: &[u32]| {
        truth.iter().map(|label| if row < wrong[part] { (label + 1) % 2 } else { *label }).collect()
    };
    Player { name, zoo: name, per_class: None, ms, says: Box::new(says) }
}

/// Runs it.
pub fn synthetic(setting: &Setting, players: Vec<Player>) -> (Contest, Judgement) {
    let width = setting.attributes.len();
    let sizes: Vec<usize> = setting.attributes.iter().map(|(_, classes)| classes.len()).collect();
    let total = match setting.kind {
        ProtocolKind::KFold => setting.parts * setting.tested,
        _ => setting.tested + setting.trained,
    };
    let label = |row: usize| sizes.iter().map(|&size| (row % size) as u32).collect::<Vec<_>>();
    let (mut networks, mut judged) = (vec![], vec![]);
    for player in players {
        let record = |part: usize| {
            let start = if setting.kind == ProtocolKind::KFold { part * setting.tested } else { 0 };
            let truth: Vec<u32> = (0..setting.tested).flat_map(label).collect();
            let predicted = (0..setting.tested).flat_map(|row| (player.says)(part, row, &label(row)));
            let (repetition, fold) = match setting.kind {
                ProtocolKind::KFold => (0, part),
                _ => (part, 0),
            };
            FoldRecord {
                key: FoldKey { network: player.name.into(), repetition, fold },
                train_samples: setting.trained,
                index: (start..start + setting.tested).collect(),
                predicted: predicted.collect(),
                truth,
                probabilities: vec![],
                test_loss: 0.0,
                chosen: None,
                best_epoch: None,
                costs: None,
                changes: vec![],
                other_statistics: None,
                epochs: vec![],
            }
        };
        let records: Vec<FoldRecord> = (0..setting.parts).map(record).collect();
        judged.push(judge(&player, &records, &Levels::new(&sizes)));
        networks.push((player.name.to_string(), records));
    }
    let clusters = (0..total).map(|row| (row / setting.cluster) as u32).collect();
    let contest = Contest { networks, clusters, width, protocol: setting.kind, seed: 0 };
    (contest, judgement(setting, judged))
}

fn judge(player: &Player, records: &[FoldRecord], levels: &Levels) -> Judged {
    let scores: Vec<Scores> = records.iter().map(|r| r.scores(levels).unwrap().percent()).collect();
    let folds = records.iter().zip(&scores).map(|(record, scores)| FoldScores {
        repetition: record.key.repetition,
        fold: record.key.fold,
        train_samples: record.train_samples,
        test_samples: record.index.len(),
        scores: *scores,
        test_loss: 0.0,
        calibration_error: 0.0,
        brier: 0.0,
    });
    let mean = |i: usize| scores.iter().map(|s| s.values()[i]).sum::<f64>() / scores.len() as f64;
    let bytes = (1000.0 * player.ms) as u64;
    let whole = player.ms;
    Judged {
        results: NetworkResults {
            network: player.name.into(),
            zoo: player.zoo.into(),
            per_class: player.per_class,
            paper: String::new(),
            settings: Default::default(),
            made_anew: vec![],
            changes: vec![],
            other_statistics: None,
            costs: Costs { parameters: bytes / 4, bytes, macs: bytes, flops: 2 * bytes },
            folds: folds.collect(),
            mean: Some(Scores::from_values([0, 1, 2, 3].map(mean))),
            sd: None,
            interval: None,
            confusion: None,
            look_alikes: None,
            attributes: vec![],
            published: None,
        },
        baseline: ["majority", "k-nn"].contains(&player.zoo),
        inputs: vec![],
        speed: Some(Speed {
            p50_ms: whole,
            p95_ms: whole,
            encoding_p50_ms: 0.0,
            whole_p50_ms: whole,
            whole_p95_ms: whole,
            runs: 1000,
            samples_per_second: 1e3 / whole,
            batch: 1,
        }),
        train_seconds: 1.0,
        epoch_seconds: None,
        calibration_error: 0.0,
        on_front: false,
        training: vec![],
    }
}

fn judgement(setting: &Setting, networks: Vec<Judged>) -> Judgement {
    let attribute = |(name, classes): &(&str, Vec<&str>)| Attribute {
        name: (*name).into(),
        classes: classes.iter().map(ToString::to_string).collect(),
    };
    let attributes: Vec<Attribute> = setting.attributes.iter().map(attribute).collect();
    let environment = Environment::now(1, 0, "simulated: nothing", "0");
    let several = attributes.len() > 1;
    Judgement {
        results: Results {
            name: "synthetic".into(),
            title: None,
            complete: true,
            missing: vec![],
            source: "simulated: nothing".into(),
            data_digest: "0".into(),
            samples: setting.tested + setting.trained,
            sample_shape: vec![1],
            classes: attributes[0].classes.clone(),
            attributes: if several { attributes } else { vec![] },
            protocol: Protocol { kind: setting.kind, ..Protocol::default() },
            folds: setting.parts,
            left_out: Default::default(),
            shortcut: None,
            seed: 0,
            unit: "percent".into(),
            networks: vec![],
        },
        kind: Kind::Simulated,
        protocol: "synthetic".into(),
        judged_on: environment.clone(),
        environment,
        chance: 50.0,
        networks,
        stress: None,
        examples: vec![],
    }
}

/// A stress test in which faults cost each network that much on average.
pub fn stress(losses: &[(&str, f64)]) -> Stress {
    let network = |(name, loss): &(&str, f64)| NetworkStress {
        network: (*name).into(),
        clean: Score { accuracy: 90.0, calibration_error: 0.0, refused: 0 },
        curves: vec![],
        mean_loss: *loss,
        worst_loss: *loss,
        corruption_error: None,
        relative_corruption_error: None,
        calibration_error: 0.0,
        verdict: "breaks first under gain".into(),
    };
    Stress {
        seed: 0,
        samples: 100,
        of: 100,
        range: Range { low: 0.0, high: 1.0, from_samples: true },
        chance: 50.0,
        reference: None,
        faults: vec![],
        left_out: Default::default(),
        networks: losses.iter().map(network).collect(),
    }
}
