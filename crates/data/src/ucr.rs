//! Time series of the UCR and UEA archives: `<name>_TRAIN` and `<name>_TEST`, as `.ts` or plain text.

use crate::hash::hash_row;
use crate::labels::by_name;
use crate::options::{Options, refuse_set};
use crate::raw::{Names, Raw};
use crate::text::read_text;
use crate::{Error, Result, names_file};
use ndarray::ArrayD;
use std::path::{Path, PathBuf};
use taxel_encodings::Layout;

/// The endings that are tried, in this order.
const ENDINGS: [&str; 4] = ["ts", "tsv", "txt", ""];

/// One series as written: class name and channels.
struct Case {
    class: String,
    channels: Vec<Vec<f32>>,
}

/// The two files of the data set that `path` names: `GunPoint`, `GunPoint_TRAIN.ts` or `GunPoint_TEST.ts`.
pub(crate) fn find(path: &Path) -> Option<[PathBuf; 2]> {
    let name = path.file_name()?.to_str()?;
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let base = stem.strip_suffix("_TRAIN").or_else(|| stem.strip_suffix("_TEST")).unwrap_or(name);
    ENDINGS.iter().find_map(|ending| {
        let file = |part: &str| {
            let dot = if ending.is_empty() { "" } else { "." };
            path.with_file_name(format!("{base}_{part}{dot}{ending}"))
        };
        let both = [file("TRAIN"), file("TEST")];
        both.iter().all(|file| file.is_file()).then_some(both)
    })
}

/// Reads both files: samples `[N, channels, length]`, the training ones first, and the official split.
///
/// - `.ts`: lines with `#` or `@` are head, then one case a line: channels and at last the class, parted by
///   `:`; values by `,`.
/// - other endings: one case a line, its class first, parted by blanks, tabs or commas; one channel.
pub(crate) fn read(path: &Path, files: &[PathBuf; 2], options: &Options) -> Result<Raw> {
    let file = path.display().to_string();
    refuse_options(&file, options)?;
    let Cases { cases, shape, origins, test } = read_both(files, options)?;
    let (mut classes, mut y) = by_name(cases.iter().map(|case| case.class.clone()).collect());
    let rows: Vec<Vec<f32>> = cases.into_iter().map(|case| case.channels.concat()).collect();
    let row_hash = rows.iter().map(|row| hash_row(row)).collect();
    let full = [vec![rows.len()], shape].concat();
    let x = ArrayD::from_shape_vec(full, rows.concat())
        .map_err(|e| Error::NotAnArray { at: file.clone(), why: e.to_string() })?;
    #[expect(clippy::expect_used, reason = "find() took the names of the files from that of the path")]
    let name = path.file_name().expect("a path with a name").to_string_lossy();
    let name = name.split_once("_TRAIN").map_or(&*name, |(before, _)| before);
    let name = name.split_once("_TEST").map_or(name, |(before, _)| before);
    let beside = [format!("{name}.classes.json"), "labels.json".into()].map(|own| path.with_file_name(own));
    let (order, facts) = names_file::of_named(&beside, &classes, &options.limits)?;
    if let Some(order) = order {
        y = y.into_iter().map(|label| position(&order, label)).collect();
        classes = order.iter().map(|class| classes[*class].clone()).collect();
    }
    Ok(Raw {
        name: name.to_string(),
        dtype: "text".into(),
        format: Some(Layout::Series),
        x,
        x_name: "the series".into(),
        y_name: "the classes".into(),
        y: y.into_iter().map(i64::from).collect(),
        columns: 1,
        names: Some(Names { file: file.clone(), columns: vec![classes], is_told: true }),
        facts,
        groups: None,
        official: Some(("the _TEST file".into(), test)),
        origins,
        row_hash,
        others: vec![],
        is_folder: false,
        file,
    })
}

/// Where a label comes in another order.
fn position(order: &[usize], label: u32) -> u32 {
    order.iter().position(|class| *class == label as usize).map_or(label, |at| at as u32)
}

/// The cases of both files, all of one shape `[channels, length]`.
struct Cases {
    cases: Vec<Case>,
    shape: Vec<usize>,
    /// File and position of each.
    origins: Vec<String>,
    /// 0 for training, 1 for testing.
    test: Vec<i64>,
}

fn read_both(files: &[PathBuf; 2], options: &Options) -> Result<Cases> {
    let (mut cases, mut origins, mut test) = (vec![], vec![], vec![]);
    let mut first: Option<(String, Vec<usize>)> = None;
    for (part, path) in files.iter().enumerate() {
        let name = path.display().to_string();
        let text = read_text(path, &options.limits)?;
        let is_ts = path.extension().is_some_and(|ending| ending == "ts");
        let own = if is_ts { read_ts(&text, &name)? } else { read_plain(&text, &name)? };
        if own.is_empty() {
            return Err(Error::NoSamples { at: name });
        }
        #[expect(clippy::expect_used, reason = "find() made the path with a name")]
        let short = path.file_name().expect("a path with a name").to_string_lossy().into_owned();
        for (i, case) in own.into_iter().enumerate() {
            let at = format!("{short}[{i}]");
            let shape = vec![case.channels.len(), case.channels[0].len()];
            let even = case.channels.iter().all(|channel| channel.len() == shape[1]);
            let (first, first_shape) = first.get_or_insert_with(|| (at.clone(), shape.clone()));
            if shape != *first_shape || !even {
                return Err(Error::SampleShape {
                    file: at,
                    shape: case.channels.iter().map(Vec::len).collect(),
                    first: first.clone(),
                    first_shape: first_shape.clone(),
                    hint: "; series of unequal length are not supported, cut or resample them",
                });
            }
            origins.push(at);
            test.push(part as i64);
            cases.push(case);
        }
    }
    #[expect(clippy::expect_used, reason = "a file without a case was refused")]
    let (_, shape) = first.expect("a case at least");
    Ok(Cases { cases, shape, origins, test })
}

fn refuse_options(file: &str, options: &Options) -> Result<()> {
    let default = Options::default();
    let set = [
        ("x", options.x != default.x),
        ("y", options.y != default.y),
        ("group", options.group.is_some()),
        ("group-block", options.group_block.is_some()),
        ("resize", options.resize.is_some()),
        ("test", options.test.is_some()),
        ("test-above", options.test_above.is_some()),
    ];
    let why = "does not apply to a pair of _TRAIN and _TEST files; leave it out";
    refuse_set(file, &set, why)
}

fn number(text: &str, file: &str, line: usize, column: usize) -> Result<f32> {
    text.trim().parse().map_err(|_| Error::CsvNumber {
        file: file.into(),
        line: line as u64,
        column,
        text: text.chars().take(40).collect(),
        hint: if text.trim() == "?" { "; series with missing values are not supported" } else { "" },
    })
}

fn read_ts(text: &str, file: &str) -> Result<Vec<Case>> {
    let mut cases = vec![];
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        if line.is_empty() || line.starts_with(['#', '@', '%']) {
            continue;
        }
        let mut parts: Vec<&str> = line.split(':').collect();
        let class = parts.pop().unwrap_or_default().trim().to_string();
        if parts.is_empty() || class.is_empty() {
            let (file, line) = (file.into(), i as u64);
            return Err(Error::NoClass { file, line });
        }
        let mut column = 0;
        let channel = |part: &&str| -> Result<Vec<f32>> {
            let mut value = |text: &str| {
                column += 1;
                number(text, file, i, column)
            };
            part.split(',').map(&mut value).collect()
        };
        cases.push(Case { class, channels: parts.iter().map(channel).collect::<Result<_>>()? });
    }
    Ok(cases)
}

fn read_plain(text: &str, file: &str) -> Result<Vec<Case>> {
    let mut cases = vec![];
    for (i, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        let mut fields = line.split([' ', '\t', ',']).filter(|field| !field.is_empty());
        let Some(class) = fields.next() else { continue };
        let values = fields.enumerate().map(|(column, text)| number(text, file, i, column + 2));
        let values: Vec<f32> = values.collect::<Result<_>>()?;
        if values.is_empty() {
            return Err(Error::NoClass { file: file.into(), line: i as u64 });
        }
        // Classes written as 1.0000000e+00 are the class 1.
        let class = class.parse::<f64>().map_or_else(|_| class.to_string(), |number| number.to_string());
        cases.push(Case { class, channels: vec![values] });
    }
    Ok(cases)
}
