//! MiniRocket: shares of positive values behind 84 fixed convolutions at many dilations.
//!
//! # Reference
//! Dempster, Schmidt & Webb, KDD 2021 (MiniRocket), and the authors' multivariate code: kernels of length
//! 9 with three weights 2 and six −1; dilations spread exponentially up to the series' length; biases are
//! quantiles of the convolution of a training recording; every feature is the share of positions where
//! the convolution lies above a bias. With several channels each kernel reads a few of them, drawn once.
//!
//! # Departures
//! Random choices (which recording, which channels) come from taxel's generator.

use rand::RngExt;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use taxel_kernels::rocket::{Dilated, LONGEST, Rocket, RocketMemory};

use crate::{Error, FeatureMatrix, Result, Saved, Series};

/// Length of a kernel.
pub(crate) const KERNEL: usize = 9;
/// Kernels: the ways to choose 3 of 9 places.
const KERNELS: usize = 84;
/// The most dilations of a kernel.
const DILATIONS: usize = 32;
/// The most channels that one kernel reads.
const CHANNELS: usize = 9;

/// The random choices of MiniRocket, dilation after dilation, 84 kernels each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Draws {
    /// The training recording whose convolution gives the biases.
    pub examples: Vec<usize>,
    /// The channels that are read.
    pub channels: Vec<Vec<usize>>,
}

/// A fitted transform. As JSON it holds everything that was drawn and fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RocketParts", into = "RocketParts")]
pub struct MiniRocket {
    shape: [usize; 2],
    /// Dilation, and features of each kernel at it.
    dilations: Vec<(usize, usize)>,
    /// Channels of each dilation's kernels.
    channels: Vec<Vec<usize>>,
    biases: Vec<f32>,
    /// All of it, as the kernels read it.
    rocket: Rocket,
}

/// Kernels and biases of a transform.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RocketParts {
    shape: [usize; 2],
    dilations: Vec<(usize, usize)>,
    channels: Vec<Vec<usize>>,
    biases: Vec<f32>,
}

impl From<MiniRocket> for RocketParts {
    fn from(MiniRocket { shape, dilations, channels, biases, .. }: MiniRocket) -> Self {
        RocketParts { shape, dilations, channels, biases }
    }
}

impl TryFrom<RocketParts> for MiniRocket {
    type Error = Error;

    fn try_from(RocketParts { shape, dilations, channels, biases }: RocketParts) -> Result<Self> {
        let fits = |&(dilation, _): &(usize, usize)| {
            dilation > 0 && dilation <= (shape[1].max(1) - 1) / (KERNEL - 1) && shape[1] < LONGEST
        };
        let features = dilations.iter().try_fold(0usize, |sum, (_, count)| sum.checked_add(*count));
        let is_whole = !dilations.is_empty()
            && dilations.iter().all(fits)
            && channels.len() == dilations.len() * KERNELS
            && channels.iter().all(|read| !read.is_empty() && read.iter().all(|&c| c < shape[0]))
            && features.and_then(|each| each.checked_mul(KERNELS)) == Some(biases.len());
        if is_whole {
            Ok(MiniRocket::new(shape, dilations, channels, biases))
        } else {
            Err(Error::Saved { tensor: "rocket".into(), reason: "does not fit the series" })
        }
    }
}

/// Lists the three places of weight 2 of each kernel, in the authors' order.
fn places() -> Vec<[usize; 3]> {
    let mut places = Vec::with_capacity(KERNELS);
    for a in 0..KERNEL {
        for b in a + 1..KERNEL {
            places.extend((b + 1..KERNEL).map(|c| [a, b, c]));
        }
    }
    places
}

/// Lists the dilations for series of `length`, with the features that one kernel has at each.
fn dilations(length: usize, features: usize) -> Vec<(usize, usize)> {
    let per_kernel = (features / KERNELS).max(1);
    let most = per_kernel.min(DILATIONS);
    let multiplier = per_kernel as f64 / most as f64;
    let exponent = ((length - 1) as f64 / (KERNEL - 1) as f64).log2();
    let mut found: Vec<(usize, usize)> = vec![];
    for i in 0..most {
        let share = if most > 1 { i as f64 / (most - 1) as f64 } else { 0.0 };
        let dilation = 2.0f64.powf(exponent * share) as usize;
        match found.last_mut() {
            Some((last, count)) if *last == dilation => *count += 1,
            _ => found.push((dilation, 1)),
        }
    }
    found.iter_mut().for_each(|(_, count)| *count = (*count as f64 * multiplier) as usize);
    let rest = per_kernel - found.iter().map(|(_, count)| count).sum::<usize>();
    let all = found.len();
    (0..rest).for_each(|i| found[i % all].1 += 1);
    found
}

impl MiniRocket {
    /// Fits the biases to `train`; `features` is rounded down to a multiple of 84.
    ///
    /// # Errors
    /// Recordings shorter than a kernel.
    pub fn fit(train: &Series, features: usize, seed: u64, purpose: &str) -> Result<Self> {
        let [channels, length] = train.shape();
        let kernels = Self::kernels(length, features)?;
        let mut rng = taxel_base::seed::rng(seed, &format!("mini-rocket/{purpose}"));
        let most = channels.min(CHANNELS);
        let mut all: Vec<usize> = (0..channels).collect();
        let mut draws = Draws { examples: vec![], channels: vec![] };
        for _ in 0..kernels {
            draws.examples.push(rng.random_range(0..train.len()));
            // Few channels more often than many: 2^u, u uniform up to log2(most + 1).
            let exponent = rng.random::<f64>() * ((most + 1) as f64).log2();
            let count = (2.0f64.powf(exponent) as usize).clamp(1, most);
            let (drawn, _) = all.partial_shuffle(&mut rng, count);
            draws.channels.push(drawn.to_vec());
        }
        Self::fit_with(train, features, draws)
    }

    /// Returns kernels times dilations for series of `length`: so many entries [`Draws`] has.
    ///
    /// # Errors
    /// Recordings shorter than a kernel.
    pub fn kernels(length: usize, features: usize) -> Result<usize> {
        if length >= KERNEL {
            Ok(KERNELS * dilations(length, features).len())
        } else {
            Err(Error::TooShort { length, least: KERNEL })
        }
    }

    /// Fits as [`MiniRocket::fit`] does, with everything random given.
    ///
    /// # Errors
    /// Recordings shorter than a kernel, or draws of another number.
    pub fn fit_with(train: &Series, features: usize, draws: Draws) -> Result<Self> {
        let [channels, length] = train.shape();
        let kernels = Self::kernels(length, features)?;
        let fits = draws.examples.len() == kernels
            && draws.channels.len() == kernels
            && draws.examples.iter().all(|&i| i < train.len())
            && draws.channels.iter().all(|read| !read.is_empty() && read.iter().all(|&c| c < channels));
        if !fits {
            return Err(Error::setting("draws", draws.examples.len(), "must be one per kernel and dilation"));
        }
        let dilations = dilations(length, features);
        let Draws { examples, channels } = draws;
        let plain = rocket(train.shape(), &dilations, &channels, None);
        let mut biases = vec![];
        // Quantiles of low discrepancy: multiples of the golden ratio.
        let golden = (5.0f64.sqrt() + 1.0) / 2.0;
        let (mut work, mut output, mut number) = (plain.work(), vec![0.0; length], 0);
        for (step, &(_, count)) in dilations.iter().enumerate() {
            let first = step * KERNELS;
            for (kernel, &example) in examples[first..first + KERNELS].iter().enumerate() {
                plain.convolve(first + kernel, train.sample(example), &mut work, &mut output);
                let mut sorted: Vec<f64> = output.iter().map(|&v| f64::from(v)).collect();
                sorted.sort_by(f64::total_cmp);
                for _ in 0..count {
                    number += 1;
                    let quantile = (f64::from(number) * golden).fract() * (length - 1) as f64;
                    let (low, high) = (sorted[quantile.floor() as usize], sorted[quantile.ceil() as usize]);
                    biases.push((low + (high - low) * quantile.fract()) as f32);
                }
            }
        }
        Ok(MiniRocket::new(train.shape(), dilations, channels, biases))
    }

    fn new(
        shape: [usize; 2],
        dilations: Vec<(usize, usize)>,
        channels: Vec<Vec<usize>>,
        biases: Vec<f32>,
    ) -> Self {
        let rocket = rocket(shape, &dilations, &channels, Some(&biases));
        MiniRocket { shape, dilations, channels, biases, rocket }
    }

    /// Returns the convolutions, whose thresholds follow each other as the features do.
    pub fn convolutions(&self) -> &[Dilated] {
        self.rocket.convolutions()
    }

    /// Returns the thresholds of all features.
    pub fn biases(&self) -> &[f32] {
        &self.biases
    }

    /// Computes the features of each recording, shares in `[0, 1]`.
    ///
    /// # Errors
    /// Series of another shape than those it was fitted to.
    pub fn transform(&self, x: &Series) -> Result<FeatureMatrix> {
        x.expect(self.shape)?;
        let width = self.biases.len();
        let mut values = vec![0.0; x.len() * width];
        values.par_chunks_exact_mut(width).enumerate().for_each_init(
            || self.rocket.work(),
            |work, (i, features)| self.rocket.shares(x.sample(i), work, features),
        );
        Ok(FeatureMatrix::new(values, width).weighted(x.weights))
    }

    /// Computes [`MiniRocket::transform`] of one recording, channel after channel, in memory that
    /// [`MiniRocket::work`] makes.
    ///
    /// # Panics
    /// A recording, memory or features of another size.
    pub fn shares(&self, recording: &[f32], work: &mut RocketMemory, features: &mut [f32]) {
        self.rocket.shares(recording, work, features);
    }

    /// Makes the memory for [`MiniRocket::shares`].
    pub fn work(&self) -> RocketMemory {
        self.rocket.work()
    }

    /// Returns the number of features where so many are asked for: the multiple of 84 below, 84 at least.
    pub fn width(features: usize) -> usize {
        (features / KERNELS).max(1) * KERNELS
    }

    /// Returns channels and length of the recordings that it was fitted to.
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// Counts the additions of the convolutions: nine readings per position and channel.
    pub(crate) fn macs(&self) -> u64 {
        let reads: usize = self.channels.iter().map(Vec::len).sum();
        (reads * KERNEL * self.shape[1]) as u64
    }

    pub(crate) fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        let flat = |pairs: &[(usize, usize)]| pairs.iter().flat_map(|&(a, b)| [a as f32, b as f32]).collect();
        let widest = self.channels.iter().map(Vec::len).max().unwrap_or(1);
        // Rows of unequal length are filled up with -1.
        let channels = self.channels.iter().flat_map(|read| {
            read.iter().map(|&c| c as f32).chain(std::iter::repeat(-1.0)).take(widest).collect::<Vec<_>>()
        });
        vec![
            ("rocket.dilations", vec![self.dilations.len(), 2], flat(&self.dilations)),
            ("rocket.channels", vec![self.channels.len(), widest], channels.collect()),
            ("rocket.biases", vec![self.biases.len()], self.biases.clone()),
        ]
    }

    /// Reads the tensors that [`MiniRocket::tensors`] gave.
    pub(crate) fn read(shape: [usize; 2], saved: &Saved) -> Result<Self> {
        let dilations: Vec<(usize, usize)> = saved
            .rows("rocket.dilations", 2)?
            .chunks_exact(2)
            .map(|pair| (pair[0] as usize, pair[1] as usize))
            .collect();
        let widest = saved.get("rocket.channels")?.len() / (dilations.len() * KERNELS).max(1);
        let row =
            |padded: &[f32]| padded.iter().filter(|c| **c >= 0.0).map(|&c| c as usize).collect::<Vec<_>>();
        let channels: Vec<Vec<usize>> = saved
            .sized("rocket.channels", dilations.len() * KERNELS * widest)?
            .chunks_exact(widest.max(1))
            .map(row)
            .collect();
        let biases = saved.get("rocket.biases")?.to_vec();
        MiniRocket::try_from(RocketParts { shape, dilations, channels, biases })
    }
}

/// Makes all convolutions, with the thresholds that follow each other in `biases`.
fn rocket(
    [channels, length]: [usize; 2],
    dilations: &[(usize, usize)],
    read: &[Vec<usize>],
    biases: Option<&[f32]>,
) -> Rocket {
    let (places, mut biases) = (places(), biases.unwrap_or_default());
    let mut convolutions = vec![];
    for (step, &(dilation, count)) in dilations.iter().enumerate() {
        let padding = (KERNEL - 1) * dilation / 2;
        for (kernel, &twos) in places.iter().enumerate() {
            let (first, rest) = biases.split_at(count.min(biases.len()));
            biases = rest;
            // Every other kernel leaves out the positions that read beyond the ends.
            let counted =
                if (step + kernel).is_multiple_of(2) { 0..length } else { padding..length - padding };
            let channels = read[step * KERNELS + kernel].clone();
            convolutions.push(Dilated { dilation, twos, channels, biases: first.to_vec(), counted });
        }
    }
    Rocket::new(channels, length, convolutions)
}
