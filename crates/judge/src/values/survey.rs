//! What a page about a data set shows.

use taxel_data::{Card, Carrier, Drift};
use taxel_report::pictures::Picture;

/// A data set to look at.
#[derive(Debug)]
pub struct Survey {
    /// What it holds, and what is wrong with it.
    pub card: Card,
    /// `kPa`, where it is known.
    pub unit: Option<String>,
    /// Readings per second, where it is known.
    pub rate: Option<f64>,
    /// A few recordings of each class.
    pub classes: Vec<ClassPictures>,
    /// Standard deviation of each taxel `[H, W]` over all samples and times; of images and their sequences.
    pub activity: Option<Picture>,
    /// Readings of each recording along time, before any rule.
    pub lengths: Vec<usize>,
    /// Means in the order of the samples.
    pub drift: Drift,
    /// Class of each sample.
    pub order: Vec<u32>,
    /// What carries the shortcut, the furthest first.
    pub carriers: Vec<Carrier>,
}

/// Some recordings of a class.
#[derive(Debug)]
pub struct ClassPictures {
    /// Class name.
    pub name: String,
    /// Origin and drawing of each.
    pub recordings: Vec<(String, Picture)>,
}
