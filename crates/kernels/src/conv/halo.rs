//! The input of a convolution with its halo of zeros.

use crate::lengths::{at_least, image};
use crate::view::AffineView;
use crate::window::Window3;

use super::band::{Band, Padded};
use super::sizes::ConvSizes;

/// How an input image lies in its halo.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Halo {
    input: [usize; 3],
    before: [usize; 3],
    /// Size of the input with its halo.
    padded: [usize; 3],
    channels: usize,
}

impl Halo {
    pub fn new(sizes: &ConvSizes, padded: [usize; 3]) -> Self {
        let Window3 { input, before, .. } = sizes.window;
        // Asserts that the length fits.
        image(padded, sizes.channels);
        Halo { input, before, padded, channels: sizes.channels }
    }

    /// Returns the number of values of the whole padded image.
    pub fn len(&self) -> usize {
        self.padded.iter().product::<usize>() * self.channels
    }

    /// Returns the number of rows of the padded image, over all depths.
    pub fn rows(&self) -> usize {
        self.padded[0] * self.padded[1]
    }

    /// Returns the input of a band, seen through `view`, with its halo; `x` itself where that is the same.
    pub fn pad<'a>(&self, x: &'a [f32], view: &AffineView, band: Band, scratch: &'a mut [f32]) -> Padded<'a> {
        let Halo { input, before, channels: c, .. } = *self;
        let x_len = input.iter().product::<usize>() * c;
        at_least("input of a convolution", x.len(), x_len);
        let x = &x[..x_len];
        let row_len = self.padded[2] * c;
        let (first, count) = band.under;
        if view.is_plain() && self.padded == input && before == [0; 3] {
            return Padded { values: &x[first * row_len..(first + count) * row_len], band };
        }
        at_least("scratch for a padded input", scratch.len(), count * row_len);
        let scratch = &mut scratch[..count * row_len];
        // Columns of the input that windows reach; a stride may leave some out at the end.
        let left = before[2].min(self.padded[2]);
        let kept = input[2].min(self.padded[2] - left);
        let lines = scratch.chunks_exact_mut(row_len);
        for (line, to) in (first..).zip(lines) {
            let (d, r) = (line / self.padded[1], line % self.padded[1]);
            let from = d.checked_sub(before[0]).zip(r.checked_sub(before[1]));
            match from.filter(|&(d, r)| d < input[0] && r < input[1]) {
                Some((d, r)) => {
                    let from = (d * input[1] + r) * input[2] * c;
                    to[..left * c].fill(0.0);
                    view.apply(c, &x[from..from + kept * c], &mut to[left * c..(left + kept) * c]);
                    to[(left + kept) * c..].fill(0.0);
                }
                None => to.fill(0.0),
            }
        }
        Padded { values: scratch, band }
    }
}
