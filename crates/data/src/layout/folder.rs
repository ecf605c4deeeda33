//! A folder of recordings, one file each.

use crate::dataset::digest::RowHash;
use crate::dataset::raw::{Names, Raw, name_of};
use crate::dataset::reading_of::time_axis;
use crate::formats::bag::bags::{self, Recorded};
use crate::layout::listing::Found;
use crate::layout::sample::{Kind, image_shape, read_sample};
use crate::length::ragged::{Collected, Ragged};
use crate::options::{ReadOptions, refuse_set};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// Most pixels along one side of a resampled image.
const MAX_SIDE: usize = 1 << 14;

/// Reads the recordings that were `found` below `root`.
pub(crate) fn read(root: &Path, found: Found, options: &ReadOptions) -> Result<Raw> {
    let file = root.display().to_string();
    let (kind, first) = same_kind(&found.files, &file)?;
    refuse_array_options(&file, kind, &found, options)?;
    refuse_resize(&file, kind, options)?;
    if found.files.len() as u64 > options.limits.max_samples {
        let (samples, limit) = (found.files.len() as u64, options.limits.max_samples);
        return Err(Error::TooManySamples { at: file, samples, limit });
    }
    let Files { x, dtype, format, row_hash, origins, bags } = match kind {
        Kind::Bag => bags(root, &found, options)?,
        _ => files(root, &found, kind, &first, options)?,
    };
    let groups = match (found.groups, options.group_block) {
        (None, Some(_)) => Some(("position".into(), found.positions)),
        (groups, _) => groups,
    };
    let mut facts = found.facts;
    facts.rate = facts.rate.or(bags.rate);
    facts.stamped = bags.rate;
    Ok(Raw {
        name: name_of(root),
        dtype,
        format,
        x,
        x_name: "the files".into(),
        y_name: found.labelled_by.into(),
        y: found.labels,
        columns: 1,
        names: Some(Names { file: file.clone(), columns: vec![found.classes], is_told: true }),
        facts,
        groups,
        official: None,
        origins,
        row_hash,
        others: Vec::new(),
        ignored: found.ignored,
        read_as: [found.read_as, bags.read_as].concat(),
        topics: bags.topics,
        table: None,
        is_folder: true,
        file,
    })
}

/// The samples of files, and what is known of them.
struct Files {
    x: Ragged,
    dtype: String,
    format: Option<Layout>,
    row_hash: Vec<RowHash>,
    origins: Vec<String>,
    bags: OfBags,
}

/// What bags say beside.
#[derive(Default)]
struct OfBags {
    rate: Option<f64>,
    read_as: Vec<String>,
    topics: Vec<String>,
}

fn bags(root: &Path, found: &Found, options: &ReadOptions) -> Result<Files> {
    let Recorded { x, layout, row_hash, origins, read_as, rate, topics } = bags::read(root, found, options)?;
    let bags = OfBags { rate, read_as, topics };
    Ok(Files { x, dtype: "mcap".into(), format: Some(layout), row_hash, origins, bags })
}

/// A sample per file.
fn files(root: &Path, found: &Found, kind: Kind, first: &str, options: &ReadOptions) -> Result<Files> {
    let file = root.display().to_string();
    if kind == Kind::Image {
        // Before the first is decoded.
        let shape = image_shape(Path::new(first), options)?;
        total_size(&file, found.files.len(), &shape, None, options)?;
    }
    let (mut row_hash, mut origins) = (Vec::new(), Vec::new());
    let mut collected = Collected::new(&file, options.limits).of_about(found.files.len());
    let mut dtype: Option<String> = None;
    for path in &found.files {
        let sample = read_sample(path, kind, options)?;
        let name = path.display().to_string();
        let first_dtype = dtype.get_or_insert_with(|| sample.dtype.clone());
        let format = kind.layout(sample.shape.len());
        let time = time_axis(options.layout, found.facts.layout, format, &sample.dtype, &sample.shape);
        if row_hash.is_empty() {
            total_size(&file, found.files.len(), &sample.shape, time, options)?;
        }
        collected.push(&name, &sample.shape, &sample.values, time, kind.hint())?;
        if sample.dtype != *first_dtype {
            let (kind, first_kind) = (sample.dtype, first_dtype.clone());
            let first = first.into();
            return Err(Error::MixedKinds { file: name, kind, first, first_kind });
        }
        row_hash.push(sample.hash);
        #[expect(clippy::expect_used, reason = "files are sought below root")]
        origins.push(path.strip_prefix(root).expect("a path below root").display().to_string());
    }
    let (Some(x), Some(dtype)) = (collected.finish(), dtype) else {
        return Err(Error::NoSamples { at: file });
    };
    let format = kind.layout(x.sample_shape().len());
    Ok(Files { x, dtype, format, row_hash, origins, bags: OfBags::default() })
}

fn refuse_resize(file: &str, kind: Kind, options: &ReadOptions) -> Result<()> {
    let Some(size) = options.resize else { return Ok(()) };
    let why = if !matches!(kind, Kind::Image | Kind::Bag) {
        "applies to PNG and JPEG files and to bags of images only; leave it out"
    } else if size.iter().any(|n| !(1..=MAX_SIDE).contains(n)) {
        "is [height, width] in pixels, each 1..16384"
    } else {
        return Ok(());
    };
    Err(Error::Option { file: file.into(), option: "resize", why })
}

fn refuse_array_options(file: &str, kind: Kind, found: &Found, options: &ReadOptions) -> Result<()> {
    let default = ReadOptions::default();
    let set = [
        ("x", options.x != default.x && !matches!(kind, Kind::Mat | Kind::Hdf5)),
        ("y", options.y != default.y && !found.is_table),
        ("group", options.group.is_some() && !found.is_table),
        ("test", options.test.is_some()),
        ("test-above", options.test_above.is_some()),
    ];
    let why = "names an array of a .npz; a folder per class has none (group-block divides \
                  the position of each file in its class folder)";
    refuse_set(file, &set, why)?;
    if options.group_block.is_some() && found.groups.is_some() {
        let why = "divides the positions of files in their class folders; these have groups of their own";
        return Err(Error::Option { file: file.into(), option: "group-block", why });
    }
    Ok(())
}

/// The one kind of all files, and the first file.
fn same_kind(files: &[PathBuf], root: &str) -> Result<(Kind, String)> {
    let mut head: Option<(Kind, String)> = None;
    for path in files {
        let file = path.display().to_string();
        let Some(kind) = Kind::of(path) else {
            return Err(Error::UnknownExtension { file });
        };
        match &head {
            None => head = Some((kind, file)),
            Some((first_kind, first)) if *first_kind != kind => {
                return Err(Error::MixedKinds {
                    file,
                    kind: kind.name().into(),
                    first: first.clone(),
                    first_kind: first_kind.name().into(),
                });
            }
            Some(_) => {}
        }
    }
    head.ok_or_else(|| Error::NoSamples { at: root.into() })
}

/// Refuses so many samples like the first before memory is claimed; unequal ones are counted as they come.
fn total_size(
    file: &str,
    files: usize,
    shape: &[usize],
    time: Option<usize>,
    options: &ReadOptions,
) -> Result<()> {
    let limit = options.limits.max_values;
    let mut equal = shape.iter().enumerate().filter(|(axis, _)| Some(*axis) != time).map(|(_, n)| n);
    let count = equal.try_fold(files, |product, n| product.checked_mul(*n));
    if count.is_some_and(|count| count as u64 <= limit) {
        return Ok(());
    }
    Err(Error::TooLarge {
        at: file.into(),
        shape: std::iter::once(files).chain(shape.iter().copied()).map(|n| n as u64).collect(),
        limit,
        hint: "shrink images with resize = [height, width], or raise limits.max-values",
    })
}
