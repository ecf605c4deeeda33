//! Arguments that say how recordings are read, the same for every command.

use std::error::Error;

use clap::Args;
use taxel::data::TableOptions;
use taxel::{Length, Options};

/// What stands where in a file of recordings, and how long samples are.
#[derive(Args, Clone)]
pub struct Reading {
    /// The array that holds the samples, if it is not called `x`.
    #[arg(long, value_name = "NAME")]
    pub x: Option<String>,
    /// The array that holds the labels, if it is not called `y`; of labels.csv or a table the column.
    #[arg(long, value_name = "NAME")]
    pub y: Option<String>,
    /// The array that holds the groups, if it is not called `group`; of labels.csv or a table the column.
    #[arg(long, value_name = "NAME")]
    pub group: Option<String>,
    /// What becomes of recordings of unequal length: resample:300, pad:300[,edge][,crop], crop:300[,centre|,end] or
    /// window:300[,150], in readings.
    #[arg(long, value_name = "RULE")]
    pub length: Option<Length>,
    /// Of a CSV table: long or wide, and the columns whose names do not say what they are, such as
    /// long,recording=grasp,time=stamp,clock=ms,ignore=id (clock: s, ms, us or ns); column=NAME for each
    /// channel where not all numbers are.
    #[arg(long, value_name = "COLUMNS")]
    pub table: Option<TableOptions>,
    /// A topic of ROS 2 bags, or a field of one (/joint_states.effort); several are joined at the times of the first
    /// [default: the one that holds numbers or images].
    #[arg(long = "topic", value_name = "TOPIC")]
    pub topics: Vec<String>,
}

impl Reading {
    /// Keys of a config, as `--set` takes them.
    pub fn sets(&self) -> impl Iterator<Item = String> {
        let text =
            |(key, name): (&str, &Option<String>)| name.as_ref().map(|name| format!("data.{key}={name:?}"));
        let names = [("x", &self.x), ("y", &self.y), ("group", &self.group)].map(text);
        let rule = self.length.map(|rule| format!("data.{}", rule.key().replacen(" = ", "=", 1)));
        let table = self.table.as_ref().map(|table| format!("data.{}", table.key().replacen(" = ", "=", 1)));
        let topics = (!self.topics.is_empty()).then(|| format!("data.topics={:?}", self.topics));
        names.into_iter().chain([rule, table, topics]).flatten()
    }

    /// Options of the reader.
    pub fn options(&self) -> Options {
        let default = Options::default();
        Options {
            x: self.x.clone().unwrap_or(default.x),
            y: self.y.clone().unwrap_or(default.y),
            group: self.group.clone(),
            length: self.length,
            table: self.table.clone().unwrap_or_default(),
            topics: self.topics.clone(),
            ..Options::default()
        }
    }
}

/// What the library calls a key is an option here too. `to` is the length that a model reads.
pub fn with_length_hint(error: impl Into<taxel::Error>, to: Option<usize>) -> Box<dyn Error> {
    let error = error.into();
    let data = match &error {
        taxel::Error::Data(data) => Some(data),
        taxel::Error::Experiment(taxel::experiment::Error::Data(data)) => Some(&**data),
        _ => None,
    };
    match data {
        Some(taxel::data::Error::UnequalLengths { proposed, .. }) => {
            let rule = to.map_or(*proposed, |to| Length::Resample { to });
            format!("{error}, or on the command line --length {rule}").into()
        }
        _ => error.into(),
    }
}
