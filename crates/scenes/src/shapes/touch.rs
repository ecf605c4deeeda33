//! A flat sensor set against a random point of a mesh.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021, section 3.3: a plane tangent to the mesh at the probed point.

use super::mesh::{Mesh, RayGrid, ViewPlane};
use super::vector::{Vector, add, cross, length, scale};
use rand::RngExt;
use taxel_base::seed::Rng;

/// Points tried before an object is given up.
pub(crate) const TRIES: usize = 1000;

/// Where a sensor touches an object, and how far from it the surface is.
pub(crate) struct Touch {
    pub point: Vector,
    pub normal: Vector,
    /// How far out of the tangent plane the first ray touches, in mm; a little below 0 where the point itself lies
    /// between rays.
    pub lift: f64,
    /// Distance of the surface behind the first touch, in mm, ray by ray; none where a ray meets nothing.
    pub gaps: Vec<Option<f64>>,
}

/// Sets a sensor that feels `depth` mm deep, turned by `spin` radians about the normal, against a point drawn from
/// `place` uniformly over the surface. In a hollow the plane moves out until the first ray touches; a point that then
/// lies out of reach is given up and another drawn. None where [`TRIES`] points are out of reach.
pub(crate) fn touch(mesh: &Mesh, place: &mut Rng, spin: f64, grid: RayGrid, depth: f64) -> Option<Touch> {
    for _ in 0..TRIES {
        let (point, normal) = mesh.point(place.random());
        // An open or badly wound surface may be meant to be felt from its other side.
        for normal in [normal, scale(normal, -1.0)] {
            // A sensor that stops above -depth feels nothing below twice that.
            let heights = mesh.heights(&tangent(point, normal, spin), grid, -2.0 * depth);
            let first = heights.iter().flatten().map(|(height, _)| *height).max_by(f64::total_cmp);
            let Some(lift) = first.filter(|first| first.abs() < depth) else { continue };
            let gap = |seen: Option<(f64, u32)>| seen.map(|(height, _)| lift - height);
            return Some(Touch { point, normal, lift, gaps: heights.into_iter().map(gap).collect() });
        }
    }
    None
}

/// Returns the tangent plane at a point; without spin, up is as far up as it can be.
pub(crate) fn tangent(point: Vector, normal: Vector, spin: f64) -> ViewPlane {
    let level = cross([0.0, 0.0, 1.0], normal);
    let right = match length(level) {
        flat if flat < 1e-6 => [1.0, 0.0, 0.0],
        steep => scale(level, 1.0 / steep),
    };
    // On top of an object, right is not quite at a right angle to the normal: make it so.
    let up = cross(normal, right);
    let up = scale(up, 1.0 / length(up));
    let right = cross(up, normal);
    let (sin, cos) = spin.sin_cos();
    ViewPlane {
        middle: point,
        right: add(scale(right, cos), scale(up, sin)),
        up: add(scale(up, cos), scale(right, -sin)),
        normal,
    }
}
