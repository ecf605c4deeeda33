//! The tables of the papers as they are printed: `papers.toml`.

use serde::Deserialize;

use crate::error::Result;
use crate::measure::Measure;
use crate::pages::Pages;

/// The tables of all papers as they are printed, and the pages that have their rows: `papers.toml`.
#[derive(Default, Deserialize)]
pub struct Papers {
    pub(crate) tables: Vec<Printed>,
}

/// A table as it is printed, and the pages that have its rows.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Printed {
    pub paper: String,
    pub table: String,
    pub says: String,
    pub lacks: Option<String>,
    /// The column of the simulated page, where it is not the accuracy.
    pub column: Option<String>,
    /// The attribute whose levels the table lists.
    pub attribute: Option<String>,
    /// Training samples per class of a learning curve.
    pub counts: Option<Vec<u32>>,
    pub simulated: String,
    pub sessions: Option<String>,
    pub imagenet: Option<String>,
    pub small: Option<String>,
    pub real: Option<String>,
    pub rows: Vec<PrintedRow>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PrintedRow {
    /// The row's name in the paper.
    pub is: String,
    /// Its name on our pages.
    pub row: Option<String>,
    pub imagenet_row: Option<String>,
    pub small_row: Option<String>,
    pub real_row: Option<String>,
    pub published: Option<String>,
    pub page: Option<String>,
    /// Precision, recall and F1 of each level.
    pub levels: Option<Vec<[u32; 3]>>,
}

impl Printed {
    /// Returns the page of a column, if the table has it.
    pub fn page(&self, kind: &str) -> Option<&str> {
        match kind {
            "simulated" => Some(&self.simulated),
            "sessions" => self.sessions.as_deref(),
            "imagenet" => self.imagenet.as_deref(),
            "small" => self.small.as_deref(),
            _ => self.real.as_deref(),
        }
    }
}

impl PrintedRow {
    /// Returns the row's name on the page of a column: what starts from ImageNet or is reduced has names of its own.
    pub fn name(&self, kind: &str) -> Option<&str> {
        match kind {
            "imagenet" => self.imagenet_row.as_deref(),
            "small" => self.small_row.as_deref(),
            "real" => self.real_row.as_deref().or(self.row.as_deref()),
            _ => self.row.as_deref(),
        }
    }

    /// Returns the printed text; empty where there is none.
    pub fn published(&self) -> &str {
        self.published.as_deref().unwrap_or_default()
    }
}

impl Papers {
    /// Reads the file of the pages.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub fn of(pages: &Pages) -> Result<Self> {
        pages.read("papers.toml")
    }

    /// Returns how far two networks lie apart as their paper prints them, in points; none where it does not print both.
    pub(crate) fn gap(&self, measure: Measure, one: &str, other: &str) -> Option<f64> {
        let papers = self.tables.iter().map(|table| &table.paper);
        papers.into_iter().find_map(|paper| {
            let value = |zoo: &str| {
                let tables = self.tables.iter().filter(|table| table.paper == *paper);
                tables.filter_map(|table| table.value(measure, zoo)).next()
            };
            Some((value(one)? - value(other)?).abs())
        })
    }
}

impl Printed {
    /// Returns the printed score of a network, in percent.
    fn value(&self, measure: Measure, zoo: &str) -> Option<f64> {
        let attribute = match measure {
            Measure::Accuracy => None,
            Measure::Attribute(name) | Measure::WorstPrecision(name) => Some(name),
        };
        let is_row = |row: &&PrintedRow| [&row.row, &row.small_row].contains(&&Some(zoo.to_string()));
        let row = self.rows.iter().find(is_row).filter(|_| self.attribute.as_deref() == attribute)?;
        match measure {
            Measure::WorstPrecision(_) => row
                .levels
                .as_ref()?
                .iter()
                .map(|[precision, ..]| f64::from(*precision))
                .min_by(f64::total_cmp),
            _ => row.published().split(' ').next()?.parse().ok(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn gaps_are_those_of_the_printed_tables() {
        let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/results");
        let papers = Papers::of(&Pages::at(&pages).unwrap()).unwrap();
        let gap = |measure, a, b| papers.gap(measure, a, b).map(|gap| (100.0 * gap).round() / 100.0);
        assert_eq!(gap(Measure::Accuracy, "vgg6-lite-1d", "vgg6-lite-2d"), Some(0.4));
        assert_eq!(gap(Measure::Accuracy, "hybrid-resvgg", "mlp"), Some(6.34), "of Tables 3 and 5");
        assert_eq!(gap(Measure::Accuracy, "tactnet3d", "tactnet3d-4-8"), Some(15.6));
        assert_eq!(gap(Measure::Attribute("hardness"), "multiscale-cnn", "mobilenet-v2"), Some(5.0));
        // Worst precision of ten levels: 80 against 71.
        assert_eq!(gap(Measure::WorstPrecision("elasticity"), "multiscale-cnn", "mobilenet-v2"), Some(9.0));
        assert_eq!(
            gap(Measure::Accuracy, "multiscale-cnn", "mobilenet-v2"),
            None,
            "levels alone are printed"
        );
        assert_eq!(gap(Measure::Accuracy, "vgg6-lite-1d", "tactnet3d"), None, "of two papers");
    }
}
