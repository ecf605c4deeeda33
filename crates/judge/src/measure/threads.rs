//! Thread pools of a given size.

use crate::error::{Error, Result};

/// Runs `work` where rayon has so many threads; baselines spread over all of them.
///
/// # Errors
/// Threads that cannot be started, or what `work` refuses.
pub(super) fn on<T: Send>(threads: usize, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Error::Threads { threads, reason: e.to_string() })?.install(work)
}
