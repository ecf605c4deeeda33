//! Simulated tactile worlds: labelled recordings with the physical truth behind them.
//!
//! A scene has the few parameters that a paper's claims depend on. Each belongs to a named effect,
//! [`explain`] lists them with their sources, `without` takes an effect out again, and [`Factors`] keep a part of it. Numbers
//! measured on a scene are measured on simulated data and never a paper's own.
//!
//! Every random number comes from [`taxel_base::seed`] under a purpose that names scene, sample and
//! effect: sample i is the same however many are asked for, and removing one effect leaves the
//! random numbers of the others alone.
//!
//! # Reference
//!
//! See each scene: [`fingertip`], [`palpation`], [`gripper`], [`imprint`], [`gel`], [`hand`], [`vision`].
//!
//! ```
//! let scene = taxel_scenes::simulate("fingertip", 30, 7, &["noise".into()])?;
//! assert_eq!(scene.x.shape(), [30, 5, 50]);
//! assert_eq!(scene.class_names, ["shore-00", "shore-10", "shore-20"]);
//! # Ok::<(), taxel_scenes::Error>(())
//! ```

mod error;
pub mod fingertip;
pub mod gel;
pub mod gripper;
pub mod hand;
pub mod imprint;
pub mod palpation;
mod parameters;
mod shapes;
mod truth;
pub mod vision;
mod world;

pub use error::{Error, Result};
pub use fingertip::Fingertip;
pub use gel::Gel;
pub use gripper::Gripper;
pub use hand::Hand;
pub use imprint::Imprint;
pub use palpation::Palpation;
pub use truth::quantity_of;
pub use vision::Vision;
pub use world::Factors;

use ndarray::{Array2, ArrayD, Axis};
use serde::{Deserialize, Deserializer, Serialize};
pub use taxel_base::Layout;
use taxel_base::names::{hint, with_meant};
use taxel_faults::{Fault, Sensor};

/// A simulated data set of N samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Raw readings, `[N, ..]`, in `unit`.
    pub x: ArrayD<f32>,
    /// Further arrays `[N, ..]` by name, such as pictures of the same objects; often none.
    pub streams: Vec<(String, ArrayD<f32>)>,
    /// Axes of one sample.
    pub layout: Layout,
    /// Class of each sample, an index into `class_names`; column 0 of `attributes` where there are any.
    pub y: Vec<u32>,
    /// Session or object of each sample: what a fair split never tears apart.
    pub group: Vec<u32>,
    /// Names of the classes.
    pub class_names: Vec<String>,
    /// Names of the channels (axis 1 of `x`); none for arrays of taxels.
    pub channel_names: Vec<String>,
    /// Unit of the readings.
    pub unit: &'static str,
    /// The largest possible reading; the smallest is 0.
    pub full_scale: f32,
    /// Readings without contact: one for all, or one per channel.
    pub rest: Vec<f32>,
    /// True physical values by name, one per sample; [`quantity_of`] says their units.
    pub truth: Vec<(String, Vec<f32>)>,
    /// Whether each sample is one to test on, where the settings say so.
    pub test: Option<Vec<bool>>,
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

impl Scene {
    /// Returns range and axes of the readings, as faults need them.
    pub fn sensor(&self) -> Sensor {
        Sensor { rest: self.rest.clone(), ..Sensor::new(self.layout, self.full_scale) }
    }

    /// Joins scenes, one after the other: each becomes a group, whatever groups it has. Pictures and marks for testing are left
    /// out. None without a scene, and for samples of several shapes.
    pub fn joined(scenes: Vec<Scene>) -> Option<Self> {
        let numbered = scenes.iter().zip(0u32..);
        let group = numbered.flat_map(|(scene, number)| std::iter::repeat_n(number, scene.y.len())).collect();
        let y = scenes.iter().flat_map(|scene| &scene.y).copied().collect();
        let views: Vec<_> = scenes.iter().map(|scene| scene.x.view()).collect();
        let x = ndarray::concatenate(Axis(0), &views).ok()?;
        let columns: Vec<_> =
            scenes.iter().filter_map(|scene| Some(scene.attributes.as_ref()?.y.view())).collect();
        let columns = ndarray::concatenate(Axis(0), &columns).ok();
        let mut scenes = scenes.into_iter();
        let mut first = scenes.next()?;
        for (at, (_, values)) in first.truth.iter_mut().enumerate() {
            values.extend(
                scenes.as_slice().iter().filter_map(|scene| scene.truth.get(at)).flat_map(|(_, next)| next),
            );
        }
        let named = first.attributes.zip(columns);
        let attributes = named.map(|(attributes, y)| Attributes { y, ..attributes });
        Some(Scene { x, y, group, attributes, streams: vec![], test: None, ..first })
    }

    /// Breaks every sample by one fault; see [`Fault::apply`].
    ///
    /// # Errors
    ///
    /// Those of [`Fault::apply`].
    pub fn corrupt(&mut self, fault: Fault, severity: u8, seed: u64) -> Result<()> {
        let sensor = self.sensor();
        let mut samples = self.x.axis_iter_mut(Axis(0)).enumerate();
        samples.try_for_each(|(i, sample)| fault.apply(sample, &sensor, severity, seed, i))?;
        Ok(())
    }
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
    /// The influence of the effect on the values.
    pub why: String,
    /// Whether `without` may name it.
    pub removable: bool,
}

/// Lists the names of all scenes.
pub fn names() -> &'static [&'static str] {
    &[fingertip::NAME, palpation::NAME, gripper::NAME, imprint::NAME, gel::NAME, hand::NAME, vision::NAME]
}

/// A number of samples that always fits into memory.
const FEW: usize = 10_000;

/// Refuses samples for which there is not enough memory, before the program is killed.
fn refuse_more_than_memory(samples: usize, values: usize) -> Result<()> {
    let fits =
        samples.checked_mul(values).is_some_and(|all| Vec::<f32>::new().try_reserve_exact(all).is_ok());
    if fits {
        return Ok(());
    }
    let expected = "they do not fit into memory; simulate fewer, or several sets with other seeds";
    Err(Error::Parameter { name: "samples", value: samples.to_string(), expected })
}

/// A scene with its settings; everything that is not set has its default.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Settings {
    /// See [`fingertip`].
    Fingertip(Fingertip),
    /// See [`palpation`].
    Palpation(Palpation),
    /// See [`gripper`].
    Gripper(Gripper),
    /// See [`imprint`].
    Imprint(Imprint),
    /// See [`gel`].
    Gel(Gel),
    /// See [`hand`].
    Hand(Hand),
    /// See [`vision`].
    Vision(Vision),
}

impl Settings {
    /// Reads the settings of the scene `name`, from any format that serde reads.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownScene`]; [`Error::Settings`] for an unknown key or a value of the wrong kind.
    pub fn read<'de, D: Deserializer<'de>>(name: &str, settings: D) -> Result<Self> {
        let read = match name {
            fingertip::NAME => Fingertip::deserialize(settings).map(Self::Fingertip),
            palpation::NAME => Palpation::deserialize(settings).map(Self::Palpation),
            gripper::NAME => Gripper::deserialize(settings).map(Self::Gripper),
            imprint::NAME => Imprint::deserialize(settings).map(Self::Imprint),
            gel::NAME => Gel::deserialize(settings).map(Self::Gel),
            hand::NAME => Hand::deserialize(settings).map(Self::Hand),
            vision::NAME => Vision::deserialize(settings).map(Self::Vision),
            _ => return Err(unknown(name)),
        };
        read.map_err(|error| Error::Settings { scene: name.into(), reason: with_meant(&error.to_string()) })
    }

    /// Returns the scene `name` as it is by default.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownScene`].
    pub fn of(name: &str) -> Result<Self> {
        match name {
            fingertip::NAME => Ok(Self::Fingertip(Fingertip::default())),
            palpation::NAME => Ok(Self::Palpation(Palpation::default())),
            gripper::NAME => Ok(Self::Gripper(Gripper::default())),
            imprint::NAME => Ok(Self::Imprint(Imprint::default())),
            gel::NAME => Ok(Self::Gel(Gel::default())),
            hand::NAME => Ok(Self::Hand(Hand::default())),
            vision::NAME => Ok(Self::Vision(Vision::default())),
            _ => Err(unknown(name)),
        }
    }

    /// Simulates `samples` recordings.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownEffect`] for a name in `without` or the factors that is no removable effect of the scene,
    /// [`Error::Parameter`] for impossible settings, a factor outside 0 to 1, or zero samples, [`Error::Mesh`] for a mesh
    /// that cannot be used.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        if samples > FEW {
            let one = self.simulated(1, seed, without)?;
            let streams = one.streams.iter().map(|(_, values)| values.len()).sum::<usize>();
            refuse_more_than_memory(samples, one.x.len() + streams + one.truth.len())?;
        }
        self.simulated(samples, seed, without)
    }

    /// Returns how much of which effects there is, where it is not all.
    pub fn factors(&self) -> &Factors {
        match self {
            Self::Fingertip(scene) => &scene.factors,
            Self::Palpation(scene) => &scene.factors,
            Self::Gripper(scene) => &scene.factors,
            Self::Imprint(scene) => &scene.factors,
            Self::Gel(scene) => &scene.factors,
            Self::Hand(scene) => &scene.factors,
            Self::Vision(scene) => &scene.factors,
        }
    }

    fn simulated(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        match self {
            Self::Fingertip(scene) => scene.simulate(samples, seed, without),
            Self::Palpation(scene) => scene.simulate(samples, seed, without),
            Self::Gripper(scene) => scene.simulate(samples, seed, without),
            Self::Imprint(scene) => scene.simulate(samples, seed, without),
            Self::Gel(scene) => scene.simulate(samples, seed, without),
            Self::Hand(scene) => scene.simulate(samples, seed, without),
            Self::Vision(scene) => scene.simulate(samples, seed, without),
        }
    }
}

/// Simulates `samples` recordings of the scene `name` with its default parameters.
///
/// # Errors
///
/// [`Error::UnknownScene`], and those of [`Settings::simulate`].
pub fn simulate(name: &str, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
    Settings::of(name)?.simulate(samples, seed, without)
}

/// Lists all parameters of the scene `name`, effect by effect.
///
/// # Errors
///
/// [`Error::UnknownScene`].
pub fn explain(name: &str) -> Result<Vec<Effect>> {
    match name {
        fingertip::NAME => Ok(fingertip::explain()),
        palpation::NAME => Ok(palpation::explain()),
        gripper::NAME => Ok(gripper::explain()),
        imprint::NAME => Ok(imprint::explain()),
        gel::NAME => Ok(gel::explain()),
        hand::NAME => Ok(hand::explain()),
        vision::NAME => Ok(vision::explain()),
        _ => Err(unknown(name)),
    }
}

fn unknown(name: &str) -> Error {
    Error::UnknownScene { name: name.into(), hint: hint(name, names().iter().copied()) }
}
