//! Orders in which images and weights lie: channels first outside, channels last inside, and weights
//! turned round for the input gradient.

use crate::lengths::at_least;

/// Transposes x (rows × columns) into y (columns × rows), or adds it to y.
pub fn transpose(rows: usize, columns: usize, x: &[f32], y: &mut [f32], accumulate: bool) {
    const BLOCK: usize = 16;
    at_least("a matrix to transpose", x.len(), rows * columns);
    at_least("a transposed matrix", y.len(), rows * columns);
    for row in (0..rows).step_by(BLOCK) {
        for column in (0..columns).step_by(BLOCK) {
            for r in row..(row + BLOCK).min(rows) {
                for c in column..(column + BLOCK).min(columns) {
                    let value = x[r * columns + c];
                    let y = &mut y[c * rows + r];
                    *y = if accumulate { *y + value } else { value };
                }
            }
        }
    }
}

/// Brings convolution weights from PyTorch's order (filters × channels/groups × kernel) into this crate's (group ×
/// kernel × channels/groups × filters/groups; depthwise: kernel × filters).
pub fn weights_in(
    filters: usize,
    channels: usize,
    volume: usize,
    groups: usize,
    w: &[f32],
    inner: &mut [f32],
) {
    check(filters * channels * volume, w, inner);
    weights(filters, channels, volume, groups, |outer, at| inner[at] = w[outer]);
}

/// Brings convolution weights from this crate's order into PyTorch's: the way back of [`weights_in`].
pub fn weights_out(
    filters: usize,
    channels: usize,
    volume: usize,
    groups: usize,
    inner: &[f32],
    w: &mut [f32],
) {
    check(filters * channels * volume, w, inner);
    weights(filters, channels, volume, groups, |outer, at| w[outer] = inner[at]);
}

fn check(len: usize, outer: &[f32], inner: &[f32]) {
    at_least("weights in PyTorch's order", outer.len(), len);
    at_least("weights in this crate's order", inner.len(), len);
}

/// Calls `pair` with the index of every weight in PyTorch's order and in this crate's. `channels` are the input
/// channels of one group.
fn weights(
    filters: usize,
    channels: usize,
    volume: usize,
    groups: usize,
    mut pair: impl FnMut(usize, usize),
) {
    let out = filters / groups;
    if channels == 1 && out == 1 {
        for filter in 0..filters {
            (0..volume).for_each(|k| pair(filter * volume + k, k * filters + filter));
        }
        return;
    }
    for filter in 0..filters {
        let (group, o) = (filter / out, filter % out);
        for channel in 0..channels {
            for k in 0..volume {
                let outer = (filter * channels + channel) * volume + k;
                pair(outer, ((group * volume + k) * channels + channel) * out + o);
            }
        }
    }
}

/// Turns weights (group × kernel × channels in × channels out, each of one group) round: the kernel from its end,
/// channels in and out exchanged.
pub(crate) fn turn_round(
    groups: usize,
    volume: usize,
    [inner, out]: [usize; 2],
    weight: &[f32],
    turned: &mut [f32],
) {
    let block = inner * out;
    check_turned(groups * volume * block, weight, turned);
    for (i, from) in weight[..groups * volume * block].chunks_exact(block).enumerate() {
        let (group, k) = (i / volume, i % volume);
        let to = (group * volume + volume - 1 - k) * block;
        transpose(inner, out, from, &mut turned[to..to + block], false);
    }
}

/// Turns depthwise weights (kernel × channels) round.
pub(crate) fn turn_round_depthwise(volume: usize, channels: usize, weight: &[f32], turned: &mut [f32]) {
    let len = volume * channels;
    check_turned(len, weight, turned);
    let taps = weight[..len].chunks_exact(channels);
    for (to, from) in turned[..len].chunks_exact_mut(channels).rev().zip(taps) {
        to.copy_from_slice(from);
    }
}

fn check_turned(len: usize, weight: &[f32], turned: &[f32]) {
    at_least("weights to turn round", weight.len(), len);
    at_least("turned weights", turned.len(), len);
}
