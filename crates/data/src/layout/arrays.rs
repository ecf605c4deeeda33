//! Samples, labels and groups by name, from a file of named arrays.

use crate::dataset::labels::{group_numbers, mark_of};
use crate::dataset::raw::{NamedColumn, Raw, SampleFacts, name_of};
use crate::dataset::spec_of::likeliest_layout;
use crate::formats::archive::Archive;
use crate::formats::npy::{Cap, Header};
use crate::formats::stored::{Column, StoredValues, column};
use crate::layout::array_targets::{ArrayTargets, TargetArrays};
use crate::layout::files;
use crate::layout::listing::unsorted;
use crate::layout::names_file;
use crate::layout::readings::Readings;
use crate::layout::resting::tare_by_array;
use crate::layout::roles::{Roles, SampleArrays, Unclear};
use crate::layout::sample;
use crate::length::ragged::{Collected, Ragged};
use crate::options::{Limits, ReadOptions, refuse_set};
use crate::reader::{FileFormat, Format, Place, Purpose, Reader, Sample};
use crate::tare::Tare;
use crate::targets::steps::StepTargets;
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
        options.refuse_targets(&file)?;
        let (names, facts) = names_file::beside(&path, true, &options.limits)?;
        let options = &with_facts(options, &facts);
        let roles = Roles::of(&archive.saved(), options, place.needs_labels(), |y| archive.entries(y))
            .map_err(|unclear| refuse(archive, unclear))?;
        let ReadSamples { mut x, dtype, origins, official } =
            read_samples(archive, &roles.x, facts.layout, options)?;
        let tared = options.tare.clone().filter(|tare| tare.array().is_some());
        if let Some(Tare::Array(rest)) = &tared {
            x = tare_by_array(x, rest, facts.layout, &dtype, archive, options)?;
        }
        let samples = x.len();
        let stored = roles.y.as_ref().map(|arrays| {
            let names = names.as_ref();
            TargetArrays { arrays, names, facts: &facts, options, samples }.read(archive)
        });
        let targets = stored.transpose()?.unwrap_or_default();
        let read_as = could_be_steps(&x, &dtype, &facts, &targets, options).into_iter().collect();
        let groups = read_groups(archive, &roles, options)?;
        let official = official.map_or_else(|| read_official(archive, options), |marks| Ok(Some(marks)))?;
        let y_name = roles.y_name().unwrap_or_else(|| options.y());
        let ArrayTargets { labels, values, steps } = targets;
        let change = format!("{y_name} holds a target for each time step");
        let raw = Raw {
            name: name_of(&path),
            file,
            dtype,
            x_name: roles.x_name(),
            y_name,
            y: labels.values,
            columns: labels.columns,
            names: names.or(labels.names),
            values,
            steps: steps.map(|steps| StepTargets { steps: vec![steps; samples], change }),
            tared,
            facts,
            groups,
            official,
            x,
            origins,
            others: others(archive, &roles, options),
            read_as,
            ..Raw::default()
        };
        match Readings::of(archive, &raw, options, place)? {
            Some(readings) => readings.joined(raw),
            None => Ok(Raw { origins: origins_of_samples(&raw)?, ..raw }),
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
        // Rows are readings, which have an axis less.
        if options.recording.is_some() {
            return false;
        }
        match Roles::of(&archive.saved(), options, false, |labels| archive.entries(labels)) {
            Ok(Roles { x: SampleArrays::One(x), y: None, .. }) => archive.shape(&x).len() == rank,
            Ok(_) => false,
            Err(_) => true,
        }
    }
}

/// Lists the arrays without a role.
fn others(archive: &Archive, roles: &Roles, options: &ReadOptions) -> Vec<String> {
    let samples = match &roles.x {
        SampleArrays::One(x) => std::slice::from_ref(x),
        SampleArrays::Split(both) => &both[..],
        SampleArrays::Each(each) => &each[..],
    };
    let of_y = roles.y.iter().flatten().flatten();
    let tared = options.tare.as_ref().and_then(Tare::array);
    let named =
        of_y.chain(roles.group.iter().flatten()).chain(&options.test).chain(&options.recording).chain(tared);
    let used: Vec<&String> = named.chain(samples).collect();
    archive.arrays().into_iter().filter(|name| !used.contains(&name)).collect()
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
fn origins_of_samples(raw: &Raw) -> Result<Vec<String>> {
    match &raw.facts.origins {
        Some(given) if given.len() != raw.origins.len() => Err(Error::Length {
            file: raw.file.clone(),
            array: format!("origins of {}", raw.facts.file),
            len: given.len(),
            x: "x".into(),
            samples: raw.origins.len(),
        }),
        Some(given) => Ok(given.clone()),
        None => Ok(raw.origins.clone()),
    }
}

/// Says how values `[N, T]` beside recordings of T time steps are read, and how else they could be.
fn could_be_steps(
    x: &Ragged,
    dtype: &str,
    facts: &SampleFacts,
    targets: &ArrayTargets,
    options: &ReadOptions,
) -> Option<String> {
    let layout = likeliest_layout([options.layout, facts.layout, None], dtype, x.sample_shape());
    let steps = x.sample_shape()[layout.time_axis()?];
    let columns = targets.values.as_ref()?.quantities().len();
    let is_open = columns == steps && columns > 1 && targets.steps.is_none();
    let is_open =
        is_open && options.target.is_none() && options.y_names().len() < 2 && facts.quantities.is_none();
    is_open.then(|| {
        format!(
            "a row of targets as {columns} quantities of the recording; if it is the target of each of its {steps} time \
             steps, say target = \"step\" (--target step)"
        )
    })
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
            let x = Ragged::from(header.read_f32(reader, at, Cap::of_samples(&options.limits), 1)?);
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
