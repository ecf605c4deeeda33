//! Networks made of others: parts of them, two halves, other heads, widths and depths, stitched weights.

mod depth;
mod halves;
mod head;
mod parts;
mod resize;
mod transfer;
mod unit;
mod width;

pub use halves::Halves;
