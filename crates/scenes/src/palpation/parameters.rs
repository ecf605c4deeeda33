//! The parameters of the palpation scene.
//!
//! # Reference
//!
//! Each row names its own; see [`palpation`](super) for the equations and [`objects`](super::objects)
//! for the things that are squeezed. "Calibrated" means: set by statistics of the real recordings that
//! `docs/scenes.md` shows side by side, never by labels.

use super::objects;
use crate::Effect;
use crate::parameters::{ASSUMED, Parameter, parameters, rows};
use crate::world::Removable;

const SENSOR: &str = "Gandarias et al. 2019b and Pastor et al. 2019, sensor specifications (Tekscan 6077)";
const TABLE_1: &str =
    "Pastor et al. 2019, Table 1; which link is which is our reading, its figure has no text";
const CALIBRATED: &str = "assumed, calibrated on tekscan3d-fixtures24";

parameters! {
    ROWS: "sensor", "rows", [28.0], "taxels", SENSOR, "the short side of a frame";
    COLUMNS: "sensor", "columns", [50.0], "taxels", SENSOR, "the long side of a frame";
    HEIGHT: "sensor", "height", [53.3], "mm", SENSOR, "with the rows: 1.90 mm from taxel to taxel";
    WIDTH: "sensor", "width", [95.3], "mm", SENSOR, "with the columns: 1.91 mm from taxel to taxel";
    FULL_SCALE: "sensor", "full scale", [34.0], "kPa", SENSOR, "harder presses saturate";
    LEVELS: "sensor", "counts at full scale", [255.0], "counts", "8-bit values of tekscan3d-fixtures24",
        "light pressure is lost in the steps";
    THRESHOLD: "sensor", "smallest reading that is not 0", [4.0], "counts",
        "tekscan3d-fixtures24: no active taxel reads less", "widely spread light pressure is not seen";

    PAD: "pad", "stiffness of 3 mm Ecoflex 00-30", [23.0], "kPa/mm",
        "69 kPa at 100 % strain (vendor's sheet) over the 3 mm of Pastor et al. 2019, section 3.2; 003 only",
        "gives rigid things an area of contact";
    PAD_DEPTH: "pad", "squeeze at which the pad is flat", [2.4], "mm", "assumed: 80 % of 3 mm",
        "contact grows stiffer under load";
    PAD_BLUR: "blur", "spread of a point load through the pad, SD", [1.5], "mm",
        "assumed: half the thickness of the pad", "neighbouring taxels share a load; 003 only";

    PEAK: "force-steps", "largest force of a squeeze", [20.0, 40.0], "N",
        "40: Gandarias et al. 2019b, section III-B; that it varies: assumed", "002: frame t is at another force each time";
    FIRST: "squeeze", "force in the first frame, of the largest", [0.03], "", "assumed; 002", "002 begins at contact";
    STEP: "force-steps", "unevenness of the force steps, log SD", [0.6], "",
        "that steps are random: Gandarias et al. 2019b and Pastor et al. 2019; the amount: assumed",
        "frame t is at another force in every grasp";
    TILT: "tilt", "tilt of the press, SD", [0.5], "deg",
        "Pastor et al. 2019, section 4.1.1: pressure is not homogeneous; the amount: assumed",
        "one side is pressed more than the other";
    SHIFT: "placement", "shift of the object, SD", [6.0, 10.0], "mm",
        "Pastor et al. 2019, section 4.1.1: random positions; the amount: assumed; across, along the sensor",
        "no taxel means the same in two grasps";
    TURN: "placement", "rotation of the object, SD", [15.0], "deg",
        "Pastor et al. 2019, section 4.1.1: random orientations; the amount: assumed", "edges and axes turn";
    GAIN: "session", "sensitivity of a session, log SD", [0.08], "", "assumed, re-calibration of the sensor",
        "absolute pressure says less; scores on unseen sessions are lower";
    TAXEL_GAIN: "taxels", "gain of a taxel, log SD: the sensor's own, a grasp's own", [0.24, 0.18], "", CALIBRATED,
        "a smooth pressure is read as grain, the same in all frames of a grasp";
    REST: "rest", "resting reading of a taxel, mean and SD before it is cut at 0", [-9.0, 9.0], "counts", CALIBRATED,
        "the pad presses here and there before anything is touched";
    REST_OWN: "rest", "share of that variance that is the sensor's own", [0.5], "", CALIBRATED,
        "the rest changes with how the pad sits in a grasp";
    NOISE: "noise", "electronic noise, SD", [1.1], "counts", "tekscan3d-fixtures24: from frame to frame before the squeeze",
        "readings are not exactly repeatable";

    TORQUE: "gripper", "torque at the ends and in the middle of the ramp", [0.05, 0.9], "of the largest",
        "Pastor et al. 2019, section 3.1", "a slow triangle, open loop: what force comes of it depends on the object";
    MOTOR: "gripper", "largest torque", [1.4], "N m", "Pastor et al. 2019, section 3.1", "scale of the force";
    CRANK: "gripper", "a, crank on the servo", [40.0], "mm", TABLE_1, "lever of the torque";
    LEVER: "gripper", "b, lever on the second phalanx", [20.0], "mm", TABLE_1, "shares torque among the joints";
    COUPLER: "gripper", "c, rod from crank to lever", [60.0], "mm", TABLE_1, "closes the five-bar loop";
    GROUND: "gripper", "e, from first joint to servo", [27.8], "mm", TABLE_1, "closes the five-bar loop";
    GROUND_ANGLE: "gripper", "gamma, direction of e", [56.0], "deg", TABLE_1, "closes the five-bar loop";
    LEVER_ANGLE: "gripper", "psi, from second phalanx to lever", [90.0], "deg", TABLE_1, "closes the five-bar loop";
    PHALANX: "gripper", "l1, first phalanx", [70.0], "mm", TABLE_1, "where the fingers touch";
    THICKNESS: "gripper", "w, from joint line to finger surface", [10.0], "mm", TABLE_1, "where the fingers touch";
    MOUNT: "gripper", "l0, first joint above the sensor", [45.0], "mm", "Pastor et al. 2019, Table 1: 25 to 45",
        "where the fingers touch";
    CENTRE: "gripper", "object's centre from the first joint, along the sensor", [50.0], "mm", ASSUMED,
        "half the sensor; where the fingers touch";
    SHARE: "gripper", "share of the computed force that reaches the taxels", [0.24], "", CALIBRATED,
        "friction of servo, linkage and side contacts";
    FRICTION: "friction", "variation of that share from grasp to grasp, log SD", [0.12], "", ASSUMED,
        "the same torque gives another force";
    HOLD: "gripper", "force that holds the object before the ramp is felt", [1.0], "N", CALIBRATED,
        "frames before the squeeze are not empty";

    REPACK: "packing", "items standing on edge", [0.3], "of all", ASSUMED,
        "bags are shuffled before every grasp (Pastor et al. 2019, section 4.1.4): each grasp another heap";
    HEAP: "packing", "unevenness of the heap, SD, of an item's height", [0.25], "", ASSUMED,
        "few items touch at light force, more as it grows";
    SLOPE: "packing", "slope of a lying item, SD", [8.0], "deg", ASSUMED, "rims instead of whole faces";
    SLIDE: "bag-shift", "chance of a shift per frame", [0.06], "",
        "Pastor et al. 2019, section 4.1.4: items may move during a grasp; the amount: assumed",
        "frames of one grasp do not show the same heap";
    SLIDING: "bag-shift", "share of the items that shift", [0.3], "", ASSUMED, "the heap changes in parts";
    SLIDE_BY: "bag-shift", "shift of an item, SD", [2.0], "mm", ASSUMED, "about a taxel";
}

/// Effects that the scene works without.
pub(super) const REMOVABLE: Removable = Removable {
    graded: &["force-steps", "tilt", "placement", "session", "taxels", "rest", "noise", "friction"],
    switched: &["blur", "packing", "bag-shift", "texture", "inclusions"],
};

/// Lists all parameters and objects, as `taxel simulate palpation --explain` prints them.
pub(crate) fn explain() -> Vec<Effect> {
    let mut effects = rows(TABLE, &REMOVABLE);
    effects.extend(objects::explain());
    effects
}
