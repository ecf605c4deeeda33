//! Birds: sparrow, gull on the wing, heron, duck, penguin.
//!
//! # Reference
//!
//! None; proportions by eye.

use super::{Solid, Variants};

pub(super) const VARIANTS: Variants = [sparrow, gull, heron, duck, penguin];

/// Adds neck, head and beak; the head's middle is given.
fn head(solid: Solid, from: [f64; 3], at: [f64; 3], radius: f64, beak: [f64; 2]) -> Solid {
    let [x, _, z] = at;
    let front = x + 0.7 * radius;
    solid
        .limb(from, at, [0.13, 0.75 * radius])
        .ball(at, radius)
        .limb([front, 0.0, z], [front + beak[0], 0.0, z - 0.1 * beak[0]], [beak[1], 0.25 * beak[1]])
        .ball([x + 0.5 * radius, 0.75 * radius, z + 0.25 * radius], 0.18 * radius)
}

fn folded_wing(solid: Solid, width: f64) -> Solid {
    let squash = [1.0, 0.3, 1.0];
    solid.flat([0.18, width, 0.06], [-0.3, 0.9 * width, 0.02], [0.2, 0.14], squash).flat(
        [-0.3, 0.9 * width, 0.02],
        [-0.62, 0.4 * width, 0.02],
        [0.14, 0.05],
        squash,
    )
}

fn leg(solid: Solid, hip: [f64; 3], length: f64, thick: f64) -> Solid {
    let (x, y, foot) = (hip[0], hip[1], hip[2] - length);
    solid
        .limb(hip, [x + 0.03, y, foot], [1.6 * thick, thick])
        .limb([x + 0.03, y, foot], [x + 0.2, y + 0.06, foot - 0.01], [thick, 0.7 * thick])
        .limb([x + 0.03, y, foot], [x + 0.2, y - 0.05, foot - 0.01], [thick, 0.7 * thick])
        .limb([x + 0.03, y, foot], [x - 0.1, y, foot - 0.01], [thick, 0.7 * thick])
}

fn sparrow() -> Solid {
    let body = Solid::new(0.05).limb([0.16, 0.0, 0.06], [-0.22, 0.0, -0.02], [0.27, 0.2]);
    let body = body.flat([-0.35, 0.0, 0.02], [-0.8, 0.0, 0.1], [0.12, 0.11], [1.0, 1.0, 0.3]);
    let body = head(body, [0.25, 0.0, 0.15], [0.36, 0.0, 0.36], 0.19, [0.14, 0.06]);
    leg(folded_wing(body, 0.26), [0.0, 0.1, -0.15], 0.28, 0.025).mirrored()
}

fn gull() -> Solid {
    let thin = [1.0, 1.0, 0.22];
    let body = Solid::new(0.05).limb([0.25, 0.0, 0.0], [-0.35, 0.0, 0.0], [0.17, 0.1]);
    head(body, [0.3, 0.0, 0.03], [0.52, 0.0, 0.08], 0.13, [0.2, 0.045])
        .flat([-0.35, 0.0, 0.0], [-0.66, 0.0, 0.01], [0.09, 0.17], [1.0, 1.0, 0.2])
        .flat([0.08, 0.1, 0.06], [0.16, 0.55, 0.2], [0.19, 0.16], thin)
        .flat([0.16, 0.55, 0.2], [-0.05, 1.05, 0.16], [0.16, 0.1], thin)
        .flat([-0.05, 1.05, 0.16], [-0.28, 1.35, 0.1], [0.1, 0.03], thin)
        .mirrored()
}

fn heron() -> Solid {
    let body = Solid::new(0.04).limb([0.1, 0.0, 0.0], [-0.28, 0.0, -0.1], [0.2, 0.12]);
    let body = body.flat([-0.3, 0.0, -0.1], [-0.6, 0.0, -0.2], [0.11, 0.07], [1.0, 1.0, 0.35]);
    let neck = [
        ([0.2, 0.0, 0.08], 0.1),
        ([0.36, 0.0, 0.3], 0.065),
        ([0.24, 0.0, 0.55], 0.055),
        ([0.34, 0.0, 0.76], 0.055),
    ];
    let body = head(body.chain(&neck), [0.34, 0.0, 0.76], [0.4, 0.0, 0.8], 0.09, [0.34, 0.04]);
    leg(folded_wing(body, 0.18), [-0.04, 0.08, -0.15], 0.75, 0.025).mirrored()
}

fn duck() -> Solid {
    let body = Solid::new(0.06).flat([0.18, 0.0, 0.0], [-0.3, 0.0, 0.0], [0.3, 0.25], [1.0, 1.0, 0.8]);
    let body = body.flat([-0.4, 0.0, 0.05], [-0.68, 0.0, 0.2], [0.14, 0.05], [1.0, 1.0, 0.5]);
    let body = body.chain(&[([0.3, 0.0, 0.12], 0.15), ([0.38, 0.0, 0.34], 0.1), ([0.44, 0.0, 0.44], 0.12)]);
    let bill = body.ball([0.45, 0.0, 0.45], 0.15).flat(
        [0.55, 0.0, 0.42],
        [0.78, 0.0, 0.37],
        [0.08, 0.09],
        [1.0, 1.0, 0.35],
    );
    folded_wing(bill.ball([0.52, 0.11, 0.5], 0.025), 0.29).mirrored()
}

fn penguin() -> Solid {
    let body = Solid::new(0.05).chain(&[
        ([0.0, 0.0, -0.35], 0.26),
        ([0.02, 0.0, 0.0], 0.27),
        ([0.04, 0.0, 0.35], 0.17),
        ([0.06, 0.0, 0.52], 0.15),
    ]);
    head(body, [0.04, 0.0, 0.4], [0.07, 0.0, 0.55], 0.16, [0.17, 0.045])
        .flat([0.0, 0.22, 0.25], [-0.06, 0.42, -0.2], [0.1, 0.06], [1.0, 0.3, 1.0])
        .flat([0.05, 0.13, -0.62], [0.22, 0.16, -0.64], [0.1, 0.11], [1.0, 1.0, 0.35])
        .flat([-0.2, 0.0, -0.5], [-0.36, 0.0, -0.6], [0.12, 0.06], [1.0, 1.0, 0.5])
        .mirrored()
}
