//! `taxel report`: pages, charts and tables from run folders.

use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use serde_json::json;
use taxel::judge::{
    Case, Choice, Criteria, Entry, Judgement, StressOptions, across, choose, named_scores, overview,
};
use taxel::reporting::{self, before, open};

use crate::Outcome;
use crate::commands::judging::{now, stress_options};
use crate::commands::signals::leave_with;

/// Makes the report of each run: which network suffices, accuracy against speed, where networks break.
///
/// Nothing is trained. Speeds and faults are measured once and kept in judgement.json; then report.html (one
/// page that needs no network), tables/ (Markdown, CSV) and charts/ (SVG, PNG) are written into the run folder.
/// Several runs also get one page side by side. Leave the machine alone while networks are timed.
#[derive(Args)]
#[command(after_help = "Examples:  taxel report runs/quickstart
           taxel report runs/quickstart --again --samples 300
           taxel report runs/hardness runs/fsr-glove28 --out reports")]
pub struct Report {
    /// Run folders.
    #[arg(required = true)]
    run: Vec<PathBuf>,
    /// Folder of the page that sets runs side by side [default: reports, for several runs].
    #[arg(long)]
    out: Option<PathBuf>,
    /// Leaves the faults out.
    #[arg(long)]
    no_stress: bool,
    /// At most so many test samples of each network under faults.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    samples: usize,
    /// Asks each network with a guard before it too, as `taxel stress --guard`.
    #[arg(long)]
    guard: bool,
    /// Measures anew, also where judgement.json is there.
    #[arg(long)]
    again: bool,
    /// Prints one JSON object per run instead of tables.
    #[arg(long)]
    json: bool,
    /// Caps the threads of the fault test [default: all cores]; speed is always measured on one.
    #[arg(long)]
    threads: Option<usize>,
}

impl Report {
    pub fn run(self) -> Outcome {
        leave_with("stopped; runs that were measured have a judgement.json: the same command goes on")?;
        let stress = (!self.no_stress).then(|| StressOptions {
            samples: self.samples.max(1),
            guard: self.guard,
            ..stress_options(self.threads)
        });
        let mut judged = vec![];
        for run in &self.run {
            let case = open(run)?;
            let judgement = self.judgement(&case, stress.clone())?;
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
        if entries.len() > 1 || self.out.is_some() {
            let folder = self.out.clone().unwrap_or_else(|| "reports".into());
            std::fs::create_dir_all(&folder)
                .map_err(|e| format!("{}: cannot be made: {e}", folder.display()))?;
            let judgements: Vec<&Judgement> = judged.iter().map(|(_, judgement)| judgement).collect();
            let ranked = across(&judgements, Criteria::default().alpha)?;
            let mut linked = vec![];
            for (page, judgement, choice) in entries {
                let page = link(&folder, &page)?;
                linked.push(Entry { page, judgement: judgement.clone(), choice: Some(choice) });
            }
            let page = overview(&linked, ranked.as_ref(), &folder)?;
            match self.json {
                true => println!("{}", named_scores(&json!({ "overview": page, "across": ranked }))?),
                false => println!("side by side: {}", page.display()),
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
        if self.json {
            let chance = if judgement.primary().is_percent() { "chance_percent" } else { "chance" };
            let object = json!({
                "name": results.name, "source": results.source, "kind": judgement.kind(), "page": page,
                (chance): judgement.chance, "chosen": choice.chosen,
                "networks": made.summary.json,
            });
            println!("{object}");
        } else {
            println!(
                "{}: {} ({} samples), {}\n",
                results.name, results.source, results.samples, judgement.protocol
            );
            println!("{}", made.summary.grid.clone().ruled());
            choice.words.iter().for_each(|line| println!("{line}"));
            println!("report: {}\n", page.display());
        }
        Ok(page)
    }

    /// What is in the run folder already, or is measured now.
    fn judgement(
        &self,
        case: &Case,
        stress: Option<StressOptions>,
    ) -> Result<Judgement, Box<dyn std::error::Error>> {
        let before = if self.again { None } else { before(case, stress.as_ref())? };
        if let Some(judgement) = before {
            eprintln!(
                "{}: measured before; --again measures anew",
                case.folder.file("judgement.json").display()
            );
            return Ok(judgement);
        }
        Ok(now(case, stress)?)
    }
}

/// The way from `folder` to `page` as a link: relative, so that both can be moved together.
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

/// With what a URL may not hold as %XX.
fn escaped(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    name.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}
