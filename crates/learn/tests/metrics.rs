//! Scores against scikit-learn's; `scripts/fixtures/metrics.py` writes its numbers.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use serde_json::Value;
use taxel_learn::metrics::{
    BINS, ClassScores, Clusters, Confusion, LevelScores, Levels, MacroScores, MeanEstimate, Scores, Terms,
    argmax, brier, calibration_error, log_loss, mean_sd, quantile, softmax,
};

fn labels(value: &Value) -> Vec<u32> {
    value.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect()
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn singles(value: &Value) -> Vec<f32> {
    floats(value).iter().map(|v| *v as f32).collect()
}

fn close(name: &str, got: f64, want: f64) {
    assert!((got - want).abs() <= 1e-9, "{name}: got {got}, want {want}");
}

fn same_scores(
    name: &str,
    scores: &MacroScores,
    per_class: &[ClassScores],
    confusion: &Confusion,
    want: &Value,
) {
    let MacroScores { accuracy, precision, recall, f1 } = *scores;
    for (score, got) in [("accuracy", accuracy), ("precision", precision), ("recall", recall), ("f1", f1)] {
        close(&format!("{name}: {score}"), got, want[score].as_f64().unwrap());
    }
    let each = want["per_class"].as_array().unwrap();
    assert_eq!(each.len(), per_class.len(), "{name}");
    for (class, (got, want)) in per_class.iter().zip(each).enumerate() {
        for (got, want) in [got.precision, got.recall, got.f1, got.support as f64].iter().zip(floats(want)) {
            close(&format!("{name}: class {class}"), *got, want);
        }
    }
    let want: Vec<Vec<u64>> = serde_json::from_value(want["confusion"].clone()).unwrap();
    assert_eq!(confusion.counts(), want, "{name}");
}

#[test]
fn scores_agree_with_scikit_learn() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("data/metrics.json")).unwrap();
    assert_eq!(cases.len(), 32);
    let (mut probable, mut absent) = (0, 0);
    for case in cases {
        let name = case["name"].as_str().unwrap();
        let classes = case["classes"].as_u64().unwrap() as usize;
        let (truth, predicted) = (labels(&case["true"]), labels(&case["predicted"]));
        let confusion = Confusion::new(&truth, &predicted, classes).unwrap();
        same_scores(name, &confusion.scores(), &confusion.per_class(), &confusion, &case);
        absent += usize::from(confusion.per_class().iter().any(|c| c.support == 0));
        if case["probabilities"].is_null() {
            continue;
        }
        probable += 1;
        let p = singles(&case["probabilities"]);
        assert_eq!(argmax(&p, classes), predicted, "{name}");
        let want = |key: &str| case[key].as_f64().unwrap();
        close(name, brier(&p, &truth, classes).unwrap(), want("brier"));
        close(name, log_loss(&p, &truth, classes).unwrap(), want("log_loss"));
        close(name, calibration_error(&p, &truth, classes, BINS).unwrap(), want("calibration_error"));
    }
    assert_eq!(probable, 24);
    assert!(absent >= 8, "{absent} cases with absent classes");
}

#[test]
fn bootstrap_means_and_quantiles_agree_with_numpy() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("data/metrics.json")).unwrap();
    for case in cases.iter().filter(|case| !case["drawn"].is_null()) {
        let name = case["name"].as_str().unwrap();
        let right: Vec<f64> = labels(&case["true"])
            .iter()
            .zip(labels(&case["predicted"]))
            .map(|(a, b)| f64::from(u8::from(*a == b)))
            .collect();
        let clusters = Clusters::new(&right, &labels(&case["clusters"]));
        close(name, clusters.mean(), case["accuracy"].as_f64().unwrap());
        let mut means = vec![];
        for (drawn, want) in case["drawn"].as_array().unwrap().iter().zip(floats(&case["drawn_means"])) {
            let drawn: Vec<usize> = labels(drawn).iter().map(|i| *i as usize).collect();
            means.push(clusters.mean_of(&drawn));
            close(name, means[means.len() - 1], want);
        }
        means.sort_by(f64::total_cmp);
        for (q, want) in [0.025, 0.5, 0.975].into_iter().zip(floats(&case["quantiles"])) {
            close(name, quantile(&means, q), want);
        }
    }
}

#[test]
fn intervals_widen_where_samples_come_in_groups() {
    // 400 samples, half of them right; then the same in 8 sessions that are all right or all wrong.
    let right: Vec<f64> = (0..400).map(|i| f64::from(i / 50 % 2)).collect();
    let samples: Vec<u32> = (0..400).collect();
    let sessions: Vec<u32> = samples.iter().map(|i| i / 50).collect();
    let interval = |groups: Option<&[u32]>| {
        MeanEstimate::of(&right, &samples, groups, Terms::Shares).unwrap().interval(0.95).unwrap()
    };
    let [low, high] = interval(None);
    // The normal approximation: 1.96 sqrt(0.25 / 400).
    assert!((low - 0.451).abs() <= 0.001 && (high - 0.549).abs() <= 0.001, "{low} {high}");
    let [low, high] = interval(Some(&sessions));
    // Wilson's of 4 in 8 is 0.215 to 0.785.
    assert!((0.15..0.28).contains(&low) && (low + high - 1.0).abs() < 1e-9, "{low} {high}");
}

#[test]
fn levels_agree_with_scikit_learn() {
    let cases: Vec<Value> = serde_json::from_str(include_str!("data/levels.json")).unwrap();
    for case in cases {
        let sizes: Vec<usize> = labels(&case["sizes"]).iter().map(|n| *n as usize).collect();
        let levels = Levels::new(&sizes);
        let truth = labels(&case["true"]);
        let predicted = levels.predicted(&singles(&case["outputs"]));
        let attributes = levels.scores(&truth, &predicted).unwrap();
        assert_eq!(attributes.len(), 2);
        for (got, want) in attributes.iter().zip(case["attributes"].as_array().unwrap()) {
            let LevelScores { scores, per_level, confusion, mean_absolute_error, within_one } = got;
            same_scores("levels", scores, per_level, confusion, want);
            close("levels", *mean_absolute_error, want["mean_absolute_error"].as_f64().unwrap());
            assert!(*mean_absolute_error > 0.0);
            let counts = confusion.counts();
            let near =
                |row: usize| counts[row].iter().enumerate().filter(move |(at, _)| at.abs_diff(row) <= 1);
            let near: usize = (0..counts.len()).flat_map(near).map(|(_, count)| *count as usize).sum();
            close("levels", within_one.unwrap(), near as f64 / (truth.len() / 2) as f64);
        }
        // Targets of the truth are predicted as the truth.
        assert_eq!(levels.predicted(&levels.targets(&truth)), truth);
        assert_eq!(levels.targets(&truth).iter().sum::<f32>(), truth.len() as f32);
    }
    assert!(Levels::new(&[2, 2]).scores(&[0, 2], &[0, 1]).is_err());
}

#[test]
fn probabilities_of_several_attributes_are_scored_attribute_by_attribute() {
    let levels = Levels::new(&[2, 3]);
    assert_eq!((levels.sizes(), levels.outputs()), (&[2, 3][..], 5));
    assert_eq!(levels.confidence(&[0.2, 0.8, 0.5, 0.3, 0.2]), 0.5, "the least sure attribute");
    // Three samples of two attributes, side by side and then each by itself.
    let both = [
        [0.75, 0.25, 0.5, 0.25, 0.25].as_slice(),
        &[0.125, 0.875, 0.0625, 0.9375, 0.0],
        &[0.5, 0.5, 0.25, 0.125, 0.625],
    ]
    .concat();
    let truth = [0, 1, 1, 1, 0, 2];
    let (first, second) =
        ([0.75, 0.25, 0.125, 0.875, 0.5, 0.5], [0.5, 0.25, 0.25, 0.0625, 0.9375, 0.0, 0.25, 0.125, 0.625]);
    let mean = |a: f64, b: f64| (a + b) / 2.0;
    let (error, score) = levels.calibration(&both, &truth).unwrap();
    let each =
        |of: fn(&[f32], &[u32], usize) -> f64| mean(of(&first, &[0, 1, 0], 2), of(&second, &[1, 1, 2], 3));
    close("calibration error", error, each(|p, t, n| calibration_error(p, t, n, BINS).unwrap()));
    close("brier", score, each(|p, t, n| brier(p, t, n).unwrap()));
    let loss = levels.log_loss(&both, &truth).unwrap();
    close("log loss", loss, each(|p, t, n| log_loss(p, t, n).unwrap()));
    assert!(error > 0.05 && score > 0.05 && loss > 0.05, "{error} {score} {loss}");
    assert!(levels.calibration(&both, &[0, 1, 1, 1, 0, 3]).is_err());
}

#[test]
fn counts_add_up_and_are_read_back() {
    let mut sum = Confusion::new(&[0, 0, 1], &[0, 1, 1], 2).unwrap();
    sum.add(&Confusion::new(&[0, 1, 1, 1], &[0, 0, 1, 1], 2).unwrap());
    assert_eq!(sum.counts(), [[2, 1], [1, 3]]);
    let text = serde_json::to_string(&sum).unwrap();
    assert_eq!(text, "[[2,1],[1,3]]");
    assert_eq!(serde_json::from_str::<Confusion>(&text).unwrap(), sum);
    for (text, expected) in [
        ("[[1,2],[3]]", "a confusion of 2 true classes has a row of 1"),
        ("[[4294967295,1],[0,0]]", "a confusion counts more samples than there can be"),
        ("[[18446744073709551615,1],[0,0]]", "a confusion counts more samples than there can be"),
    ] {
        let error = serde_json::from_str::<Confusion>(text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
    }
    assert!(serde_json::from_str::<Confusion>("[[4294967295,0],[0,0]]").is_ok());
}

#[test]
fn scores_have_a_mean_and_a_deviation_each() {
    let names = ["accuracy", "precision", "recall", "f1"];
    let scores = |values: [f64; 4]| Scores::new(names.into_iter().zip(values));
    let first = scores([0.5, 0.25, 0.75, 0.375]);
    assert_eq!(Scores::mean_sd(&[&first]), (Some(first.clone()), None));
    assert_eq!(Scores::mean_sd(&[]), (None, None));
    let (mean, sd) = Scores::mean_sd(&[&first, &scores([1.0, 0.25, 0.25, 0.625])]);
    assert_eq!(mean, Some(scores([0.75, 0.25, 0.5, 0.5])));
    // Of two values the deviation is their distance over the root of 2.
    for (name, distance) in names.into_iter().zip([0.5, 0.0, 0.5, 0.25]) {
        close("deviation", sd.as_ref().unwrap().get(name).unwrap(), distance / 2f64.sqrt());
    }
}

#[test]
fn scores_keep_their_names_order_and_values() {
    let scores = Scores::new([("mae", 0.5), ("rmse", 0.75), ("r2", -2.0)]);
    assert_eq!((scores.primary(), scores.get("r2"), scores.get("f1")), (Some(0.5), Some(-2.0), None));
    assert_eq!(Scores::default().primary(), None);
    let text = serde_json::to_string(&scores).unwrap();
    assert_eq!(text, r#"{"mae":0.5,"rmse":0.75,"r2":-2.0}"#);
    assert_eq!(serde_json::from_str::<Scores>(&text).unwrap(), scores);
    assert!(serde_json::from_str::<Scores>(r#"{"mae":"low"}"#).is_err());
    // A part has some of the names, each with the same value.
    let mut part = Scores::new([("r2", -2.0), ("mae", 0.5)]);
    assert!(part.is_part_of(&scores) && !scores.is_part_of(&part) && scores.is_part_of(&scores));
    part.set("mae", 0.25);
    assert!(!part.is_part_of(&scores));
    assert_eq!(part, Scores::new([("r2", -2.0), ("mae", 0.25)]));
}

#[test]
fn mistakes_among_look_alikes_are_told_from_others() {
    // Classes 0, 1 look alike, 2 does not.
    let confusion = Confusion::new(&[0, 0, 0, 1, 1, 2, 2], &[0, 1, 2, 0, 1, 2, 1], 3).unwrap();
    let groups = |pairs: &[(&str, &[usize])]| -> Vec<(String, Vec<usize>)> {
        pairs.iter().map(|(name, classes)| (name.to_string(), classes.to_vec())).collect()
    };
    let alikes = confusion.look_alikes(&groups(&[("rigid", &[0, 1]), ("soft", &[2])])).unwrap();
    assert_eq!((alikes.errors, alikes.within_group), (4, Some(0.5)));
    assert_eq!(alikes.confusion.counts(), [[4, 1], [1, 1]]);
    let mostly = Confusion::new(&[0, 0, 1, 2], &[1, 1, 0, 1], 3).unwrap();
    let alikes = mostly.look_alikes(&groups(&[("rigid", &[0, 1]), ("soft", &[2])])).unwrap();
    assert_eq!((alikes.errors, alikes.within_group), (4, Some(0.75)));
    let right = Confusion::new(&[0, 1, 2], &[0, 1, 2], 3).unwrap();
    assert_eq!(right.look_alikes(&groups(&[("all", &[0, 1, 2])])).unwrap().within_group, None);
    for (bad, expected) in [
        (groups(&[("rigid", &[0, 1])]), "groups of look-alikes: class 2 is in no group"),
        (groups(&[("rigid", &[0, 1]), ("soft", &[1, 2])]), "groups of look-alikes: class 1 is in two groups"),
        (groups(&[("rigid", &[0, 1, 2, 3])]), "groups of look-alikes: class 3 does not exist"),
    ] {
        assert_eq!(confusion.look_alikes(&bad).unwrap_err().to_string(), expected);
    }
}

#[test]
fn probabilities_that_do_not_pair_up_are_refused() {
    let text = |p: &[f32], truth: &[u32]| brier(p, truth, 2).unwrap_err().to_string();
    assert_eq!(text(&[0.5], &[0]), "probabilities: 1 for 1 samples of 2 classes");
    assert_eq!(text(&[], &[]), "probabilities: 0 for 0 samples of 2 classes");
    assert_eq!(text(&[0.5, 0.5], &[2]), "probabilities: label 2 of 2 classes");
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

#[test]
fn certainty_itself_is_in_the_last_bin() {
    // 1.0 and 0.95 share the bin (14/15, 1]: together half right at 0.975.
    let error = calibration_error(&[1.0, 0.0, 0.95, 0.05], &[1, 0], 2, BINS).unwrap();
    assert!((error - 0.475).abs() < 1e-6, "{error}");
}
