//! The one error type of the scenes.
//!
//! # Reference
//!
//! None: every message names the thing, its value and how to fix it.

use taxel_base::FileError;

/// A scene that cannot be simulated as asked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No scene has this name.
    #[error("there is no scene `{name}`; {hint}")]
    UnknownScene {
        /// The name asked for.
        name: String,
        /// The nearest names, and all of them.
        hint: String,
    },
    /// The settings of a scene cannot be read.
    #[error("settings of scene {scene}: {reason}")]
    Settings {
        /// The scene.
        scene: String,
        /// The problem.
        reason: String,
    },
    /// The scene has no such effect, or could not work without it.
    #[error("scene {scene} has no removable effect `{name}`; {hint}")]
    UnknownEffect {
        /// The scene.
        scene: &'static str,
        /// The effect asked for.
        name: String,
        /// The nearest of its removable effects, and all of them.
        hint: String,
    },
    /// A fault cannot be applied.
    #[error(transparent)]
    Fault(#[from] taxel_faults::Error),
    /// A mesh file, a folder of them or a built-in object cannot be used.
    #[error(transparent)]
    Mesh(#[from] FileError),
    /// A parameter is impossible.
    #[error("{name} = {value}: {expected}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// The value given.
        value: String,
        /// The values that work.
        expected: &'static str,
    },
}

/// A result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;
