//! One direction of a convolution with its plan: the algorithm is chosen once, when it is made.

use crate::layout;
use crate::pointwise;
use crate::view::AffineView;
use crate::window::Window3;

use super::band::{Band, Padded};
use super::begin::Begin;
use super::depthwise::{self, Depthwise};
use super::direct::Direct;
use super::half::HalfDirect;
use super::halo::Halo;
use super::kind::ConvKind;
use super::scatter::scatter;
use super::sizes::ConvSizes;
use super::winograd::Winograd;

/// A convolution in one direction, with its plan.
#[derive(Debug, Clone)]
pub(crate) struct ConvPass {
    pub sizes: ConvSizes,
    halo: Halo,
    /// Rows of outputs that one band has at most.
    band_rows: usize,
    algorithm: Algorithm,
}

#[derive(Debug, Clone)]
enum Algorithm {
    /// Every product of the definition.
    Direct(Direct),
    /// The same where every channel is a group of its own.
    Depthwise(Depthwise),
    /// Fewer products, of floats or bf16, where kernels are 3 long and see many channels.
    Winograd(Winograd),
    /// Every product of the definition, of bf16.
    Half(Box<HalfDirect>),
}

impl Algorithm {
    fn choose(sizes: ConvSizes, fewer: bool, half: bool) -> Self {
        if sizes.is_depthwise() {
            return Algorithm::Depthwise(Depthwise::new(sizes));
        }
        if let Some(winograd) = (fewer && sizes.groups == 1).then(|| Winograd::new(&sizes, half)).flatten() {
            return Algorithm::Winograd(winograd);
        }
        match half.then(|| HalfDirect::new(sizes)).flatten() {
            Some(half) => Algorithm::Half(Box::new(half)),
            None => Algorithm::Direct(Direct::new(sizes)),
        }
    }
}

impl ConvPass {
    /// Makes the plan; with `fewer` products where the sizes allow, or with products of bf16.
    pub fn new(sizes: ConvSizes, fewer: bool, half: bool) -> Self {
        let algorithm = Algorithm::choose(sizes, fewer, half);
        let whole = (sizes.reach(), sizes.window.output[1]);
        let (padded, band_rows) = match &algorithm {
            Algorithm::Direct(_) | Algorithm::Half(_) => whole,
            Algorithm::Depthwise(depthwise) => (whole.0, depthwise.band_rows()),
            Algorithm::Winograd(winograd) => (winograd.padded(whole.0), whole.1),
        };
        ConvPass { sizes, halo: Halo::new(&sizes, padded), band_rows, algorithm }
    }

    pub fn kind(&self) -> ConvKind {
        match self.algorithm {
            Algorithm::Direct(_) | Algorithm::Half(_) => ConvKind::Direct,
            Algorithm::Depthwise(_) => ConvKind::Depthwise,
            Algorithm::Winograd(_) => ConvKind::Winograd,
        }
    }

    /// Returns the number of values of one padded image.
    pub fn padded_len(&self) -> usize {
        self.halo.len()
    }

    /// Returns the pieces in which it goes over an image.
    pub fn bands(&self) -> impl Iterator<Item = Band> + use<> {
        let (Window3 { output, stride, .. }, extent) = (self.sizes.window, self.sizes.extent());
        let (most, all) = (self.band_rows, self.halo.rows());
        (0..output[1]).step_by(most).map(move |from| {
            let rows = most.min(output[1] - from);
            let under = if most < output[1] {
                (from * stride[1], (rows - 1) * stride[1] + extent[1])
            } else {
                (0, all)
            };
            Band { from, rows, under }
        })
    }

    pub fn pad<'a>(&self, x: &'a [f32], view: &AffineView, band: Band, scratch: &'a mut [f32]) -> Padded<'a> {
        self.halo.pad(x, view, band, scratch)
    }

    /// Returns the number of packed weights: 0 where the weights are wanted as they are.
    pub fn packed_len(&self) -> usize {
        match &self.algorithm {
            Algorithm::Direct(_) | Algorithm::Depthwise(_) => 0,
            Algorithm::Winograd(winograd) => winograd.packed_len(),
            Algorithm::Half(half) => half.packed_len(),
        }
    }

    /// Fills `packed`, [`ConvPass::packed_len`] values.
    pub fn pack(&self, weight: &[f32], packed: &mut [f32]) {
        match &self.algorithm {
            Algorithm::Direct(_) | Algorithm::Depthwise(_) => {}
            Algorithm::Winograd(winograd) => winograd.pack(weight, packed),
            Algorithm::Half(half) => half.pack(weight, packed),
        }
    }

    /// Returns the number of values of scratch beside the padded image.
    pub fn work_len(&self) -> usize {
        match &self.algorithm {
            Algorithm::Direct(_) | Algorithm::Depthwise(_) => 0,
            Algorithm::Winograd(winograd) => winograd.work_len(),
            Algorithm::Half(half) => half.work_len(),
        }
    }

    /// Computes the outputs of a band. Reads `packed` in place of `weight` where there is any.
    pub fn forward(
        &self,
        padded: Padded,
        weight: &[f32],
        packed: &[f32],
        begin: Begin,
        y: &mut [f32],
        work: &mut [f32],
    ) {
        match &self.algorithm {
            Algorithm::Direct(direct) => direct.forward(padded.values, weight, begin, y),
            Algorithm::Depthwise(depthwise) => depthwise.forward(padded, weight, begin, y),
            Algorithm::Winograd(winograd) => winograd.forward(padded.values, packed, begin, y, work),
            Algorithm::Half(half) => half.forward(padded.values, packed, begin, y, work),
        }
    }

    /// Returns the number of sums of [`ConvPass::backward_weight`].
    pub fn sums_len(&self) -> usize {
        match &self.algorithm {
            Algorithm::Direct(_) | Algorithm::Depthwise(_) | Algorithm::Half(_) => self.sizes.weight_len(),
            Algorithm::Winograd(winograd) => winograd.weight_len(),
        }
    }

    /// Adds a band's weight gradient to `sums`.
    pub fn backward_weight(&self, padded: Padded, dy: &[f32], sums: &mut [f32], work: &mut [f32]) {
        match &self.algorithm {
            Algorithm::Direct(direct) => direct.backward_weight(padded.values, dy, sums),
            Algorithm::Depthwise(depthwise) => depthwise.backward_weight(padded, dy, sums),
            Algorithm::Winograd(winograd) => winograd.backward_weight(padded.values, dy, sums, work),
            Algorithm::Half(half) => half.backward_weight(padded.values, dy, sums, work),
        }
    }

    /// Adds the weight gradient that `sums` amount to.
    pub fn finish(&self, sums: &[f32], dweight: &mut [f32]) {
        match &self.algorithm {
            Algorithm::Direct(_) | Algorithm::Depthwise(_) | Algorithm::Half(_) => {
                pointwise::copy(&sums[..self.sizes.weight_len()], dweight, true);
            }
            Algorithm::Winograd(winograd) => winograd.unpack(sums, dweight),
        }
    }

    /// Writes the weights of the turned convolution, in the order of weights that are not packed.
    pub fn turn(&self, weight: &[f32], turned: &mut [f32]) {
        let ConvSizes { window, channels, groups, .. } = self.sizes;
        match &self.algorithm {
            Algorithm::Depthwise(_) => {
                layout::turn_round_depthwise(window.volume(), channels, weight, turned);
            }
            Algorithm::Direct(_) | Algorithm::Winograd(_) | Algorithm::Half(_) => {
                layout::turn_round(groups, window.volume(), self.sizes.of_group(), weight, turned);
            }
        }
    }

    /// Adds the input gradient window by window, where no convolution makes it.
    pub fn scatter(&self, dy: &[f32], weight: &[f32], dx: &mut [f32]) {
        match &self.algorithm {
            Algorithm::Depthwise(_) => {
                depthwise::scatter(&self.sizes, dy, weight, dx);
            }
            Algorithm::Direct(_) | Algorithm::Winograd(_) => scatter(&self.sizes, false, dy, weight, dx),
            Algorithm::Half(_) => scatter(&self.sizes, true, dy, weight, dx),
        }
    }
}
