//! Bags of ROS 2 in MCAP: messages, their types, their topics.

#[cfg(feature = "mcap")]
pub(crate) mod bags;
#[cfg(feature = "mcap")]
pub(crate) mod cdr;
#[cfg(feature = "mcap")]
pub(crate) mod file;
#[cfg(feature = "mcap")]
pub(crate) mod image;
#[cfg(feature = "mcap")]
pub(crate) mod json;
#[cfg(feature = "mcap")]
pub(crate) mod message;
#[cfg(feature = "mcap")]
pub(crate) mod messages;
pub(crate) mod names;
#[cfg(feature = "mcap")]
pub(crate) mod numbers;
pub(crate) mod path;
#[cfg(feature = "mcap")]
pub(crate) mod ros_type;
#[cfg(feature = "mcap")]
pub(crate) mod topics;
#[cfg(feature = "mcap")]
pub(crate) mod tracks;
