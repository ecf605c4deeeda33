//! Convolutions with fewer products (Winograd; Lavin and Gray, "Fast Algorithms for Convolutional Neural
//! Networks", 2016).
//!
//! Input tiles and weights are transformed (`Bᵀ d`, `G g`), multiplied element by element and transformed
//! back (`Aᵀ m`). Summed over channels, the products are matrix products, one per element of the tile. The
//! weights' gradient is the same turned round: `Gᵀ [(Bᵀ d) ⊙ (A dy)]`. Infinity in a tile may come out as
//! NaN.

pub(crate) mod grid;
mod line;
mod square;
pub(crate) mod square_transforms;

use crate::conv::begin::Begin;
use crate::conv::sizes::ConvSizes;
use crate::window::Window3;

/// Channels and filters from which on squares pay.
const WIDE: usize = 16;
/// The same for squares of bf16, whose products take half as long.
pub(crate) const WIDE_PAIRED: usize = 32;
/// The same for lines, whose transforms are shorter.
const NARROW: usize = 8;

/// The plan of a convolution with fewer products.
#[derive(Debug, Clone)]
pub(crate) enum Winograd {
    Square(square::Square),
    Line(Box<line::WinogradLine>),
}

macro_rules! either {
    ($self:ident, $plan:ident => $call:expr) => {
        match $self {
            Winograd::Square($plan) => $call,
            Winograd::Line($plan) => $call,
        }
    };
}

impl Winograd {
    /// Makes the plan for an ungrouped convolution, where there is one; `paired` with products of bf16.
    pub fn new(sizes: &ConvSizes, paired: bool) -> Option<Self> {
        let ConvSizes { window, dilation, channels, filters, .. } = *sizes;
        let Window3 { output, kernel, stride, .. } = window;
        if stride != [1; 3] || dilation != [1; 3] {
            return None;
        }
        if kernel == [1, 3, 3] && output[0] == 1 {
            return Some(Winograd::Square(square::Square::new(
                [output[1], output[2]],
                channels,
                filters,
                paired,
            )));
        }
        if paired {
            // The factors of lines are up to 5 and 1/24, which bf16 is too coarse for.
            return None;
        }
        let axis = [1, 0].into_iter().find(|&axis| kernel[axis] == 3)?;
        Some(Winograd::Line(Box::new(line::WinogradLine::new(&window, axis, channels, filters))))
    }

    /// Checks whether its transforms cost less than the products that it saves.
    pub fn pays(sizes: &ConvSizes, paired: bool) -> bool {
        let ConvSizes { window, channels, filters, .. } = *sizes;
        let wide = if paired { WIDE_PAIRED } else { WIDE };
        if window.kernel != [1, 3, 3] {
            return channels.min(filters) >= NARROW;
        }
        // Weights that do not stay in cache are fetched for every image: it must have tiles for them.
        let tiles = window.output[1].div_ceil(2) * window.output[2].div_ceil(2);
        channels.min(filters) >= wide && (tiles >= 32 || channels * filters <= 128 * 128)
    }

    /// Returns the size of the input with the halo that the tiles cover.
    pub fn padded(&self, padded: [usize; 3]) -> [usize; 3] {
        either!(self, plan => plan.padded(padded))
    }

    /// Returns the number of values of the gradient of the transformed weights.
    pub fn weight_len(&self) -> usize {
        either!(self, plan => plan.weight_len())
    }

    /// Returns the number of packed weights.
    pub fn packed_len(&self) -> usize {
        match self {
            Winograd::Square(square) => square.packed_len(),
            Winograd::Line(line) => line.weight_len(),
        }
    }

    /// Returns the number of values of scratch for any pass.
    pub fn work_len(&self) -> usize {
        either!(self, plan => plan.work_len())
    }

    /// Computes the transformed weights: `u = G g`, for squares `u = G g Gᵀ`.
    pub fn pack(&self, weight: &[f32], u: &mut [f32]) {
        either!(self, plan => plan.pack(weight, u));
    }

    /// Adds `Gᵀ du` to the weights' gradient.
    pub fn unpack(&self, du: &[f32], dweight: &mut [f32]) {
        either!(self, plan => plan.unpack(du, dweight));
    }

    /// Computes `y` from a padded input and packed weights.
    pub fn forward(&self, padded: &[f32], u: &[f32], begin: Begin, y: &mut [f32], work: &mut [f32]) {
        either!(self, plan => plan.forward(padded, u, begin, y, work));
    }

    /// Adds one image's gradient to `du`, to be unpacked when all images are in.
    pub fn backward_weight(&self, padded: &[f32], dy: &[f32], du: &mut [f32], work: &mut [f32]) {
        either!(self, plan => plan.backward_weight(padded, dy, du, work));
    }
}
