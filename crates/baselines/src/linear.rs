//! Linear models on features, as others compute them.

use taxel_kernels::rocket::Dilated;

use crate::{Fitted, FittedValues};

/// A linear model on features of a series: outputs are sums of products in double precision, rounded once.
#[derive(Debug, Clone, Copy)]
pub struct LinearModel<'a> {
    /// The features that the weights meet.
    pub features: LinearFeatures<'a>,
    /// Weights `[outputs, features]`.
    pub weights: &'a [f32],
    /// A number that is added to each output.
    pub bias: &'a [f32],
}

/// The features of a linear model.
#[derive(Debug, Clone, Copy)]
pub enum LinearFeatures<'a> {
    /// The values of the series, channel after channel.
    Readings,
    /// MiniRocket's shares of time above a threshold.
    Rocket {
        /// Convolutions with their thresholds.
        convolutions: &'a [Dilated],
        /// Whether the last step of each channel and the mean of each follow.
        levels: bool,
    },
}

impl Fitted {
    /// Returns MiniRocket with ridge, or ridge, as a linear model; none of other methods.
    pub fn linear(&self) -> Option<LinearModel<'_>> {
        let (features, ridge) = match self {
            Fitted::MiniRocket(rocket, ridge) => {
                (LinearFeatures::Rocket { convolutions: rocket.convolutions(), levels: false }, ridge)
            }
            Fitted::Values(FittedValues::MiniRocket(values)) => {
                let (rocket, ridge) = values.parts();
                (LinearFeatures::Rocket { convolutions: rocket.convolutions(), levels: true }, ridge)
            }
            Fitted::Values(FittedValues::Ridge(_, ridge)) => (LinearFeatures::Readings, ridge),
            _ => return None,
        };
        let (weights, bias) = ridge.numbers();
        Some(LinearModel { features, weights, bias })
    }
}
