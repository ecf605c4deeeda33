//! Panics, caught where a program ends: at the edge of a command, or of another language.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, Once, PoisonError};

/// Place of the last panic.
static PLACE: Mutex<Option<String>> = Mutex::new(None);

/// A panic of taxel or of a library below it: a defect.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Panic {
    /// Its message, as one line.
    pub text: String,
    /// File and line.
    pub place: String,
}

impl std::fmt::Display for Panic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Panic { text, place } = self;
        write!(
            f,
            "failed inside: {text} ({place}); this is a defect, please report it; RUST_BACKTRACE=1 shows more"
        )
    }
}

impl std::error::Error for Panic {}

/// Runs `work` and returns its panic as an error. Nothing is printed unless `RUST_BACKTRACE` asks for it. Nothing of
/// `work` may outlive the call half done.
///
/// # Errors
/// The panic.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Panic> {
    listen();
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let text = text.or(payload.downcast_ref::<&str>().copied()).unwrap_or("no reason given");
        let place = PLACE.lock().unwrap_or_else(PoisonError::into_inner).take();
        Panic {
            text: text.split_whitespace().collect::<Vec<_>>().join(" "),
            place: place.unwrap_or_else(|| "unknown place".into()),
        }
    })
}

/// Remembers the places of panics from now on.
fn listen() {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(|| {
        let report = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0") {
                report(panic);
            }
            *PLACE.lock().unwrap_or_else(PoisonError::into_inner) = panic.location().map(ToString::to_string);
        }));
    });
}
