//! Bodies made of rounded parts that flow into each other, and their surface as a mesh.
//!
//! # Reference
//!
//! Signed distances of capsules and rounded boxes, and the polynomial smooth minimum, after
//! I. Quilez, "Distance functions" and "Smooth minimum". The surface by naive surface nets (Gibson,
//! "Constrained elastic surface nets", 1998, without relaxation): one vertex in each cell that the
//! surface crosses, one quad for each edge that it crosses, so it is closed.

use super::vector::{Vector, add, dot, length, scale, sub};

/// Cells along the longest side: under 2 mm on an object of 200 mm.
const CELLS: usize = 120;
/// Radius of the edges of flat parts: thin edges would come out ragged between the cells.
const EDGE: f64 = 0.02;
/// Cells along a side of the blocks that are skipped when the surface is far.
const BLOCK: usize = 5;
/// No distance changes by more than this over a unit.
const STEEPEST: f64 = 1.6;

/// A rounded part; where two meet, the solid's blend rounds the corner.
#[derive(Debug, Clone, Copy)]
struct SolidPart {
    form: Form,
    /// Taken away instead of added.
    carved: bool,
}

#[derive(Debug, Clone, Copy)]
enum Form {
    /// A rod from `a` to `b` with another radius at each end, in a space squashed along the axes.
    Limb { a: Vector, b: Vector, radii: [f64; 2], squash: Vector },
    /// A box with rounded edges, its front raised by an angle about y (in radians).
    Slab { middle: Vector, half: Vector, round: f64, raised: f64 },
}

/// A body under construction; x is forward, y left, z up, any unit.
#[derive(Debug, Clone)]
pub(crate) struct Solid {
    parts: Vec<SolidPart>,
    blend: f64,
}

impl Solid {
    /// Makes a solid of no parts yet; they will be rounded into each other over about `blend`.
    pub fn new(blend: f64) -> Self {
        Self { parts: Vec::new(), blend }
    }

    fn with(mut self, form: Form) -> Self {
        self.parts.push(SolidPart { form, carved: false });
        self
    }

    pub fn ball(self, middle: Vector, radius: f64) -> Self {
        self.limb(middle, middle, [radius, radius])
    }

    pub fn blob(self, middle: Vector, radii: Vector) -> Self {
        let most = radii[0].max(radii[1]).max(radii[2]);
        self.flat(middle, middle, [most, most], scale(radii, 1.0 / most))
    }

    pub fn limb(self, a: Vector, b: Vector, radii: [f64; 2]) -> Self {
        self.flat(a, b, radii, [1.0; 3])
    }

    /// Adds a limb whose radii shrink to a share along each axis.
    pub fn flat(self, a: Vector, b: Vector, radii: [f64; 2], squash: Vector) -> Self {
        self.with(Form::Limb { a, b, radii, squash })
    }

    /// Adds a limb through several points, each with its radius.
    pub fn chain(self, points: &[(Vector, f64)]) -> Self {
        points.windows(2).fold(self, |solid, ends| solid.limb(ends[0].0, ends[1].0, [ends[0].1, ends[1].1]))
    }

    pub fn slab(self, middle: Vector, half: Vector, round: f64) -> Self {
        self.tilted(middle, half, round, 0.0)
    }

    /// Adds a slab whose front is raised by `degrees`.
    pub fn tilted(self, middle: Vector, half: Vector, round: f64, degrees: f64) -> Self {
        self.with(Form::Slab { middle, half, round, raised: degrees.to_radians() })
    }

    /// Takes a ball away.
    pub fn hollow(mut self, middle: Vector, radius: f64) -> Self {
        self = self.ball(middle, radius);
        if let Some(part) = self.parts.last_mut() {
            part.carved = true;
        }
        self
    }

    /// Repeats all parts off the middle plane on its other side.
    pub fn mirrored(mut self) -> Self {
        let other = |v: Vector| [v[0], -v[1], v[2]];
        let twins = self.parts.iter().filter_map(|part| {
            let (off, form) = match part.form {
                Form::Limb { a, b, radii, squash } => {
                    (a[1] != 0.0 || b[1] != 0.0, Form::Limb { a: other(a), b: other(b), radii, squash })
                }
                Form::Slab { middle, half, round, raised } => {
                    (middle[1] != 0.0, Form::Slab { middle: other(middle), half, round, raised })
                }
            };
            off.then_some(SolidPart { form, ..*part })
        });
        let twins: Vec<SolidPart> = twins.collect();
        self.parts.extend(twins);
        self
    }

    /// Computes the surface: vertices and triangles.
    pub fn surface(&self) -> (Vec<Vector>, Vec<[u32; 3]>) {
        let (low, high) = self.bounds();
        let extent = sub(high, low);
        let cell = extent.into_iter().fold(0.0, f64::max) / CELLS as f64;
        // A cell of room on every side, in whole blocks.
        let size = extent.map(|e| ((e / cell) as usize + 3).next_multiple_of(BLOCK) + 1);
        let start = sub(low, [cell; 3]);
        Nets { size, start, cell }.surface(&self.field(size, start, cell))
    }

    fn bounds(&self) -> (Vector, Vector) {
        let mut bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for part in self.parts.iter().filter(|part| !part.carved) {
            let (low, high) = part.bounds();
            bounds.0 = [0, 1, 2].map(|i| bounds.0[i].min(low[i]));
            bounds.1 = [0, 1, 2].map(|i| bounds.1[i].max(high[i]));
        }
        // Where several parts meet, blending bulges, by less than its width.
        (sub(bounds.0, [self.blend; 3]), add(bounds.1, [self.blend; 3]))
    }

    /// Computes the distances at the corners of all cells; far from the surface only their sign is right.
    fn field(&self, size: [usize; 3], start: Vector, cell: f64) -> Vec<f64> {
        let mut field = vec![0.0; size.iter().product()];
        let place = |at: Vector| add(start, scale(at, cell));
        // From the middle of a block to its corners and to the next block. The distance to a limb
        // that tapers changes faster than the place does.
        let reach = STEEPEST * (0.5 * BLOCK as f64 * 3f64.sqrt() + 1.0) * cell;
        let blocks = size.map(|n| n.div_ceil(BLOCK));
        for (bx, by, bz) in all(blocks) {
            let corner = [bx * BLOCK, by * BLOCK, bz * BLOCK];
            let middle = place(corner.map(|c| c as f64 + BLOCK as f64 / 2.0));
            let around = distance(&self.parts, self.blend, middle);
            // No part beyond this can be felt anywhere in the block.
            let felt = around.abs() + 2.0 * reach + self.blend;
            let far = around.abs() > reach;
            let is_near = |part: &&SolidPart| !far && part.distance(middle) <= felt;
            let near: Vec<SolidPart> = self.parts.iter().filter(is_near).copied().collect();
            for (x, y, z) in all([0, 1, 2].map(|i| BLOCK.min(size[i] - corner[i]))) {
                let at = [corner[0] + x, corner[1] + y, corner[2] + z];
                let value =
                    if far { around } else { distance(&near, self.blend, place(at.map(|c| c as f64))) };
                field[(at[0] * size[1] + at[1]) * size[2] + at[2]] = value;
            }
        }
        field
    }
}

/// Computes the signed distance of a point to the union of the parts, less what is carved.
fn distance(parts: &[SolidPart], blend: f64, point: Vector) -> f64 {
    let added = parts.iter().filter(|part| !part.carved);
    let union = added.fold(f64::INFINITY, |sum, part| smooth_min(sum, part.distance(point), blend));
    let carved = parts.iter().filter(|part| part.carved);
    carved.fold(union, |rest, part| -smooth_min(-rest, part.distance(point), blend))
}

fn smooth_min(a: f64, b: f64, blend: f64) -> f64 {
    let overlap = (blend - (a - b).abs()).max(0.0);
    a.min(b) - if overlap > 0.0 { overlap * overlap / (4.0 * blend) } else { 0.0 }
}

impl SolidPart {
    fn distance(&self, point: Vector) -> f64 {
        match self.form {
            Form::Limb { a, b, radii, squash } => {
                let wide = |v: Vector| [v[0] / squash[0], v[1] / squash[1], v[2] / squash[2]];
                let (point, a, b) = (wide(point), wide(a), wide(b));
                let (along, from) = (sub(b, a), sub(point, a));
                let share = (dot(from, along) / dot(along, along).max(1e-12)).clamp(0.0, 1.0);
                let radius = radii[0] + share * (radii[1] - radii[0]);
                let out = sub(from, scale(along, share));
                if squash == [1.0; 3] {
                    return length(out) - radius;
                }
                // Divided by its slope, the squashed distance is right near the surface.
                let slope = length(wide(out)) / length(out).max(1e-12);
                (length(out) - radius) / slope.max(1.0) - EDGE
            }
            Form::Slab { middle, half, round, raised } => {
                let p = sub(point, middle);
                let (sin, cos) = raised.sin_cos();
                let p = [cos * p[0] + sin * p[2], p[1], cos * p[2] - sin * p[0]];
                let over = [0, 1, 2].map(|i| p[i].abs() - half[i] + round);
                let inside = over[0].max(over[1]).max(over[2]).min(0.0);
                length(over.map(|v| v.max(0.0))) + inside - round
            }
        }
    }

    fn bounds(&self) -> (Vector, Vector) {
        match self.form {
            Form::Limb { a, b, radii, squash } => {
                let reach = squash.map(|s| s * radii[0].max(radii[1]) + EDGE);
                let low = [0, 1, 2].map(|i| a[i].min(b[i]) - reach[i]);
                (low, [0, 1, 2].map(|i| a[i].max(b[i]) + reach[i]))
            }
            Form::Slab { middle, half, raised, .. } => {
                let (sin, cos) = (raised.sin().abs(), raised.cos().abs());
                let half = [cos * half[0] + sin * half[2], half[1], sin * half[0] + cos * half[2]];
                (sub(middle, half), add(middle, half))
            }
        }
    }
}

/// Iterates over all triples below `size`.
fn all(size: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
    let [a, b, c] = size;
    (0..a).flat_map(move |x| (0..b).flat_map(move |y| (0..c).map(move |z| (x, y, z))))
}

/// A grid of cells over a field of distances.
struct Nets {
    size: [usize; 3],
    start: Vector,
    cell: f64,
}

impl Nets {
    fn index(&self, at: [usize; 3]) -> usize {
        (at[0] * self.size[1] + at[1]) * self.size[2] + at[2]
    }

    fn surface(&self, field: &[f64]) -> (Vec<Vector>, Vec<[u32; 3]>) {
        const NONE: u32 = u32::MAX;
        let mut vertices = Vec::new();
        let mut vertex_of = vec![NONE; field.len()];
        for (x, y, z) in all(self.size.map(|n| n - 1)) {
            if let Some(vertex) = self.vertex([x, y, z], field) {
                vertex_of[self.index([x, y, z])] = vertices.len() as u32;
                vertices.push(vertex);
            }
        }
        let mut triangles = Vec::new();
        for (x, y, z) in all(self.size.map(|n| n - 1)) {
            let here = [x, y, z];
            let inside = field[self.index(here)] < 0.0;
            for axis in 0..3 {
                let mut next = here;
                next[axis] += 1;
                if inside == (field[self.index(next)] < 0.0) {
                    continue;
                }
                // The surface crosses this edge: join the vertices of the four cells around it.
                let [one, two] = [(axis + 1) % 3, (axis + 2) % 3];
                if here[one] == 0 || here[two] == 0 {
                    continue;
                }
                let corner = |back: [bool; 2]| {
                    let mut cell = here;
                    cell[one] -= usize::from(back[0]);
                    cell[two] -= usize::from(back[1]);
                    vertex_of[self.index(cell)]
                };
                let [a, b, c, d] = [[true, true], [false, true], [false, false], [true, false]].map(corner);
                // Seen from outside, corners go round counter-clockwise.
                let quad = if inside { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                triangles.extend(quad);
            }
        }
        (vertices, triangles)
    }

    /// Returns the mean of the points where the surface crosses the edges of a cell, if it does.
    fn vertex(&self, cell: [usize; 3], field: &[f64]) -> Option<Vector> {
        let corner = |bits: usize| [0, 1, 2].map(|axis| cell[axis] + (bits >> axis & 1));
        let values: [f64; 8] = std::array::from_fn(|bits| field[self.index(corner(bits))]);
        if values.iter().all(|v| *v < 0.0) || values.iter().all(|v| *v >= 0.0) {
            return None;
        }
        let (mut sum, mut crossings) = ([0.0; 3], 0);
        for bits in 0..8 {
            for axis in 0..3 {
                let other = bits | 1 << axis;
                let (from, to) = (values[bits], values[other]);
                if other != bits && (from < 0.0) != (to < 0.0) {
                    let mut point = corner(bits).map(|c| c as f64);
                    point[axis] += from / (from - to);
                    sum = add(sum, point);
                    crossings += 1;
                }
            }
        }
        Some(add(self.start, scale(sum, self.cell / f64::from(crossings))))
    }
}
