//! Decisions by measured values: comparisons, choices, ranks.

mod across;
mod choice;
mod choice_words;
mod comparison;
mod deciding;
mod eight_bits;
mod hardening;
mod p_value;
mod places;
mod shrinking;
mod side_by_side;
pub mod statistics;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod choice_tests;

pub use across::{across, rank};
pub use choice::choose;
pub use comparison::{Comparison, Effect, Predicted, Statistic};
pub use deciding::rounded;
pub use eight_bits::eight_bits;
pub use hardening::hardening;
pub use shrinking::{contrasts, knee, mean_score};
pub use side_by_side::{Side, side_by_side};
