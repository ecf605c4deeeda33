//! Many experiments on many machines: planned once, run wherever there is room, collected on one page.
//!
//! [`plan()`] makes a manifest of trials from a [`Study`]: configs with what is varied in them. A trial is known by
//! its identity, a hash of resolved config, samples and program, so its result counts once, however often and
//! wherever it is run. [`work()`] runs what has no result yet, locked against other processes and machines that share
//! the folder; [`collect()`] makes the page; [`tasks`] and [`emit`] hand what is missing to a scheduler.
//!
//! Nothing here schedules, and nothing here trains: a trial is a run of `taxel-trainer`.
//!
//! ```
//! use taxel_sweep::{Study, SweepFolder, plan};
//! use taxel_zoo::Registry;
//!
//! let here = tempfile::tempdir()?;
//! std::fs::write(here.path().join("presses.toml"), r#"
//!     name = "presses"
//!     [data]
//!     scene = "fingertip"
//!     samples = 30
//!     [[networks]]
//!     name = "mlp"
//! "#)?;
//! std::fs::write(here.path().join("study.toml"), r#"
//!     config = "presses.toml"
//!     [grid]
//!     "train.optimizer.lr" = [0.01, 0.1]
//!     seed = [0, 1, 2]
//! "#)?;
//! let study = Study::load(&here.path().join("study.toml"))?;
//! let folder = SweepFolder::at(&here.path().join("sweep"));
//! assert_eq!(plan(&study, &folder, &Registry::built_in())?.trials, 6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod axes;
mod chart;
mod chunks;
mod collect;
mod collected;
mod data_sets;
pub mod emit;
mod error;
mod folder;
mod gather;
mod jobs;
mod json;
mod lease;
mod manifest;
mod page;
mod plan;
mod record;
mod samples;
mod study;
mod tables;
mod tally;
mod trial;
mod work;

pub use chunks::{Chunking, Task, Tasks, tasks};
pub use collect::collect;
pub use collected::{KeyEffect, OpenTrial, ScoreSpread, Setting, Sweep, SweepProgress};
pub use emit::{Arrays, Emit};
pub use error::{Error, Result};
pub use folder::SweepFolder;
pub use jobs::{Tally, shares, work};
pub use lease::Holder;
pub use manifest::Manifest;
pub use page::sweep_page;
pub use plan::{Planned, plan};
pub use record::{Failure, NetworkScore, TrialResult, TrialTiming};
pub use study::{Configs, Draw, Folds, Random, Study};
pub use trial::{DataOf, Trial, TrialFold};
pub use work::{TrialOutcome, WorkOptions};
