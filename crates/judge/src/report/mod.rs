//! The report of a run: one page that needs nothing else, charts as SVG and PNG, tables as Markdown and CSV.
//!
//! Everything is a function of the judgement, the choice and the claims: equal ones give equal bytes.

mod axes;
mod canvas;
mod charts;
mod html;
mod numbers;
mod overview;
mod page;
mod palette;
mod pictures;
mod tables;
#[cfg(test)]
mod tests;
mod words;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::choice::Choice;
use crate::claims::Claim;
use crate::error::{Error, Result};
use crate::judgement::{Judgement, Picture};
use palette::Paint;
use pictures::Shown;
use rayon::prelude::*;
use serde_json::{Map, Value};

pub use overview::{Entry, overview};

/// Files of a report by their path below the run folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    files: Vec<(String, Vec<u8>)>,
    /// The first table of the page.
    pub summary: Summary,
}

/// The table of the networks, for a terminal and for scripts.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Heads of the columns.
    pub head: Vec<String>,
    /// What people read, row by row.
    pub rows: Vec<Vec<String>>,
    /// Columns that hold numbers.
    pub right: Vec<usize>,
    /// What programs read: one object per row, units in the keys, null for what is not known.
    pub json: Vec<Map<String, Value>>,
}

/// Folders that belong to a report alone.
const FOLDERS: [&str; 2] = ["tables", "charts"];
/// Endings of the files in them.
const ENDINGS: [&str; 4] = ["svg", "png", "md", "csv"];

/// Makes the report of one run.
///
/// # Errors
/// A chart that cannot be drawn.
pub fn report(judgement: &Judgement, choice: Option<&Choice>, claims: &[Claim]) -> Result<Report> {
    let networks = tables::networks(judgement, choice);
    let tables = tables::tables(judgement, choice, claims);
    let charts = charts::charts(judgement, choice);
    let html = page::page(judgement, choice, &tables, &charts).into_string();
    let mut files = vec![("report.html".to_string(), html.into_bytes())];
    for table in &tables {
        files.push((format!("tables/{}.md", table.name), table.markdown().into_bytes()));
        files.push((format!("tables/{}.csv", table.name), table.csv()?));
    }
    let drawn = |chart: &charts::Chart| {
        let label = format!("{}. {}", chart.title, chart.reading);
        drawing(&format!("charts/{}", chart.name), &chart.canvas(Paint::Print), &label)
    };
    let drawings: Vec<_> = charts.par_iter().map(drawn).collect::<Result<_>>()?;
    files.extend(drawings.into_iter().flatten());
    for (i, example) in judgement.examples.iter().enumerate() {
        for picture in &example.pictures {
            let name = format!("charts/example-{}-{}", i + 1, words::slug(&picture.name));
            files.extend(pictured(&name, picture)?);
        }
    }
    Ok(Report { files, summary: Summary::of(&networks) })
}

fn drawing(name: &str, canvas: &canvas::Canvas, label: &str) -> Result<[(String, Vec<u8>); 2]> {
    let png = canvas.png().map_err(|reason| Error::Write { path: format!("{name}.png"), reason })?;
    Ok([(format!("{name}.svg"), canvas.svg(label).into_bytes()), (format!("{name}.png"), png)])
}

fn pictured(name: &str, picture: &Picture) -> Result<Vec<(String, Vec<u8>)>> {
    Ok(match pictures::show(picture, Paint::Print) {
        Some(Shown::Drawing(canvas)) => drawing(name, &canvas, &picture.name)?.into(),
        Some(Shown::Pixels(_, _, png)) => vec![(format!("{name}.png"), png)],
        None => vec![],
    })
}

impl Summary {
    fn of(table: &tables::Table) -> Self {
        let object = |row: &Vec<tables::Cell>| {
            let fields = table.heads.iter().zip(row);
            let pairs =
                fields.flat_map(|(head, cell)| head.csv.iter().zip(&cell.values).map(|v| (head.right, v)));
            let value = |right: bool, text: &str| match (right, text.parse::<f64>()) {
                (true, Ok(number)) => Value::from(number),
                (true, Err(_)) => Value::Null,
                (false, _) => Value::from(text),
            };
            pairs.map(|(right, (name, text))| (name.clone(), value(right, text))).collect()
        };
        Summary {
            head: table.heads.iter().map(|head| head.shown.clone()).collect(),
            rows: table.rows.iter().map(|row| row.iter().map(|cell| cell.shown.clone()).collect()).collect(),
            right: (0..table.heads.len()).filter(|&i| table.heads[i].right).collect(),
            json: table.rows.iter().map(object).collect(),
        }
    }
}

impl Report {
    /// Paths below the run folder and what stands there.
    pub fn files(&self) -> &[(String, Vec<u8>)] {
        &self.files
    }

    /// Writes every file below `folder`, each whole or not at all, the page last; takes files of an earlier
    /// report away that this one does not have. The path of the page.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf> {
        for part in FOLDERS {
            let part = folder.join(part);
            fs::create_dir_all(&part).map_err(|e| refuse(&part, &e))?;
        }
        for (name, bytes) in self.files.iter().rev() {
            write(&folder.join(name), bytes)?;
        }
        let own: BTreeSet<PathBuf> = self.files.iter().map(|(name, _)| folder.join(name)).collect();
        for part in FOLDERS {
            let part = folder.join(part);
            for entry in fs::read_dir(&part).map_err(|e| refuse(&part, &e))? {
                let path = entry.map_err(|e| refuse(&part, &e))?.path();
                let ours = path.extension().is_some_and(|e| ENDINGS.iter().any(|own| e == *own));
                if ours && !own.contains(&path) {
                    fs::remove_file(&path).map_err(|e| refuse(&path, &e))?;
                }
            }
        }
        Ok(folder.join("report.html"))
    }
}

/// Writes one file, whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    taxel_data::write_whole(path, bytes).map_err(|e| refuse(path, &e))
}

fn refuse(path: &Path, error: &std::io::Error) -> Error {
    Error::Write { path: path.display().to_string(), reason: error.to_string() }
}
