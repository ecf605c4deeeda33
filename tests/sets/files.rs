//! Writes a set in every form that taxel reads, one for each line of the table of formats and each of its endings.

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, ImageFormat, RgbImage};
use serde_json::{Value, json};
use taxel::Layout;
use taxel::data::npy_bytes;

use super::arrays::{Array, archive};
use super::writers::{self, Cdr, Column, Definition};
use super::{Cell, Set};

/// Says where the class of a recording stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// `class/file`.
    Class,
    /// `class/session/file`.
    Session,
    /// `labels.csv`.
    Table,
    /// `class_01.mcap`.
    Name,
    /// `train/class/file` and `test/class/file`.
    Parts,
}

/// Says how a set lies on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Arrays `x`, `y`, `group` and `marks` in one file.
    Arrays(&'static str),
    /// `x_train`, `x_test` and their labels in one NumPy archive.
    Halves,
    /// A file per recording.
    Files(&'static str, By),
    /// A bag per recording, of images.
    Pictures(By),
    /// A row per sample.
    Wide(&'static str),
    /// A row per time step.
    Long(&'static str),
    /// A pair of `_TRAIN` and `_TEST` files.
    Pair(&'static str),
    LeRobot,
}

/// Says how numbers stand in a text.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    pub separator: char,
    pub point: char,
    /// Follows each number of a channel.
    pub unit: &'static str,
    /// Columns have another order in each file, keys in each line.
    pub is_turned: bool,
}

impl Style {
    pub fn of(form: Form) -> Self {
        let is_tsv = matches!(form, Form::Wide("tsv") | Form::Long("tsv"));
        Self { separator: if is_tsv { '\t' } else { ',' }, point: '.', unit: "", is_turned: false }
    }

    fn cell(&self, cell: &Cell) -> String {
        let text = match cell {
            Cell::Value(value) => {
                format!("{}{}", number(*value).replace('.', &self.point.to_string()), self.unit)
            }
            Cell::Count(count) => count.to_string(),
            Cell::Text(text) => text.clone(),
        };
        if text.contains(self.separator) { format!("\"{text}\"") } else { text }
    }

    fn line(&self, cells: &[String]) -> String {
        cells.join(&self.separator.to_string()) + "\n"
    }
}

/// Writes a number so short that it reads back as itself.
fn number(value: f64) -> String {
    let short = value as f32;
    if f64::from(short) == value { short.to_string() } else { value.to_string() }
}

impl Form {
    /// Lists the formats of the table that the form is.
    pub fn formats(self) -> Vec<&'static str> {
        match self {
            Form::Arrays("mat") => vec!["MATLAB file"],
            Form::Arrays("h5" | "hdf5") => vec!["HDF5"],
            Form::Arrays(_) | Form::Halves => vec!["NumPy archive"],
            Form::Files(ending, by) => {
                let format = match ending {
                    "csv" => "CSV recording",
                    "npy" => "NumPy array",
                    "jsonl" | "ndjson" => "JSON Lines",
                    "mat" => "MATLAB file",
                    "h5" | "hdf5" => "HDF5",
                    "mcap" => "ROS 2 bags",
                    _ => "image",
                };
                vec![format, folder(by)]
            }
            Form::Pictures(by) => vec!["ROS 2 bags", folder(by)],
            Form::Wide("parquet" | "pq") | Form::Long("parquet" | "pq") => vec!["Parquet"],
            Form::Wide(_) | Form::Long(_) => vec!["table"],
            Form::Pair(_) => vec!["UCR and UEA archives"],
            Form::LeRobot => vec!["LeRobot"],
        }
    }

    /// Returns the ending of its files, as the table of formats has it.
    pub fn ending(self) -> Option<&'static str> {
        match self {
            Form::Arrays(ending)
            | Form::Files(ending, _)
            | Form::Wide(ending)
            | Form::Long(ending)
            | Form::Pair(ending) => Some(ending),
            Form::Halves => Some("npz"),
            Form::Pictures(_) => Some("mcap"),
            Form::LeRobot => None,
        }
    }

    /// Names the form in a table.
    pub fn name(self) -> String {
        match self {
            Form::Arrays(ending) => format!("arrays .{ending}"),
            Form::Halves => "halves .npz".into(),
            Form::Files(ending, by) => format!("files .{ending} by {by:?}").to_lowercase(),
            Form::Pictures(by) => format!("images .mcap by {by:?}").to_lowercase(),
            Form::Wide(ending) => format!("wide .{ending}"),
            Form::Long(ending) => format!("long .{ending}"),
            Form::Pair(ending) => format!("pair .{ending}"),
            Form::LeRobot => "lerobot".into(),
        }
    }

    /// Lists the arguments of a command that says of a table what its columns do not.
    pub fn arguments(self, set: &Set) -> Vec<String> {
        let (form, shape) = match (self, set.layout) {
            (Form::Wide(_), Layout::Features) | (Form::Long(_), Layout::Series) => return vec![],
            (Form::Wide(_), _) => ("wide", &set.shape[..]),
            (Form::Long(_), _) => ("long", &set.shape[1..]),
            _ => return vec![],
        };
        let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
        vec!["--table".into(), format!("{form},shape={}", shape.join("x"))]
    }

    /// Lists the samples in the order in which they are read.
    pub fn order(self, set: &Set) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..set.len()).collect();
        let part = |row: usize| set.marks.as_ref().map_or(0, |marks| marks[row]);
        let day = |row: usize| set.groups.as_ref().map_or(0, |groups| groups[row]);
        let is_described = !matches!(self, Form::Files(ending, _) if is_plain(set, ending));
        // Classes by their names, or as `labels.json` lists them.
        let class = |row: usize| if is_described { (set.y[row], "") } else { (0, set.class(row)) };
        match self {
            Form::Files(_, By::Session) | Form::Pictures(By::Session) => {
                rows.sort_by_key(|row| (class(*row), day(*row)));
            }
            Form::Files(_, By::Class | By::Name) | Form::Pictures(By::Class | By::Name) => {
                rows.sort_by_key(|row| class(*row));
            }
            Form::Files(..) | Form::Pictures(_) => {}
            Form::Halves | Form::Pair(_) => rows.sort_by_key(|row| part(*row)),
            Form::Arrays(_) | Form::Wide(_) | Form::Long(_) | Form::LeRobot => {}
        }
        rows
    }

    /// Writes the set below `root`. Returns the path to read, and the keys of `[data]` that reading it needs.
    pub fn write(self, set: &Set, style: &Style, root: &Path) -> (PathBuf, String) {
        fs::create_dir_all(root).unwrap();
        match self {
            Form::Arrays(ending) => arrays(set, ending, root),
            Form::Halves => halves(set, root),
            Form::Files(ending, by) => files(set, by, ending, root, &|row, path| {
                let bytes = recording(set, ending, style, row, path);
                if let Some(bytes) = bytes {
                    fs::write(path, bytes).unwrap();
                }
            }),
            Form::Pictures(by) => files(set, by, "mcap", root, &|row, path| pictures(set, row, path)),
            Form::Wide(ending) => wide(set, ending, style, root),
            Form::Long(ending) => long(set, ending, style, root),
            Form::Pair(ending) => pair(set, ending, root),
            Form::LeRobot => lerobot(set, root),
        }
    }
}

fn folder(by: By) -> &'static str {
    if by == By::Table { "folder with a table" } else { "folder of recordings" }
}

/// Checks whether recordings say all of themselves, without a file beside them.
fn is_plain(set: &Set, ending: &str) -> bool {
    matches!((set.layout, ending), (Layout::Series, _) | (_, "png" | "jpg" | "jpeg"))
}

/// Writes what is known of the samples beside them.
fn describe(set: &Set, root: &Path) {
    let mut facts = json!({"classes": set.classes, "layout": set.layout.name()});
    if !set.names.is_empty() {
        facts["channels"] = json!(set.names);
    }
    fs::write(root.join("labels.json"), facts.to_string()).unwrap();
}

fn marks(set: &Set) -> String {
    if set.marks.is_some() { "test = \"marks\"\n".into() } else { String::new() }
}

fn arrays(set: &Set, ending: &'static str, root: &Path) -> (PathBuf, String) {
    let shape = [&[set.len()][..], &set.shape].concat();
    let first = i64::from(ending == "mat");
    let mut all = vec![
        Array::floats("x", &shape, set.x.concat()),
        Array::ints("y", set.y.iter().map(|class| *class as i64 + first)),
    ];
    all.extend(
        set.groups.iter().map(|groups| Array::ints("group", groups.iter().map(|group| *group as i64))),
    );
    all.extend(set.marks.iter().map(|marks| Array::ints("marks", marks.iter().copied())));
    let path = root.join(format!("set.{ending}"));
    fs::write(&path, archive(ending, &all)).unwrap();
    describe(set, root);
    (path, marks(set))
}

fn halves(set: &Set, root: &Path) -> (PathBuf, String) {
    let marks = set.marks.as_ref().unwrap();
    let mut all = vec![];
    for (mark, names) in
        [["x_train", "y_train", "group_train"], ["x_test", "y_test", "group_test"]].into_iter().enumerate()
    {
        let rows: Vec<usize> = (0..set.len()).filter(|row| marks[*row] == mark as i64).collect();
        let half = set.select(&rows);
        let shape = [&[half.len()][..], &set.shape].concat();
        all.push(Array::floats(names[0], &shape, half.x.concat()));
        all.push(Array::ints(names[1], half.y.iter().map(|class| *class as i64)));
        all.extend(
            half.groups.map(|groups| Array::ints(names[2], groups.into_iter().map(|group| group as i64))),
        );
    }
    let path = root.join("set.npz");
    fs::write(&path, archive("npz", &all)).unwrap();
    describe(set, root);
    (path, String::new())
}

/// Writes a file per sample where its class says.
fn files(set: &Set, by: By, ending: &str, root: &Path, put: &dyn Fn(usize, &Path)) -> (PathBuf, String) {
    let group = |row: usize| set.groups.as_ref().map(|groups| groups[row]);
    let mut table = String::from(if set.groups.is_some() { "file,label,group\n" } else { "file,label\n" });
    for row in 0..set.len() {
        let (number, class) = (format!("{row:03}"), set.class(row));
        let name = match by {
            By::Class => format!("{class}/{number}.{ending}"),
            By::Session => format!("{class}/day{}/{number}.{ending}", group(row).unwrap()),
            By::Table => format!("{number}.{ending}"),
            By::Name => format!("{class}_{number}.{ending}"),
            By::Parts => {
                let part = ["train", "test"][set.marks.as_ref().unwrap()[row] as usize];
                format!("{part}/{class}/{number}.{ending}")
            }
        };
        let path = root.join(&name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        put(row, &path);
        let group = group(row).map_or(String::new(), |group| format!(",day{group}"));
        table += &format!("{name},{class}{group}\n");
    }
    if by == By::Table {
        fs::write(root.join("labels.csv"), table).unwrap();
    }
    if !is_plain(set, ending) {
        describe(set, root);
    }
    (root.to_path_buf(), String::new())
}

/// Returns the bytes of a recording; none where they are written already.
fn recording(set: &Set, ending: &'static str, style: &Style, row: usize, path: &Path) -> Option<Vec<u8>> {
    let lines = || {
        let columns = set.recording(row);
        let line = |step: usize| {
            let pair =
                |(name, cells): &(String, Vec<Cell>)| format!("{name:?}: {}", json_cell(&cells[step], style));
            let mut pairs: Vec<String> = columns.iter().map(pair).collect();
            let count = pairs.len();
            pairs.rotate_left(if style.is_turned { (row + step) % count } else { 0 });
            format!("{{{}}}", pairs.join(", "))
        };
        (0..set.steps()).map(line).collect::<Vec<_>>()
    };
    Some(match ending {
        "csv" => {
            let mut columns = set.recording(row);
            let count = columns.len();
            columns.rotate_left(if style.is_turned { row % count } else { 0 });
            let mut text = style.line(&columns.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>());
            for step in 0..set.steps() {
                let cells: Vec<String> = columns.iter().map(|(_, cells)| style.cell(&cells[step])).collect();
                text += &style.line(&cells);
            }
            text.into_bytes()
        }
        "npy" => npy_bytes(&set.shape, &set.x[row]).unwrap(),
        "jsonl" | "ndjson" => (lines().join("\n") + "\n").into_bytes(),
        "mat" | "h5" | "hdf5" => archive(ending, &[Array::floats("x", &set.shape, set.x[row].clone())]),
        "mcap" => {
            let messages: Vec<(u64, Vec<u8>)> =
                (0..).step_by(10).zip(lines().into_iter().map(String::into_bytes)).collect();
            writers::bag(path, "/skin", None, &messages);
            return None;
        }
        "png" => picture(set, row).1,
        _ => {
            let mut bytes = std::io::Cursor::new(vec![]);
            picture(set, row).0.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
            bytes.into_inner()
        }
    })
}

fn json_cell(cell: &Cell, style: &Style) -> Value {
    match cell {
        Cell::Value(_) if style.point == ',' || !style.unit.is_empty() => {
            style.cell(cell).trim_matches('"').into()
        }
        Cell::Value(value) => number(*value).parse::<f64>().unwrap().into(),
        Cell::Count(count) => (*count).into(),
        Cell::Text(text) => text.as_str().into(),
    }
}

/// Returns a sample as a picture, and as a PNG.
fn picture(set: &Set, row: usize) -> (DynamicImage, Vec<u8>) {
    let x = &set.x[row];
    let [height, width] = <[usize; 2]>::try_from(&set.shape[set.shape.len() - 2..]).unwrap();
    let value = |channel: usize, across: u32, down: u32| {
        x[(channel * height + down as usize) * width + across as usize] as u8
    };
    let picture: DynamicImage = if set.layout == Layout::Colour {
        let pixel = |across, down| image::Rgb([0, 1, 2].map(|channel| value(channel, across, down)));
        RgbImage::from_fn(width as u32, height as u32, pixel).into()
    } else {
        let pixel = |across, down| image::Luma([value(0, across, down)]);
        GrayImage::from_fn(width as u32, height as u32, pixel).into()
    };
    let mut bytes = std::io::Cursor::new(vec![]);
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    (picture, bytes.into_inner())
}

const PICTURE: Definition = (
    "sensor_msgs/msg/Image",
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n\
     ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
     MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
);

/// Writes a sample as a bag of grey images, or of one image in colour.
fn pictures(set: &Set, row: usize, path: &Path) {
    let [height, width] = <[u32; 2]>::try_from(
        set.shape[set.shape.len() - 2..].iter().map(|axis| *axis as u32).collect::<Vec<_>>(),
    )
    .unwrap();
    let pixels = (height * width) as usize;
    let (encoding, bands) = if set.layout == Layout::Colour { ("rgb8", 3) } else { ("mono8", 1) };
    let message = |(at, values): (usize, &[f32])| {
        let bytes: Vec<u8> =
            (0..pixels).flat_map(|at| (0..bands).map(move |band| values[band * pixels + at] as u8)).collect();
        let cdr = Cdr::default().header().word(height).word(width).text(encoding).byte(0);
        (10 * at as u64, cdr.word(width * bands as u32).bytes(&bytes).finish())
    };
    let messages: Vec<(u64, Vec<u8>)> = set.x[row].chunks(pixels * bands).enumerate().map(message).collect();
    writers::bag(path, "/camera", Some(PICTURE), &messages);
}

/// The columns of a table, with a cell per line.
struct Lines(Vec<(String, Vec<Cell>)>);

impl Lines {
    fn push(&mut self, name: &str, cell: Cell) {
        match self.0.iter_mut().find(|(column, _)| column == name) {
            Some((_, cells)) => cells.push(cell),
            None => self.0.push((name.into(), vec![cell])),
        }
    }

    /// Adds what is said of a sample beside its values.
    fn push_roles(&mut self, set: &Set, row: usize) {
        self.push("label", Cell::Text(set.class(row).into()));
        if let Some(groups) = &set.groups {
            self.push("group", Cell::Text(format!("day{}", groups[row])));
        }
        if let Some(marks) = &set.marks {
            self.push("marks", Cell::Count(marks[row]));
        }
    }

    fn write(self, ending: &str, style: &Style, root: &Path) -> PathBuf {
        let path = root.join(format!("set.{ending}"));
        if matches!(ending, "parquet" | "pq") {
            let columns: Vec<(&str, Column)> =
                self.0.iter().map(|(name, cells)| (name.as_str(), column(cells))).collect();
            writers::parquet(&path, &columns);
            return path;
        }
        let names: Vec<String> = self.0.iter().map(|(name, _)| name.clone()).collect();
        let mut text = style.line(&names);
        for line in 0..self.0[0].1.len() {
            let cells: Vec<String> = self.0.iter().map(|(_, cells)| style.cell(&cells[line])).collect();
            text += &style.line(&cells);
        }
        fs::write(&path, text).unwrap();
        path
    }
}

fn column(cells: &[Cell]) -> Column {
    match cells[0] {
        Cell::Text(_) => Column::Text(
            cells
                .iter()
                .map(|cell| if let Cell::Text(text) = cell { text.clone() } else { panic!() })
                .collect(),
        ),
        Cell::Count(_) => Column::Int(
            cells.iter().map(|cell| if let Cell::Count(count) = cell { *count } else { panic!() }).collect(),
        ),
        Cell::Value(_) => Column::Double(
            cells.iter().map(|cell| if let Cell::Value(value) = cell { *value } else { panic!() }).collect(),
        ),
    }
}

fn wide(set: &Set, ending: &'static str, style: &Style, root: &Path) -> (PathBuf, String) {
    let mut lines = Lines(vec![]);
    for row in 0..set.len() {
        for (name, cell) in set.row(row) {
            lines.push(&name, cell);
        }
        lines.push_roles(set, row);
    }
    let mut keys = marks(set);
    if set.layout != Layout::Features {
        keys += &format!("layout = {:?}\n", set.layout.name());
        keys += &format!("table = {{ form = \"wide\", shape = {:?} }}\n", set.shape);
    }
    (lines.write(ending, style, root), keys)
}

fn long(set: &Set, ending: &'static str, style: &Style, root: &Path) -> (PathBuf, String) {
    let mut lines = Lines(vec![]);
    for row in 0..set.len() {
        let columns = set.recording(row);
        for step in 0..set.steps() {
            lines.push("recording", Cell::Count(row as i64));
            for (name, cells) in &columns {
                lines.push(name, cells[step].clone());
            }
            lines.push_roles(set, row);
        }
    }
    let mut keys = marks(set);
    if set.layout == Layout::Sequence {
        keys += &format!("table = {{ shape = {:?} }}\n", &set.shape[1..]);
    }
    (lines.write(ending, style, root), keys)
}

fn pair(set: &Set, ending: &'static str, root: &Path) -> (PathBuf, String) {
    let marks = set.marks.as_ref().unwrap();
    for (mark, part) in ["TRAIN", "TEST"].into_iter().enumerate() {
        let mut text = match ending {
            "ts" => format!(
                "@problemName Touch\n@univariate {}\n@classLabel true {}\n@data\n",
                set.width() == 1,
                set.classes.join(" ")
            ),
            "arff" => {
                let values = if set.width() == 1 {
                    (0..set.steps()).map(|step| format!("@attribute att{step} numeric\n")).collect()
                } else {
                    let steps: String =
                        (0..set.steps()).map(|step| format!("@attribute t{step} numeric\n")).collect();
                    format!("@attribute values relational\n{steps}@end values\n")
                };
                format!("@relation Touch\n{values}@attribute class {{{}}}\n@data\n", set.classes.join(","))
            }
            _ => String::new(),
        };
        for row in (0..set.len()).filter(|row| marks[*row] == mark as i64) {
            let channel = |channel: usize, by: &str| {
                let value = |step: usize| set.x[row][set.place(channel, step)].to_string();
                (0..set.steps()).map(value).collect::<Vec<_>>().join(by)
            };
            let all = |by: &str| (0..set.width()).map(|at| channel(at, ",")).collect::<Vec<_>>().join(by);
            text += &match ending {
                "ts" => format!("{}:{}\n", all(":"), set.class(row)),
                "arff" if set.width() == 1 => format!("{},{}\n", all(""), set.class(row)),
                "arff" => format!("'{}',{}\n", all("\\n"), set.class(row)),
                _ => format!("{}\t{}\n", set.class(row), channel(0, "\t")),
            };
        }
        fs::write(root.join(format!("Touch_{part}.{ending}")), text).unwrap();
    }
    (root.join("Touch"), String::new())
}

fn lerobot(set: &Set, root: &Path) -> (PathBuf, String) {
    let width = set.width();
    let mut features = format!(
        "\"observation.state\": {{\"dtype\": \"float32\", \"shape\": [{width}], \"names\": {:?}}}",
        set.channels(width)
    );
    for extra in &set.extras {
        let dtype = if matches!(extra.cells[0][0], Cell::Text(_)) { "string" } else { "float32" };
        features +=
            &format!(", \"{}\": {{\"dtype\": \"{dtype}\", \"shape\": [1], \"names\": null}}", extra.name);
    }
    writers::info(root, "v2.1", &features);
    let task = |(at, class): (usize, &String)| format!("{{\"task_index\": {at}, \"task\": {class:?}}}\n");
    let tasks: String = set.classes.iter().enumerate().map(task).collect();
    fs::write(root.join("meta/tasks.jsonl"), tasks).unwrap();
    for row in 0..set.len() {
        let at = |step: usize| (0..width).map(|channel| set.x[row][set.place(channel, step)]).collect();
        let state = Column::List((0..set.steps()).map(at).collect());
        let mut columns = vec![("observation.state", state)];
        columns.extend(set.extras.iter().map(|extra| (extra.name.as_str(), column(&extra.cells[row]))));
        let count = || 0..set.steps() as i64;
        columns.extend([
            ("timestamp", Column::Float(count().map(|step| step as f32 / 10.0).collect())),
            ("frame_index", Column::Int(count().collect())),
            ("episode_index", Column::Int(vec![row as i64; set.steps()])),
            ("index", Column::Int(count().map(|step| row as i64 * 1000 + step).collect())),
            ("task_index", Column::Int(vec![set.y[row] as i64; set.steps()])),
        ]);
        writers::parquet(&root.join(format!("data/chunk-000/episode_{row:06}.parquet")), &columns);
    }
    (root.to_path_buf(), String::new())
}
