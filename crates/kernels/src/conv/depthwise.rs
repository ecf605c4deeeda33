//! Depthwise convolution: every channel has its own kernel, so vectors run along channels.
//!
//! Weights lie as kernel × channels.

use crate::lengths::{at_least, exactly, image};
use crate::rows::{load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::window::Window3;

use super::band::{Band, Padded};
use super::begin::Begin;
use super::sizes::ConvSizes;

/// Kernel sizes whose weights stay in registers.
const HELD: usize = 9;

/// Values of padded input that stay in a core's own cache, beside the outputs.
const BAND: usize = 1 << 17;

/// The plan of a depthwise convolution.
#[derive(Debug, Clone)]
pub(crate) struct Depthwise {
    sizes: ConvSizes,
    /// Positions of the taps from a window's first one, in the padded image.
    offsets: Vec<usize>,
    band_rows: usize,
}

/// A band as the loops see it.
struct Image<'a> {
    window: Window3,
    /// Size of its padded input.
    padded: [usize; 3],
    channels: usize,
    offsets: &'a [usize],
}

impl Depthwise {
    pub fn new(sizes: ConvSizes) -> Self {
        let Window3 { output, kernel, stride, .. } = sizes.window;
        let (padded, extent) = (sizes.reach(), sizes.extent());
        let offset = sizes.offsets(padded);
        let mut offsets = Vec::with_capacity(sizes.window.volume());
        for kd in 0..kernel[0] {
            for kr in 0..kernel[1] {
                offsets.extend((0..kernel[2]).map(|kc| offset([kd, kr, kc])));
            }
        }
        let row = padded[2] * sizes.channels;
        let cut = output[0] == 1 && extent[0] == 1 && padded[0] * padded[1] * row > BAND;
        let band_rows = if cut {
            ((BAND / row).saturating_sub(extent[1]) / stride[1] + 1).min(output[1])
        } else {
            output[1]
        };
        Depthwise { sizes, offsets, band_rows }
    }

    /// Returns the number of rows of outputs whose padded input stays in cache.
    pub fn band_rows(&self) -> usize {
        self.band_rows
    }

    fn image(&self, band: Band) -> Image<'_> {
        let ConvSizes { mut window, channels, .. } = self.sizes;
        let mut padded = self.sizes.reach();
        if band.rows < window.output[1] {
            // Only images of one depth are cut.
            padded = [1, band.under.1, padded[2]];
            window.output[1] = band.rows;
        }
        Image { window, padded, channels, offsets: &self.offsets }
    }

    /// Computes the outputs of a band.
    pub fn forward(&self, padded: Padded, weight: &[f32], begin: Begin, y: &mut [f32]) {
        at_least("output of a convolution", y.len(), self.sizes.y_len());
        let y = &mut y[self.sizes.outputs(&padded.band)];
        forward(&self.image(padded.band), padded.values, weight, begin, y);
    }

    /// Adds a band's gradient of the weights.
    pub fn backward_weight(&self, padded: Padded, dy: &[f32], dweight: &mut [f32]) {
        at_least("dy of a convolution", dy.len(), self.sizes.y_len());
        let dy = &dy[self.sizes.outputs(&padded.band)];
        backward_weight(&self.image(padded.band), padded.values, dy, dweight);
    }
}

impl Image<'_> {
    /// Returns a window's first position in the padded image.
    #[inline(always)]
    fn first(&self, position: usize) -> usize {
        let [d, r, c] = self.window.unravel(position);
        let (stride, padded) = (self.window.stride, self.padded);
        (d * stride[0] * padded[1] + r * stride[1]) * padded[2] + c * stride[2]
    }

    /// Asserts that padded input, weights and outputs (or their gradients) are as long as the loops need, and
    /// that the last tap of the last window, the furthest of all, lies inside the padded input.
    fn check(&self, x: &[f32], weight: &[f32], y: &[f32]) {
        let (positions, channels) = (self.window.output_len(), self.channels);
        at_least("padded input of a convolution", x.len(), image(self.padded, channels));
        at_least("weights of a convolution", weight.len(), self.offsets.len() * channels);
        at_least("outputs of a convolution", y.len(), positions * channels);
        let last = self.first(positions - 1) + self.offsets.iter().max().unwrap_or(&0);
        at_least("positions under windows", self.padded.iter().product(), last + 1);
    }
}

at_level! {
    /// Computes `y = conv(x)` of a padded image: plus a bias, or added to `y`, as `begin` says.
    fn forward(image: &Image, x: &[f32], weight: &[f32], begin: Begin, y: &mut [f32]) = forward_at
}

/// Computes [`forward`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn forward_at<S: Simd>(image: &Image, x: &[f32], weight: &[f32], begin: Begin, y: &mut [f32]) {
    let Image { channels, offsets, .. } = *image;
    image.check(x, weight, y);
    if let Begin::Bias(bias) = begin {
        exactly("bias of a convolution", bias.len(), channels);
    }
    let positions = image.window.output_len();
    let add = matches!(begin, Begin::Add);
    vectors!(S, channels, c, n, {
        // SAFETY: `c + n <= channels`, the asserted length of a bias. `check` has asserted that every tap of
        // every window lies inside `x`, and that `weight` and `y` hold a row of channels per tap and position.
        unsafe {
            let start = if let Begin::Bias(bias) = begin { load::<S>(bias, c, n) } else { S::splat(0.0) };
            let mut held = [S::splat(0.0); HELD];
            let few = offsets.len() == HELD;
            for (k, held) in held.iter_mut().enumerate().take(offsets.len()) {
                *held = load::<S>(weight, k * channels + c, n);
            }
            for position in 0..positions {
                let at = image.first(position) * channels + c;
                let to = position * channels + c;
                let mut sum = if add { S::add(start, load::<S>(y, to, n)) } else { start };
                if few {
                    for k in 0..HELD {
                        sum = S::fma(load::<S>(x, at + offsets[k] * channels, n), held[k], sum);
                    }
                } else {
                    for (k, offset) in offsets.iter().enumerate() {
                        let w = load::<S>(weight, k * channels + c, n);
                        sum = S::fma(load::<S>(x, at + offset * channels, n), w, sum);
                    }
                }
                store::<S>(y, to, n, sum);
            }
        }
    });
}

at_level! {
    /// Adds the gradient of the weights.
    fn backward_weight(image: &Image, x: &[f32], dy: &[f32], dweight: &mut [f32]) = backward_weight_at
}

/// Computes [`backward_weight`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn backward_weight_at<S: Simd>(image: &Image, x: &[f32], dy: &[f32], dweight: &mut [f32]) {
    let Image { channels, offsets, .. } = *image;
    image.check(x, dweight, dy);
    let positions = image.window.output_len();
    vectors!(S, channels, c, n, {
        // As many taps at a time as stay in registers.
        for (block, offsets) in offsets.chunks(HELD).enumerate() {
            // SAFETY: `c + n <= channels`. `check` has asserted that every tap of every window lies inside
            // `x`, and that `dweight` and `dy` hold a row of channels per tap and position.
            unsafe {
                let mut sums = [S::splat(0.0); HELD];
                for position in 0..positions {
                    let at = image.first(position) * channels + c;
                    let dy = load::<S>(dy, position * channels + c, n);
                    for (sum, offset) in sums.iter_mut().zip(offsets) {
                        *sum = S::fma(load::<S>(x, at + offset * channels, n), dy, *sum);
                    }
                }
                for (k, sum) in sums.iter().enumerate().take(offsets.len()) {
                    let to = (block * HELD + k) * channels + c;
                    store::<S>(dweight, to, n, S::add(load::<S>(dweight, to, n), *sum));
                }
            }
        }
    });
}

at_level! {
    /// Adds the gradient of the input, tap by tap; for strides above 1.
    pub(crate) fn scatter(sizes: &ConvSizes, dy: &[f32], weight: &[f32], dx: &mut [f32]) = scatter_at
}

/// Computes [`scatter`] with vectors of `S`.
///
/// # Safety
/// The CPU has the features of `S`.
#[inline(always)]
unsafe fn scatter_at<S: Simd>(sizes: &ConvSizes, dy: &[f32], weight: &[f32], dx: &mut [f32]) {
    let ConvSizes { window, dilation, channels, .. } = *sizes;
    at_least("dy of a convolution", dy.len(), image(window.output, channels));
    at_least("weights of a convolution", weight.len(), image(window.kernel, channels));
    at_least("dx of a convolution", dx.len(), image(window.input, channels));
    let Window3 { input, kernel, .. } = window;
    for position in 0..window.output_len() {
        let [d, r, c] = window.unravel(position);
        let (depths, first_d) = sizes.inside(0, d);
        let (rows, first_r) = sizes.inside(1, r);
        let (columns, first_c) = sizes.inside(2, c);
        let dy = &dy[position * channels..(position + 1) * channels];
        for kd in depths.clone() {
            for kr in rows.clone() {
                for kc in columns.clone() {
                    let k = (kd * kernel[1] + kr) * kernel[2] + kc;
                    let depth = first_d + (kd - depths.start) * dilation[0];
                    let line = depth * input[1] + first_r + (kr - rows.start) * dilation[1];
                    let at = (line * input[2] + first_c + (kc - columns.start) * dilation[2]) * channels;
                    let dx = &mut dx[at..at + channels];
                    let weight = &weight[k * channels..(k + 1) * channels];
                    vectors!(S, channels, c, n, {
                        // SAFETY: `c + n <= channels`, the length of the three rows, cut just above.
                        unsafe {
                            let product =
                                S::fma(load::<S>(dy, c, n), load::<S>(weight, c, n), load::<S>(dx, c, n));
                            store::<S>(dx, c, n, product);
                        }
                    });
                }
            }
        }
    }
}
