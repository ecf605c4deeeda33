//! A network as a value: described once, read by everything else.
//!
//! A [`Graph`] is a list of [`Node`]s: an [`Op`] with its attributes, the nodes it reads, its output
//! shape and its named tensors. `engine` trains it, `devices` runs it on candle, [`Graph::cost`]
//! counts it. Network files write it with [`Network`] and [`Flow`]; serde writes it as a file and reads it back
//! equal, see [`Graph`].
//!
//! Shapes leave the batch axis out and carry axis names in every error:
//!
//! ```
//! use taxel_graph::{Conv, Network};
//!
//! let net = Network::new("too-small");
//! let x = net.input("signal", &[5, 2]).conv("stem", Conv::new(8, 5));
//! let error = net.finish(&[("logits", x)]).unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "stem: kernel 5 along length is larger than the padded size 2; the input is channels 5 × length 2"
//! );
//! ```

mod builder;
mod cost;
mod dropout;
mod edit;
mod error;
mod fill;
mod flow;
mod graph;
mod infer;
mod listing;
mod loss;
mod op;
mod serial;
mod settings;
mod shape;
mod spec;
mod state;
mod weights;
mod window;

pub use builder::Network;
pub use cost::Cost;
pub use dropout::DropoutMask;
pub use edit::Halves;
pub use error::{Error, Result};
pub use fill::Fill;
pub use flow::{BATCH_NORM_EPS, BATCH_NORM_MOMENTUM, Flow};
pub use graph::{Graph, Init, Node, NodeId, Param, TensorKind};
pub use listing::{InputKeys, Listing, NetworkCounts, Register};
pub use loss::{Loss, Targets};
pub use op::{Activation, Op};
pub use settings::{Architecture, at_least, check_width_mult, share, within};
pub use shape::{axis_names, describe};
pub use spec::{Conv, Extent, Padding, Pool};
pub use weights::{Scheme, Tensor, Weights};
pub use window::Window;
