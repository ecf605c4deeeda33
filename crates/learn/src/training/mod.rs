//! The training of a network: batches, losses, optimisers, saved sessions.

pub(crate) mod epoch;
pub(crate) mod feature_cache;
pub(crate) mod feed;
pub(crate) mod hooks;
pub(crate) mod label_objective;
pub(crate) mod learner;
pub(crate) mod network;
pub(crate) mod objective;
pub(crate) mod objective_of;
pub(crate) mod optimizer;
pub(crate) mod part;
pub(crate) mod pass;
pub(crate) mod raw_changes;
pub(crate) mod recipe;
pub(crate) mod schedule;
pub(crate) mod session;
pub(crate) mod teacher;
pub(crate) mod value_objective;
