//! The matrix-product peak of one core, and the share of it that convolutions reach.
//!
//! ```text
//! cargo run --release -p taxel-kernels --example peak
//! ```
//!
//! One thread; prints one JSON object. The peak is the best burst of f32 products of sizes whose operands
//! stay in cache. A convolution (3×3, padding 1) passes over a batch of images, as the engine calls it; a
//! fused multiply–add counts as two operations, zero padding included. `share_of_peak` are convolutions that
//! do every product; `share_of_peak_as_run` those that training runs, which leave products out where that
//! is faster, and so may exceed 1. Where the processor has AVX512-BF16, the same is told of products of bf16 with sums in
//! f32: their peak is that of the instruction alone, whose sums stay in registers. Best bursts, not medians: other programs only ever slow a burst down.

use std::hint::black_box;
use std::time::Instant;

use taxel_kernels::conv::Conv;
use taxel_kernels::half;
use taxel_kernels::matmul::{Matrix, matmul};
use taxel_kernels::{AffineView, Window3};

/// Products of n×n matrices that compete for the peak.
const PRODUCTS: [usize; 3] = [256, 384, 512];
/// Channels in, channels out, rows and columns.
const CONVOLUTIONS: [(usize, usize, usize); 8] = [
    (3, 16, 50),
    (16, 16, 50),
    (16, 16, 25),
    (16, 32, 25),
    (32, 64, 25),
    (32, 32, 13),
    (32, 64, 13),
    (64, 64, 13),
];
const IMAGES: usize = 16;

type New = fn(Window3, usize, usize, usize) -> Conv;

const BURSTS: usize = 40;

/// Best GFLOP/s over bursts of `body`, which does `macs` multiply–adds.
fn best(macs: usize, mut body: impl FnMut()) -> f64 {
    body();
    // A burst of 100 MMAC takes 1 to 10 ms: long for the clock, short between two preemptions.
    let repeats = (100_000_000 / macs).max(1);
    let burst = || {
        let start = Instant::now();
        (0..repeats).for_each(|_| body());
        start.elapsed().as_secs_f64()
    };
    let seconds = std::iter::repeat_with(burst).take(BURSTS).fold(f64::INFINITY, f64::min);
    2.0 * (macs * repeats) as f64 / seconds / 1e9
}

fn values(len: usize) -> Vec<f32> {
    (0..len).map(|i| ((i * 37 % 101) as f32 - 50.0) / 50.0).collect()
}

type Product = fn(&mut [f32], usize, Matrix, Matrix, bool);

fn product(product: Product, n: usize) -> f64 {
    let (a, b, mut out) = (values(n * n), values(n * n), values(n * n));
    best(n * n * n, || {
        product(&mut out, n, Matrix::new(&a, n, n), Matrix::new(black_box(&b), n, n), false);
        black_box(&mut out);
    })
}

/// GFLOP/s forward, for the input's gradient and for the weights' gradient; operations are those of the
/// definition, whether they are done or saved.
fn convolution(new: New, (channels, filters, size): (usize, usize, usize)) -> [f64; 3] {
    let image = [1, size, size];
    let window =
        Window3 { input: image, output: image, kernel: [1, 3, 3], stride: [1; 3], before: [0, 1, 1] };
    let conv = new(window, channels, filters, 1);
    let (x_len, y_len) = (conv.x_len(), conv.y_len());
    let (mut x, mut y) = (values(IMAGES * x_len), values(IMAGES * y_len));
    let (weight, bias) = (values(conv.weight_len()), values(filters));
    let (mut dweight, mut dbias) = (vec![0.0; conv.sums_len()], vec![0.0; filters]);
    let mut scratch = vec![0.0; conv.padded_len().max(conv.backward_len())];
    let mut work = vec![0.0; conv.work_len()];
    let (mut packed, mut turned) = (vec![], vec![]);
    conv.pack(&weight, &mut packed);
    conv.turn(&weight, &mut turned);
    let macs = IMAGES * conv.macs();
    // The halo is part of the work: it is made anew for every image and pass.
    let forward = best(macs, || {
        for (x, y) in x.chunks(x_len).zip(y.chunks_mut(y_len)) {
            for band in conv.bands() {
                let padded = conv.pad(x, &AffineView::default(), band, &mut scratch);
                conv.forward(padded, &weight, &packed, Some(&bias), y, &mut work);
            }
        }
    });
    let weight_gradient = best(macs, || {
        for (x, dy) in x.chunks(x_len).zip(y.chunks(y_len)) {
            for band in conv.bands() {
                let padded = conv.pad(x, &AffineView::default(), band, &mut scratch);
                conv.backward_weight(padded, dy, &mut dweight, Some(&mut dbias), &mut work);
            }
        }
    });
    let input_gradient = best(macs, || {
        for (dx, dy) in x.chunks_mut(x_len).zip(y.chunks(y_len)) {
            conv.backward_input(dy, &weight, &turned, &mut scratch, dx, false);
        }
    });
    black_box((x, y, dweight, dbias));
    [forward, input_gradient, weight_gradient]
}

/// Share of the peak that convolutions of one kind reach, as lines of JSON.
fn shares(new: New, peak: f64) -> String {
    let rows = CONVOLUTIONS.map(|sizes| {
        let (channels, filters, size) = sizes;
        let [forward, dx, dw] = convolution(new, sizes).map(|gflops| gflops / peak);
        format!(
            r#"    {{"conv": "3x3 {channels}->{filters} @{size}x{size}", "forward": {forward:.3}, "input_gradient": {dx:.3}, "weight_gradient": {dw:.3}}}"#
        )
    });
    rows.join(",\n")
}

/// Prints the best product of `kind`, all products, and returns the best.
fn print_products(kind: &str, multiply: Product) -> f64 {
    let products = PRODUCTS.map(|n| product(multiply, n));
    let best = products.into_iter().fold(0.0, f64::max);
    let products: Vec<String> =
        PRODUCTS.iter().zip(products).map(|(n, gflops)| format!(r#""{n}": {gflops:.1}"#)).collect();
    println!("  \"{kind}_gflops\": {{{}}},", products.join(", "));
    best
}

fn main() {
    println!("{{");
    let peak = print_products("matmul", matmul);
    println!("  \"peak_gflops\": {peak:.1},");
    println!("  \"share_of_peak\": [\n{}\n  ],", shares(Conv::direct, peak));
    println!("  \"share_of_peak_as_run\": [\n{}\n  ],", shares(Conv::new, peak));
    if let Err(reason) = half::supported() {
        println!("  \"half\": \"{reason}\"\n}}");
        return;
    }
    print_products("half_matmul", half::multiply);
    // Two products of bf16 are two multiply-adds of each of 16 lanes.
    let peak = best(20_000 * 24 * 32, || {
        black_box(half::burst(black_box(20_000)));
    });
    println!("  \"half_peak_gflops\": {peak:.1},");
    let new: New = |window, channels, filters, groups| Conv::half(window, [1; 3], channels, filters, groups);
    println!("  \"half_share_of_peak\": [\n{}\n  ]\n}}", shares(new, peak));
}
