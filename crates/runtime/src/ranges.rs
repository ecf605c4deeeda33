//! The ranges of a network's values, seen on samples like those that it will predict.

use std::collections::BTreeMap;

/// The least and the largest value of each node, by name.
pub type Ranges = BTreeMap<String, [f32; 2]>;
