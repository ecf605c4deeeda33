//! Bytes that stay in their scale: the largest of a window, shuffled channels.

use crate::frozen::place::ImagePlace;
use crate::frozen::pool::Reach;

/// Writes the largest byte of every window; `axes` hold a reach per output, over depth, rows, columns, which has an
/// input.
pub fn max(
    [depths, rows, columns]: &[Vec<Reach>; 3],
    from: &ImagePlace,
    x: &[u8],
    to: &ImagePlace,
    y: &mut [u8],
) {
    let channels = to.channels;
    for (d, depth) in depths.iter().enumerate() {
        for (r, row) in rows.iter().enumerate() {
            for (c, column) in columns.iter().enumerate() {
                let y = &mut y[to.at([d, r, c])..][..channels];
                y.fill(0);
                for id in depth.from..depth.to {
                    for ir in row.from..row.to {
                        for ic in column.from..column.to {
                            let x = &x[from.at([id, ir, ic])..][..channels];
                            y.iter_mut().zip(x).for_each(|(y, x)| *y = (*y).max(*x));
                        }
                    }
                }
            }
        }
    }
}

/// Shuffles the channels of so many groups.
pub fn shuffle(groups: usize, from: &ImagePlace, x: &[u8], to: &ImagePlace, y: &mut [u8]) {
    let (channels, each) = (to.channels, to.channels / groups);
    for (from_row, to_row) in from.rows().zip(to.rows()) {
        for column in 0..to.size[2] {
            let x = &x[from_row + column * from.pitch[2]..][..channels];
            let y = &mut y[to_row + column * to.pitch[2]..][..channels];
            for (g, x) in x.chunks_exact(each).enumerate() {
                y[g..].iter_mut().step_by(groups).zip(x).for_each(|(y, x)| *y = *x);
            }
        }
    }
}
