//! Convolution over up to three spatial axes, one image at a time.
//!
//! There are three algorithms: every product of the definition (`direct`), the same where every channel is a
//! group of its own (`depthwise`), and fewer products for kernels that are 3 long and see many channels
//! (`winograd`). A convolution chooses when it is made (`pass`). All read the input inside a halo of zeros.
//! With a stride of 1 the input gradient is the same convolution with the kernel turned round.
//!
//! Weights lie as group × kernel × channels in × channels out; depthwise as kernel × channels.

mod band;
mod begin;
mod depthwise;
mod direct;
mod half;
mod halo;
mod kind;
mod pass;
mod scatter;
mod sizes;
pub(crate) mod winograd;

pub use band::{Band, Padded};
pub use kind::ConvKind;

pub(crate) use begin::Begin;

use pass::ConvPass;
use sizes::ConvSizes;
use winograd::Winograd;

use crate::lengths::{at_least, exactly};
use crate::reduce;
use crate::view::AffineView;
use crate::window::Window3;

/// A convolution with its plan.
#[derive(Debug, Clone)]
pub struct Conv {
    /// Outputs, and the weights' gradient.
    forward: ConvPass,
    /// The input gradient as a convolution, where it is one.
    turned: Option<ConvPass>,
}

impl Conv {
    /// Makes a convolution of `channels` into `filters`; `groups` divides both.
    pub fn new(window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        Self::dilated(window, [1; 3], channels, filters, groups)
    }

    /// Makes a convolution as [`Conv::new`] does, with a kernel whose values meet inputs `dilation` apart; the window's
    /// outputs are counted with them.
    pub fn dilated(
        window: Window3,
        dilation: [usize; 3],
        channels: usize,
        filters: usize,
        groups: usize,
    ) -> Self {
        let sizes = ConvSizes::new(window, dilation, channels, filters, groups);
        Self::with(sizes, Winograd::pays(&sizes, false), false)
    }

    /// Makes a convolution as [`Conv::dilated`] does, with products of bf16 and sums of floats. Depthwise ones, and
    /// groups of an odd number of channels, stay as they are. Panics where [`crate::half::supported`] is an error.
    pub fn half(
        window: Window3,
        dilation: [usize; 3],
        channels: usize,
        filters: usize,
        groups: usize,
    ) -> Self {
        crate::half::assert_supported();
        let sizes = ConvSizes::new(window, dilation, channels, filters, groups);
        Self::with(sizes, Winograd::pays(&sizes, true), true)
    }

    /// Makes a convolution by the definition's products, whatever the sizes.
    pub fn direct(window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        Self::with(ConvSizes::new(window, [1; 3], channels, filters, groups), false, false)
    }

    /// Makes a convolution with fewer products wherever the window allows, even where that does not pay.
    pub fn winograd(window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        Self::with(ConvSizes::new(window, [1; 3], channels, filters, groups), true, false)
    }

    /// Makes a convolution as [`Conv::winograd`] does, with products of bf16 where it is [`Conv::half`]'s square of 3 × 3. Panics where
    /// [`crate::half::supported`] is an error.
    pub fn half_winograd(window: Window3, channels: usize, filters: usize, groups: usize) -> Self {
        crate::half::assert_supported();
        Self::with(ConvSizes::new(window, [1; 3], channels, filters, groups), true, true)
    }

    fn with(sizes: ConvSizes, fewer: bool, half: bool) -> Self {
        let turned = sizes.turned().map(|turned| ConvPass::new(turned, fewer, half));
        Conv { forward: ConvPass::new(sizes, fewer, half), turned }
    }

    /// Returns the algorithm that was chosen.
    pub fn kind(&self) -> ConvKind {
        self.forward.kind()
    }

    /// Returns the number of values of one input image.
    pub fn x_len(&self) -> usize {
        self.forward.sizes.x_len()
    }

    /// Returns the number of values of one output image.
    pub fn y_len(&self) -> usize {
        self.forward.sizes.y_len()
    }

    /// Returns the number of weights.
    pub fn weight_len(&self) -> usize {
        self.forward.sizes.weight_len()
    }

    /// Returns the number of multiply–accumulates of one image.
    pub fn macs(&self) -> usize {
        self.forward.sizes.window.output_len() * self.weight_len()
    }

    /// Returns the number of values of one input image with its halo: the most that [`Conv::pad`] fills.
    pub fn padded_len(&self) -> usize {
        self.forward.padded_len()
    }

    /// Returns the pieces in which passes over an image go best: kernels with few products per value wait for memory
    /// where the padded image does not stay in cache.
    pub fn bands(&self) -> impl Iterator<Item = Band> + use<> {
        self.forward.bands()
    }

    /// Returns the input of a band as the kernel reads it: seen through `view`, with a halo of zeros. Borrows `x`
    /// itself where that is the same.
    pub fn pad<'a>(&self, x: &'a [f32], view: &AffineView, band: Band, scratch: &'a mut [f32]) -> Padded<'a> {
        self.forward.pad(x, view, band, scratch)
    }

    /// Packs weights as [`Conv::forward`] wants them; leaves `packed` empty where it wants them as they are.
    pub fn pack(&self, weight: &[f32], packed: &mut Vec<f32>) {
        at_least("weights of a convolution", weight.len(), self.weight_len());
        packed.clear();
        packed.resize(self.forward.packed_len(), 0.0);
        self.forward.pack(weight, packed);
    }

    /// Returns the number of values of scratch that the passes need besides [`Conv::padded_len`].
    pub fn work_len(&self) -> usize {
        self.forward.work_len()
    }

    /// Computes `y = conv(x) + bias` of a band; `padded` comes from [`Conv::pad`], `packed` from [`Conv::pack`].
    pub fn forward(
        &self,
        padded: Padded,
        weight: &[f32],
        packed: &[f32],
        bias: Option<&[f32]>,
        y: &mut [f32],
        work: &mut [f32],
    ) {
        self.forward.forward(padded, weight, packed, bias.map_or(Begin::Zero, Begin::Bias), y, work);
    }

    /// Turns weights round as [`Conv::backward_input`] wants them, channels in and out exchanged. Leaves `turned`
    /// empty where it wants them as they are.
    pub fn turn(&self, weight: &[f32], turned: &mut Vec<f32>) {
        at_least("weights of a convolution", weight.len(), self.weight_len());
        turned.clear();
        let Some(pass) = &self.turned else { return };
        turned.resize(pass.packed_len() + self.weight_len(), 0.0);
        let (packed, turned) = turned.split_at_mut(pass.packed_len());
        self.forward.turn(weight, turned);
        pass.pack(turned, packed);
    }

    /// Returns the number of values of scratch that [`Conv::backward_input`] needs.
    pub fn backward_len(&self) -> usize {
        self.turned.as_ref().map_or(0, |pass| pass.padded_len() + pass.work_len())
    }

    /// Computes the gradient of the input as it was seen, written to or added to `dx`; `turned` comes from
    /// [`Conv::turn`].
    pub fn backward_input(
        &self,
        dy: &[f32],
        weight: &[f32],
        turned: &[f32],
        scratch: &mut [f32],
        dx: &mut [f32],
        accumulate: bool,
    ) {
        at_least("dy of a convolution", dy.len(), self.y_len());
        at_least("dx of a convolution", dx.len(), self.x_len());
        at_least("scratch for an input gradient", scratch.len(), self.backward_len());
        let dx = &mut dx[..self.x_len()];
        let Some(pass) = &self.turned else {
            if !accumulate {
                dx.fill(0.0);
            }
            return self.forward.scatter(dy, weight, dx);
        };
        let (scratch, work) = scratch.split_at_mut(pass.padded_len());
        let begin = if accumulate { Begin::Add } else { Begin::Zero };
        for band in pass.bands() {
            let padded = pass.pad(dy, &AffineView::default(), band, scratch);
            // What is packed lies in front, where there is any.
            pass.forward(padded, turned, turned, begin, dx, work);
        }
    }

    /// Returns the number of sums that [`Conv::backward_weight`] adds to, without the bias.
    pub fn sums_len(&self) -> usize {
        self.forward.sums_len()
    }

    /// Adds the gradient of the weights, from the sums over all images.
    pub fn finish(&self, sums: &[f32], dweight: &mut [f32]) {
        at_least("sums of a convolution", sums.len(), self.sums_len());
        exactly("weight gradient of a convolution", dweight.len(), self.weight_len());
        self.forward.finish(sums, dweight);
    }

    /// Adds the gradients of weights (to `sums`, see [`Conv::finish`]) and bias of a band; `padded` comes
    /// from [`Conv::pad`].
    pub fn backward_weight(
        &self,
        padded: Padded,
        dy: &[f32],
        sums: &mut [f32],
        dbias: Option<&mut [f32]>,
        work: &mut [f32],
    ) {
        let sizes = &self.forward.sizes;
        at_least("dy of a convolution", dy.len(), sizes.y_len());
        if let Some(dbias) = dbias {
            reduce::add_columns(sizes.filters, &dy[sizes.outputs(&padded.band)], dbias);
        }
        self.forward.backward_weight(padded, dy, sums, work);
    }
}
