//! Kernels in bytes against sums of whole numbers, between places with margins and other channels, in every width of
//! this CPU; and with slices that are too short.

mod common;

use common::{cases, most, panics};
use proptest::prelude::*;
use taxel_kernels::frozen::bytes::{
    self, Add, ByteOutput, ByteScale, Bytes, Conv, Map, Mean, SourceValues, Sums, Target, Width,
};
use taxel_kernels::frozen::{self, ImagePlace, Reach, Route};
use taxel_kernels::{Rectifier, Window3};

fn bytes_of(count: usize, salt: usize) -> Vec<u8> {
    (0..count).map(|i| ((i * 7919 + salt * 104_729) % 256) as u8).collect()
}

/// From -127 to 127, the ends most often: what would overflow sixteen bits does.
fn weights_of(count: usize, salt: usize) -> Vec<i8> {
    bytes_of(count, salt)
        .iter()
        .map(|b| if *b > 200 { 127 } else { (i32::from(*b) - 127).min(127) as i8 })
        .collect()
}

/// Dense bytes at `place`: margins are `zero`, what nobody may use is 255.
fn spread(place: &ImagePlace, dense: &[u8], zero: u8) -> Vec<u8> {
    let mut buffer = vec![zero; place.buffer_len() + Bytes::SPARE];
    let end = place.buffer_len();
    buffer[end..].fill(255);
    for position in 0..place.positions() {
        let [_, rows, columns] = place.size;
        let at = place.at([position / (rows * columns), position / columns % rows, position % columns]);
        let start = at - at % place.pitch[2];
        buffer[start..start + place.pitch[2]].fill(255);
        buffer[at..at + place.channels]
            .copy_from_slice(&dense[position * place.channels..][..place.channels]);
    }
    buffer
}

fn gathered<T: Copy>(place: &ImagePlace, buffer: &[T]) -> Vec<T> {
    let [_, rows, columns] = place.size;
    let at = |p: usize| place.at([p / (rows * columns), p / columns % rows, p % columns]);
    (0..place.positions()).flat_map(|p| buffer[at(p)..at(p) + place.channels].to_vec()).collect()
}

/// Sums of products, position by position; inputs outside count as the zero.
fn reference(case: &common::Case, x: &[u8], weight: &[i8], bias: &[i32], zero: u8) -> Vec<i64> {
    let Window3 { input, output, kernel, stride, before } = case.window;
    let (per, filters) = (case.channels / case.groups, case.filters / case.groups);
    let is_depthwise = per == 1 && filters == 1 && case.groups > 1;
    let mut sums = vec![];
    for at in 0..output.iter().product::<usize>() {
        let at = [at / (output[1] * output[2]), at / output[2] % output[1], at % output[2]];
        for filter in 0..case.filters {
            let (group, in_group) = (filter / filters, filter % filters);
            let mut sum = i64::from(bias[filter]);
            for k in 0..kernel.iter().product::<usize>() {
                let tap = [k / (kernel[1] * kernel[2]), k / kernel[2] % kernel[1], k % kernel[2]];
                let place: Vec<usize> =
                    (0..3).map(|a| at[a] * stride[a] + tap[a] * case.dilation[a]).collect();
                if (0..3).any(|a| place[a] < before[a] || place[a] >= before[a] + input[a]) {
                    continue;
                }
                let p = ((place[0] - before[0]) * input[1] + place[1] - before[1]) * input[2] + place[2]
                    - before[2];
                for c in 0..per {
                    let w = if is_depthwise {
                        weight[k * case.channels + filter]
                    } else {
                        weight
                            [((group * kernel.iter().product::<usize>() + k) * per + c) * filters + in_group]
                    };
                    let x = i64::from(x[p * case.channels + group * per + c]) - i64::from(zero);
                    sum += x * i64::from(w);
                }
            }
            sums.push(sum);
        }
    }
    sums
}

/// Returns the byte that is stored of a sum, in the order of operations that all widths share.
fn stored(sum: i64, unit: f32, addend: Option<f32>, output: ByteScale, rectifier: Rectifier) -> u8 {
    let steps = 1.0 / f64::from(output.step);
    let mut y = sum as f32 * (f64::from(unit) * steps) as f32;
    if let Some(addend) = addend {
        y += addend;
    }
    let zero = f32::from(output.zero);
    let (low, high) = match rectifier {
        Rectifier::None => (0.0, 255.0),
        Rectifier::Relu => (zero, 255.0),
        Rectifier::Relu6 => (zero, (zero + (6.0 * steps) as f32).min(255.0)),
    };
    (y + zero).max(low).min(high).round_ties_even() as u8
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 6 } else { 300 }))]

    #[test]
    fn convolutions_are_exact_in_every_width(
        case in cases(1..80, 2),
        wider in [0usize..3, 0..3],
        beside in [0usize..5, 0..5],
        zero in prop_oneof![Just(0u8), Just(128), Just(255)],
        rectifier in prop_oneof![Just(Rectifier::None), Just(Rectifier::Relu), Just(Rectifier::Relu6)],
    ) {
        let [before, after] = frozen::margins(&case.window, case.dilation);
        let margin = [before + wider[0], after + wider[1]];
        let from = ImagePlace::new(case.window.input, case.channels, margin, case.channels + beside[0], beside[0] / 2);
        let to = ImagePlace::new(case.window.output, case.filters, wider, case.filters + beside[1], beside[1] / 2);
        let x = bytes_of(case.window.input_len() * case.channels, 1);
        let (per, volume) = (case.channels / case.groups, case.window.volume());
        let weight = weights_of(volume * per * case.filters, 2);
        let bias: Vec<i32> = (0..case.filters).map(|f| f as i32 * 997 - 4000).collect();
        let unit: Vec<f32> = (0..case.filters).map(|f| (f % 7 + 1) as f32 * 2e-5).collect();
        let (input, scale) = (ByteScale { step: 0.1, zero }, ByteScale { step: 0.03, zero: 40 });
        let added = ByteScale { step: 0.05, zero: 9 };
        let exact = reference(&case, &x, &weight, &bias, zero);
        let buffer = spread(&from, &x, zero);
        let is_depthwise = case.groups > 1 && case.groups == case.channels && case.groups == case.filters;
        let addend = bytes_of(to.len(), 5);
        for with in [false, true] {
            let sums = Sums {
                weight: &weight, bias: &bias, unit: &unit, input,
                addend: with.then_some(added), output: ByteOutput::Bytes(scale),
            };
            let route = Route { rectifier, addend: with.then_some(to), ..Route::new(from, to) };
            let factor = (f64::from(added.step) / f64::from(scale.step)) as f32;
            let of = |i: usize| with.then(|| (f32::from(addend[i]) - f32::from(added.zero)) * factor);
            let want: Vec<u8> = exact.iter().enumerate().map(|(i, &sum)| {
                stored(sum, unit[i % case.filters], of(i), scale, rectifier)
            }).collect();
            if is_depthwise {
                if with {
                    continue;
                }
                let mut y = vec![7; to.buffer_len()];
                bytes::Depthwise::new(&case.window, case.dilation, &sums, route).run(&buffer, Target::Bytes(&mut y));
                prop_assert_eq!(gathered(&to, &y), want, "depthwise");
                continue;
            }
            let other = spread(&to, &addend, 0);
            for width in Width::all() {
                let conv = Conv::at(width, &case.window, case.dilation, case.groups, &sums, route);
                let mut y = vec![7; to.buffer_len()];
                conv.run(&buffer, with.then_some(&other[..]), Target::Bytes(&mut y));
                prop_assert_eq!(&gathered(&to, &y), &want, "{:?}", width);
                let untouched = spread(&to, &vec![7; to.len()], 7);
                let outside = untouched.iter().zip(&y).filter(|(u, y)| **u == 255 && **y != 7).count();
                prop_assert_eq!(outside, 0, "nothing is written outside the place");
            }
        }
        if !is_depthwise {
            let sums = Sums { weight: &weight, bias: &bias, unit: &unit, input, addend: None, output: ByteOutput::Floats };
            for width in Width::all() {
                let conv = Conv::at(width, &case.window, case.dilation, case.groups, &sums, Route::new(from, to));
                let mut y = vec![f32::NAN; to.buffer_len()];
                conv.run(&buffer, None, Target::Floats(&mut y));
                let want: Vec<f32> =
                    exact.iter().enumerate().map(|(i, &sum)| sum as f32 * unit[i % case.filters]).collect();
                prop_assert_eq!(gathered(&to, &y), want, "floats, {:?}", width);
            }
        }
    }
}

#[test]
fn values_go_between_bytes_and_floats() {
    let channels = [9, 1, 2, 3, 5, 8, 21];
    for channels in channels.into_iter().take(most(7, 2)) {
        let dense = ImagePlace::dense([1, 3, 5], channels);
        between_bytes_and_floats(dense, dense);
        let wide = ImagePlace::new([1, 3, 5], channels, [1, 2], channels + 3, 2);
        between_bytes_and_floats(wide, ImagePlace::new([1, 3, 5], channels, [2, 0], channels + 1, 1));
        // Rows lie together, one by one.
        between_bytes_and_floats(ImagePlace::new([1, 3, 5], channels, [1, 2], channels, 0), dense);
    }
}

fn between_bytes_and_floats(from: ImagePlace, to: ImagePlace) {
    let (scale, channels) = (ByteScale::over(-1.0, 3.0), from.channels);
    let x: Vec<f32> = (0..from.buffer_len()).map(|i| (i * 37 % 101) as f32 / 20.0 - 1.5).collect();
    let mut y = vec![0; to.buffer_len()];
    let map = Map::new((from, None), (to, ByteOutput::Bytes(scale)), None, Rectifier::None);
    map.run(SourceValues::Floats(&x), Target::Bytes(&mut y));
    let mut back = vec![0.0; from.buffer_len()];
    let map = Map::new((to, Some(scale)), (from, ByteOutput::Floats), None, Rectifier::None);
    map.run(SourceValues::Bytes(&y), Target::Floats(&mut back));
    for (x, back) in gathered(&from, &x).into_iter().zip(gathered(&from, &back)) {
        assert!((x.clamp(-1.0, 3.0) - back).abs() <= 0.51 * scale.step, "{x} comes back as {back}");
    }
    // As they are.
    let mut copy = vec![0; from.buffer_len()];
    let map = Map::new((to, Some(scale)), (from, ByteOutput::Bytes(scale)), None, Rectifier::None);
    map.run(SourceValues::Bytes(&y), Target::Bytes(&mut copy));
    assert_eq!(gathered(&to, &y), gathered(&from, &copy));
    // Through a norm and a rectifier.
    let (gain, shift): (Vec<f32>, Vec<f32>) =
        (0..channels).map(|c| (0.1 * c as f32 - 1.0, 0.2 + 0.1 * c as f32)).unzip();
    let other = ByteScale::over(0.0, 2.0);
    let mut z = vec![0; from.buffer_len()];
    let map =
        Map::new((to, Some(scale)), (from, ByteOutput::Bytes(other)), Some((&gain, &shift)), Rectifier::Relu);
    map.run(SourceValues::Bytes(&y), Target::Bytes(&mut z));
    for (i, (y, z)) in gathered(&to, &y).into_iter().zip(gathered(&from, &z)).enumerate() {
        let c = i % channels;
        let real = scale.step * (f32::from(y) - f32::from(scale.zero)) * gain[c] + shift[c];
        let got = other.step * f32::from(z);
        assert!(
            (real.clamp(0.0, 2.0) - got).abs() <= 0.51 * other.step,
            "{i} of {channels}: {real} and {got}"
        );
    }
}

#[test]
fn sums_means_and_maxima_are_those_of_the_numbers() {
    let scales = [ByteScale::over(-1.0, 1.0), ByteScale::over(0.0, 5.0)];
    let place = ImagePlace::new([1, 4, 4], 19, [1, 1], 21, 1);
    let [a, b] = [1, 2].map(|salt| bytes_of(place.len(), salt));
    let real = |scale: ByteScale, byte: u8| scale.step * (f32::from(byte) - f32::from(scale.zero));
    let (output, mut y) = (ByteScale::over(0.0, 6.0), vec![0; place.buffer_len()]);
    let sum = Add::new(
        [(place, scales[0]), (place, scales[1])],
        (place, ByteOutput::Bytes(output)),
        Rectifier::Relu,
    );
    sum.run(&spread(&place, &a, 0), &spread(&place, &b, 0), Target::Bytes(&mut y));
    for (i, y) in gathered(&place, &y).into_iter().enumerate() {
        let want = (real(scales[0], a[i]) + real(scales[1], b[i])).max(0.0);
        assert!((want - real(output, y)).abs() <= 0.51 * output.step, "{i}: {want} and {}", real(output, y));
    }
    let to = ImagePlace::dense([1, 2, 2], 19);
    let reach = |axis: usize| -> Vec<Reach> {
        let parts = if axis == 0 { vec![(0, 1)] } else { vec![(0, 2), (2, 4)] };
        parts.into_iter().map(|(from, to)| Reach { from, to, count: to - from }).collect()
    };
    let axes = [0, 1, 2].map(reach);
    let x = spread(&place, &a, 0);
    let (mut largest, mut means) = (vec![0; to.len()], vec![0.0; to.len()]);
    bytes::max(&axes, &place, &x, &to, &mut largest);
    Mean::new(axes, (place, scales[0]), (to, ByteOutput::Floats)).run(&x, Target::Floats(&mut means));
    for position in 0..4 {
        for c in 0..19 {
            let inside = [0, 1, 4, 5].map(|at| a[(position / 2 * 8 + position % 2 * 2 + at) * 19 + c]);
            let want = inside.iter().map(|v| real(scales[0], *v)).sum::<f32>() / 4.0;
            assert_eq!(largest[position * 19 + c], *inside.iter().max().unwrap_or(&0));
            assert!((means[position * 19 + c] - want).abs() < 1e-6);
        }
    }
    let (dense, mut shuffled) = (ImagePlace::dense([1, 1, 2], 6), vec![0; 12]);
    bytes::shuffle(2, &dense, &(0..12).collect::<Vec<u8>>(), &dense, &mut shuffled);
    assert_eq!(shuffled, [0, 3, 1, 4, 2, 5, 6, 9, 7, 10, 8, 11]);
}

#[test]
fn slices_that_are_too_short_are_refused() {
    let refuses = |what: &str, call: &dyn Fn()| {
        let message = panics(call).unwrap_or_else(|| "goes through".into());
        assert!(message.contains("needed"), "{what}: {message}");
    };
    let window =
        Window3 { input: [1, 5, 6], output: [1, 5, 6], kernel: [1, 3, 3], stride: [1; 3], before: [0, 1, 1] };
    let from = ImagePlace::new([1, 5, 6], 3, [1, 1], 3, 0);
    let (scale, len) = (ByteScale { step: 0.1, zero: 3 }, from.buffer_len() + Bytes::SPARE);
    let (unit, bias) = ([1e-3; 4], [0; 4]);
    for width in Width::all() {
        let to = ImagePlace::dense([1, 5, 6], 4);
        let weight = weights_of(108, 1);
        let sums = Sums {
            weight: &weight,
            unit: &unit,
            bias: &bias,
            input: scale,
            addend: Some(scale),
            output: ByteOutput::Bytes(scale),
        };
        let route = Route { addend: Some(to), ..Route::new(from, to) };
        let conv = Conv::at(width, &window, [1; 3], 1, &sums, route);
        let run = |x: usize, addend: usize, y: usize| {
            conv.run(&vec![1; x], Some(&vec![1; addend]), Target::Bytes(&mut vec![0; y]));
        };
        run(len, to.end(), to.end());
        refuses("input", &|| run(len - 4, to.end(), to.end()));
        refuses("addend", &|| run(len, to.end() - 1, to.end()));
        refuses("output", &|| run(len, to.end(), to.end() - 1));
        refuses("no addend", &|| conv.run(&vec![1; len], None, Target::Bytes(&mut vec![0; to.end()])));
        refuses("floats", &|| {
            conv.run(&vec![1; len], Some(&vec![1; to.end()]), Target::Floats(&mut vec![0.0; to.end()]));
        });
    }
    let to = ImagePlace::dense([1, 5, 6], 3);
    let weight = weights_of(27, 1);
    let sums = Sums {
        weight: &weight,
        unit: &unit[..3],
        bias: &bias[..3],
        input: scale,
        addend: None,
        output: ByteOutput::Bytes(scale),
    };
    let conv = bytes::Depthwise::new(&window, [1; 3], &sums, Route::new(from, to));
    let run = |x: usize, y: usize| conv.run(&vec![1; x], Target::Bytes(&mut vec![0; y]));
    run(from.buffer_len(), to.end());
    refuses("depthwise input", &|| run(from.buffer_len() - 1, to.end()));
    refuses("depthwise output", &|| run(from.buffer_len(), to.end() - 1));
    let large = [i32::MAX / 2; 3];
    refuses("sums beyond what floats hold", &|| {
        bytes::Depthwise::new(&window, [1; 3], &Sums { bias: &large, ..sums }, Route::new(from, to));
    });
    let map = Map::new((from, Some(scale)), (to, ByteOutput::Floats), None, Rectifier::None);
    let run =
        |x: usize, y: usize| map.run(SourceValues::Bytes(&vec![1; x]), Target::Floats(&mut vec![0.0; y]));
    run(from.end(), to.end());
    refuses("map input", &|| run(from.end() - 1, to.end()));
    refuses("map output", &|| run(from.end(), to.end() - 1));
    refuses("map of floats", &|| {
        map.run(SourceValues::Floats(&vec![1.0; len]), Target::Floats(&mut vec![0.0; len]))
    });
    let sum = Add::new([(from, scale), (to, scale)], (to, ByteOutput::Bytes(scale)), Rectifier::None);
    let run = |a: usize, b: usize, y: usize| {
        sum.run(&vec![1; a], &vec![1; b], Target::Bytes(&mut vec![0; y]));
    };
    run(from.end(), to.end(), to.end());
    refuses("first addend", &|| run(from.end() - 1, to.end(), to.end()));
    refuses("second addend", &|| run(from.end(), to.end() - 1, to.end()));
    refuses("sums", &|| run(from.end(), to.end(), to.end() - 1));
    let one = ImagePlace::dense([1; 3], 3);
    let mean = Mean::new(frozen::parts([1, 5, 6], [1; 3]), (from, scale), (one, ByteOutput::Floats));
    let run = |x: usize, y: usize| mean.run(&vec![1; x], Target::Floats(&mut vec![0.0; y]));
    run(from.end(), 3);
    refuses("mean input", &|| run(from.end() - 1, 3));
    refuses("mean output", &|| run(from.end(), 2));
}
