//! Values of the scene, each with its effect.
//!
//! # Reference
//!
//! Those of the rows. `calibrated` ones were set by the hold of real BioTac grasps of another hand (six objects, two
//! fingers): the range of what electrodes read, how much those in the middle differ from grasp to grasp, and their noise.

use crate::parameters::{ASSUMED, Parameter, parameters};

const CALIBRATED: &str = "calibrated: two BioTac fingers in the hold of 60 grasps";

parameters! {
    ALONG: "finger", "electrodes along the finger", [2.5], "mm apart", ASSUMED, "seven rows on a fingertip's length";
    ACROSS: "finger", "electrodes across the finger", [4.0], "mm apart", ASSUMED, "three columns on its width";
    FINGER: "finger", "radius of the fingertip along and across", [60.0, 7.0], "mm", ASSUMED,
        "a flat face touches along the finger, hardly across";
    REST: "finger", "reading of an electrode at rest", [3150.0, 3680.0], "12-bit counts, uniform, the same in all grasps",
        CALIBRATED, "no two electrodes read alike";
    GAIN: "finger", "reading lost where the skin is pressed in", [200.0], "counts a mm", CALIBRATED,
        "the fluid under the skin gets thinner and conducts less";
    BALL: "object", "radius of the ball", [37.0], "mm", ASSUMED, "round both ways";
    CYLINDER: "object", "radius of the cylinder", [37.0], "mm", ASSUMED, "round along the finger, straight across it";
    TURN: "placement", "SD of the cylinder's turn on the finger", [15.0], "degrees", ASSUMED,
        "no grasp is quite square to the object";
    SHIFT: "placement", "SD of the middle of contact along and across", [3.0, 1.5], "mm", ASSUMED,
        "where on the fingertip the object lies";
    DEPTH: "grip", "depth of the hold", [0.8, 2.0], "mm, log-uniform; without it their mean", ASSUMED,
        "a firmer grip presses every electrode more, whatever the object";
    CONTACT: "grip", "first contact", [0.3, 1.0], "s, uniform; without it their mean", ASSUMED, "fingers close at their own time";
    CLOSING: "grip", "from contact to hold", [0.4, 1.0], "s, uniform; without it their mean", ASSUMED, "and at their own pace";
    SESSION: "session", "SD of an electrode's rest from session to session", [20.0], "counts", ASSUMED,
        "warmth and filling drift: what is learned is not the rest of a day";
    NOISE: "noise", "SD of a reading", [0.5], "counts", CALIBRATED, "before it is rounded";
}

pub(super) fn table() -> &'static [Parameter] {
    TABLE
}
