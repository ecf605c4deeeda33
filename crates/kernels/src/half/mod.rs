//! Products of bf16 with sums in f32, by the instruction `vdpbf16ps` of AVX512-BF16.
//!
//! A bf16 is the upper half of a float: 8 bits of mantissa, the same exponents. Factors are rounded to it (nearest,
//! even), two of them lie in the 32 bits of one float, and the kernels of `tile.rs` take two products per
//! lane. A sum goes through its products in order, each fused with it, so that it does not depend on blocks or threads:
//! `fma(a1, b1, fma(a0, b0, sum))` of the rounded factors, where subnormal numbers count as zero.

mod burst;
mod halve;
mod pack;
mod product;
mod support;

pub use burst::burst;
pub use product::{HalfMatrix, multiply};
pub use support::supported;

pub(crate) use halve::halve;
pub(crate) use pack::{pair_columns_of_rows, pair_rows, pair_with_later};
pub(crate) use support::assert_supported;

#[cfg(test)]
mod tests;
