//! The `rocket` input: MiniRocket's features of a series, for networks that read them beside the series.

use ndarray::{ArrayD, ArrayView3};
use serde::{Deserialize, Serialize};
use taxel_baselines::{MiniRocket, RocketMemory, Series};
use taxel_encodings::Scaling;

use super::axes::refused;
use super::names::ROCKET;
use crate::error::{Error, Result};
use crate::problem::{Check, within};

/// Seed of the random choices, the same for every fold and run.
const SEED: u64 = 0;
/// Added to the SD of a feature, so that one that hardly varies is not blown up.
const LEAST_SD: f32 = 0.02;

/// Settings of the `rocket` input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RocketSettings {
    /// Number of features, rounded down to a multiple of 84: 84 to 100,000. Default 2000.
    pub features: usize,
}

impl Default for RocketSettings {
    fn default() -> Self {
        RocketSettings { features: 2000 }
    }
}

impl RocketSettings {
    pub(super) fn check(self) -> Check {
        within("features", self.features, 84, 100_000)
    }
}

/// MiniRocket's features: series `[N, C, T]`, z-scored per channel, become shares of positive values `[N, features]`,
/// each less its mean and divided by its SD + 0.02.
///
/// # Reference
/// Dempster, Schmidt & Webb, KDD 2021: [`MiniRocket`]. The scale is taxel's own: a feature that hardly varies in
/// training does not outweigh the others on a recording that is broken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rocket {
    features: usize,
    /// Of the readings, per channel.
    readings: Scaling,
    rocket: Option<MiniRocket>,
    /// Of the features.
    shares: Scaling,
}

impl Rocket {
    /// Makes an encoding with so many features, of which nothing is fitted yet.
    pub fn new(features: usize) -> Self {
        Rocket { features, readings: Scaling::Raw, rocket: None, shares: Scaling::Raw }
    }

    /// Returns the number of features.
    pub fn width(&self) -> usize {
        MiniRocket::width(self.features)
    }

    /// Checks the number of features and the length of recordings.
    ///
    /// # Errors
    /// A number of features out of range, recordings of fewer than 9 readings.
    pub(super) fn check(&self, length: usize) -> Result<()> {
        let Rocket { features, .. } = *self;
        RocketSettings { features }.check().map_err(|problem| problem.below("encoding.rocket"))?;
        MiniRocket::kernels(length, self.features).map(drop).map_err(refused_by_rocket)
    }

    /// Fits the encoding to training samples `[N, C, T]`.
    ///
    /// # Errors
    /// Recordings of fewer than 9 readings, readings that are not finite.
    pub fn fit(&self, train: ArrayView3<f32>, source: &str) -> Result<Self> {
        let (_, channels, length) = train.dim();
        let refuse = |e| refused(source, ROCKET, e);
        let readings = Scaling::fit_z_score(train.into_dyn()).map_err(refuse)?;
        let values = scaled(&readings, train, source)?;
        let series = Series::new(&values, channels, length).map_err(refused_by_rocket)?;
        let rocket = MiniRocket::fit(&series, self.features, SEED, "encoding").map_err(refused_by_rocket)?;
        let mut shares = Scaling::fit_z_score(features(&rocket, &series)?.view()).map_err(refuse)?;
        if let Scaling::ZScore { sd, .. } = &mut shares {
            sd.iter_mut().for_each(|sd| *sd += LEAST_SD);
        }
        Ok(Rocket { features: self.features, readings, rocket: Some(rocket), shares })
    }

    /// Turns samples `[N, C, T]` into features `[N, features]`.
    ///
    /// # Errors
    /// Nothing fitted, samples of another shape than those of the fit, readings that are not finite.
    pub(super) fn encode_batch(&self, x: ArrayView3<f32>, source: &str) -> Result<ArrayD<f32>> {
        let (_, channels, length) = x.dim();
        let rocket = self.fitted([channels, length], source)?;
        let values = scaled(&self.readings, x, source)?;
        let series = Series::new(&values, channels, length).map_err(refused_by_rocket)?;
        let mut features = features(rocket, &series)?;
        self.shares.apply(&mut features).map_err(|e| refused(source, ROCKET, e))?;
        Ok(features)
    }

    /// Makes the plan that encodes one sample of `channels` × `length` after the other.
    ///
    /// # Errors
    /// Nothing fitted, or another shape than that of the fit.
    pub(super) fn plan(&self, shape: [usize; 2], source: &str) -> Result<RocketPlan> {
        let rocket = self.fitted(shape, source)?.clone();
        let (readings, shares) = (self.readings.clone(), self.shares.clone());
        Ok(RocketPlan::new(readings, rocket, shares))
    }

    fn fitted(&self, shape: [usize; 2], source: &str) -> Result<&MiniRocket> {
        let fitted = self
            .rocket
            .as_ref()
            .filter(|fitted| fitted.shape() == shape && fitted.biases().len() == self.width());
        let expected = || match &self.rocket {
            Some(fitted) => format!("channels and readings as in training, {:?}", fitted.shape()),
            None => "a fit to training samples".into(),
        };
        let what = "recording";
        fitted.ok_or_else(|| {
            let error = taxel_encodings::Error::Shape { what, expected: expected(), got: shape.to_vec() };
            refused(source, ROCKET, error)
        })
    }
}

/// A [`Rocket`] with memory for one sample after the other.
#[derive(Debug)]
pub(super) struct RocketPlan {
    readings: Scaling,
    rocket: MiniRocket,
    shares: Scaling,
    work: RocketMemory,
    scaled: Vec<f32>,
    features: Vec<f32>,
}

impl RocketPlan {
    fn new(readings: Scaling, rocket: MiniRocket, shares: Scaling) -> Self {
        let (work, scaled) = (rocket.work(), vec![0.0; rocket.shape().iter().product()]);
        let features = vec![0.0; rocket.biases().len()];
        RocketPlan { readings, rocket, shares, work, scaled, features }
    }

    /// Encodes one sample, channel after channel; nothing is allocated.
    ///
    /// # Errors
    /// A sample or features of another size, readings that are not finite.
    pub fn encode(&mut self, sample: &[f32], to: &mut [f32]) -> taxel_encodings::Result<()> {
        let [channels, length] = self.rocket.shape();
        self.readings.encode(channels, sample, &mut self.scaled)?;
        // A scale may take a large reading beyond the largest float.
        if let Some(at) = self.scaled.iter().position(|v| !v.is_finite()) {
            let place = format!("reading {} of channel {}, scaled,", at % length, at / length);
            return Err(taxel_encodings::Error::NonFinite { place, value: self.scaled[at] });
        }
        self.rocket.shares(&self.scaled, &mut self.work, &mut self.features);
        self.shares.encode(self.features.len(), &self.features, to)
    }
}

impl Clone for RocketPlan {
    fn clone(&self) -> Self {
        RocketPlan::new(self.readings.clone(), self.rocket.clone(), self.shares.clone())
    }
}

fn scaled(scaling: &Scaling, x: ArrayView3<f32>, source: &str) -> Result<Vec<f32>> {
    let mut x = x.to_owned().into_dyn();
    scaling.apply(&mut x).map_err(|e| refused(source, ROCKET, e))?;
    Ok(x.into_iter().collect())
}

fn features(rocket: &MiniRocket, series: &Series) -> Result<ArrayD<f32>> {
    let features = rocket.transform(series).map_err(refused_by_rocket)?;
    let shape = vec![series.len(), rocket.biases().len()];
    #[expect(clippy::expect_used, reason = "a row of features per recording")]
    Ok(ArrayD::from_shape_vec(shape, features.into_values()).expect("as many values"))
}

fn refused_by_rocket(source: taxel_baselines::Error) -> Error {
    Error::Baseline { baseline: "encoding.rocket".into(), source }
}
