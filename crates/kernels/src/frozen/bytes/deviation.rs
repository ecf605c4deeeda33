//! Standard deviations of floats with the same bits on every processor.

use crate::frozen::place::ImagePlace;
use crate::lengths::at_least;

/// Channels that are computed together.
const WIDTH: usize = 16;

/// `√(mean((x − mean)²) + eps)` of every channel over all positions.
///
/// Sums run over the positions in order, and no product is fused into a sum: this is what C on a microcontroller can
/// repeat.
pub struct Deviation {
    from: ImagePlace,
    to: ImagePlace,
    eps: f32,
}

impl Deviation {
    /// Makes the deviations of what lies at `from`; `to` holds one position.
    pub fn new(eps: f32, from: ImagePlace, to: ImagePlace) -> Self {
        assert!(from.channels == to.channels && to.positions() == 1, "{from:?} to {to:?}: the channels stay");
        Deviation { from, to, eps }
    }

    /// Computes all channels.
    pub fn run(&self, x: &[f32], y: &mut [f32]) {
        let Deviation { from, to, eps } = self;
        at_least("input of a deviation", x.len(), from.end());
        at_least("output of a deviation", y.len(), to.end());
        let share = 1.0 / from.positions() as f32;
        for first in (0..from.channels).step_by(WIDTH) {
            let width = WIDTH.min(from.channels - first);
            let (mut means, mut squares) = ([0.0f32; WIDTH], [0.0f32; WIDTH]);
            self.each(x, first, width, |values| {
                means.iter_mut().zip(values).for_each(|(sum, x)| *sum += x);
            });
            means.iter_mut().for_each(|mean| *mean *= share);
            self.each(x, first, width, |values| {
                for ((sum, mean), x) in squares.iter_mut().zip(&means).zip(values) {
                    let apart = x - mean;
                    *sum += apart * apart;
                }
            });
            let y = &mut y[to.start + first..][..width];
            y.iter_mut().zip(&squares).for_each(|(y, sum)| *y = (sum * share + eps).sqrt());
        }
    }

    /// Runs `see` on `width` channels of every position, from channel `first` on.
    fn each(&self, x: &[f32], first: usize, width: usize, mut see: impl FnMut(&[f32])) {
        for row in self.from.rows() {
            for column in 0..self.from.size[2] {
                see(&x[row + column * self.from.pitch[2] + first..][..width]);
            }
        }
    }
}
