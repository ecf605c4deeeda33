//! taxel, the tactile model zoo: train, compare and ship networks on recordings of touch.
//!
//! This crate re-exports all of taxel, so that a program needs no other. The binary of the same name does the same from the
//! command line (`taxel --help`).
//!
//! # From recordings to a model
//!
//! Recordings are a [`Dataset`]: [`load`] reads files, [`Dataset::new`] takes arrays, [`simulate`] makes some.
//! A network is a value, described with [`Network`] and [`Flow`]. A [`Candidate`] is a network with its
//! [`Recipe`] (or a baseline), [`CrossValidation`] measures its accuracy on samples that it has not seen,
//! [`fit`] trains it on everything, and the [`Model`] is one file with everything that a prediction needs.
//!
//! ```
//! use taxel::{Candidate, Conv, CrossValidation, Encoding, Model, Network, Protocol, Recipe};
//!
//! // 60 grasps of silicone cylinders of three hardness levels by five fingertip sensors, 50 readings each.
//! let grasps = taxel::simulate("fingertip", 60, 0, &[])?;
//!
//! let net = Network::new("mine");
//! let signal = net.input("signal", grasps.sample_shape());
//! let features = signal.conv_bn_relu("stem", Conv::new(16, 5).same()).global_average_pool();
//! let graph = net.finish(&[("logits", features.linear("fc", grasps.task().outputs()))])?;
//! let mine = Candidate::network(graph, Recipe { epochs: 5, batch_size: 16, ..Recipe::default() });
//!
//! let validation = CrossValidation::new(&grasps).protocol(Protocol::k_fold(2)).candidate(mine.clone());
//! let results = validation.run()?;
//! println!("{}", taxel::ResultsTable::new(&results, |_| None));
//!
//! let path = std::env::temp_dir().join("taxel-tour.safetensors");
//! taxel::fit(&mine, &grasps, &Encoding::default())?.with_score(results.score("mine")).save(&path)?;
//!
//! let model = Model::open(&path)?;
//! let predictions = model.predict(&grasps.x)?;
//! println!("{}{} ({:.0} %)", model.card(), predictions.class(0), 100.0 * predictions.predicted(0)[0].probability);
//! # assert_eq!(predictions.len(), 60);
//! # std::fs::remove_file(&path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The networks of the papers
//!
//! A [`Registry`] knows networks by name and sizes them by the data; a caller adds its own:
//!
//! ```
//! use taxel::Registry;
//!
//! let registry = Registry::built_in();
//! let entry = registry.find("resnet8-lite-1d")?;
//! let settings = entry.fit(3, |input| (input == "signal").then(|| vec![5, 50]))?;
//! let graph = entry.graph(&settings)?;
//! assert_eq!((graph.parameter_count(), graph.cost().macs), (13_923, 204_928));
//! # Ok::<(), taxel::Error>(())
//! ```
//!
//! # Experiments from a file
//!
//! An [`Experiment`] is a TOML file; [`run()`](experiment::run) writes its run folder, and [`judge`] says from a
//! run folder which network suffices, how fast it is and where it breaks.
//!
//! # Where things are
//!
//! | to | look at |
//! |---|---|
//! | read, check and split recordings | [`data`] |
//! | turn samples into images and tensors | [`encodings`] |
//! | simulate a sensor | [`scenes`] |
//! | corrupt samples on purpose | [`faults`] |
//! | describe a network, count its cost | [`graph`], [`zoo`] |
//! | train, cross-validate, save | [`learn`] |
//! | train step by step | [`engine`] |
//! | run a config | [`experiment`] |
//! | judge a run | [`judge`] |
//! | predict on a stream | [`stream`] |
//! | find how few sensors, readings and bits suffice | [`shrink`] |
//! | run many configs on many machines | [`sweep`] |

mod error;
#[cfg(feature = "lab")]
mod export;
#[cfg(feature = "lab")]
mod firmware;
#[cfg(feature = "lab")]
mod footprint;
#[cfg(feature = "lab")]
mod listing;
pub mod panics;
#[cfg(feature = "lab")]
mod progress;
#[cfg(feature = "lab")]
mod remarks;
#[cfg(feature = "lab")]
pub mod reporting;
#[cfg(feature = "lab")]
mod saved_baseline;

pub use error::{Error, Result};
#[cfg(feature = "lab")]
pub use export::{Exported, ExportedInput, export};
#[cfg(feature = "lab")]
pub use firmware::{ExportedC, export_c, export_c_within};
#[cfg(feature = "lab")]
pub use footprint::{Footprint, Part, footprint, room};
#[cfg(feature = "lab")]
pub use listing::{costs, listing};
pub use ndarray;
#[cfg(feature = "lab")]
pub use progress::IndicatifProgress;
#[cfg(feature = "lab")]
pub use taxel_firmware::Core;

pub use taxel_baselines::Method as Baseline;
pub use taxel_data::{Attribute, Dataset, Labels, Layout, Length, ReadOptions, SampleSpec, Source, load};
pub use taxel_graph::{Architecture, Conv, Flow, Graph, Network, Pool};
pub use taxel_learn::{
    Candidate, Card, CrossValidation, Encoder, Encoding, Fit, Model, Optimizer, Predictions, Predictor,
    Protocol, Recipe, Results, ResultsTable, RunFolder, RunOptions, Schedule, fit,
};
#[cfg(feature = "lab")]
pub use taxel_trainer::{Experiment, Overrides, simulate};
#[cfg(feature = "lab")]
pub use taxel_zoo::{Entry, Input, Registry, Settings};

/// Names, files, seeds, printed tables.
pub use taxel_base as base;
/// Recordings: reading, checking, cards, splits, augmentation.
pub use taxel_data as data;
/// Samples to tensors.
pub use taxel_encodings as encodings;
/// Graphs compiled for training on the CPU.
pub use taxel_engine as engine;
/// Sensor faults: graded ones to test with, drawn ones to train under.
pub use taxel_faults as faults;
/// Networks as values.
pub use taxel_graph as graph;
/// Run folders judged.
#[cfg(feature = "lab")]
pub use taxel_judge as judge;
/// Training, cross-validation, metrics, models.
pub use taxel_learn as learn;
/// Networks as ONNX, out and in.
#[cfg(feature = "lab")]
pub use taxel_onnx as onnx;
/// Tables, charts and pages.
#[cfg(feature = "lab")]
pub use taxel_report as report;
/// Networks frozen for prediction.
pub use taxel_runtime as runtime;
/// Simulated worlds.
#[cfg(feature = "lab")]
pub use taxel_scenes as scenes;
/// How few sensors, readings and bits suffice.
#[cfg(feature = "lab")]
pub use taxel_shrink as shrink;
/// Models on streams of readings.
pub use taxel_stream as stream;
/// Many experiments on many machines.
#[cfg(feature = "lab")]
pub use taxel_sweep as sweep;
/// Experiments from TOML.
#[cfg(feature = "lab")]
pub use taxel_trainer as experiment;
/// Networks by name.
#[cfg(feature = "lab")]
pub use taxel_zoo as zoo;
