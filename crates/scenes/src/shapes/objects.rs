//! Thirty built-in objects: six classes, five variants each.
//!
//! # Reference
//!
//! The classes and numbers of Rouhafzay et al. 2021, section 3.3. Its meshes are not
//! published; these are ours, so no score on them is the paper's.

mod bird;
mod chair;
mod hand;
mod head;
mod plane;
mod quadruped;

use super::solid::Solid;

/// The five objects of a class.
type Variants = [fn() -> Solid; 5];

/// Class names, in the paper's order, with the variants of each.
pub(crate) const CLASSES: [(&str, Variants); 6] = [
    ("bird", bird::VARIANTS),
    ("chair", chair::VARIANTS),
    ("hand", hand::VARIANTS),
    ("head", head::VARIANTS),
    ("plane", plane::VARIANTS),
    ("quadruped", quadruped::VARIANTS),
];
