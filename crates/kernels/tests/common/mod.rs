//! Convolutions of all sizes, values for them, and slices that are too short.
#![allow(dead_code, reason = "each test file uses its part")]

pub mod placed;

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};

use proptest::prelude::*;
use taxel_kernels::Window3;

/// Sizes of a convolution in one to three dimensions.
#[derive(Debug, Clone)]
pub struct Case {
    pub window: Window3,
    pub dilation: [usize; 3],
    pub channels: usize,
    pub filters: usize,
    pub groups: usize,
}

/// A bound of sizes, lower under Miri, where a product takes microseconds.
pub fn most(usual: usize, miri: usize) -> usize {
    if cfg!(miri) { miri } else { usual }
}

/// Dense and grouped ones with so many filters per group, and depthwise ones with up to 40 channels, `depthwise`
/// to three.
pub fn cases(filters: Range<usize>, depthwise: u32) -> impl Strategy<Value = Case> {
    let axis = (1..most(12, 6), 1..most(6, 4), 1..most(4, 3), 0..most(5, 3), 0..most(5, 3), 1..most(4, 3));
    let dense = (1..most(20, 5), filters, 1..most(4, 3));
    let sizes = prop_oneof![3 => dense, depthwise => (Just(1usize), Just(1usize), 2usize..40)];
    ([axis.clone(), axis.clone(), axis], 0usize..3, sizes).prop_map(
        |(axes, flat, (channels, filters, groups))| {
            let mut window =
                Window3 { input: [1; 3], output: [1; 3], kernel: [1; 3], stride: [1; 3], before: [0; 3] };
            let mut dilations = [1; 3];
            for (a, axis) in axes.into_iter().enumerate().skip(flat) {
                let (input, kernel, stride, before, after, dilation) = axis;
                let extent = (kernel - 1) * dilation + 1;
                let padding = extent.saturating_sub(input).max(before + after);
                dilations[a] = dilation;
                window.input[a] = input;
                window.kernel[a] = kernel;
                window.stride[a] = stride;
                window.before[a] = before;
                window.output[a] = (input + padding - extent) / stride + 1;
            }
            let (channels, filters) = (channels * groups, filters * groups);
            Case { window, dilation: dilations, channels, filters, groups }
        },
    )
}

pub fn values(count: usize, salt: usize) -> Vec<f32> {
    (0..count).map(|i| (((i * 7919 + salt * 104_729) % 2003) as f32 - 1001.0) / 1000.0).collect()
}

/// The message of the panic in `call`, if it panics.
pub fn panics(call: impl FnOnce()) -> Option<String> {
    let payload = catch_unwind(AssertUnwindSafe(call)).err()?;
    let text = payload.downcast_ref::<&str>().map(ToString::to_string);
    Some(text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default())
}

#[track_caller]
pub fn says_what_is_needed(name: &str, call: impl FnOnce()) {
    let message = panics(call).unwrap_or_else(|| "goes through".into());
    assert!(message.contains("needed"), "{name}: {message}");
}

/// `call` with slices of these lengths goes through; with any of them one value shorter it panics. Slices of
/// length 0 are those that `call` does not read.
#[track_caller]
pub fn needs<const N: usize>(name: &str, lens: [usize; N], call: impl Fn([&mut [f32]; N])) {
    let run = |lens: [usize; N]| {
        let mut slices = lens.map(|len| vec![0.5; len]);
        call(slices.each_mut().map(|slice| &mut slice[..]));
    };
    run(lens);
    for which in (0..N).filter(|&which| lens[which] > 0) {
        let mut short = lens;
        short[which] -= 1;
        says_what_is_needed(&format!("{name}: slice {which} of {} values", short[which]), || run(short));
    }
}
