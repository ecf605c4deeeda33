//! `taxel shrink`: how few sensors, readings, bits and taxels suffice, and how small a network.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueHint};
use taxel::judge::Case;
use taxel::shrink::{Axis, Error, Estimate, Finished, ShrinkOptions, shrink};
use taxel::{Registry, RunFolder};

use crate::CommandResult;
use crate::commands::arguments::output_format::OutputFormat;
use crate::commands::arguments::threads::Threads;
use crate::commands::judging::choice;
use crate::terminal::interrupt::{GRACE, INTERRUPTED, flag};
use crate::terminal::messages::note;
use crate::terminal::progress::progress;
use crate::terminal::tables;
use crate::{out, outln};

/// Finds how little of the sensing and of a network suffices, and writes a smaller model.
///
/// One network of a finished run (or a baseline) is trained again on less and less. --axes says of what:
///
///   sensors     channels of a series, fingers, rows and columns of an array: those go first without which the trained network
///               loses least
///   rate        every 2nd, 4th, 8th, … reading
///   window      the first readings of a recording
///   bits        bits of the converter, over the full scale
///   resolution  squares of taxels as one
///   width       channels of the layers; a narrower network learns from the predictions of the best method, too
///   depth       residual blocks and dense layers, or else plain layers, the last ones first, likewise
///
/// Each training part of the run is divided once more: which sensors go and where the knee is, these inner folds say, by the rule of
/// `taxel choose`: the smallest setting that is not significantly worse than the whole and seems to lose no more than --margin
/// points. The test parts are predicted once for each setting, for the curves; they choose nothing.
///
/// The folder (RUN/shrink unless --output names another) then holds index.html with curves and tables, shrink.json,
/// and, where something may go, shrunk.safetensors, a model that takes whole recordings and leaves out what it does not
/// need, and shrunk.toml, its experiment, for `taxel run`. How long it may take is said first; Ctrl-C keeps what is
/// finished, and --resume goes on.
#[derive(Args)]
#[command(verbatim_doc_comment)]
#[command(after_help = "Examples:  taxel shrink runs/quickstart --quick
           taxel shrink runs/glove --network resnet8-lite-1d --axes sensors,rate,bits
           taxel shrink runs/tekscan22 --axes resolution,bits --margin 1
           taxel predict runs/glove/shrink/shrunk.safetensors glove/")]
pub struct Shrink {
    /// A run folder.
    #[arg(value_hint = ValueHint::DirPath)]
    run: PathBuf,
    /// The network or baseline, by its name in the tables [default: the one that taxel choose names, or else the best].
    #[arg(long, value_name = "NAME")]
    network: Option<String>,
    /// The axes along which it shrinks [default: all].
    #[arg(long, value_delimiter = ',', value_name = "AXIS,..")]
    axes: Vec<Axis>,
    /// A loss of accuracy that would matter, in percentage points; of values in the unit of the error [default: 2; of
    /// values 2 % of the error of always giving the mean].
    #[arg(long, value_name = "POINTS")]
    margin: Option<f64>,
    /// Level of significance of all comparisons together, between 0 and 1.
    #[arg(long, value_name = "ALPHA", default_value_t = 0.05)]
    alpha: f64,
    /// Inner folds of each training part.
    #[arg(long, value_name = "N", default_value_t = 2)]
    inner: usize,
    /// A first look in a short time: two test parts, three settings of each axis, a quarter of the epochs.
    #[arg(long)]
    quick: bool,
    /// Epochs of every training, that of the whole network too [default: the run's].
    #[arg(long, value_name = "N")]
    epochs: Option<usize>,
    /// Folder of the result [default: RUN/shrink].
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Goes on with what was interrupted, to the same bytes: finished trainings are kept, and the page is drawn anew.
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    format: OutputFormat,
    #[command(flatten)]
    threads: Threads,
}

impl Shrink {
    pub fn run(self) -> CommandResult {
        let cancel = flag(GRACE)?;
        let registry = Registry::built_in();
        let folder = RunFolder::open(&self.run)?;
        let (experiment, dataset) = taxel::experiment::open(&folder, &registry)?;
        let case = Case::new(folder, dataset)?;
        let network = match &self.network {
            Some(name) => name.clone(),
            None => chosen(&case)?,
        };
        let options = ShrinkOptions {
            axes: if self.axes.is_empty() { ShrinkOptions::default().axes } else { self.axes.clone() },
            margin: self.margin,
            alpha: self.alpha,
            inner: self.inner,
            quick: self.quick,
            epochs: self.epochs,
            resume: self.resume,
            threads: self.threads.count()?,
        };
        let output = self.output.clone().unwrap_or_else(|| self.run.join("shrink"));
        let progress = progress();
        let say = |estimate: &Estimate| note(format!("{network}: {}", words(estimate)));
        let run = (&case, &experiment, &registry);
        let finished = match shrink(run, &network, &output, &options, &say, &*progress, &cancel) {
            Ok(finished) => finished,
            Err(Error::Stopped { folder }) => {
                note(format!(
                    "stopped; finished trainings are in {folder}: the same command with --resume goes on"
                ));
                return Ok(ExitCode::from(INTERRUPTED));
            }
            Err(error) => return Err(error.into()),
        };
        if self.format.is_json() {
            let Finished { shrunk, speed, page, model } = &finished;
            let all = serde_json::json!({ "shrunk": shrunk, "speed": speed, "page": page, "model": model });
            outln!("{}", serde_json::to_string_pretty(&all)?);
        } else {
            print(&finished);
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Says how much there is to do: `84 trainings at most, about 6 min`.
fn words(estimate: &Estimate) -> String {
    let time = estimate.seconds.map_or(String::new(), |seconds| format!(", about {}", time_words(seconds)));
    format!("{} trainings at most{time} if each takes as long as in the run", estimate.trainings)
}

/// Says an estimated time in the unit of its size: `40 s`, `6 min`, `2.5 h`.
pub fn time_words(seconds: f64) -> String {
    match seconds {
        seconds if seconds < 90.0 => format!("{:.0} s", seconds.max(1.0)),
        seconds if seconds < 5400.0 => format!("{:.0} min", seconds / 60.0),
        seconds => format!("{:.1} h", seconds / 3600.0),
    }
}

/// Returns the network that suffices, or else the best; of models in eight bits the network in floats, which can be
/// trained.
fn chosen(case: &Case) -> Result<String, Box<dyn std::error::Error>> {
    let choice = choice(case)?;
    choice.words.iter().take(1).for_each(note);
    let row = choice.chosen.unwrap_or(choice.best);
    Ok(case.results.in_floats(&row).into())
}

fn print(finished: &Finished) {
    let Finished { shrunk, speed, page, model } = finished;
    outln!("{}: {}, {}, {}", shrunk.run, shrunk.network, shrunk.source, shrunk.protocol);
    shrunk.notes.iter().for_each(|note| outln!("{note}"));
    outln!();
    shrunk.words.iter().for_each(|words| outln!("{words}"));
    shrunk.left_out.iter().for_each(|(axis, reason)| outln!("{axis}: left out: {reason}"));
    outln!();
    if let Some(speed) = speed {
        let (head, longer) = (shrunk.primary.head(), shrunk.primary.show_longer());
        let header = ["model", &head, "values read", "parameters", "MACs", "answer, ms"];
        let times = [speed.whole_p50_ms, speed.small_p50_ms];
        let rows = shrunk.models.iter().zip(times).map(|(model, ms)| {
            vec![
                model.name.clone(),
                longer(model.score),
                model.readings.to_string(),
                model.parameters.to_string(),
                model.macs.to_string(),
                format!("{ms:.4}"),
            ]
        });
        out!("{}", tables::table(&header, &rows.collect::<Vec<_>>(), &[1, 2, 3, 4, 5]));
        outln!();
    }
    if let Some(model) = model {
        outln!("model: {}", model.display());
    }
    outln!("page: {}", page.display());
}
