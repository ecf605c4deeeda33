//! A data set's samples as the inputs of networks, fold by fold.

use std::sync::Arc;
use std::time::Instant;

use ndarray::{ArrayD, Axis};
use taxel_base::Layout;
use taxel_data::Dataset;
use taxel_encodings::{ElectrodeImage, Method, NumaTac, QuantileCode, Resize, Scaling, TactileTensor};
use taxel_guard::Guard;

use super::guarding::{fitted_guard, mended};
use super::names::{IMAGE, INPUTS, ROCKET, SERIES, SIGNAL, TENSOR};
use super::rocket::{Rocket, RocketSettings};
use super::scale::{Scale, Scaled};
use super::settings::{Electrodes, Encoding, Image, PictureSettings, SqueezeFrame, reduction_problem};
use super::signal::{Code, Signal};
use super::transform::Transform;

use crate::error::Result;
use crate::problem::Problem;

/// Mean and SD of ImageNet's red, green and blue in 0..1, as torchvision takes them.
const IMAGENET: [[f32; 3]; 2] = [[0.485, 0.456, 0.406], [0.229, 0.224, 0.225]];

/// Inputs of all samples under one name, row-major, PyTorch's axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded {
    shape: Vec<usize>,
    values: Vec<f32>,
}

impl Encoded {
    pub(crate) fn new(x: ArrayD<f32>) -> Self {
        let shape = x.shape().get(1..).unwrap_or_default().to_vec();
        let x = if x.is_standard_layout() { x } else { x.as_standard_layout().into_owned() };
        let (mut values, offset) = x.into_raw_vec_and_offset();
        values.drain(..offset.unwrap_or(0));
        Encoded { shape, values }
    }

    /// Returns the shape of one sample.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Returns the number of values of one sample.
    pub(crate) fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Returns the values of sample `i`; empty where there is no such sample.
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

/// One input, fitted for a fold.
#[derive(Debug, Clone)]
pub struct Input {
    /// `signal`, `image`, `tensor`, `rocket` or `series`.
    pub name: &'static str,
    /// How it was made.
    pub transform: Transform,
    /// The input of every sample, training and test.
    pub encoded: Arc<Encoded>,
    /// Time to encode one sample, in ms, averaged over all.
    pub ms_per_sample: f64,
    /// Values beyond the edges of its images, per channel: the sensor at rest. None where it has no edges.
    pub outside: Option<Vec<f32>>,
    /// The guard before it, where the encoding asks for one.
    pub guard: Option<Arc<Guard>>,
}

/// The inputs of one data set.
pub struct Encoder<'a> {
    encoding: Encoding,
    dataset: &'a Dataset,
    source: String,
    plans: Vec<InputPlan>,
}

enum InputPlan {
    /// The same in every fold.
    Done(Input),
    /// Samples with the axes that the fit takes.
    Fit { name: &'static str, transform: Transform, x: ArrayD<f32> },
}

impl<'a> Encoder<'a> {
    /// Makes an encoder that has made nothing yet.
    pub fn new(encoding: &Encoding, dataset: &'a Dataset) -> Self {
        Encoder { encoding: encoding.clone(), dataset, source: dataset.source.to_string(), plans: vec![] }
    }

    /// Makes the inputs of a model by what was fitted for it: nothing is fitted anew.
    ///
    /// # Errors
    /// Readings that cannot be encoded, an input that no encoding makes.
    pub(crate) fn of_inputs<'t>(
        dataset: &'a Dataset,
        inputs: impl Iterator<Item = (&'t str, &'t Transform)>,
        guard: Option<Guard>,
    ) -> Result<Self> {
        let mut encoder = Self::new(&Encoding::default(), dataset);
        let guard = guard.map(Arc::new);
        let behind = guard.as_ref().map(|guard| mended(guard, &dataset.x).0);
        let samples = behind.as_ref().unwrap_or(&dataset.x);
        for (name, transform) in inputs {
            let known = INPUTS.into_iter().find(|known| *known == name);
            let name = known.ok_or_else(|| Problem::new("input", name, "is made by no encoding"))?;
            let start = Instant::now();
            let x = transform.apply(samples, &encoder.source)?;
            let input = encoder.input(name, transform.clone(), x, start)?;
            encoder.plans.push(InputPlan::Done(Input { guard: guard.clone(), ..input }));
        }
        Ok(encoder)
    }

    /// Returns the samples.
    pub fn dataset(&self) -> &'a Dataset {
        self.dataset
    }

    /// Checks whether pixels or taxels lie side by side as on the sensor, so that they can be moved.
    pub(crate) fn is_warpable(&self) -> bool {
        self.encoding.is_warpable()
    }

    /// Prepares the inputs in `names` that are not there yet; what needs no fitting is encoded now. An input
    /// that the encoding does not make is left out: [`Encoder::shape`] knows no shape of it.
    ///
    /// # Errors
    /// Samples with the wrong axes, readings that cannot be encoded, or a full scale that nobody
    /// names.
    pub fn prepare(&mut self, names: &[&str]) -> Result<()> {
        let baseline = self.encoding.baseline;
        let missing = |encoder: &Self, name| names.contains(&name) && encoder.shape(name).is_none();
        let layout = self.dataset.spec.layout;
        // The channels of all fingers side by side.
        let flat = |then: Transform| match layout {
            Layout::Fingers => Transform::Series { layout, then: Box::new(then) },
            _ => then,
        };
        if missing(self, SIGNAL) {
            match self.encoding.signal.clone() {
                Signal::Scaled(Scaled { scale }) => match self.scaling(scale)? {
                    Some(scaling) => {
                        self.encode_now(SIGNAL, flat(Transform::Signal(scaling).less(baseline)))?
                    }
                    None => self.fit_later(SIGNAL, flat(Transform::Signal(Scaling::Raw).less(baseline)))?,
                },
                Signal::History(history) => {
                    let scaled = Box::new(Transform::Signal(Scaling::Raw));
                    let history = Transform::History { history, then: scaled };
                    self.fit_later(SIGNAL, flat(history.less(baseline)))?;
                }
                Signal::QuantileCode(Code { ramps, steps }) => {
                    let code = Transform::QuantileCode(QuantileCode::new(ramps, steps));
                    self.fit_later(SIGNAL, flat(code.less(baseline)))?;
                }
            }
        }
        if let Some(RocketSettings { features }) = self.encoding.rocket.filter(|_| missing(self, ROCKET)) {
            let rocket = Transform::Rocket(Box::new(Rocket::new(features)));
            self.fit_later(ROCKET, flat(rocket.less(baseline)))?;
        }
        if let Some(tensor) = self.encoding.tensor.filter(|_| missing(self, TENSOR)) {
            let frames = TactileTensor { frames: tensor.frames };
            self.plan(tensor.scale, baseline, |scaling| Transform::Tensor { tensor: frames, scaling })?;
        }
        if let Some(image) = self.encoding.image.clone().filter(|_| missing(self, IMAGE)) {
            self.image(&image, baseline)?;
        }
        if missing(self, SERIES) {
            let signal = Transform::Signal(Scaling::Raw);
            let transform = match baseline {
                Some(_) => signal.less(baseline),
                None => Transform::Series { layout, then: Box::new(signal) },
            };
            self.fit_later(SERIES, transform)?;
        }
        Ok(())
    }

    fn image(&mut self, image: &Image, baseline: Option<usize>) -> Result<()> {
        match *image {
            Image::Raw(PictureSettings { scale, resize: None, red: false }) => {
                self.plan(scale, baseline, Transform::Image)
            }
            Image::Raw(PictureSettings { scale, resize, red }) => {
                let resize = resize.map(bilinear);
                self.plan(scale, baseline, |scaling| Transform::Picture { frame: None, red, resize, scaling })
            }
            Image::Frame(SqueezeFrame { frame, scale, resize, red }) => {
                let (frame, resize) = (Some(frame), resize.map(bilinear));
                self.plan(scale, baseline, |scaling| Transform::Picture { frame, red, resize, scaling })
            }
            Image::Rows(rows) => self.plan(rows.scale, baseline, Transform::Rows),
            Image::Numatac(bits) => {
                let numatac = NumaTac { window: bits.window, ..NumaTac::default() };
                self.plan(Scale::ZScore, baseline, |scaling| Transform::Numatac { numatac, scaling })
            }
            Image::Electrodes(Electrodes { order, scale }) => self.plan(scale, baseline, |scaling| {
                Transform::Electrodes { image: ElectrodeImage { order }, scaling }
            }),
            Image::Gadf(field) => {
                self.encode_now(IMAGE, Transform::Field(field.image(Method::Difference)?).less(baseline))
            }
            Image::Gasf(field) => {
                self.encode_now(IMAGE, Transform::Field(field.image(Method::Summation)?).less(baseline))
            }
        }
    }

    /// Encodes now, unless the scale has to be fitted.
    fn plan(
        &mut self,
        scale: Scale,
        baseline: Option<usize>,
        with: impl Fn(Scaling) -> Transform,
    ) -> Result<()> {
        let name = with(Scaling::Raw).input();
        match self.scaling(scale)? {
            Some(scaling) => self.encode_now(name, with(scaling).less(baseline)),
            None => self.fit_later(name, with(Scaling::Raw).less(baseline)),
        }
    }

    /// Returns the transform that applies `then` to the part of a sample that the encoding leaves.
    fn reduced(&self, then: Transform) -> Result<Transform> {
        let (reduction, spec) = (&self.encoding.reduce, &self.dataset.spec);
        if reduction.is_whole() {
            return Ok(then);
        }
        reduction
            .plan(spec.layout, &spec.shape)
            .map_err(|error| reduction_problem(error).below("encoding"))?;
        let (layout, reduction) = (spec.layout, reduction.clone());
        Ok(Transform::Reduced { layout, reduction, then: Box::new(then) })
    }

    fn encode_now(&mut self, name: &'static str, transform: Transform) -> Result<()> {
        let transform = self.reduced(transform)?;
        let start = Instant::now();
        let x = transform.apply(&self.dataset.x, &self.source)?;
        let input = self.input(name, transform, x, start)?;
        self.plans.push(InputPlan::Done(input));
        Ok(())
    }

    fn fit_later(&mut self, name: &'static str, transform: Transform) -> Result<()> {
        let transform = self.reduced(transform)?;
        let x = transform.shape(&self.dataset.x, &self.source)?;
        self.plans.push(InputPlan::Fit { name, transform, x });
        Ok(())
    }

    /// Takes the values that `transform` has made of all samples since `start`.
    fn input(
        &self,
        name: &'static str,
        transform: Transform,
        x: ArrayD<f32>,
        start: Instant,
    ) -> Result<Input> {
        let ms_per_sample = 1e3 * start.elapsed().as_secs_f64() / x.shape()[0].max(1) as f64;
        let sample = &self.dataset.x.shape()[1..];
        let outside = transform.at_rest(sample, self.dataset.spec.mean_at_rest(), &self.source)?;
        Ok(Input { name, transform, encoded: Arc::new(Encoded::new(x)), ms_per_sample, outside, guard: None })
    }

    /// Returns the scaling of a `scale`; `None` for one that is fitted per fold.
    fn scaling(&self, scale: Scale) -> Result<Option<Scaling>> {
        match (scale, self.dataset.spec.full_scale) {
            (Scale::ZScore, _) => Ok(None),
            (Scale::Raw, _) => Ok(Some(Scaling::Raw)),
            (Scale::FullScale, Some(full_scale)) => Ok(Some(Scaling::FullScale { full_scale })),
            (Scale::Imagenet, Some(full_scale)) => {
                let [mean, sd] = IMAGENET.map(|colours| colours.map(|v| v * full_scale).to_vec());
                Ok(Some(Scaling::ZScore { mean, sd }))
            }
            (Scale::FullScale | Scale::Imagenet, None) => {
                let reason = format!(
                    "the scale needs the largest possible reading of {}, such as 1023 for 10-bit counts or 255 \
                     for 8-bit images",
                    self.source
                );
                Err(Problem::new("data.full_scale", "not set", reason).into())
            }
        }
    }

    /// Returns the shape of one sample of input `name`, if the encoding makes it.
    pub fn shape(&self, name: &str) -> Option<Vec<usize>> {
        self.plans.iter().find(|plan| plan.name() == name).map(|plan| match plan {
            InputPlan::Done(input) => input.encoded.shape().to_vec(),
            InputPlan::Fit { transform, x, .. } => transform.scaled_shape(&x.shape()[1..]),
        })
    }

    /// Returns the inputs in `names` with everything fitted on the samples in `train` alone.
    ///
    /// # Errors
    /// Readings that are not finite.
    pub fn fit(&self, names: &[&str], train: &[usize]) -> Result<Vec<Input>> {
        let fit = |plan: &InputPlan| match plan {
            InputPlan::Done(input) => Ok(input.clone()),
            InputPlan::Fit { name, transform, x } => {
                let transform = transform.fitted(x.select(Axis(0), train).view(), &self.source)?;
                let start = Instant::now();
                let x = transform.scale(x.clone(), &self.source)?;
                self.input(name, transform, x, start)
            }
        };
        let wanted = self.plans.iter().filter(|plan| names.contains(&plan.name()));
        let mut inputs = wanted.map(fit).collect::<Result<Vec<Input>>>()?;
        if self.encoding.guard {
            self.guarded(&mut inputs, train)?;
        }
        Ok(inputs)
    }

    /// Fits a guard to the samples in `train` and puts what it makes of all others in the place of these.
    fn guarded(&self, inputs: &mut [Input], train: &[usize]) -> Result<()> {
        let guard = Arc::new(fitted_guard(self.dataset, train)?);
        let mut is_train = vec![false; self.dataset.len()];
        train.iter().for_each(|&row| is_train[row] = true);
        let others: Vec<usize> = (0..is_train.len()).filter(|row| !is_train[*row]).collect();
        let (x, found) = mended(&guard, &self.dataset.x.select(Axis(0), &others));
        let broken: Vec<usize> = (0..others.len()).filter(|at| !found[*at].is_empty()).collect();
        let x = (!broken.is_empty()).then(|| x.select(Axis(0), &broken));
        for input in inputs {
            if let Some(x) = &x {
                let replaced = Encoded::new(input.transform.apply(x, &self.source)?);
                let all = Arc::make_mut(&mut input.encoded);
                let len = all.len();
                for (at, sample) in broken.iter().zip(replaced.values.chunks_exact(len.max(1))) {
                    all.values[others[*at] * len..][..len].copy_from_slice(sample);
                }
            }
            input.guard = Some(guard.clone());
        }
        Ok(())
    }
}

impl InputPlan {
    fn name(&self) -> &'static str {
        match self {
            InputPlan::Done(input) => input.name,
            InputPlan::Fit { name, .. } => name,
        }
    }
}

fn bilinear([height, width]: [usize; 2]) -> Resize {
    Resize { height, width, filter: Default::default() }
}
