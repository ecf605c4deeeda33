//! Tables in CSV, TSV and Parquet: what their columns and rows are.

pub(crate) mod columns;
pub(crate) mod long;
pub(crate) mod options;
pub(crate) mod table;
pub(crate) mod text_columns;
