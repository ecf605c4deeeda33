//! Catches panics of foreign readers without a message on standard error.
//!
//! ```
//! let read = |bytes: &[u8]| bytes[0];
//! assert_eq!(taxel_base::quiet::caught(|| read(&[7])), Some(7));
//! assert_eq!(taxel_base::quiet::caught(|| read(&[])), None);
//! ```

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Panics of this thread are not reported now.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Returns the result of `work`, or none where it panics. `work` must leave nothing half done that outlives the call. Panics
/// of other threads are reported as before.
pub fn caught<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !QUIET.get() {
                before(panic);
            }
        }));
    });
    let before = QUIET.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(work));
    QUIET.set(before);
    outcome.ok()
}
