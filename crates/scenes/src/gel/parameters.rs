//! Values of the scene, each with its effect.
//!
//! # Reference
//!
//! Those of the rows.

use crate::parameters::{ASSUMED, Parameter, parameters};

parameters! {
    SIDE_OBJECTS: "gel", "side, objects", [25.5], "mm",
        "the array of the scene imprint (Rouhafzay et al. 2021, section 3.3: 6.5 cm²)",
        "the same patch of the same objects, so that only the sensor differs";
    SIDE_CLOTHS: "gel", "side, cloths", [15.0], "mm", ASSUMED, "some ten yarns across: a texture, not a shape";
    DEPTH: "depth", "how deep the first point is pressed in", [0.5, 1.5], "mm, uniform", ASSUMED,
        "a firmer touch shows more of an object; without it 1 mm";
    MEMBRANE: "membrane", "SD of the Gaussian that smooths what is pressed in", [0.25], "mm",
        "assumed; the form is that of Gomes et al., Generation of GelSight tactile images for sim2real learning, 2021",
        "the coat bridges gaps between yarns and rounds edges off";
    AZIMUTH: "lamps", "azimuth of the red, green and blue lamps", [90.0, 210.0, 330.0], "degrees",
        "three lamps around the gel as in photometric stereo: Johnson and Adelson, Retrographic sensing, 2009",
        "each colour is the slope in one direction";
    ELEVATION: "lamps", "elevation of the lamps", [30.0], "degrees", ASSUMED, "grazing light: small slopes show";
    AMBIENT: "lamps", "share of light from everywhere", [0.3], "", ASSUMED, "no slope is quite black";
    NOISE: "noise", "SD of a pixel", [1.0], "8-bit counts", ASSUMED, "a camera's noise, before it is rounded";
    SPIN: "spin", "turn about the normal", [0.0, 360.0], "degrees, uniform", ASSUMED,
        "edges and yarns run in any direction";
    PITCH: "piece", "yarns of a piece of cloth", [0.7, 1.4], "mm apart, log-uniform", ASSUMED,
        "coarse and fine pieces of every weave: the pitch alone does not tell it; without it 1 mm";
    PIECES: "piece", "pieces of each cloth", [8.0], "", "Rouhafzay et al. 2021, section 3.1: 100 pieces of clothes; eight of each of twelve",
        "whole pieces are left out for a test";
    YARN: "cloth", "thickness of a yarn", [0.9], "of the pitch", ASSUMED,
        "round yarns that bend around each other (F. T. Peirce, The geometry of cloth structure, 1937)";
    CRIMP: "cloth", "rise of a yarn over another", [0.25], "of its thickness", ASSUMED, "which yarn lies on top is what a weave is";
}

pub(super) fn table() -> &'static [Parameter] {
    TABLE
}
