//! Kernels of frozen networks against those of training, between places with margins and other channels; and with
//! slices that are too short.

mod common;

use common::placed::{gathered, placed, spread};
use common::{needs, panics, says_what_is_needed, values};
use proptest::prelude::*;
use taxel_kernels::frozen::{self, ImagePlace, Pool, Pooling, Route};
use taxel_kernels::{AffineView, Rectifier, Window3, conv, gru, lstm, pool};

fn close(got: &[f32], want: &[f32], what: &str) {
    let largest = want.iter().fold(1.0f32, |most, v| most.max(v.abs()));
    assert_eq!(got.len(), want.len());
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        assert!((got - want).abs() <= 1e-5 * largest, "{what}[{i}]: {got} and {want}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 6 } else { 400 }))]

    #[test]
    fn convolutions_agree_with_those_of_training(placed in placed()) {
        let case = &placed.case;
        let sizes = (case.channels, case.filters, case.groups);
        let plain = match case.dilation {
            [1, 1, 1] => conv::Conv::direct(case.window, sizes.0, sizes.1, sizes.2),
            dilation => conv::Conv::dilated(case.window, dilation, sizes.0, sizes.1, sizes.2),
        };
        let (x, weight, bias) = (values(plain.x_len(), 1), values(plain.weight_len(), 2), values(case.filters, 3));
        let addend = values(plain.y_len(), 4);
        let (mut scratch, mut work) = (vec![0.0; plain.padded_len()], vec![0.0; plain.work_len()]);
        let mut sums = vec![0.0; plain.y_len()];
        for band in plain.bands() {
            let padded = plain.pad(&x, &AffineView::default(), band, &mut scratch);
            plain.forward(padded, &weight, &[], Some(&bias), &mut sums, &mut work);
        }
        let (from, to) = (placed.from(), placed.to());
        let input = spread(&from, &x);
        let seen = |sums: &[f32]| {
            let mut y = vec![0.0; sums.len()];
            AffineView { affine: None, rectifier: placed.rectifier }.apply(case.filters, sums, &mut y);
            y
        };
        let route = Route { rectifier: placed.rectifier, ..Route::new(from, to) };
        let depthwise = case.groups > 1 && case.groups == case.channels && case.groups == case.filters;
        if depthwise {
            let conv = frozen::Depthwise::new(&case.window, case.dilation, &weight, &bias, route);
            let mut y = vec![7.0; to.buffer_len()];
            conv.run(&input, &mut y);
            close(&gathered(&to, &y), &seen(&sums), "depthwise");
            return Ok(());
        }
        let conv = frozen::Conv::new(&case.window, case.dilation, case.groups, &weight, &bias, route);
        let mut y = vec![7.0; to.buffer_len()];
        conv.run(&input, None, &mut y);
        close(&gathered(&to, &y), &seen(&sums), "outputs");
        let untouched = y.iter().filter(|v| **v == 7.0).count();
        prop_assert!(untouched >= y.len() - to.len(), "nothing is written outside the place");
        let route = Route { addend: Some(to), ..route };
        let conv = frozen::Conv::new(&case.window, case.dilation, case.groups, &weight, &bias, route);
        conv.run(&input, Some(&spread(&to, &addend)), &mut y);
        sums.iter_mut().zip(&addend).for_each(|(sum, addend)| *sum += addend);
        close(&gathered(&to, &y), &seen(&sums), "outputs with an addend");
    }
}

#[test]
fn poolings_agree_with_those_of_training() {
    let window = Window3 {
        input: [2, 7, 9],
        output: [2, 4, 4],
        kernel: [1, 3, 3],
        stride: [1, 2, 2],
        before: [0, 1, 0],
    };
    let channels = 21;
    let x = values(window.input_len() * channels, 5);
    let from = ImagePlace::new(window.input, channels, [1, 2], channels + 3, 2);
    let to = ImagePlace::new(window.output, channels, [2, 0], channels + 1, 1);
    let (mut largest, mut means) = (vec![0.0; to.len()], vec![0.0; to.len()]);
    let max = pool::MaxPool::new(&window, channels);
    max.forward(&AffineView::default(), &x, &mut largest, &mut vec![0.0; max.output_len()]);
    pool::average_forward(&window, &[(0, 0); 3], channels, &x, &mut means);
    for (pooling, expected) in [(Pooling::Max, largest), (Pooling::Mean, means)] {
        let mut y = vec![0.0; to.buffer_len()];
        Pool::new(pooling, frozen::windows(&window, &[(0, 0); 3]), from, to).run(&spread(&from, &x), &mut y);
        close(&gathered(&to, &y), &expected, "pooling");
    }
}

#[test]
fn linear_and_recurrent_layers_agree_with_those_of_training() {
    for (inputs, outputs) in [(1, 1), (7, 3), (65, 16), (37, 148), (130, 129), (33, 400)] {
        let (x, weight, start) = (values(inputs, 6), values(inputs * outputs, 7), values(outputs, 8));
        let mut y = vec![0.0; outputs];
        frozen::Linear::new(inputs, outputs, &weight).run(&x, &start, Rectifier::Relu, &mut y);
        let sum = |output: usize| -> f32 {
            let products =
                (0..inputs).map(|input| f64::from(x[input]) * f64::from(weight[input * outputs + output]));
            (products.sum::<f64>() + f64::from(start[output])).max(0.0) as f32
        };
        close(&y, &(0..outputs).map(sum).collect::<Vec<_>>(), "linear");
    }
    let sizes = lstm::Lstm { channels: 5, steps: 11, hidden: 37 };
    let tensors = [values(4 * 37 * 5, 9), values(4 * 37 * 37, 10), values(4 * 37, 11), values(4 * 37, 12)];
    let [ih, hh, bias_ih, bias_hh] = &tensors;
    let weights = lstm::Weights { ih, hh, bias_ih, bias_hh };
    let x = values(5 * 11, 13);
    let (mut expected, mut h) = (vec![0.0; 37], vec![0.0; 37]);
    sizes.forward(&x, &weights, &mut lstm::Trace::new(&sizes, 1), &mut expected);
    let from = ImagePlace::new([1, 1, 11], 5, [1, 0], 8, 2);
    let frozen = frozen::Lstm::new(sizes, &weights, from);
    frozen.run(&spread(&from, &x), &mut vec![0.0; frozen.work_len()], &mut h);
    close(&h, &expected, "lstm");
    let sizes = gru::Gru { channels: 5, steps: 11, hidden: 37 };
    let [ih, hh, bias_ih, bias_hh] = [&ih[..555], &hh[..4107], &bias_ih[..111], &bias_hh[..111]];
    let weights = gru::Weights { ih, hh, bias_ih, bias_hh };
    sizes.forward(&x, &weights, &mut gru::Trace::new(&sizes, 1), &mut expected);
    let frozen = frozen::Gru::new(sizes, &weights, from);
    frozen.run(&spread(&from, &x), &mut vec![7.0; frozen.work_len()], &mut h);
    close(&h, &expected, "gru");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 200 }))]

    /// Bit by bit what the view makes of each column, and nothing else is written.
    #[test]
    fn values_are_seen_and_moved_column_by_column(
        size in [1usize..3, 1..4, 1..6],
        channels in 1usize..40,
        margin in [0usize..3, 0..3],
        beside in [0usize..5, 0..5],
        rectifier in prop_oneof![Just(Rectifier::None), Just(Rectifier::Relu), Just(Rectifier::Relu6)],
        normed in any::<bool>(),
    ) {
        let place = |beside: usize| ImagePlace::new(size, channels, margin, channels + beside, beside / 2);
        let (from, to) = (place(beside[0]), place(beside[1]));
        let (x, scale, shift) = (values(from.buffer_len(), 1), values(channels, 2), values(channels, 3));
        let view = AffineView { affine: normed.then_some((&scale, &shift)), rectifier };
        let mut y = vec![7.0; to.buffer_len()];
        frozen::map(&view, &from, &x, &to, &mut y);
        let mut want = vec![7.0; to.buffer_len()];
        for row in 0..size[0] * size[1] {
            for column in 0..size[2] {
                let at = [row / size[1], row % size[1], column];
                let (a, b) = (from.at(at), to.at(at));
                view.apply(channels, &x[a..a + channels], &mut want[b..b + channels]);
            }
        }
        prop_assert_eq!(y, want);
    }
}

#[test]
fn slices_that_are_too_short_are_refused() {
    let window =
        Window3 { input: [1, 5, 6], output: [1, 5, 6], kernel: [1, 3, 3], stride: [1; 3], before: [0, 1, 1] };
    let (from, to) = (ImagePlace::new([1, 5, 6], 3, [1, 1], 3, 0), ImagePlace::dense([1, 5, 6], 4));
    let route = Route { addend: Some(to), ..Route::new(from, to) };
    let conv = frozen::Conv::new(&window, [1; 3], 1, &values(108, 1), &values(4, 2), route);
    needs("conv", [from.buffer_len(), to.end(), to.end()], |[x, addend, y]| conv.run(x, Some(addend), y));
    let to = ImagePlace::dense([1, 5, 6], 3);
    let conv = frozen::Depthwise::new(&window, [1; 3], &values(27, 1), &values(3, 2), Route::new(from, to));
    needs("depthwise", [from.buffer_len(), to.end()], |[x, y]| conv.run(x, y));
    let pool = Pool::new(Pooling::Mean, frozen::parts([1, 5, 6], [1; 3]), from, ImagePlace::dense([1; 3], 3));
    needs("pool", [from.end(), 3], |[x, y]| pool.run(x, y));
    let linear = frozen::Linear::new(6, 5, &values(30, 1));
    needs("linear", [6, 5, 5], |[x, start, y]| linear.run(x, start, Rectifier::None, y));
    let sizes = lstm::Lstm { channels: 2, steps: 3, hidden: 4 };
    let weight = |len| vec![0.1; len];
    let (ih, hh, bias) = (weight(32), weight(64), weight(16));
    let weights = lstm::Weights { ih: &ih, hh: &hh, bias_ih: &bias, bias_hh: &bias };
    let lstm = frozen::Lstm::new(sizes, &weights, ImagePlace::dense([1, 1, 3], 2));
    needs("lstm", [6, lstm.work_len(), 4], |[x, work, h]| lstm.run(x, work, h));
    let sizes = gru::Gru { channels: 2, steps: 3, hidden: 4 };
    let weights = gru::Weights { ih: &ih[..24], hh: &hh[..48], bias_ih: &bias[..12], bias_hh: &bias[..12] };
    let gru = frozen::Gru::new(sizes, &weights, ImagePlace::dense([1, 1, 3], 2));
    needs("gru", [6, gru.work_len(), 4], |[x, work, h]| gru.run(x, work, h));
    needs("copy", [from.end(), to.end()], |[x, y]| frozen::copy(&from, x, &to, y));
    let apart = ImagePlace::new([1, 5, 6], 3, [1, 1], 8, 2);
    needs("copy apart", [apart.end(), to.end()], |[x, y]| frozen::copy(&apart, x, &to, y));
    needs("copy back", [to.end(), apart.end()], |[x, y]| frozen::copy(&to, x, &apart, y));
    needs("add", [from.end(), to.end()], |[x, y]| frozen::add(&from, x, &to, y));
}

/// Distances whose sums wrap around would let a short slice pass.
#[test]
fn distances_that_no_memory_holds_are_refused() {
    let near = ImagePlace::dense([1, 1, 3], 1);
    let far = ImagePlace { pitch: [0, 0, usize::MAX / 2 + 1], ..near };
    for (from, to) in [(far, near), (near, far)] {
        let copied = panics(|| frozen::copy(&from, &[1.0; 3], &to, &mut [0.0; 3])).unwrap_or_default();
        assert!(copied.contains("no memory holds"), "{copied}");
        let added = panics(|| frozen::add(&from, &[1.0; 3], &to, &mut [0.0; 3])).unwrap_or_default();
        assert!(added.contains("no memory holds"), "{added}");
    }
    assert!(!ImagePlace { size: [1 << (usize::BITS / 2), 1 << (usize::BITS / 2), 1], ..near }.is_empty());
    let size = near.size;
    let window = Window3 { input: size, output: size, kernel: [1, 1, 3], stride: [1; 3], before: [0, 0, 1] };
    let before = ImagePlace { start: 0, ..ImagePlace::new(size, 1, [1, 1], 1, 0) };
    says_what_is_needed("a margin before the buffer", || {
        frozen::Conv::new(&window, [1; 3], 1, &[0.0; 3], &[0.0], Route::new(before, near));
    });
}

#[test]
#[should_panic(expected = "margins of")]
fn margins_that_are_too_narrow_are_refused() {
    let window =
        Window3 { input: [1, 1, 6], output: [1, 1, 6], kernel: [1, 1, 3], stride: [1; 3], before: [0, 0, 1] };
    let place = ImagePlace::dense([1, 1, 6], 2);
    frozen::Conv::new(&window, [1; 3], 1, &[0.0; 12], &[0.0; 2], Route::new(place, place));
}
