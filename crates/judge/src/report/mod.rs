//! The report of a run: one page that needs nothing else, charts as SVG and PNG, tables as Markdown and CSV.
//!
//! Everything is a function of the judgement and the choice: equal ones give equal bytes.

mod charts;
mod curve_words;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod fixture;
mod names;
mod overview;
mod page;
mod ranked;
mod report;
mod survey;
mod tables;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests;
mod words;

pub use curve_words::curve_words;
pub use overview::{OverviewRun, overview};
pub use ranked::Ranked;
pub use report::{NetworkSummary, Report, report};
pub use survey::survey_page;
