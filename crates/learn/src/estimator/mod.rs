//! Estimators: networks and baselines, and one training of one of them.

pub(crate) mod baseline;
pub(crate) mod candidate;
pub(crate) mod fit;
pub(crate) mod making;
pub(crate) mod one_fold;
pub(crate) mod search;
