//! Laws that hold for all samples.

#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use ndarray::{Array3, ArrayD, Axis, IxDyn};
use proptest::prelude::*;
use taxel_guard::{BrokenKind, Error, Guard, KnownRange, Layout, Watch};

fn watch(train: &ArrayD<f32>, layout: Layout) -> Watch {
    Watch::new(Arc::new(Guard::fit(train.view(), layout, &KnownRange::default()).unwrap()))
}

/// Channels that follow one force.
fn presses(count: usize, channels: usize, times: usize) -> ArrayD<f32> {
    Array3::from_shape_fn((count, channels, times), |(i, c, t)| {
        let force = (i % 9 + 2) as f32 * (t as f32 * 0.3).sin().abs();
        5.0 + force * (c + 1) as f32 + ((i * 31 + c * 17 + t * 7) % 13) as f32 * 0.05
    })
    .into_dyn()
}

fn images(count: usize, side: usize) -> ArrayD<f32> {
    Array3::from_shape_fn((count, side, side), |(i, r, c)| {
        let (dr, dc) = (r as f32 - (2 + i % 4) as f32, c as f32 - (2 + i / 4 % 4) as f32);
        (200.0 * (-(dr * dr + dc * dc) / 9.0).exp()).round() + ((i + r * 3 + c * 5) % 3) as f32
    })
    .into_dyn()
}

fn shapes() -> impl Strategy<Value = (Layout, Vec<usize>)> {
    let side = 1..5usize;
    prop_oneof![
        (1..9usize).prop_map(|n| (Layout::Features, vec![n])),
        (1..6usize, 1..9usize).prop_map(|(c, t)| (Layout::Series, vec![c, t])),
        (side.clone(), side.clone()).prop_map(|(h, w)| (Layout::Image, vec![h, w])),
        (side.clone(), side.clone()).prop_map(|(h, w)| (Layout::Colour, vec![3, h, w])),
        (1..7usize, side.clone(), side.clone()).prop_map(|(t, h, w)| (Layout::Sequence, vec![t, h, w])),
        (1..4usize, side, 1..7usize).prop_map(|(f, c, t)| (Layout::Fingers, vec![f, c, t])),
    ]
}

/// A set of some samples and one more, of readings of all sizes.
fn sets() -> impl Strategy<Value = (Layout, ArrayD<f32>, Vec<f32>)> {
    let reading = prop_oneof![
        Just(0.0f32),
        Just(255.0),
        -10.0..300.0f32,
        -1e-30..1e-30f32,
        prop::num::f32::NORMAL,
        Just(f32::MAX),
        Just(f32::MIN)
    ];
    (shapes(), 1..7usize).prop_flat_map(move |((layout, shape), count)| {
        let each: usize = shape.iter().product();
        let shape = [&[count], &shape[..]].concat();
        let train = prop::collection::vec(reading.clone(), each * count);
        let train = train.prop_map(move |values| ArrayD::from_shape_vec(IxDyn(&shape), values).unwrap());
        (Just(layout), train, prop::collection::vec(reading.clone(), each))
    })
}

proptest! {
    #[test]
    fn mending_never_makes_a_reading_that_is_not_finite((layout, train, mut sample) in sets()) {
        let mut watch = watch(&train, layout);
        watch.guard().check(layout, &train.shape()[1..]).unwrap();
        let before = sample.clone();
        let found = watch.mend(&mut sample).to_vec();
        prop_assert!(sample.iter().all(|value| value.is_finite()), "{sample:?}");
        let mut elements: Vec<usize> = found.iter().map(|replaced| replaced.element).collect();
        elements.sort_unstable();
        elements.dedup();
        prop_assert_eq!(elements.len(), found.len(), "each once");
        prop_assert!(found.len() <= (watch.guard().elements() / 2).max(1));
        prop_assert!(!found.is_empty() || sample == before, "what is not found stays");
    }

    #[test]
    fn a_sample_is_mended_alike_whatever_came_before((layout, train, sample) in sets()) {
        let fresh = watch(&train, layout);
        let mut used = fresh.clone();
        for other in train.outer_iter() {
            used.mend(&mut other.iter().copied().collect::<Vec<f32>>());
        }
        let (mut a, mut b) = (sample.clone(), sample);
        let found = fresh.clone().mend(&mut a).to_vec();
        prop_assert_eq!(found.as_slice(), used.mend(&mut b));
        prop_assert_eq!(a, b);
    }

    #[test]
    fn nothing_is_found_in_a_set_that_never_varies((layout, shape) in shapes(), value in -1e3..1e3f32) {
        let train = ArrayD::from_elem(IxDyn(&[&[5], &shape[..]].concat()), value);
        let mut sample = vec![value; shape.iter().product()];
        prop_assert!(watch(&train, layout).mend(&mut sample).is_empty());
        // Nor in whatever else it reads: nothing was learned.
        sample.fill(value + 100.0);
        prop_assert!(watch(&train, layout).mend(&mut sample).is_empty());
    }

    #[test]
    fn a_stuck_or_dead_channel_is_found_and_comes_close(sample in 0..40usize, channel in 0..6usize, dead in any::<bool>()) {
        let train = presses(40, 6, 24);
        let clean: Vec<f32> = train.index_axis(Axis(0), sample).iter().copied().collect();
        let mut watch = watch(&train, Layout::Series);
        let mut broken = clean.clone();
        prop_assert!(watch.mend(&mut broken).is_empty(), "a training sample is clean");
        let value = if dead { clean[channel * 24] } else { 300.0 };
        broken[channel * 24..][..24].fill(value);
        let found = watch.mend(&mut broken).to_vec();
        prop_assert_eq!(found.iter().map(|replaced| replaced.element).collect::<Vec<_>>(), [channel]);
        prop_assert!(broken.iter().zip(&clean).all(|(a, b)| (a - b).abs() < 1.5), "{:?}", found);
    }

    #[test]
    fn a_stuck_taxel_is_found_and_its_neighbours_are_not(image in 0..16usize, taxel in 0..64usize) {
        let train = images(48, 8);
        let mut watch = watch(&train, Layout::Image);
        let clean: Vec<f32> = train.index_axis(Axis(0), image).iter().copied().collect();
        let mut broken = clean.clone();
        prop_assert!(watch.mend(&mut broken).is_empty());
        broken[taxel] = 255.0;
        if clean[taxel] >= 100.0 {
            // Pressed hard it reads much the same.
            return Ok(());
        }
        let found = watch.mend(&mut broken).to_vec();
        prop_assert_eq!(found.iter().map(|replaced| replaced.element).collect::<Vec<_>>(), [taxel]);
        prop_assert!((broken[taxel] - clean[taxel]).abs() < 60.0);
    }

    #[test]
    fn the_order_of_training_samples_is_irrelevant(turn in 1..40usize) {
        let train = presses(40, 6, 24);
        let order: Vec<usize> = (0..40).map(|i| (i + turn) % 40).collect();
        let mut a = watch(&train, Layout::Series);
        let mut b = watch(&train.select(Axis(0), &order), Layout::Series);
        for (i, sample) in train.outer_iter().enumerate() {
            let mut x: Vec<f32> = sample.iter().copied().collect();
            x[(i % 6) * 24..][..24].fill(if i % 3 == 0 { 60.0 } else { 5.0 });
            let mut y = x.clone();
            prop_assert_eq!(a.mend(&mut x), b.mend(&mut y));
            prop_assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-3));
        }
    }
}

#[test]
fn a_sample_of_another_length_or_with_a_gap_stays_as_it_is() {
    let mut watch = watch(&presses(40, 6, 24), Layout::Series);
    let mut short = vec![1e6; 5];
    assert!(watch.mend(&mut short).is_empty() && short == [1e6; 5]);
    let mut gap = vec![1e6; 6 * 24];
    gap[3] = f32::NAN;
    assert!(watch.mend(&mut gap).is_empty() && gap[4] == 1e6);
}

#[test]
fn many_channels_have_their_neighbours_nearby() {
    let mut watch = watch(&presses(30, 80, 8), Layout::Series);
    let mut sample: Vec<f32> = presses(1, 80, 8).iter().copied().collect();
    sample[70 * 8..71 * 8].fill(5.0);
    let found = watch.mend(&mut sample).to_vec();
    assert!(found.len() == 1 && found[0].element == 70, "{found:?}");
    let said = serde_json::to_value(watch.guard()).unwrap();
    let from = |element: usize| {
        said["links"][element]
            .as_array()
            .unwrap()
            .iter()
            .map(|l| l["from"].as_u64().unwrap() as usize)
            .collect::<Vec<_>>()
    };
    assert!(
        (0..80).all(|element| from(element).len() == 4
            && from(element).iter().all(|from| from.abs_diff(element) <= 16))
    );
}

#[test]
fn facts_about_the_sensor_are_taken() {
    let train = presses(40, 6, 24);
    let facts = KnownRange { full_scale: Some(1000.0), rest: Some(&[3.0]) };
    let mut watch = Watch::new(Arc::new(Guard::fit(train.view(), Layout::Series, &facts).unwrap()));
    let mut sample: Vec<f32> = train.index_axis(Axis(0), 0).iter().copied().collect();
    sample[..24].fill(1000.0);
    sample[48..72].fill(3.0);
    let kinds: Vec<BrokenKind> = watch.mend(&mut sample).iter().map(|replaced| replaced.kind).collect();
    assert_eq!(kinds, [BrokenKind::Full, BrokenKind::Rest]);
    assert!(watch.guard().words().starts_with("on: 6 channels; readings 0 to 1000, fitted on 40 samples"));
}

#[test]
fn what_cannot_be_learned_from_is_refused() {
    let train = presses(4, 2, 3);
    let fit = |x: &ArrayD<f32>, layout, facts: &KnownRange| Guard::fit(x.view(), layout, facts).unwrap_err();
    let (none, gap) = (ArrayD::zeros(IxDyn(&[0, 2, 3])), {
        let mut gap = train.clone();
        gap[[2, 1, 0]] = f32::INFINITY;
        gap
    });
    assert!(matches!(fit(&none, Layout::Series, &KnownRange::default()), Error::Shape { .. }));
    assert!(
        fit(&train, Layout::Sequence, &KnownRange::default())
            .to_string()
            .contains("these have shape [4, 2, 3]")
    );
    let message = fit(&gap, Layout::Series, &KnownRange::default()).to_string();
    assert!(message.starts_with("reading 3 of sample 2 is inf"), "{message}");
    let facts = KnownRange { rest: Some(&[0.0; 3]), ..KnownRange::default() };
    assert!(fit(&train, Layout::Series, &facts).to_string().starts_with("3 rest values for 2 channels"));
}
