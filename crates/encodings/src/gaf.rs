//! Gramian angular field: a time series as an image of pairwise angles.
//!
//! # Reference
//!
//! Wang and Oates, "Encoding Time Series as Images for Visual Inspection and Classification Using
//! Tiled Convolutional Neural Networks", AAAI workshop 2015; used in section 4.2 of paper 000
//! (Hybrid-CNN hardness recognition). With the series `x` in `[-1, 1]` and `phi = arccos(x)`:
//!
//! ```text
//! difference (GADF):  G[i][j] = sin(phi_i - phi_j) = sqrt(1 - x_i^2) x_j - x_i sqrt(1 - x_j^2)
//! summation  (GASF):  G[i][j] = cos(phi_i + phi_j) = x_i x_j - sqrt(1 - x_i^2) sqrt(1 - x_j^2)
//! ```
//!
//! Signs and segments are those of pyts' `GramianAngularField`, and so are the numbers, to 1e-5.
//!
//! # What is lost
//!
//! - The mean of each segment stays, its details go: 250 readings on 50 rows are averaged by fives.
//! - [`Range::PerSample`] throws the amplitude away: a light and a firm press of the same shape
//!   encode alike. Use [`Range::Fixed`] when amplitude carries the label.
//! - The difference field holds angles relative to each other only, and folds a difference `d`
//!   onto `pi - d`; the diagonal of the summation field keeps the values themselves.
//!
//! # Example
//!
//! The angles of 0, 0.5 and 1 are 90, 60 and 0 degrees, so the first row is sin 0, sin 30, sin 90:
//!
//! ```
//! use ndarray::arr1;
//! use taxel_encodings::{Gaf, Range};
//!
//! let gaf = Gaf { size: 3, range: Range::Fixed { low: -1.0, high: 1.0 }, ..Gaf::default() };
//! let image = gaf.encode(arr1(&[0.0, 0.5, 1.0]).view())?;
//! assert_eq!(image.row(0), arr1(&[0.0, 0.5, 1.0]));
//! # Ok::<(), taxel_encodings::Error>(())
//! ```

use crate::{Error, Result};
use ndarray::{Array2, ArrayView1};
use serde::{Deserialize, Serialize};

/// Which of the two fields.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// GADF, `sin(phi_i - phi_j)`: antisymmetric with a zero diagonal. The paper's choice.
    #[default]
    Difference,
    /// GASF, `cos(phi_i + phi_j)`: symmetric, its diagonal keeps the values.
    Summation,
}

/// What becomes -1 and what becomes 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Range {
    /// Minimum and maximum of this sample's own segments, as pyts' `sample_range=(-1, 1)`.
    /// Amplitude is lost.
    #[default]
    PerSample,
    /// The same two values for every sample; readings outside are clipped, each by itself before
    /// any averaging, as a saturated converter would do. Amplitude is kept.
    Fixed {
        /// The reading that becomes -1, in the unit of the readings.
        low: f32,
        /// The reading that becomes 1; above `low`.
        high: f32,
    },
}

/// What to do with a constant series under [`Range::PerSample`], such as a dead recording.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Constant {
    /// [`Error::Constant`]: a dead recording is named, not encoded.
    #[default]
    Error,
    /// A field of zeros, mid-grey under any colour map: the run goes on.
    Zero,
}

/// Settings of the field. The default is the paper's: 50 x 50, difference, per-sample range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gaf {
    /// Rows and columns of the image. At least 2 for [`Range::PerSample`], at least 1 otherwise;
    /// no more than the series has readings.
    pub size: usize,
    /// Difference or summation.
    #[serde(default)]
    pub method: Method,
    /// The rescaling to `[-1, 1]`.
    #[serde(default)]
    pub range: Range,
    /// What a constant series gives.
    #[serde(default)]
    pub constant: Constant,
}

impl Default for Gaf {
    fn default() -> Self {
        Self { size: 50, method: Method::default(), range: Range::default(), constant: Constant::default() }
    }
}

impl Gaf {
    /// Rejects settings that cannot encode any series.
    ///
    /// # Errors
    ///
    /// [`Error::Size`] and [`Error::Range`].
    pub fn check(&self) -> Result<()> {
        let (least, why) = match self.range {
            Range::PerSample => (2, ", one segment has no range of its own"),
            Range::Fixed { .. } => (1, ""),
        };
        if self.size < least {
            return Err(Error::Size { size: self.size, least, why });
        }
        match self.range {
            Range::Fixed { low, high } if !(low.is_finite() && high.is_finite() && low < high) => {
                Err(Error::Range { low, high })
            }
            _ => Ok(()),
        }
    }

    /// Encodes one series of L readings as an image `[size, size]` with values in `[-1, 1]`.
    ///
    /// # Errors
    ///
    /// Those of [`Gaf::check`]; [`Error::TooShort`] for L below `size`; [`Error::NonFinite`] with
    /// the index of the first NaN or infinity; [`Error::Constant`] for a constant series under
    /// [`Range::PerSample`] and [`Constant::Error`].
    pub fn encode(&self, series: ArrayView1<f32>) -> Result<Array2<f32>> {
        self.check()?;
        if series.len() < self.size {
            return Err(Error::TooShort { length: series.len(), size: self.size });
        }
        if let Some(at) = series.iter().position(|v| !v.is_finite()) {
            return Err(Error::NonFinite { place: format!("reading {at}"), value: series[at] });
        }
        let cos = match self.range {
            Range::Fixed { low, high } => segments(series, self.size, |v| to_unit(v, low, high)),
            Range::PerSample => {
                let means = segments(series, self.size, f64::from);
                let low = means.iter().copied().fold(f64::INFINITY, f64::min);
                let high = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                // Averaging alone may leave a difference of this order.
                if high - low <= 1e-12 * low.abs().max(high.abs()) {
                    return match self.constant {
                        Constant::Error => Err(Error::Constant { value: low }),
                        Constant::Zero => Ok(Array2::zeros((self.size, self.size))),
                    };
                }
                let scale = 2.0 / (high - low);
                let unit = |v: f64| ((v - low) * scale - 1.0).clamp(-1.0, 1.0);
                means.into_iter().map(unit).collect()
            }
        };
        let sin: Vec<f64> = cos.iter().map(|x| (1.0 - x * x).max(0.0).sqrt()).collect();
        let field = Array2::from_shape_fn((self.size, self.size), |(i, j)| match self.method {
            Method::Difference => sin[i] * cos[j] - cos[i] * sin[j],
            Method::Summation => cos[i] * cos[j] - sin[i] * sin[j],
        });
        Ok(field.mapv(|v| v.clamp(-1.0, 1.0) as f32))
    }
}

/// `low..high` to -1..1, clipped.
fn to_unit(v: f32, low: f32, high: f32) -> f64 {
    let (v, low, high) = (f64::from(v), f64::from(low), f64::from(high));
    ((v - low) / (high - low) * 2.0 - 1.0).clamp(-1.0, 1.0)
}

/// Piecewise aggregate approximation: means of `size` segments without overlap.
fn segments(series: ArrayView1<f32>, size: usize, value: impl Fn(f32) -> f64) -> Vec<f64> {
    let step = series.len() as f64 / size as f64;
    // pyts truncates floating-point bounds, which is not always floor(i * length / size).
    let bound = |i: usize| match i {
        i if i == size => series.len(),
        i => (i as f64 * step) as usize,
    };
    (0..size)
        .map(|i| {
            let (start, end) = (bound(i), bound(i + 1));
            let sum: f64 = (start..end).map(|t| value(series[t])).sum();
            sum / (end - start) as f64
        })
        .collect()
}
