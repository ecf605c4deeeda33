//! From samples to the inputs that networks read, fold by fold.
//!
//! What needs no fitting is computed once; what does (z-scores) is fitted on the training part of
//! each fold. What was fitted is a [`Transform`], saved with the network and enough to encode new
//! recordings.

use std::rc::Rc;
use std::time::Instant;

use ndarray::{ArrayD, ArrayViewD, Axis, Ix3, Ix4};
use serde::{Deserialize, Serialize};
use taxel_encodings::numatac::{fit_features, scale_features};
use taxel_encodings::{
    Frame, Gaf, HardnessImage, Method, NumaTac, Resize, Scaling, TactileTensor, red_channel,
};

use crate::config::{Image, ImageKind, Problem, Scale};
use crate::error::{Error, Result};
use crate::experiment::Experiment;
use crate::samples::Samples;

/// Input of 1D networks: channels × time.
pub const SIGNAL: &str = "signal";
/// Input of 2D networks: channels × rows × columns.
pub const IMAGE: &str = "image";

/// Input of 3D networks: channels × rows × columns × frames.
pub const TENSOR: &str = "tensor";

/// Mean and SD of ImageNet's red, green and blue in 0..1, as torchvision takes them.
const IMAGENET: [[f32; 3]; 2] = [[0.485, 0.456, 0.406], [0.229, 0.224, 0.225]];

/// Inputs of all samples under one name, row-major, PyTorch's axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    shape: Vec<usize>,
    values: Vec<f32>,
}

impl Encoded {
    fn new(x: ArrayD<f32>) -> Self {
        let shape = x.shape().get(1..).unwrap_or_default().to_vec();
        let x = if x.is_standard_layout() { x } else { x.as_standard_layout().into_owned() };
        let (mut values, offset) = x.into_raw_vec_and_offset();
        values.drain(..offset.unwrap_or(0));
        Encoded { shape, values }
    }

    /// Shape of one sample.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Values of one sample.
    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Values of sample `i`; empty where there is no such sample.
    pub fn sample(&self, i: usize) -> &[f32] {
        let len = self.shape.iter().product::<usize>();
        self.values.get(i * len..(i + 1) * len).unwrap_or_default()
    }

    /// Puts the values of `rows`, one after the other, into `batch`.
    pub fn gather(&self, rows: &[usize], batch: &mut Vec<f32>) {
        batch.clear();
        rows.iter().for_each(|&row| batch.extend_from_slice(self.sample(row)));
    }
}

/// How raw samples `[N, ..]` become one input; everything that was fitted is in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Transform {
    /// `[N, C, T]` (or `[N, F]` as one channel) scaled per channel.
    Signal(Scaling),
    /// `[N, H, W]` as `[N, 1, H, W]`, or `[N, C, H, W]`, scaled per channel.
    Image(Scaling),
    /// `[N, C, T]` as a coloured Gramian angular field `[N, C, H, W]`.
    Field(HardnessImage),
    /// Images, or one frame of each `[N, T, H, W]`, coloured and resized, then scaled per channel.
    Picture {
        /// Which frame; none where the samples are images.
        frame: Option<Frame>,
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
    /// `[N, C, T]` as `[N, 1, C, T]`, scaled per row.
    Rows(Scaling),
    /// `[N, C, T]` less the mean of its first readings, per sample and channel, and then something else.
    Baseline {
        /// How many readings.
        readings: usize,
        /// What follows.
        then: Box<Transform>,
    },
}

/// Takes the mean of the first `readings` off each channel of samples `[N, C, T]`.
///
/// # Errors
/// Samples with other axes, or with fewer readings.
pub(crate) fn less_baseline(mut x: ArrayD<f32>, readings: usize, source: &str) -> Result<ArrayD<f32>> {
    let length = x.shape().last().copied().unwrap_or(0);
    if x.ndim() != 3 || length < readings {
        let reason = "encoding.baseline needs [N, C, T] with at least as many readings";
        let shape = x.shape().get(1..).unwrap_or_default().to_vec();
        return Err(Error::Axes { source_label: source.into(), input: SIGNAL, shape, reason });
    }
    for mut series in x.lanes_mut(Axis(2)) {
        let sum: f64 = series.iter().take(readings).map(|&v| f64::from(v)).sum();
        let mean = (sum / readings as f64) as f32;
        series.mapv_inplace(|v| v - mean);
    }
    Ok(x)
}

impl Transform {
    /// Encodes raw samples `[N, ..]`; `source` names them in messages.
    ///
    /// # Errors
    /// Samples with other axes than the transform takes, or readings that cannot be encoded.
    pub fn apply(&self, x: &ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
        self.scale(self.shape(x, source)?, source)
    }

    /// What a reading of 0 becomes, per channel of images and tensors: what lies beyond their edges.
    pub(crate) fn rest(&self) -> Option<Vec<f32>> {
        let scaling = match self {
            Transform::Image(scaling)
            | Transform::Picture { scaling, .. }
            | Transform::Tensor { scaling, .. } => scaling,
            Transform::Baseline { then, .. } => return then.rest(),
            Transform::Signal(_) | Transform::Field(_) | Transform::Numatac { .. } | Transform::Rows(_) => {
                return None;
            }
        };
        Some(match scaling {
            Scaling::ZScore { mean, sd } => mean.iter().zip(sd).map(|(mean, sd)| -mean / sd).collect(),
            Scaling::Raw | Scaling::FullScale { .. } => vec![0.0],
        })
    }

    /// Whether every sample is scaled by its own range: twice the readings give the same input.
    pub fn is_blind_to_amplitude(&self) -> bool {
        matches!(self, Transform::Field(field) if field.gaf.range == taxel_encodings::Range::PerSample)
    }

    /// Name of the input that it makes.
    fn input(&self) -> &'static str {
        match self {
            Transform::Signal(_) => SIGNAL,
            Transform::Tensor { .. } => TENSOR,
            Transform::Baseline { then, .. } => then.input(),
            _ => IMAGE,
        }
    }

    /// Everything but the scaling.
    fn shape(&self, x: &ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
        let input = self.input();
        let refuse = |e| encoding(source, input, e);
        let wrong = |_| axes_error(x, input, source);
        match self {
            Transform::Signal(_) => signal_axes(x.clone(), SIGNAL, source),
            Transform::Rows(_) => Ok(signal_axes(x.clone(), IMAGE, source)?.insert_axis(Axis(1))),
            Transform::Baseline { readings, then } => {
                then.shape(&less_baseline(x.clone(), *readings, source)?, source)
            }
            Transform::Image(_) => image_axes(x.clone(), source),
            Transform::Field(field) => {
                let x = signal_axes(x.clone(), IMAGE, source)?;
                let x = x.view().into_dimensionality::<Ix3>().map_err(wrong)?;
                Ok(field.encode_batch(x).map_err(refuse)?.into_dyn())
            }
            Transform::Picture { frame, red, resize, .. } => {
                let images = match frame {
                    None => image_axes(x.clone(), source)?,
                    Some(frame) => {
                        let x = x.view().into_dimensionality::<Ix4>().map_err(wrong)?;
                        frame.encode_batch(x).map_err(refuse)?.into_dyn()
                    }
                };
                let mut images = images.into_dimensionality::<Ix4>().map_err(wrong)?;
                if *red && images.shape()[1] == 1 {
                    images = red_channel(images.index_axis(Axis(1), 0));
                }
                if let Some(resize) = resize {
                    images = resize.encode_batch(images.view()).map_err(refuse)?;
                }
                Ok(images.into_dyn())
            }
            Transform::Tensor { tensor, .. } => {
                let x = x.view().into_dimensionality::<Ix4>().map_err(wrong)?;
                let tensors: Vec<_> = x
                    .outer_iter()
                    .map(|one| tensor.encode(one))
                    .collect::<std::result::Result<_, _>>()
                    .map_err(refuse)?;
                let views: Vec<_> = tensors.iter().map(|one| one.view()).collect();
                ndarray::stack(Axis(0), &views)
                    .map(|x| x.into_dyn())
                    .map_err(|_| axes_error(&ArrayD::zeros(vec![0]), input, source))
            }
            Transform::Numatac { numatac, .. } => {
                let x = x.view().into_dimensionality::<Ix4>().map_err(wrong)?;
                Ok(numatac.encode_batch(x).map_err(refuse)?.into_dyn())
            }
        }
    }

    fn scale(&self, mut x: ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
        let input = self.input();
        let refuse = |e| encoding(source, input, e);
        match self {
            Transform::Field(_) => {}
            Transform::Baseline { then, .. } => return then.scale(x, source),
            Transform::Numatac { scaling, .. } | Transform::Rows(scaling) => {
                let view =
                    x.view().into_dimensionality::<Ix4>().map_err(|_| axes_error(&x, input, source))?;
                return Ok(scale_features(scaling, view).map_err(refuse)?.into_dyn());
            }
            Transform::Signal(scaling)
            | Transform::Image(scaling)
            | Transform::Picture { scaling, .. }
            | Transform::Tensor { scaling, .. } => scaling.apply(&mut x).map_err(refuse)?,
        }
        Ok(x)
    }

    /// The same with a scale fitted to `train`, shaped but not scaled.
    fn fitted(&self, train: ArrayViewD<f32>, source: &str) -> Result<Self> {
        let refuse = |e| encoding(source, self.input(), e);
        let fitted = || Scaling::fit_z_score(train.view()).map_err(refuse);
        Ok(match self.clone() {
            Transform::Signal(_) => Transform::Signal(fitted()?),
            Transform::Image(_) => Transform::Image(fitted()?),
            Transform::Field(field) => Transform::Field(field),
            Transform::Picture { frame, red, resize, .. } => {
                Transform::Picture { frame, red, resize, scaling: fitted()? }
            }
            Transform::Tensor { tensor, .. } => Transform::Tensor { tensor, scaling: fitted()? },
            Transform::Numatac { numatac, .. } => {
                Transform::Numatac { numatac, scaling: self.fitted_rows(train, source)? }
            }
            Transform::Rows(_) => Transform::Rows(self.fitted_rows(train, source)?),
            Transform::Baseline { readings, then } => {
                Transform::Baseline { readings, then: Box::new(then.fitted(train, source)?) }
            }
        })
    }
}

impl Transform {
    fn fitted_rows(&self, train: ArrayViewD<f32>, source: &str) -> Result<Scaling> {
        let view = train.view().into_dimensionality::<Ix4>();
        let view = view.map_err(|_| axes_error(&train.to_owned(), IMAGE, source))?;
        fit_features(view).map_err(|e| encoding(source, IMAGE, e))
    }

    /// The same after the baseline is taken off.
    pub(crate) fn less(self, baseline: Option<usize>) -> Self {
        match baseline {
            Some(readings) => Transform::Baseline { readings, then: Box::new(self) },
            None => self,
        }
    }
}

/// One input, fitted for a fold.
#[derive(Debug, Clone)]
pub struct Input {
    /// `signal` or `image`.
    pub name: &'static str,
    /// How it was made.
    pub transform: Transform,
    /// The input of every sample, training and test.
    pub encoded: Rc<Encoded>,
    /// Time to encode one sample, in ms, averaged over all.
    pub ms_per_sample: f64,
}

/// The encodings of one experiment's samples.
pub struct Encoder<'a> {
    samples: &'a Samples,
    plans: Vec<Plan>,
}

enum Plan {
    /// The same in every fold.
    Done(Input),
    /// Samples with the axes of the input, to be scaled by z-scores.
    Fit { transform: Transform, x: ArrayD<f32> },
}

impl<'a> Encoder<'a> {
    /// Prepares the inputs in `wanted`; what needs no fitting is encoded now.
    ///
    /// # Errors
    /// Samples with the wrong axes, readings that cannot be encoded, or a full scale that nobody
    /// names.
    pub fn new(experiment: &Experiment, samples: &'a Samples, wanted: &[&str]) -> Result<Self> {
        let config = &experiment.config().encoding;
        let mut plans = vec![];
        let mut plan = |scale: Scale, with: &dyn Fn(Scaling) -> Transform| -> Result<()> {
            plans.push(match scaling(scale, experiment, samples)? {
                Some(scaling) => done(with(scaling).less(config.baseline), samples)?,
                None => {
                    let transform = with(Scaling::Raw).less(config.baseline);
                    let x = transform.shape(&samples.x, &samples.source)?;
                    Plan::Fit { transform, x }
                }
            });
            Ok(())
        };
        if wanted.contains(&SIGNAL) {
            plan(config.signal.scale, &Transform::Signal)?;
        }
        if let Some(tensor) = config.tensor.filter(|_| wanted.contains(&TENSOR)) {
            let frames = TactileTensor { frames: tensor.frames };
            plan(tensor.scale.unwrap_or(Scale::FullScale), &|scaling| Transform::Tensor {
                tensor: frames,
                scaling,
            })?;
        }
        if let Some(image) = config.image.as_ref().filter(|_| wanted.contains(&IMAGE)) {
            let scale = image.scale.unwrap_or(Scale::FullScale);
            let resize =
                image.resize.map(|[height, width]| Resize { height, width, filter: Default::default() });
            let red = image.red.unwrap_or(false);
            match image.kind {
                ImageKind::Raw if resize.is_none() && !red => plan(scale, &Transform::Image)?,
                ImageKind::Raw => {
                    plan(scale, &|scaling| Transform::Picture { frame: None, red, resize, scaling })?;
                }
                ImageKind::Frame => {
                    let frame = Some(image.frame.unwrap_or_default());
                    plan(scale, &|scaling| Transform::Picture { frame, red, resize, scaling })?;
                }
                ImageKind::Rows => plan(image.scale.unwrap_or(Scale::ZScore), &Transform::Rows)?,
                ImageKind::Numatac => {
                    let numatac = NumaTac { window: image.window.unwrap_or(300), ..NumaTac::default() };
                    plan(Scale::ZScore, &|scaling| Transform::Numatac { numatac, scaling })?;
                }
                ImageKind::Gadf | ImageKind::Gasf => {
                    let method =
                        if image.kind == ImageKind::Gadf { Method::Difference } else { Method::Summation };
                    let field = Transform::Field(field(image, method)).less(config.baseline);
                    plans.push(done(field, samples)?);
                }
            }
        }
        Ok(Encoder { samples, plans })
    }

    /// Shape of one sample of input `name`, if the experiment makes it.
    pub fn shape(&self, name: &str) -> Option<Vec<usize>> {
        self.plans.iter().find_map(|plan| match plan {
            Plan::Done(input) => (input.name == name).then(|| input.encoded.shape().to_vec()),
            Plan::Fit { transform, x } => (transform.input() == name).then(|| x.shape()[1..].to_vec()),
        })
    }

    /// The inputs with everything fitted on the samples in `train` alone.
    ///
    /// # Errors
    /// Readings that are not finite.
    pub fn fit(&self, train: &[usize]) -> Result<Vec<Input>> {
        let fit = |plan: &Plan| match plan {
            Plan::Done(input) => Ok(input.clone()),
            Plan::Fit { transform, x } => {
                let source = &self.samples.source;
                let transform = transform.fitted(x.select(Axis(0), train).view(), source)?;
                let start = Instant::now();
                let x = transform.scale(x.clone(), source)?;
                Ok(input(transform.input(), transform, x, start))
            }
        };
        self.plans.iter().map(fit).collect()
    }
}

fn done(transform: Transform, samples: &Samples) -> Result<Plan> {
    let start = Instant::now();
    let x = transform.apply(&samples.x, &samples.source)?;
    Ok(Plan::Done(input(transform.input(), transform, x, start)))
}

fn input(name: &'static str, transform: Transform, x: ArrayD<f32>, start: Instant) -> Input {
    let ms_per_sample = 1e3 * start.elapsed().as_secs_f64() / x.shape()[0].max(1) as f64;
    Input { name, transform, encoded: Rc::new(Encoded::new(x)), ms_per_sample }
}

fn field(image: &Image, method: Method) -> HardnessImage {
    let gaf = Gaf {
        size: image.size.unwrap_or(50),
        method,
        range: image.range.unwrap_or_default().into(),
        constant: image.constant.unwrap_or_default(),
    };
    HardnessImage { gaf, colormap: image.colormap.unwrap_or_default() }
}

/// `None` for a scale that is fitted per fold.
fn scaling(scale: Scale, experiment: &Experiment, samples: &Samples) -> Result<Option<Scaling>> {
    match (scale, samples.full_scale) {
        (Scale::ZScore, _) => Ok(None),
        (Scale::Raw, _) => Ok(Some(Scaling::Raw)),
        (Scale::FullScale, Some(full_scale)) => Ok(Some(Scaling::FullScale { full_scale })),
        (Scale::Imagenet, Some(full_scale)) => {
            let [mean, sd] = IMAGENET.map(|colours| colours.map(|v| v * full_scale).to_vec());
            Ok(Some(Scaling::ZScore { mean, sd }))
        }
        (Scale::FullScale | Scale::Imagenet, None) => Err(experiment.refuse(Problem {
            key: "data.full_scale".into(),
            value: "not set".into(),
            reason: format!(
                "the scale needs the largest possible reading of {}, such as 1023 for 10-bit \
                 counts or 255 for 8-bit images",
                samples.source
            ),
        })),
    }
}

fn encoding(source: &str, input: &'static str, error: taxel_encodings::Error) -> Error {
    Error::Encoding { source_label: source.into(), input, source: error }
}

fn axes_error(x: &ArrayD<f32>, input: &'static str, source: &str) -> Error {
    let shape = x.shape().get(1..).unwrap_or_default().to_vec();
    let reason = match input {
        SIGNAL => "a signal is [N, C, T] or [N, F]",
        TENSOR => "a tactile tensor is made of squeezes [N, T, H, W]",
        _ => {
            "a field and rows are made of [N, C, T]; samples that are images need encoding.image.kind = \"raw\" and \
              [N, H, W] or [N, C, H, W], squeezes \"frame\" and [N, T, H, W], NumaTac bits \"numatac\""
        }
    };
    Error::Axes { source_label: source.into(), input, shape, reason }
}

fn signal_axes(x: ArrayD<f32>, input: &'static str, source: &str) -> Result<ArrayD<f32>> {
    match x.ndim() {
        2 => Ok(x.insert_axis(Axis(1))),
        3 => Ok(x),
        _ => Err(axes_error(&x, input, source)),
    }
}

fn image_axes(x: ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
    match x.ndim() {
        3 => Ok(x.insert_axis(Axis(1))),
        4 => Ok(x),
        _ => Err(axes_error(&x, IMAGE, source)),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn what_lies_beyond_an_image_is_a_reading_of_zero() {
        let scaling = Scaling::ZScore { mean: vec![2.0, -1.0], sd: vec![4.0, 0.5] };
        let transform = Transform::Image(scaling);
        let zeros = transform.apply(&ArrayD::zeros(vec![1, 2, 1, 1]), "zeros").unwrap();
        assert_eq!(transform.rest().unwrap(), zeros.into_iter().collect::<Vec<f32>>());
        assert_eq!(Transform::Signal(Scaling::Raw).rest(), None);
    }
}
