//! The gradient of stored values from the gradient of what was seen of them.

use crate::fold::Fold;
use crate::lengths::{exactly, whole_rows};
use crate::rows::{block, load, store, vectors};
use crate::simd::{Simd, at_level};
use crate::view::{AffineView, Rectifier, rectified_gradient};
use crate::{activation, pointwise};

/// Coefficients of a batch norm's input gradient: `dx = a · dy + b · (x − mean) + c` per channel.
#[derive(Debug, Clone, Default)]
pub struct InputGradient {
    /// Factor of `dy`.
    pub dy: Vec<f32>,
    /// Factor of `x − mean`.
    pub x: Vec<f32>,
    /// Batch mean.
    pub mean: Vec<f32>,
    /// Constant.
    pub constant: Vec<f32>,
}

/// [`InputGradient`] where it lies.
struct InputGradientView<'a> {
    dy: &'a [f32],
    x: &'a [f32],
    mean: &'a [f32],
    constant: &'a [f32],
}

/// Writes the gradient of stored values `x` (rows × channels) or adds it, from the gradient `dy` of their view.
/// `norm` holds the coefficients of the view's batch norm. It is given if and only if the view has scale and shift.
pub fn backward(
    channels: usize,
    x: &[f32],
    view: &AffineView,
    norm: Option<&InputGradient>,
    dy: &[f32],
    dx: &mut [f32],
    accumulate: bool,
) {
    whole_rows("stored values", x.len(), channels);
    exactly("dy of stored values", dy.len(), x.len());
    exactly("dx of stored values", dx.len(), x.len());
    assert!(
        view.affine.is_some() == norm.is_some(),
        "scale and shift of a view are needed together with the gradient of its batch norm"
    );
    match (view.affine, norm) {
        (Some((scale, shift)), Some(norm)) => {
            let mut rest = 0;
            if let Some(fold) = Fold::new(channels) {
                rest = fold.whole(x.len());
                let wide = InputGradientView {
                    dy: &fold.repeat(&norm.dy),
                    x: &fold.repeat(&norm.x),
                    mean: &fold.repeat(&norm.mean),
                    constant: &fold.repeat(&norm.constant),
                };
                let (scale, shift) = (fold.repeat(scale), fold.repeat(shift));
                let (x, dy, dx) = (&x[..rest], &dy[..rest], &mut dx[..rest]);
                through_norm(fold.channels(), x, &scale, &shift, view.rectifier, &wide, dy, dx, accumulate);
            }
            let norm =
                InputGradientView { dy: &norm.dy, x: &norm.x, mean: &norm.mean, constant: &norm.constant };
            let (x, dy, dx) = (&x[rest..], &dy[rest..], &mut dx[rest..]);
            through_norm(channels, x, scale, shift, view.rectifier, &norm, dy, dx, accumulate);
        }
        _ => match view.rectifier {
            Rectifier::None => pointwise::copy(dy, dx, accumulate),
            Rectifier::Relu => activation::relu_backward(x, dy, dx, accumulate),
            Rectifier::Relu6 => activation::relu6_backward(x, dy, dx, accumulate),
        },
    }
}

at_level! {
    fn through_norm(
        channels: usize, x: &[f32], scale: &[f32], shift: &[f32], rectifier: Rectifier, norm: &InputGradientView,
        dy: &[f32], dx: &mut [f32], accumulate: bool,
    ) = through_norm_at
}

/// Takes `dy` back through a view with batch norm, with vectors of `S`: the gradient is written to or added to `dx`.
///
/// # Safety
/// The CPU has the features of `S`.
#[allow(clippy::too_many_arguments)]
#[inline(always)]
unsafe fn through_norm_at<S: Simd>(
    channels: usize,
    x: &[f32],
    scale: &[f32],
    shift: &[f32],
    rectifier: Rectifier,
    norm: &InputGradientView,
    dy: &[f32],
    dx: &mut [f32],
    accumulate: bool,
) {
    let coefficients =
        [scale.len(), shift.len(), norm.dy.len(), norm.x.len(), norm.mean.len(), norm.constant.len()];
    assert!(
        coefficients.iter().all(|len| *len == channels),
        "coefficients of {channels} channels are needed"
    );
    let block = block(channels);
    let blocks = x.chunks(block).zip(dy.chunks(block));
    for (dx, (x, dy)) in dx.chunks_mut(block).zip(blocks) {
        // Channel by channel, so that the coefficients stay in registers.
        vectors!(S, channels, c, n, {
            // SAFETY: `c + n <= channels`: the asserted length of every coefficient, and that of every row
            // that `chunks_exact` gives.
            unsafe {
                let (scale, shift) = (load::<S>(scale, c, n), load::<S>(shift, c, n));
                let (of_dy, of_x) = (load::<S>(norm.dy, c, n), load::<S>(norm.x, c, n));
                let (mean, constant) = (load::<S>(norm.mean, c, n), load::<S>(norm.constant, c, n));
                let rows = x.chunks_exact(channels).zip(dy.chunks_exact(channels));
                for (dx, (x, dy)) in dx.chunks_exact_mut(channels).zip(rows) {
                    let (x, dy) = (load::<S>(x, c, n), load::<S>(dy, c, n));
                    let dy = rectified_gradient::<S>(rectifier, S::fma(x, scale, shift), dy);
                    let mut value = S::fma(dy, of_dy, S::fma(S::sub(x, mean), of_x, constant));
                    if accumulate {
                        value = S::add(value, load::<S>(dx, c, n));
                    }
                    store::<S>(dx, c, n, value);
                }
            }
        });
    }
}
