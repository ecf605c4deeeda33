//! A setting outside its range; and that of a table of training faults.

pub use taxel_base::problem::{Check, Problem, require, share, within};

/// Turns the refusal of training faults into a problem of the key that is refused in their table.
pub(crate) fn fault_problem(error: taxel_faults::Error) -> Problem {
    match error {
        taxel_faults::Error::Parameter { name, value, expected } => {
            Problem::new(format!("faults.{name}"), value, expected)
        }
        taxel_faults::Error::Fault { fault, .. } => Problem::new("faults.kinds", fault, error.to_string()),
        other => Problem::new("faults", "{ .. }", other.to_string()),
    }
}
