//! Names of tables and charts: those who make one and those who show it take the name from here.

/// Tables: the name of their files, and of their place in the page.
pub(super) mod table {
    pub const ATTRIBUTES: &str = "attributes";
    pub const BREAKING_POINTS: &str = "breaking-points";
    pub const CARRIERS: &str = "carriers";
    pub const CERTAINTY: &str = "certainty";
    pub const CHANNELS: &str = "channels";
    pub const CLASSES: &str = "classes";
    pub const CONFUSION: &str = "confusion";
    pub const COPIES: &str = "copies";
    pub const COSTS: &str = "costs";
    pub const EARLY: &str = "early";
    pub const EARLY_DECISIONS: &str = "early-decisions";
    pub const EIGHT_BITS: &str = "eight-bits";
    pub const ERRORS: &str = "errors";
    pub const EVIDENCE: &str = "evidence";
    pub const EXAMPLES: &str = "examples";
    pub const FAULTS: &str = "faults";
    pub const FAULT_CURVES: &str = "fault-curves";
    pub const FAULT_LOSSES: &str = "fault-losses";
    pub const FEW_SAMPLES: &str = "few-samples";
    pub const FOLDS: &str = "folds";
    pub const GUARD: &str = "guard";
    pub const HARDENING: &str = "hardening";
    pub const IMPORTANCE: &str = "importance";
    pub const NETWORKS: &str = "networks";
    pub const OVERVIEW_REAL: &str = "overview-real";
    pub const OVERVIEW_SIMULATED: &str = "overview-simulated";
    pub const PUBLISHED: &str = "published";
    pub const RANKS: &str = "ranks";
    pub const SPEED: &str = "speed";
    pub const SURE: &str = "sure";
    pub const TRAINING: &str = "training";
    pub const UNKNOWN: &str = "unknown";
    pub const UNSEEN: &str = "unmet-faults";
    pub const WEIGHT_CHANGES: &str = "weight-changes";
}

/// Charts: the name of their files.
pub(super) mod chart {
    pub const CALIBRATION: &str = "calibration";
    pub const CARRIER: &str = "carrier";
    /// Prefix of the names of all confusion matrices.
    pub const CONFUSION: &str = "confusion-";
    pub const CRITICAL_DIFFERENCE: &str = "critical-difference";
    pub const EARLY: &str = "early";
    pub const DRIFT: &str = "drift";
    pub const FAULT_CURVES: &str = "fault-curves";
    pub const FAULT_LOSSES: &str = "fault-losses";
    pub const FEW_SAMPLES: &str = "few-samples";
    pub const IMPORTANCE: &str = "importance";
    pub const LATENCY: &str = "latency";
    pub const LEARNING_CURVE: &str = "learning-curve";
    pub const LENGTHS: &str = "lengths";
    pub const MACS: &str = "macs";
    pub const RANGES: &str = "ranges";
    pub const RELIABILITY: &str = "reliability";
    pub const SIZE: &str = "size";
    pub const SUREST: &str = "surest";
    pub const TRAINING: &str = "training";
    /// Prefix of the names of all plots of predicted against true values.
    pub const VALUES: &str = "values-";
    pub const WEIGHT_CHANGES: &str = "weight-changes";
    pub const WHERE_TIME_GOES: &str = "where-time-goes";

    /// Returns the name of the chart of that metric against a cost: `accuracy-latency`.
    pub fn against(metric: &str, cost: &str) -> String {
        format!("{metric}-{cost}")
    }
}
