//! Files of a report.

use std::path::Path;

use crate::chart::Chart;
use crate::error::{Error, Result};
use crate::palette::Paint;
use crate::table::Table;

/// A path below the folder of a report, and what stands there.
pub type File = (String, Vec<u8>);

/// A table as Markdown and as CSV.
pub fn of_table(table: &Table) -> [File; 2] {
    let name = |ending| format!("tables/{}.{ending}", table.name);
    [(name("md"), table.markdown().into_bytes()), (name("csv"), table.csv().into_bytes())]
}

/// A chart as SVG and as PNG.
///
/// # Errors
/// A chart that cannot be drawn.
pub fn of_chart(chart: &Chart) -> Result<[File; 2]> {
    let canvas = chart.canvas(Paint::Print);
    let name = format!("charts/{}", chart.name);
    Ok([
        (format!("{name}.svg"), canvas.svg(&chart.label()).into_bytes()),
        (format!("{name}.png"), canvas.png()?),
    ])
}

/// Writes a file below `folder`, whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write(folder: &Path, (name, bytes): &File) -> Result<()> {
    let path = folder.join(name);
    taxel_base::files::write_whole(&path, bytes).map_err(|e| Error::write(&path, e))
}

/// Makes a folder, if it is not there.
///
/// # Errors
/// A folder that cannot be made.
pub fn make(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e))
}

/// A name that is safe in a file name and an anchor.
pub fn slug(text: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    text.chars().map(keep).collect()
}
