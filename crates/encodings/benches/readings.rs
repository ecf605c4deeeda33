//! One raw reading to one input, as a frozen network is fed: `cargo bench -p taxel-encodings`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use taxel_encodings::{HardnessImage, NumaTac, OneFrame, Resize, Scaling, TactileTensor};

/// Readings as a sensor of ten bits gives them.
fn readings(n: usize) -> Vec<f32> {
    (0..n).map(|i| 512.0 + 400.0 * (i as f32 * 0.37).sin()).collect()
}

fn scales(c: &mut Criterion) {
    for [channels, length] in [[5, 50], [60, 75]] {
        let x = readings(channels * length);
        let mut out = vec![0.0; x.len()];
        let z_score = Scaling::ZScore { mean: vec![500.0; channels], sd: vec![3.0; channels] };
        for (name, scaling) in
            [("z-score", z_score), ("full scale", Scaling::FullScale { full_scale: 1023.0 })]
        {
            c.bench_function(&format!("{name} {channels}x{length}"), |b| {
                b.iter(|| scaling.encode(channels, black_box(&x), &mut out).is_ok());
            });
        }
    }
}

fn images(c: &mut Criterion) {
    let x = readings(250);
    let image = HardnessImage::default();
    if let Ok(mut plan) = image.plan(x.len()) {
        let mut out = vec![0.0; image.shape().iter().product()];
        c.bench_function("gadf in jet, 50x50 of 250", |b| {
            b.iter(|| plan.encode(black_box(&x), &mut out).is_ok())
        });
    }
    let shape = [1, 48, 72];
    if let Ok(plan) = (Resize { height: 32, width: 32, filter: Default::default() }).plan(shape) {
        let (x, mut out) = (readings(48 * 72), vec![0.0; 32 * 32]);
        c.bench_function("resize 48x72 to 32x32", |b| {
            b.iter(|| plan.encode(black_box(&x), &mut out).is_ok())
        });
    }
}

fn sequences(c: &mut Criterion) {
    let shape = [10, 28, 50];
    let x = readings(shape.iter().product());
    c.bench_function("peak of 10 frames 28x50", |b| {
        b.iter(|| OneFrame::Peak.pick_of(shape, black_box(&x)).is_ok())
    });
    for frames in [10, 8] {
        let tensor = TactileTensor { frames: Some(frames) };
        let mut out = vec![0.0; 28 * 50 * frames];
        c.bench_function(&format!("tensor of {frames} of 10 frames 28x50"), |b| {
            b.iter(|| tensor.encode_into(shape, black_box(&x), &mut out).is_ok());
        });
    }
    // Rest for 20 ticks, then contact.
    let shape = [2, 23, 400];
    let bits: Vec<f32> = (0..2 * 23 * 400).map(|i| if i % 400 < 20 { 2000.0 } else { 2600.0 }).collect();
    let numatac = NumaTac::default();
    let mut out = vec![0.0; 2 * 23 * numatac.window];
    c.bench_function("numatac 2x23x400 to 300", |b| {
        b.iter(|| numatac.encode_into(shape, black_box(&bits), &mut out).is_ok());
    });
}

criterion_group!(benches, scales, images, sequences);
criterion_main!(benches);
