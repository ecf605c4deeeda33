//! `taxel-reproduction`: writes the pages of the study.

// Doc comments on arguments are what --help prints, not Markdown.
#![allow(rustdoc::broken_intra_doc_links, rustdoc::invalid_html_tags)]

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use taxel::IndicatifProgress;
use taxel::judge::{Case, Judgement};
use taxel::reporting::{judgement, open};
use taxel_reproduction::{
    Claim, Pages, Papers, Result, claims, claims_page, claims_report, papers_page, pin, shrink_page,
};

/// Five papers on touch: what they claim, and what of it holds on our runs.
#[derive(Parser)]
#[command(name = "taxel-reproduction", version, arg_required_else_help = true)]
struct Arguments {
    /// Folder of the result pages.
    #[arg(long, default_value = "docs/results", global = true)]
    pages: PathBuf,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Tests every claim of the papers on runs and writes claims.md.
    ///
    /// Results of these runs replace their rows in reference/claims.csv, so runs can be tested one after another, on any
    /// machine. Without a run the page is written again from that file. A run without a judgement is measured first.
    /// Explanations of claims that do not hold come from why.toml.
    Claims {
        /// Run folders.
        runs: Vec<PathBuf>,
        /// Writes a page of these runs alone into this folder instead.
        #[arg(long, short)]
        output: Option<PathBuf>,
    },
    /// Writes papers.md: every table of the papers, published, simulated and real side by side.
    ///
    /// Printed numbers, and which page has a row, come from papers.toml; scores come from those pages.
    Papers,
    /// Writes pins.json: what tests hold a small experiment of each paper to.
    ///
    /// Every config of the folder is run as it was drawn, whose losses follow from scene, encoding, network,
    /// initialisation and protocol alone, and with ten seeds, whose spread tells what one seed may show. A change that
    /// moves the first says so in its commit, and why. It takes about five minutes on two cores.
    Pin {
        /// The folder of the configs.
        #[arg(default_value = "tests/papers")]
        folder: PathBuf,
    },
    /// Prints a result page from what `taxel shrink` wrote: its sentences, its tables, the smaller model's settings.
    Shrink {
        /// The folder that `taxel shrink` wrote.
        folder: PathBuf,
        /// Heading of the page.
        title: String,
        /// How it was made, put above the tables.
        #[arg(long, value_name = "LINES")]
        command: Option<String>,
    },
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(printed) => {
            print!("{printed}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Runs a command and returns what it prints: a page, or the path of one.
fn run(arguments: Arguments) -> Result<String> {
    let path = match arguments.command {
        Command::Claims { runs, output: Some(folder) } => {
            claims_report(&tested(&runs, &Pages::at(&arguments.pages)?)?, &folder)?
        }
        Command::Claims { runs, output: None } => {
            let pages = Pages::at(&arguments.pages)?;
            claims_page(&pages, &tested(&runs, &pages)?)?
        }
        Command::Papers => papers_page(&Pages::at(&arguments.pages)?)?,
        Command::Pin { folder } => pin(&folder)?,
        Command::Shrink { folder, title, command } => {
            return shrink_page(&folder, &title, command.as_deref());
        }
    };
    Ok(format!("{}\n", path.display()))
}

/// Tests all runs together: those on the same samples, divided alike, share their networks.
fn tested(runs: &[PathBuf], pages: &Pages) -> Result<Vec<Claim>> {
    let printed = Papers::of(pages)?;
    let mut judged = vec![];
    for path in runs {
        let case = open(path)?;
        let found = judgement(&case, None, &IndicatifProgress::default())?;
        judged.push((case, found));
    }
    let together: Vec<(&Case, &Judgement)> = judged.iter().map(|(case, found)| (case, found)).collect();
    Ok(claims(&together, &printed)?)
}
