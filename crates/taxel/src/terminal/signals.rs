//! Signals that end a command: at once, or after its work is saved.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use super::interrupt::{GRACE, INTERRUPTED};
use super::messages::note;

/// Exit code of work that was saved and has to be started again (`EX_TEMPFAIL`).
const AGAIN: u8 = 75;

/// Ends the process with these words at Ctrl-C (or SIGTERM): for commands that write whole files and nothing else.
pub fn leave_with(words: &'static str) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        note(words);
        std::process::exit(i32::from(INTERRUPTED));
    })
}

/// Signals to work that is saved before it ends.
#[derive(Default)]
pub struct Signals {
    /// Ends the work after the epoch under way.
    pub stop: Arc<AtomicBool>,
    /// Ends the work at once: the epoch took too long.
    pub cancel: Arc<AtomicBool>,
    code: Arc<AtomicUsize>,
}

impl Signals {
    /// Listens to Ctrl-C, and where there are such signals to SIGTERM and SIGUSR1. A second Ctrl-C ends the process;
    /// schedulers may send theirs to a script and to what it has started, which passes it on.
    pub fn listen() -> Result<Self, Box<dyn std::error::Error>> {
        let signals = Signals::default();
        signals.register()?;
        let (stop, cancel) = (Arc::clone(&signals.stop), Arc::clone(&signals.cancel));
        std::thread::Builder::new().name("signals".into()).spawn(move || {
            while !stop.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(100));
            }
            std::thread::sleep(GRACE);
            cancel.store(true, Ordering::Relaxed);
        })?;
        Ok(signals)
    }

    #[cfg(unix)]
    fn register(&self) -> std::io::Result<()> {
        use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
        use signal_hook::flag;
        flag::register_conditional_shutdown(SIGINT, INTERRUPTED.into(), Arc::clone(&self.stop))?;
        for (signal, code) in [(SIGINT, INTERRUPTED), (SIGTERM, AGAIN), (SIGUSR1, AGAIN)] {
            flag::register_usize(signal, Arc::clone(&self.code), code.into())?;
            flag::register(signal, Arc::clone(&self.stop))?;
        }
        Ok(())
    }

    #[cfg(not(unix))]
    fn register(&self) -> Result<(), ctrlc::Error> {
        let (stop, code) = (Arc::clone(&self.stop), Arc::clone(&self.code));
        ctrlc::set_handler(move || {
            code.store(INTERRUPTED.into(), Ordering::SeqCst);
            if stop.swap(true, Ordering::SeqCst) {
                std::process::exit(i32::from(INTERRUPTED));
            }
        })
    }

    /// Returns the exit code of work that was stopped.
    pub fn code(&self) -> u8 {
        u8::try_from(self.code.load(Ordering::Relaxed)).ok().filter(|code| *code > 0).unwrap_or(AGAIN)
    }
}
