//! Names of the inputs that an encoding makes.

/// Input of 1D networks: channels × time.
pub const SIGNAL: &str = "signal";
/// Input of 2D networks: channels × rows × columns.
pub const IMAGE: &str = "image";
/// Input of 3D networks: channels × rows × columns × frames.
pub const TENSOR: &str = "tensor";
/// Input beside a signal: features.
pub const ROCKET: &str = "rocket";
/// Input of baselines: channels × time.
pub const SERIES: &str = "series";
/// All of them.
pub(super) const INPUTS: [&str; 5] = [SIGNAL, IMAGE, TENSOR, ROCKET, SERIES];
