//! Intervals of means: SciPy's numbers (`scripts/fixtures/intervals.py`), and how often they cover what they should.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use rand::RngExt;
use serde_json::Value;
use taxel_base::seed::Rng;
use taxel_learn::metrics::{Clusters, MeanEstimate, Terms, bootstrap, central, t_quantile};

fn cases(name: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("data/intervals.json")).unwrap();
    all[name].as_array().unwrap_or_else(|| panic!("no {name}")).clone()
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn names(value: &Value) -> Vec<u32> {
    value.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect()
}

fn near(what: &str, got: f64, want: f64) {
    assert!((got - want).abs() <= 1e-9 * want.abs().max(1.0), "{what}: got {got}, want {want}");
}

#[test]
fn shares_of_samples_have_scipys_wilson_intervals() {
    for case in cases("wilson") {
        let [right, total] = ["right", "total"].map(|name| case[name].as_u64().unwrap() as u32);
        let terms: Vec<f64> = (0..total).map(|sample| f64::from(u8::from(sample < right))).collect();
        let samples: Vec<u32> = (0..total).collect();
        let estimate = MeanEstimate::of(&terms, &samples, None, Terms::Shares).unwrap();
        let got = estimate.interval(case["confidence"].as_f64().unwrap()).unwrap();
        got.iter().zip(floats(&case["interval"])).for_each(|(got, want)| near("bound", *got, want));
        // Exact copies of a sample count as one.
        let twice = [terms.clone(), terms].concat();
        let copies = MeanEstimate::of(&twice, &[samples.clone(), samples].concat(), None, Terms::Shares);
        assert_eq!(copies.unwrap().interval(0.95), estimate.interval(0.95));
    }
}

#[test]
fn quantiles_of_students_t_are_scipys() {
    for case in cases("quantiles") {
        let [freedom, q] = ["freedom", "q"].map(|name| case[name].as_f64().unwrap());
        near("quantile", t_quantile(freedom, q), case["value"].as_f64().unwrap());
    }
    near("normal", t_quantile(f64::INFINITY, 0.975), 1.959_963_984_540_054);
}

#[test]
fn grouped_means_have_the_intervals_of_their_twin() {
    for case in cases("grouped") {
        let kind = match case["kind"].as_str().unwrap() {
            "shares" => Terms::Shares,
            "amounts" => Terms::Amounts,
            _ => Terms::Differences,
        };
        let (samples, groups) = (names(&case["samples"]), names(&case["groups"]));
        let estimate = MeanEstimate::of(&floats(&case["terms"]), &samples, Some(&groups), kind).unwrap();
        near("mean", estimate.mean, case["mean"].as_f64().unwrap());
        let got = estimate.interval(0.95).unwrap();
        got.iter().zip(floats(&case["interval"])).for_each(|(got, want)| near("bound", *got, want));
    }
}

#[test]
fn a_mean_rests_on_its_samples() {
    let of = |terms: &[f64], samples: &[u32], kind| MeanEstimate::of(terms, samples, None, kind).unwrap();
    // One of three samples is tested twice: as good as 4² / (2² + 1 + 1) samples that are tested equally often.
    let twice = of(&[1.0, 1.0, 0.0, 1.0], &[0, 0, 1, 2], Terms::Shares);
    assert!((twice.samples - 16.0 / 6.0).abs() < 1e-12, "{twice:?}");
    // Variance 1 of three amounts.
    let amounts = of(&[1.0, 2.0, 3.0], &[0, 1, 2], Terms::Amounts);
    assert!((amounts.variance - 1.0 / 3.0).abs() < 1e-12 && amounts.freedom == 2.0, "{amounts:?}");
    let differences = of(&[-1.0; 5], &[0, 1, 2, 3, 4], Terms::Differences);
    assert_eq!(differences.interval(0.95).unwrap()[0], -1.0);
    // Groups that are more alike than chance would have it do not make the mean surer.
    let half: Vec<f64> = (0..200).map(|row| f64::from(row % 2)).collect();
    let (samples, groups): (Vec<u32>, Vec<u32>) = (0..200).map(|row| (row, row / 10)).unzip();
    let grouped = MeanEstimate::of(&half, &samples, Some(&groups), Terms::Shares).unwrap();
    assert!((grouped.variance - 0.25 / 200.0).abs() < 1e-12, "{grouped:?}");
}

#[test]
fn what_cannot_be_estimated_has_no_interval() {
    let of = |terms: &[f64], samples: &[u32], groups: Option<&[u32]>, kind| {
        MeanEstimate::of(terms, samples, groups, kind)
    };
    assert!(of(&[], &[], None, Terms::Shares).is_none());
    assert!(of(&[1.0], &[0, 1], None, Terms::Shares).is_none());
    assert!(of(&[1.0, 0.0], &[0, 1], Some(&[4, 4]), Terms::Shares).is_none(), "one group");
    assert!(of(&[1.0], &[0], None, Terms::Amounts).is_none(), "one sample");
    let zeros = of(&[0.0; 4], &[0, 1, 2, 3], None, Terms::Amounts).unwrap();
    assert_eq!(zeros.interval(0.95), None);
}

#[test]
fn a_group_that_is_right_throughout_does_not_promise_100_percent() {
    let interval = |wrong: u32, groups: u32| {
        let terms: Vec<f64> = (0..30 * groups).map(|at| f64::from(u8::from(at >= wrong))).collect();
        let samples: Vec<u32> = (0..30 * groups).collect();
        let each: Vec<u32> = samples.iter().map(|sample| sample / 30).collect();
        MeanEstimate::of(&terms, &samples, Some(&each), Terms::Shares).unwrap().interval(0.95).unwrap()
    };
    for (groups, between) in [(2, 0.60..0.75), (5, 0.80..0.90), (20, 0.95..0.98)] {
        let [low, high] = interval(0, groups);
        assert!(between.contains(&low) && high == 1.0, "{groups} groups: {low} to {high}");
        // Mistakes do not raise it, but for a hair.
        assert!(interval(1, groups)[0] < low + 0.01 && interval(3, groups)[0] < low, "{groups} groups");
    }
}

/// Groups of samples: names of samples and of groups.
fn grouped(sizes: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let groups: Vec<u32> =
        (0..).zip(sizes).flat_map(|(group, &size)| (0..size).map(move |_| group)).collect();
    ((0..groups.len() as u32).collect(), groups)
}

/// Draws right and wrong predictions of one group from Pólya's urn: beta-binomial, correlated by `correlation`.
fn urn(rng: &mut Rng, size: u32, share: f64, correlation: f64) -> Vec<f64> {
    let weight = if correlation > 0.0 { 1.0 / correlation - 1.0 } else { f64::INFINITY };
    let mut right = 0.0;
    let draw = |drawn: u32| {
        let chance =
            if weight.is_finite() { (weight * share + right) / (weight + f64::from(drawn)) } else { share };
        let hit = f64::from(u8::from(rng.random::<f64>() < chance));
        right += hit;
        hit
    };
    (0..size).map(draw).collect()
}

/// Draws a number of the standard normal distribution (Box & Muller 1958).
fn normal(rng: &mut Rng) -> f64 {
    let (a, b): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// Returns by how many percent of `draws` an interval covers the truth.
fn covered(draws: usize, mut hits: impl FnMut() -> bool) -> f64 {
    100.0 * (0..draws).filter(|_| hits()).count() as f64 / draws as f64
}

fn holds(interval: Option<[f64; 2]>, truth: f64) -> bool {
    interval.is_some_and(|[low, high]| low <= truth && truth <= high)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

const SHARES: [f64; 5] = [0.6, 0.8, 0.9, 0.95, 0.98];
const CORRELATIONS: [f64; 4] = [0.05, 0.1, 0.2, 0.3];

/// Computes the coverage over all shares and correlations.
fn coverage(sizes: &[u32], interval: impl Fn(&[f64], &[u32], &[u32]) -> Option<[f64; 2]>) -> f64 {
    let (samples, groups) = grouped(sizes);
    let mut each = vec![];
    for share in SHARES {
        for correlation in CORRELATIONS {
            let mut rng = taxel_base::seed::rng(6, &format!("{sizes:?} {share} {correlation}"));
            each.push(covered(150, || {
                let terms: Vec<f64> =
                    sizes.iter().flat_map(|&size| urn(&mut rng, size, share, correlation)).collect();
                holds(interval(&terms, &samples, &groups), share)
            }));
        }
    }
    mean(&each)
}

fn of_shares(terms: &[f64], samples: &[u32], groups: &[u32]) -> Option<[f64; 2]> {
    MeanEstimate::of(terms, samples, Some(groups), Terms::Shares)?.interval(0.95)
}

#[test]
fn intervals_of_shares_cover_what_they_say() {
    for total in [30, 150] {
        let samples: Vec<u32> = (0..total).collect();
        let of = |share| {
            let mut rng = taxel_base::seed::rng(6, &format!("{total} {share}"));
            covered(2000, || {
                let terms = urn(&mut rng, total, share, 0.0);
                let estimate = MeanEstimate::of(&terms, &samples, None, Terms::Shares).unwrap();
                holds(estimate.interval(0.95), share)
            })
        };
        let all = mean(&SHARES.map(of));
        println!("{total} samples: {all:.1} %");
        assert!((93.0..=97.0).contains(&all), "{total} samples: {all} %");
    }
}

#[test]
fn intervals_of_shares_of_groups_cover_what_they_say() {
    // Of two and three groups they rest on what is assumed of the correlation, and rather cover more.
    for (groups, most) in [(2, 98.5), (3, 98.5), (5, 97.0), (10, 97.0), (20, 97.0)] {
        let unequal: Vec<u32> = (0..groups).map(|at| [8, 16, 30, 52, 80][at as usize % 5]).collect();
        for sizes in [vec![30; groups as usize], unequal] {
            let all = coverage(&sizes, of_shares);
            println!("{groups} groups {}: {all:.1} %", sizes[0]);
            assert!((93.0..=most).contains(&all), "{sizes:?}: {all} %");
        }
    }
}

/// The interval before: percentiles of resampled groups. It shows that the simulation can fail.
#[test]
fn percentiles_of_resampled_groups_do_not_cover() {
    let percentile = |terms: &[f64], _: &[u32], groups: &[u32]| {
        let clusters = Clusters::new(terms, groups);
        let means = bootstrap(clusters.len(), 200, 0, "before", |drawn| Some(clusters.mean_of(drawn)));
        let (low, high) = central(&means, 0.95);
        Some([low, high])
    };
    for (groups, most) in [(2, 60.0), (3, 78.0), (5, 86.0), (10, 90.0), (20, 93.0)] {
        let all = coverage(&vec![30; groups], percentile);
        println!("{groups} groups before: {all:.1} %");
        assert!(all < most, "{groups} groups: {all} %");
    }
}

#[test]
fn intervals_of_amounts_cover_what_they_say() {
    for (groups, least, most) in [
        (0, 93.0, 97.0),
        (2, 93.0, 99.5),
        (3, 93.0, 99.0),
        (5, 93.0, 98.5),
        (10, 93.0, 97.5),
        (20, 93.0, 97.0),
    ] {
        let mut each = vec![];
        for spread in [0.2, 0.35, 0.5] {
            let (sizes, spread): (Vec<u32>, f64) =
                if groups == 0 { (vec![30], 0.0) } else { (vec![20; groups], spread) };
            let (samples, names) = grouped(&sizes);
            let truth = (2.0 / std::f64::consts::PI).sqrt() * (spread * spread / 2.0).exp();
            let mut rng = taxel_base::seed::rng(6, &format!("amounts {groups} {spread}"));
            each.push(covered(600, || {
                let mut terms = vec![];
                for &size in &sizes {
                    let scale = (spread * normal(&mut rng)).exp();
                    terms.extend((0..size).map(|_| scale * normal(&mut rng).abs()));
                }
                let by = (groups > 0).then_some(names.as_slice());
                let estimate = MeanEstimate::of(&terms, &samples, by, Terms::Amounts).unwrap();
                holds(estimate.interval(0.95), truth)
            }));
        }
        let all = mean(&each);
        println!("amounts of {groups} groups: {all:.1} %");
        assert!((least..=most).contains(&all), "{groups} groups: {all} %");
    }
}

#[test]
fn intervals_of_paired_differences_cover_what_they_say() {
    // Of 100 samples only one network gets 15 right and only the other 5, more in some groups than in others.
    for (groups, least, most) in [
        (0, 93.0, 97.0),
        (2, 93.0, 99.5),
        (3, 93.0, 99.0),
        (5, 93.0, 98.0),
        (10, 93.0, 97.5),
        (20, 93.0, 97.0),
    ] {
        let sizes: Vec<u32> = if groups == 0 { vec![60] } else { vec![30; groups] };
        let (samples, names) = grouped(&sizes);
        let mut each = vec![];
        for correlation in [0.05, 0.1, 0.2] {
            let correlation = if groups == 0 { 0.0 } else { correlation };
            let mut rng = taxel_base::seed::rng(6, &format!("pairs {groups} {correlation}"));
            each.push(covered(600, || {
                let mut terms = vec![];
                for &size in &sizes {
                    let gained = urn(&mut rng, size, 0.15, correlation);
                    let lost = urn(&mut rng, size, 0.05 / 0.85, correlation);
                    terms.extend(gained.iter().zip(&lost).map(|(gain, loss)| gain - (1.0 - gain) * loss));
                }
                let by = (groups > 0).then_some(names.as_slice());
                let estimate = MeanEstimate::of(&terms, &samples, by, Terms::Differences).unwrap();
                holds(estimate.interval(0.95), 0.10)
            }));
        }
        let all = mean(&each);
        println!("differences of {groups} groups: {all:.1} %");
        assert!((least..=most).contains(&all), "{groups} groups: {all} %");
    }
}
