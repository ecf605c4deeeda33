//! The code that all crates share: nearest names, whole files, seeded generators, printed tables, layouts of samples.
//!
//! - [`names`] finds the name that was meant, for messages about an unknown one.
//! - [`FileError`] says which file cannot be used, where in it, and why.
//! - [`files`] writes files that are whole or not there.
//! - [`seed`] gives one generator for each seed and purpose.
//! - [`exponential`] gives the same bits on every processor.
//! - [`quiet`] catches panics of foreign readers.
//! - [`Grid`] prints a table of texts, [`thousands`] a large number.
//! - [`printable`] makes foreign texts safe for a terminal, [`spreadsheet_text`] for a spreadsheet.
//! - [`problem`] refuses settings outside their range.
//! - [`Layout`] says what the axes of one raw sample are.
//!
//! ```
//! use taxel_base::{Layout, names, seed};
//!
//! let layout: Layout = "series".parse()?;
//! assert_eq!(layout.axes(), "channels × time");
//! assert_eq!(names::nearest("resnet81d", ["mlp", "resnet8-1d"]), ["resnet8-1d"]);
//! assert_eq!(seed::rng(7, "init/fc.weight"), seed::rng(7, "init/fc.weight"));
//! # Ok::<(), taxel_base::UnknownLayout>(())
//! ```

pub mod exponential;
mod file_error;
pub mod files;
mod grid;
mod layout;
pub mod names;
mod numbers;
mod printable;
pub mod problem;
pub mod quiet;
pub mod seed;

pub use file_error::{FileError, reason};
pub use grid::{Align, Grid, markdown_text};
pub use layout::{Layout, UnknownLayout};
pub use numbers::thousands;
pub use printable::{printable, spreadsheet_text};
pub use problem::Problem;
