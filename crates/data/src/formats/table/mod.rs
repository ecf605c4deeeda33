//! Tables in CSV, TSV and Parquet: what their columns and rows are.

pub(crate) mod column_kind;
pub(crate) mod column_name;
pub(crate) mod columns;
pub(crate) mod decorated;
pub(crate) mod file_doubts;
pub(crate) mod filled_in;
pub(crate) mod label_changes;
pub(crate) mod long;
pub(crate) mod number_form;
pub(crate) mod options;
pub(crate) mod recording;
pub(crate) mod recording_columns;
pub(crate) mod row_source;
pub(crate) mod separators;
pub(crate) mod table;
pub(crate) mod targets;
pub(crate) mod text_columns;
pub(crate) mod time_text;
