//! The options of a stream.

use taxel_data::Padding;

/// When windows of a stream begin and are decided.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StreamOptions {
    /// Time steps from one window to the next, from 1. Default a quarter of a window, at least 1.
    pub hop: Option<usize>,
    /// Whether windows begin with contact.
    pub contact: bool,
    /// Time steps of a window before the one that contact begins with. Default 0; where the model looks for contact itself,
    /// half of what it can leave out.
    pub before: Option<usize>,
    /// The probability, above 0 and at most 1, at which a window is decided before it is full. A calibrated model waits for
    /// more where its run says that early decisions would be right less often than this.
    pub early: Option<f32>,
    /// The familiarity, 0..1, up to which a window is unknown to the model; 0 for none. Default 0.
    pub unknown: f32,
    /// Share of windows, 0.8, 0.9, 0.95 or 0.99, whose intervals are to hold the true values. Default no intervals.
    pub interval: Option<f64>,
    /// Fewest time steps of a window that is decided early. Default a tenth of a window, the least that reports
    /// measure.
    pub least: Option<usize>,
    /// Padding of a window that is decided early. Default that of the model's length rule, else its last time step.
    pub padding: Option<Padding>,
    /// First readings that are at rest: their mean is taken off where the training had resting values taken off. Default as many
    /// as there, or 10 where these came in an array; 0 for readings that are tared already.
    pub tare: Option<usize>,
    /// The largest possible value. Default that of the model's card.
    pub full_scale: Option<f32>,
}
