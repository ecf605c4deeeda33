//! A model on a stream: which windows are decided, when, and by which numbers.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use ndarray::{ArrayD, IxDyn};
use support::{CHANNELS, TICKS, model, reading};
use taxel_data::Padding;
use taxel_learn::Model;
use taxel_stream::{Condition, Decider, StreamOptions};

/// Last time step, time steps known and probabilities of every decision on `readings`.
type Decisions = Vec<(u64, usize, Vec<f32>)>;

fn decider(model: &Model, options: &StreamOptions) -> Decider {
    Decider::new(model.predictor(1, 1).unwrap(), options).unwrap()
}

fn decisions(decider: &mut Decider, readings: impl IntoIterator<Item = [f32; CHANNELS]>) -> Decisions {
    let mut all = vec![];
    for reading in readings {
        all.extend(decider.push(&reading).map(|d| (d.reading, d.known, d.probabilities().unwrap().to_vec())));
    }
    all
}

/// Returns the prediction for the window of `known` time steps that ends with `last`, padded.
fn predicted(model: &Model, last: u64, known: usize, padding: Padding) -> Vec<f32> {
    let mut sample = vec![0.0; CHANNELS * TICKS];
    for tick in 0..known {
        let values = reading(last as usize + 1 - known + tick);
        (0..CHANNELS).for_each(|channel| sample[channel * TICKS + tick] = values[channel]);
    }
    padding.fill(&mut sample, (CHANNELS, 1), known);
    let x = ArrayD::from_shape_vec(IxDyn(&[1, CHANNELS, TICKS]), sample).unwrap();
    model.predict(&x).unwrap().outputs
}

fn lasts(all: &Decisions) -> Vec<u64> {
    all.iter().map(|decision| decision.0).collect()
}

#[test]
fn windows_slide_by_the_hop_with_the_answers_of_predict() {
    let model = model();
    let windows = |hop: Option<usize>, readings: usize| {
        decisions(
            &mut decider(&model, &StreamOptions { hop, ..StreamOptions::default() }),
            (0..readings).map(reading),
        )
    };
    // Windows of 12 time steps; a quarter is 3.
    assert_eq!(lasts(&windows(None, 20)), [11, 14, 17]);
    assert_eq!(lasts(&windows(Some(1), 14)), [11, 12, 13]);
    assert_eq!(lasts(&windows(Some(12), 40)), [11, 23, 35]);
    assert_eq!(lasts(&windows(Some(15), 60)), [11, 26, 41, 56], "three readings are in no window");
    for (last, known, probabilities) in windows(Some(5), 60) {
        assert_eq!(known, TICKS);
        let want = predicted(&model, last, known, Padding::Zero);
        assert_eq!(
            probabilities.iter().map(|p| p.to_bits()).collect::<Vec<_>>(),
            want.iter().map(|p| p.to_bits()).collect::<Vec<_>>()
        );
    }
}

#[test]
fn an_early_decision_is_made_once_as_soon_as_the_model_is_sure() {
    let model = model();
    for padding in [Padding::Zero, Padding::Edge] {
        // A confidence that is reached somewhere on the way: the highest that the first window shows before it is full.
        let sure = |known: usize| {
            predicted(&model, known as u64 - 1, known, padding).into_iter().fold(0.0, f32::max)
        };
        let most = (1..TICKS).map(sure).fold(0.0, f32::max);
        let first = (1..TICKS).find(|known| sure(*known) == most).unwrap();
        let options = StreamOptions {
            early: Some(most),
            least: Some(1),
            padding: Some(padding),
            hop: Some(TICKS),
            ..StreamOptions::default()
        };
        let all = decisions(&mut decider(&model, &options), (0..TICKS).map(reading));
        assert_eq!(all.len(), 1, "once per window");
        assert_eq!((all[0].0, all[0].1), (first as u64 - 1, first));
        assert_eq!(all[0].2, predicted(&model, first as u64 - 1, first, padding));
        // Never sure: decided when it is full.
        let options = StreamOptions { early: Some(1.0), ..options };
        assert_eq!(lasts(&decisions(&mut decider(&model, &options), (0..24).map(reading))), [11, 23]);
        // Always sure: with the first time step of each window, of which the next begins with what is there.
        let options = StreamOptions { early: Some(0.01), hop: Some(4), ..options };
        let all = decisions(&mut decider(&model, &options), (0..20).map(reading));
        assert_eq!(
            all.iter().map(|decision| (decision.0, decision.1)).collect::<Vec<_>>(),
            [(0, 1), (12, 9), (16, 9)]
        );
        // By default with a tenth of 12 time steps, two, or as many as are said.
        for (least, first) in [(None, 1), (Some(7), 6), (Some(99), 11)] {
            let all =
                decisions(&mut decider(&model, &StreamOptions { least, ..options }), (0..12).map(reading));
            assert_eq!(lasts(&all), [first]);
        }
    }
}

#[test]
fn contact_begins_a_window_and_its_end_waits_for_the_next() {
    let model = model();
    let options = StreamOptions { contact: true, hop: Some(6), ..StreamOptions::default() };
    // Level 10 at rest, contact from 30 to 34 and from 60 to 99.
    let at = |t: usize| [if (30..35).contains(&t) || (60..100).contains(&t) { 20.0 } else { 10.0 }, 10.0];
    let mut stream = decider(&model, &options);
    let all = decisions(&mut stream, (0..120).map(at));
    assert_eq!(lasts(&all), [41, 71, 77, 83, 89, 95, 101]);
    assert_eq!(stream.contacts(), 2);
    let before = StreamOptions { before: Some(4), ..options };
    assert_eq!(lasts(&decisions(&mut decider(&model, &before), (0..60).map(at))), [37]);
    // A gap lets go: contact that goes on begins again.
    let mut stream = decider(&model, &options);
    decisions(&mut stream, (0..65).map(at));
    stream.anew();
    assert_eq!(lasts(&decisions(&mut stream, (65..80).map(at))), [76]);
    let mut blind = decider(&model, &options);
    assert!(decisions(&mut blind, (0..60).map(|t| [t as f32 - 100.0, 0.0])).is_empty());
    assert!(blind.waits_in_vain() && !stream.waits_in_vain());
}

#[test]
fn missing_readings_and_another_recording_begin_a_window_anew() {
    let model = model();
    let mut stream = decider(&model, &StreamOptions { hop: Some(12), ..StreamOptions::default() });
    assert!(decisions(&mut stream, (0..11).map(reading)).is_empty());
    stream.anew();
    assert_eq!(lasts(&decisions(&mut stream, (11..30).map(reading))), [22], "readings are counted on");
    stream.begin();
    assert_eq!(lasts(&decisions(&mut stream, (0..12).map(reading))), [11]);
    assert!(stream.push(&[1.0]).is_none(), "no reading of this model");
}

#[test]
fn what_is_wrong_with_the_channels_stands_beside_the_decision() {
    let model = model();
    let mut stream = decider(&model, &StreamOptions { full_scale: Some(5.0), ..StreamOptions::default() });
    let mut last = None;
    for t in 0..30 {
        if let Some(d) = stream.push(&[7.0, t as f32 / 7.0]) {
            let stuck: Vec<usize> = d.health.in_condition(Condition::Stuck).collect();
            last = Some((d.reading, stuck, d.health.saturated(d.known).collect::<Vec<_>>()));
        }
    }
    assert_eq!(last, Some((29, vec![0], vec![0])));
}

#[test]
fn options_out_of_their_range_are_refused_by_name() {
    let refused = |options: StreamOptions| match Decider::new(model().predictor(1, 1).unwrap(), &options) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{options:?}"),
    };
    let default = StreamOptions::default();
    assert!(refused(StreamOptions { hop: Some(0), ..default }).contains("hop 0"));
    assert!(refused(StreamOptions { early: Some(0.0), ..default }).contains("early 0"));
    assert!(refused(StreamOptions { early: Some(1.5), ..default }).contains("early 1.5"));
    assert!(refused(StreamOptions { full_scale: Some(-1.0), ..default }).contains("full-scale -1"));
    assert!(refused(StreamOptions { before: Some(12), ..default }).contains("before 12"));
}
