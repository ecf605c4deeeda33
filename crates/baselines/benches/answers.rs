//! One recording to its scores, and many: `cargo bench -p taxel-baselines`.

use std::error::Error;
use std::hint::black_box;

use criterion::Criterion;
use taxel_baselines::{Method, Series};

/// Recordings that differ by class and by noise.
fn recordings(n: usize, classes: usize, len: usize) -> Vec<f32> {
    let noise = |i: usize| ((i * 7919 + i / 13) % 997) as f32 / 997.0;
    let value = |i: usize| {
        let (sample, at) = (i / len, i % len);
        ((at as f32) * (0.05 + 0.01 * (sample % classes) as f32)).sin() + noise(i)
    };
    (0..n * len).map(value).collect()
}

fn bench(c: &mut Criterion, method: Method, sizes: [usize; 3], classes: usize) -> Result<(), Box<dyn Error>> {
    let [samples, channels, length] = sizes;
    let x = recordings(samples, classes, channels * length);
    let y: Vec<u32> = (0..samples).map(|i| (i % classes) as u32).collect();
    let fitted = method.fit(&Series::new(&x, channels, length)?, &y, classes, 0, "bench")?;
    let test = recordings(64, classes, channels * length);
    let test = Series::new(&test, channels, length)?;
    let (mut workspace, mut scores) = (fitted.workspace(), vec![0.0; classes]);
    let name = format!("{} {channels}x{length}, {classes} classes, {samples} samples", method.name());
    c.bench_function(&name, |b| {
        b.iter(|| fitted.predict_one(black_box(test.sample(0)), &mut workspace, &mut scores).is_ok());
    });
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    c.bench_function(&format!("64 at a time: {name}"), |b| {
        b.iter(|| pool.install(|| fitted.scores(black_box(&test)).is_ok()));
    });
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut c = Criterion::default().configure_from_args();
    let rocket = Method::MiniRocket { features: 10_000 };
    bench(&mut c, rocket, [112, 5, 50], 28)?;
    bench(&mut c, rocket, [100, 60, 75], 6)?;
    for method in
        [Method::NearestNeighbours { k: 1 }, Method::SvmLinear { c: 1.0 }, Method::SvmRbf { c: 1.0 }]
    {
        bench(&mut c, method, [112, 5, 50], 28)?;
        bench(&mut c, method, [400, 60, 75], 6)?;
    }
    c.final_summary();
    Ok(())
}
