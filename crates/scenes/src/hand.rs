//! A fingertip with impedance electrodes in a hand that grasps a box, a ball or a cylinder.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021, section 3.4: grasps of three objects by a Barrett hand (BiGS) whose fingertips
//! have electrodes under a skin filled with fluid; electrodes at 100 Hz are mapped to 7 × 3, and the first 700 frames
//! are read. Contact: the gap between two curved bodies near their first touch, of second order in the distance from
//! it, as in Hertz's theory.
//!
//! # Departures
//!
//! - The recordings are not at hand. One of the hand's three fingers is recorded.
//! - Skin and fluid give way exactly where the object goes: no bulge beside it. The object is rigid.
//! - Every grasp succeeds, as those that the paper chose. The hold is still: no skin that gives way with time, no slip
//!   when the object is lifted. No source gives their values, and assumed ones changed no method.
//!
//! # What tells the object
//!
//! How far from the first touch electrodes are pressed: on the box along the whole finger, on the cylinder across it,
//! on the ball neither. Grip and place scale and shift the same readings.

mod parameters;

use ndarray::{Array2, Array4, ArrayViewMut3, Axis};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use self::parameters::*;
use crate::parameters::{Parameter, rows};
use crate::world::{Factors, Removable, World, columns, each_sample, normal};
use crate::{Effect, Error, Layout, Result, Scene};

/// Name of the scene.
pub(crate) const NAME: &str = "hand";
const REMOVABLE: Removable = Removable { graded: &["placement", "grip", "session", "noise"], switched: &[] };
const OBJECTS: [&str; 3] = ["box", "ball", "cylinder"];
const ROWS: usize = 7;
const COLUMNS: usize = 3;
/// Frames and their rate in Hz (Rouhafzay et al. 2021, section 3.4).
const FRAMES: usize = 700;
const RATE: f64 = 100.0;
/// 12-bit converter.
const FULL_SCALE: f64 = 4095.0;
const TRUTH: [&str; 5] = ["depth_mm", "contact_s", "hold_s", "shift_along_mm", "shift_across_mm"];

/// Settings of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Hand {
    /// Sessions, at least 1. They take turns: sample i is of session `(i / 3) % sessions`.
    pub sessions: u32,
    /// Time steps of a sample, 1 to 700: the last ones. 1 is a single one in the hold.
    pub frames: usize,
    /// How much of an effect there is: `{ placement = 0.5 }` halves it, 0 leaves it out, 1 keeps it. Default 1 for every one.
    #[serde(skip_serializing_if = "Factors::is_empty")]
    pub factors: Factors,
}

impl Default for Hand {
    /// Returns ten sessions, which the paper does not report.
    fn default() -> Self {
        Self { sessions: 10, frames: FRAMES, factors: Factors::new() }
    }
}

/// The quantities that differ from grasp to grasp besides the object.
struct HandGrasp {
    depth: f64,
    contact: f64,
    hold: f64,
    /// Middle of contact on the finger, along and across, in mm.
    shift: [f64; 2],
    /// Turn of the cylinder, in radians.
    turn: f64,
}

impl Hand {
    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        let reject = |name, value: String, expected| Err(Error::Parameter { name, value, expected });
        match (self.sessions, self.frames) {
            (0, _) => reject("sessions", "0".into(), "must be at least 1"),
            (_, 1..=FRAMES) => Ok(()),
            (_, frames) => {
                reject("frames", frames.to_string(), "must be 1 to 700, the last ones of a recording")
            }
        }
    }

    /// Simulates grasps `[samples, frames, 7 along the finger, 3 across]` in whole counts, 0..=4095, at 100 Hz.
    ///
    /// Sample i is of object `i % 3`; groups are sessions. Truth: `depth_mm` of the hold, `contact_s`, `hold_s` (its
    /// begin), `shift_along_mm` and `shift_across_mm` of the contact.
    ///
    /// # Errors
    ///
    /// Those of [`Hand::check`]; [`Error::Parameter`] for zero samples; [`Error::UnknownEffect`] for a name in
    /// `without` that is not a removable effect.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        self.check()?;
        let world = World::new(NAME, samples, seed, without, &self.factors, &REMOVABLE)?;
        let session = |i: usize| i / OBJECTS.len() % self.sessions as usize;
        let mut x = Array4::zeros((samples, self.frames, ROWS, COLUMNS));
        let truth = each_sample(&mut x, |i, recording| {
            let grasp = HandGrasp::draw(&world, i);
            record(&world, i, session(i), &grasp, recording);
            grasp.truth()
        });
        Ok(Scene {
            x: x.into_dyn(),
            streams: Vec::new(),
            layout: Layout::Sequence,
            y: (0..samples).map(|i| (i % OBJECTS.len()) as u32).collect(),
            group: (0..samples).map(|i| session(i) as u32).collect(),
            class_names: OBJECTS.map(String::from).to_vec(),
            channel_names: Vec::new(),
            unit: "12-bit counts",
            full_scale: FULL_SCALE as f32,
            rest: vec![middle(&REST).round() as f32],
            truth: columns(&TRUTH, &truth),
            test: None,
            attributes: None,
        })
    }
}

impl HandGrasp {
    fn draw(world: &World, i: usize) -> Self {
        let mut grip = world.rng(&format!("{i}/grip"));
        let [depth, contact, closing] = std::array::from_fn(|_| grip.random::<f64>());
        let gripped = |range: &Parameter, share| world.unless("grip", range.between(share), middle(range));
        let mut place = world.rng(&format!("{i}/placement"));
        let mut placed = |sd: f64| world.unless("placement", sd * normal(&mut place), 0.0);
        let shift = [SHIFT.value[0], SHIFT.value[1]].map(&mut placed);
        let turn = placed(TURN.get()).to_radians();
        let contact = gripped(&CONTACT, contact);
        HandGrasp {
            depth: world.unless("grip", DEPTH.log_between(depth), middle(&DEPTH)),
            contact,
            hold: contact + gripped(&CLOSING, closing),
            shift,
            turn,
        }
    }

    fn truth(&self) -> Vec<f64> {
        vec![self.depth, self.contact, self.hold, self.shift[0], self.shift[1]]
    }

    /// Returns how deep the first touch is pressed in at a time in s, in mm; below 0 before contact.
    fn depth_at(&self, time: f64) -> f64 {
        self.depth * ((time - self.contact) / (self.hold - self.contact)).min(1.0)
    }
}

/// Returns the curvatures of an object on the finger in 1/mm: along, across, and of both together.
fn curvatures(object: usize, turn: f64) -> [f64; 3] {
    let (sin, cos) = turn.sin_cos();
    match OBJECTS[object] {
        "ball" => [1.0 / BALL.get(), 1.0 / BALL.get(), 0.0],
        "cylinder" => [cos * cos, sin * sin, cos * sin].map(|share| share / CYLINDER.get()),
        _ => [0.0; 3],
    }
}

fn record(world: &World, i: usize, session: usize, grasp: &HandGrasp, mut recording: ArrayViewMut3<f32>) {
    let [along, across, both] = curvatures(i % OBJECTS.len(), grasp.turn);
    let (along, across) = (along + 1.0 / FINGER.value[0], across + 1.0 / FINGER.value[1]);
    let (mut sensor, mut day) = (world.rng("electrodes"), world.rng(&format!("session/{session}")));
    let rest = Array2::from_shape_simple_fn((ROWS, COLUMNS), || {
        let electrode = REST.between(sensor.random::<f64>());
        electrode + world.unless("session", SESSION.get() * normal(&mut day), 0.0)
    });
    let mut noise = world.rng(&format!("{i}/noise"));
    let frames = recording.len_of(Axis(0));
    // Those before have noise too: the last ones are the same however many are kept.
    for _ in 0..(FRAMES - frames) * ROWS * COLUMNS {
        normal(&mut noise);
    }
    for (frame, mut readings) in recording.outer_iter_mut().enumerate() {
        let depth = grasp.depth_at((FRAMES - frames + frame) as f64 / RATE);
        for ((row, column), reading) in readings.indexed_iter_mut() {
            let x = (row as f64 - 3.0) * ALONG.get() - grasp.shift[0];
            let y = (column as f64 - 1.0) * ACROSS.get() - grasp.shift[1];
            let gap = (along * x * x + across * y * y) / 2.0 + both * x * y;
            let pressed = (depth - gap).max(0.0);
            let noise = world.unless("noise", NOISE.get() * normal(&mut noise), 0.0);
            let value = rest[[row, column]] - GAIN.get() * pressed + noise;
            *reading = value.round().clamp(0.0, FULL_SCALE) as f32;
        }
    }
}

fn middle(range: &Parameter) -> f64 {
    (range.value[0] + range.value[1]) / 2.0
}

/// Lists all parameters, as `taxel simulate hand --explain` prints them.
pub(crate) fn explain() -> Vec<Effect> {
    rows(table(), &REMOVABLE)
}
