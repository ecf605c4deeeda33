//! Samples with weights: a weight of 2 is two copies, in networks and baselines.

#![allow(clippy::unwrap_used)]

mod support;

use ndarray::Axis;
use serde_json::json;
use support::{mlp, presses, recipe, run, three_folds};
use taxel_baselines::Method;
use taxel_data::{Dataset, Layout, Quantity};
use taxel_learn::{Candidate, Encoding, fit};

/// 45 presses of weights 1 and 2, and the same with two copies of those of weight 2.
fn both() -> (Dataset, Dataset) {
    let one = presses(45, 12);
    let names = one.output_names();
    let weights: Vec<f32> = (0..45).map(|row| (1 + row % 2) as f32).collect();
    let rows: Vec<usize> = (0..45).flat_map(|row| vec![row; 1 + row % 2]).collect();
    let labels: Vec<&str> = rows.iter().map(|&row| names[one.strata()[row] as usize].as_str()).collect();
    let copies = Dataset::new("presses", Layout::Series, one.x.select(Axis(0), &rows), &labels).unwrap();
    (one.with_weights(&weights).unwrap(), copies)
}

fn raw() -> Encoding {
    serde_json::from_value(json!({ "signal": { "scale": "raw" } })).unwrap()
}

/// The largest difference between the answers of two fits to the same recordings.
fn apart(candidate: &Candidate, [one, two]: [&Dataset; 2], x: &Dataset) -> f32 {
    let [one, two] =
        [one, two].map(|dataset| fit(candidate, dataset, &raw()).unwrap().predict(&x.x).unwrap().outputs);
    one.iter().zip(two.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn a_weight_of_2_is_two_copies() {
    let (weighted, copies) = both();
    let plain = presses(45, 12);
    let step = json!({ "epochs": 30, "batch_size": 80, "optimizer": { "name": "sgdm", "lr": 0.003 } });
    for changes in [json!({}), json!({ "label_smoothing": 0.1 }), json!({ "loss": "hinge" })] {
        let mut step = step.clone();
        step.as_object_mut().unwrap().extend(changes.as_object().unwrap().clone());
        let candidate = mlp(&plain, recipe(step));
        let (same, other) =
            (apart(&candidate, [&weighted, &copies], &plain), apart(&candidate, [&weighted, &plain], &plain));
        assert!(
            same < 2e-4 && other > 10.0 * same,
            "{changes}: {same} from copies, {other} from equal weights"
        );
    }
    let majority = Candidate::baseline(Method::Majority);
    assert!(apart(&majority, [&weighted, &copies], &plain) < 1e-6);
}

#[test]
fn only_ratios_of_weights_count() {
    let plain = presses(45, 12);
    let tripled = plain.clone().with_weights(&[3.0; 45]).unwrap();
    let force = vec![Quantity { name: "force".into(), unit: None }];
    let values: Vec<f32> = (0..45).map(|row| (row % 7) as f32).collect();
    let plain_values = plain.clone().with_values(force.clone(), values.clone()).unwrap();
    let tripled_values = plain.clone().with_values(force, values).unwrap().with_weights(&[3.0; 45]).unwrap();
    let ridge = Candidate::baseline(Method::Ridge);
    assert_eq!(apart(&ridge, [&plain_values, &tripled_values], &plain), 0.0);
    let network = mlp(&plain, recipe(json!({})));
    assert!(apart(&network, [&plain, &tripled], &plain) < 1e-4);
    assert_ne!(plain.digest, tripled.digest);
}

#[test]
fn samples_of_weight_0_are_left_out_and_bad_weights_refused() {
    let plain = presses(6, 12);
    let kept = plain.clone().with_weights(&[1.0, 0.0, 2.0, 0.0, 1.0, 1.0]).unwrap();
    assert_eq!((kept.len(), kept.weights.as_deref()), (4, Some(&[1.0, 2.0, 1.0, 1.0][..])));
    for (bad, words) in [
        (vec![1.0; 5], "weights has 5 entries but x has 6"),
        (vec![-1.0; 6], "weights is -1, which is negative"),
        (vec![f32::NAN; 6], "weights is NaN"),
        (vec![0.0; 6], "for every sample"),
    ] {
        let error = plain.clone().with_weights(&bad).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn methods_that_take_no_weights_are_left_out_with_the_reason() {
    let weights: Vec<f32> = (0..45).map(|row| (1 + row % 2) as f32).collect();
    let dataset = presses(45, 12).with_weights(&weights).unwrap();
    let methods = [Method::Majority, Method::NearestNeighbours { k: 1 }];
    let error = fit(&Candidate::baseline(methods[1]), &dataset, &raw()).unwrap_err().to_string();
    assert!(error.contains("counts all samples alike, and these have weights"), "{error}");
    let (_keep, folder) =
        run(three_folds(&dataset, vec![Candidate::baseline(methods[0]), mlp(&dataset, recipe(json!({})))]));
    assert!(folder.results().unwrap().complete);
}
