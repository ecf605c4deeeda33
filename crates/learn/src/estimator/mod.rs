//! Estimators: networks and baselines behind one trait, and one training of one of them.

pub(crate) mod average;
pub(crate) mod baseline;
pub(crate) mod candidate;
pub(crate) mod estimator;
pub(crate) mod fit;
pub(crate) mod left_out;
pub(crate) mod network;
pub(crate) mod one_fold;
pub(crate) mod search;
mod series_shape;
pub(crate) mod train_fold;
pub(crate) mod trainable;
pub(crate) mod tuning;
