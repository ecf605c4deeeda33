//! One set of vector operations for AVX-512, AVX2 with FMA, NEON, and whatever the compiler makes of four floats.
//! Chosen once, at run time.
//!
//! Kernels are written once over the trait `Simd` and compiled for every width inside a function that
//! carries the target features; everything between is inlined.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod dispatch;
mod level;
#[cfg(target_arch = "aarch64")]
mod neon;
mod portable;
mod product;
mod vector;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub(crate) use avx512::Avx512;
pub(crate) use dispatch::at_level;
#[cfg(target_arch = "aarch64")]
pub(crate) use level::is_wanted;
pub use level::{Level, level};
#[cfg(target_arch = "aarch64")]
pub(crate) use neon::Neon;
pub(crate) use portable::Portable;
#[cfg(target_arch = "x86_64")]
pub(crate) use product::Pairs;
pub(crate) use product::{Floats, Product};
pub(crate) use vector::{Simd, WIDEST};
