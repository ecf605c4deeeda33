//! Comparisons of classifiers: each against SciPy or a published worked example.
//!
//! Over folds the [`corrected_t`] test, over samples [`mcnemar`] or, where they are grouped, [`grouped_pairs`], any other
//! statistic by a [`cluster_bootstrap`], several comparisons together corrected by [`holm`]; over several data sets [`friedman`] with
//! [`nemenyi`]'s critical difference, [`wilcoxon`] for pairs, and [`random_effects`] for one effect. [`looks`] at a run that goes on
//! share the errors among them, [`false_discovery`] counts them over a page. No function returns NaN: what cannot be
//! computed is an error, or has the value that its documentation says.
//!
//! ```
//! use taxel_judge::statistics::{corrected_t, holm, mcnemar};
//!
//! // Five folds, each with a quarter as many test as training samples: the naive p would be 0.02.
//! let test = corrected_t(&[2.0, 1.0, 0.5, 3.0, 1.5], 0.25, 0.95)?;
//! assert!((test.p - 0.0682).abs() < 1e-4 && test.interval.is_some());
//! assert_eq!(mcnemar(0, 0), 1.0);
//! assert_eq!(holm(&[0.01, 0.04]), [0.02, 0.04]);
//! # Ok::<(), taxel_judge::Error>(())
//! ```

mod bootstrap;
mod check;
mod pairs;
mod pooling;
mod power;
mod power_law;
mod ranks;

pub use crate::values::Friedman;
pub use bootstrap::cluster_bootstrap;
pub use pairs::{
    PairedTest, SpreadRatio, corrected_t, grouped_pairs, holm, independent, mcnemar, spread_ratio,
};
pub use pooling::{Look, PooledEffect, false_discovery, looks, random_effects};
pub use power::samples_to_decide;
pub use power_law::power_law;
pub(crate) use ranks::signed_rank;
pub use ranks::{friedman, nemenyi, ranks, wilcoxon};
