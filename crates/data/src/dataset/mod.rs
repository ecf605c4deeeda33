//! The data set in memory, and how stored arrays become one.

pub(crate) mod assemble;
pub(crate) mod channel_facts;
pub(crate) mod channel_names;
pub(crate) mod dataset;
pub(crate) mod digest;
pub(crate) mod facts;
pub(crate) mod frames;
pub(crate) mod full_scale;
pub(crate) mod labels;
pub(crate) mod learn;
pub(crate) mod memory;
pub(crate) mod one_hot;
pub(crate) mod precision;
pub(crate) mod problems;
pub(crate) mod quantities;
pub(crate) mod raw;
pub(crate) mod rows;
pub(crate) mod sample_spec;
pub(crate) mod source;
pub(crate) mod spec_of;
pub(crate) mod target_steps;
pub(crate) mod targets;
pub(crate) mod validate;
