//! Scores against scikit-learn's; `scripts/fixtures/metrics.py` writes its numbers.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use serde_json::Value;
use taxel_trainer::metrics::{Confusion, Scores, argmax, mean_sd, softmax};

fn labels(value: &Value) -> Vec<u32> {
    value.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect()
}

#[test]
fn scores_agree_with_scikit_learn() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("data/metrics.json")).unwrap();
    assert_eq!(cases.len(), 8);
    for case in cases {
        let classes = case["classes"].as_u64().unwrap() as usize;
        let confusion = Confusion::new(&labels(&case["true"]), &labels(&case["predicted"]), classes).unwrap();
        for (name, got) in Scores::NAMES.into_iter().zip(confusion.scores().values()) {
            let want = case[name].as_f64().unwrap();
            assert!((got - want).abs() <= 1e-9, "{}: {name}: got {got}, want {want}", case["name"]);
        }
        let want: Vec<Vec<u64>> = serde_json::from_value(case["confusion"].clone()).unwrap();
        assert_eq!(confusion.counts(), want, "{}", case["name"]);
    }
}

#[test]
fn labels_that_do_not_pair_up_are_refused() {
    let text =
        |truth: &[u32], predicted: &[u32]| Confusion::new(truth, predicted, 2).unwrap_err().to_string();
    assert_eq!(text(&[0, 1], &[0]), "predicted labels: 1 for 2 true ones; one each is needed");
    assert_eq!(text(&[], &[]), "predicted labels: 0 for 0 true ones; one each is needed");
    assert_eq!(text(&[0], &[2]), "labels: true 0, predicted 2 of 2 classes");
}

#[test]
fn deviation_is_the_samples_own() {
    // numpy.std([87, 89, 90.5, 86, 88], ddof=1)
    let (mean, sd) = mean_sd(&[87.0, 89.0, 90.5, 86.0, 88.0]);
    assert!((mean - 88.1).abs() <= 1e-12, "{mean}");
    assert!((sd.unwrap() - 1.7464249196572974).abs() <= 1e-12, "{sd:?}");
    assert_eq!(mean_sd(&[3.0]), (3.0, None));
}

#[test]
fn softmax_survives_large_logits() {
    let mut rows = [1000.0, 1000.0, 0.0, -1e30, 0.0, 2.0f32.ln()];
    softmax(&mut rows, 3);
    for (got, want) in rows.iter().zip([0.5, 0.5, 0.0, 0.0, 1.0 / 3.0, 2.0 / 3.0]) {
        assert!((got - want).abs() <= 1e-6, "{rows:?}");
    }
    assert_eq!(argmax(&rows, 3), [0, 2]);
}
