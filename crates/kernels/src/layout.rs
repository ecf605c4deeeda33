//! Between the outside order (channels first) and the inside order (channels last).

/// x (rows × columns) → y (columns × rows), or added to y.
pub fn transpose(rows: usize, columns: usize, x: &[f32], y: &mut [f32], accumulate: bool) {
    const BLOCK: usize = 16;
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

/// Convolution weights from PyTorch's order (filters × channels/groups × kernel) to this crate's
/// (group × kernel × channels/groups × filters/groups; depthwise: kernel × filters).
pub fn weights_in(
    filters: usize,
    channels: usize,
    volume: usize,
    groups: usize,
    w: &[f32],
    inner: &mut [f32],
) {
    weights(filters, channels, volume, groups, |outer, at| inner[at] = w[outer]);
}

/// The way back of [`weights_in`].
pub fn weights_out(
    filters: usize,
    channels: usize,
    volume: usize,
    groups: usize,
    inner: &[f32],
    w: &mut [f32],
) {
    weights(filters, channels, volume, groups, |outer, at| w[outer] = inner[at]);
}

/// `channels` are the input channels of one group.
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
