//! Meshes on disk: OBJ, STL and OFF files, files or in one folder per class.
//!
//! # Reference
//!
//! OBJ through `tobj`, STL through `stl_io`. OFF as princeton.edu's shape benchmarks have it: the
//! word OFF, the numbers of vertices, faces and edges, a line per vertex, and per face its number
//! of corners and their indices; `#` starts a comment.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use taxel_base::FileError;
use taxel_base::files::read_bytes;

use super::mesh::{MOST_TRIANGLES, Mesh};
use super::vector::Vector;
use crate::Result;

const MOST_BYTES: u64 = 512 << 20;
const FORMATS: [&str; 3] = ["obj", "stl", "off"];

/// Refuses a mesh that cannot be read.
fn refuse<T>(file: &Path, reason: impl Into<String>) -> Result<T> {
    Err(FileError::new(file, reason).into())
}

/// Lists the files of a folder by class: one sub-folder per class, or one file per class.
///
/// # Errors
///
/// [`Error::Mesh`](crate::Error::Mesh) for a path that is no such folder, or a class without meshes.
pub(crate) fn classes(folder: &Path) -> Result<Vec<(String, Vec<PathBuf>)>> {
    let entries = listed(folder)?;
    let folders: Vec<PathBuf> = entries.iter().filter(|path| path.is_dir()).cloned().collect();
    let files: Vec<PathBuf> = entries.into_iter().filter(|path| is_mesh(path)).collect();
    let classes: Vec<(String, Vec<PathBuf>)> = match (folders.is_empty(), files.is_empty()) {
        (false, false) => return refuse(folder, "holds both folders and meshes; give one folder per class"),
        (true, _) => files.into_iter().map(|file| (stem(&file), vec![file])).collect(),
        (false, true) => {
            let meshes = |class: &PathBuf| {
                let files: Vec<PathBuf> = listed(class)?.into_iter().filter(|path| is_mesh(path)).collect();
                if files.is_empty() {
                    return refuse(class, "holds no .obj, .stl or .off; add meshes or remove the folder");
                }
                Ok((stem(class), files))
            };
            folders.iter().map(meshes).collect::<Result<_>>()?
        }
    };
    match classes.len() {
        0 => refuse(folder, "holds no .obj, .stl or .off; give a folder with one sub-folder per class"),
        1 => refuse(folder, format!("holds one class, `{}`; at least two are needed", classes[0].0)),
        _ => Ok(classes),
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Lists a folder, sorted by name, so that the order is the same everywhere.
fn listed(folder: &Path) -> Result<Vec<PathBuf>> {
    let read = || -> std::io::Result<Vec<PathBuf>> {
        let paths: std::io::Result<Vec<PathBuf>> =
            fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect();
        paths.map(|mut paths| {
            paths.retain(|path| !stem(path).starts_with('.'));
            paths.sort();
            paths
        })
    };
    match read() {
        Ok(paths) => Ok(paths),
        Err(error) => refuse(
            folder,
            format!("cannot be read as a folder: {error}; give one sub-folder of meshes per class"),
        ),
    }
}

fn format(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn is_mesh(path: &Path) -> bool {
    FORMATS.contains(&format(path).as_str())
}

/// Reads and checks one mesh; see [`Mesh::new`] for `diagonal`.
///
/// # Errors
///
/// [`Error::Mesh`](crate::Error::Mesh) naming the file.
pub(crate) fn mesh(file: &Path, diagonal: f64) -> Result<Mesh> {
    match fs::metadata(file) {
        Err(error) => return refuse(file, format!("cannot be read: {error}")),
        Ok(about) if about.len() > MOST_BYTES => {
            return refuse(file, format!("has {} bytes, more than {MOST_BYTES}; decimate it", about.len()));
        }
        Ok(_) => {}
    }
    let bytes = match read_bytes(file) {
        Ok(bytes) => bytes,
        Err(error) => return refuse(file, format!("cannot be read: {error}")),
    };
    let parts = match format(file).as_str() {
        "obj" => obj(&bytes),
        "stl" => stl(bytes),
        "off" => off(&bytes),
        _ => Err("unknown kind of mesh; use .obj, .stl or .off".into()),
    };
    match parts {
        Ok((vertices, triangles)) => Mesh::new(&file.display().to_string(), vertices, triangles, diagonal),
        Err(reason) => refuse(file, reason),
    }
}

type MeshParts = std::result::Result<(Vec<Vector>, Vec<[u32; 3]>), String>;

fn obj(bytes: &[u8]) -> MeshParts {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    // Colours are no matter of touch: materials are not looked for.
    let nothing = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, nothing)
        .map_err(|error| format!("not a readable OBJ file: {error}; export it again"))?;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for model in models {
        let first = vertices.len() as u32;
        let (points, _) = model.mesh.positions.as_chunks::<3>();
        vertices.extend(points.iter().map(|p| p.map(f64::from)));
        let (faces, _) = model.mesh.indices.as_chunks::<3>();
        triangles.extend(faces.iter().map(|face| face.map(|v| v.saturating_add(first))));
    }
    Ok((vertices, triangles))
}

fn stl(mut bytes: Vec<u8>) -> MeshParts {
    // Some programs begin the header of a binary file with the word that marks text files.
    if let Some(count) = bytes.get(80..84) {
        let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
        if bytes.len() as u64 == 84 + 50 * u64::from(count) {
            bytes[..80].fill(0);
        }
    }
    // The reader takes a text without a name for a binary file.
    if bytes.starts_with(b"solid\n") || bytes.starts_with(b"solid\r") {
        bytes.insert(5, b' ');
    }
    let wrong = |error: std::io::Error| format!("not a readable STL file: {error}; export it again");
    let mut source = Cursor::new(bytes);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for triangle in stl_io::create_stl_reader(&mut source).map_err(wrong)?.take(MOST_TRIANGLES + 1) {
        let first = vertices.len() as u32;
        let [a, b, c] = triangle.map_err(wrong)?.vertices;
        vertices.extend([a, b, c].map(|v| [v[0], v[1], v[2]].map(f64::from)));
        triangles.push([first, first + 1, first + 2]);
    }
    Ok((vertices, triangles))
}

fn off(bytes: &[u8]) -> MeshParts {
    let text = std::str::from_utf8(bytes).map_err(|_| "not a readable OFF file: not text".to_string())?;
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or_default());
    let mut words = lines.flat_map(str::split_whitespace).peekable();
    match words.next() {
        Some("OFF") => {}
        first => return Err(format!("not a readable OFF file: begins with {first:?} and not with OFF")),
    }
    fn next<'a, T: std::str::FromStr>(
        words: &mut impl Iterator<Item = &'a str>,
        what: &str,
    ) -> std::result::Result<T, String> {
        let word = words.next().ok_or(format!("ends before {what}; the file is cut short"))?;
        word.parse().map_err(|_| format!("{what} is {word:?}, not a number that fits; export it again"))
    }
    let vertices: usize = next(&mut words, "the number of vertices")?;
    let faces: usize = next(&mut words, "the number of faces")?;
    let _edges: usize = next(&mut words, "the number of edges")?;
    if faces > MOST_TRIANGLES {
        return Err(format!("more than {MOST_TRIANGLES} faces; decimate the mesh first"));
    }
    let mut points = Vec::new();
    for at in 0..vertices {
        let mut coordinate = || next::<f64>(&mut words, &format!("vertex {at}"));
        points.push([coordinate()?, coordinate()?, coordinate()?]);
    }
    let mut triangles = Vec::new();
    for at in 0..faces {
        let what = format!("face {at}");
        let corners: usize = next(&mut words, &what)?;
        let first: u32 = next(&mut words, &what)?;
        let mut last: u32 = next(&mut words, &what)?;
        for _ in 2..corners {
            let corner = next(&mut words, &what)?;
            triangles.push([first, last, corner]);
            last = corner;
        }
    }
    Ok((points, triangles))
}
