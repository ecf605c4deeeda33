//! Models as C for microcontrollers, with the bits of `taxel predict`: networks in eight bits or in floats, MiniRocket and ridge.
//!
//! A [`Library`] is printed from the steps and places of the runtime ([`Blueprint`](taxel_runtime::Blueprint)), never from the
//! graph: what the runtime joins, rounds and leaves in floats, the C does as well. [`Library::files`] is the folder: C99 with
//! constant tables and one arena, a test that tries every threshold of every layer, and what Arduino, PlatformIO, Zephyr and
//! CMake expect. [`write_folder`] writes it whole or not at all.
//!
//! In eight bits sums are whole numbers. What follows (a product, an addend, zero, bounds, rounding to even) are single operations of
//! 32-bit floats, none of which may be fused with another. In floats all products are fused, in the runtime's order. What cannot be done with the same bits is refused with the reason.
//!
//! ```
//! use taxel_encodings::Scaling;
//! use taxel_firmware::{Answers, Encoding, Expected, Library, Method, Samples};
//! use taxel_graph::{Architecture, Scheme, Weights};
//! use taxel_reference_networks::MlpConfig;
//! use taxel_runtime::{Blueprint, Frozen, Observer};
//!
//! let graph = MlpConfig { classes: 2, in_features: 12, hidden: 8 }.graph()?;
//! let weights = Weights::init(&graph, Scheme::Pytorch, 0, "doc");
//! let samples = Samples::new(3, &[[0.0, 1.0]; 2], 6);
//! let mut observer = Observer::new(&graph, &weights)?;
//! for sample in samples.values().chunks(12) {
//!     observer.see(&[sample])?;
//! }
//! let ranges = observer.ranges();
//! let blueprint = Blueprint::new(&graph, &weights, &ranges)?;
//! let frozen = Frozen::quantized(&graph, &weights, &ranges)?;
//! let mut expected = Expected { outputs: vec![0.0; 6], ..Expected::default() };
//! frozen.predict_many(&mut frozen.workspace(), &[&samples.values()], &mut expected.outputs)?;
//! expected.answers = expected.outputs.clone();
//! expected.answers.chunks_mut(2).for_each(taxel_base::exponential::softmax);
//!
//! let (encoding, answers) = (Encoding::Scaled(&Scaling::Raw), Answers::classes(vec!["soft".into(), "hard".into()]));
//! let library = Library::new("squeeze", Method::Network(&blueprint), (encoding, [2, 6]), answers, samples, expected);
//! assert!(library.size()?.ram < 100);
//! let paths: Vec<String> = library.files()?.into_iter().map(|file| file.path).collect();
//! assert!(paths.contains(&"src/taxel_squeeze.c".to_string()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod answers;
mod arena;
mod body;
mod check;
mod cores;
mod encoding;
mod error;
mod floats;
mod fuse;
mod kernel;
mod layer;
mod layouts;
mod library;
mod linear;
mod literals;
mod lower;
mod numbers;
mod print;
mod row_text;
mod rows;
mod samples;
mod size;
mod source;
mod whole;
mod write;

pub use answers::{Answers, Attribute, Gate, Quantity, ReadingsGate, Shares, Spread};
pub use cores::{Core, Part};
pub use encoding::Encoding;
pub use error::{Error, Result};
pub use library::{CFile, Expected, Library, Method};
pub use linear::{Features, Linear};
pub use samples::Samples;
pub use size::Size;
pub use write::write_folder;
