//! A flat array of sensing elements pressed against an object: its imprint, and pictures of it.
//!
//! # Reference
//!
//! The virtual tactile sensor of Rouhafzay et al. 2021, section 3.3: a plane tangent
//! to a triangular mesh at the probed point, n × n sensing elements on it, the distance of each to
//! the surface along the plane's normal, normalised to 0..1; 30 objects of six classes, as many
//! imprints of each; 128 × 128 elements, beside a real array of 16 × 16 on 6.5 cm².
//!
//! # Departures
//!
//! - A reading is 1 where the array touches and 0 where the object is `depth_mm` away or missing:
//!   one minus the distance, so that no contact reads 0 as on every other sensor.
//! - In a hollow the tangent plane would cut into the object. A real array stops where its first
//!   element touches: the plane is moved along the normal until one does, and points that then lie
//!   out of reach are never probed.
//! - The paper's meshes and their sizes are not published: see `docs/scenes/imprint.md`.
//!
//! # What tells the class
//!
//! The shape of a patch of 25 mm: the curvature of fingers and of chair legs, edges of wings,
//! corners. Most patches of a round body say little, whatever the object.

mod view;

use std::f64::consts::TAU;
use std::path::PathBuf;

use crate::Layout;
use crate::shapes::mesh::RayGrid;
use crate::shapes::touch::{TRIES, touch};
use crate::shapes::vector::Vector;
use crate::shapes::{MeshObject, by_class, in_turn, load};
use crate::world::{Factors, Removable, World, each_sample};
use crate::{Effect, Error, Result, Scene};
use ndarray::{Array3, Array4, ArrayViewMut2};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use taxel_base::FileError;
use taxel_base::seed::rng;

/// Name of the scene.
pub(crate) const NAME: &str = "imprint";
/// Lowest and highest camera, in degrees above the horizon.
const ELEVATION: [f64; 2] = [-10.0, 50.0];
const REMOVABLE: Removable = Removable { graded: &["spin"], switched: &[] };

/// Settings of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Imprint {
    /// Sensing elements along a side, 1 to 1024.
    pub elements: usize,
    /// Distance between elements in mm; none shares a side of 25.5 mm among them.
    pub pitch_mm: Option<f64>,
    /// How far from the array a surface is still felt, in mm.
    pub depth_mm: f64,
    /// Every object is brought to this size: corner to corner of its bounding box, in mm.
    pub size_mm: f64,
    /// A folder of own meshes (OBJ, STL, OFF): one sub-folder per class, or one file per class.
    pub meshes: Option<PathBuf>,
    /// Pixels along a side of the picture that goes with each imprint; 0 for none.
    pub view: usize,
    /// How much of an effect there is: `{ placement = 0.5 }` halves it, 0 leaves it out, 1 keeps it. Default 1 for every one.
    #[serde(skip_serializing_if = "Factors::is_empty")]
    pub factors: Factors,
}

impl Default for Imprint {
    fn default() -> Self {
        Self {
            elements: 128,
            pitch_mm: None,
            depth_mm: 10.0,
            size_mm: 200.0,
            meshes: None,
            view: 0,
            factors: Factors::new(),
        }
    }
}

/// Side of the real array: 6.5 cm².
const SIDE: f64 = 25.5;

/// Where and how the array touches an object.
struct Probe {
    point: Vector,
    normal: Vector,
    /// Turn of the array about the normal, in radians.
    spin: f64,
    /// How far out of the tangent plane the first element touches, in mm; a little below 0 where
    /// the point itself lies between elements.
    lift: f64,
}

impl Imprint {
    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        let reject = |name, value: String, expected| Err(Error::Parameter { name, value, expected });
        if !(1..=1024).contains(&self.elements) {
            return reject("elements", self.elements.to_string(), "must be in 1..=1024");
        }
        if self.view > 1024 {
            return reject("view", self.view.to_string(), "must be in 0..=1024 pixels; 0 for no pictures");
        }
        let lengths = [("pitch_mm", self.pitch()), ("depth_mm", self.depth_mm), ("size_mm", self.size_mm)];
        // Written as "not inside" so that NaN fails too.
        match lengths.into_iter().find(|(_, mm)| !(1e-3..=1e5).contains(mm)) {
            Some((name, mm)) => reject(name, mm.to_string(), "must be in 0.001..=100000 mm"),
            None => Ok(()),
        }
    }

    fn pitch(&self) -> f64 {
        self.pitch_mm.unwrap_or(SIDE / self.elements as f64)
    }

    /// Simulates imprints `[samples, elements, elements]` in 0..1, and pictures
    /// `[samples, 3, view, view]` in 0..1 as stream `view`.
    ///
    /// Sample i is of class `i % classes`; the objects of a class, which are the groups, take
    /// turns. Truth: `point_<x|y|z>_mm` from the middle of the object, `normal_<x|y|z>`,
    /// `spin_deg`, `lift_mm` (how far out of the tangent plane the first element touches), and with
    /// pictures `azimuth_deg` and `elevation_deg` of the camera.
    ///
    /// # Errors
    ///
    /// Those of [`Imprint::check`]; [`Error::Parameter`] for zero samples; [`Error::UnknownEffect`]
    /// for a name in `without` that is not a removable effect; [`Error::Mesh`] for a mesh that
    /// cannot be used.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        self.check()?;
        let world = World::new(NAME, samples, seed, without, &self.factors, &REMOVABLE)?;
        let (class_names, objects) = load(self.meshes.as_deref(), self.size_mm)?;
        let by_class = by_class(class_names.len(), &objects);
        let object = |i: usize| in_turn(&by_class, i);

        let mut x = Array3::zeros((samples, self.elements, self.elements));
        let press = |i, imprint: ArrayViewMut2<f32>| self.press(&objects[object(i)], &world, i, imprint);
        let probes: Vec<Probe> = each_sample(&mut x, press).into_iter().collect::<Result<_>>()?;
        let mut truth: Vec<(String, Vec<f32>)> = Vec::new();
        let mut add = |name: &str, value: &dyn Fn(&Probe) -> f64| {
            truth.push((name.into(), probes.iter().map(|probe| value(probe) as f32).collect()));
        };
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            add(&format!("point_{name}_mm"), &|probe| probe.point[axis]);
        }
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            add(&format!("normal_{name}"), &|probe| probe.normal[axis]);
        }
        add("spin_deg", &|probe| probe.spin.to_degrees());
        add("lift_mm", &|probe| probe.lift);

        let mut streams = Vec::new();
        if self.view > 0 {
            let (pictures, cameras) = self.pictures(samples, seed, &objects, &object);
            streams.push(("view".into(), pictures.into_dyn()));
            for (axis, name) in ["azimuth_deg", "elevation_deg"].into_iter().enumerate() {
                truth.push((name.into(), cameras.iter().map(|c| c[axis].to_degrees() as f32).collect()));
            }
        }
        Ok(Scene {
            x: x.into_dyn(),
            streams,
            layout: Layout::Image,
            y: (0..samples).map(|i| (i % class_names.len()) as u32).collect(),
            group: (0..samples).map(|i| object(i) as u32).collect(),
            class_names,
            channel_names: Vec::new(),
            unit: "closeness",
            full_scale: 1.0,
            rest: vec![0.0],
            truth,
            test: None,
            attributes: None,
        })
    }

    /// Presses the array against a random point of the object.
    fn press(
        &self,
        object: &MeshObject,
        world: &World,
        sample: usize,
        mut imprint: ArrayViewMut2<f32>,
    ) -> Result<Probe> {
        let mut place = world.rng(&format!("{sample}/point"));
        let spin = world.unless("spin", TAU * world.rng(&format!("{sample}/spin")).random::<f64>(), 0.0);
        let grid = RayGrid { side: self.elements, pitch: self.pitch() };
        let Some(touch) = touch(&object.mesh, &mut place, spin, grid, self.depth_mm) else {
            let reason = format!(
                "no point of {TRIES} can be reached by a flat array of {:.1} mm that feels {} mm deep; use a smaller array",
                self.pitch() * self.elements as f64,
                self.depth_mm
            );
            return Err(FileError::new(object.name.as_ref(), reason).into());
        };
        for (reading, gap) in imprint.iter_mut().zip(touch.gaps) {
            *reading = gap.map_or(0.0, |gap| 1.0 - gap / self.depth_mm).clamp(0.0, 1.0) as f32;
        }
        Ok(Probe { point: touch.point, normal: touch.normal, spin, lift: touch.lift })
    }

    /// Draws a picture of each sample's object from a random side; returns with them where the camera stood.
    fn pictures(
        &self,
        samples: usize,
        seed: u64,
        objects: &[MeshObject],
        object: &(dyn Fn(usize) -> usize + Sync),
    ) -> (Array4<f32>, Vec<[f64; 2]>) {
        let mut pictures = Array4::zeros((samples, 3, self.view, self.view));
        let cameras = each_sample(&mut pictures, |i, picture| {
            let mut rng = rng(seed, &format!("{NAME}/{i}/camera"));
            let [low, high] = ELEVATION.map(f64::to_radians);
            let (azimuth, elevation) = (TAU * rng.random::<f64>(), low + (high - low) * rng.random::<f64>());
            view::render(&objects[object(i)].mesh, self.size_mm, azimuth, elevation, picture);
            [azimuth, elevation]
        });
        (pictures, cameras)
    }
}

/// Lists all parameters, as `taxel simulate imprint --explain` prints them.
pub(crate) fn explain() -> Vec<Effect> {
    let default = Imprint::default();
    [effects_of_the_array(&default), effects_of_objects(&default)].concat()
}

fn effect(name: &str, parameter: &str, value: String, unit: &str, source: &str, why: &str) -> Effect {
    Effect {
        name: name.into(),
        parameter: parameter.into(),
        value,
        unit: unit.into(),
        source: source.into(),
        why: why.into(),
        removable: REMOVABLE.has(name),
    }
}

fn effects_of_the_array(default: &Imprint) -> Vec<Effect> {
    let paper = "Rouhafzay et al. 2021, section 3.3";
    vec![
        effect(
            "array",
            "elements",
            format!("{0} × {0}", default.elements),
            "",
            paper,
            "resolution of the imprint",
        ),
        effect(
            "array",
            "pitch_mm",
            format!("{SIDE} / elements"),
            "mm",
            "Rouhafzay et al. 2021, section 3.3: the real array has 6.5 cm²; taken for the virtual one too",
            "a patch, not the object: other resolutions feel the same patch",
        ),
        effect(
            "array",
            "depth_mm",
            default.depth_mm.to_string(),
            "mm",
            "assumed: the paper normalises distances and does not say by what",
            "curvature becomes contrast; what is farther away is not felt",
        ),
    ]
}

fn effects_of_objects(default: &Imprint) -> Vec<Effect> {
    vec![
        effect(
            "object",
            "size_mm",
            default.size_mm.to_string(),
            "mm, corner to corner",
            "assumed",
            "how much of an object a patch is",
        ),
        effect(
            "object",
            "meshes",
            "6 classes of 5".into(),
            "objects",
            "Rouhafzay et al. 2021, section 3.3, names the classes; the shapes are ours",
            "objects of a class differ: whole objects are left out for a test",
        ),
        effect(
            "probing",
            "point",
            "uniform over the surface".into(),
            "",
            "assumed: the paper does not say where it probes",
            "most patches of an object tell little",
        ),
        effect(
            "spin",
            "turn about the normal",
            "0 to 360".into(),
            "degrees, uniform",
            "assumed: an arm may come with any turn of its wrist",
            "edges and ridges run in any direction",
        ),
        effect(
            "camera",
            "azimuth; elevation",
            format!("0 to 360; {} to {}", ELEVATION[0], ELEVATION[1]),
            "degrees, uniform",
            "assumed: the paper says a virtual camera",
            "the visual stream of the same object",
        ),
    ]
}

#[cfg(test)]
mod tests;
