//! The parameters of the fingertip scene.
//!
//! # Reference
//!
//! Each row names its own; see [`fingertip`](super) for the equations.

use crate::Effect;
use crate::parameters::{ASSUMED, Parameter, parameters, rows};
use crate::world::Removable;

/// The values of the curve that tutorials read off; the vendor calls it reference only.
const CURVE: &str = "force-resistance curve of the FSR 400 series data sheet (Interlink): about 30 kohm at 20 g, 6 kohm at 100 g, 1 kohm at 1 kg";
const PAPER: &str = "Kaewrakmuk and Srinonchat 2026, section 4.2";

parameters! {
    START: "grasp", "start of the motion", [0.4], "s", ASSUMED, "readings begin before contact";
    RAMP: "grasp", "duration of the motion", [2.0], "s", ASSUMED, "a steady ramp, then hold";
    TRAVEL: "grasp", "commanded fingertip travel", [18.0], "mm", ASSUMED,
        "the same predefined position in every grasp";
    GAP: "grasp", "distance to the object", [13.0, 12.0, 11.5, 12.0, 13.0], "mm", ASSUMED,
        "fingers touch one after the other; what is left of the travel squeezes";
    TIP: "contact", "fingertip radius", [8.0], "mm", ASSUMED, "curvature in Hertz' law";
    OBJECT: "contact", "cylinder radius", [25.0], "mm", PAPER, "curvature in Hertz' law";
    POISSON: "contact", "Poisson's ratio", [0.5], "", "rubber is incompressible", "E* in Hertz' law";
    CONDUCTANCE: "sensor", "conductance at 1 N", [0.16], "mS", CURVE,
        "more force, more counts";
    EXPONENT: "sensor", "exponent of the force", [0.85], "", CURVE,
        "counts are not proportional to force";
    RESISTOR: "sensor", "divider resistor", [10.0], "kohm", "usual with an FSR 402",
        "counts saturate at high force";
    STIFFNESS: "compliance", "servo, tendon and finger in series", [2.0], "N/mm", ASSUMED,
        "force is a balance of object and finger: levels come closer, and differ in shape";
    RELAXED: "relaxation", "share of the force lost", [0.3], "", ASSUMED,
        "force decays under a held squeeze, more so on a soft object";
    RELAXATION_TIME: "relaxation", "time constant", [1.0], "s", ASSUMED, "within the hold";
    QUALITY: "contact-quality", "share of the force on the sensor", [0.5, 0.85, 0.9, 0.85, 0.45], "",
        "Kaewrakmuk and Srinonchat 2026, section 4.1: thumb and little finger vary; values assumed",
        "scales the amplitude of a finger";
    QUALITY_SPREAD: "contact-quality", "log spread per grasp", [0.25, 0.12, 0.12, 0.12, 0.25], "", ASSUMED,
        "scales the amplitude of a finger";
    SHIFT: "placement", "shift between thumb and fingers, SD", [0.6], "mm", ASSUMED,
        "the thumb touches later and presses less when the fingers press more";
    TILT: "placement", "tilt from finger to finger, SD", [0.3], "mm", ASSUMED,
        "index and little finger press differently";
    HOLD_ERROR: "servo", "error of the hold position, SD", [0.3], "mm", ASSUMED,
        "all fingers press more or less together, as on another object";
    START_ERROR: "servo", "error of the start, SD", [0.08], "s", ASSUMED, "the onset says little";
    SESSION_QUALITY: "session", "log contact quality, SD", [0.15], "", ASSUMED,
        "a session's own amplitudes: scores on unseen sessions are lower";
    SESSION_SHIFT: "session", "shift, SD", [0.4], "mm", ASSUMED, "a session's own placement";
    SESSION_PERIOD: "session", "period of the drift", [50.0], "grasps", ASSUMED,
        "both wander to and fro within a session";
    NOISE: "noise", "electronic noise, SD", [1.5], "counts", "assumed, 1 to 2 of 1023",
        "readings are not exactly repeatable";
}

/// Effects that the scene works without.
pub(super) const REMOVABLE: Removable = Removable {
    graded: &["compliance", "relaxation", "contact-quality", "placement", "servo", "session", "noise"],
    switched: &[],
};

/// Lists all parameters, as `taxel simulate fingertip --explain` prints them.
pub(crate) fn explain() -> Vec<Effect> {
    rows(TABLE, &REMOVABLE)
}
