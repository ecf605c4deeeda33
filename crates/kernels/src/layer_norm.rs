//! Layer normalisation of the features of one sample.
//!
//! Sums run in sixteen lanes whatever the processor has, so that every one gives the same bits.

use crate::lengths::exactly;

/// Sums that run side by side.
const LANES: usize = 16;

/// Adds up `term` over two slices of one length.
#[inline(always)]
fn sum(a: &[f32], b: &[f32], term: impl Fn(f32, f32) -> f32) -> f32 {
    let mut lanes = [0f32; LANES];
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a_chunks.remainder().iter().zip(b_chunks.remainder());
    for (a, b) in a_chunks.zip(b_chunks) {
        lanes.iter_mut().zip(a.iter().zip(b)).for_each(|(lane, (&a, &b))| *lane += term(a, b));
    }
    lanes.iter_mut().zip(rest).for_each(|(lane, (&a, &b))| *lane += term(a, b));
    let mut width = LANES;
    while width > 1 {
        width /= 2;
        for lane in 0..width {
            lanes[lane] += lanes[lane + width];
        }
    }
    lanes[0]
}

/// Computes `y = (x − mean) / √(var + eps) · weight + bias` over all values of x, and returns the mean and
/// `1 / √(var + eps)`, which [`backward`] needs.
pub fn forward(eps: f32, x: &[f32], weight: &[f32], bias: &[f32], y: &mut [f32]) -> [f32; 2] {
    exactly("weight of a layer norm", weight.len(), x.len());
    exactly("bias of a layer norm", bias.len(), x.len());
    exactly("output of a layer norm", y.len(), x.len());
    let share = 1.0 / x.len() as f32;
    let mean = sum(x, x, |x, _| x) * share;
    let variance = sum(x, x, |x, _| (x - mean) * (x - mean)) * share;
    let inverse = 1.0 / (variance + eps).sqrt();
    for ((y, x), (weight, bias)) in y.iter_mut().zip(x).zip(weight.iter().zip(bias)) {
        *y = (x - mean) * inverse * weight + bias;
    }
    [mean, inverse]
}

/// Writes to `dx`, or adds to it, the gradient of the input; `moments` come from [`forward`].
pub fn backward(
    [mean, inverse]: [f32; 2],
    x: &[f32],
    weight: &[f32],
    dy: &[f32],
    dx: &mut [f32],
    accumulate: bool,
) {
    exactly("weight of a layer norm", weight.len(), x.len());
    exactly("output gradient of a layer norm", dy.len(), x.len());
    exactly("input gradient of a layer norm", dx.len(), x.len());
    let share = 1.0 / x.len() as f32;
    let shift = sum(dy, weight, |dy, weight| dy * weight) * share;
    // Lanes as in `sum`, of three factors.
    let mut slope = [0f32; LANES];
    let terms = x.iter().zip(dy.iter().zip(weight));
    for (at, (x, (dy, weight))) in terms.enumerate() {
        slope[at % LANES] += dy * weight * (x - mean);
    }
    let slope = slope.iter().sum::<f32>() * share * inverse * inverse;
    for ((dx, x), (dy, weight)) in dx.iter_mut().zip(x).zip(dy.iter().zip(weight)) {
        let gradient = inverse * (dy * weight - shift - (x - mean) * slope);
        *dx = if accumulate { *dx + gradient } else { gradient };
    }
}

/// Adds the gradients of weight and bias; `moments` come from [`forward`].
pub fn add_gradients(
    [mean, inverse]: [f32; 2],
    x: &[f32],
    dy: &[f32],
    dweight: &mut [f32],
    dbias: &mut [f32],
) {
    exactly("output gradient of a layer norm", dy.len(), x.len());
    exactly("weight gradient of a layer norm", dweight.len(), x.len());
    exactly("bias gradient of a layer norm", dbias.len(), x.len());
    for ((dweight, dbias), (x, dy)) in dweight.iter_mut().zip(dbias).zip(x.iter().zip(dy)) {
        *dweight += dy * (x - mean) * inverse;
        *dbias += dy;
    }
}
