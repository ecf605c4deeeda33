//! One picture: a mesh under a lamp, its texture, what is behind it.
//!
//! # Reference
//!
//! Lambert's cosine law; value noise (random numbers on a lattice, smoothly in between) for texture and background.

use ndarray::ArrayViewMut3;

use super::parameters::{BACKGROUND, TEXTURE};
use crate::shapes::mesh::{Mesh, RayGrid, ViewPlane};
use crate::shapes::vector::{Vector, add, cross, dot, length, scale};

/// Rays along a side of each pixel: edges are smooth.
const RAYS: usize = 2;
/// Without a texture: grey; without a background: black.
const PLAIN: [f64; 3] = [0.75; 3];

/// The quantities that differ from picture to picture. Angles in radians.
pub(super) struct Appearance {
    pub azimuth: f64,
    pub elevation: f64,
    pub roll: f64,
    /// Share of the picture that the bounding box fills from corner to corner.
    pub zoom: f64,
    /// In shares of the picture, to the right and up.
    pub shift: [f64; 2],
    /// Turn of the lamp about the line of sight, and angle between both.
    pub lamp: [f64; 2],
    pub ambient: f64,
    /// Numbers in 0..1: two colours, size of the grain, its seed.
    pub texture: Option<[f64; 12]>,
    /// Likewise.
    pub background: Option<[f64; 12]>,
}

impl Appearance {
    pub const TRUTH: [&'static str; 7] =
        ["azimuth_deg", "elevation_deg", "roll_deg", "zoom", "shift_x", "shift_y", "ambient"];

    /// Lists the values in the order of [`Appearance::TRUTH`].
    pub fn truth(&self) -> Vec<f64> {
        let angles = [self.azimuth, self.elevation, self.roll].map(f64::to_degrees);
        [&angles[..], &[self.zoom], &self.shift, &[self.ambient]].concat()
    }
}

/// Fills `[3, side, side]` with values in 0..1. The mesh is `size` from corner to corner.
pub(super) fn picture(mesh: &Mesh, size: f64, look: &Appearance, mut picture: ArrayViewMut3<f32>) {
    let side = picture.dim().1;
    let (frame, lamp) = camera(look);
    let width = size / look.zoom;
    let grid = RayGrid { side: side * RAYS, pitch: width / (side * RAYS) as f64 };
    let middle = add(scale(frame.right, -look.shift[0] * width), scale(frame.up, -look.shift[1] * width));
    let frame = ViewPlane { middle, ..frame };
    let texture = look.texture.map(|drawn| Paint::new(drawn, TEXTURE.value));
    let background = look.background.map(|drawn| Paint::new(drawn, BACKGROUND.value));
    let share = 1.0 / (RAYS * RAYS) as f32;
    picture.fill(0.0);
    for (ray, seen) in mesh.heights(&frame, grid, f64::NEG_INFINITY).into_iter().enumerate() {
        let (row, column) = (ray / grid.side, ray % grid.side);
        let half = (grid.side as f64 - 1.0) / 2.0;
        let across = [(column as f64 - half) * grid.pitch, (half - row as f64) * grid.pitch];
        let colour = match seen {
            None => background
                .as_ref()
                .map_or([0.0; 3], |paint| paint.colour([across[0] / width, across[1] / width, 0.0])),
            Some((height, triangle)) => {
                let in_plane = add(scale(frame.right, across[0]), scale(frame.up, across[1]));
                let place = add(middle, add(in_plane, scale(frame.normal, height)));
                let colour = texture.as_ref().map_or(PLAIN, |paint| paint.colour(scale(place, 1.0 / size)));
                let normal = mesh.normal(triangle);
                // Which way a triangle winds says nothing: turn its normal to the camera.
                let facing = if dot(normal, frame.normal) < 0.0 { -1.0 } else { 1.0 };
                let light = look.ambient + (1.0 - look.ambient) * (facing * dot(normal, lamp)).max(0.0);
                colour.map(|value| value * light)
            }
        };
        for (channel, value) in colour.into_iter().enumerate() {
            picture[[channel, row / RAYS, column / RAYS]] += value as f32 * share;
        }
    }
    // Sums of shares may pass 1 in the last digit.
    picture.mapv_inplace(|value| value.clamp(0.0, 1.0));
}

/// Returns the plane of the picture, facing the camera, and the direction of the lamp.
fn camera(look: &Appearance) -> (ViewPlane, Vector) {
    let Appearance { azimuth, elevation, roll, lamp: [turn, away], .. } = *look;
    let towards = [elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()];
    let level = [-azimuth.sin(), azimuth.cos(), 0.0];
    let upright = cross(towards, level);
    let turned = |sin: f64, cos: f64| add(scale(level, cos), scale(upright, sin));
    let (sin, cos) = roll.sin_cos();
    let frame =
        ViewPlane { middle: [0.0; 3], right: turned(sin, cos), up: turned(cos, -sin), normal: towards };
    let beside = turned(turn.sin(), turn.cos());
    let lamp = add(scale(towards, away.cos()), scale(beside, away.sin()));
    (frame, scale(lamp, 1.0 / length(lamp)))
}

/// Two colours, mixed by noise.
struct Paint {
    colours: [[f64; 3]; 2],
    grains: f64,
    seed: u64,
}

impl Paint {
    fn new(drawn: [f64; 12], grains: &[f64]) -> Self {
        let [a, b, c, d, e, f, size, seed, ..] = drawn;
        Paint {
            colours: [[a, b, c], [d, e, f]],
            grains: grains[0] * (grains[1] / grains[0]).powf(size),
            seed: seed.to_bits(),
        }
    }

    fn colour(&self, place: Vector) -> [f64; 3] {
        let mix = noise(scale(place, self.grains), self.seed);
        let [one, other] = self.colours;
        std::array::from_fn(|channel| one[channel] + (other[channel] - one[channel]) * mix)
    }
}

/// Returns value noise in 0..1: random at whole numbers, smooth in between.
fn noise(place: Vector, seed: u64) -> f64 {
    let cell = place.map(f64::floor);
    // Without slope at whole numbers.
    let within: Vector = std::array::from_fn(|axis| {
        let t = place[axis] - cell[axis];
        t * t * (3.0 - 2.0 * t)
    });
    (0..8usize)
        .map(|corner| {
            let bit = |axis: usize| (corner >> axis & 1) as f64;
            let weight: f64 =
                (0..3).map(|axis| if bit(axis) > 0.0 { within[axis] } else { 1.0 - within[axis] }).product();
            weight * lattice(std::array::from_fn(|axis| (cell[axis] + bit(axis)) as i64), seed)
        })
        .sum()
}

/// Returns a number in 0..1 for a point of the lattice (the finaliser of SplitMix64, Steele et al. 2014, over its
/// parts).
fn lattice(point: [i64; 3], seed: u64) -> f64 {
    let mixed = point.into_iter().fold(seed, |state, part| {
        let mut z = (state ^ part as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    });
    (mixed >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_lattice_at_whole_numbers_and_stays_between_its_corners() {
        for (x, y, z) in [(0, 0, 0), (3, -2, 7), (-5, 4, 1)] {
            let at = noise([x as f64, y as f64, z as f64], 9);
            assert_eq!(at, lattice([x, y, z], 9));
        }
        let values: Vec<f64> =
            (0..1000).map(|i| noise([i as f64 * 0.173, i as f64 * 0.311, 0.4], 5)).collect();
        assert!(values.iter().all(|value| (0.0..=1.0).contains(value)));
        let mean = values.iter().sum::<f64>() / 1000.0;
        assert!((mean - 0.5).abs() < 0.1, "{mean}");
        // Another seed is another texture, and neighbours are alike.
        assert_ne!(noise([0.5, 0.5, 0.5], 1), noise([0.5, 0.5, 0.5], 2));
        assert!((noise([0.5, 0.5, 0.5], 1) - noise([0.501, 0.5, 0.5], 1)).abs() < 0.01);
    }
}
