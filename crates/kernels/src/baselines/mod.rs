//! Loops of the baselines: distances and dot products in double precision, MiniRocket's convolutions.

pub mod double;
pub mod rocket;
