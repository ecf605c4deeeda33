//! Inputs, folds and the order of training.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use ndarray::{Array3, ArrayD, Axis};
use proptest::prelude::*;
use taxel_encodings::Scaling;
use taxel_trainer::{Encoder, Experiment, IMAGE, Labels, Overrides, SIGNAL, Samples, Transform, shuffled};

fn experiment(encoding: &str, protocol: &str) -> Experiment {
    let text = format!(
        "name = \"t\"\n[data]\npath = \"-\"\n[encoding]\n{encoding}\n[protocol]\nfolds = 2\n{protocol}\n\
         [[networks]]\nname = \"mlp\"\n"
    );
    Experiment::parse(&text, "t.toml", &Overrides::default()).unwrap()
}

/// Eight samples 2 × 6 in two classes and two groups; sample i lies around i in channel 0.
fn samples() -> Samples {
    let x = Array3::from_shape_fn((8, 2, 6), |(i, c, t)| (i + 10 * c) as f32 + 0.1 * t as f32);
    Samples {
        labels: Labels::new(vec![], vec![]),
        official: None,
        source: "real: ladder".into(),
        x: x.into_dyn(),
        y: vec![0, 1, 0, 1, 0, 1, 0, 1],
        classes: vec!["a".into(), "b".into()],
        groups: Some(vec![0, 0, 0, 0, 1, 1, 1, 1]),
        units: None,
        full_scale: None,
        rest: None,
        origins: vec![String::new(); 8],
        digest: String::new(),
    }
}

#[test]
fn z_scores_know_the_training_part_only() {
    let samples = samples();
    let experiment = experiment("", "");
    let encoder = Encoder::new(&experiment, &samples, &[SIGNAL]).unwrap();
    assert_eq!((encoder.shape(SIGNAL), encoder.shape(IMAGE)), (Some(vec![2, 6]), None));
    let train = [0, 1, 2, 3];
    let inputs = encoder.fit(&train).unwrap();
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
fn a_field_is_made_from_raw_readings() {
    let samples = samples();
    let image = "image = { kind = \"gadf\", size = 4, colormap = \"grey\" }";
    let inputs = |signal: &str| {
        let experiment = experiment(&format!("{image}\n{signal}"), "");
        Encoder::new(&experiment, &samples, &[SIGNAL, IMAGE]).unwrap().fit(&[0, 1]).unwrap()
    };
    let (z, raw) = (inputs(""), inputs("signal = { scale = \"raw\" }"));
    assert_eq!(z[1].encoded.shape(), [1, 4, 4]);
    assert_eq!(z[1].encoded, raw[1].encoded);
    assert_ne!(z[0].encoded, raw[0].encoded);
    let Transform::Field(field) = &z[1].transform else { panic!() };
    let sample = samples.x.index_axis(Axis(0), 3).into_dimensionality().unwrap();
    let want: Vec<f32> = field.encode(sample).unwrap().iter().copied().collect();
    assert_eq!(z[1].encoded.sample(3), want);
    assert_eq!(raw[0].encoded.sample(1)[..2], [1.0, 1.1]);
    let gasf = experiment(&image.replace("gadf", "gasf"), "");
    let gasf = Encoder::new(&gasf, &samples, &[IMAGE]).unwrap().fit(&[0]).unwrap();
    assert_ne!(gasf[0].encoded, z[1].encoded);
}

#[test]
fn images_get_a_channel_axis_and_a_full_scale() {
    let samples = samples();
    let raw = experiment("image = { kind = \"raw\" }", "");
    let error = Encoder::new(&raw, &samples, &[IMAGE]).err().unwrap().to_string();
    assert!(error.starts_with("t.toml:2: data.full_scale = not set: "), "{error}");
    let scaled = Samples { full_scale: Some(2.0), ..samples.clone() };
    let inputs = Encoder::new(&raw, &scaled, &[IMAGE]).unwrap().fit(&[0]).unwrap();
    assert_eq!(inputs[0].encoded.shape(), [1, 2, 6]);
    assert_eq!(inputs[0].encoded.sample(3)[6], 6.5);
    let signal = Samples { x: ArrayD::zeros(vec![8, 1, 2, 3]), ..samples };
    let error = Encoder::new(&raw, &signal, &[SIGNAL]).err().unwrap().to_string();
    assert_eq!(
        error,
        "real: ladder: samples of shape [1, 2, 3] cannot become `signal`: a signal is [N, C, T] or [N, F]"
    );
}

#[test]
fn a_bad_reading_is_named_by_sample() {
    let mut bad = samples();
    bad.x.index_axis_mut(Axis(0), 5)[[1, 2]] = f32::NAN;
    for encoding in ["signal = { scale = \"raw\" }", "image = { kind = \"gadf\", size = 4 }"] {
        let error = Encoder::new(&experiment(encoding, ""), &bad, &[SIGNAL, IMAGE]).err();
        let error = error.map(|e| e.to_string()).unwrap_or_else(|| {
            let experiment = experiment(encoding, "");
            Encoder::new(&experiment, &bad, &[SIGNAL]).unwrap().fit(&[4, 5]).err().unwrap().to_string()
        });
        assert!(error.starts_with("real: ladder: ") && error.contains("sample"), "{error}");
    }
}

#[test]
fn grouped_folds_cut_no_group_and_need_groups() {
    let grouped = experiment("", "split = \"group\"");
    let samples = samples();
    for fold in samples.folds(&grouped, 0).unwrap() {
        let groups = samples.groups.as_ref().unwrap();
        let inside =
            |rows: &[usize]| rows.iter().map(|&i| groups[i]).collect::<std::collections::BTreeSet<_>>();
        assert!(inside(&fold.train).is_disjoint(&inside(&fold.test)));
    }
    let error = Samples { groups: None, ..samples }.folds(&grouped, 0).unwrap_err().to_string();
    assert!(error.starts_with("t.toml:8: protocol.split = \"group\": real: ladder has no groups"), "{error}");
}

#[test]
fn every_epoch_has_its_own_order_and_its_own_only() {
    let train: Vec<usize> = (0..50).map(|i| 2 * i).collect();
    let order = shuffled(&train, 1, 0, 0, 0);
    assert_eq!(order, shuffled(&train, 1, 0, 0, 0));
    for other in [(2, 0, 0, 0), (1, 1, 0, 0), (1, 0, 1, 0), (1, 0, 0, 1)] {
        assert_ne!(order, shuffled(&train, other.0, other.1, other.2, other.3), "{other:?}");
    }
}

proptest! {
    #[test]
    fn batches_partition_the_training_set(
        count in 1usize..200, batch in 1usize..70, seed: u64, epoch in 0usize..1000,
    ) {
        let train: Vec<usize> = (0..count).map(|i| 3 * i + 1).collect();
        let order = shuffled(&train, seed, 0, 0, epoch);
        let batches: Vec<&[usize]> = order.chunks(batch).collect();
        prop_assert_eq!(batches.len(), count.div_ceil(batch));
        let mut seen = batches.concat();
        seen.sort_unstable();
        prop_assert_eq!(seen, train);
    }
}

#[test]
fn a_baseline_is_taken_off_before_anything_else() {
    let samples = samples();
    let raw = experiment("baseline = 2\nsignal = { scale = \"raw\" }", "");
    let inputs = Encoder::new(&raw, &samples, &[SIGNAL]).unwrap().fit(&[0]).unwrap();
    // 0.1 a tick from the mean of the first two on, whatever sample and channel.
    for sample in 0..8 {
        let want = [-0.05, 0.05, 0.15, 0.25, 0.35, 0.45].repeat(2);
        let pairs = inputs[0].encoded.sample(sample).iter().zip(&want);
        assert!(pairs.into_iter().all(|(got, want)| (got - want).abs() < 1e-5), "{sample}");
    }
    // Scales are fitted to what is left, and the saved transform does the same to new recordings.
    let scaled = experiment("baseline = 2", "");
    let inputs = Encoder::new(&scaled, &samples, &[SIGNAL]).unwrap().fit(&[0, 1]).unwrap();
    let again = inputs[0].transform.apply(&samples.x, "again").unwrap();
    assert_eq!(again.iter().take(12).copied().collect::<Vec<f32>>(), inputs[0].encoded.sample(0));
    let Transform::Baseline { readings: 2, then } = &inputs[0].transform else { panic!() };
    let Transform::Signal(Scaling::ZScore { mean, .. }) = &**then else { panic!() };
    assert!(mean.iter().all(|mean| (mean - 0.2).abs() < 1e-5), "{mean:?}");
    let long = experiment("baseline = 7", "");
    let error = Encoder::new(&long, &samples, &[SIGNAL]).err().unwrap().to_string();
    assert!(error.contains("encoding.baseline needs [N, C, T] with at least as many readings"), "{error}");
}

#[test]
fn rows_are_an_image_and_each_is_scaled_by_itself() {
    let samples = samples();
    let rows = experiment("image = { kind = \"rows\" }", "");
    let encoder = Encoder::new(&rows, &samples, &[IMAGE]).unwrap();
    assert_eq!(encoder.shape(IMAGE), Some(vec![1, 2, 6]));
    let inputs = encoder.fit(&[0, 1]).unwrap();
    let Transform::Rows(Scaling::ZScore { mean, sd }) = &inputs[0].transform else { panic!() };
    assert!((mean[0] - 0.75).abs() < 1e-5 && (mean[1] - 10.75).abs() < 1e-5, "{mean:?}");
    assert!((inputs[0].encoded.sample(3)[6] - (13.0 - mean[1]) / sd[1]).abs() < 1e-5);
}

#[test]
fn colours_are_scaled_as_imagenet_was() {
    let x = ArrayD::from_shape_fn(vec![8, 3, 1, 2], |at| (51 * at[1] + 102 * at[3]) as f32);
    let samples = Samples { x, full_scale: Some(255.0), ..samples() };
    let colours = experiment("image = { kind = \"raw\", scale = \"imagenet\" }", "");
    let inputs = Encoder::new(&colours, &samples, &[IMAGE]).unwrap().fit(&[0]).unwrap();
    // (v / 255 - mean) / sd by hand.
    let want = [-2.117_904, -0.371_179, -1.142_857, 0.642_857, -0.026_667, 1.751_111];
    for (got, want) in inputs[0].encoded.sample(5).iter().zip(want) {
        assert!((got - want).abs() < 1e-5, "{got} {want}");
    }
    let grey = Samples { x: ArrayD::zeros(vec![8, 2, 6]), ..samples };
    assert!(Encoder::new(&colours, &grey, &[IMAGE]).is_err());
    let red = experiment("image = { kind = \"raw\", scale = \"imagenet\", red = true }", "");
    let inputs = Encoder::new(&red, &grey, &[IMAGE]).unwrap().fit(&[0]).unwrap();
    assert!((inputs[0].encoded.sample(0)[12] + 0.456 / 0.224).abs() < 1e-5);
}
