//! A network as the file that defines it lists it for the zoo: name, source, inputs, and its costs.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::settings::Architecture;

/// One input of a network, and the settings that size its axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InputKeys {
    /// Name of the input, which is that of its encoding.
    pub name: &'static str,
    /// Settings of the axes in order, batch left out; a single one means that the whole sample is flattened into it.
    pub keys: &'static [&'static str],
}

impl InputKeys {
    /// `signal` `[in_channels, length]`.
    pub const SIGNAL: InputKeys = InputKeys { name: "signal", keys: &["in_channels", "length"] };
    /// `signal` flattened to `[1, in_features]`.
    pub const FLAT: InputKeys = InputKeys { name: "signal", keys: &["in_features"] };
    /// `image` `[in_channels, height, width]`.
    pub const IMAGE: InputKeys = InputKeys { name: "image", keys: &["in_channels", "height", "width"] };
    /// `tensor` `[in_channels, height, width, frames]`.
    pub const TENSOR: InputKeys =
        InputKeys { name: "tensor", keys: &["in_channels", "height", "width", "frames"] };
    /// `rocket` `[features]`.
    pub const ROCKET: InputKeys = InputKeys { name: "rocket", keys: &["features"] };
}

/// Counts of a network at its published settings, as its PyTorch twin has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NetworkCounts {
    /// Learned values.
    pub parameters: u64,
    /// Running means and variances of batch norms.
    pub statistics: u64,
    /// Multiply–accumulates of one sample.
    pub macs: u64,
}

/// A network as the zoo lists it. It stands beside the network, in the same file; the family's `list` hands it over.
#[derive(Debug, Clone)]
pub struct Listing<C> {
    /// Name in configs, on the command line and in run folders, and of the graph.
    pub name: &'static str,
    /// Crate that it stands in, `taxel-` left out.
    pub family: &'static str,
    /// Author and year, or paper and place, where it is published.
    pub paper: &'static str,
    /// The published settings.
    pub config: C,
    /// Inputs in order.
    pub inputs: &'static [InputKeys],
    /// Counts at the published settings; tests hold the graph against them.
    pub counts: NetworkCounts,
    /// Sizes at which tests that walk every network may take it, where the published ones take minutes.
    pub quick: &'static [(&'static str, usize)],
}

/// Takes the networks that families list.
pub trait Register {
    /// Takes one.
    fn add<C>(&mut self, network: Listing<C>)
    where
        C: Architecture + Serialize + DeserializeOwned + Send + Sync + 'static;
}
