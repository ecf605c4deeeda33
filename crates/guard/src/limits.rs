//! The numbers behind every decision of a guard.

/// How far beyond anything that training has seen a residual must lie, as a factor. New clean samples go beyond the
/// largest of n windows by chance, once in n on average; a quarter more they hardly ever do: of a random fifth held out of
/// five recorded sets 0 to 1.3 % had an alarm with it, up to 4 % without.
pub const MARGIN: f64 = 1.25;

/// The share of training samples whose largest residual stays below the bound that all elements share: a sample has
/// many elements, and the worst of them must not raise an alarm in more than about one sample of a hundred.
pub const SHARE: f64 = 0.99;

/// Readings count as full scale or as rest when they are so close to it, as a share of the sensor's range; residuals
/// below it are never far. A ten-bit converter's step.
pub const TOLERANCE: f64 = 1e-3;

/// A window is still where it varies by less than this share of the least that the channel ever varied in training.
pub const QUIET: f64 = 0.1;

/// Readings that a window must have to be called still: two or three may be equal by chance.
pub const FEWEST: usize = 4;

/// Correlation from which one channel says anything of another.
pub const RELATED: f64 = 0.3;

/// Neighbours of an element.
pub const NEIGHBOURS: usize = 4;

/// Of more channels than this, neighbours are sought among the [`NEAR`] before and after: pairs grow with the square.
pub const ALL_PAIRS: usize = 64;

/// Channels before and after.
pub const NEAR: usize = 16;

/// The share of the elements that may be replaced in one sample; where more are unlike training, the sample as a whole
/// is, and there is nothing left to mend it by.
pub const MOST: f64 = 0.5;
