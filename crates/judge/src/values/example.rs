//! A test sample that is worth a look.

use serde::{Deserialize, Serialize};

/// A test sample, what networks see of it and say about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// `fingertip[17]`, or a file.
    pub origin: String,
    /// Its class; with several attributes `elasticity:3, hardness:7`.
    pub truth: String,
    /// The raw sample first, then each encoding.
    pub pictures: Vec<Picture>,
    /// What each network says.
    pub verdicts: Vec<Verdict>,
}

/// What a network says about a sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Name in the experiment.
    pub network: String,
    /// Like [`Example::truth`].
    pub predicted: String,
    /// Probability of it, 0 to 1 (of several attributes the smallest).
    pub probability: f64,
    /// Whether it is right.
    pub right: bool,
}

/// How [`Picture::values`] are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PictureKind {
    /// `[C, T]`: one line per channel.
    Lines,
    /// `[H, W]`: one grey or coloured image; scaled from its least to its largest value.
    Grey,
    /// `[3, H, W]`: red, green, blue.
    Colour,
    /// `[K, H, W]`: some frames of a sequence, from early to late.
    Frames,
}

/// An array to be drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// `reading`, or the name of an input.
    pub name: String,
    /// How it is drawn.
    pub kind: PictureKind,
    /// As `kind` says.
    pub shape: Vec<usize>,
    /// Row-major.
    pub values: Vec<f32>,
}
