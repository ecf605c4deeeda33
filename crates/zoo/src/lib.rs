//! The registry: every network by name, with its configuration, inputs and paper.
//!
//! ```
//! let entry = taxel_zoo::find("hybrid-resvgg")?;
//! let graph = entry.graph(&taxel_zoo::Settings::new())?;
//! assert_eq!(graph.parameter_count(), 116_547);
//!
//! let mut settings = taxel_zoo::Settings::new();
//! settings.insert("clases".into(), 28.into());
//! let error = entry.graph(&settings).unwrap_err();
//! assert!(error.to_string().starts_with("hybrid-resvgg: unknown field `clases`"));
//! # Ok::<(), taxel_zoo::Error>(())
//! ```
//!
//! A custom network joins them. Its settings are a struct that serde reads, its graph is what
//! [`Architecture`](taxel_graph::Architecture) makes of them:
//!
//! ```
//! use serde::{Deserialize, Serialize};
//! use taxel_graph::{Architecture, Conv, Graph, Network, at_least};
//! use taxel_zoo::{Entry, Input, Registry, Settings};
//!
//! #[derive(Clone, Serialize, Deserialize)]
//! #[serde(deny_unknown_fields, default)]
//! struct Tiny {
//!     classes: usize,
//!     in_channels: usize,
//!     length: usize,
//! }
//!
//! impl Default for Tiny {
//!     fn default() -> Self {
//!         Tiny { classes: 3, in_channels: 5, length: 50 }
//!     }
//! }
//!
//! impl Architecture for Tiny {
//!     fn graph(&self) -> taxel_graph::Result<Graph> {
//!         at_least(&[("classes", self.classes, 2)])?;
//!         let net = Network::new("tiny");
//!         let signal = net.input("signal", &[self.in_channels, self.length]);
//!         let features = signal.conv_bn_relu("stem", Conv::new(8, 3)).global_average_pool();
//!         net.finish(&[("logits", features.linear("fc", self.classes))])
//!     }
//! }
//!
//! let mut registry = Registry::built_in();
//! registry.add(Entry::of(Tiny::default(), "tiny", "my-lab", "unpublished", [Input::signal()]))?;
//!
//! // Sized by the data, as every network is: 4 classes of 2 × 20 readings.
//! let entry = registry.find("tiny")?;
//! let settings = entry.fit(4, |input| (input == "signal").then(|| vec![2, 20]))?;
//! assert_eq!(entry.graph(&settings)?.parameter_count(), 8 * 2 * 3 + 8 + 16 + 4 * 8 + 4);
//!
//! let error = registry.find("tinny").unwrap_err();
//! assert_eq!(error.to_string(), "no network is called `tinny`; did you mean `tiny`?");
//! # Ok::<(), taxel_zoo::Error>(())
//! ```

mod built_in;
mod entry;
mod error;
mod registry;

pub use built_in::{built_in, find};
pub use entry::{BuildError, Entry, Input, Settings, WIDTH_MULT, WITHOUT_BLOCKS, WITHOUT_LAYERS};
pub use error::{Error, Result};
pub use registry::Registry;

/// MATLAB's layer numbers of a graph, by which Rouhafzay et al. 2021 name frozen layers.
pub use taxel_visuotactile::matlab;
