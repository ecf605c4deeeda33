//! Work without Python's lock: short work here, long work on a separate thread while this one watches for Ctrl-C.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::{PyErr, PyResult, Python, pyfunction};
use taxel::panics::caught;

use crate::raise::defect;

/// Time between two looks for Ctrl-C.
const LISTEN: Duration = Duration::from_millis(50);
/// Stack of a thread that trains; that of a main thread.
const STACK: usize = 8 << 20;

/// Runs short work while other threads of Python go on.
pub fn short<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    py.detach(|| caught(work)).map_err(|panic| defect(&panic))?
}

/// Runs long work as [`short`]; Ctrl-C sets the flag that `work` gets, and is raised once `work` has ended.
pub fn long<T: Send>(py: Python<'_>, work: impl FnOnce(&AtomicBool) -> PyResult<T> + Send) -> PyResult<T> {
    let cancel = AtomicBool::new(false);
    py.detach(|| {
        let (working, ended) = channel::<()>();
        std::thread::scope(|scope| {
            let cancel = &cancel;
            let job = move || {
                // Gone when the work is over, however it ends.
                let _working = working;
                caught(|| work(cancel))
            };
            let thread = std::thread::Builder::new().name("taxel".into()).stack_size(STACK);
            let thread = thread
                .spawn_scoped(scope, job)
                .map_err(|e| PyRuntimeError::new_err(format!("a thread cannot be started: {e}")))?;
            let mut interrupted: Option<PyErr> = None;
            while ended.recv_timeout(LISTEN) == Err(RecvTimeoutError::Timeout) {
                if let Err(signal) = Python::attach(|py| py.check_signals()) {
                    cancel.store(true, Ordering::Relaxed);
                    interrupted.get_or_insert(signal);
                }
            }
            let outcome =
                thread.join().map_err(|_| PyRuntimeError::new_err("a thread ended without a word"))?;
            match interrupted {
                Some(signal) => Err(signal),
                None => outcome.map_err(|panic| defect(&panic))?,
            }
        })
    })
}

/// Panics, to test what becomes of a defect.
#[pyfunction]
pub fn fail(py: Python<'_>, text: &str) -> PyResult<()> {
    #[expect(clippy::panic, reason = "it is what the function is for")]
    short(py, || panic!("{text}"))
}
