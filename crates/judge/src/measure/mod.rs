//! Measurements of a run: speed, scores under faults, examples.

mod apart;
mod certainty;
mod chance;
mod early;
mod eight_bits;
mod errors;
mod examples;
mod guarding;
mod held_out;
mod importance;
mod judge;
mod parts;
mod pictures;
mod scores;
mod speed;
mod stress;
mod survey;
mod threads;
mod verdict;

pub use early::EarlyOptions;
pub use held_out::{HeldOutRow, held_out};
pub use judge::{JudgeOptions, judge};
pub use speed::speed;
pub use stress::{StressOptions, stress};
pub use survey::survey;
