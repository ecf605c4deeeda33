//! Rows of two runs on the samples that both tested.

use std::error::Error;
use std::path::Path;

use taxel::judge::{Case, Side, SideBySide, SideCosts, side_by_side, speed};
use taxel::learn::NetworkResults;
use taxel::reporting::open;

/// Seconds that a model of each run is timed at most.
const SECONDS: f64 = 1.0;

/// Compares a row of one run with a row of another; names are those of `networks`, or the most accurate ones.
pub fn compared(paths: [&Path; 2], networks: &[String]) -> Result<SideBySide, Box<dyn Error>> {
    if let [_, _, third, ..] = networks {
        return Err(format!("--network {third}: two rows are compared; name one for each run").into());
    }
    let cases = [open(paths[0])?, open(paths[1])?];
    let [first, second] = &cases;
    if first.dataset.digest != second.dataset.digest || first.task() != second.task() {
        let (a, b) = (paths[0].display(), paths[1].display());
        return Err(format!(
            "{b}: its samples or targets are not those of {a}; compare runs on the same data"
        )
        .into());
    }
    let names = [networks.first(), networks.get(1).or(networks.first())];
    let sides = [side(first, paths[0], names[0])?, side(second, paths[1], names[1])?];
    let protocol = (&first.results.protocol, first.results.seed);
    let found = side_by_side(&first.dataset, first.task(), protocol, sides)?;
    found.ok_or_else(|| {
        format!("{} and {} tested no sample in common", paths[0].display(), paths[1].display()).into()
    })
}

/// Returns the row of a run that is named, or the most accurate one.
fn side(case: &Case, path: &Path, name: Option<&String>) -> Result<Side, Box<dyn Error>> {
    let rows: Vec<&NetworkResults> =
        case.results.networks.iter().filter(|row| !row.folds.is_empty()).collect();
    let row = match name {
        Some(name) => rows.iter().find(|row| row.network == *name).copied().ok_or_else(|| {
            let hint = taxel::base::names::hint(name, rows.iter().map(|row| row.network.as_str()));
            format!("--network {name}: {} has no finished row of this name; {hint}", path.display())
        })?,
        None => best(case, &rows).ok_or_else(|| format!("{}: has no finished row", path.display()))?,
    };
    let records: Vec<_> = case.records(&row.network).cloned().collect();
    let model = records.first().and_then(|record| case.model(&record.key).ok());
    let file = records.first().map(|record| case.folder.model_path(&record.key));
    let bytes = file.and_then(|path| std::fs::metadata(path).ok()).map_or(row.costs.bytes, |file| file.len());
    let ms =
        model.and_then(|model| speed(&model, &case.dataset.x, SECONDS).ok()).map(|speed| speed.whole.p50_ms);
    let run = path.file_name().unwrap_or_default().to_string_lossy();
    let costs = SideCosts { parameters: row.costs.parameters, bytes, macs: Some(row.costs.macs), ms };
    Ok(Side { name: format!("{run}: {}", row.network), records, costs })
}

fn best<'r>(case: &Case, rows: &[&'r NetworkResults]) -> Option<&'r NetworkResults> {
    let primary = case.primary();
    let scored = rows.iter().filter_map(|row| Some((*row, row.primary()?)));
    scored.reduce(|best, row| if primary.prefers(row.1, best.1) { row } else { best }).map(|(row, _)| row)
}
