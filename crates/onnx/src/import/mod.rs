//! A network of another framework, read from ONNX.

mod attributes;
mod draft;
mod int_tables;
mod ints;
mod layers;
mod maths;
mod model;
mod nodes;
mod pools;
mod recurrent;
mod reshape;
mod shapes;
mod stored;
mod values;
mod work;

pub use model::{Imported, from_bytes, read};
