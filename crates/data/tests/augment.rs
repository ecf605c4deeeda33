//! Augmentation: warps are those of scipy (`scripts/fixtures/affine.py`), draws depend on their key.

#![allow(clippy::unwrap_used)]

use taxel_data::{Augment, Key, Layout, Warp};

const KEY: Key = Key { seed: 1, repetition: 0, fold: 2, epoch: 3, sample: 4 };
const NOTHING: Warp =
    Warp { flip_rows: false, flip_columns: false, shift: [0.0; 2], scale: 1.0, degrees: 0.0 };

fn list(value: &serde_json::Value) -> Vec<f32> {
    serde_json::from_value(value.clone()).unwrap()
}

#[test]
fn warps_are_those_of_scipy() {
    let fixture: serde_json::Value = serde_json::from_str(include_str!("data/affine.json")).unwrap();
    let shape: [usize; 2] = serde_json::from_value(fixture["shape"].clone()).unwrap();
    let (image, outside) = (list(&fixture["image"]), fixture["outside"].as_f64().unwrap() as f32);
    let cases = fixture["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 9);
    for case in cases {
        let warp = Warp {
            flip_rows: case["flip_rows"].as_bool().unwrap(),
            flip_columns: case["flip_columns"].as_bool().unwrap(),
            shift: serde_json::from_value(case["shift"].clone()).unwrap(),
            scale: case["scale"].as_f64().unwrap(),
            degrees: case["degrees"].as_f64().unwrap(),
        };
        let mut got = image.clone();
        warp.apply(&mut got, [1, shape[0], shape[1], 1], outside);
        let want = list(&case["warped"]);
        assert_eq!(got.len(), want.len());
        for (at, (got, want)) in got.iter().zip(&want).enumerate() {
            // The fixture has six digits.
            assert!((got - want).abs() < 1e-3, "{warp:?} at {at}: got {got}, want {want}");
        }
    }
}

#[test]
fn nothing_and_reflections_move_values_and_change_none() {
    let image: Vec<f32> = (0..24).map(|i| (i as f32).sin()).collect();
    let mut same = image.clone();
    NOTHING.apply(&mut same, [2, 3, 4, 1], 9.0);
    assert_eq!(same, image);
    let mut both = image.clone();
    Warp { flip_rows: true, flip_columns: true, ..NOTHING }.apply(&mut both, [1, 6, 4, 1], 9.0);
    assert!(both.iter().eq(image.iter().rev()), "both ways is the list backwards");
}

#[test]
fn channels_and_frames_warp_alike() {
    let (rows, columns) = (7, 5);
    let plane: Vec<f32> = (0..35).map(|i| (i as f32 * 0.7).cos()).collect();
    let warp = Warp { shift: [0.4, -1.3], scale: 1.1, degrees: 8.0, ..NOTHING };
    let mut one = plane.clone();
    warp.apply(&mut one, [1, rows, columns, 1], 0.5);
    let mut channels: Vec<f32> = plane.iter().chain(&plane).copied().collect();
    warp.apply(&mut channels, [2, rows, columns, 1], 0.5);
    assert!(channels.chunks(35).all(|c| c == one));
    let mut frames: Vec<f32> = plane.iter().flat_map(|&v| [v, v, v]).collect();
    warp.apply(&mut frames, [1, rows, columns, 3], 0.5);
    assert!(frames.chunks(3).zip(&one).all(|(frames, v)| frames.iter().all(|f| f == v)));
}

#[test]
fn a_draw_depends_on_its_key_alone() {
    let augment = Augment { scale: [0.9, 1.1], ..Augment::tactnet() };
    let draw = |key: Key| augment.draw(&key);
    assert_eq!(draw(KEY), draw(KEY));
    let others = [
        Key { seed: 9, ..KEY },
        Key { repetition: 9, ..KEY },
        Key { fold: 9, ..KEY },
        Key { epoch: 9, ..KEY },
        Key { sample: 9, ..KEY },
    ];
    assert!(others.into_iter().all(|key| draw(key).shift != draw(KEY).shift));
    // Digits of neighbouring fields must not run into each other.
    assert_ne!(
        draw(Key { epoch: 11, sample: 1, ..KEY }).shift,
        draw(Key { epoch: 1, sample: 11, ..KEY }).shift
    );
    let upright = Augment { rotate: 0.0, flip_rows: false, ..augment };
    assert_eq!(upright.draw(&KEY), Warp { degrees: 0.0, flip_rows: false, ..draw(KEY) });
    assert_eq!(Augment::default().draw(&KEY), NOTHING);
}

#[test]
fn draws_fill_their_ranges_evenly() {
    let augment = Augment { scale: [0.8, 1.2], ..Augment::tactnet() };
    let warps: Vec<Warp> = (0..4000).map(|sample| augment.draw(&Key { sample, ..KEY })).collect();
    let spread = |of: fn(&Warp) -> f64, low: f64, high: f64| {
        let values: Vec<f64> = warps.iter().map(of).collect();
        let quarter = values.iter().filter(|&&v| v < low + (high - low) / 4.0).count();
        assert!(values.iter().all(|v| (low..=high).contains(v)));
        assert!((900..1100).contains(&quarter), "{quarter} of 4000 in the lowest quarter");
    };
    spread(|w| w.shift[0], -3.0, 3.0);
    spread(|w| w.shift[1], -3.0, 3.0);
    spread(|w| w.degrees, -10.0, 10.0);
    spread(|w| w.scale, 0.8, 1.2);
    let share = |of: fn(&Warp) -> bool| warps.iter().filter(|w| of(w)).count();
    for half in [share(|w| w.flip_rows), share(|w| w.flip_columns), share(|w| w.flip_rows == w.flip_columns)]
    {
        assert!((1900..2100).contains(&half), "{half} of 4000");
    }
}

#[test]
fn impossible_amounts_name_the_key() {
    let refused = |augment: Augment| augment.check().unwrap_err().to_string();
    let none = Augment::default();
    assert!(none.check().is_ok() && Augment::tactnet().check().is_ok());
    assert_eq!(refused(Augment { shift: -1.0, ..none }), "shift = -1: must be in 0..=10000 taxels");
    assert!(refused(Augment { shift: f64::NAN, ..none }).starts_with("shift = NaN"));
    assert!(refused(Augment { rotate: 181.0, ..none }).starts_with("rotate = 181"));
    for scale in [[0.0, 1.0], [1.1, 0.9], [1.0, f64::INFINITY], [f64::NAN, 1.0]] {
        assert!(refused(Augment { scale, ..none }).starts_with("scale = ["), "{scale:?}");
    }
    assert!(
        refused(Augment { gain: [1.1, 0.9], ..none }).starts_with("gain = [1.1, 0.9]: must be [smallest")
    );
    assert!(refused(Augment { time_warp: [0.0, 1.0], ..none }).starts_with("time_warp = [0, 1]"));
    assert!(
        refused(Augment { jitter: 1.5, ..none }).starts_with("jitter = 1.5: must be a share of the range")
    );
    assert!(refused(Augment { time_shift: f64::NAN, ..none }).starts_with("time_shift = NaN"));
    let error = serde_json::from_str::<Augment>(r#"{"flip": true}"#).unwrap_err().to_string();
    assert!(error.contains("unknown field `flip`, expected one of `flip_rows`"), "{error}");
}

#[test]
fn readings_change_by_draws_of_their_own() {
    let all = Augment {
        gain: [0.5, 2.0],
        jitter: 0.1,
        time_shift: 0.2,
        time_warp: [0.8, 1.25],
        ..Augment::default()
    };
    let draw = |augment: &Augment, key: Key| {
        let change = augment.draw_readings(&key);
        [change.gain, change.duration, change.shift, change.jitter]
    };
    assert_eq!(draw(&all, KEY), draw(&all, KEY));
    assert_ne!(draw(&all, KEY), draw(&all, Key { epoch: 9, ..KEY }));
    assert_eq!(draw(&Augment::default(), KEY), [1.0, 1.0, 0.0, 0.0]);
    // One that is left out does not move the others.
    let [_, duration, shift, jitter] = draw(&all, KEY);
    assert_eq!(draw(&Augment { gain: [1.0, 1.0], ..all }, KEY), [1.0, duration, shift, jitter]);
    let draws: Vec<[f64; 4]> = (0..4000).map(|sample| draw(&all, Key { sample, ..KEY })).collect();
    for (of, low, high) in [(0, 0.5, 2.0), (1, 0.8, 1.25), (2, -0.2, 0.2)] {
        let values: Vec<f64> = draws.iter().map(|draw| draw[of]).collect();
        assert!(values.iter().all(|v| (low..=high).contains(v)));
        // Factors are as often below 1 as above.
        let middle = if of == 2 { 0.0 } else { 1.0 };
        let below = values.iter().filter(|v| **v < middle).count();
        assert!((1900..2100).contains(&below), "{below} of 4000");
    }
}

#[test]
fn keys_say_what_they_change() {
    let none = Augment::default();
    assert!(!none.changes_images() && !none.changes_readings());
    assert!(Augment::tactnet().changes_images() && !Augment::tactnet().changes_readings());
    let gain = Augment { gain: [0.5, 2.0], ..none };
    assert!(gain.changes_readings() && !gain.changes_images());
    let moved = Augment { time_shift: 0.1, ..none };
    assert!(gain.check_layout(Layout::Features).is_ok() && moved.check_layout(Layout::Series).is_ok());
    let error = moved.check_layout(Layout::Features).unwrap_err().to_string();
    assert!(error.starts_with("time_shift = 0.1: moves readings in time"), "{error}");
    // Settings of images are written as they were before readings had any.
    let written = serde_json::to_value(Augment::tactnet()).unwrap();
    assert_eq!(written.as_object().unwrap().len(), 5);
}
