//! Formats that this build does without.

use crate::dataset::raw::Raw;
use crate::ending::has_ending;
use crate::formats::bag::path::is_bag;
use crate::formats::names::{is_image, is_lerobot};
use crate::options::ReadOptions;
use crate::reader::{FileFormat, Format, Place, Reader, Sample};
use crate::{Error, Result};
use std::path::Path;

/// Refuses files of formats whose cargo feature is off, by name of the feature.
pub(crate) struct NotBuilt;

/// Returns the feature that reads a path; none where this build has it, or where no feature does.
fn feature_of(path: &Path) -> Option<&'static str> {
    let features = [
        ("hdf5", cfg!(feature = "hdf5"), has_ending(path, &["h5", "hdf5"])),
        ("image", cfg!(feature = "image"), is_image(path)),
        ("matlab", cfg!(feature = "matlab"), has_ending(path, &["mat"])),
        ("mcap", cfg!(feature = "mcap"), is_bag(path)),
        ("parquet", cfg!(feature = "parquet"), has_ending(path, &["parquet", "pq"]) || is_lerobot(path)),
    ];
    features.into_iter().find(|(_, is_built, is_it)| !is_built && *is_it).map(|(feature, ..)| feature)
}

fn refuse<T>(path: &Path) -> Result<T> {
    let (file, feature) = (path.display().to_string(), feature_of(path).unwrap_or_default());
    Err(Error::NotBuilt { file, feature })
}

impl Reader for NotBuilt {
    fn formats(&self) -> &'static [Format] {
        &[]
    }

    fn recognises(&self, place: &Place, _: &ReadOptions) -> bool {
        place.path.exists() && feature_of(place.path).is_some()
    }

    fn read(&self, place: &Place, _: &ReadOptions) -> Result<Raw> {
        refuse(place.path)
    }

    fn file_format(&self) -> Option<&dyn FileFormat> {
        Some(self)
    }
}

impl FileFormat for NotBuilt {
    fn name(&self) -> &'static str {
        "a format that this build does without"
    }

    fn format(&self) -> &'static Format {
        &Format { name: "", endings: &[], holds: "", becomes: "" }
    }

    fn takes(&self, path: &Path) -> bool {
        feature_of(path).is_some()
    }

    fn takes_option(&self, _: &str) -> bool {
        true
    }

    fn shape(&self, path: &Path, _: &ReadOptions) -> Result<Option<Vec<usize>>> {
        refuse(path)
    }

    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Sample> {
        refuse(path)
    }
}
