//! A judgement made by hand, with names that want to break out.

use serde_json::{Value, json};
use taxel_faults::Fault;

use crate::values::{Choice, CostKind, Criteria, Evidence, Judgement, Test};

/// A class that would be a tag, an end of an attribute, a column and a formula.
pub(super) const HOSTILE: &str = "<b>&\"x|$a_1$";

/// Name, accuracy, p50 in ms, bytes, whether it is on the front.
const NETWORKS: [(&str, f64, f64, u64, bool); 5] = [
    ("small-1d", 91.25, 0.02, 55_692, true),
    ("large-2d", 93.5, 0.71, 1_205_112, true),
    // As accurate as the one above and slower: dominated.
    (HOSTILE, 93.5, 0.9, 2_205_112, false),
    ("majority", 33.3, 0.00001, 12, true),
    ("k-nn", 71.0, 0.04, 120_480, false),
];

fn network(number: usize) -> Value {
    let (name, accuracy, p50, bytes, on_front) = NETWORKS[number];
    let scores = json!({"accuracy": accuracy, "precision": accuracy - 1.0, "recall": accuracy - 2.0, "f1": accuracy - 3.0});
    let mut fold = scores.clone();
    for (key, value) in [
        ("repetition", json!(0)),
        ("fold", json!(0)),
        ("train_samples", json!(80)),
        ("test_samples", json!(40)),
        ("test_loss", json!(0.25)),
        ("calibration_error", json!(0.05)),
        ("brier", json!(0.2)),
    ] {
        fold[key] = value;
    }
    let published = json!({"table": "Kaewrakmuk and Srinonchat 2026, Table 5", "accuracy": [87.94, 1.42], "megabytes": 0.06, "gflops": 0.0002});
    let training = json!([
        {"epoch": 0, "train_loss": 1.0, "train_accuracy": 40.0, "validation_loss": 1.1, "validation_accuracy": 38.0},
        {"epoch": 1, "train_loss": 0.5, "train_accuracy": 80.0, "validation_loss": 0.7, "validation_accuracy": 75.0},
    ]);
    let baseline = number >= 3;
    let latency =
        |median: f64, late: f64| json!({"p50_ms": p50 * median, "p95_ms": p50 * late, "runs": 1000});
    json!({
        "network": name, "zoo": name, "paper": "Kaewrakmuk and Srinonchat 2026", "settings": {}, "folds": [fold],
        "costs": {"parameters": bytes / 4, "bytes": bytes, "macs": if number == 3 { 0 } else { 10 * bytes }, "flops": 20 * bytes},
        "mean": scores, "sd": {"accuracy": 1.5, "precision": 1.0, "recall": 1.0, "f1": 1.0},
        "interval": [accuracy - 4.0, accuracy + 3.0],
        "confusion": [[12, 1], [3, 24]], "published": if number == 0 { published } else { Value::Null },
        "baseline": baseline, "inputs": ["signal"],
        "speed": {
            "encoding": latency(0.25, 0.3), "network": latency(0.75, 0.8), "whole": latency(1.0, 1.5),
            "samples_per_second": 1e3 / p50, "batch": 64,
        },
        "train_seconds": 1.5, "epoch_seconds": if baseline { Value::Null } else { json!(0.1) }, "calibration_error": 0.05,
        "on_front": on_front, "training": if baseline { json!([]) } else { training },
        "changes": if number == 1 { json!([{"layer": HOSTILE, "change": 1.25e-4}]) } else { json!([]) },
    })
}

fn stress() -> Value {
    let score = |accuracy: f64| json!({"accuracy": accuracy, "calibration_error": 0.125, "unknown": 0.0625});
    let example = |number: usize| {
        let (name, clean, ..) = NETWORKS[number];
        let curve = |fault: &str, step: f64| {
            let points: Vec<Value> =
                (1..=5).map(|s| json!([s, score(clean - step * f64::from(s))])).collect();
            json!({"fault": fault, "points": points, "breaks_at": if step > 5.0 { json!(3) } else { Value::Null }})
        };
        json!({
            "network": name, "clean": score(clean), "curves": [curve("noise", 1.0), curve("gain", 10.0)],
            "mean_loss": 16.5, "worst_loss": 30.0, "corruption_error": 87.5, "relative_corruption_error": null,
            "other": {"is_guarded": true, "clean": score(clean - 0.5), "curves": [curve("noise", 1.0), curve("gain", 4.0)], "mean_loss": 7.5},
            "sure": {"share": 0.75, "right": 0.96875}, "sure_when_broken": {"share": 0.5, "right": 0.625},
            "calibration_error": 0.25, "verdict": format!("breaks first under {HOSTILE}"),
        })
    };
    let fault = |fault: Fault| json!({"fault": fault, "what": fault.describe(), "levels": fault.severities(), "unit": fault.unit()});
    json!({
        "seed": 3, "samples": 40, "of": 120, "range": {"low": 0.0, "high": 1023.0, "from_samples": false}, "chance": 33.3,
        "reference": "k-nn", "faults": [fault(Fault::Noise), fault(Fault::Gain)], "left_out": {"shift": HOSTILE},
        "alarms": {"samples": 40, "alarmed": 2, "replaced": 3, "elements": 5},
        "networks": (0..NETWORKS.len()).map(example).collect::<Vec<_>>(),
    })
}

fn early() -> Value {
    let network = |(name, accuracy, ..): (&str, f64, f64, u64, bool)| {
        let point = |seen: u8| json!({"seen": seen, "accuracy": accuracy - 0.5 * f64::from(100 - seen), "refused": 0});
        let points: Vec<Value> = (1..=10).map(|tenth| point(10 * tenth)).collect();
        let decisions =
            json!([{"confidence": 0.9, "accuracy": accuracy - 1.25, "seen": 62.5, "early": 80.0}]);
        json!({"network": name, "points": points, "decisions": decisions})
    };
    json!({"samples": 40, "of": 120, "ticks": 50, "padding": "zero", "networks": NETWORKS.map(network)})
}

fn certainty() -> Value {
    let set = json!({"share": 0.9, "least": [0.25], "covered": 0.875, "worst_group": 0.75, "size": 1.25});
    let bin = |sure: f64| json!({"answers": 20, "sure": sure, "right": sure - 0.05});
    let row = |(name, ..): (&str, f64, f64, u64, bool)| {
        json!({
            "network": name,
            "certainty": {
                "temperature": 0.5, "sets": [set], "worst_group_gap": 0.125,
                "fitted_on": {"samples": 120, "groups": 6, "parts": "groups", "digest": "d1ge57"},
                "calibration_error": {"before": 0.5, "after": 0.0625, "floor": 0.03125},
            },
            "reliability": {"bins": [bin(0.4), bin(0.9)], "surest": [1.0, 1.0, 0.95, 0.95, 0.9, 0.9, 0.85, 0.85, 0.8, 0.75]},
            "unknown": {"draws": 3, "auroc": 0.875, "auroc_softmax": 0.75, "refused": 0.5, "false_alarms": 0.0625},
        })
    };
    NETWORKS.map(row).into_iter().collect()
}

/// Makes a judgement with every part that a report shows.
pub(super) fn judgement() -> Judgement {
    let environment = json!({
        "taxel": "0.1.0", "commit": "0123abc", "optimised": true, "platform": "linux-x86_64", "cpu": HOSTILE, "cores": 2,
        "threads": 2, "seed": 3, "source": "simulated: fingertip", "data_digest": "d1ge57",
    });
    let picture = |name: &str, kind: &str, shape: &[usize]| {
        let values: Vec<f32> = (0..shape.iter().product()).map(|i| i as f32).collect();
        json!({"name": name, "kind": kind, "shape": shape, "values": values})
    };
    let verdict = json!({"network": "small-1d", "predicted": HOSTILE, "probability": 0.875, "right": false});
    let value = json!({
        "results": {
            "name": HOSTILE, "title": HOSTILE, "complete": true, "missing": [], "source": "simulated: fingertip",
            "data_digest": "d1ge57", "samples": 120, "sample_shape": [5, 50], "classes": [HOSTILE, "soft"],
            "protocol": {"kind": "k-fold", "folds": 2}, "folds": 2, "seed": 3, "unit": "percent", "networks": [],
            "left_out": {"svm": HOSTILE},
        },
        "protocol": "stratified 2-fold", "environment": environment, "judged_on": environment,
        "chance": 33.3, "networks": (0..NETWORKS.len()).map(network).collect::<Vec<_>>(), "stress": stress(), "early": early(), "certainty": certainty(),
        "examples": [{
            "origin": HOSTILE, "truth": "soft", "verdicts": [verdict],
            "pictures": [
                picture("reading", "lines", &[2, 6]), picture("image", "colour", &[3, 4, 4]),
                picture("tensor", "frames", &[2, 4, 3]), picture("grey", "grey", &[2, 3]),
            ],
        }],
    });
    serde_json::from_value(value).unwrap()
}

/// Makes a choice of the judgement.
pub(super) fn choice() -> Choice {
    let criteria = Criteria {
        cost: CostKind::Latency,
        alpha: 0.05,
        max_loss: None,
        margin: Some(5.0),
        clean_only: false,
        room: None,
    };
    let evidence = |network: &str, difference: f64| Evidence {
        network: network.into(),
        score: 93.5 + difference,
        difference,
        interval: (difference < 0.0).then_some([difference - 1.0, difference + 1.0]),
        p: (difference < 0.0).then_some(0.25),
        test: (difference < 0.0).then_some(Test::NadeauBengio),
        p_holm: (difference < 0.0).then_some(0.5),
        worse: false,
        cost: Some(0.02),
        mean_loss: Some(16.5),
        breaks_at_1: vec![],
        refused: None,
    };
    Choice {
        criteria,
        primary: Default::default(),
        test: Test::NadeauBengio,
        best: "large-2d".into(),
        chosen: Some("small-1d".into()),
        passed_over: None,
        steadier: None,
        enough_data: false,
        evidence: vec![evidence("small-1d", -2.25), evidence("large-2d", 0.0)],
        words: vec![format!("small-1d: {HOSTILE}")],
    }
}
