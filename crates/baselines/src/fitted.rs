//! Methods that have seen their training part.

use crate::{
    ALPHAS, Error, ExtraTrees, FittedValues, Method, MiniRocket, Nearest, Result, Ridge, RocketMemory, Saved,
    Series, Svm, SvmKernel,
};
use crate::{nearest, softmax, svm, values};

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
    /// A method that learned values, or trees that learned the shares of classes.
    Values(FittedValues),
}

impl Method {
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
        self.refuse_weights(train)?;
        if let Some(&label) = y.iter().find(|&&label| label as usize >= classes) {
            return Err(Error::Label { label, classes });
        }
        Ok(match *self {
            Method::Majority => {
                let mut counts = vec![0.0; classes];
                let weight = |row: usize| train.weights.map_or(1.0, |weights| weights[row]);
                y.iter().enumerate().for_each(|(row, &label)| counts[label as usize] += weight(row));
                let whole: f32 = (0..y.len()).map(weight).sum();
                Fitted::Majority(counts.iter().map(|count| count / whole).collect())
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
            Method::ExtraTrees { trees, min_samples_leaf } => {
                let (sizes, key) = ([trees, min_samples_leaf], (seed, purpose));
                Fitted::Values(FittedValues::ExtraTrees(ExtraTrees::fit_classes(
                    train, y, classes, sizes, key,
                )?))
            }
            Method::Mean | Method::Ridge => return Err(self.refuse_classes()),
        })
    }

    /// Refuses weights that the method cannot take.
    pub(crate) fn refuse_weights(&self, train: &Series) -> Result<()> {
        match train.weights.filter(|_| !self.takes_weights()) {
            Some(_) => {
                Err(Error::setting("method", self.name(), "counts all samples alike and takes no weights"))
            }
            None => Ok(()),
        }
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
            Method::ExtraTrees { .. } => return Self::read_values(method, shape, classes, saved),
            Method::Mean | Method::Ridge => return Err(method.refuse_classes()),
        })
    }

    /// Computes scores `[n, classes]` from 0 to 1, row-major, each row adding up to 1. They order the classes; only those
    /// of the majority and of trees are probabilities. Of a method that learned values these, `[n, outputs]`, in the units of the targets.
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
