//! What the library refuses, as the Python exception of its kind with the library's own words.

use std::io::ErrorKind;

use pyo3::PyErr;
use pyo3::exceptions::{
    PyArithmeticError, PyFileExistsError, PyFileNotFoundError, PyIsADirectoryError, PyKeyboardInterrupt,
    PyOSError, PyPermissionError, PyRuntimeError, PyValueError,
};
use taxel::panics::Panic;
use taxel::{data, experiment, learn};
use taxel_checkpoint::Cause;

/// The exception of an error.
pub fn raised(error: impl Into<taxel::Error>) -> PyErr {
    let error = error.into();
    let text = error.to_string();
    match kind(&error) {
        Kind::File(ErrorKind::NotFound) => PyFileNotFoundError::new_err(text),
        Kind::File(ErrorKind::PermissionDenied) => PyPermissionError::new_err(text),
        Kind::File(ErrorKind::IsADirectory) => PyIsADirectoryError::new_err(text),
        Kind::File(ErrorKind::AlreadyExists) => PyFileExistsError::new_err(text),
        Kind::File(_) => PyOSError::new_err(text),
        Kind::Diverged => PyArithmeticError::new_err(text),
        Kind::Stopped => PyKeyboardInterrupt::new_err(text),
        Kind::Asked => PyValueError::new_err(text),
    }
}

/// Something that was asked for and is not possible.
pub fn refused(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A defect.
pub fn defect(panic: &Panic) -> PyErr {
    PyRuntimeError::new_err(panic.to_string())
}

/// What kind of thing went wrong.
enum Kind {
    /// The system refused a file.
    File(ErrorKind),
    /// Training left the finite numbers.
    Diverged,
    /// Ctrl-C.
    Stopped,
    /// What was asked for is not possible.
    Asked,
}

fn kind(error: &taxel::Error) -> Kind {
    match error {
        taxel::Error::Data(error) => of_data(error),
        taxel::Error::Learn(error) => of_learn(error),
        taxel::Error::Judge(taxel::judge::Error::Learn(error)) => of_learn(error),
        taxel::Error::Judge(taxel::judge::Error::Report(taxel::report::Error::Write { .. })) => {
            Kind::File(ErrorKind::Other)
        }
        taxel::Error::Experiment(error) => match error {
            experiment::Error::Data(error) => of_data(error),
            experiment::Error::Learn(error) => of_learn(error),
            experiment::Error::File(error) => error.kind.map_or(Kind::Asked, Kind::File),
            experiment::Error::Onnx(error) => of_onnx(error),
            _ => Kind::Asked,
        },
        taxel::Error::Onnx(error) => of_onnx(error),
        taxel::Error::Io(error) => Kind::File(error.kind()),
        _ => Kind::Asked,
    }
}

fn of_data(error: &data::Error) -> Kind {
    match error {
        data::Error::NotFound { .. } => Kind::File(ErrorKind::NotFound),
        data::Error::Io { kind, .. } => Kind::File(*kind),
        data::Error::Write { .. } => Kind::File(ErrorKind::Other),
        _ => Kind::Asked,
    }
}

fn of_learn(error: &learn::Error) -> Kind {
    match error {
        learn::Error::Io { source, .. } => Kind::File(source.kind()),
        learn::Error::Data(error) => of_data(error),
        learn::Error::Checkpoint(error) => match &error.cause {
            Cause::Io(error) | Cause::Write(error) => Kind::File(error.kind()),
            _ => Kind::Asked,
        },
        learn::Error::Diverged { .. }
        | learn::Error::NothingChosen { .. }
        | learn::Error::Unfinished { .. } => Kind::Diverged,
        learn::Error::Cancelled { .. } => Kind::Stopped,
        _ => Kind::Asked,
    }
}

fn of_onnx(error: &taxel::onnx::Error) -> Kind {
    match &*error.cause {
        taxel::onnx::Cause::Io(error) | taxel::onnx::Cause::Write(error) => Kind::File(error.kind()),
        _ => Kind::Asked,
    }
}
