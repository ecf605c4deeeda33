//! The side of an object that faces the sensor, as a height map over the taxels.
//!
//! # Reference
//!
//! None: geometry of the shapes in [`objects`](super::objects).

use super::objects::{Item, ObjectShape, SqueezedObject};
use super::parameters::*;
use crate::world::{World, normal};
use rand::RngExt;
use std::f64::consts::{PI, TAU};
use taxel_base::seed::Rng;

/// Taxels of a frame.
pub(super) const TAXELS: usize = 28 * 50;

/// A distance that nothing is squeezed through, mm.
pub(super) const FAR: f32 = 1e6;

/// Where the object lies on the sensor.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Placement {
    /// Of its centre from the sensor's, along and across, mm.
    pub(super) shift: [f64; 2],
    /// rad.
    pub(super) turn: f64,
}

impl Placement {
    pub(super) fn draw(world: &World, sample: usize) -> Placement {
        let mut rng = world.rng(&format!("{sample}/placement"));
        let mut by = |sd: f64| world.unless("placement", sd * normal(&mut rng), 0.0);
        Placement { shift: [by(SHIFT.value[1]), by(SHIFT.value[0])], turn: by(TURN.get().to_radians()) }
    }

    /// Turns a place on the object into one on the sensor.
    fn out(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turn.sin_cos();
        [self.shift[0] + u * cos - v * sin, self.shift[1] + u * sin + v * cos]
    }

    /// Turns a place on the sensor into one on the object.
    fn back(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turn.sin_cos();
        let (x, y) = (x - self.shift[0], y - self.shift[1]);
        [x * cos + y * sin, -x * sin + y * cos]
    }
}

/// Returns the pitch of the taxels along and across, mm.
pub(super) fn pitch() -> [f64; 2] {
    [WIDTH.get() / COLUMNS.get(), HEIGHT.get() / ROWS.get()]
}

/// Returns the centre of a taxel from the sensor's, along and across, mm.
pub(super) fn centre(taxel: usize) -> [f64; 2] {
    let columns = COLUMNS.get() as usize;
    let [along, across] = pitch();
    let (row, column) = ((taxel / columns) as f64, (taxel % columns) as f64);
    [(column + 0.5 - COLUMNS.get() / 2.0) * along, (row + 0.5 - ROWS.get() / 2.0) * across]
}

/// Computes the distance of the surface behind each taxel from the object's foremost point, mm; [`FAR`] beside it. A
/// bag has its own: [`Heap`].
pub(super) fn gaps(object: &SqueezedObject, place: &Placement, textured: bool) -> Vec<f32> {
    let gap = |taxel: usize| {
        let [u, v] = place.back(centre(taxel));
        let shape = shape_gap(&object.shape, u, v)?;
        let texture = object.texture.filter(|_| textured).map_or(0.0, |t| {
            let (u, v) = (TAU * u / t.pitch, TAU * v / t.pitch);
            t.height * (1.0 - u.cos() * v.cos()) / 2.0
        });
        Some((shape + texture) as f32)
    };
    (0..TAXELS).map(|taxel| gap(taxel).unwrap_or(FAR)).collect()
}

fn shape_gap(shape: &ObjectShape, u: f64, v: f64) -> Option<f64> {
    match *shape {
        ObjectShape::Cylinder { radius, length, ribs } => {
            let round = radius * radius - v * v;
            let rib = ribs.map_or(0.0, |r| r.depth * (1.0 - (TAU * u / r.pitch).cos()) / 2.0);
            (round > 0.0 && u.abs() <= length / 2.0).then(|| radius - round.sqrt() + rib)
        }
        ObjectShape::Ellipsoid { half: [a, b, c], groove } => {
            let round = 1.0 - (u / a).powi(2) - (v / b).powi(2);
            let slit = groove.is_some_and(|g| v.abs() < g.half_width && u > 0.0 && u < g.length);
            (round > 0.0 && !slit).then(|| c * (1.0 - round.sqrt()))
        }
        ObjectShape::Rim { radius, round } => {
            let from = (u.hypot(v) - radius).abs();
            (from < round).then(|| round - (round * round - from * from).sqrt())
        }
        ObjectShape::Block { half: [a, b], round } => {
            // How far each edge is overstepped into its rounding.
            let over = |at: f64, half: f64| (at.abs() - half + round).max(0.0) / round;
            let edge = over(u, a).hypot(over(v, b));
            (edge < 1.0).then(|| round * (1.0 - (1.0 - edge * edge).sqrt()))
        }
        ObjectShape::Bag { .. } => None,
    }
}

/// Computes how deep each taxel has to be squeezed until a lump is felt, mm; `None` without lumps.
pub(super) fn covers(object: &SqueezedObject, place: &Placement) -> Option<Vec<f32>> {
    let cover = |taxel: usize| {
        let [u, v] = place.back(centre(taxel));
        let above = object.inclusions.iter().filter_map(|lump| {
            let from = (u - lump.at[0]).powi(2) + (v - lump.at[1]).powi(2);
            let round = lump.radius * lump.radius - from;
            (round > 0.0).then(|| lump.cover + lump.radius - round.sqrt())
        });
        above.fold(f64::from(FAR), f64::min) as f32
    };
    (!object.inclusions.is_empty()).then(|| (0..TAXELS).map(cover).collect())
}

/// The contents of a bag, item by item.
pub(super) struct Heap {
    items: Vec<Placed>,
}

#[derive(Debug, Clone, Copy)]
struct Placed {
    item: Item,
    at: [f64; 2],
    /// Of its middle above the heap's mean, mm.
    level: f64,
    /// Direction of its axis over the sensor, rad.
    axis: f64,
    /// Lying on its face, tilted by this much along `axis`; or on its side.
    pose: Posture,
}

#[derive(Debug, Clone, Copy)]
enum Posture {
    Flat { slope: f64 },
    Side,
}

impl Heap {
    /// Shakes the bag: every item lands somewhere else.
    pub(super) fn pack(
        half: [f64; 2],
        count: usize,
        items: &[Item],
        place: Placement,
        rng: &mut Rng,
    ) -> Heap {
        let placed = (0..count).map(|i| {
            let item = items[i % items.len()];
            let (radius, angle) = (rng.random::<f64>().sqrt(), rng.random::<f64>() * TAU);
            let at = place.out([half[0] * radius * angle.cos(), half[1] * radius * angle.sin()]);
            let side = item.lies || rng.random::<f64>() < REPACK.get();
            let slope = SLOPE.get().to_radians() * normal(rng);
            let thick = if item.lies { 2.0 * item.radius } else { item.height };
            let pose = if side { Posture::Side } else { Posture::Flat { slope } };
            Placed { item, at, level: HEAP.get() * thick * normal(rng), axis: rng.random::<f64>() * PI, pose }
        });
        Heap { items: placed.collect() }
    }

    /// Lets some items slide and settle anew.
    pub(super) fn slide(&mut self, rng: &mut Rng) {
        for placed in &mut self.items {
            // The same numbers are drawn whether an item slides or not.
            let (chance, x, y, turn) = (rng.random::<f64>(), normal(rng), normal(rng), normal(rng));
            if chance < SLIDING.get() {
                placed.at = [placed.at[0] + SLIDE_BY.get() * x, placed.at[1] + SLIDE_BY.get() * y];
                placed.axis += 0.2 * turn;
            }
        }
    }

    /// Computes the distances as [`gaps`] does, of the foremost item behind each taxel.
    pub(super) fn gaps(&self) -> Vec<f32> {
        let columns = COLUMNS.get() as usize;
        let ([along, across], rows) = (pitch(), ROWS.get() as usize);
        let mut height = vec![-FAR; TAXELS];
        for placed in &self.items {
            let [x, y] = placed.at;
            let reach = placed.item.radius.hypot(placed.item.height / 2.0).max(placed.item.radius);
            let range = |at: f64, pitch: f64, n: usize| {
                let middle = at / pitch + n as f64 / 2.0 - 0.5;
                let (low, high) = (middle - reach / pitch, middle + reach / pitch);
                (low.ceil().max(0.0) as usize)..((high.floor() + 1.0).clamp(0.0, n as f64) as usize)
            };
            for row in range(y, across, rows) {
                for column in range(x, along, columns) {
                    let taxel = row * columns + column;
                    let [tx, ty] = centre(taxel);
                    if let Some(top) = placed.top(tx - x, ty - y) {
                        height[taxel] = height[taxel].max(top as f32);
                    }
                }
            }
        }
        let highest = height.iter().copied().fold(-FAR, f32::max);
        height.iter().map(|&h| if h > -FAR { highest - h } else { FAR }).collect()
    }
}

impl Placed {
    /// Returns the height of its top at an offset from its middle, mm; none beside it.
    fn top(&self, dx: f64, dy: f64) -> Option<f64> {
        let (sin, cos) = self.axis.sin_cos();
        let (u, v) = (dx * cos + dy * sin, -dx * sin + dy * cos);
        let Item { radius, hole, height, .. } = self.item;
        match self.pose {
            Posture::Flat { slope } => {
                let from = u.hypot(v);
                (from <= radius && from >= hole).then(|| self.level + height / 2.0 + u * slope.tan())
            }
            // A drum on its side: round across, flat along its axis.
            Posture::Side => {
                let round = radius * radius - v * v;
                (round > 0.0 && u.abs() <= height / 2.0).then(|| self.level + round.sqrt())
            }
        }
    }
}

/// Gain and resting reading (counts) of every taxel.
pub(super) struct Taxels {
    pub(super) gain: Vec<f32>,
    pub(super) rest: Vec<f32>,
}

/// Draws from the standard normal distribution, two numbers per taxel, for [`Taxels`].
pub(super) fn draws(mut rng: Rng) -> Vec<[f64; 2]> {
    (0..TAXELS).map(|_| [normal(&mut rng), normal(&mut rng)]).collect()
}

impl Taxels {
    /// Makes the taxels from the sensor's own draws and a grasp's.
    pub(super) fn new(world: &World, sensor: &[[f64; 2]], grasp: &[[f64; 2]]) -> Taxels {
        let (log_sensor, log_grasp) = (TAXEL_GAIN.value[0], TAXEL_GAIN.value[1]);
        let gain = |(sensor, grasp): (&[f64; 2], &[f64; 2])| {
            world.unless("taxels", (log_sensor * sensor[0] + log_grasp * grasp[0]).exp(), 1.0) as f32
        };
        let (mean, sd, share) = (REST.value[0], REST.value[1], REST_OWN.get());
        let rest = |(sensor, grasp): (&[f64; 2], &[f64; 2])| {
            let reading = mean + sd * (share.sqrt() * sensor[1] + (1.0 - share).sqrt() * grasp[1]);
            world.unless("rest", reading.max(0.0), 0.0) as f32
        };
        Taxels {
            gain: sensor.iter().zip(grasp).map(gain).collect(),
            rest: sensor.iter().zip(grasp).map(rest).collect(),
        }
    }
}
