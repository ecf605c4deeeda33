//! Samples, labels and groups by name, from a file of named arrays.

use crate::dataset::labels::by_name;
use crate::dataset::raw::{Facts, Names, Raw, name_of};
use crate::dataset::spec_of::time_axis;
use crate::dataset::targets::{Quantity, Values};
use crate::formats::archive::Archive;
use crate::formats::npy::{Cap, Header};
use crate::formats::stored::{Column, Stored, column};
use crate::layout::files;
use crate::layout::names_file;
use crate::layout::roles::{Roles, Samples, Unclear};
use crate::layout::sample;
use crate::length::ragged::{Collected, Ragged};
use crate::options::{Limits, ReadOptions};
use crate::reader::{FileFormat, Format, Place, Purpose, Reader, Sample};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// Reads files of named arrays in one format: each is a set of samples, or one recording.
pub(crate) struct ArrayFile {
    pub format: &'static Format,
    /// The name of the file that is the whole set of its folder.
    pub inside: Option<&'static str>,
    /// Of a format whose files in a folder are one recording each.
    pub recording: Option<OneArray>,
    pub open: fn(&Path) -> Result<Archive>,
}

/// Says what a file is that is one recording: one array of it.
pub(crate) struct OneArray {
    pub name: &'static str,
    pub hint: &'static str,
}

impl Reader for ArrayFile {
    fn formats(&self) -> &'static [Format] {
        std::slice::from_ref(self.format)
    }

    fn recognises(&self, place: &Place, _: &ReadOptions) -> bool {
        self.set_at(place.path).is_some()
    }

    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        match place.purpose {
            Purpose::Predict { rank } if self.is_one_recording(place.path, options, rank) => {
                files::alone(place, options)
            }
            _ => {
                let path = self.set_at(place.path).unwrap_or_else(|| place.path.to_path_buf());
                read(&path, (self.open)(&path)?, options, place.needs_labels())
            }
        }
    }

    fn file_format(&self) -> Option<&dyn FileFormat> {
        self.recording.is_some().then_some(self)
    }
}

impl FileFormat for ArrayFile {
    fn name(&self) -> &'static str {
        self.recording.as_ref().map_or(self.format.name, |one| one.name)
    }

    fn format(&self) -> &'static Format {
        self.format
    }

    fn layout(&self, _: usize) -> Option<Layout> {
        None
    }

    fn hint(&self) -> &'static str {
        self.recording.as_ref().map_or("", |one| one.hint)
    }

    fn takes_option(&self, option: &str) -> bool {
        option == "x"
    }

    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Sample> {
        let file = path.display().to_string();
        let mut archive = (self.open)(path)?;
        let (held, described) = (archive.recordings(), archive.described());
        let name = match held.as_slice() {
            [one] => one.clone(),
            _ if held.iter().any(|name| name == options.x()) => options.x().to_string(),
            _ => return Err(Error::missing(&file, options.x(), &described, "x")),
        };
        archive.with(&file, &name, "x", |header, reader, at| sample::one(header, reader, at, &options.limits))
    }
}

impl ArrayFile {
    /// The file of arrays at a path: itself, or the one in the folder.
    fn set_at(&self, path: &Path) -> Option<PathBuf> {
        if self.format.names(path) && path.is_file() {
            return Some(path.to_path_buf());
        }
        self.inside.map(|name| path.join(name)).filter(|path| path.is_file())
    }

    /// Whether a file holds one recording of `rank` axes and not a set of them.
    fn is_one_recording(&self, path: &Path, options: &ReadOptions, rank: usize) -> bool {
        if self.recording.is_none() {
            return false;
        }
        let Ok(mut archive) = (self.open)(path) else { return false };
        match Roles::of(&archive.saved(), options, false, |labels| archive.entries(labels)) {
            Ok(Roles { x: Samples::One(x), y: None, .. }) => archive.shape(&x).len() == rank,
            Ok(_) => false,
            Err(_) => true,
        }
    }
}

/// Reads the arrays that `options` names; labels and groups stay as stored, and where there need be none `y` is empty.
fn read(path: &Path, mut archive: Archive, options: &ReadOptions, needs_labels: bool) -> Result<Raw> {
    let file = path.display().to_string();
    if options.resize.is_some() {
        let why = "applies to a folder of PNG or JPEG files only; leave it out";
        return Err(Error::Option { file, option: "resize", why });
    }
    let (names, facts) = names_file::beside(path, &options.limits)?;
    let options = &said(options, &facts);
    let roles = Roles::of(&archive.saved(), options, needs_labels, |labels| archive.entries(labels));
    let roles = roles.map_err(|unclear| refuse(&file, &mut archive, unclear))?;
    let Read { x, dtype, origins, official } =
        read_samples(&mut archive, &file, &roles.x, facts.layout, options)?;
    let origins = told_origins(&facts, &file, origins)?;
    let values = match &roles.y {
        Some(arrays) => read_values(&mut archive, &file, arrays, &facts, &options.limits)?,
        None => None,
    };
    let labels = match roles.y.as_ref().filter(|_| values.is_none()) {
        Some(arrays) => read_labels(&mut archive, &file, arrays, names.as_ref(), options, x.len())?,
        None => Labels { values: vec![], columns: 1, names: None },
    };
    let groups = read_groups(&mut archive, &file, &roles, options)?;
    let official = match official {
        Some(marks) => Some(marks),
        None => read_official(&mut archive, &file, options)?,
    };
    let mut used: Vec<&String> = roles.y.iter().chain(&roles.group).flatten().chain(&options.test).collect();
    let x_name = match &roles.x {
        Samples::One(x) => {
            used.push(x);
            x.clone()
        }
        Samples::Split(both) => {
            used.extend(both);
            both.join(" with ")
        }
        Samples::Each(each) => {
            used.extend(each);
            "the other arrays".into()
        }
    };
    let others = archive.arrays().iter().filter(|name| !used.contains(name)).cloned().collect();
    let y_name = roles.y.map_or_else(|| options.y().to_string(), |arrays| arrays.join(" with "));
    let hashes = x.hashes();
    Ok(Raw::new(name_of(path), file, x, origins)
        .stored_as(dtype, None)
        .called(x_name, y_name)
        .with_labels(labels.values, labels.columns, names.or(labels.names))
        .with_values(values)
        .with_facts(facts)
        .with_groups(groups)
        .with_official(official)
        .with_hashes(hashes)
        .passing_over(others, vec![]))
}

/// The options, and where they do not name the arrays of groups and marks, what the file of names says.
fn said(options: &ReadOptions, facts: &Facts) -> ReadOptions {
    let own = options.clone();
    let or = |told: Option<String>, fact: &Option<String>| told.or_else(|| fact.clone());
    ReadOptions { group: or(own.group, &facts.group_array), test: or(own.test, &facts.test_array), ..own }
}

/// Where samples come from, as the file of names says, or else as they are numbered.
fn told_origins(facts: &Facts, file: &str, numbered: Vec<String>) -> Result<Vec<String>> {
    match &facts.origins {
        None => Ok(numbered),
        Some(told) if told.len() == numbered.len() => Ok(told.clone()),
        Some(told) => Err(Error::Length {
            file: file.into(),
            array: format!("origins of {}", facts.file),
            len: told.len(),
            x: "x".into(),
            samples: numbered.len(),
        }),
    }
}

/// What the file holds, where a role is unclear.
fn refuse(file: &str, archive: &mut Archive, unclear: Unclear) -> Error {
    let Unclear { array, option, several } = unclear;
    if several.is_empty() {
        return Error::missing(file, &array, &archive.described(), option);
    }
    let (file, held) = (file.to_string(), archive.described().join(", "));
    Error::AmbiguousArray { file, option, several: several.join(", "), held }
}

/// Samples, their stored type, where each comes from, and which the file itself marks for testing.
struct Read {
    x: Ragged,
    dtype: String,
    origins: Vec<String>,
    official: Option<(String, Vec<i64>)>,
}

fn read_samples(
    archive: &mut Archive,
    file: &str,
    samples: &Samples,
    layout: Option<Layout>,
    options: &ReadOptions,
) -> Result<Read> {
    let numbered = |name: &str, x: &Ragged| (0..x.len()).map(|i| format!("{name}[{i}]")).collect::<Vec<_>>();
    match samples {
        Samples::One(name) => {
            let (x, dtype) = read_array(archive, file, name, &options.limits)?;
            Ok(Read { origins: numbered(name, &x), x, dtype, official: None })
        }
        Samples::Split([train, test]) => {
            if options.test.is_some() {
                let why =
                    "names a split, but the file has its own, a training and a test array; leave it out";
                return Err(Error::Option { file: file.into(), option: "test", why });
            }
            let (x, dtype) = read_array(archive, file, train, &options.limits)?;
            let (tested, _) = read_array(archive, file, test, &options.limits)?;
            let origins = [numbered(train, &x), numbered(test, &tested)].concat();
            let marks = [vec![0; x.len()], vec![1; tested.len()]].concat();
            let x = x.joined(tested).map_err(|[first_shape, shape]| Error::SampleShape {
                file: format!("{file}: {test}"),
                shape,
                first: train.clone(),
                first_shape,
                hint: "; training and test samples are of one shape",
            })?;
            Ok(Read { x, dtype, origins, official: Some((test.clone(), marks)) })
        }
        Samples::Each(names) => {
            let mut collected = Collected::new(file, options.limits);
            let mut dtype = String::new();
            for name in names {
                let own = archive.with(file, name, "x", |header, reader, at| {
                    sample::one(header, reader, at, &options.limits)
                })?;
                let time = time_axis(options.layout, layout, None, &own.dtype, &own.shape);
                let at = format!("{file}: {name}");
                collected.push(&at, &own.shape, &own.values, time, " but for time")?;
                if dtype.is_empty() {
                    dtype = own.dtype;
                }
            }
            let x = collected.finish().ok_or_else(|| Error::NoSamples { at: file.into() })?;
            Ok(Read { x, dtype, origins: names.clone(), official: None })
        }
    }
}

/// Samples `[N, ...]` and the type that they are stored in; no axis is empty.
fn read_array(archive: &mut Archive, file: &str, name: &str, limits: &Limits) -> Result<(Ragged, String)> {
    archive.with(file, name, "x", |header, reader, at| {
        sample_shape(header, at, limits)?;
        Ok((header.read_f32(reader, at, Cap::of_samples(limits))?.into(), header.dtype.clone()))
    })
}

/// Reads targets that are stored as floats; none where they are stored otherwise. They are never taken for labels. MATLAB
/// stores labels as floats too: there they are labels.
fn read_values(
    archive: &mut Archive,
    file: &str,
    arrays: &[String],
    facts: &Facts,
    limits: &Limits,
) -> Result<Option<Values>> {
    if archive.counts_from_one() {
        return Ok(None);
    }
    let (mut all, mut width) = (vec![], None);
    for array in arrays {
        let read = archive.with(file, array, "y", |header, reader, at| {
            if !header.dtype.contains('f') {
                return Ok(None);
            }
            let shape = header.shape.clone();
            let columns = match shape[..] {
                [_] => 1,
                [_, columns] if columns > 0 => columns as usize,
                _ => {
                    return Err(Error::Shape {
                        at: at.into(),
                        shape,
                        wanted: "values are [N], or [N, k] of k quantities",
                    });
                }
            };
            Ok(Some((columns, header.read_f32(reader, at, Cap::of_labels(limits))?)))
        })?;
        let Some((columns, values)) = read else { return Ok(None) };
        if *width.get_or_insert(columns) != columns {
            let (first, second) = (arrays[0].clone(), array.clone());
            return Err(Error::Parts { file: file.into(), first, second });
        }
        all.extend(values);
    }
    let Some(width) = width else { return Ok(None) };
    Ok(Some(Values::new(quantities(facts, &arrays.join(" with "), width)?, all)))
}

/// Returns what the columns of values are: as the file of names says, or by the name of their array.
fn quantities(facts: &Facts, array: &str, width: usize) -> Result<Vec<Quantity>> {
    let numbered = |i: usize| Quantity {
        name: if width == 1 { array.to_string() } else { format!("{array}-{i}") },
        unit: None,
    };
    match &facts.quantities {
        None => Ok((0..width).map(numbered).collect()),
        Some(named) if named.len() == width => Ok(named.clone()),
        Some(named) => Err(Error::LabelsForm {
            file: facts.file.clone(),
            why: format!("names {} quantities, but {array} has {width} columns", named.len()),
        }),
    }
}

/// Labels row by row, how many a sample has, and their names where the array says them.
pub(crate) struct Labels {
    pub values: Vec<i64>,
    columns: usize,
    names: Option<Names>,
}

fn read_labels(
    archive: &mut Archive,
    file: &str,
    arrays: &[String],
    known: Option<&Names>,
    options: &ReadOptions,
    samples: usize,
) -> Result<Labels> {
    let wanted = "labels are whole numbers from 0: save y as an integer array";
    let Column { values, columns } = column(archive, file, arrays, "y", wanted, &options.limits)?;
    let columns = columns.ok_or_else(|| Error::Shape {
        at: format!("{file}: {}", arrays[0]),
        shape: archive.shape(&arrays[0]),
        wanted: "labels are [N], or [N, k] for k attributes",
    })?;
    let name = arrays.join(" with ");
    match values {
        Stored::Texts(texts) => named(texts, columns, &name, file, known),
        Stored::Numbers(values) if archive.counts_from_one() => Ok(from_one(values, columns, samples, name)),
        Stored::Numbers(values) => Ok(Labels { values, columns, names: None }),
    }
}

/// Texts as labels: positions among those that occur, or among the names of a file beside.
pub(crate) fn named(
    texts: Vec<String>,
    columns: usize,
    array: &str,
    file: &str,
    known: Option<&Names>,
) -> Result<Labels> {
    let mut values = vec![0; texts.len()];
    let mut lists = vec![];
    for column in 0..columns {
        let own: Vec<String> = texts.iter().skip(column).step_by(columns).cloned().collect();
        let places: Vec<i64> = match known.and_then(|known| Some((known, known.columns.get(column)?))) {
            None => {
                let (names, places) = by_name(own);
                lists.push(names);
                places.into_iter().map(i64::from).collect()
            }
            Some((known, names)) => {
                let place = |(row, text): (usize, &String)| {
                    let place = names.iter().position(|name| name == text);
                    place.map(|place| place as i64).ok_or_else(|| Error::LabelsForm {
                        file: known.file.clone(),
                        why: format!("does not name {text:?}, which {file}: {array}[{row}] is"),
                    })
                };
                own.iter().enumerate().map(place).collect::<Result<_>>()?
            }
        };
        values.iter_mut().skip(column).step_by(columns).zip(places).for_each(|(value, place)| *value = place);
    }
    let names = known.is_none().then(|| Names { file: array.into(), columns: lists, is_told: false });
    Ok(Labels { values, columns, names })
}

/// Numbers as MATLAB counts, from 1, as numbers from 0 that bear their own number as name.
fn from_one(mut y: Vec<i64>, columns: usize, samples: usize, array: String) -> Labels {
    if y.iter().min() != Some(&1) {
        return Labels { values: y, columns, names: None };
    }
    y.iter_mut().for_each(|label| *label -= 1);
    let names = |column: usize| match y.iter().skip(column).step_by(columns).max() {
        None => vec![],
        // Numbers that no file of so many samples can fill are named nowhere: they are refused as gaps.
        Some(last) => (0..=*last.min(&(samples as i64))).map(|label| (label + 1).to_string()).collect(),
    };
    let columns_of = (0..columns).map(names).collect();
    let names = Names { file: array, columns: columns_of, is_told: false };
    Labels { values: y, columns, names: Some(names) }
}

/// Groups and the name of their array; texts are numbered as class names are.
fn read_groups(
    archive: &mut Archive,
    file: &str,
    roles: &Roles,
    options: &ReadOptions,
) -> Result<Option<(String, Vec<i64>)>> {
    let refuse = |why| Err(Error::Option { file: file.into(), option: "group_block", why });
    let Some(arrays) = &roles.group else {
        return match options.group_block {
            None => Ok(None),
            Some(_) => refuse("needs an array to divide into blocks; name it with group = \"trial\""),
        };
    };
    let wanted = "groups are whole numbers: save them as an integer array";
    let Column { values, columns } = column(archive, file, arrays, "group", wanted, &options.limits)?;
    if columns != Some(1) || archive.is_table(&arrays[0]) {
        let (at, shape) = (format!("{file}: {}", arrays[0]), archive.shape(&arrays[0]));
        return Err(Error::Shape { at, shape, wanted: "groups are [N], one whole number per sample" });
    }
    let values = match values {
        Stored::Numbers(values) => values,
        Stored::Texts(_) if options.group_block.is_some() => {
            return refuse("divides consecutive numbers, but the groups are texts; leave it out");
        }
        Stored::Texts(texts) => by_name(texts).1.into_iter().map(i64::from).collect(),
    };
    let name = options.group.clone().unwrap_or_else(|| "group".into());
    Ok(Some((name, values)))
}

/// Marks of the samples that the authors test on, and the name of their array.
fn read_official(
    archive: &mut Archive,
    file: &str,
    options: &ReadOptions,
) -> Result<Option<(String, Vec<i64>)>> {
    let Some(name) = &options.test else {
        return match options.test_above {
            None => Ok(None),
            Some(_) => {
                let (file, why) = (file.into(), "needs the name of an array in test");
                Err(Error::Option { file, option: "test_above", why })
            }
        };
    };
    let wanted = "marks are 0 for training and 1 for testing: save them as an integer or boolean array";
    let Column { values, .. } =
        column(archive, file, std::slice::from_ref(name), "test", wanted, &options.limits)?;
    let mark = |(row, text): (usize, String)| match text.to_lowercase().as_str() {
        "train" | "training" => Ok(0),
        "test" | "testing" => Ok(1),
        _ => Err(Error::Mark { at: format!("{file}: {name}[{row}]"), text }),
    };
    let values = match values {
        Stored::Numbers(values) => values,
        Stored::Texts(texts) => texts.into_iter().enumerate().map(mark).collect::<Result<_>>()?,
    };
    Ok(Some((name.clone(), values)))
}

/// Refuses an array that is not samples `[N, ...]`, or too many of them.
pub(crate) fn sample_shape(header: &Header, at: &str, limits: &Limits) -> Result<()> {
    let shape = header.shape.clone();
    if header.is_pickled() {
        return Err(header.unsupported(at, ""));
    }
    if !(2..=4).contains(&shape.len()) {
        return Err(Error::Shape {
            at: at.into(),
            shape,
            wanted: "samples are [N, C, T], [N, H, W] or [N, T, H, W], samples first",
        });
    }
    if shape[0] > limits.max_samples {
        let limit = limits.max_samples;
        return Err(Error::TooManySamples { at: at.into(), samples: shape[0], limit });
    }
    match shape.iter().position(|axis| *axis == 0) {
        Some(0) => Err(Error::NoSamples { at: at.into() }),
        Some(axis) => Err(Error::EmptyAxis { at: at.into(), shape, axis }),
        None => Ok(()),
    }
}
