//! Every method with its settings.

use serde::{Deserialize, Serialize};

use crate::{Error, minirocket, svm};

/// A method with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// [`MiniRocket`](crate::MiniRocket) features, scaled, into a [`Ridge`](crate::Ridge) classifier; for values [`RocketValues`](crate::RocketValues).
    MiniRocket {
        /// About that many features. Default 10,000.
        #[serde(default = "features")]
        features: usize,
    },
    /// [`Ridge`](crate::Ridge) regression on the readings of the series, for targets that are values.
    Ridge,
    /// [`ExtraTrees`](crate::ExtraTrees); of classes each tree gives the shares in its leaf.
    ExtraTrees {
        /// Trees. Default 100.
        #[serde(default = "trees")]
        trees: usize,
        /// The least samples of a leaf. Default 2.
        #[serde(default = "min_samples_leaf")]
        min_samples_leaf: usize,
    },
    /// [`Svm`](crate::Svm) with a linear kernel.
    SvmLinear {
        /// Penalty of a margin's violation. Default 1.
        #[serde(default = "unit")]
        c: f64,
    },
    /// [`Svm`](crate::Svm) with a Gaussian kernel of scikit-learn's default width.
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

    /// Checks whether samples may have weights in training.
    pub fn takes_weights(&self) -> bool {
        matches!(self, Method::Majority | Method::Mean | Method::Ridge | Method::MiniRocket { .. })
    }

    /// Checks whether it learns values.
    pub fn learns_values(&self) -> bool {
        !matches!(self, Method::Majority | Method::SvmLinear { .. } | Method::SvmRbf { .. })
    }

    /// Checks whether it learns classes. Some methods learn both.
    pub fn learns_classes(&self) -> bool {
        !matches!(self, Method::Mean | Method::Ridge)
    }
}
