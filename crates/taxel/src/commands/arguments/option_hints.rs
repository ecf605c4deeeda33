//! Hints at options of the command line, for errors about recordings.

use std::error::Error;

use taxel::Length;

/// Adds the option of the command line that does the same as the key which an error names. `to` is the length that a
/// model reads.
pub fn with_option_hint(error: impl Into<taxel::Error>, to: Option<usize>) -> Box<dyn Error> {
    let error = error.into();
    let data = match &error {
        taxel::Error::Data(data) => Some(data),
        #[cfg(feature = "lab")]
        taxel::Error::Experiment(taxel::experiment::Error::Data(data)) => Some(&**data),
        _ => None,
    };
    match data {
        Some(taxel::data::Error::UnequalLengths { proposed, .. }) => {
            let rule = to.map_or(*proposed, |to| Length::Resample { to });
            format!("{error}, or on the command line --length {rule}").into()
        }
        Some(taxel::data::Error::TooLarge { shape, limit, .. }) => {
            let values = shape.iter().fold(1u64, |product, axis| product.saturating_mul(*axis));
            format!("{error}, or on the command line --max-values {}", values.max(limit + 1)).into()
        }
        _ => error.into(),
    }
}
