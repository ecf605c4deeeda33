//! Any network on any samples: recipe, fit, cross-validation, resume, metrics, and the model in one file.
//!
//! A [`Candidate`] is a network with its [`Recipe`], or a baseline. [`CrossValidation`] trains and tests
//! candidates on the same folds, in memory or into a [`RunFolder`] that an interrupted run goes on with.
//! [`fit()`] trains one on everything, and a [`Model`] is the file that is shipped:
//!
//! ```
//! use taxel_data::Dataset;
//! use taxel_base::Layout;
//! use taxel_graph::Network;
//! use taxel_learn::{Candidate, Encoding, Model, Recipe, fit};
//!
//! // Twelve presses of one sensor, ten readings each.
//! let x = ndarray::ArrayD::from_shape_fn(vec![12, 1, 10], |at| (at[0] % 2) as f32 + 0.01 * at[2] as f32);
//! let labels: Vec<&str> = (0..12).map(|i| ["soft", "hard"][i % 2]).collect();
//! let presses = Dataset::new("presses", Layout::Series, x.clone(), &labels)?;
//!
//! let net = Network::new("own");
//! let logits = net.input("signal", &[1, 10]).flatten().linear("fc", 2);
//! let graph = net.finish(&[("logits", logits)])?;
//! let own = Candidate::network(graph, Recipe { epochs: 20, ..Recipe::default() });
//!
//! let path = std::env::temp_dir().join("taxel-learn-doc.safetensors");
//! fit(&own, &presses, &Encoding::default())?.save(&path)?;
//! let model = Model::open(&path)?;
//! let predictions = model.predict(&x)?;
//! assert_eq!((predictions.class(0), predictions.class(1)), ("soft", "hard"));
//! # std::fs::remove_file(&path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Equal settings on equal data give equal bytes for any number of threads, except for `timings.jsonl`,
//! `environment.json` and `folds/*.timing.json` of a run folder.

pub mod certainty;
pub mod encoding;
mod error;
mod estimator;
mod json_file;
mod latency;
pub mod metrics;
mod model;
mod problem;
mod progress;
mod run;
mod sensor;
mod table;
mod training;

pub use encoding::{Compiled, Converter, Encoder, Encoding, Reduction, Transform, fitted_guard, mended};
pub use error::{Error, Result};
pub use estimator::candidate::{Candidate, Hardening, Published, Twin, augmented, clean, file_name};
pub use estimator::estimator::Estimator;
pub use estimator::fit::{Fit, fit};
pub use estimator::one_fold::{OneFold, Tested, inner_folds};
pub use estimator::search::{Chosen, Combination, Search, Trial};
pub use estimator::trainable::Trainable;
pub use estimator::tuning::Tuning;
pub use latency::{Latency, Stopwatch, milliseconds};
pub use model::{
    AverageMember, Card, FORMAT, HUB_LIBRARY, MaskGrid, Masked, Model, ModelInput, ModelKind, OutsideRange,
    Predictions, Predictor, Quantized, Ranges, Score, TrainedOn, TrainingPart, Workspace, at_rest,
};
pub use problem::{Check, Problem, require, share, within};
pub use progress::{Progress, Silent};
pub use run::cross_validation::CrossValidation;
pub use run::environment::{Environment, cores, program};
pub use run::folder::{Identity, RunFolder};
pub use run::gather::gather;
pub use run::kept::{read_kept, write_kept};
pub use run::leaks::Leak;
pub use run::lock::Lock;
pub use run::options::{RunOptions, threads};
pub use run::protocol::{Protocol, Split};
pub use run::quantized_run::quantize_run;
pub use run::records::{Change, Costs, FoldKey, FoldRecord, OtherStatistics, Timing};
pub use run::results::{FoldScores, NetworkResults, Results};
pub use run::run_models::read_weights;
pub use run::work::{RowWork, Work};
pub use sensor::{SensorFacts, sensor};
pub use table::ResultsTable;
pub use taxel_guard as guard;
pub use training::epoch::Epoch;
pub use training::optimizer::{Decay, Moments, Optimizer};
pub use training::part::shuffled;
pub use training::recipe::{
    BatchNorm, ClassWeights, Criterion, EarlyStopping, FrozenStatistics, Precision, Recipe,
};
pub use training::schedule::Schedule;
pub use training::session::forget;
pub use training::teacher::Teacher;
