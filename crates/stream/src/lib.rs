//! A model on a stream of time steps.
//!
//! A [`Decider`] is pure: time steps in, decisions out. A time step (in code: a reading) is all values of one instant. It slides a
//! [`Window`] over the time steps of one sensor and predicts with the model when the window is full, or earlier where the
//! model is confident enough; a [`Contact`] judge may start the windows, and [`Health`] says which channels are dead, stuck or saturated.
//! [`Stamps`] watches the time stamps for gaps and jumps.
//!
//! Time steps come from a [`StreamSource`]: lines of text, recordings replayed, a serial port. [`start`] reads it on a separate
//! thread into a bounded queue, the [`ReadingStream`].
//!
//! ```
//! use taxel_data::{Dataset, Layout};
//! use taxel_graph::Network;
//! use taxel_learn::{Candidate, Encoding, Recipe, fit};
//! use taxel_stream::{Decider, StreamOptions};
//!
//! // A press of a soft thing rises slowly, one of a hard thing fast.
//! let force = |i: usize, t: usize| (1 + 2 * (i % 2)) as f32 * t as f32;
//! let x = ndarray::ArrayD::from_shape_fn(vec![12, 1, 10], |at| force(at[0], at[2]));
//! let labels: Vec<&str> = (0..12).map(|i| ["soft", "hard"][i % 2]).collect();
//! let presses = Dataset::new("presses", Layout::Series, x, &labels)?;
//! let net = Network::new("linear");
//! let logits = net.input("signal", &[1, 10]).flatten().linear("fc", 2);
//! let candidate = Candidate::network(net.finish(&[("logits", logits)])?, Recipe { epochs: 40, ..Recipe::default() });
//! let model = fit(&candidate, &presses, &Encoding::default())?;
//!
//! let mut decider = Decider::new(model.predictor(1, 1)?, &StreamOptions::default())?;
//! let mut said = vec![];
//! for t in 0..10 {
//!     if let Some(decision) = decider.push(&[force(1, t)]) {
//!         assert!(decision.probabilities().is_ok_and(|all| all.len() == 2));
//!         said.push(decision.reading);
//!     }
//! }
//! assert_eq!(said, [9]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod channels;
mod columns;
#[cfg(test)]
mod columns_tests;
mod contact;
mod decider;
mod error;
mod fault;
mod health;
mod latency_histogram;
mod lines;
#[cfg(feature = "mcap")]
mod messages;
mod numbers;
mod options;
mod pace;
mod queue;
mod replay;
mod rest;
#[cfg(feature = "serial")]
mod serial;
mod source;
mod stamps;
mod text;
mod time_column;
mod window;

pub use channels::StreamChannels;
pub use columns::LineColumns;
pub use contact::Contact;
pub use decider::{Decider, Decision};
pub use error::{Error, Result};
pub use health::{Condition, Health};
pub use latency_histogram::LatencyHistogram;
pub use options::StreamOptions;
pub use pace::Pace;
pub use queue::{Arrival, Next, ReadingStream, StreamCounters, StreamCounts};
pub use source::{SourceSettings, StreamSource, start};
pub use stamps::{Event, Stamps};
pub use time_column::Time;
pub use window::Window;
