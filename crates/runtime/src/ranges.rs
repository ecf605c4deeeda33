//! What values a network holds, seen on samples like those that it will be asked about.

use std::collections::BTreeMap;

/// The least and the largest value of each node, by name.
pub type Ranges = BTreeMap<String, [f32; 2]>;
