//! The underactuated fingers of Pastor et al. 2019: torque in, force on the thumb out.
//!
//! # Reference
//!
//! Pastor et al. 2019, section 3.1, equation 1, `F = J^-T T^-T tau`, with its Table 1. The text gives no figure
//! of the linkage; we read a five-bar loop of ground e (first joint to servo, at gamma), crank a,
//! coupler c, lever b (at psi on the second phalanx) and first phalanx l1. d places the servo housing
//! and is not needed. Both phalanges touch the object as if its section were a circle resting on the
//! sensor. The return spring is left out: it is weak against the motor and its rate is not published.
//!
//! # What follows
//!
//! The thinner an object is, the less the fingers press on the sensor: at 20 mm a fifth of what they
//! do at 65 mm. Soft objects therefore see little force, as in real recordings.

use super::parameters::*;

/// A finger pair on an object of some thickness.
pub(super) struct Fingers {
    /// Force on the sensor in N per N m of each servo's torque, for a thickness of `i` mm.
    table: Vec<f32>,
}

/// Grid of the table, mm; outside, its ends hold.
const THINNEST: usize = 10;
const THICKEST: usize = 78;

impl Fingers {
    pub(super) fn new() -> Self {
        let force = |mm: usize| 2.0 * press(mm.clamp(THINNEST, THICKEST) as f64).max(0.0) as f32;
        Fingers { table: (0..=THICKEST + 1).map(force).collect() }
    }

    /// Returns the force in N per N m and its slope in N per N m and mm, both fingers together.
    pub(super) fn force(&self, thickness: f32) -> (f32, f32) {
        let at = thickness.clamp(0.0, THICKEST as f32);
        let low = at.floor();
        let (a, b) = (self.table[low as usize], self.table[low as usize + 1]);
        (a + (at - low) * (b - a), b - a)
    }
}

/// Computes the force of one finger towards the sensor per N m, on an object `thickness` mm thick.
fn press(thickness: f64) -> f64 {
    let pose = Pose::on(thickness);
    let [first, second] = pose.contact_forces();
    // Each phalanx presses at right angles to itself, towards the object.
    first * pose.theta1.cos() + second * (pose.theta1 + pose.theta2).cos()
}

/// The joint angles in rad and how far from its joint each phalanx touches, mm.
#[derive(Debug, Clone, Copy)]
struct Pose {
    theta1: f64,
    theta2: f64,
    reach: [f64; 2],
}

impl Pose {
    fn on(thickness: f64) -> Pose {
        let circle = thickness / 2.0 + THICKNESS.get();
        let (x, y) = (CENTRE.get(), thickness / 2.0 - MOUNT.get());
        let distance = x.hypot(y);
        // Tangents from the first joint, and from the second, which is as far from both contacts.
        let first = (distance * distance - circle * circle).max(0.0).sqrt();
        let second = PHALANX.get() - first;
        let theta1 = y.atan2(x) + (circle / distance).min(1.0).asin();
        Pose { theta1, theta2: -2.0 * (second / circle).atan(), reach: [first, second] }
    }

    /// Computes the normal forces of the phalanges for a closing torque of 1 N m, N.
    fn contact_forces(&self) -> [f64; 2] {
        let [q1, q2] = self.joint_torques();
        let [k1, k2] = self.reach;
        // J^-T of the normal speeds (k1 w1, (l1 cos theta2 + k2) w1 + k2 w2).
        let second = q2 / k2;
        let first = (q1 - second * (PHALANX.get() * self.theta2.cos() + k2)) / k1;
        [1e3 * first, 1e3 * second]
    }

    /// Computes T^-T tau: torques about the two joints for 1 N m on the crank, by the rates of the closed loop.
    fn joint_torques(&self) -> [f64; 2] {
        let at = |length: f64, angle: f64| [length * angle.cos(), length * angle.sin()];
        let gamma = GROUND_ANGLE.get().to_radians();
        let (servo, knee) = (at(GROUND.get(), gamma), at(PHALANX.get(), self.theta1));
        let lever = at(LEVER.get(), self.theta1 + self.theta2 + LEVER_ANGLE.get().to_radians());
        let pin = [knee[0] + lever[0], knee[1] + lever[1]];
        let crank = at(CRANK.get(), self.crank(pin));
        let rod = [servo[0] + crank[0] - pin[0], servo[1] + crank[1] - pin[1]];
        // How far each angle moves the rod's ends along the rod.
        let along = |arm: [f64; 2]| rod[1] * arm[0] - rod[0] * arm[1];
        [along(pin) / along(crank), along(lever) / along(crank)]
    }

    /// Computes the angle at which the crank holds the coupler's other end at `pin`, elbow up, rad.
    fn crank(&self, pin: [f64; 2]) -> f64 {
        let gamma = GROUND_ANGLE.get().to_radians();
        let (x, y) = (pin[0] - GROUND.get() * gamma.cos(), pin[1] - GROUND.get() * gamma.sin());
        let (a, c, length) = (CRANK.get(), COUPLER.get(), x.hypot(y));
        let bend = (a * a + length * length - c * c) / (2.0 * a * length);
        y.atan2(x) + bend.clamp(-1.0, 1.0).acos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pin(theta1: f64, theta2: f64) -> [f64; 2] {
        let lever = theta1 + theta2 + LEVER_ANGLE.get().to_radians();
        [
            PHALANX.get() * theta1.cos() + LEVER.get() * lever.cos(),
            PHALANX.get() * theta1.sin() + LEVER.get() * lever.sin(),
        ]
    }

    #[test]
    fn the_loop_closes_and_its_rates_are_those_of_the_crank() {
        for thickness in [15.0, 25.0, 40.0, 55.0, 70.0, 77.0] {
            let pose = Pose::on(thickness);
            let angle = |d1: f64, d2: f64| pose.crank(pin(pose.theta1 + d1, pose.theta2 + d2));
            let (gamma, crank) = (GROUND_ANGLE.get().to_radians(), angle(0.0, 0.0));
            let end = [
                GROUND.get() * gamma.cos() + CRANK.get() * crank.cos(),
                GROUND.get() * gamma.sin() + CRANK.get() * crank.sin(),
            ];
            let at = pin(pose.theta1, pose.theta2);
            let coupler = (end[0] - at[0]).hypot(end[1] - at[1]);
            assert!((coupler - COUPLER.get()).abs() < 1e-9, "{thickness} mm: coupler {coupler}");
            // Virtual work: the torque about a joint is how fast the crank turns with it.
            let rate = |d1: f64, d2: f64| (angle(d1, d2) - angle(-d1, -d2)) / 2e-6;
            let want = [rate(1e-6, 0.0), rate(0.0, 1e-6)];
            let got = pose.joint_torques();
            assert!((0..2).all(|i| (got[i] - want[i]).abs() < 1e-6), "{thickness} mm: {got:?}, {want:?}");
        }
    }

    #[test]
    fn the_contacts_do_the_work_of_the_joints() {
        let pose = Pose::on(50.0);
        let [f1, f2] = pose.contact_forces();
        // Turning the first joint moves both contacts, turning the second only the outer one; mm.
        let outer = PHALANX.get() * pose.theta2.cos() + pose.reach[1];
        let work = [f1 * pose.reach[0] + f2 * outer, f2 * pose.reach[1]];
        let torques = pose.joint_torques();
        assert!((0..2).all(|i| (work[i] / 1e3 - torques[i]).abs() < 1e-9), "{work:?}, {torques:?}");
        // Each phalanx touches the circle, its surface w from its joint line.
        let circle = 25.0 + THICKNESS.get();
        let (x, y) = (CENTRE.get(), 25.0 - MOUNT.get());
        let beside = (x * pose.theta1.sin() - y * pose.theta1.cos()).abs();
        assert!((beside - circle).abs() < 1e-9, "{beside}");
    }

    #[test]
    fn thick_objects_are_pressed_harder_up_to_65_mm() {
        let fingers = Fingers::new();
        let forces: Vec<f32> = (16..=65).map(|mm| fingers.force(mm as f32).0).collect();
        assert!(forces.is_sorted() && forces[49] > 4.0 * forces[4], "{forces:?}");
        assert!(forces.iter().all(|f| (0.0..100.0).contains(f)));
        let (force, slope) = fingers.force(40.5);
        assert!((force + 0.25 * slope - fingers.force(40.75).0).abs() < 1e-3);
    }
}
