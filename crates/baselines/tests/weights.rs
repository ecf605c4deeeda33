//! Methods whose samples have weights, against scikit-learn.

#![allow(clippy::unwrap_used)]

use serde_json::Value;
use taxel_baselines::{ALPHAS, FeatureMatrix, Method, Ridge, Series};

fn singles(value: &Value) -> Vec<f32> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect()
}

fn close(got: &[f32], want: &[f32], about: &str) {
    assert_eq!(got.len(), want.len(), "{about}");
    for (got, want) in got.iter().zip(want) {
        assert!((got - want).abs() <= 2e-5 * want.abs().max(1.0), "{about}: {got} and {want}");
    }
}

#[test]
fn ridge_and_mean_of_weighted_samples_agree_with_scikit_learn() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("data/weights.json")).unwrap();
    for case in &cases {
        let width = case["width"].as_u64().unwrap() as usize;
        let [train, test, targets, weights] =
            ["train", "test", "targets", "weights"].map(|key| singles(&case[key]));
        let train = Series::new(&train, width, 1).unwrap().weighted(&weights).unwrap();
        let test = Series::new(&test, width, 1).unwrap();
        for (method, key) in [(Method::Ridge, "ridge"), (Method::Mean, "mean")] {
            let fitted = method.fit_values(&train, &targets, 2, 0, "twin").unwrap();
            let want = singles(&case[key]);
            close(&fitted.scores(&test).unwrap()[..want.len()], &want, &format!("{key} of {width}"));
        }
        let x = FeatureMatrix::new(singles(&case["train"]), width).weighted(Some(&weights));
        let ridge = Ridge::fit_values(&x, &targets, 2, &ALPHAS).unwrap();
        let (alpha, error) = (case["alpha"].as_f64().unwrap(), case["error"].as_f64().unwrap());
        assert!((ridge.alpha() - alpha).abs() < 1e-9 * alpha, "{} and {alpha}", ridge.alpha());
        assert!((ridge.error() - error).abs() < 1e-6 * error, "{} and {error}", ridge.error());
        // What is left out alone is predicted by the others, in the unit of the targets: its weighted errors are those above.
        let units: Vec<u32> = (0..weights.len() as u32).collect();
        let left_out = ridge.left_out_values(&x, &targets, &units).unwrap();
        let squares =
            left_out.chunks(2).zip(targets.chunks(2)).zip(&weights).map(|((said, truth), weight)| {
                let square = |(said, truth): (&f32, &f32)| f64::from(said - truth).powi(2);
                f64::from(*weight) * said.iter().zip(truth).map(square).sum::<f64>()
            });
        let mean = squares.sum::<f64>() / (2.0 * weights.iter().map(|w| f64::from(*w)).sum::<f64>());
        assert!((mean - error).abs() < 1e-4 * error, "{mean} and {error}");
    }
}

#[test]
fn a_sample_of_weight_2_counts_as_two() {
    let x: Vec<f32> = (0..60).map(|i| ((i * 37) % 23) as f32 - (i % 3) as f32).collect();
    let y: Vec<f32> = (0..20).map(|i| ((i * 7) % 11) as f32).collect();
    let weights: Vec<f32> = (0..20).map(|i| (1 + i % 2) as f32).collect();
    let rows: Vec<usize> = (0..20).flat_map(|i| vec![i; 1 + i % 2]).collect();
    let twice: Vec<f32> = rows.iter().flat_map(|row| x[row * 3..row * 3 + 3].to_vec()).collect();
    let targets: Vec<f32> = rows.iter().map(|row| y[*row]).collect();
    for alpha in ALPHAS {
        let weighted = FeatureMatrix::new(x.clone(), 3).weighted(Some(&weights));
        let one = Ridge::fit_values(&weighted, &y, 1, &[alpha]).unwrap();
        let two = Ridge::fit_values(&FeatureMatrix::new(twice.clone(), 3), &targets, 1, &[alpha]).unwrap();
        close(&one.decide(&weighted), &two.decide(&weighted), &format!("penalty {alpha}"));
    }
    let labels = |y: &[f32]| y.iter().map(|v| u32::from(*v > 5.0)).collect::<Vec<_>>();
    let (series, copies) = (Series::new(&x, 3, 1).unwrap(), Series::new(&twice, 3, 1).unwrap());
    let one = Method::Majority.fit(&series.weighted(&weights).unwrap(), &labels(&y), 2, 0, "one").unwrap();
    let two = Method::Majority.fit(&copies, &labels(&targets), 2, 0, "two").unwrap();
    close(&one.scores(&series).unwrap(), &two.scores(&series).unwrap(), "majority");
}

#[test]
fn methods_that_count_all_alike_refuse_weights() {
    let x = [1.0, 2.0, 3.0, 4.0];
    let series = Series::new(&x, 1, 1).unwrap();
    let weighted = series.weighted(&[1.0, 2.0, 1.0, 1.0]).unwrap();
    for method in
        [Method::NearestNeighbours { k: 1 }, Method::SvmLinear { c: 1.0 }, Method::SvmRbf { c: 1.0 }]
    {
        let error = method.fit(&weighted, &[0, 1, 0, 1], 2, 0, "refused").unwrap_err().to_string();
        assert!(error.contains("takes no weights"), "{error}");
        assert!(!method.takes_weights());
    }
    let trees = Method::ExtraTrees { trees: 3, min_samples_leaf: 1 };
    let error = trees.fit_values(&weighted, &x, 1, 0, "refused").unwrap_err().to_string();
    assert!(error.contains("takes no weights"), "{error}");
    for bad in [&[1.0, 2.0][..], &[0.0; 4], &[-1.0; 4], &[f32::NAN; 4]] {
        assert!(series.weighted(bad).is_err(), "{bad:?}");
    }
}
