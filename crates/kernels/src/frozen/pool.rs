//! Maximum and mean over windows between two places.

use crate::adaptive_pool::part;
use crate::lengths::at_least;
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::window::Window3;

use super::place::ImagePlace;

/// The value of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pooling {
    /// The largest value; NaN wins.
    Max,
    /// The mean over as many values as each axis counts.
    Mean,
}

/// The inputs of one output along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reach {
    /// First input.
    pub from: usize,
    /// One past the last.
    pub to: usize,
    /// Values that the mean counts; more than the inputs where padding counts.
    pub count: usize,
}

/// Returns the inputs of each output of `window`; of the padding, means count `counted` (before, after) per axis.
pub fn windows(window: &Window3, counted: &[(usize, usize); 3]) -> [Vec<Reach>; 3] {
    [0, 1, 2].map(|axis| {
        let reach = |out: usize| {
            let (values, from) = window.inside(axis, out);
            Reach { from, to: from + values.len(), count: window.counted(axis, out, counted[axis]) }
        };
        (0..window.output[axis]).map(reach).collect()
    })
}

/// Returns the inputs of each output of an image of size `from` that is cut into `to` parts, as in
/// [`AdaptivePool`](crate::adaptive_pool::AdaptivePool); one part is the whole.
pub fn parts(from: [usize; 3], to: [usize; 3]) -> [Vec<Reach>; 3] {
    [0, 1, 2].map(|axis| {
        let reach = |out: usize| {
            let part = part(from[axis], to[axis], out);
            Reach { from: part.start, to: part.end, count: part.len() }
        };
        (0..to[axis]).map(reach).collect()
    })
}

/// A pooling with its windows.
pub struct Pool {
    pooling: Pooling,
    from: ImagePlace,
    to: ImagePlace,
    axes: [Vec<Reach>; 3],
}

impl Pool {
    /// Makes the pooling of what lies at `from` into `to`; `axes` hold a reach per output, over depth, rows, columns.
    pub fn new(pooling: Pooling, axes: [Vec<Reach>; 3], from: ImagePlace, to: ImagePlace) -> Self {
        assert!(from.channels == to.channels, "{from:?} to {to:?}: the channels stay");
        for (axis, reaches) in axes.iter().enumerate() {
            assert!(reaches.len() == to.size[axis], "a reach per output is needed: {reaches:?}");
            let fits = |r: &Reach| r.from <= r.to && r.to <= from.size[axis] && r.count > 0;
            assert!(reaches.iter().all(fits), "reaches inside {from:?} are needed: {reaches:?}");
        }
        Pool { pooling, from, to, axes }
    }

    /// Computes every output from its window.
    pub fn run(&self, x: &[f32], y: &mut [f32]) {
        match self.pooling {
            Pooling::Max => max(self, x, y),
            Pooling::Mean => mean(self, x, y),
        }
    }
}

at_level! {
    fn max(pool: &Pool, x: &[f32], y: &mut [f32]) = max_at
}

/// Computes the largest value of every window with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn max_at<S: Simd>(pool: &Pool, x: &[f32], y: &mut [f32]) {
    // SAFETY: the caller has the features.
    unsafe { run_at::<S, true>(pool, x, y) }
}

at_level! {
    fn mean(pool: &Pool, x: &[f32], y: &mut [f32]) = mean_at
}

/// Computes the mean of every window with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn mean_at<S: Simd>(pool: &Pool, x: &[f32], y: &mut [f32]) {
    // SAFETY: the caller has the features.
    unsafe { run_at::<S, false>(pool, x, y) }
}

/// Computes the largest value of every window if `MAX`, else its mean, with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn run_at<S: Simd, const MAX: bool>(pool: &Pool, x: &[f32], y: &mut [f32]) {
    let Pool { from, to, axes: [depths, rows, columns], .. } = pool;
    at_least("input of a pooling", x.len(), from.end());
    at_least("output of a pooling", y.len(), to.end());
    for (d, depth) in depths.iter().enumerate() {
        for (r, row) in rows.iter().enumerate() {
            for (c, column) in columns.iter().enumerate() {
                let at = to.at([d, r, c]);
                let share = 1.0 / (depth.count * row.count * column.count) as f32;
                vectors!(S, to.channels, channel, n, {
                    // SAFETY: `new` asserts that reaches lie inside `from` and outputs inside `to`, whose ends the
                    // lengths are asserted to cover; `channel + n <= channels`.
                    unsafe {
                        let start = if MAX { f32::NEG_INFINITY } else { 0.0 };
                        let mut value = S::splat(start);
                        for id in depth.from..depth.to {
                            for ir in row.from..row.to {
                                let line = from.at([id, ir, column.from]) + channel;
                                for ic in 0..column.to - column.from {
                                    let x = load::<S>(x, line + ic * from.pitch[2], n);
                                    value = if MAX {
                                        S::where_beats(x, value, x, value)
                                    } else {
                                        S::add(value, x)
                                    };
                                }
                            }
                        }
                        let value = if MAX { value } else { S::mul(value, S::splat(share)) };
                        store::<S>(y, at + channel, n, value);
                    }
                });
            }
        }
    }
}
