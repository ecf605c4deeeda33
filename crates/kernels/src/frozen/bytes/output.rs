//! The output of exact sums: bytes of another scale, or floats.

use crate::view::Rectifier;

use super::ByteScale;

/// As what outputs are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ByteOutput {
    /// As bytes of a scale.
    Bytes(ByteScale),
    /// As floats.
    Floats,
}

/// Memory that outputs go to.
pub enum Target<'a> {
    /// Bytes.
    Bytes(&'a mut [u8]),
    /// Floats.
    Floats(&'a mut [f32]),
}

/// How a float becomes what is stored: `clamp(x + zero, low, high)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ending {
    /// The number that is stored for 0.
    pub zero: f32,
    /// The least number that is stored.
    pub low: f32,
    /// The largest one.
    pub high: f32,
}

impl ByteOutput {
    /// Returns the number of steps of the output in one unit.
    pub fn steps(&self) -> f64 {
        match self {
            ByteOutput::Bytes(scale) => 1.0 / f64::from(scale.step),
            ByteOutput::Floats => 1.0,
        }
    }

    /// Returns the number of steps of the output in one `unit` of sums.
    pub fn factor(&self, unit: f32) -> f32 {
        (f64::from(unit) * self.steps()) as f32
    }

    /// Returns how a number of steps becomes what is stored.
    pub fn ending(&self, rectifier: Rectifier) -> Ending {
        let (zero, low, high) = match self {
            ByteOutput::Bytes(scale) => (f32::from(scale.zero), 0.0, 255.0),
            ByteOutput::Floats => (0.0, f32::NEG_INFINITY, f32::INFINITY),
        };
        let six = (zero + (6.0 * self.steps()) as f32).min(high);
        match rectifier {
            Rectifier::None => Ending { zero, low, high },
            Rectifier::Relu => Ending { zero, low: zero, high },
            Rectifier::Relu6 => Ending { zero, low: zero, high: six },
        }
    }
}

impl Target<'_> {
    /// Returns the number of values that there is room for.
    pub(super) fn len(&self) -> usize {
        match self {
            Target::Bytes(y) => y.len(),
            Target::Floats(y) => y.len(),
        }
    }

    /// Checks whether this is memory for `output`.
    pub(super) fn fits(&self, output: ByteOutput) -> bool {
        matches!(
            (self, output),
            (Target::Bytes(_), ByteOutput::Bytes(_)) | (Target::Floats(_), ByteOutput::Floats)
        )
    }

    /// Returns where the outputs from `at` on go; panics beyond the end.
    pub(super) fn at(&mut self, at: usize) -> Pointer {
        match self {
            Target::Bytes(y) => Pointer::Bytes(y[at..].as_mut_ptr()),
            Target::Floats(y) => Pointer::Floats(y[at..].as_mut_ptr()),
        }
    }
}

/// An address in a [`Target`].
#[derive(Clone, Copy)]
pub(super) enum Pointer {
    Bytes(*mut u8),
    Floats(*mut f32),
}
