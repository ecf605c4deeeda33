//! Baselines against NumPy and scikit-learn; `scripts/fixtures/baselines.py` writes their numbers.

#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::Value;
use taxel_baselines::{
    ALPHAS, Draws, FeatureMatrix, Fitted, Method, MiniRocket, Ridge, Series, Svm, SvmKernel,
};

fn fixture() -> Value {
    serde_json::from_str(include_str!("data/baselines.json")).unwrap()
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn singles(value: &Value) -> Vec<f32> {
    floats(value).iter().map(|v| *v as f32).collect()
}

fn whole(value: &Value) -> Vec<usize> {
    floats(value).iter().map(|v| *v as usize).collect()
}

fn argmax(rows: &[f32], classes: usize) -> Vec<usize> {
    let best = |row: &[f32]| (0..classes).fold(0, |best, i| if row[i] > row[best] { i } else { best });
    rows.chunks_exact(classes).map(best).collect()
}

fn close(what: &str, got: &[f32], want: &[f64], tolerance: f64) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let gap = (f64::from(*got) - want).abs();
        assert!(gap <= tolerance, "{what}[{i}]: got {got}, want {want}");
    }
}

#[test]
fn mini_rocket_agrees_with_numpy() {
    for case in fixture()["rocket"].as_array().unwrap() {
        let shape = whole(&case["shape"]);
        let (train, test) = (singles(&case["train"]), singles(&case["test"]));
        let train = Series::new(&train, shape[1], shape[2]).unwrap();
        let test = Series::new(&test, shape[1], shape[2]).unwrap();
        let features = case["features"].as_u64().unwrap() as usize;
        assert_eq!(
            MiniRocket::kernels(shape[2], features).unwrap(),
            84 * case["dilations"].as_array().unwrap().len()
        );
        let channels = case["channels"].as_array().unwrap().iter().map(whole).collect();
        let draws = Draws { examples: whole(&case["examples"]), channels };
        let rocket = MiniRocket::fit_with(&train, features, draws).unwrap();
        // Exact: sums of multiples of 2^-8, and one rounding to f32 on both sides.
        close("bias", rocket.biases(), &floats(&case["biases"]), 0.0);
        let rows = rocket.transform(&test).unwrap();
        close("features", &rows.values()[..features], &floats(&case["first_row"]), 1e-7);
        for (row, want) in rows.values().chunks_exact(features).zip(floats(&case["rows"])) {
            let sum: f64 = row.iter().enumerate().map(|(i, v)| (i + 1) as f64 * f64::from(*v)).sum();
            assert!((sum - want).abs() <= 1e-6 * want, "{sum} and {want}");
        }
    }
}

#[test]
fn draws_follow_the_seed_and_short_series_are_refused() {
    let x: Vec<f32> = (0..5 * 4 * 20).map(|i| (i as f32).sin()).collect();
    let series = Series::new(&x, 4, 20).unwrap();
    let fit = |seed, purpose: &str| MiniRocket::fit(&series, 500, seed, purpose).unwrap();
    assert_eq!(fit(1, "a"), fit(1, "a"));
    assert_ne!(fit(1, "a"), fit(2, "a"));
    assert_ne!(fit(1, "a"), fit(1, "b"));
    let short = Series::new(&x, 50, 8).unwrap();
    let error = MiniRocket::fit(&short, 500, 0, "a").unwrap_err().to_string();
    assert_eq!(error, "MiniRocket needs at least 9 readings in time, the recordings have 8");
    assert_eq!(Method::MiniRocket { features: 500 }.unfit(10, 8).unwrap(), error);
    assert!(Method::SvmRbf { c: 1.0 }.unfit(8001, 8).is_some());
}

#[test]
fn ridge_agrees_with_scikit_learn() {
    for case in fixture()["classifiers"].as_array().unwrap() {
        let (classes, width) = (case["classes"].as_u64().unwrap() as usize, case["width"].as_u64().unwrap());
        let y: Vec<u32> = whole(&case["y"]).iter().map(|v| *v as u32).collect();
        let features = |key: &str| FeatureMatrix::new(singles(&case[key]), width as usize);
        let ridge = Ridge::fit(&features("train"), &y, classes, &ALPHAS).unwrap();
        assert!((ridge.alpha() / case["alpha"].as_f64().unwrap() - 1.0).abs() <= 1e-12, "{}", ridge.alpha());
        let error = case["error"].as_f64().unwrap();
        assert!((ridge.error() - error).abs() <= 1e-9 * error, "{} and {error}", ridge.error());
        close("ridge", &ridge.decide(&features("test")), &floats(&case["ridge"]), 1e-5);
    }
}

#[test]
fn machines_and_neighbours_agree_with_scikit_learn() {
    for case in fixture()["classifiers"].as_array().unwrap() {
        let (classes, width) = (case["classes"].as_u64().unwrap() as usize, case["width"].as_u64().unwrap());
        let y: Vec<u32> = whole(&case["y"]).iter().map(|v| *v as u32).collect();
        let (train, test) = (singles(&case["train"]), singles(&case["test"]));
        let train = Series::new(&train, 1, width as usize).unwrap();
        let test = Series::new(&test, 1, width as usize).unwrap();
        let fit = |method: Method| method.fit(&train, &y, classes, 0, "twin").unwrap();
        for (kernel, name) in [(SvmKernel::Linear, "linear"), (SvmKernel::Rbf, "rbf")] {
            let fitted = fit(match kernel {
                SvmKernel::Linear => Method::SvmLinear { c: 1.0 },
                SvmKernel::Rbf => Method::SvmRbf { c: 1.0 },
            });
            let Fitted::Svm(svm) = &fitted else { panic!("no machine") };
            let svm: &Svm = svm;
            close(name, &svm.decide(&test).unwrap(), &floats(&case[format!("svm_{name}")]), 1e-3);
            let predicted = argmax(&fitted.scores(&test).unwrap(), classes);
            assert_eq!(predicted, whole(&case[format!("svm_{name}_predicted")]), "{name}");
            assert!(fitted.macs() > 0 && fitted.parameters() > 0);
        }
        for k in [1, 3] {
            let scores = fit(Method::NearestNeighbours { k }).scores(&test).unwrap();
            assert_eq!(argmax(&scores, classes), whole(&case[format!("nearest_{k}")]), "{k} neighbours");
        }
        if width >= 9 {
            let scores = fit(Method::MiniRocket { features: 168 }).scores(&test).unwrap();
            assert!(scores.chunks(classes).all(|row| (row.iter().sum::<f32>() - 1.0).abs() < 1e-5));
        }
    }
}

#[test]
fn labels_and_readings_are_checked() {
    let x = [1.0, 2.0, 3.0, 4.0];
    let series = Series::new(&x, 1, 2).unwrap();
    let fit = |y: &[u32]| Method::Majority.fit(&series, y, 2, 0, "doc").map(|_| ()).unwrap_err().to_string();
    assert_eq!(fit(&[0]), "1 labels for 2 samples; one each is needed");
    assert_eq!(fit(&[0, 2]), "label 2 is not one of 2 classes");
    assert!(Series::new(&x, 1, 3).is_err() && Series::new(&[], 1, 2).is_err());
    let error = Series::new(&[1.0, f32::NAN], 1, 1).unwrap_err().to_string();
    assert!(error.starts_with("sample 1 holds NaN"), "{error}");
    let fitted = Method::Majority.fit(&series, &[1, 1], 2, 0, "doc").unwrap();
    assert_eq!(fitted.scores(&series).unwrap(), [0.0, 1.0, 0.0, 1.0]);
    let machine = Method::SvmRbf { c: 1.0 }.fit(&series, &[1, 1], 2, 0, "one class").unwrap();
    assert_eq!(machine.scores(&series).unwrap(), [0.5; 4]);
    let other = Series::new(&x, 2, 1).unwrap();
    assert!(machine.scores(&other).unwrap_err().to_string().contains("fitted to 1 channels × 2"));
}

#[test]
fn one_recording_gets_the_scores_of_many_bit_for_bit() {
    let (channels, length, classes) = (3, 40, 4);
    let values = |n: usize, salt: usize| -> Vec<f32> {
        (0..n * channels * length).map(|i| ((i * 37 + salt) % 101) as f32 * 0.37 - 18.0).collect()
    };
    let (train, test) = (values(70, 0), values(37, 11));
    let y: Vec<u32> = (0..70).map(|i| i % classes).collect();
    let train = Series::new(&train, channels, length).unwrap();
    let test = Series::new(&test, channels, length).unwrap();
    let several = [
        Method::NearestNeighbours { k: 5 },
        Method::NearestNeighbours { k: 70 },
        Method::ExtraTrees { trees: 7, min_samples_leaf: 3 },
    ];
    for method in Method::all().into_iter().chain(several) {
        let fitted = method.fit(&train, &y, classes as usize, 0, "one").unwrap();
        let all = fitted.scores(&test).unwrap();
        let (mut workspace, mut scores) = (fitted.workspace(), vec![0.0; classes as usize]);
        for (i, want) in all.chunks(classes as usize).enumerate() {
            fitted.predict_one(test.sample(i), &mut workspace, &mut scores).unwrap();
            let bits = |x: &[f32]| x.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&scores), bits(want), "{}, recording {i}", method.name());
        }
        if method != Method::Majority {
            assert!(fitted.predict_one(&[0.0], &mut workspace, &mut scores).is_err(), "{}", method.name());
        }
        assert!(fitted.predict_one(test.sample(0), &mut workspace, &mut [0.0]).is_err());
    }
}

/// Of equally far neighbours the first of the training part votes.
#[test]
fn ties_go_to_the_first() {
    let x = [0.0, 2.0, 2.0, 0.0, 1.0, 1.0];
    let train = Series::new(&x, 1, 1).unwrap();
    let scores = |k: usize, y: &[u32], at: f32| {
        let fitted = Method::NearestNeighbours { k }.fit(&train, y, 3, 0, "ties").unwrap();
        argmax(&fitted.scores(&Series::new(&[at], 1, 1).unwrap()).unwrap(), 3)[0]
    };
    assert_eq!(scores(1, &[2, 1, 1, 1, 1, 1], 0.0), 2);
    assert_eq!(scores(1, &[1, 1, 1, 1, 0, 2], 1.0), 0);
    assert_eq!(scores(2, &[0, 1, 2, 1, 2, 2], 0.0), 0);
    // Two votes each: the class of the nearest.
    assert_eq!(scores(4, &[0, 1, 1, 2, 2, 0], 0.0), 0);
}
