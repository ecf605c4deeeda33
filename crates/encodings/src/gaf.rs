//! Gramian angular field: a time series as an image of pairwise angles.
//!
//! # Reference
//!
//! Wang and Oates, "Encoding Time Series as Images for Visual Inspection and Classification Using
//! Tiled Convolutional Neural Networks", AAAI workshop 2015; used in section 4.2 of Kaewrakmuk and Srinonchat 2026
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

use crate::finite::{check_finite, values};
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

/// The values that become -1 and 1.
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

/// The treatment of a constant series under [`Range::PerSample`], such as a dead recording.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// The treatment of a constant series.
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
        let mut fields = Fields::new(self, series.len())?;
        let series = values(&series);
        check_finite(&series, |at| format!("reading {at}"))?;
        fields.look(&series)?;
        let mut field = vec![0.0; self.size * self.size];
        field.chunks_exact_mut(self.size).enumerate().for_each(|(i, row)| fields.row(i, row));
        #[expect(clippy::expect_used, reason = "made with that many values")]
        Ok(Array2::from_shape_vec((self.size, self.size), field).expect("size x size values"))
    }
}

/// Fields of series of one length: where their segments begin, and the angles of the last one.
#[derive(Debug, Clone)]
pub(crate) struct Fields {
    gaf: Gaf,
    /// Where the segments begin, and the end of the last.
    bounds: Vec<usize>,
    cos: Vec<f64>,
    sin: Vec<f64>,
    is_flat: bool,
}

impl Fields {
    /// Prepares the fields of series of so many `readings`.
    ///
    /// # Errors
    ///
    /// Those of [`Gaf::check`], [`Error::TooShort`].
    pub fn new(gaf: &Gaf, readings: usize) -> Result<Self> {
        gaf.check()?;
        let size = gaf.size;
        if readings < size {
            return Err(Error::TooShort { length: readings, size });
        }
        let step = readings as f64 / size as f64;
        // pyts truncates floating-point bounds, which is not always floor(i * length / size).
        let bound = |i: usize| if i == size { readings } else { (i as f64 * step) as usize };
        let (cos, sin) = (vec![0.0; size], vec![0.0; size]);
        Ok(Fields { gaf: gaf.clone(), bounds: (0..=size).map(bound).collect(), cos, sin, is_flat: false })
    }

    /// Takes the angles of a series, whose readings are finite.
    ///
    /// # Errors
    ///
    /// [`Error::Constant`].
    pub fn look(&mut self, series: &[f32]) -> Result<()> {
        let Fields { gaf, bounds, cos, sin, is_flat } = self;
        *is_flat = false;
        match gaf.range {
            Range::Fixed { low, high } => segments(series, bounds, cos, |v| to_unit(v, low, high)),
            Range::PerSample => {
                segments(series, bounds, cos, f64::from);
                let low = cos.iter().copied().fold(f64::INFINITY, f64::min);
                let high = cos.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                // Averaging alone may leave a difference of this order.
                if high - low <= 1e-12 * low.abs().max(high.abs()) {
                    *is_flat = true;
                    return match gaf.constant {
                        Constant::Error => Err(Error::Constant { value: low }),
                        Constant::Zero => Ok(()),
                    };
                }
                let scale = 2.0 / (high - low);
                cos.iter_mut().for_each(|v| *v = ((*v - low) * scale - 1.0).clamp(-1.0, 1.0));
            }
        }
        sin.iter_mut().zip(cos).for_each(|(sin, x)| *sin = (1.0 - *x * *x).max(0.0).sqrt());
        Ok(())
    }

    /// Writes row `i` of the field.
    pub fn row(&self, i: usize, row: &mut [f32]) {
        if self.is_flat {
            return row.fill(0.0);
        }
        let (cos, sin) = (self.cos[i], self.sin[i]);
        let angles = self.cos.iter().zip(&self.sin);
        match self.gaf.method {
            Method::Difference => row.iter_mut().zip(angles).for_each(|(v, (other_cos, other_sin))| {
                *v = (sin * other_cos - cos * other_sin).clamp(-1.0, 1.0) as f32;
            }),
            Method::Summation => row.iter_mut().zip(angles).for_each(|(v, (other_cos, other_sin))| {
                *v = (cos * other_cos - sin * other_sin).clamp(-1.0, 1.0) as f32;
            }),
        }
    }
}

/// Maps `low..high` to -1..1, clipped.
fn to_unit(v: f32, low: f32, high: f32) -> f64 {
    let (v, low, high) = (f64::from(v), f64::from(low), f64::from(high));
    ((v - low) / (high - low) * 2.0 - 1.0).clamp(-1.0, 1.0)
}

/// Takes the piecewise aggregate approximation: means of the segments between `bounds`, without overlap.
fn segments(series: &[f32], bounds: &[usize], means: &mut [f64], value: impl Fn(f32) -> f64) {
    for (mean, ends) in means.iter_mut().zip(bounds.windows(2)) {
        let sum: f64 = series[ends[0]..ends[1]].iter().map(|&v| value(v)).sum();
        *mean = sum / (ends[1] - ends[0]) as f64;
    }
}
