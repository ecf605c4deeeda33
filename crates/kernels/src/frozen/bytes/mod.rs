//! Frozen networks in eight bits: values are bytes, weights are signed bytes, and sums are 32-bit integers.
//!
//! A value is `step · (byte − zero)`, weights are symmetric around 0. Sums are exact and everything that follows rounds
//! in the same way, so that all widths of vectors give the same bytes. Sums of bytes alone
//! ([`Depthwise`], means) go through floats where those are exact: below 2²⁴.

mod add;
#[cfg(target_arch = "aarch64")]
mod arm;
mod buffer;
mod conv;
mod depthwise;
mod deviation;
mod dot;
mod map;
mod mean;
mod moved;
mod output;
mod tile;

pub use add::Add;
pub use buffer::Bytes;
pub use conv::{Conv, Sums};
pub use depthwise::{Depthwise, EXACT};
pub use deviation::Deviation;
pub use dot::Width;
pub use map::{Map, SourceValues};
pub use mean::Mean;
pub use moved::{max, shuffle};
pub use output::{ByteOutput, Ending, Target};

/// How numbers are written in bytes: `step · (byte − zero)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ByteScale {
    /// Distance of neighbouring numbers, above 0.
    pub step: f32,
    /// The byte that means 0.
    pub zero: u8,
}

impl ByteScale {
    /// Returns the finest scale that reaches from `low` to `high`, and has 0.
    pub fn over(low: f32, high: f32) -> Self {
        let (low, high) = (low.min(0.0), high.max(0.0));
        let step = (high - low) / 255.0;
        if !step.is_normal() {
            return ByteScale { step: 1.0, zero: 0 };
        }
        ByteScale { step, zero: (-low / step).round_ties_even() as u8 }
    }
}
