//! A folder with one sub-folder of recordings per class.

use crate::hash::{RowHash, hash_row};
use crate::npy;
use crate::options::{Limits, Options, refuse_set};
use crate::raw::{Facts, Names, Raw, name_of};
use crate::text::read_text;
use crate::{Error, Result, csv_file, image_file, mat, names_file};
use ndarray::ArrayD;
use std::cmp::Ordering;
use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use taxel_encodings::Layout;

/// Most pixels along one side of a resampled image.
const MAX_SIDE: usize = 1 << 14;

/// What a class folder may hold; a data set holds one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Csv,
    Npy,
    Mat,
    Image,
}

impl Kind {
    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        match extension.as_str() {
            "csv" => Some(Self::Csv),
            "npy" => Some(Self::Npy),
            "mat" => Some(Self::Mat),
            "png" | "jpg" | "jpeg" => Some(Self::Image),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Csv => "CSV",
            Self::Npy => "NPY",
            Self::Mat => "MAT",
            Self::Image => "an image",
        }
    }
}

/// One recording, read.
struct Sample {
    shape: Vec<usize>,
    values: Vec<f32>,
    hash: RowHash,
    dtype: String,
}

/// Files or folders right under `folder`, hidden ones left out.
pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = |e: std::io::Error| Error::Io { file: folder.display().to_string(), kind: e.kind() };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        if !entry.file_name().to_string_lossy().starts_with('.') {
            paths.push(entry.path());
        }
    }
    paths.sort();
    Ok(paths)
}

/// Reads every recording of every class folder of `root`; `labels.json` beside them may say what the readings
/// are, and the order of the classes.
pub(crate) fn read(root: &Path, classes: &[PathBuf], options: &Options) -> Result<Raw> {
    #[expect(clippy::expect_used, reason = "a class folder is an entry of root")]
    let name = |path: &PathBuf| path.file_name().expect("entries have names").to_string_lossy().into();
    let names: Vec<String> = classes.iter().map(name).collect();
    let (order, facts) = names_file::of_named(&[root.join("labels.json")], &names, &options.limits)?;
    let order = order.unwrap_or_else(|| (0..names.len()).collect());
    let files = list(classes)?;
    let files: Vec<Vec<PathBuf>> = order.iter().map(|class| files[*class].clone()).collect();
    let names = order.iter().map(|class| names[*class].clone()).collect();
    Ok(Raw { facts, ..read_files(root, &files, names, options)? })
}

/// Reads recordings below `root`, one file each; `files` by class, `names` those of the classes.
pub(crate) fn read_files(
    root: &Path,
    files: &[Vec<PathBuf>],
    names: Vec<String>,
    options: &Options,
) -> Result<Raw> {
    let file = root.display().to_string();
    let (kind, first) = same_kind(files, &file)?;
    refuse_array_options(&file, kind, options)?;
    refuse_resize(&file, kind, options)?;
    let (mut values, mut row_hash, mut origins) = (Vec::<f32>::new(), Vec::new(), Vec::new());
    let (mut y, mut positions) = (Vec::new(), Vec::new());
    let mut head: Option<(Vec<usize>, String)> = None;
    let count = files.iter().map(Vec::len).sum();
    if kind == Kind::Image {
        // Before the first is decoded.
        refuse_empty(Path::new(&first), &first)?;
        let shape = image_file::shape(Path::new(&first), &first, options.resize, &options.limits)?;
        total_size(&file, count, &shape, options)?;
    }
    for (label, folder) in files.iter().enumerate() {
        for (position, path) in folder.iter().enumerate() {
            let sample = read_sample(path, kind, options)?;
            match &head {
                None => {
                    total_size(&file, count, &sample.shape, options)?;
                    // Growing step by step would take twice the memory in the end.
                    values.reserve_exact(count * sample.values.len());
                    head = Some((sample.shape, sample.dtype));
                }
                Some(head) => same_form(path, &sample, &first, head, kind)?,
            }
            values.extend(sample.values);
            row_hash.push(sample.hash);
            y.push(label as i64);
            positions.push(position as i64);
            #[expect(clippy::expect_used, reason = "files are sought below root")]
            origins.push(path.strip_prefix(root).expect("a path below root").display().to_string());
        }
    }
    let (shape, dtype) = head.ok_or_else(|| Error::NoSamples { at: file.clone() })?;
    let format = match (kind, shape.len()) {
        (Kind::Image, 3) => Some(Layout::Colour),
        (Kind::Image, _) => Some(Layout::Image),
        (Kind::Csv, _) => Some(Layout::Series),
        (Kind::Npy | Kind::Mat, _) => None,
    };
    let full: Vec<usize> = std::iter::once(y.len()).chain(shape).collect();
    let x = ArrayD::from_shape_vec(full, values)
        .map_err(|e| Error::NotAnArray { at: file.clone(), why: e.to_string() })?;
    Ok(Raw {
        name: name_of(root),
        dtype,
        format,
        x,
        x_name: "the files".into(),
        y_name: "the class folders".into(),
        y,
        columns: 1,
        names: Some(Names { file: file.clone(), columns: vec![names], is_told: true }),
        facts: Facts::default(),
        groups: options.group_block.map(|_| ("position".into(), positions)),
        official: None,
        origins,
        row_hash,
        others: Vec::new(),
        is_folder: true,
        file,
    })
}

fn refuse_resize(file: &str, kind: Kind, options: &Options) -> Result<()> {
    let Some(size) = options.resize else { return Ok(()) };
    let why = if kind != Kind::Image {
        "applies to PNG and JPEG files only; leave it out"
    } else if size.iter().any(|n| !(1..=MAX_SIDE).contains(n)) {
        "is [height, width] in pixels, each 1..16384"
    } else {
        return Ok(());
    };
    Err(Error::Option { file: file.into(), option: "resize", why })
}

fn refuse_array_options(file: &str, kind: Kind, options: &Options) -> Result<()> {
    let default = Options::default();
    let set = [
        ("x", options.x != default.x && kind != Kind::Mat),
        ("y", options.y != default.y),
        ("group", options.group.is_some()),
        ("test", options.test.is_some()),
        ("test-above", options.test_above.is_some()),
    ];
    let why = "names an array of a .npz; a folder per class has none (group-block divides \
                  the position of each file in its class folder)";
    refuse_set(file, &set, why)
}

/// The recordings of each class folder: `take2.csv` before `take10.csv`.
fn list(classes: &[PathBuf]) -> Result<Vec<Vec<PathBuf>>> {
    let mut files = Vec::with_capacity(classes.len());
    for class in classes {
        let paths = entries(class)?;
        if paths.is_empty() {
            return Err(Error::EmptyClassFolder { file: class.display().to_string() });
        }
        if let Some(folder) = paths.iter().find(|path| path.is_dir()) {
            return Err(Error::NestedFolder { file: folder.display().to_string() });
        }
        files.push(in_order(paths));
    }
    Ok(files)
}

/// Paths in counting order.
pub(crate) fn in_order(mut paths: Vec<PathBuf>) -> Vec<PathBuf> {
    paths.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
    paths
}

/// Compares texts with their runs of digits as numbers.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut a_rest, mut b_rest) = (a, b);
    while let (Some(x), Some(y)) = (a_rest.chars().next(), b_rest.chars().next()) {
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
            let (i, j) = (digits(a_rest), digits(b_rest));
            let number = |text: &'_ str| text.trim_start_matches('0').to_string();
            let (m, n) = (number(&a_rest[..i]), number(&b_rest[..j]));
            let order = m.len().cmp(&n.len()).then_with(|| m.cmp(&n));
            if order != Ordering::Equal {
                return order;
            }
            (a_rest, b_rest) = (&a_rest[i..], &b_rest[j..]);
        } else if x == y {
            (a_rest, b_rest) = (&a_rest[x.len_utf8()..], &b_rest[y.len_utf8()..]);
        } else {
            return x.cmp(&y);
        }
    }
    a_rest.len().cmp(&b_rest.len()).then_with(|| a.cmp(b))
}

/// The one kind of all files, and the first file.
fn same_kind(files: &[Vec<PathBuf>], root: &str) -> Result<(Kind, String)> {
    let mut head: Option<(Kind, String)> = None;
    for path in files.iter().flatten() {
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

fn total_size(file: &str, files: usize, shape: &[usize], options: &Options) -> Result<()> {
    if files as u64 > options.limits.max_samples {
        let limit = options.limits.max_samples;
        return Err(Error::TooManySamples { at: file.into(), samples: files as u64, limit });
    }
    let limit = options.limits.max_values;
    let count = shape.iter().try_fold(files, |product, n| product.checked_mul(*n));
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

/// Shape and type of a sample must be those of the first.
fn same_form(
    path: &Path,
    sample: &Sample,
    first: &str,
    head: &(Vec<usize>, String),
    kind: Kind,
) -> Result<()> {
    let file = path.display().to_string();
    if sample.shape != head.0 {
        return Err(Error::SampleShape {
            file,
            shape: sample.shape.clone(),
            first: first.into(),
            first_shape: head.0.clone(),
            hint: match kind {
                Kind::Csv | Kind::Mat => " (channels, time): cut or pad the recordings",
                Kind::Npy => "",
                Kind::Image => ": set resize = [height, width], or use grey or colour throughout",
            },
        });
    }
    if sample.dtype != head.1 {
        return Err(Error::MixedKinds {
            file,
            kind: sample.dtype.clone(),
            first: first.into(),
            first_kind: head.1.clone(),
        });
    }
    Ok(())
}

fn refuse_empty(path: &Path, file: &str) -> Result<()> {
    let metadata = path.metadata().map_err(|e| Error::Io { file: file.into(), kind: e.kind() })?;
    if metadata.len() == 0 {
        return Err(Error::EmptyFile { file: file.into() });
    }
    Ok(())
}

fn read_sample(path: &Path, kind: Kind, options: &Options) -> Result<Sample> {
    let limits = &options.limits;
    let file = path.display().to_string();
    let io = |e: std::io::Error| Error::Io { file: file.clone(), kind: e.kind() };
    refuse_empty(path, &file)?;
    match kind {
        Kind::Csv => {
            let (shape, values) = csv_file::read(&read_text(path, limits)?, &file, limits.max_values)?;
            let hash = hash_row(&values);
            Ok(Sample { shape, values, hash, dtype: "csv".into() })
        }
        Kind::Npy => {
            let mut reader = BufReader::new(File::open(path).map_err(io)?);
            let header = npy::read_header(&mut reader, &file)?;
            one(&header, &mut reader, &file, limits)
        }
        Kind::Mat => {
            let mut archive = mat::Archive::open(path)?;
            let held = archive.recordings();
            let name = match held.as_slice() {
                [one] => one.clone(),
                _ if held.contains(&options.x) => options.x.clone(),
                _ => return Err(Error::missing(&file, &options.x, &held, "x")),
            };
            let at = format!("{file}: {name}");
            archive.with(&name, &at, |header, reader, at| one(header, reader, at, limits))
        }
        Kind::Image => {
            let picture = image_file::read(path, &file, options.resize, limits)?;
            Ok(Sample {
                shape: picture.shape,
                values: picture.values,
                hash: picture.hash,
                dtype: format!("png/jpeg u{}", picture.bits),
            })
        }
    }
}

/// One array as one recording.
fn one(header: &npy::Header, reader: &mut dyn Read, at: &str, limits: &Limits) -> Result<Sample> {
    let shape = header.shape.clone();
    if !(2..=3).contains(&shape.len()) {
        let wanted = "one recording is [C, T], [H, W] or [T, H, W]";
        return Err(Error::Shape { at: at.into(), shape, wanted });
    }
    if let Some(axis) = shape.iter().position(|axis| *axis == 0) {
        return Err(Error::EmptyAxis { at: at.into(), shape, axis });
    }
    let array = header.read_f32(reader, at, npy::Cap::of_samples(limits))?;
    let shape = array.shape().to_vec();
    let values = array.into_iter().collect::<Vec<f32>>();
    let hash = hash_row(&values);
    Ok(Sample { shape, values, hash, dtype: header.dtype.clone() })
}

#[cfg(test)]
mod tests {
    use super::natural;

    #[test]
    fn files_are_in_the_order_people_count() {
        let mut names = ["b2", "a10", "a9", "a010", "a1b", "a", "a99999999999999999999999"];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["a", "a1b", "a9", "a010", "a10", "a99999999999999999999999", "b2"]);
    }
}
