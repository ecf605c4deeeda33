//! One thread for what would spread over many.

use crate::error::{Error, Result};

/// Runs `work` where rayon has one thread: baselines spread over the threads of their pool.
///
/// # Errors
/// A thread that cannot be started, or what `work` refuses.
pub(super) fn alone<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.map_err(|e| Error::Threads { threads: 1, reason: e.to_string() })?.install(work)
}
