//! `taxel data`: recordings on disk, checked and converted.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};

use crate::CommandResult;
use crate::commands::arguments::option_hints::with_option_hint;
use crate::commands::arguments::output_format::OutputFormat;
use crate::outln;
use crate::terminal::messages::note;

/// Checks recordings on disk, or converts them.
#[derive(Subcommand)]
pub enum Data {
    Check(Check),
    Convert(Convert),
}

/// The arguments that both commands take.
#[derive(Args)]
struct Recordings {
    /// A file or a folder.
    path: PathBuf,
    #[command(flatten)]
    read_options: taxel_data::ReadOptions,
    /// Turns that many consecutive group values, or files of a class folder, into one group.
    #[arg(long, value_name = "N")]
    group_block: Option<u32>,
    /// The array or column that marks the samples of the official test set: 1, 0 for the others.
    #[arg(long, value_name = "NAME")]
    test: Option<String>,
    /// Takes samples with a mark above this number as the test set.
    #[arg(long, value_name = "N", requires = "test", allow_negative_numbers = true)]
    test_above: Option<i64>,
    /// Names of the columns of y [N, k] where they are attributes and not one-hot.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    attributes: Vec<String>,
    /// Size in pixels that image files are shrunk to first.
    #[arg(long, value_name = "HEIGHT,WIDTH", value_parser = size)]
    resize: Option<[usize; 2]>,
}

/// Checks a data set and prints its card: shape, classes, groups, ranges, copies, dead channels.
///
/// The card also says how many samples a few global statistics alone tell apart: where they tell many, the set may be
/// confounded.
///
/// A data set is a .npz, a .h5 or a .mat of MATLAB with x [N, channels, time], [N, rows, columns] or
/// [N, frames, rows, columns], y [N] (or one-hot) and optionally group [N], with labels.json beside it; a CSV or Parquet
/// table, wide (a row per sample, label) or long (recording, time, channels, label[, group]); a folder of CSV
/// (rows = time), NPY, MAT, HDF5, PNG or JPEG files in class/ or class/session/, or with labels.csv (file,label,group); a
/// folder of ROS 2 bags in MCAP, named by class (cup_03.mcap) or sorted like other files; or a set of the UCR and UEA archives. Recordings may differ in length: the card shows how, and --length shows the
/// set under a rule. Ends with 1 if something keeps it from being used.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  taxel data check recordings/ --html card.html\n  taxel data check recordings/ --format json"
)]
pub struct Check {
    #[command(flatten)]
    recordings: Recordings,
    #[command(flatten)]
    format: OutputFormat,
    /// Draws the set on a page as well: recordings of each class, lengths, ranges of channels, copies, channels that are
    /// dead, stuck or clipped, means over the recording order, which of the plainest numbers tells the classes apart.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

/// Converts a data set to one .npz.
///
/// It holds x [N, ...], y, groups and the authors' test marks. Names, unit, rate and everything else that is known of the
/// set are in NAME.classes.json beside it. Every other command reads the two as it reads the original.
///
/// Recordings of unequal length are filled up with NaN, which is read as unequal length again; with --length they
/// are written under that rule.
#[derive(Args)]
#[command(after_help = "Example:  taxel data convert recordings/ --output set.npz")]
pub struct Convert {
    #[command(flatten)]
    recordings: Recordings,
    /// The data set to write, `.npz`; one that is there is replaced.
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
}

/// Reads a height and a width: `40,30`.
fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |side: &str| side.trim().parse().ok().filter(|side| (1..=4096).contains(side));
    match text.split_once(',').map(|(height, width)| (side(height), side(width))) {
        Some((Some(height), Some(width))) => Ok([height, width]),
        _ => Err("expected height and width in pixels, 1 to 4096 each, such as 40,30".into()),
    }
}

impl Recordings {
    fn options(&self) -> taxel_data::ReadOptions {
        taxel_data::ReadOptions {
            group_block: self.group_block,
            test: self.test.clone(),
            test_above: self.test_above,
            resize: self.resize,
            attributes: self.attributes.clone(),
            ..self.read_options.clone()
        }
    }
}

impl Data {
    pub fn run(self) -> CommandResult {
        match self {
            Data::Check(check) => check.run(),
            Data::Convert(convert) => convert.run(),
        }
    }
}

impl Check {
    fn run(self) -> CommandResult {
        let surveyed = taxel_data::survey(&self.recordings.path, &self.recordings.options())
            .map_err(|e| with_option_hint(e, None))?;
        let card = match &self.html {
            None => surveyed.card,
            Some(page) => {
                let survey = taxel_judge::survey(surveyed);
                taxel_judge::survey_page(&survey, page)?;
                survey.card
            }
        };
        if self.format.is_json() {
            outln!("{}", serde_json::to_string_pretty(&card)?);
        } else {
            outln!("{card}");
        }
        if let Some(page) = &self.html {
            note(format!("drawn in {}", page.display()));
        }
        Ok(if card.problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}

impl Convert {
    fn run(self) -> CommandResult {
        let Recordings { path, .. } = &self.recordings;
        let written = taxel_data::convert(path, &self.recordings.options(), &self.output)
            .map_err(|e| with_option_hint(e, None))?;
        let [arrays, names] = written.files.map(|file| file.display().to_string());
        let padded = match written.padded {
            None => String::new(),
            Some([shortest, longest]) => {
                format!(", recordings of {shortest} to {longest} readings filled up with NaN")
            }
        };
        outln!("{arrays}: x {:?}{padded}", written.shape);
        outln!("{names}: class names and what else is known");
        Ok(ExitCode::SUCCESS)
    }
}
