//! The parameters of the gripper scene.
//!
//! # Reference
//!
//! Each row names its own; see [`gripper`](super) for the equations and [`objects`](super::objects)
//! for the things that are grasped.

use super::objects;
use crate::Effect;
use crate::parameters::{ASSUMED, Parameter, parameters, rows};
use crate::world::Removable;

const COLLECTION: &str = "Zhang et al. 2022, section 3.2.2";
const BIOTAC: &str = "assumed: as the same maker's BioTac has it";

parameters! {
    TICK: "sensor", "time from DC value to DC value", [0.01], "s", "Zhang et al. 2022, section 3.1: 100 Hz",
        "one column of a recording";
    BURST: "sensor", "AC values per tick", [22.0], "", "Zhang et al. 2022, section 3.1: 2200 Hz",
        "vibration within a tick";
    DC_UNIT: "sensor", "pressure of a DC bit", [12.94], "Pa", "Zhang et al. 2022, equation 1",
        "a whole squeeze is some fifty steps";
    AC_UNIT: "sensor", "pressure of an AC bit", [0.13], "Pa", "Zhang et al. 2022, equation 2", "fine steps";
    DC_OFFSET: "sensor", "DC reading at rest", [238.0], "bit", COLLECTION, "not 0: has to be subtracted";
    AC_OFFSET: "sensor", "AC reading at rest", [2048.0], "bit", "assumed: middle of 12 bits; BioTac rests at 2041 in biotac-pr2-hold6",
        "what the ratio of the contact judge is relative to";
    CONVERTER: "sensor", "largest reading", [4095.0], "bit", BIOTAC, "strong vibration is cut off";
    CORNER: "sensor", "lowest frequency of AC", [10.0], "Hz", BIOTAC,
        "AC follows the rate of the pressure, not the pressure";
    PRESSURE: "skin", "fluid pressure per force", [150.0], "Pa/N", ASSUMED, "scale of DC";
    SKIN: "skin", "stiffness of the sensor's foam", [5.0], "N/mm", ASSUMED,
        "in series with the object: hard objects look alike";

    SPEED: "grasp", "speed of each finger", [10.0], "mm/s",
        "constant: Zhang et al. 2022, section 3.2.2; the value: assumed", "soft objects take longer to press back";
    APPROACH: "grasp", "time to contact, least and most", [0.4, 0.9], "s", ASSUMED,
        "a recording begins before contact: the judge has to find it";
    STOP: "grasp", "DC reading of either finger that stops the squeeze", [270.0], "bit", COLLECTION,
        "all objects are squeezed to nearly the same pressure, not depth";
    HOLD: "grasp", "time of the hold", [1.0], "s", "assumed, so that the grasp fits 3 s", "relaxation shows";
    RECORDED: "grasp", "ticks of a recording", [450.0], "ticks",
        "more than 300: Zhang et al. 2022, section 3.2.3", "longer than the window that the judge cuts out";
    DELAY: "delay", "from the stop reading to the stop, mean and SD", [0.06, 0.015], "s",
        "that there is a delay: Zhang et al. 2022, section 3.2.2; the value: assumed",
        "hard objects overshoot: more pressure in the hold";

    SOFTEST: "object", "stiffness of hardness level 1", [0.4], "N/mm", ASSUMED, "rate at which pressure rises";
    PER_LEVEL: "object", "stiffness of a level to the one below", [1.67], "", ASSUMED,
        "equal steps of the logarithm, as people judge hardness: level 10 is 100 times level 1";
    WITHIN: "object", "stiffness of the three objects of a level to the level's", [0.93, 1.0, 1.07], "", ASSUMED,
        "an object is not its level: unseen objects are harder than unseen grasps";
    RELAXED: "relaxation", "share of an object's force that fades, elasticity levels 10 and 1", [0.05, 0.6], "", ASSUMED,
        "elasticity: less elastic objects let go during the hold and return late";
    RELAXATION_TIME: "relaxation", "time constant", [0.3], "s", ASSUMED, "within the hold";

    TAP: "tap", "vibration at contact: of a soft and, added, of a hard object", [75.0, 45.0], "Pa",
        "assumed, above the threshold of the contact judge", "the judge finds the start by it";
    TAP_PITCH: "tap", "its frequency: of a soft and, added, of a hard object", [250.0, 150.0], "Hz", ASSUMED,
        "harder objects ring higher";
    TAP_DAMPING: "tap", "its damping ratio, elasticity levels 10 and 1", [0.03, 0.3], "", ASSUMED,
        "elastic objects ring longer";
    AREA: "placement", "pressure per force, per grasp and finger, log SD", [0.1], "",
        "slight posture changes: Zhang et al. 2022, section 3.2.2; the amount: assumed", "amplitude says less";
    OFF_CENTRE: "placement", "object off the middle, SD", [0.25], "mm",
        "fingers touch almost at the same time: Zhang et al. 2022, section 3.2.2; the amount: assumed",
        "one finger is later and presses less";
    TAP_SPREAD: "placement", "strength of the tap, per grasp, log SD", [0.08], "", ASSUMED, "amplitude says less";
    SESSION_OFFSET: "offset", "DC and AC rest, per session and finger, SD", [3.0, 10.0], "bit",
        "atmospheric pressure: Zhang et al. 2022, section 3.2.3; the amount: assumed",
        "the same stop reading is another force";
    TREMBLE: "noise", "trembling of the arm in AC, SD", [26.0], "bit", "biotac-pr2-hold6, within a hold",
        "slow, as in the recordings";
    TREMBLE_CORNER: "noise", "its corner frequency", [1.0], "Hz",
        "assumed, calibrated on biotac-pr2-hold6: 83 % of the power below 5 Hz", "slow, as in the recordings";
    NOISE: "noise", "electronic noise of DC and AC, SD", [0.5, 1.7], "bit", "DC: assumed; AC: biotac-pr2-hold6, above 200 Hz", "readings are not exactly repeatable";
}

/// Effects that the scene works without.
pub(super) const REMOVABLE: Removable =
    Removable { graded: &["delay", "relaxation", "placement", "offset", "noise"], switched: &[] };

/// Lists all parameters and objects, as `taxel simulate gripper --explain` prints them.
pub(crate) fn explain() -> Vec<Effect> {
    let mut effects = rows(TABLE, &REMOVABLE);
    effects.extend(objects::explain());
    effects
}
