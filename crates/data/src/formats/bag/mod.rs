//! Bags of ROS 2 in MCAP: messages, their types, their topics.

pub(crate) mod bags;
pub(crate) mod cdr;
pub(crate) mod file;
pub(crate) mod json_numbers;
pub(crate) mod message;
pub(crate) mod names;
pub(crate) mod path;
pub(crate) mod ros_type;
pub(crate) mod topics;
pub(crate) mod tracks;
