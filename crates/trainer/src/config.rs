//! What an experiment is: the tables of its TOML file.
//!
//! Defaults are the recipe of paper 000 (Hybrid-CNN hardness recognition), Table 1 and section 5.1.
//! Ranges are checked in [`Config::check`]; files, `[quick]` and `--set` are read by
//! [`crate::Experiment`].

mod baseline;
mod check;
pub(crate) mod lines;
mod network;
mod protocol;
mod range;
mod train;

pub use baseline::Baseline;
pub use check::Problem;
pub use network::{Network, Published};
pub use protocol::{Protocol, ProtocolKind, Split};
pub use range::Range;
pub use train::{
    BatchNorm, By, Choose, ClassWeights, EarlyStopping, Optimizer, OptimizerName, OptimizerOverride,
    Schedule, ScheduleKind, Train, TrainOverride,
};

use serde::{Deserialize, Serialize};
use taxel_data::{Drop, Limits};
use taxel_encodings::{Colormap, Constant};

/// One experiment: data, encoding, protocol, training, networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Name of the run folder: letters, digits, `.`, `_`, `-`.
    pub name: String,
    /// One line for tables and reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// What the author expects to come out, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expect: Option<String>,
    /// Seed of every random choice, 0 to 2^63 - 1. Default 0.
    #[serde(default)]
    pub seed: u64,
    /// Where the samples come from.
    pub data: Data,
    /// What the networks read.
    #[serde(default)]
    pub encoding: Encoding,
    /// How samples are divided into training and test.
    #[serde(default)]
    pub protocol: Protocol,
    /// How every network is trained.
    #[serde(default)]
    pub train: Train,
    /// Settings of the training that each fold chooses by itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choose: Option<Choose>,
    /// The networks, in the order of the table.
    pub networks: Vec<Network>,
    /// Methods that cost almost nothing and stand in the table too. Default all; `[]` for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baselines: Option<Vec<Baseline>>,
    /// Values that replace the ones above under `--quick`; empty in a resolved config.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub quick: toml::Table,
}

/// The `[data]` table: a simulated scene, or recordings on disk with the options of their loader.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Data {
    /// A scene of `taxel simulate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Recordings to simulate, 1 to 10 million.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<usize>,
    /// Settings of the scene, as `taxel simulate --set` takes them.
    #[serde(default, skip_serializing_if = "toml::Table::is_empty")]
    pub set: toml::Table,
    /// Effects of the scene to leave out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// A `.npz` or folder of recordings; `${NAME}` is replaced by the environment variable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// The largest possible reading, for `scale = "full-scale"`; a scene knows its own, and so does
    /// a data set with `full_scale` in its labels.json.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub full_scale: Option<f64>,
    /// Name of the array of samples. Default `x`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<String>,
    /// Name of the array of labels. Default `y`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<String>,
    /// Name of the array of groups. Default `group` where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Turns that many consecutive group values into one group.
    #[serde(default, alias = "group-block", skip_serializing_if = "Option::is_none")]
    pub group_block: Option<u32>,
    /// Indices to keep along axis 1 of the samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<usize>>,
    /// Rows to leave out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drop: Vec<Drop>,
    /// Refuse exact copies with different labels that are not dropped. Default false.
    #[serde(default, alias = "deny-contradictory", skip_serializing_if = "Option::is_none")]
    pub deny_contradictory: Option<bool>,
    /// Name of the array that marks the samples to test on (not 0) for `protocol.kind = "official"`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test: Option<String>,
    /// Samples with more than this in the `test` array are tested, in place of those that are not 0.
    #[serde(default, alias = "test-above", skip_serializing_if = "Option::is_none")]
    pub test_above: Option<i64>,
    /// For labels `[N, k]`: the column that becomes the class. Default 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attribute: Option<usize>,
    /// Learns every column of labels `[N, k]`, under these names: paper 004's two levels.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<String>,
    /// Keeps the samples of these classes only, in this order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub classes: Option<Vec<String>>,
    /// Groups of classes that look alike, by name: the results tell mistakes within from those between.
    #[serde(default, skip_serializing_if = "std::collections::BTreeMap::is_empty")]
    pub look_alikes: std::collections::BTreeMap<String, Vec<String>>,
    /// For image files: `[height, width]` in pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resize: Option<[usize; 2]>,
    /// Ceilings on file sizes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<Limits>,
}

/// The `[encoding]` table: how samples become the inputs of networks.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoding {
    /// Readings at the start of [N, C, T] whose mean is taken off each channel, for networks and baselines
    /// alike. Default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<usize>,
    /// `signal` [N, C, T], for 1D networks and the flattened MLP.
    #[serde(default)]
    pub signal: Signal,
    /// `image` [N, C, H, W], for 2D networks; no image without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<Image>,
    /// `tensor` [N, 1, H, W, T], for 3D networks; no tensor without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tensor: Option<Tensor>,
}

/// How readings are scaled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// `(v - mean) / sd` per channel, fitted on the training part of each fold.
    #[default]
    ZScore,
    /// `v / full_scale`.
    FullScale,
    /// `(v / full_scale - mean) / sd` of ImageNet's red, green and blue, as torchvision's networks were
    /// trained.
    Imagenet,
    /// As they are.
    Raw,
}

/// `encoding.signal`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signal {
    /// Scale of the readings. Default `z-score`; the paper names none.
    #[serde(default)]
    pub scale: Scale,
}

/// What an image is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ImageKind {
    /// Gramian angular difference field of the raw readings, coloured. The paper's choice.
    Gadf,
    /// Gramian angular summation field of the raw readings, coloured.
    Gasf,
    /// The samples are images: [N, H, W] becomes [N, 1, H, W], [N, C, H, W] stays.
    Raw,
    /// One frame of each squeeze [N, T, H, W], for 2D networks (papers 002 and 003).
    Frame,
    /// Series [N, C, T] as one channel of C rows and T columns, each row scaled by itself.
    Rows,
    /// Bits [N, fingers, 1 DC + 22 AC, ticks] in Pa from contact on, z-scores per feature (paper 004).
    Numatac,
}

/// `encoding.image`. A field is always made from raw readings, whatever `encoding.signal` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Image {
    /// Field or images as recorded.
    pub kind: ImageKind,
    /// Fields: rows and columns. Default 50.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<usize>,
    /// Fields: `"per-sample"` (default; amplitude is lost) or `{ low, high }` in the unit of the readings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<Range>,
    /// Fields: `jet` (default), `viridis` or `grey`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colormap: Option<Colormap>,
    /// Fields: what a constant recording gives under `per-sample`: `error` (default) or `zero`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constant: Option<Constant>,
    /// Images as recorded and frames: scale of the pixels, default `full-scale`. Rows: of the readings,
    /// default `z-score`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<Scale>,
    /// Images as recorded and frames: `[height, width]` in pixels to resample to, bilinear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resize: Option<[usize; 2]>,
    /// Images as recorded and frames: one grey channel becomes the red of three (paper 001). Default
    /// false.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub red: Option<bool>,
    /// Frames: `"peak"` (default), or `{ at = 5 }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<taxel_encodings::Frame>,
    /// Numatac: ticks from contact on. Default 300.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<usize>,
}

/// `encoding.tensor`: squeezes [N, T, H, W] as tactile tensors [N, 1, H, W, T] (paper 003).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tensor {
    /// Frames to resample to. Default as recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    /// Scale of the readings. Default `full-scale`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<Scale>,
}

impl Config {
    /// The network that a row of the results is of: it bears its label, in a learning curve with the number of
    /// samples behind it (`mlp.n5`). None for a baseline.
    pub fn network(&self, row: &str) -> Option<&Network> {
        self.networks.iter().find(|network| {
            row.strip_prefix(network.label()).is_some_and(|rest| rest.is_empty() || rest.starts_with(".n"))
        })
    }
}
