//! How a stream is answered.

use taxel_data::Padding;

/// How a stream is answered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// Readings from one window to the next, from 1. Default a quarter of a window, at least 1.
    pub hop: Option<usize>,
    /// Whether windows begin with contact.
    pub contact: bool,
    /// Readings of a window before the one that contact begins with. Default 0; where the model looks for contact itself,
    /// half of what it can leave out.
    pub before: Option<usize>,
    /// The probability, above 0 and at most 1, at which a window is decided before it is full.
    pub early: Option<f32>,
    /// Readings that a window has at least before it is decided early. Default a tenth of a window, the least that reports
    /// measure.
    pub least: Option<usize>,
    /// What a window is filled up with that is decided early. Default as the model's own length rule does, else its last reading.
    pub padding: Option<Padding>,
    /// The largest possible reading. Default what the model's card says.
    pub full_scale: Option<f32>,
}
