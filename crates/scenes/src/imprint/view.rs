//! A picture of a mesh: what a camera sees of the object that the sensor touches.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021, sections 2 and 7: pictures by a virtual camera, nothing more
//! is said. Here: parallel projection, one matt material, one lamp beside the camera.

use crate::shapes::mesh::{Mesh, RayGrid, ViewPlane};
use crate::shapes::vector::{Vector, add, cross, dot, length, scale};
use ndarray::ArrayViewMut3;

/// The same for all objects, so that colour tells nothing; red, green, blue in 0..1.
const MATERIAL: [f64; 3] = [0.80, 0.74, 0.66];
const AMBIENT: f64 = 0.25;
/// The picture is wider than the object's bounding box from corner to corner by this.
const MARGIN: f64 = 1.02;

/// Fills `[3, side, side]` with values in 0..1, white where there is no object.
///
/// The camera stands at `azimuth` (0 is in front, along x) and `elevation`, both in radians.
pub(super) fn render(
    mesh: &Mesh,
    diagonal: f64,
    azimuth: f64,
    elevation: f64,
    mut picture: ArrayViewMut3<f32>,
) {
    let side = picture.dim().1;
    let towards = [elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()];
    let right = [-azimuth.sin(), azimuth.cos(), 0.0];
    let frame = ViewPlane { middle: [0.0; 3], right, up: cross(towards, right), normal: towards };
    let lamp = unit(add(towards, add(scale(right, -0.5), scale(frame.up, 0.6))));
    let grid = RayGrid { side, pitch: diagonal * MARGIN / side as f64 };
    picture.fill(1.0);
    for (pixel, seen) in mesh.heights(&frame, grid, f64::NEG_INFINITY).into_iter().enumerate() {
        let Some((_, triangle)) = seen else { continue };
        let normal = mesh.normal(triangle);
        // Which way a triangle winds says nothing: turn its normal to the camera.
        let facing = if dot(normal, towards) < 0.0 { -1.0 } else { 1.0 };
        let light = AMBIENT + (1.0 - AMBIENT) * (facing * dot(normal, lamp)).max(0.0);
        for (channel, material) in MATERIAL.into_iter().enumerate() {
            picture[[channel, pixel / side, pixel % side]] = (material * light) as f32;
        }
    }
}

fn unit(v: Vector) -> Vector {
    scale(v, 1.0 / length(v))
}
