//! Statistics against SciPy's; `scripts/fixtures/statistics.py` writes its numbers.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::cell::Cell;

use rand::RngExt;
use serde_json::Value;
use taxel_judge::statistics::{
    cluster_bootstrap, corrected_t, false_discovery, friedman, grouped_pairs, holm, independent, mcnemar,
    nemenyi, random_effects, spread_ratio, wilcoxon,
};
use taxel_learn::metrics::{Clusters, bootstrap, mean_sd, quantile, t_quantile};

fn cases(name: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("data/statistics.json")).unwrap();
    all[name].as_array().unwrap_or_else(|| panic!("no {name}")).clone()
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn close(name: &str, got: f64, want: &Value) {
    let want = want.as_f64().unwrap();
    assert!((got - want).abs() <= 1e-9 * want.abs().max(1.0), "{name}: got {got}, want {want}");
}

fn close_all(name: &str, got: &[f64], want: &Value) {
    let want = want.as_array().unwrap();
    assert_eq!(got.len(), want.len(), "{name}");
    got.iter().zip(want).for_each(|(got, want)| close(name, *got, want));
}

#[test]
fn corrected_t_is_scipys_with_the_corrected_variance() {
    for case in cases("corrected_t") {
        let ratio = case["ratio"].as_f64().unwrap();
        let test = corrected_t(&floats(&case["differences"]), ratio, 0.95).unwrap();
        close("mean", test.mean, &case["mean"]);
        close("p", test.p, &case["p"]);
        close_all("interval", &test.interval.unwrap(), &case["interval"]);
        // Turned round, everything but p changes its sign.
        let turned: Vec<f64> = floats(&case["differences"]).iter().map(|d| -d).collect();
        let other = corrected_t(&turned, ratio, 0.95).unwrap();
        assert!((other.p - test.p).abs() < 1e-12 && (other.mean + test.mean).abs() < 1e-12);
    }
}

#[test]
fn differences_without_spread_have_a_documented_answer() {
    let none = corrected_t(&[0.0; 4], 0.25, 0.95).unwrap();
    assert_eq!((none.mean, none.interval, none.p), (0.0, Some([0.0, 0.0]), 1.0));
    // All the same is no proof: the sign test of five folds says 1/16.
    let same = corrected_t(&[3.0; 5], 0.25, 0.95).unwrap();
    assert_eq!((same.mean, same.interval, same.p), (3.0, None, 0.0625));
    // Rounding is no spread either.
    assert_eq!(corrected_t(&[0.1 + 0.2, 0.3], 1.0, 0.95).unwrap().interval, None);
    assert_eq!(corrected_t(&[1e6, 1e6 + 2e-10], 1.0, 0.95).unwrap().interval, None);
    for (differences, ratio, confidence, says) in [
        (&[1.0][..], 0.25, 0.95, "at least 2"),
        (&[][..], 0.25, 0.95, "at least 2"),
        (&[1.0, f64::NAN], 0.25, 0.95, "value 1 is NaN"),
        (&[1.0, 2.0], -0.5, 0.95, "-0.5 test samples"),
        (&[1.0, 2.0], f64::INFINITY, 0.95, "inf test samples"),
        (&[1.0, 2.0], 0.25, 1.0, "not in (0, 1)"),
    ] {
        let error = corrected_t(differences, ratio, confidence).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn independent_estimates_differ_as_newcombe_has_it() {
    let both = |value: &Value| {
        let bounds = floats(&value[1]);
        (value[0].as_f64().unwrap(), [bounds[0], bounds[1]])
    };
    for case in cases("independent") {
        let (size, interval) = independent(both(&case["a"]), both(&case["b"])).unwrap();
        close("size", size, &case["size"]);
        close_all("interval", &interval, &case["interval"]);
    }
    // Newcombe's Table II, (a): 56 of 70 less 48 of 80.
    let (_, [low, high]) = {
        let case = &cases("independent")[0];
        independent(both(&case["a"]), both(&case["b"])).unwrap()
    };
    assert!((low - 0.0524).abs() < 5e-5 && (high - 0.3339).abs() < 5e-5, "{low} {high}");
    assert!(independent((0.5, [0.6, 0.7]), (0.5, [0.4, 0.6])).is_err());
    assert!(independent((f64::NAN, [0.6, 0.7]), (0.5, [0.4, 0.6])).is_err());
}

#[test]
fn mcnemar_is_the_exact_binomial_test() {
    for case in cases("mcnemar") {
        close("p", mcnemar(case["a"].as_u64().unwrap(), case["b"].as_u64().unwrap()), &case["p"]);
    }
    assert_eq!(mcnemar(0, 0), 1.0);
}

#[test]
fn holm_steps_down_and_never_falls() {
    for case in cases("holm") {
        close_all("adjusted", &holm(&floats(&case["p"])), &case["adjusted"]);
    }
    assert!(holm(&[]).is_empty());
}

#[test]
fn wilcoxon_counts_every_pattern_of_signs() {
    for case in cases("wilcoxon") {
        close("p", wilcoxon(&floats(&case["differences"])).unwrap(), &case["p"]);
    }
    assert_eq!(wilcoxon(&[0.0, 0.0]).unwrap(), 1.0);
    assert!(wilcoxon(&[]).is_err() && wilcoxon(&[f64::NAN]).is_err() && wilcoxon(&[1.0; 501]).is_err());
    assert!(wilcoxon(&[1.0; 500]).is_ok());
}

#[test]
fn friedman_is_scipys() {
    for case in cases("friedman") {
        let scores: Vec<Vec<f64>> = case["scores"].as_array().unwrap().iter().map(floats).collect();
        let test = friedman(&scores).unwrap();
        close_all("ranks", &test.ranks, &case["ranks"]);
        close("statistic", test.statistic, &case["statistic"]);
        close("p", test.p, &case["p"]);
        close("p_iman_davenport", test.p_iman_davenport, &case["p_iman_davenport"]);
    }
    let ties = friedman(&[vec![1.0; 3], vec![2.0; 3]]).unwrap();
    assert_eq!((ties.statistic, ties.p, ties.p_iman_davenport), (0.0, 1.0, 1.0));
    assert_eq!(ties.ranks, [2.0; 3]);
    let alike = friedman(&[vec![3.0, 2.0, 1.0], vec![9.0, 8.0, 7.0]]).unwrap();
    assert_eq!((alike.ranks, alike.p_iman_davenport), (vec![1.0, 2.0, 3.0], 0.0));
    assert!((alike.statistic - 4.0).abs() < 1e-12);
    for bad in [vec![], vec![vec![1.0; 3]], vec![vec![1.0, 2.0]; 4], vec![vec![1.0; 3], vec![1.0; 4]]] {
        assert!(friedman(&bad).is_err(), "{bad:?}");
    }
    assert!(friedman(&[vec![1.0, 2.0, f64::NAN], vec![1.0; 3]]).is_err());
}

/// Demsar (2006), section 3.2.3: four classifiers on 14 data sets.
#[test]
fn the_worked_example_of_demsar_comes_out() {
    let scores = &cases("friedman")[0]["scores"];
    let scores: Vec<Vec<f64>> = scores.as_array().unwrap().iter().map(floats).collect();
    let ranks = friedman(&scores).unwrap().ranks;
    for (got, printed) in ranks.iter().zip([3.143, 2.000, 2.893, 1.964]) {
        assert!((got - printed).abs() < 5e-4, "{got}, printed {printed}");
    }
    // His chi-squared is not corrected for ties.
    let squares: f64 = ranks.iter().map(|r| r * r).sum();
    let plain = 12.0 * 14.0 / 20.0 * (squares - 4.0 * 25.0 / 4.0);
    assert!((plain - 9.28).abs() < 0.005, "{plain}");
    // Critical differences of his text at 5 % and 10 %.
    assert!((nemenyi(4, 14, 0.05).unwrap() - 1.25).abs() < 0.005);
    assert!((nemenyi(4, 14, 0.10).unwrap() - 1.12).abs() < 0.005);
}

#[test]
fn nemenyis_difference_is_that_of_the_studentized_range() {
    for case in cases("nemenyi") {
        let [methods, sets] = ["methods", "sets"].map(|name| case[name].as_u64().unwrap() as usize);
        let got = nemenyi(methods, sets, case["alpha"].as_f64().unwrap()).unwrap();
        close("difference", got, &case["difference"]);
    }
    // Demsar's Table 5(a): q of 2 to 10 classifiers, 5 % and 10 %.
    let printed = [
        [1.960, 2.343, 2.569, 2.728, 2.850, 2.949, 3.031, 3.102, 3.164],
        [1.645, 2.052, 2.291, 2.459, 2.589, 2.693, 2.780, 2.855, 2.920],
    ];
    for (alpha, row) in [0.05, 0.10].into_iter().zip(printed) {
        for (methods, want) in (2..).zip(row) {
            let k = methods as f64;
            let q = nemenyi(methods, 6, alpha).unwrap() / (k * (k + 1.0) / 36.0).sqrt();
            assert!((q - want).abs() < 2e-3, "{methods} at {alpha}: {q}, printed {want}");
        }
    }
    assert!(nemenyi(1, 5, 0.05).is_err() && nemenyi(3, 0, 0.05).is_err() && nemenyi(3, 5, 0.0).is_err());
}

#[test]
fn a_ratio_of_spreads_is_pitmans() {
    for case in cases("spread") {
        let ratio = spread_ratio(&floats(&case["a"]), &floats(&case["b"]), 0.95).unwrap().unwrap();
        close("ratio", ratio.ratio, &case["ratio"]);
        close_all("interval", &ratio.interval, &case["interval"]);
    }
    assert_eq!(spread_ratio(&[1.0; 4], &[1.0, 2.0, 3.0, 4.0], 0.95).unwrap(), None);
    assert_eq!(spread_ratio(&[1.0, 2.0, 3.0], &[2.0, 4.0, 6.0], 0.95).unwrap(), None);
    assert!(spread_ratio(&[1.0, 2.0], &[2.0, 3.0], 0.95).is_err());
    assert!(spread_ratio(&[1.0, 2.0, 3.0], &[2.0, 3.0], 0.95).is_err());
}

#[test]
fn the_bootstrap_draws_whole_clusters_and_keeps_pairs() {
    // A difference of accuracies: the mean of paired differences, as the bootstrap of a mean has it.
    let differences = [1.0, 0.0, 0.0, -1.0, 1.0, 1.0, 0.0, 1.0, -1.0];
    let clusters = [3, 3, 3, 5, 5, 8, 8, 9, 9];
    let mean =
        |rows: &[usize]| Some(rows.iter().map(|&row| differences[row]).sum::<f64>() / rows.len() as f64);
    let interval = cluster_bootstrap(&clusters, mean, 0.9, 500, (4, "x")).unwrap().unwrap();
    // The percentiles moved out by what four clusters leave uncertain, by hand.
    let drawn = Clusters::new(&differences, &clusters);
    let means = bootstrap(drawn.len(), 500, 4, "x", |drawn_clusters| Some(drawn.mean_of(drawn_clusters)));
    let (alike, whole) = (81.0 / (9.0 + 3.0 * 4.0), drawn.mean());
    let t = t_quantile(alike - 1.0, 0.95) * (alike / (alike - 1.0f64)).sqrt();
    let (_, sd) = mean_sd(&means);
    for (bound, percentile, side) in [(interval[0], 0.05, -1.0), (interval[1], 0.95, 1.0)] {
        let moved = (quantile(&means, percentile) - whole).abs() * t / 1.644_853_626_951_472_6;
        let twin = whole + side * moved.max(t * sd.unwrap());
        assert!((bound - twin).abs() < 1e-9, "{bound} {twin}");
    }
    let again = cluster_bootstrap(&clusters, mean, 0.9, 500, (4, "x")).unwrap().unwrap();
    assert_eq!(interval, again);
    // One cluster says nothing about others; a statistic that is mostly undefined has no interval.
    assert_eq!(cluster_bootstrap(&[7; 9], mean, 0.9, 500, (4, "x")).unwrap(), None);
    assert!(cluster_bootstrap(&[7, 7, 8], mean, 0.9, 500, (4, "x")).unwrap().is_some());
    assert_eq!(cluster_bootstrap(&clusters, |_| None, 0.9, 500, (4, "x")).unwrap(), None);
    // Without spread nothing is known, unless nothing differs.
    assert_eq!(cluster_bootstrap(&clusters, |_| Some(2.0), 0.9, 500, (4, "x")).unwrap(), None);
    assert_eq!(cluster_bootstrap(&clusters, |_| Some(0.0), 0.9, 500, (4, "x")).unwrap(), Some([0.0, 0.0]));
    // One undefined resample in twenty is borne, two are not.
    for (undefined, has) in [(1, true), (2, false)] {
        let draw = Cell::new(0);
        let now_and_then = |_: &[usize]| {
            draw.set(draw.get() + 1);
            (draw.get() > undefined).then_some(f64::from(draw.get()))
        };
        let interval = cluster_bootstrap(&clusters, now_and_then, 0.9, 20, (4, "x")).unwrap();
        assert_eq!(interval.is_some(), has, "{undefined} undefined");
    }
    assert!(cluster_bootstrap(&clusters, |_| Some(f64::NAN), 0.9, 500, (4, "x")).is_err());
    assert!(cluster_bootstrap(&clusters, mean, 0.0, 500, (4, "x")).is_err());
    assert!(cluster_bootstrap(&clusters, mean, 0.9, 0, (4, "x")).is_err());
}

#[test]
fn pairs_of_groups_are_tested_by_their_groups() {
    // 10 samples of each of 6 groups: the first network alone gets 4 more right in every group.
    let groups: Vec<u32> = (0..60).map(|at| at / 10).collect();
    let samples: Vec<u32> = (0..60).collect();
    let even: Vec<f64> = (0..60).map(|at| f64::from(u8::from(at % 10 < 4))).collect();
    let even = grouped_pairs(&even, &samples, &groups, 0.95).unwrap().unwrap();
    assert!(even.p < 0.001 && even.interval.unwrap()[0] > 0.2, "{even:?}");
    // The same 24 samples, all of two groups and four of a third: that may be chance.
    let uneven: Vec<f64> = (0..60).map(|at| f64::from(u8::from(at < 24))).collect();
    let uneven = grouped_pairs(&uneven, &samples, &groups, 0.95).unwrap().unwrap();
    assert!((uneven.mean - even.mean).abs() < 1e-12, "{uneven:?}");
    assert!(uneven.p > 0.03 && uneven.p > 100.0 * even.p, "{uneven:?} {even:?}");
    assert!(mcnemar(24, 0) < 1e-6, "samples alone would promise much");
    assert_eq!(grouped_pairs(&[1.0, 0.0], &[0, 1], &[3, 3], 0.95).unwrap(), None);
    assert!(grouped_pairs(&[], &[], &[], 0.95).is_err());
    // Nothing differs in 60 samples: not a promise that nothing ever will.
    let none = grouped_pairs(&[0.0; 60], &samples, &groups, 0.95).unwrap().unwrap();
    let [low, high] = none.interval.unwrap();
    assert!(none.p == 1.0 && low < -0.01 && high > 0.01, "{none:?}");
}

/// Macro-F1 of three classes over confusions `[true][predicted]` of samples, by position.
fn macro_f1(labels: &[(usize, usize)], rows: &[usize]) -> f64 {
    let mut counts = [[0.0; 3]; 3];
    rows.iter().for_each(|&row| counts[labels[row].0][labels[row].1] += 1.0);
    let of = |class: usize| {
        let (hits, both) =
            (counts[class][class], (0..3).map(|other| counts[class][other] + counts[other][class]));
        2.0 * hits / both.sum::<f64>().max(1.0)
    };
    (0..3).map(of).sum::<f64>() / 3.0
}

/// Groups of 30 samples with their own accuracy, and 30 samples alone: how often the truth lies inside.
#[test]
fn the_bootstrap_of_macro_f1_covers_with_its_correction() {
    let draw = |rng: &mut taxel_base::seed::Rng, groups: usize| {
        let mut labels = vec![];
        for _ in 0..groups {
            let accuracy = 0.65 + 0.3 * rng.random::<f64>();
            labels.extend((0..30).map(|at| {
                let (truth, right) = (at % 3, rng.random::<f64>() < accuracy);
                (truth, if right { truth } else { (truth + 1 + usize::from(rng.random::<f64>() < 0.3)) % 3 })
            }));
        }
        labels
    };
    let mut rng = taxel_base::seed::rng(6, "truth of F1");
    let many = draw(&mut rng, 20_000);
    let truth = macro_f1(&many, &(0..many.len()).collect::<Vec<_>>());
    for (groups, least) in [(2, 88.0), (3, 90.0), (5, 92.0), (10, 93.0), (20, 93.0)] {
        let clusters: Vec<u32> = (0..30 * groups as u32).map(|at| at / 30).collect();
        let (mut inside, mut before) = (0, 0);
        for trial in 0..300 {
            let labels = draw(&mut rng, groups);
            let statistic = |rows: &[usize]| Some(macro_f1(&labels, rows));
            let purpose = format!("F1 {trial}");
            let found = cluster_bootstrap(&clusters, statistic, 0.95, 200, (6, &purpose)).unwrap();
            inside += usize::from(found.is_some_and(|[low, high]| low <= truth && truth <= high));
            let values = bootstrap(groups, 200, 6, &purpose, |drawn| {
                let rows: Vec<usize> = drawn.iter().flat_map(|g| 30 * g..30 * (g + 1)).collect();
                Some(macro_f1(&labels, &rows))
            });
            let [low, high] = [0.025, 0.975].map(|q| quantile(&values, q));
            before += usize::from(low <= truth && truth <= high);
        }
        let [inside, before] = [inside, before].map(|hits| f64::from(hits as u32) / 3.0);
        println!("macro-F1, {groups} groups: {inside:.1} %, percentiles alone {before:.1} %");
        assert!((least..=98.5).contains(&inside), "{groups} groups: {inside} %");
        assert!(groups > 5 || before < 90.0, "{groups} groups, percentiles alone: {before} %");
    }
}

#[test]
fn effects_of_several_runs_are_pooled_as_statsmodels_does() {
    for case in cases("random_effects") {
        let effects: Vec<(f64, f64)> =
            floats(&case["sizes"]).into_iter().zip(floats(&case["errors"])).collect();
        let pooled = random_effects(&effects, 0.95).unwrap();
        close("mean", pooled.mean, &case["mean"]);
        close_all("interval", &pooled.interval, &case["interval"]);
        close("p", pooled.p, &case["p"]);
        close("between", pooled.between, &case["between"]);
    }
    for (effects, says) in
        [(&[(1.0, 1.0)][..], "at least 2"), (&[(1.0, 1.0), (2.0, 0.0)][..], "a standard error of 0")]
    {
        let error = random_effects(effects, 0.95).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn q_values_are_scipys() {
    for case in cases("false_discovery") {
        close_all("q", &false_discovery(&floats(&case["p"])), &case["q"]);
    }
    assert!(false_discovery(&[]).is_empty());
}
