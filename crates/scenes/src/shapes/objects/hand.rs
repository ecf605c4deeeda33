//! Hands: open, fist, pointing, victory, relaxed.
//!
//! # Reference
//!
//! None; proportions by eye. The palm looks along x, fingers point up.

use super::{Solid, Variants};

pub(super) const VARIANTS: Variants = [open, fist, pointing, victory, relaxed];

/// Bend of each joint in degrees, and spread sideways, of index, middle, ring and little finger.
struct Pose {
    bends: [f64; 4],
    spread: f64,
    /// Tip of the thumb.
    thumb: [[f64; 3]; 2],
    slim: f64,
}

impl Pose {
    fn solid(&self) -> Solid {
        let palm = Solid::new(0.035)
            .slab([0.0, 0.0, 0.0], [0.11, 0.34, 0.36], 0.1)
            .limb([0.0, 0.02, -0.3], [0.0, 0.02, -0.8], [0.19, 0.19])
            .blob([0.07, 0.22, -0.16], [0.1, 0.13, 0.2])
            .blob([0.07, -0.22, -0.14], [0.08, 0.1, 0.2]);
        let [middle, tip] = self.thumb;
        let thumb = [([0.04, 0.26, -0.2], 0.12), (middle, 0.1 * self.slim), (tip, 0.08 * self.slim)];
        (0..4).fold(palm.chain(&thumb), |solid, finger| self.finger(solid, finger))
    }

    fn finger(&self, solid: Solid, finger: usize) -> Solid {
        let length = [0.68, 0.76, 0.7, 0.54][finger];
        let thick = [0.082, 0.086, 0.08, 0.07][finger] * self.slim;
        let y = 0.255 - 0.17 * finger as f64;
        let lean = self.spread * (1.2 - 0.8 * finger as f64) * 0.12;
        let mut at = [0.0, y, 0.3 - 0.05 * (finger as f64 - 1.0).abs()];
        let (mut bend, mut points) = (0.0, vec![(at, 1.1 * thick)]);
        for (share, thinner) in [(0.45, 1.0), (0.3, 0.93), (0.25, 0.82)] {
            bend += f64::to_radians(self.bends[finger]);
            let step = share * length;
            let straight = bend.cos();
            at = [at[0] + step * bend.sin(), at[1] + step * lean * straight.abs(), at[2] + step * straight];
            points.push((at, thinner * thick));
        }
        solid.chain(&points)
    }
}

fn open() -> Solid {
    let thumb = [[0.06, 0.5, 0.02], [0.08, 0.66, 0.22]];
    Pose { bends: [4.0, 3.0, 4.0, 6.0], spread: 1.6, thumb, slim: 1.0 }.solid()
}

fn fist() -> Solid {
    let thumb = [[0.26, 0.34, 0.06], [0.36, 0.12, 0.16]];
    Pose { bends: [82.0; 4], spread: 0.0, thumb, slim: 1.1 }.solid()
}

fn pointing() -> Solid {
    let thumb = [[0.24, 0.32, 0.04], [0.34, 0.08, 0.12]];
    Pose { bends: [3.0, 80.0, 82.0, 82.0], spread: 0.2, thumb, slim: 1.0 }.solid()
}

fn victory() -> Solid {
    let thumb = [[0.24, 0.26, 0.02], [0.34, 0.0, 0.08]];
    Pose { bends: [3.0, 3.0, 80.0, 82.0], spread: 2.2, thumb, slim: 0.9 }.solid()
}

fn relaxed() -> Solid {
    let thumb = [[0.2, 0.42, 0.02], [0.3, 0.46, 0.24]];
    Pose { bends: [22.0, 28.0, 33.0, 38.0], spread: 0.5, thumb, slim: 0.92 }.solid()
}
