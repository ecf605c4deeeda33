//! `taxel-reproduction`: writes the pages of the study.

// Doc comments on arguments are what --help prints, not Markdown.
#![allow(rustdoc::broken_intra_doc_links, rustdoc::invalid_html_tags)]

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use taxel::IndicatifProgress;
use taxel::judge::{Case, Judgement};
use taxel::reporting::{judgement, open};
use taxel_reproduction::{Claim, Pages, Result, claims, claims_page, claims_report, papers_page};

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
    /// Asks runs about every claim of the papers and writes claims.md.
    ///
    /// What the runs say takes the place of what reference/claims.csv said of them, so that runs may be asked one after
    /// another, on any machine; without a run the page is drawn anew. A run without a judgement is measured first. What
    /// was found out about a claim that does not hold comes from why.toml.
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
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(page) => {
            println!("{}", page.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: Arguments) -> Result<PathBuf> {
    match arguments.command {
        Command::Claims { runs, output: Some(folder) } => claims_report(&asked(&runs)?, &folder),
        Command::Claims { runs, output: None } => claims_page(&Pages::at(&arguments.pages)?, &asked(&runs)?),
        Command::Papers => papers_page(&Pages::at(&arguments.pages)?),
    }
}

/// Asks all runs together: those on the same samples, divided alike, share their networks.
fn asked(runs: &[PathBuf]) -> Result<Vec<Claim>> {
    let mut judged = vec![];
    for path in runs {
        let case = open(path)?;
        let found = judgement(&case, None, &IndicatifProgress::default())?;
        judged.push((case, found));
    }
    let together: Vec<(&Case, &Judgement)> = judged.iter().map(|(case, found)| (case, found)).collect();
    Ok(claims(&together)?)
}
