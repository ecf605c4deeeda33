//! A squeeze and release of 33 named objects on a pressure-sensing array.
//!
//! # Reference
//!
//! Gandarias et al. 2019b (Active tactile recognition of deformable objects): 9 deformable objects pressed by hand,
//! 10 frames of 28 x 50 taxels, 0 to 40 N in uneven steps. Pastor et al. 2019 (Robotic palpation): 24 objects,
//! rigid, deformable and in bags, squeezed by two underactuated fingers against the sensor under a
//! silicone pad; torque runs from 5 % to 90 % of 1.4 N m and back in random steps, 51 frames. The
//! physics, in files of their own: what the objects are (`objects`), the surface behind each taxel
//! (`surface`), the elastic bed and the pad (`press`), the fingers (`finger`).
//!
//! # What tells the objects
//!
//! The footprint at one force tells shape and stiffness, mixed: a stiff ball under little force looks
//! like a soft one under more. How the footprint grows tells them apart. A lump inside a sponge adds
//! nothing until the soft cover above it is squeezed away: at light force the twins give the same
//! readings to the last count.
//!
//! # What is left out
//!
//! Hysteresis and creep of foam and sensor, friction along the surface, gravity, the bag's foil, and
//! the fingers' own contact with the sensor's frame: none of the papers' claims depends on them.

mod finger;
mod objects;
mod parameters;
mod press;
mod surface;

pub(crate) use parameters::explain;

use crate::Layout;
use crate::world::{Factors, World, columns, normal};
use crate::{Error, Result, Scene};
use finger::Fingers;
use ndarray::Array4;
use objects::{ObjectKind, ObjectShape, PAPER_002, PAPER_003, SqueezedObject};
use parameters::*;
use press::{Bed, Drive};
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surface::{Heap, Placement, TAXELS, Taxels};
use taxel_base::seed::Rng;

/// Name of the scene.
pub(crate) const NAME: &str = "palpation";

/// Whose experiment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Paper {
    /// 9 deformable objects, pressed by hand, no pad, 10 frames.
    #[serde(rename = "002")]
    Manual,
    /// 24 objects, squeezed by a gripper, 51 frames.
    #[default]
    #[serde(rename = "003")]
    Gripper,
}

/// Which objects of Pastor et al. 2019.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Subset {
    /// Every object of the paper.
    #[default]
    All,
    /// Cans, bottles, mice, a wheel: 8.
    Rigid,
    /// Balls and sponges: 8; all 9 of Gandarias et al. 2019b.
    Deformable,
    /// Nuts, washers, gears, rivets, pipes: 8.
    InBag,
}

/// Settings of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Palpation {
    /// `002` or `003`. Default 003.
    pub paper: Paper,
    /// Which objects. Default all; Gandarias et al. 2019b has deformable ones only.
    pub subset: Subset,
    /// Frames of a squeeze and release, 3 to 1000. Default 10 (002) or 51 (003).
    pub frames: Option<usize>,
    /// Sessions, at least 1. They take turns: sample i is of session `(i / classes) % sessions`.
    pub sessions: u32,
    /// How much of an effect there is: `{ placement = 0.5 }` halves it, 0 leaves it out, 1 keeps it. Default 1 for every one.
    #[serde(skip_serializing_if = "Factors::is_empty")]
    pub factors: Factors,
}

impl Default for Palpation {
    /// Returns the scene of Pastor et al. 2019 in five sessions (which the paper does not report).
    fn default() -> Self {
        Self {
            paper: Paper::Gripper,
            subset: Subset::All,
            frames: None,
            sessions: 5,
            factors: Factors::new(),
        }
    }
}

impl Palpation {
    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        let reject = |name, value: String, expected| Err(Error::Parameter { name, value, expected });
        if self.sessions == 0 {
            return reject("sessions", "0".into(), "must be at least 1");
        }
        if !(3..=1000).contains(&self.frames()) {
            return reject(
                "frames",
                self.frames().to_string(),
                "must be 3 to 1000: first touch, squeeze, release",
            );
        }
        if self.paper == Paper::Manual && matches!(self.subset, Subset::Rigid | Subset::InBag) {
            let value = format!("{:?}", self.subset).to_lowercase();
            return reject(
                "subset",
                value,
                "paper = 002 has deformable objects only; use all, or paper = 003",
            );
        }
        Ok(())
    }

    /// Returns the number of frames of one recording.
    pub fn frames(&self) -> usize {
        self.frames.unwrap_or(match self.paper {
            Paper::Manual => 10,
            Paper::Gripper => 51,
        })
    }

    fn objects(&self) -> Vec<&'static SqueezedObject> {
        let all: &[SqueezedObject] = match self.paper {
            Paper::Manual => &PAPER_002,
            Paper::Gripper => &PAPER_003,
        };
        let wanted = |object: &&SqueezedObject| match self.subset {
            Subset::All => true,
            Subset::Rigid => object.kind == ObjectKind::Rigid,
            Subset::Deformable => object.kind == ObjectKind::Deformable,
            Subset::InBag => object.kind == ObjectKind::InBag,
        };
        all.iter().filter(wanted).collect()
    }

    /// Simulates squeezes as counts `[samples, frames, 28 rows, 50 columns]`, whole numbers 0..=255,
    /// 255 at 34 kPa.
    ///
    /// Sample i is of object `i % objects`. Truth: `session`, `subset` (0 rigid, 1 deformable, 2 in
    /// bag), `stiffness_kpa_per_mm` and `inclusions` of the object, `peak_force_n` and `peak_depth_mm`
    /// of the squeeze, `shift_along_mm`, `shift_across_mm`, `turn_deg`, `tilt_deg`, `sensitivity` and,
    /// for Pastor et al. 2019, `force_per_torque` (N per N m on the unsqueezed object; 0 for Gandarias et al. 2019b).
    ///
    /// # Errors
    ///
    /// Those of [`Palpation::check`]; [`Error::Parameter`] for zero samples;
    /// [`Error::UnknownEffect`] for a name in `without` that is not a removable effect.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        self.check()?;
        let world = World::new(NAME, samples, seed, without, &self.factors, &REMOVABLE)?;
        let (objects, frames) = (self.objects(), self.frames());
        let session = |i: usize| i / objects.len() % self.sessions as usize;
        let lab = Lab {
            world: &world,
            paper: self.paper,
            fingers: Fingers::new(),
            spread: press::spread(),
            taxels: surface::draws(world.rng("taxels")),
        };
        let (rows, columns_) = (ROWS.get() as usize, COLUMNS.get() as usize);
        let mut x = vec![0.0; samples * frames * TAXELS];
        let truth: Vec<Vec<f64>> = x
            .par_chunks_exact_mut(frames * TAXELS)
            .enumerate()
            .map(|(i, recording)| lab.squeeze(i, session(i), objects[i % objects.len()], recording))
            .collect();
        #[expect(clippy::expect_used, reason = "x was made with so many values")]
        let x = Array4::from_shape_vec((samples, frames, rows, columns_), x).expect("as many values as made");
        Ok(Scene {
            x: x.into_dyn(),
            streams: Vec::new(),
            layout: Layout::Sequence,
            y: (0..samples).map(|i| (i % objects.len()) as u32).collect(),
            group: (0..samples).map(|i| session(i) as u32).collect(),
            class_names: objects.iter().map(|object| object.name.into()).collect(),
            channel_names: Vec::new(),
            unit: "8-bit counts, 255 = 34 kPa",
            full_scale: LEVELS.get() as f32,
            rest: vec![0.0],
            truth: columns(&TRUTH, &truth),
            test: None,
            attributes: None,
        })
    }
}

const TRUTH: [&str; 12] = [
    "session",
    "subset",
    "stiffness_kpa_per_mm",
    "inclusions",
    "peak_force_n",
    "peak_depth_mm",
    "shift_along_mm",
    "shift_across_mm",
    "turn_deg",
    "tilt_deg",
    "sensitivity",
    "force_per_torque",
];

/// The sensor, and what presses.
struct Lab<'a> {
    world: &'a World<'a>,
    paper: Paper,
    fingers: Fingers,
    spread: [f32; 4],
    taxels: Vec<[f64; 2]>,
}

impl Lab<'_> {
    /// Fills one recording, frame by frame, and returns the true values in the order of [`TRUTH`].
    fn squeeze(&self, i: usize, session: usize, object: &SqueezedObject, recording: &mut [f32]) -> Vec<f64> {
        let world = self.world;
        let padded = self.paper == Paper::Gripper;
        let place = Placement::draw(world, i);
        let tilt = self.tilt(i);
        let mut heap = self.pack(i, object, place);
        let covers = surface::covers(object, &place).filter(|_| world.has("inclusions"));
        let gaps = |heap: Option<&Heap>| {
            let gaps = match heap {
                Some(heap) => heap.gaps(),
                None => surface::gaps(object, &place, world.has("texture")),
            };
            tilted(gaps, tilt)
        };
        let mut bed = Bed::new(object, padded, gaps(heap.as_ref()), covers);
        let mut slide = world.rng(&format!("{i}/bag-shift"));
        let mut noise = world.rng(&format!("{i}/noise"));
        let noisy = world.unless("noise", NOISE.get(), 0.0) as f32;
        let sensitivity = self.sensitivity(session);
        let gain = (LEVELS.get() / FULL_SCALE.get() * sensitivity) as f32;
        let grasp = surface::draws(world.rng(&format!("{i}/taxels")));
        let taxels = Taxels::new(world, &self.taxels, &grasp);
        let friction = self.friction(i);
        let (mut depth, mut deepest, mut strongest) = (1.0, 0.0_f32, 0.0_f32);
        let frames = recording.len() / TAXELS;
        let levels = self.levels(i, frames);
        for (values, level) in recording.chunks_exact_mut(TAXELS).zip(levels) {
            if let Some(heap) =
                heap.as_mut().filter(|_| slide.random::<f64>() < SLIDE.get() && world.has("bag-shift"))
            {
                heap.slide(&mut slide);
                bed.gaps = gaps(Some(heap));
            }
            let drive = self.drive(object, level, friction);
            depth = bed.sink(&drive, depth);
            let mut frame = [0.0; TAXELS];
            bed.pressures(depth, &mut frame);
            let force = frame.iter().sum::<f32>() * press::taxel_area();
            (deepest, strongest) = (deepest.max(depth), strongest.max(force));
            if padded && world.has("blur") {
                press::blur(&mut frame, &self.spread);
            }
            let taxels = taxels.gain.iter().zip(&taxels.rest);
            for ((value, pressure), (taxel_gain, rest)) in values.iter_mut().zip(frame).zip(taxels) {
                let electronic: f32 = noise.sample(StandardNormal);
                *value = counts(gain * taxel_gain * pressure + rest + noisy * electronic);
            }
        }
        self.truth(session, object, place, tilt, [strongest, deepest], [sensitivity, friction])
    }

    /// Returns the true values in the order of [`TRUTH`]; of all frames the strongest force and the deepest press.
    fn truth(
        &self,
        session: usize,
        object: &SqueezedObject,
        place: Placement,
        tilt: [f64; 2],
        [strongest, deepest]: [f32; 2],
        [sensitivity, friction]: [f64; 2],
    ) -> Vec<f64> {
        let padded = self.paper == Paper::Gripper;
        let unsqueezed = if padded { f64::from(self.fingers.force(object.thickness as f32).0) } else { 0.0 };
        let lumps = if self.world.has("inclusions") { object.inclusions.len() } else { 0 };
        vec![
            session as f64,
            f64::from(object.kind as u8),
            object.stiffness,
            lumps as f64,
            f64::from(strongest),
            f64::from(deepest),
            place.shift[0],
            place.shift[1],
            place.turn.to_degrees(),
            tilt[0].hypot(tilt[1]).to_degrees(),
            sensitivity,
            unsqueezed * SHARE.get() * friction,
        ]
    }

    fn pack(&self, i: usize, object: &SqueezedObject, place: Placement) -> Option<Heap> {
        let ObjectShape::Bag { half, count, items } = object.shape else { return None };
        // Without packing, the bag is as it was when it was filled.
        let is_repacked = self.world.has("packing");
        let purpose = if is_repacked { format!("{i}/packing") } else { format!("packing/{}", object.name) };
        Some(Heap::pack(half, count, items, place, &mut self.world.rng(&purpose)))
    }

    fn tilt(&self, i: usize) -> [f64; 2] {
        let mut rng = self.world.rng(&format!("{i}/tilt"));
        let mut angle = || self.world.unless("tilt", TILT.get().to_radians() * normal(&mut rng), 0.0);
        [angle(), angle()]
    }

    fn friction(&self, i: usize) -> f64 {
        let draw = normal(&mut self.world.rng(&format!("{i}/friction")));
        self.world.unless("friction", (FRICTION.get() * draw).exp(), 1.0)
    }

    fn sensitivity(&self, session: usize) -> f64 {
        let draw = normal(&mut self.world.rng(&format!("session/{session}")));
        self.world.unless("session", (GAIN.get() * draw).exp(), 1.0)
    }

    /// Draws the force in N (002), or the torque as a share of the largest (003), frame by frame.
    fn levels(&self, i: usize, frames: usize) -> Vec<f64> {
        let mut rng = self.world.rng(&format!("{i}/force-steps"));
        let [low, high] = match self.paper {
            Paper::Gripper => [TORQUE.value[0], TORQUE.value[1]],
            Paper::Manual => {
                let [least, most] = [PEAK.value[0], PEAK.value[1]];
                let peak = least + (most - least) * rng.random::<f64>();
                let peak = self.world.unless("force-steps", peak, most);
                [FIRST.get() * peak, peak]
            }
        };
        let top = (frames - 1) / 2;
        let uneven = self.world.unless("force-steps", STEP.get(), 0.0);
        let up = steps(top, uneven, &mut rng);
        let down = steps(frames - 1 - top, uneven, &mut rng);
        let share = up.into_iter().chain(down.into_iter().rev().skip(1));
        share.map(|share| low + (high - low) * share).collect()
    }

    fn drive(&self, object: &SqueezedObject, level: f64, friction: f64) -> Drive<'_> {
        match self.paper {
            Paper::Manual => Drive::Force(level as f32),
            Paper::Gripper => Drive::Fingers {
                fingers: &self.fingers,
                torque: (level * MOTOR.get() * SHARE.get() * friction) as f32,
                hold: HOLD.get() as f32,
                thickness: object.thickness as f32,
            },
        }
    }
}

/// Draws `n` uneven steps from 0 to 1: `n + 1` values.
fn steps(n: usize, uneven: f64, rng: &mut Rng) -> Vec<f64> {
    let steps: Vec<f64> = (0..n).map(|_| (uneven * normal(rng)).exp()).collect();
    let sum: f64 = steps.iter().sum();
    let mut at = 0.0;
    let mut values = vec![0.0];
    values.extend(steps.iter().map(|step| {
        at += step / sum;
        at
    }));
    values
}

/// Tilts the sensor that sees a surface: returns distances from the surface's new foremost point.
fn tilted(mut gaps: Vec<f32>, tilt: [f64; 2]) -> Vec<f32> {
    for (taxel, gap) in gaps.iter_mut().enumerate() {
        let [x, y] = surface::centre(taxel);
        *gap += (x * tilt[0].tan() + y * tilt[1].tan()) as f32;
    }
    let foremost = gaps.iter().copied().fold(f32::INFINITY, f32::min);
    gaps.iter_mut().for_each(|gap| *gap -= foremost);
    gaps
}

/// Converts as the converter does: whole counts, nothing below the threshold, nothing above full scale.
fn counts(value: f32) -> f32 {
    let counts = value.round();
    if counts < THRESHOLD.get() as f32 { 0.0 } else { counts.min(LEVELS.get() as f32) }
}
