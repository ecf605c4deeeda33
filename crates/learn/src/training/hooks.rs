//! The connection of a training to its caller.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::training::session::Saver;

/// The connection of a training to its caller.
pub struct Hooks<'a> {
    /// Hears how many samples each step took.
    pub tick: &'a mut dyn FnMut(usize),
    /// Set from outside to end the training between two steps.
    pub cancel: &'a AtomicBool,
    /// Where it is saved from time to time.
    pub saver: &'a mut Saver,
}

impl Hooks<'_> {
    /// Checks whether the training is to end.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}
