//! Convolution of bf16 between two places.

use crate::frozen::conv::{self, margins};
use crate::frozen::place::{ImagePlace, Route};
use crate::half::{assert_supported, pair_columns_of_rows, pair_rows};
use crate::lengths::{at_least, exactly};
use crate::window::Window3;

/// A convolution with its weights in bf16: each output has the bits of [`crate::conv::Conv::half`].
pub struct Conv {
    from: ImagePlace,
    /// Columns of zeros that become pairs, too.
    margin: [usize; 2],
    work_len: usize,
    pairs: conv::Conv,
}

impl Conv {
    /// Checks whether pairs of channels do not cross the edge of a group, and are more than single channels.
    pub fn takes(channels: usize, groups: usize) -> bool {
        let inner = channels / groups;
        inner > 1 && (groups == 1 || inner.is_multiple_of(2))
    }

    /// Makes a convolution along `route`, as [`frozen::Conv::new`](crate::frozen::Conv::new) does of floats; weights are rounded
    /// here. Channels are such as [`Conv::takes`].
    pub fn new(
        window: &Window3,
        dilation: [usize; 3],
        groups: usize,
        weight: &[f32],
        bias: &[f32],
        route: Route,
    ) -> Self {
        assert_supported();
        let Route { from, to, .. } = route;
        assert!(
            Self::takes(from.channels, groups),
            "pairs of channels are needed: {groups} groups of {from:?}"
        );
        let margin = margins(window, dilation);
        assert!((0..2).all(|a| margin[a] <= from.margin[a]), "margins of {margin:?} are needed: {from:?}");
        let left = margin[0].saturating_mul(from.pitch[2]);
        assert!(left <= from.start, "{left} values are needed before the first: {from:?}");
        let (inner, out) = (from.channels / groups, to.channels / groups);
        exactly("weights of a convolution", weight.len(), window.volume() * inner * to.channels);
        let half = inner.div_ceil(2);
        let mut packed = vec![0.0; window.volume() * half * to.channels];
        for (from, to) in weight.chunks_exact(inner * out).zip(packed.chunks_exact_mut(half * out)) {
            pair_rows(inner, out, out, from, to);
        }
        let place = ImagePlace::new(from.size, groups * half, margin, groups * half, 0);
        let route = Route { from: place, ..route };
        let pairs = conv::Conv::paired(window, dilation, groups, &packed, bias, route);
        // One long stretch is rounded faster than many short ones.
        let from = from.line().filter(|_| margin == [0; 2]).unwrap_or(from);
        Conv { from, margin, work_len: place.buffer_len(), pairs }
    }

    /// Returns the number of values of scratch that [`Conv::run`] needs.
    pub fn work_len(&self) -> usize {
        self.work_len
    }

    /// Computes `y = rectifier(conv(x) + bias + addend)`.
    pub fn run(&self, x: &[f32], addend: Option<&[f32]>, work: &mut [f32], y: &mut [f32]) {
        at_least("scratch of a frozen convolution", work.len(), self.work_len);
        let work = &mut work[..self.work_len];
        let ImagePlace { size, channels, pitch, .. } = self.from;
        let columns = self.margin[0] + size[2] + self.margin[1];
        let left = self.margin[0] * pitch[2];
        let rows = work.chunks_exact_mut(columns * channels.div_ceil(2));
        for (at, pairs) in self.from.rows().zip(rows) {
            let x = x.get(at - left..).unwrap_or_default();
            pair_columns_of_rows(channels, pitch[2], x, pairs);
        }
        self.pairs.run(work, addend, y);
    }
}
