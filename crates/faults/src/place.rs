//! The object lies elsewhere on the array.
//!
//! # Reference
//!
//! Bilinear sampling as `scipy.ndimage` does it (`order=1, mode="grid-constant"`).

use crate::work::FaultySample;

/// Moves the image by `taxels` up, down, left or right; rest values come in from outside.
pub(crate) fn shift(work: &mut FaultySample, taxels: isize) {
    let by = taxels * work.sign() as isize;
    let (down, right) = if work.sign() > 0.0 { (by, 0) } else { (0, by) };
    let clean = work.x.clone();
    for element in 0..work.elements() {
        let row = (element / work.columns).checked_add_signed(-down).filter(|&r| r < work.rows);
        let column = (element % work.columns).checked_add_signed(-right).filter(|&c| c < work.columns);
        match row.zip(column) {
            Some((row, column)) => work.x.row_mut(element).assign(&clean.row(row * work.columns + column)),
            None => work.kill(element),
        }
    }
}

/// Turns the image about its middle by `degrees`, one way or the other; rest values come in from
/// outside.
pub(crate) fn rotation(work: &mut FaultySample, degrees: f64) {
    let (sin, cos) = (degrees * work.sign()).to_radians().sin_cos();
    let middle = ((work.rows - 1) as f64 / 2.0, (work.columns - 1) as f64 / 2.0);
    let clean = work.x.clone();
    for element in 0..work.elements() {
        let (row, column) = (element / work.columns, element % work.columns);
        let (down, right) = (row as f64 - middle.0, column as f64 - middle.1);
        let from = (middle.0 + cos * down + sin * right, middle.1 - sin * down + cos * right);
        let (top, left) = (from.0.floor(), from.1.floor());
        let (below, beside) = (from.0 - top, from.1 - left);
        let mut blend = vec![0.0f64; work.times()];
        for (row, high) in [(top, 1.0 - below), (top + 1.0, below)] {
            for (column, wide) in [(left, 1.0 - beside), (left + 1.0, beside)] {
                let weight = high * wide;
                let inside =
                    (0.0..work.rows as f64).contains(&row) && (0.0..work.columns as f64).contains(&column);
                let rest = f64::from(work.rest(element));
                let source =
                    clean.row(if inside { row as usize * work.columns + column as usize } else { 0 });
                for (sum, &v) in blend.iter_mut().zip(source) {
                    *sum += weight * if inside { f64::from(v) } else { rest };
                }
            }
        }
        work.x.row_mut(element).iter_mut().zip(blend).for_each(|(v, sum)| *v = sum as f32);
    }
}
