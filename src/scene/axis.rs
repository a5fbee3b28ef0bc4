//! The axes of a scene.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A coordinate axis of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// Along e_x = (1, 0, 0).
    X,
    /// Along e_y = (0, 1, 0).
    Y,
    /// Along e_z = (0, 0, 1).
    Z,
}

pub(super) fn all_axes() -> Vec<Axis> {
    vec![Axis::X, Axis::Y, Axis::Z]
}
