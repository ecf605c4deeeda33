//! Reads files of recordings, one recording each.

use crate::dataset::raw::{Names, Raw, name_of};
use crate::dataset::spec_of::likeliest_layout;
use crate::dataset::targets::Values;
use crate::error::plural;
use crate::layout::listing::{FoundFiles, unsorted};
use crate::layout::names_file::stamp;
use crate::length::ragged::Collected;
use crate::options::{ReadOptions, refuse_set};
use crate::reader::{FileFormat, Format, Place, Reader, Recorded};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// Most pixels along one side of a resampled image.
const MAX_SIDE: usize = 1 << 14;

/// Reads a single file of a format that holds one recording per file: for a prediction, since it says no class.
pub(crate) struct OnePerFile<F>(pub F);

impl<F: FileFormat> Reader for OnePerFile<F> {
    fn formats(&self) -> &'static [Format] {
        std::slice::from_ref(self.0.format())
    }

    fn recognises(&self, place: &Place, _: &ReadOptions) -> bool {
        !place.needs_labels() && self.0.takes(place.path) && place.path.exists()
    }

    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        read(place, unsorted(vec![place.path.to_path_buf()]), options)
    }

    fn reads_sets(&self) -> bool {
        false
    }

    fn file_format(&self) -> Option<&dyn FileFormat> {
        Some(&self.0)
    }
}

/// Reads the recordings that were `found` at a place: below it, or the one that it is.
pub(crate) fn read(place: &Place, found: FoundFiles, options: &ReadOptions) -> Result<Raw> {
    let root = match found.files.as_slice() {
        [one] if one == place.path => place.path.parent().unwrap_or(Path::new("")),
        _ => place.path,
    };
    let file = root.display().to_string();
    let (format, first) = same_format(place, &found.files, &file)?;
    refuse_array_options(&file, format, &found, options, place.needs_labels())?;
    refuse_resize(&file, format, options)?;
    options.limits.refuse_samples(&file, found.files.len() as u64)?;
    let stated = ReadOptions { layout: options.layout.or(found.facts.layout), ..options.clone() };
    let recorded = match format.read_together(root, &found, &stated) {
        Some(recorded) => recorded?,
        None => one_by_one(root, &found, format, &first, options)?,
    };
    let mut groups = match (found.groups, options.group_block) {
        (None, Some(_)) => Some(("position".into(), found.positions)),
        (groups, _) => groups,
    };
    let mut labels = found.labels;
    let (mut official, mut values) = (found.official, found.values);
    if !recorded.frames.is_empty() {
        labels = each_frame(&labels, &recorded.frames);
        official = official.map(|(name, marks)| (name, each_frame(&marks, &recorded.frames)));
        values = values.map(|values| values_of_frames(&values, &recorded.frames));
        let numbered = || ("recording".into(), (0..recorded.frames.len() as i64).collect());
        let (name, of_file) = groups.unwrap_or_else(numbered);
        groups = Some((name, each_frame(&of_file, &recorded.frames)));
    }
    let mut facts = found.facts;
    facts.depth = recorded.depth.or(facts.depth);
    stamp(&mut facts, recorded.rate, options)?;
    facts.rate = facts.rate.or(recorded.rate);
    let names = Names { file: file.clone(), columns: vec![found.classes], is_given: true };
    Ok(Raw {
        name: name_of(root),
        file,
        x: recorded.x,
        origins: recorded.origins,
        dtype: recorded.dtype,
        format: recorded.layout,
        x_name: "the files".into(),
        y_name: found.labelled_by.into(),
        y: labels,
        names: Some(names),
        values,
        facts,
        groups,
        official,
        ignored: [found.ignored, recorded.ignored].concat(),
        read_as: [found.read_as, recorded.read_as].concat(),
        warnings: recorded.warnings,
        topics: recorded.topics,
        channel_names: recorded.channel_names,
        is_folder: true,
        ..Raw::default()
    })
}

/// Repeats the values of each file for each of its frames.
fn values_of_frames(of_file: &Values, frames: &[usize]) -> Values {
    let of = |(file, frames): (usize, &usize)| std::iter::repeat_n(file, *frames);
    let rows: Vec<usize> = frames.iter().enumerate().flat_map(of).collect();
    Values::new(of_file.quantities().to_vec(), of_file.of(&rows))
}

/// Repeats what is said of each file for each of its frames; nothing where nothing is said.
fn each_frame(of_file: &[i64], frames: &[usize]) -> Vec<i64> {
    of_file.iter().zip(frames).flat_map(|(value, frames)| std::iter::repeat_n(*value, *frames)).collect()
}

/// Reads a sample per file.
fn one_by_one(
    root: &Path,
    found: &FoundFiles,
    format: &dyn FileFormat,
    first: &str,
    options: &ReadOptions,
) -> Result<Recorded> {
    let file = root.display().to_string();
    refuse_empty(Path::new(first))?;
    // Before the first is decoded.
    if let Some(shape) = format.shape(Path::new(first), options)? {
        total_size(&file, found.files.len(), &shape, None, options)?;
    }
    let mut origins = Vec::new();
    let mut collected = Collected::new(&file, options.limits).of_about(found.files.len());
    let mut dtype: Option<String> = None;
    let mut turned = 0;
    for path in &found.files {
        refuse_empty(path)?;
        let sample = format.read(path, options)?;
        let name = path.display().to_string();
        let first_dtype = dtype.get_or_insert_with(|| sample.dtype.clone());
        let layout = format.layout(sample.shape.len());
        let given = [options.layout, found.facts.layout, layout];
        let time = likeliest_layout(given, &sample.dtype, &sample.shape).time_axis();
        if origins.is_empty() {
            total_size(&file, found.files.len(), &sample.shape, time, options)?;
        }
        collected.push(&name, &sample.shape, &sample.values, time, format.hint())?;
        if sample.dtype != *first_dtype {
            let (kind, first_kind) = (sample.dtype, first_dtype.clone());
            return Err(Error::MixedKinds { file: name, kind, first: first.into(), first_kind });
        }
        turned += usize::from(sample.is_turned);
        #[expect(clippy::expect_used, reason = "files are sought below root")]
        origins.push(path.strip_prefix(root).expect("a path below root").display().to_string());
    }
    let (Some(x), Some(dtype)) = (collected.finish(), dtype) else {
        return Err(Error::NoSamples { at: file });
    };
    let layout = format.layout(x.sample_shape().len());
    let of = plural(origins.len(), "image");
    let said = (turned > 0).then(|| format!("{turned} of {of} turned as their EXIF orientation says"));
    Ok(Recorded {
        depth: format.depth(&dtype),
        read_as: said.into_iter().collect(),
        ..Recorded::of(x, dtype, layout, origins)
    })
}

fn refuse_empty(path: &Path) -> Result<()> {
    let file = path.display().to_string();
    match path.metadata() {
        Ok(about) if about.len() == 0 => Err(Error::EmptyFile { file }),
        Ok(_) => Ok(()),
        Err(e) => Err(Error::io(path)(e)),
    }
}

fn refuse_resize(file: &str, format: &dyn FileFormat, options: &ReadOptions) -> Result<()> {
    let Some(size) = options.resize else { return Ok(()) };
    let why = if !format.takes_option("resize") {
        "applies to PNG and JPEG files and to bags of images only; leave it out"
    } else if size.iter().any(|n| !(1..=MAX_SIDE).contains(n)) {
        "is [height, width] in pixels, each 1..16384"
    } else {
        return Ok(());
    };
    Err(Error::Option { file: file.into(), option: "resize", why })
}

fn refuse_array_options(
    file: &str,
    format: &dyn FileFormat,
    found: &FoundFiles,
    options: &ReadOptions,
    is_learning: bool,
) -> Result<()> {
    let set = [
        ("x", options.names_x() && !format.takes_option("x")),
        ("y", options.names_y() && !found.is_table),
        ("group", options.group.is_some() && !found.is_table),
        ("test", options.test.is_some()),
        ("test_above", options.test_above.is_some()),
        ("target", options.target.is_some()),
    ];
    let why = "names an array of a .npz; a folder per class has none (group_block divides \
                  the position of each file in its class folder)";
    refuse_set(file, &set, why)?;
    let why = "names an array or a column of readings; here each file is a recording: leave it out";
    // A model that was trained on such an array says so of every recording.
    refuse_set(file, &[("recording", options.recording.is_some() && is_learning)], why)?;
    let why = "divides the positions of files in their class folders; these have groups of their own";
    refuse_set(file, &[("group_block", options.group_block.is_some() && found.groups.is_some())], why)
}

/// Returns the one format of all files, and the first file.
fn same_format(place: &Place, files: &[PathBuf], root: &str) -> Result<(&'static dyn FileFormat, String)> {
    let mut head: Option<(&dyn FileFormat, String)> = None;
    for path in files {
        let file = path.display().to_string();
        let Some(format) = place.format_of(path) else {
            return Err(place.unknown_extension(file));
        };
        match &head {
            None => head = Some((format, file)),
            Some((first_format, first)) if first_format.name() != format.name() => {
                let (kind, first_kind) = (format.name().into(), first_format.name().into());
                return Err(Error::MixedKinds { file, kind, first: first.clone(), first_kind });
            }
            Some(_) => {}
        }
    }
    head.ok_or_else(|| Error::NoSamples { at: root.into() })
}

/// Refuses too many samples like the first before memory is claimed; unequal ones are counted as they are read.
fn total_size(
    file: &str,
    files: usize,
    shape: &[usize],
    time: Option<usize>,
    options: &ReadOptions,
) -> Result<()> {
    let mut equal = shape.iter().enumerate().filter(|(axis, _)| Some(*axis) != time).map(|(_, n)| n);
    let count = equal.try_fold(files, |product, n| product.checked_mul(*n));
    if count.is_some_and(|count| count as u64 <= options.limits.max_values) {
        return Ok(());
    }
    let hint = "shrink images with resize = [height, width], or raise limits.max_values";
    Err(options.limits.too_large(file, &[&[files], shape].concat(), hint))
}
