//! From a run folder to its report: opened with its data, measured once, judged, written down.

use std::path::{Path, PathBuf};

use taxel_judge::{Case, Choice, EarlyOptions, JudgeOptions, Judgement, Report, StressOptions};
use taxel_learn::{Progress, RunFolder};
use taxel_zoo::Registry;

use crate::error::Result;

/// Opens a run folder with its samples, read or simulated again.
///
/// # Errors
/// A folder that holds no run, and data that cannot be loaded any more.
pub fn open(path: &Path) -> Result<Case> {
    let folder = RunFolder::open(path)?;
    let (_, dataset) = taxel_trainer::open(&folder, &Registry::built_in())?;
    Ok(Case::new(folder, dataset)?)
}

/// Reads the judgement in the run folder, if it has the faults that are asked for.
///
/// # Errors
/// A damaged judgement.
pub fn before(case: &Case, stress: Option<&StressOptions>) -> Result<Option<Judgement>> {
    let has = |judgement: &Judgement| match (stress, &judgement.stress) {
        (None, _) => true,
        (Some(wanted), Some(had)) => {
            !wanted.guard || had.networks.iter().any(|network| network.other.is_some())
        }
        (Some(_), None) => false,
    };
    Ok(Judgement::read(case)?.filter(has))
}

/// Reads the judgement that [`before`] finds, or else measures now.
///
/// # Errors
/// As of the two.
pub fn judgement(
    case: &Case,
    stress: Option<StressOptions>,
    progress: &(dyn Progress + Sync),
) -> Result<Judgement> {
    match before(case, stress.as_ref())? {
        Some(judgement) => Ok(judgement),
        None => measure(case, stress, progress),
    }
}

/// Measures the run, and writes the judgement into its folder, which no other process may write to.
///
/// # Errors
/// A folder that another process writes to, models that are missing or damaged.
pub fn measure(
    case: &Case,
    stress: Option<StressOptions>,
    progress: &(dyn Progress + Sync),
) -> Result<Judgement> {
    let _lock = case.folder.lock()?;
    let limits = |stress: &StressOptions| EarlyOptions { samples: stress.samples, threads: stress.threads };
    let options = JudgeOptions {
        early: Some(stress.as_ref().map(limits).unwrap_or_default()),
        stress,
        say: &|what| progress.say(what),
        start: &|steps| progress.start(steps),
        tick: &|| progress.step(1),
        ..JudgeOptions::default()
    };
    let judgement = taxel_judge::judge(case, &options);
    progress.finish();
    let judgement = judgement?;
    judgement.write(&case.folder)?;
    Ok(judgement)
}

/// Writes page, tables and charts of one run into its folder; returns them, and the path of the page.
///
/// # Errors
/// A chart that cannot be drawn, a file that cannot be written.
pub fn write(case: &Case, judgement: &Judgement, choice: &Choice) -> Result<(Report, PathBuf)> {
    let made = taxel_judge::report(judgement, Some(choice))?;
    let _lock = case.folder.lock()?;
    let page = made.write(case.folder.path())?;
    Ok((made, page))
}
