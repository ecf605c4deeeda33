//! Samples, labels and groups by name, from a file of named arrays.

use crate::dataset::labels::{as_values, by_name, group_numbers, mark_of};
use crate::dataset::one_hot::class_of;
use crate::dataset::raw::{NamedColumn, Names, Raw, SampleFacts, name_of};
use crate::dataset::spec_of::likeliest_layout;
use crate::dataset::targets::Values;
use crate::formats::archive::Archive;
use crate::formats::npy::{Cap, Header};
use crate::formats::stored::{Column, StoredValues, column, columns, parts_differ};
use crate::layout::files;
use crate::layout::listing::unsorted;
use crate::layout::names_file;
use crate::layout::roles::{Roles, SampleArrays, Unclear};
use crate::layout::sample;
use crate::length::ragged::{Collected, Ragged};
use crate::options::{Limits, ReadOptions, refuse_set};
use crate::reader::{FileFormat, Format, Place, Purpose, Reader, Sample};
use crate::{Error, Result};
use std::path::{Path, PathBuf};
use taxel_base::Layout;

/// Reads files of named arrays in one format: each is a set of samples, or one recording.
pub(crate) struct ArrayFile {
    pub format: &'static Format,
    /// The name of the file that is the whole set of its folder.
    pub inside: Option<&'static str>,
    /// The form of a recording, where files in a folder are one recording each.
    pub recording: Option<OneArray>,
    pub open: fn(&Path) -> Result<Box<Archive>>,
}

/// How messages speak of a file that is one recording.
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

    /// Reads the arrays that `options` names. Labels and groups stay as stored; `y` is empty where there are no labels.
    fn read(&self, place: &Place, options: &ReadOptions) -> Result<Raw> {
        if let Purpose::Predict { rank } = place.purpose
            && self.is_one_recording(place.path, options, rank)
        {
            return files::read(place, unsorted(vec![place.path.to_path_buf()]), options);
        }
        let path = self.set_at(place.path).unwrap_or_else(|| place.path.to_path_buf());
        let archive = &mut *(self.open)(&path)?;
        let file = archive.file().to_string();
        refuse_resize(&file, options)?;
        let (names, facts) = names_file::beside(&path, true, &options.limits)?;
        let options = &with_facts(options, &facts);
        let roles = Roles::of(&archive.saved(), options, place.needs_labels(), |y| archive.entries(y))
            .map_err(|unclear| refuse(archive, unclear))?;
        let ReadSamples { x, dtype, origins, official } =
            read_samples(archive, &roles.x, facts.layout, options)?;
        let origins = given_origins(&facts, &file, origins)?;
        let (labels, values) = match &roles.y {
            Some(arrays) => read_targets(archive, arrays, (names.as_ref(), &facts), options, x.len())?,
            None => (StoredLabels::default(), None),
        };
        let groups = read_groups(archive, &roles, options)?;
        let official = official.map_or_else(|| read_official(archive, options), |marks| Ok(Some(marks)))?;
        let (x_name, samples) = match &roles.x {
            SampleArrays::One(x) => (x.clone(), std::slice::from_ref(x)),
            SampleArrays::Split(both) => (both.join(" with "), &both[..]),
            SampleArrays::Each(each) => ("the other arrays".into(), &each[..]),
        };
        let used = roles.y.iter().chain(&roles.group).flatten().chain(&options.test).chain(samples);
        let used: Vec<&String> = used.collect();
        let others = archive.arrays().into_iter().filter(|name| !used.contains(&name)).collect();
        let y_name = roles.y.map_or_else(|| options.y().to_string(), |arrays| arrays.join(" with "));
        Ok(Raw {
            name: name_of(&path),
            file,
            dtype,
            x_name,
            y_name,
            y: labels.values,
            columns: labels.columns,
            names: names.or(labels.names),
            values,
            facts,
            groups,
            official,
            x,
            origins,
            others,
            ..Raw::default()
        })
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

    fn hint(&self) -> &'static str {
        self.recording.as_ref().map_or("", |one| one.hint)
    }

    fn takes_option(&self, option: &str) -> bool {
        option == "x"
    }

    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Sample> {
        let mut archive = (self.open)(path)?;
        let held = archive.recordings();
        let name = match held.as_slice() {
            [one] => one.clone(),
            _ if held.iter().any(|name| name == options.x()) => options.x().to_string(),
            _ => {
                let described = archive.described();
                return Err(Error::missing(archive.file(), options.x(), &described, "x"));
            }
        };
        archive.with(&name, "x", |header, reader, at| sample::one(header, reader, at, &options.limits))
    }
}

impl ArrayFile {
    /// Returns the file of arrays at a path: itself, or the one in the folder.
    fn set_at(&self, path: &Path) -> Option<PathBuf> {
        if self.format.names(path) && path.is_file() {
            return Some(path.to_path_buf());
        }
        self.inside.map(|name| path.join(name)).filter(|path| path.is_file())
    }

    /// Checks whether a file holds one recording of `rank` axes and not a set of them.
    fn is_one_recording(&self, path: &Path, options: &ReadOptions, rank: usize) -> bool {
        if self.recording.is_none() {
            return false;
        }
        let Ok(mut archive) = (self.open)(path) else { return false };
        match Roles::of(&archive.saved(), options, false, |labels| archive.entries(labels)) {
            Ok(Roles { x: SampleArrays::One(x), y: None, .. }) => archive.shape(&x).len() == rank,
            Ok(_) => false,
            Err(_) => true,
        }
    }
}

fn refuse_resize(file: &str, options: &ReadOptions) -> Result<()> {
    let why = "applies to a folder of PNG or JPEG files only; leave it out";
    refuse_set(file, &[("resize", options.resize.is_some())], why)
}

/// Takes from the file of names which arrays are groups and marks, where the options do not say it.
fn with_facts(options: &ReadOptions, facts: &SampleFacts) -> ReadOptions {
    let options = options.clone();
    let or = |given: Option<String>, fact: &Option<String>| given.or_else(|| fact.clone());
    let (group, test) = (or(options.group, &facts.group_array), or(options.test, &facts.test_array));
    ReadOptions { group, test, ..options }
}

/// Returns the origins of samples that the file of names gives, or else the numbered ones.
fn given_origins(facts: &SampleFacts, file: &str, numbered: Vec<String>) -> Result<Vec<String>> {
    match &facts.origins {
        None => Ok(numbered),
        Some(given) if given.len() == numbered.len() => Ok(given.clone()),
        Some(given) => Err(Error::Length {
            file: file.into(),
            array: format!("origins of {}", facts.file),
            len: given.len(),
            x: "x".into(),
            samples: numbered.len(),
        }),
    }
}

/// Says what the file holds, where a role is unclear.
fn refuse(archive: &mut Archive, unclear: Unclear) -> Error {
    let Unclear { array, option, several } = unclear;
    let (file, held) = (archive.file().to_string(), archive.described());
    if several.is_empty() {
        return Error::missing(&file, &array, &held, option);
    }
    let (several, held) = (several.join(", "), held.join(", "));
    let how = format!("name yours with {option} = \"...\": it holds {held}");
    Error::file(file, format!("{several} could each be {option}; {how}"))
}

/// Samples with their stored type and origins, and the marks of those that the file itself keeps for testing.
struct ReadSamples {
    x: Ragged,
    dtype: String,
    origins: Vec<String>,
    official: Option<NamedColumn>,
}

fn read_samples(
    archive: &mut Archive,
    samples: &SampleArrays,
    layout: Option<Layout>,
    options: &ReadOptions,
) -> Result<ReadSamples> {
    let numbered = |name: &str, x: &Ragged| (0..x.len()).map(|i| format!("{name}[{i}]")).collect::<Vec<_>>();
    // Samples `[N, ...]` without an empty axis, and their stored type.
    let read_array = |archive: &mut Archive, name: &str| {
        archive.with(name, "x", |header, reader, at| {
            sample_shape(header, at, &options.limits)?;
            let x = Ragged::from(header.read_f32(reader, at, Cap::of_samples(&options.limits))?);
            Ok((x, header.dtype.clone()))
        })
    };
    match samples {
        SampleArrays::One(name) => {
            let (x, dtype) = read_array(archive, name)?;
            Ok(ReadSamples { origins: numbered(name, &x), x, dtype, official: None })
        }
        SampleArrays::Split([train, test]) => {
            let why = "names a split, but the file has its own, a training and a test array; leave it out";
            refuse_set(archive.file(), &[("test", options.test.is_some())], why)?;
            let (x, dtype) = read_array(archive, train)?;
            let (tested, _) = read_array(archive, test)?;
            let origins = [numbered(train, &x), numbered(test, &tested)].concat();
            let marks = [vec![0; x.len()], vec![1; tested.len()]].concat();
            let x = x.joined(tested).map_err(|[first_shape, shape]| Error::SampleShape {
                file: archive.at(test),
                shape,
                first: train.clone(),
                first_shape,
                hint: "; training and test samples are of one shape",
            })?;
            Ok(ReadSamples { x, dtype, origins, official: Some((test.clone(), marks)) })
        }
        SampleArrays::Each(names) => {
            let mut collected = Collected::new(archive.file(), options.limits);
            let mut dtype = String::new();
            for name in names {
                let sample = archive
                    .with(name, "x", |header, reader, at| sample::one(header, reader, at, &options.limits))?;
                let time = likeliest_layout([options.layout, layout, None], &sample.dtype, &sample.shape)
                    .time_axis();
                let at = archive.at(name);
                collected.push(&at, &sample.shape, &sample.values, time, " but for time")?;
                if dtype.is_empty() {
                    dtype = sample.dtype;
                }
            }
            let x = collected.finish().ok_or_else(|| Error::NoSamples { at: archive.file().into() })?;
            Ok(ReadSamples { x, dtype, origins: names.clone(), official: None })
        }
    }
}

/// Reads labels or, in their place, values.
fn read_targets(
    archive: &mut Archive,
    arrays: &[String],
    (names, facts): (Option<&Names>, &SampleFacts),
    options: &ReadOptions,
    samples: usize,
) -> Result<(StoredLabels, Option<Values>)> {
    // Who names classes or attributes means labels, however they are stored.
    let is_labelled = names.is_some() || options.attribute.is_some() || !options.attributes.is_empty();
    if is_labelled {
        return Ok((read_labels(archive, arrays, names, options, samples)?, None));
    }
    if let Some(values) = read_values(archive, arrays, facts, &options.limits)? {
        return Ok((StoredLabels::default(), Some(values)));
    }
    let labels = read_labels(archive, arrays, names, options, samples)?;
    let one = labels.names.as_ref().filter(|_| labels.columns == 1);
    let Some(numbers) = one.and_then(|names| as_values(&names.columns[0])) else { return Ok((labels, None)) };
    let values = labels.values.iter().map(|label| numbers[*label as usize]).collect();
    let quantities = names_file::quantities(facts, &arrays.join(" with "), 1)?;
    Ok((StoredLabels::default(), Some(Values::new(quantities, values))))
}

/// Reads targets that are stored as floats; none where they are stored otherwise or are one-hot. MATLAB stores labels
/// as floats too: there they are labels.
fn read_values(
    archive: &mut Archive,
    arrays: &[String],
    facts: &SampleFacts,
    limits: &Limits,
) -> Result<Option<Values>> {
    if archive.counts_from_one() {
        return Ok(None);
    }
    let (mut all, mut width) = (vec![], None);
    for array in arrays {
        let read = archive.with(array, "y", |header, reader, at| {
            if !header.dtype.contains('f') {
                return Ok(None);
            }
            let Some(columns) = columns(&header.shape) else {
                let (at, shape) = (at.into(), header.shape.clone());
                return Err(Error::Shape { at, shape, wanted: "values are [N], or [N, k] of k quantities" });
            };
            Ok(Some((columns, header.read_f32(reader, at, Cap::of_labels(limits))?)))
        })?;
        let Some((columns, values)) = read else { return Ok(None) };
        if *width.get_or_insert(columns) != columns {
            return Err(parts_differ(archive, arrays, array));
        }
        all.extend(values);
    }
    // Many frameworks store one-hot classes as floats; who names quantities means values.
    let is_one_hot = |width: usize| width > 1 && all.chunks_exact(width).all(|row| class_of(row).is_some());
    let is_values = |width: &usize| facts.quantities.is_some() || !is_one_hot(*width);
    let Some(width) = width.filter(is_values) else { return Ok(None) };
    Ok(Some(Values::new(names_file::quantities(facts, &arrays.join(" with "), width)?, all)))
}

/// Labels row by row, the number of columns, and their names where the array says them.
pub(crate) struct StoredLabels {
    pub values: Vec<i64>,
    columns: usize,
    names: Option<Names>,
}

impl Default for StoredLabels {
    /// Returns no labels, in one column.
    fn default() -> Self {
        Self { values: vec![], columns: 1, names: None }
    }
}

fn read_labels(
    archive: &mut Archive,
    arrays: &[String],
    known: Option<&Names>,
    options: &ReadOptions,
    samples: usize,
) -> Result<StoredLabels> {
    let wanted = "labels are whole numbers from 0: save y as an integer array";
    let Column { values, columns } = column(archive, arrays, "y", wanted, &options.limits)?;
    let columns = columns.ok_or_else(|| Error::Shape {
        at: archive.at(&arrays[0]),
        shape: archive.shape(&arrays[0]),
        wanted: "labels are [N], or [N, k] for k attributes",
    })?;
    let name = arrays.join(" with ");
    match values {
        StoredValues::Texts(texts) => named(texts, columns, &name, archive.file(), known),
        StoredValues::Numbers(values) if archive.counts_from_one() => {
            Ok(from_one(values, columns, samples, name))
        }
        StoredValues::Numbers(values) => Ok(StoredLabels { values, columns, names: None }),
    }
}

/// Turns texts into labels: positions among those that occur, or among the names of a file beside.
pub(crate) fn named(
    texts: Vec<String>,
    columns: usize,
    array: &str,
    file: &str,
    known: Option<&Names>,
) -> Result<StoredLabels> {
    let mut values = vec![0; texts.len()];
    let mut lists = vec![];
    for column in 0..columns {
        let texts: Vec<String> = texts.iter().skip(column).step_by(columns).cloned().collect();
        let places: Vec<i64> = match known.and_then(|known| Some((known, known.columns.get(column)?))) {
            None => {
                let (names, places) = by_name(texts);
                lists.push(names);
                places.into_iter().map(i64::from).collect()
            }
            Some((known, names)) => {
                let place = |(row, text): (usize, &String)| {
                    let place = names.iter().position(|name| name == text);
                    place.map(|place| place as i64).ok_or_else(|| {
                        let why = format!("does not name {text:?}, which {file}: {array}[{row}] is");
                        Error::labels_form(&known.file, why)
                    })
                };
                texts.iter().enumerate().map(place).collect::<Result<_>>()?
            }
        };
        values.iter_mut().skip(column).step_by(columns).zip(places).for_each(|(value, place)| *value = place);
    }
    let names = known.is_none().then(|| Names { file: array.into(), columns: lists, is_given: false });
    Ok(StoredLabels { values, columns, names })
}

/// Turns numbers that MATLAB counts from 1 into numbers from 0, with the old number as name.
fn from_one(mut y: Vec<i64>, columns: usize, samples: usize, array: String) -> StoredLabels {
    if y.iter().min() != Some(&1) {
        return StoredLabels { values: y, columns, names: None };
    }
    y.iter_mut().for_each(|label| *label -= 1);
    let names = |column: usize| match y.iter().skip(column).step_by(columns).max() {
        None => vec![],
        // More names than samples are never needed: larger numbers are refused as gaps.
        Some(last) => (0..=*last.min(&(samples as i64))).map(|label| (label + 1).to_string()).collect(),
    };
    let columns_of = (0..columns).map(names).collect();
    let names = Names { file: array, columns: columns_of, is_given: false };
    StoredLabels { values: y, columns, names: Some(names) }
}

/// Reads groups and the name of their array; texts are numbered as class names are.
fn read_groups(archive: &mut Archive, roles: &Roles, options: &ReadOptions) -> Result<Option<NamedColumn>> {
    let file = archive.file().to_string();
    let refuse = |why| Err(Error::Option { file: file.clone(), option: "group_block", why });
    let Some(arrays) = &roles.group else {
        return match options.group_block {
            None => Ok(None),
            Some(_) => refuse("needs an array to divide into blocks; name it with group = \"trial\""),
        };
    };
    let wanted = "groups are whole numbers: save them as an integer array";
    let Column { values, columns } = column(archive, arrays, "group", wanted, &options.limits)?;
    // A matrix of one column is a table, but of MATLAB, which has no vectors.
    let is_table = |header: Header| header.as_column().shape.len() != 1 && !header.matlab;
    if columns != Some(1) || archive.header(&arrays[0]).is_some_and(is_table) {
        let (at, shape) = (archive.at(&arrays[0]), archive.shape(&arrays[0]));
        return Err(Error::Shape { at, shape, wanted: "groups are [N], one whole number per sample" });
    }
    let values = match values {
        StoredValues::Numbers(values) => values,
        StoredValues::Texts(_) if options.group_block.is_some() => {
            return refuse("divides consecutive numbers, but the groups are texts; leave it out");
        }
        StoredValues::Texts(texts) => group_numbers(texts).map_err(|why| Error::file(&file, why))?,
    };
    let name = options.group.clone().unwrap_or_else(|| "group".into());
    Ok(Some((name, values)))
}

/// Reads the marks of the samples that the authors test on, and the name of their array.
fn read_official(archive: &mut Archive, options: &ReadOptions) -> Result<Option<NamedColumn>> {
    let Some(name) = &options.test else {
        let set = [("test_above", options.test_above.is_some())];
        return refuse_set(archive.file(), &set, "needs the name of an array in test").map(|()| None);
    };
    let wanted = "marks are 0 for training and 1 for testing: save them as an integer or boolean array";
    let Column { values, .. } = column(archive, std::slice::from_ref(name), "test", wanted, &options.limits)?;
    let mark = |(row, text): (usize, String)| {
        let why = || format!("is {text:?}; marks are train and test, or 0 and 1");
        mark_of(&text).ok_or_else(|| Error::file(format!("{}[{row}]", archive.at(name)), why()))
    };
    let values = match values {
        StoredValues::Numbers(values) => values,
        StoredValues::Texts(texts) => texts.into_iter().enumerate().map(mark).collect::<Result<_>>()?,
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
    limits.refuse_samples(at, shape[0])?;
    match shape.iter().position(|axis| *axis == 0) {
        Some(0) => Err(Error::NoSamples { at: at.into() }),
        Some(axis) => Err(Error::EmptyAxis { at: at.into(), shape, axis }),
        None => Ok(()),
    }
}
