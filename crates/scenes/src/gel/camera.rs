//! The picture that a camera behind the gel takes of its coat.
//!
//! # Reference
//!
//! M. K. Johnson and E. H. Adelson, "Retrographic sensing for the measurement of surface texture and shape", CVPR 2009:
//! a matt coat lit from several sides, so that brightness is slope. D. F. Gomes, P. Paoletti and S. Luo, "Generation
//! of GelSight tactile images for sim2real learning", 2021: the coat as a Gaussian of what is pressed into it.
//!
//! # Departures
//!
//! Lambert's law instead of Phong's, no shadows, no edge of the gel, no markers.

use super::parameters::{AMBIENT, AZIMUTH, ELEVATION, MEMBRANE};

/// Largest value of a pixel.
pub(super) const FULL_SCALE: f64 = 255.0;

/// How deep the gel is pressed in at each of `side` × `side` places, in mm, and the places' distance.
pub(super) struct Dent {
    pub depth: Vec<f64>,
    pub side: usize,
    pub pitch: f64,
}

impl Dent {
    /// Returns the coat over the dent: smoothed, as if the dent went on beyond the edge as it is there.
    pub(super) fn smoothed(self) -> Self {
        let sd = MEMBRANE.get() / self.pitch;
        let reach = (3.0 * sd).ceil() as i64;
        let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / sd).powi(2)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let last = self.side as i64 - 1;
        let pass = |from: &[f64], by_row: bool| -> Vec<f64> {
            let at = |pixel: usize, shift: i64| {
                let (row, column) = ((pixel / self.side) as i64, (pixel % self.side) as i64);
                let moved = |v: i64| (v + shift).clamp(0, last);
                let (row, column) = if by_row { (moved(row), column) } else { (row, moved(column)) };
                from[row as usize * self.side + column as usize]
            };
            let smooth =
                |pixel| weights.iter().zip(-reach..).map(|(w, shift)| w * at(pixel, shift)).sum::<f64>();
            (0..from.len()).map(|pixel| smooth(pixel) / total).collect()
        };
        let depth = pass(&pass(&self.depth, true), false);
        Dent { depth, ..self }
    }

    /// Returns the colour of each place in counts before noise and rounding: red, green, blue.
    pub(super) fn lit(&self) -> impl Iterator<Item = [f64; 3]> {
        let at = |row: usize, column: usize| self.depth[row * self.side + column];
        let last = self.side - 1;
        let lamps = lamps();
        (0..self.depth.len()).map(move |pixel| {
            let (row, column) = (pixel / self.side, pixel % self.side);
            // Towards the neighbours that there are, two places apart except at the edge.
            let slope = |low: f64, high: f64, apart: usize| (high - low) / (apart.max(1) as f64 * self.pitch);
            let (left, right) = (column.saturating_sub(1), (column + 1).min(last));
            let (above, below) = (row.saturating_sub(1), (row + 1).min(last));
            // x goes right, y up; the coat stands towards the camera where it is pressed in.
            let dx = slope(at(row, left), at(row, right), right - left);
            let dy = slope(at(below, column), at(above, column), below - above);
            let length = (dx * dx + dy * dy + 1.0).sqrt();
            lamps.map(|[x, y, z]| {
                let facing = ((z - dx * x - dy * y) / length).max(0.0);
                FULL_SCALE * (AMBIENT.get() + (1.0 - AMBIENT.get()) * facing)
            })
        })
    }
}

/// Returns the directions to the red, green and blue lamp.
fn lamps() -> [[f64; 3]; 3] {
    let up = ELEVATION.get().to_radians();
    [0, 1, 2].map(|lamp| {
        let around = AZIMUTH.value[lamp].to_radians();
        [up.cos() * around.cos(), up.cos() * around.sin(), up.sin()]
    })
}

/// Returns the value of a pixel where nothing touches, in counts.
pub(super) fn rest() -> f64 {
    let flat = AMBIENT.get() + (1.0 - AMBIENT.get()) * ELEVATION.get().to_radians().sin();
    (FULL_SCALE * flat).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dent(of: impl Fn(f64, f64) -> f64) -> Dent {
        let middle = |at: usize| at as f64 - 7.0;
        let depth = (0..225).map(|pixel| of(middle(pixel % 15), -middle(pixel / 15))).collect();
        Dent { depth, side: 15, pitch: 1.0 }
    }

    #[test]
    fn slopes_towards_a_lamp_are_bright_in_its_colour() {
        let flat: Vec<[f64; 3]> = dent(|_, _| 1.0).lit().collect();
        assert!(flat.iter().flatten().all(|value| (value - rest()).abs() < 0.51));
        // It falls off upwards, towards the red lamp.
        let up: Vec<[f64; 3]> = dent(|_, y| -0.3 * y).lit().collect();
        assert!(up.iter().all(|[red, green, blue]| *red > 1.2 * rest() && (green - blue).abs() < 1e-9));
        assert!(up.iter().all(|[_, green, _]| *green < rest()));
        // Lambert: a slope that faces the lamp has all its light.
        let facing =
            dent(|_, y| -ELEVATION.get().to_radians().cos() / ELEVATION.get().to_radians().sin() * y);
        assert!(facing.lit().all(|[red, ..]| (red - FULL_SCALE).abs() < 1e-9));
    }

    #[test]
    fn the_coat_keeps_its_volume_and_loses_its_edges() {
        let spike = dent(|x, y| if x == 0.0 && y == 0.0 { 1.0 } else { 0.0 });
        let fine = Dent { pitch: MEMBRANE.get(), ..spike }.smoothed();
        assert!((fine.depth.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        // SD of one place: the density of a normal distribution, squared.
        assert!((fine.depth[112] - 0.159).abs() < 0.005, "{}", fine.depth[112]);
    }
}
