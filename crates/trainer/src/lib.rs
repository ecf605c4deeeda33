//! Experiments from TOML: data, encoding, protocol, training, metrics, run folders.
//!
//! An [`Experiment`] is a checked config; [`run`] trains every network on every fold and writes a
//! [`RunFolder`]; [`Table`] prints it. Equal configs on equal data write equal bytes, except for
//! `timings.jsonl`, `environment.json` and `folds/*.timing.json`.
//!
//! ```no_run
//! use std::path::Path;
//! use std::sync::atomic::AtomicBool;
//! use taxel_trainer::{Experiment, Overrides, RunOptions, Silent, Table, run};
//!
//! let overrides = Overrides { quick: true, ..Overrides::default() };
//! let experiment = Experiment::load(Path::new("configs/quickstart.toml"), &overrides)?;
//! let folder = run(&experiment, &RunOptions::default(), &Silent, &AtomicBool::new(false))?;
//! println!("{}", Table::of(&folder)?);
//! # Ok::<(), taxel_trainer::Error>(())
//! ```

mod assemble;
mod baseline;
mod checkpoint;
pub mod config;
mod encode;
mod environment;
mod error;
mod experiment;
mod files;
mod folder;
mod labels;
pub mod metrics;
mod predictor;
mod progress;
mod results;
mod run;
mod samples;
mod session;
mod table;
mod tensorboard;
mod train;

pub use checkpoint::{Metadata, read_checkpoint, write_checkpoint};
pub use config::{Config, Problem, Range};
pub use encode::{Encoded, Encoder, IMAGE, Input, SIGNAL, TENSOR, Transform};
pub use environment::Environment;
pub use error::{Error, Result};
pub use experiment::{Experiment, Overrides};
pub use folder::RunFolder;
pub use labels::{Attribute, Labels};
pub use predictor::Predictor;
pub use progress::{IndicatifProgress, Progress, Silent};
pub use results::{
    Change, Chosen, Costs, FoldKey, FoldRecord, FoldScores, NetworkResults, OtherStatistics, Results, Timing,
    Trial,
};
pub use run::{RunOptions, run, run_on};
pub use samples::Samples;
pub use table::{Table, thousands};
pub use train::{Epoch, Latency, Material, Task, Trained, shuffled};
