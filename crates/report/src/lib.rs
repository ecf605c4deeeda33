//! Reports of any kind: tables, charts, pictures and HTML pages that need no other file.
//!
//! Crates that measure or decide build their own pages with this one; it knows none of their values.
//!
//! - [`table`] holds numbers once, for page, Markdown and CSV.
//! - [`chart`] is a drawing with a title and words on how to read it; [`canvas`], [`axes`], [`labels`] and [`palette`]
//!   draw it, as SVG and PNG, in light and dark.
//! - [`pictures`] draws arrays: signals as lines, images and their sequences as pixels.
//! - [`html`] frames a page; [`files`] names and writes what belongs to it.
//! - [`numbers`] prints numbers as people read them.
//!
//! Equal values give equal bytes.
//!
//! ```
//! use taxel_report::html;
//! use taxel_report::numbers::tenth;
//! use taxel_report::table::{Cell, Column, Table};
//!
//! let rows = [("mlp", 91.25), ("k-nn", 71.0)];
//! let columns = vec![
//!     Column::text("network", "network", |row: &(&str, f64)| Cell::text(row.0)),
//!     Column::number("accuracy %", &["accuracy_percent"], |row: &(&str, f64)| Cell::number(Some(row.1), tenth)),
//! ];
//! let table = Table::new("networks", "Accuracy by network".into(), columns, &rows);
//! assert_eq!(table.csv(), "network,accuracy_percent\nmlp,91.25\nk-nn,71\n");
//!
//! let page = html::frame("Two networks", &html::table(&table)).into_string();
//! assert!(page.contains("<caption") && page.contains("91.2"));
//! ```

pub mod axes;
pub mod canvas;
pub mod chart;
mod error;
pub mod files;
pub mod html;
pub mod labels;
pub mod numbers;
pub mod palette;
pub mod pictures;
pub mod table;

pub use error::{Error, Result};
