//! Files of a report.

use std::path::{Path, PathBuf};

use maud::Markup;

use crate::chart::Chart;
use crate::error::{Error, Result};
use crate::html::frame;
use crate::palette::Paint;
use crate::table::Table;

/// A path below the folder of a report, and what stands there.
pub type File = (String, Vec<u8>);

/// Returns the files of a table: Markdown and CSV.
pub fn of_table(table: &Table) -> [File; 2] {
    let name = |ending| format!("tables/{}.{ending}", table.name);
    [(name("md"), table.markdown().into_bytes()), (name("csv"), table.csv().into_bytes())]
}

/// Returns the files of a chart: SVG and PNG.
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

/// Writes `index.html` below `folder`, last, with its tables and charts as files beside it. Returns the path of the page.
///
/// # Errors
/// A chart that cannot be drawn, a file that cannot be written.
pub fn write_page<'a>(
    folder: &Path,
    (title, body): (&str, &Markup),
    tables: impl IntoIterator<Item = &'a Table>,
    charts: impl IntoIterator<Item = &'a Chart<'a>>,
) -> Result<PathBuf> {
    make(&folder.join("tables"))?;
    tables.into_iter().flat_map(of_table).try_for_each(|file| write(folder, &file))?;
    for chart in charts {
        make(&folder.join("charts"))?;
        of_chart(chart)?.iter().try_for_each(|file| write(folder, file))?;
    }
    let page = frame(title, body).into_string();
    write(folder, &("index.html".into(), page.into_bytes()))?;
    Ok(folder.join("index.html"))
}

/// Makes a folder, if it is not there.
///
/// # Errors
/// A folder that cannot be made.
pub fn make(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e))
}

/// Returns a name that is safe in a file name and an anchor.
pub fn slug(text: &str) -> String {
    let keep = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    text.chars().map(keep).collect()
}
