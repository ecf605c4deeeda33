//! Numbers that people read.

/// Thousands apart: 1,234,567.
pub fn thousands(number: u64) -> String {
    indicatif::HumanCount(number).to_string()
}
