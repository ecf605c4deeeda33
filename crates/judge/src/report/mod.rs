//! The report of a run: one page that needs nothing else, charts as SVG and PNG, tables as Markdown and CSV.
//!
//! Everything is a function of the judgement, the choice and the claims: equal ones give equal bytes.

mod axes;
mod canvas;
mod charts;
mod files;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod fixture;
mod html;
mod names;
mod numbers;
mod overview;
mod page;
mod palette;
mod pictures;
mod ranked;
mod report;
mod shrunk;
mod survey;
mod sweep;
mod tables;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests;
mod words;

pub use overview::{Entry, overview};
pub use report::{Report, Summary, report};
pub use shrunk::shrunk_page;
pub use survey::survey_page;
pub use sweep::sweep_page;
