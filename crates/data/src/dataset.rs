//! The data set in memory.

use ndarray::{Array2, ArrayD};
use serde::Serialize;

/// First 16 bytes of the BLAKE3 hash of one recorded sample.
pub type RowHash = [u8; 16];

/// What the axes of `x` are; for a `.npz` this is a guess from rank and type.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Axes {
    /// `[N, F]`: one row of numbers per sample.
    #[serde(rename = "N×F")]
    Features,
    /// `[N, C, T]`: channels over time.
    #[serde(rename = "N×C×T")]
    ChannelsTime,
    /// `[N, H, W]`: one pressure image.
    #[serde(rename = "N×H×W")]
    HeightWidth,
    /// `[N, T, H, W]`: pressure images over time.
    #[serde(rename = "N×T×H×W")]
    TimeHeightWidth,
    /// `[N, 3, H, W]`: one colour image, red, green, blue.
    #[serde(rename = "N×3×H×W")]
    ColourHeightWidth,
}

impl std::fmt::Display for Axes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::Features => "N×F",
            Self::ChannelsTime => "N×C×T",
            Self::HeightWidth => "N×H×W",
            Self::TimeHeightWidth => "N×T×H×W",
            Self::ColourHeightWidth => "N×3×H×W",
        })
    }
}

/// Labelled recordings, all of one shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// The file or folder name without extension; `data.npz` goes by its folder.
    pub name: String,
    /// Samples `[N, ...]` in C order, as stored: no scaling.
    pub x: ArrayD<f32>,
    /// What the axes of `x` are.
    pub axes: Axes,
    /// Type of the stored values: `<f4`, `|u1`, `csv`, `png/jpeg u8`.
    pub dtype: String,
    /// Class of each sample, `0..classes.len()`; every class has at least one sample.
    pub y: Vec<u32>,
    /// Class names by label.
    pub classes: Vec<String>,
    /// All label columns `[N, k]` where the file holds k > 1 of them.
    pub attributes: Option<Array2<u32>>,
    /// Value names of each column of `attributes`; empty without them.
    pub attribute_classes: Vec<Vec<String>>,
    /// Which samples the data set's authors test on, where they say so.
    pub official: Option<Vec<bool>>,
    /// Group (object, session, block) of each sample.
    pub groups: Option<Vec<u32>>,
    /// What the groups are, such as `session` or `trial/12`.
    pub group_name: Option<String>,
    /// What the samples are, if the file of class names says it: `simulated: fingertip`.
    pub source: Option<String>,
    /// The highest reading that the sensor gives, if that file says it.
    pub full_scale: Option<f64>,
    /// Where each sample comes from: its file, or `x[17]`.
    pub sources: Vec<String>,
    /// Sources of the rows left out by [`Options::drop`](crate::Options::drop).
    pub dropped: Vec<String>,
    /// Hash of each full recorded sample, before channels are selected or images resized.
    pub row_hash: Vec<RowHash>,
    /// BLAKE3 of shape, values, labels and groups, in hexadecimal.
    pub digest: String,
}

impl Dataset {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.y.len()
    }

    /// Whether there are no samples.
    pub fn is_empty(&self) -> bool {
        self.y.is_empty()
    }

    /// Shape of one sample: the axes of `x` after the first.
    pub fn sample_shape(&self) -> &[usize] {
        self.x.shape().get(1..).unwrap_or_default()
    }

    /// Samples per class, in the order of `classes`.
    pub fn class_counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.classes.len()];
        for label in &self.y {
            if let Some(count) = counts.get_mut(*label as usize) {
                *count += 1;
            }
        }
        counts
    }
}

/// Hashes one sample; -0 and 0 count as equal.
pub(crate) fn hash_row(row: &[f32]) -> RowHash {
    let mut hasher = blake3::Hasher::new();
    update(&mut hasher, row.iter().map(|v| (v + 0.0).to_le_bytes()));
    let mut hash = [0; 16];
    hash.copy_from_slice(&hasher.finalize().as_bytes()[..16]);
    hash
}

/// BLAKE3 of the content, each part preceded by its length.
pub(crate) fn digest(
    x: &ArrayD<f32>,
    y: &[u32],
    attributes: Option<&Array2<u32>>,
    groups: Option<&[u32]>,
) -> String {
    let mut hasher = blake3::Hasher::new();
    let len = |hasher: &mut blake3::Hasher, n: usize| {
        hasher.update(&(n as u64).to_le_bytes());
    };
    len(&mut hasher, x.ndim());
    for axis in x.shape() {
        len(&mut hasher, *axis);
    }
    update(&mut hasher, x.iter().map(|v| v.to_le_bytes()));
    len(&mut hasher, y.len());
    update(&mut hasher, y.iter().map(|v| v.to_le_bytes()));
    let groups = groups.unwrap_or_default();
    len(&mut hasher, groups.len());
    update(&mut hasher, groups.iter().map(|v| v.to_le_bytes()));
    if let Some(attributes) = attributes {
        len(&mut hasher, attributes.ncols());
        update(&mut hasher, attributes.iter().map(|v| v.to_le_bytes()));
    }
    hasher.finalize().to_hex().to_string()
}

/// Feeds four-byte words to the hasher in large pieces: many small ones are slow.
fn update(hasher: &mut blake3::Hasher, words: impl Iterator<Item = [u8; 4]>) {
    let mut buffer = [0; 1 << 14];
    let mut used = 0;
    for word in words {
        buffer[used..used + 4].copy_from_slice(&word);
        used += 4;
        if used == buffer.len() {
            hasher.update(&buffer);
            used = 0;
        }
    }
    hasher.update(&buffer[..used]);
}
