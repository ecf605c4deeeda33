//! Chairs: with slats, armchair, office chair, rocking chair, bar stool with a back.
//!
//! # Reference
//!
//! None; proportions by eye.

use super::{Solid, Variants};

pub(super) const VARIANTS: Variants = [slats, armchair, office, rocking, bar];

/// Adds four legs under a seat of half-widths `half` at `seat`, splayed outward by `splay`.
fn legs(solid: Solid, half: [f64; 2], seat: f64, floor: f64, thick: f64, splay: f64) -> Solid {
    let leg = |solid: Solid, x: f64| {
        let foot = [x * (1.0 + splay), half[1] * (1.0 + splay), floor];
        solid.limb([x, half[1], seat], foot, [thick, 0.75 * thick])
    };
    leg(leg(solid, half[0]), -half[0])
}

fn slats() -> Solid {
    let seat = Solid::new(0.02).slab([0.0, 0.0, 0.0], [0.36, 0.36, 0.035], 0.02);
    let seat = legs(seat, [0.31, 0.31], 0.0, -0.7, 0.04, 0.0);
    let back = seat.limb([-0.33, 0.32, 0.0], [-0.45, 0.32, 0.78], [0.04, 0.03]);
    let back = [-0.16, 0.0, 0.16].into_iter().fold(back, |solid, y| {
        solid.flat([-0.34, y, 0.05], [-0.44, y, 0.7], [0.035, 0.035], [0.35, 1.0, 1.0])
    });
    back.tilted([-0.445, 0.0, 0.72], [0.03, 0.36, 0.07], 0.02, -8.0).mirrored()
}

fn armchair() -> Solid {
    legs(Solid::new(0.04), [0.36, 0.4], -0.2, -0.48, 0.06, 0.0)
        .slab([0.03, 0.0, -0.16], [0.45, 0.42, 0.14], 0.07)
        .slab([0.08, 0.0, 0.04], [0.38, 0.3, 0.1], 0.08)
        .tilted([-0.42, 0.0, 0.22], [0.13, 0.46, 0.5], 0.11, -10.0)
        .slab([0.02, 0.42, 0.06], [0.44, 0.11, 0.2], 0.09)
        .mirrored()
}

fn office() -> Solid {
    let base = Solid::new(0.03).limb([0.0, 0.0, 0.0], [0.0, 0.0, -0.5], [0.05, 0.05]);
    let star = (0..5).map(|i| (f64::from(i) * 72.0).to_radians());
    let base = star.fold(base, |solid, angle| {
        let foot = [0.42 * angle.cos(), 0.42 * angle.sin(), -0.58];
        solid.limb([0.0, 0.0, -0.5], foot, [0.05, 0.035]).ball([foot[0], foot[1], -0.64], 0.06)
    });
    // Two arms by hand: the star is not symmetric piece by piece.
    let arm = |solid: Solid, y: f64| {
        let rod = solid.limb([-0.05, y, 0.0], [-0.05, y, 0.3], [0.03, 0.03]);
        rod.slab([0.04, y, 0.31], [0.22, 0.05, 0.03], 0.03)
    };
    arm(arm(base, 0.4), -0.4)
        .slab([0.0, 0.0, 0.0], [0.36, 0.36, 0.07], 0.06)
        .limb([-0.36, 0.0, 0.0], [-0.46, 0.0, 0.25], [0.05, 0.04])
        .tilted([-0.44, 0.0, 0.55], [0.05, 0.32, 0.38], 0.045, -8.0)
}

fn rocking() -> Solid {
    let seat = Solid::new(0.02).slab([0.0, 0.0, 0.0], [0.36, 0.36, 0.04], 0.03);
    let seat = legs(seat, [0.3, 0.31], 0.0, -0.48, 0.035, 0.1);
    let runner = [-60, -30, 0, 30, 60].map(|at: i32| {
        let x = f64::from(at) / 100.0;
        ([x, 0.345, -0.6 + 0.33 * x * x], 0.035)
    });
    let back = seat.chain(&runner).limb([-0.33, 0.31, 0.0], [-0.52, 0.31, 0.8], [0.035, 0.03]);
    let back = [-0.2, -0.1, 0.0, 0.1, 0.2]
        .into_iter()
        .fold(back, |solid, y| solid.limb([-0.33, y, 0.0], [-0.51, y, 0.75], [0.02, 0.02]));
    back.limb([-0.52, -0.31, 0.8], [-0.52, 0.31, 0.8], [0.045, 0.045])
        .chain(&[([0.27, 0.33, 0.0], 0.025), ([0.25, 0.37, 0.27], 0.03), ([-0.38, 0.34, 0.3], 0.03)])
        .mirrored()
}

fn bar() -> Solid {
    let seat = Solid::new(0.02).flat([0.0; 3], [0.0; 3], [0.3, 0.3], [1.0, 1.0, 0.2]);
    let legs = legs(seat, [0.17, 0.17], -0.02, -1.05, 0.035, 0.7);
    let ring = legs
        .limb([0.25, -0.25, -0.68], [0.25, 0.25, -0.68], [0.022, 0.022])
        .limb([-0.25, -0.25, -0.68], [-0.25, 0.25, -0.68], [0.022, 0.022])
        .limb([-0.23, 0.23, -0.55], [0.23, 0.23, -0.55], [0.022, 0.022]);
    let back = [(-0.27, 0.0), (-0.23, 0.14), (-0.13, 0.24)].map(|(x, y)| ([x, y, 0.3], 0.035));
    ring.chain(&back).limb([-0.22, 0.12, 0.0], [-0.23, 0.14, 0.3], [0.025, 0.025]).mirrored()
}
