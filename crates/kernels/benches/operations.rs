//! Single operations on one image, one thread; ids are operation/phase/shape.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use taxel_kernels::conv::Conv;
use taxel_kernels::pool::MaxPool;
use taxel_kernels::{AffineView, Window3, batch_norm, reduce};

/// Channels in and out, input, kernel, groups.
type Sizes = (usize, usize, [usize; 3], [usize; 3], usize);

/// Padding keeps the size in two dimensions; there is none in three.
const CONVOLUTIONS: [Sizes; 6] = [
    (3, 16, [1, 50, 50], [1, 3, 3], 1),
    (16, 32, [1, 25, 25], [1, 3, 3], 1),
    (64, 64, [1, 13, 13], [1, 3, 3], 1),
    (32, 64, [1, 1, 50], [1, 1, 5], 1),
    (8, 16, [24, 46, 8], [5, 3, 3], 1),
    (32, 32, [1, 112, 112], [1, 3, 3], 32),
];

fn values(len: usize) -> Vec<f32> {
    (0..len).map(|i| ((i * 37 % 101) as f32 - 50.0) / 50.0).collect()
}

fn joined(sizes: [usize; 3]) -> String {
    sizes.map(|size| size.to_string()).join("x")
}

fn convolutions(c: &mut Criterion) {
    for (channels, filters, input, kernel, groups) in CONVOLUTIONS {
        let before = if input[0] == 1 { kernel.map(|size| size / 2) } else { [0; 3] };
        let output = std::array::from_fn(|a| input[a] + 2 * before[a] + 1 - kernel[a]);
        let conv =
            Conv::new(Window3 { input, output, kernel, stride: [1; 3], before }, channels, filters, groups);
        let shape = format!("{channels}-{filters}x{}@{}", joined(kernel), joined(input));
        let (x, mut y, mut dx) = (values(conv.x_len()), values(conv.y_len()), values(conv.x_len()));
        let (weight, bias) = (values(conv.weight_len()), values(filters));
        let (mut sums, mut dbias) = (vec![0.0; conv.sums_len()], vec![0.0; filters]);
        let mut scratch = vec![0.0; conv.padded_len().max(conv.backward_len())];
        let mut work = vec![0.0; conv.work_len()];
        let (mut packed, mut turned) = (vec![], vec![]);
        conv.pack(&weight, &mut packed);
        conv.turn(&weight, &mut turned);
        let mut group = c.benchmark_group("conv");
        group.throughput(Throughput::Elements(conv.macs() as u64));
        group.bench_function(format!("forward/{shape}"), |b| {
            b.iter(|| {
                for band in conv.bands() {
                    let padded = conv.pad(black_box(&x), &AffineView::default(), band, &mut scratch);
                    conv.forward(padded, &weight, &packed, Some(&bias), &mut y, &mut work);
                }
            });
        });
        let dy = y.clone();
        group.bench_function(format!("weight_gradient/{shape}"), |b| {
            b.iter(|| {
                for band in conv.bands() {
                    let padded = conv.pad(black_box(&x), &AffineView::default(), band, &mut scratch);
                    conv.backward_weight(padded, &dy, &mut sums, Some(&mut dbias), &mut work);
                }
            });
        });
        group.bench_function(format!("input_gradient/{shape}"), |b| {
            b.iter(|| conv.backward_input(black_box(&dy), &weight, &turned, &mut scratch, &mut dx, false));
        });
    }
}

fn pools_and_sums(c: &mut Criterion) {
    let (channels, size) = (16, 50);
    let window = Window3 {
        input: [1, size, size],
        output: [1, size / 2, size / 2],
        kernel: [1, 2, 2],
        stride: [1, 2, 2],
        before: [0; 3],
    };
    let pool = MaxPool::new(&window, channels);
    let (scale, shift) = (values(channels), values(channels));
    let view = AffineView { affine: Some((&scale, &shift)), ..AffineView::default() };
    let (x, mut dx) = (values(size * size * channels), values(size * size * channels));
    let (mut y, mut taken) = (vec![0.0; pool.output_len()], vec![0.0; pool.output_len()]);
    let shape = format!("{channels}@{size}x{size}");
    c.bench_function(&format!("max_pool/forward/{shape}"), |b| {
        b.iter(|| pool.forward(&view, black_box(&x), &mut y, &mut taken));
    });
    c.bench_function(&format!("max_pool/input_gradient/{shape}"), |b| {
        b.iter(|| pool.backward(&taken, black_box(&y), &mut dx, false));
    });
    let mut sums = vec![0.0; channels];
    c.bench_function(&format!("batch_norm/sums/{shape}"), |b| {
        b.iter(|| reduce::add_columns(channels, black_box(&x), &mut sums));
    });
    let zeros = || vec![0.0; channels];
    let gradient =
        batch_norm::InputGradient { dy: scale.clone(), x: shift.clone(), mean: zeros(), constant: zeros() };
    let dy = x.clone();
    c.bench_function(&format!("batch_norm/input_gradient/{shape}"), |b| {
        b.iter(|| batch_norm::backward(channels, black_box(&x), &view, Some(&gradient), &dy, &mut dx, false));
    });
}

criterion_group!(benches, convolutions, pools_and_sums);
criterion_main!(benches);
