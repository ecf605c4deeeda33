//! Errors of the library as Python exceptions of their kind, with the same words.

use std::io::ErrorKind;

use pyo3::PyErr;
use pyo3::exceptions::{
    PyArithmeticError, PyFileExistsError, PyFileNotFoundError, PyIsADirectoryError, PyKeyboardInterrupt,
    PyOSError, PyPermissionError, PyRuntimeError, PyValueError,
};
use taxel::panics::Panic;
use taxel::{data, experiment, learn};
use taxel_checkpoint::Cause;

/// Returns the exception of an error.
pub fn raised(error: impl Into<taxel::Error>) -> PyErr {
    let error = error.into();
    let text = error.to_string();
    match exception(&error) {
        Exception::File(ErrorKind::NotFound) => PyFileNotFoundError::new_err(text),
        Exception::File(ErrorKind::PermissionDenied) => PyPermissionError::new_err(text),
        Exception::File(ErrorKind::IsADirectory) => PyIsADirectoryError::new_err(text),
        Exception::File(ErrorKind::AlreadyExists) => PyFileExistsError::new_err(text),
        Exception::File(_) => PyOSError::new_err(text),
        Exception::Diverged => PyArithmeticError::new_err(text),
        Exception::Stopped => PyKeyboardInterrupt::new_err(text),
        Exception::Value => PyValueError::new_err(text),
    }
}

/// Returns the exception of a request that is not possible.
pub fn refused(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Returns the exception of a defect.
pub fn defect(panic: &Panic) -> PyErr {
    PyRuntimeError::new_err(panic.to_string())
}

/// Kinds of exceptions.
enum Exception {
    /// The system refused a file.
    File(ErrorKind),
    /// Training left the finite numbers.
    Diverged,
    /// Ctrl-C.
    Stopped,
    /// A request that is not possible.
    Value,
}

fn exception(error: &taxel::Error) -> Exception {
    match error {
        taxel::Error::Data(error) => of_data(error),
        taxel::Error::Learn(error) => of_learn(error),
        taxel::Error::Judge(taxel::judge::Error::Learn(error)) => of_learn(error),
        taxel::Error::Judge(taxel::judge::Error::Data(error)) => of_data(error),
        taxel::Error::Judge(taxel::judge::Error::Report(taxel::report::Error::Write { .. })) => {
            Exception::File(ErrorKind::Other)
        }
        taxel::Error::Experiment(error) => match error {
            experiment::Error::Data(error) => of_data(error),
            experiment::Error::Learn(error) => of_learn(error),
            experiment::Error::File(error) => error.kind.map_or(Exception::Value, Exception::File),
            experiment::Error::Onnx(error) => of_onnx(error),
            _ => Exception::Value,
        },
        taxel::Error::Onnx(error) => of_onnx(error),
        taxel::Error::Io(error) => Exception::File(error.kind()),
        _ => Exception::Value,
    }
}

fn of_data(error: &data::Error) -> Exception {
    match error {
        data::Error::NotFound { .. } => Exception::File(ErrorKind::NotFound),
        data::Error::Io { kind, .. } => Exception::File(*kind),
        data::Error::Write { .. } => Exception::File(ErrorKind::Other),
        data::Error::File(error) => error.kind.map_or(Exception::Value, Exception::File),
        _ => Exception::Value,
    }
}

fn of_learn(error: &learn::Error) -> Exception {
    match error {
        learn::Error::Io { source, .. } => Exception::File(source.kind()),
        learn::Error::Data(error) => of_data(error),
        learn::Error::Checkpoint(error) => match &error.cause {
            Cause::Io(error) | Cause::Write(error) => Exception::File(error.kind()),
            _ => Exception::Value,
        },
        learn::Error::Diverged { .. }
        | learn::Error::NothingChosen { .. }
        | learn::Error::Unfinished { .. } => Exception::Diverged,
        learn::Error::Cancelled { .. } => Exception::Stopped,
        _ => Exception::Value,
    }
}

fn of_onnx(error: &taxel::onnx::Error) -> Exception {
    match &*error.cause {
        taxel::onnx::Cause::Io(error) | taxel::onnx::Cause::Write(error) => Exception::File(error.kind()),
        _ => Exception::Value,
    }
}
