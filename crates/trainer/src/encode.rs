//! From samples to the inputs that networks read, fold by fold.
//!
//! What needs no fitting is computed once; what does (z-scores) is fitted on the training part of
//! each fold. What was fitted is a [`Transform`], saved with the network and enough to encode new
//! recordings.

use std::rc::Rc;
use std::time::Instant;

use ndarray::{ArrayD, Axis, Ix3};
use serde::{Deserialize, Serialize};
use taxel_encodings::{Gaf, HardnessImage, Method, Scaling};

use crate::config::{Image, ImageKind, Problem, Scale};
use crate::error::{Error, Result};
use crate::experiment::Experiment;
use crate::samples::Samples;

/// Input of 1D networks: channels × time.
pub const SIGNAL: &str = "signal";
/// Input of 2D networks: channels × rows × columns.
pub const IMAGE: &str = "image";

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
}

impl Transform {
    /// Encodes raw samples `[N, ..]`; `source` names them in messages.
    ///
    /// # Errors
    /// Samples with other axes than the transform takes, or readings that cannot be encoded.
    pub fn apply(&self, x: &ArrayD<f32>, source: &str) -> Result<ArrayD<f32>> {
        let (name, scaling) = match self {
            Transform::Field(field) => {
                let x = signal_axes(x.clone(), IMAGE, source)?;
                let wrong = || axes_error(&x, IMAGE, source);
                let x = x.view().into_dimensionality::<Ix3>().map_err(|_| wrong())?;
                let images = field.encode_batch(x).map_err(|e| encoding(source, IMAGE, e))?;
                return Ok(images.into_dyn());
            }
            Transform::Signal(scaling) => (SIGNAL, scaling),
            Transform::Image(scaling) => (IMAGE, scaling),
        };
        let mut x = match name {
            SIGNAL => signal_axes(x.clone(), SIGNAL, source)?,
            _ => image_axes(x.clone(), source)?,
        };
        scaling.apply(&mut x).map_err(|e| encoding(source, name, e))?;
        Ok(x)
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
    /// Z-scores of samples with the axes of the input.
    Fit { name: &'static str, x: ArrayD<f32> },
}

impl<'a> Encoder<'a> {
    /// Prepares the inputs in `wanted`; what needs no fitting is encoded now.
    ///
    /// # Errors
    /// Samples with the wrong axes, readings that cannot be encoded, or a full scale that nobody
    /// names.
    pub fn new(experiment: &Experiment, samples: &'a Samples, wanted: &[&str]) -> Result<Self> {
        let encoding = &experiment.config().encoding;
        let mut plans = vec![];
        if wanted.contains(&SIGNAL) {
            let scaling = scaling(encoding.signal.scale, experiment, samples)?;
            plans.push(match scaling {
                Some(scaling) => done(SIGNAL, Transform::Signal(scaling), samples)?,
                None => {
                    Plan::Fit { name: SIGNAL, x: signal_axes(samples.x.clone(), SIGNAL, &samples.source)? }
                }
            });
        }
        if let Some(image) = &encoding.image
            && wanted.contains(&IMAGE)
        {
            let transform = match image.kind {
                ImageKind::Raw => scaling(image.scale.unwrap_or(Scale::FullScale), experiment, samples)?
                    .map(Transform::Image),
                ImageKind::Gadf => Some(Transform::Field(field(image, Method::Difference))),
                ImageKind::Gasf => Some(Transform::Field(field(image, Method::Summation))),
            };
            plans.push(match transform {
                Some(transform) => done(IMAGE, transform, samples)?,
                None => Plan::Fit { name: IMAGE, x: image_axes(samples.x.clone(), &samples.source)? },
            });
        }
        Ok(Encoder { samples, plans })
    }

    /// Shape of one sample of input `name`, if the experiment makes it.
    pub fn shape(&self, name: &str) -> Option<Vec<usize>> {
        self.plans.iter().find_map(|plan| match plan {
            Plan::Done(input) => (input.name == name).then(|| input.encoded.shape().to_vec()),
            Plan::Fit { name: own, x } => (*own == name).then(|| x.shape()[1..].to_vec()),
        })
    }

    /// The inputs with everything fitted on the samples in `train` alone.
    ///
    /// # Errors
    /// Readings that are not finite.
    pub fn fit(&self, train: &[usize]) -> Result<Vec<Input>> {
        let fit = |plan: &Plan| match plan {
            Plan::Done(input) => Ok(input.clone()),
            Plan::Fit { name, x } => {
                let refuse = |e| encoding(&self.samples.source, name, e);
                let scaling = Scaling::fit_z_score(x.select(Axis(0), train).view()).map_err(refuse)?;
                let start = Instant::now();
                let mut x = x.clone();
                scaling.apply(&mut x).map_err(refuse)?;
                let transform = match *name {
                    SIGNAL => Transform::Signal(scaling),
                    _ => Transform::Image(scaling),
                };
                Ok(input(name, transform, x, start))
            }
        };
        self.plans.iter().map(fit).collect()
    }
}

fn done(name: &'static str, transform: Transform, samples: &Samples) -> Result<Plan> {
    let start = Instant::now();
    let x = transform.apply(&samples.x, &samples.source)?;
    Ok(Plan::Done(input(name, transform, x, start)))
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
        (Scale::FullScale, None) => Err(experiment.refuse(Problem {
            key: "data.full_scale".into(),
            value: "not set".into(),
            reason: format!(
                "scale = \"full-scale\" needs the largest possible reading of {}, such as 1023 for 10-bit \
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
        _ => {
            "a field is made of [N, C, T]; samples that are images need encoding.image.kind = \"raw\" and \
              [N, H, W] or [N, C, H, W]"
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
