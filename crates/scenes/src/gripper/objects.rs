//! The grasped objects: the 30 of Zhang et al. 2022 and their levels.
//!
//! # Reference
//!
//! Names: Zhang et al. 2022, figure 3. Levels stand in its figure 4, of which the text gives one: the mineral
//! water bottle is of elasticity 9 and hardness 3. All other levels are ours, after what the objects
//! are, with three objects on each level of each attribute as the paper says. Elasticity is how much
//! of the force an object keeps and returns, hardness how little it yields (section 1).

use crate::Effect;

/// One object: its name and its levels, 1 to 10.
#[derive(Debug, Clone, Copy)]
pub(super) struct GraspedObject {
    pub(super) name: &'static str,
    pub(super) elasticity: u8,
    pub(super) hardness: u8,
}

const fn object(name: &'static str, elasticity: u8, hardness: u8) -> GraspedObject {
    GraspedObject { name, elasticity, hardness }
}

/// The 30 objects in the order of figure 3.
pub(super) const OBJECTS: [GraspedObject; 30] = [
    object("towel", 3, 2),
    object("garbage bag", 1, 1),
    object("paper cup", 8, 5),
    object("medium draw paper", 6, 4),
    object("earphone box", 5, 8),
    object("bubble wrap", 8, 2),
    object("mineral water bottle", 9, 3),
    object("hand cream", 3, 4),
    object("square sponge", 10, 2),
    object("jelly", 7, 3),
    object("glue", 5, 5),
    object("mask", 4, 1),
    object("tennis", 10, 7),
    object("double layer foam", 9, 5),
    object("can", 2, 9),
    object("square foam", 9, 6),
    object("ham sausage", 6, 7),
    object("triangular bandage", 2, 1),
    object("metal column", 1, 10),
    object("rubber", 8, 8),
    object("black bandage", 5, 3),
    object("book", 2, 10),
    object("glass bottle", 1, 10),
    object("orange", 7, 7),
    object("plastic box", 3, 9),
    object("dental cylinder box", 4, 9),
    object("small draw paper", 6, 4),
    object("white thread group", 7, 6),
    object("foam ball", 10, 6),
    object("soap box", 4, 8),
];

impl GraspedObject {
    /// Returns its place among the objects of its hardness level: 0, 1 or 2.
    pub(super) fn place(&self) -> usize {
        let same = OBJECTS.iter().filter(|other| other.hardness == self.hardness);
        same.take_while(|other| other.name != self.name).count()
    }
}

/// Lists the objects as rows of `--explain`.
pub(super) fn explain() -> Vec<Effect> {
    let row = |object: &GraspedObject| Effect {
        name: "object".into(),
        parameter: object.name.into(),
        value: format!("elasticity {}, hardness {}", object.elasticity, object.hardness),
        unit: "levels".into(),
        source: match object.name {
            "mineral water bottle" => "Zhang et al. 2022, section 3.2.4".into(),
            _ => "name: Zhang et al. 2022, figure 3; levels: assumed".into(),
        },
        why: "a group: what a split by objects never tears apart".into(),
        removable: false,
    };
    OBJECTS.iter().map(row).collect()
}
