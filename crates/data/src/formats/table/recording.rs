//! One recording of a table.

use crate::Result;
use crate::formats::table::columns::TableColumns;
use crate::formats::table::text_columns::TableRow;

/// One recording of a table, without its values.
pub(crate) struct TableRecording {
    pub name: String,
    /// Of each column of labels; empty where a row has none.
    pub labels: Vec<String>,
    pub group: Option<String>,
    /// Not 0 where it is tested on.
    pub mark: Option<i64>,
    /// Line of its first row, and the file that holds it.
    pub line: u64,
    pub file: String,
}

impl TableRecording {
    /// Takes name, label, group and mark of a recording from a row.
    pub fn of(row: &TableRow, name: String, columns: &TableColumns) -> Result<Self> {
        Ok(Self {
            name,
            labels: columns.labels.iter().map(|at| row.label(*at)).collect(),
            group: columns.group.map(|at| row.named(at)).transpose()?,
            mark: columns.test.map(|at| row.mark(at)).transpose()?,
            line: row.line,
            file: row.file.into(),
        })
    }
}
