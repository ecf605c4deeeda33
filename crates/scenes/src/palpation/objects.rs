//! The squeezed objects: the 9 of Gandarias et al. 2019b and the 24 of Pastor et al. 2019.
//!
//! # Reference
//!
//! Names: Gandarias et al. 2019b, section III-C; Pastor et al. 2019, figure 5. Neither paper gives a dimension or a
//! stiffness: nuts and washers have the sizes of ISO 4032 and ISO 7089, cans and bottles those of the
//! trade, all else is assumed. Twins differ in their inclusions and in nothing else.

use crate::Effect;

/// The three subsets of Pastor et al. 2019; all of Gandarias et al. 2019b is deformable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ObjectKind {
    Rigid,
    Deformable,
    InBag,
}

/// One object. Lengths in mm, stiffness in kPa of pressure per mm of squeeze.
#[derive(Debug, Clone, Copy)]
pub(super) struct SqueezedObject {
    pub(super) name: &'static str,
    pub(super) kind: ObjectKind,
    pub(super) shape: ObjectShape,
    /// From the sensor to the fingers, unloaded.
    pub(super) thickness: f64,
    /// Of the object itself, without the sensor's pad.
    pub(super) stiffness: f64,
    /// Squeeze at which its material is flat and yields no further.
    pub(super) depth: f64,
    /// Bumps on the surface.
    pub(super) texture: Option<Texture>,
    /// Hard lumps inside.
    pub(super) inclusions: &'static [Inclusion],
}

/// Egg-crate bumps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Texture {
    /// From bump to bump.
    pub(super) pitch: f64,
    /// From valley to top.
    pub(super) height: f64,
}

/// A hard sphere in a soft object, felt once the soft cover above it is squeezed away.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inclusion {
    /// Position along and across the object.
    pub(super) at: [f64; 2],
    pub(super) radius: f64,
    /// Soft material above its top.
    pub(super) cover: f64,
    /// Pressure per mm beyond the cover.
    pub(super) stiffness: f64,
}

/// The side that touches the sensor.
#[derive(Debug, Clone, Copy)]
pub(super) enum ObjectShape {
    /// Lying along the sensor; `ribs` deepen the wall every `pitch` by `depth`.
    Cylinder { radius: f64, length: f64, ribs: Option<Ribs> },
    /// Half of an ellipsoid with these half axes along, across and down.
    Ellipsoid { half: [f64; 3], groove: Option<Groove> },
    /// A ring of this radius, lying, its rim rounded by `round`.
    Rim { radius: f64, round: f64 },
    /// A flat face with edges rounded by `round`.
    Block { half: [f64; 2], round: f64 },
    /// A bag of `count` items, drawn from the list in turn, over an ellipse with these half axes.
    Bag { half: [f64; 2], count: usize, items: &'static [Item] },
}

/// Valleys around a cylinder.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ribs {
    pub(super) pitch: f64,
    pub(super) depth: f64,
}

/// A slit along an ellipsoid, as a mouse has around its wheel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Groove {
    pub(super) half_width: f64,
    pub(super) length: f64,
}

/// Something small and round with a hole: a nut, a washer, a gear; a rod has its length as height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub(super) radius: f64,
    pub(super) hole: f64,
    pub(super) height: f64,
    /// Always on its side, as rods are.
    pub(super) lies: bool,
}

const STIFF: f64 = 1e4;

const THING: SqueezedObject = SqueezedObject {
    name: "",
    kind: ObjectKind::Rigid,
    shape: ObjectShape::Block { half: [30.0, 20.0], round: 2.0 },
    thickness: 60.0,
    stiffness: STIFF,
    depth: 0.0,
    texture: None,
    inclusions: &[],
};

const fn cylinder(radius: f64, length: f64) -> ObjectShape {
    ObjectShape::Cylinder { radius, length, ribs: None }
}

const fn ribbed(radius: f64, length: f64, pitch: f64, depth: f64) -> ObjectShape {
    ObjectShape::Cylinder { radius, length, ribs: Some(Ribs { pitch, depth }) }
}

const fn lump(u: f64, v: f64) -> Inclusion {
    Inclusion { at: [u, v], radius: 8.0, cover: 16.0, stiffness: 3.0 }
}

const LUMPS: &[Inclusion] = &[lump(-19.0, 6.0), lump(3.0, -8.0), lump(20.0, 4.0)];
const BALL_LUMPS: &[Inclusion] = &[
    Inclusion { at: [-7.0, 4.0], radius: 7.0, cover: 5.0, stiffness: 6.0 },
    Inclusion { at: [8.0, -5.0], radius: 7.0, cover: 5.0, stiffness: 6.0 },
];

const BALL: SqueezedObject = SqueezedObject {
    kind: ObjectKind::Deformable,
    shape: ObjectShape::Ellipsoid { half: [32.0, 32.0, 32.0], groove: None },
    thickness: 62.0,
    stiffness: 1.8,
    depth: 26.0,
    ..THING
};

const SPONGE: SqueezedObject = SqueezedObject {
    kind: ObjectKind::Deformable,
    shape: ObjectShape::Block { half: [38.0, 23.0], round: 17.0 },
    thickness: 40.0,
    stiffness: 0.03,
    depth: 36.0,
    ..THING
};

const ROUGH: Option<Texture> = Some(Texture { pitch: 10.0, height: 6.0 });
const ROUGH_SPONGE: SqueezedObject = SqueezedObject { stiffness: 0.035, texture: ROUGH, ..SPONGE };
const SCRUNCHY: SqueezedObject = SqueezedObject {
    shape: ObjectShape::Ellipsoid { half: [45.0, 32.0, 28.0], groove: None },
    thickness: 55.0,
    stiffness: 0.05,
    texture: Some(Texture { pitch: 14.0, height: 8.0 }),
    ..SPONGE
};

/// The 9 objects of Gandarias et al. 2019b, in its order.
pub(super) const PAPER_002: [SqueezedObject; 9] = [
    SqueezedObject { name: "ball_inclusions", inclusions: BALL_LUMPS, ..BALL },
    SqueezedObject { name: "ball_rough", texture: Some(Texture { pitch: 7.0, height: 2.0 }), ..BALL },
    SqueezedObject { name: "ball", ..BALL },
    SqueezedObject {
        name: "sponge_exfoliating",
        stiffness: 0.06,
        texture: Some(Texture { pitch: 6.0, height: 3.0 }),
        ..SPONGE
    },
    SqueezedObject { name: "sponge_smooth", ..SPONGE },
    SqueezedObject { name: "sponge_smooth_inclusions", inclusions: LUMPS, ..SPONGE },
    SqueezedObject { name: "sponge_scrunchy", ..SCRUNCHY },
    SqueezedObject { name: "sponge_rough", ..ROUGH_SPONGE },
    SqueezedObject { name: "sponge_rough_inclusions", inclusions: LUMPS, ..ROUGH_SPONGE },
];

const fn ring(radius: f64, hole: f64, height: f64) -> Item {
    Item { radius, hole, height, lies: false }
}

const fn rod(radius: f64, length: f64) -> Item {
    Item { radius, hole: 0.0, height: length, lies: true }
}

/// Radius of the circle with the area of the hexagon: 0.525 of the width across flats.
const M6: Item = ring(5.3, 3.0, 5.2);
const M8: Item = ring(6.8, 4.0, 6.8);
const M10: Item = ring(8.4, 5.0, 8.4);
const NUTS: &[Item] = &[M6, M8, M10, M8];
const WASHERS: &[Item] =
    &[ring(6.0, 3.2, 1.6), ring(8.0, 4.2, 1.6), ring(10.0, 5.25, 2.0), ring(12.0, 6.5, 2.5)];

const BAG: SqueezedObject =
    SqueezedObject { kind: ObjectKind::InBag, thickness: 38.0, stiffness: 12.0, depth: 4.0, ..THING };

const fn bag(name: &'static str, count: usize, items: &'static [Item]) -> SqueezedObject {
    SqueezedObject { name, shape: ObjectShape::Bag { half: [44.0, 26.0], count, items }, ..BAG }
}

/// The 24 objects of Pastor et al. 2019, in its order: 8 rigid, 8 deformable, 8 in bags.
pub(super) const PAPER_003: [SqueezedObject; 24] = [
    SqueezedObject {
        name: "bottle of coke",
        shape: ribbed(33.0, 200.0, 46.0, 2.2),
        thickness: 66.0,
        ..THING
    },
    SqueezedObject { name: "energy drink can", shape: cylinder(26.5, 135.0), thickness: 53.0, ..THING },
    SqueezedObject {
        name: "mouse 1",
        shape: ObjectShape::Ellipsoid {
            half: [56.0, 31.0, 20.0],
            groove: Some(Groove { half_width: 3.5, length: 30.0 }),
        },
        thickness: 38.0,
        ..THING
    },
    SqueezedObject {
        name: "mouse 2",
        shape: ObjectShape::Ellipsoid {
            half: [50.0, 28.0, 17.0],
            groove: Some(Groove { half_width: 4.5, length: 22.0 }),
        },
        thickness: 35.0,
        ..THING
    },
    SqueezedObject {
        name: "bottle of ice tea",
        shape: ribbed(32.0, 200.0, 17.0, 1.6),
        thickness: 64.0,
        stiffness: 25.0,
        depth: 8.0,
        ..THING
    },
    SqueezedObject {
        name: "skate wheel",
        shape: ObjectShape::Rim { radius: 24.0, round: 9.0 },
        thickness: 30.0,
        stiffness: 30.0,
        depth: 6.0,
        ..THING
    },
    SqueezedObject { name: "soda can", shape: cylinder(33.0, 115.0), thickness: 66.0, ..THING },
    SqueezedObject {
        name: "bottle of water",
        shape: ribbed(32.0, 200.0, 11.0, 1.0),
        thickness: 64.0,
        stiffness: 6.0,
        depth: 20.0,
        ..THING
    },
    SqueezedObject { name: "ball 1", ..BALL },
    SqueezedObject {
        name: "ball 2",
        shape: ObjectShape::Ellipsoid { half: [35.0, 35.0, 35.0], groove: None },
        thickness: 68.0,
        stiffness: 1.2,
        texture: Some(Texture { pitch: 9.0, height: 1.6 }),
        ..BALL
    },
    SqueezedObject { name: "sponge rough", ..ROUGH_SPONGE },
    SqueezedObject { name: "sponge rough with inclusions", inclusions: LUMPS, ..ROUGH_SPONGE },
    SqueezedObject { name: "sponge scrunchy", ..SCRUNCHY },
    SqueezedObject { name: "sponge soft", ..SPONGE },
    SqueezedObject { name: "sponge soft with inclusions", inclusions: LUMPS, ..SPONGE },
    SqueezedObject {
        name: "sponge pipe",
        shape: cylinder(20.0, 110.0),
        thickness: 42.0,
        stiffness: 0.8,
        depth: 16.0,
        ..SPONGE
    },
    bag("gears", 26, &[ring(15.0, 3.0, 8.0), ring(10.0, 2.5, 8.0), ring(7.0, 2.0, 10.0)]),
    bag("mixed nuts", 60, NUTS),
    bag("mixed washer", 70, WASHERS),
    bag("M6 nuts", 100, &[M6]),
    bag("M8 nuts", 64, &[M8]),
    bag("M10 nuts", 42, &[M10]),
    bag("rivets", 130, &[rod(2.0, 14.0), rod(2.4, 18.0)]),
    SqueezedObject { stiffness: 2.0, depth: 8.0, ..bag("rubber pipes", 45, &[rod(4.0, 30.0)]) },
];

/// Lists the objects as rows of `--explain`.
pub(super) fn explain() -> Vec<Effect> {
    let papers: [(&str, &str, &[SqueezedObject]); 2] = [
        ("002", "Gandarias et al. 2019b, section III-C", &PAPER_002),
        ("003", "Pastor et al. 2019, figure 5", &PAPER_003),
    ];
    let mut effects = Vec::new();
    for (paper, source, objects) in papers {
        for object in objects {
            effects.push(Effect {
                name: "object".into(),
                parameter: format!("{paper}: {}", object.name),
                value: describe(object),
                unit: "mm, kPa/mm".into(),
                source: format!("{source}; dimensions and stiffness assumed"),
                why: "a class: what its footprint does as the force grows".into(),
                removable: false,
            });
            effects.extend(texture_row(paper, object));
            effects.extend(inclusion_row(paper, object));
        }
    }
    effects
}

fn describe(object: &SqueezedObject) -> String {
    let yields = if object.stiffness >= STIFF {
        "does not yield".to_string()
    } else {
        format!("stiffness {}, flat at {}", object.stiffness, object.depth)
    };
    format!("{}, {} thick, {yields}", object.shape.text(), object.thickness)
}

fn texture_row(paper: &str, object: &SqueezedObject) -> Option<Effect> {
    object.texture.map(|texture| Effect {
        name: "texture".into(),
        parameter: format!("{paper}: {}", object.name),
        value: format!("bumps {} high every {}", texture.height, texture.pitch),
        unit: "mm".into(),
        source: "that it is rough: its name; the amount: assumed".into(),
        why: "seen at light force, flattened at full force".into(),
        removable: true,
    })
}

fn inclusion_row(paper: &str, object: &SqueezedObject) -> Option<Effect> {
    object.inclusions.first().map(|first| Effect {
        name: "inclusions".into(),
        parameter: format!("{paper}: {}", object.name),
        value: format!(
            "{} spheres of radius {}, {} below the surface, {} beyond",
            object.inclusions.len(),
            first.radius,
            first.cover,
            first.stiffness
        ),
        unit: "mm, kPa/mm".into(),
        source: "that it has them: its name; size and depth: assumed".into(),
        why: "invisible at light force, seen once the cover is squeezed away".into(),
        removable: true,
    })
}

impl ObjectShape {
    fn text(&self) -> String {
        match self {
            ObjectShape::Cylinder { radius, length, ribs } => {
                let ribs = ribs.map(|r| format!(", ribs {} deep every {}", r.depth, r.pitch));
                format!("cylinder of radius {radius}, length {length}{}", ribs.unwrap_or_default())
            }
            ObjectShape::Ellipsoid { half, groove } => {
                let groove = groove.map(|g| format!(", slit {} wide", 2.0 * g.half_width));
                format!("ellipsoid {} x {} x {}{}", half[0], half[1], half[2], groove.unwrap_or_default())
            }
            ObjectShape::Rim { radius, round } => format!("ring of radius {radius}, rim rounded by {round}"),
            ObjectShape::Block { half, round } => {
                format!("block {} x {}, edges {round}", 2.0 * half[0], 2.0 * half[1])
            }
            ObjectShape::Bag { count, items, .. } => {
                let sizes: Vec<String> = items.iter().map(Item::text).collect();
                format!("{count} items: {}", sizes.join("; "))
            }
        }
    }
}

impl Item {
    fn text(&self) -> String {
        if self.lies {
            return format!("rod {} x {}", 2.0 * self.radius, self.height);
        }
        format!("ring {} / {} x {}", 2.0 * self.radius, 2.0 * self.hole, self.height)
    }
}
