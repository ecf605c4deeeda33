//! A guard before every model: it finds channels and taxels that are known to be broken, and replaces their values by
//! predictions from the training data.
//!
//! An *element* is a channel of a series, a taxel of an array, a feature; its *window* is its values in one sample.
//! [`Guard::fit`] learns from clean training samples alone how well the neighbours of an element predict it: the
//! four taxels around it, or the four channels that go with it most closely. [`Watch::mend`] then looks at one raw
//! sample, before any encoding.
//!
//! # Reference
//!
//! None: the rules are ours, [`BrokenKind`] says them, [`limits`] holds their numbers. `scripts/fixtures/guard.py` is the same in NumPy.
//!
//! ```
//! use ndarray::Array3;
//! use std::sync::Arc;
//! use taxel_guard::{KnownRange, Guard, BrokenKind, Layout, Watch};
//!
//! // Three channels that rise together.
//! let train = Array3::from_shape_fn((40, 3, 20), |(i, c, t)| ((i % 7 + 1) * (c + 1) * t) as f32);
//! let guard = Guard::fit(train.view().into_dyn(), Layout::Series, &KnownRange::default())?;
//! let mut sample: Vec<f32> = train.outer_iter().next().unwrap().iter().copied().collect();
//! sample[20..40].fill(399.0); // Channel 1 is stuck at the highest reading.
//! let mut watch = Watch::new(Arc::new(guard));
//! let found = watch.mend(&mut sample);
//! assert_eq!((found.len(), found[0].element, found[0].kind), (1, 1, BrokenKind::Full));
//! assert!((sample[39] - 38.0).abs() < 0.1); // As the other two say.
//! # Ok::<(), taxel_guard::Error>(())
//! ```

mod channels;
mod error;
mod fit;
mod guard;
pub mod limits;
mod places;
mod ranking;
mod watch;
mod window;

pub use error::{Error, Result};
pub use fit::KnownRange;
pub use guard::{BrokenKind, Guard, Link};
pub use taxel_base::Layout;
pub use watch::{ReplacedElement, Watch};
