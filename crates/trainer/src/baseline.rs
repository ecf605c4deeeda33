//! Baselines on the folds of the networks.

use std::time::Instant;

use ndarray::{ArrayD, Axis};
use taxel_baselines::{Fitted, Method, Series};
use taxel_data::Fold;
use taxel_encodings::Scaling;
use taxel_graph::{Tensor, Weights};

use crate::config::{Config, ImageKind};
use crate::encode::{Transform, less_baseline};
use crate::error::{Error, Result};
use crate::labels::Labels;
use crate::metrics::log_loss;
use crate::predictor::side_by_side;
use crate::results::Costs;
use crate::train::Latency;

/// What baselines read: recordings `[N, channels, length]` as they are; every channel is scaled by the mean
/// and deviation of the training part, after `encoding.baseline`.
pub(crate) struct Readings {
    x: ArrayD<f32>,
}

/// A fitted baseline's answers.
pub(crate) struct Outcome {
    pub weights: Weights,
    pub transform: Transform,
    pub probabilities: Vec<f32>,
    pub test_loss: f64,
    pub costs: Costs,
    pub train_seconds: f64,
    pub test_seconds: f64,
    pub latency: Option<Latency>,
}

impl Readings {
    /// Rows of an image and taxels of a frame become channels: `[C, T]` stays, images `[H, W]` are H
    /// channels, colour images `[C, H, W]` C·H, frames `[T, H, W]` H·W channels of length T.
    ///
    /// # Errors
    /// Recordings that have no baseline; `source` names them in the message.
    pub fn of(x: &ArrayD<f32>, config: &Config, source: &str) -> Result<Self> {
        if let Some(readings) = config.encoding.baseline {
            return Ok(Readings { x: less_baseline(x.clone(), readings, source)? });
        }
        let is_image = config.encoding.image.as_ref().is_some_and(|image| image.kind == ImageKind::Raw);
        let x = x.view();
        let shape = match *x.shape() {
            [n, length] => vec![n, 1, length],
            [n, channels, length] => vec![n, channels, length],
            [n, a, b, c] if is_image => vec![n, a * b, c],
            [n, frames, rows, columns] => vec![n, rows * columns, frames],
            ref other => vec![other.first().copied().unwrap_or(0), 1, other.iter().skip(1).product()],
        };
        let turned = x.ndim() == 4 && !is_image;
        let x = if turned { x.permuted_axes(vec![0, 2, 3, 1]) } else { x };
        let values: Vec<f32> = x.iter().copied().collect();
        // The shape has as many values: a failure leaves nothing to baseline.
        Ok(Readings { x: ArrayD::from_shape_vec(shape, values).unwrap_or_default() })
    }

    /// Channels and length of a recording.
    pub fn shape(&self) -> [usize; 2] {
        let axis = |i: usize| self.x.shape().get(i).copied().unwrap_or(0);
        [axis(1), axis(2)]
    }

    /// The recordings.
    pub fn into_array(self) -> ArrayD<f32> {
        self.x
    }

    /// Why `method` cannot be fitted to `samples` of these recordings, if so.
    pub fn unfit(&self, method: &Method, samples: usize) -> Option<String> {
        method.unfit(samples, self.x.shape().last().copied().unwrap_or(0))
    }
}

/// Fits `method` to the fold's training part and asks it about the test part.
///
/// # Errors
/// What the method refuses.
pub(crate) fn run(
    method: &Method,
    readings: &Readings,
    labels: &Labels,
    fold: &Fold,
    (seed, purpose): (u64, &str),
    with_latency: bool,
) -> Result<Outcome> {
    let refuse = |source| Error::Baseline { baseline: method.name().into(), source };
    let encoding = |source| Error::Encoding { source_label: "readings".into(), input: "series", source };
    let start = Instant::now();
    let train = readings.x.select(Axis(0), &fold.train);
    let scaling = Scaling::fit_z_score(train.view()).map_err(encoding)?;
    let scaled = |rows: &[usize]| -> Result<Vec<f32>> {
        let mut x = readings.x.select(Axis(0), rows);
        scaling.apply(&mut x).map_err(encoding)?;
        Ok(x.into_iter().collect())
    };
    let (channels, length) = (readings.x.shape()[1], readings.x.shape()[2]);
    let train = scaled(&fold.train)?;
    let train = Series::new(&train, channels, length).map_err(refuse)?;
    let truth = labels.of(&fold.train);
    let width = labels.attributes().len();
    let mut machines: Vec<Fitted> = vec![];
    for (i, attribute) in labels.attributes().iter().enumerate() {
        let y: Vec<u32> = truth.iter().skip(i).step_by(width).copied().collect();
        let purpose = format!("{purpose}/{i}");
        machines.push(method.fit(&train, &y, attribute.classes.len(), seed, &purpose).map_err(refuse)?);
    }
    let train_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let test = scaled(&fold.test)?;
    let test = Series::new(&test, channels, length).map_err(refuse)?;
    let answer = |x: &Series| -> Result<Vec<Vec<f32>>> {
        machines.iter().map(|machine| machine.scores(x).map_err(refuse)).collect()
    };
    let scores = answer(&test)?;
    let test_seconds = start.elapsed().as_secs_f64();
    let sizes = labels.levels();
    let probabilities = side_by_side(&scores, sizes.sizes(), test.len());
    let mut test_loss = 0.0;
    let truth = labels.of(&fold.test);
    for (i, (own, attribute)) in scores.iter().zip(labels.attributes()).enumerate() {
        let y: Vec<u32> = truth.iter().skip(i).step_by(width).copied().collect();
        test_loss += log_loss(own, &y, attribute.classes.len())? / width as f64;
    }
    let latency = match with_latency {
        true => {
            let one = Series::new(test.sample(0), channels, length).map_err(refuse)?;
            // As the networks: one sample, one thread.
            let pool = pool(1)?;
            Some(pool.install(|| Latency::of(|| answer(&one)))?)
        }
        false => None,
    };
    let mut weights = Weights::new();
    for (machine, attribute) in machines.iter().zip(labels.attributes()) {
        for (name, shape, data) in machine.tensors() {
            let name = if width > 1 { format!("{}.{name}", attribute.name) } else { name.into() };
            weights.insert(&name, Tensor { shape, data });
        }
    }
    let sum = |cost: fn(&Fitted) -> u64| machines.iter().map(cost).sum::<u64>();
    let parameters = sum(Fitted::parameters);
    let macs = sum(Fitted::macs);
    Ok(Outcome {
        weights,
        transform: Transform::Signal(scaling),
        probabilities,
        test_loss,
        costs: Costs { parameters, bytes: 4 * parameters, macs, flops: 2 * macs },
        train_seconds,
        test_seconds,
        latency,
    })
}

/// Threads for the baselines of a run.
pub(crate) fn pool(threads: usize) -> Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| taxel_engine::Error::Threads { threads, reason: e.to_string() }.into())
}
