//! OneFrame sequences, sizes, electrode images and NumaTac samples against NumPy, PyTorch and
//! scikit-learn (`scripts/fixtures/encodings.py`), and the bad inputs that must be named.

#![allow(clippy::unwrap_used)]

use ndarray::{Array, Array3, Array4, ArrayD, Axis, Dimension};
use npyz::npz::NpzArchive;
use taxel_encodings::numatac::{self, Offset};
use taxel_encodings::{
    ElectrodeImage, Error, Filter, NumaTac, OneFrame, Order, Resize, TactileTensor, all_frames, red_channel,
};

fn array<D: Dimension>(name: &str) -> Array<f32, D> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/encodings.npz");
    let mut archive = NpzArchive::open(path).unwrap();
    let file = archive.by_name(name).unwrap().unwrap();
    let shape: Vec<usize> = file.shape().iter().map(|&n| n as usize).collect();
    let values: Vec<f32> = file.into_vec().unwrap();
    ArrayD::from_shape_vec(shape, values).unwrap().into_dimensionality().unwrap()
}

fn assert_close<D: Dimension>(what: &str, got: &Array<f32, D>, want: &Array<f32, D>, bound: f32) {
    assert_eq!(got.shape(), want.shape(), "{what}");
    for (got, want) in got.iter().zip(want) {
        // Written as "within" so that NaN fails.
        assert!((got - want).abs() <= bound * want.abs().max(1.0), "{what}: got {got}, want {want}");
    }
}

#[test]
fn frames_are_resampled_as_numpy_interpolates() {
    let frames: Array3<f32> = array("frames");
    for new in [1, 2, 5, 7, 13, 51] {
        let tensor = TactileTensor { frames: Some(new) }.encode(frames.view()).unwrap();
        assert_close(
            &format!("{new} frames"),
            &tensor.index_axis(Axis(0), 0).to_owned(),
            &array(&format!("frames_{new}")),
            1e-5,
        );
    }
    let as_recorded = TactileTensor::default().encode(frames.view()).unwrap();
    assert_eq!(as_recorded.index_axis(Axis(0), 0), frames.view().permuted_axes([1, 2, 0]));
    // The layout in memory is no business of the encoding.
    let turned = frames.view().permuted_axes([2, 1, 0]).as_standard_layout().into_owned();
    let turned = TactileTensor { frames: Some(13) }.encode(turned.view().permuted_axes([2, 1, 0])).unwrap();
    assert_eq!(turned, TactileTensor { frames: Some(13) }.encode(frames.view()).unwrap());
}

#[test]
fn impossible_resampling_is_named() {
    let one = Array3::zeros((1, 2, 2));
    let message = |recording: &Array3<f32>, frames| {
        TactileTensor { frames: Some(frames) }.encode(recording.view()).unwrap_err().to_string()
    };
    assert!(message(&one, 5).contains("at least 2 frames to make 5 of"), "{}", message(&one, 5));
    assert!(message(&one, 0).contains("size = 0: must be at least 1 frame"));
    assert!(message(&Array3::zeros((0, 2, 2)), 1).contains("at least 1 frames"));
    let mut bad = Array3::zeros((3, 2, 2));
    bad[[2, 1, 0]] = f32::NAN;
    assert!(message(&bad, 3).starts_with("reading [2, 1, 0] is NaN"));
    assert_eq!(TactileTensor { frames: Some(1) }.encode(one.view()).unwrap().shape(), [1, 2, 2, 1]);
}

#[test]
fn single_frames_are_the_peak_one_index_or_all() {
    let frames: Array3<f32> = array("frames");
    let sums: Vec<f32> = frames.outer_iter().map(|frame| frame.sum()).collect();
    let peak = OneFrame::Peak.pick(frames.view()).unwrap();
    assert!(sums.iter().all(|&sum| sum <= sums[peak]));
    let mut flat = Array3::ones((4, 2, 2));
    assert_eq!(OneFrame::Peak.pick(flat.view()).unwrap(), 0, "the first of equals");
    flat[[2, 0, 0]] = 2.0;
    assert_eq!(OneFrame::Peak.pick(flat.view()).unwrap(), 2);

    let batch: Array4<f32> = ndarray::stack(Axis(0), &[frames.view(), frames.view()]).unwrap();
    let picked = OneFrame::At(3).encode_batch(batch.view()).unwrap();
    assert_eq!(picked.shape(), [2, 1, 3, 4]);
    assert_eq!(picked.index_axis(Axis(0), 1).index_axis(Axis(0), 0), frames.index_axis(Axis(0), 3));
    let error = OneFrame::At(7).encode_batch(batch.view()).unwrap_err().to_string();
    assert!(error.starts_with("sample 0: recording: expected at least 8 frames"), "{error}");

    let all = all_frames(batch.view());
    assert_eq!(all.shape(), [14, 1, 3, 4]);
    // Image i is of sample i / 7.
    assert_eq!(all.index_axis(Axis(0), 9).index_axis(Axis(0), 0), frames.index_axis(Axis(0), 2));
}

#[test]
fn sizes_are_those_of_pytorch() {
    let images: Array4<f32> = array("images");
    for (height, width) in [(7, 10), (14, 20), (3, 5), (1, 1), (28, 7), (5, 13)] {
        for (filter, name) in [(Filter::Bilinear, "bilinear"), (Filter::Area, "area")] {
            let resized = Resize { height, width, filter }.encode_batch(images.view()).unwrap();
            let name = format!("{name}_{height}_{width}");
            assert_close(&name, &resized, &array(&name), 1e-5);
        }
    }
    let same = Resize { height: 7, width: 10, filter: Filter::Area }.encode_batch(images.view()).unwrap();
    assert_eq!(same, images);
    let message = |height, width, images: &Array4<f32>| {
        let resize = Resize { height, width, filter: Filter::Bilinear };
        resize.encode_batch(images.view()).unwrap_err().to_string()
    };
    assert!(message(0, 5, &images).contains("size = 0: must be at least 1 row and column"));
    assert!(message(2, 2, &Array4::zeros((1, 1, 0, 3))).contains("at least one pixel"));
    let mut bad = images;
    bad[[1, 2, 3, 4]] = f32::INFINITY;
    assert!(message(2, 2, &bad).starts_with("reading [2, 3, 4] of sample 1 is inf"));
}

#[test]
fn grey_goes_into_red() {
    let grey = Array3::from_shape_fn((2, 3, 4), |(n, y, x)| (n * 12 + y * 4 + x) as f32);
    let coloured = red_channel(grey.view());
    assert_eq!(coloured.shape(), [2, 3, 3, 4]);
    assert_eq!(coloured.index_axis(Axis(1), 0), grey);
    assert!(
        coloured.index_axis(Axis(1), 1).iter().chain(&coloured.index_axis(Axis(1), 2)).all(|&v| v == 0.0)
    );
}

#[test]
fn electrode_images_are_numpy_s_reshape_in_either_order() {
    let electrodes: Array3<f32> = array("electrodes");
    for (order, name) in [(Order::Columns, "electrodes_columns"), (Order::Rows, "electrodes_rows")] {
        let image = ElectrodeImage { order }.encode(electrodes.view()).unwrap();
        let frames = electrodes.view().permuted_axes([2, 0, 1]);
        let shape = [frames.dim().0, 7, 3];
        let (values, mut again) = (frames.iter().copied().collect::<Vec<f32>>(), vec![0.0; 3 * 70 * 70]);
        ElectrodeImage { order }.encode_frames(shape, &values, &mut again).unwrap();
        assert_eq!(again, image.iter().copied().collect::<Vec<f32>>(), "{name}, frame by frame");
        assert_eq!(image, array(name), "{name}");
    }
    let short = Array4::zeros((2, 7, 3, 699));
    let error = ElectrodeImage::default().encode_batch(short.view()).unwrap_err().to_string();
    assert!(error.contains("expected [7, 3, 700 or more], got shape [7, 3, 699]"), "{error}");
    assert!(ElectrodeImage::default().encode(Array3::zeros((3, 7, 700)).view()).is_err());
    assert!(ElectrodeImage::default().encode(Array3::zeros((7, 3, 700)).view()).is_ok(), "700 are enough");
}

#[test]
fn numatac_samples_are_those_of_equations_1_to_3() {
    let grasps: Array4<f32> = array("grasps");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/encodings.npz");
    let mut archive = NpzArchive::open(path).unwrap();
    let onsets: Vec<i64> = archive.by_name("onsets").unwrap().unwrap().into_vec().unwrap();
    let numatac = NumaTac { window: 20, ..NumaTac::default() };
    for (grasp, onset) in grasps.outer_iter().zip(onsets) {
        assert_eq!(numatac.onset(grasp).unwrap() as i64, onset);
    }
    let samples = numatac.encode_batch(grasps.view()).unwrap();
    assert_close("samples", &samples, &array("samples"), 2e-5);

    // Fitted on the first three alone.
    let scaling = numatac::fit_features(samples.select(Axis(0), &[0, 1, 2]).view()).unwrap();
    let scaled = numatac::scale_features(&scaling, samples.view()).unwrap();
    assert_close("scaled", &scaled, &array("scaled"), 2e-4);
    let all = numatac::fit_features(samples.view()).unwrap();
    assert_ne!(scaling, all);
}

#[test]
fn bits_become_pascals_by_a_fixed_offset() {
    // Zhang et al. 2022, section 3.2.2: 270 bit at an offset of 238; its 3493.8 Pa left the offset out.
    let mut grasp = Array3::from_elem((2, 23, 320), 2048.0);
    grasp.index_axis_mut(Axis(1), 0).fill(270.0);
    grasp[[1, 5, 10]] = 2300.0;
    let at = |dc| {
        let numatac = NumaTac { offset: Offset::Fixed { dc, ac: 2048.0 }, ..NumaTac::default() };
        numatac.encode(grasp.view()).unwrap()
    };
    assert_eq!(at(238.0).shape(), [2, 23, 300]);
    assert!((at(238.0)[[0, 0, 0]] - 414.08).abs() < 1e-3);
    assert!((at(0.0)[[0, 0, 0]] - 3493.8).abs() < 1e-3);
    assert!((at(0.0)[[1, 5, 0]] - 32.76).abs() < 1e-3);
}

#[test]
fn the_judge_fires_beyond_its_thresholds_and_not_on_them() {
    let judge = NumaTac::default();
    assert!(!judge.touches(100.0, 110.0) && judge.touches(100.0, 110.1));
    assert!(!judge.touches(100.0, 90.0) && judge.touches(100.0, 89.9));
    assert!(!judge.touches(0.0, 50.0), "a dead channel touches nothing");
    // A slow drift to twice the rest is no contact: neighbours are compared.
    let drift =
        Array3::from_shape_fn((2, 23, 200), |(_, value, tick)| 1000.0 + 0.25 * (tick * 22 + value) as f32);
    assert!(matches!(judge.onset(drift.view()), Err(Error::NoContact { .. })));
    // One AC value per tick is enough: then neighbours are ticks.
    let step = Array3::from_shape_fn((1, 2, 9), |(_, _, tick)| if tick < 4 { 100.0 } else { 200.0 });
    assert_eq!(judge.onset(step.view()).unwrap(), 4);
}

#[test]
fn recordings_that_cannot_be_cut_are_named() {
    let grasp = |onset: Option<usize>, ticks: usize| {
        let mut grasp = Array4::from_elem((2, 2, 23, ticks), 2048.0);
        grasp[[0, 0, 3, 12]] = 3000.0;
        if let Some(onset) = onset {
            grasp[[1, 1, 7, onset]] = 1000.0;
        }
        grasp
    };
    let message =
        |grasp: &Array4<f32>| NumaTac::default().encode_batch(grasp.view()).unwrap_err().to_string();
    let text = message(&grasp(None, 450));
    assert!(text.starts_with("sample 1: no AC value is more than 1.1 or less than 0.9 times"), "{text}");
    let text = message(&grasp(Some(151), 450));
    assert!(text.starts_with("sample 1: contact in tick 151 of 450"), "{text}");
    assert!(message(&grasp(Some(0), 450)).starts_with("sample 1: contact in tick 0 of 450"));
    assert!(NumaTac::default().encode_batch(grasp(Some(150), 450).view()).is_ok());
    let mut bad = grasp(Some(150), 450);
    bad[[1, 0, 0, 449]] = f32::NAN;
    assert!(message(&bad).starts_with("reading [0, 0, 449] of sample 1 is NaN"));
    assert!(message(&Array4::zeros((1, 2, 1, 450))).contains("[fingers, 1 DC + AC values, ticks]"));

    let setting = |numatac: NumaTac| numatac.encode_batch(grasp(Some(150), 450).view()).unwrap_err();
    for (above, below) in [(1.0, 0.9), (f32::NAN, 0.9), (1.1, 1.0), (1.1, -0.1)] {
        let error = setting(NumaTac { above, below, ..NumaTac::default() });
        assert!(matches!(error, Error::Parameter { .. }), "{above}, {below}: {error}");
    }
    for (dc, ac, name) in [(f32::NAN, 0.0, "offset.dc"), (0.0, f32::INFINITY, "offset.ac")] {
        let error = setting(NumaTac { offset: Offset::Fixed { dc, ac }, ..NumaTac::default() });
        assert!(error.to_string().contains(name), "{error}");
    }
    assert!(setting(NumaTac { window: 0, ..NumaTac::default() }).to_string().starts_with("size = 0:"));
}
