//! Inputs: what is fitted, on which samples, and what is refused.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use ndarray::{Array3, ArrayD, Axis};
use serde_json::{Value, json};
use taxel_base::Layout;
use taxel_baselines::{MiniRocket, Series};
use taxel_data::Dataset;
use taxel_encodings::Scaling;
use taxel_learn::encoding::{IMAGE, Input, ROCKET, SERIES, SIGNAL};
use taxel_learn::{Encoder, Encoding, Error, Transform};

/// An encoding as a config writes it.
fn encoding(value: Value) -> Encoding {
    let encoding: Encoding = serde_json::from_value(value).unwrap();
    encoding.check().unwrap();
    encoding
}

/// The inputs in `names` of every sample, fitted on `train`.
fn inputs(value: Value, ladder: &Dataset, names: &[&str], train: &[usize]) -> Result<Vec<Input>, Error> {
    let mut encoder = Encoder::new(&encoding(value), ladder);
    encoder.prepare(names)?;
    encoder.fit(names, train)
}

/// Returns the message for samples that cannot be encoded.
fn refusal(value: Value, ladder: &Dataset, names: &[&str], train: &[usize]) -> String {
    inputs(value, ladder, names, train).err().unwrap().to_string()
}

/// Eight samples 2 × 6 in two classes; sample i lies around i in channel 0.
fn ladder() -> Dataset {
    let x = Array3::from_shape_fn((8, 2, 6), |(i, c, t)| (i + 10 * c) as f32 + 0.1 * t as f32);
    Dataset::new("ladder", Layout::Series, x.into_dyn(), &["a", "b"].repeat(4)).unwrap()
}

/// Its samples `rows` alone.
fn with_samples(ladder: &Dataset, rows: &[usize]) -> Dataset {
    let classes: Vec<&str> = rows.iter().map(|i| ["a", "b"][i % 2]).collect();
    Dataset::new("ladder", Layout::Series, ladder.x.select(Axis(0), rows), &classes).unwrap()
}

/// The same classes with other samples.
fn with(layout: Layout, x: ArrayD<f32>) -> Dataset {
    Dataset::new("ladder", layout, x, &["a", "b"].repeat(4)).unwrap()
}

#[test]
fn z_scores_know_the_training_part_only() {
    let ladder = ladder();
    let mut encoder = Encoder::new(&Encoding::default(), &ladder);
    encoder.prepare(&[SIGNAL]).unwrap();
    assert_eq!((encoder.shape(SIGNAL), encoder.shape(IMAGE)), (Some(vec![2, 6]), None));
    let train = [0, 1, 2, 3];
    let inputs = encoder.fit(&[SIGNAL], &train).unwrap();
    let of_train: Vec<f32> = train.iter().flat_map(|&i| inputs[0].encoded.sample(i)[..6].to_vec()).collect();
    let mean = of_train.iter().sum::<f32>() / 24.0;
    let variance = of_train.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / 24.0;
    assert!(mean.abs() <= 1e-5 && (variance - 1.0).abs() <= 1e-4, "{mean} {variance}");
    // Had the test part been seen, these would lie within the training range.
    assert!(inputs[0].encoded.sample(7)[0] > 2.0, "{:?}", inputs[0].encoded.sample(7));
    let Transform::Signal(Scaling::ZScore { mean, .. }) = &inputs[0].transform else { panic!() };
    assert!((mean[0] - 1.75).abs() <= 1e-5 && (mean[1] - 11.75).abs() <= 1e-5, "{mean:?}");
}

#[test]
fn the_quantile_code_knows_the_training_part_only() {
    let ladder = ladder();
    let code = json!({ "signal": { "kind": "quantile-code", "steps": 3 } });
    let train = [0, 1, 2, 3];
    let fitted = inputs(code.clone(), &ladder, &[SIGNAL], &train).unwrap();
    // 16 ramps and half as many again, and a z-score, of four views of two channels.
    assert_eq!(fitted[0].encoded.shape(), [4 * 2 * 25, 3]);
    let mut encoder = Encoder::new(&encoding(code.clone()), &ladder);
    encoder.prepare(&[SIGNAL]).unwrap();
    assert_eq!(encoder.shape(SIGNAL), Some(vec![200, 3]));
    let cut = with_samples(&ladder, &train);
    let of_train = inputs(code.clone(), &cut, &[SIGNAL], &train).unwrap();
    assert_eq!(fitted[0].transform, of_train[0].transform);
    assert_ne!(fitted[0].transform, inputs(code, &ladder, &[SIGNAL], &[4, 5, 6, 7]).unwrap()[0].transform);
    // Whatever is above all training readings looks the same.
    let readings = |i: usize| fitted[0].encoded.sample(i)[..24 * 3].to_vec();
    assert_eq!(readings(6), readings(7));
    assert_ne!(readings(2), readings(3));
}

#[test]
fn the_quantile_code_takes_features_and_what_is_left_of_a_baseline() {
    let code = json!({ "signal": { "kind": "quantile-code" } });
    let features = with(Layout::Features, ArrayD::from_shape_fn(vec![8, 5], |at| (at[0] * at[1]) as f32));
    let shape = inputs(code, &features, &[SIGNAL], &[0, 1, 2, 3]).unwrap()[0].encoded.shape().to_vec();
    assert_eq!(shape, [4 * 25, 5]);
    let ladder = ladder();
    let less = json!({ "baseline": 2, "signal": { "kind": "quantile-code" } });
    let less = &inputs(less, &ladder, &[SIGNAL], &[0, 1, 2, 3]).unwrap()[0];
    let Transform::Baseline { readings: 2, then } = &less.transform else { panic!() };
    assert!(matches!(&**then, Transform::QuantileCode(_)));
    let again = less.transform.apply(&ladder.x, "ladder").unwrap();
    assert_eq!(again.iter().take(100 * 6).copied().collect::<Vec<_>>(), less.encoded.sample(0)[..600]);
}

/// Sixteen samples 2 × 20 in two classes.
fn waves() -> Dataset {
    let x = Array3::from_shape_fn((16, 2, 20), |(i, c, t)| {
        ((1 + i) as f32 * t as f32 * 0.1 + c as f32).sin() * (c + 1) as f32 + 0.2 * i as f32
    });
    Dataset::new("waves", Layout::Series, x.into_dyn(), &["a", "b"].repeat(8)).unwrap()
}

#[test]
fn features_of_mini_rocket_know_the_training_part_only() {
    let (waves, train) = (waves(), [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    let rocket = json!({ "rocket": { "features": 400 } });
    let names = [ROCKET, SERIES];
    let fitted = inputs(rocket.clone(), &waves, &names, &train).unwrap();
    let mut encoder = Encoder::new(&encoding(rocket.clone()), &waves);
    encoder.prepare(&names).unwrap();
    // The multiple of 84 below 400.
    assert_eq!(encoder.shape(ROCKET), Some(vec![336]));
    let cut =
        Dataset::new("waves", Layout::Series, waves.x.select(Axis(0), &train), &["a", "b"].repeat(5)[..9])
            .unwrap();
    let of_train = inputs(rocket.clone(), &cut, &names, &train).unwrap();
    assert_eq!(fitted[0].transform, of_train[0].transform);
    assert_ne!(
        fitted[0].transform,
        inputs(rocket, &waves, &names, &[7, 8, 9, 10, 11, 12]).unwrap()[0].transform
    );

    // Shares of the z-scores that baselines read, less their mean, by their SD + 0.02, as in NumPy.
    let of = |rows: &[usize]| -> Vec<f32> {
        rows.iter().flat_map(|&row| fitted[1].encoded.sample(row).to_vec()).collect()
    };
    let seen = of(&train);
    let plain = MiniRocket::fit(&Series::new(&seen, 2, 20).unwrap(), 400, 0, "encoding").unwrap();
    let shares =
        |rows: &[usize]| plain.transform(&Series::new(&of(rows), 2, 20).unwrap()).unwrap().into_values();
    let (seen, all) = (shares(&train), shares(&(0..16).collect::<Vec<_>>()));
    let mut blown_up = 0.0f32;
    for feature in 0..336 {
        let column: Vec<f64> = seen.iter().skip(feature).step_by(336).map(|&v| f64::from(v)).collect();
        let mean = column.iter().sum::<f64>() / 9.0;
        let sd = (column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 9.0).sqrt();
        let sd = if sd < 1e-7 { 1.0 } else { sd };
        for row in 0..16 {
            let want = (f64::from(all[row * 336 + feature]) - mean) / (sd + 0.02);
            let got = f64::from(fitted[0].encoded.sample(row)[feature]);
            assert!(
                (got - want).abs() <= 1e-4 * (1.0 + want.abs()),
                "{feature} of {row}: {got}, want {want}"
            );
            blown_up = blown_up.max(got.abs() as f32);
        }
    }
    assert!(blown_up > 1.0 && blown_up < 50.0, "{blown_up}");
}

#[test]
fn features_of_mini_rocket_come_back_from_json_or_are_refused() {
    let waves = waves();
    let rocket = json!({ "baseline": 3, "rocket": { "features": 84 } });
    let fitted = &inputs(rocket, &waves, &[ROCKET], &[0, 1, 2, 3]).unwrap()[0];
    let written = serde_json::to_value(&fitted.transform).unwrap();
    let read: Transform = serde_json::from_value(written.clone()).unwrap();
    assert_eq!(read, fitted.transform);
    assert_eq!(read.apply(&waves.x, "waves").unwrap().as_slice().unwrap()[..84], *fitted.encoded.sample(0));
    // What is damaged is refused, not read beyond its end.
    let place = "/baseline/then/rocket/rocket";
    for (key, value) in [
        ("shape", json!([1, 20])),
        ("shape", json!([2, 4_000_000_000_u64])),
        ("dilations", json!([])),
        ("dilations", json!([[9, 1]])),
        ("dilations", json!([[0, 1]])),
        ("dilations", json!([[1, 18_446_744_073_709_551_615_u64]])),
        ("channels", json!([])),
        ("channels", json!(vec![vec![2]; 84])),
        ("biases", json!([0.5])),
    ] {
        let mut damaged = written.clone();
        damaged.pointer_mut(place).unwrap()[key] = value.clone();
        let read = serde_json::from_value::<Transform>(damaged);
        // Another length fits by itself, but not these samples.
        let said = match read {
            Ok(read) => read.apply(&waves.x, "waves").unwrap_err().to_string(),
            Err(error) => error.to_string(),
        };
        assert!(said.contains("does not fit the series"), "{key} = {value}: {said}");
    }
    // Numbers of features that no config could ask for are refused before they are counted with.
    for features in [0, 83, u64::MAX] {
        let mut damaged = written.clone();
        damaged.pointer_mut("/baseline/then/rocket").unwrap()["features"] = json!(features);
        let read: Transform = serde_json::from_value(damaged).unwrap();
        let said = read.apply(&waves.x, "waves").unwrap_err().to_string();
        assert!(said.contains("encoding.rocket.features"), "{features}: {said}");
    }
    // A scale that takes readings beyond the largest float is refused by both ways.
    let mut damaged = written;
    damaged.pointer_mut("/baseline/then/rocket/readings/z-score").unwrap()["sd"] = json!([1e-38, 1.0]);
    let read: Transform = serde_json::from_value(damaged).unwrap();
    let said = read.apply(&(&waves.x * 1e3), "waves").unwrap_err().to_string();
    assert!(said.contains("inf"), "{said}");
    let reading: Vec<f32> = waves.x.iter().take(40).map(|v| v * 1e3).collect();
    let said =
        read.compile(&[2, 20], "one").unwrap().encode(&reading, &mut [0.0; 84]).unwrap_err().to_string();
    assert!(said.contains("inf"), "{said}");
    let other = with(Layout::Series, ArrayD::zeros(vec![8, 2, 21]));
    let said = fitted.transform.apply(&other.x, "other").unwrap_err().to_string();
    assert!(said.starts_with("other: rocket: ") && said.contains("[2, 20]"), "{said}");
}

#[test]
fn features_of_mini_rocket_need_nine_readings() {
    let said = refusal(json!({ "rocket": {} }), &ladder(), &[ROCKET], &[0, 1, 2, 3]);
    assert_eq!(said, "encoding.rocket: MiniRocket needs at least 9 readings in time, the recordings have 6");
    let few: Encoding = serde_json::from_value(json!({ "rocket": { "features": 83 } })).unwrap();
    assert_eq!(few.check().unwrap_err().key, "rocket.features");
}

#[test]
fn keys_of_a_signal_belong_to_its_kind() {
    let refused = |value: Value| serde_json::from_value::<Encoding>(json!({ "signal": value })).unwrap_err();
    let message = refused(json!({ "steps": 9 })).to_string();
    assert!(
        message.starts_with("`steps` is no key of a signal of kind \"scaled\", which has scale"),
        "{message}"
    );
    let message = refused(json!({ "kind": "quantile-code", "scale": "raw" })).to_string();
    assert!(message.contains("`scale` is no key of a signal of kind \"quantile-code\""), "{message}");
    assert!(refused(json!({ "kind": "ramps" })).to_string().contains("unknown variant `ramps`"));
    assert!(refused(json!({ "scales": "raw" })).to_string().contains("unknown field `scales`"));
    // What is written is what was always written, where no code is asked for.
    let plain = serde_json::to_value(encoding(json!({}))).unwrap();
    assert_eq!(plain, json!({ "signal": { "scale": "z-score" } }));
    let code = encoding(json!({ "signal": { "kind": "quantile-code" } }));
    let written = serde_json::to_value(&code).unwrap();
    assert_eq!(written, json!({ "signal": { "kind": "quantile-code", "ramps": 768, "steps": 40 } }));
    assert_eq!(encoding(written), code);
    let history = encoding(json!({ "signal": { "kind": "history", "lags": [1, 3] } }));
    let written = serde_json::to_value(&history).unwrap();
    assert_eq!(written, json!({ "signal": { "kind": "history", "lags": [1, 3] } }));
    assert_eq!(encoding(written), history);
    let message = refused(json!({ "kind": "quantile-code", "lags": [1] })).to_string();
    assert!(message.contains("`lags` is no key of a signal of kind \"quantile-code\""), "{message}");
    let message = refused(json!({ "kind": "history", "ramps": 9 })).to_string();
    assert!(
        message.contains("`ramps` is no key of a signal of kind \"history\", which has lags"),
        "{message}"
    );
    let none: Encoding =
        serde_json::from_value(json!({ "signal": { "kind": "history", "lags": [0] } })).unwrap();
    assert_eq!(none.check().unwrap_err().key, "signal.lags");
    let none: Encoding =
        serde_json::from_value(json!({ "signal": { "kind": "quantile-code", "steps": 0 } })).unwrap();
    assert_eq!(none.check().unwrap_err().key, "signal.steps");
}

#[test]
fn a_field_is_made_from_raw_readings() {
    let ladder = ladder();
    let image = json!({ "kind": "gadf", "size": 4, "colormap": "grey" });
    let with = |signal: Value| {
        inputs(json!({ "image": image, "signal": signal }), &ladder, &[SIGNAL, IMAGE], &[0, 1]).unwrap()
    };
    let (z, raw) = (with(json!({})), with(json!({ "scale": "raw" })));
    assert_eq!(z[1].encoded.shape(), [1, 4, 4]);
    assert_eq!(z[1].encoded, raw[1].encoded);
    assert_ne!(z[0].encoded, raw[0].encoded);
    let Transform::Field(field) = &z[1].transform else { panic!() };
    let sample = ladder.x.index_axis(Axis(0), 3).into_dimensionality().unwrap();
    let want: Vec<f32> = field.encode(sample).unwrap().iter().copied().collect();
    assert_eq!(z[1].encoded.sample(3), want);
    assert_eq!(raw[0].encoded.sample(1)[..2], [1.0, 1.1]);
    let gasf = json!({ "image": { "kind": "gasf", "size": 4, "colormap": "grey" } });
    let gasf = inputs(gasf, &ladder, &[IMAGE], &[0]).unwrap();
    assert_ne!(gasf[0].encoded, z[1].encoded);
}

#[test]
fn images_get_a_channel_axis_and_a_full_scale() {
    let ladder = ladder();
    let raw = || json!({ "image": { "kind": "raw" } });
    let error = refusal(raw(), &ladder, &[IMAGE], &[0]);
    assert_eq!(
        error,
        "data.full_scale = not set: the scale needs the largest possible reading of real: ladder, such as 1023 \
         for 10-bit counts or 255 for 8-bit images"
    );
    let scaled = ladder.with_full_scale(20.0).unwrap();
    let images = inputs(raw(), &scaled, &[IMAGE], &[0]).unwrap();
    assert_eq!(images[0].encoded.shape(), [1, 2, 6]);
    assert_eq!(images[0].encoded.sample(3)[6], 0.65);
    let squeezes = with(Layout::Sequence, ArrayD::zeros(vec![8, 1, 2, 3]));
    assert_eq!(
        refusal(raw(), &squeezes, &[SIGNAL], &[0]),
        "real: ladder: samples of shape [1, 2, 3] cannot become `signal`: a signal is [N, C, T], [N, F] or [N, fingers, C, T]"
    );
}

#[test]
fn channels_of_all_fingers_are_one_signal() {
    let x = ArrayD::from_shape_fn(vec![8, 2, 3, 4], |at| {
        (at[0] + 10 * at[1] + 100 * at[2] + 1000 * at[3]) as f32
    });
    let fingers = with(Layout::Fingers, x);
    let raw = json!({ "signal": { "scale": "raw" } });
    let signal = inputs(raw, &fingers, &[SIGNAL], &[0]).unwrap();
    assert_eq!(signal[0].encoded.shape(), [6, 4]);
    // Finger 1, channel 0 of sample 5.
    assert_eq!(signal[0].encoded.sample(5)[12..16], [15.0, 1015.0, 2015.0, 3015.0]);
    let code = json!({ "signal": { "kind": "quantile-code" } });
    assert_eq!(inputs(code, &fingers, &[SIGNAL], &[0, 1, 2]).unwrap()[0].encoded.shape()[1], 4);
}

#[test]
fn a_bad_reading_is_named_by_sample() {
    let mut bad = ladder();
    bad.x.index_axis_mut(Axis(0), 5)[[1, 2]] = f32::NAN;
    let raw = json!({ "signal": { "scale": "raw" } });
    let error = refusal(raw, &bad, &[SIGNAL], &[0]);
    assert!(error.starts_with("real: ladder: signal: ") && error.contains("sample 5"), "{error}");
    let field = json!({ "image": { "kind": "gadf", "size": 4 } });
    let error = refusal(field, &bad, &[IMAGE], &[0]);
    assert!(error.starts_with("real: ladder: image: ") && error.contains("sample 5"), "{error}");
    // A scale is fitted to training samples: the first of them that is bad is named.
    let error = refusal(json!({}), &bad, &[SIGNAL], &[4, 5]);
    assert!(error.starts_with("real: ladder: signal: ") && error.contains("sample"), "{error}");
}

#[test]
fn a_baseline_is_taken_off_before_anything_else() {
    let ladder = ladder();
    let raw = json!({ "baseline": 2, "signal": { "scale": "raw" } });
    let signals = inputs(raw.clone(), &ladder, &[SIGNAL], &[0]).unwrap();
    // 0.1 a tick from the mean of the first two on, whatever sample and channel.
    for sample in 0..8 {
        let want = [-0.05, 0.05, 0.15, 0.25, 0.35, 0.45].repeat(2);
        let pairs = signals[0].encoded.sample(sample).iter().zip(&want);
        assert!(pairs.into_iter().all(|(got, want)| (got - want).abs() < 1e-5), "{sample}");
    }
    // What baselines read is less the same mean.
    let series = inputs(raw, &ladder, &[SERIES], &[0, 1]).unwrap();
    let Transform::Baseline { readings: 2, then } = &series[0].transform else { panic!() };
    assert!(matches!(&**then, Transform::Signal(Scaling::ZScore { .. })), "{then:?}");
    // Scales are fitted to what is left, and the saved transform does the same to new recordings.
    let scaled = inputs(json!({ "baseline": 2 }), &ladder, &[SIGNAL], &[0, 1]).unwrap();
    let again = scaled[0].transform.apply(&ladder.x, "again").unwrap();
    assert_eq!(again.iter().take(12).copied().collect::<Vec<f32>>(), scaled[0].encoded.sample(0));
    let Transform::Baseline { readings: 2, then } = &scaled[0].transform else { panic!() };
    let Transform::Signal(Scaling::ZScore { mean, .. }) = &**then else { panic!() };
    assert!(mean.iter().all(|mean| (mean - 0.2).abs() < 1e-5), "{mean:?}");
    let error = refusal(json!({ "baseline": 7 }), &ladder, &[SIGNAL], &[0]);
    assert!(error.contains("encoding.baseline needs [N, C, T] with at least as many readings"), "{error}");
}

#[test]
fn rows_are_an_image_and_each_is_scaled_by_itself() {
    let ladder = ladder();
    let mut encoder = Encoder::new(&encoding(json!({ "image": { "kind": "rows" } })), &ladder);
    encoder.prepare(&[IMAGE]).unwrap();
    assert_eq!(encoder.shape(IMAGE), Some(vec![1, 2, 6]));
    let inputs = encoder.fit(&[IMAGE], &[0, 1]).unwrap();
    let Transform::Rows(Scaling::ZScore { mean, sd }) = &inputs[0].transform else { panic!() };
    assert!((mean[0] - 0.75).abs() < 1e-5 && (mean[1] - 10.75).abs() < 1e-5, "{mean:?}");
    assert!((inputs[0].encoded.sample(3)[6] - (13.0 - mean[1]) / sd[1]).abs() < 1e-5);
}

#[test]
fn colours_are_scaled_as_imagenet_was() {
    let x = ArrayD::from_shape_fn(vec![8, 3, 1, 2], |at| (51 * at[1] + 102 * at[3]) as f32);
    let colours = with(Layout::Colour, x).with_full_scale(255.0).unwrap();
    let imagenet = || json!({ "image": { "kind": "raw", "scale": "imagenet" } });
    let images = inputs(imagenet(), &colours, &[IMAGE], &[0]).unwrap();
    // (v / 255 - mean) / sd by hand.
    let want = [-2.117_904, -0.371_179, -1.142_857, 0.642_857, -0.026_667, 1.751_111];
    for (got, want) in images[0].encoded.sample(5).iter().zip(want) {
        assert!((got - want).abs() < 1e-5, "{got} {want}");
    }
    // Beyond the edges lies the sensor at rest: what a sample of such readings becomes.
    let edges = images[0].outside.as_deref().unwrap();
    assert!((edges[1] + 0.456 / 0.224).abs() < 1e-5);
    let resting = inputs(imagenet(), &colours.with_rest(vec![51.0]), &[IMAGE], &[0]).unwrap();
    assert_eq!(resting[0].outside.as_deref().unwrap()[1], resting[0].encoded.sample(0)[2]);
    let grey = with(Layout::Image, ArrayD::zeros(vec![8, 2, 6])).with_full_scale(255.0).unwrap();
    assert!(inputs(imagenet(), &grey, &[IMAGE], &[0]).is_err());
    let red = json!({ "image": { "kind": "raw", "scale": "imagenet", "red": true } });
    let images = inputs(red, &grey, &[IMAGE], &[0]).unwrap();
    assert!((images[0].encoded.sample(0)[12] + 0.456 / 0.224).abs() < 1e-5);
}

/// Rows of an image and taxels of a frame become channels.
#[test]
fn baselines_read_channels_and_time_of_every_layout() {
    let shape = |layout, axes: &[usize]| {
        let x = ArrayD::from_shape_fn(axes.to_vec(), |at| at[0] as f32 + 0.5 * at[1] as f32);
        let samples = with(layout, x);
        let series = inputs(json!({}), &samples, &[SERIES], &[0, 1]).unwrap();
        series[0].encoded.shape().to_vec()
    };
    assert_eq!(shape(Layout::Features, &[8, 7]), [1, 7]);
    assert_eq!(shape(Layout::Series, &[8, 2, 7]), [2, 7]);
    assert_eq!(shape(Layout::Image, &[8, 5, 7]), [5, 7]);
    assert_eq!(shape(Layout::Colour, &[8, 3, 5, 7]), [15, 7]);
    assert_eq!(shape(Layout::Sequence, &[8, 4, 5, 7]), [35, 4]);
    assert_eq!(shape(Layout::Fingers, &[8, 2, 23, 9]), [46, 9]);
}

#[test]
fn less_of_a_sample_is_the_first_thing_that_an_encoding_does() {
    let ladder = ladder();
    let train = [0, 1, 2, 3];
    let reduce = json!({ "channels": [1], "window": 2 });
    let encoding = json!({ "reduce": reduce, "signal": { "scale": "z-score" } });
    let less = &inputs(encoding, &ladder, &[SIGNAL], &train).unwrap()[0];
    assert_eq!(less.encoded.shape(), [1, 2]);
    let Transform::Reduced { reduction, then, .. } = &less.transform else { panic!() };
    assert_eq!((reduction.channels.as_deref(), reduction.window), (Some(&[1][..]), Some(2)));
    let Transform::Signal(Scaling::ZScore { mean, .. }) = &**then else { panic!() };
    assert_eq!(mean.len(), 1, "fitted on what is left");
    // Baselines read no more.
    let series = &inputs(json!({ "reduce": reduce }), &ladder, &[SERIES], &train).unwrap()[0];
    assert_eq!(series.encoded.shape(), [1, 2]);
    let again = less.transform.apply(&ladder.x, "ladder").unwrap();
    assert_eq!(again.iter().take(2).copied().collect::<Vec<_>>(), less.encoded.sample(0));
}

#[test]
fn a_reduction_that_does_not_fit_is_refused_by_its_key() {
    let ladder = ladder();
    let refused = |reduce: Value| {
        let error = inputs(json!({ "reduce": reduce }), &ladder, &[SIGNAL], &[0, 1]).unwrap_err();
        error.to_string()
    };
    assert!(
        refused(json!({ "channels": [9] })).starts_with("encoding.reduce.channels = [9]: must be below 2")
    );
    assert!(
        refused(json!({ "pool": 2 })).starts_with("encoding.reduce.pool = ..: has no meaning for a series")
    );
    let of = |value: Value| {
        let encoding: Encoding = serde_json::from_value(value).unwrap();
        encoding.check().unwrap_err().to_string()
    };
    assert!(of(json!({ "reduce": { "every": 0 } })).starts_with("reduce.every = 0: must be 1 or more"));
    let guarded = of(json!({ "guard": true, "reduce": { "every": 2 } }));
    assert!(guarded.starts_with("guard = true: looks at channels"), "{guarded}");
    // What reads everything is written as before.
    assert!(serde_json::to_value(encoding(json!({}))).unwrap().get("reduce").is_none());
}
