//! Faults over time.
//!
//! # Reference
//!
//! Hysteresis is measured as in data sheets of force sensors: the largest difference between
//! loading and unloading, in % of the peak. The curve that unloading takes is ours.

use crate::work::FaultySample;
use rand::RngExt;
use taxel_base::Layout;

/// Lets unloading read more than loading did, by `share` of the peak so far where it is most.
///
/// A reading `u` (of the peak so far, above rest) becomes `u (1 + c) / (1 + c u)`: nothing changes
/// at rest and at the peak, and between them the readings stay in order.
pub(crate) fn hysteresis(work: &mut FaultySample, share: f64) {
    // The curve is highest above u by (s - 1) / (s + 1), s being the root of 1 + c.
    let c = ((1.0 + share) / (1.0 - share)).powi(2) - 1.0;
    for element in 0..work.elements() {
        let rest = f64::from(work.rest(element));
        let mut peak = 0.0f64;
        for reading in work.x.row_mut(element) {
            let above = f64::from(*reading) - rest;
            peak = peak.max(above.abs());
            if above.abs() < peak {
                *reading = (rest + above * (1.0 + c) / (1.0 + c * above.abs() / peak)) as f32;
            }
        }
    }
}

/// Drops `share` of the frames, never the first; the last one that came is seen again instead.
/// Shares of less than one frame count as for dead channels.
pub(crate) fn jitter(work: &mut FaultySample, share: f64) {
    let times = work.times();
    let count = work.round(share * times as f64);
    let mut dropped = vec![false; times];
    for at in work.order(times - 1).into_iter().take(count) {
        dropped[at + 1] = true;
    }
    for element in 0..work.elements() {
        for time in (0..times).filter(|&t| dropped[t]) {
            work.x[[element, time]] = work.x[[element, time - 1]];
        }
    }
}

/// Starts the window `share` of its length late or early. What was never recorded is the first or
/// last reading, held.
pub(crate) fn onset(work: &mut FaultySample, share: f64) {
    let times = work.times();
    let count = work.round(share * times as f64) as isize;
    let late = count * work.sign() as isize;
    let clean = work.x.clone();
    for time in 0..times {
        let from = time.saturating_add_signed(late).min(times - 1);
        work.x.column_mut(time).assign(&clean.column(from));
    }
}

/// Delays one channel, finger or row of taxels by `share` of the window, as one that is read by another converter or
/// scanned late. Until its first reading arrives, that is held.
pub(crate) fn lag(work: &mut FaultySample, share: f64) {
    let late = match work.sensor.layout {
        Layout::Features | Layout::Series => vec![work.rng.random_range(0..work.elements())],
        _ => {
            let row = work.rng.random_range(0..work.rows);
            work.row(row)
        }
    };
    let times = work.times();
    let count = work.round(share * times as f64);
    for element in late {
        for time in (1..times).rev() {
            work.x[[element, time]] = work.x[[element, time.saturating_sub(count)]];
        }
    }
}
