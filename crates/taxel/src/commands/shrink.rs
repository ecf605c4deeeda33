//! `taxel shrink`: how few sensors, readings, bits and taxels suffice, and how small a network.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use taxel::IndicatifProgress;
use taxel::judge::{Case, Criteria, choose};
use taxel::shrink::{Axis, Error, Estimate, Finished, Options, shrink};
use taxel::{Registry, RunFolder};

use crate::commands::interrupt::{INTERRUPTED, flag};
use crate::commands::judging::judgement;
use crate::{Outcome, text};

/// Finds out how little of the sensing and of a network suffices, and writes a smaller model that reads no more.
///
/// One network of a finished run (or a baseline) is trained again on less and less. --axes says of what:
///
///   sensors     channels of a series, fingers, rows and columns of an array: those go first without which the trained network
///               loses least
///   rate        every 2nd, 4th, 8th, … reading
///   window      the first readings of a recording
///   bits        bits of the converter, over the full scale
///   resolution  squares of taxels as one
///   width       channels of the layers; a narrower network learns from the best method's answers, too
///   depth       residual blocks and dense layers, or else plain layers, the last ones first, likewise
///
/// Each training part of the run is divided once more: which sensors go and where the knee is, these inner folds say, by the rule of
/// `taxel choose`: the smallest setting that is not significantly worse than the whole and seems to lose no more than --margin
/// points. The test parts are asked once for each setting, for the curves; they choose nothing.
///
/// The folder (RUN/shrink unless --output names another) then holds index.html with curves and tables, shrink.json,
/// and, where something may go, shrunk.safetensors, a model that takes whole recordings and leaves aside what it does not
/// read, and shrunk.toml, its experiment, for `taxel run`. How long it may take is said first; Ctrl-C keeps what is
/// finished, and --resume goes on.
#[derive(Args)]
#[command(verbatim_doc_comment)]
#[command(after_help = "Examples:  taxel shrink runs/quickstart --quick
           taxel shrink runs/glove --network resnet8-lite-1d --axes sensors,rate,bits
           taxel shrink runs/tekscan22 --axes resolution,bits --margin 1
           taxel predict runs/glove/shrink/shrunk.safetensors glove/")]
pub struct Shrink {
    /// A run folder.
    run: PathBuf,
    /// The network or baseline [default: the one that taxel choose names, or else the best].
    #[arg(long)]
    network: Option<String>,
    /// What may become less [default: all of it].
    #[arg(long, value_delimiter = ',', value_name = "AXIS,..")]
    axes: Vec<Axis>,
    /// A loss of accuracy that would matter, in percentage points; of values in the unit of the error [default: 2; of
    /// values 2 % of the error of always giving the mean].
    #[arg(long, value_name = "POINTS")]
    margin: Option<f64>,
    /// Level of significance over a curve.
    #[arg(long, default_value_t = 0.05)]
    alpha: f64,
    /// Inner folds of each training part.
    #[arg(long, value_name = "N", default_value_t = 2)]
    inner: usize,
    /// A first look: two test parts, three settings of each axis, a quarter of the epochs.
    #[arg(long)]
    quick: bool,
    /// Epochs of every training, the whole's too, in place of the run's.
    #[arg(long, value_name = "N")]
    epochs: Option<usize>,
    /// The folder that is written [default: RUN/shrink].
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Goes on in a folder with finished trainings, or draws its page anew.
    #[arg(long)]
    resume: bool,
    /// Prints everything as one JSON object.
    #[arg(long)]
    json: bool,
    /// Caps the threads [default: all cores]; results do not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

impl Shrink {
    pub fn run(self) -> Outcome {
        let cancel = flag()?;
        let registry = Registry::built_in();
        let folder = RunFolder::open(&self.run)?;
        let (experiment, dataset) = taxel::experiment::open(&folder, &registry)?;
        let case = Case::new(folder, dataset)?;
        let network = match &self.network {
            Some(name) => name.clone(),
            None => chosen(&case)?,
        };
        let own = Options::default();
        let options = Options {
            axes: if self.axes.is_empty() { own.axes } else { self.axes.clone() },
            margin: self.margin,
            alpha: self.alpha,
            inner: self.inner,
            quick: self.quick,
            epochs: self.epochs,
            resume: self.resume,
            threads: super::threads(self.threads),
        };
        let out = self.output.clone().unwrap_or_else(|| self.run.join("shrink"));
        let progress = IndicatifProgress::default();
        let say = |estimate: &Estimate| eprintln!("{network}: {}", words(estimate));
        let run = (&case, &experiment, &registry);
        let finished = match shrink(run, &network, &out, &options, &say, &progress, &cancel) {
            Ok(finished) => finished,
            Err(Error::Stopped { folder }) => {
                eprintln!(
                    "stopped; finished trainings are in {folder}: the same command with --resume goes on"
                );
                return Ok(ExitCode::from(INTERRUPTED));
            }
            Err(error) => return Err(error.into()),
        };
        match self.json {
            true => {
                let Finished { shrunk, speed, page, model } = &finished;
                let all =
                    serde_json::json!({ "shrunk": shrunk, "speed": speed, "page": page, "model": model });
                println!("{}", serde_json::to_string_pretty(&all)?);
            }
            false => print(&finished),
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// `84 trainings at most, about 6 min`.
fn words(estimate: &Estimate) -> String {
    let time = match estimate.seconds {
        None => String::new(),
        Some(seconds) if seconds < 90.0 => format!(", about {:.0} s", seconds.max(1.0)),
        Some(seconds) if seconds < 5400.0 => format!(", about {:.0} min", seconds / 60.0),
        Some(seconds) => format!(", about {:.1} h", seconds / 3600.0),
    };
    format!("{} trainings at most{time} if each takes as long as in the run", estimate.trainings)
}

/// The network that suffices, or else the best; of models in eight bits the network in floats, which can be trained.
fn chosen(case: &Case) -> Result<String, Box<dyn std::error::Error>> {
    let judgement = judgement(case, None)?;
    let choice = choose(case, &judgement, &Criteria::default())?;
    choice.words.iter().take(1).for_each(|line| eprintln!("{line}"));
    let row = choice.chosen.unwrap_or(choice.best);
    Ok(case.results.in_floats(&row).into())
}

fn print(finished: &Finished) {
    let Finished { shrunk, speed, page, model } = finished;
    println!("{}: {}, {}, {}", shrunk.run, shrunk.network, shrunk.source, shrunk.protocol);
    shrunk.notes.iter().for_each(|note| println!("{note}"));
    println!();
    shrunk.words.iter().for_each(|words| println!("{words}"));
    shrunk.left_out.iter().for_each(|(axis, reason)| println!("{axis}: left out: {reason}"));
    println!();
    if let Some(speed) = speed {
        let (head, longer) = (shrunk.primary.head(), shrunk.primary.show_longer());
        let header = ["model", &head, "values read", "parameters", "MACs", "answer, ms"];
        let times = [speed.whole_p50_ms, speed.small_p50_ms];
        let rows = shrunk.models.iter().zip(times).map(|(own, ms)| {
            vec![
                own.name.clone(),
                longer(own.score),
                own.readings.to_string(),
                own.parameters.to_string(),
                own.macs.to_string(),
                format!("{ms:.4}"),
            ]
        });
        print!("{}", text::table(&header, &rows.collect::<Vec<_>>(), &[1, 2, 3, 4, 5]));
        println!();
    }
    if let Some(model) = model {
        println!("model: {}", model.display());
    }
    println!("page: {}", page.display());
}
