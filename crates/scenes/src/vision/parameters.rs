//! Values of the scene, each with its effect. All are ours: they make pictures differ, and nothing is claimed of them.
//!
//! # Reference
//!
//! None: ImageNet's photographs have no parameters to take over.

use crate::parameters::{ASSUMED, Parameter, parameters};

parameters! {
    AZIMUTH: "pose", "azimuth", [0.0, 360.0], "degrees, uniform", ASSUMED, "an object is seen from all sides";
    ELEVATION: "pose", "elevation", [-20.0, 70.0], "degrees, uniform", ASSUMED, "and from above";
    ROLL: "pose", "roll", [-30.0, 30.0], "degrees, uniform", ASSUMED, "no edge has a direction of its own";
    ZOOM: "pose", "zoom", [0.7, 1.3], "of the picture, uniform", ASSUMED, "near and far";
    SHIFT: "pose", "shift", [-0.12, 0.12], "of the picture, uniform", ASSUMED, "not always in the middle";
    LAMP: "light", "angle between lamp and line of sight", [10.0, 75.0], "degrees, uniform", ASSUMED,
        "the same surface is bright in one picture and dark in another";
    AMBIENT: "light", "share of light from everywhere", [0.15, 0.5], "uniform", ASSUMED, "deep or faint shading";
    TEXTURE: "texture", "grains along the object", [2.0, 16.0], "log-uniform", ASSUMED,
        "two colours and a grain of the surface, drawn for every picture: they tell no object";
    BACKGROUND: "background", "grains across the picture", [1.0, 12.0], "log-uniform", ASSUMED,
        "two colours and a grain behind the object: the outline has to be found";
}

pub(super) fn table() -> &'static [Parameter] {
    TABLE
}
