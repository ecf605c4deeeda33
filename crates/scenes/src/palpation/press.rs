//! A press: how deep the sensor sinks in under a force, and what pressure each taxel then has.
//!
//! # Reference
//!
//! An elastic bed (Winkler; K. L. Johnson, "Contact Mechanics", Cambridge 1985, section 4.3): pressure
//! behind a taxel depends on the squeeze at that taxel alone, `p = k s / (1 - s / m)`. k is that of pad
//! and object in series, m the squeeze at which both are flat. A lump adds `k' (s - cover)` once the
//! squeeze exceeds its soft cover. The pad then spreads the load (a Gaussian).

use super::finger::Fingers;
use super::objects::SqueezedObject;
use super::parameters::*;
use super::surface::{FAR, TAXELS, pitch};

/// Beyond this share of the full squeeze the law goes on as a straight line.
const FLAT: f32 = 0.95;

/// An object and a pad under the sensor.
pub(super) struct Bed {
    /// Distance of the surface behind each taxel, mm.
    pub(super) gaps: Vec<f32>,
    covers: Option<Vec<f32>>,
    stiffness: f32,
    depth: f32,
    lump_stiffness: f32,
}

/// The force or the position of a press.
#[derive(Clone, Copy)]
pub(super) enum Drive<'a> {
    /// So many N, however deep it gets.
    Force(f32),
    /// `hold` N, and the fingers with this torque (share of losses included) on an object that was
    /// `thickness` mm thick.
    Fingers { fingers: &'a Fingers, torque: f32, hold: f32, thickness: f32 },
}

impl Drive<'_> {
    /// Returns the force in N at a depth in mm, and its slope.
    fn at(&self, depth: f32) -> (f32, f32) {
        match *self {
            Drive::Force(force) => (force, 0.0),
            Drive::Fingers { fingers, torque, hold, thickness } => {
                let (force, slope) = fingers.force(thickness - depth);
                (hold + torque * force, -torque * slope)
            }
        }
    }
}

impl Bed {
    pub(super) fn new(
        object: &SqueezedObject,
        padded: bool,
        gaps: Vec<f32>,
        covers: Option<Vec<f32>>,
    ) -> Bed {
        let pad = if padded { 1.0 / PAD.get() } else { 0.0 };
        let pad_depth = if padded { PAD_DEPTH.get() } else { 0.0 };
        Bed {
            gaps,
            covers,
            stiffness: (1.0 / (1.0 / object.stiffness + pad)) as f32,
            depth: (object.depth + pad_depth) as f32,
            lump_stiffness: object.inclusions.first().map_or(0.0, |lump| lump.stiffness) as f32,
        }
    }

    /// Computes the pressure in kPa at a squeeze in mm, and its slope.
    #[inline(always)]
    fn law(&self, squeeze: f32) -> (f32, f32) {
        let squeeze = squeeze.max(0.0);
        let share = (squeeze / self.depth).min(FLAT);
        let left = 1.0 / (1.0 - share);
        let slope = self.stiffness * left * left;
        let beyond = (squeeze - FLAT * self.depth).max(0.0);
        let touched = if squeeze > 0.0 { 1.0 } else { 0.0 };
        (self.stiffness * self.depth * share * left + slope * beyond, slope * touched)
    }

    #[inline(always)]
    fn lump(&self, squeeze: f32, cover: f32) -> (f32, f32) {
        let beyond = (squeeze - cover).max(0.0);
        (self.lump_stiffness * beyond, if beyond > 0.0 { self.lump_stiffness } else { 0.0 })
    }

    /// Sums the pressures in kPa at a depth in mm, and their slopes.
    fn sum(&self, depth: f32) -> (f32, f32) {
        let mut sum = (0.0, 0.0);
        for &gap in &self.gaps {
            let (pressure, slope) = self.law(depth - gap);
            sum = (sum.0 + pressure, sum.1 + slope);
        }
        for (&gap, &cover) in self.gaps.iter().zip(self.covers.iter().flatten()) {
            let (pressure, slope) = self.lump(depth - gap, cover);
            sum = (sum.0 + pressure, sum.1 + slope);
        }
        sum
    }

    /// Finds the depth in mm, from the first touch, at which bed and drive balance; `start` is a guess.
    pub(super) fn sink(&self, drive: &Drive, start: f32) -> f32 {
        let area = taxel_area();
        // The bed pushes back more the deeper it is, the drive presses less: one root.
        let over = |depth: f32| {
            let ((pressure, rise), (force, slope)) = (self.sum(depth), drive.at(depth));
            (area * pressure - force, area * rise - slope)
        };
        let (mut low, mut high, mut depth) = (0.0, FAR / 10.0, start.max(1e-3));
        for _ in 0..60 {
            let (excess, slope) = over(depth);
            if excess > 0.0 {
                high = depth
            } else {
                low = depth
            }
            let newton = depth - excess / slope.max(1e-9);
            // Halve the bracket, or double an open one, where Newton leaves it.
            let safe = if high < FAR / 10.0 { (low + high) / 2.0 } else { 2.0 * depth + 0.1 };
            let next = if newton > low && newton < high.min(2.0 * depth + 1.0) { newton } else { safe };
            if (next - depth).abs() < 1e-4 * (1.0 + depth) {
                return next;
            }
            depth = next;
        }
        depth
    }

    /// Writes the pressure of each taxel at a depth, kPa.
    pub(super) fn pressures(&self, depth: f32, into: &mut [f32; TAXELS]) {
        for (pressure, &gap) in into.iter_mut().zip(&self.gaps) {
            *pressure = self.law(depth - gap).0;
        }
        for ((pressure, &gap), &cover) in into.iter_mut().zip(&self.gaps).zip(self.covers.iter().flatten()) {
            *pressure += self.lump(depth - gap, cover).0;
        }
    }
}

/// Returns the force in N of 1 kPa on one taxel.
pub(super) fn taxel_area() -> f32 {
    let [along, across] = pitch();
    (along * across * 1e-3) as f32
}

/// Taps of the pad's blur on each side.
const REACH: usize = 3;

/// Returns the pad's spread of a load, from the middle outwards; the taps of a whole row add to 1.
pub(super) fn spread() -> [f32; REACH + 1] {
    let sd = PAD_BLUR.get() / pitch()[0];
    let weight = |tap: usize| (-0.5 * (tap as f64 / sd).powi(2)).exp();
    let sum: f64 = weight(0) + 2.0 * (1..=REACH).map(weight).sum::<f64>();
    std::array::from_fn(|tap| (weight(tap) / sum) as f32)
}

/// Blurs a frame along both axes; load that leaves the sensor is lost.
pub(super) fn blur(frame: &mut [f32; TAXELS], spread: &[f32; REACH + 1]) {
    const COLUMNS: usize = 50;
    const ROWS: usize = TAXELS / COLUMNS;
    for row in frame.chunks_exact_mut(COLUMNS) {
        let mut wide = [0.0; COLUMNS + 2 * REACH];
        wide[REACH..REACH + COLUMNS].copy_from_slice(row);
        for (column, value) in row.iter_mut().enumerate() {
            let at = column + REACH;
            *value = (1..=REACH)
                .fold(spread[0] * wide[at], |sum, tap| sum + spread[tap] * (wide[at - tap] + wide[at + tap]));
        }
    }
    let before = *frame;
    let row = |at: isize| {
        let is_there = (0..ROWS as isize).contains(&at);
        if is_there { &before[at as usize * COLUMNS..][..COLUMNS] } else { &[0.0; COLUMNS] }
    };
    for (at, values) in frame.chunks_exact_mut(COLUMNS).enumerate() {
        values.iter_mut().for_each(|v| *v *= spread[0]);
        for tap in 1..=REACH as isize {
            let (up, down, weight) = (row(at as isize - tap), row(at as isize + tap), spread[tap as usize]);
            for ((value, up), down) in values.iter_mut().zip(up).zip(down) {
                *value += weight * (up + down);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::objects::PAPER_002;
    use super::*;

    /// Makes the flat face of the smooth sponge on ten taxels, without pad.
    fn sponge() -> (Bed, &'static SqueezedObject) {
        let object = &PAPER_002[4];
        let mut gaps = vec![FAR; TAXELS];
        gaps[100..110].fill(0.0);
        (Bed::new(object, false, gaps, None), object)
    }

    #[test]
    fn the_depth_balances_the_force() {
        let (bed, object) = sponge();
        let (k, m) = (object.stiffness, object.depth);
        for force in [1e-3, 0.05, 0.2, 5.0] {
            let depth = f64::from(bed.sink(&Drive::Force(force as f32), 1.0));
            let pressure = force / (10.0 * f64::from(taxel_area()));
            // p = k s / (1 - s / m), solved for s by hand; a line beyond 95 % of m.
            let want = pressure / (k + pressure / m);
            let end = k * 0.95 * m / 0.05;
            let want = if want < 0.95 * m { want } else { 0.95 * m + (pressure - end) / (k * 400.0) };
            assert!((depth - want).abs() < 2e-3 * want, "{force} N: {depth} mm, by hand {want} mm");
        }
    }

    #[test]
    fn fingers_press_less_as_they_close() {
        let (bed, _) = sponge();
        let fingers = Fingers::new();
        let drive = Drive::Fingers { fingers: &fingers, torque: 0.1, hold: 0.02, thickness: 40.0 };
        let depth = bed.sink(&drive, 1.0);
        let force = taxel_area() * bed.sum(depth).0;
        let want = 0.02 + 0.1 * fingers.force(40.0 - depth).0;
        assert!((force - want).abs() < 1e-2 * want, "{force} N, fingers {want} N");
        assert!(want < 0.02 + 0.1 * fingers.force(40.0).0);
    }

    #[test]
    fn the_blur_keeps_the_load_and_spreads_it_as_a_gaussian() {
        let mut frame = [0.0; TAXELS];
        frame[14 * 50 + 25] = 8.0;
        blur(&mut frame, &spread());
        assert!((frame.iter().sum::<f32>() - 8.0).abs() < 1e-5);
        let at = |row: usize, column: usize| frame[row * 50 + column];
        let taps = spread();
        assert!((at(13, 27) - 8.0 * taps[1] * taps[2]).abs() < 1e-6);
        assert_eq!((at(14, 22), at(14, 21)), (8.0 * taps[0] * taps[3], 0.0));
        let sd = 1.5 / (95.3 / 50.0);
        assert!((taps[1] / taps[0] - f32::exp(-0.5 / (sd * sd))).abs() < 1e-6);
    }
}
