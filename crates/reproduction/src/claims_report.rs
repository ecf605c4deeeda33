//! The claims tested on some runs, as a page with tables beside it.

use std::path::{Path, PathBuf};

use maud::html;
use taxel::data::SourceKind;
use taxel::report::files::write_page;
use taxel::report::html::table;
use taxel::report::numbers::{digits, in_brackets};
use taxel::report::table::{Cell, Column, Table};

use crate::claims::{Claim, Verdict};
use crate::error::Result;
use crate::kept::kind;

/// Writes `index.html` below `folder`, with its tables as files. Returns the path of the page.
///
/// # Errors
/// A file that cannot be written.
pub fn claims_report(claims: &[Claim], folder: &Path) -> Result<PathBuf> {
    let tables: Vec<Table> = tested(claims).into_iter().chain([all(claims)]).collect();
    let body = html! {
        header {
            p.kicker { "taxel reproduction" }
            h1 { "Claims of the papers" }
            p { "Only claims that some run here can test are set side by side; the second table has all." }
        }
        main id="main" { @for shown in &tables { section { (table(shown)) } } }
    };
    Ok(write_page(folder, ("Claims of the papers", &body), &tables, [])?)
}

/// Returns every claim of every run, with effects.
fn all(claims: &[Claim]) -> Table {
    let columns = vec![
        Column::text("paper", "paper", |c: &Claim| Cell::text(&c.paper)),
        Column::text("printed in", "place", |c: &Claim| Cell::text(&c.place)),
        Column::text("claim", "claim", |c: &Claim| Cell::text(&c.says)),
        Column::text("run", "run", |c: &Claim| Cell::text(&c.run)),
        Column::text("on", "source", |c: &Claim| Cell::text(c.source.to_string())),
        Column::text("readings", "kind", |c: &Claim| Cell::text(kind(c.source.kind))),
        Column::text("outcome", "outcome", |c: &Claim| Cell::text(c.outcome().words())),
        Column::text("effect", "effect", |c: &Claim| Cell::text(c.effect())),
        Column::number("size [95 % interval]", &["size", "size_low", "size_high"], |c: &Claim| {
            let weakest = c.weakest();
            let interval = weakest.and_then(|contrast| contrast.interval);
            Cell::number(weakest.map(|contrast| contrast.size), digits)
                .interval(interval, in_brackets(digits))
        }),
    ];
    Table::new("claims", "What the papers claim, and what of it holds here".into(), columns, claims)
}

/// Returns the claims that some run can test, and what each run says.
fn tested(claims: &[Claim]) -> Option<Table> {
    let mut runs: Vec<(&str, SourceKind)> = vec![];
    let mut rows: Vec<Vec<&Claim>> = vec![];
    for claim in claims {
        let run = (claim.run.as_str(), claim.source.kind);
        if !runs.contains(&run) {
            runs.push(run);
        }
        let same = |row: &&mut Vec<&Claim>| {
            (&row[0].paper, &row[0].place, &row[0].says) == (&claim.paper, &claim.place, &claim.says)
        };
        match rows.iter_mut().find(same) {
            Some(row) => row.push(claim),
            None => rows.push(vec![claim]),
        }
    }
    rows.retain(|row| row.iter().any(|claim| claim.outcome() != Verdict::CannotBeTested));
    if rows.is_empty() {
        return None;
    }
    let mut columns: Vec<Column<Vec<&Claim>>> = vec![
        Column::text("claim", "claim", |row: &Vec<&Claim>| Cell::text(&row[0].says)),
        Column::text("paper", "paper", |row: &Vec<&Claim>| Cell::text(&row[0].paper)),
        Column::text("printed in", "place", |row: &Vec<&Claim>| Cell::text(&row[0].place)),
    ];
    for (run, of) in runs {
        let name = run.to_string();
        columns.push(Column::text(&format!("{run} ({})", kind(of)), run, move |row: &Vec<&Claim>| {
            let found = row.iter().find(|claim| claim.run == name);
            let tested = found.filter(|claim| claim.outcome() != Verdict::CannotBeTested);
            Cell::text(tested.map_or("–", |claim| claim.outcome().words()))
        }));
    }
    Some(Table::new("claims-by-run", "What the papers claim, run by run".into(), columns, &rows))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::claims::Contrast;
    use taxel::Source;

    /// A text that would be a tag, an end of an attribute, a column and a formula.
    const HOSTILE: &str = "<b>&\"x|$a_1$";

    fn contrast(interval: [f64; 2]) -> Contrast {
        Contrast {
            effect: "accuracy, points".into(),
            size: (interval[0] + interval[1]) / 2.0,
            interval: Some(interval),
            refuting: Some(interval),
            error: None,
            p: None,
            margin: None,
        }
    }

    fn claim() -> Claim {
        Claim {
            paper: "000".into(),
            place: "Table 5".into(),
            says: HOSTILE.into(),
            run: "run".into(),
            source: Source::simulated("fingertip"),
            fresh: false,
            least: 0.0,
            contrasts: vec![contrast([-3.0, -0.5])],
            lacks: None,
        }
    }

    #[test]
    fn several_runs_share_a_page_of_claims() {
        let untested = Claim { says: "nobody can test this".into(), contrasts: vec![], ..claim() };
        let elsewhere = Claim { run: "other".into(), contrasts: vec![contrast([0.5, 3.0])], ..claim() };
        let folder = tempfile::tempdir().unwrap();
        let page = claims_report(&[claim(), elsewhere, untested], folder.path()).unwrap();
        let page = std::fs::read_to_string(page).unwrap();
        assert!(page.contains("does not hold") && !page.contains(HOSTILE), "{page}");
        let rows = |name: &str| {
            let mut reader = csv::Reader::from_path(folder.path().join("tables").join(name)).unwrap();
            reader.records().map(|row| row.unwrap()).collect::<Vec<_>>()
        };
        let by_run = rows("claims-by-run.csv");
        assert_eq!(by_run.len(), 1);
        assert_eq!(
            by_run[0].iter().collect::<Vec<_>>(),
            [HOSTILE, "000", "Table 5", "does not hold", "holds"]
        );
        let all = rows("claims.csv");
        assert_eq!((all[0].get(6), all[0].get(10)), (Some("does not hold"), Some("-0.5")));
        assert_eq!(all[2].get(2), Some("nobody can test this"), "the file holds every claim");
    }
}
