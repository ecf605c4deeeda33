//! A triangular mesh: checked, brought to size, and seen along parallel rays.
//!
//! # Reference
//!
//! Rouhafzay et al. 2021, section 3.3, casts a ray from each sensing element along
//! the plane's normal. Those rays are parallel and lie on a grid, so [`Mesh::heights`] goes through
//! the triangles once and asks each which rays it meets: the same distances as ray casting, without
//! a search tree.

use taxel_base::FileError;

use super::vector::{Vector, add, cross, dot, length, scale, sub};
use crate::Result;

/// Above this a mesh is refused: an imprint of a hand needs thousands of triangles, not millions.
pub(crate) const MOST_TRIANGLES: usize = 2_000_000;

/// Vertices and triangles; every index is valid, every number finite, some triangle has an area.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mesh {
    pub vertices: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
    /// Area of all triangles up to and with this one.
    area_up_to: Vec<f64>,
}

/// A plane in space: rows of the grid go against `up`, columns along `right`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ViewPlane {
    pub middle: Vector,
    pub right: Vector,
    pub up: Vector,
    /// Points away from the object; heights count along it.
    pub normal: Vector,
}

/// `side` × `side` parallel rays, `pitch` apart.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayGrid {
    pub side: usize,
    pub pitch: f64,
}

impl Mesh {
    /// Checks a mesh and brings it to a size: centred, `diagonal` from corner to corner of its
    /// bounding box.
    ///
    /// Open and non-manifold surfaces, either winding and single triangles without area are fine:
    /// a sensor touches what it meets from outside, and no inside is ever asked for.
    ///
    /// # Errors
    ///
    /// [`Error::Mesh`](crate::Error::Mesh), naming `file`, for a mesh that is empty, too large, without area, or has
    /// an index out of range or a vertex that is not finite.
    pub fn new(file: &str, vertices: Vec<Vector>, triangles: Vec<[u32; 3]>, diagonal: f64) -> Result<Self> {
        let refuse = |reason: String| Err(FileError::new(file.as_ref(), reason).into());
        if vertices.is_empty() || triangles.is_empty() {
            return refuse("holds no triangles; export a surface, not points or curves".into());
        }
        if triangles.len() > MOST_TRIANGLES {
            return refuse(format!("more than {MOST_TRIANGLES} triangles; decimate the mesh first"));
        }
        if let Some(at) = vertices.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
            return refuse(format!("vertex {at} is {:?}; remove or repair it", vertices[at]));
        }
        if let Some(at) = triangles.iter().position(|t| t.iter().any(|&v| v as usize >= vertices.len())) {
            let (triangle, held) = (triangles[at], vertices.len());
            return refuse(format!(
                "triangle {at} is {triangle:?} of {held} vertices; export the mesh again"
            ));
        }
        // Vertices that no triangle uses are no part of the surface.
        let used = || triangles.iter().flatten().map(|&v| vertices[v as usize]);
        let low = used().fold([f64::INFINITY; 3], |l, v| [0, 1, 2].map(|i| l[i].min(v[i])));
        let high = used().fold([f64::NEG_INFINITY; 3], |h, v| [0, 1, 2].map(|i| h[i].max(v[i])));
        let (middle, extent) = (scale(add(low, high), 0.5), length(sub(high, low)));
        if !(extent > 0.0 && extent.is_finite()) {
            return refuse(format!("is {extent} from corner to corner; export it in sensible units"));
        }
        let vertices: Vec<Vector> =
            vertices.iter().map(|&v| scale(sub(v, middle), diagonal / extent)).collect();
        let mut mesh = Self { vertices, triangles, area_up_to: Vec::new() };
        let mut sum = 0.0;
        let areas = (0..mesh.triangles.len()).map(|t| {
            sum += length(mesh.twice_normal(t)) / 2.0;
            sum
        });
        mesh.area_up_to = areas.collect();
        if sum <= 1e-9 * diagonal * diagonal {
            return refuse("all triangles are degenerate (no area); export a surface".into());
        }
        Ok(mesh)
    }

    fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// Returns the normal of a triangle, as long as twice its area.
    fn twice_normal(&self, triangle: usize) -> Vector {
        let [a, b, c] = self.corners(triangle);
        cross(sub(b, a), sub(c, a))
    }

    /// Returns the point that three numbers in 0..1 choose, uniformly over the surface, and the unit normal of its
    /// triangle.
    pub fn point(&self, chosen: [f64; 3]) -> (Vector, Vector) {
        #[expect(clippy::expect_used, reason = "a mesh without an area is refused")]
        let total = *self.area_up_to.last().expect("new() wants a triangle at least");
        let triangle = self.area_up_to.partition_point(|&sum| sum <= chosen[0] * total);
        let triangle = triangle.min(self.triangles.len() - 1);
        let [a, b, c] = self.corners(triangle);
        let mut across = [chosen[1], chosen[2]];
        if across[0] + across[1] > 1.0 {
            across = across.map(|v| 1.0 - v);
        }
        let point = add(a, add(scale(sub(b, a), across[0]), scale(sub(c, a), across[1])));
        let normal = self.twice_normal(triangle);
        (point, scale(normal, 1.0 / length(normal)))
    }

    /// Finds for each ray of the grid, row by row, the outermost height of the surface above the plane and the triangle
    /// it belongs to; none where the ray meets nothing. What lies below `floor` is passed over.
    pub fn heights(&self, frame: &ViewPlane, grid: RayGrid, floor: f64) -> Vec<Option<(f64, u32)>> {
        let seen: Vec<Vector> = self
            .vertices
            .iter()
            .map(|&vertex| {
                let v = sub(vertex, frame.middle);
                [dot(v, frame.right), dot(v, frame.up), dot(v, frame.normal)]
            })
            .collect();
        let mut heights = vec![None; grid.side * grid.side];
        for (at, triangle) in self.triangles.iter().enumerate() {
            let corners = triangle.map(|v| seen[v as usize]);
            if corners.iter().all(|corner| corner[2] < floor) {
                continue;
            }
            grid.meet(corners, |ray, height| {
                let known: &mut Option<(f64, u32)> = &mut heights[ray];
                if known.is_none_or(|(outermost, _)| outermost < height) {
                    *known = Some((height, at as u32));
                }
            });
        }
        heights
    }

    /// Returns the unit normal of a triangle, on either side.
    pub fn normal(&self, triangle: u32) -> Vector {
        let normal = self.twice_normal(triangle as usize);
        scale(normal, 1.0 / length(normal))
    }
}

impl RayGrid {
    /// Calls `met` with the index of each ray that goes through the triangle and the height where.
    fn meet(self, [a, b, c]: [Vector; 3], mut met: impl FnMut(usize, f64)) {
        let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        // Seen from the side a triangle hides no ray.
        if twice_area == 0.0 {
            return;
        }
        let half = (self.side as f64 - 1.0) / 2.0;
        let Some(columns) = self.between([a[0], b[0], c[0]].map(|x| x / self.pitch + half)) else { return };
        let Some(rows) = self.between([a[1], b[1], c[1]].map(|y| half - y / self.pitch)) else { return };
        for row in rows {
            let y = (half - row as f64) * self.pitch;
            for column in columns.clone() {
                let x = (column as f64 - half) * self.pitch;
                let share = |p: Vector, q: Vector| {
                    ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / twice_area
                };
                let [of_a, of_b, of_c] = [share(b, c), share(c, a), share(a, b)];
                // A ray through a shared edge belongs to both triangles, rounding or not.
                if of_a.min(of_b).min(of_c) >= -1e-9 {
                    met(row * self.side + column, of_a * a[2] + of_b * b[2] + of_c * c[2]);
                }
            }
        }
    }

    /// Returns the grid lines between the smallest and the largest of three places.
    fn between(self, places: [f64; 3]) -> Option<std::ops::RangeInclusive<usize>> {
        let low = places.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
        let high = places.into_iter().fold(f64::NEG_INFINITY, f64::max).min(self.side as f64 - 1.0);
        (low <= high).then(|| (low - 1e-9).max(0.0).ceil() as usize..=(high + 1e-9) as usize)
    }
}
