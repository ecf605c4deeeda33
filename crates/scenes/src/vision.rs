//! Colour pictures of objects: something to learn seeing on, before a network is taught to touch.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021 starts its five networks from ImageNet weights, which are photographs of a
//! thousand classes. Nobody who has only taxel has those; this scene stands in for them: the objects of
//! [`crate::imprint`], as a camera sees them, with light, texture, background and pose of their own in every picture.
//!
//! # Departures
//!
//! - Thirty objects are far from ImageNet's thousand classes: what a network learns here is less, and less general.
//!   With a user's own ImageNet weights the same experiments take those.
//! - Parallel projection, matt surfaces, no shadows.
//!
//! # What tells the class
//!
//! The outline and the shading of the object. Its colours and its background are drawn anew for every picture, so
//! they tell nothing.

mod paint;
mod parameters;

use std::f64::consts::TAU;
use std::path::PathBuf;

use ndarray::Array4;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use self::paint::{Appearance, picture};
use self::parameters::{AMBIENT, AZIMUTH, ELEVATION, LAMP, ROLL, SHIFT, ZOOM};
use crate::parameters::rows;
use crate::shapes::{by_class, in_turn, load};
use crate::world::{Factors, Removable, World, columns, each_sample};
use crate::{Effect, Error, Layout, Result, Scene};

/// Name of the scene.
pub(crate) const NAME: &str = "vision";
const REMOVABLE: Removable = Removable { graded: &[], switched: &["light", "texture", "background", "pose"] };
/// Meshes are this large from corner to corner; pictures are scaled to it, so its value means nothing.
const SIZE: f64 = 200.0;

/// Settings of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Vision {
    /// Pixels along a side, 8 to 1024.
    pub pixels: usize,
    /// The classes to tell apart.
    pub classes: VisionClasses,
    /// A folder of own meshes (OBJ, STL, OFF): one sub-folder per class, or one file per class.
    pub meshes: Option<PathBuf>,
    /// How much of an effect there is: `{ placement = 0.5 }` halves it, 0 leaves it out, 1 keeps it. Default 1 for every one.
    #[serde(skip_serializing_if = "Factors::is_empty")]
    pub factors: Factors,
}

/// The classes to tell apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum VisionClasses {
    /// Every object is a class of its own: thirty of those built in.
    Object,
    /// Birds, chairs, hands and so on; the objects of a class are its groups.
    Family,
}

impl Default for Vision {
    fn default() -> Self {
        Self { pixels: 64, classes: VisionClasses::Object, meshes: None, factors: Factors::new() }
    }
}

impl Vision {
    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        if (8..=1024).contains(&self.pixels) {
            return Ok(());
        }
        let value = self.pixels.to_string();
        Err(Error::Parameter { name: "pixels", value, expected: "must be in 8..=1024" })
    }

    /// Simulates pictures `[samples, 3 colours, pixels, pixels]` in 0..1.
    ///
    /// Sample i is of class `i % classes`; of families the objects take turns, and are the groups. Truth:
    /// `azimuth_deg`, `elevation_deg`, `roll_deg` of the camera, `zoom` (share of the picture that the object's
    /// bounding box would fill from corner to corner), `shift_x` and `shift_y` in shares of the picture, and
    /// `ambient`, the share of light that comes from everywhere.
    ///
    /// # Errors
    ///
    /// Those of [`Vision::check`]; [`Error::Parameter`] for zero samples; [`Error::UnknownEffect`] for a name in
    /// `without` that is not a removable effect; [`Error::Mesh`] for a mesh that cannot be used.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        self.check()?;
        let world = World::new(NAME, samples, seed, without, &self.factors, &REMOVABLE)?;
        let (families, objects) = load(self.meshes.as_deref(), SIZE)?;
        let by_family = by_class(families.len(), &objects);
        let (class_names, count) = match self.classes {
            VisionClasses::Object => {
                (objects.iter().map(|object| object.name.clone()).collect(), objects.len())
            }
            VisionClasses::Family => (families.clone(), families.len()),
        };
        let object = |i: usize| match self.classes {
            VisionClasses::Object => i % count,
            VisionClasses::Family => in_turn(&by_family, i),
        };
        let mut x = Array4::zeros((samples, 3, self.pixels, self.pixels));
        let truth = each_sample(&mut x, |i, image| {
            let look = look(&world, i);
            picture(&objects[object(i)].mesh, SIZE, &look, image);
            look.truth()
        });
        Ok(Scene {
            x: x.into_dyn(),
            streams: Vec::new(),
            layout: Layout::Colour,
            y: (0..samples).map(|i| (i % count) as u32).collect(),
            group: (0..samples).map(|i| object(i) as u32).collect(),
            class_names,
            channel_names: ["red", "green", "blue"].map(String::from).to_vec(),
            unit: "brightness",
            full_scale: 1.0,
            rest: vec![0.0],
            truth: columns(&Appearance::TRUTH, &truth),
            test: None,
            attributes: None,
        })
    }
}

/// Draws the appearance of sample `i`; an effect that is left out has its plainest value.
fn look(world: &World, i: usize) -> Appearance {
    let draw = |effect: &str| {
        let mut rng = world.rng(&format!("{i}/{effect}"));
        std::array::from_fn::<f64, 12, _>(|_| rng.random::<f64>())
    };
    let (pose, light) = (draw("pose"), draw("light"));
    let posed = world.has("pose");
    let roll = if posed { ROLL.between(pose[2]).to_radians() } else { 0.0 };
    let shift = [pose[4], pose[5]].map(|share| if posed { SHIFT.between(share) } else { 0.0 });
    let lit = world.has("light");
    Appearance {
        azimuth: if posed { AZIMUTH.between(pose[0]) } else { 30.0 }.to_radians(),
        elevation: if posed { ELEVATION.between(pose[1]) } else { 20.0 }.to_radians(),
        roll,
        zoom: if posed { ZOOM.between(pose[3]) } else { 0.9 },
        shift,
        // Turn about the line of sight, and how far the lamp stands from it.
        lamp: if lit { [TAU * light[0], LAMP.between(light[1]).to_radians()] } else { [0.9, 0.7] },
        ambient: if lit { AMBIENT.between(light[2]) } else { 0.3 },
        texture: world.has("texture").then(|| draw("texture")),
        background: world.has("background").then(|| draw("background")),
    }
}

/// Lists all parameters, as `taxel simulate vision --explain` prints them.
pub(crate) fn explain() -> Vec<Effect> {
    rows(parameters::table(), &REMOVABLE)
}
