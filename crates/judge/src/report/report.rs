//! The report of one run: its page, tables and charts as files.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Map, Value};
use taxel_base::Grid;
use taxel_report::files::{File, make, of_chart, of_table, slug, write};
use taxel_report::palette::Paint;
use taxel_report::pictures::{ArrayPicture, Shown, show};
use taxel_report::table::Table;

use super::charts::charts;
use super::page::page;
use super::tables::{networks, tables};
use crate::error::{Error, Result};
use crate::values::{Choice, Judgement};

/// Files of a report by their path below the run folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    files: Vec<File>,
    /// The first table of the page.
    pub summary: NetworkSummary,
}

/// The table of the networks, for a terminal and for scripts.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkSummary {
    /// The table for people.
    pub grid: Grid,
    /// The table for programs: one object per row, units in the keys, null for what is not known.
    pub json: Vec<Map<String, Value>>,
}

/// Folders that belong to a report alone.
const FOLDERS: [&str; 2] = ["tables", "charts"];
/// Endings of the files in them, half-written ones of killed processes included.
const ENDINGS: [&str; 5] = ["svg", "png", "md", "csv", "part"];

/// Makes the report of one run.
///
/// # Errors
/// A chart that cannot be drawn, or a picture of the judgement that is not what it says.
pub fn report(judgement: &Judgement, choice: Option<&Choice>) -> Result<Report> {
    let tables = tables(judgement, choice)?;
    let charts = charts(judgement, choice);
    let html = page(judgement, choice, &tables, &charts)?.into_string();
    let mut files = vec![("report.html".to_string(), html.into_bytes())];
    files.extend(tables.iter().flat_map(of_table));
    let drawn: Vec<[File; 2]> = charts.par_iter().map(of_chart).collect::<taxel_report::Result<_>>()?;
    files.extend(drawn.into_iter().flatten());
    for (i, example) in judgement.examples.iter().enumerate() {
        for picture in &example.pictures {
            let name = format!("charts/example-{}-{}", i + 1, slug(&picture.name));
            files.extend(pictured(&name, picture)?);
        }
    }
    Ok(Report { files, summary: NetworkSummary::of(&networks(judgement, choice)) })
}

fn pictured(name: &str, picture: &ArrayPicture) -> Result<Vec<File>> {
    Ok(match show(picture, Paint::Print)? {
        Shown::Drawing(canvas) => vec![
            (format!("{name}.svg"), canvas.svg(&picture.name).into_bytes()),
            (format!("{name}.png"), canvas.png()?),
        ],
        Shown::Pixels(_, _, png) => vec![(format!("{name}.png"), png)],
    })
}

impl NetworkSummary {
    fn of(table: &Table) -> Self {
        // Of a number what is not known is null, of a text it is empty.
        let value = |right: bool, text: &str| match (right, text.parse::<f64>()) {
            (true, Ok(number)) => Value::from(number),
            (true, Err(_)) => Value::Null,
            (false, _) => Value::from(text),
        };
        let mut json = vec![];
        for row in &table.rows {
            let mut object = Map::new();
            for (head, cell) in table.heads.iter().zip(row) {
                let fields = head.csv.iter().zip(&cell.values);
                object.extend(fields.map(|(name, text)| (name.clone(), value(head.right, text))));
            }
            json.push(object);
        }
        NetworkSummary { grid: table.shown().ruled(), json }
    }
}

impl Report {
    /// Returns the files: paths below the run folder, and contents.
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
            make(&folder.join(part))?;
        }
        self.files.iter().rev().try_for_each(|file| write(folder, file))?;
        let written: BTreeSet<PathBuf> = self.files.iter().map(|(name, _)| folder.join(name)).collect();
        for part in FOLDERS {
            let part = folder.join(part);
            for entry in fs::read_dir(&part).map_err(|e| Error::write(&part, e))? {
                let path = entry.map_err(|e| Error::write(&part, e))?.path();
                let ours = path.extension().is_some_and(|e| ENDINGS.iter().any(|ending| e == *ending));
                if ours && !written.contains(&path) {
                    fs::remove_file(&path).map_err(|e| Error::write(&path, e))?;
                }
            }
        }
        Ok(folder.join("report.html"))
    }
}
