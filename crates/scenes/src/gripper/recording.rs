//! One grasp: approach, squeeze, hold, release, as two fingers read it.
//!
//! # Reference
//!
//! See [`gripper`](super).

use super::parameters::*;
use crate::world::{World, normal};
use rand::RngExt;
use std::f64::consts::TAU;
use taxel_base::seed::Rng;

/// The material of an object.
pub(super) struct Material {
    /// N/mm.
    pub(super) stiffness: f64,
    /// Share of its force that fades.
    pub(super) relaxed: f64,
    /// Damping ratio of its tap.
    pub(super) damping: f64,
}

impl Material {
    /// Returns how hard it is against the sensor's foam, 0 to 1.
    fn firmness(&self) -> f64 {
        self.stiffness / (self.stiffness + SKIN.get())
    }
}

/// The quantities that differ from grasp to grasp.
pub(super) struct GripperGrasp {
    material: Material,
    /// Of the first touch, s.
    pub(super) contact: f64,
    delay: f64,
    /// How much later each finger touches, mm.
    late: [f64; 2],
    /// Pa per N of each finger.
    pressure: [f64; 2],
    tap: f64,
    offset: [[f64; 2]; 2],
}

/// The outcome of a grasp.
#[derive(Debug, Default)]
pub(super) struct GraspOutcome {
    /// Time at which the fingers stopped, s.
    pub(super) stop: f64,
    /// Largest force of each finger, N.
    pub(super) peak: [f64; 2],
}

impl GripperGrasp {
    pub(super) fn draw(world: &World, i: usize, session: usize, material: Material) -> GripperGrasp {
        let mut approach = world.rng(&format!("{i}/approach"));
        let [soonest, latest] = [APPROACH.value[0], APPROACH.value[1]];
        let contact = soonest + (latest - soonest) * approach.random::<f64>();
        let late = normal(&mut world.rng(&format!("{i}/delay")));
        let delay = world.unless("delay", (DELAY.value[0] + DELAY.value[1] * late).max(0.0), 0.0);
        let mut place = world.rng(&format!("{i}/placement"));
        let mut draw = |sd: f64| world.unless("placement", sd * normal(&mut place), 0.0);
        let off = draw(OFF_CENTRE.get());
        let pressure = [draw(AREA.get()), draw(AREA.get())].map(|log| PRESSURE.get() * log.exp());
        let tap = draw(TAP_SPREAD.get()).exp();
        let mut rest = world.rng(&format!("session/{session}"));
        let mut offset = |base: f64, sd: f64| base + world.unless("offset", sd * normal(&mut rest), 0.0);
        let offset = [(); 2].map(|()| {
            [
                offset(DC_OFFSET.get(), SESSION_OFFSET.value[0]),
                offset(AC_OFFSET.get(), SESSION_OFFSET.value[1]),
            ]
        });
        let late = [(-off).max(0.0), off.max(0.0)];
        GripperGrasp { material, contact, delay, late, pressure, tap, offset }
    }

    /// Returns the reading of DC at rest, per finger, bits.
    pub(super) fn rest(&self) -> [f64; 2] {
        self.offset.map(|[dc, _]| dc)
    }

    /// Fills one recording `[2 fingers, 1 DC + 22 AC, ticks]`, row-major, in bits.
    pub(super) fn record(&self, world: &World, i: usize, into: &mut [f32]) -> GraspOutcome {
        let ticks = RECORDED.get() as usize;
        let burst = BURST.get() as usize;
        let step = TICK.get() / BURST.get();
        let mut fingers = [0, 1].map(|finger| Finger::new(self, world, i, finger));
        let mut outcome = GraspOutcome { stop: f64::INFINITY, ..GraspOutcome::default() };
        let mut stop_at = f64::INFINITY;
        for tick in 0..ticks {
            for sub in 0..burst {
                let time = (tick * burst + sub) as f64 * step;
                let depth = self.depth(time, outcome.stop);
                for (finger, fluid) in fingers.iter_mut().enumerate() {
                    let ac = fluid.step(self, time, depth - self.late[finger]);
                    into[(finger * (burst + 1) + 1 + sub) * ticks + tick] = ac;
                }
            }
            for (finger, fluid) in fingers.iter_mut().enumerate() {
                let dc = fluid.dc();
                into[finger * (burst + 1) * ticks + tick] = dc;
                outcome.peak[finger] = outcome.peak[finger].max(fluid.force);
                if dc >= STOP.get() as f32 && stop_at.is_infinite() {
                    stop_at = (tick + 1) as f64 * TICK.get() + self.delay;
                }
            }
            // Seen from the next tick on.
            outcome.stop = stop_at;
        }
        outcome
    }

    /// Returns how far the fingers have come since the first touch, mm.
    fn depth(&self, time: f64, stop: f64) -> f64 {
        let speed = SPEED.get();
        let closing = time.min(stop) - self.contact;
        let opening = (time - stop - HOLD.get()).max(0.0);
        speed * (closing - opening)
    }
}

/// The fluid pressure of one finger.
struct Finger {
    rng: Rng,
    noise: [f64; 2],
    tremble: f64,
    pressure: f64,
    offset: [f64; 2],
    /// N.
    force: f64,
    /// The object's lasting indentation, mm.
    flow: f64,
    /// Pressure that AC has got used to, Pa.
    slow: f64,
    wobble: f64,
    touched: Option<f64>,
}

impl Finger {
    fn new(grasp: &GripperGrasp, world: &World, i: usize, finger: usize) -> Finger {
        let quiet = |value: f64| world.unless("noise", value, 0.0);
        Finger {
            rng: world.rng(&format!("{i}/noise/{finger}")),
            noise: [quiet(NOISE.value[0]), quiet(NOISE.value[1])],
            tremble: quiet(TREMBLE.get()),
            pressure: grasp.pressure[finger],
            offset: grasp.offset[finger],
            force: 0.0,
            flow: 0.0,
            slow: 0.0,
            wobble: 0.0,
            touched: None,
        }
    }

    /// Goes on by one AC value, bits.
    fn step(&mut self, grasp: &GripperGrasp, time: f64, depth: f64) -> f32 {
        let step = TICK.get() / BURST.get();
        // Object and foam in series, the object's flow taken off: F = K (depth - flow).
        let (material, firm) = (&grasp.material, grasp.material.firmness());
        let series = firm * SKIN.get();
        self.force = series * (depth - self.flow).max(0.0);
        let indented = (depth - self.force / SKIN.get()).max(0.0);
        self.flow += step / RELAXATION_TIME.get() * (material.relaxed * indented - self.flow);
        let pressure = self.pressure * self.force;
        self.slow += step * TAU * CORNER.get() * (pressure - self.slow);
        if depth > 0.0 && self.touched.is_none() {
            self.touched = Some(time);
        }
        let tap = self.touched.map_or(0.0, |start| {
            let turn = TAU * (TAP_PITCH.value[0] + TAP_PITCH.value[1] * firm) * (time - start + step);
            let strength = grasp.tap * (TAP.value[0] + TAP.value[1] * firm);
            strength * (-material.damping * turn).exp() * turn.sin()
        });
        let vibration = (pressure - self.slow + tap) / AC_UNIT.get();
        // First-order red noise of the wanted SD.
        let kept = (-TAU * TREMBLE_CORNER.get() * step).exp();
        self.wobble = kept * self.wobble + (1.0 - kept * kept).sqrt() * normal(&mut self.rng);
        let noise = self.tremble * self.wobble + self.noise[1] * normal(&mut self.rng);
        bits(self.offset[1] + vibration + noise)
    }

    /// Returns the DC value at this moment, bits.
    fn dc(&mut self) -> f32 {
        let noise = self.noise[0] * normal(&mut self.rng);
        bits(self.offset[0] + self.pressure * self.force / DC_UNIT.get() + noise)
    }
}

fn bits(value: f64) -> f32 {
    value.round().clamp(0.0, CONVERTER.get()) as f32
}
