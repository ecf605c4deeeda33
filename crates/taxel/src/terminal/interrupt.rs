//! Ctrl-C, and the flag that it sets.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::messages::note;

/// Exit code after Ctrl-C, as shells have it.
pub const INTERRUPTED: u8 = 130;
/// Time that work may take to be saved after the first signal.
#[cfg(feature = "lab")]
pub const GRACE: Duration = Duration::from_secs(20);

/// Returns a flag that Ctrl-C (or SIGTERM) sets; a second one does not wait for the current batch.
///
/// A command that has not ended `grace` later is ended: nobody reads its output, or its work takes too long. Schedulers
/// kill without a word half a minute after the first signal.
pub fn flag(grace: Duration) -> Result<Arc<AtomicBool>, ctrlc::Error> {
    let cancel = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&cancel);
    ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        std::thread::spawn(move || {
            std::thread::sleep(grace);
            // Standard error may wait for a reader too.
            std::thread::spawn(|| {
                note("stopped by a signal: its output waits for a reader, or its work took too long")
            });
            std::thread::sleep(Duration::from_millis(100));
            std::process::exit(i32::from(INTERRUPTED));
        });
    })?;
    Ok(cancel)
}
