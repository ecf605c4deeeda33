//! Commands that say how the others are used: shells, manual pages, keys of a config.

pub mod completions;
pub mod man;
pub mod schema;
