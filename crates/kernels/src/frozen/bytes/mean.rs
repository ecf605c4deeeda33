//! Means over windows of bytes.

use crate::frozen::place::ImagePlace;
use crate::frozen::pool::Reach;
use crate::lengths::at_least;
use crate::rows::vectors;
use crate::simd::{Simd, at_level};
use crate::view::Rectifier;

use super::ByteScale;
use super::depthwise::EXACT;
use super::map::store_at;
use super::output::{ByteOutput, Ending, Target};

/// A mean with its windows.
pub struct Mean {
    from: ImagePlace,
    to: ImagePlace,
    axes: [Vec<Reach>; 3],
    scale: ByteScale,
    output: ByteOutput,
    ending: Ending,
}

impl Mean {
    /// Makes the means of what lies at `from` into `to`; `axes` hold a reach per output, over depth, rows, columns.
    pub fn new(
        axes: [Vec<Reach>; 3],
        (from, scale): (ImagePlace, ByteScale),
        (to, output): (ImagePlace, ByteOutput),
    ) -> Self {
        assert!(from.channels == to.channels, "{from:?} to {to:?}: the channels stay");
        for (axis, reaches) in axes.iter().enumerate() {
            assert!(reaches.len() == to.size[axis], "a reach per output is needed: {reaches:?}");
            let fits = |r: &Reach| r.from <= r.to && r.to <= from.size[axis] && r.count > 0;
            assert!(reaches.iter().all(fits), "reaches inside {from:?} are needed: {reaches:?}");
        }
        assert!(from.positions() * 255 < EXACT as usize, "smaller windows are needed: {from:?}");
        Mean { from, to, axes, scale, output, ending: output.ending(Rectifier::None) }
    }

    /// Returns factor and shift of a sum of `inside` bytes whose mean counts `count`: a stored number is an [`Ending`] of
    /// `factor · sum + shift`.
    pub fn coefficients(scale: ByteScale, output: ByteOutput, count: usize, inside: usize) -> (f32, f32) {
        let share = f64::from(scale.step) * output.steps() / count as f64;
        (share as f32, (-f64::from(scale.zero) * share * inside as f64) as f32)
    }

    /// Computes every output from its window.
    pub fn run(&self, x: &[u8], mut y: Target) {
        run(self, x, &mut y);
    }
}

at_level! {
    fn run(mean: &Mean, x: &[u8], y: &mut Target) = run_at
}

/// Computes [`Mean::run`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn run_at<S: Simd>(mean: &Mean, x: &[u8], y: &mut Target) {
    let Mean { from, to, axes: [depths, rows, columns], .. } = mean;
    at_least("input of a pooling", x.len(), from.end());
    at_least("output of a pooling", y.len(), to.end());
    assert!(y.fits(mean.output), "memory for {:?} is needed", mean.output);
    for (d, depth) in depths.iter().enumerate() {
        for (r, row) in rows.iter().enumerate() {
            for (c, column) in columns.iter().enumerate() {
                let at = to.at([d, r, c]);
                let count = depth.count * row.count * column.count;
                let inside = (depth.to - depth.from) * (row.to - row.from) * (column.to - column.from);
                let (factor, shift) = Mean::coefficients(mean.scale, mean.output, count, inside);
                vectors!(S, to.channels, channel, n, {
                    // SAFETY: `new` asserts that reaches lie inside `from` and outputs inside `to`, whose ends the
                    // lengths are asserted to cover; `channel + n <= channels`.
                    unsafe {
                        let mut sum = S::splat(0.0);
                        for id in depth.from..depth.to {
                            for ir in row.from..row.to {
                                let line = x.as_ptr().add(from.at([id, ir, column.from]) + channel);
                                for ic in 0..column.to - column.from {
                                    sum = S::add(sum, S::load_bytes(line.add(ic * from.pitch[2]), n));
                                }
                            }
                        }
                        let value = S::add(S::mul(sum, S::splat(factor)), S::splat(shift));
                        store_at::<S>(y, at + channel, n, value, &mean.ending);
                    }
                });
            }
        }
    }
}
