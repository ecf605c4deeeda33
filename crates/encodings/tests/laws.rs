//! Laws that hold for any series, and the bad inputs that must be named.

use ndarray::{Array1, Array2, Array3, Axis, arr1};
use proptest::prelude::*;
use taxel_encodings::{Colormap, Constant, Error, Gaf, HardnessImage, Method, Range};

const COLORMAPS: [Colormap; 3] = [Colormap::Grey, Colormap::Jet, Colormap::Viridis];

/// A series, an image size that it can fill, and a method.
fn any_case() -> impl Strategy<Value = (Array1<f32>, Gaf)> {
    let series = prop::collection::vec(-1000f32..1000.0, 2..120);
    (series, 2..120usize, any::<bool>(), any::<bool>()).prop_map(|(series, size, sum, fixed)| {
        let range = if fixed { Range::Fixed { low: -400.0, high: 600.0 } } else { Range::PerSample };
        let method = if sum { Method::Summation } else { Method::Difference };
        let size = size.min(series.len());
        (Array1::from_vec(series), Gaf { size, method, range, constant: Constant::Zero })
    })
}

proptest! {
    #[test]
    fn fields_are_bounded_and_have_their_symmetry((series, gaf) in any_case()) {
        let field = gaf.encode(series.view()).unwrap();
        prop_assert!(field.iter().all(|v| (-1.0..=1.0).contains(v)));
        let sign = if gaf.method == Method::Difference { -1.0 } else { 1.0 };
        prop_assert_eq!(field.t().to_owned(), field.mapv(|v| sign * v));
        if gaf.method == Method::Difference {
            prop_assert!(field.diag().iter().all(|&v| v == 0.0));
        }
    }

    #[test]
    fn per_sample_range_ignores_gain_and_offset(
        (series, gaf) in any_case(), gain in 0.1f32..10.0, offset in -100f32..100.0,
    ) {
        // A wide range, so that the rounding of `moved` stays small beside it.
        let series = Array1::from_iter(series.iter().copied().chain([-1000.0, 1000.0]));
        let gaf = Gaf { range: Range::PerSample, size: series.len(), ..gaf };
        let moved = series.mapv(|v| gain * v + offset);
        let (a, b) = (gaf.encode(series.view()).unwrap(), gaf.encode(moved.view()).unwrap());
        for (a, b) in a.iter().zip(&b) {
            // 1e-7 of rounding at the ends of the range, under the root of 1 - x^2.
            prop_assert!((a - b).abs() <= 2e-3, "{a} became {b}");
        }
    }

    #[test]
    fn colours_are_in_the_unit_interval(values in prop::collection::vec(-2f32..2.0, 1..50)) {
        let field = Array2::from_shape_vec((1, values.len()), values).unwrap();
        for colormap in COLORMAPS {
            let image = colormap.apply(&field).unwrap();
            prop_assert_eq!(image.shape(), [colormap.channels(), 1, field.len()]);
            prop_assert!(image.iter().all(|v| (0.0..=1.0).contains(v)));
        }
    }
}

#[test]
fn a_fixed_range_keeps_the_amplitude_that_a_per_sample_range_loses() {
    let firm = Array1::from_shape_fn(250, |t| 800.0 * (t as f32 / 40.0).sin().abs());
    let light = firm.mapv(|v| v / 2.0);
    let gap = |gaf: Gaf| {
        let (a, b) = (gaf.encode(firm.view()).unwrap(), gaf.encode(light.view()).unwrap());
        (a - b).iter().fold(0f32, |a, b| a.max(b.abs()))
    };
    assert!(gap(Gaf::default()) < 1e-6);
    assert!(gap(Gaf { range: Range::Fixed { low: 0.0, high: 1023.0 }, ..Gaf::default() }) > 0.1);
}

#[test]
fn a_fixed_range_that_is_that_of_the_series_gives_the_same() {
    let series = Array1::from_shape_fn(60, |t| 100.0 - 500.0 * (t as f32 / 7.0).sin());
    let (low, high) = (-380.0, 590.0);
    let series = Array1::from_iter(series.iter().map(|v| v.clamp(low, high)).chain([low, high]));
    for method in [Method::Summation, Method::Difference] {
        let per_sample = Gaf { size: series.len(), method, ..Gaf::default() };
        let fixed = Gaf { range: Range::Fixed { low, high }, ..per_sample.clone() };
        let (per_sample, fixed) =
            (per_sample.encode(series.view()).unwrap(), fixed.encode(series.view()).unwrap());
        assert!(per_sample.iter().zip(&fixed).all(|(a, b)| (a - b).abs() < 1e-6));
    }
}

#[test]
fn segments_that_differ_by_rounding_are_constant() {
    let (large, small) = (1e6f32, 1e-4f32);
    let segments = [[large, small, small, small], [small, small, small, large]];
    let sums = segments.map(|segment| segment.map(f64::from).iter().sum::<f64>());
    assert_ne!(sums[0], sums[1], "the same readings in another order");
    let method = Method::Summation;
    let zero = Gaf { size: 2, method, constant: Constant::Zero, ..Gaf::default() };
    let series = arr1(segments.as_flattened());
    assert_eq!(zero.encode(series.view()).unwrap(), Array2::<f32>::zeros((2, 2)));
}

#[test]
fn a_constant_series_is_an_error_or_a_field_of_zeros() {
    let dead = Array1::from_elem(250, 0.1f32);
    let error = Gaf::default().encode(dead.view()).unwrap_err();
    assert!(error.to_string().starts_with("the series is constant (value 0.1"), "{error}");
    let zero = Gaf { constant: Constant::Zero, ..Gaf::default() };
    assert_eq!(zero.encode(dead.view()).unwrap(), Array2::<f32>::zeros((50, 50)));
    // Not constant, but its segments are.
    let buzz = Array1::from_shape_fn(250, |t| [1.0, 2.0, 3.0, 4.0, 5.0][t % 5]);
    assert_eq!(Gaf::default().encode(buzz.view()), Err(Error::Constant { value: 3.0 }));
    let fixed = Gaf { range: Range::Fixed { low: 0.0, high: 1.0 }, ..Gaf::default() };
    assert!(fixed.encode(dead.view()).unwrap().iter().all(|&v| v == 0.0));
}

#[test]
fn bad_series_and_settings_are_named() {
    let message = |gaf: &Gaf, series: &[f32]| gaf.encode(arr1(series).view()).unwrap_err().to_string();
    let small = Gaf { size: 3, ..Gaf::default() };
    assert_eq!(
        message(&small, &[1.0, f32::NAN, 2.0]),
        "reading 1 is NaN; drop or interpolate bad taxels before encoding"
    );
    assert!(message(&small, &[1.0, 2.0, f32::NEG_INFINITY]).starts_with("reading 2 is -inf;"));
    assert!(message(&small, &[1.0, 2.0]).contains("2 readings for an image of size 3"));
    assert!(message(&small, &[]).contains("0 readings"));
    for size in [0, 1] {
        let gaf = Gaf { size, ..Gaf::default() };
        assert!(message(&gaf, &[1.0, 2.0]).starts_with(&format!("size = {size}: must be at least 2")));
    }
    for (low, high) in [(1.0, 0.0), (1.0, 1.0), (f32::NAN, 1.0), (0.0, f32::INFINITY)] {
        let gaf = Gaf { range: Range::Fixed { low, high }, ..small.clone() };
        assert!(message(&gaf, &[1.0, 2.0, 3.0]).starts_with(&format!("range {low}..{high} is")));
    }
    let one = Gaf { size: 1, range: Range::Fixed { low: 0.0, high: 1.0 }, ..Gaf::default() };
    assert_eq!(one.encode(arr1(&[0.5]).view()).unwrap(), Array2::<f32>::zeros((1, 1)));
    for colormap in COLORMAPS {
        let error = colormap.apply(&Array2::from_elem((2, 2), f32::NAN)).unwrap_err();
        assert!(error.to_string().starts_with("pixel [0, 0] is NaN;"), "{error}");
    }
}

#[test]
fn a_batch_is_its_samples_and_names_the_bad_one() {
    let image = HardnessImage::default();
    let mut x = Array3::from_shape_fn((4, 5, 50), |(i, c, t)| ((i + 1) * (c + 2) * t % 97) as f32);
    let batch = image.encode_batch(x.view()).unwrap();
    for (one, x) in batch.outer_iter().zip(x.outer_iter()) {
        assert_eq!(one, image.encode(x).unwrap());
    }
    let none = x.slice_axis(Axis(0), (0..0).into());
    assert_eq!(image.encode_batch(none).unwrap().shape(), [0, 3, 50, 50]);

    x[[3, 2, 17]] = f32::NAN;
    assert_eq!(
        image.encode_batch(x.view()).unwrap_err().to_string(),
        "reading 17 of channel 2 of sample 3 is NaN; drop or interpolate bad taxels before encoding"
    );
    x.index_axis_mut(Axis(0), 1).fill(7.0);
    let error = image.encode_batch(x.view()).unwrap_err().to_string();
    assert!(error.starts_with("sample 1: the series is constant (value 7)"), "{error}");
}

#[test]
fn settings_read_as_they_are_written_in_a_config() {
    let text = r#"{"gaf": {"size": 64, "method": "summation", "constant": "zero",
        "range": {"fixed": {"low": 0, "high": 1023}}}, "colormap": "viridis"}"#;
    let image: HardnessImage = serde_json::from_str(text).unwrap();
    let range = Range::Fixed { low: 0.0, high: 1023.0 };
    let gaf = Gaf { size: 64, method: Method::Summation, range, constant: Constant::Zero };
    assert_eq!(image, HardnessImage { gaf, colormap: Colormap::Viridis });
    assert_eq!(serde_json::from_str::<HardnessImage>("{}").unwrap(), HardnessImage::default());
    for misspelt in [
        r#"{"colourmap": "jet"}"#,
        r#"{"gaf": {"size": 5, "metod": "summation"}}"#,
        r#"{"gaf": {"size": 5, "range": {"fixed": {"low": 0, "high": 1, "mid": 0}}}}"#,
    ] {
        let error = serde_json::from_str::<HardnessImage>(misspelt).unwrap_err();
        assert!(error.to_string().contains("unknown field"), "{error}");
    }
}
