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
    /// A score of a learning curve that stands alone on another page.
    pub alone: Option<AloneScore>,
    /// Precision, recall and F1 of each level.
    pub levels: Option<Vec<[u32; 3]>>,
}

/// A score that stands behind the last semicolon of a cell, without SD.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AloneScore {
    pub page: String,
    pub row: String,
    pub column: String,
    /// Training samples per class.
    pub count: u32,
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
        let is_row = |row: &&PrintedRow| [&row.row, &row.small_row].contains(&&Some(zoo.to_string()));
        let row =
            self.rows.iter().find(is_row).filter(|_| self.attribute.as_deref() == measure.attribute())?;
        match measure {
            Measure::Accuracy | Measure::Attribute(_) => row.published().split(' ').next()?.parse().ok(),
            _ => {
                let levels: Vec<[f64; 3]> =
                    row.levels.as_ref()?.iter().map(|level| level.map(f64::from)).collect();
                measure.of_levels(&levels)
            }
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
        assert_eq!(gap(Measure::WorstRecall("hardness"), "multiscale-cnn", "mobilenet-v2"), Some(4.0));
        assert_eq!(gap(Measure::BestF1("elasticity"), "multiscale-cnn", "resnet18"), Some(4.0));
        assert_eq!(
            gap(Measure::Accuracy, "multiscale-cnn", "mobilenet-v2"),
            None,
            "levels alone are printed"
        );
        assert_eq!(gap(Measure::Accuracy, "vgg6-lite-1d", "tactnet3d"), None, "of two papers");
    }
    fn papers() -> Papers {
        let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/results");
        Papers::of(&Pages::at(&pages).unwrap()).unwrap()
    }

    /// Returns the number that a table of Rouhafzay et al. 2021 prints of a row.
    fn percent(papers: &Papers, table: &str, row: &str) -> f64 {
        let table = papers.tables.iter().find(|t| t.paper == "001" && t.table == table).unwrap();
        table.value(Measure::Accuracy, row).unwrap()
    }

    /// Checks three claims whose places say that their own tables contradict or do not support them.
    #[test]
    fn claims_that_their_own_tables_contradict_are_contradicted() {
        let papers = papers();
        let says = |part: &str| {
            let known = crate::claims::CLAIMS.iter().find(|claim| claim.says.contains(part)).unwrap();
            known.place.to_string()
        };
        // ResNet50 is not the best of Table 1, and is of Tables 2 to 5.
        let leads = |table: &str| {
            let of = |row: &str| percent(&papers, table, row);
            ["alexnet", "googlenet", "vgg16", "mobilenet-v2"]
                .iter()
                .all(|other| of("resnet50-tuned") > of(&format!("{other}-tuned")))
        };
        let tables = ["Table 1", "Table 2", "Table 3", "Table 4", "Table 5"];
        assert_eq!(tables.map(leads), [false, true, true, true, true]);
        assert!(
            percent(&papers, "Table 1", "mobilenet-v2-tuned") > percent(&papers, "Table 1", "resnet50-tuned")
        );
        assert!(says("ResNet50 is the best").ends_with("its own Table 1 has MobileNetV2 ahead"));
        // MnasNet's worst recall of an elasticity level is above multi-scale's; of a hardness level it is not.
        let worst = |attribute: &'static str, zoo: &str| {
            let measure = Measure::WorstRecall(attribute);
            papers.tables.iter().filter(|t| t.paper == "004").find_map(|t| t.value(measure, zoo)).unwrap()
        };
        let ahead = |zoo: &str| worst("elasticity", zoo) > worst("elasticity", "multiscale-cnn");
        assert_eq!(
            ["mnasnet1-0", "resnet18", "shufflenet-v2", "mobilenet-v2"].map(ahead),
            [true, false, false, false]
        );
        assert!(worst("hardness", "mnasnet1-0") < worst("hardness", "multiscale-cnn"));
        assert!(says("worst recall of an elasticity").ends_with("its own Table 2 has MnasNet ahead"));
        // Two SDs over five folds each: for four and four degrees of freedom P(F > f) = 3x² - 2x³ with x = 1 / (1 + f).
        let table = papers.tables.iter().find(|t| t.paper == "000" && t.table == "Table 4").unwrap();
        let sds: Vec<f64> = table
            .rows
            .iter()
            .map(|row| row.published().split("± ").nth(1).unwrap().parse().unwrap())
            .collect();
        let x = 1.0 / (1.0 + (sds[1] / sds[0]).powi(2));
        let p = 2.0 * (3.0 * x * x - 2.0 * x * x * x);
        assert!(says("head adds spread").ends_with(&format!("(F-test, p = {p:.2})")), "{p}");
    }

    /// Checks that "around a random guess" reaches as far as ResNet50's frozen row of Table 3.
    #[test]
    fn around_chance_is_what_table_3_prints() {
        let papers = papers();
        let table = papers.tables.iter().find(|t| t.paper == "001" && t.table == "Table 3").unwrap();
        let frozen =
            table.rows.iter().filter_map(|row| row.row.as_deref()).filter(|row| row.ends_with("-frozen"));
        let most = frozen.map(|row| percent(&papers, "Table 3", row)).fold(0.0, f64::max);
        let above = (100.0 * (most - 100.0 / 6.0)).round() / 100.0;
        assert!((above - crate::claims::AROUND_CHANCE).abs() < 0.011, "{above}");
    }

    /// Returns the numbers of test samples up to 3000 that fit all ten printed percentages but so many.
    fn fitting(papers: &Papers, table: &str, misprints: usize) -> Vec<u32> {
        let table = papers.tables.iter().find(|t| t.paper == "001" && t.table == table).unwrap();
        let printed: Vec<f64> = table.rows.iter().map(|row| row.published().parse().unwrap()).collect();
        let fits = |n: u32, percent: f64| {
            let right = (percent * f64::from(n) / 100.0).round();
            (100.0 * right / f64::from(n) - percent).abs() <= 0.0051
        };
        (10..3000)
            .filter(|&n| printed.iter().filter(|&&percent| !fits(n, percent)).count() <= misprints)
            .collect()
    }

    /// Sizes of the test sets of Rouhafzay et al. 2021 follow from its percentages, and its configs take them.
    #[test]
    fn sample_counts_of_the_configs_are_those_of_the_printed_percentages() {
        let papers = papers();
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/visuotactile");
        let test = |table: u32| {
            let path = configs.join(format!("visuotactile-001-fresh-table-{table}.toml"));
            let config: toml::Table = std::fs::read_to_string(path).unwrap().parse().unwrap();
            let of = |key: &str| config["protocol"][key].as_integer().unwrap();
            // 75 % of all are trained on.
            assert_eq!(of("train"), 3 * i64::from(PRINTED[table as usize - 1]), "Table {table}");
        };
        (1..=5).for_each(test);
        for (table, count) in PRINTED.into_iter().enumerate() {
            let name = format!("Table {}", table + 1);
            // GoogLeNet's 39.57 of Table 3 is no multiple of 1/210: 39.52 is.
            let fits = fitting(&papers, &name, usize::from(table == 2));
            assert_eq!(fits.first(), Some(&count), "{name}: {fits:?}");
            assert!(fits.iter().all(|n| n % count == 0), "{name}: {fits:?}");
        }
    }

    /// Test samples of Tables 1 to 5.
    const PRINTED: [u32; 5] = [1881, 1454, 210, 210, 718];
}
