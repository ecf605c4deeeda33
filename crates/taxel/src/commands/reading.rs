//! Arguments that say how recordings are read, the same for every command.

use std::error::Error;

use clap::Args;
use taxel::data::{Limits, TableOptions};
use taxel::{Length, ReadOptions};

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
    /// channel where not all numbers are; shape=16x16 where a row is an image of 16 × 16 taxels, or a frame.
    #[arg(long, value_name = "COLUMNS")]
    pub table: Option<TableOptions>,
    /// A topic of ROS 2 bags, or a field of one (/joint_states.effort); several are joined at the times of the first
    /// [default: the one that holds numbers or images].
    #[arg(long = "topic", value_name = "TOPIC")]
    pub topics: Vec<String>,
    /// Most values in all samples together, as the limits of a config: a file that says more is refused before memory is
    /// taken for it [default: 268435456, which are 1 GiB].
    #[arg(long, value_name = "COUNT")]
    pub max_values: Option<u64>,
}

impl Reading {
    /// Keys of a config, as `--set` takes them.
    #[cfg(feature = "lab")]
    pub fn sets(&self) -> impl Iterator<Item = String> {
        let text =
            |(key, name): (&str, &Option<String>)| name.as_ref().map(|name| format!("data.{key}={name:?}"));
        let names = [("x", &self.x), ("y", &self.y), ("group", &self.group)].map(text);
        let rule = self.length.map(|rule| format!("data.{}", rule.key().replacen(" = ", "=", 1)));
        let table = self.table.as_ref().map(|table| format!("data.{}", table.key().replacen(" = ", "=", 1)));
        let topics = (!self.topics.is_empty()).then(|| format!("data.topics={:?}", self.topics));
        let most = self.max_values.map(|most| format!("data.limits.max-values={most}"));
        names.into_iter().chain([rule, table, topics, most]).flatten()
    }

    /// ReadOptions of the reader.
    pub fn options(&self) -> ReadOptions {
        let default = ReadOptions::default();
        ReadOptions {
            x: self.x.clone().unwrap_or(default.x),
            y: self.y.clone().unwrap_or(default.y),
            group: self.group.clone(),
            length: self.length,
            table: self.table.clone().unwrap_or_default(),
            topics: self.topics.clone(),
            limits: Limits {
                max_values: self.max_values.unwrap_or(default.limits.max_values),
                ..default.limits
            },
            ..ReadOptions::default()
        }
    }
}

/// What the library calls a key is an option here too. `to` is the length that a model reads.
pub fn with_option_hint(error: impl Into<taxel::Error>, to: Option<usize>) -> Box<dyn Error> {
    let error = error.into();
    let data = match &error {
        taxel::Error::Data(data) => Some(data),
        #[cfg(feature = "lab")]
        taxel::Error::Experiment(taxel::experiment::Error::Data(data)) => Some(&**data),
        _ => None,
    };
    match data {
        Some(taxel::data::Error::UnequalLengths { proposed, .. }) => {
            let rule = to.map_or(*proposed, |to| Length::Resample { to });
            format!("{error}, or on the command line --length {rule}").into()
        }
        Some(taxel::data::Error::TooLarge { shape, limit, .. }) => {
            let values = shape.iter().fold(1u64, |product, axis| product.saturating_mul(*axis));
            format!("{error}, or on the command line --max-values {}", values.max(limit + 1)).into()
        }
        _ => error.into(),
    }
}
