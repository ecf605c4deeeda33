//! How raw samples become one input; everything that was fitted is in it.

use ndarray::{Array4, ArrayD, ArrayView4, ArrayViewD, Axis};
use serde::{Deserialize, Serialize};
use taxel_base::Layout;
use taxel_encodings::numatac::{fit_features, scale_features};
use taxel_encodings::{
    ElectrodeImage, HardnessImage, History, NumaTac, OneFrame, QuantileCode, Reduction, Resize, Scaling,
    TactileTensor, red_channel,
};

use super::axes::{
    image_axes, less_baseline, of_sample, reduced, refused, series, signal_axes, with_axes, wrong_axes,
};
use super::names::{IMAGE, ROCKET, SIGNAL, TENSOR};
use super::rocket::Rocket;
use crate::error::Result;

/// How raw samples `[N, ..]` become one input; everything that was fitted is in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Transform {
    /// `[N, C, T]` (or `[N, F]` as one channel) scaled per channel.
    Signal(Scaling),
    /// `[N, C, T]` (or `[N, F]` as one channel) as ramps and z-scores `[N, rows, steps]`.
    QuantileCode(QuantileCode),
    /// `[N, C, T]` (or `[N, F]` as one channel) as features `[N, features]`.
    Rocket(Box<Rocket>),
    /// `[N, H, W]` as `[N, 1, H, W]`, or `[N, C, H, W]`, scaled per channel.
    Image(Scaling),
    /// `[N, C, T]` as a coloured Gramian angular field `[N, C, H, W]`.
    Field(HardnessImage),
    /// Images, or one frame of each `[N, T, H, W]`, coloured and resized, then scaled per channel.
    Picture {
        /// Which frame; none where the samples are images.
        frame: Option<OneFrame>,
        /// Whether one grey channel becomes the red of three.
        red: bool,
        /// The new size.
        resize: Option<Resize>,
        /// Scale of the pixels.
        scaling: Scaling,
    },
    /// `[N, T, H, W]` as `[N, 1, H, W, T]`, scaled.
    Tensor {
        /// Frames.
        tensor: TactileTensor,
        /// Scale of the readings.
        scaling: Scaling,
    },
    /// Bits `[N, fingers, features, ticks]` in Pa from contact on, scaled per finger and feature.
    Numatac {
        /// Contact judge and offsets.
        numatac: NumaTac,
        /// Scale of the pressures.
        scaling: Scaling,
    },
    /// `[N, T, 7, 3]` electrodes as `[N, 3, 70, 70]`, scaled per colour.
    Electrodes {
        /// Order of the values.
        image: ElectrodeImage,
        /// Scale of the readings.
        scaling: Scaling,
    },
    /// `[N, C, T]` as `[N, 1, C, T]`, scaled per row.
    Rows(Scaling),
    /// Samples of any layout as `[N, C, T]`, and then something else: what baselines read.
    Series {
        /// Axes of a sample.
        layout: Layout,
        /// The next transform.
        then: Box<Transform>,
    },
    /// `[N, C, T]` less the mean of its first readings, per sample and channel, and then something else.
    Baseline {
        /// How many readings.
        readings: usize,
        /// The next transform.
        then: Box<Transform>,
    },
    /// `[N, C, T]` as the last reading of each channel and its differences to earlier ones, `[N, rows, 1]`, and then something else.
    History {
        /// Which earlier ones.
        history: History,
        /// The next transform.
        then: Box<Transform>,
    },
    /// Less of a raw sample of any layout, and then something else.
    Reduced {
        /// Axes of a sample.
        layout: Layout,
        /// The part of it that is kept.
        reduction: Reduction,
        /// The next transform.
        then: Box<Transform>,
    },
}

impl Transform {
    /// Encodes raw samples `[N, ..]`; `source` names them in messages.
    ///
    /// # Errors
    /// Samples with other axes than the transform takes, or readings that cannot be encoded.
    pub fn apply(&self, x: &ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
        self.scale(self.shape(x, source)?, source)
    }

    /// Returns the values beyond the edges of images and tensors, one per channel: the first pixel of a raw sample of
    /// this shape that reads `rest` all over, encoded. None where the input has no edges.
    ///
    /// # Errors
    /// As [`Transform::apply`].
    pub(super) fn at_rest(&self, sample: &[usize], rest: f32, source: &str) -> Result<Option<Vec<f32>>> {
        if !self.has_edges() {
            return Ok(None);
        }
        let whole = self.apply(&ArrayD::from_elem([&[1], sample].concat(), rest), source)?;
        Ok(Some(
            whole.index_axis(Axis(0), 0).outer_iter().filter_map(|plane| plane.first().copied()).collect(),
        ))
    }

    /// Returns the transform that makes the input, behind those that only change raw samples.
    fn last(&self) -> &Transform {
        match self {
            Transform::Baseline { then, .. }
            | Transform::Series { then, .. }
            | Transform::History { then, .. }
            | Transform::Reduced { then, .. } => then.last(),
            _ => self,
        }
    }

    fn has_edges(&self) -> bool {
        matches!(
            self.last(),
            Transform::Image(_)
                | Transform::Picture { .. }
                | Transform::Electrodes { .. }
                | Transform::Tensor { .. }
        )
    }

    /// Checks whether every sample is scaled by its own range: twice the readings give the same input.
    pub fn is_blind_to_amplitude(&self) -> bool {
        match self {
            Transform::Field(field) => field.gaf.range == taxel_encodings::Range::PerSample,
            Transform::Reduced { then, .. } => then.is_blind_to_amplitude(),
            _ => false,
        }
    }

    /// Returns the last axes of what it makes of any sample, where its settings give them; empty elsewhere.
    pub(crate) fn sizes(&self) -> Vec<usize> {
        match self.last() {
            Transform::Field(field) => vec![field.gaf.size; 2],
            Transform::Picture { resize: Some(resize), .. } => vec![resize.height, resize.width],
            Transform::Tensor { tensor: TactileTensor { frames: Some(frames) }, .. } => vec![*frames],
            Transform::Numatac { numatac, .. } => vec![numatac.window],
            _ => vec![],
        }
    }

    /// Returns the shape of one sample once what [`Transform::shape`] gives is scaled.
    pub(super) fn scaled_shape(&self, shape: &[usize]) -> Vec<usize> {
        match (self.last(), shape) {
            (Transform::QuantileCode(code), &[channels, length]) => code.shape(channels, length).to_vec(),
            (Transform::Rocket(rocket), _) => vec![rocket.width()],
            _ => shape.to_vec(),
        }
    }

    /// Returns the name of the input that it makes.
    pub(super) fn input(&self) -> &'static str {
        match self.last() {
            Transform::Signal(_) | Transform::QuantileCode(_) => SIGNAL,
            Transform::Rocket(_) => ROCKET,
            Transform::Tensor { .. } => TENSOR,
            _ => IMAGE,
        }
    }

    /// Returns the reduction that comes before everything else; none where whole samples are read.
    pub fn reduction(&self) -> Option<&Reduction> {
        match self {
            Transform::Reduced { reduction, .. } => Some(reduction),
            _ => None,
        }
    }

    /// Shapes raw samples: applies everything but what is fitted.
    pub(super) fn shape(&self, x: &ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
        let input = self.input();
        let refuse = |e| refused(source, input, e);
        match self {
            Transform::Signal(_) | Transform::QuantileCode(_) => signal_axes(x.clone(), SIGNAL, source),
            Transform::Rocket(rocket) => {
                let x = signal_axes(x.clone(), ROCKET, source)?;
                rocket.check(x.len_of(Axis(2)))?;
                Ok(x)
            }
            Transform::Rows(_) => Ok(signal_axes(x.clone(), IMAGE, source)?.insert_axis(Axis(1))),
            Transform::Baseline { readings, then } => {
                then.shape(&less_baseline(x.clone(), *readings, source)?, source)
            }
            Transform::History { history, then } => {
                let x = signal_axes(x.clone(), SIGNAL, source)?;
                then.shape(&histories(&x, history).map_err(refuse)?, source)
            }
            Transform::Series { layout, then } => then.shape(&series(x, *layout, source)?, source),
            Transform::Reduced { layout, reduction, then } => {
                then.shape(&reduced(x, *layout, reduction).map_err(refuse)?, source)
            }
            Transform::Image(_) => image_axes(x.clone(), source),
            Transform::Field(field) => {
                let x = signal_axes(x.clone(), IMAGE, source)?;
                Ok(field.encode_batch(with_axes(x.view(), input, source)?).map_err(refuse)?.into_dyn())
            }
            Transform::Picture { frame, red, resize, .. } => {
                pictures(x, *frame, *red, resize.as_ref(), source)
            }
            Transform::Tensor { tensor, .. } => tensors(x, *tensor, source),
            Transform::Numatac { numatac, .. } => {
                Ok(numatac.encode_batch(with_axes(x.view(), input, source)?).map_err(refuse)?.into_dyn())
            }
            Transform::Electrodes { image, .. } => {
                let frames: ArrayView4<f32> = with_axes(x.view(), input, source)?;
                // [N, T, 7, 3] as [N, 7, 3, T].
                let series = frames.permuted_axes([0, 2, 3, 1]);
                Ok(image.encode_batch(series).map_err(refuse)?.into_dyn())
            }
        }
    }

    pub(super) fn scale(&self, mut x: ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
        let input = self.input();
        let refuse = |e| refused(source, input, e);
        match self {
            Transform::Field(_) => {}
            Transform::QuantileCode(code) => {
                let view = with_axes(x.view(), input, source)?;
                return Ok(code.encode_batch(view).map_err(refuse)?.into_dyn());
            }
            Transform::Rocket(rocket) => {
                return rocket.encode_batch(with_axes(x.view(), input, source)?, source);
            }
            Transform::Baseline { then, .. }
            | Transform::Series { then, .. }
            | Transform::History { then, .. }
            | Transform::Reduced { then, .. } => return then.scale(x, source),
            Transform::Numatac { scaling, .. } | Transform::Rows(scaling) => {
                let view = with_axes(x.view(), input, source)?;
                return Ok(scale_features(scaling, view).map_err(refuse)?.into_dyn());
            }
            Transform::Signal(scaling)
            | Transform::Image(scaling)
            | Transform::Picture { scaling, .. }
            | Transform::Electrodes { scaling, .. }
            | Transform::Tensor { scaling, .. } => scaling.apply(&mut x).map_err(refuse)?,
        }
        Ok(x)
    }

    /// Returns the same transform with a scale fitted to `train`, which is shaped but not scaled.
    pub(super) fn fitted(&self, train: ArrayViewD<f32>, source: &str) -> Result<Self> {
        let input = self.input();
        let refuse = |e| refused(source, input, e);
        let fitted = || Scaling::fit_z_score(train.view()).map_err(refuse);
        Ok(match self.clone() {
            Transform::Signal(_) => Transform::Signal(fitted()?),
            Transform::QuantileCode(code) => {
                Transform::QuantileCode(code.fit(with_axes(train, input, source)?).map_err(refuse)?)
            }
            Transform::Rocket(rocket) => {
                Transform::Rocket(Box::new(rocket.fit(with_axes(train, input, source)?, source)?))
            }
            Transform::Image(_) => Transform::Image(fitted()?),
            Transform::Field(field) => Transform::Field(field),
            Transform::Picture { frame, red, resize, .. } => {
                Transform::Picture { frame, red, resize, scaling: fitted()? }
            }
            Transform::Tensor { tensor, .. } => Transform::Tensor { tensor, scaling: fitted()? },
            Transform::Electrodes { image, .. } => Transform::Electrodes { image, scaling: fitted()? },
            Transform::Numatac { numatac, .. } => {
                Transform::Numatac { numatac, scaling: self.fitted_rows(train, source)? }
            }
            Transform::Rows(_) => Transform::Rows(self.fitted_rows(train, source)?),
            Transform::Series { layout, then } => {
                Transform::Series { layout, then: Box::new(then.fitted(train, source)?) }
            }
            Transform::Baseline { readings, then } => {
                Transform::Baseline { readings, then: Box::new(then.fitted(train, source)?) }
            }
            Transform::History { history, then } => {
                Transform::History { history, then: Box::new(then.fitted(train, source)?) }
            }
            Transform::Reduced { layout, reduction, then } => {
                Transform::Reduced { layout, reduction, then: Box::new(then.fitted(train, source)?) }
            }
        })
    }
}

impl Transform {
    fn fitted_rows(&self, train: ArrayViewD<f32>, source: &str) -> Result<Scaling> {
        fit_features(with_axes(train, IMAGE, source)?).map_err(|e| refused(source, IMAGE, e))
    }

    /// Returns the transform that takes the baseline off first; the same transform where `baseline` is `None`.
    pub(super) fn less(self, baseline: Option<usize>) -> Self {
        match baseline {
            Some(readings) => Transform::Baseline { readings, then: Box::new(self) },
            None => self,
        }
    }
}

/// Makes rows `[N, rows, 1]` of recordings `[N, C, T]`.
fn histories(x: &ArrayD<f32>, history: &History) -> taxel_encodings::Result<ArrayD<f32>> {
    let &[n, channels, length] = x.shape() else { return Ok(x.clone()) };
    let mut rows = ArrayD::zeros([&[n][..], &history.shape(channels)].concat());
    for (recording, mut rows) in x.outer_iter().zip(rows.outer_iter_mut()) {
        let recording = recording.as_standard_layout();
        if let (Some(recording), Some(rows)) = (recording.as_slice(), rows.as_slice_mut()) {
            history.encode([channels, length], recording, rows)?;
        }
    }
    Ok(rows)
}

/// Makes pictures of images, or of one frame of each sample: coloured, then resized.
fn pictures(
    x: &ArrayD<f32>,
    frame: Option<OneFrame>,
    red: bool,
    resize: Option<&Resize>,
    source: &str,
) -> Result<ArrayD<f32>> {
    let refuse = |e| refused(source, IMAGE, e);
    let images = match frame {
        None => image_axes(x.clone(), source)?,
        Some(frame) => frame.encode_batch(with_axes(x.view(), IMAGE, source)?).map_err(refuse)?.into_dyn(),
    };
    let wrong = |_| wrong_axes(of_sample(x.shape()), IMAGE, source);
    let mut images: Array4<f32> = images.into_dimensionality().map_err(wrong)?;
    if red && images.shape()[1] == 1 {
        images = red_channel(images.index_axis(Axis(1), 0));
    }
    if let Some(resize) = resize {
        images = resize.encode_batch(images.view()).map_err(refuse)?;
    }
    Ok(images.into_dyn())
}

/// Makes tensors `[N, 1, H, W, T]` of squeezes `[N, T, H, W]`.
fn tensors(x: &ArrayD<f32>, tensor: TactileTensor, source: &str) -> Result<ArrayD<f32>> {
    let squeezes: ArrayView4<f32> = with_axes(x.view(), TENSOR, source)?;
    let tensors: Vec<_> = squeezes
        .outer_iter()
        .map(|one| tensor.encode(one))
        .collect::<std::result::Result<_, _>>()
        .map_err(|e| refused(source, TENSOR, e))?;
    let views: Vec<_> = tensors.iter().map(|one| one.view()).collect();
    ndarray::stack(Axis(0), &views)
        .map(ndarray::ArrayBase::into_dyn)
        .map_err(|_| wrong_axes(of_sample(x.shape()), TENSOR, source))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// Compares each with what the transform makes of a whole sample at rest.
    #[test]
    fn what_lies_beyond_an_image_is_the_sensor_at_rest() {
        let scales = |channels: usize| {
            let fitted = Scaling::ZScore {
                mean: [2.0, -1.0, 0.5][..channels].to_vec(),
                sd: [4.0, 0.5, 2.0][..channels].to_vec(),
            };
            [Scaling::Raw, Scaling::FullScale { full_scale: 255.0 }, fitted]
        };
        let agree = |transform: Transform, shape: Vec<usize>, rest: f32| {
            let at_rest = transform.at_rest(&shape[1..], rest, "samples").unwrap().unwrap();
            let whole = transform.apply(&ArrayD::from_elem(shape, rest), "samples").unwrap();
            assert_eq!(at_rest.len(), whole.shape()[1]);
            for (value, plane) in at_rest.into_iter().zip(whole.index_axis(Axis(0), 0).outer_iter()) {
                assert!(plane.iter().all(|v| *v == value), "{transform:?}: {value} against {plane}");
            }
        };
        for rest in [0.0, 166.0] {
            for scaling in scales(2) {
                agree(Transform::Image(scaling), vec![1, 2, 4, 4], rest);
            }
            for (red, channels) in [(true, 3), (false, 1)] {
                for scaling in scales(channels) {
                    agree(
                        Transform::Picture { frame: Some(OneFrame::Peak), red, resize: None, scaling },
                        vec![1, 5, 4, 4],
                        rest,
                    );
                }
            }
        }
        // Colours that are there already are not made red.
        for red in [true, false] {
            let scaling = Scaling::FullScale { full_scale: 255.0 };
            let picture = Transform::Picture { frame: None, red, resize: None, scaling };
            assert_eq!(picture.at_rest(&[3, 4, 4], 51.0, "samples").unwrap(), Some(vec![0.2; 3]));
        }
        assert_eq!(Transform::Signal(Scaling::Raw).at_rest(&[2, 4], 1.0, "samples").unwrap(), None);
    }
}
