//! `taxel report`: pages, charts and tables from run folders.

use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use clap::{Args, ValueHint};
use serde_json::json;
use taxel::judge::{
    Case, Choice, Criteria, Judgement, LearningCurve, OverviewRun, StressOptions, across, choose,
    curve_words, named_scores, overview,
};
use taxel::reporting::{self, before, open};
use taxel::shrink::learning_curve;
use taxel::{Registry, RunFolder};

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::threads::Threads;
use crate::commands::judging::{now, stress_options};
use crate::outln;
use crate::terminal::messages::note;
use crate::terminal::progress::progress;
use crate::terminal::signals::leave_with;

/// Makes a page of each run: which network suffices, accuracy against speed, where networks break.
///
/// Nothing is trained, unless --learning-curve asks for it. Speeds and faults are measured once and kept in judgement.json; then report.html (one
/// page that needs no network), tables/ (Markdown, CSV) and charts/ (SVG, PNG) are written into the run folder.
/// Several runs also get one page side by side. Leave the machine alone while networks are timed.
#[derive(Args)]
#[command(after_help = "Examples:  taxel report runs/quickstart
           taxel report runs/quickstart --again --max-samples 300
           taxel report runs/glove --learning-curve
           taxel report runs/hardness runs/fsr-glove28 --output reports")]
pub struct Report {
    /// Run folders.
    #[arg(required = true, value_hint = ValueHint::DirPath)]
    run: Vec<PathBuf>,
    /// Folder of the page that sets runs side by side [default: reports, for several runs].
    #[arg(long, short, alias = "out", value_name = "DIR")]
    output: Option<PathBuf>,
    /// Leaves the faults out.
    #[arg(long)]
    no_stress: bool,
    /// Most test samples of each network under faults.
    #[arg(long, alias = "samples", value_name = "N", default_value_t = 1000)]
    max_samples: usize,
    /// Tests each network behind a guard as well, as `taxel stress --compare-guard`.
    #[arg(long, alias = "guard")]
    compare_guard: bool,
    /// Trains the network that is taken on an eighth, a quarter, half and all of inner folds of the training parts as well, to say
    /// what more recordings would bring. `taxel run --plan` says what that costs.
    #[arg(long)]
    learning_curve: bool,
    /// Measures anew, also where judgement.json is there.
    #[arg(long)]
    again: bool,
    #[command(flatten)]
    format: OutputFormat,
    #[command(flatten)]
    threads: Threads,
}

impl Report {
    pub fn run(self) -> CommandResult {
        leave_with("stopped; runs that were measured have a judgement.json: the same command goes on")?;
        let threads = self.threads.count()?;
        let stress = (!self.no_stress).then(|| StressOptions {
            samples: self.max_samples.max(1),
            guard: self.compare_guard,
            ..stress_options(threads)
        });
        let mut judged = vec![];
        for run in &self.run {
            let case = open(run)?;
            let judgement = self.judgement(&case, stress.clone())?;
            let judgement =
                if self.learning_curve { with_curve(&case, judgement, run, threads)? } else { judgement };
            judged.push((case, judgement));
        }
        let together: Vec<(&Case, &Judgement)> =
            judged.iter().map(|(case, judgement)| (case, judgement)).collect();
        let mut entries = vec![];
        for &(case, judgement) in &together {
            let choice = choose(case, judgement, &Criteria::default())?;
            let page = self.one(case, judgement, &choice)?;
            entries.push((page, judgement, choice));
        }
        if entries.len() > 1 || self.output.is_some() {
            let folder = self.output.clone().unwrap_or_else(|| "reports".into());
            std::fs::create_dir_all(&folder)
                .map_err(|e| format!("{}: cannot be made: {e}", folder.display()))?;
            let judgements: Vec<&Judgement> = judged.iter().map(|(_, judgement)| judgement).collect();
            let ranked = across(&judgements, Criteria::default().alpha)?;
            let mut linked = vec![];
            for (page, judgement, choice) in entries {
                let page = link(&folder, &page)?;
                linked.push(OverviewRun { page, judgement: judgement.clone(), choice: Some(choice) });
            }
            let page = overview(&linked, ranked.as_ref(), &folder)?;
            if self.format.is_json() {
                outln!("{}", named_scores(&json!({ "overview": page, "across": ranked }))?);
            } else {
                outln!("side by side: {}", page.display());
            }
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Writes the report of one run and prints where it is.
    fn one(
        &self,
        case: &Case,
        judgement: &Judgement,
        choice: &Choice,
    ) -> Result<PathBuf, Box<dyn std::error::Error>> {
        let (made, page) = reporting::write(case, judgement, choice)?;
        let results = &judgement.results;
        if self.format.is_json() {
            let chance = if judgement.primary().is_percent() { "chance_percent" } else { "chance" };
            let object = json!({
                "name": results.name, "source": results.source, "kind": judgement.kind(), "page": page,
                (chance): judgement.chance, "chosen": choice.chosen,
                "networks": made.summary.json, "learning_curve": judgement.learning_curve,
            });
            outln!("{object}");
        } else {
            outln!(
                "{}: {} ({} samples), {}\n",
                results.name,
                results.source,
                results.samples,
                judgement.protocol
            );
            outln!("{}", made.summary.grid.clone().ruled());
            choice.words.iter().for_each(|line| outln!("{line}"));
            for line in
                judgement.learning_curve.iter().flat_map(|curve| curve_words(curve, &judgement.primary()))
            {
                outln!("{line}");
            }
            outln!("report: {}\n", page.display());
        }
        Ok(page)
    }

    /// Reads what was measured before, or measures now.
    fn judgement(
        &self,
        case: &Case,
        stress: Option<StressOptions>,
    ) -> Result<Judgement, Box<dyn std::error::Error>> {
        let before = if self.again { None } else { before(case, stress.as_ref())? };
        if let Some(judgement) = before {
            let file = case.folder.file("judgement.json");
            note(format!("{}: measured before; --again measures anew", file.display()));
            return Ok(judgement);
        }
        Ok(now(case, stress)?)
    }
}

/// Returns the judgement with the learning curve of the network that is taken, and writes it into the run folder. A curve of that
/// network that is there already is kept.
fn with_curve(
    case: &Case,
    judgement: Judgement,
    run: &Path,
    threads: usize,
) -> Result<Judgement, Box<dyn std::error::Error>> {
    let choice = choose(case, &judgement, &Criteria::default())?;
    let row = choice.chosen.unwrap_or(choice.best);
    let network = case.results.in_floats(&row).to_string();
    let is_same = |curve: &LearningCurve| curve.network == network && curve.whole.is_some();
    if judgement.learning_curve.as_ref().is_some_and(is_same) {
        return Ok(judgement);
    }
    let registry = Registry::built_in();
    let (experiment, _) = taxel::experiment::open(&RunFolder::open(run)?, &registry)?;
    let progress = progress();
    let never = AtomicBool::new(false);
    let curve = learning_curve((case, &experiment, &registry), &network, threads, &*progress, &never)?;
    let judgement = Judgement { learning_curve: Some(curve), ..judgement };
    let _lock = case.folder.lock()?;
    judgement.write(&case.folder)?;
    Ok(judgement)
}

/// Returns the link from `folder` to `page`: relative, so that both can be moved together.
fn link(folder: &Path, page: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let full =
        |path: &Path| path.canonicalize().map_err(|e| format!("{}: cannot be read: {e}", path.display()));
    let (from, to) = (full(folder)?, full(page)?);
    let common = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(common).map(|_| "..".to_string());
    let down = to.components().skip(common).map(|part| match part {
        Component::Normal(name) => escaped(&name.to_string_lossy()),
        other => other.as_os_str().to_string_lossy().into_owned(),
    });
    Ok(up.chain(down).collect::<Vec<_>>().join("/"))
}

/// Replaces what a URL may not hold by %XX.
fn escaped(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}
