//! A transform for readings of one shape: one raw reading to one input, without allocating.

use taxel_base::Layout;
use taxel_encodings::{
    CodePlan, ElectrodeImage, History, ImagePlan, NumaTac, OneFrame, ReductionPlan, ResizePlan, Scaling,
    TactileTensor,
};

use super::axes::{refused, wrong_axes};
use super::names::{IMAGE, SERIES, SIGNAL};
use super::rocket::RocketPlan;
use super::transform::Transform;
use crate::error::{Error, Result};

/// A [`Transform`] for readings of one shape, with the memory that it needs: each thread has its own.
///
/// Its inputs are those of [`Transform::apply`], bit for bit.
#[derive(Debug, Clone)]
pub struct Compiled {
    stages: Vec<Stage>,
    input: &'static str,
    /// Values of a raw reading.
    readings: usize,
    /// Shape of the input.
    shape: Vec<usize>,
    source: String,
}

/// One step, with what comes out of it; the last one writes where its caller says.
#[derive(Debug, Clone)]
struct Stage {
    work: Operation,
    values: Vec<f32>,
}

#[derive(Debug, Clone)]
enum Operation {
    Reduce(Box<ReductionPlan>),
    /// Takes the mean of the first readings off each row of this length.
    Baseline {
        readings: usize,
        length: usize,
    },
    /// The last of so many readings of each channel, and its differences.
    History {
        history: History,
        shape: [usize; 2],
    },
    /// Frames of so many pixels as one series per pixel.
    Series {
        pixels: usize,
    },
    Scale {
        scaling: Scaling,
        channels: usize,
    },
    Code(Box<CodePlan>),
    Rocket(Box<RocketPlan>),
    Field(Box<ImagePlan>),
    Frame {
        frame: OneFrame,
        shape: [usize; 3],
    },
    /// Grey as the red of three colours.
    Red,
    Resize(Box<ResizePlan>),
    Tensor {
        tensor: TactileTensor,
        shape: [usize; 3],
    },
    Numatac {
        numatac: NumaTac,
        shape: [usize; 3],
    },
    Electrodes {
        image: ElectrodeImage,
        shape: [usize; 3],
    },
}

impl Transform {
    /// Compiles the transform for raw samples of `shape`; `source` names them in messages.
    ///
    /// # Errors
    /// A shape that the transform does not take.
    pub fn compile(&self, shape: &[usize], source: &str) -> Result<Compiled> {
        let (input, readings) = (self.input(), shape.iter().product());
        let mut compiled = Compiled { stages: vec![], input, readings, shape: vec![], source: source.into() };
        compiled.shape = compiled.add(self, shape)?;
        Ok(compiled)
    }
}

impl Compiled {
    /// Returns the shape of the input.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Encodes one raw reading, row-major, into `input`.
    ///
    /// # Errors
    /// A reading of another length or one that cannot be encoded, an `input` of another length.
    pub fn encode(&mut self, reading: &[f32], input: &mut [f32]) -> Result<()> {
        let (name, source) = (self.input, &self.source);
        if reading.len() != self.readings {
            let (what, expected) = ("reading", format!("{} values", self.readings));
            let got = vec![reading.len()];
            return Err(refused(source, name, taxel_encodings::Error::Shape { what, expected, got }));
        }
        let Some((last, before)) = self.stages.split_last_mut() else {
            return Err(wrong_axes(&self.shape, name, source));
        };
        let mut from = reading;
        for Stage { work, values } in before {
            work.run(from, values).map_err(|e| refused(source, name, e))?;
            from = values;
        }
        last.work.run(from, input).map_err(|e| refused(source, name, e))
    }

    fn push(&mut self, work: Operation, shape: Vec<usize>) -> Vec<usize> {
        self.stages.push(Stage { work, values: vec![0.0; shape.iter().product()] });
        shape
    }

    /// Adds the stages of `transform` for values of `shape`; what shape comes out.
    fn add(&mut self, transform: &Transform, shape: &[usize]) -> Result<Vec<usize>> {
        let source = self.source.clone();
        let wrong = |input| wrong_axes(shape, input, &source);
        let refuse = |e| refused(&source, transform.input(), e);
        match (transform, shape) {
            // Features are one channel.
            (
                Transform::Signal(_)
                | Transform::QuantileCode(_)
                | Transform::Rocket(_)
                | Transform::Rows(_)
                | Transform::History { .. },
                &[length],
            ) => self.add(transform, &[1, length]),
            (Transform::Signal(scaling), &[channels, length]) => {
                Ok(self.push(scale(scaling, channels), vec![channels, length]))
            }
            (Transform::QuantileCode(_) | Transform::Rocket(_), &[channels, length]) => {
                self.features(transform, [channels, length])
            }
            (Transform::Rows(scaling), &[channels, length]) => {
                Ok(self.push(scale(scaling, channels), vec![1, channels, length]))
            }
            (Transform::Image(scaling), &[height, width]) => {
                Ok(self.push(scale(scaling, 1), vec![1, height, width]))
            }
            (Transform::Image(scaling), &[channels, ..]) if shape.len() == 3 => {
                Ok(self.push(scale(scaling, channels), shape.to_vec()))
            }
            (Transform::Field(field), &[_] | &[_, _]) => {
                let plan = field.plan(shape.iter().product()).map_err(refuse)?;
                Ok(self.push(Operation::Field(Box::new(plan)), field.shape().to_vec()))
            }
            (Transform::Picture { .. }, _) => self.picture(transform, shape),
            (
                Transform::Tensor { .. } | Transform::Numatac { .. } | Transform::Electrodes { .. },
                &[a, b, c],
            ) => self.arranged(transform, [a, b, c]),
            (Transform::Series { layout, then }, shape) => {
                let shape = self.series(*layout, shape).ok_or_else(|| wrong(SERIES))?;
                self.add(then, &shape)
            }
            (Transform::History { history, then }, &[channels, length]) => {
                let rows = self.history(history, [channels, length]).map_err(refuse)?;
                self.add(then, &rows)
            }
            (Transform::Baseline { readings, then }, shape) => {
                let shape = self.baseline(*readings, shape)?;
                self.add(then, &shape)
            }
            (Transform::Reduced { layout, reduction, then }, shape) => {
                let plan = reduction.plan(*layout, shape).map_err(refuse)?;
                let left = self.reduce(plan);
                self.add(then, &left)
            }
            _ => Err(wrong(transform.input())),
        }
    }

    /// Adds the stage of a code or of features of channels × time.
    fn features(&mut self, transform: &Transform, shape: [usize; 2]) -> Result<Vec<usize>> {
        let source = self.source.clone();
        match transform {
            Transform::QuantileCode(code) => {
                let plan = code.plan(shape[0], shape[1]).map_err(|e| refused(&source, SIGNAL, e))?;
                Ok(self.push(Operation::Code(Box::new(plan)), code.shape(shape[0], shape[1]).to_vec()))
            }
            Transform::Rocket(rocket) => {
                let plan = rocket.plan(shape, &source)?;
                Ok(self.push(Operation::Rocket(Box::new(plan)), vec![rocket.width()]))
            }
            _ => Err(wrong_axes(&shape, transform.input(), &source)),
        }
    }

    /// Adds the stage of the last readings and their differences.
    fn history(&mut self, history: &History, shape: [usize; 2]) -> taxel_encodings::Result<Vec<usize>> {
        history.check(shape[1])?;
        let work = Operation::History { history: history.clone(), shape };
        Ok(self.push(work, history.shape(shape[0]).to_vec()))
    }

    /// Adds the stage that leaves out a part of a sample.
    fn reduce(&mut self, plan: ReductionPlan) -> Vec<usize> {
        let left = plan.shape().to_vec();
        self.push(Operation::Reduce(Box::new(plan)), left)
    }

    /// Adds the stage that takes the mean of the first `readings` off each channel.
    fn baseline(&mut self, readings: usize, shape: &[usize]) -> Result<Vec<usize>> {
        match *shape {
            [channels, length] if length >= readings => {
                Ok(self.push(Operation::Baseline { readings, length }, vec![channels, length]))
            }
            _ => {
                let reason = "encoding.baseline needs [N, C, T] with at least as many readings";
                let source_label = self.source.clone();
                Err(Error::Axes { source_label, input: SIGNAL, shape: shape.to_vec(), reason })
            }
        }
    }

    /// Adds the stages of a transform that arranges the values of three axes anew and scales them.
    fn arranged(&mut self, transform: &Transform, shape: [usize; 3]) -> Result<Vec<usize>> {
        let (work, to, scaling, channels) = match transform {
            Transform::Tensor { tensor, scaling } => {
                let [frames, rows, columns] = shape;
                let to = vec![1, rows, columns, tensor.frames.unwrap_or(frames)];
                (Operation::Tensor { tensor: *tensor, shape }, to, scaling, 1)
            }
            Transform::Numatac { numatac, scaling } => {
                let [fingers, features, _] = shape;
                let to = vec![fingers, features, numatac.window];
                (Operation::Numatac { numatac: *numatac, shape }, to, scaling, fingers * features)
            }
            Transform::Electrodes { image, scaling } => {
                let to = image.shape().to_vec();
                let channels = to[0];
                (Operation::Electrodes { image: *image, shape }, to, scaling, channels)
            }
            _ => return Err(wrong_axes(&shape, transform.input(), &self.source)),
        };
        let to = self.push(work, to);
        Ok(self.push(scale(scaling, channels), to))
    }

    fn picture(&mut self, transform: &Transform, shape: &[usize]) -> Result<Vec<usize>> {
        let source = self.source.clone();
        let wrong = || wrong_axes(shape, IMAGE, &source);
        let Transform::Picture { frame, red, resize, scaling } = transform else { return Err(wrong()) };
        let mut image = match (frame, shape) {
            (None, &[height, width]) => [1, height, width],
            (None, &[channels, height, width]) => [channels, height, width],
            (Some(frame), &[frames, height, width]) => {
                let work = Operation::Frame { frame: *frame, shape: [frames, height, width] };
                self.push(work, vec![1, height, width]);
                [1, height, width]
            }
            _ => return Err(wrong()),
        };
        if *red && image[0] == 1 {
            image[0] = 3;
            self.push(Operation::Red, image.to_vec());
        }
        if let Some(resize) = resize {
            let plan = resize.plan(image).map_err(|e| refused(&source, IMAGE, e))?;
            image = [image[0], resize.height, resize.width];
            self.push(Operation::Resize(Box::new(plan)), image.to_vec());
        }
        Ok(self.push(scale(scaling, image[0]), image.to_vec()))
    }

    /// Takes samples of any layout as channels × time and returns their shape; none where the axes are others.
    fn series(&mut self, layout: Layout, shape: &[usize]) -> Option<Vec<usize>> {
        Some(match (layout, shape) {
            (Layout::Features, &[length]) => vec![1, length],
            (Layout::Series | Layout::Image, &[channels, length]) => vec![channels, length],
            (Layout::Colour | Layout::Fingers, &[a, b, length]) => vec![a * b, length],
            (Layout::Sequence, &[frames, rows, columns]) => {
                self.push(Operation::Series { pixels: rows * columns }, vec![rows * columns, frames])
            }
            _ => return None,
        })
    }
}

fn scale(scaling: &Scaling, channels: usize) -> Operation {
    Operation::Scale { scaling: scaling.clone(), channels }
}

impl Operation {
    fn run(&mut self, from: &[f32], to: &mut [f32]) -> taxel_encodings::Result<()> {
        match self {
            Operation::Reduce(plan) => plan.apply(from, to)?,
            Operation::Baseline { readings, length } => {
                for (from, to) in from.chunks_exact(*length).zip(to.chunks_exact_mut(*length)) {
                    let sum: f64 = from.iter().take(*readings).map(|&v| f64::from(v)).sum();
                    let mean = (sum / *readings as f64) as f32;
                    to.iter_mut().zip(from).for_each(|(to, v)| *to = v - mean);
                }
            }
            Operation::History { history, shape } => history.encode(*shape, from, to)?,
            Operation::Series { pixels } => {
                let frames = from.len() / *pixels;
                for (t, frame) in from.chunks_exact(*pixels).enumerate() {
                    to[t..].iter_mut().step_by(frames).zip(frame).for_each(|(to, v)| *to = *v);
                }
            }
            Operation::Scale { scaling, channels } => scaling.encode(*channels, from, to)?,
            Operation::Code(plan) => plan.encode(from, to)?,
            Operation::Rocket(plan) => plan.encode(from, to)?,
            Operation::Field(plan) => plan.encode(from, to)?,
            Operation::Frame { frame, shape } => {
                let at = frame.pick_of(*shape, from)?;
                to.copy_from_slice(&from[at * to.len()..][..to.len()]);
            }
            Operation::Red => {
                let (red, rest) = to.split_at_mut(from.len());
                red.copy_from_slice(from);
                rest.fill(0.0);
            }
            Operation::Resize(plan) => plan.encode(from, to)?,
            Operation::Tensor { tensor, shape } => tensor.encode_into(*shape, from, to)?,
            Operation::Numatac { numatac, shape } => numatac.encode_into(*shape, from, to)?,
            Operation::Electrodes { image, shape } => image.encode_frames(*shape, from, to)?,
        }
        Ok(())
    }
}
