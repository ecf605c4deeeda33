//! A run: every candidate on every fold, in memory or in a folder.

pub(crate) mod assemble;
pub(crate) mod cross_validation;
pub(crate) mod environment;
pub(crate) mod finished;
pub(crate) mod folder;
pub(crate) mod gather;
pub(crate) mod kept;
pub(crate) mod leaks;
pub(crate) mod lock;
pub(crate) mod model_latency;
pub(crate) mod options;
pub(crate) mod plan;
pub(crate) mod protocol;
pub(crate) mod quantized_run;
pub(crate) mod records;
pub(crate) mod results;
pub(crate) mod run;
pub(crate) mod run_models;
#[cfg(feature = "tensorboard")]
pub(crate) mod tensorboard;
pub(crate) mod unknown;
pub(crate) mod work;
