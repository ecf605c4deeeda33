//! Faults: their physical units hold, they are graded, reproducible, and never leave the range.

#![allow(clippy::unwrap_used)]

use ndarray::{Array1, Array2, ArrayD, Axis, IxDyn};
use taxel_faults::Error;
use taxel_faults::{Fault, Layout, Sensor};

const FULL: f32 = 1000.0;

const LAYOUTS: [(Layout, &[usize]); 6] = [
    (Layout::Series, &[5, 50]),
    (Layout::Series, &[23, 60]),
    (Layout::Image, &[28, 50]),
    (Layout::Colour, &[3, 24, 32]),
    (Layout::Sequence, &[10, 14, 25]),
    (Layout::Fingers, &[2, 23, 100]),
];

/// A press that comes and goes: a bump over the elements, another strength for each.
fn press(layout: Layout, shape: &[usize]) -> ArrayD<f32> {
    let swing = |at: usize, n: usize| (std::f32::consts::PI * (at as f32 + 0.5) / n as f32).sin();
    ArrayD::from_shape_fn(IxDyn(shape), |at| {
        let bumps = (0..shape.len()).map(|axis| match (layout, axis) {
            (Layout::Series, 0) => 0.7 + 0.3 * (2.3 * at[0] as f32).sin(),
            (Layout::Fingers, 0 | 1) => 0.7 + 0.25 * (1.7 * (at[0] + 3 * at[1]) as f32).sin(),
            (Layout::Colour, 0) => 1.0 - 0.2 * at[0] as f32,
            _ => swing(at[axis], shape[axis]).powi(2),
        });
        0.95 * FULL * bumps.product::<f32>()
    })
}

fn broken(fault: Fault, x: &ArrayD<f32>, sensor: &Sensor, severity: u8, sample: usize) -> ArrayD<f32> {
    let mut y = x.clone();
    fault.apply(y.view_mut(), sensor, severity, 3, sample).unwrap();
    y
}

fn distance(a: &ArrayD<f32>, b: &ArrayD<f32>) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
}

/// Every fault on every layout that it has a meaning for.
fn all() -> impl Iterator<Item = (Fault, Layout, &'static [usize])> {
    let pairs = Fault::ALL.into_iter().flat_map(|f| LAYOUTS.map(|(layout, shape)| (f, layout, shape)));
    pairs.filter(|(fault, layout, _)| fault.applicable(*layout))
}

#[test]
fn each_severity_is_farther_from_the_clean_sample_than_the_one_before() {
    for (fault, layout, shape) in all() {
        let (x, sensor) = (press(layout, shape), Sensor::new(layout, FULL));
        let mean = |severity| {
            let samples = (0..60).map(|i| distance(&x, &broken(fault, &x, &sensor, severity, i)));
            samples.sum::<f64>() / 60.0
        };
        let by_severity: Vec<f64> = (1..=5).map(mean).collect();
        // Two fingers can lose one and no more; five channels are mixed up after four swaps.
        let capped =
            matches!((fault, shape), (Fault::DeadLine, [2, ..]) | (Fault::DeadLine | Fault::Swap, [5, ..]));
        let rises = by_severity.is_sorted_by(|a, b| if capped { a <= b } else { a < b });
        assert!(rises && by_severity[0] > 0.0, "{fault} on {layout:?} {shape:?}: {by_severity:?}");
    }
}

#[test]
fn readings_keep_shape_and_range_and_are_never_nan() {
    for (fault, layout, shape) in all() {
        let mut sensor = Sensor::new(layout, FULL);
        let ends = [ArrayD::zeros(shape), ArrayD::from_elem(shape, FULL), press(layout, shape)];
        for rest in [0.0, 400.0, FULL] {
            sensor.rest = vec![rest];
            for x in &ends {
                for severity in 1..=5 {
                    let y = broken(fault, x, &sensor, severity, 9);
                    assert_eq!(y.shape(), shape);
                    assert!(y.iter().all(|v| (0.0..=FULL).contains(v)), "{fault} on {layout:?}");
                }
            }
        }
    }
}

#[test]
fn the_same_sample_breaks_the_same_way_and_another_one_another_way() {
    for (fault, layout, shape) in all() {
        let (x, sensor) = (press(layout, shape), Sensor::new(layout, FULL));
        let seeded = |seed, sample| {
            let mut y = x.clone();
            fault.apply(y.view_mut(), &sensor, 4, seed, sample).unwrap();
            y
        };
        assert_eq!(seeded(1, 0), seeded(1, 0), "{fault}");
        let random =
            !matches!(fault, Fault::Quantisation | Fault::Saturation | Fault::Hysteresis | Fault::Crosstalk);
        assert_eq!((1..20).any(|i| seeded(1, i) != seeded(1, 0)), random, "{fault}: samples");
        assert_eq!((2..20).any(|s| seeded(s, 0) != seeded(1, 0)), random, "{fault}: seeds");
    }
}

#[test]
fn the_memory_layout_of_the_readings_changes_nothing() {
    for (fault, layout, shape) in all() {
        let (x, sensor) = (press(layout, shape), Sensor::new(layout, FULL));
        let mut reversed = x.t().as_standard_layout().into_owned();
        fault.apply(reversed.view_mut().reversed_axes(), &sensor, 4, 3, 5).unwrap();
        assert_eq!(reversed.t(), broken(fault, &x, &sensor, 4, 5), "{fault} on {layout:?}");
    }
}

#[test]
fn noise_has_the_stated_deviation() {
    let x = ArrayD::from_elem(IxDyn(&[100, 400]), FULL / 2.0);
    for (severity, percent) in (1..).zip([1.0, 2.0, 5.0, 10.0]) {
        let y = broken(Fault::Noise, &x, &Sensor::new(Layout::Series, FULL), severity, 0);
        let sd = distance(&x, &y) / 200.0;
        let want = percent / 100.0 * f64::from(FULL);
        assert!((sd / want - 1.0).abs() < 0.02, "SD {sd}, want {want}");
    }
}

#[test]
fn a_converter_of_n_bits_has_2_to_the_n_levels_and_keeps_its_ends() {
    let x = Array1::linspace(-20.0, FULL, 5000).into_shape_with_order((1, 5000)).unwrap().into_dyn();
    let sensor = Sensor { low: -20.0, ..Sensor::new(Layout::Series, FULL) };
    for (severity, bits) in (1..).zip([8, 6, 5, 4, 3]) {
        let y = broken(Fault::Quantisation, &x, &sensor, severity, 0);
        let mut levels: Vec<f32> = y.iter().copied().collect();
        levels.dedup();
        assert_eq!(levels.len(), 1 << bits);
        assert_eq!((levels[0], levels[levels.len() - 1]), (-20.0, FULL));
        let step = 1020.0 / ((1 << bits) - 1) as f32;
        assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() <= 0.501 * step), "not the nearest level");
    }
}

#[test]
fn drift_ends_where_it_says_and_grows_evenly() {
    for (layout, shape) in LAYOUTS {
        let x = ArrayD::from_elem(shape, FULL / 2.0);
        for (severity, percent) in (1..).zip([2.0, 5.0, 10.0, 20.0, 40.0]) {
            let y = broken(Fault::Drift, &x, &Sensor::new(layout, FULL), severity, 1);
            let time = if layout == Layout::Sequence { Axis(0) } else { Axis(shape.len() - 1) };
            let end = percent / 100.0 * FULL;
            let away = (&y - &x).mapv(f32::abs);
            if !layout.has_time() {
                assert!(away.iter().all(|v| (v - end).abs() < 0.01), "{layout:?}");
                continue;
            }
            let times = shape[time.index()];
            for (t, now) in away.axis_iter(time).enumerate() {
                let want = end * t as f32 / (times - 1) as f32;
                assert!(now.iter().all(|v| (v - want).abs() < 0.01), "{layout:?} at {t}: {now}");
            }
        }
    }
    let x = ArrayD::from_elem(IxDyn(&[200, 2]), FULL / 2.0);
    let y = broken(Fault::Drift, &x, &Sensor::new(Layout::Series, FULL), 5, 1);
    let up = y.index_axis(Axis(1), 1).iter().filter(|&&v| v > FULL / 2.0).count();
    assert!((70..130).contains(&up), "up and down are equally likely: {up} of 200");
}

#[test]
fn a_gain_is_constant_in_time_spread_over_the_stated_range_and_leaves_rest_alone() {
    let mut sensor = Sensor::new(Layout::Series, FULL);
    sensor.rest = vec![100.0];
    let x = Array2::from_shape_fn((400, 4), |(_, t)| 100.0 + 100.0 * t as f32).into_dyn();
    for (severity, percent) in (1..).zip([5.0, 10.0, 20.0, 40.0, 60.0]) {
        let y = broken(Fault::Gain, &x, &sensor, severity, 0);
        let gains: Vec<f32> = y.outer_iter().map(|c| (c[[3]] - 100.0) / 300.0 - 1.0).collect();
        for (channel, gain) in y.outer_iter().zip(&gains) {
            let want = Array1::from_shape_fn(4, |t| 100.0 + 100.0 * t as f32 * (1.0 + gain));
            assert!((&channel - &want).iter().all(|v| v.abs() < 0.01), "{channel} {want}");
        }
        let (low, high) = gains.iter().fold((0f32, 0f32), |(l, h), &g| (l.min(g), h.max(g)));
        let bound = percent / 100.0;
        assert!(low >= -bound - 1e-5 && low < -0.95 * bound, "{low} for -{bound}");
        assert!(high <= bound + 1e-5 && high > 0.95 * bound, "{high} for {bound}");
    }
    let fingers = press(Layout::Fingers, &[2, 23, 100]);
    let y = broken(Fault::Gain, &fingers, &Sensor::new(Layout::Fingers, FULL), 3, 0);
    let ratio = &y / &fingers;
    assert!((ratio[[0, 0, 50]] - ratio[[0, 22, 50]]).abs() < 1e-5, "one gain for a finger");
    assert!((ratio[[0, 0, 50]] - ratio[[1, 0, 50]]).abs() > 1e-3, "fingers differ");
}

/// Share of elements, over many samples, all of whose readings are `value`.
fn share_at(fault: Fault, severity: u8, shape: &[usize; 2], value: f32) -> f64 {
    let x = ArrayD::from_elem(IxDyn(shape), FULL / 2.0);
    let mut sensor = Sensor::new(Layout::Series, FULL);
    sensor.rest = vec![30.0];
    let samples = 2000;
    let hit = (0..samples).map(|i| {
        let y = broken(fault, &x, &sensor, severity, i);
        y.outer_iter().filter(|channel| channel.iter().all(|&v| v == value)).count()
    });
    hit.sum::<usize>() as f64 / (samples * shape[0]) as f64
}

#[test]
fn the_stated_share_of_channels_is_dead_or_stuck() {
    for shape in [[5, 3], [40, 3]] {
        for severity in 1..=5 {
            for (fault, value) in [(Fault::Dead, 30.0), (Fault::Stuck, FULL)] {
                let share = share_at(fault, severity, &shape, value);
                let want = f64::from(fault.level(severity).unwrap()) / 100.0;
                assert!(
                    (share - want).abs() < 0.08 * want + 0.004,
                    "{fault} {severity}: {share}, want {want}"
                );
            }
        }
    }
}

#[test]
fn a_worse_severity_breaks_the_same_taxels_and_more() {
    let x = ArrayD::from_elem(IxDyn(&[28, 50]), FULL / 2.0);
    let sensor = Sensor::new(Layout::Image, FULL);
    for fault in [Fault::Dead, Fault::Stuck, Fault::DeadLine] {
        let hit = |severity| broken(fault, &x, &sensor, severity, 8).mapv(|v| v != FULL / 2.0);
        for severity in 1..5 {
            let (less, more) = (hit(severity), hit(severity + 1));
            assert!(less.iter().zip(&more).all(|(less, more)| !less || *more), "{fault}");
        }
    }
}

#[test]
fn dead_lines_are_whole_rows_columns_and_fingers() {
    for (severity, count) in (1..).zip([1, 2, 3, 4, 6]) {
        let image = ArrayD::from_elem(IxDyn(&[28, 50]), 7.0);
        let y = broken(Fault::DeadLine, &image, &Sensor::new(Layout::Image, FULL), severity, 0);
        let dead = |axis| y.axis_iter(Axis(axis)).filter(|line| line.iter().all(|&v| v == 0.0)).count();
        let (rows, columns) = (dead(0), dead(1));
        assert_eq!(rows + columns, count);
        let lost = rows * 50 + columns * 28 - rows * columns;
        assert_eq!(y.iter().filter(|&&v| v == 0.0).count(), lost, "nothing else is dead");

        let fingers = ArrayD::from_elem(IxDyn(&[4, 3, 10]), 7.0);
        let y = broken(Fault::DeadLine, &fingers, &Sensor::new(Layout::Fingers, FULL), severity, 0);
        let dead = y.outer_iter().filter(|finger| finger.iter().all(|&v| v == 0.0)).count();
        assert_eq!(dead, count.min(3), "one finger at least still feels");
    }
}

#[test]
fn saturation_clips_at_its_level_on_both_sides_of_rest() {
    let x = Array1::linspace(-FULL, FULL, 500).into_shape_with_order((1, 500)).unwrap().into_dyn();
    let sensor = Sensor { layout: Layout::Series, low: -FULL, high: FULL, rest: vec![200.0] };
    for (severity, share) in (1..).zip([0.8, 0.6, 0.5, 0.4, 0.3]) {
        let y = broken(Fault::Saturation, &x, &sensor, severity, 0);
        let (low, high) = (200.0 - share * 1200.0, 200.0 + share * 800.0);
        let want = x.mapv(|v| v.clamp(low, high));
        assert!(distance(&y, &want) < 0.01, "{share}");
    }
}

#[test]
fn the_loop_of_hysteresis_is_as_wide_as_stated_and_closed_at_both_ends() {
    let (n, peak) = (2001, 800.0);
    let x = Array2::from_shape_fn((1, n), |(_, t)| peak * (1.0 - (t as f32 / 1000.0 - 1.0).abs())).into_dyn();
    for (severity, share) in (1..).zip([0.05, 0.1, 0.2, 0.3, 0.5]) {
        let y = broken(Fault::Hysteresis, &x, &Sensor::new(Layout::Series, FULL), severity, 0);
        let (up, down) = (|t: usize| y[[0, t]], |t: usize| y[[0, n - 1 - t]]);
        assert!((0..=1000).all(|t| (up(t) - x[[0, t]]).abs() < 1e-3), "loading is as it was");
        let width = (0..=1000).map(|t| down(t) - up(t)).fold(0f32, f32::max);
        assert!((width - share * peak).abs() < 0.5, "{width}, want {}", share * peak);
        assert_eq!((down(0), down(1000)), (0.0, peak));
        assert!((0..1000).all(|t| down(t) < down(t + 1)), "unloading still falls");
    }
}

#[test]
fn crosstalk_gives_the_stated_share_to_the_neighbours() {
    for (severity, share) in (1..).zip([0.05, 0.1, 0.2, 0.3, 0.5]) {
        let mut image = ArrayD::zeros(IxDyn(&[7, 9]));
        image[[3, 4]] = 100.0;
        let y = broken(Fault::Crosstalk, &image, &Sensor::new(Layout::Image, FULL), severity, 0);
        let close = |at: [usize; 2], want: f32| (y[at] - want).abs() < 1e-3;
        assert!(close([3, 4], 100.0 * (1.0 - share)), "{share}");
        assert!([[2, 4], [4, 4], [3, 3], [3, 5]].into_iter().all(|at| close(at, 25.0 * share)), "{y}");
        assert!((y.sum() - 100.0).abs() < 1e-2, "nothing is lost inside");

        let mut fingers = ArrayD::zeros(IxDyn(&[2, 3, 4]));
        fingers.index_axis_mut(Axis(0), 0).index_axis_mut(Axis(0), 2).fill(100.0);
        let y = broken(Fault::Crosstalk, &fingers, &Sensor::new(Layout::Fingers, FULL), severity, 0);
        assert!((y[[0, 1, 0]] - 50.0 * share).abs() < 1e-3);
        assert!(y.index_axis(Axis(0), 1).iter().all(|&v| v == 0.0), "fingers do not bleed into each other");
        let offsets: Vec<f32> = vec![200.0, 50.0, 0.0];
        let idle = Array2::from_shape_fn((3, 4), |(c, _)| offsets[c]).into_dyn();
        let sensor = Sensor { rest: offsets, ..Sensor::new(Layout::Series, FULL) };
        assert_eq!(broken(Fault::Crosstalk, &idle, &sensor, severity, 0), idle, "offsets do not bleed");
    }
}

#[test]
fn a_dropped_frame_shows_the_one_before() {
    let (times, samples) = (50, 600);
    let x = Array2::from_shape_fn((3, times), |(c, t)| (1 + t + 100 * c) as f32).into_dyn();
    for severity in 1..=5 {
        let mut dropped = 0;
        for sample in 0..samples {
            let y = broken(Fault::Jitter, &x, &Sensor::new(Layout::Series, FULL), severity, sample);
            for t in 1..times {
                let held = y[[0, t]] != x[[0, t]];
                dropped += usize::from(held);
                let want = if held { t - 1 } else { t };
                let source = if held { &y } else { &x };
                assert!((0..3).all(|c| y[[c, t]] == source[[c, want]]), "all channels drop together");
            }
            assert_eq!(y[[0, 0]], 1.0);
        }
        let share = dropped as f64 / (times * samples) as f64;
        let want = f64::from(Fault::Jitter.level(severity).unwrap()) / 100.0;
        assert!((share - want).abs() < 0.05 * want, "{share}, want {want}");
    }
}

#[test]
fn the_window_starts_the_stated_share_late_or_early() {
    let x = Array2::from_shape_fn((2, 100), |(c, t)| (t + 200 * c) as f32).into_dyn();
    for (severity, count) in (1..).zip([2i32, 5, 10, 20, 30]) {
        let moves: Vec<i32> = (0..40)
            .map(|sample| {
                let y = broken(Fault::Onset, &x, &Sensor::new(Layout::Series, FULL), severity, sample);
                let by = y[[0, 50]] as i32 - 50;
                let want = ArrayD::from_shape_fn(x.raw_dim(), |at| {
                    ((at[1] as i32 + by).clamp(0, 99) + 200 * at[0] as i32) as f32
                });
                assert_eq!(y, want);
                by
            })
            .collect();
        assert!(moves.iter().all(|by| by.abs() == count), "{moves:?}");
        assert!(moves.contains(&count) && moves.contains(&-count), "late and early");
    }
}

#[test]
fn the_object_moves_by_whole_taxels_in_four_directions() {
    let at = |row: usize, column: usize| 1.0 + (row * 30 + column) as f32;
    let x = Array2::from_shape_fn((20, 30), |(r, c)| at(r, c)).into_dyn();
    let sensor = Sensor { rest: vec![0.5], ..Sensor::new(Layout::Image, FULL) };
    for (severity, taxels) in (1..).zip([1i32, 2, 4, 6, 8]) {
        let mut seen = std::collections::BTreeSet::new();
        for sample in 0..40 {
            let y = broken(Fault::Shift, &x, &sensor, severity, sample);
            let found = y[[10, 15]] as i32 - 1;
            let (down, right) = (10 - found / 30, 15 - found % 30);
            seen.insert((down, right));
            for (to, &v) in y.indexed_iter() {
                let from = (to[0] as i32 - down, to[1] as i32 - right);
                let inside = (0..20).contains(&from.0) && (0..30).contains(&from.1);
                assert_eq!(v, if inside { at(from.0 as usize, from.1 as usize) } else { 0.5 });
            }
        }
        assert_eq!(seen, [(-taxels, 0), (taxels, 0), (0, -taxels), (0, taxels)].into());
    }
}

#[test]
fn rotation_is_that_of_scipy() {
    let text = include_str!("data/rotation.json");
    let fixture: serde_json::Value = serde_json::from_str(text).unwrap();
    let list = |v: &serde_json::Value| -> Vec<f32> { serde_json::from_value(v.clone()).unwrap() };
    let shape: Vec<usize> = serde_json::from_value(fixture["shape"].clone()).unwrap();
    let x = ArrayD::from_shape_vec(shape.clone(), list(&fixture["image"])).unwrap();
    let mut matched = 0;
    for case in fixture["cases"].as_array().unwrap() {
        let degrees = case["degrees"].as_f64().unwrap() as f32;
        let severities = Fault::Rotation.severities();
        let severity = 1 + severities.iter().position(|&d| d == degrees.abs()).unwrap() as u8;
        let mut sensor = Sensor::new(Layout::Image, FULL);
        sensor.rest = vec![case["rest"].as_f64().unwrap() as f32];
        let want = ArrayD::from_shape_vec(shape.clone(), list(&case["turned"])).unwrap();
        let gap = |sample| {
            let y = broken(Fault::Rotation, &x, &sensor, severity, sample);
            y.iter().zip(&want).map(|(y, w)| (y - w).abs()).fold(0f32, f32::max)
        };
        // One way or the other: some samples must turn as this case does, and exactly so.
        let same = (0..20).filter(|&sample| gap(sample) < 2e-3).count();
        assert!((4..17).contains(&same), "{degrees}: {same} of 20");
        matched += 1;
    }
    assert_eq!(matched, 12);
}

#[test]
fn every_frame_moves_alike() {
    let x = press(Layout::Image, &[14, 25]);
    let both = ndarray::stack(Axis(0), &[x.view(), x.view()]).unwrap();
    for fault in [Fault::Shift, Fault::Rotation, Fault::Swap, Fault::DeadLine] {
        let y = broken(fault, &both, &Sensor::new(Layout::Sequence, FULL), 3, 2);
        assert_eq!(y.index_axis(Axis(0), 0), y.index_axis(Axis(0), 1), "{fault}");
        assert_eq!(y.index_axis(Axis(0), 0), broken(fault, &x, &Sensor::new(Layout::Image, FULL), 3, 2));
    }
}

/// Fewest swaps that put a permutation right.
fn swaps(order: &[usize]) -> usize {
    let mut order = order.to_vec();
    let mut count = 0;
    for i in 0..order.len() {
        while order[i] != i {
            let to = order[i];
            order.swap(i, to);
            count += 1;
        }
    }
    count
}

#[test]
fn the_stated_number_of_swaps_puts_the_channels_right_again() {
    for (layout, shape, channels) in [
        (Layout::Series, vec![5, 3], 5),
        (Layout::Series, vec![12, 3], 12),
        (Layout::Fingers, vec![2, 6, 3], 12),
        (Layout::Series, vec![1, 3], 1),
    ] {
        let times = 3;
        let x = ArrayD::from_shape_vec(shape, (0..channels * times).map(|i| i as f32).collect()).unwrap();
        for severity in 1..=5 {
            for sample in 0..30 {
                let y = broken(Fault::Swap, &x, &Sensor::new(layout, FULL), severity, sample);
                let y: Vec<f32> = y.into_iter().collect();
                let order: Vec<usize> = y.chunks(times).map(|c| c[0] as usize / times).collect();
                assert!(y.chunks(times).all(|c| c[1] == c[0] + 1.0 && c[2] == c[0] + 2.0));
                assert_eq!(swaps(&order), usize::from(severity).min(channels - 1), "{order:?}");
            }
        }
    }
    let x = Array2::from_shape_fn((9, 14), |(r, c)| (r * 14 + c) as f32).into_dyn();
    let (mut rows, mut columns) = (false, false);
    for sample in 0..20 {
        let y = broken(Fault::Swap, &x, &Sensor::new(Layout::Image, FULL), 2, sample);
        let row: Vec<usize> = (0..9).map(|r| y[[r, 0]] as usize / 14).collect();
        let column: Vec<usize> = (0..14).map(|c| y[[0, c]] as usize % 14).collect();
        assert_eq!(swaps(&row) + swaps(&column), 2, "two rows or two columns at a time");
        rows |= swaps(&row) > 0;
        columns |= swaps(&column) > 0;
    }
    assert!(rows && columns);
}

#[test]
fn a_lag_delays_one_channel_and_holds_its_first_reading() {
    let x = ArrayD::from_shape_fn(IxDyn(&[5, 40]), |at| (100 * at[0] + at[1]) as f32);
    let mut late = std::collections::BTreeSet::new();
    for sample in 0..40 {
        // 20 % of 40 readings.
        let y = broken(Fault::Lag, &x, &Sensor::new(Layout::Series, FULL), 4, sample);
        let changed: Vec<usize> =
            (0..5).filter(|c| y.index_axis(Axis(0), *c) != x.index_axis(Axis(0), *c)).collect();
        let [channel] = changed[..] else { panic!("{changed:?}") };
        assert!((0..40usize).all(|t| y[[channel, t]] == x[[channel, t.saturating_sub(8)]]));
        late.insert(channel);
    }
    assert_eq!(late.len(), 5, "every channel in turn");
}

#[test]
fn a_row_of_features_breaks_as_one_channel() {
    let row = press(Layout::Series, &[1, 60]).remove_axis(Axis(0));
    for fault in Fault::ALL {
        assert_eq!(fault.refusal(Layout::Features), fault.refusal(Layout::Series), "{fault}");
        if !fault.applicable(Layout::Features) {
            continue;
        }
        for (severity, sample) in (1..=5).flat_map(|severity| (0..8).map(move |sample| (severity, sample))) {
            let rest = Sensor { rest: vec![120.0], ..Sensor::new(Layout::Features, FULL) };
            let channel = Sensor { layout: Layout::Series, ..rest.clone() };
            let wanted = broken(fault, &row.clone().insert_axis(Axis(0)), &channel, severity, sample);
            assert_eq!(broken(fault, &row, &rest, severity, sample), wanted.remove_axis(Axis(0)), "{fault}");
        }
    }
    let mut channel = row.insert_axis(Axis(0));
    let error = Fault::Noise.apply(channel.view_mut(), &Sensor::new(Layout::Features, FULL), 1, 0, 4);
    let message = "sample 4: shape [1, 60] is not a row of features [F]";
    assert_eq!(error.unwrap_err().to_string(), message);
}

#[test]
fn what_has_no_meaning_is_refused_by_name() {
    let mut x = ArrayD::from_elem(IxDyn(&[5, 50]), 1.0);
    let error = Fault::Rotation.apply(x.view_mut(), &Sensor::new(Layout::Series, FULL), 1, 0, 0);
    assert_eq!(
        error.unwrap_err().to_string(),
        "fault rotation has no meaning for a series [C, T]: it moves the object over an array, and channels \
         have no place"
    );
    let error = Fault::Jitter.apply(x.view_mut(), &Sensor::new(Layout::Image, FULL), 1, 0, 0);
    assert!(matches!(error, Err(Error::Fault { fault: "jitter", .. })));
    assert_eq!(
        LAYOUTS.map(|(layout, _)| Fault::ALL.iter().filter(|f| f.applicable(layout)).count()),
        [14, 14, 12, 12, 16, 14]
    );
}

#[test]
fn impossible_requests_name_the_value_and_leave_the_readings_alone() {
    let clean = ArrayD::from_elem(IxDyn(&[5, 50]), 1.0);
    let sensor = Sensor::new(Layout::Series, FULL);
    let refused = |x: &ArrayD<f32>, sensor: &Sensor, severity| {
        let mut y = x.clone();
        let error = Fault::Noise.apply(y.view_mut(), sensor, severity, 0, 7).unwrap_err().to_string();
        assert!(y.iter().zip(x).all(|(y, x)| y.to_bits() == x.to_bits()));
        error
    };
    assert_eq!(refused(&clean, &sensor, 0), "severity = 0: must be in 1..=5");
    assert_eq!(refused(&clean, &sensor, 6), "severity = 6: must be in 1..=5");
    let mut bad = clean.clone();
    bad[[2, 17]] = f32::NAN;
    assert_eq!(
        refused(&bad, &sensor, 1),
        "sample 7: reading [2, 17] is NaN; drop or interpolate bad taxels first"
    );
    let flat = clean.clone().into_shape_with_order(IxDyn(&[250])).unwrap();
    assert_eq!(refused(&flat, &sensor, 1), "sample 7: shape [250] is not a series [C, T]");
    let four = ArrayD::from_elem(IxDyn(&[4, 5, 6]), 1.0);
    let colour = refused(&four, &Sensor::new(Layout::Colour, FULL), 1);
    assert_eq!(colour, "sample 7: shape [4, 5, 6] is not a colour image [3, H, W]");
    let empty = ArrayD::zeros(IxDyn(&[0, 50]));
    assert_eq!(refused(&empty, &sensor, 1), "sample 7: shape [0, 50] is not a series [C, T]");
    let refused = |sensor: Sensor| refused(&clean, &sensor, 1);
    assert!(refused(Sensor::new(Layout::Series, 0.0)).starts_with("range of the readings = 0..0: "));
    assert!(refused(Sensor::new(Layout::Series, f32::NAN)).starts_with("range of the readings = 0..NaN: "));
    let rest = |rest| Sensor { rest, ..sensor.clone() };
    assert!(refused(rest(vec![1.0, 2.0])).starts_with("number of rest values = 2: "));
    assert!(refused(rest(vec![-1.0])).starts_with("rest = -1: "));
    assert!(refused(rest(vec![f32::NAN])).starts_with("rest = NaN: "));
}

#[test]
fn names_are_read_back() {
    for fault in Fault::ALL {
        assert_eq!(fault.name().parse(), Ok(fault));
        assert_eq!(serde_json::to_value(fault).unwrap(), fault.name());
    }
    let error = "rust".parse::<Fault>().unwrap_err().to_string();
    assert!(error.starts_with("there is no fault `rust`; known: noise, quantisation, "), "{error}");
}
