//! Faults of amplifier and converter: each reading changes by itself.
//!
//! # Reference
//!
//! None; the definitions are ours.

use crate::work::FaultySample;
use rand::RngExt;
use rand_distr::StandardNormal;
use taxel_base::Layout;

/// Adds white noise of `share` of full scale (SD) to every reading.
pub(crate) fn noise(work: &mut FaultySample, share: f64) {
    let sd = share as f32 * work.sensor.span();
    for reading in &mut work.x {
        *reading += sd * work.rng.sample::<f32, _>(StandardNormal);
    }
}

/// Rounds to the `2^bits` levels of a converter over the whole range.
pub(crate) fn quantisation(work: &mut FaultySample, bits: f32) {
    let (low, high) = (f64::from(work.sensor.low), f64::from(work.sensor.high));
    let step = (high - low) / (f64::from(bits).exp2() - 1.0);
    work.x.mapv_inplace(|v| (low + ((f64::from(v) - low) / step).round() * step) as f32);
}

/// Adds a ramp from nothing at the first reading to `share` of full scale, up or down, at the last.
///
/// Every channel or finger goes its own way; an array as a whole. A single image is taken when the
/// ramp has ended.
pub(crate) fn drift(work: &mut FaultySample, share: f64) {
    let last = work.times() - 1;
    let has_time = work.sensor.layout.has_time() && last > 0;
    let ramp = |time: usize| if has_time { time as f64 / last as f64 } else { 1.0 };
    let ramp: Vec<f64> = (0..=last).map(ramp).collect();
    let end = share * f64::from(work.sensor.span());
    let mut sign = 0.0;
    for element in 0..work.elements() {
        let another = match work.sensor.layout {
            Layout::Features | Layout::Series => true,
            Layout::Fingers => element % work.columns == 0,
            Layout::Image | Layout::Colour | Layout::Sequence => element == 0,
        };
        if another {
            sign = work.sign();
        }
        let offset = ramp.iter().map(|r| (sign * r * end) as f32);
        work.x.row_mut(element).iter_mut().zip(offset).for_each(|(v, offset)| *v += offset);
    }
}

/// Multiplies what lies above rest by a gain in `1 - share ..= 1 + share`, uniform, of each
/// channel, finger or taxel.
pub(crate) fn gain(work: &mut FaultySample, share: f64) {
    let mut gain = 1.0;
    for element in 0..work.elements() {
        if work.sensor.layout != Layout::Fingers || element % work.columns == 0 {
            gain = (1.0 + share * work.rng.random_range(-1.0..=1.0)) as f32;
        }
        let rest = work.rest(element);
        work.x.row_mut(element).mapv_inplace(|v| rest + gain * (v - rest));
    }
}

/// Clips at `share` of the way from rest to either end of the range.
pub(crate) fn saturation(work: &mut FaultySample, share: f64) {
    let (low, high, share) = (work.sensor.low, work.sensor.high, share as f32);
    for element in 0..work.elements() {
        let rest = work.rest(element);
        let (low, high) = (rest - share * (rest - low), rest + share * (high - rest));
        work.x.row_mut(element).mapv_inplace(|v| v.clamp(low, high));
    }
}
