//! Functions that tests of scenes share.

#![allow(dead_code, clippy::unwrap_used)]

use taxel_scenes::{Scene, explain};

/// Names of the effects of `scene` that can be taken out.
pub fn removable(scene: &str) -> Vec<String> {
    let effects = explain(scene).unwrap();
    let mut names: Vec<String> = effects.into_iter().filter(|e| e.removable).map(|e| e.name).collect();
    names.sort();
    names.dedup();
    names
}

/// Everything removable of `scene` but these.
pub fn all_but(scene: &str, effects: &[&str]) -> Vec<String> {
    removable(scene).into_iter().filter(|name| !effects.contains(&name.as_str())).collect()
}

/// A true physical value of every sample.
pub fn truth<'a>(scene: &'a Scene, name: &str) -> &'a [f32] {
    &scene.truth.iter().find(|(n, _)| n == name).unwrap().1
}
