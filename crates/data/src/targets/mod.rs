//! Targets as files hold them: of recordings or of time steps, values or names of classes.

pub(crate) mod event;
mod event_targets;
pub(crate) mod missing;
pub(crate) mod options;
pub(crate) mod quantities;
pub(crate) mod rows;
pub(crate) mod steps;
pub(crate) mod texts;
