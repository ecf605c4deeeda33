//! Methods that cost almost nothing, and that a network has to beat.
//!
//! All take series `[n, channels, length]`. With one class each they give a score per class, the largest for the predicted
//! one: [`Method::fit`] learns from the training part, [`Fitted::scores`] predicts. With values they predict these:
//! [`Method::fit_values`].
//!
//! ```
//! use taxel_baselines::{Method, Series};
//!
//! let x = [0.0, 0.1, 0.9, 1.0];
//! let train = Series::new(&x, 1, 1)?;
//! let fitted = Method::NearestNeighbours { k: 1 }.fit(&train, &[0, 0, 1, 1], 2, 0, "doc")?;
//! let scores = fitted.scores(&Series::new(&[0.2, 0.8], 1, 1)?)?;
//! assert_eq!(scores, [1.0, 0.0, 0.0, 1.0]);
//! let forces = Method::Mean.fit_values(&train, &[1.0, 1.0, 3.0, 3.0], 1, 0, "doc")?;
//! assert_eq!(forces.scores(&Series::new(&[0.2], 1, 1)?)?, [2.0]);
//! # Ok::<(), taxel_baselines::Error>(())
//! ```
//!
//! # Reference
//! See each method: [`MiniRocket`], [`Ridge`], [`Svm`], [`ExtraTrees`].

mod error;
mod extra_trees;
mod grow;
mod minirocket;
mod nearest;
mod ridge;
mod rocket_values;
mod saved;
mod summary;
mod svm;
mod values;

pub use error::{Error, Result};
pub use extra_trees::ExtraTrees;
pub use minirocket::{Draws, MiniRocket};
pub use nearest::{Nearest, NearestValues};
pub use ridge::{ALPHAS, FeatureMatrix, Ridge};
pub use rocket_values::RocketValues;
pub use saved::Saved;
pub use svm::{Svm, SvmKernel};
pub use taxel_kernels::rocket::RocketMemory;
pub use values::FittedValues;

use serde::{Deserialize, Serialize};

/// Recordings `[n, channels, length]`, row-major, all finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series<'a> {
    values: &'a [f32],
    channels: usize,
    length: usize,
}

impl<'a> Series<'a> {
    /// Views `values` as recordings of `channels` × `length`.
    ///
    /// # Errors
    /// No recordings, a rest that is no whole recording, or a value that is not finite.
    pub fn new(values: &'a [f32], channels: usize, length: usize) -> Result<Self> {
        let each = channels * length;
        if each == 0 || values.is_empty() || !values.len().is_multiple_of(each) {
            return Err(Error::Shape { values: values.len(), channels, length });
        }
        match values.iter().position(|v| !v.is_finite()) {
            Some(at) => Err(Error::NotFinite { sample: at / each, value: values[at] }),
            None => Ok(Series { values, channels, length }),
        }
    }

    /// Returns the number of recordings.
    pub fn len(&self) -> usize {
        self.values.len() / (self.channels * self.length)
    }

    /// Checks whether there is no recording. There is always at least one.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Returns channels and length of a recording.
    pub fn shape(&self) -> [usize; 2] {
        [self.channels, self.length]
    }

    /// Returns the values of recording `i`, channel after channel.
    pub fn sample(&self, i: usize) -> &'a [f32] {
        let each = self.channels * self.length;
        &self.values[i * each..(i + 1) * each]
    }

    /// Returns one channel of recording `i`.
    pub fn channel(&self, i: usize, channel: usize) -> &'a [f32] {
        &self.sample(i)[channel * self.length..(channel + 1) * self.length]
    }

    /// Refuses series of another shape than a method was fitted to.
    pub(crate) fn expect(&self, fitted: [usize; 2]) -> Result<()> {
        if self.shape() == fitted { Ok(()) } else { Err(Error::OtherShape { fitted, given: self.shape() }) }
    }
}

/// A method with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "name", deny_unknown_fields)]
pub enum Method {
    /// The commonest class of the training part, for every sample.
    Majority,
    /// The mean of each value in the training part, for every sample (scikit-learn's `DummyRegressor`).
    Mean,
    /// The commonest class among the `k` nearest training samples (Euclidean); the mean of their values, each counting alike
    /// (scikit-learn's `KNeighborsRegressor`).
    #[serde(rename = "k-nn")]
    NearestNeighbours {
        /// Neighbours that count. Default 1.
        #[serde(default = "one")]
        k: usize,
    },
    /// [`MiniRocket`] features, scaled, into a [`Ridge`] classifier; for values [`RocketValues`].
    MiniRocket {
        /// About that many features. Default 10,000.
        #[serde(default = "features")]
        features: usize,
    },
    /// [`Ridge`] regression on the readings of the series, for targets that are values.
    Ridge,
    /// [`ExtraTrees`], for targets that are values.
    ExtraTrees {
        /// Trees. Default 100.
        #[serde(default = "trees")]
        trees: usize,
        /// The least samples of a leaf. Default 2.
        #[serde(default = "min_samples_leaf")]
        min_samples_leaf: usize,
    },
    /// [`Svm`] with a linear kernel.
    SvmLinear {
        /// Penalty of a margin's violation. Default 1.
        #[serde(default = "unit")]
        c: f64,
    },
    /// [`Svm`] with a Gaussian kernel of scikit-learn's default width.
    SvmRbf {
        /// Penalty of a margin's violation. Default 1.
        #[serde(default = "unit")]
        c: f64,
    },
}

fn one() -> usize {
    1
}

fn features() -> usize {
    10_000
}

fn trees() -> usize {
    100
}

fn min_samples_leaf() -> usize {
    2
}

fn unit() -> f64 {
    1.0
}

/// A method that has seen its training part.
#[derive(Debug, Clone, PartialEq)]
pub enum Fitted {
    /// Share of each class in the training part.
    Majority(Vec<f32>),
    /// The training part itself.
    Nearest(Nearest),
    /// Features and the linear classifier on them.
    MiniRocket(Box<MiniRocket>, Ridge),
    /// Support vectors.
    Svm(Svm),
    /// A method that learned values.
    Values(FittedValues),
}

impl Method {
    /// Returns every method for values with its default settings, cheapest first.
    pub fn of_values() -> [Method; 5] {
        [
            Method::Mean,
            Method::Ridge,
            Method::NearestNeighbours { k: one() },
            Method::MiniRocket { features: features() },
            Method::ExtraTrees { trees: trees(), min_samples_leaf: min_samples_leaf() },
        ]
    }

    /// Returns every method for classes with its default settings, cheapest first.
    pub fn all() -> [Method; 5] {
        [
            Method::Majority,
            Method::NearestNeighbours { k: one() },
            Method::MiniRocket { features: features() },
            Method::SvmLinear { c: unit() },
            Method::SvmRbf { c: unit() },
        ]
    }

    /// Returns the name in tables and files.
    pub fn name(&self) -> &'static str {
        match self {
            Method::Majority => "majority",
            Method::Mean => "mean",
            Method::NearestNeighbours { .. } => "k-nn",
            Method::MiniRocket { .. } => "mini-rocket",
            Method::SvmLinear { .. } => "svm-linear",
            Method::SvmRbf { .. } => "svm-rbf",
            Method::Ridge => "ridge",
            Method::ExtraTrees { .. } => "extra-trees",
        }
    }

    /// Returns where it is published.
    pub fn reference(&self) -> &'static str {
        match self {
            Method::Majority => "the commonest class",
            Method::Mean => "the mean value",
            Method::NearestNeighbours { .. } => "Cover & Hart 1967",
            Method::MiniRocket { .. } => "Dempster, Schmidt & Webb 2021",
            Method::SvmLinear { .. } | Method::SvmRbf { .. } => "Cortes & Vapnik 1995",
            Method::Ridge => "Hoerl & Kennard 1970",
            Method::ExtraTrees { .. } => "Geurts, Ernst & Wehenkel 2006",
        }
    }

    /// Says why it cannot be fitted to `samples` recordings of `length` readings, if so.
    pub fn unfit(&self, samples: usize, length: usize) -> Option<String> {
        match self {
            Method::MiniRocket { .. } if length < minirocket::KERNEL => {
                Some(Error::TooShort { length, least: minirocket::KERNEL }.to_string())
            }
            Method::SvmLinear { .. } | Method::SvmRbf { .. } if samples > svm::MOST => {
                Some(format!("{samples} training samples are more than {}", svm::MOST))
            }
            _ => None,
        }
    }

    /// Checks whether it learns values.
    pub fn learns_values(&self) -> bool {
        !matches!(self, Method::Majority | Method::SvmLinear { .. } | Method::SvmRbf { .. })
    }

    /// Checks whether it learns classes. Some methods learn both.
    pub fn learns_classes(&self) -> bool {
        !matches!(self, Method::Mean | Method::Ridge | Method::ExtraTrees { .. })
    }

    /// Learns from `train` and values `[n, outputs]`, row-major; `seed` and `purpose` key what is drawn at random.
    ///
    /// # Errors
    /// Values that do not pair up with the series or are not finite, a method that learns classes alone, or settings and series
    /// that the method refuses.
    pub fn fit_values(
        &self,
        train: &Series,
        values: &[f32],
        outputs: usize,
        seed: u64,
        purpose: &str,
    ) -> Result<Fitted> {
        FittedValues::fit(self, train, values, outputs, (seed, purpose)).map(Fitted::Values)
    }

    /// Learns from `train` and its classes `y`, all below `classes`; `seed` and `purpose` key what is
    /// drawn at random.
    ///
    /// # Errors
    /// Labels that do not pair up with the series, or settings and series that the method refuses.
    pub fn fit(&self, train: &Series, y: &[u32], classes: usize, seed: u64, purpose: &str) -> Result<Fitted> {
        if y.len() != train.len() {
            return Err(Error::Labels { labels: y.len(), samples: train.len() });
        }
        if let Some(&label) = y.iter().find(|&&label| label as usize >= classes) {
            return Err(Error::Label { label, classes });
        }
        Ok(match *self {
            Method::Majority => {
                let mut counts = vec![0.0; classes];
                y.iter().for_each(|&label| counts[label as usize] += 1.0);
                Fitted::Majority(counts.iter().map(|count| count / y.len() as f32).collect())
            }
            Method::NearestNeighbours { k } => Fitted::Nearest(Nearest::fit(train, y, classes, k)?),
            Method::MiniRocket { features } => {
                let rocket = MiniRocket::fit(train, features, seed, purpose)?;
                let x = rocket.transform(train)?;
                let ridge = Ridge::fit(&x, y, classes, &ALPHAS)?;
                Fitted::MiniRocket(Box::new(rocket), ridge)
            }
            Method::SvmLinear { c } => Fitted::Svm(Svm::fit(train, y, classes, SvmKernel::Linear, c)?),
            Method::SvmRbf { c } => Fitted::Svm(Svm::fit(train, y, classes, SvmKernel::Rbf, c)?),
            Method::Mean | Method::Ridge | Method::ExtraTrees { .. } => return Err(self.refuse_classes()),
        })
    }

    fn refuse_classes(&self) -> Error {
        Error::setting("method", self.name(), "learns values, and the targets are classes")
    }
}

impl Fitted {
    /// Reads the `method` that had been fitted to values of series of `shape` (channels, length) and was saved as
    /// [`Fitted::tensors`].
    ///
    /// # Errors
    /// An array that is missing or does not fit, or a method that learns classes alone.
    pub fn read_values(method: &Method, shape: [usize; 2], outputs: usize, saved: &Saved) -> Result<Self> {
        FittedValues::read(method, shape, outputs, saved).map(Fitted::Values)
    }

    /// Reads the `method` that had been fitted to classes of series of `shape` (channels, length) and was saved as
    /// [`Fitted::tensors`].
    ///
    /// # Errors
    /// An array that is missing or does not fit, or a method that learns values alone.
    pub fn read(method: &Method, shape: [usize; 2], classes: usize, saved: &Saved) -> Result<Self> {
        Ok(match *method {
            Method::Majority => Fitted::Majority(saved.sized("shares", classes)?.to_vec()),
            Method::NearestNeighbours { k } => Fitted::Nearest(Nearest::read(k, shape, classes, saved)?),
            Method::MiniRocket { .. } => {
                let rocket = MiniRocket::read(shape, saved)?;
                let ridge = Ridge::read(rocket.biases().len(), classes, saved)?;
                Fitted::MiniRocket(Box::new(rocket), ridge)
            }
            Method::SvmLinear { .. } => Fitted::Svm(Svm::read(SvmKernel::Linear, shape, classes, saved)?),
            Method::SvmRbf { .. } => Fitted::Svm(Svm::read(SvmKernel::Rbf, shape, classes, saved)?),
            Method::Mean | Method::Ridge | Method::ExtraTrees { .. } => return Err(method.refuse_classes()),
        })
    }

    /// Computes scores `[n, classes]` from 0 to 1, row-major, each row adding up to 1. They order the classes; only the
    /// majority's are probabilities. Of a method that learned values these, `[n, outputs]`, in the units of the targets.
    ///
    /// # Errors
    /// Series of another shape than those it was fitted to.
    pub fn scores(&self, x: &Series) -> Result<Vec<f32>> {
        let mut scores = self.decide(x)?;
        self.soften(&mut scores);
        Ok(scores)
    }

    /// Computes what [`Fitted::soften`] turns into scores: decision values of MiniRocket and the SVMs, the scores themselves
    /// elsewhere, values of a method that learned these.
    ///
    /// # Errors
    /// As [`Fitted::scores`].
    pub fn decide(&self, x: &Series) -> Result<Vec<f32>> {
        match self {
            Fitted::Majority(shares) => Ok(shares.repeat(x.len())),
            Fitted::Nearest(nearest) => nearest.scores(x),
            Fitted::MiniRocket(rocket, ridge) => Ok(ridge.decide(&rocket.transform(x)?)),
            Fitted::Svm(svm) => svm.votes(x),
            Fitted::Values(fitted) => fitted.predict(x),
        }
    }

    /// Turns rows of [`Fitted::decide`] into scores, in place.
    pub fn soften(&self, decided: &mut [f32]) {
        if self.has_decisions() {
            softmax(decided, self.classes());
        }
    }

    /// Computes what [`Fitted::decide`] would say of the samples that it was fitted to had it not seen their unit (those of one
    /// number in `units` are left out together): in closed form for MiniRocket's ridge, none of other methods. The features
    /// stay those that were fitted to all samples.
    ///
    /// # Errors
    /// Other samples than those that it was fitted to.
    pub fn left_out(&self, train: &Series, y: &[u32], units: &[u32]) -> Result<Option<Vec<f32>>> {
        match self {
            Fitted::MiniRocket(rocket, ridge) => {
                ridge.left_out(&rocket.transform(train)?, y, units).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Predicts values `[n, outputs]` of the samples that it was fitted to had it not seen their unit (those of one number in
    /// `units` are left out together): in closed form for both ridges, none of other methods. `values` are the targets that it
    /// was fitted to. Penalty, scale and MiniRocket's thresholds stay those that were fitted to all samples.
    ///
    /// # Errors
    /// Other samples than those that it was fitted to, or a method that learned classes.
    pub fn left_out_values(
        &self,
        train: &Series,
        values: &[f32],
        outputs: usize,
        units: &[u32],
    ) -> Result<Option<Vec<f32>>> {
        match self {
            Fitted::Values(fitted) if fitted.outputs() == outputs => fitted.left_out(train, values, units),
            _ => Err(Error::setting("outputs", outputs, "are not the values that it was fitted to")),
        }
    }

    /// Checks whether it decides by values without bounds, one per class.
    pub fn has_decisions(&self) -> bool {
        matches!(self, Fitted::MiniRocket(..) | Fitted::Svm(_))
    }

    /// Makes the memory for one call of [`Fitted::predict_one`] after the other.
    pub fn workspace(&self) -> Workspace {
        Workspace(match self {
            Fitted::Majority(_) => MethodMemory::Majority,
            Fitted::Nearest(nearest) => MethodMemory::Nearest(nearest.neighbours().memory()),
            Fitted::MiniRocket(rocket, ridge) => {
                let (features, products) = (vec![0.0; rocket.biases().len()], vec![0.0; ridge.classes()]);
                MethodMemory::MiniRocket(Box::new(rocket.work()), features, products)
            }
            Fitted::Svm(_) => MethodMemory::Svm(svm::SvmMemory::default()),
            Fitted::Values(fitted) => MethodMemory::Values(fitted.memory()),
        })
    }

    /// Computes [`Fitted::scores`] of one recording, channel after channel, bit for bit. After the first call nothing
    /// is allocated.
    ///
    /// # Errors
    /// Another shape, a value that is not finite, or a workspace of another kind of method.
    pub fn predict_one(
        &self,
        recording: &[f32],
        workspace: &mut Workspace,
        scores: &mut [f32],
    ) -> Result<()> {
        self.decide_one(recording, workspace, scores)?;
        self.soften(scores);
        Ok(())
    }

    /// Computes [`Fitted::decide`] of one recording, as [`Fitted::predict_one`] does its scores.
    ///
    /// # Errors
    /// As [`Fitted::predict_one`].
    pub fn decide_one(&self, recording: &[f32], workspace: &mut Workspace, scores: &mut [f32]) -> Result<()> {
        if let Some([channels, length]) = self.shape() {
            let x = Series::new(recording, channels, length)?;
            if x.len() != 1 {
                return Err(Error::Shape { values: recording.len(), channels, length });
            }
        }
        if scores.len() != self.classes() {
            return Err(Error::setting("scores", scores.len(), "must be one per class"));
        }
        match (self, &mut workspace.0) {
            (Fitted::Majority(shares), MethodMemory::Majority) => scores.copy_from_slice(shares),
            (Fitted::Nearest(nearest), MethodMemory::Nearest(memory))
                if memory.fits(nearest.neighbours().len()) =>
            {
                nearest.predict_one(recording, memory, scores);
            }
            (Fitted::MiniRocket(rocket, ridge), MethodMemory::MiniRocket(work, features, products))
                if features.len() == rocket.biases().len() && products.len() == ridge.classes() =>
            {
                rocket.shares(recording, work, features);
                ridge.decide_one(features, products, scores);
            }
            (Fitted::Svm(svm), MethodMemory::Svm(work)) => svm.predict_one(recording, work, scores),
            (Fitted::Values(fitted), MethodMemory::Values(memory)) => {
                return fitted.predict_one(recording, memory, scores);
            }
            _ => return Err(Error::foreign_workspace()),
        }
        Ok(())
    }

    /// Returns channels and length of the recordings; none where any will do.
    fn shape(&self) -> Option<[usize; 2]> {
        match self {
            Fitted::Majority(_) => None,
            Fitted::Nearest(nearest) => Some(nearest.neighbours().shape()),
            Fitted::MiniRocket(rocket, _) => Some(rocket.shape()),
            Fitted::Svm(svm) => Some(svm.shape()),
            Fitted::Values(fitted) => fitted.shape(),
        }
    }

    /// Returns the number of classes, or of values.
    pub fn classes(&self) -> usize {
        match self {
            Fitted::Majority(shares) => shares.len(),
            Fitted::Nearest(nearest) => nearest.classes(),
            Fitted::MiniRocket(_, ridge) => ridge.classes(),
            Fitted::Svm(svm) => svm.classes(),
            Fitted::Values(fitted) => fitted.outputs(),
        }
    }

    /// Counts the stored numbers.
    pub fn parameters(&self) -> u64 {
        self.tensors().iter().map(|(_, _, values)| values.len() as u64).sum()
    }

    /// Counts the multiply-accumulates for one sample; MiniRocket's additions and the trees' comparisons count as such.
    pub fn macs(&self) -> u64 {
        match self {
            Fitted::Majority(_) => 0,
            Fitted::Nearest(nearest) => nearest.neighbours().macs(),
            Fitted::MiniRocket(rocket, ridge) => rocket.macs() + ridge.macs(),
            Fitted::Svm(svm) => svm.macs(),
            Fitted::Values(fitted) => fitted.macs(),
        }
    }

    /// Returns everything that was fitted, as named arrays: name, shape, values.
    pub fn tensors(&self) -> Vec<(&'static str, Vec<usize>, Vec<f32>)> {
        match self {
            Fitted::Majority(shares) => vec![("shares", vec![shares.len()], shares.clone())],
            Fitted::Nearest(nearest) => nearest.tensors(),
            Fitted::MiniRocket(rocket, ridge) => {
                let mut tensors = rocket.tensors();
                tensors.extend(ridge.tensors());
                tensors
            }
            Fitted::Svm(svm) => svm.tensors(),
            Fitted::Values(fitted) => fitted.tensors(),
        }
    }
}

/// Memory of one thread that predicts with a [`Fitted`] method, which makes it.
#[derive(Debug)]
pub struct Workspace(MethodMemory);

#[derive(Debug)]
enum MethodMemory {
    Majority,
    Nearest(nearest::NearestMemory),
    /// Of the convolutions, features, and products with the weights of each class.
    MiniRocket(Box<RocketMemory>, Vec<f32>, Vec<f64>),
    Svm(svm::SvmMemory),
    Values(values::ValuesMemory),
}

/// Takes the softmax over each row of `classes` values, in place.
pub fn softmax(values: &mut [f32], classes: usize) {
    for row in values.chunks_exact_mut(classes.max(1)) {
        let largest = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        row.iter_mut().for_each(|v| *v = (*v - largest).exp());
        let sum: f32 = row.iter().sum();
        row.iter_mut().for_each(|v| *v /= sum);
    }
}
