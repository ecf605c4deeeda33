//! Experiments from TOML: one resolved config, its samples, its candidates, its run folder.
//!
//! TOML text becomes raw tables, which are merged key by key (`[quick]`, overrides, one network's own
//! settings), and then one [`Config`] in which nothing is left open. An [`Experiment`] is such a config that
//! remembers where each value was written; [`run()`] hands it to `taxel-learn`.
//!
//! ```no_run
//! use std::path::Path;
//! use std::sync::atomic::AtomicBool;
//! use taxel_learn::{ResultsTable, RunOptions, Silent};
//! use taxel_trainer::{Experiment, Overrides, run};
//! use taxel_zoo::Registry;
//!
//! let (overrides, registry) = (Overrides { quick: true, ..Overrides::default() }, Registry::built_in());
//! let experiment = Experiment::load(Path::new("configs/quickstart.toml"), &overrides, &registry)?;
//! let options = RunOptions::default();
//! let folder = run(&experiment, &registry, None, &options, &Silent, &AtomicBool::new(false))?;
//! println!("{}", ResultsTable::of(&folder)?);
//! # Ok::<(), taxel_trainer::Error>(())
//! ```

mod average;
mod baseline;
mod config;
mod data;
mod data_schema;
mod error;
mod experiment;
mod measured;
mod merge;
mod misread;
mod network;
mod network_file;
mod positions;
mod read;
mod reference;
mod run;
mod samples;
mod start;
mod unknown;
mod value_reader;
mod variant;

pub use baseline::Baseline;
pub use config::{Choose, Config};
pub use data::{Data, Origin, RecordingsOrigin, SAMPLES, SceneOrigin, settings};
pub use error::{Error, Result};
pub use experiment::{Experiment, Overrides, name_of};
pub use measured::{Estimate, RowCost};
pub use network::Network;
pub use network_file::read_network;
pub use reference::{page, schema};
pub use run::{RUN_CONFIG, Runner, open, prepared, run};
pub use samples::{quantity, simulate, simulated};
pub use start::Start;
pub use variant::{Depth, Variant};
