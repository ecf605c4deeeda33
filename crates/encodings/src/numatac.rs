//! Recordings of two NumaTac fingers as dual-channel samples.
//!
//! # Reference
//!
//! Zhang et al. 2022 (Identifying the strength level of objects' tactile attributes), section 3.1: bits to Pa
//! (equations 1 and 2), and the contact judge, which starts a sample where an AC value is more than 1.1
//! or less than 0.9 times the one before; section 3.2.3: 300 ticks are kept, z-scores per feature
//! (equation 3). The judge reads raw bits, and we read "next" and "previous" as neighbours at 2200 Hz.
//!
//! The offset is the reading under atmospheric pressure: here, the mean of each finger's readings
//! before contact. The text's example of 270 bit = 3493.8 Pa leaves its offset of 238 out.

use crate::finite::{check_finite, place, values};
use crate::{Error, Result, Scaling};
use ndarray::{Array3, Array4, ArrayView3, ArrayView4, Ix4};
use serde::{Deserialize, Serialize};

/// The value that is subtracted before bits become Pa.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Offset {
    /// Mean of DC, and of all AC values, of each finger before contact.
    #[default]
    BeforeContact,
    /// The same two values for every finger and sample, in bits.
    Fixed {
        /// Reading of DC at rest.
        dc: f32,
        /// Reading of AC at rest.
        ac: f32,
    },
}

/// Settings of the encoding; the default is the paper's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NumaTac {
    /// Ticks that are kept from contact on; at least 1.
    pub window: usize,
    /// Contact is where AC rises by more than this factor from value to value; above 1.
    pub above: f32,
    /// Or falls below this factor; between 0 and 1.
    pub below: f32,
    /// The value that is subtracted.
    pub offset: Offset,
}

/// Pressure of a DC and of an AC bit, Pa (equations 1 and 2).
pub const PA_PER_BIT: [f64; 2] = [12.94, 0.13];

impl Default for NumaTac {
    fn default() -> Self {
        Self { window: 300, above: 1.1, below: 0.9, offset: Offset::BeforeContact }
    }
}

impl NumaTac {
    /// Checks whether the contact judge sees contact between two neighbouring AC values in bits.
    pub fn touches(&self, before: f32, after: f32) -> bool {
        before > 0.0 && (after > self.above * before || after < self.below * before)
    }

    /// Finds the first tick in which any finger of a recording `[fingers, 1 DC + AC, ticks]` in bits touches something.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] for a recording without AC, [`Error::NoContact`] where the judge never fires,
    /// [`Error::Parameter`] for impossible thresholds, [`Error::NonFinite`] for a bad reading.
    pub fn onset(&self, recording: ArrayView3<f32>) -> Result<usize> {
        self.onset_of(recording.dim().into(), &values(&recording))
    }

    fn onset_of(&self, shape: [usize; 3], recording: &[f32]) -> Result<usize> {
        self.check()?;
        check_finite(recording, |at| place(shape, at))?;
        let [_, features, ticks] = shape;
        if features < 2 || recording.is_empty() {
            let expected = "[fingers, 1 DC + AC values, ticks]".into();
            return Err(Error::Shape { what: "recording", expected, got: shape.to_vec() });
        }
        let first = |finger: &[f32]| {
            let mut before = finger[ticks];
            (0..ticks).position(|tick| {
                (1..features).any(|feature| {
                    let value = finger[feature * ticks + tick];
                    let touches = self.touches(before, value);
                    before = value;
                    touches
                })
            })
        };
        recording
            .chunks_exact(features * ticks)
            .filter_map(first)
            .min()
            .ok_or(Error::NoContact { above: self.above, below: self.below })
    }

    /// Encodes one recording `[fingers, 1 DC + AC, ticks]` in bits as `[fingers, 1 DC + AC, window]` in
    /// Pa, from contact on.
    ///
    /// # Errors
    ///
    /// Those of [`NumaTac::onset`]; [`Error::Window`] where contact comes too late for the window, or
    /// at once, so that there is no rest to take the offset from.
    pub fn encode(&self, recording: ArrayView3<f32>) -> Result<Array3<f32>> {
        let (fingers, features, ticks) = recording.dim();
        let mut sample = vec![0.0; fingers * features * self.window];
        self.encode_into([fingers, features, ticks], &values(&recording), &mut sample)?;
        #[expect(clippy::expect_used, reason = "made with that many values")]
        Ok(Array3::from_shape_vec((fingers, features, self.window), sample).expect("as many values"))
    }

    /// Does [`NumaTac::encode`] for the values of one recording of `shape` fingers × 1 DC + AC × ticks into `sample`;
    /// nothing is allocated.
    ///
    /// # Errors
    ///
    /// Those of [`NumaTac::encode`], and [`Error::Shape`] for values or a sample of another length.
    pub fn encode_into(&self, shape: [usize; 3], recording: &[f32], sample: &mut [f32]) -> Result<()> {
        let [fingers, features, ticks] = shape;
        if recording.len() != fingers * features * ticks || sample.len() != fingers * features * self.window {
            let expected = format!("{shape:?} readings, and room for {} ticks of them", self.window);
            let got = vec![recording.len(), sample.len()];
            return Err(Error::Shape { what: "recording", expected, got });
        }
        let onset = self.onset_of(shape, recording)?;
        let late = onset + self.window > ticks;
        if late || (onset == 0 && self.offset == Offset::BeforeContact) {
            return Err(Error::Window { onset, window: self.window, ticks });
        }
        let each = features * ticks;
        for (finger, into) in
            recording.chunks_exact(each).zip(sample.chunks_exact_mut(features * self.window))
        {
            let rest = self.rest(finger, ticks, onset);
            let series = finger.chunks_exact(ticks).zip(into.chunks_exact_mut(self.window));
            for (feature, (series, into)) in series.enumerate() {
                let (rest, pa) = (rest[feature.min(1)], PA_PER_BIT[feature.min(1)]);
                for (value, &bits) in into.iter_mut().zip(&series[onset..]) {
                    *value = ((f64::from(bits) - rest) * pa) as f32;
                }
            }
        }
        Ok(())
    }

    /// Encodes `[N, fingers, 1 DC + AC, ticks]`.
    ///
    /// # Errors
    ///
    /// Those of [`NumaTac::encode`], naming the sample.
    pub fn encode_batch(&self, recordings: ArrayView4<f32>) -> Result<Array4<f32>> {
        self.check()?;
        let (samples, fingers, features, _) = recordings.dim();
        let mut encoded = Array4::zeros((samples, fingers, features, self.window));
        for (sample, (recording, mut into)) in
            recordings.outer_iter().zip(encoded.outer_iter_mut()).enumerate()
        {
            into.assign(&self.encode(recording).map_err(|e| e.in_sample(sample))?);
        }
        Ok(encoded)
    }

    /// Returns DC and AC of a finger at rest, bits.
    fn rest(&self, finger: &[f32], ticks: usize, onset: usize) -> [f64; 2] {
        let mean = |features: &[f32]| {
            let rows = features.chunks_exact(ticks);
            let count = (rows.len() * onset) as f64;
            rows.flat_map(|row| &row[..onset]).map(|&v| f64::from(v)).sum::<f64>() / count
        };
        match self.offset {
            Offset::Fixed { dc, ac } => [dc, ac].map(f64::from),
            Offset::BeforeContact => [mean(&finger[..ticks]), mean(&finger[ticks..])],
        }
    }

    fn check(&self) -> Result<()> {
        let reject =
            |name: &str, value, expected| Err(Error::Parameter { name: name.into(), value, expected });
        if self.window == 0 {
            return Err(Error::Size { size: 0, least: 1, why: " tick in the window" });
        }
        if !(self.above > 1.0 && self.above.is_finite()) {
            return reject("above", self.above, "above 1 and finite, as 1.1");
        }
        if !(0.0..1.0).contains(&self.below) {
            return reject("below", self.below, "at least 0 and below 1, as 0.9");
        }
        match self.offset {
            Offset::Fixed { dc, .. } if !dc.is_finite() => reject("offset.dc", dc, "finite"),
            Offset::Fixed { ac, .. } if !ac.is_finite() => reject("offset.ac", ac, "finite"),
            _ => Ok(()),
        }
    }
}

/// Fits Z-scores per feature (equation 3): mean and SD of each of the fingers' features over `train`, shaped
/// `[N, fingers, features, ticks]`. Give it training samples only.
///
/// # Errors
///
/// Those of [`Scaling::fit_z_score`].
pub fn fit_features(train: ArrayView4<f32>) -> Result<Scaling> {
    Scaling::fit_z_score(flat(train)?.view().into_dyn())
}

/// Scales samples `[N, fingers, features, ticks]` by what [`fit_features`] has fitted.
///
/// # Errors
///
/// Those of [`Scaling::apply`].
pub fn scale_features(scaling: &Scaling, x: ArrayView4<f32>) -> Result<Array4<f32>> {
    let mut scaled = flat(x)?.into_dyn();
    scaling.apply(&mut scaled)?;
    let back = scaled.into_shape_with_order(x.raw_dim()).map(|x| x.into_dimensionality::<Ix4>());
    match back {
        Ok(Ok(back)) => Ok(back),
        _ => Err(axes(&x)),
    }
}

/// Flattens `[N, fingers, features, ticks]` to `[N, fingers * features, ticks]`.
fn flat(x: ArrayView4<f32>) -> Result<Array3<f32>> {
    let (samples, fingers, features, ticks) = x.dim();
    let values: Vec<f32> = x.iter().copied().collect();
    Array3::from_shape_vec((samples, fingers * features, ticks), values).map_err(|_| axes(&x))
}

fn axes(x: &ArrayView4<f32>) -> Error {
    let expected = "[samples, fingers, features, ticks]".into();
    Error::Shape { what: "samples", expected, got: x.shape().to_vec() }
}
