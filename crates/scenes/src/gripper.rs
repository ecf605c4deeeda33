//! Two fingers with pressure sensors squeeze, hold and release 30 everyday objects.
//!
//! # Reference
//!
//! Zhang et al. 2022 (Identifying the strength level of objects' tactile attributes), section 3: SynTouch
//! NumaTac sensors on both fingers of a Kinova gripper; per finger and tick of 10 ms one DC value of
//! the fluid pressure (100 Hz) and 22 AC values of its vibration (2200 Hz), in raw bits. The gripper
//! closes at constant speed until one DC value reaches 270 bit, runs on for the delay of the command,
//! holds, and opens. Every object has a level of elasticity and one of hardness, 1 to 10.
//!
//! The physics: object and foam in series, `F = K (depth - flow)`, with `K = k k_s / (k + k_s)`; the
//! object flows towards a share of its indentation (a standard linear solid), `d flow/dt = (g d - flow)
//! / tau`; DC is proportional to F; AC is the pressure above 10 Hz and the decaying ring of the first
//! touch.
//!
//! # What tells the levels
//!
//! Hardness: how fast pressure rises, and how far it overshoots the stop. Elasticity: how much fades
//! in the hold, how early contact ends, how long the tap rings. Of a hard object the foam takes nearly
//! all indentation, so that its elasticity hardly shows but in the ring.
//!
//! # What is left out
//!
//! Temperature, slip, the arm's own motion, the motor's hum (with one, no method did better or worse), and shape: the fluid pressure does not know where it is
//! touched.

mod objects;
mod parameters;
mod recording;

pub(crate) use parameters::explain;

use crate::Layout;
use crate::world::{Factors, World, columns};
use crate::{Attributes, Error, Result, Scene};
use ndarray::{Array2, Array4};
use objects::{GraspedObject, OBJECTS};
use parameters::*;
use rayon::prelude::*;
use recording::{GripperGrasp, Material};
use serde::{Deserialize, Serialize};

/// Name of the scene.
pub(crate) const NAME: &str = "gripper";

/// Settings of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Gripper {
    /// Names of the objects, in any order; each once. Default all 30.
    pub objects: Option<Vec<String>>,
    /// Sessions, at least 1. They take turns: sample i is of session `(i / objects) % sessions`.
    pub sessions: u32,
    /// How much of an effect there is: `{ placement = 0.5 }` halves it, 0 leaves it out, 1 keeps it. Default 1 for every one.
    #[serde(skip_serializing_if = "Factors::is_empty")]
    pub factors: Factors,
}

impl Default for Gripper {
    /// Returns all objects in five sessions (which the paper does not report).
    fn default() -> Self {
        Self { objects: None, sessions: 5, factors: Factors::new() }
    }
}

const TRUTH: [&str; 11] = [
    "session",
    "elasticity_level",
    "hardness_level",
    "stiffness_n_per_mm",
    "relaxing_share",
    "contact_s",
    "stop_s",
    "peak_force_left_n",
    "peak_force_right_n",
    "dc_rest_left_bit",
    "dc_rest_right_bit",
];

impl Gripper {
    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        if self.sessions == 0 {
            let expected = "must be at least 1";
            return Err(Error::Parameter { name: "sessions", value: "0".into(), expected });
        }
        self.chosen().map(|_| ())
    }

    fn chosen(&self) -> Result<Vec<&'static GraspedObject>> {
        let Some(names) = &self.objects else { return Ok(OBJECTS.iter().collect()) };
        let reject = |value: String, expected| Err(Error::Parameter { name: "objects", value, expected });
        if names.is_empty() {
            return reject("[]".into(), "name at least one object");
        }
        let mut chosen = Vec::new();
        for (i, name) in names.iter().enumerate() {
            if names[..i].contains(name) {
                return reject(name.clone(), "each object is named once");
            }
            match OBJECTS.iter().find(|object| object.name == name) {
                Some(object) => chosen.push(object),
                None => {
                    return reject(
                        name.clone(),
                        "is none of the 30 objects that the explanation of scene gripper lists",
                    );
                }
            }
        }
        Ok(chosen)
    }

    /// Simulates grasps as raw bits `[samples, 2 fingers, 1 DC + 22 AC, 450 ticks]`, whole numbers
    /// 0..=4095; contact comes after 0.4 to 0.9 s.
    ///
    /// Sample i is of object `i % objects`, which is its group. `attributes` holds the indices of the
    /// levels of elasticity and hardness, `y` the first. Truth: `session`, both levels, `stiffness_n_per_mm`,
    /// `relaxing_share`, `contact_s` (first touch), `stop_s`, `peak_force_<finger>_n` and
    /// `dc_rest_<finger>_bit`.
    ///
    /// # Errors
    ///
    /// Those of [`Gripper::check`]; [`Error::Parameter`] for zero samples; [`Error::UnknownEffect`] for
    /// a name in `without` that is not a removable effect.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        self.check()?;
        let world = World::new(NAME, samples, seed, without, &self.factors, &REMOVABLE)?;
        let objects = self.chosen()?;
        let shape = [2, BURST.get() as usize + 1, RECORDED.get() as usize];
        let mut x = vec![0.0; samples * shape.iter().product::<usize>()];
        let truth: Vec<Vec<f64>> = x
            .par_chunks_exact_mut(shape.iter().product())
            .enumerate()
            .map(|(i, recording)| {
                let session = i / objects.len() % self.sessions as usize;
                grasp(&world, i, session, objects[i % objects.len()], recording)
            })
            .collect();
        let levels = [
            objects.iter().map(|object| object.elasticity).collect(),
            objects.iter().map(|object| object.hardness).collect(),
        ];
        let attributes = attributes(&levels, samples);
        #[expect(clippy::expect_used, reason = "x was made with so many values")]
        let x = Array4::from_shape_vec((samples, shape[0], shape[1], shape[2]), x)
            .expect("as many values as made");
        Ok(Scene {
            x: x.into_dyn(),
            streams: Vec::new(),
            layout: Layout::Fingers,
            y: attributes.y.column(0).to_vec(),
            group: (0..samples).map(|i| (i % objects.len()) as u32).collect(),
            class_names: attributes.class_names[0].clone(),
            channel_names: vec!["left".into(), "right".into()],
            unit: "bits",
            full_scale: CONVERTER.get() as f32,
            rest: [rest(), rest()].concat(),
            truth: columns(&TRUTH, &truth),
            test: None,
            attributes: Some(attributes),
        })
    }
}

/// Returns one finger's channels at rest: DC, then AC. Sessions differ by a few bits.
fn rest() -> Vec<f32> {
    let ac = std::iter::repeat_n(AC_OFFSET.get() as f32, BURST.get() as usize);
    std::iter::once(DC_OFFSET.get() as f32).chain(ac).collect()
}

fn grasp(world: &World, i: usize, session: usize, object: &GraspedObject, recording: &mut [f32]) -> Vec<f64> {
    // From 0 at level 10 to 1 at level 1.
    let dull = f64::from(10 - object.elasticity) / 9.0;
    let between = |ends: &[f64]| ends[0] + (ends[1] - ends[0]) * dull;
    let level = PER_LEVEL.get().powi(i32::from(object.hardness) - 1);
    let stiffness = SOFTEST.get() * level * WITHIN.value[object.place()];
    let relaxed = world.unless("relaxation", between(RELAXED.value), 0.0);
    let material = Material { stiffness, relaxed, damping: between(TAP_DAMPING.value) };
    let grasp = GripperGrasp::draw(world, i, session, material);
    let outcome = grasp.record(world, i, recording);
    vec![
        session as f64,
        f64::from(object.elasticity),
        f64::from(object.hardness),
        stiffness,
        relaxed,
        grasp.contact,
        outcome.stop,
        outcome.peak[0],
        outcome.peak[1],
        grasp.rest()[0],
        grasp.rest()[1],
    ]
}

/// Returns the labels of both attributes: indices into the levels that the chosen objects have.
fn attributes(levels: &[Vec<u8>; 2], samples: usize) -> Attributes {
    let present = levels.each_ref().map(|levels| {
        let mut present = levels.clone();
        present.sort_unstable();
        present.dedup();
        present
    });
    let index = |(i, attribute): (usize, usize)| {
        let level = levels[attribute][i % levels[attribute].len()];
        present[attribute].partition_point(|&other| other < level) as u32
    };
    let names = |attribute: usize, name: &str| {
        present[attribute].iter().map(|level| format!("{name}-{level}")).collect()
    };
    Attributes {
        y: Array2::from_shape_fn((samples, 2), index),
        class_names: vec![names(0, "elasticity"), names(1, "hardness")],
    }
}
