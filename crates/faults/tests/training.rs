//! Faults that are trained under: how often they come, how strong they are, that they are reproducible.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use ndarray::{Array2, ArrayD};
use taxel_faults::{Error, Fault, Layout, Sensor, TrainingFaults};

const DRAWS: usize = 4000;

fn grasp() -> ArrayD<f32> {
    Array2::from_shape_fn((5, 40), |(c, t)| 100.0 + 20.0 * c as f32 + 5.0 * t as f32).into_dyn()
}

fn sensor() -> Sensor {
    Sensor::new(Layout::Series, 1000.0)
}

/// Every draw: how many faults, and what became of the grasp.
fn draws(faults: &TrainingFaults) -> Vec<(usize, ArrayD<f32>)> {
    let plan = faults.plan(Layout::Series, &[5, 40]).unwrap();
    let draw = |i: usize| {
        let mut x = grasp();
        let count = plan.apply(x.view_mut(), &sensor(), 7, &format!("draw/{i}"), i).unwrap();
        (count, x)
    };
    (0..DRAWS).map(draw).collect()
}

#[test]
fn faults_come_as_often_as_asked() {
    let found = draws(&TrainingFaults::default());
    let share = |count| found.iter().filter(|(faults, _)| *faults == count).count() as f64 / DRAWS as f64;
    // 0.3 · 0.86, 0.7 · 0.86 + 0.3 · 0.14, 0.7 · 0.14; four standard errors are 0.03.
    for (count, expected) in [(0, 0.258), (1, 0.644), (2, 0.098)] {
        assert!((share(count) - expected).abs() < 0.03, "{count} faults: {}", share(count));
    }
    assert!(found.iter().filter(|(count, _)| *count == 0).all(|(_, x)| *x == grasp()));
    assert!(found.iter().all(|(_, x)| x.iter().all(|v| (0.0..=1000.0).contains(v))));
}

#[test]
fn a_draw_is_a_function_of_seed_and_purpose() {
    let faults = TrainingFaults { probability: 1.0, ..TrainingFaults::default() };
    let (a, b) = (draws(&faults), draws(&faults));
    assert_eq!(a, b);
    let distinct = a.windows(2).filter(|pair| pair[0].1 != pair[1].1).count();
    assert!(distinct > DRAWS * 9 / 10, "{distinct}");
}

#[test]
fn a_kind_that_is_left_out_never_comes() {
    let only =
        |kind| TrainingFaults { probability: 1.0, second: 0.0, kinds: vec![kind], ..Default::default() };
    // One channel at least is dead, half of the five at most and one more by rounding.
    for (_, x) in draws(&only(Fault::Dead)) {
        let dead = x.rows().into_iter().filter(|row| row.iter().all(|v| *v == 0.0)).count();
        assert!((1..=3).contains(&dead), "{dead}");
    }
    let without = TrainingFaults { without: vec![Fault::Dead, Fault::DeadLine], ..only(Fault::Stuck) };
    assert!(without.plan(Layout::Series, &[5, 40]).unwrap().kinds().eq([Fault::Stuck]));
    let all = TrainingFaults { without: vec![Fault::Dead], ..Default::default() };
    let kinds: Vec<Fault> = all.plan(Layout::Series, &[5, 40]).unwrap().kinds().collect();
    assert_eq!(kinds.len(), 12);
    assert!(!kinds.contains(&Fault::Dead) && !kinds.contains(&Fault::Rotation));
}

#[test]
fn a_single_channel_meets_only_what_it_can_learn_from() {
    let kinds = |faults: TrainingFaults, shape: &[usize]| -> Vec<Fault> {
        faults.plan(Layout::Series, shape).unwrap().kinds().collect()
    };
    let several = [Fault::Dead, Fault::Stuck, Fault::DeadLine, Fault::Crosstalk, Fault::Swap];
    let both = kinds(TrainingFaults::default(), &[2, 40]);
    let single = kinds(TrainingFaults::default(), &[1, 40]);
    assert!(several.iter().all(|kind| both.contains(kind) && !single.contains(kind)));
    assert_eq!(both.len(), single.len() + several.len());
    // A row of features is broken as one channel.
    let features: Vec<Fault> =
        TrainingFaults::default().plan(Layout::Features, &[7]).unwrap().kinds().collect();
    assert!(!features.iter().any(|kind| several.contains(kind)), "{features:?}");
    // Whoever asks for a kind gets it.
    let wanted = TrainingFaults { kinds: vec![Fault::Dead], ..Default::default() };
    assert_eq!(kinds(wanted, &[1, 40]), [Fault::Dead]);
    let wrong = TrainingFaults::default().plan(Layout::Series, &[40]).unwrap_err().to_string();
    assert!(wrong.starts_with("shape = [40]"), "{wrong}");
}

#[test]
fn levels_lie_where_they_are_asked_for() {
    let faults = TrainingFaults {
        probability: 1.0,
        second: 0.0,
        kinds: vec![Fault::Saturation],
        levels: BTreeMap::from([(Fault::Saturation, [20.0, 25.0])]),
        ..Default::default()
    };
    let mut peaks: Vec<f32> =
        draws(&faults).iter().map(|(_, x)| x.iter().copied().fold(0.0, f32::max)).collect();
    peaks.sort_by(f32::total_cmp);
    assert!(peaks[0] >= 200.0 && peaks[0] < 201.0, "{}", peaks[0]);
    assert!(peaks[DRAWS - 1] <= 250.0 && peaks[DRAWS - 1] > 249.0);
    let middle = peaks[DRAWS / 2];
    assert!((middle - 225.0).abs() < 2.0, "{middle}");
}

#[test]
fn settings_outside_their_range_are_refused_by_name() {
    let refused = |faults: TrainingFaults| faults.plan(Layout::Series, &[5, 40]).unwrap_err().to_string();
    let faults = TrainingFaults { probability: f64::NAN, ..Default::default() };
    assert!(refused(faults).starts_with("probability = NaN"));
    let faults = TrainingFaults { copies: 0, ..Default::default() };
    assert!(refused(faults).starts_with("copies = 0"));
    let levels = BTreeMap::from([(Fault::Noise, [5.0, 1.0])]);
    let faults = TrainingFaults { levels, ..Default::default() };
    assert!(refused(faults).starts_with("levels.noise = [5, 1]"));
    let faults = TrainingFaults { kinds: vec![Fault::Shift], ..Default::default() };
    assert!(matches!(faults.plan(Layout::Series, &[5, 40]), Err(Error::Fault { fault: "shift", .. })));
    let faults =
        TrainingFaults { kinds: vec![Fault::Noise], without: vec![Fault::Noise], ..Default::default() };
    assert!(refused(faults).starts_with("without = "));
    let mut image = ArrayD::zeros(vec![5]);
    let plan = TrainingFaults::default().plan(Layout::Series, &[5, 40]).unwrap();
    assert!(plan.apply(image.view_mut(), &sensor(), 0, "x", 3).is_err());
}

#[test]
fn settings_survive_a_file() {
    let faults = TrainingFaults {
        without: vec![Fault::DeadLine],
        levels: BTreeMap::from([(Fault::Noise, [0.5, 1.0])]),
        ..Default::default()
    };
    let text = serde_json::to_string(&faults).unwrap();
    assert_eq!(serde_json::from_str::<TrainingFaults>(&text).unwrap(), faults);
    assert_eq!(serde_json::from_str::<TrainingFaults>("{}").unwrap(), TrainingFaults::default());
}
