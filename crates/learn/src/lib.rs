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
//! let answers = model.predict(&x)?;
//! assert_eq!((answers.class(0), answers.class(1)), ("soft", "hard"));
//! # std::fs::remove_file(&path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Equal settings on equal data give equal bytes for any number of threads, except for `timings.jsonl`,
//! `environment.json` and `folds/*.timing.json` of a run folder.

mod assemble;
mod baseline;
mod breaker;
mod candidate;
mod cross_validation;
pub mod encoding;
mod environment;
mod epoch;
mod error;
mod feed;
mod finished;
mod fit;
mod folder;
mod gather;
mod grid;
mod hooks;
mod json_file;
mod latency;
mod learner;
mod lock;
mod making;
pub mod metrics;
mod model;
mod numbers;
mod objective;
mod one_fold;
mod optimizer;
mod options;
mod part;
mod plan;
mod problem;
mod progress;
mod protocol;
mod quantized_run;
mod recipe;
mod records;
mod responder;
mod results;
mod run;
mod run_models;
mod schedule;
mod search;
mod sensor;
mod session;
mod still;
mod table;
mod table_latency;
mod teacher;
mod tensorboard;
mod training;

pub use candidate::{Candidate, Estimator, Hardening, Published, Trainable, Twin, clean, file_name};
pub use cross_validation::CrossValidation;
pub use encoding::{Compiled, Converter, Encoder, Encoding, Reduction, Transform, fitted_guard, mended};
pub use environment::{Environment, cores, program};
pub use epoch::Epoch;
pub use error::{Error, Result};
pub use fit::{Fit, fit};
pub use folder::{Identity, RunFolder};
pub use gather::gather;
pub use grid::{Align, Grid, markdown_text};
pub use latency::{Latency, Stopwatch, milliseconds};
pub use lock::Lock;
pub use model::{
    Anatomy, Card, EIGHT_BITS, FORMAT, Model, ModelInput, Predictions, Predictor, Quantized, Score,
    TrainedOn, TrainingPart, Workspace,
};
pub use numbers::thousands;
pub use one_fold::{OneFold, Tested, inner_folds};
pub use optimizer::{Decay, Moments, Optimizer};
pub use options::{RunOptions, threads};
pub use part::shuffled;
pub use problem::{Check, Problem, require, share, within};
pub use progress::{IndicatifProgress, Progress, Silent};
pub use protocol::{Protocol, Split};
pub use quantized_run::quantize_run;
pub use recipe::{BatchNorm, ClassWeights, Criterion, EarlyStopping, FrozenStatistics, Recipe};
pub use records::{Change, Costs, FoldKey, FoldRecord, OtherStatistics, Timing};
pub use results::{FoldScores, NetworkResults, Results};
pub use run_models::read_weights;
pub use schedule::Schedule;
pub use search::{Chosen, Combination, Search, Trial};
pub use sensor::{SensorFacts, sensor};
pub use session::forget;
pub use table::Table;
pub use taxel_guard as guard;
pub use teacher::Teacher;
