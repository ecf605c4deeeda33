//! Reads the table of classes of a folder of recordings: `labels.csv` with `file,label[,group]`.

use crate::dataset::labels::{by_name, group_numbers};
use crate::formats::bag::path::is_bag;
use crate::formats::csv_text::CsvText;
use crate::formats::text::csv_reader;
use crate::layout::listing::{FoundFiles, Listing};
use crate::options::ReadOptions;
use crate::{Error, Result};
use std::collections::{HashMap, HashSet};
use std::path::{Component, Path, PathBuf};

/// Name of the table.
pub(crate) const LABELS: &str = "labels.csv";

/// Reads the table of the folder `root`: a header, then a row per recording, its path below the folder, its
/// class and, where there is such a column, its group. Other columns are for people.
///
/// Columns `start` and `end` cut bags into parts: seconds from its first message, the end not included.
///
/// The columns `label` and `group` may bear other names: [`ReadOptions::y`] and [`ReadOptions::group`].
pub(crate) fn read(root: &Path, top: &Listing, options: &ReadOptions) -> Result<FoundFiles> {
    let path = root.join(LABELS);
    let file = path.display().to_string();
    let refuse = |why: String| {
        Error::file(
            &path,
            format!("{why}; write a first line file,label or file,label,group and a line per recording"),
        )
    };
    let table = CsvText::read_list(&path, &options.limits)?;
    let mut reader = csv_reader(&table.text, table.separator(), true);
    let csv = Error::csv(&file);
    let columns = LabelTableColumns::of(reader.headers().map_err(&csv)?, options).map_err(refuse)?;
    let mut rows = LabelRows::default();
    for record in reader.records() {
        rows.add(root, &columns, &record.map_err(&csv)?).map_err(refuse)?;
    }
    if rows.files.is_empty() {
        return Err(refuse("has no rows".into()));
    }
    let mut found = rows.found(columns).map_err(refuse)?;
    found.read_as.extend(table.left_out.iter().cloned());
    let listed: HashSet<&PathBuf> = found.files.iter().collect();
    let unlisted: Vec<_> =
        top.files.iter().filter(|file| **file != path && !listed.contains(file)).cloned().collect();
    found.pass_over(root, top.ignored.iter().cloned().chain(unlisted));
    Ok(found)
}

/// The columns of the table.
struct LabelTableColumns {
    header: csv::StringRecord,
    file: usize,
    /// Labels, or values of several quantities.
    labels: Vec<usize>,
    group: Option<(usize, String)>,
    /// Start and end of parts of bags.
    span: Option<(usize, usize)>,
}

impl LabelTableColumns {
    /// Finds the columns by their names, or says which is missing.
    fn of(header: &csv::StringRecord, options: &ReadOptions) -> Result<Self, String> {
        let place = |name: &str| header.iter().position(|column| column.eq_ignore_ascii_case(name));
        let needed = |name: &str| {
            let held =
                || format!("has no column {name}: its first line is {:?}", header.iter().collect::<Vec<_>>());
            place(name).ok_or_else(held)
        };
        Ok(Self {
            file: needed("file")?,
            labels: if options.names_y() {
                options.y_names().iter().map(|name| needed(name)).collect::<Result<_, _>>()?
            } else {
                vec![needed("label")?]
            },
            group: match &options.group {
                Some(name) => Some((needed(name)?, name.clone())),
                None => place("group").map(|at| (at, "group".to_string())),
            },
            span: place("start").zip(place("end")),
            header: header.clone(),
        })
    }
}

/// The content of the table.
#[derive(Default)]
struct LabelRows {
    files: Vec<PathBuf>,
    /// Of each column of labels, row by row.
    labels: Vec<String>,
    groups: Vec<String>,
    spans: Vec<[f64; 2]>,
    /// Line of each row.
    order: Vec<u64>,
    /// Line of each recording, or part of one.
    lines: HashMap<(PathBuf, String), u64>,
}

impl LabelRows {
    /// Adds a row, or says what is wrong with it.
    fn add(
        &mut self,
        root: &Path,
        columns: &LabelTableColumns,
        record: &csv::StringRecord,
    ) -> Result<(), String> {
        let line = record.position().map_or(0, csv::Position::line);
        let field = |at: usize| record.get(at).unwrap_or_default();
        let file = recording(root, field(columns.file)).map_err(|why| format!("line {line}: {why}"))?;
        let span = columns.span.filter(|_| is_bag(&file)).map(|(start, end)| [field(start), field(end)]);
        let part = span.map_or(String::new(), |span| span.join(" to "));
        if let Some(first) = self.lines.insert((file.clone(), part), line) {
            return Err(format!("lines {first} and {line} are both {:?}", field(columns.file)));
        }
        if let Some(span) = span {
            self.spans.push(seconds(span).map_err(|why| format!("line {line}: {why}"))?);
        }
        let group = columns.group.as_ref().map(|(at, _)| *at);
        if let Some(at) = group.filter(|at| field(*at).is_empty()) {
            return Err(format!("line {line}: {} is empty", &columns.header[at]));
        }
        self.files.push(file);
        self.labels.extend(columns.labels.iter().map(|at| field(*at).to_string()));
        self.order.push(line);
        self.groups.extend(group.map(|at| field(at).to_string()));
        Ok(())
    }

    /// Returns the recordings with labels and groups as numbers.
    fn found(self, columns: LabelTableColumns) -> Result<FoundFiles, String> {
        let Self { files, labels: texts, groups, spans, order, .. } = self;
        let numbers = |values: Vec<u32>| values.into_iter().map(i64::from).collect();
        // Several columns make no class.
        let (classes, labels) =
            if columns.labels.len() == 1 { by_name(texts.clone()) } else { (vec![], vec![]) };
        let target_names = columns.labels.iter().map(|at| columns.header[*at].to_string()).collect();
        let groups = columns.group.map(|(_, name)| Ok::<_, String>((name, group_numbers(groups)?)));
        Ok(FoundFiles {
            positions: (0..files.len() as i64).collect(),
            labels: numbers(labels),
            classes,
            texts,
            target_names,
            lines: order,
            groups: groups.transpose()?,
            labelled_by: LABELS,
            is_table: true,
            // Either all bags are cut into parts or none.
            spans: Some(spans).filter(|spans| spans.len() == files.len()),
            files,
            ..FoundFiles::default()
        })
    }
}

/// Reads start and end of a part of a bag, or says what is wrong with them.
fn seconds(span: [&str; 2]) -> Result<[f64; 2], String> {
    let part = span.join(" to ");
    let [Some(start), Some(end)] = span.map(|text| text.parse::<f64>().ok()) else {
        return Err(format!("start and end are {part:?}, not two numbers of seconds"));
    };
    if start.partial_cmp(&end) != Some(std::cmp::Ordering::Less) {
        return Err(format!("end is not after start ({part} s)"));
    }
    Ok([start, end])
}

/// Returns the file that a row names, which lies below `root`.
fn recording(root: &Path, name: &str) -> Result<PathBuf, String> {
    let inside =
        Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if name.is_empty() || !inside {
        return Err(format!("file is {name:?}; give a path below the folder of the table"));
    }
    let path = root.join(Path::new(name).components().collect::<PathBuf>());
    let is_there = path.is_file() || is_bag(&path);
    is_there.then_some(path).ok_or_else(|| format!("there is no file {name:?} in the folder of the table"))
}
