//! MiniRocket for values: its features, and the level that they forget.

use taxel_kernels::rocket::RocketMemory;

use crate::summary::{each_recording, levels};
use crate::{ALPHAS, FeatureMatrix, MiniRocket, Result, Ridge, Saved, Series};

/// [`MiniRocket`] features, then the last step of every channel, then the mean over time of every channel, into a [`Ridge`]
/// regression.
///
/// MiniRocket's features are shares of time above a threshold of a convolution whose weights add up to 0: how high a series
/// lies shows at its ends alone, where zeros are filled in. Dempster, Schmidt & Webb 2021 have classes; the level is taxel's
/// own.
#[derive(Debug, Clone, PartialEq)]
pub struct RocketValues {
    rocket: MiniRocket,
    ridge: Ridge,
}

/// Memory of the convolutions, features, and products with the weights of each value.
#[derive(Debug)]
pub(crate) struct RocketValuesMemory {
    work: RocketMemory,
    features: Vec<f32>,
    products: Vec<f64>,
}

/// Returns the number of features of series with so many channels.
fn width(rocket: &MiniRocket) -> usize {
    rocket.biases().len() + 2 * rocket.shape()[0]
}

/// Writes the features of one recording.
fn write(rocket: &MiniRocket, recording: &[f32], work: &mut RocketMemory, features: &mut [f32]) {
    let (shares, level) = features.split_at_mut(rocket.biases().len());
    rocket.shares(recording, work, shares);
    levels(recording, rocket.shape()[1], level);
}

/// Computes the features of each recording.
fn transform(rocket: &MiniRocket, x: &Series) -> Result<FeatureMatrix> {
    x.expect(rocket.shape())?;
    let write = |work: &mut RocketMemory, x: &[f32], row: &mut [f32]| write(rocket, x, work, row);
    Ok(each_recording(x, width(rocket), || rocket.work(), write))
}

impl RocketValues {
    pub(crate) fn fit(
        train: &Series,
        values: &[f32],
        outputs: usize,
        features: usize,
        (seed, purpose): (u64, &str),
    ) -> Result<Self> {
        let rocket = MiniRocket::fit(train, features, seed, purpose)?;
        let ridge = Ridge::fit_values(&transform(&rocket, train)?, values, outputs, &ALPHAS)?;
        Ok(RocketValues { rocket, ridge })
    }

    /// Returns the features without their level, and the regression.
    pub(crate) fn parts(&self) -> (&MiniRocket, &Ridge) {
        (&self.rocket, &self.ridge)
    }

    pub(crate) fn shape(&self) -> [usize; 2] {
        self.rocket.shape()
    }

    pub(crate) fn outputs(&self) -> usize {
        self.ridge.classes()
    }

    pub(crate) fn predict(&self, x: &Series) -> Result<Vec<f32>> {
        Ok(self.ridge.decide(&transform(&self.rocket, x)?))
    }

    pub(crate) fn memory(&self) -> RocketValuesMemory {
        RocketValuesMemory {
            work: self.rocket.work(),
            features: vec![0.0; width(&self.rocket)],
            products: vec![0.0; self.outputs()],
        }
    }

    /// Checks whether `memory` is that of such features and values.
    pub(crate) fn fits(&self, memory: &RocketValuesMemory) -> bool {
        memory.features.len() == width(&self.rocket) && memory.products.len() == self.outputs()
    }

    /// Writes the values of one recording.
    pub(crate) fn predict_one(&self, recording: &[f32], memory: &mut RocketValuesMemory, values: &mut [f32]) {
        let RocketValuesMemory { work, features, products } = memory;
        write(&self.rocket, recording, work, features);
        self.ridge.decide_one(features, products, values);
    }

    pub(crate) fn left_out(&self, train: &Series, values: &[f32], units: &[u32]) -> Result<Vec<f32>> {
        self.ridge.left_out_values(&transform(&self.rocket, train)?, values, units)
    }

    pub(crate) fn macs(&self) -> u64 {
        self.rocket.macs() + self.ridge.macs()
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let mut tensors = self.rocket.tensors();
        tensors.extend(self.ridge.tensors());
        tensors
    }

    /// Reads the tensors that [`RocketValues::tensors`] gave.
    pub(crate) fn read(shape: [usize; 2], outputs: usize, saved: &Saved) -> Result<Self> {
        let rocket = MiniRocket::read(shape, saved)?;
        let ridge = Ridge::read(width(&rocket), outputs, saved)?;
        Ok(RocketValues { rocket, ridge })
    }
}
