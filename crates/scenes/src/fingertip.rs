//! Five fingertip FSRs of a tendon-driven hand closing on a silicone cylinder.
//!
//! # Reference
//!
//! The set-up is that of Kaewrakmuk and Srinonchat 2026, sections 4.1 and 4.2: one
//! FSR 402 on each fingertip of an InMoov-like hand, a preset closing motion, 50 raw 10-bit counts
//! per finger at 10 Hz, silicone cylinders of Shore A 00, 10 and 20. Section 5.4 names the nuisances:
//! finger geometry, gripping position and contact location. The physics:
//!
//! - hardness S to Young's modulus (A. N. Gent, "On the relation between indentation hardness and
//!   Young's modulus", Transactions of the Institution of the Rubber Industry 34, 1958, 46-57, in the
//!   form with Shore A that is in common use): `E = 0.0981 (56 + 7.62336 S) / (0.137505 (254 - 2.54 S))`
//!   MPa. It is used between about 20 and 80; 0 and 10 lie outside and are extrapolated;
//! - contact (Hertz): `F = 4/3 E* sqrt(R) d^1.5`, `E* = E / (1 - nu^2)`, `1/R = 1/tip + 1/object`;
//! - relaxation (one Prony term): a step of the elastic force decays as `1 - g (1 - exp(-t/tau))`;
//! - balance: servo, tendon and finger are a spring in series, `command - gap = d + F / k`;
//! - sensor: conductance `c F^b` of an FSR in a divider, `1023 G R / (1 + G R)` counts.
//!
//! # What tells hardness
//!
//! The plateau does, but placement and contact quality scale it too. What they leave alone is the
//! shape in time: against the finger's spring a soft object is squeezed to nearly the commanded
//! depth, so its force follows `d^1.5` and relaxes by nearly `g`; a hard one follows the spring,
//! linear and hardly relaxing.

mod parameters;

pub(crate) use parameters::explain;

use crate::Layout;
use crate::parameters::Parameter;
use crate::world::{Factors, World, normal};
use crate::{Error, Result, Scene};
use ndarray::Array3;
use parameters::*;
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// Name of the scene.
pub(crate) const NAME: &str = "fingertip";
/// Samples per recording and their spacing in s (Kaewrakmuk and Srinonchat 2026, section 4.2).
const STEPS: usize = 50;
const INTERVAL: f64 = 0.1;
/// Integration steps per reading.
const SUBSTEPS: usize = 5;
/// 10-bit converter of an Arduino Mega (Kaewrakmuk and Srinonchat 2026, section 4.2).
const FULL_SCALE: f64 = 1023.0;
const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];
const THUMB: usize = 0;

/// Settings of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Fingertip {
    /// Shore A hardness of each class; distinct, each in `[0, 95]`.
    pub shore: Vec<f32>,
    /// Draws the hardness of each sample evenly from this range, least and most, instead; its class is
    /// then the nearest in `shore`, and the truth `shore` is what to regress on.
    pub between: Option<[f32; 2]>,
    /// Share of the samples, the last ones, whose hardness is drawn from `between`, (0, 1). The others have the hardnesses of
    /// `shore`, and the drawn ones are marked for testing: hardnesses that no training has seen.
    pub unseen: Option<f32>,
    /// Sessions, at least 1. They take turns: sample i is of session `(i / classes) % sessions`.
    pub sessions: u32,
    /// How much of an effect there is: `{ placement = 0.5 }` halves it, 0 leaves it out, 1 keeps it. Default 1 for every one.
    #[serde(skip_serializing_if = "Factors::is_empty")]
    pub factors: Factors,
}

impl Default for Fingertip {
    /// Returns Kaewrakmuk and Srinonchat 2026's three levels, in ten sessions (which the paper does not report).
    fn default() -> Self {
        Self {
            shore: vec![0.0, 10.0, 20.0],
            between: None,
            unseen: None,
            sessions: 10,
            factors: Factors::new(),
        }
    }
}

impl Fingertip {
    /// Rejects impossible settings.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    pub fn check(&self) -> Result<()> {
        let reject = |name, value: String, expected| Err(Error::Parameter { name, value, expected });
        let listed = || format!("{:?}", self.shore);
        if self.sessions == 0 {
            return reject("sessions", "0".into(), "must be at least 1");
        }
        if self.shore.is_empty() {
            return reject("shore", listed(), "name at least one hardness");
        }
        // Gent's relation has a pole at 100.
        if !self.shore.iter().all(|s| (0.0..=95.0).contains(s)) {
            return reject("shore", listed(), "each Shore A hardness must be in [0, 95]");
        }
        let range = |[least, most]: [f32; 2]| least >= 0.0 && most <= 95.0 && least < most;
        if let Some(between) = self.between.filter(|between| !range(*between)) {
            let expected = "least and most Shore A hardness must be in [0, 95], the least first";
            return reject("between", format!("{between:?}"), expected);
        }
        if let Some(unseen) = self.unseen {
            if !(unseen > 0.0 && unseen < 1.0) {
                return reject(
                    "unseen",
                    unseen.to_string(),
                    "must be above 0 and below 1: a share of the samples",
                );
            }
            if self.between.is_none() {
                let expected = "needs the range that unseen hardnesses are drawn from: between = [0, 40]";
                return reject("unseen", unseen.to_string(), expected);
            }
        }
        let twice = |i: usize| self.shore[..i].contains(&self.shore[i]);
        if (0..self.shore.len()).any(twice) {
            return reject("shore", listed(), "each hardness is a class of its own and must differ");
        }
        Ok(())
    }

    /// Simulates grasps as raw counts `[samples, 5 fingers, 50 times]`, whole numbers 0..=1023.
    ///
    /// Sample i is of class `i % classes`, but see [`between`](Self::between). Truth: `shore`, `young_modulus_mpa`,
    /// `placement_shift_mm`, `placement_tilt_mm`, `hold_error_mm`, `start_error_s`,
    /// `hold_force_n` (sum over the fingers at the last reading) and
    /// `contact_quality_<finger>`.
    ///
    /// # Errors
    ///
    /// Those of [`Fingertip::check`]; [`Error::Parameter`] for zero samples;
    /// [`Error::UnknownEffect`] for a name in `without` that is not a removable effect.
    pub fn simulate(&self, samples: usize, seed: u64, without: &[String]) -> Result<Scene> {
        self.check()?;
        let world = World::new(NAME, samples, seed, without, &self.factors, &REMOVABLE)?;
        let known = self.known(samples)?;
        let mut x = Array3::zeros((samples, FINGERS.len(), STEPS));
        let (mut y, mut group) = (Vec::new(), Vec::new());
        let mut truth: Vec<(String, Vec<f32>)> = Vec::new();
        for (i, mut recording) in x.outer_iter_mut().enumerate() {
            let turn = i / self.shore.len();
            let (class, shore) = self.hardness(&world, i, i >= known);
            let session = turn % self.sessions as usize;
            let grasp = grasp(&world, i, session, turn / self.sessions as usize);
            let modulus = young_modulus(f64::from(shore));
            let mut noise = world.rng(&format!("{i}/noise"));
            let mut hold_force = 0.0;
            for (finger, mut series) in recording.outer_iter_mut().enumerate() {
                let forces = forces(&world, &grasp, finger, modulus);
                hold_force += forces[STEPS - 1];
                for (reading, force) in series.iter_mut().zip(forces) {
                    let counts = counts(force * grasp.quality[finger]);
                    let noise = world.unless("noise", NOISE.get() * normal(&mut noise), 0.0);
                    *reading = ((counts + noise).round().clamp(0.0, FULL_SCALE) + 0.0) as f32;
                }
            }
            y.push(class as u32);
            group.push(session as u32);
            let mut values = vec![
                ("shore".into(), f64::from(shore)),
                ("young_modulus_mpa".into(), modulus),
                ("placement_shift_mm".into(), grasp.shift),
                ("placement_tilt_mm".into(), grasp.tilt),
                ("hold_error_mm".into(), grasp.hold_error),
                ("start_error_s".into(), grasp.start_error),
                ("hold_force_n".into(), hold_force),
            ];
            let quality = FINGERS.iter().zip(grasp.quality);
            values.extend(quality.map(|(finger, q)| (format!("contact_quality_{finger}"), q)));
            if truth.is_empty() {
                truth = values.iter().map(|(name, _)| (String::clone(name), Vec::new())).collect();
            }
            for ((_, column), (_, value)) in truth.iter_mut().zip(values) {
                column.push(value as f32);
            }
        }
        Ok(Scene {
            x: x.into_dyn(),
            streams: Vec::new(),
            layout: Layout::Series,
            y,
            group,
            class_names: self.shore.iter().map(|s| format!("shore-{s:02}")).collect(),
            channel_names: FINGERS.map(String::from).to_vec(),
            unit: "ADC counts",
            full_scale: FULL_SCALE as f32,
            rest: vec![0.0],
            truth,
            test: self.unseen.map(|_| (0..samples).map(|i| i >= known).collect()),
            attributes: None,
        })
    }
}

impl Fingertip {
    /// Counts the samples, the first ones, that have the hardnesses of `shore`.
    fn known(&self, samples: usize) -> Result<usize> {
        let Some(unseen) = self.unseen else { return Ok(if self.between.is_some() { 0 } else { samples }) };
        let drawn = (f64::from(unseen) * samples as f64).round() as usize;
        // One sample alone is asked for to see how large it is.
        if samples > 1 && (drawn == 0 || drawn >= samples) {
            let expected = "leaves no sample to train on or none to test on; simulate more";
            return Err(Error::Parameter { name: "unseen", value: unseen.to_string(), expected });
        }
        Ok(samples - drawn.min(samples))
    }

    /// Returns class and Shore A hardness of sample `i`.
    fn hardness(&self, world: &World, i: usize, is_drawn: bool) -> (usize, f32) {
        let Some([least, most]) = self.between.filter(|_| is_drawn) else {
            let class = i % self.shore.len();
            return (class, self.shore[class]);
        };
        let shore = least + (most - least) * world.rng(&format!("{i}/hardness")).random::<f32>();
        let gap = |class: &usize| (self.shore[*class] - shore).abs();
        let nearest = (0..self.shore.len()).min_by(|a, b| gap(a).total_cmp(&gap(b)));
        #[expect(clippy::expect_used, reason = "settings without a hardness are refused")]
        let nearest = nearest.expect("check() wants a hardness at least");
        (nearest, shore)
    }
}

/// The quantities that differ from grasp to grasp besides the object.
struct FingertipGrasp {
    /// The object is nearer to the fingers and farther from the thumb by this much, mm.
    shift: f64,
    /// Each finger from index to little is farther than the one before by this much, mm.
    tilt: f64,
    hold_error: f64,
    start_error: f64,
    quality: [f64; FINGERS.len()],
}

/// Draws grasp `i`, the `turn`-th of its session.
fn grasp(world: &World, i: usize, session: usize, turn: usize) -> FingertipGrasp {
    let mut drift = world.rng(&format!("session/{session}"));
    let cycle = turn as f64 / SESSION_PERIOD.get();
    // An offset of its own plus a slow swing; SD 1 together.
    let mut wander = || {
        let (offset, swing, phase) = (normal(&mut drift), normal(&mut drift), drift.random::<f64>());
        let swing = swing * (std::f64::consts::TAU * (cycle + phase)).sin();
        world.unless("session", (offset + swing) / 1.5f64.sqrt(), 0.0)
    };
    let session_shift = SESSION_SHIFT.get() * wander();
    let session_quality = FINGERS.map(|_| SESSION_QUALITY.get() * wander());

    let mut place = world.rng(&format!("{i}/placement"));
    let mut placed = |sd: &Parameter| world.unless("placement", sd.get() * normal(&mut place), 0.0);
    let (shift, tilt) = (session_shift + placed(&SHIFT), placed(&TILT));
    let mut servo = world.rng(&format!("{i}/servo"));
    let mut error = |sd: &Parameter| world.unless("servo", sd.get() * normal(&mut servo), 0.0);
    let (hold_error, start_error) = (error(&HOLD_ERROR), error(&START_ERROR));
    let mut contact = world.rng(&format!("{i}/contact-quality"));
    let quality = std::array::from_fn(|finger| {
        let spread = QUALITY_SPREAD.value[finger] * normal(&mut contact);
        let of_grasp = world.unless("contact-quality", QUALITY.value[finger] * spread.exp(), 1.0);
        // No more force can reach the sensor than the finger presses with.
        (of_grasp * session_quality[finger].exp()).min(1.0)
    });
    FingertipGrasp { shift, tilt, hold_error, start_error, quality }
}

/// Computes the force of one finger on the object at each reading, N.
fn forces(world: &World, grasp: &FingertipGrasp, finger: usize, modulus: f64) -> [f64; STEPS] {
    let radius = 1.0 / (1.0 / TIP.get() + 1.0 / OBJECT.get());
    let hertz = 4.0 / 3.0 * modulus / (1.0 - POISSON.get().powi(2)) * radius.sqrt();
    let away = match finger {
        THUMB => grasp.shift,
        // From -1.5 for the index finger to 1.5 for the little finger.
        _ => grasp.tilt * (finger as f64 - 2.5) - grasp.shift,
    };
    let gap = GAP.value[finger] + away;
    let travel = TRAVEL.get() + grasp.hold_error;
    let start = START.get() + grasp.start_error;
    let relaxed = world.unless("relaxation", RELAXED.get(), 0.0);
    let yielding = world.unless("compliance", 1.0 / STIFFNESS.get(), 0.0);

    let step = INTERVAL / SUBSTEPS as f64;
    let decay = (-step / RELAXATION_TIME.get()).exp();
    // A change of the elastic force spreads over the step: half of it has decayed.
    let fresh = relaxed * decay.sqrt();
    let (mut elastic, mut viscous, mut force) = (0.0, 0.0, 0.0);
    std::array::from_fn(|reading| {
        let substeps = if reading == 0 { 0 } else { SUBSTEPS };
        for substep in 0..substeps {
            let time = (reading - 1) as f64 * INTERVAL + (substep + 1) as f64 * step;
            let depth = travel * ((time - start) / RAMP.get()).clamp(0.0, 1.0) - gap;
            let carried = viscous * decay - fresh * elastic;
            let share = 1.0 - relaxed + fresh;
            let d = squeeze(depth.max(0.0), share * hertz * yielding, carried * yielding);
            let next = hertz * d.powf(1.5);
            viscous = carried + fresh * next;
            elastic = next;
            force = ((1.0 - relaxed) * elastic + viscous).max(0.0);
        }
        force
    })
}

/// Solves `d + a d^1.5 + b = depth` for the indentation d in `[0, depth]`.
fn squeeze(depth: f64, a: f64, b: f64) -> f64 {
    // The left side is convex and d = depth lies right of the root: Newton's steps only shrink.
    let mut d = depth;
    for _ in 0..20 {
        let over = d + a * d * d.sqrt() + b - depth;
        let next = (d - over / (1.0 + 1.5 * a * d.sqrt())).clamp(0.0, depth);
        if (d - next).abs() < 1e-9 {
            return next;
        }
        d = next;
    }
    d
}

/// Converts a Shore A hardness to Young's modulus in MPa (Gent 1958).
pub fn young_modulus(shore: f64) -> f64 {
    0.0981 * (56.0 + 7.62336 * shore) / (0.137505 * (254.0 - 2.54 * shore))
}

/// Returns the noiseless counts of a force in N on the sensor.
fn counts(force: f64) -> f64 {
    let ratio = CONDUCTANCE.get() * force.powf(EXPONENT.get()) * RESISTOR.get();
    FULL_SCALE * ratio / (1.0 + ratio)
}
