//! Scaling of raw readings for the networks that take the series as it is.
//!
//! # Reference
//!
//! Kaewrakmuk and Srinonchat 2026, section 4.2, feeds raw counts to its 1D networks
//! ([`Scaling::Raw`]). The other two are common practice and our own addition.

use crate::finite::{self, all_finite};
use crate::{Error, Result};
use ndarray::{ArrayD, ArrayViewD, Axis, Dimension};
use serde::{Deserialize, Serialize};

/// A linear map of each channel (axis 1 of `[samples, channels, ..]`).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Scaling {
    /// Readings as they are.
    #[default]
    Raw,
    /// `v / full_scale`: 0..1 for readings of 0..`full_scale`.
    FullScale {
        /// The largest possible reading, 1023 for 10-bit counts; positive.
        full_scale: f32,
    },
    /// `(v - mean) / sd` per channel; see [`Scaling::fit_z_score`].
    ZScore {
        /// Mean of each channel over the training data.
        mean: Vec<f32>,
        /// Standard deviation of each channel over the training data; positive.
        sd: Vec<f32>,
    },
}

impl Scaling {
    /// Fits mean and standard deviation (divided by n) of each channel over `train`, shaped `[samples, channels, ..]`.
    /// Give it training samples only: with test samples in it, a score on them is no longer a score on unseen data.
    ///
    /// A constant channel gets `sd = 1`, so that it becomes zeros.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for fewer than two axes or no readings, [`Error::NonFinite`] for a bad
    /// reading.
    pub fn fit_z_score(train: ArrayViewD<f32>) -> Result<Self> {
        check_shape(&train, "training data")?;
        check_finite(&train)?;
        if train.is_empty() {
            return Err(shape_error(&train, "training data", "at least one reading".into()));
        }
        let (mean, sd) = train
            .axis_iter(Axis(1))
            .map(|channel| {
                let n = channel.len() as f64;
                let mean = channel.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
                let squares = channel.iter().map(|&v| (f64::from(v) - mean).powi(2));
                let (mean, sd) = (mean as f32, (squares.sum::<f64>() / n).sqrt() as f32);
                // Smaller than the readings' own rounding is constant.
                (mean, if sd <= f32::EPSILON * mean.abs() { 1.0 } else { sd })
            })
            .unzip();
        Ok(Self::ZScore { mean, sd })
    }

    /// Scales `x`, shaped `[samples, channels, ..]`, in place.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for fewer than two axes or other channels than fitted,
    /// [`Error::Parameter`] for a scale that is not positive, [`Error::NonFinite`] for a bad
    /// reading. `x` is unchanged then.
    pub fn apply(&self, x: &mut ArrayD<f32>) -> Result<()> {
        check_shape(&x.view(), "readings")?;
        self.check(x.len_of(Axis(1)), || x.shape().to_vec())?;
        check_finite(&x.view())?;
        match self {
            Self::Raw => {}
            Self::FullScale { full_scale } => x.mapv_inplace(|v| v / full_scale),
            Self::ZScore { mean, sd } => {
                for ((mut channel, mean), sd) in x.axis_iter_mut(Axis(1)).zip(mean).zip(sd) {
                    channel.mapv_inplace(|v| (v - mean) / sd);
                }
            }
        }
        Ok(())
    }

    /// Scales one sample `[channels, ..]`, row-major, into `out`, bit for bit as [`Scaling::apply`] does; nothing is
    /// allocated.
    ///
    /// # Errors
    ///
    /// Those of [`Scaling::apply`], and [`Error::Shape`] for an `out` of another length or values that are no whole
    /// channels.
    pub fn encode(&self, channels: usize, x: &[f32], out: &mut [f32]) -> Result<()> {
        let each = x.len() / channels.max(1);
        if each * channels != x.len() || out.len() != x.len() {
            let expected = format!("{channels} channels of one length, and room for {}", x.len());
            return Err(Error::Shape { what: "readings", expected, got: vec![x.len(), out.len()] });
        }
        self.check(channels, || vec![1, channels, each])?;
        finite::check_finite(x, |at| {
            let (channel, reading) = (at / each, at % each);
            format!("reading {reading} of channel {channel} of sample 0")
        })?;
        match self {
            Self::Raw => out.copy_from_slice(x),
            Self::FullScale { full_scale } => {
                out.iter_mut().zip(x).for_each(|(out, v)| *out = v / full_scale);
            }
            Self::ZScore { mean, sd } => {
                let channels = out.chunks_exact_mut(each.max(1)).zip(x.chunks_exact(each.max(1)));
                for ((out, x), (mean, sd)) in channels.zip(mean.iter().zip(sd)) {
                    out.iter_mut().zip(x).for_each(|(out, v)| *out = (v - mean) / sd);
                }
            }
        }
        Ok(())
    }

    /// Checks the parameters; `shape` is that of the readings, for messages.
    fn check(&self, channels: usize, shape: impl FnOnce() -> Vec<usize>) -> Result<()> {
        let is_positive = |value: f32| value > 0.0 && value.is_finite();
        let refuse = |name: String, value: f32, expected| Err(Error::Parameter { name, value, expected });
        match self {
            Self::FullScale { full_scale } if !is_positive(*full_scale) => {
                refuse("full_scale".into(), *full_scale, "positive and finite")
            }
            Self::ZScore { mean, sd } => {
                if mean.len() != channels || sd.len() != mean.len() {
                    let expected = format!(
                        "as many channels as were fitted ({} means, {} deviations)",
                        mean.len(),
                        sd.len()
                    );
                    return Err(Error::Shape { what: "readings", expected, got: shape() });
                }
                if let Some(at) = mean.iter().position(|v| !v.is_finite()) {
                    return refuse(format!("mean[{at}]"), mean[at], "finite");
                }
                match sd.iter().position(|&v| !is_positive(v)) {
                    Some(at) => refuse(format!("sd[{at}]"), sd[at], "positive and finite"),
                    None => Ok(()),
                }
            }
            Self::Raw | Self::FullScale { .. } => Ok(()),
        }
    }
}

pub(crate) fn shape_error(x: &ArrayViewD<f32>, what: &'static str, expected: String) -> Error {
    Error::Shape { what, expected, got: x.shape().to_vec() }
}

fn check_shape(x: &ArrayViewD<f32>, what: &'static str) -> Result<()> {
    match x.ndim() {
        0 | 1 => Err(shape_error(x, what, "[samples, channels, ..]".into())),
        _ => Ok(()),
    }
}

pub(crate) fn check_finite(x: &ArrayViewD<f32>) -> Result<()> {
    // The place of a bad reading is looked for only where there is one.
    if x.as_slice().is_some_and(all_finite) {
        return Ok(());
    }
    match x.indexed_iter().find(|(_, v)| !v.is_finite()) {
        None => Ok(()),
        Some((at, &value)) => {
            let at = at.as_array_view().to_vec();
            let place = match &at[2..] {
                [] => String::new(),
                [time] => format!("reading {time} of "),
                more => format!("reading {more:?} of "),
            };
            let place = format!("{place}channel {} of sample {}", at[1], at[0]);
            Err(Error::NonFinite { place, value })
        }
    }
}
