//! Objects that scenes touch and look at: meshes of six classes, built in or read from a folder.
//!
//! # Reference
//!
//! The classes and numbers of Rouhafzay et al. 2021, section 3.3; see [`objects`].

use std::path::Path;

use rayon::prelude::*;

use crate::Result;

pub(crate) mod mesh;
pub(crate) mod objects;
pub(crate) mod read;
pub(crate) mod solid;
pub(crate) mod touch;
pub(crate) mod vector;

use mesh::Mesh;

/// A mesh and where it belongs.
pub(crate) struct MeshObject {
    /// `bird-1`, or its file.
    pub name: String,
    /// An index into the names of the classes.
    pub class: usize,
    pub mesh: Mesh,
}

/// Returns the class names and all objects, class by class: those of a `folder` (OBJ, STL, OFF; one sub-folder per
/// class, or one file per class), otherwise the thirty built in. Every object is `size` from corner to corner.
///
/// # Errors
///
/// [`crate::Error::Mesh`] for a mesh that cannot be used.
pub(crate) fn load(folder: Option<&Path>, size: f64) -> Result<(Vec<String>, Vec<MeshObject>)> {
    let Some(folder) = folder else {
        let all: Vec<(usize, usize)> =
            (0..objects::CLASSES.len()).flat_map(|c| (0..5).map(move |v| (c, v))).collect();
        let build = |&(class, variant): &(usize, usize)| {
            let (name, variants) = objects::CLASSES[class];
            let name = format!("{name}-{}", variant + 1);
            let (vertices, triangles) = variants[variant]().surface();
            Ok(MeshObject { mesh: Mesh::new(&name, vertices, triangles, size)?, name, class })
        };
        let names = objects::CLASSES.map(|(name, _)| name.to_string()).to_vec();
        return Ok((names, all.par_iter().map(build).collect::<Result<_>>()?));
    };
    let classes = read::classes(folder)?;
    let files: Vec<(usize, &Path)> = classes
        .iter()
        .enumerate()
        .flat_map(|(class, (_, files))| files.iter().map(move |file| (class, file.as_path())))
        .collect();
    let load = |&(class, file): &(usize, &Path)| {
        Ok(MeshObject { name: file.display().to_string(), class, mesh: read::mesh(file, size)? })
    };
    let objects = files.par_iter().map(load).collect::<Result<_>>()?;
    Ok((classes.into_iter().map(|(name, _)| name).collect(), objects))
}

/// Returns the object of sample `i`: classes take turns, and in a class its objects.
pub(crate) fn in_turn(by_class: &[Vec<usize>], i: usize) -> usize {
    let objects = &by_class[i % by_class.len()];
    objects[i / by_class.len() % objects.len()]
}

/// Lists for each class the numbers of its objects, in their order.
pub(crate) fn by_class(classes: usize, objects: &[MeshObject]) -> Vec<Vec<usize>> {
    let of =
        |class: usize| objects.iter().enumerate().filter(move |(_, o)| o.class == class).map(|(at, _)| at);
    (0..classes).map(|class| of(class).collect()).collect()
}
