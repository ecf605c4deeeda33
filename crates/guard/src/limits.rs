//! The numbers behind every decision of a guard.

/// The factor by which a residual must exceed the largest of training. A new clean sample exceeds the largest of n windows by
/// chance, once in n on average, but hardly ever by a quarter: of a random fifth held out of five recorded sets 0 to 1.3 % had
/// an alarm with this factor, up to 4 % without.
pub const MARGIN: f64 = 1.25;

/// The share of training samples whose largest residual stays below the bound that all elements share: a sample has
/// many elements, and the worst of them must not raise an alarm in more than about one sample of a hundred.
pub const SHARE: f64 = 0.99;

/// Largest distance of a value from full scale or rest that counts as being there, as a share of the sensor's range; smaller
/// residuals are never far. One step of a ten-bit converter.
pub const TOLERANCE: f64 = 1e-3;

/// A window is still where it varies by less than this share of the least that the channel ever varied in training.
pub const QUIET: f64 = 0.1;

/// Fewest values of a window that can be still: two or three may be equal by chance.
pub const FEWEST: usize = 4;

/// Smallest correlation of channels that predict each other.
pub const RELATED: f64 = 0.3;

/// Neighbours of an element.
pub const NEIGHBOURS: usize = 4;

/// Of more channels than this, neighbours are sought among the [`NEAR`] before and after: pairs grow with the square.
pub const ALL_PAIRS: usize = 64;

/// Channels before and after.
pub const NEAR: usize = 16;

/// Largest share of the elements that is replaced in one sample; where more are unlike training, the whole sample is, and
/// nothing is left to predict it by.
pub const MOST: f64 = 0.5;
