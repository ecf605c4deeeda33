//! A camera behind a coated gel looks at what is pressed into it: objects and cloths.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021, sections 3.1 and 3.2: twelve clothes under a GelSight (ViTac) and ten objects
//! under a BathTip (VT-60). How such a sensor sees: M. K. Johnson and E. H. Adelson, "Retrographic sensing for the
//! measurement of surface texture and shape", CVPR 2009; D. F. Gomes, P. Paoletti and S. Luo, "Generation of GelSight
//! tactile images for sim2real learning", 2021. What cloths look like: F. T. Peirce, "The geometry of cloth structure",
//! Journal of the Textile Institute 28, 1937.
//!
//! # Departures
//!
//! - The recordings and their shapes are not at hand. The objects are the thirty in six classes of
//!   [`imprint`](crate::imprint), probed in the same way: the same touches by another sensor.
//! - The twelve cloths are weaves and knits of ours; the paper does not name its own.
//! - One flat gel for both. The BathTip is a hemisphere without coloured lamps, and less sensitive.
//! - A gel that is pressed in gives way as deep as the object goes: no stiffness of either.
//!
//! # What tells the class
//!
//! Of objects what tells it in `imprint`, curvature and edges, but as slopes of the one or two millimetres next to
//! the first touch. Of cloths which yarn lies on top: pieces of every weave are coarse and fine.

mod camera;
mod cloth;
mod parameters;

use std::f64::consts::TAU;
use std::path::PathBuf;

use ndarray::{Array3, Array4, ArrayViewMut3};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use taxel_base::FileError;

use self::camera::{Dent, FULL_SCALE, rest};
use self::cloth::CLOTHS;
use self::parameters::{DEPTH, NOISE, PIECES, PITCH, SIDE_CLOTHS, SIDE_OBJECTS};
use crate::parameters::rows;
use crate::shapes::mesh::RayGrid;
use crate::shapes::touch::{TRIES, touch};
use crate::shapes::{MeshObject, by_class, in_turn, load};
use crate::world::{Factors, Removable, World, columns, each_sample, normal};
use crate::{Effect, Error, Layout, Result, Scene};

/// Name of the scene.
pub(crate) const NAME: &str = "gel";
const REMOVABLE: Removable =
    Removable { graded: &["depth", "noise", "spin", "piece"], switched: &["membrane"] };
/// Objects are this large from corner to corner, in mm, as in `imprint`.
const SIZE: f64 = 200.0;
/// Places of the gel along the side of a pixel: yarns are finer than pixels may be.
const FINER: usize = 2;
const TRUTH: [&str; 3] = ["depth_mm", "spin_deg", "pitch_mm"];

/// Settings of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Gel {
    /// The things that are pressed into the gel.
    pub touches: Touches,
    /// Pixels along a side, 8 to 512.
    pub pixels: usize,
    /// A folder of own meshes (OBJ, STL, OFF) in place of the objects: one sub-folder per class, or one file per class.
    pub meshes: Option<PathBuf>,
    /// How much of an effect there is: `{ placement = 0.5 }` halves it, 0 leaves it out, 1 keeps it. Default 1 for every one.
    #[serde(skip_serializing_if = "Factors::is_empty")]
    pub factors: Factors,
}

/// The things that are pressed into the gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Touches {
    /// Thirty objects of six classes; the objects are the groups.
    Objects,
    /// Twelve cloths; the pieces are the groups.
    Cloths,
}

impl Default for Gel {
    fn default() -> Self {
        Self { touches: Touches::Cloths, pixels: 64, meshes: None, factors: Factors::new() }
    }
}

/// Takes the picture of a sample and returns its truth.
type TakePicture<'a> = dyn Fn(usize, ArrayViewMut3<f32>) -> Result<Vec<f64>> + Sync + 'a;

/// The quantities that differ from touch to touch.
struct Press {
    /// How deep the first point goes, in mm.
    depth: f64,
    /// Turn about the normal, in radians.
    spin: f64,
}

impl Gel {
    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        let reject = |name, value: String, expected| Err(Error::Parameter { name, value, expected });
        if !(8..=512).contains(&self.pixels) {
            return reject("pixels", self.pixels.to_string(), "must be in 8..=512");
        }
        if let (Touches::Cloths, Some(folder)) = (self.touches, &self.meshes) {
            let expected = "cloths have no meshes; take touches = \"objects\" or leave meshes out";
            return reject("meshes", folder.display().to_string(), expected);
        }
        Ok(())
    }

    /// Simulates pictures `[samples, 3 colours, pixels, pixels]` in whole counts, 0..=255.
    ///
    /// Sample i is of class `i % classes`; the objects of a class, or its pieces, take turns, and are the groups.
    /// Truth: `depth_mm`, `spin_deg` and, of cloths, `pitch_mm` of the yarns.
    ///
    /// # Errors
    ///
    /// Those of [`Gel::check`]; [`Error::Parameter`] for zero samples; [`Error::UnknownEffect`] for a name in
    /// `without` that is not a removable effect; [`Error::Mesh`] for a mesh that cannot be used.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        self.check()?;
        let world = World::new(NAME, samples, seed, without, &self.factors, &REMOVABLE)?;
        match self.touches {
            Touches::Objects => self.objects(&world, samples),
            Touches::Cloths => self.cloths(&world, samples),
        }
    }

    fn objects(&self, world: &World, samples: usize) -> Result<Scene> {
        let (names, objects) = load(self.meshes.as_deref(), SIZE)?;
        let by_class = by_class(names.len(), &objects);
        let object = |i: usize| in_turn(&by_class, i);
        let grid = self.grid(SIDE_OBJECTS.get());
        let one = |i: usize, picture: ArrayViewMut3<f32>| {
            let press = press(world, i);
            let depth = pressed(&objects[object(i)], world, i, &press, grid)?;
            self.look(world, i, Dent { depth, side: grid.side, pitch: grid.pitch }, picture);
            Ok(vec![press.depth, press.spin.to_degrees()])
        };
        self.scene(samples, names, &object, &TRUTH[..2], &one)
    }

    fn cloths(&self, world: &World, samples: usize) -> Result<Scene> {
        let pieces = PIECES.get() as usize;
        let piece = |i: usize| i % CLOTHS.len() * pieces + i / CLOTHS.len() % pieces;
        let grid = self.grid(SIDE_CLOTHS.get());
        let one = |i: usize, picture: ArrayViewMut3<f32>| {
            let press = press(world, i);
            let share = world.rng(&format!("piece/{}", piece(i))).random::<f64>();
            let pitch = world.unless("piece", PITCH.log_between(share), 1.0);
            let depth = laid(CLOTHS[i % CLOTHS.len()].1, world, i, &press, grid, pitch);
            self.look(world, i, Dent { depth, side: grid.side, pitch: grid.pitch }, picture);
            Ok(vec![press.depth, press.spin.to_degrees(), pitch])
        };
        self.scene(samples, CLOTHS.map(|(name, _)| name.to_string()).to_vec(), &piece, &TRUTH, &one)
    }

    /// Returns the places of a gel of this side, in mm.
    fn grid(&self, side: f64) -> RayGrid {
        RayGrid { side: self.pixels * FINER, pitch: side / (self.pixels * FINER) as f64 }
    }

    /// Takes the picture of a dent.
    fn look(&self, world: &World, i: usize, dent: Dent, mut picture: ArrayViewMut3<f32>) {
        let side = dent.side;
        let dent = if world.has("membrane") { dent.smoothed() } else { dent };
        let mut sum = Array3::<f64>::zeros((3, self.pixels, self.pixels));
        for (place, colours) in dent.lit().enumerate() {
            for (colour, value) in colours.into_iter().enumerate() {
                sum[[colour, place / side / FINER, place % side / FINER]] += value;
            }
        }
        let mut noise = world.rng(&format!("{i}/noise"));
        for (pixel, sum) in picture.iter_mut().zip(sum) {
            let noise = world.unless("noise", NOISE.get() * normal(&mut noise), 0.0);
            *pixel = (sum / (FINER * FINER) as f64 + noise).round().clamp(0.0, FULL_SCALE) as f32;
        }
    }

    fn scene(
        &self,
        samples: usize,
        class_names: Vec<String>,
        group: &dyn Fn(usize) -> usize,
        names: &[&str],
        one: &TakePicture,
    ) -> Result<Scene> {
        let mut x = Array4::zeros((samples, 3, self.pixels, self.pixels));
        let truth: Vec<Vec<f64>> = each_sample(&mut x, one).into_iter().collect::<Result<_>>()?;
        Ok(Scene {
            x: x.into_dyn(),
            streams: Vec::new(),
            layout: Layout::Colour,
            y: (0..samples).map(|i| (i % class_names.len()) as u32).collect(),
            group: (0..samples).map(|i| group(i) as u32).collect(),
            class_names,
            channel_names: ["red", "green", "blue"].map(String::from).to_vec(),
            unit: "8-bit counts",
            full_scale: FULL_SCALE as f32,
            rest: vec![rest() as f32],
            truth: columns(names, &truth),
            test: None,
            attributes: None,
        })
    }
}

fn press(world: &World, i: usize) -> Press {
    let share = world.rng(&format!("{i}/depth")).random::<f64>();
    let spin = TAU * world.rng(&format!("{i}/spin")).random::<f64>();
    Press { depth: world.unless("depth", DEPTH.between(share), 1.0), spin: world.unless("spin", spin, 0.0) }
}

/// Computes how deep an object dents the gel, place by place, in mm.
fn pressed(object: &MeshObject, world: &World, i: usize, press: &Press, grid: RayGrid) -> Result<Vec<f64>> {
    let mut place = world.rng(&format!("{i}/point"));
    // What lies deeper than the gel is pressed in does not touch it; what lies far out is out of reach as in `imprint`.
    let reach = 10.0;
    let Some(touch) = touch(&object.mesh, &mut place, press.spin, grid, reach) else {
        let reason = format!("no point of {TRIES} can be reached by a flat gel of {} mm", SIDE_OBJECTS.get());
        return Err(FileError::new(object.name.as_ref(), reason).into());
    };
    let dent = |gap: Option<f64>| gap.map_or(0.0, |gap| (press.depth - gap).max(0.0));
    Ok(touch.gaps.into_iter().map(dent).collect())
}

/// Computes how deep a cloth dents the gel, place by place, in mm.
fn laid(
    face: fn(f64, f64) -> f64,
    world: &World,
    i: usize,
    press: &Press,
    grid: RayGrid,
    pitch: f64,
) -> Vec<f64> {
    let mut place = world.rng(&format!("{i}/point"));
    // No repeat of a draft is longer than eight yarns.
    let from = [0, 1].map(|_| 8.0 * place.random::<f64>());
    let (sin, cos) = press.spin.sin_cos();
    let half = (grid.side as f64 - 1.0) / 2.0;
    let heights: Vec<f64> = (0..grid.side * grid.side)
        .map(|at| {
            let (x, y) = ((at % grid.side) as f64 - half, half - (at / grid.side) as f64);
            let (x, y) = (x * grid.pitch / pitch, y * grid.pitch / pitch);
            pitch * face(from[0] + cos * x - sin * y, from[1] + sin * x + cos * y)
        })
        .collect();
    let top = heights.iter().copied().fold(f64::MIN, f64::max);
    heights.into_iter().map(|height| (press.depth - (top - height)).max(0.0)).collect()
}

/// Lists all parameters, as `taxel simulate gel --explain` prints them.
pub(crate) fn explain() -> Vec<Effect> {
    rows(parameters::table(), &REMOVABLE)
}
