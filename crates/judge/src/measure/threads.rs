//! As many threads as are asked for, for what would spread over more.

use crate::error::{Error, Result};

/// Runs `work` where rayon has one thread: baselines spread over the threads of their pool.
///
/// # Errors
/// A thread that cannot be started, or what `work` refuses.
pub(super) fn alone<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    on(1, work)
}

/// Runs `work` where rayon has so many threads.
///
/// # Errors
/// Threads that cannot be started, or what `work` refuses.
pub(super) fn on<T: Send>(threads: usize, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Error::Threads { threads, reason: e.to_string() })?.install(work)
}
