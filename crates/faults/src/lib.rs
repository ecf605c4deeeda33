//! Faults of tactile sensors in the lab: graded ones on raw samples, to test with
//! ([`Fault::apply`]) and to train under ([`TrainingFaults`]).
//!
//! Every fault acts before any encoding, on simulated and on recorded data alike, in five
//! severities with a physical unit. It keeps the shape, stays within the sensor's range and never
//! makes a NaN. What it draws depends on seed, fault and sample alone: severity 3 breaks the
//! taxels that severity 2 breaks, and more, so a curve over severities compares like with like.
//!
//! # Reference
//!
//! None published as a whole: the table of `docs/faults.md`; each function says what it means.
//!
//! ```
//! use ndarray::Array2;
//! use taxel_faults::{Fault, Layout, Sensor};
//!
//! let sensor = Sensor::new(Layout::Series, 1023.0);
//! let mut grasp = Array2::<f32>::from_elem((5, 50), 900.0);
//! Fault::Saturation.apply(grasp.view_mut().into_dyn(), &sensor, 5, 0, 17)?;
//! assert!(grasp.iter().all(|&v| v == 0.3 * 1023.0));
//! # Ok::<(), taxel_faults::Error>(())
//! ```

mod elements;
mod error;
mod fault;
mod place;
mod sensor;
mod signal;
mod time;
mod training;
mod work;

pub use error::{Error, Result};
pub use fault::Fault;
pub use sensor::Sensor;
pub use taxel_base::Layout;
pub use training::{FaultPlan, TrainingFaults};
