//! A setting outside its range; and those of the tables of training faults and augmentation.

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

/// Turns the refusal of augmentation into a problem of the key that is refused in its table.
pub(crate) fn augment_problem(error: taxel_data::Error) -> Problem {
    match error {
        taxel_data::Error::Augment { key, value, expected } => {
            Problem::new(format!("augment.{key}"), value, expected)
        }
        other => Problem::new("augment", "{ .. }", other.to_string()),
    }
}
