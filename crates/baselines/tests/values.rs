//! Baselines for values against scikit-learn; `scripts/fixtures/values.py` writes its numbers.

#![allow(clippy::unwrap_used, clippy::panic)]

use allocation_counter::measure;
use serde_json::Value;
use taxel_baselines::{ALPHAS, Error, Fitted, Method, MiniRocket, Ridge, Saved, Series};

fn fixture() -> Value {
    serde_json::from_str(include_str!("data/values.json")).unwrap()
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn singles(value: &Value) -> Vec<f32> {
    floats(value).iter().map(|v| *v as f32).collect()
}

fn close(what: &str, got: &[f32], want: &[f64], tolerance: f64) {
    assert_eq!(got.len(), want.len(), "{what}");
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let gap = (f64::from(*got) - want).abs();
        assert!(gap <= tolerance * want.abs().max(1.0), "{what}[{i}]: got {got}, want {want}");
    }
}

/// Recordings of 2 channels and 40 steps, and two values of each: how high it lies, and how high its last step.
fn presses(n: usize, salt: usize) -> (Vec<f32>, Vec<f32>) {
    let noise = |i: usize| (((i + salt) * 7919 + i / 13) % 997) as f32 / 997.0;
    let height = |sample: usize| ((sample * 37 + salt) % 101) as f32 / 10.0;
    let x = (0..n * 80).map(|i| height(i / 80) * (1.0 + (i % 40) as f32 / 40.0) + noise(i)).collect();
    (x, (0..n).flat_map(|sample| [height(sample), 2000.0 * height(sample) - 7.0]).collect())
}

/// The methods of values with settings that fit quickly.
fn methods() -> [Method; 6] {
    [
        Method::Mean,
        Method::Ridge,
        Method::NearestNeighbours { k: 1 },
        Method::NearestNeighbours { k: 4 },
        Method::MiniRocket { features: 168 },
        Method::ExtraTrees { trees: 20, min_samples_leaf: 2 },
    ]
}

fn fitted(method: Method, n: usize) -> Fitted {
    let (x, y) = presses(n, 0);
    method.fit_values(&Series::new(&x, 2, 40).unwrap(), &y, 2, 3, "own").unwrap()
}

/// Share of the targets' variance that is predicted.
fn r2(truth: &[f32], predicted: &[f32]) -> f64 {
    let mean = truth.iter().map(|v| f64::from(*v)).sum::<f64>() / truth.len() as f64;
    let off = |a: f64, b: f64| (a - b) * (a - b);
    let left: f64 = truth.iter().zip(predicted).map(|(a, b)| off((*a).into(), (*b).into())).sum();
    1.0 - left / truth.iter().map(|a| off((*a).into(), mean)).sum::<f64>()
}

#[test]
fn mean_neighbours_and_ridge_agree_with_scikit_learn() {
    for case in fixture()["cases"].as_array().unwrap() {
        let (width, outputs) = (case["width"].as_u64().unwrap() as usize, 2);
        let (train, y, test) = (singles(&case["train"]), singles(&case["y"]), singles(&case["test"]));
        let train = Series::new(&train, 1, width).unwrap();
        let test = Series::new(&test, 1, width).unwrap();
        let fit = |method: Method| method.fit_values(&train, &y, outputs, 0, "twin").unwrap();
        close("mean", &fit(Method::Mean).scores(&test).unwrap(), &floats(&case["mean"]), 1e-6);
        for k in [1, 5] {
            let got = fit(Method::NearestNeighbours { k }).scores(&test).unwrap();
            close("neighbours", &got, &floats(&case[format!("nearest_{k}")]), 1e-6);
        }
        let ridge = fit(Method::Ridge);
        close("ridge", &ridge.scores(&test).unwrap(), &floats(&case["ridge"]), 1e-5);
        let tensors = ridge.tensors();
        let (_, _, alpha) = tensors.iter().find(|(name, ..)| *name == "ridge.alpha").unwrap();
        close("alpha", alpha, &[case["alpha"].as_f64().unwrap()], 1e-6);
    }
}

#[test]
fn trees_predict_as_well_as_those_of_scikit_learn() {
    let case = &fixture()["friedman"];
    let (x, y) = (singles(&case["x"]), singles(&case["y"]));
    let (width, n) = (case["width"].as_u64().unwrap() as usize, case["train"].as_u64().unwrap() as usize);
    // Channels of one step: the features are the readings.
    let train = Series::new(&x[..n * width], width, 1).unwrap();
    let test = Series::new(&x[n * width..], width, 1).unwrap();
    let theirs = floats(&case["r2"]);
    let mean = theirs.iter().sum::<f64>() / theirs.len() as f64;
    let squares: f64 = theirs.iter().map(|r2| (r2 - mean).powi(2)).sum();
    let sd = (squares / (theirs.len() - 1) as f64).sqrt();
    let [.., method] = Method::of_values();
    let mut sum = 0.0;
    for seed in 0..10 {
        let trees = method.fit_values(&train, &y[..n], 1, seed, "friedman").unwrap();
        let ours = r2(&y[n..], &trees.scores(&test).unwrap());
        assert!((ours - mean).abs() <= 0.02 + 2.0 * sd, "seed {seed}: {ours}, and {mean} ± {sd}");
        sum += ours / 10.0;
    }
    println!("R2 of ours {sum:.4}, of scikit-learn's {mean:.4} ± {sd:.4}");
    assert!((sum - mean).abs() <= 2.0 * sd, "{sum}, and {mean} ± {sd}");
}

/// Returns the share of pairs of one sample of each class that scores bring in the right order.
fn auroc(is_high: &[bool], scores: &[f32]) -> f64 {
    let of = |class: bool| {
        scores.iter().zip(is_high).filter(move |(_, is)| **is == class).map(|(score, _)| *score)
    };
    let order =
        |high: f32, low: f32| f64::from(u8::from(high > low)) + 0.5 * f64::from(u8::from(high == low));
    let right: f64 = of(true).map(|high| of(false).map(|low| order(high, low)).sum::<f64>()).sum();
    right / (of(true).count() * of(false).count()) as f64
}

#[test]
fn trees_tell_classes_as_well_as_those_of_scikit_learn() {
    let case = &fixture()["friedman"];
    let (x, y) = (singles(&case["x"]), singles(&case["y"]));
    let (width, n) = (case["width"].as_u64().unwrap() as usize, case["train"].as_u64().unwrap() as usize);
    let train = Series::new(&x[..n * width], width, 1).unwrap();
    let test = Series::new(&x[n * width..], width, 1).unwrap();
    let is_high: Vec<bool> = y.iter().map(|y| *y > case["high_above"].as_f64().unwrap() as f32).collect();
    let labels: Vec<u32> = is_high.iter().map(|is| u32::from(*is)).collect();
    let theirs = floats(&case["auroc"]);
    let mean = theirs.iter().sum::<f64>() / theirs.len() as f64;
    let method = Method::ExtraTrees { trees: 100, min_samples_leaf: 2 };
    let mut sum = 0.0;
    for seed in 0..10 {
        let trees = method.fit(&train, &labels[..n], 2, seed, "friedman").unwrap();
        let scores = trees.scores(&test).unwrap();
        assert!(
            scores.chunks_exact(2).all(|row| row.iter().all(|share| (0.0..=1.0).contains(share))
                && (row[0] + row[1] - 1.0).abs() < 1e-5)
        );
        let second: Vec<f32> = scores.chunks_exact(2).map(|row| row[1]).collect();
        sum += auroc(&is_high[n..], &second) / 10.0;
    }
    println!("AUROC of ours {sum:.4}, of scikit-learn's {mean:.4}");
    assert!((sum - mean).abs() <= 0.005, "{sum}, and {mean}");
}

/// A second output that is the same but for its unit changes no split.
#[test]
fn units_do_not_decide_the_splits() {
    let (x, _) = presses(60, 0);
    let series = Series::new(&x, 2, 40).unwrap();
    let y: Vec<f32> = (0..60).map(|i| (i * 29 % 31) as f32).collect();
    let scaled: Vec<f32> = y.iter().flat_map(|v| [*v, 1024.0 * v]).collect();
    let method = Method::ExtraTrees { trees: 5, min_samples_leaf: 1 };
    let one = method.fit_values(&series, &y, 1, 0, "own").unwrap().scores(&series).unwrap();
    let two = method.fit_values(&series, &scaled, 2, 0, "own").unwrap().scores(&series).unwrap();
    for (one, two) in one.iter().zip(two.chunks_exact(2)) {
        assert!((one - two[0]).abs() < 1e-4 && (1024.0 * one - two[1]).abs() < 1e-1, "{one} {two:?}");
    }
    // Leaves of one sample each know it.
    close("own", &one, &y.iter().map(|v| f64::from(*v)).collect::<Vec<_>>(), 1e-5);
}

#[test]
fn what_was_learned_holds_for_others() {
    let (x, y) = presses(40, 11);
    let series = Series::new(&x, 2, 40).unwrap();
    for method in methods() {
        let predicted = fitted(method, 120).scores(&series).unwrap();
        for output in 0..2 {
            let column = |rows: &[f32]| rows.iter().skip(output).step_by(2).copied().collect::<Vec<f32>>();
            let found = r2(&column(&y), &column(&predicted));
            let least = if method == Method::Mean { -0.1 } else { 0.95 };
            assert!(found > least, "{method:?}, output {output}: R2 {found}");
        }
    }
}

/// Whole waves of any phase at a height that is small against them, which MiniRocket's shares of time hardly tell.
#[test]
fn mini_rocket_for_values_knows_the_level() {
    let level = |sample: usize| (sample * 37 % 101) as f32 / 101.0;
    let wave = |sample: usize, t: usize| 3.0 * (t as f32 * 0.314_159_27 + (sample * 53 % 97) as f32).sin();
    let x: Vec<f32> = (0..120 * 40).map(|i| level(i / 40) + wave(i / 40, i % 40)).collect();
    let y: Vec<f32> = (0..120).map(level).collect();
    let train = Series::new(&x[..80 * 40], 1, 40).unwrap();
    let test = Series::new(&x[80 * 40..], 1, 40).unwrap();
    let method = Method::MiniRocket { features: 168 };
    let own = method.fit_values(&train, &y[..80], 1, 0, "own").unwrap().scores(&test).unwrap();
    let shares = MiniRocket::fit(&train, 168, 0, "own").unwrap();
    let ridge = Ridge::fit_values(&shares.transform(&train).unwrap(), &y[..80], 1, &ALPHAS).unwrap();
    let without = ridge.decide(&shares.transform(&test).unwrap());
    let (with, without) = (r2(&y[80..], &own), r2(&y[80..], &without));
    assert!(1.0 - with < 0.3 * (1.0 - without), "R2 {with} with the level, {without} without");
}

#[test]
fn one_recording_gets_the_values_of_many_bit_for_bit_and_allocates_nothing() {
    let (x, _) = presses(37, 11);
    let series = Series::new(&x, 2, 40).unwrap();
    for method in methods() {
        let fitted = fitted(method, 70);
        let all = fitted.decide(&series).unwrap();
        assert_eq!(fitted.scores(&series).unwrap(), all);
        let (mut workspace, mut values) = (fitted.workspace(), [0.0; 2]);
        for (i, want) in all.chunks_exact(2).enumerate() {
            fitted.decide_one(series.sample(i), &mut workspace, &mut values).unwrap();
            assert_eq!(values.map(f32::to_bits), [want[0], want[1]].map(f32::to_bits), "{method:?}, {i}");
        }
        let allocated = measure(|| {
            fitted.decide_one(series.sample(0), &mut workspace, &mut values).unwrap();
        });
        assert_eq!(allocated.count_total, 0, "{method:?}");
        assert!(fitted.decide_one(series.sample(0), &mut workspace, &mut [0.0]).is_err());
        if method != Method::Mean {
            assert!(fitted.decide_one(&[0.0], &mut workspace, &mut values).is_err(), "{method:?}");
            let mut broken = series.sample(0).to_vec();
            broken[5] = f32::NAN;
            let error = fitted.decide_one(&broken, &mut workspace, &mut values).unwrap_err();
            assert!(matches!(error, Error::NotFinite { .. }), "{method:?}: {error}");
            let other = Series::new(&x, 1, 80).unwrap();
            assert!(fitted.scores(&other).unwrap_err().to_string().contains("fitted to 2 channels"));
        }
    }
}

#[test]
fn threads_change_no_byte_and_seeds_do() {
    let run = |threads: usize, method: Method| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fitted(method, 70).tensors())
    };
    for method in methods() {
        assert_eq!(run(1, method), run(3, method), "{method:?}");
    }
    let (x, y) = presses(70, 0);
    let series = Series::new(&x, 2, 40).unwrap();
    let fit = |seed, purpose| methods()[5].fit_values(&series, &y, 2, seed, purpose).unwrap();
    assert_eq!(fit(1, "a"), fit(1, "a"));
    assert_ne!(fit(1, "a"), fit(2, "a"));
    assert_ne!(fit(1, "a"), fit(1, "b"));
}

/// Reads what was fitted, with one array as `change` leaves it.
fn read_again(method: Method, name: &str, change: impl Fn(&mut Vec<f32>)) -> taxel_baselines::Result<Fitted> {
    let mut tensors = fitted(method, 30).tensors();
    tensors.iter_mut().filter(|(own, ..)| *own == name).for_each(|(_, _, data)| change(data));
    let mut saved = Saved::default();
    for (name, shape, data) in &tensors {
        assert!(!name.is_empty() && shape.iter().product::<usize>() >= data.len().min(1));
        saved.insert(name, data);
    }
    Fitted::read_values(&method, [2, 40], 2, &saved)
}

#[test]
fn what_was_fitted_is_read_again() {
    for method in methods() {
        let (read, fitted) = (read_again(method, "", |_| {}).unwrap(), fitted(method, 30));
        // A ridge's penalty is rounded in the file.
        assert_eq!(read.tensors(), fitted.tensors(), "{method:?}");
        let (x, _) = presses(9, 11);
        let series = Series::new(&x, 2, 40).unwrap();
        assert_eq!(read.scores(&series).unwrap(), fitted.scores(&series).unwrap(), "{method:?}");
        assert!(fitted.parameters() > 0 && (fitted.macs() > 0) == (method != Method::Mean), "{method:?}");
        for (name, shape, data) in fitted.tensors() {
            assert_eq!(shape.iter().product::<usize>(), data.len(), "{name}");
            let error = read_again(method, name, |data| data.truncate(data.len() - 1));
            assert!(error.is_err(), "{method:?} with a shorter {name}");
        }
    }
}

#[test]
fn damaged_trees_are_refused() {
    let method = methods()[5];
    let refused = |name: &str, change: &dyn Fn(&mut Vec<f32>)| {
        let error = read_again(method, name, change).unwrap_err().to_string();
        assert!(error.starts_with("saved array trees."), "{error}");
        error
    };
    // The first node parts: beyond its tree, back to itself, to the next node, between two nodes, or nowhere.
    for child in [1e9, -1.0, 0.0, 1.0, 2.5, f32::NAN, f32::INFINITY] {
        let error = refused("trees.right", &|right| right[0] = child);
        assert!(error.contains("is no later node of its tree"), "{child}: {error}");
    }
    for feature in [22.0, -2.0, 0.5, f32::NAN] {
        let error = refused("trees.feature", &|features| features[0] = feature);
        assert!(error.contains("is no feature of the series"), "{feature}: {error}");
    }
    // Fewer leaves than values, and a tree whose last node parts.
    refused("trees.feature", &|features| features[0] = -1.0);
    refused("trees.feature", &|features| *features.last_mut().unwrap() = 0.0);
    refused("trees.threshold", &|thresholds| thresholds[0] = f32::NAN);
    refused("trees.values", &|values| values[3] = f32::INFINITY);
    for size in [0.0, -3.0, 1e12, 2.5, f32::NAN] {
        refused("trees.sizes", &|sizes| sizes[0] = size);
    }
    refused("trees.sizes", &|sizes| sizes[0] += 1.0);
    refused("trees.sizes", &|sizes| sizes.push(1.0));
}

#[test]
fn values_and_settings_are_checked() {
    let (x, y) = presses(30, 0);
    let series = Series::new(&x, 2, 40).unwrap();
    let refused = |method: Method, y: &[f32], outputs: usize| {
        method.fit_values(&series, y, outputs, 0, "own").unwrap_err().to_string()
    };
    let mut broken = y.clone();
    broken[7] = f32::NAN;
    for method in methods() {
        assert!(refused(method, &y[1..], 2).contains("labels for 30 samples"));
        assert!(refused(method, &[], 0).contains("labels for 30 samples"));
        assert!(refused(method, &broken, 2).starts_with("the target of sample 3 is NaN"));
    }
    assert!(refused(Method::ExtraTrees { trees: 0, min_samples_leaf: 2 }, &y, 2).contains("trees = 0"));
    let leafless = Method::ExtraTrees { trees: 1, min_samples_leaf: 0 };
    assert!(refused(leafless, &y, 2).contains("min_samples_leaf = 0"));
    assert!(refused(Method::NearestNeighbours { k: 0 }, &y, 2).contains("k = 0"));
    let labels = vec![0; 30];
    for method in Method::all().into_iter().chain(Method::of_values()) {
        let (of_values, of_classes) =
            (method.fit_values(&series, &y, 2, 0, "own"), method.fit(&series, &labels, 2, 0, "own"));
        assert_eq!(of_values.is_ok(), method.learns_values(), "{method:?}");
        assert_eq!(of_classes.is_ok(), method.learns_classes(), "{method:?}");
        let error = of_values.and(of_classes);
        if let Err(error) = error {
            assert!(error.to_string().contains("and the targets are"), "{error}");
        }
    }
}

#[test]
fn settings_have_the_names_and_defaults_of_configs() {
    let read = |text: &str| serde_json::from_str::<Method>(text).unwrap();
    assert_eq!(
        Method::of_values().map(|m| m.name()),
        ["mean", "ridge", "k-nn", "mini-rocket", "extra-trees"]
    );
    for method in Method::of_values() {
        assert_eq!(read(&format!("{{\"name\": \"{}\"}}", method.name())), method);
    }
    let few = Method::ExtraTrees { trees: 7, min_samples_leaf: 3 };
    assert_eq!(read("{\"name\": \"extra-trees\", \"trees\": 7, \"min_samples_leaf\": 3}"), few);
}

/// Both ridges know it; that it is what ridges that are fitted anew would say is tested beside the closed form.
#[test]
fn samples_that_are_left_out_are_predicted_in_closed_form() {
    let (x, y) = presses(30, 0);
    let series = Series::new(&x, 2, 40).unwrap();
    let units: Vec<u32> = (0..30).map(|i| i / 3).collect();
    for method in methods() {
        let fitted = fitted(method, 30);
        let own = fitted.left_out_values(&series, &y, 2, &units).unwrap();
        let has = matches!(method, Method::Ridge | Method::MiniRocket { .. });
        assert_eq!(own.is_some(), has, "{method:?}");
        assert!(fitted.left_out_values(&series, &y, 1, &units).is_err(), "{method:?}");
        let Some(own) = own else { continue };
        assert_ne!(own, fitted.scores(&series).unwrap());
        assert!(r2(&y, &own) > 0.95, "{method:?}");
        assert!(fitted.left_out_values(&series, &y[2..], 2, &units).is_err(), "{method:?}");
        assert!(fitted.left_out_values(&series, &y, 2, &units[1..]).is_err(), "{method:?}");
    }
}
