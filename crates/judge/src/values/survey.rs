//! Values on the page of a data set.

use taxel_data::{Card, Carrier, Drift};
use taxel_report::pictures::ArrayPicture;

/// A data set to look at.
#[derive(Debug)]
pub struct Survey {
    /// Its contents and problems.
    pub card: Card,
    /// `kPa`, where it is known.
    pub unit: Option<String>,
    /// Readings per second, where it is known.
    pub rate: Option<f64>,
    /// A few recordings of each class.
    pub classes: Vec<ClassPictures>,
    /// Standard deviation of each taxel `[H, W]` over all samples and times; of images and their sequences.
    pub activity: Option<ArrayPicture>,
    /// Readings of each recording along time, before any rule.
    pub lengths: Vec<usize>,
    /// Means in the order of the samples.
    pub drift: Drift,
    /// Class of each sample.
    pub order: Vec<u32>,
    /// Statistics that tell the classes apart, the most accurate first.
    pub carriers: Vec<Carrier>,
}

/// Some recordings of a class.
#[derive(Debug)]
pub struct ClassPictures {
    /// Class name.
    pub name: String,
    /// Origin and drawing of each.
    pub recordings: Vec<(String, ArrayPicture)>,
}
