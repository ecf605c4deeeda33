//! `taxel data`: a user's own recordings.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Subcommand};

use crate::Outcome;
use crate::commands::reading::Reading;

/// Looks at recordings on disk.
#[derive(Subcommand)]
pub enum Data {
    Check(Check),
}

/// Reads a data set and prints its card: shape, classes, groups, ranges, duplicates, dead channels, and how many
/// samples a few global statistics alone tell apart: where they tell many, the set may be confounded.
///
/// A data set is a .npz or a .mat of MATLAB 5 to 7 with x [N, channels, time], [N, rows, columns] or
/// [N, frames, rows, columns], y [N] (or one-hot) and optionally group [N], with labels.json beside it; a folder
/// of CSV (rows = time), NPY, MAT, PNG or JPEG files in class/ or class/session/, or with labels.csv
/// (file,label,group); or a set of the UCR and UEA archives. Recordings may differ in length: the card shows how,
/// and --length shows the set under a rule. Ends with 1 if something keeps it from being used.
#[derive(Args)]
#[command(after_help = "Example:  taxel data check recordings/ --json")]
pub struct Check {
    /// A file or a folder.
    path: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Turns that many consecutive group values, or files of a class folder, into one group.
    #[arg(long)]
    group_block: Option<u32>,
    /// Names of the columns of y [N, k] where they are attributes and not one-hot.
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',')]
    attributes: Vec<String>,
    /// Size in pixels that image files are shrunk to first.
    #[arg(long, value_name = "HEIGHT,WIDTH", value_parser = size)]
    resize: Option<[usize; 2]>,
    /// JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// `40,30`.
fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |side: &str| side.trim().parse().ok().filter(|side| (1..=4096).contains(side));
    match text.split_once(',').map(|(height, width)| (side(height), side(width))) {
        Some((Some(height), Some(width))) => Ok([height, width]),
        _ => Err("expected height and width in pixels, 1 to 4096 each, such as 40,30".into()),
    }
}

impl Data {
    pub fn run(self) -> Outcome {
        let Data::Check(check) = self;
        let options = taxel_data::Options {
            group_block: check.group_block,
            resize: check.resize,
            attributes: check.attributes,
            ..check.reading.options()
        };
        let card = taxel_data::check_with(&check.path, &options)?;
        if check.json {
            println!("{}", serde_json::to_string_pretty(&card)?);
        } else {
            println!("{card}");
        }
        Ok(if card.problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}
