//! Readings to tensors: Gramian angular fields, colour maps, frame sequences, dual-channel series,
//! quantile codes, sizes, scaling; less of a raw sample ([`Reduction`]).
//!
//! Everything here is a function of one sample, or is fitted on training data and carries what it
//! has fitted ([`Scaling::ZScore`]). Bad readings are errors that name them, never NaN pixels.
//!
//! # Reference
//!
//! Kaewrakmuk and Srinonchat 2026, section 4.2; for the other papers see each encoding.
//!
//! ```
//! use ndarray::Array3;
//! use taxel_encodings::HardnessImage;
//!
//! let grasps = Array3::from_shape_fn((2, 5, 50), |(_, finger, t)| (finger * t) as f32);
//! let images = HardnessImage::default().encode_batch(grasps.view())?;
//! assert_eq!(images.shape(), [2, 3, 50, 50]);
//! # Ok::<(), taxel_encodings::Error>(())
//! ```

mod bigs;
mod colormap;
mod error;
mod finite;
mod gaf;
mod hardness;
mod history;
pub mod numatac;
mod quantile_code;
mod reduction;
mod resize;
mod scale;
mod sequence;
mod viridis;

pub use bigs::{ElectrodeImage, Order};
pub use colormap::Colormap;
pub use error::{Error, RefusedReduction, Result};
pub use gaf::{Constant, Gaf, Method, Range};
pub use hardness::{HardnessImage, ImagePlan};
pub use history::History;
pub use numatac::NumaTac;
pub use quantile_code::{CodePlan, CodeView, QuantileCode};
pub use reduction::{Converter, Reduction, ReductionPlan};
pub use resize::{Filter, Resize, ResizePlan, red_channel};
pub use scale::Scaling;
pub use sequence::{OneFrame, TactileTensor, all_frames};
