//! Simulated tactile worlds: labelled recordings with the physical truth behind them.
//!
//! A scene has the few parameters that a paper's claims depend on. Each belongs to a named effect,
//! [`explain`] lists them with their sources, and `without` takes an effect out again. Numbers
//! measured on a scene are measured on simulated data and never a paper's own.
//!
//! Every random number comes from [`taxel_seed`] under a purpose that names scene, sample and
//! effect: sample i is the same however many are asked for, and removing one effect leaves the
//! random numbers of the others alone.
//!
//! # Reference
//!
//! See each scene: [`fingertip`], [`palpation`], [`gripper`].
//!
//! ```
//! let scene = taxel_scenes::simulate("fingertip", 30, 7, &["noise".into()])?;
//! assert_eq!(scene.x.shape(), [30, 5, 50]);
//! assert_eq!(scene.class_names, ["shore-00", "shore-10", "shore-20"]);
//! # Ok::<(), taxel_scenes::Error>(())
//! ```

mod error;
pub mod fingertip;
pub mod gripper;
pub mod palpation;
mod parameters;
mod world;

pub use error::{Error, Result};
pub use fingertip::Fingertip;
pub use gripper::Gripper;
pub use palpation::Palpation;

use ndarray::{Array2, ArrayD};
use serde::{Deserialize, Serialize};

/// A simulated data set of N samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Raw readings, `[N, ..]`, in `unit`.
    pub x: ArrayD<f32>,
    /// Class of each sample, an index into `class_names`; column 0 of `attributes` where there are any.
    pub y: Vec<u32>,
    /// Session of each sample: what a fair split never tears apart.
    pub group: Vec<u32>,
    /// Names of the classes.
    pub class_names: Vec<String>,
    /// Names of the channels (axis 1 of `x`); empty where axis 1 is frames.
    pub channel_names: Vec<String>,
    /// Unit of the readings.
    pub unit: &'static str,
    /// The largest possible reading; the smallest is 0.
    pub full_scale: f32,
    /// True physical values by name, one per sample.
    pub truth: Vec<(String, Vec<f32>)>,
    /// Labels of scenes with more than one attribute.
    pub attributes: Option<Attributes>,
}

/// More than one label per sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attributes {
    /// Labels `[N, k]`, each an index into the names of its column.
    pub y: Array2<u32>,
    /// Names of the values of each of the k attributes.
    pub class_names: Vec<Vec<String>>,
}

/// One parameter of a scene and the effect that it is there for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Effect {
    /// The effect, as `without` takes it; several parameters may share one.
    pub name: String,
    /// The parameter.
    pub parameter: String,
    /// Its value, or one value per finger.
    pub value: String,
    /// The unit of the value; empty for a ratio.
    pub unit: String,
    /// Where the value comes from; `assumed` where nothing is published.
    pub source: String,
    /// What the effect does to the readings.
    pub why: String,
    /// Whether `without` may name it.
    pub removable: bool,
}

/// A scene with its settings, as a TOML or JSON table: `scene` names it, the other keys are its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "scene", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Settings {
    /// Five fingertip FSRs on silicone cylinders (paper 000).
    Fingertip(Fingertip),
    /// Squeezes on a pressure array (papers 002 and 003).
    Palpation(Palpation),
    /// Grasps of everyday objects by two fingers (paper 004).
    Gripper(Gripper),
}

impl Settings {
    /// The scene `name` with its default settings.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownScene`].
    pub fn named(name: &str) -> Result<Self> {
        match name {
            fingertip::NAME => Ok(Self::Fingertip(Fingertip::default())),
            palpation::NAME => Ok(Self::Palpation(Palpation::default())),
            gripper::NAME => Ok(Self::Gripper(Gripper::default())),
            _ => Err(Error::UnknownScene { name: name.into(), known: names().join(", ") }),
        }
    }

    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        match self {
            Self::Fingertip(scene) => scene.check(),
            Self::Palpation(scene) => scene.check(),
            Self::Gripper(scene) => scene.check(),
        }
    }

    /// Simulates `samples` recordings; `without` names effects to leave out.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownEffect`] for a name in `without` that is no removable effect of the scene,
    /// [`Error::Parameter`] for impossible settings or zero samples.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        match self {
            Self::Fingertip(scene) => scene.simulate(samples, seed, without),
            Self::Palpation(scene) => scene.simulate(samples, seed, without),
            Self::Gripper(scene) => scene.simulate(samples, seed, without),
        }
    }
}

/// Names of all scenes.
pub fn names() -> &'static [&'static str] {
    &[fingertip::NAME, palpation::NAME, gripper::NAME]
}

/// Simulates `samples` recordings of the scene `name` with its default settings.
///
/// # Errors
///
/// [`Error::UnknownScene`], and those of [`Settings::simulate`].
pub fn simulate(name: &str, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
    Settings::named(name)?.simulate(samples, seed, without)
}

/// All parameters of the scene `name`, effect by effect.
///
/// # Errors
///
/// [`Error::UnknownScene`].
pub fn explain(name: &str) -> Result<Vec<Effect>> {
    Ok(match Settings::named(name)? {
        Settings::Fingertip(_) => fingertip::explain(),
        Settings::Palpation(_) => palpation::explain(),
        Settings::Gripper(_) => gripper::explain(),
    })
}
