//! Prediction with products of bf16: factors are rounded to it, sums, biases and all values between layers are floats.
//!
//! A convolution first makes pairs of its input ([`crate::half`]) in scratch, then computes as its kind in floats does. All
//! panic where [`supported`](crate::half::supported) is an error.

mod conv;
mod linear;
mod winograd;

pub use conv::Conv;
pub use linear::Linear;
pub use winograd::Winograd;
